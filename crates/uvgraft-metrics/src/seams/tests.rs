use uvgraft::color::delta_e;
use uvgraft::texture::{Channels, Depth, Size, Texels};

use super::*;

const RED: [f32; 3] = [0.8, 0.2, 0.2];
const BLUE: [f32; 3] = [0.2, 0.2, 0.8];

/// Two adjacent squares along x, each with its own width and its own rectangle in the texture
/// (left, top, right, bottom). Vertices are split where they meet, as exporters do.
fn squares(widths: [f32; 2], places: [[f32; 4]; 2]) -> Mesh {
    let [a, b] = widths;
    let square =
        |from: f32, to: f32| [[from, 0.0, 0.0], [to, 0.0, 0.0], [to, 1.0, 0.0], [from, 1.0, 0.0]];
    let positions = [square(0.0, a), square(a, a + b)].concat();
    let corners = |[left, top, right, bottom]: [f32; 4]| {
        [[left, top], [right, top], [right, bottom], [left, bottom]]
    };
    let uv = places.map(corners).concat();
    let faces = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    Mesh::from_triangles(positions, uv, &faces, &faces).unwrap()
}

/// A texture of 100×100 texels of 32-bit floats.
fn painted(color: impl Fn(f32, f32) -> [f32; 3]) -> Texture {
    let at = |index: u32| color((index % 100) as f32 + 0.5, (index / 100) as f32 + 0.5);
    let texels = Texels::F32((0..10_000).flat_map(at).collect());
    Texture::new(Size::square(100), Channels::Rgb, Encoding::Srgb, texels).unwrap()
}

/// Red in the left half, blue in the right one.
fn halves() -> Texture {
    painted(|x, _| if x < 50.0 { RED } else { BLUE })
}

const APART: [[f32; 4]; 2] = [[0.1, 0.1, 0.4, 0.3], [0.6, 0.4, 0.9, 0.8]];
const TOGETHER: [[f32; 4]; 2] = [[0.2, 0.1, 0.5, 0.3], [0.5, 0.1, 0.9, 0.3]];

fn measured(mesh: &Mesh, texture: &Texture, inside: [bool; 4], offset: Offset) -> SeamReport {
    measure(mesh, texture, &inside, &SeamOptions { offset, ..SeamOptions::default() }).unwrap()
}

fn close(found: f64, wanted: f64) {
    assert!((found - wanted).abs() < 1e-6, "found {found}, wanted {wanted}");
}

fn close_uv(found: [[f64; 2]; 2], wanted: [[f64; 2]; 2]) {
    for (found, wanted) in found.as_flattened().iter().zip(wanted.as_flattened()) {
        // UV coordinates are stored as 32-bit floats.
        assert!((found - wanted).abs() < 1e-6, "{found} in {found:?}, wanted {wanted:?}");
    }
}

#[test]
fn two_islands_of_two_colours() {
    let mesh = squares([1.0, 1.0], APART);
    let report = measured(&mesh, &halves(), [true; 4], Offset::Texels(1.0));
    let wanted = delta_e(RED, BLUE);
    assert!(wanted > 40.0);
    // One seam; the right island has more texels along it: 40.
    let EdgeGroup { edges, length, points, delta_e } = report.uv_seams;
    assert_eq!((edges, length, points), (1, 1.0, 40));
    let steps = delta_e.unwrap();
    for found in [steps.mean, steps.median, steps.p95, steps.p99, steps.max] {
        close(found, wanted);
    }
    assert_eq!(report.uv_seams_inside, report.uv_seams);
    assert_eq!((report.rim.edges, report.rim.delta_e), (0, None));
    // Two diagonals, each within one colour.
    let EdgeGroup { edges, length, points, delta_e } = report.ordinary;
    assert_eq!(edges, 2);
    // 36 and 50 texels, less those near the corners, where walks leave the squares.
    assert!((70..86).contains(&points), "{points}");
    close(length, 2.0 * 2f64.sqrt());
    assert_eq!(delta_e.unwrap().max, 0.0);
    assert_eq!(report.beside_uv_seams, report.ordinary);
    assert_eq!(report.beside_uv_seams_inside, report.ordinary);
    assert_eq!(report.beside_rim.edges, 0);
    assert_eq!(report.notes, SeamNotes { single_edges: 6, ..SeamNotes::default() });

    assert_eq!(report.worst, [0]);
    let seam = &report.edges[0];
    assert_eq!((seam.sides[0].face, seam.sides[0].corner), (0, 1));
    assert_eq!((seam.sides[1].face, seam.sides[1].corner), (3, 2));
    assert_eq!(seam.sides[0].uv, [[0.4, 0.1], [0.4, 0.3]]);
    assert_eq!(seam.sides[1].uv, [[0.6, 0.4], [0.6, 0.8]]);
    assert_eq!(seam.ends, [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]);
    // All steps are equal, so the first one is the worst: half a point spacing from the first end.
    let step = seam.worst.unwrap();
    close(step.along, 0.0125);
    close_uv(step.uv, [[0.4, 0.1025], [0.6, 0.405]]);
    close_uv(step.sampled, [[0.39, 0.1025], [0.61, 0.405]]);
    close(f64::from(step.colors[0][0]), 0.8);
    close(f64::from(step.colors[1][2]), 0.8);
}

