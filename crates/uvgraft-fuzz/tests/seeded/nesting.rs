//! Values nested deeply, and long strings: readers refuse or read them on the stack of a thread, which
//! has 2 MiB.

use std::thread;

use serde_json::json;
use uvgraft_files::input::Input;
use uvgraft_gltf::container::Glb;
use uvgraft_gltf::scene::{MeshChoice, PoseRequest, Scene, contents, read_mesh, whole};
use uvgraft_io::{
    arrays, correspondence_table, pair_file, pickle, vertex_groups, vertex_list, vertex_map,
};
use uvgraft_tests::strip::Strip;

use super::alone;

const DEPTH: usize = 100_000;

/// More than any name, in bytes.
const LONG: usize = 30 << 20;

/// Lists in lists, or objects in objects.
fn nested(open: &str, close: &str) -> String {
    open.repeat(DEPTH) + "1" + &close.repeat(DEPTH)
}

fn glb(json: &str) -> Vec<u8> {
    Glb::write(json.as_bytes(), &[]).expect("below 4 GiB")
}

/// Reads a file in every way, on a thread with the stack of those that tests and Rayon use.
///
/// Returns whether it is a scene.
fn is_scene(bytes: &[u8]) -> bool {
    let small = thread::Builder::new().stack_size(2 << 20);
    thread::scope(|scope| {
        let read = || {
            let _ = contents(Input::bytes("nested.glb", bytes));
            let _ = read_mesh(bytes, &MeshChoice::default());
            let _ = whole(Input::bytes("nested.glb", bytes));
            Scene::read(bytes).is_ok_and(|scene| scene.pose(&PoseRequest::default()).is_ok())
        };
        let reader = small.spawn_scoped(scope, read).expect("a thread");
        reader.join().expect("files are read or refused")
    })
}

