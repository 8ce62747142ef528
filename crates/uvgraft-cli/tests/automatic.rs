//! Which way `pair` takes by itself, and what it says about the others.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use crate::bench::Bench;
use serde_json::Value;
use uvgraft::{Extent, Mesh, Piece};
use uvgraft_io::{obj, pair_file};
use uvgraft_tests::real;
use uvgraft_tests::shuffled::Shuffled;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// A bumpy sheet of 12 × 12 quads without some, of which the last rows lie in another UV tile.
fn head(shift: [f32; 3], scale: f32, rows_elsewhere: u32) -> Mesh {
    const SIDE: u32 = 12;
    let places = |k: u32| [k % (SIDE + 1), k / (SIDE + 1)].map(|at| at as f32 / SIDE as f32);
    let count = (SIDE + 1) * (SIDE + 1);
    let positions = (0..count).map(places).map(|[x, y]| {
        [x + shift[0], y + shift[1], 0.2 * (5.0 * x).sin() * (3.0 * y).cos() + shift[2]]
    });
    // The UV coordinates of all vertices twice, the second time two tiles to the right.
    let uv = |tile: f32| {
        (0..count).map(places).map(move |[x, y]| [0.05 + scale * x + tile, 0.05 + scale * y])
    };
    let quads = (0..SIDE * SIDE).filter(|quad| ![17, 40, 41, 77, 103].contains(quad));
    let (mut faces, mut uv_faces) = (Vec::new(), Vec::new());
    for quad in quads {
        let k = quad / SIDE * (SIDE + 1) + quad % SIDE;
        let is_elsewhere = quad / SIDE >= SIDE - rows_elsewhere;
        for face in [[k, k + 1, k + SIDE + 2], [k, k + SIDE + 2, k + SIDE + 1]] {
            faces.push(face);
            uv_faces.push(face.map(|at| if is_elsewhere { at + count } else { at }));
        }
    }
    let uv = uv(0.0).chain(uv(2.0)).collect();
    Mesh::from_triangles(positions.collect(), uv, &faces, &uv_faces).unwrap()
}

#[test]
fn one_mesh_with_two_layouts_is_linked_by_its_faces() {
    let bench = Bench::new();
    obj::save(&head([0.0; 3], 0.9, 0), bench.path("plain.obj")).unwrap();
    // Positions differ, and the last two rows are "eyes" in a tile of their own.
    let other = head([9.0, 0.5, -3.0], 0.5, 2);
    obj::save(&other, bench.path("eyes.obj")).unwrap();
    for meshes in ["plain.obj eyes.obj", "eyes.obj plain.obj"] {
        let report = json(&bench.make(&format!("pair {meshes} -o new.uvpair --json")));
        assert_eq!(report["linked_by"], serde_json::json!({ "faces": "vertices" }));
        assert_eq!(report["not_linked_by"], serde_json::json!([]));
        let pair = pair_file::read(bench.path("new.uvpair")).unwrap().pair;
        let inside =
            (0..other.faces().len() as u32).filter(|&face| !other.is_outside(face as usize));
        let wanted: Vec<Piece> = inside.map(|face| Piece::whole(face, face, [0, 1, 2])).collect();
        assert_eq!(pair.pieces().collect::<Vec<_>>(), wanted);
        assert_eq!(wanted.len(), other.faces().len() - 48);
    }
}

#[test]
fn the_report_says_why_earlier_ways_were_not_taken() {
    let bench = Bench::new();
    let mesh = head([0.0; 3], 0.9, 0);
    obj::save(&mesh, bench.path("plain.obj")).unwrap();
    let shuffled = Shuffled::new(&mesh, 3).mesh;
    obj::save(&shuffled, bench.path("shuffled.obj")).unwrap();
    let text = bench.succeed("pair plain.obj shuffled.obj -o new.uvpair");
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[0].starts_with("linked by connectivity: "), "{text}");
    assert!(
        lines[1].starts_with("  not by same faces: the meshes must have the same faces"),
        "{text}"
    );
    let report = json(&bench.succeed("pair plain.obj shuffled.obj -o new.uvpair --json"));
    assert!(report["linked_by"]["topology"]["matched"].as_u64() > Some(0));
    assert_eq!(report["not_linked_by"].as_array().map(Vec::len), Some(1));
}

#[test]
fn flame_with_another_layout_is_linked_by_its_faces() {
    let Some(folder) = real::folder() else { return };
    let bench = Bench::new();
    for file in ["flame_head_template.obj", "flame_hifi3d_uv.obj"] {
        std::fs::copy(folder.join(file), bench.path(file)).unwrap();
    }
    let meshes = "flame_hifi3d_uv.obj flame_head_template.obj";
    let report = json(&bench.make(&format!("pair {meshes} --by auto -o new.uvpair --json")));
    assert_eq!(report["linked_by"], serde_json::json!({ "faces": "vertices" }));
    // All but the eyeballs, which have a tile of their own.
    assert_eq!(report["links"], 9_976 - 2_176);
    let pair = pair_file::read(bench.path("new.uvpair")).unwrap().pair;
    for piece in pair.pieces() {
        let Extent::Whole(corners) = piece.extent else { panic!("a part") };
        for (k, &corner) in corners.iter().enumerate() {
            let target = pair.target().faces()[piece.target as usize][k];
            let source = pair.source().faces()[piece.source as usize][usize::from(corner)];
            assert_eq!(target, source);
        }
    }
}
