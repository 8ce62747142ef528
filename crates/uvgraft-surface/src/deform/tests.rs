use std::f32::consts::TAU;

use super::*;
use crate::piece::{Extent, Piece};

/// A dome over a square, divided into `side` × `side` squares.
fn dome(side: u32, turned: bool) -> Mesh {
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    for y in 0..=side {
        for x in 0..=side {
            let [x, y] = [x, y].map(|k| 2.0 * k as f32 / side as f32 - 1.0);
            positions.push([x, y, 0.6 * (1.0 - x * x) * (1.0 - y * y)]);
        }
    }
    for y in 0..side {
        for x in 0..side {
            let [a, b, c, d] =
                [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(dx, dy)| (y + dy) * (side + 1) + x + dx);
            faces.extend(if turned { [[a, b, d], [b, c, d]] } else { [[a, b, c], [a, c, d]] });
        }
    }
    let uv = positions.iter().map(|&[x, y, _]| [0.5 + 0.45 * x, 0.5 + 0.45 * y]).collect();
    Mesh::from_triangles(positions, uv, &faces, &faces).unwrap()
}

/// A bump that slides and swells, and fades out within the square.
fn bump(mesh: &Mesh) -> Vec<[f32; 3]> {
    let offset = |&[x, y, _]: &[f32; 3]| {
        let far = ((x * x + y * y).sqrt() / 0.7).min(1.0);
        let share = 0.5 + 0.5 * (far * TAU / 2.0).cos();
        [0.15 * share, 0.05 * share * x, 0.2 * share]
    };
    let mut offsets: Vec<_> = mesh.positions().iter().map(offset).collect();
    offsets.iter_mut().filter(|offset| offset[0] < 1e-6).for_each(|offset| *offset = [0.0; 3]);
    offsets
}

fn moves(offsets: &[[f32; 3]]) -> Vec<bool> {
    offsets.iter().map(|offset| *offset != [0.0; 3]).collect()
}

fn identity(mesh: &Mesh) -> Pair {
    let faces = 0..mesh.faces().len() as u32;
    let pieces = faces.map(|face| Piece::whole(face, face, [0, 1, 2]));
    Pair::from_pieces(mesh.clone(), mesh.clone(), pieces).unwrap()
}

fn largest(a: &[[f32; 3]], b: &[[f32; 3]]) -> f32 {
    let apart = |(a, b): (&[f32; 3], &[f32; 3])| Vec3::from(*a).distance(Vec3::from(*b));
    a.iter().zip(b).map(apart).fold(0.0, f32::max)
}

#[test]
fn a_mesh_takes_its_own_deformation_back() {
    let mesh = dome(24, false);
    let offsets = bump(&mesh);
    let transfer = DeformationTransfer::new(&identity(&mesh), &moves(&offsets)).unwrap();
    let found = transfer.transfer(&offsets).unwrap();
    assert!(largest(&found, &offsets) < 1e-6, "{}", largest(&found, &offsets));
    let still = offsets.iter().zip(&found).filter(|(offset, _)| **offset == [0.0; 3]);
    assert!(still.clone().count() > 100);
    assert!(still.clone().all(|(_, found)| *found == [0.0; 3]), "exactly zero");
    assert!((transfer.alignment().scale - 1.0).abs() < 1e-9);
    assert!(transfer.has_counterpart().iter().all(|has| *has));
}

#[test]
fn other_triangles_sizes_and_axes_move_alike() {
    let mesh = dome(24, false);
    let offsets = bump(&mesh);
    let found = crate::correspond::find(
        mesh.clone(),
        dome(31, true),
        &crate::correspond::FindOptions {
            by: crate::correspond::By::Surface,
            ..Default::default()
        },
    );
    let pair = found.unwrap().pair;
    // Twice as large, and Z up.
    let turned = |[x, y, z]: [f32; 3]| [2.0 * x, -2.0 * z, 2.0 * y];
    let placed = pair.target().positions().iter().map(|&at| turned(at)).collect();
    let target = pair.target().clone().with_positions(placed).unwrap();
    let pair = Pair::from_pieces(mesh, target, pair.pieces()).unwrap();
    let transfer = DeformationTransfer::new(&pair, &moves(&offsets)).unwrap();
    assert!((transfer.alignment().scale - 2.0).abs() < 0.01);
    let found = transfer.transfer(&offsets).unwrap();
    let wanted: Vec<_> = bump(&dome(31, true)).into_iter().map(turned).collect();
    // The bump is 0.5 high, and its flanks are a few edges wide.
    assert!(largest(&found, &wanted) < 0.02, "{}", largest(&found, &wanted));
}

