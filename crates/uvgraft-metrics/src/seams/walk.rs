//! Straight walks over the surface, from an edge into one of its triangles and beyond.
//!
//! Triangles are unfolded into a plane one after the other, each attached at the edge through which
//! it was entered, so a walk is a straight line on the unfolded surface. Lengths of sides are
//! measured either on the surface or in texels.

use glam::{DVec3, Vec3};
use uvgraft::edges::{Edges, HalfEdge, NO_HALF_EDGE};
use uvgraft::mesh::Mesh;
use uvgraft::texture::Size;

/// Maximum number of triangles in a walk; only walks around a vertex of many slivers reach it.
const MAX_TRIANGLES: usize = 256;

/// The unit of distances.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum DistanceSpace {
    /// Texels of a texture of this size; walks end at UV seams.
    Texels(Size),
    /// Units of the mesh's positions; walks continue across UV seams.
    Surface,
}

/// Direction and length of a walk that starts at an edge.
#[derive(Debug, Clone, Copy)]
pub(super) struct Heading {
    /// Component along the edge's direction; `(along, across)` has unit length.
    pub along: f64,
    /// Component into the triangle; above 0.
    pub across: f64,
    /// Length of the walk.
    pub distance: f64,
}

/// The end of a walk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Arrival {
    /// The end point, in the texture's unit square.
    pub uv: [f64; 2],
    /// Whether the walk has its full length; if not, the surface ended.
    pub complete: bool,
    /// Whether it crossed a UV seam or the region boundary.
    pub crossed: bool,
}

/// A surface to walk on.
pub(super) struct Walker<'a> {
    mesh: &'a Mesh,
    edges: &'a Edges,
    kinds: &'a [HalfKind],
}

/// The class of a half-edge.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct HalfKind {
    pub is_uv_seam: bool,
    pub is_rim: bool,
}

/// A triangle in the plane: the edge through which it was entered runs from `(0, 0)` to
/// `(base, 0)`, and the third corner is at `apex`, with a positive second coordinate.
struct Flat {
    base: f64,
    apex: [f64; 2],
}

impl<'a> Walker<'a> {
    /// - `kinds`: `[3 * faces]`
    pub fn new(mesh: &'a Mesh, edges: &'a Edges, kinds: &'a [HalfKind]) -> Self {
        Self { mesh, edges, kinds }
    }

    /// Walks from a point on a half-edge into its triangle.
    ///
    /// - `at`: the point, from 0 at the start of the half-edge to 1 at its end.
    ///
    /// In each triangle the line is followed to the side through which it leaves. The direction is
    /// then expressed in the frame of the next triangle, whose base is that side: the component
    /// along the side changes sign if the two half-edges run in opposite directions, the outward
    /// component becomes the inward one.
    ///
    /// `None` if the triangle has no area.
    pub fn walk(
        &self,
        space: DistanceSpace,
        half: HalfEdge,
        at: f64,
        heading: Heading,
    ) -> Option<Arrival> {
        let mut half = half;
        let mut flat = self.flat(space, half)?;
        let mut from = [at * flat.base, 0.0];
        let mut direction = [heading.along, heading.across];
        let mut remaining = heading.distance;
        let mut crossed = false;
        for _ in 0..MAX_TRIANGLES {
            let (distance, exit) = flat.exit(from, direction);
            if remaining <= distance {
                let to = [from[0] + direction[0] * remaining, from[1] + direction[1] * remaining];
                return Some(Arrival { uv: self.uv(half, &flat, to), complete: true, crossed });
            }
            let to = [from[0] + direction[0] * distance, from[1] + direction[1] * distance];
            let ended = Arrival { uv: self.uv(half, &flat, to), complete: false, crossed };
            let out = half / 3 * 3 + (half + exit) % 3;
            let next = self.edges.opposite[out as usize];
            if next == NO_HALF_EDGE
                || (space != DistanceSpace::Surface && self.kinds[out as usize].is_uv_seam)
            {
                return Some(ended);
            }
            let kind = self.kinds[out as usize];
            crossed |= kind.is_uv_seam || kind.is_rim;
            let Some(next_flat) = self.flat(space, next) else { return Some(ended) };
            let [start, end] = flat.side(exit);
            let along = unit([end[0] - start[0], end[1] - start[1]]);
            let onward = direction[0] * along[0] + direction[1] * along[1];
            let outward = direction[0] * along[1] - direction[1] * along[0];
            let passed = ((to[0] - start[0]) * along[0] + (to[1] - start[1]) * along[1])
                .clamp(0.0, next_flat.base);
            let opposed = self.edges.ends(out)[0] != self.edges.ends(next)[0];
            (from, direction) = if opposed {
                ([next_flat.base - passed, 0.0], [-onward, outward])
            } else {
                ([passed, 0.0], [onward, outward])
            };
            remaining -= distance;
            (half, flat) = (next, next_flat);
        }
        let uv = self.uv(half, &flat, from);
        Some(Arrival { uv, complete: false, crossed })
    }

