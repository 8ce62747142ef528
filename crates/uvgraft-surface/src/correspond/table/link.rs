//! Links two meshes by a vertex table.
//!
//! Where every point is a vertex, the table is a vertex map and faces are matched. Otherwise the
//! vertices are placed on the other mesh, and the two surfaces are laid over each other exactly.

use glam::{DVec3, Vec3};

use super::{SurfacePoint, VertexTable};
use crate::correspond::surface::{SurfaceOptions, placed, share_of_area};
use crate::correspond::vertex_map::{OUTSIDE, link_faces};
use crate::mesh::Mesh;
use crate::pair::Pair;
use crate::piece::Piece;
use crate::surface::Surface;

/// Least share of the faces whose corners have points that must match for a table of vertices to be a
/// vertex map. Below, the meshes have other faces, and the table has the nearest vertices.
const ENOUGH: f64 = 0.5;

/// The mesh whose vertices the rows of a table are; they lie on the other one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum TableRows {
    /// The source's vertices, as points on the target.
    Source,
    /// The target's vertices, as points on the source.
    Target,
}

/// What linking by a table found.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct TableReport {
    /// The mesh whose vertices the table's rows are.
    pub rows: TableRows,
    /// Number of its vertices.
    pub vertices: usize,
    /// How many of them have a point on the other mesh.
    pub points: usize,
    /// Its faces that are not linked since a corner has no point.
    pub faces_without_points: usize,
    /// Whether all points are vertices, so that faces correspond as wholes.
    pub is_vertex_map: bool,
    /// The share of its area that has a counterpart.
    pub covered: f64,
}

/// Why a table does not link two meshes.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TableLinkError {
    /// It is not a table of these meshes.
    #[error(
        "the table must have {rows_wanted} rows with points on a mesh of {onto_wanted} vertices, got \
         {rows} rows on {onto}"
    )]
    Size {
        /// Number of rows.
        rows: usize,
        /// Number of vertices of the mesh whose vertices the rows are.
        rows_wanted: usize,
        /// Number of vertices that the points lie between.
        onto: usize,
        /// Number of vertices of the other mesh.
        onto_wanted: usize,
    },
    /// No face lies on the other mesh.
    #[error(
        "none of the faces lies on the other mesh where the table puts their corners; check that the \
         table belongs to these meshes"
    )]
    Nothing,
    /// Faces correspond, but none of them lies in the unit square of its texture.
    #[error("{OUTSIDE}")]
    Outside,
}

/// Links two meshes by a table.
///
/// - `rows`: the mesh whose vertices the table's rows are.
/// - `options`: of these, `reach` and `visibility` bound how far from the other mesh a face may be
///   between its corners, and how much it may turn away.
///
/// Polygons may be retriangulated where the table is a vertex map.
///
/// # Errors
/// [`TableLinkError`] for a table of other meshes, and if nothing corresponds.
pub fn link(
    mut source: Mesh,
    mut target: Mesh,
    table: &VertexTable,
    rows: TableRows,
    options: &SurfaceOptions,
) -> Result<(Pair, TableReport), TableLinkError> {
    let (mesh, onto) = match rows {
        TableRows::Source => (&mut source, &mut target),
        TableRows::Target => (&mut target, &mut source),
    };
    let (rows_wanted, onto_wanted) = (mesh.positions().len(), onto.positions().len());
    let points = table.points();
    if points.len() != rows_wanted || table.onto_vertices() != onto_wanted {
        let (rows, onto) = (points.len(), table.onto_vertices());
        return Err(TableLinkError::Size { rows, rows_wanted, onto, onto_wanted });
    }
    let by_vertices = table.vertex_map().and_then(|map| by_vertices(mesh, onto, &map));
    let is_vertex_map = by_vertices.is_some();
    let found = by_vertices.unwrap_or_else(|| {
        let place = |vertex: u32| points[vertex as usize].map(|point| position(&point, onto));
        let placed = placed(onto, mesh, place, options);
        Linked {
            pieces: placed.pieces,
            covered: placed.covered,
            faces_without_points: placed.faces_without_place,
        }
    });
    if found.pieces.is_empty() {
        return Err(TableLinkError::Nothing);
    }
    let report = TableReport {
        rows,
        vertices: rows_wanted,
        points: table.count(),
        faces_without_points: found.faces_without_points,
        is_vertex_map,
        covered: found.covered,
    };
    let mut pieces = found.pieces;
    if rows == TableRows::Source {
        pieces = pieces.into_iter().map(Piece::swapped).collect();
        pieces.sort_by_key(|piece| piece.target);
    }
    let pair = Pair::of_found(source, target, pieces).ok_or(TableLinkError::Outside)?;
    Ok((pair, report))
}

