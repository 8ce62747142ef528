//! How large a step of colour lies between each texel and those beside it.
//!
//! A step is how steep colours are beyond noise and beyond the slope that goes on around: shading and soft shadows
//! go on for many texels, an edge is over after a few.

use crate::layout_grid::{GridColors, LayoutGrid, NONE};
use crate::threads::{for_each_chunk, map_indices};

use super::barrier::{Barrier, barrier};
use super::layout::BodyLayout;

/// The unit of costs: this share of a ΔE.
pub(super) const UNITS: f32 = 16.0;
/// How far on each side slopes go on, in texels: from half of it to it.
const AROUND: usize = 6;
/// How many times the slope around counts. Where light and shadow meet it is less than in the middle.
const SLOPE: f32 = 1.6;
/// A steepness that nine in ten texels of skin stay below is noise; so many times that, and within this range.
const NOISE: f32 = 1.2;
const NOISE_RANGE: [f32; 2] = [0.35, 1.6];
/// An edge goes on where it is as steep as this share of noise.
pub(super) const FAINT: f32 = 0.55;

/// What it costs to go from texels to those beside them.
#[derive(Debug, Clone)]
pub(super) struct Steps {
    seen: Vec<Seen>,
    /// To each texel, from wherever it is beside.
    costs: Vec<u16>,
    /// What is close to long edges: gaps in them are closed.
    pub barrier: Barrier,
    noise: f32,
}

/// A colour, about as one sees it; four values fill a vector register, the last is 0.
type Seen = [f32; 4];

/// About CIELAB, linear in values as stored: its differences, from pale to dark skin, to some tenths.
fn seen(rgb: [f32; 3]) -> Seen {
    let [r, g, b] = rgb.map(|value| value.clamp(0.0, 1.0));
    [
        29.0 * r + 65.0 * g + 6.0 * b,
        108.0 * r - 143.0 * g + 35.0 * b,
        44.0 * r + 91.0 * g - 135.0 * b,
        0.0,
    ]
}

fn squared(a: Seen, b: Seen) -> f32 {
    (0..4).map(|k| (a[k] - b[k]).powi(2)).sum()
}

fn distance(a: Seen, b: Seen) -> f32 {
    squared(a, b).sqrt()
}

impl Steps {
    pub fn new(body: &BodyLayout, colors: &GridColors) -> Self {
        let seen = softened(body, colors);
        let edges = edges(body, &seen);
        let noise = [&body.cheeks, &body.neck, &body.hands]
            .map(|area| noise_of(&edges, area))
            .into_iter()
            .fold(NOISE_RANGE[0], f32::max)
            .min(NOISE_RANGE[1]);
        let cost = |&edge: &f32| ((edge - noise).max(0.0) * UNITS) as u16;
        let costs = edges.iter().map(cost).collect();
        let barrier = barrier(body, &edges, noise);
        Self { seen, costs, barrier, noise }
    }

    /// How far one texel's colour is from another's, about as CIELAB has it; the last value is 0.
    pub fn difference(&self, from: u32, to: u32) -> [f32; 4] {
        let [from, to] = [from, to].map(|texel| self.seen[texel as usize]);
        [0, 1, 2, 3].map(|k| from[k] - to[k])
    }

    /// The texels beside one, and what it costs to get there.
    #[inline]
    pub fn ways(&self, grid: &LayoutGrid, texel: u32, mut visit: impl FnMut(u32, u16)) {
        for near in grid.beside(texel) {
            if near != NONE {
                visit(near, self.costs[near as usize]);
            }
        }
        for other in grid.across(texel) {
            let change = distance(self.seen[texel as usize], self.seen[other as usize]);
            let cost = ((change - self.noise).max(0.0) * UNITS) as u16;
            visit(other, cost.max(self.costs[other as usize]));
        }
    }
}

/// Colours as they are seen without thin dark strands of hair, which vanish in a closing, and without a weave, which
/// vanishes in a blur.
fn softened(body: &BodyLayout, colors: &GridColors) -> Vec<Seen> {
    let values = map_indices(colors.rgb.len(), |texel| seen(colors.rgb[texel]));
    let other = vec![[0.0; 4]; values.len()];
    let mut buffers = Buffers { body, values, other };
    buffers.pass(lightest);
    buffers.pass(darkest);
    buffers.pass(blurred);
    buffers.pass(blurred);
    buffers.values
}

/// Values, and where the next ones go.
struct Buffers<'a> {
    body: &'a BodyLayout,
    values: Vec<Seen>,
    other: Vec<Seen>,
}

impl Buffers<'_> {
    /// Along rows, then along columns.
    fn pass(&mut self, kernel: impl Fn([Seen; 5]) -> Seen + Sync) {
        for axis in 0..2 {
            along(self.body, &self.values, axis, &kernel, &mut self.other);
            std::mem::swap(&mut self.values, &mut self.other);
        }
    }
}

