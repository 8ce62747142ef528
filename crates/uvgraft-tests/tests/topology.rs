//! Meshes linked by connectivity alone.

use uvgraft::correspond::{By, FindOptions, Method, find};
use uvgraft::{Extent, Pair, Piece};
use uvgraft_tests::real;
use uvgraft_tests::shuffled::Shuffled;

fn by(by: By) -> FindOptions {
    let mut options = FindOptions::default();
    options.by = by;
    options
}

/// The pieces of a pair of shuffled meshes of triangles, in terms of the original ones, sorted.
fn original(pair: &Pair, source: &Shuffled, target: &Shuffled) -> Vec<(u32, u32, [u8; 3])> {
    let mut pieces: Vec<(u32, u32, [u8; 3])> = pair
        .pieces()
        .map(|Piece { target: to, source: from, extent }| {
            let Extent::Whole(corners) = extent else { panic!("a part") };
            let (to, to_first) = target.polygons[to as usize];
            let (from, from_first) = source.polygons[from as usize];
            let mut back = [0; 3];
            for k in 0..3 {
                let corner = (usize::from(corners[k]) + from_first) % 3;
                back[(k + to_first) % 3] = corner as u8;
            }
            (to as u32, from as u32, back)
        })
        .collect();
    pieces.sort_unstable();
    pieces
}

fn links(pair: &Pair) -> Vec<(u32, u32, [u8; 3])> {
    let mut pieces: Vec<(u32, u32, [u8; 3])> = pair
        .pieces()
        .map(|piece| {
            let Extent::Whole(corners) = piece.extent else { panic!("a part") };
            (piece.target, piece.source, corners)
        })
        .collect();
    pieces.sort_unstable();
    pieces
}

#[test]
fn a_shuffled_head_is_found_in_a_shuffled_body() {
    let Some(pair) = real::flame_to_smplx() else { return };
    for seed in 0..6 {
        let source = Shuffled::new(pair.source(), seed);
        let target = Shuffled::new(pair.target(), seed + 100);
        let found = find(source.mesh.clone(), target.mesh.clone(), &by(By::Topology)).unwrap();
        assert_eq!(original(&found.pair, &source, &target), links(&pair));
        // The other way round.
        let found = find(target.mesh.clone(), source.mesh.clone(), &by(By::Any)).unwrap();
        assert_eq!(found.pair.piece_count(), pair.piece_count());
        assert!(matches!(found.method, Method::Topology(report) if !report.is_mirrored));
    }
}
