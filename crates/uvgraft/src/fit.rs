//! Solves for the texture that reads back best, instead of the one that sampling gives.
//!
//! Carrying a texture `s` from one layout to another and reading it back through `H` loses detail,
//! since it is filtered twice. The texture `f` that minimises `‖H f − s‖²` is found by conjugate
//! gradients on the normal equations (CGLS, Hestenes and Stiefel 1952, in the form of Björck 1996),
//! started from the sampled texture `f₀` and held to it by `λ ‖f − f₀‖²` where `H` sees little or
//! nothing.
//!
//! Sampled halfway between texels, a bilinear filter cancels stripes one texel wide; sampled at
//! texel centres it passes them unchanged. Where both layouts have about the same texel density the
//! two cases alternate across the surface, and a solution that makes up for the whole loss rings
//! with the same period. `μ ‖∇(f − f₀)‖²` damps exactly this: its weight is greatest for stripes,
//! and greatest relative to the data where few texels are read.

use std::ops::Range;
use std::sync::Arc;

use uvgraft_surface::piece::FacePiece;
use uvgraft_surface::raster::corners_px;
use uvgraft_surface::threads::{for_each_chunk, map_indices};

use crate::filter::Filter;
use crate::formats::Formats;
use crate::map::{Coverage, LayoutTriangles, MapOptions, Precedence, TexelSet};
use crate::operator::Operator;
use crate::resample::load;
use crate::resampler::{MapInputs, Resampler};
use crate::texture::{Depth, Texels, Texture};

/// Stopping criteria and regularisation of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct FitOptions {
    /// Maximum number of steps.
    pub max_steps: u32,
    /// The fit stops after a step that lowers the error by less than this fraction.
    pub min_gain: f64,
    /// `λ`: weight of a texel's squared distance from its sampled value, relative to the weight of
    /// its data, which is about the number of texels that read it. With 0, texels that `H` barely
    /// sees are left to noise.
    pub regularization: f32,
    /// `μ`: weight of squared differences between neighbours of the correction `f − f₀`, relative
    /// to the same weight of the data. `None` picks a default for the filter: 0.1 for the bilinear
    /// one, 0 for sharper ones.
    pub smoothness: Option<f32>,
}

impl FitOptions {
    /// Sets the maximum number of steps.
    #[must_use]
    pub const fn max_steps(self, max_steps: u32) -> Self {
        Self { max_steps, ..self }
    }

    /// Sets the least relative gain of a step.
    #[must_use]
    pub const fn min_gain(self, min_gain: f64) -> Self {
        Self { min_gain, ..self }
    }

    /// Sets `λ`.
    #[must_use]
    pub const fn regularization(self, regularization: f32) -> Self {
        Self { regularization, ..self }
    }

    /// Sets `μ`.
    #[must_use]
    pub const fn smoothness(self, smoothness: f32) -> Self {
        Self { smoothness: Some(smoothness), ..self }
    }
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { max_steps: 32, min_gain: 0.005, regularization: 0.02, smoothness: None }
    }
}

/// Default `μ` of a filter.
fn default_smoothness(filter: Filter) -> f32 {
    match filter {
        // From 0.1 on, a fitted texture has no more noise than the sampled one has error. Measured
        // against the texture that a face was baked from, fits without it were worse than sampling
        // at 1024².
        Filter::Nearest | Filter::Bilinear => 0.1,
        // These pass nearly everything up to stripes of a texel and a half; here `μ` takes as much
        // from the detail as from the noise.
        Filter::CatmullRom | Filter::Lanczos3 => 0.0,
    }
}

/// Progress of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct FitProgress {
    /// Steps done; 0 is the sampled texture.
    pub step: u32,
    /// Maximum number of steps.
    pub max_steps: u32,
    /// Root mean square of `H f − s` over the channels of the texels in the equations
    /// ([`FitSummary::share_met`]), before values are rounded and clamped to the format; 1.0 is the
    /// difference between black and white.
    pub rms: f64,
}

