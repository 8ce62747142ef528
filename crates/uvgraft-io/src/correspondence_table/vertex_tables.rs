//! Vertex tables of two meshes from files of correspondences.

use std::collections::HashMap;

use uvgraft::correspond::table::{SurfacePoint, TableError, TableRows, UvLocator, VertexTable};
use uvgraft::{Mesh, MeshError, Size};

use super::{CorrespondenceFile, TexelGrid, TexelLayout, layout_mesh};

/// A vertex table, and which mesh it is of.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundTable {
    /// The mesh whose vertices its rows are.
    pub rows: TableRows,
    /// The table.
    pub table: VertexTable,
    /// Rows of the file that have weights but are not a point on a face, and count as empty.
    pub unusable: usize,
}

/// Why a file is not a table of two meshes.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TableFitError {
    /// Its shape is not that of the meshes.
    #[error(
        "the table is {shape}; it must have {wanted}, but the source mesh has {source_vertices} vertices \
         and the target mesh {target_vertices}"
    )]
    Shape {
        /// What the table is, with its shape.
        shape: String,
        /// What it must have.
        wanted: &'static str,
        /// Number of vertices of the source.
        source_vertices: usize,
        /// Number of vertices of the target.
        target_vertices: usize,
    },
    /// Its content does not fit the meshes.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The texels of a layout that neither mesh has.
    #[error(
        "the file has a UV layout with {coordinates} coordinates and the vertices at its texels; one mesh \
         must have this layout and the other these vertices, at least {vertices}, but the coordinates \
         are in {source_share:.0} % of the source's layout and {target_share:.0} % of the target's"
    )]
    Layout {
        /// Number of UV coordinates of the layout.
        coordinates: usize,
        /// Number of vertices that its texels need.
        vertices: usize,
        /// Percentage of the coordinates that are also the source's.
        source_share: f64,
        /// Percentage of the coordinates that are also the target's.
        target_share: f64,
    },
    /// The texels of a layout that give no mesh.
    #[error("the texels of the layout must be those of a mesh: {0}")]
    LayoutMesh(MeshError),
}

/// Interprets a file for two meshes.
///
/// Usually there is one table. There are two where the meshes have equally many vertices, so that
/// rows may be either's: the target's come first, as these files are usually made.
///
/// - A matrix has a row for each vertex of one mesh and a column for each of the other, or twice as
///   many. Faces with weights have a row for each vertex of one mesh; faces are triangles of the other.
/// - A grid is of the texels of one mesh's layout, with positions in the other's. It is the target's
///   unless texels and positions lie on islands the other way round only.
/// - The texels of a layout have vertices. One mesh must have this layout, and the other mesh these
///   vertices.
///
/// # Errors
/// [`TableFitError`] with both meshes' counts.
pub fn vertex_tables(
    file: &CorrespondenceFile,
    source: &Mesh,
    target: &Mesh,
) -> Result<Vec<FoundTable>, TableFitError> {
    let meshes = [source, target];
    match file {
        CorrespondenceFile::Matrix(matrix) => {
            let [rows, columns] = matrix.shape();
            let wanted = "a row for each vertex of one mesh and a column for each vertex of the other, \
                          or twice as many";
            let fits = |mesh: &Mesh, onto: &Mesh| {
                let vertices = onto.positions().len();
                rows == mesh.positions().len()
                    && (columns == vertices || columns == vertices.saturating_mul(2))
            };
            by_rows(meshes, format!("a matrix of {rows} x {columns}"), wanted, fits, |_, onto| {
                let (table, counts) =
                    VertexTable::from_rows(matrix.rows(), columns, onto.positions().len())?;
                Ok((table, counts.spread + counts.unweighted))
            })
        }
        CorrespondenceFile::Points { faces, weights } => {
            let shape = format!("a list of {} faces and weights", faces.len());
            let fits = |mesh: &Mesh, _: &Mesh| faces.len() == mesh.positions().len();
            by_rows(meshes, shape, "one for each vertex of one mesh", fits, |_, onto| {
                let vertices = onto.positions().len();
                Ok((VertexTable::from_faces(onto.faces(), vertices, faces, weights)?, 0))
            })
        }
        CorrespondenceFile::Corners { vertices, weights } => {
            let shape = format!("a list of {} triangles and weights", vertices.len());
            let fits = |mesh: &Mesh, _: &Mesh| vertices.len() == mesh.positions().len();
            by_rows(meshes, shape, "one for each vertex of one mesh", fits, |_, onto| {
                Ok((VertexTable::from_corners(vertices, weights, onto.positions().len())?, 0))
            })
        }
        CorrespondenceFile::Layout(layout) => of_layout(layout, meshes),
        CorrespondenceFile::Grid(grid) => of_grid(grid, meshes).map(|table| vec![table]),
    }
}

