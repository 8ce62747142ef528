//! Correspondences written by NumPy and SciPy, by means of `table_samples/make.py`.

use std::path::{Path, PathBuf};

use uvgraft::correspond::table::{RowCounts, VertexTable};
use uvgraft_io::correspondence_table::{self, CorrespondenceFile, layout_mesh};

const MATRICES: [&str; 12] = [
    "scipy_1_2_csc.pkl",
    "scipy_1_2_coo.pkl",
    "scipy_1_5_csr.pkl",
    "scipy_1_5_coo.pkl",
    "scipy_1_5_csc.npz",
    "scipy_1_11_coo.pkl",
    "scipy_1_11_csc.pkl",
    "scipy_1_17_coo.pkl",
    "scipy_1_17_csr.pkl",
    "scipy_1_17_csr.npz",
    "scipy_1_17_coo.npz",
    "dense.pkl",
];

const LAYOUTS: [&str; 2] = ["numpy_1_16_texture_data.npy", "numpy_2_texture_data.npy"];

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/table_samples").join(name)
}

fn sample(name: &str) -> CorrespondenceFile {
    correspondence_table::read(path(name)).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn one_matrix_in_every_format() {
    for name in MATRICES {
        let CorrespondenceFile::Matrix(matrix) = sample(name) else { panic!("{name}") };
        assert_eq!((matrix.shape(), matrix.values().len()), ([3, 8], 9), "{name}");
        let (table, counts) = VertexTable::from_rows(matrix.rows(), matrix.shape()[1], 4).unwrap();
        let wanted = RowCounts { vertices: 1, edges: 1, faces: 1, ..RowCounts::default() };
        assert_eq!(counts, wanted, "{name}");
        let points: Vec<_> = table.points().iter().map(|point| point.unwrap()).collect();
        assert_eq!(points[0].vertex(), Some(1), "{name}");
        assert_eq!((points[1].vertices, points[1].weights), ([2, 0, 2], [0.75, 0.25, 0.0]));
        assert_eq!((points[2].vertices, points[2].weights), ([0, 1, 3], [0.5, 0.25, 0.25]));
    }
}

#[test]
fn a_layout_with_and_without_its_coordinates() {
    for name in LAYOUTS {
        let CorrespondenceFile::Layout(mut layout) = sample(name) else { panic!("{name}") };
        let made = layout_mesh(&layout).unwrap();
        assert!(made.is_exact && made.left_out == 0, "{name}");
        assert_eq!(made.mesh.faces(), [[7, 4, 5], [5, 4, 6]]);
        let corner = |face: usize, k: usize| made.mesh.uv_triangle(face)[k];
        assert_eq!(made.mesh.uv_faces(), [[0, 2, 1], [1, 2, 3]]);
        let near = |a: [f32; 2], b: [f32; 2]| (0..2).all(|k| (a[k] - b[k]).abs() < 1e-5);
        assert!(near(corner(0, 0), [0.1, 0.1]) && near(corner(1, 2), [0.9, 0.9]), "{name}");
        // The same from texels alone; faces are in the order of their vertices then.
        layout.uv = None;
        let found = layout_mesh(&layout).unwrap();
        assert!(!found.is_exact && found.left_out == 0);
        assert_eq!(found.mesh.faces(), [[5, 4, 6], [7, 4, 5]]);
        assert_eq!(found.mesh.uv().len(), 4);
        for k in 0..3 {
            assert!(near(found.mesh.uv_triangle(1)[k], corner(0, k)), "{name} {k}");
            assert!(near(found.mesh.uv_triangle(0)[k], corner(1, k)), "{name} {k}");
        }
    }
}

/// Everything that is done with a file.
fn use_all(bytes: &[u8]) -> bool {
    match correspondence_table::parse(bytes) {
        Ok(CorrespondenceFile::Matrix(matrix)) => {
            let _ = VertexTable::from_rows(matrix.rows(), matrix.shape()[1], 4);
            true
        }
        Ok(CorrespondenceFile::Layout(layout)) => {
            let _ = layout_mesh(&layout);
            true
        }
        found => found.is_ok(),
    }
}

#[test]
fn no_bytes_make_it_panic() {
    let mut random = fastrand::Rng::with_seed(5);
    for name in MATRICES.into_iter().chain(LAYOUTS) {
        let bytes = std::fs::read(path(name)).unwrap();
        for length in (0..bytes.len()).step_by(bytes.len() / 300 + 1) {
            assert!(!use_all(&bytes[..length]), "{name} cut to {length}");
        }
        let mut accepted = 0;
        for _ in 0..1500 {
            let mut bytes = bytes.clone();
            for _ in 0..random.usize(1..4) {
                let at = random.usize(0..bytes.len());
                let end = (at + random.usize(1..9)).min(bytes.len());
                match random.u32(0..5) {
                    0 => bytes[at] = random.u8(..),
                    1 => bytes[at..end].fill(0xff),
                    2 => bytes[at..end].fill(0),
                    3 => drop(bytes.drain(at..end)),
                    _ => bytes[at] ^= 1 << random.u32(0..8),
                }
            }
            accepted += usize::from(use_all(&bytes));
        }
        assert!(accepted < 1500, "{name}: {accepted}");
    }
}
