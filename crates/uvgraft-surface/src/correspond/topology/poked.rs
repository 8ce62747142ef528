//! Polygons that have an added centre vertex in one mesh, as modelling programs "poke" faces.
//!
//! Without its centre, such a fan of triangles is the polygon that it was. The centre of a quad
//! corresponds to the middle of the diagonal along which the other mesh splits the quad, so that each
//! triangle of the fan is a part of one triangle there.

use std::collections::HashMap;

use super::net::NONE;
use crate::mesh::Mesh;
use crate::piece::{Piece, Weights};

/// Corners of the polygons that are recognised.
const CORNERS: std::ops::RangeInclusive<usize> = 3..=4;

/// Rings without added centres: fans of three or four triangles around a point are joined.
///
/// `None` if there are few such fans: points of this valence are then ordinary ones.
pub(super) fn without_centres(rings: &[Vec<u32>]) -> Option<Vec<Vec<u32>>> {
    /// Least share of rings in fans. Origin not recorded.
    const ENOUGH: f64 = 0.25;
    let mut at_point: Vec<(u32, u32)> = Vec::with_capacity(4 * rings.len());
    for (index, ring) in (0..).zip(rings) {
        at_point.extend(ring.iter().map(|&point| (point, index)));
    }
    at_point.sort_unstable();
    let mut fans = Vec::new();
    for group in at_point.chunk_by(|one, other| one.0 == other.0) {
        let is_fan = CORNERS.contains(&group.len())
            && group.iter().all(|&(_, ring)| rings[ring as usize].len() == 3);
        let around = |&(point, ring): &(u32, u32)| edge_across(&rings[ring as usize], point);
        let edges = || group.iter().map(around).collect::<Option<Vec<[u32; 2]>>>();
        if let Some(ring) = is_fan.then(edges).flatten().and_then(|edges| cycle(&edges)) {
            fans.push((group, ring));
        }
    }
    // Centres have the fewest triangles; the corners around them have two for each polygon.
    fans.sort_by_key(|(group, _)| group.len());
    let mut is_joined = vec![false; rings.len()];
    let mut merged = Vec::new();
    for (group, ring) in fans {
        if group.iter().all(|&(_, ring)| !is_joined[ring as usize]) {
            group.iter().for_each(|&(_, ring)| is_joined[ring as usize] = true);
            merged.push(ring);
        }
    }
    let joined = is_joined.iter().filter(|is_joined| **is_joined).count();
    if (joined as f64) < ENOUGH * rings.len() as f64 || joined == 0 {
        return None;
    }
    let left = rings.iter().zip(is_joined).filter(|(_, is_joined)| !is_joined);
    merged.extend(left.map(|(ring, _)| ring.clone()));
    Some(merged)
}

/// The side of a triangle that is opposite to a point.
fn edge_across(ring: &[u32], point: u32) -> Option<[u32; 2]> {
    let k = ring.iter().position(|&at| at == point)?;
    Some([ring[(k + 1) % 3], ring[(k + 2) % 3]])
}

/// The closed ring that edges make up, in their order; `None` if they don't.
fn cycle(edges: &[[u32; 2]]) -> Option<Vec<u32>> {
    let mut ring = vec![edges[0][0]];
    let mut at = edges[0][1];
    while at != ring[0] {
        if ring.len() == edges.len() || ring.contains(&at) {
            return None;
        }
        ring.push(at);
        at = edges.iter().find(|edge| edge[0] == at)?[1];
    }
    (ring.len() == edges.len()).then_some(ring)
}

