//! A mesh's connectivity: rings of points and the half-edges between them.

use std::cmp::Reverse;

use glam::DVec3;

use crate::mesh::Mesh;
use crate::surface::Surface;

/// Stands for the index of something that does not exist.
pub(super) const NONE: u32 = u32::MAX;

/// Polygons over welded points. Half-edge `h` runs from `points[h]` to the next point of its ring.
#[derive(Debug, Clone)]
pub(super) struct Net {
    /// `rings + 1` offsets into `points`.
    pub starts: Vec<u32>,
    /// The points of all rings, one after the other.
    pub points: Vec<u32>,
    /// The ring of each half-edge.
    pub ring_of: Vec<u32>,
    /// The half-edge on the other side, or [`NONE`] at a border and where more than two rings or
    /// windings of both kinds meet.
    pub twin: Vec<u32>,
    /// The number of rings at each point.
    pub valence: Vec<u32>,
}

impl Net {
    pub fn new(rings: &[Vec<u32>], points: usize) -> Self {
        let mut starts = vec![0];
        let mut flat = Vec::new();
        let mut ring_of = Vec::new();
        for (ring, corners) in (0..).zip(rings) {
            flat.extend(corners);
            ring_of.resize(flat.len(), ring);
            starts.push(flat.len() as u32);
        }
        let mut valence = vec![0; points];
        for &point in &flat {
            valence[point as usize] += 1;
        }
        let mut net = Self { starts, points: flat, ring_of, twin: Vec::new(), valence };
        net.twin = net.twins();
        net
    }

    fn twins(&self) -> Vec<u32> {
        let ends = |half: u32| (self.points[half as usize], self.points[self.next(half) as usize]);
        let mut by_edge: Vec<(u32, u32, u32)> = (0..self.points.len() as u32)
            .map(|half| {
                let (a, b) = ends(half);
                (a.min(b), a.max(b), half)
            })
            .collect();
        by_edge.sort_unstable();
        let mut twin = vec![NONE; self.points.len()];
        for group in by_edge.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)) {
            if let &[(.., one), (.., other)] = group
                && ends(one).0 != ends(other).0
            {
                twin[one as usize] = other;
                twin[other as usize] = one;
            }
        }
        twin
    }

    pub fn rings(&self) -> usize {
        self.starts.len() - 1
    }

    /// The half-edges of a ring.
    pub fn halves(&self, ring: u32) -> std::ops::Range<u32> {
        self.starts[ring as usize]..self.starts[ring as usize + 1]
    }

    /// The next half-edge of the same ring.
    pub fn next(&self, half: u32) -> u32 {
        let ring = self.halves(self.ring_of[half as usize]);
        if half + 1 == ring.end { ring.start } else { half + 1 }
    }

    /// The previous half-edge of the same ring.
    pub fn previous(&self, half: u32) -> u32 {
        let ring = self.halves(self.ring_of[half as usize]);
        if half == ring.start { ring.end - 1 } else { half - 1 }
    }

    /// The same net seen from the other side. Half-edges keep the point that they start at, so
    /// `flipped().points` is another order of the same rings.
    pub fn flipped(&self) -> Self {
        let rings: Vec<Vec<u32>> = (0..self.rings() as u32)
            .map(|ring| self.halves(ring).rev().map(|half| self.points[half as usize]).collect())
            .collect();
        Self::new(&rings, self.valence.len())
    }
}

/// The polygons of a mesh as rings of its surface's points. Corners that weld to the same point as
/// the one before are dropped, and with them polygons that become lines.
pub(super) fn polygons(mesh: &Mesh, surface: &Surface) -> Vec<Vec<u32>> {
    (0..mesh.polygon_count())
        .map(|polygon| {
            let fan = mesh.polygon(polygon);
            let first = surface.triangles()[fan.start];
            let mut ring = vec![first[0], first[1]];
            ring.extend(fan.map(|face| surface.triangles()[face][2]));
            ring.dedup();
            while ring.len() > 1 && ring.first() == ring.last() {
                ring.pop();
            }
            ring
        })
        .filter(|ring| ring.len() > 2)
        .collect()
}