    /// A triangle laid into the plane, if it has an area.
    fn flat(&self, space: DistanceSpace, half: HalfEdge) -> Option<Flat> {
        let (face, corner) = (half as usize / 3, half as usize % 3);
        let at = |k: usize| {
            let corner = (corner + k) % 3;
            match space {
                DistanceSpace::Surface => {
                    let vertex = self.mesh.faces()[face][corner];
                    Vec3::from(self.mesh.positions()[vertex as usize]).as_dvec3()
                }
                DistanceSpace::Texels(size) => {
                    let [u, v] = self.mesh.uv()[self.mesh.uv_faces()[face][corner] as usize];
                    DVec3::new(
                        f64::from(u) * f64::from(size.width),
                        f64::from(v) * f64::from(size.height),
                        0.0,
                    )
                }
            }
        };
        let [a, b, c] = [at(0), at(1), at(2)];
        let (edge, side) = (b - a, c - a);
        let base = edge.length();
        let along = side.dot(edge) / base;
        let height = (side - edge * (along / base)).length();
        // With rounding, collinear corners are off the line by a small fraction of its length.
        let is_wide = height > (base + along.abs()) * 1e-12 && height > 0.0;
        (base > 0.0 && is_wide && (base + along + height).is_finite())
            .then_some(Flat { base, apex: [along, height] })
    }

    /// The texture coordinates of a point in a flat triangle.
    fn uv(&self, half: HalfEdge, flat: &Flat, at: [f64; 2]) -> [f64; 2] {
        let third = (at[1] / flat.apex[1]).clamp(0.0, 1.0);
        let second = ((at[0] - third * flat.apex[0]) / flat.base).clamp(0.0, 1.0 - third);
        let weights = [1.0 - second - third, second, third];
        let (face, corner) = (half as usize / 3, half as usize % 3);
        let corners = self.mesh.uv_triangle(face);
        let mut uv = [0.0; 2];
        for (k, weight) in weights.into_iter().enumerate() {
            let corner = corners[(corner + k) % 3];
            uv[0] += weight * f64::from(corner[0]);
            uv[1] += weight * f64::from(corner[1]);
        }
        uv
    }
}

impl Flat {
    /// The ends of side 0 (the base), 1 or 2, in order around the triangle.
    fn side(&self, side: u32) -> [[f64; 2]; 2] {
        let (start, end) = ([0.0, 0.0], [self.base, 0.0]);
        match side {
            0 => [start, end],
            1 => [end, self.apex],
            _ => [self.apex, start],
        }
    }

    /// Distance to the side through which a walk from the base leaves, and the index of that side.
    fn exit(&self, from: [f64; 2], direction: [f64; 2]) -> (f64, u32) {
        let distance = |side: u32| {
            let [start, end] = self.side(side);
            let normal = [end[1] - start[1], start[0] - end[0]];
            let speed = direction[0] * normal[0] + direction[1] * normal[1];
            let gap = (start[0] - from[0]) * normal[0] + (start[1] - from[1]) * normal[1];
            if speed > 0.0 { (gap / speed).max(0.0) } else { f64::INFINITY }
        };
        let [right, left] = [distance(1), distance(2)];
        if right <= left { (right, 1) } else { (left, 2) }
    }
}

