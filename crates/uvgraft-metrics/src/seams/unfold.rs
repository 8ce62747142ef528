//! Unfolds the surroundings of a point on an edge into a plane.

use uvgraft::edges::Edges;
use uvgraft::mesh::Mesh;

use super::SeamEdge;
use super::edge_class::{EdgeClass, kinds_by_half};
use super::walk::{DistanceSpace, HalfKind, Heading, Walker};

/// A surface that can be unfolded around points on its edges, to draw what a seam looks like.
pub struct Unfolded<'a> {
    mesh: &'a Mesh,
    edges: Edges,
    kinds: Vec<HalfKind>,
}

impl<'a> Unfolded<'a> {
    /// Prepares a mesh.
    pub fn new(mesh: &'a Mesh) -> Self {
        let edges = Edges::new(mesh);
        let nothing = vec![false; mesh.faces().len()];
        let kinds: Vec<_> =
            edges.shared.iter().map(|edge| EdgeClass::of(mesh, edge, &nothing)).collect();
        let kinds = kinds_by_half(&edges, &kinds);
        Self { mesh, edges, kinds }
    }

    /// The point in the texture's unit square at a given offset from a point on an edge, walking
    /// straight along the surface.
    ///
    /// - `edge`: an edge of this mesh.
    /// - `along`: the point on the edge, 0 at its first end and 1 at its second.
    /// - `across`: distance perpendicular to the edge, in mesh units; negative on the side of its
    ///   first triangle, positive on that of its second.
    /// - `forward`: distance along the direction from its first to its second end, in mesh units.
    ///
    /// `None` if the surface ends earlier, or the triangle on that side has no area.
    ///
    /// # Panics
    /// If the edge refers to a triangle that the mesh does not have.
    pub fn uv(&self, edge: &SeamEdge, along: f64, across: f64, forward: f64) -> Option<[f64; 2]> {
        let side = usize::from(across > 0.0);
        let [first, half] =
            [0, side].map(|k| edge.sides[k].face * 3 + u32::from(edge.sides[k].corner));
        let is_turned = self.edges.ends(first)[0] != self.edges.ends(half)[0];
        let distance = across.hypot(forward);
        // A walk exactly along the edge would be on neither side.
        let away = (across.abs() / distance).max(1e-6);
        let forward = (1.0 - away * away).max(0.0).sqrt().copysign(forward);
        let (at, forward) = if is_turned { (1.0 - along, -forward) } else { (along, forward) };
        let heading = match distance > 0.0 {
            true => Heading { along: forward, across: away, distance },
            false => Heading { along: 0.0, across: 1.0, distance: 0.0 },
        };
        let walker = Walker::new(self.mesh, &self.edges, &self.kinds);
        let arrival = walker.walk(DistanceSpace::Surface, half, at, heading)?;
        arrival.complete.then_some(arrival.uv)
    }
}