/// Pieces with the table's mesh as their target.
struct Linked {
    pieces: Vec<Piece>,
    covered: f64,
    faces_without_points: usize,
}

/// Matches faces by their vertices; `None` if most have no counterpart.
fn by_vertices(mesh: &mut Mesh, onto: &mut Mesh, map: &[i64]) -> Option<Linked> {
    let common = |vertex: u32| u32::try_from(map[vertex as usize]).unwrap_or(u32::MAX);
    let (mut fanned, mut fanned_onto) = (mesh.clone(), onto.clone());
    let pieces = link_faces(&mut fanned_onto, &mut fanned, |vertex| vertex, common);
    let has_points = |face: &&[u32; 3]| face.iter().all(|&vertex| common(vertex) != u32::MAX);
    let with_points = fanned.faces().iter().filter(has_points).count();
    let mut covered = vec![0.0; fanned.faces().len()];
    pieces.iter().for_each(|piece| covered[piece.target as usize] = 1.0);
    if pieces.is_empty() || covered.iter().sum::<f64>() < ENOUGH * with_points as f64 {
        return None;
    }
    let faces_without_points = fanned.faces().len() - with_points;
    let covered = share_of_area(&Surface::new(&fanned), &covered);
    (*mesh, *onto) = (fanned, fanned_onto);
    Some(Linked { pieces, covered, faces_without_points })
}