#[test]
fn a_continuous_texture_has_no_step() {
    let across = |x: f32, y: f32| [x / 100.0, y / 100.0, 0.5];
    let mirrored = [[0.1, 0.1, 0.4, 0.3], [0.4, 0.1, 0.1, 0.3]];
    let report =
        measured(&squares([1.0; 2], mirrored), &painted(across), [true; 4], Offset::Texels(1.0));
    // The right island lies on the left one, folded at the edge: not a UV seam.
    assert_eq!(report.uv_seams.edges, 0);
    // Mirrored and moved.
    let turned = [[0.1, 0.1, 0.4, 0.3], [0.9, 0.1, 0.6, 0.3]];
    let repeated = painted(|x, y| across(x % 50.0, y));
    let report = measured(&squares([1.0; 2], turned), &repeated, [true; 4], Offset::Texels(3.0));
    assert!(report.uv_seams.delta_e.unwrap().max < 1e-4, "{:?}", report.uv_seams);
    let step = report.edges[0].worst.unwrap();
    close(step.sampled[0][0], 0.37);
    close(step.sampled[1][0], 0.87);
}

#[test]
fn the_rim_may_be_inside_an_island() {
    let mesh = squares([1.0, 3.0], TOGETHER);
    let (left, right) = ([true, true, false, false], [false, false, true, true]);
    let report = measured(&mesh, &halves(), left, Offset::Texels(1.0));
    assert_eq!((report.uv_seams.edges, report.rim.edges, report.rim.points), (0, 1, 20));
    close(report.rim.delta_e.unwrap().median, delta_e(RED, BLUE));
    assert_eq!((report.beside_rim.edges, report.ordinary.edges), (2, 2));
    assert!(report.edges[0].is_rim && !report.edges[0].is_uv_seam);
    // The diagonals end at the boundary, but no point on them samples across it.
    assert_eq!(report.beside_rim.delta_e.unwrap().max, 0.0);
    assert!(report.beside_rim.points > 60, "{:?}", report.beside_rim);
    // The region's side comes first.
    let red_first = |report: &SeamReport| report.edges[0].worst.unwrap().colors[0][0] > 0.5;
    assert!(red_first(&report));
    assert!(!red_first(&measured(&mesh, &halves(), right, Offset::Texels(1.0))));
    // Exactly on the edge both sides have the same colour.
    let report = measured(&mesh, &halves(), left, Offset::Texels(0.0));
    close(report.rim.delta_e.unwrap().max, 0.0);
}

#[test]
fn distances_are_those_of_the_surface() {
    // 0.25 is a quarter of the left square, 30 texels wide, and a twelfth of the right one, 40
    // texels wide.
    let mesh = squares([1.0, 3.0], TOGETHER);
    let region = [true, true, false, false];
    let report = measured(&mesh, &halves(), region, Offset::Distance(0.25));
    let step = report.edges[0].worst.unwrap();
    let v = step.uv[0][1];
    close_uv(step.sampled, [[0.5 - 0.075, v], [0.5 + 0.4 / 12.0, v]]);
    assert_eq!(report.notes.shortened, 0);
    // The left square is narrower than 2.
    let report = measured(&mesh, &halves(), region, Offset::Distance(2.0));
    assert_eq!(report.notes.shortened, 20);
    let step = report.edges[0].worst.unwrap();
    close_uv(step.sampled, [[0.2, v], [0.5 + 0.8 / 3.0, v]]);
}