#[test]
fn degenerate_and_unpaired_triangles_follow_their_neighbours() {
    let mesh = dome(20, false);
    let offsets = bump(&mesh);
    let mut positions = mesh.positions().to_vec();
    // Two vertices coincide near the middle, and some triangles have no counterpart.
    positions[221] = positions[220];
    let target = mesh.clone().with_positions(positions).unwrap();
    let faces = (0..mesh.faces().len() as u32).filter(|face| !(380..430).contains(face));
    let pieces = faces.map(|face| Piece::whole(face, face, [0, 1, 2]));
    let pair = Pair::from_pieces(mesh, target, pieces).unwrap();
    let transfer = DeformationTransfer::new(&pair, &moves(&offsets)).unwrap();
    let found = transfer.transfer(&offsets).unwrap();
    assert!(largest(&found, &offsets) < 0.06, "{}", largest(&found, &offsets));
}

#[test]
fn corrections_meet_their_conditions_and_stay_local() {
    let mesh = dome(40, false);
    let offsets = bump(&mesh);
    let transfer = DeformationTransfer::new(&identity(&mesh), &moves(&offsets)).unwrap();
    let middle = 20 * 41 + 20;
    let row = vec![(middle, [0.0, 0.0, 1.0]), (middle + 1, [0.0, 0.0, 1.0])];
    let found = transfer.correction(&transfer.handles(&[row]), &[Some(0.02)]);
    let [a, b] = [middle, middle + 1].map(|at| found[at as usize]);
    assert!((a[2] + b[2] - 0.02).abs() < 1e-5, "{a:?} {b:?}");
    assert!(a[0].abs() < 1e-6 && a[1].abs() < 1e-6);
    // Smooth around it, as far as the mesh can be within a few hundredths; gone at the edge.
    let beside = found[middle as usize + 41][2];
    assert!(beside > 0.3 * a[2], "{beside} {a:?}");
    let most = largest(&found, &vec![[0.0; 3]; found.len()]);
    assert!(most < 0.011, "{most}");
    let far = found[middle as usize + 41 * 12][2];
    assert!(far.abs() < 0.1 * a[2], "{far} {a:?}");
    // Conditions on what stays, or on no vertex, change nothing.
    let still = transfer.handles(&[vec![(0, [1.0; 3])], vec![(9999, [1.0; 3])], Vec::new()]);
    for changes in [&[Some(1.0); 3][..], &[None; 3], &[Some(0.0)], &[]] {
        let found = transfer.correction(&still, changes);
        assert!(found.iter().all(|offset| *offset == [0.0; 3]), "{changes:?}");
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let mesh = dome(6, false);
    let offsets = bump(&mesh);
    let pair = identity(&mesh);
    let error = DeformationTransfer::new(&pair, &[true; 3]).unwrap_err().to_string();
    assert_eq!(error, "movement must be given for each of the 49 source vertices, got 3");
    let nothing = DeformationTransfer::new(&pair, &[false; 49]).unwrap_err();
    assert_eq!(nothing, DeformError::Nothing);
    // What moves has no counterpart.
    let corner = Pair::from_pieces(mesh.clone(), mesh, [Piece::whole(0, 0, [0, 1, 2])]).unwrap();
    assert!(matches!(corner.pieces().next().unwrap().extent, Extent::Whole(_)));
    assert_eq!(
        DeformationTransfer::new(&corner, &moves(&offsets)).unwrap_err(),
        DeformError::Nothing
    );
    let transfer = DeformationTransfer::new(&pair, &moves(&offsets)).unwrap();
    assert!(matches!(transfer.transfer(&offsets[1..]), Err(DeformError::Count { found: 48, .. })));
    let mut broken = offsets;
    broken[7][1] = f32::NAN;
    let error = transfer.transfer(&broken).unwrap_err();
    assert!(matches!(error, DeformError::NotFinite { vertex: 7, .. }), "{error}");
}
