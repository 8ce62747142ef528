//! How large a step of colour lies between each texel and the next.
//!
//! A step is what colours change by beyond noise and beyond how they change on around it: shading and soft shadows go
//! on for many texels, an edge is over after a few.

use crate::layout_grid::{GridColors, LayoutGrid, NONE};
use crate::threads::map_indices;

use super::BodyLayout;

/// The unit of costs: this share of a ΔE.
pub(super) const UNITS: f32 = 16.0;
/// How far on each side slopes go on, in texels.
const AROUND: usize = 5;
/// A change that nine in ten texels of skin stay below is noise; so many times that, and within this range.
const NOISE: f32 = 1.2;
const NOISE_RANGE: [f32; 2] = [0.35, 1.6];

/// What it costs to go from texels to the next.
#[derive(Debug, Clone)]
pub(super) struct Steps {
    pub seen: Vec<[f32; 3]>,
    /// To each texel, from wherever it is beside.
    costs: Vec<u16>,
    /// Edges that are long enough not to be noise, and what is close to them: gaps in them are closed.
    pub barrier: Vec<bool>,
    noise: f32,
}

/// About CIELAB, linear in values as stored: its differences, from pale to dark skin, to some tenths.
fn seen(rgb: [f32; 3]) -> [f32; 3] {
    let [r, g, b] = rgb.map(|value| value.clamp(0.0, 1.0));
    [
        29.0 * r + 65.0 * g + 6.0 * b,
        108.0 * r - 143.0 * g + 35.0 * b,
        44.0 * r + 91.0 * g - 135.0 * b,
    ]
}

pub(super) fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>().sqrt()
}

impl Steps {
    pub fn new(body: &BodyLayout, colors: &GridColors) -> Self {
        let grid = &body.grid;
        let mut values = map_indices(colors.rgb.len(), |texel| seen(colors.rgb[texel]));
        // Thin dark strands of hair vanish in a closing; a blur is what a weave vanishes in.
        for lightest in [true, true, false, false] {
            for axis in 0..2 {
                values = along(grid, &values, axis, |[before, here, after]| {
                    let pick = |a: [f32; 3], b: [f32; 3]| {
                        if (a[0] >= b[0]) == lightest { a } else { b }
                    };
                    pick(pick(before, here), after)
                });
            }
        }
        for axis in [0, 1, 0, 1, 0, 1, 0, 1] {
            values = along(grid, &values, axis, |[before, here, after]| {
                [0, 1, 2].map(|k| 0.25 * (before[k] + after[k]) + 0.5 * here[k])
            });
        }
        let edges = edges(grid, &values);
        let noise = [&body.areas.cheeks, &body.areas.neck, &body.areas.hands]
            .map(|area| noise_of(&edges, area))
            .into_iter()
            .fold(NOISE_RANGE[0], f32::max)
            .min(NOISE_RANGE[1]);
        let cost = |texel: usize| ((edges[texel] - noise).max(0.0) * UNITS) as u16;
        let costs = map_indices(edges.len(), cost);
        let barrier = barrier(body, &edges, noise);
        Self { seen: values, costs, barrier, noise }
    }

    /// The texels beside one, and what it costs to get there.
    pub fn ways<'a>(
        &'a self,
        grid: &'a LayoutGrid,
        texel: u32,
    ) -> impl Iterator<Item = (u32, u16)> + 'a {
        let beside = grid.beside(texel).into_iter().filter(|&near| near != NONE);
        let over_seams = grid.across(texel).map(move |other| {
            let change = distance(self.seen[texel as usize], self.seen[other as usize]);
            let cost = ((change - self.noise).max(0.0) * UNITS) as u16;
            (other, cost.max(self.costs[other as usize]))
        });
        beside.map(|near| (near, self.costs[near as usize])).chain(over_seams)
    }
}

/// An edge goes on where it is as steep as this share of noise, if it is long and somewhere higher than noise.
const FAINT: f32 = 0.55;
/// The least height that an edge has somewhere, in ΔE from a texel to the next beyond noise.
const LEAST_HEIGHT: f32 = 0.35;
/// The least numbers of texels of edges, and the half of gaps in them that are closed: where cloth's colour meets
/// that of a darker place of the skin, an edge has gaps, and the longer it is the less is it chance.
const GAPS: [(usize, usize); 2] = [(40, 3), (150, 10)];
/// The largest of them.
pub(super) const GAP: usize = 10;

