//! Strips and tiles: where they are in the file and in the image.

use std::io::{Read, Seek};

use uvgraft::texture::Size;

use super::directory::Directory;
use super::layout::Samples;
use super::{FORMAT, damaged, tags};
use crate::ImageError;

/// How an image is divided into strips or tiles, row by row, and plane by plane if it has planes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid {
    image: Size,
    /// Sides of a strip or tile. Tiles at the right and bottom edge are padded, strips are not.
    pub(super) width: u32,
    pub(super) height: u32,
    is_tiled: bool,
    planes: usize,
}

/// Where a strip or tile belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    /// The sample that it has, if it has only one.
    pub(super) plane: usize,
    /// Its top left corner.
    pub(super) x: u32,
    pub(super) y: u32,
    /// What of it is inside the image.
    pub(super) width: u32,
    pub(super) height: u32,
}

impl Grid {
    pub(super) fn read<R: Read + Seek>(
        directory: &mut Directory<R>,
        image: Size,
        samples: &Samples,
    ) -> Result<Self, ImageError> {
        let side = |number: Option<u64>| {
            number.map(|side| u32::try_from(side).unwrap_or(u32::MAX)).filter(|&side| side > 0)
        };
        let planes = if samples.is_planar { samples.count } else { 1 };
        let tile_width = directory.number(tags::TILE_WIDTH)?;
        let is_tiled = tile_width.is_some();
        let (width, height) = if is_tiled {
            (side(tile_width), side(directory.number(tags::TILE_LENGTH)?))
        } else {
            let rows = directory.number(tags::ROWS_PER_STRIP)?.unwrap_or(u64::MAX);
            (Some(image.width), side(Some(rows.min(image.height.into()))))
        };
        let (Some(width), Some(height)) = (width, height) else {
            return Err(damaged("its strips or tiles have no texels"));
        };
        Ok(Self { image, width, height, is_tiled, planes })
    }

    fn across(&self) -> usize {
        self.image.width.div_ceil(self.width) as usize
    }

    fn down(&self) -> usize {
        self.image.height.div_ceil(self.height) as usize
    }

    /// Number of strips or tiles.
    pub(super) fn len(&self) -> usize {
        self.across() * self.down() * self.planes
    }

    pub(super) fn place(&self, index: usize) -> Place {
        let in_plane = self.across() * self.down();
        let (plane, index) = (index / in_plane, index % in_plane);
        let x = (index % self.across()) as u32 * self.width;
        let y = (index / self.across()) as u32 * self.height;
        let width = self.width.min(self.image.width - x);
        let height = self.height.min(self.image.height - y);
        Place { plane, x, y, width, height }
    }

    /// For each strip or tile its bytes in a file.
    ///
    /// # Errors
    /// [`ImageError::Truncated`] if any of them is not in the file.
    pub(super) fn find<'f, R: Read + Seek>(
        &self,
        directory: &mut Directory<R>,
        file: &'f [u8],
    ) -> Result<Vec<&'f [u8]>, ImageError> {
        let [offsets, counts] = if self.is_tiled {
            [tags::TILE_OFFSETS, tags::TILE_BYTE_COUNTS]
        } else {
            [tags::STRIP_OFFSETS, tags::STRIP_BYTE_COUNTS]
        };
        // Some programs give tiles the tags of strips.
        let offsets = match directory.numbers(offsets)? {
            None => directory.numbers(tags::STRIP_OFFSETS)?,
            offsets => offsets,
        };
        let offsets = offsets.unwrap_or_default();
        let counts = match directory.numbers(counts)? {
            None => directory.numbers(tags::STRIP_BYTE_COUNTS)?,
            counts => counts,
        };
        // Without lengths, each may extend to the end of the file.
        let counts = counts.unwrap_or_else(|| {
            offsets.iter().map(|&at| (file.len() as u64).saturating_sub(at).max(1)).collect()
        });
        let wanted = self.len();
        for found in [offsets.len(), counts.len()] {
            if found < wanted {
                let reason = format!("must have {wanted} strips or tiles, got {found}");
                return Err(damaged(reason));
            }
        }
        let bytes = |(at, count): (u64, u64)| {
            let range = usize::try_from(at).ok()?..usize::try_from(at.checked_add(count)?).ok()?;
            file.get(range)
        };
        let found = offsets.into_iter().zip(counts).take(wanted);
        let found: Option<Vec<_>> = found.map(bytes).collect();
        found.ok_or(ImageError::Truncated { format: FORMAT })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_cut_at_the_edges() {
        let image = Size::new(37, 23);
        let grid = Grid { image, width: 16, height: 20, is_tiled: true, planes: 2 };
        assert_eq!(grid.len(), 12);
        let place = |plane, x, y, width, height| Place { plane, x, y, width, height };
        assert_eq!(grid.place(0), place(0, 0, 0, 16, 20));
        assert_eq!(grid.place(5), place(0, 32, 20, 5, 3));
        assert_eq!(grid.place(7), place(1, 16, 0, 16, 20));
    }
}
