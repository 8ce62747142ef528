//! Meshes of hundreds of thousands of triangles give maps as correct as small ones.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use uvgraft::map::Patch;
use uvgraft::{Direction, Extent, MapOptions, SamplingMap, Size};
use uvgraft_tests::synthetic;

#[test]
fn every_texel_of_a_large_mesh_is_in_its_triangle() {
    let pair = synthetic::sheets(200_000);
    let (source, target) = (pair.source(), pair.target());
    assert!(target.faces().len() > 190_000);
    assert_eq!(pair.piece_count(), target.faces().len());
    let size = Size::new(811, 640);
    let scale = [f64::from(size.width), f64::from(size.height)];
    let map = SamplingMap::new(&pair, Direction::Forward, size, &MapOptions::with_gutter(3));
    let corners_px = |face: u32| {
        let corners = target.uv_triangle(face as usize);
        corners.map(|[u, v]| [f64::from(u) * scale[0], f64::from(v) * scale[1]])
    };

    // Pieces are in the order of target faces, and so are patches: one per piece, then the
    // gutter's.
    let owned: Vec<&Patch> = map.patches()[..pair.piece_count()].iter().collect();
    for (piece, patch) in pair.pieces().zip(&owned) {
        assert_eq!(patch.face, piece.target);
        let Extent::Whole(corners) = piece.extent else { panic!("whole triangles") };
        let wanted = source.uv_triangle(piece.source as usize);
        for (corner, k) in corners_px(piece.target).into_iter().zip(corners) {
            let found = patch.src_uv_from_tgt_px.at(corner);
            let wanted = wanted[k as usize].map(f64::from);
            assert!((found[0] - wanted[0]).hypot(found[1] - wanted[1]) < 1e-9);
        }
    }

    let (mut linked, mut gutter) = (0, 0);
    for row in 0..size.height {
        let runs = map.row(row);
        assert!(runs.windows(2).all(|pair| pair[0].x + pair[0].len <= pair[1].x));
        for run in runs {
            if map.is_gutter(*run) {
                gutter += run.len as usize;
                continue;
            }
            linked += run.len as usize;
            let [a, b, c] = corners_px(owned[run.patch as usize].face);
            for x in [run.x, run.x + run.len - 1] {
                let at = [f64::from(x) + 0.5, f64::from(row) + 0.5];
                let side = |p: [f64; 2], q: [f64; 2]| {
                    (q[0] - p[0]) * (at[1] - p[1]) - (q[1] - p[1]) * (at[0] - p[0])
                };
                let sides = [side(a, b), side(b, c), side(c, a)];
                let inside = |sign: f64| sides.iter().all(|side| side * sign > -1e-9);
                assert!(inside(1.0) || inside(-1.0), "texel ({x}, {row})");
            }
        }
    }
    assert_eq!((linked, gutter), (map.stats().linked, map.stats().gutter));
    assert_eq!(map.stats().overlapping, 0);
    assert_eq!(linked, map.stats().covered);
    // Six sheets cover 88 % by 88 % of their cells, plus a few texels around each.
    let share = linked as f64 / size.texels() as f64;
    assert!((share - 0.88 * 0.88).abs() < 0.01, "{share}");
    assert!(gutter > 10_000);
}
