//! The texture that reads back best, rather than the one that sampling gives.
//!
//! Carrying a texture `s` from one layout to another and back through `H` loses what sampling blurs
//! twice. The texture `f` with the least `‖H f − s‖²` is found by conjugate gradients on the normal
//! equations (CGLS, Hestenes and Stiefel 1952, in the form of Björck 1996), started from the sampled
//! texture `f₀` and held to it by `λ ‖f − f₀‖²` where `H` sees little or nothing.

use std::ops::Range;

use crate::map::{Coverage, Layout, MapOptions, Precedence, Prefer, Region, corners_px};
use crate::operator::Operator;
use crate::overlay::{Formats, Layer, Overlay};
use crate::pair::{Direction, Pair};
use crate::resample::load;
use crate::texture::{Depth, Size, TexelFormat, Texels, Texture};
use crate::threads::{for_each_chunk, map_indices};
use crate::transfer::{Transfer, TransferError, TransferOptions};

/// When a fit ends, and how strongly it is held to what was sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitOptions {
    /// The most steps that are taken.
    pub max_steps: u32,
    /// A step that lowers the error by less than this share of it is the last.
    pub least_gain: f64,
    /// `λ`: how much a texel's distance from its sampled value counts beside what it is seen with,
    /// which is about the number of texels that read it. 0 leaves what `H` barely sees to noise.
    pub regularization: f32,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { max_steps: 32, least_gain: 0.005, regularization: 0.02 }
    }
}

/// How far a fit has come.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FitProgress {
    /// Steps done; 0 is the sampled texture.
    pub step: u32,
    /// The most steps that there can be.
    pub max_steps: u32,
    /// Root mean square of `H f − s` over the texels that are met ([`Fit::share_met`]) and their
    /// channels, before values are rounded and clamped to the format; 1.0 for the difference between
    /// black and white.
    pub rms: f64,
}

/// Carries textures as [`Transfer`] does, and then makes the result the one that reads back best.
#[derive(Debug, Clone)]
pub struct Fit {
    there: Transfer,
    back: Transfer,
    /// What is solved for: the texels of the result that linked triangles own.
    unknowns: Region,
    /// What is to be met: the texels of the source that read them.
    equations: Region,
    options: FitOptions,
}

impl Fit {
    /// Prepares fits of textures of `source_size` onto bases of `target_size`. The result is meant
    /// to be read with `options.filter`.
    ///
    /// # Panics
    /// If a side of a size is 0 or beyond [`Texture::MAX_SIDE`].
    pub fn new(
        pair: &Pair,
        direction: Direction,
        source_size: Size,
        target_size: Size,
        options: &TransferOptions,
        fit: FitOptions,
    ) -> Self {
        let there = Transfer::new(pair, direction, source_size, target_size, options);
        let unknowns = Region::linked(there.map(), |_| true);
        // The gutter is no part of what has to be met; nor is what lies beside the unknowns, islands
        // or not: whatever the base holds there, the border must not make up for it.
        let bare = TransferOptions { map: MapOptions::with_gutter(0), ..*options };
        let back = Transfer::reading(pair, direction.opposite(), &unknowns, source_size, &bare);
        let lost = lost_faces(pair, direction, target_size, options.map.prefer);
        let equations = Region::linked(back.map(), |face| !lost[face as usize]);
        Self { there, back, unknowns, equations, options: fit }
    }

    /// The transfer that the fit starts from.
    pub fn transfer(&self) -> &Transfer {
        &self.there
    }

    /// Which share of the source's linked texels is met by the fit, from 0 to 1. The rest reads what
    /// another island of the target's layout owns, where islands overlap.
    pub fn share_met(&self) -> f64 {
        let linked = self.back.map().stats().linked;
        if linked == 0 { 1.0 } else { self.equations.texels() as f64 / linked as f64 }
    }

    /// Lays a fitted texture over a base; as [`Transfer::apply`] in everything else. Integer depths
    /// clamp to their range. The gutter stays as it was sampled.
    ///
    /// `progress` is called before the first step and after each.
    ///
    /// # Errors
    /// [`TransferError::Size`] if a texture has another size than this was made for,
    /// [`TransferError::NotFinite`] if a float source holds a NaN or an infinity.
    pub fn apply(
        &self,
        source: Texture,
        base: Texture,
        progress: &mut dyn FnMut(FitProgress),
    ) -> Result<Texture, TransferError> {
        self.there.check_base(&base)?;
        self.overlay(source, base.format(), progress)?.lay(0, base)
    }

