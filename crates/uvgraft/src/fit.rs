//! The texture that reads back best, rather than the one that sampling gives.
//!
//! Carrying a texture `s` from one layout to another and back through `H` loses what sampling blurs
//! twice. The texture `f` with the least `‖H f − s‖²` is found by conjugate gradients on the normal
//! equations (CGLS, Hestenes and Stiefel 1952, in the form of Björck 1996), started from the sampled
//! texture `f₀` and held to it by `λ ‖f − f₀‖²` where `H` sees little or nothing.
//!
//! Halfway between texels a bilinear filter sees nothing of stripes one texel wide, and on a texel all of
//! them. Where texels are about as dense on both sides that alternates from place to place, and a solution
//! that makes up for all that is lost rings in time with it. `μ ‖∇(f − f₀)‖²` holds back just that: it
//! weighs most for stripes, and most where few texels are read.

use std::ops::Range;
use std::sync::Arc;

use crate::filter::Filter;
use crate::formats::Formats;
use crate::map::{Coverage, LayoutTriangles, MapOptions, Precedence, Region, corners_px};
use crate::operator::Operator;
use crate::piece::FacePiece;
use crate::resample::load;
use crate::resampler::{Resampler, Way};
use crate::texture::{Depth, Texels, Texture};
use crate::threads::{for_each_chunk, map_indices};

/// When a fit ends, and how strongly it is held to what was sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct FitOptions {
    /// The most steps that are taken.
    pub max_steps: u32,
    /// A step that lowers the error by less than this share of it is the last.
    pub least_gain: f64,
    /// `λ`: how much a texel's distance from its sampled value counts beside what it is seen with,
    /// which is about the number of texels that read it. 0 leaves what `H` barely sees to noise.
    pub regularization: f32,
    /// `μ`: how much differences between neighbours of what is changed count beside what a texel is seen with.
    /// `None` takes what suits the filter: 0.1 for the bilinear one, and nothing for those that are sharper.
    pub smoothness: Option<f32>,
}

impl FitOptions {
    /// The same with so many steps at most.
    #[must_use]
    pub const fn max_steps(self, max_steps: u32) -> Self {
        Self { max_steps, ..self }
    }

    /// The same with another least gain of a step.
    #[must_use]
    pub const fn least_gain(self, least_gain: f64) -> Self {
        Self { least_gain, ..self }
    }

    /// The same with another `λ`.
    #[must_use]
    pub const fn regularization(self, regularization: f32) -> Self {
        Self { regularization, ..self }
    }

    /// The same with another `μ`.
    #[must_use]
    pub const fn smoothness(self, smoothness: f32) -> Self {
        Self { smoothness: Some(smoothness), ..self }
    }
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { max_steps: 32, least_gain: 0.005, regularization: 0.02, smoothness: None }
    }
}

/// `μ` of a filter.
fn default_smoothness(filter: Filter) -> f32 {
    match filter {
        // From 0.1 on a fitted texture has no more noise than the sampled one has error: against the
        // texture that a face was baked from, fits without it were worse than sampling at 1024².
        Filter::Nearest | Filter::Bilinear => 0.1,
        // These see nearly everything up to stripes of a texel and a half, and what `μ` takes from the
        // noise it takes from the detail as well.
        Filter::CatmullRom | Filter::Lanczos3 => 0.0,
    }
}

/// How far a fit has come.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct FitProgress {
    /// Steps done; 0 is the sampled texture.
    pub step: u32,
    /// The most steps that there can be.
    pub max_steps: u32,
    /// Root mean square of `H f − s` over the texels that are met ([`FitSummary::share_met`]) and their
    /// channels, before values are rounded and clamped to the format; 1.0 for the difference between
    /// black and white.
    pub rms: f64,
}

/// How a fit went.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct FitSummary {
    /// Steps that were taken.
    pub steps: u32,
    /// [`FitProgress::rms`] of the sampled texture.
    pub sampled_rms: f64,
    /// [`FitProgress::rms`] of the fitted texture.
    pub fitted_rms: f64,
    /// Which share of the source's linked texels is met by the fit, from 0 to 1. The rest reads what
    /// another island of the target's layout owns, where islands overlap.
    pub share_met: f64,
}

