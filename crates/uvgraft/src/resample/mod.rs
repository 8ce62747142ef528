//! Filling a texture through a sampling map.
//!
//! [`reference()`](reference::resample) is the specification. The fast path does the same arithmetic
//! in the same order, so that both give the same bits.

pub(crate) mod fast;
pub mod reference;

use crate::filter::Filter;
use crate::map::{Patch, Run, SamplingMap};
use crate::texture::{Size, Value};

/// The most samples per texel and axis under minification. A texel that spans more source texels
/// belongs to a sliver or to a thumbnail.
const MAX_SAMPLES: f64 = 16.0;

/// Where the samples of one run lie in the source, in texels. Shared by all kernels: they may
/// differ in how they read, never in where.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Walk {
    start: [f64; 2],
    step: [f64; 2],
    /// How many samples a texel averages along the target's x and y.
    pub samples: [u32; 2],
    /// Source offset from one sample to the next along the target's x and y.
    sample_steps: [[f64; 2]; 2],
}

impl Walk {
    pub fn new(map: &SamplingMap, row: u32, run: Run, source: Size, filter: Filter) -> Self {
        let patch = &map.patches()[run.patch as usize];
        let scale = [f64::from(source.width), f64::from(source.height)];
        let uv = patch.src_uv_from_tgt_px.at([f64::from(run.x) + 0.5, f64::from(row) + 0.5]);
        let slope = patch.src_uv_from_tgt_px.jacobian;
        let (samples, sample_steps) = footprint(patch, scale, filter);
        Self {
            start: [uv[0] * scale[0], uv[1] * scale[1]],
            step: [slope[0][0] * scale[0], slope[1][0] * scale[1]],
            samples,
            sample_steps,
        }
    }

    /// Source position of the centre of the run's texel `k`, in texels from the top left corner.
    pub fn at(&self, k: u32) -> [f64; 2] {
        let k = f64::from(k);
        [self.start[0] + k * self.step[0], self.start[1] + k * self.step[1]]
    }

    /// Source position of sample `(a, b)` of the texel whose centre is at `centre`.
    pub fn sample(&self, centre: [f64; 2], a: u32, b: u32) -> [f64; 2] {
        let a = f64::from(a) - f64::from(self.samples[0] - 1) * 0.5;
        let b = f64::from(b) - f64::from(self.samples[1] - 1) * 0.5;
        [0, 1].map(|i| centre[i] + a * self.sample_steps[0][i] + b * self.sample_steps[1][i])
    }
}

/// How many samples a texel takes on each axis, and the source offsets between them: one for each
/// source texel that the target texel spans along that axis, rounded, so that what is about as
/// dense stays sharp and what is denser is averaged.
fn footprint(patch: &Patch, scale: [f64; 2], filter: Filter) -> ([u32; 2], [[f64; 2]; 2]) {
    let column = |k: usize| [patch.jacobian[0][k] * scale[0], patch.jacobian[1][k] * scale[1]];
    let columns = [column(0), column(1)];
    if filter == Filter::Nearest {
        return ([1, 1], [[0.0; 2]; 2]);
    }
    let samples = columns.map(|[x, y]| x.hypot(y).round().clamp(1.0, MAX_SAMPLES) as u32);
    let step = |k: usize| columns[k].map(|component| component / f64::from(samples[k]));
    (samples, [step(0), step(1)])
}

/// The texel before a position on one axis, and how far the position lies beyond its centre.
pub(crate) fn split(position: f64) -> (i64, f32) {
    let shifted = position - 0.5;
    // `floor` is a function call where the processor's baseline has no instruction for it.
    let whole = shifted as i64;
    let floor = whole - i64::from(shifted < whole as f64);
    (floor, (shifted - floor as f64) as f32)
}

/// Reads a texel as levels, colour multiplied by opacity where there is one.
pub(crate) fn load<T: Value, const C: usize>(texel: &[T]) -> [f32; C] {
    let mut levels: [f32; C] = std::array::from_fn(|channel| texel[channel].to_level());
    if C == 2 || C == 4 {
        let opacity = levels[C - 1] / T::ONE.to_level();
        for level in &mut levels[..C - 1] {
            *level *= opacity;
        }
    }
    levels
}

/// Lays filtered levels over what is there.
pub(crate) fn store<T: Value, const C: usize>(levels: [f32; C], texel: &mut [T]) {
    if C == 2 || C == 4 {
        let one = T::ONE.to_level();
        // Cubic filters overshoot; more than full opacity is none of the base, not less than none.
        let alpha = levels[C - 1].clamp(0.0, one);
        let below = (one - alpha) / one * texel[C - 1].to_level();
        let total = alpha + below;
        if total <= 0.0 {
            return;
        }
        for channel in 0..C - 1 {
            let level = levels[channel] * one + texel[channel].to_level() * below;
            texel[channel] = T::from_level(level / total);
        }
        texel[C - 1] = T::from_level(total);
    } else {
        for (channel, level) in levels.into_iter().enumerate() {
            texel[channel] = T::from_level(level);
        }
    }
}
