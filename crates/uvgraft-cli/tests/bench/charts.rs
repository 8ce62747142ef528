//! Two charts that share texels, like two eyes.

use uvgraft::{Mesh, Pair};
use uvgraft_io::pair_file::{self, PairFile};

use super::Bench;

/// Two squares as `eyes.uvpair`, side by side in the source. In the target the second begins at
/// `left`; the first is on the person's right and ends at 0.5.
pub fn bench(left: f32) -> Bench {
    let squares = |lefts: [f32; 2]| {
        let (mut uv, mut positions) = (Vec::new(), Vec::new());
        for (left, x) in lefts.into_iter().zip([-1.0, 1.0]) {
            uv.extend([[left, 0.0], [left + 0.5, 0.0], [left + 0.5, 1.0], [left, 1.0]]);
            positions.extend([[x; 3]; 4]);
        }
        let faces = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        Mesh::from_triangles(positions, uv, &faces, &faces).unwrap()
    };
    let ids: Vec<i64> = (0..8).collect();
    let file = PairFile {
        pair: Pair::by_vertex_map(squares([0.0, 0.5]), squares([0.0, left]), &ids).unwrap().into(),
        source_name: "source.obj".to_owned(),
        target_name: "target.obj".to_owned(),
        note: String::new(),
    };
    let bench = Bench::new();
    pair_file::write(&file, bench.path("eyes.uvpair")).unwrap();
    bench
}
