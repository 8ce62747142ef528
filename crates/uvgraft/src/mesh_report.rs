//! Statistics of one mesh and its layout: what one wants to know of a file before pairing it.

use uvgraft_surface::anatomy::{Anatomy, Area, Landmark};
use uvgraft_surface::disjoint::DisjointSets;
use uvgraft_surface::islands::Islands;
use uvgraft_surface::known::{Recognition, recognise};
use uvgraft_surface::mesh::{Mesh, TileFaces, doubled_area};
use uvgraft_surface::piece::wide;
use uvgraft_surface::surface::Surface;

use crate::map::{MapOptions, SamplingMap};
use crate::texture::Size;

/// Side of the texture that overlaps are counted in, in texels.
pub const OVERLAP_SIDE: u32 = 1024;

/// Statistics of a mesh. Edges and components are those of its surface, on which vertices that an
/// exporter split along UV seams are one.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct MeshReport {
    /// Number of positions.
    pub vertices: usize,
    /// Number of positions that no face uses.
    pub unused_vertices: usize,
    /// Number of UV coordinates.
    pub uv_coordinates: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Number of polygons before triangulation.
    pub polygons: usize,
    /// Number of UV islands.
    pub islands: usize,
    /// Number of connected components.
    pub components: usize,
    /// Number of edges with one triangle.
    pub open_edges: usize,
    /// Number of connected groups of open edges: holes and rims.
    pub boundaries: usize,
    /// Number of edges with more than two triangles.
    pub non_manifold_edges: usize,
    /// Number of triangles without area: two corners coincide, or all lie on a line.
    pub degenerate: usize,
    /// Number of triangles without UV area, which cannot hold any texture.
    pub degenerate_uv: usize,
    /// Number of triangles with UV coordinates outside the unit square.
    pub outside: usize,
    /// The UV tiles in use.
    pub tiles: Vec<TileFaces>,
    /// Texels that more than one UV island covers, in a texture of [`OVERLAP_SIDE`]².
    pub overlapping_texels: usize,
    /// Texels that any triangle covers, in a texture of [`OVERLAP_SIDE`]².
    pub covered_texels: usize,
    /// Lowest and highest coordinates of the vertices in use, in the mesh's unit.
    pub bounds: [[f32; 3]; 2],
    /// What the mesh shows; `None` if no head was found.
    pub subject: Option<Subject>,
    /// Units in which the mesh would have the size of a person; several if `subject` is unknown.
    pub units: Vec<Unit>,
    /// Its name and the name of its layout, if they are publicly known.
    pub recognition: Recognition,
}

/// What a mesh shows, by its anatomy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "kebab-case"))]
pub enum Subject {
    /// A head, perhaps with neck and shoulders.
    Head,
    /// A body, at least from the hips up.
    Body,
}

/// A unit of length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Unit {
    /// Metre.
    Metre,
    /// Decimetre, as in MakeHuman's files.
    Decimetre,
    /// Centimetre.
    Centimetre,
    /// Millimetre.
    Millimetre,
}

uvgraft_surface::choices!(Unit {
    Metre => "m", "Metres";
    Decimetre => "dm", "Decimetres";
    Centimetre => "cm", "Centimetres";
    Millimetre => "mm", "Millimetres";
});
#[cfg(feature = "serde")]
uvgraft_surface::serialize_by_name!(Unit);

impl MeshReport {
    /// Computes the statistics of a mesh. Most of the time goes into looking for a head.
    pub fn new(mesh: &Mesh) -> Self {
        let surface = Surface::new(mesh);
        let edges = EdgeCounts::of(&surface);
        let bounds = bounds(mesh);
        let subject = subject(mesh);
        let size = Size::square(OVERLAP_SIDE);
        let texels = SamplingMap::of_layout(mesh, size, &MapOptions::with_gutter(0)).stats();
        let faces = 0..mesh.faces().len();
        let has_no_uv_area = |&face: &usize| doubled_area(wide(mesh.uv_triangle(face))) == 0.0;
        Self {
            vertices: mesh.positions().len(),
            unused_vertices: is_used(mesh).into_iter().filter(|is_used| !is_used).count(),
            uv_coordinates: mesh.uv().len(),
            triangles: faces.len(),
            polygons: mesh.polygon_count(),
            islands: Islands::new(mesh).count(),
            components: components(surface.positions().len(), surface.triangles()),
            open_edges: edges.open,
            boundaries: edges.boundaries,
            non_manifold_edges: edges.non_manifold,
            degenerate: faces.clone().filter(|&face| surface.area(face as u32) == 0.0).count(),
            degenerate_uv: faces.clone().filter(has_no_uv_area).count(),
            outside: faces.filter(|&face| mesh.is_outside(face)).count(),
            tiles: mesh.tiles(),
            overlapping_texels: texels.overlapping,
            covered_texels: texels.covered,
            bounds,
            subject,
            units: units(bounds, subject),
            recognition: recognise(mesh),
        }
    }
}

