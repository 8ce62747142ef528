//! Meshes numbered in another order.

use uvgraft::{Corner, Mesh};

/// A mesh with its vertices, UV coordinates, polygons and first corners in random order.
#[derive(Debug)]
pub struct Shuffled {
    /// The mesh.
    pub mesh: Mesh,
    /// The new index of each vertex.
    pub vertices: Vec<u32>,
    /// For each new polygon, the original one, and the original corner that comes first.
    pub polygons: Vec<(usize, usize)>,
}

impl Shuffled {
    /// Shuffles a mesh.
    ///
    /// # Panics
    /// Never: the mesh stays as sound as it is.
    pub fn new(mesh: &Mesh, seed: u64) -> Self {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut order = |count: usize| {
            let mut order: Vec<u32> = (0..count as u32).collect();
            random.shuffle(&mut order);
            order
        };
        let (vertices, uv) = (order(mesh.positions().len()), order(mesh.uv().len()));
        let polygons: Vec<(usize, usize)> = order(mesh.polygon_count())
            .into_iter()
            .map(|polygon| (polygon as usize, random.usize(0..64)))
            .map(|(polygon, first)| (polygon, first % mesh.polygon_corners(polygon).len()))
            .collect();
        let mut corners = Vec::new();
        let mut sizes = Vec::new();
        for &(polygon, first) in &polygons {
            let mut ring = mesh.polygon_corners(polygon);
            ring.rotate_left(first);
            sizes.push(ring.len() as u32);
            corners.extend(ring.into_iter().map(|corner| Corner {
                vertex: vertices[corner.vertex as usize],
                uv: uv[corner.uv as usize],
            }));
        }
        let positions = placed(mesh.positions(), &vertices);
        let mesh = Mesh::from_polygons(positions, placed(mesh.uv(), &uv), &corners, &sizes);
        Self { mesh: mesh.expect("as sound as before"), vertices, polygons }
    }
}

fn placed<const N: usize>(values: &[[f32; N]], places: &[u32]) -> Vec<[f32; N]> {
    let mut placed = vec![[0.0; N]; values.len()];
    for (value, &place) in values.iter().zip(places) {
        placed[place as usize] = *value;
    }
    placed
}
