//! Vertex maps of meshes whose vertices a tool has split, or to which it has added some.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its meshes has failed")]

use std::collections::{HashMap, HashSet};

use uvgraft::correspond::split_vertices::{MapUse, Numbering, link_by_vertex_map};
use uvgraft::{Mesh, Pair};
use uvgraft_figure::Figure;

/// The mesh with a vertex for each pair of a vertex and a coordinate, in this order, and the same
/// triangles.
fn split(mesh: &Mesh, ordered: impl Fn(&mut [(u32, u32)])) -> Mesh {
    let corners = || {
        mesh.faces()
            .as_flattened()
            .iter()
            .copied()
            .zip(mesh.uv_faces().as_flattened().iter().copied())
    };
    let mut pairs: Vec<(u32, u32)> = Vec::new();
    let mut known = HashSet::new();
    corners().filter(|pair| known.insert(*pair)).for_each(|pair| pairs.push(pair));
    ordered(&mut pairs);
    let number: HashMap<_, _> = pairs.iter().copied().zip(0_u32..).collect();
    let faces: Vec<u32> = corners().map(|pair| number[&pair]).collect();
    let faces = faces.as_chunks::<3>().0;
    let positions = pairs.iter().map(|&(vertex, _)| mesh.positions()[vertex as usize]).collect();
    let uv = pairs.iter().map(|&(_, uv)| mesh.uv()[uv as usize]).collect();
    Mesh::from_triangles(positions, uv, faces, faces).unwrap()
}

/// As Blender's and other exporters do: copies behind the vertices.
fn appended(pairs: &mut [(u32, u32)]) {
    pairs.sort_unstable();
    let mut last = None;
    let is_first: Vec<bool> =
        pairs.iter().map(|&(vertex, _)| last.replace(vertex) != Some(vertex)).collect();
    let of = |wanted: bool| pairs.iter().zip(&is_first).filter(move |(_, it)| **it == wanted);
    let ordered: Vec<(u32, u32)> = of(true).chain(of(false)).map(|(pair, _)| *pair).collect();
    pairs.copy_from_slice(&ordered);
}

/// As trimesh does: by coordinate.
fn by_coordinate(pairs: &mut [(u32, u32)]) {
    pairs.sort_unstable_by_key(|&(vertex, uv)| (uv, vertex));
    pairs.reverse();
}

/// The mesh with each vertex at a place of its own.
fn apart(mesh: &Mesh) -> Mesh {
    let moved = |(vertex, [x, y, z]): (usize, &[f32; 3])| [x + 1e-6 * vertex as f32, *y, *z];
    let positions = mesh.positions().iter().enumerate().map(moved).collect();
    Mesh::from_triangles(positions, mesh.uv().to_vec(), mesh.faces(), mesh.uv_faces()).unwrap()
}

fn figure() -> (Mesh, Mesh, Vec<i64>, usize) {
    let Figure { head, body, vertex_map, .. } = Figure::new();
    let ids: Vec<i64> = vertex_map.iter().map(|&id| i64::from(id)).collect();
    // With the same diagonals in both.
    let pair = Pair::by_vertex_map(head, body, &ids).unwrap();
    let [head, body] = [pair.source(), pair.target()].map(apart);
    let plain = link_by_vertex_map(&head, &body, &ids).unwrap();
    assert_eq!(
        (&plain.used, plain.used.assumed()),
        (&MapUse::Numbered([Numbering::Stored; 2]), None)
    );
    let by_map = Pair::by_vertex_map(head.clone(), body.clone(), &ids).unwrap();
    assert_eq!(plain.pair, by_map);
    (head, body, ids, plain.pair.pieces().len())
}

#[test]
fn split_vertices_are_those_that_the_map_counts() {
    let (head, body, ids, links) = figure();
    let sorted = |pairs: &mut [(u32, u32)]| pairs.sort_unstable();
    for (source, target, wanted) in [
        (split(&head, appended), body.clone(), "the first"),
        (split(&head, sorted), body.clone(), "different places of vertices of the source mesh"),
        (head.clone(), split(&body, appended), "of the target mesh"),
        (split(&head, sorted), split(&body, sorted), "source mesh and the"),
        (split(&head, by_coordinate), body.clone(), "linked by connectivity instead"),
        (head.clone(), split(&body, by_coordinate), "linked by connectivity instead"),
    ] {
        let found = link_by_vertex_map(&source, &target, &ids).unwrap();
        let assumed = found.used.assumed().unwrap();
        assert!(assumed.contains(wanted), "{wanted}: {assumed}");
        assert_eq!(found.pair.pieces().len(), links, "{assumed}");
    }
}

#[test]
fn appended_vertices_are_left_out() {
    let (head, body, ids, links) = figure();
    let mut positions = head.positions().to_vec();
    let first = positions.len() as u32;
    positions.extend([[0.0, 9.0, 0.0], [0.1, 9.0, 0.0], [0.0, 9.1, 0.0]]);
    let faces = [head.faces(), &[[first, first + 1, first + 2]]].concat();
    let uv_faces = [head.uv_faces(), &[[0, 1, 2]]].concat();
    let longer = Mesh::from_triangles(positions, head.uv().to_vec(), &faces, &uv_faces).unwrap();
    let found = link_by_vertex_map(&longer, &body, &ids).unwrap();
    assert_eq!(found.pair.pieces().len(), links);
    let wanted = format!(
        "taken for a map of the first {first} vertices (3 after them are left out) of the source mesh"
    );
    assert_eq!(found.used.assumed(), Some(wanted));
}

#[test]
fn a_split_source_may_have_another_number_of_vertices_than_the_map_and_the_target() {
    let head = apart(&Figure::new().head);
    let ids: Vec<i64> = (0..head.positions().len() as i64).collect();
    let links = Pair::by_vertex_map(head.clone(), head.clone(), &ids).unwrap().pieces().len();
    let found = link_by_vertex_map(&split(&head, appended), &head, &ids).unwrap();
    assert!(found.used.assumed().unwrap().contains("the first"));
    assert_eq!(found.pair.pieces().len(), links);
    let swapped = link_by_vertex_map(&split(&head, by_coordinate), &head, &ids[..]);
    assert!(swapped.unwrap_err().to_string().contains("swapped"));
}

#[test]
fn what_is_not_understood_is_refused_with_the_counts() {
    let (head, body, ids, _) = figure();
    let refused = |source: &Mesh, ids: &[i64]| {
        link_by_vertex_map(source, &body, ids).unwrap_err().to_string()
    };
    let vertices = head.positions().len();
    let short = refused(&head, &ids[..7]);
    let wanted = format!("one entry per vertex of the source mesh, {vertices}, got 7");
    assert!(short.ends_with(&wanted), "{short}");
    let longer = [&ids[..], &[0]].concat();
    assert!(refused(&head, &longer).contains(&format!("got {}", vertices + 1)));
    let apart = split(&head, by_coordinate);
    let (count, short) = (apart.positions().len(), refused(&apart, &ids[..7]));
    assert!(short.contains(&format!("{count} (at {vertices} different places), got 7")), "{short}");
    let far = vec![body.positions().len() as i64; vertices];
    assert!(refused(&head, &far).contains("are the indices 1-based?"));
}
