//! What keeps apart surfaces that are close to each other: eyeballs and lids, what is seen and what
//! lies inside.

use std::sync::Arc;

use glam::DVec3;

use super::shape::Shape;
use crate::anatomy::Ball;
use crate::correspond::similarity::Similarity;
use crate::threads::map_indices;
use crate::triangle_tree::{Effort, TriangleTree};

/// What a triangle belongs to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TriangleKind {
    /// [`Self::SKIN`], the number of a source's ball, or [`Self::ALONE`].
    ball: u16,
    /// The share of directions before the triangle from which it is seen.
    exposure: f32,
}

impl TriangleKind {
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
        /// Of about 16 rising directions at least five are open.
        const SEEN: f32 = 0.3;
        let is_apart = |a: Self, b: Self| a.is_hidden() && b.exposure >= SEEN;
        self.is_of_body(other) && !is_apart(self, other) && !is_apart(other, self)
    }

    /// Whether nothing outside sees the triangle.
    pub fn is_hidden(self) -> bool {
        /// Of about 16 rising directions none is open.
        const HIDDEN: f32 = 0.02;
        self.exposure <= HIDDEN
    }

    /// The same without any counterpart.
    pub fn alone(self) -> Self {
        Self { ball: Self::ALONE, ..self }
    }

    /// Of points whose triangles have these kinds: a point on the edge of an opening is seen.
    pub fn joined(self, other: Self) -> Self {
        Self { exposure: self.exposure.max(other.exposure), ..self }
    }
}

/// The kinds of both meshes' triangles, source first, and where the target's balls go.
pub(super) struct TriangleKinds {
    pub source: Vec<TriangleKind>,
    pub target: Vec<TriangleKind>,
    /// For each ball of the target with a counterpart: its faces, its centre, where that goes, and
    /// how much larger it becomes. In the shapes' space.
    pub moves: Vec<BallMove>,
}

#[derive(Debug, Clone)]
pub(super) struct BallMove {
    faces: Vec<u32>,
    center: DVec3,
    to: DVec3,
    scale: f64,
}

impl BallMove {
    /// Moves and scales the ball of a shape.
    pub fn apply(&self, shape: &mut Shape) {
        let mut points: Vec<u32> =
            self.faces.iter().flat_map(|&face| shape.triangles[face as usize]).collect();
        points.sort_unstable();
        points.dedup();
        for point in points {
            let point = &mut shape.points[point as usize];
            *point = self.to + (*point - self.center) * self.scale;
        }
    }
}

impl TriangleKinds {
    /// - `shapes`, `balls`: source and aligned target.
    /// - `worn`: the target's triangles that belong nowhere and hide nothing; of all or of none.
    /// - `to_shape`: from the source's space to the shapes'.
    /// - `aligned`: from the target's space to the source's.
    /// - `effort`: of searches.
    pub fn new(
        shapes: [&Shape; 2],
        balls: [Vec<Ball>; 2],
        worn: &[bool],
        to_shape: impl Fn(DVec3) -> DVec3,
        aligned: &Similarity,
        unit: f64,
        effort: &Arc<Effort>,
    ) -> Self {
        let [mut source, mut target] =
            [Side::new(shapes[0], &[], effort), Side::new(shapes[1], worn, effort)];
        let [source_balls, mut target_balls] = balls;
        for ball in &mut target_balls {
            ball.center = to_shape(aligned.apply(ball.center));
            ball.radius *= aligned.scale / unit;
        }
        let source_balls: Vec<Ball> = source_balls
            .into_iter()
            .map(|ball| Ball { center: to_shape(ball.center), radius: ball.radius / unit, ..ball })
            .collect();
        let mut moves = Vec::new();
        match (source_balls.is_empty(), target_balls.is_empty()) {
            (true, false) => target.settle(&target_balls, &source),
            (false, true) => source.settle(&source_balls, &target),
            _ => moves = matched(&mut source, &source_balls, &mut target, target_balls),
        }
        Self { source: source.kinds, target: target.kinds, moves }
    }
}

/// A shape whose triangles get their kinds.
struct Side<'a> {
    shape: &'a Shape,
    tree: TriangleTree,
    normals: Vec<DVec3>,
    kinds: Vec<TriangleKind>,
}

