//! Known layouts and reports on meshes, through the program.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use crate::bench::{self, Bench};
use serde_json::Value;
use uvgraft::{Mesh, Size};
use uvgraft_figure::Figure;
use uvgraft_io::arrays::{NamedArrays, NumericArray, save_npz};
use uvgraft_io::obj;
use uvgraft_tests::real;
use uvgraft_tests::strip::Strip;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// The value of a row in a report.
fn row<'a>(report: &'a str, name: &str) -> &'a str {
    let line = report.lines().find_map(|line| line.strip_prefix(name));
    line.unwrap_or_else(|| panic!("{name} in:\n{report}")).trim()
}

#[test]
fn the_known_layouts_are_listed() {
    let bench = Bench::new();
    let text = bench.succeed("layouts");
    for wanted in [
        "| FLAME ",
        "|   layout SMPL-X Blender add-on ",
        "20,908",
        "connectivity",
        "https://flame.is.tue.mpg.de",
        "licence  CC0",
    ] {
        assert!(text.contains(wanted), "{wanted} in:\n{text}");
    }
    let meshes = json(&bench.succeed("layouts --json"));
    let flame =
        meshes["meshes"].as_array().unwrap().iter().find(|mesh| mesh["name"] == "FLAME").unwrap();
    assert_eq!(flame["editions"][0]["vertices"], 5_023);
    assert_eq!(flame["editions"][0]["fingerprint"].as_str().unwrap().len(), 16);
    assert_eq!(flame["layouts"][1]["uv_coordinates"], 5_150);
    assert!(flame["source"].as_str().unwrap().starts_with("https://"));
}

#[test]
fn a_mesh_is_described() {
    let bench = Bench::new();
    let report = bench.succeed("inspect mesh target.obj --preview layout.png");
    for (name, wanted) in [
        ("mesh  ", "unknown"),
        ("layout  ", "unknown"),
        ("vertices", "29"),
        ("triangles", "34"),
        ("polygons", "17"),
        ("connected components", "2"),
        ("open edges", "20, along 2 boundaries"),
        ("non-manifold edges", "0"),
        ("UV islands", "2"),
        ("UV tiles", "1001 (34 triangles)"),
        ("outside unit square", "0 triangles"),
        ("texels overlapping", "0 at 1024×1024"),
        ("shows", "no head was found"),
    ] {
        assert_eq!(row(&report, name), wanted, "{name}");
    }
    assert!(report.lines().all(|line| line.chars().count() <= 100), "{report}");
    let Size { width, height } = bench.texture("layout.png").size();
    assert!((1000..1200).contains(&width) && (1000..1300).contains(&height), "{width}×{height}");

    let report = json(&bench.succeed("inspect mesh target.obj --json"));
    assert_eq!((&report["triangles"], &report["islands"]), (&34.into(), &2.into()));
    assert_eq!(report["recognition"]["mesh"], Value::Null);
    let fingerprints = ["surface_fingerprint", "layout_fingerprint"];
    let digits = |name: &str| report["recognition"][name].as_str().unwrap().len();
    assert_eq!(fingerprints.map(digits), [16, 16]);
}

#[test]
fn what_a_mesh_shows_and_its_unit_are_guessed() {
    let figure = Figure::new();
    let bench = Bench::new();
    for (name, mesh, wanted) in
        [("head.obj", &figure.head, "a head"), ("body.obj", &figure.body, "a body")]
    {
        obj::save(mesh, bench.path(name)).unwrap();
        let report = bench.succeed(&format!("inspect mesh {name}"));
        assert_eq!(row(&report, "shows"), wanted);
        assert!(row(&report, "size").ends_with("unit probably m"), "{report}");
    }
}

/// Two triangles, the second in tile 1003.
fn in_two_tiles() -> Mesh {
    let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let uv = vec![[0.1, 0.1], [0.9, 0.1], [0.1, 0.9], [2.1, 0.1], [2.9, 0.1], [2.1, 0.9]];
    Mesh::from_triangles(positions, uv, &[[0, 1, 2], [1, 3, 2]], &[[0, 1, 2], [3, 4, 5]]).unwrap()
}