fn barrier(body: &BodyLayout, edges: &[f32], noise: f32) -> Vec<bool> {
    let grid = &body.grid;
    let is_edge: Vec<bool> = (0..edges.len())
        .map(|texel| edges[texel] > FAINT * noise && !body.is_feature(texel))
        .collect();
    let parts = super::super::geodesic::parts(grid, &is_edge);
    let mut all = vec![false; edges.len()];
    for (least, gap) in GAPS {
        let mut found = vec![false; edges.len()];
        for part in parts.iter().filter(|part| part.len() >= least) {
            let heights = part.iter().map(|&texel| edges[texel as usize] - noise);
            if heights.fold(0.0, f32::max) >= LEAST_HEIGHT {
                part.iter().for_each(|&texel| found[texel as usize] = true);
            }
        }
        for (all, near) in all.iter_mut().zip(super::grow::widened(grid, &found, gap)) {
            *all |= near;
        }
    }
    all
}

/// Each texel from those before and behind it along an axis.
fn along(
    grid: &LayoutGrid,
    values: &[[f32; 3]],
    axis: usize,
    kernel: impl Fn([[f32; 3]; 3]) -> [f32; 3] + Sync,
) -> Vec<[f32; 3]> {
    map_indices(values.len(), |texel| {
        let here = values[texel];
        if grid.faces()[texel] == NONE {
            return here;
        }
        let beside = grid.beside(texel as u32);
        // Beyond an island's edge the surface goes on on another.
        let beyond = || grid.across(texel as u32).next().map_or(here, |near| values[near as usize]);
        let at = |near: u32| if near == NONE { beyond() } else { values[near as usize] };
        kernel([at(beside[2 * axis]), here, at(beside[2 * axis + 1])])
    })
}

/// How steep colours are at each texel, less the slope that goes on around it.
///
/// In whichever direction a way leads: along an edge that it meets at a small angle it would climb little by little.
fn edges(grid: &LayoutGrid, values: &[[f32; 3]]) -> Vec<f32> {
    let strides = [1, grid.size().width as usize];
    map_indices(values.len(), |texel| {
        if grid.faces()[texel] == NONE {
            return 0.0;
        }
        let beside = grid.beside(texel as u32);
        let here = values[texel];
        let beyond = || grid.across(texel as u32).next().map_or(here, |near| values[near as usize]);
        let at = |near: u32| if near == NONE { beyond() } else { values[near as usize] };
        let changes =
            [0, 1].map(|axis| 0.5 * distance(at(beside[2 * axis]), at(beside[2 * axis + 1])));
        let steepness = changes[0].hypot(changes[1]);
        if steepness < FAINT * NOISE_RANGE[0] {
            return 0.0;
        }
        let axis = usize::from(changes[1] > changes[0]);
        let stride = strides[axis];
        let goes_on = |side: usize| {
            let mut at = texel as u32;
            (0..=AROUND).all(|_| {
                at = grid.beside(at)[2 * axis + side];
                at != NONE
            })
        };
        if !goes_on(0) || !goes_on(1) {
            return steepness;
        }
        // A slope goes on on both sides, an edge on neither.
        let slope = |from: usize, to: usize| distance(values[from], values[to]) / 3.0;
        let [first, last] = [texel - AROUND * stride, texel + AROUND * stride];
        let slopes =
            [slope(first - stride, first + 2 * stride), slope(last - 2 * stride, last + stride)];
        (steepness - 1.6 * slopes[0].min(slopes[1])).max(0.0)
    })
}

fn noise_of(edges: &[f32], area: &[f32]) -> f32 {
    let is_in = |texel: &usize| area[*texel] >= 0.5;
    let mut changes: Vec<f32> = (0..area.len()).filter(is_in).map(|texel| edges[texel]).collect();
    if changes.is_empty() {
        return 0.0;
    }
    let most = changes.len() * 9 / 10;
    NOISE * *changes.select_nth_unstable_by(most, f32::total_cmp).1
}
