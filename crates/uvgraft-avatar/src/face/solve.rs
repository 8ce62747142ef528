//! Solves for expressions as combinations of movements, by regularised least squares on
//! measurements.

use glam::Vec3;
use nalgebra::{DMatrix, DVector};

use super::costs::{Costs, Head};
use super::features::Eye;
use super::measures::{Quantity, Row, row, value};
use super::movement::{BlendBasis, local};
use super::quadratic::least;
use super::targets::{Of, TARGETS, Target};
use super::{Face, Measures};
use crate::rig::{ExpressionPreset as Preset, Morph};

/// An expression that the movements cannot make, or only in part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnmetTarget {
    /// The expression.
    pub preset: Preset,
    /// The share of its goals that they reach, out of 1.
    pub share: f32,
    /// Whether the rest of the face moves along too much.
    pub strays: bool,
    /// Whether it was left out for either reason.
    pub is_left_out: bool,
}

/// The solved expressions.
#[derive(Debug, Clone)]
pub struct Solved {
    /// A morph for each expression, with VRM's name; `blink` is left out, being both of its sides.
    pub morphs: Vec<(Preset, Morph)>,
    /// Expressions that could not be made, or not in full.
    pub shortfalls: Vec<UnmetTarget>,
}

/// Expressions below the first share of their goals are left out, those below the second are
/// reported.
const MIN_SHARE: f32 = 0.5;
const WHOLE_SHARE: f32 = 0.8;
/// Limit of the stray movement of the skin elsewhere, relative to the largest goal: a
/// jaw alone has a ninth.
const MAX_STRAY: f64 = 0.18;
/// Missing a goal by this many millimetres costs 1.
const GOAL_MM: f64 = 0.25;
/// The same for quantities that should not change.
const OTHER_MM: f64 = 0.3;
/// The same for the margins of closing lids, off their path around the eyeball: vertically, and in
/// depth.
const LID_MM: f64 = 0.4;
const LID_DEPTH_MM: f64 = 1.0;
/// Cost of a mean square millimetre of difference between left and right.
const ASYMMETRY: f64 = 8.0;
/// Cost of a coefficient of 1, which is one standard deviation.
const COEFFICIENT: f64 = 20.0;
/// Distance between an adult's eye centres in millimetres, so that costs mean the same in any unit.
const EYES_MM: f64 = 64.0;

/// Solves for VRM's expressions.
///
/// For each, finds the coefficients `x` within their limits that minimise the sum of the squared
/// misses of its goals, the squared changes of all other measurements, the squared movement of the
/// skin elsewhere, the difference between left and right, and `|x|²`. The penalties keep the
/// solution natural, since the few goals alone leave most coefficients undetermined. The blinks of
/// the two eyes are solved together, as mirror images of each other. Results that fall short of
/// their goals due to the penalties are scaled up.
///
/// - `rest`: `[vertices]` the rest positions of the mesh that `face` was located on.
pub fn solve(face: &Face, rest: &[[f32; 3]], movements: &[BlendBasis]) -> Solved {
    let effects = Effects::new(face, rest, movements);
    let mut solved = Solved { morphs: Vec::new(), shortfalls: Vec::new() };
    let mut targets = TARGETS.iter();
    while let Some(target) = targets.next() {
        let found = match target.preset {
            Preset::BlinkLeft => {
                let other = targets.next().unwrap_or(target);
                effects.solve_pair(face, rest, [target, other])
            }
            _ => effects.solve_one(face, rest, target),
        };
        for (target, coefficients) in found {
            let offsets = combined(movements, &coefficients);
            let reach = effects.reach(face, rest, target, &coefficients, &offsets);
            let Reach { share, strays, scale } = reach;
            let is_left_out = share < MIN_SHARE || strays;
            if share < WHOLE_SHARE || strays {
                let preset = target.preset;
                solved.shortfalls.push(UnmetTarget { preset, share, strays, is_left_out });
            }
            if !is_left_out {
                let scaled: Vec<[f32; 3]> =
                    offsets.iter().map(|offset| offset.map(|value| value * scale)).collect();
                let morph = Morph::from_dense(target.preset.name(), &scaled);
                solved.morphs.push((target.preset, morph));
            }
        }
    }
    solved
}

fn combined(movements: &[BlendBasis], coefficients: &[f64]) -> Vec<[f32; 3]> {
    let mut offsets = vec![[0.0; 3]; movements.first().map_or(0, |first| first.offsets.len())];
    for (movement, &coefficient) in movements.iter().zip(coefficients) {
        let values = offsets.as_flattened_mut().iter_mut();
        for (value, offset) in values.zip(movement.offsets.as_flattened()) {
            *value += coefficient as f32 * offset;
        }
    }
    offsets
}

/// A row of the least-squares problem: the effect of the coefficients on a quantity, in
/// millimetres.
struct Condition {
    row: DVector<f64>,
    desired: f64,
    weight: f64,
}