#[test]
fn each_uv_tile_has_its_panel() {
    let bench = Bench::new();
    obj::save(&in_two_tiles(), bench.path("tiles.obj")).unwrap();
    let report = bench.succeed("inspect mesh tiles.obj --preview tiles.png");
    assert_eq!(row(&report, "UV tiles"), "1001 (1 triangle), 1003 (1 triangle)");
    assert_eq!(row(&report, "outside unit square"), "1 triangle");
    let picture = bench.texture("tiles.png");
    let Size { width, height } = picture.size();
    assert!((2000..2200).contains(&width), "{width}×{height}");
    // Both triangles are drawn in the upper left of their panels.
    let bright = |x: u32| {
        let texel = bench::texel_u8(&picture, x, height / 3);
        texel.iter().copied().max().unwrap()
    };
    let background = bright(width / 2 - 40);
    for x in [width / 8, width * 5 / 8] {
        assert!(bright(x) > background + 40, "{x}: {} and {background}", bright(x));
    }
}

#[test]
fn a_pair_with_islands_in_other_tiles_is_warned_of() {
    let bench = Bench::new();
    bench.save_pair("tiles.uvpair", in_two_tiles(), in_two_tiles(), &[0, 1, 2, 3]);
    let run = bench.run("inspect tiles.uvpair");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!(run.stderr.matches("1 triangle lies in other UV tiles (1003)").count(), 2);
    assert_eq!(bench.run("inspect my.uvpair").stderr, "");
}

#[test]
fn avatars_are_described() {
    let bench = Bench::new();
    let strip = Strip::new();
    bench.write("strip.glb", strip.glb());
    bench.write("strip.bin", &strip.binary);
    let apart = strip.clone().with("/buffers/0/uri", "strip.bin".into());
    bench.write("strip.gltf", apart.json.to_string());
    for file in ["strip.glb", "strip.gltf"] {
        let report = bench.succeed(&format!("inspect {file}"));
        for (name, wanted) in [
            ("format", "glTF 2.0"),
            ("parts", "1; 6 vertices, 4 triangles"),
            ("  strip / cloth", "6 vertices, 4 triangles, UV set 0, skinned, 1 morph targets"),
            ("skeleton", "2 joints"),
            ("morph targets", "1: bulge"),
            ("clips", "1: bend (1.00 s)"),
        ] {
            assert_eq!(row(&report, name), wanted, "{file}: {report}");
        }
        assert!(report.contains("bytes; baseColorTexture of cloth"), "{report}");
        let document = json(&bench.succeed(&format!("inspect {file} --json")));
        assert_eq!(document["images"][0]["size"], serde_json::json!([2, 2]));
        assert_eq!(document["clips"][0]["seconds"], 1.0);
        assert_eq!(document["parts"][0]["uv_sets"], serde_json::json!([0]));
    }
    let vrm = serde_json::json!({
        "specVersion": "1.0",
        "humanoid": { "humanBones": { "hips": { "node": 0 }, "head": { "node": 1 } } },
        "expressions": { "preset": { "aa": {} } },
        "meta": { "thumbnailImage": 0 },
    });
    let vrm = strip.with("/extensions", serde_json::json!({ "VRMC_vrm": vrm }));
    bench.write("me.vrm", vrm.glb());
    let report = bench.succeed("inspect me.vrm");
    assert_eq!(row(&report, "format"), "VRM 1.0");
    assert_eq!(row(&report, "humanoid bones"), "2: head, hips");
    assert_eq!(row(&report, "expressions"), "1: aa");
    assert!(report.contains("baseColorTexture of cloth, thumbnailImage"), "{report}");
    bench.refuse("inspect me.vrm --preview out.png", &["me.vrm", "--preview is for pair files"]);
    bench.write("cut.glb", &vrm.glb()[..200]);
    bench.refuse("inspect cut.glb", &["cut.glb: truncated"]);
}

#[test]
fn bad_input_is_refused() {
    let bench = Bench::new();
    bench.refuse("inspect mesh ids.npy", &["ids.npy: "]);
    bench.refuse("inspect mesh none.obj", &["none.obj"]);
    bench.refuse("inspect mesh target.obj --preview layout.txt", &["layout.txt", "image"]);
    bench.refuse("inspect target.obj", &["target.obj", "not a pair file", "`inspect mesh`"]);
    bench.refuse("inspect", &["<PAIR>"]);
    bench.refuse("inspect mesh", &["<MESH>"]);
}

