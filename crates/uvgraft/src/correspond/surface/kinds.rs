//! What keeps apart surfaces that are close to each other: eyeballs and lids, what is seen and what
//! lies inside.

use glam::DVec3;

use super::shape::Shape;
use crate::anatomy::Ball;
use crate::correspond::similarity::Similarity;
use crate::threads::map_indices;

/// What a triangle belongs to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Kind {
    /// [`Self::SKIN`], the number of a source's ball, or [`Self::ALONE`].
    ball: u16,
    /// The share of directions before the triangle from which it is seen.
    exposure: f32,
}

impl Kind {
    /// Not a ball.
    const SKIN: u16 = u16::MAX - 1;
    /// A ball that the other mesh doesn't have.
    const ALONE: u16 = u16::MAX;
    /// A triangle that may lie on any other.
    pub const ANY: Self = Self { ball: Self::SKIN, exposure: 0.15 };

    /// Whether both belong to the same ball, or both to the skin.
    pub fn is_of_body(self, other: Self) -> bool {
        self.ball == other.ball && self.ball != Self::ALONE
    }

    /// Whether a triangle of the target may lie on one of the source.
    pub fn may_meet(self, other: Self) -> bool {
        const HIDDEN: f32 = 0.02;
        const SEEN: f32 = 0.3;
        let is_apart = |a: Self, b: Self| a.exposure <= HIDDEN && b.exposure >= SEEN;
        self.is_of_body(other) && !is_apart(self, other) && !is_apart(other, self)
    }

    /// Of points whose triangles have these kinds: a point on the edge of an opening is seen.
    pub fn joined(self, other: Self) -> Self {
        Self { exposure: self.exposure.max(other.exposure), ..self }
    }
}

/// The kinds of both meshes' triangles, source first, and where the target's balls go.
pub(super) struct Kinds {
    pub source: Vec<Kind>,
    pub target: Vec<Kind>,
    /// For each ball of the target with a counterpart: its faces, its centre, where that goes, and
    /// how much larger it becomes. In the shapes' space.
    pub moves: Vec<BallMove>,
}

#[derive(Debug, Clone)]
pub(super) struct BallMove {
    pub faces: Vec<u32>,
    pub center: DVec3,
    pub to: DVec3,
    pub scale: f64,
}

impl Kinds {
    /// - `shapes`, `balls`: source and aligned target.
    /// - `to_shape`: from the source's space to the shapes'.
    /// - `aligned`: from the target's space to the source's.
    pub fn new(
        shapes: [&Shape; 2],
        balls: [Vec<Ball>; 2],
        to_shape: impl Fn(DVec3) -> DVec3,
        aligned: &Similarity,
        unit: f64,
    ) -> Self {
        let [mut source, mut target] = shapes.map(|shape| {
            exposures(shape)
                .into_iter()
                .map(|exposure| Kind { ball: Kind::SKIN, exposure })
                .collect::<Vec<Kind>>()
        });
        let [source_balls, target_balls] = balls;
        let mut moves = Vec::new();
        // In a surface that has no balls, as a scan, eyes are part of the skin.
        if !source_balls.is_empty() {
            for (number, ball) in (0..).zip(&source_balls) {
                for &face in &ball.faces {
                    source[face as usize].ball = number;
                }
            }
            for ball in target_balls {
                let (center, radius) =
                    (to_shape(aligned.apply(ball.center)), ball.radius * aligned.scale / unit);
                let unlike = |other: &Ball| {
                    let far = to_shape(other.center).distance(center);
                    far + (other.radius / unit - radius).abs()
                };
                let nearest = (0..)
                    .zip(&source_balls)
                    .map(|(number, other)| (unlike(other), number, other))
                    .filter(|(unlike, ..)| *unlike < radius)
                    .min_by(|a, b| a.0.total_cmp(&b.0));
                let number = nearest.map_or(Kind::ALONE, |(_, number, _)| number);
                for &face in &ball.faces {
                    target[face as usize].ball = number;
                }
                if let Some((.., other)) = nearest {
                    let to = to_shape(other.center);
                    let scale = other.radius / unit / radius;
                    moves.push(BallMove { faces: ball.faces, center, to, scale });
                }
            }
        }
        Self { source, target, moves }
    }
}

/// For each triangle, the share of directions before it that nothing hides.
fn exposures(shape: &Shape) -> Vec<f32> {
    /// About half of them are before a triangle.
    const DIRECTIONS: usize = 40;
    /// Rays start this far before the triangle, and rise at least so steeply.
    const BEFORE: f64 = 1e-5;
    const RISE: f64 = 0.2;
    let directions: Vec<DVec3> = fibonacci(DIRECTIONS);
    let (tree, normals) = (shape.tree(), shape.face_normals());
    map_indices(shape.triangles.len(), |triangle| {
        let normal = normals[triangle];
        let center = shape.corners(triangle).into_iter().sum::<DVec3>() / 3.0 + normal * BEFORE;
        let before: Vec<DVec3> =
            directions.iter().copied().filter(|along| along.dot(normal) > RISE).collect();
        let open = before.iter().filter(|&&along| !tree.is_hit(center, along)).count();
        open as f32 / before.len().max(1) as f32
    })
}

/// Directions all around, evenly.
fn fibonacci(count: usize) -> Vec<DVec3> {
    let turn = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..count)
        .map(|index| {
            let height = 1.0 - (2 * index + 1) as f64 / count as f64;
            let (sin, cos) = (turn * index as f64).sin_cos();
            let radius = (1.0 - height * height).sqrt();
            DVec3::new(radius * cos, height, radius * sin)
        })
        .collect()
}
