//! UASTC blocks, 4 × 4 texels in 16 bytes each, from the encoder of Basis Universal.
//!
//! The encoder produces `.basis` files: a header, slice descriptions, and slices. Here each slice
//! is a mip level, and for UASTC its bytes are exactly those of a KTX2 level.
//!
//! Source: Binomial, "Basis Universal" (the layout of `.basis` files).

use basis_universal::BasisTextureFormat;
use basis_universal::encoding::{ColorSpace, Compressor, CompressorParams};
use uvgraft::{Size, threads};

/// Largest side, in texels.
pub(super) const MAX_SIDE: u32 = 16_384;

/// Size of a block, in bytes.
pub(super) const BLOCK: usize = 16;

/// A mip level: RGBA texels, row by row from the top.
pub(super) struct Level {
    pub size: Size,
    pub rgba: Vec<u8>,
}

/// Number of blocks of an image; those at the edges may extend beyond it.
pub(super) const fn blocks(size: Size) -> usize {
    size.width.div_ceil(4) as usize * size.height.div_ceil(4) as usize
}

/// The blocks of each level, row by row from the top; `None` if the encoder fails.
///
/// Each level must have 1 to [`MAX_SIDE`] texels on a side and a matching number of values.
pub(super) fn encode(levels: &[Level], is_color: bool) -> Option<Vec<Vec<u8>>> {
    slices(&basis_file(levels, is_color)?, levels)
}

/// A `.basis` file with an image for each level; `None` if the encoder fails.
#[expect(unsafe_code, reason = "the encoder is C++ and leaves it to callers to check what it gets")]
pub(super) fn basis_file(levels: &[Level], is_color: bool) -> Option<Vec<u8>> {
    let is_sound = |level: &Level| {
        let Size { width, height } = level.size;
        let sides = 1..=MAX_SIDE;
        let is_size = sides.contains(&width) && sides.contains(&height);
        is_size && level.rgba.len() == 4 * level.size.texels()
    };
    if levels.is_empty() || !levels.iter().all(is_sound) {
        return None;
    }
    let mut params = CompressorParams::new();
    params.set_basis_format(BasisTextureFormat::UASTC4x4);
    params.set_color_space(if is_color { ColorSpace::Srgb } else { ColorSpace::Linear });
    // Each level is a separate image: the encoder's own mipmap filter differs from ours.
    params.set_generate_mipmaps(false);
    params.resize_source_image_list(levels.len() as u32);
    for (index, Level { size, rgba }) in (0..).zip(levels) {
        params.source_image_mut(index).init(rgba, size.width, size.height, 4);
    }
    // Blocks are encoded independently, so the number of threads does not affect the result.
    let most = threads::count().min(64) as u32;
    let mut compressor = Compressor::new(most);
    // SAFETY: the parameters are the encoder's defaults except for a supported format and images
    // whose buffers match their sizes, none empty or above the encoder's limit.
    let is_ready = unsafe { compressor.init(&params) };
    drop(params);
    if !is_ready {
        return None;
    }
    // SAFETY: as above, and the encoder accepted them.
    unsafe { compressor.process() }.ok()?;
    Some(compressor.basis_file().to_vec())
}

/// Extracts the slices from a `.basis` file that has one for each level.
fn slices(file: &[u8], levels: &[Level]) -> Option<Vec<Vec<u8>>> {
    const TOTAL: usize = 14;
    const FORMAT: usize = 20;
    const DESCRIPTIONS: usize = 65;
    const DESCRIPTION_LEN: usize = 23;
    const OFFSET: usize = 13;
    const UASTC: u8 = 1;
    let word = |at: usize| {
        let word = file.get(at..)?.first_chunk().map(|&word| u32::from_le_bytes(word));
        word.map(|word| word as usize)
    };
    if !file.starts_with(b"sB") || file.get(FORMAT) != Some(&UASTC) {
        return None;
    }
    // The number of slices is a 24-bit field.
    if word(TOTAL)? & 0xff_ffff != levels.len() {
        return None;
    }
    let first = word(DESCRIPTIONS)?;
    let slice = |(index, level): (usize, &Level)| {
        let description = first.checked_add(index * DESCRIPTION_LEN)?.checked_add(OFFSET)?;
        let (start, len) = (word(description)?, word(description + 4)?);
        let slice = file.get(start..start.checked_add(len)?)?;
        (len == BLOCK * blocks(level.size)).then(|| slice.to_vec())
    };
    levels.iter().enumerate().map(slice).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(width: u32, height: u32) -> Level {
        let size = Size::new(width, height);
        let rgba = (0..4 * size.texels()).map(|k| (k * 37 % 256) as u8).collect();
        Level { size, rgba }
    }

    #[test]
    fn each_level_has_its_blocks() {
        let levels = [level(12, 8), level(6, 4), level(3, 2), level(1, 1)];
        let all = encode(&levels, true).unwrap();
        let lens: Vec<usize> = all.iter().map(Vec::len).collect();
        assert_eq!(lens, [6 * 16, 2 * 16, 16, 16]);
        // The encoding of a level does not depend on the others.
        for (level, blocks) in levels.into_iter().zip(all) {
            assert_eq!(encode(&[level], true).unwrap(), [blocks]);
        }
    }

    #[test]
    fn unsound_levels_never_reach_the_encoder() {
        let short = Level { size: Size::new(4, 4), rgba: vec![0; 63] };
        let empty = Level { size: Size::new(0, 4), rgba: Vec::new() };
        for levels in [vec![], vec![short], vec![empty], vec![level(MAX_SIDE + 1, 1)]] {
            assert_eq!(encode(&levels, true), None);
        }
    }

    #[test]
    fn truncated_files_have_no_slices() {
        let one = [level(4, 4)];
        let mut file = vec![0; 100];
        file[..2].copy_from_slice(b"sB");
        (file[14], file[20], file[65]) = (1, 1, 77);
        // The slice would start at offset 100.
        (file[77 + 13], file[77 + 17]) = (100, 16);
        assert_eq!(slices(&file, &one), None);
        file.extend(0..16);
        assert_eq!(slices(&file, &one), Some(vec![(0..16).collect()]));
        assert!((0..file.len()).all(|len| slices(&file[..len], &one).is_none()));
        assert_eq!(slices(&file, &[level(8, 4)]), None);
    }
}