/// What fits of textures of one size are solved with: made once, used for any number of textures.
#[derive(Debug)]
pub(crate) struct FitSystem {
    there: Arc<Resampler>,
    back: Operator,
    /// What is solved for: the texels of the result that pieces own.
    unknowns: Region,
    /// What is to be met: the texels of the source that read them.
    equations: Region,
}

/// Why a texture was not fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct NotFinite {
    /// Column and row of the texel.
    pub texel: [u32; 2],
}

impl FitSystem {
    /// - `there`: what the fit starts from. The result is meant to be read with its filter.
    /// - `way`: that of `there`.
    pub fn new(way: &Way<'_>, there: Arc<Resampler>) -> Self {
        let unknowns = Region::linked(there.map(), |_| true);
        // The gutter is no part of what has to be met; nor is what lies beside the unknowns, islands
        // or not: whatever the base holds there, the border must not make up for it.
        let back = Way {
            direction: way.direction.opposite(),
            target_size: there.source_size(),
            map: MapOptions::with_gutter(0).prefer(way.map.prefer),
            ..*way
        };
        let back = Arc::new(Resampler::reading(&back, &unknowns, there.filter()));
        let lost = lost_pieces(way);
        let equations = Region::linked(back.map(), |patch| !lost[patch.piece as usize]);
        Self { there, back: Operator::new(back), unknowns, equations }
    }

    /// See [`FitSummary::share_met`].
    fn share_met(&self) -> f64 {
        let linked = self.back.resampler().map().stats().linked;
        if linked == 0 { 1.0 } else { self.equations.texels() as f64 / linked as f64 }
    }

    /// Solves for a texture: the premultiplied values of every texel of the target, 1.0 for white. The gutter
    /// stays as it was sampled.
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
                (index / channels.count(), self.there.source_size().width as usize);
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
        let layer = match (channels.count(), formats.has_opacity()) {
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

/// A system and how far it is solved.
struct Problem<'a> {
    system: &'a FitSystem,
    options: &'a FitOptions,
}

impl Problem<'_> {
    /// The fitted texture, premultiplied, with the gutter as it was sampled.
    fn solve<const C: usize, const OPACITY: bool>(
        &self,
        mut seen: Vec<f32>,
        progress: &mut dyn FnMut(FitProgress),
    ) -> Vec<f32> {
        if OPACITY {
            for texel in seen.chunks_exact_mut(C) {
                let levels = load::<f32, C, OPACITY>(texel);
                texel.copy_from_slice(&levels);
            }
        }
        let FitSystem { there, back, unknowns, equations } = self.system;
        let count = unknowns.size().texels() * C;
        let mut fitted = vec![0.0; count];
        there.fill_floats::<C>(&mut seen, &mut fitted);

        // What is left to explain, where there is something: s − H f₀.
        let mut step = fitted.clone();
        let mut made = vec![0.0; equations.size().texels() * C];
        back.resampler().fill_floats::<C>(&mut step, &mut made);
        let mut rest = vec![0.0; made.len()];
        equations.update::<C>(&mut rest, &seen, |_, seen| seen);
        equations.update::<C>(&mut rest, &made, |rest, made| rest - made);
        drop(seen);

        let lambda = self.options.regularization;
        let smoothness =
            self.options.smoothness.unwrap_or_else(|| default_smoothness(there.filter()));
        // λ ‖f − f₀‖² + μ ‖∇(f − f₀)‖².
        let held = |moved: &[f32]| {
            let far = f64::from(lambda) * unknowns.dot::<C>(moved, moved);
            let rough = if smoothness == 0.0 { 0.0 } else { unknowns.roughness::<C>(moved) };
            far + f64::from(smoothness) * rough
        };
        let terms = (equations.texels() * C).max(1) as f64;
        let mut squares = equations.dot::<C>(&rest, &rest);
        let mut report = |step: u32, squares: f64| {
            let rms = (squares / terms).sqrt();
            progress(FitProgress { step, max_steps: self.options.max_steps, rms });
        };
        report(0, squares);
        let mut moved = vec![0.0; count];
        let mut gradient = vec![0.0; count];
        step.fill(0.0);
        let (mut error, mut steepness) = (squares, 0.0);
        for number in 1..=self.options.max_steps {
            // Downhill: Hᵀ rest − λ moved − μ ∇ᵀ∇ moved, then turned to be conjugate to the steps before.
            gradient.fill(0.0);
            back.add_transposed_to::<C>(&rest, &mut gradient);
            unknowns.update::<C>(&mut gradient, &moved, |pull, moved| pull - lambda * moved);
            if smoothness > 0.0 {
                unknowns.smooth::<C>(&moved, &mut gradient, smoothness);
            }
            let before = steepness;
            steepness = unknowns.dot::<C>(&gradient, &gradient);
            if steepness == 0.0 {
                break;
            }
            let turn = if number == 1 { 0.0 } else { (steepness / before) as f32 };
            unknowns.update::<C>(&mut step, &gradient, |step, pull| pull + turn * step);

            // As far as the error falls. Padding writes beside the unknowns, where nothing looks.
            back.resampler().fill_floats::<C>(&mut step, &mut made);
            let bend = equations.dot::<C>(&made, &made) + held(&step);
            if bend.is_nan() || bend <= 0.0 || bend.is_infinite() {
                break;
            }
            let along = (steepness / bend) as f32;
            unknowns.update::<C>(&mut moved, &step, |moved, step| moved + along * step);
            equations.update::<C>(&mut rest, &made, |rest, made| rest - along * made);
            squares = equations.dot::<C>(&rest, &rest);
            report(number, squares);
            let was = error;
            error = squares + held(&moved);
            if was - error < self.options.least_gain * was {
                break;
            }
        }
        unknowns.update::<C>(&mut fitted, &moved, |fitted, moved| fitted + moved);
        fitted
    }
}

