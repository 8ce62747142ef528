//! Meshes of other topology and shape, linked by their surfaces.

use glam::{DQuat, DVec3};
use uvgraft::correspond::surface::SurfaceReport;
use uvgraft::correspond::{By, FindOptions, Method, find};
use uvgraft::piece::Weights;
use uvgraft::{Anatomy, Area, Extent, Landmark, Mesh, Pair, Piece};
use uvgraft_figure::Figure;
use uvgraft_tests::remeshed::Remeshed;
use uvgraft_tests::synthetic::posed;

fn registered(source: &Mesh, target: &Mesh) -> (Pair, SurfaceReport) {
    let mut options = FindOptions::default();
    options.by = By::Surface;
    let found = find(source.clone(), target.clone(), &options).expect("heads are found");
    let Method::Surface(report) = found.method else { panic!("not by surface") };
    (found.pair, report)
}

fn point(mesh: &Mesh, face: u32, weights: Weights) -> DVec3 {
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

/// The peak signal-to-noise ratio of a colour that is carried over, in decibels, by area.
fn psnr(pair: &Pair) -> f64 {
    let (mut squares, mut areas) = (0.0, 0.0);
    for piece in pair.pieces() {
        let [target, source] = corners(&piece);
        let [a, b, c] = target.map(|weights| point(pair.target(), piece.target, weights));
        let area = (b - a).cross(c - a).length();
        for weights in [[0.6, 0.2, 0.2], [0.2, 0.6, 0.2], [0.2, 0.2, 0.6]] {
            let here = point(pair.target(), piece.target, mixed(target, weights));
            let there = point(pair.source(), piece.source, mixed(source, weights));
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
        let [a, b, c] = unit.map(|weights| point(pair.target(), group[0].target, weights));
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
            assert!(psnr >= 40.0, "{name}: {psnr} dB");
            assert!(repeatedly < 1e-4, "{name}: covered repeatedly {repeatedly}");
            // Where a twin cuts off a sharp edge, normals differ too much.
            assert!(once >= 0.99, "{name}: covered once {once}");
            assert!(report.covered >= 0.96, "{name}: covered {}", report.covered);
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

struct Errors {
    name: &'static str,
    /// Sorted, in millimetres.
    mm: Vec<f64>,
}

impl Errors {
    fn at(&self, share: f64) -> f64 {
        self.mm[((self.mm.len() - 1) as f64 * share).round() as usize]
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
        let found: Vec<DVec3> =
            report.registered.iter().map(|at| glam::Vec3::from(*at).as_dvec3()).collect();
        let mut linked = vec![false; truth.len()];
        for piece in pair.pieces() {
            target.faces()[piece.target as usize]
                .iter()
                .for_each(|&vertex| linked[vertex as usize] = true);
        }
        let anatomy = Anatomy::find(&target).unwrap();
        let within = |areas: &[Area], vertex: usize| {
            areas.iter().any(|&area| anatomy.area(area)[vertex] > 0.5)
        };
        let face = [Area::Cheeks, Area::Forehead, Area::Nose, Area::Lips, Area::Jaw, Area::Brows];
        let errors = |name: &'static str, areas: &[Area]| {
            let mut mm: Vec<f64> = (0..truth.len())
                .filter(|&vertex| linked[vertex] && within(areas, vertex))
                .map(|vertex| truth[vertex].distance(found[vertex]) * MM)
                .collect();
            mm.sort_unstable_by(f64::total_cmp);
            assert!(mm.len() > 10, "{name}: {} linked vertices", mm.len());
            Errors { name, mm }
        };
        let all = errors("face", &face);
        let text = format!("shape {shape}: {} {} {}", all.at(0.5), all.at(0.9), all.at(0.99));
        assert!(all.at(0.5) <= 2.0 && all.at(0.9) <= 5.0 && all.at(0.99) <= 13.0, "{text}");
        for part in [errors("lips", &[Area::Lips]), errors("nose", &[Area::Nose])] {
            assert!(part.at(0.5) <= 1.2, "{text}, {} {}", part.name, part.at(0.5));
        }
        assert_eq!(report.flipped, 0, "{text}");
        let Coverage { once, repeatedly } = coverage(&pair);
        assert!(repeatedly < 1e-4, "{text}, covered repeatedly {repeatedly}");
        // The rest is beyond the end of the other surface: of the neck, and of the hair's cap.
        assert!(once >= 0.97, "{text}, covered once {once}");
        assert!(report.covered > 0.95, "{text}, covered {}", report.covered);
    }
}
