//! Luma and colour differences, of which the latter may be stored for blocks of texels.
//!
//! # Source
//! TIFF 6.0, section 21.

use std::io::{Read, Seek};

use super::directory::Directory;
use super::{damaged, tags, unsupported};
use crate::ImageError;

/// How luma and colour differences are stored, and the colours that they stand for.
#[derive(Debug, Clone, Copy)]
pub(super) struct YCbCr {
    /// Texels that share a colour difference, in a row and in a column: 1, 2 or 4.
    block: [usize; 2],
    /// The share of red, green and blue in luma.
    shares: [f32; 3],
    /// The codes of black and white of each.
    range: [[f32; 2]; 3],
}

impl YCbCr {
    pub(super) fn read<R: Read + Seek>(directory: &mut Directory<R>) -> Result<Self, ImageError> {
        let block = directory.numbers(tags::YCBCR_SUBSAMPLING)?;
        let block = match block.as_deref() {
            None => [2, 2],
            Some(&[x @ (1 | 2 | 4), y @ (1 | 2 | 4)]) => [x as usize, y as usize],
            Some(other) => {
                let reason = format!("YCbCrSubSampling must be two of 1, 2 and 4, got {other:?}");
                return Err(damaged(reason));
            }
        };
        let shares = numbers(directory, tags::YCBCR_COEFFICIENTS)?.unwrap_or([0.299, 0.587, 0.114]);
        let [y0, y1, b0, b1, r0, r1] = numbers(directory, tags::REFERENCE_BLACK_WHITE)?
            .unwrap_or([0.0, 255.0, 128.0, 255.0, 128.0, 255.0]);
        if y0 >= y1 || b0 >= b1 || r0 >= r1 || shares.iter().any(|&share| share <= 0.0) {
            let wanted =
                "convert it to RGB, for example by `magick IN.tif -colorspace sRGB OUT.tif`";
            return Err(unsupported("YCbCr colours of an unknown definition", wanted));
        }
        Ok(Self { block, shares, range: [[y0, y1], [b0, b1], [r0, r1]] })
    }

    /// Rows that are stored together.
    pub(super) fn rows(&self) -> usize {
        self.block[1]
    }

    /// Bytes of rows that are stored together.
    pub(super) fn stored_bytes(&self, width: usize) -> usize {
        width.div_ceil(self.block[0]) * (self.block[0] * self.block[1] + 2)
    }

    /// Colours of rows that are stored together: for each block its lumas, and the two differences.
    ///
    /// - `rgb`: `[rows, width, 3]`, of at most [`Self::rows`] rows.
    pub(super) fn unpack(&self, stored: &[u8], width: usize, rgb: &mut [u8]) {
        let [across, down] = self.block;
        for (y, row) in rgb.chunks_exact_mut(3 * width).enumerate() {
            let blocks = stored.chunks_exact(across * down + 2);
            for (block, texels) in blocks.zip(row.chunks_mut(3 * across)) {
                let differences = [block[across * down], block[across * down + 1]];
                let lumas = &block[y * across..];
                for (&luma, texel) in lumas.iter().zip(texels.chunks_exact_mut(3)) {
                    texel.copy_from_slice(&self.rgb(luma, differences));
                }
            }
        }
    }

    fn rgb(&self, luma: u8, [blue, red]: [u8; 2]) -> [u8; 3] {
        let code = |code: u8, [black, white]: [f32; 2], full: f32| {
            (f32::from(code) - black) * full / (white - black)
        };
        let [luma_range, blue_range, red_range] = self.range;
        let luma = code(luma, luma_range, 255.0);
        let [of_red, of_green, of_blue] = self.shares;
        let red = luma + code(red, red_range, 127.0) * (2.0 - 2.0 * of_red);
        let blue = luma + code(blue, blue_range, 127.0) * (2.0 - 2.0 * of_blue);
        let green = (luma - of_blue * blue - of_red * red) / of_green;
        // Casts clamp.
        [red, green, blue].map(|level| level.round() as u8)
    }
}

/// As many fractions as a tag must have.
fn numbers<R: Read + Seek, const N: usize>(
    directory: &mut Directory<R>,
    tag: u16,
) -> Result<Option<[f32; N]>, ImageError> {
    let Some(numbers) = directory.fractions(tag)? else { return Ok(None) };
    match <[f64; N]>::try_from(&numbers[..]) {
        Ok(numbers) if numbers.iter().all(|number| number.is_finite()) => {
            Ok(Some(numbers.map(|number| number as f32)))
        }
        _ => Err(damaged(format!("tag {tag} must have {N} numbers, got {numbers:?}"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_share_differences() {
        let full = [[0.0, 255.0], [128.0, 255.0], [128.0, 255.0]];
        let stored = YCbCr { block: [2, 2], shares: [0.299, 0.587, 0.114], range: full };
        // Two blocks for rows of 3 texels; the second is red, by luma 76, blue 85 and red 255.
        let bytes = [10, 20, 30, 40, 128, 128, 76, 9, 76, 9, 85, 255];
        assert_eq!(stored.stored_bytes(3), bytes.len());
        let mut rgb = [0; 2 * 3 * 3];
        stored.unpack(&bytes, 3, &mut rgb);
        let wanted = [[10; 3], [20; 3], [254, 0, 0], [30; 3], [40; 3], [254, 0, 0]];
        assert_eq!(rgb, wanted.as_flattened());
        // The last row of an odd height has no other.
        let mut rgb = [0; 3 * 3];
        stored.unpack(&bytes, 3, &mut rgb);
        assert_eq!(rgb, wanted[..3].as_flattened());
        // Codes of studio video: white is 235, grey has differences of 128.
        let studio = [[16.0, 235.0], [128.0, 240.0], [128.0, 240.0]];
        let stored = YCbCr { range: studio, ..stored };
        assert_eq!(stored.rgb(235, [128, 128]), [255; 3]);
        assert_eq!(stored.rgb(16, [128, 128]), [0; 3]);
    }
}
