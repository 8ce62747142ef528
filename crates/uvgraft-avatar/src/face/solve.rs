//! Expressions as mixes of what moves a face, by least squares on what they are named after.

use glam::Vec3;
use nalgebra::{DMatrix, DVector};

use super::costs::{Costs, Head};
use super::features::Eye;
use super::measures::{Quantity, Row, row, value};
use super::movement::{Movement, local};
use super::quadratic::least;
use super::targets::{Of, TARGETS, Target};
use super::{Face, Measures};
use crate::rig::{ExpressionPreset as Preset, Morph};

/// An expression that movements cannot make, or not in full.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shortfall {
    /// Which.
    pub preset: Preset,
    /// How much of it they make, of 1.
    pub share: f32,
    /// Whether the rest of the face would come along: movements that cannot do it alone.
    pub strays: bool,
    /// Whether it was left out for that.
    pub is_left_out: bool,
}

/// Expressions, solved.
#[derive(Debug, Clone)]
pub struct Solved {
    /// A morph for each expression, by VRM's name; `blink` is both of its sides.
    pub morphs: Vec<(Preset, Morph)>,
    /// What cannot be done.
    pub shortfalls: Vec<Shortfall>,
}

/// Less than this share of an expression is none, and less than the second is worth saying.
const LEAST_SHARE: f32 = 0.5;
const WHOLE_SHARE: f32 = 0.8;
/// How far skin elsewhere may move, as a part of the largest goal: jaws take a ninth along.
const MOST_STRAY: f64 = 0.18;
/// What misses a goal by so many millimetres costs 1.
const GOAL_MM: f64 = 0.25;
/// What moves along with an expression by so many.
const OTHER_MM: f64 = 0.3;
/// Lids' margins beside their way around the eyeball.
const LID_MM: f64 = 0.4;
const LID_DEPTH_MM: f64 = 1.0;
/// What a mean square millimetre costs where left and right are not mirror images.
const ASYMMETRY: f64 = 8.0;
/// What a coefficient of 1, a standard deviation, costs.
const COEFFICIENT: f64 = 20.0;
/// Millimetres between the eyes' centres of a grown person, so that costs mean the same in any unit.
const EYES_MM: f64 = 64.0;

