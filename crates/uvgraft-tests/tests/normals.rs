//! Normal maps transferred to another layout equal those baked there.

#![expect(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::sync::Arc;

use uvgraft::{
    Channels, Content, Depth, Direction, Encoding, Filter, Graft, Mesh, NormalFrames,
    NormalOptions, NormalY, Pair, Size, Sizes, Texels, Texture,
};
use uvgraft_figure::Figure;
use uvgraft_tests::normal_bake::{
    Baked, Spots, angle, bake, face_rotations, linked_faces, rotated, spots,
};
use uvgraft_tests::{real, synthetic};

type Vector = [f64; 3];

/// Baked at about five hundred texels, wrinkles are sampled finely enough for bilinear filtering;
/// the remaining errors are kinks of the frames between triangles within a filter's four texels.
const MEDIAN_DEGREES: f64 = 1.0;
const P99_DEGREES: f64 = 3.0;

fn texture(size: Size, texels: &[[f32; 3]]) -> Texture {
    let texels = Texels::F32(texels.as_flattened().to_vec());
    Texture::new(size, Channels::Rgb, Encoding::Data, texels).unwrap()
}

fn quantised(texture: &Texture) -> Texture {
    let Texels::F32(values) = texture.texels() else { panic!("floats") };
    let levels = values.iter().map(|value| (value * 255.0).round() / 255.0).collect();
    Texture::new(texture.size(), Channels::Rgb, Encoding::Data, Texels::F32(levels)).unwrap()
}

/// The result of a transfer of a map over a flat one.
fn transferred(graft: &Graft, source: &Texture) -> Vec<f32> {
    let base = [0.5, 0.5, 1.0];
    let size = graft.sizes().to;
    let base = Texture::filled(size, Channels::Rgb, Encoding::Data, Depth::F32, &base).unwrap();
    let result = graft.apply(source, base).unwrap();
    let Texels::F32(values) = result.into_texels() else { panic!("floats") };
    values
}

fn bilinear(pair: &Arc<Pair>, direction: Direction, size: Size, content: Content) -> Graft {
    Graft::builder(Arc::clone(pair), Sizes { from: size, to: size })
        .direction(direction)
        .filter(Filter::Bilinear)
        .content(content)
        .build()
        .unwrap()
}

/// Filters normals without rotating them.
fn copying(pair: &Arc<Pair>, direction: Direction, size: Size) -> Graft {
    bilinear(pair, direction, size, Content::Data)
}

/// Filters normals and rotates them.
fn turning(pair: &Arc<Pair>, direction: Direction, size: Size) -> Graft {
    bilinear(pair, direction, size, Content::Normals(NormalOptions::default()))
}

/// A pair with both layouts baked.
struct Scene {
    pair: Arc<Pair>,
    size: Size,
    source: Baked,
    target: Baked,
}

impl Scene {
    /// - `own`: maps a triangle of the source, a position and a normal, both in the target's space,
    ///   to the normal in the source's space.
    fn new(pair: Arc<Pair>, size: Size, own: impl Fn(usize, Vector, Vector) -> Vector) -> Self {
        let (of_source, of_target): (Spots, Spots) = spots(&pair);
        let source = bake(pair.source(), &of_source, size, NormalY::OpenGl, own);
        let target = bake(pair.target(), &of_target, size, NormalY::OpenGl, |_, _, normal| normal);
        Self { pair, size, source, target }
    }

    fn same(pair: Arc<Pair>, size: Size) -> Self {
        Self::new(pair, size, |_, _, normal| normal)
    }

    fn sides(&self, direction: Direction) -> (&Baked, &Baked) {
        match direction {
            Direction::Forward => (&self.source, &self.target),
            Direction::Reverse => (&self.target, &self.source),
        }
    }

