//! Meshes of other topology and shape, linked by their surfaces.

use glam::{DQuat, DVec3};
use uvgraft::correspond::surface::{Align, SurfaceError, SurfaceReport};
use uvgraft::correspond::{By, FindOptions, Method, MethodFailure, find};
use uvgraft::piece::Weights;
use uvgraft::{Anatomy, Area, Extent, Landmark, Mesh, Pair, Piece};
use uvgraft_figure::Figure;
use uvgraft_tests::real;
use uvgraft_tests::remeshed::Remeshed;
use uvgraft_tests::synthetic::posed;

fn registered(source: &Mesh, target: &Mesh) -> (Pair, SurfaceReport) {
    let mut options = FindOptions::default();
    options.by = By::Surface;
    let found = find(source.clone(), target.clone(), &options).expect("heads are found");
    let Method::Surface(report) = found.method else { panic!("not by surface") };
    (found.pair, report)
}

fn point_on(mesh: &Mesh, face: u32, weights: Weights) -> DVec3 {
    let corners = mesh.faces()[face as usize];
    let at = |k: usize| glam::Vec3::from(mesh.positions()[corners[k] as usize]).as_dvec3();
    (0..3).map(|k| at(k) * weights[k]).sum()
}

/// The weights of a piece's corners in the target face and in the source face.
fn corners(piece: &Piece) -> [[Weights; 3]; 2] {
    let unit = |k: usize| {
        let mut weights = [0.0; 3];
        weights[k] = 1.0;
        weights
    };
    match piece.extent {
        Extent::Whole(corners) => {
            [[0, 1, 2].map(unit), corners.map(|corner| unit(usize::from(corner)))]
        }
        Extent::Part { target, source } => [target, source],
    }
}

fn mixed(corners: [Weights; 3], weights: Weights) -> Weights {
    std::array::from_fn(|k| (0..3).map(|i| corners[i][k] * weights[i]).sum())
}

/// A smooth function of position in metres, from 0 to 1.
fn color(at: DVec3) -> f64 {
    const WAVE: f64 = 0.08;
    let phase = at * (std::f64::consts::TAU / WAVE);
    0.5 + (phase.x.sin() + phase.y.sin() + phase.z.sin()) / 6.0
}

/// The peak signal-to-noise ratio of a colour that is transferred, in decibels, by area.
fn psnr(pair: &Pair) -> f64 {
    let (mut squares, mut areas) = (0.0, 0.0);
    for piece in pair.pieces() {
        let [target, source] = corners(&piece);
        let [a, b, c] = target.map(|weights| point_on(pair.target(), piece.target, weights));
        let area = (b - a).cross(c - a).length();
        for weights in [[0.6, 0.2, 0.2], [0.2, 0.6, 0.2], [0.2, 0.2, 0.6]] {
            let here = point_on(pair.target(), piece.target, mixed(target, weights));
            let there = point_on(pair.source(), piece.source, mixed(source, weights));
            squares += area * (color(here) - color(there)).powi(2);
            areas += area;
        }
    }
    10.0 * (areas / squares).log10()
}

/// How often random points of the target's linked faces are covered, by area.
#[derive(Debug, Default)]
struct Coverage {
    /// The share in exactly one piece.
    once: f64,
    /// The share in several.
    repeatedly: f64,
}

fn coverage(pair: &Pair) -> Coverage {
    const SAMPLES: usize = 8;
    let mut random = fastrand::Rng::with_seed(3);
    let (mut found, mut all) = (Coverage::default(), 0.0);
    let pieces: Vec<Piece> = pair.pieces().collect();
    for group in pieces.chunk_by(|one, other| one.target == other.target) {
        let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let [a, b, c] = unit.map(|weights| point_on(pair.target(), group[0].target, weights));
        let area = (b - a).cross(c - a).length();
        for _ in 0..SAMPLES {
            let (mut u, mut v) = (random.f64(), random.f64());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let contains = |piece: &&Piece| {
                let [a, b, c] = corners(piece)[0].map(|weights| [weights[1], weights[2]]);
                let side = |p: [f64; 2], q: [f64; 2]| {
                    (q[0] - p[0]) * (v - p[1]) - (q[1] - p[1]) * (u - p[0])
                };
                let sides = [side(a, b), side(b, c), side(c, a)];
                sides.iter().all(|side| *side > 0.0) || sides.iter().all(|side| *side < 0.0)
            };
            all += area;
            match group.iter().filter(contains).count() {
                0 => {}
                1 => found.once += area,
                _ => found.repeatedly += area,
            }
        }
    }
    Coverage { once: found.once / all, repeatedly: found.repeatedly / all }
}