/// Tables of the meshes that a table's shape fits.
fn by_rows(
    [source, target]: [&Mesh; 2],
    shape: String,
    wanted: &'static str,
    fits: impl Fn(&Mesh, &Mesh) -> bool,
    table: impl Fn(&Mesh, &Mesh) -> Result<(VertexTable, usize), TableError>,
) -> Result<Vec<FoundTable>, TableFitError> {
    let mut found = Vec::new();
    let mut refused = None;
    for (rows, mesh, onto) in
        [(TableRows::Target, target, source), (TableRows::Source, source, target)]
    {
        if !fits(mesh, onto) {
            continue;
        }
        match table(mesh, onto) {
            Ok((table, unusable)) => found.push(FoundTable { rows, table, unusable }),
            Err(error) => refused = refused.or(Some(error)),
        }
    }
    match refused {
        _ if !found.is_empty() => Ok(found),
        Some(error) => Err(error.into()),
        None => Err(TableFitError::Shape {
            shape,
            wanted,
            source_vertices: source.positions().len(),
            target_vertices: target.positions().len(),
        }),
    }
}

fn of_grid(grid: &TexelGrid, [source, target]: [&Mesh; 2]) -> Result<FoundTable, TableFitError> {
    /// Texels along the edges of islands may lie just outside of them.
    const MARGIN: f64 = 0.05;
    let locators = [source, target].map(UvLocator::new);
    let is_of_source = fit_of_grid(grid, [&locators[1], &locators[0]])
        > fit_of_grid(grid, [&locators[0], &locators[1]]) + MARGIN;
    let (rows, onto, mesh) = if is_of_source {
        (TableRows::Source, target, source)
    } else {
        (TableRows::Target, source, target)
    };
    let (table, _) = VertexTable::from_texels(onto, mesh, grid.size, &grid.uv)?;
    Ok(FoundTable { rows, table, unusable: 0 })
}

/// The share of a grid's texels that lie in one layout, with a position in another.
///
/// - `layouts`: that of the positions, and that of the texels.
fn fit_of_grid(grid: &TexelGrid, [onto, of]: [&UvLocator; 2]) -> f64 {
    /// About as many texels are looked at.
    const SAMPLES: usize = 10_000;
    let size = [grid.size.width, grid.size.height].map(f64::from);
    let width = grid.size.width as usize;
    let with_position = || grid.uv.iter().enumerate().filter(|(_, uv)| !uv[0].is_nan());
    let step = with_position().count() / SAMPLES + 1;
    let fits = |(texel, uv): &(usize, &[f32; 2])| {
        let texel = [texel % width, texel / width].map(|at| at as f64 + 0.5);
        let texel = [texel[0] / size[0], texel[1] / size[1]];
        let reach = 1.0 / size[0].max(size[1]);
        of.locate(texel, 0.0).is_some() && onto.locate(uv.map(f64::from), reach).is_some()
    };
    let looked_at = || with_position().step_by(step);
    looked_at().filter(fits).count() as f64 / looked_at().count().max(1) as f64
}

/// UV coordinates at the same place of a layout may be this far apart, in texels: half of what a
/// corner can be off that was recovered from texels.
const SAME_PX: f64 = 0.5;

/// Maximum number of a layout's coordinates within one texel.
const MAX_PER_TEXEL: usize = 64;

fn of_layout(
    layout: &TexelLayout,
    [source, target]: [&Mesh; 2],
) -> Result<Vec<FoundTable>, TableFitError> {
    /// Least share of a layout's coordinates that a mesh with this layout has.
    const ENOUGH: f64 = 0.8;
    let made = layout_mesh(layout).map_err(TableFitError::LayoutMesh)?.mesh;
    let corners = Corners::new(&made, layout.size);
    let shares = [source, target].map(|mesh| corners.share_in(mesh));
    let vertices = made.positions().len();
    let mut found = Vec::new();
    for (rows, mesh, onto, share) in [
        (TableRows::Target, target, source, shares[1]),
        (TableRows::Source, source, target, shares[0]),
    ] {
        if share >= ENOUGH && onto.positions().len() >= vertices {
            let table = VertexTable::new(corners.points(mesh), onto.positions().len())?;
            found.push((share, FoundTable { rows, table, unusable: 0 }));
        }
    }
    // The one that has this layout more certainly comes first.
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    if found.is_empty() {
        return Err(TableFitError::Layout {
            coordinates: made.uv().len(),
            vertices,
            source_share: 100.0 * shares[0],
            target_share: 100.0 * shares[1],
        });
    }
    Ok(found.into_iter().map(|(_, table)| table).collect())
}