    /// Angles to the directly baked map: without rotation, rotated, and rotated from 8 bits.
    fn compare(&self, direction: Direction) -> [Errors; 3] {
        let (from, to) = self.sides(direction);
        let copying = copying(&self.pair, direction, self.size);
        let turning = turning(&self.pair, direction, self.size);
        let source = texture(self.size, &from.texels);
        let [naive, turned] = [&copying, &turning].map(|graft| transferred(graft, &source));
        [naive, turned, transferred(&turning, &quantised(&source))]
            .map(|values| self.errors(&turning, &values, to))
    }

    fn errors(&self, graft: &Graft, values: &[f32], wanted: &Baked) -> Errors {
        // Where triangles share texels, only one of them was baked.
        let mut is_shared = wanted.is_shared.clone();
        for ([target, source], _) in linked_faces(&self.pair) {
            match graft.direction() {
                Direction::Forward => is_shared[target] |= self.source.is_shared[source],
                Direction::Reverse => is_shared[source] |= self.target.is_shared[target],
            }
        }
        let map = graft.map();
        let mut errors = Vec::new();
        for row in 0..self.size.height {
            for &run in map.row(row).iter().filter(|run| !map.is_gutter(**run)) {
                if is_shared[map.patches()[run.patch as usize].face as usize] {
                    continue;
                }
                for x in run.x..run.x + run.len {
                    let texel = (row * self.size.width + x) as usize;
                    errors.push(angle(&values[texel * 3..][..3], &wanted.texels[texel]));
                }
            }
        }
        Errors::new(errors)
    }
}

#[derive(Debug)]
struct Errors {
    median: f64,
    p99: f64,
    texels: usize,
}

impl Errors {
    fn new(mut errors: Vec<f64>) -> Self {
        errors.sort_by(f64::total_cmp);
        let at = |share: f64| errors[((errors.len() - 1) as f64 * share) as usize];
        Self { median: at(0.5), p99: at(0.99), texels: errors.len() }
    }

    fn assert_below(&self, name: &str, median: f64, p99: f64) {
        assert!(self.texels > 5_000, "{name}: {self:?}");
        assert!(self.median < median && self.p99 < p99, "{name}: {self:?}");
    }
}

/// - `copied`: lower bounds of the errors of copying, median and p99.
#[expect(clippy::print_stdout, reason = "figures of a test, shown where it fails")]
fn assert_transfers(name: &str, scene: &Scene, copied: [f64; 2]) {
    for direction in [Direction::Forward, Direction::Reverse] {
        let [naive, turned, from_bytes] = scene.compare(direction);
        println!("{name} {direction:?}:\n  {naive:?}\n  {turned:?}\n  {from_bytes:?}");
        let is_worse = naive.median > copied[0] && naive.p99 > copied[1];
        assert!(is_worse, "{name}: copying does as well: {naive:?}");
        turned.assert_below(name, MEDIAN_DEGREES, P99_DEGREES);
        // Half a level of 8 bits is up to 0.4° along the diagonal.
        from_bytes.assert_below(name, MEDIAN_DEGREES + 0.2, P99_DEGREES + 0.4);
    }
}

#[test]
fn charts_that_are_turned_and_mirrored_keep_their_surface() {
    assert_transfers(
        "charts",
        &Scene::same(synthetic::turned_charts(), Size::square(512)),
        [20.0, 90.0],
    );
}

fn figure() -> Arc<Pair> {
    let figure = Figure::new();
    let vertex_map: Vec<i64> = figure.vertex_map.iter().map(|&vertex| vertex.into()).collect();
    Arc::new(Pair::by_vertex_map(figure.head, figure.body, &vertex_map).unwrap())
}

#[test]
fn the_figure_keeps_its_surface() {
    // Most of it has the same orientation in both layouts; hair and the back of the head are
    // rotated.
    assert_transfers("figure", &Scene::same(figure(), Size::square(2048)), [0.0, 90.0]);
}

