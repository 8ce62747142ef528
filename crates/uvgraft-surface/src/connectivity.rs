//! Fingerprints of connectivity: which polygons meet at which vertices, wherever the vertices are.
//!
//! Two files of one mesh agree in their fingerprint however their vertices and faces are ordered,
//! whatever pose and shape the mesh has, and whether an exporter split its vertices at UV seams. A
//! fingerprint identifies a mesh or a layout without containing anything of it.
//!
//! Based on the colour refinement of Weisfeiler and Leman, 1968: every vertex starts with the number
//! of its polygons, and in each round takes in what its polygons' corners had in the round before.
//! The sorted colours would be the fingerprint; their sum, which needs no order, is hashed instead.

use std::fmt;

use crate::bits::mixed;
use crate::islands::weld_corners;
use crate::mesh::Mesh;
use crate::surface::Surface;

/// Number of rounds. After the last, the colour of a vertex depends on all polygons up to four edges
/// away: enough to tell edits anywhere, and few enough to be fast.
const ROUNDS: usize = 4;

/// 64 bits that identify the connectivity of a mesh or of its layout. Displayed as 16 hexadecimal
/// digits.
///
/// Computed in integers with fixed constants, so it is the same on every platform and in every
/// version.
///
/// Polygons are taken as they are: a mesh of quads and its triangulation differ, because the
/// diagonals of quads are a choice of whoever splits them. Windings are not taken into account, nor
/// are vertices without polygons.
///
/// # Example
/// ```
/// # use uvgraft_surface::{Fingerprint, Mesh};
/// # fn example(published: &Mesh, mine: &Mesh) {
/// if Fingerprint::of_surface(published) == Fingerprint::of_surface(mine) {
///     println!("the same mesh, perhaps in another pose or vertex order");
/// }
/// # }
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Fingerprint(pub u64);

impl Fingerprint {
    /// The fingerprint of a mesh's surface. Vertices on open edges that share a position are one, as
    /// exporters split vertices along UV seams.
    pub fn of_surface(mesh: &Mesh) -> Self {
        let surface = Surface::new(mesh);
        Self::of(mesh, surface.triangles(), surface.positions().len())
    }

    /// The fingerprint of a mesh's layout: of the polygons as its UV seams part them. Corners at one
    /// place of the surface with the same UV coordinate are one vertex.
    ///
    /// It says where the seams are, not where the islands lie in the square.
    pub fn of_layout(mesh: &Mesh) -> Self {
        Welded::new(mesh).fingerprints(mesh)[1]
    }

    /// The fingerprint of a mesh's polygons with other vertices.
    ///
    /// - `triangles`: `[triangles]`, the vertex at each corner of the mesh's triangles, below
    ///   `count`.
    fn of(mesh: &Mesh, triangles: &[[u32; 3]], count: usize) -> Self {
        let rings = Rings::new(mesh, triangles);
        let mut colors = vec![0_u64; count];
        for &vertex in &rings.corners {
            colors[vertex as usize] += 1;
        }
        let is_used: Vec<bool> = colors.iter().map(|&polygons| polygons > 0).collect();
        let mut around = vec![0_u64; count];
        for _ in 0..ROUNDS {
            around.fill(0);
            rings.for_each(|ring| gather(ring, &colors, &mut around));
            for (color, around) in colors.iter_mut().zip(&around) {
                *color = mixed(color.wrapping_mul(3).wrapping_add(*around));
            }
        }
        let used = colors.iter().zip(&is_used).filter(|(_, is_used)| **is_used);
        let (sum, vertices) = used
            .fold((0_u64, 0_u64), |(sum, n), (&color, _)| (sum.wrapping_add(mixed(color)), n + 1));
        let polygons = rings.starts.len() as u64;
        Self(mixed(mixed(mixed(vertices).wrapping_add(polygons)).wrapping_add(sum)))
    }
}

impl fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for Fingerprint {
    /// As its 16 digits, since JSON numbers hold 53 bits.
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// The vertices of a mesh and of its layout without what exporters split.
pub(crate) struct Welded {
    surface: Surface,
    /// `[triangles]`: the place on the surface and in the layout at each corner.
    corners: Vec<[u32; 3]>,
    /// Number of these places.
    count: u32,
}

impl Welded {
    pub fn new(mesh: &Mesh) -> Self {
        let surface = Surface::new(mesh);
        let (corners, count) = weld_corners(mesh, surface.triangles(), surface.positions().len());
        Self { surface, corners, count }
    }

    /// The fingerprints of the surface and of the layout.
    pub fn fingerprints(&self, mesh: &Mesh) -> [Fingerprint; 2] {
        let (points, triangles) = (self.surface.positions().len(), self.surface.triangles());
        [
            Fingerprint::of(mesh, triangles, points),
            Fingerprint::of(mesh, &self.corners, self.count as usize),
        ]
    }