#[test]
fn every_format_that_pairs_take_is_described() {
    let bench = Bench::new();
    let strip = Strip::new();
    bench.write("strip.glb", strip.glb());
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
               property float z\nproperty float s\nproperty float t\nelement face 1\n\
               property list uchar int vertex_indices\nend_header\n\
               0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n";
    bench.write("one.ply", ply);
    let [ints, floats] = [
        NumericArray::new_i64(vec![1, 3], vec![0, 1, 2]).unwrap(),
        NumericArray::new_f32(vec![3, 2], vec![0.0, 0.0, 1.0, 0.0, 0.0, 1.0]).unwrap(),
    ];
    let mut model = NamedArrays::new();
    let positions = vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    model.insert("v_template", NumericArray::new_f32(vec![3, 3], positions).unwrap());
    model.insert("f", ints.clone());
    model.insert("vt", floats);
    model.insert("ft", ints);
    save_npz(&model, bench.path("MODEL.npz")).unwrap();
    bench.write(
        "parts.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\no left\n\
                              f 1/1 2/2 3/3\no right\nf 1/1 2/2 3/3\n",
    );
    for (file, triangles) in [
        ("strip.glb", "4"),
        ("strip.glb#0", "4"),
        ("strip.glb#strip/0", "4"),
        ("one.ply", "1"),
        ("MODEL.npz", "1"),
        ("parts.obj", "2"),
        ("parts.obj#right", "1"),
    ] {
        let report = bench.succeed(&format!("inspect mesh {file} --preview layout.png"));
        assert_eq!(row(&report, "triangles"), triangles, "{file}");
        assert!(bench.bytes("layout.png").starts_with(b"\x89PNG"));
    }
    bench.refuse("inspect mesh strip.glb#3", &["strip.glb", "TEXCOORD_3"]);
    bench.refuse("inspect mesh parts.obj#top", &["no object, group or material is named"]);
    bench.write("mesh.png", strip.glb());
    bench.refuse("inspect mesh mesh.png#0 --preview mesh.png", &["mesh.png", "is also an input"]);
}

#[test]
fn pairs_that_look_wrong_are_warned_of_once() {
    let bench = Bench::new();
    obj::save(&in_two_tiles(), bench.path("tiles.obj")).unwrap();
    let run = bench.run("pair tiles.obj tiles.obj --by faces -o new.uvpair");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    // One warning a side, although two checks see the triangle.
    assert_eq!(run.stderr.matches("warning").count(), 2, "{}", run.stderr);
    assert_eq!(run.stderr.matches("outside the unit square").count(), 2, "{}", run.stderr);
    let Some(folder) = real::folder() else { return };
    for file in ["flame_head_template.obj", "flame_hifi3d_uv.obj"] {
        std::fs::copy(folder.join(file), bench.path(file)).unwrap();
    }
    let run = bench.run("pair flame_head_template.obj flame_hifi3d_uv.obj -o new.uvpair");
    assert!(run.stderr.contains("FLAME with the layout HiFi3D++"), "{}", run.stderr);
    assert_eq!(run.stderr.matches("2,176 triangles").count(), 1, "{}", run.stderr);
}

#[test]
fn real_meshes_have_names() {
    let Some(folder) = real::folder() else { return };
    let bench = Bench::new();
    for (file, mesh, layout) in [
        ("flame_head_template.obj", "FLAME", "FLAME"),
        ("flame_hifi3d_uv.obj", "FLAME", "HiFi3D++"),
        ("hifi3d_head.obj", "HiFi3D++", "HiFi3D++"),
        ("smplx_addon.obj", "SMPL-X", "SMPL-X Blender add-on"),
    ] {
        std::fs::copy(folder.join(file), bench.path(file)).unwrap();
        let report = bench.succeed(&format!("inspect mesh {file}"));
        assert_eq!(row(&report, "mesh  "), format!("{mesh} (same connectivity)"));
        assert_eq!(row(&report, "layout  "), format!("{layout} (same connectivity)"));
    }
    let ids = folder.join("smplx_flame_vertex_ids.npy");
    std::fs::copy(ids, bench.path("flame_ids.npy")).unwrap();
    bench.succeed(
        "pair flame_head_template.obj smplx_addon.obj --vertex-map flame_ids.npy -o f.uvpair",
    );
    let report = bench.succeed("inspect f.uvpair");
    assert_eq!(
        row(&report, "known layout").split_whitespace().collect::<Vec<_>>().join(" "),
        "FLAME SMPL-X Blender add-on"
    );
}
