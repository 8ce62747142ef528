//! The colour space that a PNG declares by its chunks.
//!
//! Sources: PNG, third edition, section 11.3.2 for the chunks, of which the first in the order cICP,
//! iCCP, sRGB, gAMA and cHRM counts; ITU-T H.273, tables 2 and 3, for the numbers in cICP.

use ::png::{CodingIndependentCodePoints, Info, ScaledFloat};

use super::FORMAT;
use crate::ImageError;
use crate::color_space::{Chromaticities, D65};

/// What values mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ColorSpace {
    pub(super) transfer: Transfer,
    pub(super) primaries: Chromaticities,
    /// Whether black and white are not 0 and the largest value, but 16/255 and 235/255.
    pub(super) is_narrow: bool,
}

/// How values follow from light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Transfer {
    Srgb,
    Linear,
    /// Light is this power of a value.
    Power(f64),
    /// ITU-R BT.709, as a camera applies it.
    Bt709,
    /// Perceptual quantisation of SMPTE ST 2084.
    Pq,
    /// Hybrid log-gamma of ARIB STD-B67.
    Hlg,
}

/// Gammas that count as that of sRGB, in units of 1/100,000: 1/2.2, which stands for sRGB in a file, as
/// older programs round it.
const SRGB_GAMMAS: std::ops::RangeInclusive<u32> = 45_000..=45_900;

/// Gammas outside are nonsense, and ignored as by libpng.
const GAMMAS: std::ops::RangeInclusive<u32> = 16..=625_000_000;

/// The declared colour space; `None` is sRGB or that of an ICC profile.
pub(super) fn declared(info: &Info<'_>) -> Result<Option<ColorSpace>, ImageError> {
    if let Some(code_points) = code_points(info) {
        return by_code_points(code_points).map(Some);
    }
    if info.icc_profile.is_some() || info.srgb.is_some() {
        return Ok(None);
    }
    let gamma =
        info.gama_chunk.map(ScaledFloat::into_scaled).filter(|gamma| GAMMAS.contains(gamma));
    let transfer = match gamma {
        Some(100_000) => Transfer::Linear,
        Some(gamma) if !SRGB_GAMMAS.contains(&gamma) => Transfer::Power(1e5 / f64::from(gamma)),
        _ => Transfer::Srgb,
    };
    let pair = |(x, y): (ScaledFloat, ScaledFloat)| [x.into_value(), y.into_value()].map(f64::from);
    let declared = info.chrm_chunk.map(|it| [it.red, it.green, it.blue, it.white].map(pair));
    let primaries = Chromaticities::declared(declared);
    Ok(Some(ColorSpace { transfer, primaries, is_narrow: false }))
}

/// The content of a cICP chunk that says anything.
pub(super) fn code_points<'a>(info: &'a Info<'_>) -> Option<&'a CodingIndependentCodePoints> {
    const UNSPECIFIED: u8 = 2;
    info.coding_independent_code_points.as_ref().filter(|points| {
        points.color_primaries != UNSPECIFIED && points.transfer_function != UNSPECIFIED
    })
}

/// Refuses the content of a cICP chunk that is of YCbCr instead of RGB, or of no known range.
pub(super) fn check_code_points([_, _, matrix, range]: [u8; 4]) -> Result<(), ImageError> {
    if matrix == 0 && range <= 1 {
        return Ok(());
    }
    Err(ImageError::Unsupported {
        format: FORMAT,
        found: format!("cICP matrix coefficients {matrix}, range flag {range}"),
        wanted: "must be 0, and 0 or 1; convert it to sRGB first",
    })
}

fn by_code_points(points: &CodingIndependentCodePoints) -> Result<ColorSpace, ImageError> {
    let (primaries, transfer) = (points.color_primaries, points.transfer_function);
    match (primaries_of(primaries), transfer_of(transfer)) {
        (Some(primaries), Some(transfer)) => {
            let is_narrow = !points.is_video_full_range_image;
            Ok(ColorSpace { transfer, primaries, is_narrow })
        }
        _ => Err(ImageError::Unsupported {
            format: FORMAT,
            found: format!("cICP colour primaries {primaries}, transfer function {transfer}"),
            wanted: "convert it to sRGB first",
        }),
    }
}

fn primaries_of(number: u8) -> Option<Chromaticities> {
    const C: [f64; 2] = [0.310, 0.316];
    let of = |red, green, blue, white| Some(Chromaticities { red, green, blue, white });
    match number {
        1 => Some(Chromaticities::SRGB),
        4 => of([0.67, 0.33], [0.21, 0.71], [0.14, 0.08], C),
        5 => of([0.64, 0.33], [0.29, 0.60], [0.15, 0.06], D65),
        6 | 7 => of([0.630, 0.340], [0.310, 0.595], [0.155, 0.070], D65),
        8 => of([0.681, 0.319], [0.243, 0.692], [0.145, 0.049], C),
        9 => of([0.708, 0.292], [0.170, 0.797], [0.131, 0.046], D65),
        11 => of([0.680, 0.320], [0.265, 0.690], [0.150, 0.060], [0.314, 0.351]),
        12 => of([0.680, 0.320], [0.265, 0.690], [0.150, 0.060], D65),
        22 => of([0.630, 0.340], [0.295, 0.605], [0.155, 0.077], D65),
        _ => None,
    }
}

fn transfer_of(number: u8) -> Option<Transfer> {
    match number {
        1 | 6 | 14 | 15 => Some(Transfer::Bt709),
        4 => Some(Transfer::Power(2.2)),
        5 => Some(Transfer::Power(2.8)),
        8 => Some(Transfer::Linear),
        13 => Some(Transfer::Srgb),
        16 => Some(Transfer::Pq),
        18 => Some(Transfer::Hlg),
        _ => None,
    }
}
