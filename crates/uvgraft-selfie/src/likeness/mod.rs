//! A fitted shape transferred from a head to a body that contains such a head.
//!
//! What the fit moved on the head is turned and scaled into the body's space and added there, so
//! that a body with another face keeps the difference. The seam of the pair stays where it is:
//! moves fade out towards it.

mod parts;
#[cfg(test)]
mod tests;

use glam::DVec3;
use uvgraft::correspond::similarity::Similarity;
use uvgraft::easing::smoothstep_f64;
use uvgraft::piece::Extent;
use uvgraft::surface_field::{Smoothness, SurfaceField};
use uvgraft::threads::map_indices;
use uvgraft::{Anatomy, Pair};

use self::parts::BodyParts;

/// Why a shape was not transferred.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LikenessError {
    /// Too few of the body's vertices are linked, or they are on a line.
    #[error(
        "the pair must link the head's surface to that of the body, but links {linked} vertices"
    )]
    Unlinked {
        /// Number of vertices of the body that are linked.
        linked: usize,
    },
    /// The equations have no solution.
    #[error("the body's surface cannot be bent smoothly: its positions are out of range")]
    Unsolvable,
}

/// How a body's vertices move so that its head gets a fitted shape.
#[derive(Debug, Clone)]
pub struct Likeness {
    /// `[vertices]` of the body at rest.
    rest: Vec<DVec3>,
    /// `[vertices]`
    moves: Vec<DVec3>,
    /// The body's connected parts that are loose in its head: centre and move.
    loose: Vec<(DVec3, DVec3)>,
    /// Distance between the eyes, in the body's unit.
    unit: f64,
}

/// Over how many eye distances moves fade out towards the end of the neck.
const FADE: f64 = 1.0;

/// How much nearer than any other place the vertices are whose moves decide for a point.
const NEAREST: usize = 60;

impl Likeness {
    /// Carries a shape over.
    ///
    /// - `pair`: from the head to the body.
    /// - `anatomy`: of the pair's source.
    /// - `shaped`: `[vertices]` of the pair's source with the fitted shape.
    /// - `body`: `[vertices]` of the pair's target, in any shape that it can take.
    ///
    /// # Errors
    /// [`LikenessError`]
    ///
    /// # Panics
    /// If there are not as many positions as vertices.
    pub fn new(
        pair: &Pair,
        anatomy: &Anatomy,
        shaped: &[DVec3],
        body: &[[f32; 3]],
    ) -> Result<Self, LikenessError> {
        assert_eq!(shaped.len(), pair.source().positions().len(), "vertices of the head");
        assert_eq!(body.len(), pair.target().positions().len(), "vertices of the body");
        let at = |position: &[f32; 3]| glam::Vec3::from(*position).as_dvec3();
        let head: Vec<DVec3> = pair.source().positions().iter().map(at).collect();
        let rest: Vec<DVec3> = body.iter().map(at).collect();
        let places = places(pair);
        let on_head = |values: &[DVec3], place: &Place| -> DVec3 {
            (0..3).map(|k| values[place.vertices[k] as usize] * place.weights[k]).sum()
        };
        let pairs: Vec<[DVec3; 2]> = places
            .iter()
            .zip(&rest)
            .filter_map(|(place, &to)| Some([on_head(&head, place.as_ref()?), to]))
            .collect();
        let frame = anatomy.frame();
        let unlinked = LikenessError::Unlinked { linked: pairs.len() };
        let alignment = Similarity::robust(&pairs, true).ok_or(unlinked)?;
        let turned = |shift: DVec3| alignment.rotation * shift * alignment.scale;
        let body = BodyParts::new(pair);
        let ends = body.end_of_head(|vertex| {
            let Some(place) = &places[vertex as usize] else { return false };
            // Holes such as the mouth are not where the head ends.
            frame.local(on_head(&head, place).to_array())[1] < -1.8
        });
        let unit = frame.unit * alignment.scale;
        let moved = |vertex: usize| {
            let place = places[vertex].as_ref()?;
            let shift = on_head(shaped, place) - on_head(&head, place);
            let nearest = ends.iter().map(|&at| rest[at as usize].distance_squared(rest[vertex]));
            let nearest = nearest.fold(f64::INFINITY, f64::min).sqrt();
            Some(turned(shift) * smoothstep_f64(0.0, FADE * unit, nearest))
        };
        let mut known: Vec<Option<DVec3>> = map_indices(rest.len(), moved);
        for vertex in body.beyond(&ends) {
            known[vertex as usize].get_or_insert(DVec3::ZERO);
        }
        let moves = vec![DVec3::ZERO; rest.len()];
        let mut likeness = Self { moves, rest, loose: Vec::new(), unit };
        likeness.move_skin(&body, &known)?;
        likeness.move_loose(&body, &known);
        Ok(likeness)
    }

    /// The body's vertices, moved by a share: 0 for rest, 1 for the fitted shape.
    pub fn positions(&self, share: f64) -> Vec<[f32; 3]> {
        let moved = |(&rest, &by): (&DVec3, &DVec3)| (rest + by * share).as_vec3().to_array();
        self.rest.iter().zip(&self.moves).map(moved).collect()
    }