/// Random triangles, which lie all over each other.
fn soup(seed: u64, count: u32) -> Mesh {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut place = || [random.f32(), random.f32(), random.f32()];
    let positions: Vec<[f32; 3]> = (0..3 * count).map(|_| place()).collect();
    let uv = positions.iter().map(|&[x, y, _]| [x, y]).collect();
    let faces: Vec<[u32; 3]> = (0..count).map(|k| [0, 1, 2].map(|at| 3 * k + at)).collect();
    Mesh::from_triangles(positions, uv, &faces, &faces).expect("a sound mesh")
}

fn refused(source: Mesh, target: Mesh) -> SurfaceError {
    let mut options = FindOptions::default();
    options.by = By::Surface;
    options.surface.align = Align::None;
    match find(source, target, &options).expect_err("no surfaces").0.remove(0) {
        MethodFailure::Surface(error) => error,
        other => panic!("{other}"),
    }
}

#[test]
fn triangles_that_make_up_no_surface_are_refused_within_a_limit() {
    let error = refused(soup(1, 2500), soup(2, 2500));
    assert!(matches!(error, SurfaceError::Overlaid { steps } if steps < 250_000_000), "{error}");
    // A point that thousands of others depend on: its equations would have millions of entries each.
    let wheel = |turn: f32| {
        const SIDES: u32 = 4000;
        let angle = |k: u32| turn + k as f32 / SIDES as f32 * std::f32::consts::TAU;
        let mut positions = vec![[0.0, 0.0, 0.2]];
        positions.extend((0..SIDES).map(|k| angle(k).sin_cos()).map(|(x, y)| [x, y, 0.0]));
        let uv = positions.iter().map(|&[x, y, _]| [x, y].map(|at| 0.5 + 0.4 * at)).collect();
        let faces: Vec<[u32; 3]> = (0..SIDES).map(|k| [0, k + 1, (k + 1) % SIDES + 1]).collect();
        let moved = |[x, y, z]: [f32; 3]| [x, y, z + turn];
        Mesh::from_triangles(positions.into_iter().map(moved).collect(), uv, &faces, &faces)
            .expect("a sound mesh")
    };
    assert_eq!(refused(wheel(0.0), wheel(0.03)), SurfaceError::Connected);
}

#[test]
fn remeshed_twins_carry_a_smooth_function() {
    let head = Figure::new().head;
    let twins = [
        ("turned", Remeshed::new(&head).turned()),
        ("divided", Remeshed::new(&head).divided()),
        ("decimated", Remeshed::new(&head).decimated(&head, 0.5, 1)),
        ("other", Remeshed::new(&head).turned().decimated(&head, 0.5, 2)),
    ];
    for (name, twin) in twins {
        let twin = twin.mesh(&head);
        for (source, target) in [(&head, &twin), (&twin, &head)] {
            let (pair, report) = registered(source, target);
            let (psnr, Coverage { once, repeatedly }) = (psnr(&pair), coverage(&pair));
            println!("{name}: {psnr:.1} dB, {once:.4} covered once");
            assert!(psnr >= 40.0, "{name}: {psnr} dB");
            assert!(repeatedly < 1e-4, "{name}: covered repeatedly {repeatedly}");
            assert!(once >= 0.995, "{name}: covered once {once}");
            // Where a twin cuts off a sharp edge, normals differ too much.
            assert!(report.covered >= 0.98, "{name}: covered {}", report.covered);
        }
    }
}