/// Joins triangles in pairs to the quads that they were before somebody triangulated them.
///
/// Programs write the two halves of a quad one after the other, so these are tried first. If they
/// don't pair up, pairs are chosen by shape, the most rectangular quads first.
pub(super) fn merged_triangles(triangles: &[Vec<u32>], positions: &[DVec3]) -> Vec<Vec<u32>> {
    /// Least share of triangles in consecutive pairs for the order to be that of quads.
    const ORDERED: f64 = 0.9;
    let mut partner = vec![NONE; triangles.len()];
    let mut index = 0;
    let mut paired = 0;
    while index + 1 < triangles.len() {
        if quad(&triangles[index], &triangles[index + 1]).is_some() {
            partner[index] = index as u32 + 1;
            partner[index + 1] = index as u32;
            paired += 2;
            index += 1;
        }
        index += 1;
    }
    if (paired as f64) < ORDERED * triangles.len() as f64 {
        partner = by_shape(triangles, positions);
    }
    let mut rings = Vec::with_capacity(triangles.len());
    for (index, triangle) in triangles.iter().enumerate() {
        match partner[index] {
            NONE => rings.push(triangle.clone()),
            other if (other as usize) > index => {
                rings.extend(quad(triangle, &triangles[other as usize]));
            }
            _ => {}
        }
    }
    rings
}

/// The quad of two triangles that share an edge with consistent winding.
fn quad(one: &[u32], other: &[u32]) -> Option<Vec<u32>> {
    if one.len() != 3 || other.len() != 3 {
        return None;
    }
    (0..3).find_map(|k| {
        let (a, b) = (one[k], one[(k + 1) % 3]);
        let far = (0..3).find(|&j| other[j] == b && other[(j + 1) % 3] == a)?;
        let apex = other[(far + 2) % 3];
        let opposite = one[(k + 2) % 3];
        (apex != opposite).then(|| vec![a, apex, b, opposite])
    })
}

/// Pairs of triangles, the ones with the most rectangular quads first.
fn by_shape(triangles: &[Vec<u32>], positions: &[DVec3]) -> Vec<u32> {
    let net = Net::new(triangles, positions.len());
    let mut edges: Vec<(Reverse<u64>, u32)> = (0..net.twin.len() as u32)
        .filter(|&half| net.twin[half as usize] != NONE && half < net.twin[half as usize])
        .filter_map(|half| {
            let [one, other] =
                [half, net.twin[half as usize]].map(|half| net.ring_of[half as usize]);
            let corners = quad(&triangles[one as usize], &triangles[other as usize])?;
            let at = |k: usize| positions[corners[k % 4] as usize];
            // The least sine of a corner, and how flat the quad is along its diagonal.
            let normal =
                |k: usize| (at(k + 1) - at(k)).cross(at(k + 3) - at(k)).normalize_or_zero();
            let sine = |k: usize| {
                let [a, b] = [at(k + 1) - at(k), at(k + 3) - at(k)].map(DVec3::normalize_or_zero);
                a.cross(b).length()
            };
            let least = (0..4).map(sine).fold(1.0, f64::min);
            let flat = normal(1).dot(normal(3)).max(0.0);
            Some((Reverse((least * flat * 1e9) as u64), half))
        })
        .collect();
    edges.sort_unstable();
    let mut partner = vec![NONE; triangles.len()];
    for (_, half) in edges {
        let [one, other] = [half, net.twin[half as usize]].map(|half| net.ring_of[half as usize]);
        if partner[one as usize] == NONE && partner[other as usize] == NONE {
            partner[one as usize] = other;
            partner[other as usize] = one;
        }
    }
    partner
}