/// Outcome of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct FitSummary {
    /// Steps taken.
    pub steps: u32,
    /// [`FitProgress::rms`] of the sampled texture.
    pub sampled_rms: f64,
    /// [`FitProgress::rms`] of the fitted texture.
    pub fitted_rms: f64,
    /// Fraction of the source's linked texels that have an equation, from 0 to 1. The others read
    /// texels that another island of the target's layout owns, where islands overlap.
    pub share_met: f64,
}

/// The linear system for fits of one texture size: built once, reused for any number of textures.
#[derive(Debug)]
pub(crate) struct FitSystem {
    sampling: Arc<Resampler>,
    back: Operator,
    /// Unknowns: the texels of the result that pieces own.
    unknowns: TexelSet,
    /// Equations: the texels of the source that read them.
    equations: TexelSet,
}

/// The texture has a value that is NaN or infinite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct NotFinite {
    /// Column and row of the texel.
    pub texel: [u32; 2],
}

impl FitSystem {
    /// - `sampling`: gives the starting point `f₀`. The result is meant to be read with the same
    ///   filter.
    /// - `inputs`: what the map of `sampling` was made from.
    pub fn new(inputs: &MapInputs<'_>, sampling: Arc<Resampler>) -> Self {
        let unknowns = TexelSet::linked(sampling.map(), |_| true);
        // No equations for the gutter, nor for anything outside the unknowns, island or not: texels
        // at their boundary must not compensate for whatever the base holds there.
        let back = MapInputs {
            direction: inputs.direction.opposite(),
            target_size: sampling.source_size(),
            map: MapOptions::with_gutter(0).prefer(inputs.map.prefer),
            ..*inputs
        };
        let back = Arc::new(Resampler::reading(&back, &unknowns, sampling.filter()));
        let lost = lost_pieces(inputs);
        let equations = TexelSet::linked(back.map(), |patch| !lost[patch.piece as usize]);
        Self { sampling, back: Operator::new(back), unknowns, equations }
    }

    /// See [`FitSummary::share_met`].
    fn share_met(&self) -> f64 {
        let linked = self.back.resampler().map().stats().linked;
        if linked == 0 { 1.0 } else { self.equations.texels() as f64 / linked as f64 }
    }

    /// Solves for a texture: the premultiplied values of every texel of the target, 1.0 for white.
    /// The gutter stays as sampled.
    ///
    /// - `progress`: called before the first step and after each.
    pub fn solve(
        &self,
        formats: &Formats,
        source: Texture,
        options: &FitOptions,
        progress: &mut dyn FnMut(FitProgress),
    ) -> Result<(Vec<f32>, FitSummary), NotFinite> {
        let source = formats.working(source);
        let channels = source.channels();
        let source = source.converted(channels, Depth::F32);
        let Texels::F32(source) = source.into_texels() else { unreachable!("converted") };
        if let Some(index) = source.iter().position(|value| !value.is_finite()) {
            let (texel, width) =
                (index / channels.count(), self.sampling.source_size().width as usize);
            return Err(NotFinite { texel: [(texel % width) as u32, (texel / width) as u32] });
        }
        let mut summary = None;
        let mut report = |now: FitProgress| {
            let sampled_rms = summary.map_or(now.rms, |summary: FitSummary| summary.sampled_rms);
            summary = Some(FitSummary {
                steps: now.step,
                sampled_rms,
                fitted_rms: now.rms,
                share_met: self.share_met(),
            });
            progress(now);
        };
        let problem = Problem { system: self, options };
        let layer = match (channels.count(), formats.has_alpha()) {
            (1, _) => problem.solve::<1, false>(source, &mut report),
            (2, false) => problem.solve::<2, false>(source, &mut report),
            (2, true) => problem.solve::<2, true>(source, &mut report),
            (3, _) => problem.solve::<3, false>(source, &mut report),
            (_, false) => problem.solve::<4, false>(source, &mut report),
            (_, true) => problem.solve::<4, true>(source, &mut report),
        };
        Ok((layer, summary.expect("progress is reported before the first step")))
    }
}

/// A fit of one texture.
struct Problem<'a> {
    system: &'a FitSystem,
    options: &'a FitOptions,
}

