//! Smooth fields over a mesh: displacements that bend it so that some places come to given
//! positions, or colours that spread from where they are known.
//!
//! The equations are those of surface registration; see `correspond/surface/equations.rs`.

use glam::DVec3;

use crate::correspond::surface::equations::{Anchor, Equations, Stiffness};
use crate::correspond::surface::shape::Shape;
use crate::mesh::Mesh;
use crate::surface::Surface;
use crate::surface_index::SurfacePoint;

/// How smooth a field is, as lengths in the mesh's unit: it follows data over longer distances and
/// smooths what is smaller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Smoothness {
    /// Resistance to changes of the field's slope.
    pub bending: f64,
    /// Resistance to the slope itself: far from data the field becomes constant.
    pub membrane: f64,
}

/// A value that the field should have at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldValue {
    /// The place.
    pub at: SurfacePoint,
    /// The three values there.
    pub value: [f64; 3],
    /// How much it counts, as an area in the square of the mesh's unit.
    pub weight: f64,
}

/// A mesh prepared for smooth fields. Vertices that exporters split along UV seams have one value.
#[derive(Debug)]
pub struct SurfaceField {
    equations: Equations,
    triangles: Vec<[u32; 3]>,
    /// Each vertex's point; vertices in no triangle have none.
    point_of_vertex: Vec<Option<u32>>,
    scale: f64,
}

impl SurfaceField {
    /// Prepares a mesh.
    ///
    /// - `scale`: a typical length in the mesh's unit, such as the distance between the eyes; it
    ///   only keeps numbers in range.
    pub fn new(mesh: &Mesh, scale: f64) -> Self {
        let surface = Surface::new(mesh);
        let shape = Shape::new(&surface, |point| point / scale);
        let mut point_of_vertex = vec![None; mesh.positions().len()];
        for (face, points) in mesh.faces().iter().zip(&shape.triangles) {
            for k in 0..3 {
                point_of_vertex[face[k] as usize] = Some(points[k]);
            }
        }
        let equations = Equations::new(&shape);
        Self { equations, triangles: shape.triangles, point_of_vertex, scale }
    }

    /// The area around each vertex, in the square of the mesh's unit.
    pub fn areas(&self) -> Vec<f64> {
        let area = |point: u32| self.equations.masses()[point as usize] * self.scale * self.scale;
        self.point_of_vertex.iter().map(|point| point.map_or(0.0, area)).collect()
    }