#[test]
fn the_real_pair_keeps_its_surface() {
    let Some(pair) = real::flame_to_smplx() else { return };
    // Both layouts on one shape, so that they alone differ.
    let mut places = vec![None; pair.source().positions().len()];
    for ([target, source], corners) in linked_faces(&pair) {
        let vertices = pair.target().faces()[target];
        for (vertex, corner) in vertices.into_iter().zip(corners) {
            let of_source = pair.source().faces()[source][corner];
            places[of_source as usize] = Some(pair.target().positions()[vertex as usize]);
        }
    }
    let positions = places.into_iter().zip(pair.source().positions());
    let positions = positions.map(|(place, &own)| place.unwrap_or(own)).collect();
    let source = pair.source();
    let source =
        Mesh::from_triangles(positions, source.uv().to_vec(), source.faces(), source.uv_faces());
    let same = Pair::from_pieces(source.unwrap(), pair.target().clone(), pair.pieces());
    let same = Scene::same(Arc::new(same.unwrap()), Size::square(2048));
    assert_transfers("real layouts", &same, [3.0, 20.0]);

    // The unmodified meshes: two heads of nearly the same shape, held at different angles.
    let rotations = face_rotations(&pair);
    let own = |face: usize, _, normal| rotated(&rotations[face].unwrap(), normal);
    let scene = Scene::new(pair, Size::square(2048), own);
    for direction in [Direction::Forward, Direction::Reverse] {
        let [naive, turned, _] = scene.compare(direction);
        println!("real {direction:?}: {naive:?}\n  {turned:?}");
        // The shapes differ by degrees, and so do the frames of triangles, some of which are
        // folded.
        turned.assert_below("real", 2.5, 25.0);
        // A flat map on one is nearly flat on the other.
        let graft = turning(&scene.pair, direction, scene.size);
        let flat = vec![[0.5, 0.5, 1.0]; scene.size.texels()];
        let values = transferred(&graft, &texture(scene.size, &flat));
        let flat = Baked { texels: flat, is_shared: scene.sides(direction).1.is_shared.clone() };
        let tilt = scene.errors(&graft, &values, &flat);
        println!("  flat: {tilt:?}");
        tilt.assert_below("real, flat", 1.0, 6.0);
    }
}

/// The pair with another source: other positions and, if `rewind`, all faces wound the other way.
fn with_source(pair: &Pair, rewind: bool, place: impl Fn(Vector) -> Vector) -> Arc<Pair> {
    let placed = synthetic::posed(pair.source(), rewind, place);
    let mut vertex_map = vec![-1; placed.positions().len()];
    for ([target, source], corners) in linked_faces(pair) {
        let vertices = pair.target().faces()[target];
        for (vertex, corner) in vertices.into_iter().zip(corners) {
            let of_source = pair.source().faces()[source][corner];
            vertex_map[of_source as usize] = i64::from(vertex);
        }
    }
    Arc::new(Pair::by_vertex_map(placed, pair.target().clone(), &vertex_map).unwrap())
}

/// Rotated by quarter turns about two axes and by 0.6 radians about a third.
fn turn([x, y, z]: Vector) -> Vector {
    let (sin, cos) = 0.6f64.sin_cos();
    let [x, y, z] = [z, x, y];
    [cos * x - sin * y, sin * x + cos * y, z]
}

#[test]
fn a_mesh_that_is_placed_differently_has_the_same_map() {
    let pair = synthetic::turned_charts();
    let place = |at: Vector| {
        let at = turn(at).map(|value| value * 170.0);
        [at[0] + 3.0, at[1] - 40.0, at[2]]
    };
    let placed = with_source(&pair, false, place);
    let size = Size::square(512);
    let scene = Scene::new(Arc::clone(&placed), size, |_, _, normal| turn(normal));
    assert_transfers("placed", &scene, [20.0, 90.0]);
    // Texel by texel it equals the result for the original mesh, up to rounding of positions.
    let source = texture(size, &scene.source.texels);
    let [a, b] =
        [&pair, &placed].map(|pair| transferred(&turning(pair, Direction::Forward, size), &source));
    let worst = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst < 1e-3, "{worst}");
}