    /// Number of points of the surface that triangles use.
    pub fn used_points(&self) -> usize {
        let points = 0..self.surface.positions().len() as u32;
        points.filter(|&point| !self.surface.around(point).is_empty()).count()
    }

    /// Number of UV coordinates that triangles use.
    pub fn uv_count(&self) -> usize {
        self.count as usize
    }
}

/// Polygons as rings of vertices.
struct Rings {
    corners: Vec<u32>,
    /// The first corner of each polygon.
    starts: Vec<u32>,
}

impl Rings {
    fn new(mesh: &Mesh, triangles: &[[u32; 3]]) -> Self {
        let mut corners = Vec::with_capacity(triangles.len() * 3);
        let mut starts = Vec::with_capacity(mesh.polygon_count());
        for polygon in 0..mesh.polygon_count() {
            starts.push(corners.len() as u32);
            let fan = &triangles[mesh.polygon(polygon)];
            corners.extend(fan.first().into_iter().flat_map(|first| [first[0], first[1]]));
            corners.extend(fan.iter().map(|triangle| triangle[2]));
        }
        Self { corners, starts }
    }

    fn for_each(&self, mut visit: impl FnMut(&[u32])) {
        let ends = self.starts.iter().skip(1).copied().chain([self.corners.len() as u32]);
        for (&start, end) in self.starts.iter().zip(ends) {
            visit(&self.corners[start as usize..end as usize]);
        }
    }
}

/// Adds what one polygon contributes to each of its vertices: symmetric in the direction and
/// independent of where the ring starts. The neighbours along the ring count apart from the rest, so
/// the two ways to go around the same corners differ.
fn gather(ring: &[u32], colors: &[u64], around: &mut [u64]) {
    let size = ring.len();
    let color = |index: usize| colors[ring[index] as usize];
    let all = (0..size).fold(size as u64, |sum, k| sum.wrapping_add(mixed(color(k))));
    for k in 0..size {
        let beside = mixed(color((k + 1) % size)).wrapping_add(mixed(color((k + size - 1) % size)));
        let share = mixed(all.wrapping_add(beside.wrapping_mul(5)));
        let vertex = ring[k] as usize;
        around[vertex] = around[vertex].wrapping_add(share);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Corner;

    const SIDE: u32 = 9;

    type Ring = Vec<Corner>;

    /// A bumpy sheet of quads with its layout cut in two along the middle column, and a vertex that
    /// no quad uses.
    fn sheet() -> (Vec<[f32; 3]>, Vec<[f32; 2]>, Vec<Ring>) {
        let at = |k: u32| (k % SIDE, k / SIDE);
        let mut positions: Vec<[f32; 3]> = (0..SIDE * SIDE)
            .map(|k| [at(k).0 as f32, at(k).1 as f32, (k * k % 7) as f32 * 0.1])
            .collect();
        positions.push([50.0; 3]);
        let uv = |shift: f32| {
            move |k| [(k % SIDE) as f32 * 0.04 + shift, (k / SIDE) as f32 * 0.04 + shift]
        };
        let both: Vec<[f32; 2]> =
            (0..SIDE * SIDE).map(uv(0.0)).chain((0..SIDE * SIDE).map(uv(0.5))).collect();
        let mut polygons = Vec::new();
        for y in 0..SIDE - 1 {
            for x in 0..SIDE - 1 {
                let island = if x < SIDE / 2 { 0 } else { SIDE * SIDE };
                let corner = |x, y| Corner { vertex: y * SIDE + x, uv: island + y * SIDE + x };
                polygons.push(vec![
                    corner(x, y),
                    corner(x + 1, y),
                    corner(x + 1, y + 1),
                    corner(x, y + 1),
                ]);
            }
        }
        (positions, both, polygons)
    }

    fn mesh(positions: &[[f32; 3]], uv: &[[f32; 2]], polygons: &[Ring]) -> Mesh {
        let sizes: Vec<u32> = polygons.iter().map(|ring| ring.len() as u32).collect();
        Mesh::from_polygons(positions.to_vec(), uv.to_vec(), &polygons.concat(), &sizes).unwrap()
    }

    fn both(mesh: &Mesh) -> [Fingerprint; 2] {
        [Fingerprint::of_surface(mesh), Fingerprint::of_layout(mesh)]
    }

    /// Each quad as two triangles.
    fn split(polygons: &[Ring]) -> Vec<Ring> {
        let halves =
            |ring: &Ring| [vec![ring[0], ring[1], ring[2]], vec![ring[0], ring[2], ring[3]]];
        polygons.iter().flat_map(halves).collect()
    }

    #[test]
    fn known_values_stay() {
        let (positions, uv, polygons) = sheet();
        // Computed once: a change here would make every published fingerprint useless.
        let [surface, layout] = both(&mesh(&positions, &uv, &polygons));
        assert_eq!(surface.to_string(), "11e5bc2d8c13a180");
        assert_eq!(layout.to_string(), "0678f034ef992ec1");
    }

    #[test]
    fn order_does_not_matter() {
        let (positions, uv, polygons) = sheet();
        for polygons in [polygons.clone(), split(&polygons)] {
            let wanted = both(&mesh(&positions, &uv, &polygons));
            for seed in 1..6 {
                let mut random = fastrand::Rng::with_seed(seed);
                let mut shuffled = |count: usize| {
                    let mut order: Vec<u32> = (0..count as u32).collect();
                    random.shuffle(&mut order);
                    order
                };
                let [vertex, uv_index] = [positions.len(), uv.len()].map(&mut shuffled);
                let mut moved_positions = positions.clone();
                let mut moved_uv = uv.clone();
                for (from, &to) in vertex.iter().enumerate() {
                    // Another shape, too.
                    moved_positions[to as usize] = positions[from].map(|value| 3.0 * value + 1.0);
                }
                for (from, &to) in uv_index.iter().enumerate() {
                    moved_uv[to as usize] = uv[from].map(|value| 0.7 * value);
                }
                let mut moved: Vec<Ring> = polygons.clone();
                for ring in &mut moved {
                    let start = random.usize(..ring.len());
                    ring.rotate_left(start);
                    for corner in ring {
                        corner.vertex = vertex[corner.vertex as usize];
                        corner.uv = uv_index[corner.uv as usize];
                    }
                }
                random.shuffle(&mut moved);
                assert_eq!(both(&mesh(&moved_positions, &moved_uv, &moved)), wanted, "{seed}");
            }
        }
    }

    #[test]
    fn vertices_that_an_exporter_split_are_one() {
        let (positions, uv, polygons) = sheet();
        let polygons = split(&polygons);
        let wanted = both(&mesh(&positions, &uv, &polygons));
        // As in a GLB: each corner's vertex has its own UV coordinate.
        let used: Vec<Corner> = polygons.concat();
        let mut vertices: Vec<Corner> = Vec::new();
        let mut of = |corner: &Corner| {
            let place = vertices.iter().position(|known| known == corner);
            let place = place.unwrap_or_else(|| {
                vertices.push(*corner);
                vertices.len() - 1
            });
            Corner { vertex: place as u32, uv: place as u32 }
        };
        let as_glb: Vec<Corner> = used.iter().map(&mut of).collect();
        let sizes = vec![3; polygons.len()];
        let at = vertices.iter().map(|corner| positions[corner.vertex as usize]).collect();
        let at_uv = vertices.iter().map(|corner| uv[corner.uv as usize]).collect();
        let glb = Mesh::from_polygons(at, at_uv, &as_glb, &sizes).unwrap();
        assert!(glb.positions().len() > positions.len());
        assert_eq!(both(&glb), wanted);
    }

    #[test]
    fn one_flipped_edge_is_a_difference() {
        let (positions, uv, polygons) = sheet();
        let triangles = split(&polygons);
        let before = both(&mesh(&positions, &uv, &triangles));
        for quad in [0, polygons.len() / 2, polygons.len() - 1] {
            let mut flipped = triangles.clone();
            let ring = &polygons[quad];
            flipped[2 * quad] = vec![ring[1], ring[2], ring[3]];
            flipped[2 * quad + 1] = vec![ring[1], ring[3], ring[0]];
            let after = both(&mesh(&positions, &uv, &flipped));
            assert_ne!(after[0], before[0], "{quad}");
            assert_ne!(after[1], before[1], "{quad}");
        }
    }

    #[test]
    fn a_moved_seam_differs_in_the_layout_only() {
        let (positions, uv, mut polygons) = sheet();
        let before = both(&mesh(&positions, &uv, &polygons));
        // A quad beside the seam goes to the other island.
        for corner in &mut polygons[SIDE as usize / 2] {
            corner.uv -= SIDE * SIDE;
        }
        let after = both(&mesh(&positions, &uv, &polygons));
        assert_eq!(after[0], before[0]);
        assert_ne!(after[1], before[1]);
    }

    #[test]
    fn quads_and_their_triangles_differ() {
        let (positions, uv, polygons) = sheet();
        let [quads, triangles] =
            [&polygons, &split(&polygons)].map(|polygons| both(&mesh(&positions, &uv, polygons)));
        assert_ne!(quads[0], triangles[0]);
    }
}
