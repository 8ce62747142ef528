//! Matches the profile of a face against a planar section of the mesh.

use glam::DVec3;

use super::points::Points;
use crate::directions::perpendicular;

/// Profile of an adult face on the midline, from hairline to chin: height and depth relative to the
/// centre between the eyeballs, in distances between the eyes. Rounded facial proportions (sellion,
/// pronasale, subnasale, stomion, pogonion and points between them).
const TEMPLATE: [[f64; 2]; 24] = [
    [1.2, 0.15],
    [1.0, 0.26],
    [0.8, 0.34],
    [0.6, 0.4],
    [0.45, 0.43],
    [0.3, 0.43],
    [0.15, 0.38],
    [0.02, 0.36],
    [-0.1, 0.4],
    [-0.22, 0.48],
    [-0.35, 0.58],
    [-0.48, 0.67],
    TIP,
    [-0.72, 0.64],
    [-0.82, 0.5],
    [-0.93, 0.5],
    [-1.03, 0.52],
    [-1.12, 0.46],
    [-1.22, 0.48],
    [-1.36, 0.37],
    [-1.5, 0.36],
    [-1.65, 0.37],
    [-1.8, 0.25],
    [-1.95, -0.1],
];
/// The tip of the nose in [`TEMPLATE`].
const TIP: [f64; 2] = [-0.6, 0.74];
/// Deviations are clamped to this, so that single outliers don't dominate the mean. Origin not
/// recorded.
const LARGEST_DEVIATION: f64 = 0.5;

/// The intersection of a mesh with a plane, as segments in the plane's coordinates.
pub(super) struct Section {
    origin: DVec3,
    axes: [DVec3; 2],
    segments: Vec<[[f64; 2]; 2]>,
}

/// The position of a face in space, matched by its profile.
#[derive(Debug, Clone, Copy)]
pub(super) struct FaceFit {
    /// Mean deviation from the profile of a face, in distances between the eyes.
    pub deviation: f64,
    /// The point halfway between the eyes.
    pub origin: DVec3,
    pub up: DVec3,
    pub forward: DVec3,
    /// The distance between the eyes.
    pub unit: f64,
}

/// Penalty on the deviation of orientations that the rest of the mesh contradicts. Narrow
/// or flat heads deviate by a tenth even when upright.
const UPSIDE_DOWN: f64 = 0.08;

/// An orientation of a section: the angle of forward, and the side of it on which up is.
#[derive(Debug, Clone, Copy)]
struct Turn {
    angle: f64,
    is_mirrored: bool,
}

impl Turn {
    fn up_and_forward(self) -> [[f64; 2]; 2] {
        let (sin, cos) = self.angle.sin_cos();
        let up = if self.is_mirrored { [sin, -cos] } else { [-sin, cos] };
        [up, [cos, sin]]
    }

    fn all(steps: usize) -> impl Iterator<Item = Self> {
        (0..2 * steps).map(move |index| Self {
            angle: (index / 2) as f64 * std::f64::consts::TAU / steps as f64,
            is_mirrored: index % 2 == 1,
        })
    }

    fn near(self, step: f64) -> impl Iterator<Item = Self> {
        (-2..=2).map(move |k| Self { angle: self.angle + f64::from(k) * step, ..self })
    }
}

/// A candidate for the face in a section: its eyes are in coordinates of the rotated section.
#[derive(Debug, Clone, Copy)]
struct Guess {
    deviation: f64,
    turn: Turn,
    eyes: [f64; 2],
    unit: f64,
}