/// Which pieces of the way back read texels that another island of the target's layout owns: where islands
/// overlap, such as two eyes on one disc, the one that lost its texels has no say.
fn lost_pieces(way: &Way<'_>) -> Vec<bool> {
    let target = way.pair.to(way.direction);
    let precedence = Precedence::new(target, way.map.prefer);
    let coverage = Coverage::new(&LayoutTriangles::new(target, way.target_size), &precedence);
    let back = way.pair.face_pieces(way.direction.opposite());
    if coverage.overlapping == 0 {
        return vec![false; back.all().len()];
    }
    let island_of = |face: u32| precedence.of_faces()[face as usize];
    let is_lost = |piece: &FacePiece| {
        let face = piece.from;
        // By the middle of the whole face, however it is cut: a part at an island's rim may have its middle where
        // nobody owns anything.
        let corners = corners_px(target, face as usize, way.target_size);
        let centre =
            [0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / 3.0);
        coverage.owner(centre).is_some_and(|owner| island_of(owner) != island_of(face))
    };
    back.all().iter().map(is_lost).collect()
}

/// Vectors of texels with `C` values each, added and multiplied over a region.
impl Region {
    /// Replaces each value by a function of it and of another vector's.
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

    /// Takes `weight` times the graph Laplacian of `values` from `gradient`: each texel is drawn to those of its
    /// four neighbours that are in the region too.
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

    /// The sum of squared differences between neighbours: values times the Laplacian of [`Region::smooth`].
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

/// Calls `visit` with what two sorted lists of ranges share.
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
    use super::*;
    use crate::mesh::Mesh;
    use crate::pair::{Direction, Pair};
    use crate::piece::Piece;
    use crate::texture::Size;

    /// Of two islands on one place the second looks out a little; its rim has no say either.
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
        let way = Way {
            pair: &pair,
            direction: Direction::Forward,
            target_size: Size::square(100),
            map: MapOptions::default(),
        };
        assert_eq!(lost_pieces(&way), [false, true, true, true]);
    }
}