/// Finds VRM's expressions.
///
/// For each the coefficients `x` within their limits are found that cost least: squared misses of its
/// goals, squared changes of all else that is measured, squared movement of the skin elsewhere, what differs between
/// left and right, and `|x|²`. Blinks of both eyes are found at once, as mirror images of each other. What falls
/// short of its goal by shrinkage is scaled up to it.
///
/// - `rest`: `[vertices]` the mesh at rest that `face` was found on.
pub fn solve(face: &Face, rest: &[[f32; 3]], movements: &[Movement]) -> Solved {
    let fields = Fields::new(face, rest, movements);
    let mut solved = Solved { morphs: Vec::new(), shortfalls: Vec::new() };
    let mut targets = TARGETS.iter();
    while let Some(target) = targets.next() {
        let found = match target.preset {
            Preset::BlinkLeft => {
                let other = targets.next().unwrap_or(target);
                fields.solve_pair(face, rest, [target, other])
            }
            _ => fields.solve_one(face, rest, target),
        };
        for (target, coefficients) in found {
            let offsets = mixed(movements, &coefficients);
            let reach = fields.reach(face, rest, target, &coefficients, &offsets);
            let Reach { share, strays, scale } = reach;
            let is_left_out = share < LEAST_SHARE || strays;
            if share < WHOLE_SHARE || strays {
                let preset = target.preset;
                solved.shortfalls.push(Shortfall { preset, share, strays, is_left_out });
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

fn mixed(movements: &[Movement], coefficients: &[f64]) -> Vec<[f32; 3]> {
    let mut offsets = vec![[0.0; 3]; movements.first().map_or(0, |first| first.offsets.len())];
    for (movement, &coefficient) in movements.iter().zip(coefficients) {
        let values = offsets.as_flattened_mut().iter_mut();
        for (value, offset) in values.zip(movement.offsets.as_flattened()) {
            *value += coefficient as f32 * offset;
        }
    }
    offsets
}

/// A row of the least squares: what coefficients do to a quantity in millimetres.
struct Condition {
    row: DVector<f64>,
    wanted: f64,
    weight: f64,
}

/// Movements as tables, in millimetres of a grown person.
struct Fields {
    limits: Vec<[f64; 2]>,
    is_jaw: Vec<bool>,
    /// For each quantity what a coefficient of each movement adds to it.
    rows: Vec<(Quantity, DVector<f64>)>,
    /// For each eye and margin of a lid: up and forward, and where the margin is from the eye's centre.
    lids: [Vec<[LidRow; 2]>; 2],
    /// What movement costs.
    costs: Costs,
    mm: f64,
}

struct LidRow {
    up: DVector<f64>,
    forward: DVector<f64>,
    /// Up and forward of the eye's centre.
    place: [f64; 2],
}

impl Fields {
    fn new(face: &Face, rest: &[[f32; 3]], movements: &[Movement]) -> Self {
        let mm = EYES_MM / face.frame.unit;
        let of_row = |row: &Row| {
            let of = |movement: &Movement| f64::from(value(row, &movement.offsets)) * mm;
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
            let place = Vec3::from(local(face, spot.of(rest))) - eye.center;
            LidRow {
                up: along(axes[1]),
                forward: along(axes[2]),
                place: [place.y, place.z].map(|value| f64::from(value) * EYES_MM),
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
        let count = self.limits.len();
        let mut matrix = self.costs.moving(target.zone) + self.costs.lopsided() * ASYMMETRY;
        let mut right = DVector::zeros(count);
        self.conditions(face, rest, target).iter().for_each(|condition| {
            matrix.ger(condition.weight, &condition.row, &condition.row, 1.0);
            right.axpy(condition.weight * condition.wanted, &condition.row, 1.0);
        });
        for at in 0..count {
            matrix[(at, at)] += COEFFICIENT;
        }
        let bounds = self.bounds(target);
        least(&matrix, &right, &bounds)
            .map(|x| (target, x.iter().copied().collect()))
            .into_iter()
            .collect()
    }

    /// Two targets that are each other's mirror image.
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
            let mut own = self.costs.moving(target.zone);
            let mut wanted = DVector::zeros(count);
            for condition in self.conditions(face, rest, target) {
                own.ger(condition.weight, &condition.row, &condition.row, 1.0);
                wanted.axpy(condition.weight * condition.wanted, &condition.row, 1.0);
            }
            for at in 0..count {
                own[(at, at)] += COEFFICIENT;
            }
            let mut block = matrix.view_mut((from, from), (count, count));
            block += own;
            right.rows_mut(from, count).copy_from(&wanted);
        }
        // What the right side does, less the mirror image of what the left one does.
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

    /// What is asked of an expression.
    fn conditions(&self, face: &Face, rest: &[[f32; 3]], target: &Target) -> Vec<Condition> {
        let before = face.measure(rest);
        let mut conditions = Vec::new();
        for (quantity, row) in &self.rows {
            let goal = target.goals.iter().find(|(found, _, _)| found == quantity);
            let (wanted, tolerance) = match goal {
                Some(goal) => (self.goal_mm(face, &before, goal), GOAL_MM),
                None if target.free.contains(quantity) => continue,
                None => (0.0, OTHER_MM),
            };
            let weight = tolerance.powi(-2);
            conditions.push(Condition { row: row.clone(), wanted, weight });
        }
        match target.preset {
            Preset::BlinkLeft => self.close(0, &mut conditions),
            Preset::BlinkRight => self.close(1, &mut conditions),
            _ => {}
        }
        conditions
    }

    /// A goal in millimetres of a grown person.
    fn goal_mm(&self, face: &Face, before: &Measures, goal: &(Quantity, f32, Of)) -> f64 {
        let &(quantity, share, of) = goal;
        let whole = match (of, quantity) {
            (Of::Gap, Quantity::LidGap(side)) => f64::from(before.lid_gap[side]) * self.mm,
            (Of::Mouth, _) => f64::from(face.mouth_width) * EYES_MM,
            _ => EYES_MM,
        };
        f64::from(share) * whole
    }

    /// Margins turn about the eye's centre until they meet, three quarters of the way down.
    fn close(&self, side: usize, conditions: &mut Vec<Condition>) {
        const MEET: f64 = 0.75;
        for [upper, lower] in &self.lids[side] {
            let elevation = |lid: &LidRow| lid.place[0].atan2(lid.place[1]);
            let meet = elevation(upper) + MEET * (elevation(lower) - elevation(upper));
            for lid in [upper, lower] {
                let radius = lid.place[0].hypot(lid.place[1]);
                let [up, forward] = [radius * meet.sin(), radius * meet.cos()];
                let mut ask = |row: &DVector<f64>, wanted, tolerance: f64| {
                    conditions.push(Condition {
                        row: row.clone(),
                        wanted,
                        weight: tolerance.powi(-2),
                    });
                };
                ask(&lid.up, up - lid.place[0], LID_MM);
                ask(&lid.forward, forward - lid.place[1], LID_DEPTH_MM);
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
        const MOST: f64 = 1.35;
        let before = face.measure(rest);
        let (mut reached, mut wanted, mut largest_mm) = (0.0, 0.0, 0.0_f64);
        for goal in target.goals {
            let goal_mm = self.goal_mm(face, &before, goal);
            let found_mm = f64::from(value(&row(face, goal.0), offsets)) * self.mm;
            reached += goal_mm * found_mm;
            wanted += goal_mm * goal_mm;
            largest_mm = largest_mm.max(goal_mm.abs());
        }
        let share = if wanted > 0.0 { reached / wanted } else { 0.0 };
        let within = coefficients.iter().zip(&self.limits).map(|(&x, &[low, high])| {
            let limit = if x < 0.0 { low } else { high };
            if x.abs() < 1e-9 { f64::INFINITY } else { limit / x }
        });
        let most = within.fold(MOST, f64::min).max(1.0);
        Reach {
            share: share as f32,
            strays: self.costs.stray_mm(target.zone, coefficients) > MOST_STRAY * largest_mm,
            scale: share.recip().clamp(1.0, most) as f32,
        }
    }
}

/// What an expression comes to.
struct Reach {
    share: f32,
    strays: bool,
    /// What reaches its goals in full, as far as limits allow.
    scale: f32,
}