/// A long seam without a step and a short one with a step: weights are lengths on the surface, not
/// numbers of texels.
#[test]
fn long_edges_weigh_more() {
    // Three triangles around an edge of length 3 and one of length 1.
    let positions =
        vec![[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 1.0, 0.0], [2.0, -1.0, 0.0], [4.0, 0.5, 0.0]];
    let faces = [[0, 1, 2], [1, 0, 3], [2, 1, 4]];
    let uv = vec![
        [0.1, 0.1],
        [0.3, 0.1],
        [0.3, 0.3],
        [0.3, 0.6],
        [0.1, 0.6],
        [0.2, 0.8],
        [0.7, 0.1],
        [0.7, 0.7],
        [0.9, 0.5],
    ];
    let mesh =
        Mesh::from_triangles(positions, uv, &faces, &[[0, 1, 2], [3, 4, 5], [6, 7, 8]]).unwrap();
    let options = SeamOptions::default();
    let report = measure(&mesh, &halves(), &[true; 3], &options).unwrap();
    let EdgeGroup { edges, length, points, delta_e: steps } = report.uv_seams;
    assert_eq!((edges, length, points), (2, 4.0, 20 + 60));
    let (steps, wanted) = (steps.unwrap(), delta_e(RED, BLUE));
    close(steps.mean, wanted / 4.0);
    assert_eq!(steps.median, 0.0);
    close(steps.p95, wanted);
    // Only the edge that has a step is reported.
    assert_eq!(report.worst, [1]);
    close(report.edges[1].mean.unwrap(), wanted);
}

#[test]
fn worst_edges_keep_a_distance() {
    // Ten seams in a row; steps grow to the right, but the last edges are close together.
    let x = |k: u32| if k < 9 { k as f32 } else { 8.0 + (k - 8) as f32 * 0.01 };
    let mut positions = Vec::new();
    let mut uv = Vec::new();
    let mut faces = Vec::new();
    for k in 0..11u32 {
        let (left, right) = (x(k), x(k + 1));
        let u = 0.05 + 0.08 * k as f32;
        positions.extend([
            [left, 0.0, 0.0],
            [right, 0.0, 0.0],
            [right, 1.0, 0.0],
            [left, 1.0, 0.0],
        ]);
        uv.extend([[u, 0.1], [u + 0.04, 0.1], [u + 0.04, 0.2], [u, 0.2]]);
        faces.extend([[4 * k, 4 * k + 1, 4 * k + 2], [4 * k, 4 * k + 2, 4 * k + 3]]);
    }
    let mesh = Mesh::from_triangles(positions, uv, &faces, &faces).unwrap();
    let texture = painted(|x, _| [(x / 100.0).powi(2), 0.0, 0.0]);
    let options = SeamOptions { worst: 3, ..SeamOptions::default() };
    let report = measure(&mesh, &texture, &[true; 22], &options).unwrap();
    assert_eq!((report.uv_seams.edges, report.worst.len()), (10, 3));
    let steps: Vec<f64> = report.worst.iter().map(|&k| report.edges[k].mean.unwrap()).collect();
    assert!(steps.is_sorted_by(|a, b| a >= b));
    // The colour is constant along each seam.
    close(steps[0], report.uv_seams.delta_e.unwrap().max);
    // Edges at the region boundary are counted separately and do not displace these.
    let mut inside = vec![true; 22];
    inside[20..].fill(false);
    let with_rim = measure(&mesh, &texture, &inside, &options).unwrap();
    assert_eq!(with_rim.worst.len(), 4);
    assert_eq!(with_rim.worst.iter().filter(|&&k| with_rim.edges[k].is_rim).count(), 1);
    let places: Vec<f32> = report.worst.iter().map(|&k| report.edges[k].ends[0][0]).collect();
    for (index, place) in places.iter().enumerate() {
        assert!(places[..index].iter().all(|other| (other - place).abs() > 0.1), "{places:?}");
    }
}

