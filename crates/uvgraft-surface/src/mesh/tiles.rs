//! UV coordinates outside the unit square: UDIM tiles, and moving faces into the unit square.

use std::collections::{BTreeMap, HashMap};

use super::{MARGIN, Mesh, MeshPart};
use crate::tile::Tile;

/// The faces of a layout in one UV tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct TileFaces {
    /// Column and row of the tile, upwards from the unit square, which is `[0, 0]`.
    pub tile: [i32; 2],
    /// Its UDIM number, `None` if it has none: those are from 0 to 9 across and from 0 upwards.
    pub udim: Option<u32>,
    /// Number of triangles whose UV centroid lies in the tile.
    pub faces: usize,
}

/// Where UV coordinates move to: `uv * scale + offset`, in each direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Placement {
    pub scale: [f64; 2],
    pub offset: [f64; 2],
}

impl Placement {
    /// Moves a tile into the unit square.
    pub fn of_tile(tile: Tile) -> Self {
        // `v` grows downwards, rows of tiles upwards.
        Self { scale: [1.0; 2], offset: [-f64::from(tile.column()), f64::from(tile.row())] }
    }

    fn apply(&self, uv: [f32; 2]) -> [f32; 2] {
        [0, 1].map(|k| (f64::from(uv[k]) * self.scale[k] + self.offset[k]) as f32)
    }
}

/// The integer coordinates of the top left of the cell of the UV grid in which all of some UV
/// coordinates lie, within a thousandth; `None` if there is no such cell.
fn cell(uv: &[[f32; 2]]) -> Option<[f64; 2]> {
    let cell = [0, 1].map(|k| {
        let sum: f64 = uv.iter().map(|uv| f64::from(uv[k])).sum();
        (sum / uv.len() as f64).floor()
    });
    let margin = f64::from(MARGIN);
    let is_within = |uv: &[f32; 2]| {
        (0..2).all(|k| (-margin..=1.0 + margin).contains(&(f64::from(uv[k]) - cell[k])))
    };
    uv.iter().all(is_within).then_some(cell)
}

impl Mesh {
    /// The UDIM tile in which a triangle lies wholly, within a thousandth; `None` if it crosses the
    /// border of a tile, or lies where there are none.
    pub fn tile(&self, face: usize) -> Option<Tile> {
        if !self.is_outside(face) {
            return Some(Tile::FIRST);
        }
        let [column, row_down] = cell(&self.uv_triangle(face))?;
        // The casts saturate.
        Tile::at(column as i32, -row_down as i32)
    }

    /// The UV tiles that faces lie in, by their centroids, in ascending order from row to row.
    pub fn tiles(&self) -> Vec<TileFaces> {
        let mut counts: BTreeMap<[i32; 2], usize> = BTreeMap::new();
        for face in 0..self.faces().len() {
            let [a, b, c] = self.uv_triangle(face).map(|uv| uv.map(f64::from));
            let [u, v] = [0, 1].map(|k| (a[k] + b[k] + c[k]) / 3.0);
            // Rows are counted upwards, as in UDIM numbers, and `v` grows downwards. The cast saturates.
            let [column, row] = [u.floor() as i32, (1.0 - v).floor() as i32];
            *counts.entry([row, column]).or_default() += 1;
        }
        let tile = |([row, column], faces): ([i32; 2], usize)| {
            let is_numbered = (0..10).contains(&column) && (0..900).contains(&row);
            let udim = is_numbered.then(|| (1001 + column + 10 * row) as u32);
            TileFaces { tile: [column, row], udim, faces }
        };
        counts.into_iter().map(tile).collect()
    }

    /// The mesh with polygons moved by whole units into the unit square, for textures that repeat. A
    /// polygon that crosses the border between two repetitions stays where it is.
    #[must_use]
    pub fn repeated(&self) -> Self {
        let (mut moved, mut indices) = (self.clone(), HashMap::new());
        for polygon in 0..self.polygon_count() {
            let uv: Vec<[f32; 2]> = (self.polygon_corners(polygon).iter())
                .map(|corner| self.uv[corner.uv as usize])
                .collect();
            let Some(cell) = cell(&uv).filter(|cell| *cell != [0.0; 2]) else { continue };
            let is_inside = uv.as_flattened().iter().all(super::is_inside);
            if is_inside {
                continue;
            }
            let placement = Placement { scale: [1.0; 2], offset: cell.map(|at| -at) };
            for face in self.polygon(polygon) {
                for corner in &mut moved.uv_faces[face] {
                    let key = (*corner, cell.map(f64::to_bits));
                    *corner = *indices.entry(key).or_insert_with(|| {
                        moved.uv.push(placement.apply(self.uv[*corner as usize]));
                        moved.uv.len() as u32 - 1
                    });
                }
            }
        }
        moved
    }

    /// The mesh with all UV coordinates clamped to the unit square, for textures whose edge texels
    /// continue beyond it.
    #[must_use]
    pub fn clamped(mut self) -> Self {
        self.uv.as_flattened_mut().iter_mut().for_each(|value| *value = value.clamp(0.0, 1.0));
        self
    }

