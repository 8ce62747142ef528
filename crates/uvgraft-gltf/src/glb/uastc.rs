//! Blocks of 4 by 4 texels in 16 bytes each, from the encoder of Basis Universal.
//!
//! The encoder makes `.basis` files: a header, descriptions of slices, and slices. Here a slice is a
//! mip level, and in UASTC its bytes are what a KTX2 file holds.
//!
//! Source: Binomial, "Basis Universal" (the layout of `.basis` files).

use basis_universal::BasisTextureFormat;
use basis_universal::encoding::{ColorSpace, Compressor, CompressorParams};
use uvgraft::{Size, threads};

/// The most texels on a side.
pub(super) const MAX_SIDE: u32 = 16_384;

/// The bytes of a block.
pub(super) const BLOCK: usize = 16;

/// A mip level: red, green, blue and opacity of each texel, row by row from the top.
pub(super) struct Level {
    pub size: Size,
    pub rgba: Vec<u8>,
}

/// How many blocks an image has; those at the edges may reach beyond it.
pub(super) const fn blocks(size: Size) -> usize {
    size.width.div_ceil(4) as usize * size.height.div_ceil(4) as usize
}

/// The blocks of each level, row by row from the top; none if the encoder fails.
///
/// Each level is to have 1 to [`MAX_SIDE`] texels on a side and as many values as that needs.
pub(super) fn encode(levels: &[Level], is_color: bool) -> Option<Vec<Vec<u8>>> {
    slices(&basis_file(levels, is_color)?, levels)
}

/// A `.basis` file with an image for each level; none if the encoder fails.
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
    // Each level is an image by itself: the encoder would filter them otherwise than the rest here.
    params.set_generate_mipmaps(false);
    params.resize_source_image_list(levels.len() as u32);
    for (index, Level { size, rgba }) in (0..).zip(levels) {
        params.source_image_mut(index).init(rgba, size.width, size.height, 4);
    }
    // Blocks are independent of each other, so that threads change nothing.
    let most = threads::count().min(64) as u32;
    let mut compressor = Compressor::new(most);
    // SAFETY: the parameters are the encoder's own but for a format it has and images that hold as many
    // texels as their sizes say, none empty or above its limit.
    let is_ready = unsafe { compressor.init(&params) };
    drop(params);
    if !is_ready {
        return None;
    }
    // SAFETY: as above, and the encoder accepted them.
    unsafe { compressor.process() }.ok()?;
    Some(compressor.basis_file().to_vec())
}

/// Takes the slices out of a `.basis` file with one for each level.
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
    // The number of slices has three bytes.
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
        // What a level becomes does not depend on the others.
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
    fn files_that_are_cut_short_have_no_slices() {
        let one = [level(4, 4)];
        let mut file = vec![0; 100];
        file[..2].copy_from_slice(b"sB");
        (file[14], file[20], file[65]) = (1, 1, 77);
        // The slice would begin at 100.
        (file[77 + 13], file[77 + 17]) = (100, 16);
        assert_eq!(slices(&file, &one), None);
        file.extend(0..16);
        assert_eq!(slices(&file, &one), Some(vec![(0..16).collect()]));
        assert!((0..file.len()).all(|len| slices(&file[..len], &one).is_none()));
        assert_eq!(slices(&file, &[level(8, 4)]), None);
    }
}