    /// The smooth field that comes closest to the values.
    ///
    /// - `at_vertices`: `[vertices]`, weight and value of each; may be empty. A weight of
    ///   [`SurfaceField::areas`] is that of a place known as well as the field is smooth.
    /// - `at_places`: values between vertices.
    ///
    /// Returns `[vertices]` values; far from all data they tend to 0. `None` if the equations
    /// cannot be factorised, as with positions that overflow.
    pub fn solve(
        &self,
        smoothness: Smoothness,
        at_vertices: &[(f64, [f64; 3])],
        at_places: &[FieldValue],
    ) -> Option<Vec<[f64; 3]>> {
        let per_area = 1.0 / (self.scale * self.scale);
        let stiffness = Stiffness {
            bending: smoothness.bending / self.scale,
            membrane: smoothness.membrane / self.scale,
        };
        let points = self.equations.masses().len();
        let (mut weights, mut sums) = (vec![0.0; points], vec![DVec3::ZERO; points]);
        for (&(weight, value), point) in at_vertices.iter().zip(&self.point_of_vertex) {
            if let Some(point) = point.map(|point| point as usize) {
                weights[point] += weight * per_area;
                sums[point] += DVec3::from(value) * (weight * per_area);
            }
        }
        let mean = |(&weight, sum): (&f64, DVec3)| if weight > 0.0 { sum / weight } else { sum };
        let targets: Vec<DVec3> = weights.iter().zip(sums).map(mean).collect();
        let anchors: Vec<Anchor> = at_places
            .iter()
            .map(|place| {
                // An anchor's weight is its weights' square.
                let root = (place.weight * per_area).sqrt();
                Anchor {
                    points: self.triangles[place.at.face as usize],
                    weights: place.at.weights.map(|weight| weight * root),
                    displacement: DVec3::from(place.value) * root,
                }
            })
            .collect();
        let solution = self.equations.solve(stiffness, &weights, &targets, &anchors)?;
        let value = |point: u32| solution[point as usize].to_array();
        Some(self.point_of_vertex.iter().map(|point| point.map_or([0.0; 3], value)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of `side` by `side` cells with edges of 1 cm.
    fn sheet(side: u32) -> Mesh {
        let at = |index: u32| [index % (side + 1), index / (side + 1)];
        let points = (side + 1) * (side + 1);
        let positions = (0..points).map(|i| [0.01 * at(i)[0] as f32, 0.01 * at(i)[1] as f32, 0.0]);
        let uv = (0..points).map(|i| at(i).map(|k| k as f32 / side as f32));
        let faces: Vec<[u32; 3]> = (0..side * side)
            .flat_map(|cell| {
                let a = cell / side * (side + 1) + cell % side;
                let (b, c, d) = (a + 1, a + side + 2, a + side + 1);
                [[a, b, c], [a, c, d]]
            })
            .collect();
        Mesh::from_triangles(positions.collect(), uv.collect(), &faces, &faces).unwrap()
    }

    fn corner(mesh: &Mesh, vertex: u32) -> SurfacePoint {
        let face = mesh.faces().iter().position(|face| face.contains(&vertex)).unwrap();
        let weights = mesh.faces()[face].map(|at| if at == vertex { 1.0 } else { 0.0 });
        SurfacePoint { face: face as u32, weights }
    }

    #[test]
    fn values_known_at_corners_of_a_sheet_spread_smoothly() {
        let mesh = sheet(10);
        let known = [(0, 0.0), (10, 1.0), (110, 0.0), (120, 1.0)];
        let places = known.map(|(vertex, value)| FieldValue {
            at: corner(&mesh, vertex),
            value: [value, 2.0 * value, -value],
            weight: 1e3,
        });
        let smooth = Smoothness { bending: 0.2, membrane: 0.0 };
        let field = SurfaceField::new(&mesh, 0.1).solve(smooth, &[], &places).unwrap();
        assert!((field[60][0] - 0.5).abs() < 1e-3 && (field[10][1] - 2.0).abs() < 0.01);
        for (position, value) in mesh.positions().iter().zip(field) {
            let wanted = f64::from(position[0]) * 10.0;
            // Nearly linear: along the edges of the sheet the discrete Laplacian is not exact.
            for (found, factor) in value.into_iter().zip([1.0, 2.0, -1.0]) {
                assert!((found - factor * wanted).abs() < 0.3, "{position:?}: {found} {wanted}");
            }
        }
    }

    #[test]
    fn vertices_keep_their_own_values_where_their_weight_is_large() {
        let mesh = sheet(6);
        let field = SurfaceField::new(&mesh, 0.1);
        let areas = field.areas();
        let total: f64 = areas.iter().sum();
        assert!((total - 0.0036).abs() < 0.2 * 0.0036, "{total}");
        let at: Vec<(f64, [f64; 3])> = areas
            .iter()
            .enumerate()
            .map(|(vertex, &area)| (1e6 * area, [vertex as f64, 0.0, 1.0]))
            .collect();
        let smooth = Smoothness { bending: 0.01, membrane: 0.01 };
        let solved = field.solve(smooth, &at, &[]).unwrap();
        for (vertex, value) in solved.into_iter().enumerate() {
            assert!((value[0] - vertex as f64).abs() < 0.01 && (value[2] - 1.0).abs() < 0.01);
        }
    }
}