/// The cell of a place in texels. The cast saturates.
fn cell(px: [f64; 2]) -> [i64; 2] {
    px.map(|value| value.floor() as i64)
}

/// The corners of a layout by place.
struct Corners<'a> {
    layout: &'a Mesh,
    locator: UvLocator,
    sides: [f64; 2],
    /// The UV coordinates in each cell of a texel's size, with a vertex at each.
    cells: HashMap<[i64; 2], Vec<(u32, u32)>>,
}

impl<'a> Corners<'a> {
    fn new(layout: &'a Mesh, size: Size) -> Self {
        let sides = [size.width, size.height].map(f64::from);
        let mut made =
            Self { layout, locator: UvLocator::new(layout), sides, cells: HashMap::new() };
        let mut is_known = vec![false; layout.uv().len()];
        for (face, uv_face) in layout.faces().iter().zip(layout.uv_faces()) {
            for (&vertex, &uv) in face.iter().zip(uv_face) {
                if !std::mem::replace(&mut is_known[uv as usize], true) {
                    let cell = cell(made.place(layout.uv()[uv as usize]));
                    let entries = made.cells.entry(cell).or_default();
                    // No real layout has more, and each mesh coordinate looks at all of them.
                    if entries.len() < MAX_PER_TEXEL {
                        entries.push((uv, vertex));
                    }
                }
            }
        }
        made
    }

    fn place(&self, uv: [f32; 2]) -> [f64; 2] {
        [0, 1].map(|k| f64::from(uv[k]) * self.sides[k])
    }

    /// The coordinates of the layout within [`SAME_PX`] of one, nearest first, with their vertices.
    fn near(&self, uv: [f32; 2]) -> Vec<(f64, u32, u32)> {
        let px = self.place(uv);
        let [x, y] = cell(px);
        let around = (-1..=1).flat_map(|j| (-1..=1).map(move |i| [i, j]));
        let cells =
            around.filter_map(|[i, j]| self.cells.get(&[x.saturating_add(i), y.saturating_add(j)]));
        let mut found: Vec<(f64, u32, u32)> = cells
            .flatten()
            .map(|&(uv, vertex)| {
                let at = self.place(self.layout.uv()[uv as usize]);
                ((at[0] - px[0]).hypot(at[1] - px[1]), uv, vertex)
            })
            .filter(|found| found.0 <= SAME_PX)
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found
    }

    /// The share of the layout's coordinates that a mesh has too.
    fn share_in(&self, mesh: &Mesh) -> f64 {
        let mut is_there = vec![false; self.layout.uv().len()];
        for &uv in mesh.uv() {
            for (_, uv, _) in self.near(uv) {
                is_there[uv as usize] = true;
            }
        }
        is_there.iter().filter(|is_there| **is_there).count() as f64 / is_there.len().max(1) as f64
    }

    /// Where the vertices of a mesh with this layout lie on the mesh of the vertices.
    fn points(&self, mesh: &Mesh) -> Vec<Option<SurfacePoint>> {
        let mut points = vec![None; mesh.positions().len()];
        for (face, uv_face) in mesh.faces().iter().zip(mesh.uv_faces()) {
            for (&vertex, &uv) in face.iter().zip(uv_face) {
                let point = &mut points[vertex as usize];
                *point = point.or_else(|| self.point(mesh.uv()[uv as usize]));
            }
        }
        points
    }

    fn point(&self, uv: [f32; 2]) -> Option<SurfacePoint> {
        if let Some(&(_, _, vertex)) = self.near(uv).first() {
            return Some(SurfacePoint { vertices: [vertex; 3], weights: [1.0, 0.0, 0.0] });
        }
        let reach = SAME_PX / self.sides[0].max(self.sides[1]);
        let found = self.locator.locate(uv.map(f64::from), reach)?;
        let vertices = self.layout.faces()[found.face as usize];
        Some(SurfacePoint { vertices, weights: found.weights })
    }
}