impl Section {
    /// Intersects the triangles of the `wanted` components within `reach` of `origin` with the plane
    /// through it normal to `normal`.
    pub fn new(
        points: &Points,
        wanted: impl Fn(u32) -> bool,
        origin: DVec3,
        normal: DVec3,
        reach: f64,
    ) -> Self {
        let first = perpendicular(normal);
        let axes = [first, normal.cross(first)];
        let heights: Vec<f64> =
            points.positions.iter().map(|&point| (point - origin).dot(normal)).collect();
        let mut segments = Vec::new();
        for &triangle in &points.triangles {
            let height = triangle.map(|point| heights[point as usize]);
            let above = height.map(|height| height >= 0.0);
            let is_crossed = above[0] != above[1] || above[1] != above[2];
            if !is_crossed || !wanted(points.component[triangle[0] as usize]) {
                continue;
            }
            let corners = points.corners(triangle);
            let mut ends = [[0.0; 2]; 2];
            let mut count = 0;
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                if above[a] != above[b] && count < 2 {
                    let along = height[a] / (height[a] - height[b]);
                    let offset = corners[a].lerp_monotonic(corners[b], along) - origin;
                    ends[count] = axes.map(|axis| offset.dot(axis));
                    count += 1;
                }
            }
            if ends.iter().all(|end| end[0].hypot(end[1]) < reach) {
                segments.push(ends);
            }
        }
        Self { origin, axes, segments }
    }

    /// The best orientations of the face if the eyes are known, likeliest first: that of all angles
    /// in steps of 10 degrees, refined down to 0.02 degrees, and the best in which up is on the other
    /// side.
    pub fn around_eyes(&self, unit: f64) -> [FaceFit; 2] {
        let deviation = |turn: Turn| {
            let outline = Outline::new(self, turn, [-2.2 * unit, 1.5 * unit], 93);
            let unlikely = if self.is_upside_down(turn) { UPSIDE_DOWN } else { 0.0 };
            outline.deviation([0.0, 0.0], unit, f64::INFINITY) + unlikely
        };
        let refined = |mut best: (f64, Turn)| {
            for degrees in [3.0_f64, 1.0, 0.4, 0.15, 0.05, 0.02] {
                best = least(best.1.near(degrees.to_radians()), deviation);
            }
            self.found(best.0, best.1, [0.0, 0.0], unit)
        };
        let best = least(Turn::all(36), deviation);
        let [up, _] = best.1.up_and_forward();
        let is_other = |turn: &Turn| {
            let [other, _] = turn.up_and_forward();
            up[0] * other[0] + up[1] * other[1] < 0.0
        };
        [refined(best), refined(least(Turn::all(36).filter(is_other), deviation))]
    }

    /// Whether the section extends far more above the eyes than below: a neck or body does, a
    /// skull doesn't.
    fn is_upside_down(&self, turn: Turn) -> bool {
        let [up, _] = turn.up_and_forward();
        let heights = self.segments.iter().flatten().map(|[p, q]| p * up[0] + q * up[1]);
        let [low, high] = heights.fold([0.0_f64; 2], |[low, high], y| [low.min(y), high.max(y)]);
        high > 1.4 * -low
    }

    /// Up to 8 candidates for the face if the eyes are unknown, likeliest first.
    ///
    /// Exhaustive search over orientations and scales, with the nose at each local maximum of the
    /// outline, since the deviation has many local minima. The best candidates are then refined in
    /// angle and scale.
    pub fn anywhere(&self) -> Vec<FaceFit> {
        const MAX: usize = 8;
        let reach = self.segments.iter().flatten().map(|end| end[0].hypot(end[1]));
        let reach = reach.fold(0.0, f64::max);
        let units: Vec<f64> = (0..20).map(|k| reach / 17.0 * 1.13_f64.powi(k)).collect();
        let all = Turn::all(36).filter_map(|turn| self.best_guess(turn, &units, reach, 900));
        let mut guesses: Vec<Guess> = all.collect();
        guesses.sort_by(|a, b| a.deviation.total_cmp(&b.deviation));
        guesses.truncate(MAX);
        for guess in &mut guesses {
            for step in [0.05, 0.02] {
                let units = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|k| guess.unit * (1.0 + step * k));
                let near = guess.turn.near(step);
                let all = near.filter_map(|turn| self.best_guess(turn, &units, reach, 1200));
                let best = all.min_by(|a, b| a.deviation.total_cmp(&b.deviation));
                *guess = best.unwrap_or(*guess);
            }
        }
        guesses.sort_by(|a, b| a.deviation.total_cmp(&b.deviation));
        let found = |guess: Guess| self.found(guess.deviation, guess.turn, guess.eyes, guess.unit);
        guesses.into_iter().map(found).collect()
    }

    /// The best candidate for an orientation, over all scales in `units`.
    fn best_guess(&self, turn: Turn, units: &[f64], reach: f64, bins: usize) -> Option<Guess> {
        let outline = Outline::new(self, turn, [-reach, reach], bins);
        let mut best: Option<Guess> = None;
        for &unit in units {
            outline.for_each_tip(unit, |eyes| {
                let limit = best.map_or(LARGEST_DEVIATION, |best| best.deviation);
                let deviation = outline.deviation(eyes, unit, limit);
                if deviation < limit {
                    best = Some(Guess { deviation, turn, eyes, unit });
                }
            });
        }
        best
    }

    fn found(&self, deviation: f64, turn: Turn, eyes: [f64; 2], unit: f64) -> FaceFit {
        let [up, forward] = turn.up_and_forward();
        let space = |[a, b]: [f64; 2]| [self.axes[0] * a, self.axes[1] * b].iter().sum();
        let (up, forward): (DVec3, DVec3) = (space(up), space(forward));
        let origin = self.origin + up * eyes[0] + forward * eyes[1];
        FaceFit { deviation, origin, up, forward, unit }
    }
}

