//! A flat sheet with a linked centre, so that distances on it are known.
//!
//! The target is 16×16 quads of 10 mm and fills its layout; the source is the 8×8 in the centre and
//! fills its own. With 64 texels a side in the source and 128 in the target, a texel is 1.25 mm on
//! both, and texel `(x, y)` of the source is texel `(x + 32, y + 32)` of the target.

use uvgraft::{Mesh, Pair};
use uvgraft_io::pair_file::{self, PairFile};

use super::Bench;

/// Vertices of the source, nine in a row.
pub const SOURCE_VERTICES: u32 = 81;
/// Vertices of the target, seventeen in a row.
pub const TARGET_VERTICES: u32 = 289;
/// Linked texels of the target, along either axis.
pub const LINKED: std::ops::Range<u32> = 32..96;

/// A bench with `plane.uvpair`.
pub fn bench() -> Bench {
    let bench = Bench::new();
    let ids: Vec<i64> =
        (0..SOURCE_VERTICES).map(|id| i64::from((id / 9 + 4) * 17 + id % 9 + 4)).collect();
    let file = PairFile {
        pair: Pair::by_vertex_map(sheet(8, 4), sheet(16, 0), &ids).unwrap().into(),
        source_name: "patch.obj".to_owned(),
        target_name: "sheet.obj".to_owned(),
        note: String::new(),
    };
    pair_file::write(&file, bench.path("plane.uvpair")).unwrap();
    bench
}

/// A square of `quads` a side, from row and column `first` of the sheet.
fn sheet(quads: u32, first: u32) -> Mesh {
    let side = quads + 1;
    let vertices = (0..side * side).map(|id| [id % side, id / side]);
    let meters = |k: u32| (first + k) as f32 * 0.01;
    let positions = vertices.clone().map(|[x, y]| [meters(x), -meters(y), 0.0]).collect();
    let uv = vertices.map(|at| at.map(|k| k as f32 / quads as f32)).collect();
    let faces: Vec<[u32; 3]> = (0..quads * quads)
        .flat_map(|quad| {
            let corner = quad / quads * side + quad % quads;
            let below = corner + side;
            [[corner, below, below + 1], [corner, below + 1, corner + 1]]
        })
        .collect();
    Mesh::from_triangles(positions, uv, &faces, &faces).unwrap()
}

/// The source's vertices in columns.
pub fn source_columns(columns: std::ops::RangeInclusive<u32>) -> Vec<u32> {
    (0..SOURCE_VERTICES).filter(|id| columns.contains(&(id % 9))).collect()
}

/// The target's vertices in columns.
pub fn target_columns(columns: std::ops::RangeInclusive<u32>) -> Vec<u32> {
    (0..TARGET_VERTICES).filter(|id| columns.contains(&(id % 17))).collect()
}