/// Links the triangles around added centres with the triangles of the polygons in the other mesh.
/// Returns pieces whose target is in `poked`, and the number of polygons.
///
/// - `poked_point`, `whole_point`: the common point of each vertex, or [`NONE`].
pub(super) fn pieces(
    poked: &Mesh,
    whole: &Mesh,
    poked_point: impl Fn(u32) -> u32,
    whole_point: impl Fn(u32) -> u32,
) -> (Vec<Piece>, usize) {
    let centres = fans(poked, &poked_point);
    let triangles =
        if centres.is_empty() { Triangles::default() } else { Triangles::new(whole, whole_point) };
    let (mut found, mut polygons) = (Vec::new(), 0);
    for fan in centres {
        let edges: Vec<[u32; 2]> = fan.iter().map(|side| side.edge).collect();
        let Some(polygon) = cycle(&edges).and_then(|ring| triangles.polygon(&ring)) else {
            continue;
        };
        let parts = fan.iter().filter_map(|side| side.piece(&polygon));
        let before = found.len();
        found.extend(parts);
        polygons += usize::from(found.len() > before);
    }
    (found, polygons)
}

/// A triangle at an added centre.
struct Side {
    face: u32,
    /// The corner of the face that is the centre.
    centre: usize,
    /// The points of the other two corners, in the order of the face.
    edge: [u32; 2],
}

/// The triangles around each vertex without a point whose other corners have points.
fn fans(mesh: &Mesh, point: impl Fn(u32) -> u32) -> Vec<Vec<Side>> {
    let mut sides: Vec<(u32, Side)> = Vec::new();
    for (face, corners) in (0..).zip(mesh.faces()) {
        let points = corners.map(&point);
        for centre in 0..3 {
            let edge = [points[(centre + 1) % 3], points[(centre + 2) % 3]];
            if points[centre] == NONE && !edge.contains(&NONE) {
                sides.push((corners[centre], Side { face, centre, edge }));
            }
        }
    }
    sides.sort_by_key(|(vertex, _)| *vertex);
    let mut fans: Vec<(u32, Vec<Side>)> = Vec::new();
    for (vertex, side) in sides {
        match fans.last_mut() {
            Some((last, fan)) if *last == vertex => fan.push(side),
            _ => fans.push((vertex, vec![side])),
        }
    }
    fans.into_iter().map(|(_, fan)| fan).filter(|fan| CORNERS.contains(&fan.len())).collect()
}

/// A polygon of the other mesh.
struct Polygon {
    /// Its triangles, with the points of their corners.
    triangles: Vec<(u32, [u32; 3])>,
    /// The points between which the centre is: all of a triangle, or the ends of a quad's diagonal.
    middle: Vec<u32>,
}

/// Triangles by the directed edges between points.
#[derive(Default)]
struct Triangles {
    by_edge: HashMap<[u32; 2], (u32, [u32; 3])>,
}

impl Triangles {
    fn new(mesh: &Mesh, point: impl Fn(u32) -> u32) -> Self {
        let mut by_edge = HashMap::new();
        for (face, corners) in (0..).zip(mesh.faces()) {
            let points = corners.map(&point);
            if !points.contains(&NONE) {
                for k in 0..3 {
                    by_edge.insert([points[k], points[(k + 1) % 3]], (face, points));
                }
            }
        }
        Self { by_edge }
    }

    /// The triangle at a directed edge, and the point across.
    fn at(&self, edge: [u32; 2]) -> Option<((u32, [u32; 3]), u32)> {
        let found = *self.by_edge.get(&edge)?;
        let across = found.1.into_iter().find(|point| !edge.contains(point))?;
        Some((found, across))
    }

    /// The triangles that make up a ring, wound either way.
    fn polygon(&self, ring: &[u32]) -> Option<Polygon> {
        let reversed: Vec<u32> = ring.iter().rev().copied().collect();
        self.wound_alike(ring).or_else(|| self.wound_alike(&reversed))
    }

