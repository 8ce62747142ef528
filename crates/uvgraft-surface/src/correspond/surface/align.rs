//! Bringing the target into the source's place before registration.

use glam::{DMat3, DVec3};

use super::kinds::TriangleKind;
use super::register::Goal;
use super::shape::Shape;
use super::worn::worn;
use crate::anatomy::{self, Anatomy, AnatomyError, HeadFrame, Landmark};
use crate::correspond::similarity::Similarity;
use crate::mesh::Mesh;
use crate::statistics::median;
use crate::threads::map_indices;

/// Landmarks on the skin that are the same place of any head. Foremost points (of nose, chin and
/// brow) are not: where they are depends on how a head is held and on its shape.
const ON_SKIN: [Landmark; 3] =
    [Landmark::NoseBase, Landmark::LeftMouthCorner, Landmark::RightMouthCorner];

/// Landmarks that decide the alignment: rigid parts of the skull, and the eyes.
pub(super) const STEADY: [Landmark; 7] = [
    Landmark::LeftEye,
    Landmark::RightEye,
    Landmark::NoseTip,
    Landmark::NoseBase,
    Landmark::Mouth,
    Landmark::BrowCenter,
    Landmark::Chin,
];

/// The landmarks of two heads.
#[derive(Debug)]
pub(super) struct Heads {
    pub target: Anatomy,
    pub source: Anatomy,
}

impl Heads {
    /// # Errors
    /// Which mesh (`"source"` or `"target"`) has no head, and why.
    pub fn find(source: &Mesh, target: &Mesh) -> Result<Self, (&'static str, AnatomyError)> {
        let target = Anatomy::find(target).map_err(|error| ("target", error))?;
        let source = Anatomy::find(source).map_err(|error| ("source", error))?;
        Ok(Self { target, source })
    }

    /// The target's triangles that it wears over the skin, if the source wears nothing: nothing of the
    /// source belongs there. Empty otherwise.
    ///
    /// - `meshes`, `shapes`: source and target.
    pub fn worn(&self, meshes: [&Mesh; 2], shapes: [&Shape; 2]) -> Vec<bool> {
        let worn = |side: usize, head: &Anatomy| {
            worn(meshes[side], shapes[side], head, &anatomy::balls(meshes[side]))
        };
        let of_target = worn(1, &self.target);
        let is_alone = of_target.contains(&true) && !worn(0, &self.source).contains(&true);
        if is_alone { of_target } else { Vec::new() }
    }

    /// The places of landmarks that both heads have, target first.
    pub fn common(&self, landmarks: &[Landmark]) -> Vec<[DVec3; 2]> {
        let both = |&landmark: &Landmark| {
            let [target, source] = [&self.target, &self.source].map(|head| head.point(landmark));
            Some([DVec3::from(target?), DVec3::from(source?)])
        };
        landmarks.iter().filter_map(both).collect()
    }

    /// The transform that brings the target's head to the source's.
    pub fn alignment(&self, scales: bool) -> Option<Similarity> {
        let pairs = self.common(&STEADY);
        Similarity::between(&pairs, &vec![1.0; pairs.len()], scales)
    }

    /// Landmarks on the skin.
    pub fn on_skin(&self) -> Vec<[DVec3; 2]> {
        self.common(&ON_SKIN)
    }
}

