//! Body models as published. They may not be redistributed, so an environment variable names their
//! folder; without it there is nothing to test.

use std::path::PathBuf;

use uvgraft_io::{obj, vertex_map};

/// A file in the folder that `UVGRAFT_DATA` names.
fn real_file(name: &str) -> Option<PathBuf> {
    std::env::var_os("UVGRAFT_DATA").map(|folder| PathBuf::from(folder).join(name))
}

macro_rules! real_file_or_skip {
    ($name:literal) => {
        match real_file($name) {
            Some(path) => path,
            None => {
                eprintln!("skipped: UVGRAFT_DATA is not set");
                return;
            }
        }
    };
}

#[test]
fn flame_has_the_size_it_is_known_for() {
    let mesh = obj::read(&real_file_or_skip!("flame_head_template.obj")).unwrap();
    assert_eq!((mesh.positions().len(), mesh.uv().len()), (5_023, 5_118));
    assert_eq!((mesh.faces().len(), mesh.polygon_count()), (9_976, 9_976));
    let [part] = mesh.parts() else { panic!("{:?}", mesh.parts()) };
    assert!(!part.material.is_empty());
    assert_eq!(part.polygons, 0..9_976);
    assert!(mesh.uv().iter().flatten().all(|value| (0.0..=1.0).contains(value)));
}

#[test]
fn smplx_has_the_size_it_is_known_for() {
    let mesh = obj::read(&real_file_or_skip!("smplx_addon.obj")).unwrap();
    assert_eq!((mesh.positions().len(), mesh.uv().len()), (10_475, 11_437));
    assert_eq!((mesh.faces().len(), mesh.polygon_count()), (20_908, 20_908));
    let [part] = mesh.parts() else { panic!("{:?}", mesh.parts()) };
    assert!(!part.object.is_empty() && !part.material.is_empty());
}

#[test]
fn real_meshes_survive_the_round_trip_with_the_digits_they_came_with() {
    let path = real_file_or_skip!("smplx_addon.obj");
    let mesh = obj::read(&path).unwrap();
    let mut text = Vec::new();
    obj::write(&mesh, &mut text).unwrap();
    assert_eq!(obj::parse(&text).unwrap(), mesh);

    let numbers = |text: &[u8]| -> Vec<f64> {
        let text = String::from_utf8(text.to_vec()).unwrap();
        let lines = text.lines().filter_map(|line| line.strip_prefix("vt "));
        lines.flat_map(str::split_whitespace).map(|number| number.parse().unwrap()).collect()
    };
    assert_eq!(numbers(&text), numbers(&std::fs::read(&path).unwrap()));
}

#[test]
fn a_vertex_map_names_vertices_of_both_and_is_written_back_byte_for_byte() {
    let path = real_file_or_skip!("smplx_flame_vertex_ids.npy");
    let ids = vertex_map::read(&path).unwrap();
    assert_eq!(ids.len(), 5_023);
    assert!(ids.iter().all(|id| (0..10_475).contains(id)));

    let ids: Vec<u32> = ids.iter().map(|&id| id as u32).collect();
    let mut bytes = Vec::new();
    vertex_map::write_npy(&ids, &mut bytes).unwrap();
    assert!(bytes == std::fs::read(&path).unwrap(), "differs from what NumPy wrote");
}