/// A head of another shape, elsewhere and in another unit.
fn another(head: &Mesh, shape: usize) -> Mesh {
    let anatomy = Anatomy::find(head).expect("the figure has a face");
    let frame = *anatomy.frame();
    let nose = DVec3::from(frame.local(anatomy.point(Landmark::NoseTip).expect("a nose")));
    let [wide, high, deep, jaw, longer, cheeks] = [
        [1.08, 1.05, 0.97, 0.06, 0.12, 0.05],
        [0.94, 1.10, 1.04, -0.05, -0.06, 0.0],
        [1.03, 0.94, 1.06, 0.10, 0.05, 0.12],
    ][shape];
    let turn = DQuat::from_rotation_y(0.4) * DQuat::from_rotation_x(-0.15);
    posed(head, false, |at| {
        let at = DVec3::from(frame.local(at));
        let below = (-at.y).clamp(0.0, 2.0) / 2.0;
        let bump = |center: DVec3, radius: f64| {
            (-(at - center).length_squared() / (radius * radius)).exp()
        };
        let cheek = bump(DVec3::new(0.8, -0.7, 0.4), 0.5) + bump(DVec3::new(-0.8, -0.7, 0.4), 0.5);
        let shaped = DVec3::new(
            at.x * (wide + jaw * below * below * (3.0 - 2.0 * below)),
            at.y * high,
            at.z * deep + longer * bump(nose, 0.45) + cheeks * cheek,
        );
        (turn * shaped * 21.0 + DVec3::new(40.0, -7.0, 3.0)).to_array()
    })
}

/// How far registered vertices are from where they belong.
struct Accuracy<'a> {
    target: &'a Mesh,
    anatomy: Anatomy,
    is_linked: Vec<bool>,
    errors_mm: Vec<f64>,
}

impl<'a> Accuracy<'a> {
    const FACE: [Area; 6] =
        [Area::Cheeks, Area::Forehead, Area::Nose, Area::Lips, Area::Jaw, Area::Brows];

    /// - `truth`: where each vertex of the target belongs on the source; NaN if that is not known.
    /// - `mm`: millimetres in a unit of the source.
    fn new(pair: &'a Pair, report: &SurfaceReport, truth: &[DVec3], mm: f64) -> Self {
        let target = pair.target();
        let mut is_linked = vec![false; truth.len()];
        for piece in pair.pieces() {
            let corners = target.faces()[piece.target as usize];
            corners.iter().for_each(|&vertex| is_linked[vertex as usize] = true);
        }
        let found = report.registered.iter().map(|&at| glam::Vec3::from(at).as_dvec3());
        let errors_mm = truth.iter().zip(found).map(|(at, found)| at.distance(found) * mm);
        let anatomy = Anatomy::find(target).expect("the target has a face");
        Self { errors_mm: errors_mm.collect(), target, anatomy, is_linked }
    }

    /// Quantiles of the errors within areas.
    fn at<const N: usize>(&self, areas: &[Area], shares: [f64; N]) -> [f64; N] {
        let is_within =
            |vertex: usize| areas.iter().any(|&area| self.anatomy.area(area)[vertex] > 0.5);
        let mut errors: Vec<f64> = (0..self.target.positions().len())
            .filter(|&vertex| self.is_linked[vertex] && is_within(vertex))
            .map(|vertex| self.errors_mm[vertex])
            .filter(|error| error.is_finite())
            .collect();
        errors.sort_unstable_by(f64::total_cmp);
        assert!(errors.len() > 10, "{} linked vertices", errors.len());
        shares.map(|share| errors[((errors.len() - 1) as f64 * share).round() as usize])
    }