impl<'a> Side<'a> {
    /// All skin, except what is worn.
    fn new(shape: &'a Shape, worn: &[bool], effort: &Arc<Effort>) -> Self {
        let (tree, normals) = (shape.tree(effort), shape.face_normals());
        let exposures = if worn.contains(&true) {
            exposures(shape, &shape.without(worn).tree(effort), &normals)
        } else {
            exposures(shape, &tree, &normals)
        };
        let mut kinds: Vec<TriangleKind> = exposures
            .into_iter()
            .map(|exposure| TriangleKind { ball: TriangleKind::SKIN, exposure })
            .collect();
        for (kind, _) in kinds.iter_mut().zip(worn).filter(|(_, is_worn)| **is_worn) {
            *kind = kind.alone();
        }
        Self { shape, tree, normals, kinds }
    }

    fn mark(&mut self, faces: &[u32], ball: u16) {
        faces.iter().for_each(|&face| self.kinds[face as usize].ball = ball);
    }

    /// Decides on balls where the other mesh has none. In a scan, eyes are part of the skin, and balls
    /// belong there. Where the other mesh has empty sockets, they belong nowhere.
    fn settle(&mut self, balls: &[Ball], other: &Self) {
        /// What is seen less lies behind lids. At most one of about 16 rising directions is open.
        const BEHIND_LIDS: f32 = 0.1;
        for ball in balls {
            let is_seen = |&face: &u32| self.kinds[face as usize].exposure > BEHIND_LIDS;
            let (seen, hidden): (Vec<u32>, Vec<u32>) =
                ball.faces.iter().copied().partition(is_seen);
            if !self.is_on(&seen, ball.radius, other) {
                self.mark(&seen, TriangleKind::ALONE);
            }
            self.mark(&hidden, TriangleKind::ALONE);
        }
    }

    /// Whether a ball's faces lie on the other shape's surface, measured along their normals: the lids
    /// around an empty socket are near too, but beside the ball.
    fn is_on(&self, faces: &[u32], radius: f64, other: &Self) -> bool {
        /// In radii. Alignment leaves up to 0.5, and sockets are at least 1.4 deep.
        const NEAR: f64 = 0.8;
        const MOST: f64 = 0.85;
        const COMPATIBLE: f64 = 0.5;
        let (mut near, mut all) = (0.0, 0.0);
        for &face in faces {
            let area = self.shape.area_vector(face as usize).length();
            let center = self.shape.corners(face as usize).into_iter().sum::<DVec3>() / 3.0;
            let normal = self.normals[face as usize];
            let is_alike = |at: u32| other.normals[at as usize].dot(normal) > COMPATIBLE;
            all += area;
            if other.tree.is_met_along(center, normal, NEAR * radius, is_alike) {
                near += area;
            }
        }
        near > MOST * all
    }
}

/// Gives balls of both meshes that are near each other the same number, and returns where those of the
/// target go.
fn matched(
    source: &mut Side<'_>,
    source_balls: &[Ball],
    target: &mut Side<'_>,
    target_balls: Vec<Ball>,
) -> Vec<BallMove> {
    let mut moves = Vec::new();
    for (number, ball) in (0..).zip(source_balls) {
        source.mark(&ball.faces, number);
    }
    for ball in target_balls {
        let unlike =
            |other: &Ball| other.center.distance(ball.center) + (other.radius - ball.radius).abs();
        let nearest = (0..)
            .zip(source_balls)
            .map(|(number, other)| (unlike(other), number, other))
            .filter(|(unlike, ..)| *unlike < ball.radius)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        target.mark(&ball.faces, nearest.map_or(TriangleKind::ALONE, |(_, number, _)| number));
        if let Some((.., other)) = nearest {
            let scale = other.radius / ball.radius;
            moves.push(BallMove {
                faces: ball.faces,
                center: ball.center,
                to: other.center,
                scale,
            });
        }
    }
    moves
}

/// For each triangle, the share of directions before it that nothing hides.
fn exposures(shape: &Shape, tree: &TriangleTree, normals: &[DVec3]) -> Vec<f32> {
    /// About half of them are before a triangle.
    const DIRECTIONS: usize = 40;
    /// Rays start this far before the triangle, relative to its size, so that they pass what noise
    /// folded over it, and at most so far.
    const BEFORE: f64 = 0.3;
    const FARTHEST: f64 = 0.004;
    /// They rise at least so steeply: 12°.
    const RISE: f64 = 0.2;
    let directions: Vec<DVec3> = fibonacci(DIRECTIONS);
    map_indices(shape.triangles.len(), |triangle| {
        let normal = normals[triangle];
        let size = shape.area_vector(triangle).length().sqrt();
        let before = (BEFORE * size).min(FARTHEST);
        let center = shape.corners(triangle).into_iter().sum::<DVec3>() / 3.0 + normal * before;
        // Two fifths of the directions, 16 of 40: a share of 0.06 is one of them.
        let rising: Vec<DVec3> =
            directions.iter().copied().filter(|along| along.dot(normal) > RISE).collect();
        let open = rising.iter().filter(|&&along| !tree.is_hit(center, along)).count();
        open as f32 / rising.len().max(1) as f32
    })
}

