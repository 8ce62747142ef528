//! Colour steps between adjacent texels.
//!
//! A step is the colour gradient minus noise and minus the slope that continues on both sides:
//! shading and soft shadows extend over many texels, while an edge ends after a few.

use fearless_simd::{Level, Simd};
use uvgraft_surface::statistics::order_statistic;
use uvgraft_surface::threads::{for_each, map_indices};

use super::barrier::{Barrier, FAINT, barrier};
use super::layout::BodyLayout;
use super::taps::next_texel;
use crate::layout_grid::{GridColors, LayoutGrid, NONE};
use crate::simd::dispatch;

/// Costs are in 1/16 ΔE.
pub(super) const UNITS: f32 = 16.0;
/// Slopes are measured on each side from half this distance to this distance, in texels.
const AROUND: usize = 6;
/// Factor on the surrounding slope, which is lower at the ends of a shadow's transition than at its
/// centre. At 0.8, 94 % of the skin in the beige shirt is found, not 88.8 %, and nothing else
/// changes; at 3.2, 60 % of that shirt becomes skin (the bodies of `decide`).
const SLOPE: f32 = 1.6;
/// Noise is this multiple of the 90th percentile of the steepness of skin, clamped to the range
/// below. At 0.6, 6 % of the skin in the brown shirt is lost and 7 % of the beige shirt becomes
/// skin; at 2.4, 60 % of it. The lower end of the range is flat down to 0.18; at 0.7, 60 % of that
/// shirt becomes skin.
const NOISE: f32 = 1.2;
const NOISE_RANGE: [f32; 2] = [0.35, 1.6];

/// The cost of moving between adjacent texels.
#[derive(Debug, Clone)]
pub(super) struct Steps {
    labs: Vec<Lab>,
    /// The cost of entering each texel from any neighbour on its island.
    costs: Vec<u16>,
    /// The texels close to long edges, with gaps closed.
    pub barrier: Barrier,
    noise: f32,
}

/// A colour in approximate CIELAB; padded with a 0 to four values, which fill a vector register.
type Lab = [f32; 4];

/// Approximate CIELAB, linear in sRGB values as stored. Differences between skin colours,
/// pale to dark, are accurate to some tenths.
fn lab(rgb: [f32; 3]) -> Lab {
    let [r, g, b] = rgb.map(|value| value.clamp(0.0, 1.0));
    [
        // Rows sum to 100, 0 and 0: white is white, and greys have no hue.
        29.0 * r + 65.0 * g + 6.0 * b,
        108.0 * r - 143.0 * g + 35.0 * b,
        44.0 * r + 91.0 * g - 135.0 * b,
        0.0,
    ]
}

fn squared(a: Lab, b: Lab) -> f32 {
    (0..4).map(|k| (a[k] - b[k]).powi(2)).sum()
}

fn distance(a: Lab, b: Lab) -> f32 {
    squared(a, b).sqrt()
}

impl Steps {
    pub fn new(body: &BodyLayout, colors: &GridColors) -> Self {
        let labs = softened(body, colors);
        let noise_in = |area: &[u32]| {
            let edge = |index: usize| edge(body, &labs, area[index] as usize, 0.0);
            noise_of(map_indices(area.len(), edge))
        };
        let noise = [&body.cheeks, &body.neck, &body.hands]
            .map(|area| noise_in(area))
            .into_iter()
            .fold(NOISE_RANGE[0], f32::max)
            .min(NOISE_RANGE[1]);
        // Lower steepness makes no difference to costs or barriers.
        let edges = map_indices(labs.len(), |texel| edge(body, &labs, texel, FAINT * noise));
        let cost = |&edge: &f32| ((edge - noise).max(0.0) * UNITS) as u16;
        let costs = edges.iter().map(cost).collect();
        let barrier = barrier(body, &edges, noise);
        Self { labs, costs, barrier, noise }
    }

    /// The difference of two texels' colours in approximate CIELAB; the last value is 0.
    pub fn difference(&self, from: u32, to: u32) -> [f32; 4] {
        let [from, to] = [from, to].map(|texel| self.labs[texel as usize]);
        [0, 1, 2, 3].map(|k| from[k] - to[k])
    }