/// Linear effects of the movements, in millimetres of an adult's head.
struct Effects {
    limits: Vec<[f64; 2]>,
    is_jaw: Vec<bool>,
    /// For each quantity, its change with the coefficient of each movement.
    rows: Vec<(Quantity, DVector<f64>)>,
    /// For each eye, the upper and lower margin in each column of its lids.
    lids: [Vec<[LidRow; 2]>; 2],
    /// Costs of moving the skin.
    costs: Costs,
    mm: f64,
}

struct LidRow {
    up: DVector<f64>,
    forward: DVector<f64>,
    /// Up and forward offset from the eye's centre.
    offset: [f64; 2],
}

impl Effects {
    fn new(face: &Face, rest: &[[f32; 3]], movements: &[BlendBasis]) -> Self {
        let mm = EYES_MM / face.frame.unit;
        let of_row = |row: &Row| {
            let of = |movement: &BlendBasis| f64::from(value(row, &movement.offsets)) * mm;
            DVector::from_iterator(movements.len(), movements.iter().map(of))
        };
        let rows = Quantity::ALL.map(|quantity| (quantity, of_row(&row(face, quantity))));
        let axes = face.frame.axes.map(|axis| Vec3::from(axis.map(|value| value as f32)));
        let lid_row = |spot: &super::surface::Spot, eye: &Eye| {
            let along = |axis: Vec3| {
                let row =
                    spot.parts().iter().map(|&(vertex, part)| (vertex, axis * part)).collect();
                of_row(&row)
            };
            let offset = Vec3::from(local(face, spot.of(rest))) - eye.center;
            LidRow {
                up: along(axes[1]),
                forward: along(axes[2]),
                offset: [offset.y, offset.z].map(|value| f64::from(value) * EYES_MM),
            }
        };
        let lids = [0, 1].map(|side| {
            let eye = &face.eyes[side];
            let pair = |lid: &super::features::Opening| {
                [lid_row(&lid.upper, eye), lid_row(&lid.lower, eye)]
            };
            eye.lids.iter().map(pair).collect()
        });
        let head = Head::new(face, rest);
        Self {
            limits: movements.iter().map(|movement| movement.limits.map(f64::from)).collect(),
            is_jaw: movements.iter().map(|movement| movement.is_jaw).collect(),
            rows: rows.into(),
            lids,
            costs: Costs::new(&head, movements, &axes, mm as f32),
            mm,
        }
    }