#[inline(always)]
fn lightest(taps: [Seen; 5]) -> Seen {
    taps.into_iter().fold(taps[2], |best, tap| if tap[0] > best[0] { tap } else { best })
}

#[inline(always)]
fn darkest(taps: [Seen; 5]) -> Seen {
    taps.into_iter().fold(taps[2], |best, tap| if tap[0] < best[0] { tap } else { best })
}

#[inline(always)]
fn blurred([a, b, c, d, e]: [Seen; 5]) -> Seen {
    [0, 1, 2, 3].map(|k| (a[k] + e[k] + 4.0 * (b[k] + d[k]) + 6.0 * c[k]) / 16.0)
}

/// What is beside a texel along an axis: beyond an island's edge what is across the seam, or itself.
#[inline(always)]
fn next_value(grid: &LayoutGrid, values: &[Seen], texel: u32, near: u32) -> Seen {
    if near != NONE {
        return values[near as usize];
    }
    let beyond = grid.across(texel).next().unwrap_or(texel);
    values[beyond as usize]
}

/// Each texel from the two before and the two behind it along an axis.
fn along(
    body: &BodyLayout,
    values: &[Seen],
    axis: usize,
    kernel: impl Fn([Seen; 5]) -> Seen + Sync,
    out: &mut [Seen],
) {
    let grid = &body.grid;
    let width = grid.size().width as usize;
    let stride = [1, width][axis];
    for_each_chunk(out, width, |y, row| {
        for (x, out) in row.iter_mut().enumerate() {
            let at = y * width + x;
            let bits = body.bits[at];
            if bits.is_within(axis) {
                let taps = [at - 2 * stride, at - stride, at, at + stride, at + 2 * stride];
                *out = kernel(taps.map(|tap| values[tap]));
                continue;
            }
            if !bits.is_covered() {
                continue;
            }
            let texel = at as u32;
            let side = |side: usize| {
                let near = grid.beside(texel)[2 * axis + side];
                let first = next_value(grid, values, texel, near);
                let second = if near == NONE { NONE } else { grid.beside(near)[2 * axis + side] };
                [first, if second == NONE { first } else { values[second as usize] }]
            };
            let ([b, a], [d, e]) = (side(0), side(1));
            *out = kernel([a, b, values[texel as usize], d, e]);
        }
    });
}

/// How steep colours are at each texel, less the slope that goes on around it.
///
/// In whichever direction a way leads: along an edge that it meets at a small angle it would climb little by little.
fn edges(body: &BodyLayout, values: &[Seen]) -> Vec<f32> {
    let grid = &body.grid;
    let width = grid.size().width as usize;
    map_indices(values.len(), |texel| {
        let bits = body.bits[texel];
        if !bits.is_covered() {
            return 0.0;
        }
        let beside = if bits.is_within(0) && bits.is_within(1) {
            [texel - 1, texel + 1, texel - width, texel + width].map(|near| values[near])
        } else {
            grid.beside(texel as u32).map(|near| next_value(grid, values, texel as u32, near))
        };
        let at = |side: usize| beside[side];
        let changes = [squared(at(0), at(1)), squared(at(2), at(3))];
        let steepness = 0.5 * (changes[0] + changes[1]).sqrt();
        if steepness < FAINT * NOISE_RANGE[0] {
            return 0.0;
        }
        let axis = usize::from(changes[1] > changes[0]);
        let slopes = [0, 1].map(|side| slope(grid, values, texel, 2 * axis + side));
        let [Some(before), Some(behind)] = slopes else { return steepness };
        // A slope goes on on both sides, an edge on neither.
        (steepness - SLOPE * before.min(behind)).max(0.0)
    })
}

/// The slope some texels to a side; `None` where the island ends before.
fn slope(grid: &LayoutGrid, values: &[Seen], texel: usize, side: usize) -> Option<f32> {
    let (mut at, mut half) = (texel as u32, texel);
    for step in 1..=AROUND {
        at = grid.beside(at)[side];
        if at == NONE {
            return None;
        }
        if step == AROUND / 2 {
            half = at as usize;
        }
    }
    Some(distance(values[half], values[at as usize]) / (AROUND - AROUND / 2) as f32)
}

fn noise_of(edges: &[f32], area: &[u32]) -> f32 {
    let mut changes: Vec<f32> = area.iter().map(|&texel| edges[texel as usize]).collect();
    if changes.is_empty() {
        return 0.0;
    }
    let most = changes.len() * 9 / 10;
    NOISE * *changes.select_nth_unstable_by(most, f32::total_cmp).1
}