    /// Visits the neighbours of a texel on the surface, with the cost of moving there.
    #[inline]
    pub fn ways(&self, body: &BodyLayout, texel: u32, mut visit: impl FnMut(u32, u16)) {
        let grid = &body.grid;
        let mut jump = |other: u32| {
            let change = distance(self.labs[texel as usize], self.labs[other as usize]);
            let cost = ((change - self.noise).max(0.0) * UNITS) as u16;
            visit(other, cost.max(self.costs[other as usize]));
        };
        if body.bits[texel as usize].is_contact() {
            body.contacts.of(texel).for_each(&mut jump);
        }
        if grid.is_inside(texel) {
            grid.each_neighbour(texel, |near| visit(near, self.costs[near as usize]));
            return;
        }
        grid.across(texel).for_each(&mut jump);
        for near in grid.beside(texel).into_iter().filter(|&near| near != NONE) {
            visit(near, self.costs[near as usize]);
        }
    }
}

/// Colours without thin dark hairs, which a morphological closing removes, and without the texture
/// of fabric, which two binomial blurs remove. Both would otherwise be taken for edges.
fn softened(body: &BodyLayout, colors: &GridColors) -> Vec<Lab> {
    let plane = |k: usize| map_indices(colors.rgb.len(), |texel| lab(colors.rgb[texel])[k]);
    let values = [plane(0), plane(1), plane(2)];
    let other = values.clone();
    let mut buffers = Buffers { body, values, other };
    buffers.pass::<Lightest>();
    buffers.pass::<Darkest>();
    buffers.pass::<Blurred>();
    buffers.pass::<Blurred>();
    let [l, a, b] = buffers.values;
    map_indices(l.len(), |texel| [l[texel], a[texel], b[texel], 0.0])
}

/// The three values of [`Lab`] as planes, so that runs of texels fill vector registers.
type Planes = [Vec<f32>; 3];

/// Adjacent texels of a row, by planes.
type Stretch<const W: usize> = [[f32; W]; 3];

/// Texels processed together.
const STRETCH: usize = 16;

/// The current values and the output buffer of the next pass.
struct Buffers<'a> {
    body: &'a BodyLayout,
    values: Planes,
    other: Planes,
}

impl Buffers<'_> {
    /// Filters along rows, then along columns.
    fn pass<K: Kernel>(&mut self) {
        for axis in 0..2 {
            along::<K>(self.body, &self.values, axis, &mut self.other);
            std::mem::swap(&mut self.values, &mut self.other);
        }
    }
}

/// A filter of five taps: a texel with the two before and the two after it.
trait Kernel {
    fn of<const W: usize>(taps: &[Stretch<W>; 5]) -> Stretch<W>;
}

struct Lightest;
struct Darkest;
struct Blurred;

impl Kernel for Lightest {
    #[inline(always)]
    fn of<const W: usize>(taps: &[Stretch<W>; 5]) -> Stretch<W> {
        extreme(taps, |tap, best| tap > best)
    }
}

impl Kernel for Darkest {
    #[inline(always)]
    fn of<const W: usize>(taps: &[Stretch<W>; 5]) -> Stretch<W> {
        extreme(taps, |tap, best| tap < best)
    }
}

impl Kernel for Blurred {
    #[inline(always)]
    fn of<const W: usize>([a, b, c, d, e]: &[Stretch<W>; 5]) -> Stretch<W> {
        let mut out = *c;
        for plane in 0..3 {
            for k in 0..W {
                let ends = a[plane][k] + e[plane][k];
                let beside = b[plane][k] + d[plane][k];
                out[plane][k] = (ends + 4.0 * beside + 6.0 * c[plane][k]) * (1.0 / 16.0);
            }
        }
        out
    }
}

/// The colour of the tap with the most extreme lightness. Colours are taken whole: extremes
/// by channel would make new ones.
#[inline(always)]
fn extreme<const W: usize>(
    taps: &[Stretch<W>; 5],
    is_beyond: impl Fn(f32, f32) -> bool,
) -> Stretch<W> {
    let mut best = taps[2];
    for tap in [&taps[0], &taps[1], &taps[3], &taps[4]] {
        for k in 0..W {
            let is_beyond = is_beyond(tap[0][k], best[0][k]);
            for plane in 0..3 {
                best[plane][k] = if is_beyond { tap[plane][k] } else { best[plane][k] };
            }
        }
    }
    best
}