    /// Fails unless a face is where it belongs.
    #[expect(clippy::print_stdout, reason = "the documents quote these figures")]
    fn check(&self, name: &str) {
        let [median, p90, p99] = self.at(&Self::FACE, [0.5, 0.9, 0.99]);
        let [[lips], [nose]] = [Area::Lips, Area::Nose].map(|area| self.at(&[area], [0.5]));
        let text = format!(
            "{name}: face {median:.2}, 90 % {p90:.2}, 99 % {p99:.2}, lips {lips:.2}, nose {nose:.2} mm"
        );
        println!("{text}");
        assert!(median <= 2.0 && p90 <= 5.0 && p99 <= 13.0 && lips <= 1.2 && nose <= 1.2, "{text}");
    }
}

#[test]
fn heads_of_other_shape_and_topology_are_registered() {
    const MM: f64 = 1000.0;
    let head = Figure::new().head;
    for shape in 0..3 {
        let remeshed = match shape {
            0 => Remeshed::new(&head).turned(),
            1 => Remeshed::new(&head).decimated(&head, 0.6, 5),
            _ => Remeshed::new(&head).turned().decimated(&head, 0.6, 6),
        };
        let target = remeshed.mesh(&another(&head, shape));
        let truth = remeshed.places(&head);
        let (pair, report) = registered(&head, &target);
        let text = format!("shape {shape}");
        Accuracy::new(&pair, &report, &truth, MM).check(&text);
        assert_eq!(report.flipped, 0, "{text}");
        let Coverage { once, repeatedly } = coverage(&pair);
        assert!(repeatedly < 1e-4, "{text}, covered repeatedly {repeatedly}");
        println!("{text}: {once:.4} covered once");
        // The rest is beyond the end of the other surface: of the neck, and of the hair's cap.
        assert!(once >= 0.98, "{text}, covered once {once}");
        assert!(report.covered > 0.97, "{text}, covered {}", report.covered);
    }
}

/// The front of a face, from the hairline to the chin, as an open sheet without eyes.
fn mask_of(head: &Mesh) -> Mesh {
    let frame = *Anatomy::find(head).expect("the figure has a face").frame();
    let is_front = |face: &usize| {
        let is_within = |&vertex: &u32| {
            let at = head.positions()[vertex as usize].map(f64::from);
            let [x, y, z] = frame.local(at);
            let is_eye = DVec3::new(x.abs() - 0.5, y, z).length() < 0.25;
            !is_eye && x.abs() < 1.05 && (-1.75..1.0).contains(&y) && z > -0.9
        };
        head.faces()[*face].iter().all(is_within)
    };
    let kept: Vec<usize> = (0..head.faces().len()).filter(is_front).collect();
    let faces: Vec<[u32; 3]> = kept.iter().map(|&face| head.faces()[face]).collect();
    let uv_faces: Vec<[u32; 3]> = kept.iter().map(|&face| head.uv_faces()[face]).collect();
    Mesh::from_triangles(head.positions().to_vec(), head.uv().to_vec(), &faces, &uv_faces)
        .expect("faces of a sound mesh")
}

#[test]
fn masks_are_registered_upright() {
    const MM: f64 = 1000.0;
    let head = Figure::new().head;
    let mask = mask_of(&another(&head, 1));
    let (pair, report) = registered(&head, &mask);
    let mut errors = Vec::new();
    for &vertex in mask.faces().as_flattened() {
        let at = |position: [f32; 3]| glam::Vec3::from(position).as_dvec3();
        let [truth, found] =
            [head.positions(), &report.registered].map(|all| at(all[vertex as usize]));
        errors.push(truth.distance(found) * MM);
    }
    errors.sort_unstable_by(f64::total_cmp);
    let median = errors[errors.len() / 2];
    println!("mask: {median:.2} mm, {:.4} covered", report.covered);
    assert!(median < 3.0 && report.covered > 0.9, "{median} mm, covered {}", report.covered);
    assert!(pair.piece_count() > 1000);
}

