//! Meshes of every format and their selectors, through the program.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use crate::bench::Bench;
use serde_json::{Value, json};
use uvgraft_io::arrays::{NamedArrays, NumericArray, save_npz};
use uvgraft_tests::strip::Strip;

/// The strip with a second UV set, in which it is half as large.
fn strip() -> Strip {
    let mut strip = Strip::new();
    let uv = [[0.0_f32, 0.5], [0.5, 0.5], [0.0, 0.25], [0.5, 0.25], [0.0, 0.0], [0.5, 0.0]];
    let bytes: Vec<u8> = uv.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
    let second = strip.add(&bytes, 5126, 6, "VEC2");
    strip.with("/meshes/0/primitives/0/attributes/TEXCOORD_1", second.into())
}

const IDENTITY: &str = "0 1 2 3 4 5\n";

/// The strip as PLY, whose UV coordinates have the origin at the bottom left.
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\n\
                   property float z\nproperty float s\nproperty float t\nelement face 2\n\
                   property list uchar int vertex_indices\nend_header\n\
                   -0.5 0 0 0 0\n0.5 0 0 1 0\n-0.5 1 0 0 0.5\n0.5 1 0 1 0.5\n-0.5 2 0 0 1\n\
                   0.5 2 0 1 1\n4 0 1 3 2\n4 2 3 5 4\n";

/// The strip as a body model.
fn model(with_layout: bool) -> NamedArrays {
    let heights = [0.0, 0.0, 1.0, 1.0, 2.0, 2.0];
    let positions = (0..6).flat_map(|v| [v as f32 % 2.0 - 0.5, heights[v], 0.0]).collect();
    let uv = (0..6).flat_map(|v| [v as f32 % 2.0, heights[v] / 2.0]).collect();
    let faces = vec![0, 1, 3, 0, 3, 2, 2, 3, 5, 2, 5, 4];
    let mut arrays = NamedArrays::new();
    arrays.insert("v_template", NumericArray::new_f32(vec![6, 3], positions).unwrap());
    arrays.insert("f", NumericArray::new_i64(vec![4, 3], faces.clone()).unwrap());
    if with_layout {
        arrays.insert("vt", NumericArray::new_f32(vec![6, 2], uv).unwrap());
        arrays.insert("ft", NumericArray::new_i64(vec![4, 3], faces).unwrap());
    }
    arrays
}

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("mesh.glb", strip().glb());
    bench.write("identity.txt", IDENTITY);
    bench
}

fn report(bench: &Bench, meshes: &str) -> Value {
    let text =
        bench.succeed(&format!("pair {meshes} --vertex-map identity.txt -o new.uvpair --json"));
    serde_json::from_str(&text).unwrap()
}

#[test]
fn two_uv_sets_of_one_file_are_a_pair() {
    let bench = bench();
    let report = report(&bench, "mesh.glb#0 mesh.glb#1");
    assert_eq!((&report["links"], &report["target"]["linked"]), (&json!(4), &json!(4)));
    assert_eq!(report["source_name"], "mesh.glb#0");
    assert_eq!(report["target_name"], "mesh.glb#1");
    assert_ne!(report["source_fingerprint"], report["target_fingerprint"]);
    assert!(!report["note"].as_str().unwrap().is_empty());
}

#[test]
fn every_format_has_the_same_layout() {
    let bench = bench();
    let strip = Strip::new();
    bench.write("strip.bin", &strip.binary);
    bench.write("apart.gltf", strip.with("/buffers/0/uri", "strip.bin".into()).json.to_string());
    bench.write("mesh.ply", PLY);
    save_npz(&model(true), bench.path("MODEL.npz")).unwrap();
    // Neither names nor extensions matter.
    bench.write("really#a.obj", strip_glb());
    let files = ["mesh.glb", "apart.gltf", "MODEL.npz", "really#a.obj", "mesh.glb#strip/0"];
    let prints = files.map(|file| {
        let report = report(&bench, &format!("{file} mesh.ply"));
        assert_eq!(report["links"], 4, "{file}");
        assert_eq!(report["source_name"], file);
        assert_eq!(report["target"]["polygons"], 2);
        report["source_fingerprint"].clone()
    });
    assert!(prints.iter().all(|print| *print == prints[0]), "{prints:?}");
}

fn strip_glb() -> Vec<u8> {
    strip().glb()
}

#[test]
fn what_does_not_exist_is_bad_input() {
    let bench = bench();
    save_npz(&model(false), bench.path("MODEL.npz")).unwrap();
    let glb = strip_glb();
    bench.write("cut.glb", &glb[..glb.len() / 2]);
    bench.write(
        "index.glb",
        strip().with_bytes(uvgraft_tests::strip::INDICES, 0, [9, 0, 9, 0]).glb(),
    );
    bench.write("cut.ply", &PLY[..PLY.len() - 20]);
    for (mesh, wanted) in [
        ("mesh.glb#hat", "must be one of strip, cloth"),
        (
            "mesh.glb#3",
            "mesh.glb: node \"strip\", mesh 0, primitive 0: must have the UV set 3 (TEXCOORD_3), but has TEXCOORD_0, \
             TEXCOORD_1; select another set (mesh.glb#0) or a node, mesh or material with that \
             set (mesh.glb#NAME)",
        ),
        ("cut.glb", "cut.glb: truncated"),
        ("index.glb", "index 0 must be less than 6, got 9"),
        ("cut.ply", "cut.ply: truncated"),
        ("MODEL.npz", "MODEL.npz: the model file has no UV layout (array `vt`); use an OBJ file"),
        ("MODEL.npz#body", "no UV layout"),
        ("source.obj#hat", "no object, group or material is named \"hat\""),
        ("ids.npy", "got a single NPY array"),
        ("identity.txt", "a mesh must be an OBJ, PLY, GLB or glTF file, or a body model"),
        ("none.glb#1", "none.glb#1: No such file"),
    ] {
        let run = bench.run(&format!("pair {mesh} target.obj --vertex-map ids.npy -o new.uvpair"));
        assert_eq!(run.code, Some(2), "{mesh}: {}", run.stderr);
        assert!(run.stderr.contains(wanted), "{mesh}: {}", run.stderr);
        assert!(!bench.exists("new.uvpair"));
    }
    // The output may not replace an input, with or without a selector.
    let run = bench.run("pair mesh.glb#0 mesh.glb#1 --vertex-map identity.txt -o mesh.glb");
    assert!(run.code == Some(2) && run.stderr.contains("is also an input"), "{}", run.stderr);
}
