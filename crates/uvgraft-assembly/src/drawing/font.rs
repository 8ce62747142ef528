//! The font of captions: Noto Sans Mono, under the SIL Open Font License 1.1 (`LICENSE-OFL`).

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, RasterizedChar, get_raster};

const WEIGHT: FontWeight = FontWeight::Regular;

/// A size of the font, by its scale: capitals are about 8 pixels times that high.
#[derive(Debug, Clone, Copy)]
pub(super) struct FontSize {
    raster: RasterHeight,
    /// How often each pixel of the raster is repeated in either direction.
    repeats: u32,
}

impl FontSize {
    /// - `scale`: 1, or an even number.
    pub(super) fn new(scale: u32) -> Self {
        match scale {
            0 | 1 => Self { raster: RasterHeight::Size16, repeats: 1 },
            _ => Self { raster: RasterHeight::Size32, repeats: scale / 2 },
        }
    }

    /// From the top of a line to that of the next, in pixels; capitals are in the middle half of it.
    pub(super) fn height(self) -> u32 {
        self.raster.val() as u32 * self.repeats
    }

    /// The width of a character in pixels, the same for all.
    pub(super) fn width(self) -> u32 {
        let width = noto_sans_mono_bitmap::get_raster_width(WEIGHT, self.raster);
        width as u32 * self.repeats
    }

    /// How much of each pixel a character covers, as shares of 255, with the pixel's column and row. A character
    /// that the font does not have is a question mark.
    pub(super) fn coverage(self, character: char) -> impl Iterator<Item = ([u32; 2], u8)> {
        let of = |character| get_raster(character, WEIGHT, self.raster);
        let glyph = of(character).or_else(|| of('?'));
        let rows = glyph.into_iter().flat_map(|glyph: RasterizedChar| (0..).zip(glyph.rows()));
        let pixels = rows.flat_map(|(row, values)| {
            (0..).zip(values).map(move |(column, &value)| ([column, row], value))
        });
        let covered = pixels.filter(|&(_, value)| value > 0);
        covered.flat_map(move |([column, row], value)| {
            (0..self.repeats * self.repeats).map(move |index| {
                let [x, y] = [index % self.repeats, index / self.repeats];
                ([column * self.repeats + x, row * self.repeats + y], value)
            })
        })
    }
}