    fn wound_alike(&self, ring: &[u32]) -> Option<Polygon> {
        let (first, across) = self.at([ring[0], ring[1]])?;
        if ring.len() == 3 {
            let middle = ring.to_vec();
            return (across == ring[2]).then(|| Polygon { triangles: vec![first], middle });
        }
        let (edge, middle) = match across {
            at if at == ring[2] => ([ring[2], ring[3]], [ring[0], ring[2]]),
            at if at == ring[3] => ([ring[1], ring[2]], [ring[1], ring[3]]),
            _ => return None,
        };
        let (second, _) = self.at(edge).filter(|(_, across)| middle.contains(across))?;
        Some(Polygon { triangles: vec![first, second], middle: middle.to_vec() })
    }
}

impl Side {
    /// The part of the polygon's triangle at the side's edge that corresponds to it.
    fn piece(&self, polygon: &Polygon) -> Option<Piece> {
        let has_edge = |points: &[u32; 3]| self.edge.iter().all(|point| points.contains(point));
        let &(face, points) = polygon.triangles.iter().find(|(_, points)| has_edge(points))?;
        let share = 1.0 / polygon.middle.len() as f64;
        let middle: Weights =
            points.map(|point| if polygon.middle.contains(&point) { share } else { 0.0 });
        let [a, b] = self.edge.map(|edge| points.map(|point| f64::from(u8::from(point == edge))));
        let own = |k: usize| {
            let mut weights = [0.0; 3];
            weights[(self.centre + k) % 3] = 1.0;
            weights
        };
        Some(Piece::part((self.face, [own(1), own(2), own(0)]), (face, [a, b, middle])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fans_become_the_polygons_that_they_were() {
        // A quad with a centre, and a triangle with one beside it.
        let fan = |ring: &[u32], centre: u32| -> Vec<Vec<u32>> {
            (0..ring.len()).map(|k| vec![centre, ring[k], ring[(k + 1) % ring.len()]]).collect()
        };
        let mut rings = fan(&[0, 1, 2, 3], 4);
        rings.extend(fan(&[1, 5, 2], 6));
        rings.push(vec![0, 3, 7]);
        let mut merged = without_centres(&rings).unwrap();
        for ring in &mut merged {
            let least = ring.iter().enumerate().min_by_key(|(_, point)| **point).unwrap().0;
            ring.rotate_left(least);
        }
        merged.sort();
        assert_eq!(merged, [vec![0, 1, 2, 3], vec![0, 3, 7], vec![1, 5, 2]]);
        // An open fan is none.
        assert_eq!(without_centres(&fan(&[0, 1, 2, 3], 4)[..3]), None);
        assert_eq!(without_centres(&[]), None);
    }

    #[test]
    fn a_centre_is_in_the_middle_of_the_other_meshs_diagonal() {
        let mesh = |faces: &[[u32; 3]]| {
            let positions = vec![[0.0; 3]; 5];
            Mesh::from_triangles(positions, vec![[0.5; 2]; 5], faces, faces).unwrap()
        };
        let poked = mesh(&[[4, 0, 1], [1, 2, 4], [3, 4, 2], [4, 3, 0]]);
        let point = |vertex: u32| if vertex == 4 { NONE } else { vertex };
        for whole in [[[0, 1, 2], [0, 2, 3]], [[3, 0, 1], [2, 3, 1]], [[2, 1, 0], [3, 2, 0]]] {
            let whole = mesh(&whole);
            let (found, polygons) = pieces(&poked, &whole, point, point);
            assert_eq!((found.len(), polygons), (4, 1));
            // With the corners of a unit square as coordinates, each piece is the same on both sides.
            let at = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.5]];
            for piece in found {
                let crate::piece::Extent::Part { target, source } = piece.extent else { panic!() };
                let corners =
                    |mesh: &Mesh, face: u32| mesh.faces()[face as usize].map(|v| at[v as usize]);
                for k in 0..3 {
                    let [a, b] = [
                        crate::piece::mixed(&corners(&poked, piece.target), target[k]),
                        crate::piece::mixed(&corners(&whole, piece.source), source[k]),
                    ];
                    assert_eq!(a, b);
                }
            }
        }
    }
}
