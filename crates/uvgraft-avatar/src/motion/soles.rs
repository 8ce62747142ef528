//! The soles of feet: the points of a body that touch the ground.

use glam::{Quat, Vec3};

use crate::rig::{HumanBone, Rigid, Skeleton, Skin};

/// The parts of both feet that can touch the ground.
#[derive(Debug, Clone)]
pub struct Soles {
    /// Left, right.
    pub(super) feet: [Sole; 2],
}

/// The surface of a foot, as points of its convex hull.
#[derive(Debug, Clone)]
pub(super) struct Sole {
    /// Those of the rear half come first.
    points: Vec<Point>,
    /// Number of points in the rear half.
    behind: usize,
}

/// A point of the body with its skinning weights.
#[derive(Debug, Clone)]
struct Point {
    rest: Vec3,
    influences: Vec<(u16, f32)>,
}

/// Where half of a foot is in a pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Contact {
    /// Height of its lowest point.
    pub height: f32,
    /// Position of the point that is lowest at rest.
    pub point: Vec3,
}

/// Number of directions in which the convex hull is sampled.
const DIRECTIONS: usize = 96;
/// A vertex belongs to a foot if its weights for the foot and toes sum to more than this.
const OWN: f32 = 0.5;
/// For skeletons without a mesh: depth of the sole below the lowest joint of the foot.
const SOLE_M: f32 = 0.02;

impl Soles {
    /// From a body at rest, standing upright and facing +Z; `None` if it has no feet.
    ///
    /// - `positions`: of its vertices, as many as in `skin`.
    pub fn new(positions: &[[f32; 3]], skin: &Skin, skeleton: &Skeleton) -> Option<Self> {
        let [left, right] = bones(skeleton)?;
        let sole = |joints: [Option<usize>; 2]| {
            let own = |&&(joint, _): &&(u16, f32)| joints.contains(&Some(usize::from(joint)));
            let share = |vertex: usize| -> f32 {
                skin.of(vertex).iter().filter(own).map(|&(_, weight)| weight).sum()
            };
            let vertices = (0..positions.len()).filter(|&vertex| share(vertex) > OWN);
            let point = |vertex: usize| Point {
                rest: positions[vertex].into(),
                influences: skin.of(vertex).to_vec(),
            };
            Sole::new(&vertices.map(point).collect::<Vec<_>>())
        };
        Some(Self { feet: [sole(left)?, sole(right)?] })
    }

    /// From joints alone, with a sole two centimetres below the lowest joint of each foot.
    pub fn of_joints(skeleton: &Skeleton) -> Option<Self> {
        let place = |joint: usize| Vec3::from(skeleton.joints()[joint].position);
        let sole = |[foot, toes]: [Option<usize>; 2]| {
            let joints: Vec<usize> = foot.into_iter().chain(toes).collect();
            let lowest = joints.iter().map(|&joint| place(joint).y).reduce(f32::min)? - SOLE_M;
            let point = |&joint: &usize| Point {
                rest: Vec3 { y: lowest, ..place(joint) },
                influences: vec![(joint as u16, 1.0)],
            };
            Sole::new(&joints.iter().map(point).collect::<Vec<_>>())
        };
        let [left, right] = bones(skeleton)?;
        Some(Self { feet: [sole(left)?, sole(right)?] })
    }
}

/// The joints of feet and toes, left and right.
fn bones(skeleton: &Skeleton) -> Option<[[Option<usize>; 2]; 2]> {
    let foot = |foot: HumanBone, toes: HumanBone| {
        skeleton.human(foot).map(|joint| [Some(joint), skeleton.human(toes)])
    };
    Some([
        foot(HumanBone::LeftFoot, HumanBone::LeftToes)?,
        foot(HumanBone::RightFoot, HumanBone::RightToes)?,
    ])
}