#[test]
fn a_mesh_that_is_wound_the_other_way_has_its_normals_turned_around() {
    let pair = with_source(&synthetic::turned_charts(), true, |at| at);
    assert!(pair.pieces().all(|piece| piece.flips()));
    assert_transfers("rewound", &Scene::same(pair, Size::square(512)), [20.0, 90.0]);
}

#[test]
fn a_mirror_image_is_recognised() {
    let pair = figure();
    let mirrored = |[x, y, z]: Vector| [x, y, -z];
    // Mirrored files usually keep their front faces in front, but either winding works.
    for rewind in [true, false] {
        let pair = with_source(&pair, rewind, mirrored);
        let scene = Scene::new(pair, Size::square(1024), |_, _, normal| mirrored(normal));
        let [_, turned, _] = scene.compare(Direction::Forward);
        println!("{turned:?}");
        turned.assert_below("mirrored", MEDIAN_DEGREES, P99_DEGREES);
    }
}

#[test]
fn a_bent_mesh_is_followed_part_by_part() {
    // Bent around an axis along y by 2.5 radians from one side to the other: lengths in the x-y
    // plane are preserved, except for the effect of height.
    const RADIUS: f64 = 0.4;
    let place = |[x, y, z]: Vector| {
        let (sin, cos) = (x / RADIUS).sin_cos();
        let far = RADIUS + 0.15 * z;
        [sin * far, y, cos * far - RADIUS]
    };
    let turn = |_, [x, ..]: Vector, [nx, ny, nz]: Vector| {
        let (sin, cos) = (x / RADIUS).sin_cos();
        [cos * nx + sin * nz, ny, cos * nz - sin * nx]
    };
    // Flat in both poses, so that they differ by little more than rotations.
    let pair = synthetic::turned_charts();
    let low = synthetic::posed(pair.target(), false, |[x, y, z]| [x, y, 0.15 * z]);
    let vertex_map: Vec<i64> = (0..low.positions().len() as i64).collect();
    let source = synthetic::posed(pair.source(), false, place);
    let pair = Arc::new(Pair::by_vertex_map(source, low, &vertex_map).unwrap());
    let scene = Scene::new(pair, Size::square(512), turn);
    for direction in [Direction::Forward, Direction::Reverse] {
        let [_, turned, _] = scene.compare(direction);
        println!("{direction:?} {turned:?}");
        // Bending stretches the outside of raised parts.
        turned.assert_below("bent", 1.0, 4.0);
    }
}

#[test]
fn green_follows_the_convention() {
    let pair = synthetic::turned_charts();
    let size = Size::square(256);
    let (of_source, _) = spots(&pair);
    let graft = |source: NormalY, target: NormalY| {
        let content = Content::Normals(NormalOptions::new(source, target));
        bilinear(&pair, Direction::Forward, size, content)
    };
    let turned = |source: NormalY, target: NormalY| {
        let baked = bake(pair.source(), &of_source, size, source, |_, _, normal| normal);
        transferred(&graft(source, target), &texture(size, &baked.texels))
    };
    let wanted = turned(NormalY::OpenGl, NormalY::OpenGl);
    let graft = graft(NormalY::OpenGl, NormalY::OpenGl);
    let map = graft.map();
    for source in [NormalY::OpenGl, NormalY::DirectX] {
        for target in [NormalY::OpenGl, NormalY::DirectX] {
            let found = turned(source, target);
            for row in 0..size.height {
                let reached = map.row(row).iter().flat_map(|run| run.x..run.x + run.len);
                for texel in reached.map(|x| (row * size.width + x) as usize * 3) {
                    let [found, wanted] = [&found, &wanted].map(|values| &values[texel..][..3]);
                    let green = if target == NormalY::OpenGl { found[1] } else { 1.0 - found[1] };
                    let error = angle(&[found[0], green, found[2]], wanted);
                    // Rounding of encoded floats.
                    assert!(error < 1e-3, "{source:?} {target:?}: {error}");
                }
            }
        }
    }
}