impl Problem<'_> {
    /// Minimises `‖H (f₀ + δ) − s‖² + λ ‖δ‖² + μ ‖∇δ‖²` by CGLS and returns `f₀ + δ`,
    /// premultiplied, with the gutter as sampled.
    ///
    /// CGLS needs only products with `H` and `Hᵀ`; neither `H` nor `HᵀH` is stored. Solving for the
    /// correction `δ` leaves texels that `H` does not see at `f₀`. The fit stops at the least gain,
    /// or if the curvature along a step is not positive and finite. `alpha`, `beta` and `gamma` are
    /// the step length, the conjugation factor and the squared norm of the gradient.
    ///
    /// - `source`: `s`, not premultiplied.
    fn solve<const C: usize, const ALPHA: bool>(
        &self,
        mut source: Vec<f32>,
        progress: &mut dyn FnMut(FitProgress),
    ) -> Vec<f32> {
        if ALPHA {
            for texel in source.chunks_exact_mut(C) {
                let levels = load::<f32, C, ALPHA>(texel);
                texel.copy_from_slice(&levels);
            }
        }
        let FitSystem { sampling, back, unknowns, equations } = self.system;
        let count = unknowns.size().texels() * C;
        let mut fitted = vec![0.0; count];
        sampling.fill_floats::<C>(&mut source, &mut fitted);
        let mut residual = self.residual::<C>(fitted.clone(), &source);
        drop(source);

        let regularization = self.regularization();
        let penalty = |delta: &[f32]| regularization.penalty::<C>(unknowns, delta);
        let terms = (equations.texels() * C).max(1) as f64;
        let mut squares = equations.dot::<C>(&residual, &residual);
        let mut report = |step: u32, squares: f64| {
            let rms = (squares / terms).sqrt();
            progress(FitProgress { step, max_steps: self.options.max_steps, rms });
        };
        report(0, squares);
        let [mut delta, mut gradient, mut step] = [(); 3].map(|()| vec![0.0; count]);
        let mut product = vec![0.0; residual.len()];
        let (mut error, mut gamma) = (squares, 0.0);
        for number in 1..=self.options.max_steps {
            // Negative gradient `Hᵀ residual − λ δ − μ ∇ᵀ∇ δ`, made conjugate to the previous
            // steps.
            gradient.fill(0.0);
            back.add_transposed_to::<C>(&residual, &mut gradient);
            regularization.add_gradient::<C>(unknowns, &delta, &mut gradient);
            let last_gamma = gamma;
            gamma = unknowns.dot::<C>(&gradient, &gradient);
            if gamma == 0.0 {
                break;
            }
            let beta = if number == 1 { 0.0 } else { (gamma / last_gamma) as f32 };
            unknowns.update::<C>(&mut step, &gradient, |step, g| g + beta * step);

            // Exact line search. Padding writes outside the unknowns, where nothing reads.
            back.resampler().fill_floats::<C>(&mut step, &mut product);
            let curvature = equations.dot::<C>(&product, &product) + penalty(&step);
            if curvature.is_nan() || curvature <= 0.0 || curvature.is_infinite() {
                break;
            }
            let alpha = (gamma / curvature) as f32;
            unknowns.update::<C>(&mut delta, &step, |delta, step| delta + alpha * step);
            equations.update::<C>(&mut residual, &product, |r, product| r - alpha * product);
            squares = equations.dot::<C>(&residual, &residual);
            report(number, squares);
            let was = error;
            error = squares + penalty(&delta);
            if was - error < self.options.min_gain * was {
                break;
            }
        }
        unknowns.update::<C>(&mut fitted, &delta, |fitted, delta| fitted + delta);
        fitted
    }

    /// `s − H f`, where there is an equation.
    ///
    /// - `texture`: `f`, which is padded in place.
    fn residual<const C: usize>(&self, mut texture: Vec<f32>, source: &[f32]) -> Vec<f32> {
        let FitSystem { back, equations, .. } = self.system;
        let mut product = vec![0.0; equations.size().texels() * C];
        back.resampler().fill_floats::<C>(&mut texture, &mut product);
        let mut residual = vec![0.0; product.len()];
        equations.update::<C>(&mut residual, source, |_, source| source);
        equations.update::<C>(&mut residual, &product, |residual, product| residual - product);
        residual
    }

    fn regularization(&self) -> Regularization {
        let default = || default_smoothness(self.system.sampling.filter());
        Regularization {
            lambda: self.options.regularization,
            smoothness: self.options.smoothness.unwrap_or_else(default),
        }
    }
}