fn unit(vector: [f64; 2]) -> [f64; 2] {
    let length = vector[0].hypot(vector[1]);
    vector.map(|value| value / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ACROSS: Heading = Heading { along: 0.0, across: 1.0, distance: 0.0 };

    /// A strip of three unit squares along x, bent up at a right angle after the first. In the
    /// texture the squares are 10, 20 and 30 of 100 texels wide, and the last one is elsewhere.
    fn strip() -> (Mesh, Vec<HalfKind>) {
        let positions = vec![
            [0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [1.0, 0.0, 1.0],
            [1.0, 1.0, 1.0],
            [1.0, 0.0, 2.0],
            [1.0, 1.0, 2.0],
        ];
        let uv = vec![
            [0.0, 0.0],
            [0.0, 0.1],
            [0.1, 0.0],
            [0.1, 0.1],
            [0.3, 0.0],
            [0.3, 0.1],
            [0.5, 0.5],
            [0.5, 0.6],
            [0.8, 0.5],
            [0.8, 0.6],
        ];
        let square = |k: u32| [[k, k + 2, k + 3], [k, k + 3, k + 1]];
        let faces = [square(0), square(2), square(4)].concat();
        let uv_faces = [square(0), square(2), square(6)].concat();
        let mesh = Mesh::from_triangles(positions, uv, &faces, &uv_faces).unwrap();
        let mut kinds = vec![HalfKind::default(); 18];
        // Between the second square (edge 1 of triangle 2) and the third (edge 2 of triangle 5).
        kinds[7].is_uv_seam = true;
        kinds[17].is_uv_seam = true;
        (mesh, kinds)
    }

    fn walk(
        space: DistanceSpace,
        half: HalfEdge,
        at: f64,
        heading: Heading,
    ) -> Option<([f64; 2], bool)> {
        let (mesh, kinds) = strip();
        let edges = Edges::new(&mesh);
        let arrival = Walker::new(&mesh, &edges, &kinds).walk(space, half, at, heading)?;
        assert_eq!(arrival.crossed, arrival.uv[0] > 0.5, "the third square is beyond the seam");
        // Rounded to six decimals.
        Some((arrival.uv.map(|value| (value * 1e6).round() / 1e6), arrival.complete))
    }

    /// From the far left edge (edge 2 of triangle 1, from (0, 1) to (0, 0)), a quarter of its
    /// length from its end.
    #[test]
    fn walks_on_the_surface_continue_over_bends_and_seams() {
        let to = |distance| {
            walk(DistanceSpace::Surface, 5, 0.75, Heading { distance, ..ACROSS }).unwrap()
        };
        assert_eq!(to(0.0), ([0.0, 0.025], true));
        assert_eq!(to(0.5), ([0.05, 0.025], true));
        assert_eq!(to(1.5), ([0.2, 0.025], true));
        assert_eq!(to(2.5), ([0.65, 0.525], true));
        assert_eq!(to(3.0), ([0.8, 0.525], true));
        assert_eq!(to(3.5), ([0.8, 0.525], false));
    }

    #[test]
    fn walks_in_texels_stay_in_the_island() {
        let space = DistanceSpace::Texels(Size::square(100));
        let to = |distance| walk(space, 5, 0.75, Heading { distance, ..ACROSS }).unwrap();
        assert_eq!(to(5.0), ([0.05, 0.025], true));
        assert_eq!(to(25.0), ([0.25, 0.025], true));
        assert_eq!(to(35.0), ([0.3, 0.025], false));
    }

    #[test]
    fn aslant() {
        // 3 along, against the edge's upward direction, for every 4 across.
        let heading = Heading { along: -0.6, across: 0.8, distance: 0.5 };
        assert_eq!(walk(DistanceSpace::Surface, 5, 0.75, heading), Some(([0.04, 0.055], true)));
        // Leaves over the side.
        let heading = Heading { distance: 5.0, ..heading };
        assert_eq!(walk(DistanceSpace::Surface, 5, 0.75, heading), Some(([0.1, 0.1], false)));
    }

    #[test]
    fn triangles_without_area_cannot_be_walked_on() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        let uv = vec![[0.1, 0.3], [0.2, 0.4], [0.1, 0.5]];
        let mesh = Mesh::from_triangles(positions, uv, &[[0, 1, 2]], &[[0, 1, 2]]).unwrap();
        let edges = Edges::new(&mesh);
        let kinds = [HalfKind::default(); 3];
        let walker = Walker::new(&mesh, &edges, &kinds);
        let heading = Heading { distance: 1.0, ..ACROSS };
        assert_eq!(walker.walk(DistanceSpace::Surface, 0, 0.5, heading), None);
        assert!(walker.walk(DistanceSpace::Texels(Size::square(10)), 0, 0.5, heading).is_some());
    }
}