/// The alignment with the target's face upside down, if that brings the surfaces clearly closer: the
/// profile of a face alone, without a skull and eyeballs, may be taken for its own upside down.
///
/// - `found`: the refined alignment.
/// - `head`: the source's.
pub(super) fn opposite(
    found: Similarity,
    target: &Shape,
    goal: &Goal,
    head: &HeadFrame,
    scales: bool,
) -> Option<Similarity> {
    /// In distances between the eyes: where the centre of the turned face may belong.
    const OFFSETS: [f64; 3] = [-0.5, 0.0, 0.5];
    /// How much closer the opposite must be. Origin not recorded.
    const CLEARER: f64 = 0.6;
    let unit = head.unit * super::HEAD_PER_EYES;
    let [_, up, forward] = head.axes.map(DVec3::from);
    let half_turn = DMat3::from_axis_angle(forward, std::f64::consts::PI);
    let count = target.points.len().max(1) as f64;
    let center = target.points.iter().map(|&point| found.apply(point)).sum::<DVec3>() / count;
    let turned = OFFSETS.map(|offset| Similarity {
        rotation: half_turn * found.rotation,
        translation: half_turn * (found.translation - center) + center + up * (offset * head.unit),
        ..found
    });
    let misfit = |transform: &Similarity| misfit(target, goal, transform, unit);
    let (misfit_of_best, best) = turned
        .into_iter()
        .map(|turned| refine(turned, target, goal, unit, scales))
        .map(|turned| (misfit(&turned), turned))
        .min_by(|one, other| one.0.total_cmp(&other.0))?;
    (misfit_of_best < CLEARER * misfit(&found)).then_some(best)
}

/// The median distance between the surfaces, from the points of the one that lies closer on the other.
fn misfit(target: &Shape, goal: &Goal, transform: &Similarity, unit: f64) -> f64 {
    const REACH: f64 = 0.1;
    /// 60°.
    const COMPATIBLE: f64 = 0.5;
    const SAMPLES: usize = 2000;
    let points = target.points.iter().map(|&point| transform.apply(point)).collect();
    let target =
        Goal::new(Shape { points, triangles: target.triangles.clone() }, goal.tree.effort());
    let distance = |from: &Shape, to: &Goal| {
        let normals = from.normals();
        let step = (from.points.len() / SAMPLES).max(1);
        let distances = (0..from.points.len()).step_by(step).map(|index| {
            let [point, normal] = [from.points[index], normals[index]];
            let partner = to.partner(TriangleKind::ANY, point, normal, REACH * unit, COMPATIBLE);
            partner.map_or(REACH * unit, |partner| partner.distance)
        });
        median(distances).unwrap_or(0.0)
    };
    distance(&target.shape, goal).min(distance(&goal.shape, &target))
}

/// Refines an alignment by iterated closest points (P. Besl and N. McKay, "A method for
/// registration of 3-D shapes", 1992), of which the nearest part counts.
pub(super) fn refine(
    start: Similarity,
    target: &Shape,
    goal: &Goal,
    unit: f64,
    scales: bool,
) -> Similarity {
    const STEPS: usize = 30;
    /// At most this share of the unit apart.
    const REACH: f64 = 0.05;
    const COMPATIBLE: f64 = 0.6;
    const SETTLED: f64 = 1e-7;
    let normals = target.normals();
    let mut found = start;
    for _ in 0..STEPS {
        let partners = map_indices(target.points.len(), |index| {
            let at = found.apply(target.points[index]);
            let normal = found.rotation * normals[index];
            let partner = goal.partner(TriangleKind::ANY, at, normal, REACH * unit, COMPATIBLE)?;
            (!goal.is_at_border(&partner)).then_some([target.points[index], partner.point])
        });
        let pairs: Vec<[DVec3; 2]> = partners.into_iter().flatten().collect();
        let distances = found.distances(&pairs);
        // Tukey's biweight at six medians: details that differ don't pull.
        let reach = (6.0 * median(distances.iter().copied()).unwrap_or(0.0)).max(1e-9 * unit);
        let weight = |distance: &f64| (1.0 - (distance / reach).powi(2)).max(0.0).powi(2);
        let weights: Vec<f64> = distances.iter().map(weight).collect();
        let Some(next) = Similarity::between(&pairs, &weights, scales) else { break };
        let step = target.points.iter().step_by(64);
        let change = step.map(|&point| next.apply(point).distance(found.apply(point)));
        let change = change.fold(0.0, f64::max);
        found = next;
        if change < SETTLED * unit {
            break;
        }
    }
    found
}