/// Unknown values are skipped without recursion, so that files with them may be read.
#[test]
fn nested_json_of_scenes_is_refused_or_skipped() {
    let _alone = alone();
    for (open, close) in [("[", "]"), ("{\"a\":", "}")] {
        let value = nested(open, close);
        assert!(!is_scene(&glb(&value)) && !is_scene(value.as_bytes()));
        for (start, end) in [
            (r#""extras":"#, ""),
            (r#""nodes":[{"extensions":"#, "}]"),
            (r#""meshes":[{"primitives":[],"extras":"#, "}]"),
            (r#""meshes":[{"primitives":[{"attributes":"#, "}]}]"),
            (r#""extensions":{"VRM":"#, "}"),
            (r#""extensions":{"VRMC_vrm":{"expressions":"#, "}}"),
        ] {
            let text = format!(r#"{{"asset":{{"version":"2.0"}},{start}{value}{end}}}"#);
            assert_eq!(is_scene(text.as_bytes()), is_scene(&glb(&text)), "{start}");
        }
        let known = format!(r#"{{"asset":{value}}}"#);
        assert!(!is_scene(&glb(&known)));
    }
}

#[test]
fn nested_json_of_other_files_is_refused() {
    let _alone = alone();
    for (open, close) in [("[", "]"), ("{\"a\":", "}")] {
        let value = nested(open, close);
        let inner = format!("{{\"face\":{value}}}");
        for bytes in [value.as_bytes(), inner.as_bytes()] {
            assert!(vertex_groups::parse(bytes).is_err());
            assert!(vertex_list::parse(bytes, 40).is_err());
            assert!(vertex_map::parse(bytes).is_err());
            assert!(correspondence_table::parse(bytes).is_err());
        }
    }
}

/// The header of a pair file is JSON, with JSON in a string of it.
#[test]
fn nested_json_of_pair_files_is_refused() {
    let _alone = alone();
    let seed = (uvgraft_fuzz::target("pair_file").unwrap().seeds)().swap_remove(0);
    assert!(pair_file::decode(&seed).is_ok());
    let length = usize::try_from(u64::from_le_bytes(*seed.first_chunk().unwrap())).unwrap();
    let (header, tensors) = seed[8..].split_at(length);
    let header = std::str::from_utf8(header).unwrap();
    for (open, close) in [("[", "]"), ("{\\\"a\\\":", "}")] {
        let value = nested(open, close);
        let plain = value.replace('\\', "");
        let outer = header.replacen('{', &format!("{{\"nested\":{plain},"), 1);
        let inner = header.replacen("{\\\"", &format!("{{\\\"nested\\\":{value},\\\""), 1);
        assert!(outer.len() > DEPTH && inner.len() > DEPTH);
        for header in [outer, inner] {
            let bytes = [&header.len().to_le_bytes(), header.as_bytes(), tensors].concat();
            assert!(pair_file::decode(&bytes).is_err());
        }
    }
}

/// Pickles may nest as deeply as they have instructions.
#[test]
fn nested_pickles_are_no_arrays() {
    const INSTRUCTIONS: usize = pickle::MAX_INSTRUCTIONS;
    let _alone = alone();
    let lists = |depth: usize| {
        [&b"\x80\x02"[..], &b"]".repeat(depth), &b"a".repeat(depth - 1), b"."].concat()
    };
    let tuples = |depth: usize| [&b"\x80\x02N"[..], &b"\x85".repeat(depth), b"."].concat();
    let dicts = |depth: usize| {
        [&b"\x80\x02"[..], &b"}K\x01".repeat(depth), b"N", &b"s".repeat(depth), b"."].concat()
    };
    for (accepted, refused) in [
        (lists(INSTRUCTIONS / 2 - 2), lists(1 << 20)),
        (tuples(INSTRUCTIONS - 4), tuples(1 << 20)),
        (dicts(INSTRUCTIONS / 3 - 2), dicts(1 << 20)),
    ] {
        assert!(pickle::parse(&accepted).is_ok());
        assert!(pickle::parse(&refused).is_err());
        for bytes in [accepted, refused] {
            // A dict that is nested too deeply is left out.
            assert!(
                arrays::parse(&bytes).is_ok_and(|read| read.names().next().is_none())
                    || arrays::parse(&bytes).is_err()
            );
            assert!(vertex_groups::parse(&bytes).is_err());
            assert!(correspondence_table::parse(&bytes).is_err());
        }
    }
}

#[test]
fn nodes_may_be_nested_deeply() {
    let _alone = alone();
    let mut strip = Strip::new();
    let first = strip.json["nodes"].as_array().unwrap().len();
    let chain = (first..first + DEPTH).map(|at| json!({ "children": [at + 1] }));
    strip.json["nodes"].as_array_mut().unwrap().extend(chain.chain([json!({ "mesh": 0 })]));
    strip.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(first.into());
    assert!(is_scene(&strip.glb()));
    // Each of them shows the mesh, or the last one is the first one's parent.
    let mut ring = strip.clone();
    ring.json["nodes"][first + DEPTH]["children"] = json!([first]);
    assert!(!is_scene(&ring.glb()));
    for at in first..first + DEPTH {
        strip.json["nodes"][at]["mesh"] = 0.into();
    }
    is_scene(&strip.glb());
}

#[test]
fn long_strings_are_read_or_refused() {
    let _alone = alone();
    let long = "x".repeat(LONG);
    for (name, wanted) in [
        ("/nodes/0/name", true),
        ("/meshes/0/extras/targetNames/0", true),
        ("/asset/version", false),
    ] {
        let file = Strip::new().with(name, long.as_str().into());
        assert_eq!(is_scene(&file.glb()), wanted, "{name}");
    }
    let text = |code: u8, content: &str| {
        let length = (content.len() as u32).to_le_bytes();
        [&[code], &length[..], content.as_bytes()].concat()
    };
    for (key, value) in [("a", &long[..]), (&long, "a")] {
        let pickle = [b"\x80\x02}", &text(b'X', key)[..], &text(b'X', value), b"s."].concat();
        assert!(pickle::parse(&pickle).is_ok());
        assert_eq!(arrays::parse(&pickle).is_ok(), key.len() == 1, "names have a limit");
        assert!(vertex_groups::parse(&pickle).is_err());
    }
    let groups = json!({ long.as_str(): [1, 2] }).to_string();
    assert!(vertex_groups::parse(groups.as_bytes()).is_err(), "names have a limit");
}