fn least(turns: impl Iterator<Item = Turn>, deviation: impl Fn(Turn) -> f64) -> (f64, Turn) {
    let first = (f64::INFINITY, Turn { angle: 0.0, is_mirrored: false });
    turns.map(|turn| (deviation(turn), turn)).fold(
        first,
        |best, next| {
            if next.0 < best.0 { next } else { best }
        },
    )
}

/// The foremost depth at each height of a rotated section.
struct Outline {
    low: f64,
    step: f64,
    depths: Vec<f64>,
}

impl Outline {
    fn new(section: &Section, turn: Turn, [low, high]: [f64; 2], bins: usize) -> Self {
        let [up, forward] = turn.up_and_forward();
        let step = (high - low) / bins as f64;
        let mut depths = vec![f64::NEG_INFINITY; bins];
        for ends in &section.segments {
            let [a, b] = ends.map(|[p, q]| {
                let height = (p * up[0] + q * up[1] - low) / step - 0.5;
                [height, p * forward[0] + q * forward[1]]
            });
            let (a, b) = if a[0] <= b[0] { (a, b) } else { (b, a) };
            let (first, last) = (a[0].ceil().max(0.0), b[0].floor().min(bins as f64 - 1.0));
            if first > last {
                continue;
            }
            let slope = (b[1] - a[1]) / (b[0] - a[0]).max(1e-12);
            for bin in first as usize..=last as usize {
                let depth = a[1] + slope * (bin as f64 - a[0]);
                depths[bin] = depths[bin].max(depth);
            }
        }
        Self { low, step, depths }
    }

    fn at(&self, height: f64) -> f64 {
        let bin = (height - self.low) / self.step;
        if bin < 0.0 { f64::NEG_INFINITY } else { self.get(bin as usize) }
    }

    fn get(&self, bin: usize) -> f64 {
        self.depths.get(bin).copied().unwrap_or(f64::NEG_INFINITY)
    }

    /// Mean absolute deviation of the outline from [`TEMPLATE`] with the eyes at a height and
    /// depth, in distances between the eyes; any value above `limit` if it exceeds that.
    fn deviation(&self, eyes: [f64; 2], unit: f64, limit: f64) -> f64 {
        let limit = limit * TEMPLATE.len() as f64;
        let mut sum = 0.0;
        for [height, depth] in TEMPLATE {
            let found = (self.at(eyes[0] + height * unit) - eyes[1]) / unit;
            sum += (found - depth).abs().min(LARGEST_DEVIATION);
            if sum > limit {
                break;
            }
        }
        sum / TEMPLATE.len() as f64
    }

    /// Visits the positions of the eyes that follow if the tip of the nose is at a local
    /// maximum of the outline, for each maximum that may be a nose.
    fn for_each_tip(&self, unit: f64, mut visit: impl FnMut([f64; 2])) {
        let beside = ((0.2 * unit / self.step) as usize).max(1);
        for bin in beside..self.depths.len().saturating_sub(beside) {
            let depth = self.depths[bin];
            if !depth.is_finite() || self.get(bin - 1) > depth || self.get(bin + 1) > depth {
                continue;
            }
            let height = self.low + (bin as f64 + 0.5) * self.step;
            // A nose protrudes from the line between brow and upper lip.
            let [brow, lip] = [0.9, -0.35].map(|above| self.at(height + above * unit));
            if depth - 0.28 * brow - 0.72 * lip < 0.12 * unit {
                continue;
            }
            if self.get(bin - beside) < depth && self.get(bin + beside) < depth - 0.03 * unit {
                visit([height - TIP[0] * unit, depth - TIP[1] * unit]);
            }
        }
    }
}