    /// How a point inside the head moves, such as the joint of an eye, moved by a share: with the
    /// eyeball around it, or else with what is near.
    pub fn point(&self, at: [f32; 3], share: f64) -> [f32; 3] {
        /// Joints of eyes are in their middle, in eye distances.
        const WITHIN: f64 = 0.15;
        let point = glam::Vec3::from(at).as_dvec3();
        let distance = |loose: &&(DVec3, DVec3)| loose.0.distance(point);
        let around = self
            .loose
            .iter()
            .filter(|loose| distance(loose) < WITHIN * self.unit)
            .min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let all = 0..self.rest.len() as u32;
        let by = around.map_or_else(|| self.near(point, all), |&(_, by)| by);
        (point + by * share).as_vec3().to_array()
    }

    /// The mean move of the vertices nearest to a point.
    fn near(&self, point: DVec3, vertices: impl Iterator<Item = u32>) -> DVec3 {
        let distance = |at: u32| self.rest[at as usize].distance_squared(point);
        let mut near: Vec<(f64, u32)> = vertices.map(|at| (distance(at), at)).collect();
        let count = NEAREST.min(near.len());
        if count == 0 {
            return DVec3::ZERO;
        }
        near.select_nth_unstable_by(count - 1, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near.truncate(count);
        // The order of a selection is not determined, and that of a sum matters.
        near.sort_unstable_by_key(|&(_, at)| at);
        near.iter().map(|&(_, at)| self.moves[at as usize]).sum::<DVec3>() / count as f64
    }

    /// Moves the skin: vertices with known moves by these; the others, such as those of a mouth that
    /// the head lacks, follow smoothly.
    fn move_skin(
        &mut self,
        body: &BodyParts<'_>,
        known: &[Option<DVec3>],
    ) -> Result<(), LikenessError> {
        const FOLLOWING: Smoothness = Smoothness { bending: 0.3, membrane: 0.3 };
        for &vertex in body.skin() {
            self.moves[vertex as usize] = known[vertex as usize].unwrap_or_default();
        }
        let is_open = body.skin().iter().any(|&vertex| known[vertex as usize].is_none());
        if !is_open || self.moves.iter().all(|by| *by == DVec3::ZERO) {
            return Ok(());
        }
        let shape = body.mesh.clone().with_positions(self.positions(0.0));
        let field = SurfaceField::new(&shape.map_err(|_| LikenessError::Unsolvable)?, self.unit);
        let value = |(by, area): (&Option<DVec3>, f64)| match by {
            Some(by) => (100.0 * area, by.to_array()),
            None => (0.0, [0.0; 3]),
        };
        let values: Vec<(f64, [f64; 3])> = known.iter().zip(field.areas()).map(value).collect();
        let smoothness = Smoothness {
            bending: FOLLOWING.bending * self.unit,
            membrane: FOLLOWING.membrane * self.unit,
        };
        let solved = field.solve(smoothness, &values, &[]).ok_or(LikenessError::Unsolvable)?;
        for &vertex in body.skin().iter().filter(|&&vertex| known[vertex as usize].is_none()) {
            self.moves[vertex as usize] = DVec3::from(solved[vertex as usize]);
        }
        Ok(())
    }

    /// Moves eyeballs, teeth and everything else that is loose: rigidly.
    fn move_loose(&mut self, body: &BodyParts<'_>, known: &[Option<DVec3>]) {
        for part in body.loose() {
            let count = part.len() as f64;
            let center = part.iter().map(|&at| self.rest[at as usize]).sum::<DVec3>() / count;
            let linked: Vec<DVec3> = part.iter().filter_map(|&at| known[at as usize]).collect();
            let by = if linked.is_empty() {
                self.near(center, body.skin().iter().copied())
            } else {
                linked.iter().sum::<DVec3>() / linked.len() as f64
            };
            part.iter().for_each(|&vertex| self.moves[vertex as usize] = by);
            self.loose.push((center, by));
        }
    }
}

/// A place on the head: three vertices and their weights.
#[derive(Debug, Clone, Copy)]
struct Place {
    vertices: [u32; 3],
    weights: [f64; 3],
}

/// For each vertex of the target its place on the source, if it is linked.
fn places(pair: &Pair) -> Vec<Option<Place>> {
    /// Weight of a corner that is as good as a vertex.
    const VERTEX: f64 = 0.999;
    let (source, target) = (pair.source(), pair.target());
    let mut places: Vec<Option<Place>> = vec![None; target.positions().len()];
    let unit = |corner: usize| [0, 1, 2].map(|k| f64::from(u8::from(k == corner)));
    for piece in pair.pieces() {
        let face = target.faces()[piece.target as usize];
        let vertices = source.faces()[piece.source as usize];
        let corners: [(Option<usize>, [f64; 3]); 3] = match piece.extent {
            Extent::Whole(corners) => [0, 1, 2].map(|k| (Some(k), unit(usize::from(corners[k])))),
            Extent::Part { target, source } => [0, 1, 2].map(|k| {
                let corner = (0..3).find(|&corner| target[k][corner] > VERTEX);
                (corner, source[k])
            }),
        };
        for (corner, weights) in corners {
            if let Some(corner) = corner {
                places[face[corner] as usize].get_or_insert(Place { vertices, weights });
            }
        }
    }
    places
}