    /// The mesh as triangles, those of some tiles moved; all others lie left of the unit square, where
    /// nothing reaches them. Faces and vertices keep their indices, and parts their triangles.
    pub(crate) fn placed(&self, place: impl Fn(Tile) -> Option<Placement>) -> Self {
        let rightmost = self.uv.iter().map(|uv| f64::from(uv[0])).fold(0.0, f64::max);
        let (mut uv, mut indices) = (Vec::with_capacity(self.uv.len()), HashMap::new());
        let mut placed = |corner: u32, tile: Option<(Tile, Placement)>| {
            *indices.entry((corner, tile.map(|(tile, _)| tile))).or_insert_with(|| {
                let [u, v] = self.uv[corner as usize];
                uv.push(match tile {
                    Some((_, placement)) => placement.apply([u, v]),
                    // The difference is at most 0 exactly, however large the coordinates are.
                    None => [(f64::from(u) - rightmost - 1.0) as f32, v],
                });
                uv.len() as u32 - 1
            })
        };
        let uv_faces = (0..self.faces.len())
            .map(|face| {
                let tile = self.tile(face).and_then(|tile| Some((tile, place(tile)?)));
                self.uv_faces[face].map(|corner| placed(corner, tile))
            })
            .collect();
        let start = |polygon: u32| self.polygon_starts.get(polygon as usize).copied();
        let end = self.faces.len() as u32;
        let of_part = |part: &MeshPart| {
            let [first, last] =
                [part.polygons.start, part.polygons.end].map(|at| start(at).unwrap_or(end));
            MeshPart { polygons: first..last, ..part.clone() }
        };
        Self {
            positions: self.positions.clone(),
            uv,
            faces: self.faces.clone(),
            uv_faces,
            polygon_starts: (0..=end).collect(),
            parts: self.parts.iter().map(of_part).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Corner;

    /// Triangles with their lowest corner at these places, half as large as a tile.
    fn mesh(places: &[[f32; 2]]) -> Mesh {
        let uv: Vec<[f32; 2]> =
            places.iter().flat_map(|&[u, v]| [[u, v], [u + 0.5, v], [u, v + 0.5]]).collect();
        let positions = uv.iter().map(|&[x, y]| [x, y, 0.0]).collect();
        let faces: Vec<[u32; 3]> =
            (0..places.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        Mesh::from_triangles(positions, uv, &faces, &faces).unwrap()
    }

    #[test]
    fn faces_lie_in_tiles() {
        let mesh = mesh(&[
            [0.1, 0.1],
            [2.0, 0.5],
            [0.25, -0.5],
            [0.6, 0.2],
            [-0.8, 0.2],
            [0.2, 1.2],
            [10.1, 0.1],
            [3e9, 0.0],
            [1.5005, 0.0],
        ]);
        let tiles: Vec<Option<u16>> =
            (0..9).map(|face| mesh.tile(face).map(Tile::number)).collect();
        let none = None;
        assert_eq!(
            tiles,
            [Some(1001), Some(1003), Some(1011), none, none, none, none, none, Some(1002)]
        );
    }

    #[test]
    fn repeated_polygons_move_as_a_whole() {
        let mesh = mesh(&[[0.25, 0.25], [2.25, -1.75], [0.75, 0.0], [-0.75, 0.25]]);
        let moved = mesh.repeated();
        let at = |face| moved.uv_triangle(face)[0];
        assert_eq!([at(0), at(1), at(2), at(3)], [[0.25; 2], [0.25; 2], [0.75, 0.0], [0.25; 2]]);
        let outside: Vec<bool> = (0..4).map(|face| moved.is_outside(face)).collect();
        assert_eq!(outside, [false, false, true, false]);
        // Corners that faces of two repetitions share are split.
        let uv = vec![[0.5, 0.0], [1.0, 0.0], [1.0, 1.0], [1.5, 0.0]];
        let positions = vec![[0.0; 3]; 4];
        let faces = [[0, 1, 2], [1, 3, 2]];
        let sheet = Mesh::from_triangles(positions, uv, &faces, &faces).unwrap().repeated();
        assert_eq!(sheet.uv_triangle(0), [[0.5, 0.0], [1.0, 0.0], [1.0, 1.0]]);
        assert_eq!(sheet.uv_triangle(1), [[0.0, 0.0], [0.5, 0.0], [0.0, 1.0]]);
        assert_eq!(sheet.faces(), faces);
    }

    #[test]
    fn clamped_coordinates_are_those_of_the_edge() {
        let mesh = mesh(&[[0.75, -0.25]]).clamped();
        assert_eq!(mesh.uv_triangle(0), [[0.75, 0.0], [1.0, 0.0], [0.75, 0.25]]);
    }

    #[test]
    fn faces_without_a_place_are_out_of_reach() {
        let mesh = mesh(&[[2.25, -0.75], [0.25, 0.25], [1e30, 0.0]]);
        let tile = Tile::at(2, 1).unwrap();
        let placed = mesh.placed(|found| (found == tile).then(|| Placement::of_tile(tile)));
        assert_eq!(placed.uv_triangle(0), [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75]]);
        for face in [1, 2] {
            assert!(placed.uv_triangle(face).iter().all(|uv| uv[0] <= -1.0), "{face}");
            assert_eq!(placed.tile(face), None);
        }
    }

    #[test]
    fn parts_keep_their_triangles() {
        let corners: Vec<Corner> =
            [0, 1, 3, 2, 1, 3, 2].map(|k| Corner { vertex: k, uv: k }).to_vec();
        let uv = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
        let part = |name: &str, polygons| MeshPart {
            object: name.to_owned(),
            polygons,
            ..MeshPart::default()
        };
        let mesh = Mesh::from_polygons(vec![[0.0; 3]; 4], uv, &corners, &[4, 3])
            .unwrap()
            .with_parts(vec![part("a", 0..1), part("b", 1..2)]);
        let placed = mesh.placed(|tile| Some(Placement::of_tile(tile)));
        let ranges: Vec<_> = placed.parts().iter().map(|part| part.polygons.clone()).collect();
        assert_eq!(ranges, [0..2, 2..3]);
        assert_eq!(placed.faces(), mesh.faces());
        assert_eq!(placed.uv_triangle(1), mesh.uv_triangle(1));
    }
}