#[test]
fn what_cannot_be_measured_is_counted() {
    let mesh = squares([1.0; 2], APART);
    let options = SeamOptions::default();
    // Transparent on the right.
    let texels = (0..10_000).flat_map(|k| [9, 9, 9, if k % 100 < 50 { 255 } else { 0 }]).collect();
    let clear = Texture::new(Size::square(100), Channels::Rgba, Encoding::Srgb, Texels::U8(texels))
        .unwrap();
    let report = measure(&mesh, &clear, &[true; 4], &options).unwrap();
    assert_eq!((report.notes.clear, report.uv_seams.points), (40, 0));
    assert_eq!((report.uv_seams.delta_e, report.edges[0].worst), (None, None));
    assert!(report.worst.is_empty());
    assert_eq!(report.uv_seams.length, 1.0);
    // NaN in the rows that the lower half of the right edge samples; whether the point at the
    // centre of the last row above them samples the next one depends on rounding.
    let nan = painted(|_, y| if y < 60.0 { RED } else { [f32::NAN; 3] });
    let report = measure(&mesh, &nan, &[true; 4], &options).unwrap();
    assert!((20..=21).contains(&report.notes.not_finite));
    assert_eq!(report.notes.not_finite + report.uv_seams.points, 40);
    // Degenerate to a line in the texture.
    let line = squares([1.0; 2], [APART[0], [0.6, 0.4, 0.6, 0.8]]);
    let report = measure(&line, &halves(), &[true; 4], &options).unwrap();
    assert_eq!((report.notes.no_area, report.uv_seams.points), (40, 0));
    // On the surface it has an area, in which all colours are those of the line.
    let report = measured(&line, &halves(), [true; 4], Offset::Distance(0.1));
    assert_eq!((report.notes.no_area, report.uv_seams.points), (0, 40));
    // Narrower than the offset: 2 of 5 texels, up to the far side.
    let narrow = squares([1.0; 2], [APART[0], [0.6, 0.4, 0.62, 0.8]]);
    let report = measured(&narrow, &halves(), [true; 4], Offset::Texels(5.0));
    assert_eq!(report.notes.shortened, 40);
    close(report.edges[0].worst.unwrap().sampled[1][0], 0.62);
    // Outside the texture, whose right edge is blue.
    let beside = squares([1.0; 2], [APART[0], [3.6, 0.4, 3.9, 0.8]]);
    let report = measure(&beside, &halves(), &[true; 4], &options).unwrap();
    assert_eq!((report.notes.outside, report.uv_seams.points), (40, 40));
    close(report.uv_seams.delta_e.unwrap().max, delta_e(RED, BLUE));
}

#[test]
fn bad_arguments_are_rejected() {
    let mesh = squares([1.0; 2], APART);
    let options = |offset| SeamOptions { offset, worst: 1 };
    let data = halves().with_encoding(Encoding::Data);
    let one = options(Offset::Texels(1.0));
    assert_eq!(measure(&mesh, &data, &[true; 4], &one), Err(SeamError::NotColor));
    assert_eq!(
        measure(&mesh, &halves(), &[true; 3], &one),
        Err(SeamError::Region { found: 3, wanted: 4 })
    );
    for offset in [f64::NAN, f64::INFINITY, -1.0] {
        for offset in [Offset::Texels(offset), Offset::Distance(offset)] {
            let refused = measure(&mesh, &halves(), &[true; 4], &options(offset));
            assert!(matches!(refused, Err(SeamError::Offset(_))), "{offset:?}");
        }
    }
}

/// Random triangles over few vertices, with extreme coordinates: every possible mesh defect.
fn rubble(seed: u64) -> (Mesh, Vec<bool>) {
    let mut random = fastrand::Rng::with_seed(seed);
    let wild = [0.0, -0.0, 1.0, 1e-30, 3e38, -3e38, 1e-45];
    let mut number = || match random.u32(0..8) {
        0 => wild[random.usize(0..wild.len())],
        _ => random.f32(),
    };
    let positions = (0..12).map(|_| [number(), number(), number()]).collect();
    let uv = (0..12).map(|_| [number(), number()]).collect();
    let mut faces = || -> Vec<[u32; 3]> {
        (0..60).map(|_| [random.u32(0..12), random.u32(0..12), random.u32(0..12)]).collect()
    };
    let (faces, uv_faces) = (faces(), faces());
    let inside = (0..60).map(|_| random.bool()).collect();
    (Mesh::from_triangles(positions, uv, &faces, &uv_faces).unwrap(), inside)
}

