//! All triangles of a picture in one list, with their vertex attributes.

use glam::Vec3;
use uvgraft::Mesh;
use uvgraft_avatar::normals::vertex_normals;
use uvgraft_gltf::scene::PosedPrimitive;

use super::camera::Bounds;
use super::surface::Surface;

#[derive(Debug, Default)]
pub(crate) struct Geometry {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    /// Empty, or one colour for each position.
    pub colors: Vec<[f32; 4]>,
    pub uv: Vec<[f32; 2]>,
    /// Further sets of texture coordinates, each as long as `uv`.
    pub more_uv: Vec<Vec<[f32; 2]>>,
    pub faces: Vec<Face>,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Face {
    pub vertices: [u32; 3],
    pub uv: [u32; 3],
    pub surface: u32,
}

impl Geometry {
    /// A mesh, with the surface index of every triangle.
    pub fn of_mesh(mesh: &Mesh, surfaces: &[u32]) -> Self {
        let faces = mesh.faces().iter().zip(mesh.uv_faces()).zip(surfaces);
        Self {
            positions: mesh.positions().iter().map(|&p| Vec3::from(p)).collect(),
            normals: vertex_normals(mesh.positions(), mesh.faces()),
            colors: Vec::new(),
            uv: mesh.uv().to_vec(),
            more_uv: Vec::new(),
            faces: faces
                .map(|((&vertices, &uv), &surface)| Face { vertices, uv, surface })
                .collect(),
        }
    }

    /// The drawn primitives of a scene. Triangles with a corner that is missing or not finite are
    /// left out, and so are those without a surface. Missing normals and texture coordinates are
    /// zero, missing colours white.
    pub fn of_primitives(drawn: &[PosedPrimitive], surfaces: &[Surface]) -> Self {
        let sets = drawn.iter().map(|piece| piece.more_uv.len()).max().unwrap_or(0);
        let mut all = Self { more_uv: vec![Vec::new(); sets], ..Self::default() };
        let colored = drawn.iter().any(|piece| piece.colors.is_some());
        for piece in drawn {
            let (first, count) = (all.positions.len() as u32, piece.positions.len());
            all.positions.extend(piece.positions.iter().map(|&p| Vec3::from(p)));
            let normals = piece.normals.iter().map(|&n| Vec3::from(n));
            all.normals.extend(normals.chain(std::iter::repeat(Vec3::default())).take(count));
            let filled = |uv: &[[f32; 2]]| {
                let uv = uv.iter().copied().chain(std::iter::repeat([0.0; 2])).take(count);
                uv.collect::<Vec<_>>()
            };
            all.uv.extend(filled(&piece.uv));
            for (set, all) in all.more_uv.iter_mut().enumerate() {
                all.extend(filled(piece.more_uv.get(set).map_or(&[][..], |uv| uv)));
            }
            if colored {
                let colors = piece.colors.as_deref().unwrap_or_default().iter().copied();
                all.colors.extend(colors.chain(std::iter::repeat([1.0; 4])).take(count));
            }
            if piece.material >= surfaces.len() {
                continue;
            }
            let sound = |vertex: u32| {
                let p = piece.positions.get(vertex as usize);
                p.is_some_and(|p| p.iter().all(|value| value.is_finite()))
            };
            for triangle in piece.triangles.iter() {
                if triangle.iter().all(|&vertex| sound(vertex)) {
                    let vertices = triangle.map(|vertex| first + vertex);
                    let surface = piece.material as u32;
                    all.faces.push(Face { vertices, uv: vertices, surface });
                }
            }
        }
        all
    }

    /// Texture coordinates of a triangle's corners. Set 0 is `uv`, the others are in `more_uv`; a
    /// set that does not exist falls back to `uv`.
    pub fn corner_uv(&self, face: usize, coordinates: usize) -> [[f32; 2]; 3] {
        let more = coordinates.checked_sub(1).and_then(|set| self.more_uv.get(set));
        let uv = more.unwrap_or(&self.uv);
        self.faces[face].uv.map(|index| uv[index as usize])
    }

    pub fn corners(&self, face: usize) -> [Vec3; 3] {
        self.faces[face].vertices.map(|vertex| self.positions[vertex as usize])
    }

    /// Normal of a triangle on its front side, with twice the triangle's area as length.
    pub fn normal_of(&self, face: usize) -> Vec3 {
        let [a, b, c] = self.corners(face);
        (b - a).cross(c - a)
    }

    /// The bounding box of all triangles; the origin if there are none.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let used = self.faces.iter().flat_map(|face| face.vertices);
        let points = used.map(|vertex| self.positions[vertex as usize].into());
        let bounds = Bounds::of(points);
        bounds.map_or_else(Default::default, |found| (found.low.into(), found.high.into()))
    }
}