#[test]
fn noise_leaves_no_gaps() {
    /// Deviation of each coordinate, in metres: as of a depth sensor, on edges of about 2 mm.
    const NOISE_M: f64 = 0.000_15;
    let head = Figure::new().head;
    let twin = Remeshed::new(&head).divided().mesh(&head);
    let random = std::cell::RefCell::new(fastrand::Rng::with_seed(4));
    // About normal: the sum of four uniform numbers.
    let noise = || {
        let sum: f64 = (0..4).map(|_| random.borrow_mut().f64()).sum();
        (sum - 2.0) * NOISE_M * 3.0_f64.sqrt()
    };
    let noisy = posed(&twin, false, |at| at.map(|coordinate| coordinate + noise()));
    for (source, target) in [(&head, &noisy), (&noisy, &head)] {
        let (pair, report) = registered(source, target);
        let Coverage { once, repeatedly } = coverage(&pair);
        println!("noise: {once:.4} covered once, {:.4} in all", report.covered);
        assert!(once > 0.99 && repeatedly < 1e-3, "covered once {once}, repeatedly {repeatedly}");
        assert!(report.covered > 0.97, "covered {}", report.covered);
    }
}

/// Where the vertices of FLAME are on a head of HiFi3D++, according to FLAME's layout for the textures
/// of that head; NaN for eyeballs, which that head doesn't have.
fn according_to_layout(head: &Mesh, flame: &Mesh) -> Vec<DVec3> {
    let mut truth = vec![DVec3::NAN; flame.positions().len()];
    let corners: Vec<[[f32; 2]; 3]> = head
        .uv_faces()
        .iter()
        .map(|points| points.map(|point| head.uv()[point as usize]))
        .collect();
    for (vertices, points) in flame.faces().iter().zip(flame.uv_faces()) {
        for (&vertex, &point) in vertices.iter().zip(points) {
            let [u, v] = flame.uv()[point as usize];
            if u > 1.0 || !truth[vertex as usize].is_nan() {
                continue;
            }
            let weights = |[a, b, c]: &[[f32; 2]; 3]| {
                let cross = |p: &[f32; 2], q: &[f32; 2], r: [f32; 2]| {
                    let [px, py, qx, qy, rx, ry] =
                        [p[0], p[1], q[0], q[1], r[0], r[1]].map(f64::from);
                    (qx - px) * (ry - py) - (qy - py) * (rx - px)
                };
                let total = cross(a, b, *c);
                let at = [u, v];
                [cross(b, c, at) / total, cross(c, a, at) / total, cross(a, b, at) / total]
            };
            let found = (0..).zip(&corners).find_map(|(face, corners)| {
                let weights = weights(corners);
                weights.iter().all(|&weight| weight >= -1e-6).then(|| point_on(head, face, weights))
            });
            truth[vertex as usize] = found.unwrap_or(DVec3::NAN);
        }
    }
    truth
}

#[test]
fn flame_is_registered_to_a_real_head_as_an_artist_did() {
    /// HiFi3D++ counts in decimetres.
    const MM: f64 = 100.0;
    let Some(folder) = real::folder() else { return };
    let mesh = |name: &str| uvgraft_io::obj::read(folder.join(name)).expect("a sound mesh");
    let head = mesh("hifi3d_head.obj");
    let truth = according_to_layout(&head, &mesh("flame_hifi3d_uv.obj"));
    let (pair, report) = registered(&head, &mesh("flame_head_template.obj"));
    Accuracy::new(&pair, &report, &truth, MM).check("FLAME on HiFi3D++");
    assert_eq!(report.flipped, 0);
    let Coverage { once, repeatedly } = coverage(&pair);
    println!("FLAME on HiFi3D++: {once:.4} covered once, {:.4} in all", report.covered);
    assert!(once > 0.995 && repeatedly < 1e-4, "covered once {once}, repeatedly {repeatedly}");
    // That head has empty sockets, and eyeballs must not get their colours.
    let is_eye = |face: u32| {
        let eyes = pair.target().faces()[face as usize];
        // FLAME's eyeballs are its last vertices.
        eyes.iter().all(|&vertex| vertex >= 3931)
    };
    assert!(pair.pieces().all(|piece| !is_eye(piece.target)));
}