#[test]
fn malformed_meshes_cause_no_panic_and_no_nan() {
    let texture = halves();
    for seed in 0..30 {
        let (mesh, inside) = rubble(seed);
        let unfolded = Unfolded::new(&mesh);
        for offset in [0.0, 1.0, 1e9].map(|it| [Offset::Texels(it), Offset::Distance(it)]).concat()
        {
            let report = measured_with(&mesh, &texture, &inside, offset);
            for group in [report.uv_seams, report.rim, report.ordinary] {
                let finite = |steps: StepStatistics| steps.mean.is_finite() && steps.max <= 120.0;
                assert!(group.delta_e.is_none_or(finite), "{seed}: {group:?}");
            }
            for edge in &report.edges {
                let uv = unfolded.uv(edge, 0.3, 0.1, -0.2);
                assert!(uv.is_none_or(|uv| uv.iter().all(|value| !value.is_nan())));
            }
        }
    }
}

fn measured_with(mesh: &Mesh, texture: &Texture, inside: &[bool], offset: Offset) -> SeamReport {
    measure(mesh, texture, inside, &SeamOptions { offset, worst: 5 }).unwrap()
}

/// Enough edges for many chunks; along ordinary edges, fewer points than texels.
#[test]
fn threads_do_not_show() {
    let mut random = fastrand::Rng::with_seed(3);
    let side = 60u32;
    let positions: Vec<[f32; 3]> =
        (0..side * side).map(|k| [(k % side) as f32, (k / side) as f32, random.f32()]).collect();
    let uv: Vec<[f32; 2]> =
        (0..2).flat_map(|_| positions.iter().map(|&[x, y, _]| [x / 60.0, y / 60.0])).collect();
    let quads = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| y * side + x));
    let faces: Vec<[u32; 3]> =
        quads.flat_map(|k| [[k, k + 1, k + side], [k + 1, k + side + 1, k + side]]).collect();
    let mut uv_faces = faces.clone();
    for face in &mut uv_faces {
        if random.bool() {
            *face = face.map(|index| index + side * side);
        }
    }
    let mut uv = uv;
    uv[(side * side) as usize..].iter_mut().for_each(|uv| uv[0] += 0.001);
    let mesh = Mesh::from_triangles(positions, uv, &faces, &uv_faces).unwrap();
    let inside: Vec<bool> = (0..faces.len()).map(|_| random.bool()).collect();
    let texels = (0..1 << 20).flat_map(|_| [random.u8(..), random.u8(..), random.u8(..)]).collect();
    let texture =
        Texture::new(Size::square(1024), Channels::Rgb, Encoding::Srgb, Texels::U8(texels))
            .unwrap();
    assert_eq!(texture.depth(), Depth::U8);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| measured_with(&mesh, &texture, &inside, Offset::Texels(1.0)))
    };
    let one = run(1);
    assert!(one.edges.len() > 10 * CHUNK && (1000..MAX_CONTROLS).contains(&one.ordinary.points));
    assert_eq!(one, run(2));
    assert_eq!(one, run(5));
}

#[test]
fn surroundings_are_unfolded() {
    let mesh = squares([1.0, 3.0], APART);
    let report = measured(&mesh, &halves(), [true, true, false, false], Offset::Texels(1.0));
    let unfolded = Unfolded::new(&mesh);
    let at = |across: f64, forward: f64| unfolded.uv(&report.edges[0], 0.5, across, forward);
    let close = |found: Option<[f64; 2]>, wanted: [f64; 2]| {
        close_uv([found.unwrap(); 2], [wanted; 2]);
    };
    close(at(-0.5, 0.0), [0.25, 0.2]);
    close(at(-0.5, 0.25), [0.25, 0.25]);
    close(at(1.5, 0.0), [0.75, 0.6]);
    close(at(1.5, -0.25), [0.75, 0.5]);
    close(at(0.0, 0.0), [0.4, 0.2]);
    assert_eq!(at(-0.5, 0.6), None);
    assert_eq!(at(3.5, 0.0), None);
}