/// For each position, whether a face uses it.
fn is_used(mesh: &Mesh) -> Vec<bool> {
    let mut is_used = vec![false; mesh.positions().len()];
    for &vertex in mesh.faces().as_flattened() {
        is_used[vertex as usize] = true;
    }
    is_used
}

/// Lowest and highest coordinates over the vertices in use.
fn bounds(mesh: &Mesh) -> [[f32; 3]; 2] {
    let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for (position, _) in mesh.positions().iter().zip(is_used(mesh)).filter(|(_, is_used)| *is_used)
    {
        for k in 0..3 {
            bounds[0][k] = bounds[0][k].min(position[k]);
            bounds[1][k] = bounds[1][k].max(position[k]);
        }
    }
    bounds
}

/// Number of connected components among the points that triangles use.
fn components(points: usize, triangles: &[[u32; 3]]) -> usize {
    let mut sets = DisjointSets::new(points as u32);
    for &[a, b, c] in triangles {
        sets.join(a, b);
        sets.join(a, c);
    }
    let mut roots: Vec<u32> = triangles.iter().map(|&[a, ..]| sets.root(a)).collect();
    roots.sort_unstable();
    roots.dedup();
    roots.len()
}

struct EdgeCounts {
    open: usize,
    boundaries: usize,
    non_manifold: usize,
}

impl EdgeCounts {
    fn of(surface: &Surface) -> Self {
        let sides = surface.triangles().iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        // The side of a triangle with two corners at one point is no edge.
        let sides = sides.filter(|(a, b)| a != b);
        let mut edges: Vec<(u32, u32)> = sides.map(|(a, b)| (a.min(b), a.max(b))).collect();
        edges.sort_unstable();
        let groups = || edges.chunk_by(PartialEq::eq);
        let open: Vec<(u32, u32)> =
            groups().filter(|group| group.len() == 1).map(|group| group[0]).collect();
        let mut sets = DisjointSets::new(surface.positions().len() as u32);
        open.iter().for_each(|&(a, b)| sets.join(a, b));
        let mut roots: Vec<u32> = open.iter().map(|&(a, _)| sets.root(a)).collect();
        roots.sort_unstable();
        roots.dedup();
        Self {
            open: open.len(),
            boundaries: roots.len(),
            non_manifold: groups().filter(|group| group.len() > 2).count(),
        }
    }
}

fn subject(mesh: &Mesh) -> Option<Subject> {
    let anatomy = Anatomy::find(mesh).ok()?;
    let has = |area| anatomy.area(area).iter().any(|&weight| weight > 0.5);
    // Hands in pockets and feet in shoes are not found.
    let is_body = has(Area::Hands) || has(Area::Feet) || reaches_hips(mesh, &anatomy);
    Some(if is_body { Subject::Body } else { Subject::Head })
}

/// Whether the mesh goes on below the chin for more than a bust does.
fn reaches_hips(mesh: &Mesh, anatomy: &Anatomy) -> bool {
    /// In heights of the head from crown to chin: FLAME, a head with shoulders, has 0.4 of them
    /// below the chin, and SMPL-X 5.8, of which hips are at about 2.5.
    const BELOW_CHIN: f64 = 2.0;
    let height = |point: [f64; 3]| anatomy.frame().local(point)[1];
    let [Some(crown), Some(chin)] = [Landmark::Crown, Landmark::Chin].map(|it| anatomy.point(it))
    else {
        return false;
    };
    let (crown, chin) = (height(crown), height(chin));
    let heights = mesh.positions().iter().zip(is_used(mesh)).filter(|(_, is_used)| *is_used);
    let lowest = heights.map(|(position, _)| height(position.map(f64::from)));
    chin - lowest.fold(chin, f64::min) > BELOW_CHIN * (crown - chin)
}