/// One square, upright in the source, with the given target layout.
fn square_to(target_uv: [[f32; 2]; 4]) -> Arc<Pair> {
    let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let faces = [[0, 1, 2], [0, 2, 3]];
    let upright = vec![[0.1, 0.9], [0.9, 0.9], [0.9, 0.1], [0.1, 0.1]];
    let mesh = |uv| Mesh::from_triangles(positions.clone(), uv, &faces, &faces).unwrap();
    let pair = Pair::by_vertex_map(mesh(upright), mesh(target_uv.to_vec()), &[0, 1, 2, 3]);
    Arc::new(pair.unwrap())
}

#[test]
fn a_square_by_hand_with_its_gutter() {
    // Tilted to the right by 0.6, and up by 0.
    let right = [0.8, 0.5, 0.9];
    let cases = [
        // Unchanged.
        ([[0.1, 0.9], [0.9, 0.9], [0.9, 0.1], [0.1, 0.1]], [0.8, 0.5, 0.9]),
        // The right side is now at the top: tilted up.
        ([[0.9, 0.9], [0.9, 0.1], [0.1, 0.1], [0.1, 0.9]], [0.5, 0.8, 0.9]),
        // Mirrored: tilted to the left.
        ([[0.9, 0.9], [0.1, 0.9], [0.1, 0.1], [0.9, 0.1]], [0.2, 0.5, 0.9]),
        // Mirrored and rotated: the right side is now at the bottom.
        ([[0.1, 0.1], [0.1, 0.9], [0.9, 0.9], [0.9, 0.1]], [0.5, 0.2, 0.9]),
    ];
    for (target, wanted) in cases {
        let pair = square_to(target);
        let size = Size::new(64, 48);
        let source = texture(size, &vec![right; size.texels()]);
        let graft = turning(&pair, Direction::Forward, size);
        let values = transferred(&graft, &source);
        assert_eq!(graft.map().stats().linked + graft.map().stats().gutter, size.texels());
        for texel in values.chunks_exact(3) {
            let is_wanted = (0..3).all(|k| (texel[k] - wanted[k]).abs() < 1e-6);
            assert!(is_wanted, "{texel:?}, wanted {wanted:?}");
        }
    }
}

#[test]
fn bands_and_opacity_do_not_show() {
    let scene = Scene::same(synthetic::turned_charts(), Size::square(200));
    let graft = copying(&scene.pair, Direction::Forward, scene.size);
    let frames = NormalFrames::new(&scene.pair, Direction::Forward);
    let (map, options) = (graft.map(), NormalOptions::default());
    let source = texture(scene.size, &scene.source.texels);
    let filtered = transferred(&graft, &source);
    let mut whole = filtered.clone();
    frames.turn(map, options, 0, &mut whole, Channels::Rgb);
    assert_eq!(whole, transferred(&turning(&scene.pair, Direction::Forward, scene.size), &source));
    let mut banded = filtered.clone();
    for (band, values) in (0..).zip(banded.chunks_mut(200 * 3 * 7)) {
        frames.turn(map, options, band * 7, values, Channels::Rgb);
    }
    assert_eq!(whole, banded);
    let with_opacity = |values: &[f32]| -> Vec<f32> {
        values.chunks_exact(3).flat_map(|texel| [texel[0], texel[1], texel[2], 0.3]).collect()
    };
    let mut values = with_opacity(&filtered);
    frames.turn(map, options, 0, &mut values, Channels::Rgba);
    assert_eq!(values, with_opacity(&whole));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut alone = filtered;
    pool.install(|| {
        let frames = NormalFrames::new(&scene.pair, Direction::Forward);
        frames.turn(map, options, 0, &mut alone, Channels::Rgb);
    });
    assert_eq!(whole, alone);
}