    fn solve_one<'t>(
        &self,
        face: &Face,
        rest: &[[f32; 3]],
        target: &'t Target,
    ) -> Vec<(&'t Target, Vec<f64>)> {
        let costs = self.costs.moving(target.zone) + self.costs.asymmetry() * ASYMMETRY;
        let (matrix, right) = self.system(face, rest, target, costs);
        let bounds = self.bounds(target);
        least(&matrix, &right, &bounds)
            .map(|x| (target, x.iter().copied().collect()))
            .into_iter()
            .collect()
    }

    /// The matrix and the right-hand side for a target.
    ///
    /// - `costs`: of the coefficients, besides their own size.
    fn system(
        &self,
        face: &Face,
        rest: &[[f32; 3]],
        target: &Target,
        costs: DMatrix<f64>,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let (mut matrix, mut right) = (costs, DVector::zeros(self.limits.len()));
        for condition in self.conditions(face, rest, target) {
            matrix.ger(condition.weight, &condition.row, &condition.row, 1.0);
            right.axpy(condition.weight * condition.desired, &condition.row, 1.0);
        }
        for at in 0..right.len() {
            matrix[(at, at)] += COEFFICIENT;
        }
        (matrix, right)
    }

    /// Solves two targets that are mirror images of each other, as one system of twice the size
    /// that penalises the difference between one side and the mirror image of the other.
    fn solve_pair<'t>(
        &self,
        face: &Face,
        rest: &[[f32; 3]],
        targets: [&'t Target; 2],
    ) -> Vec<(&'t Target, Vec<f64>)> {
        let count = self.limits.len();
        let mut matrix = DMatrix::zeros(2 * count, 2 * count);
        let mut right = DVector::zeros(2 * count);
        for (side, target) in targets.into_iter().enumerate() {
            let from = side * count;
            let (own, desired) = self.system(face, rest, target, self.costs.moving(target.zone));
            let mut block = matrix.view_mut((from, from), (count, count));
            block += own;
            right.rows_mut(from, count).copy_from(&desired);
        }
        // Penalty on the movement of the right side minus the mirrored movement of the left side.
        let Costs { straight, mirrored, crossed, .. } = &self.costs;
        for (at, block) in [
            ((0, 0), mirrored.clone()),
            ((count, count), straight.clone()),
            ((0, count), -crossed),
            ((count, 0), -crossed.transpose()),
        ] {
            let mut view = matrix.view_mut(at, (count, count));
            view += block * ASYMMETRY;
        }
        let bounds = [self.bounds(targets[0]), self.bounds(targets[1])].concat();
        let Some(x) = least(&matrix, &right, &bounds) else { return Vec::new() };
        let side = |from: usize| x.rows(from, count).iter().copied().collect();
        vec![(targets[0], side(0)), (targets[1], side(count))]
    }

    fn bounds(&self, target: &Target) -> Vec<[f64; 2]> {
        let limits = self.limits.iter().zip(&self.is_jaw);
        limits
            .map(|(&limits, &is_jaw)| if is_jaw && !target.jaw { [0.0; 2] } else { limits })
            .collect()
    }

    /// The conditions of an expression: its goals, and no change of other quantities.
    fn conditions(&self, face: &Face, rest: &[[f32; 3]], target: &Target) -> Vec<Condition> {
        let before = face.measure(rest);
        let mut conditions = Vec::new();
        for (quantity, row) in &self.rows {
            let goal = target.goals.iter().find(|(found, _, _)| found == quantity);
            let (desired, tolerance) = match goal {
                Some(goal) => (self.goal_mm(face, &before, goal), GOAL_MM),
                None if target.free.contains(quantity) => continue,
                None => (0.0, OTHER_MM),
            };
            let weight = tolerance.powi(-2);
            conditions.push(Condition { row: row.clone(), desired, weight });
        }
        match target.preset {
            Preset::BlinkLeft => self.close(0, &mut conditions),
            Preset::BlinkRight => self.close(1, &mut conditions),
            _ => {}
        }
        conditions
    }

    /// A goal in millimetres of an adult's head.
    fn goal_mm(&self, face: &Face, before: &Measures, goal: &(Quantity, f32, Of)) -> f64 {
        let &(quantity, share, of) = goal;
        let whole = match (of, quantity) {
            (Of::Gap, Quantity::LidGap(side)) => f64::from(before.lid_gap[side]) * self.mm,
            (Of::Mouth, _) => f64::from(face.mouth_width) * EYES_MM,
            _ => EYES_MM,
        };
        f64::from(share) * whole
    }

    /// Makes both margins of the lids rotate about the eye's centre until they meet, three quarters
    /// of the way down. A goal for the gap alone would move them straight through the eyeball.
    fn close(&self, side: usize, conditions: &mut Vec<Condition>) {
        const MEET: f64 = 0.75;
        for [upper, lower] in &self.lids[side] {
            let elevation = |lid: &LidRow| lid.offset[0].atan2(lid.offset[1]);
            let meet = elevation(upper) + MEET * (elevation(lower) - elevation(upper));
            for lid in [upper, lower] {
                let radius = lid.offset[0].hypot(lid.offset[1]);
                let [up, forward] = [radius * meet.sin(), radius * meet.cos()];
                let mut require = |row: &DVector<f64>, desired, tolerance: f64| {
                    conditions.push(Condition {
                        row: row.clone(),
                        desired,
                        weight: tolerance.powi(-2),
                    });
                };
                require(&lid.up, up - lid.offset[0], LID_MM);
                require(&lid.forward, forward - lid.offset[1], LID_DEPTH_MM);
            }
        }
    }

    /// How much of its goals an expression reaches.
    fn reach(
        &self,
        face: &Face,
        rest: &[[f32; 3]],
        target: &Target,
        coefficients: &[f64],
        offsets: &[[f32; 3]],
    ) -> Reach {
        const MAX: f64 = 1.35;
        let before = face.measure(rest);
        let (mut reached, mut desired, mut largest_mm) = (0.0, 0.0, 0.0_f64);
        for goal in target.goals {
            let goal_mm = self.goal_mm(face, &before, goal);
            let found_mm = f64::from(value(&row(face, goal.0), offsets)) * self.mm;
            reached += goal_mm * found_mm;
            desired += goal_mm * goal_mm;
            largest_mm = largest_mm.max(goal_mm.abs());
        }
        let share = if desired > 0.0 { reached / desired } else { 0.0 };
        let within = coefficients.iter().zip(&self.limits).map(|(&x, &[low, high])| {
            let limit = if x < 0.0 { low } else { high };
            if x.abs() < 1e-9 { f64::INFINITY } else { limit / x }
        });
        let most = within.fold(MAX, f64::min).max(1.0);
        Reach {
            share: share as f32,
            strays: self.costs.stray_mm(target.zone, coefficients) > MAX_STRAY * largest_mm,
            scale: share.recip().clamp(1.0, most) as f32,
        }
    }
}

/// Evaluation of a solved expression.
struct Reach {
    share: f32,
    strays: bool,
    /// Factor to reach the goals in full, as far as the limits allow.
    scale: f32,
}