/// The units in which the longest side of the bounds is that of a person: 12 to 60 cm for a head,
/// perhaps a bust, and 1 to 2.5 m for a body, standing or with arms spread.
fn units(bounds: [[f32; 3]; 2], subject: Option<Subject>) -> Vec<Unit> {
    let longest = (0..3).map(|k| bounds[1][k] - bounds[0][k]).fold(0.0, f32::max);
    let fits = |metres: f32| {
        let is_head = (0.12..=0.6).contains(&metres) && subject != Some(Subject::Body);
        let is_body = (1.0..=2.5).contains(&metres) && subject != Some(Subject::Head);
        is_head || is_body
    };
    [
        (Unit::Metre, 1.0),
        (Unit::Decimetre, 0.1),
        (Unit::Centimetre, 0.01),
        (Unit::Millimetre, 0.001),
    ]
    .into_iter()
    .filter(|(_, metres)| fits(longest * metres))
    .map(|(unit, _)| unit)
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles that share an edge, a third at the same edge, one by itself whose vertices are
    /// on a line, and an unused vertex. The third lies in tile 1011, the last left of all tiles.
    fn mesh() -> Mesh {
        let positions = vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.5, 0.5, 1.5],
            [5.0, 0.0, 0.0],
            [6.0, 0.0, 0.0],
            [7.0, 0.0, 0.0],
            [99.0, 0.0, 0.0],
        ];
        let uv = vec![
            [0.1, 0.9],
            [0.6, 0.9],
            [0.1, 0.4],
            [0.6, 0.4],
            [0.1, -0.4],
            [0.6, -0.4],
            [0.3, -0.6],
            [-0.5, 0.5],
            [-0.6, 0.5],
            [-0.7, 0.5],
        ];
        let faces = [[0, 1, 2], [1, 3, 2], [1, 2, 4], [5, 6, 7]];
        let uv_faces = [[0, 1, 2], [1, 3, 2], [4, 5, 6], [7, 8, 9]];
        Mesh::from_triangles(positions, uv, &faces, &uv_faces).unwrap()
    }

    #[test]
    fn a_small_mesh_is_counted_right() {
        let report = MeshReport::new(&mesh());
        assert_eq!((report.vertices, report.unused_vertices, report.uv_coordinates), (9, 1, 10));
        assert_eq!((report.triangles, report.polygons, report.islands), (4, 4, 3));
        assert_eq!((report.components, report.open_edges, report.boundaries), (2, 9, 2));
        assert_eq!((report.non_manifold_edges, report.degenerate), (1, 1));
        assert_eq!((report.degenerate_uv, report.outside), (1, 2));
        let tiles: Vec<_> =
            report.tiles.iter().map(|tile| (tile.tile, tile.udim, tile.faces)).collect();
        let wanted = [([-1, 0], None, 1), ([0, 0], Some(1001), 2), ([0, 1], Some(1011), 1)];
        assert_eq!(tiles, wanted);
        assert_eq!(report.bounds, [[0.0; 3], [7.0, 1.0, 1.5]]);
        assert_eq!((report.overlapping_texels, report.subject), (0, None));
        let quarter = (OVERLAP_SIDE * OVERLAP_SIDE / 4) as usize;
        assert!(report.covered_texels.abs_diff(quarter) < 2_000, "{}", report.covered_texels);
    }

    #[test]
    fn split_vertices_are_no_boundary() {
        let positions = vec![
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
        ];
        let uv = vec![[0.0; 2]; 6];
        let faces = [[0, 1, 2], [3, 4, 5]];
        let report = MeshReport::new(&Mesh::from_triangles(positions, uv, &faces, &faces).unwrap());
        assert_eq!((report.components, report.open_edges, report.boundaries), (1, 4, 1));
    }

    #[test]
    fn units_follow_the_size_and_the_subject() {
        let of = |longest: f32, subject| units([[0.0; 3], [0.1, longest, 0.1]], subject);
        use Unit::*;
        assert_eq!(of(0.26, Some(Subject::Head)), [Metre]);
        assert_eq!(of(0.26, None), [Metre]);
        assert_eq!(of(1.8, None), [Metre, Decimetre]);
        assert_eq!(of(17.0, Some(Subject::Body)), [Decimetre]);
        assert_eq!(of(170.0, Some(Subject::Body)), [Centimetre]);
        assert_eq!(of(250.0, Some(Subject::Head)), [Millimetre]);
        // A body in centimetres or a head in millimetres.
        assert_eq!(of(250.0, None), [Centimetre, Millimetre]);
        assert_eq!(of(1e6, None), []);
    }

    #[test]
    fn far_coordinates_do_no_harm() {
        let uv = vec![[3e38, 3e38], [3e38, -3e38], [-3e38, 3e38]];
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let faces = [[0, 1, 2]];
        let report = MeshReport::new(&Mesh::from_triangles(positions, uv, &faces, &faces).unwrap());
        assert_eq!((report.outside, report.tiles.len()), (1, 1));
        assert_eq!(report.tiles[0].udim, None);
    }
}