/// Regularisation of the correction: `λ ‖δ‖² + μ ‖∇δ‖²`.
#[derive(Clone, Copy)]
struct Regularization {
    /// `λ`.
    lambda: f32,
    /// `μ`.
    smoothness: f32,
}

impl Regularization {
    fn penalty<const C: usize>(self, unknowns: &TexelSet, delta: &[f32]) -> f64 {
        let offset = f64::from(self.lambda) * unknowns.dot::<C>(delta, delta);
        let rough = if self.smoothness == 0.0 { 0.0 } else { unknowns.roughness::<C>(delta) };
        offset + f64::from(self.smoothness) * rough
    }

    /// Adds `−λ δ − μ ∇ᵀ∇ δ`.
    fn add_gradient<const C: usize>(
        self,
        unknowns: &TexelSet,
        delta: &[f32],
        gradient: &mut [f32],
    ) {
        unknowns.update::<C>(gradient, delta, |g, delta| g - self.lambda * delta);
        if self.smoothness > 0.0 {
            unknowns.smooth::<C>(delta, gradient, self.smoothness);
        }
    }
}

/// Which pieces of the opposite direction read texels that another island of the target's layout
/// owns. Where islands overlap, such as two eyes on one disc, the one that lost its texels must not
/// enter the equations.
fn lost_pieces(inputs: &MapInputs<'_>) -> Vec<bool> {
    let target = inputs.pair.to(inputs.direction);
    let precedence = Precedence::of(&inputs.pair.oriented(inputs.direction), inputs.map.prefer);
    let coverage = Coverage::new(&LayoutTriangles::new(target, inputs.target_size), &precedence);
    let back = inputs.pair.face_pieces(inputs.direction.opposite());
    if coverage.overlapping == 0 {
        return vec![false; back.all().len()];
    }
    let island_of = |face: u32| precedence.of_faces()[face as usize];
    let is_lost = |piece: &FacePiece| {
        let face = piece.from;
        // Test the centroid of the whole face, however it is cut: the centroid of a part at an
        // island's edge may lie where no island owns a texel.
        let corners = corners_px(target, face as usize, inputs.target_size);
        let centre =
            [0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / 3.0);
        coverage.owner(centre).is_some_and(|owner| island_of(owner) != island_of(face))
    };
    back.all().iter().map(is_lost).collect()
}

/// Vector operations on texels with `C` values each, restricted to a region.
impl TexelSet {
    /// Replaces each value by a function of it and of the same element of `others`.
    fn update<const C: usize>(
        &self,
        values: &mut [f32],
        others: &[f32],
        change: impl Fn(f32, f32) -> f32 + Send + Sync,
    ) {
        let stride = self.size().width as usize * C;
        for_each_chunk(values, stride, |row, values| {
            for span in self.row(row) {
                let span = span.start as usize * C..span.end as usize * C;
                let others = &others[row * stride..][span.clone()];
                for (value, &other) in values[span].iter_mut().zip(others) {
                    *value = change(*value, other);
                }
            }
        });
    }

    /// Adds `−weight · L values` to `gradient`, `L` being the graph Laplacian: each texel is pulled
    /// towards those of its four neighbours that are in the region too.
    fn smooth<const C: usize>(&self, values: &[f32], gradient: &mut [f32], weight: f32) {
        let stride = self.size().width as usize * C;
        for_each_chunk(gradient, stride, |row, gradient| {
            let own = &values[row * stride..][..stride];
            for span in self.row(row) {
                for k in span.start as usize * C..(span.end as usize - 1) * C {
                    let pull = weight * (own[k + C] - own[k]);
                    gradient[k] += pull;
                    gradient[k + C] -= pull;
                }
            }
            let beside = [row.checked_sub(1), Some(row + 1)].into_iter().flatten();
            for other in beside.filter(|&other| other < self.size().height as usize) {
                let values = &values[other * stride..][..stride];
                for_each_shared(self.row(row), self.row(other), |shared| {
                    for k in shared.start as usize * C..shared.end as usize * C {
                        gradient[k] += weight * (values[k] - own[k]);
                    }
                });
            }
        });
    }

