//! A method of finding correspondences that the library does not have, implemented in its own file.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod same_places;

use std::sync::Arc;

use uvgraft::{Direction, Filter, Graft, Mesh, Pair, Size, Sizes, Texture};
use uvgraft_figure::{Figure, paint_body, paint_head};

/// A mesh with its triangles in another order, each starting at a random corner.
fn shuffled(mesh: &Mesh, seed: u64) -> Mesh {
    let mut rng = fastrand::Rng::with_seed(seed);
    let mut faces: Vec<([u32; 3], [u32; 3])> =
        mesh.faces().iter().copied().zip(mesh.uv_faces().iter().copied()).collect();
    rng.shuffle(&mut faces);
    for (vertices, uv) in &mut faces {
        let first = rng.usize(..3);
        vertices.rotate_left(first);
        uv.rotate_left(first);
    }
    let (faces, uv_faces): (Vec<_>, Vec<_>) = faces.into_iter().unzip();
    Mesh::from_triangles(mesh.positions().to_vec(), mesh.uv().to_vec(), &faces, &uv_faces).unwrap()
}

#[test]
fn positions_link_as_well_as_a_vertex_map() {
    let figure = Figure::new();
    let vertex_map: Vec<i64> = figure.vertex_map.iter().map(|&vertex| vertex.into()).collect();
    // Polygons triangulated alike in both meshes, as by a vertex map.
    let pair = Pair::by_vertex_map(figure.head.clone(), figure.body.clone(), &vertex_map).unwrap();
    let [head, body] =
        [(pair.source(), 1), (pair.target(), 2)].map(|(mesh, seed)| shuffled(mesh, seed));

    let by_map = Pair::by_vertex_map(head.clone(), body.clone(), &vertex_map).unwrap();
    let by_place = same_places::pair(head, body).unwrap();
    assert_eq!(by_map.piece_count(), pair.piece_count());
    assert_eq!(by_place.piece_count(), pair.piece_count());

    let (by_map, by_place) = (Arc::new(by_map), Arc::new(by_place));
    let sizes = Sizes { from: Size::square(512), to: Size::square(1024) };
    let (face, skin) = (paint_head(&figure, sizes.from), paint_body(&figure, sizes.to));
    let carried = |pair: &Arc<Pair>, direction: Direction| -> Texture {
        let (sizes, texture, base) = match direction {
            Direction::Forward => (sizes, &face, &skin),
            Direction::Reverse => (Sizes { from: sizes.to, to: sizes.from }, &skin, &face),
        };
        let graft = Graft::builder(Arc::clone(pair), sizes).direction(direction);
        graft.filter(Filter::Bilinear).build().unwrap().apply(texture, base).unwrap()
    };
    for direction in [Direction::Forward, Direction::Reverse] {
        let [by_map, by_place] = [&by_map, &by_place].map(|pair| carried(pair, direction));
        assert!(by_map == by_place, "{direction:?}");
    }
    assert!(carried(&by_place, Direction::Forward) != skin);
}