/// Filters all texels along an axis.
fn along<K: Kernel>(body: &BodyLayout, values: &Planes, axis: usize, out: &mut Planes) {
    let width = body.grid.size().width as usize;
    let stride = [1, width][axis];
    let level = Level::new();
    let [a, b, c] = out;
    let rows = a.chunks_mut(width).zip(b.chunks_mut(width)).zip(c.chunks_mut(width));
    for_each(rows, |y, ((a, b), c)| {
        let mut out = [a, b, c];
        let taps = &body.taps[axis].rows[y];
        for columns in &taps.runs {
            let columns = columns.start as usize..columns.end as usize;
            let first = y * width + columns.start - 2 * stride;
            let taps = [0, 1, 2, 3, 4].map(|tap| first + tap * stride);
            let mut out = out.each_mut().map(|row| &mut row[columns.clone()]);
            dispatch!(level, simd => run::<K, _>(simd, values, taps, &mut out));
        }
        for (x, taps) in &taps.others {
            let mut values_of_taps = [[[0.0]; 3]; 5];
            for (of_tap, &tap) in values_of_taps.iter_mut().zip(taps) {
                for (value, plane) in of_tap.iter_mut().zip(values) {
                    *value = [plane[tap as usize]];
                }
            }
            for (row, [value]) in out.iter_mut().zip(K::of(&values_of_taps)) {
                row[*x as usize] = value;
            }
        }
    });
}

/// Filters a run of texels whose taps are at constant offsets.
///
/// - `taps`: the taps of the first texel.
#[inline(always)]
fn run<K: Kernel, S: Simd>(_: S, values: &Planes, taps: [usize; 5], out: &mut [&mut [f32]; 3]) {
    let len = out[0].len();
    let mut done = 0;
    while done + STRETCH <= len {
        stretch::<K, STRETCH>(values, taps, done, out);
        done += STRETCH;
    }
    while done < len {
        stretch::<K, 1>(values, taps, done, out);
        done += 1;
    }
}

#[inline(always)]
fn stretch<K: Kernel, const W: usize>(
    values: &Planes,
    taps: [usize; 5],
    first: usize,
    out: &mut [&mut [f32]; 3],
) {
    // Loops rather than `map`, which isn't compiled for the SIMD level.
    let mut stretches = [[[0.0; W]; 3]; 5];
    for (stretch, tap) in stretches.iter_mut().zip(taps) {
        for (stretch, values) in stretch.iter_mut().zip(values) {
            stretch.copy_from_slice(&values[tap + first..][..W]);
        }
    }
    for (out, found) in out.iter_mut().zip(&K::of(&stretches)) {
        out[first..first + W].copy_from_slice(found);
    }
}

/// The steepness of an edge at a texel: the gradient's magnitude less [`SLOPE`] times the slope
/// that continues on both sides, in ΔE per texel; 0 if the gradient is less than `least`.
///
/// With central differences, the gradient is `½ √(|Δx|² + |Δy|²)`. It is independent of the
/// direction of paths: with differences along the path, one that meets an edge at a small
/// angle would climb it in many steps below the noise level.
fn edge(body: &BodyLayout, values: &[Lab], texel: usize, least: f32) -> f32 {
    let grid = &body.grid;
    let width = grid.size().width as usize;
    if !body.bits[texel].is_covered() {
        return 0.0;
    }
    let [left, right, above, below] = if grid.is_inside(texel as u32) {
        [texel - 1, texel + 1, texel - width, texel + width]
    } else {
        let beside = grid.beside(texel as u32);
        beside.map(|near| next_texel(grid, texel as u32, near) as usize)
    };
    let changes = [squared(values[left], values[right]), squared(values[above], values[below])];
    let steepness = 0.5 * (changes[0] + changes[1]).sqrt();
    if steepness < least {
        return 0.0;
    }
    let axis = usize::from(changes[1] > changes[0]);
    let slope = |side: usize| slope(grid, values, texel, 2 * axis + side);
    let (Some(before), Some(behind)) = (slope(0), slope(1)) else { return steepness };
    // A slope continues on both sides, an edge does not.
    (steepness - SLOPE * before.min(behind)).max(0.0)
}

/// The mean slope from 3 to 6 texels to a side, in ΔE per texel; `None` where the island
/// ends before.
fn slope(grid: &LayoutGrid, values: &[Lab], texel: usize, side: usize) -> Option<f32> {
    let [half, end] = grid.along::<AROUND>(texel as u32, side)?;
    let change = distance(values[half as usize], values[end as usize]);
    Some(change / (AROUND - AROUND / 2) as f32)
}

/// The noise level of an area: [`NOISE`] times the 90th percentile of its texels' steepness.
fn noise_of(edges: Vec<f32>) -> f32 {
    NOISE * order_statistic(edges, |count| count * 9 / 10).unwrap_or(0.0)
}