    /// Fits a texture that can be laid over a base of some format, band by band; as
    /// [`Transfer::overlay`]. `progress` is called as by [`Fit::apply`].
    ///
    /// # Errors
    /// As [`Fit::apply`].
    pub fn overlay(
        &self,
        source: Texture,
        base: TexelFormat,
        progress: &mut dyn FnMut(FitProgress),
    ) -> Result<Overlay<'_>, TransferError> {
        self.there.check_source(&source)?;
        let formats = Formats::new(source.format(), base, self.there.options().linear_light);
        let source = formats.working(source);
        let channels = source.channels();
        let source = source.converted(channels, Depth::F32);
        let Texels::F32(source) = source.into_texels() else { unreachable!("converted") };
        if let Some(index) = source.iter().position(|value| !value.is_finite()) {
            let (texel, width) =
                (index / channels.count(), self.there.source_size().width as usize);
            let (x, y) = ((texel % width) as u32, (texel / width) as u32);
            return Err(TransferError::NotFinite { x, y });
        }
        let layer = match (channels.count(), formats.has_opacity()) {
            (1, _) => self.solve::<1, false>(source, progress),
            (2, false) => self.solve::<2, false>(source, progress),
            (2, true) => self.solve::<2, true>(source, progress),
            (3, _) => self.solve::<3, false>(source, progress),
            (_, false) => self.solve::<4, false>(source, progress),
            (_, true) => self.solve::<4, true>(source, progress),
        };
        Ok(Overlay::new(self.there.map(), formats, Layer::Solved(layer)))
    }

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
        let (unknowns, equations) = (&self.unknowns, &self.equations);
        let count = unknowns.size().texels() * C;
        let back = Operator::new(&self.back);
        let mut fitted = vec![0.0; count];
        self.there.fill_floats::<C>(&mut seen, &mut fitted);

        // What is left to explain, where there is something: s − H f₀.
        let mut step = fitted.clone();
        let mut made = vec![0.0; equations.size().texels() * C];
        self.back.fill_floats::<C>(&mut step, &mut made);
        let mut rest = vec![0.0; made.len()];
        equations.update::<C>(&mut rest, &seen, |_, seen| seen);
        equations.update::<C>(&mut rest, &made, |rest, made| rest - made);
        drop(seen);

        let lambda = self.options.regularization;
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
            // Downhill: Hᵀ rest − λ moved, then turned to be conjugate to the steps before.
            gradient.fill(0.0);
            back.add_transposed_to::<C>(&rest, &mut gradient);
            unknowns.update::<C>(&mut gradient, &moved, |pull, moved| pull - lambda * moved);
            let before = steepness;
            steepness = unknowns.dot::<C>(&gradient, &gradient);
            if steepness == 0.0 {
                break;
            }
            let turn = if number == 1 { 0.0 } else { (steepness / before) as f32 };
            unknowns.update::<C>(&mut step, &gradient, |step, pull| pull + turn * step);

            // As far as the error falls. Padding writes beside the unknowns, where nothing looks.
            self.back.fill_floats::<C>(&mut step, &mut made);
            let bend = equations.dot::<C>(&made, &made)
                + f64::from(lambda) * unknowns.dot::<C>(&step, &step);
            if bend.is_nan() || bend <= 0.0 || bend.is_infinite() {
                break;
            }
            let along = (steepness / bend) as f32;
            unknowns.update::<C>(&mut moved, &step, |moved, step| moved + along * step);
            equations.update::<C>(&mut rest, &made, |rest, made| rest - along * made);
            squares = equations.dot::<C>(&rest, &rest);
            report(number, squares);
            let was = error;
            error = squares + f64::from(lambda) * unknowns.dot::<C>(&moved, &moved);
            if was - error < self.options.least_gain * was {
                break;
            }
        }
        unknowns.update::<C>(&mut fitted, &moved, |fitted, moved| fitted + moved);
        fitted
    }
}

/// Which faces of the source's layout read texels that another island of the target's layout owns:
/// where islands overlap, such as two eyes on one disc, the one that lost its texels has no say.
fn lost_faces(pair: &Pair, direction: Direction, target_size: Size, prefer: Prefer) -> Vec<bool> {
    let target = pair.to(direction);
    let precedence = Precedence::new(target, prefer);
    let coverage = Coverage::new(&Layout::new(target, target_size), &precedence);
    if coverage.overlapping == 0 {
        return vec![false; pair.from(direction).faces().len()];
    }
    let island_of = |face: u32| precedence.of_faces()[face as usize];
    let lost = |face: u32| {
        let corners = corners_px(target, face as usize, target_size);
        let centre =
            [0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / 3.0);
        coverage.owner(centre).is_some_and(|owner| island_of(owner) != island_of(face))
    };
    let counterparts = pair.oriented(direction.opposite()).from_face;
    counterparts.into_iter().map(|found| found.is_some_and(|found| lost(found.face))).collect()
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