/// Directions all around, evenly.
fn fibonacci(count: usize) -> Vec<DVec3> {
    // The golden angle: no two of few directions line up.
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

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;

    /// Rows and columns of quads over `u` from 0 to 1 and `v` from 0 to 1.
    fn patch(place: impl Fn(f64, f64) -> DVec3) -> Shape {
        const SIDE: u32 = 24;
        let step = |at: u32| f64::from(at) / f64::from(SIDE);
        let points = (0..=SIDE).flat_map(|row| (0..=SIDE).map(move |column| (column, row)));
        let points = points.map(|(column, row)| place(step(column), step(row))).collect();
        let at = |column: u32, row: u32| row * (SIDE + 1) + column;
        let quads = (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| (column, row)));
        let triangles = quads
            .flat_map(|(x, y)| {
                let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        Shape { points, triangles }
    }

    /// A ball of radius 1 around the origin with its pole along +Z, in a shell that leaves the front
    /// open.
    fn ball() -> (Shape, Ball) {
        let sphere = |radius: f64, turn: f64, tilt: f64| {
            let ((sin, cos), (across, along)) = (turn.sin_cos(), tilt.sin_cos());
            radius * DVec3::new(across * cos, across * sin, -along)
        };
        let mut shape = patch(|u, v| sphere(1.0, TAU * u, PI * v));
        let faces = (0..shape.triangles.len() as u32).collect();
        let shell = patch(|u, v| sphere(1.05, TAU * u, 0.65 * PI * v));
        let offset = shape.points.len() as u32;
        shape.points.extend(shell.points);
        shape.triangles.extend(shell.triangles.iter().map(|points| points.map(|at| at + offset)));
        (shape, Ball { faces, center: DVec3::ZERO, radius: 1.0 })
    }

    /// A square of skin with a depth below each place, seen from +Z.
    fn skin(depth: impl Fn(f64) -> f64) -> Shape {
        patch(|u, v| {
            let [x, y] = [u, v].map(|at| 6.0 * at - 3.0);
            DVec3::new(x, y, -depth(x.hypot(y)))
        })
    }

    /// The kinds of a ball's front and back beside a mesh without balls.
    fn beside(skin: &Shape) -> [bool; 2] {
        let (shape, ball) = ball();
        let faces = ball.faces.clone();
        let aligned = Similarity::IDENTITY;
        let (balls, effort) = ([Vec::new(), vec![ball]], Effort::unlimited());
        let kinds =
            TriangleKinds::new([skin, &shape], balls, &[], |point| point, &aligned, 1.0, &effort);
        assert!(kinds.moves.is_empty());
        let kind_of = |least: f64, most: f64| {
            let mut there = faces.iter().map(|&face| face as usize).filter(|&triangle| {
                let center = shape.corners(triangle).into_iter().sum::<DVec3>() / 3.0;
                shape.area_vector(triangle).length() > 1e-9 && (least..most).contains(&center.z)
            });
            there.all(|triangle| kinds.target[triangle].is_of_body(kinds.source[0]))
        };
        [kind_of(0.6, 1.1), kind_of(-1.1, -0.2)]
    }

    #[test]
    fn an_eye_that_is_part_of_the_skin_has_the_eyeball() {
        let painted =
            skin(|radius| if radius < 1.0 { -(1.0 - radius * radius).sqrt() } else { 0.0 });
        assert_eq!(beside(&painted), [true, false]);
        // Also if the ball lies deeper than the skin.
        let prominent =
            skin(|radius| if radius < 1.2 { -0.4 - (1.44 - radius * radius).sqrt() } else { 0.0 });
        assert_eq!(beside(&prominent), [true, false]);
    }

    #[test]
    fn an_empty_socket_has_no_eyeball() {
        let socket = skin(|radius| if radius < 0.9 { 1.5 } else { 0.0 });
        assert_eq!(beside(&socket), [false, false]);
        let hole = skin(|radius| if radius < 0.9 { 40.0 } else { 0.0 });
        assert_eq!(beside(&hole), [false, false]);
    }
}