impl Sole {
    /// Keeps the points that are extreme in some direction, for each half of the foot.
    fn new(points: &[Point]) -> Option<Self> {
        let ends = |low: f32, point: &Point| low.min(point.rest.z);
        let back = points.iter().fold(f32::MAX, ends);
        let front = -points.iter().fold(f32::MAX, |low, point| low.min(-point.rest.z));
        let middle = (back + front) / 2.0;
        let mut kept = Vec::new();
        let mut behind = 0;
        for half in [true, false] {
            let in_half: Vec<&Point> =
                points.iter().filter(|point| (point.rest.z < middle) == half).collect();
            let mut chosen: Vec<usize> = directions()
                .filter_map(|direction| {
                    let out = |at: &usize| in_half[*at].rest.dot(direction);
                    (0..in_half.len()).max_by(|a, b| out(a).total_cmp(&out(b)))
                })
                .collect();
            // The lowest point comes first: it represents the half in measurements of speed.
            chosen
                .sort_by(|&a, &b| in_half[a].rest.y.total_cmp(&in_half[b].rest.y).then(a.cmp(&b)));
            chosen.dedup();
            kept.extend(chosen.into_iter().map(|at| in_half[at].clone()));
            if half {
                behind = kept.len();
            }
        }
        (!kept.is_empty()).then_some(Self { points: kept, behind })
    }

    /// The contacts of heel and ball in a pose; for a foot with points in one half only, both are
    /// the same.
    pub(super) fn contacts(&self, motions: &[Rigid]) -> [Contact; 2] {
        let (heel, ball) = self.points.split_at(self.behind);
        let contact = |points: &[Point]| {
            let height = points.iter().map(|point| point.posed(motions).y).fold(f32::MAX, f32::min);
            points.first().map(|first| Contact { height, point: first.posed(motions) })
        };
        let [heel, ball] = [contact(heel), contact(ball)];
        let any = heel.or(ball).unwrap_or(Contact { height: 0.0, point: Vec3::ZERO });
        [heel.unwrap_or(any), ball.unwrap_or(any)]
    }
}

impl Point {
    fn posed(&self, motions: &[Rigid]) -> Vec3 {
        self.influences.iter().fold(Vec3::ZERO, |sum, &(joint, weight)| {
            let Rigid { rotation, translation } = motions[usize::from(joint)];
            let moved = Quat::from_array(rotation) * self.rest + Vec3::from(translation);
            sum + weight * moved
        })
    }
}

/// Directions spread evenly over the sphere along a Fibonacci spiral, and straight down.
fn directions() -> impl Iterator<Item = Vec3> {
    let golden = std::f32::consts::PI * (3.0 - 5.0_f32.sqrt());
    let direction = move |index: usize| {
        let y = 1.0 - (2 * index + 1) as f32 / DIRECTIONS as f32;
        let radius = (1.0 - y * y).sqrt();
        let angle = golden * index as f32;
        Vec3::new(radius * angle.cos(), y, radius * angle.sin())
    };
    std::iter::once(Vec3::NEG_Y).chain((0..DIRECTIONS).map(direction))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;
    use crate::rig::Pose;

    #[test]
    fn hulls_touch_the_ground_where_vertices_do() {
        let avatar = example::avatar().standing().unwrap();
        let soles = avatar.soles().unwrap();
        for clip in &avatar.clips {
            for pose in clip.poses.iter().step_by(7) {
                let motions = avatar.skeleton.motions(pose).unwrap();
                let posed = avatar.posed(pose, &[]).unwrap();
                for (sole, bones) in soles.feet.iter().zip([
                    [HumanBone::LeftFoot, HumanBone::LeftToes],
                    [HumanBone::RightFoot, HumanBone::RightToes],
                ]) {
                    let own = bones.map(|bone| avatar.skeleton.human(bone).unwrap() as u16);
                    let lowest = (0..posed.len())
                        .filter(|&vertex| own.contains(&avatar.skin.of(vertex)[0].0))
                        .map(|vertex| posed[vertex][1])
                        .fold(f32::MAX, f32::min);
                    let [heel, ball] = sole.contacts(&motions);
                    let found = heel.height.min(ball.height);
                    assert!((found - lowest).abs() < 0.003, "{found} {lowest}");
                    assert!(sole.points.len() < 2 * DIRECTIONS);
                }
            }
        }
        let rest = avatar.skeleton.motions(&Pose::rest(avatar.skeleton.joints().len())).unwrap();
        let [heel, ball] = soles.feet[0].contacts(&rest);
        assert!(heel.point.z < ball.point.z && heel.height < 0.02 && ball.height < 0.02);
    }
}