    /// Sum of squared differences between neighbours: `xᵀ L x` with the Laplacian of
    /// [`TexelSet::smooth`].
    fn roughness<const C: usize>(&self, values: &[f32]) -> f64 {
        let stride = self.size().width as usize * C;
        let square = |a: f32, b: f32| f64::from(a - b).powi(2);
        let rows = map_indices(self.size().height as usize, |row| {
            let own = &values[row * stride..][..stride];
            let mut sum = 0.0;
            for span in self.row(row) {
                let span = span.start as usize * C..(span.end as usize - 1) * C;
                sum += span.map(|k| square(own[k], own[k + C])).sum::<f64>();
            }
            if row + 1 < self.size().height as usize {
                let below = &values[(row + 1) * stride..][..stride];
                for_each_shared(self.row(row), self.row(row + 1), |shared| {
                    let shared = shared.start as usize * C..shared.end as usize * C;
                    sum += shared.map(|k| square(own[k], below[k])).sum::<f64>();
                });
            }
            sum
        });
        rows.into_iter().sum()
    }

    fn dot<const C: usize>(&self, a: &[f32], b: &[f32]) -> f64 {
        let stride = self.size().width as usize * C;
        let rows = map_indices(self.size().height as usize, |row| {
            let (a, b) = (&a[row * stride..][..stride], &b[row * stride..][..stride]);
            let product = |(&a, &b): (&f32, &f32)| f64::from(a) * f64::from(b);
            let of_span = |span: &Range<u32>| {
                let span = span.start as usize * C..span.end as usize * C;
                a[span.clone()].iter().zip(&b[span]).map(product).sum::<f64>()
            };
            self.row(row).iter().map(of_span).sum::<f64>()
        });
        rows.into_iter().sum()
    }
}

/// Calls `visit` with each intersection of two sorted lists of ranges.
fn for_each_shared(a: &[Range<u32>], mut b: &[Range<u32>], mut visit: impl FnMut(Range<u32>)) {
    for range in a {
        b = &b[b.partition_point(|other| other.end <= range.start)..];
        for other in b.iter().take_while(|other| other.start < range.end) {
            visit(range.start.max(other.start)..range.end.min(other.end));
        }
    }
}

#[cfg(test)]
mod tests {
    use uvgraft_surface::mesh::Mesh;
    use uvgraft_surface::pair::{Direction, Pair};
    use uvgraft_surface::piece::Piece;

    use super::*;
    use crate::texture::Size;

    /// Two overlapping islands, the second protruding a little: its edge must not enter the
    /// equations either.
    #[test]
    fn parts_of_a_lost_face_are_lost() {
        let faces = [[0, 1, 2], [3, 4, 5]];
        let mesh = |second: [[f32; 2]; 3]| {
            let first = [[0.1, 0.1], [0.4, 0.1], [0.1, 0.4]];
            let uv = [first, second].concat();
            Mesh::from_triangles(vec![[0.0; 3]; 6], uv, &faces, &faces).unwrap()
        };
        let source = mesh([[0.6, 0.6], [0.9, 0.6], [0.6, 0.9]]);
        let target = mesh([[0.1, 0.05], [0.4, 0.05], [0.1, 0.4]]);
        let [a, b, c] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let inner = [0.48, 0.48, 0.04];
        let parts = [[a, b, inner], [b, c, inner], [c, a, inner]];
        let parts = parts.map(|part| Piece::part((1, part), (1, part)));
        let pieces = [Piece::whole(0, 0, [0, 1, 2])].into_iter().chain(parts);
        let pair = Pair::from_pieces(source, target, pieces).unwrap();
        let inputs = MapInputs {
            pair: &pair,
            direction: Direction::Forward,
            target_size: Size::square(100),
            map: MapOptions::default(),
        };
        assert_eq!(lost_pieces(&inputs), [false, true, true, true]);
    }
}