#[test]
fn the_gutter_continues_its_island() {
    let pair = synthetic::turned_charts();
    let scene = Scene::same(pair, Size::square(512));
    let graft = turning(&scene.pair, Direction::Forward, scene.size);
    let values = transferred(&graft, &texture(scene.size, &scene.source.texels));
    let map = graft.map();
    let mut jumps = Vec::new();
    for row in 0..scene.size.height {
        for pair in map.row(row).windows(2) {
            let meet = pair[0].x + pair[0].len == pair[1].x;
            if meet && map.is_gutter(pair[0]) != map.is_gutter(pair[1]) {
                let right = (row * scene.size.width + pair[1].x) as usize * 3;
                jumps.push(angle(&values[right - 3..][..3], &values[right..][..3]));
            }
        }
        let lengths = map.row(row).iter().flat_map(|run| run.x..run.x + run.len).map(|x| {
            let texel = &values[(row * scene.size.width + x) as usize * 3..][..3];
            texel.iter().map(|value| (value * 2.0 - 1.0).powi(2)).sum::<f32>()
        });
        assert!(lengths.into_iter().all(|length| (length - 1.0).abs() < 1e-5));
    }
    assert!(jumps.len() > 1000);
    // Between adjacent texels wrinkles rotate by up to a degree, and frames with the surface.
    let worst = jumps.iter().copied().fold(0.0, f64::max);
    assert!(worst < 2.5, "{worst}° from one texel to the next");
}

/// Random triangles of few vertices and UV coordinates, some enormous, with most possible defects.
fn broken(rng: &mut fastrand::Rng, size: f32) -> Mesh {
    let positions = (0..12).map(|_| [(); 3].map(|()| (rng.f32() - 0.5) * size)).collect();
    let uv = (0..12).map(|_| [rng.f32(), (rng.f32() * 4.0).floor() / 4.0]).collect();
    let faces: Vec<[u32; 3]> = (0..40).map(|_| [(); 3].map(|()| rng.u32(..12))).collect();
    let uv_faces: Vec<[u32; 3]> = (0..40).map(|_| [(); 3].map(|()| rng.u32(..12))).collect();
    Mesh::from_triangles(positions, uv, &faces, &uv_faces).unwrap()
}

#[test]
fn broken_meshes_and_texels_give_normals_all_the_same() {
    let mut rng = fastrand::Rng::with_seed(9);
    for size in [0.0, 1e-38, 1.0, 1e20, 3e38] {
        let source = broken(&mut rng, size);
        let target = synthetic::posed(&broken(&mut rng, size), false, |at| at);
        // The same triangles in both, with other positions and UV coordinates.
        let source = Mesh::from_triangles(
            source.positions().to_vec(),
            source.uv().to_vec(),
            target.faces(),
            source.uv_faces(),
        );
        let vertex_map: Vec<i64> = (0..12).collect();
        let pair = Arc::new(Pair::by_vertex_map(source.unwrap(), target, &vertex_map).unwrap());
        let side = Size::square(96);
        for direction in [Direction::Forward, Direction::Reverse] {
            let graft = copying(&pair, direction, side);
            let special = [f32::NAN, f32::INFINITY, 0.5, 0.2, 1e38];
            let mut values: Vec<f32> =
                (0..side.texels() * 3).map(|_| special[rng.usize(..special.len())]).collect();
            let before = values.clone();
            let frames = NormalFrames::new(&pair, direction);
            let map = graft.map();
            frames.turn(map, NormalOptions::default(), 0, &mut values, Channels::Rgb);
            for row in 0..side.height {
                let mut is_reached = vec![false; side.width as usize];
                for run in map.row(row) {
                    is_reached[run.x as usize..(run.x + run.len) as usize].fill(true);
                }
                for (x, is_reached) in is_reached.into_iter().enumerate() {
                    let at = (row * side.width) as usize * 3 + x * 3;
                    let [found, before] = [&values, &before].map(|values| &values[at..][..3]);
                    if is_reached {
                        let length: f32 =
                            found.iter().map(|value| (value * 2.0 - 1.0).powi(2)).sum();
                        assert!((length - 1.0).abs() < 1e-5, "{found:?}");
                    } else {
                        assert!(found.iter().zip(before).all(|(a, b)| a.to_bits() == b.to_bits()));
                    }
                }
            }
        }
    }
}