fn position(point: &SurfacePoint, onto: &Mesh) -> DVec3 {
    let at = |vertex: u32| Vec3::from(onto.positions()[vertex as usize]).as_dvec3();
    point.parts().map(|(vertex, weight)| at(vertex) * weight).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::piece::Extent;

    /// A square of `n * n` quads in the plane, slightly bent, with the layout of its outline.
    fn sheet(n: u32) -> Mesh {
        let count = n + 1;
        let uv: Vec<[f32; 2]> = (0..count * count)
            .map(|k| [k % count, k / count].map(|at| 0.1 + 0.8 * at as f32 / n as f32))
            .collect();
        let positions = uv.iter().map(|&[u, v]| [u, v, 0.05 * (3.0 * u).sin()]).collect();
        let mut faces = Vec::new();
        for k in (0..n * n).map(|k| k / n * count + k % n) {
            faces.extend([[k, k + 1, k + count + 1], [k, k + count + 1, k + count]]);
        }
        Mesh::from_triangles(positions, uv, &faces, &faces).unwrap()
    }

    /// Where each vertex of one sheet lies on another, by UV coordinates, which are the same place.
    fn table(of: &Mesh, onto: &Mesh, skip: u32) -> VertexTable {
        let locator = super::super::UvLocator::new(onto);
        let mut points = vec![None; of.positions().len()];
        for (vertex, point) in points.iter_mut().enumerate() {
            let uv = of.uv()[vertex].map(f64::from);
            let found = locator.locate(uv, 1e-3).unwrap();
            let vertices = onto.faces()[found.face as usize];
            *point = (vertex as u32 != skip)
                .then_some(SurfacePoint { vertices, weights: found.weights });
        }
        VertexTable::new(points, onto.positions().len()).unwrap()
    }

    /// Pieces put each UV coordinate at itself, and cover this share of the sheet's UV area.
    fn checked_area(pair: &Pair) -> f64 {
        let mut total = 0.0;
        for piece in pair.pieces() {
            let [target, source] = piece.uv(pair.target(), pair.source());
            for (a, b) in target.as_flattened().iter().zip(source.as_flattened()) {
                assert!((a - b).abs() < 2e-3, "{a} {b}");
            }
            total += crate::mesh::doubled_area(target) / 2.0;
        }
        total / 0.64
    }

    #[test]
    fn tables_of_either_mesh_link_what_they_place() {
        let (coarse, fine) = (sheet(4), sheet(9));
        for rows in [TableRows::Source, TableRows::Target] {
            let table = match rows {
                TableRows::Source => table(&coarse, &fine, u32::MAX),
                TableRows::Target => table(&fine, &coarse, u32::MAX),
            };
            let options = SurfaceOptions::default();
            let (pair, report) =
                link(coarse.clone(), fine.clone(), &table, rows, &options).unwrap();
            assert!(!report.is_vertex_map);
            assert_eq!((report.points, report.faces_without_points), (report.vertices, 0));
            assert!(report.covered > 0.999, "{report:?}");
            let area = checked_area(&pair);
            assert!((area - 1.0).abs() < 2e-3, "{rows:?} {area}");
        }
    }

    #[test]
    fn rows_without_points_leave_their_faces_out() {
        let (coarse, fine) = (sheet(4), sheet(9));
        // An inner vertex of the fine sheet with six faces.
        let table = table(&fine, &coarse, 44);
        let options = SurfaceOptions::default();
        let (pair, report) = link(coarse, fine, &table, TableRows::Target, &options).unwrap();
        assert_eq!((report.points, report.faces_without_points), (99, 6));
        assert!((checked_area(&pair) - (1.0 - 6.0 / 162.0)).abs() < 2e-3);
        assert!(
            pair.pieces()
                .all(|piece| { !pair.target().faces()[piece.target as usize].contains(&44) })
        );
    }

    #[test]
    fn tables_of_vertices_are_vertex_maps() {
        let sheet = sheet(4);
        let mut ids: Vec<u32> = (0..25).collect();
        fastrand::Rng::with_seed(5).shuffle(&mut ids);
        // `ids[vertex]` is where a vertex of the sheet is in the shuffled one.
        let mut positions = vec![[0.0; 3]; 25];
        (0..25).for_each(|vertex| positions[ids[vertex] as usize] = sheet.positions()[vertex]);
        let faces: Vec<[u32; 3]> =
            sheet.faces().iter().map(|face| face.map(|vertex| ids[vertex as usize])).collect();
        let shuffled =
            Mesh::from_triangles(positions, sheet.uv().to_vec(), &faces, sheet.uv_faces()).unwrap();
        let point =
            |&vertex: &u32| Some(SurfacePoint { vertices: [vertex; 3], weights: [1.0, 0.0, 0.0] });
        let table = VertexTable::new(ids.iter().map(point).collect(), 25).unwrap();
        let options = SurfaceOptions::default();
        for (source, target, rows) in
            [(&sheet, &shuffled, TableRows::Source), (&shuffled, &sheet, TableRows::Target)]
        {
            let (pair, report) =
                link(source.clone(), target.clone(), &table, rows, &options).unwrap();
            assert!(report.is_vertex_map && report.covered == 1.0, "{report:?}");
            assert_eq!(pair.piece_count(), 32);
            assert!(pair.pieces().all(|piece| matches!(piece.extent, Extent::Whole(_))));
            checked_area(&pair);
        }
    }

    #[test]
    fn nearest_vertices_of_another_mesh_are_laid_over_it() {
        let (coarse, fine) = (sheet(4), sheet(8));
        // Every vertex of the coarse sheet is one of the fine sheet, whose faces are smaller.
        let table = table(&coarse, &fine, u32::MAX);
        assert!(table.vertex_map().is_some());
        let options = SurfaceOptions::default();
        let (pair, report) = link(coarse, fine, &table, TableRows::Source, &options).unwrap();
        assert!(!report.is_vertex_map && report.covered > 0.999, "{report:?}");
        assert!((checked_area(&pair) - 1.0).abs() < 2e-3);
    }

    #[test]
    fn tables_of_other_meshes_are_refused() {
        let (coarse, fine) = (sheet(4), sheet(9));
        let table = table(&fine, &coarse, u32::MAX);
        let options = SurfaceOptions::default();
        let linked = |rows| link(coarse.clone(), fine.clone(), &table, rows, &options).map(|_| ());
        let wrong = TableLinkError::Size { rows: 100, rows_wanted: 25, onto: 25, onto_wanted: 100 };
        assert_eq!(linked(TableRows::Source), Err(wrong));
        // All vertices at one.
        let point = SurfacePoint { vertices: [7; 3], weights: [1.0, 0.0, 0.0] };
        let flat = VertexTable::new(vec![Some(point); 100], 25).unwrap();
        let linked = link(coarse.clone(), fine.clone(), &flat, TableRows::Target, &options);
        assert_eq!(linked.unwrap_err(), TableLinkError::Nothing);
    }
}
