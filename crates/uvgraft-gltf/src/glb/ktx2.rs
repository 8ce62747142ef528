//! Textures as KTX2 files: UASTC blocks with all mip levels, which stay compressed in GPU memory.
//!
//! Sources: Khronos Group, "KTX File Format Specification", version 2.0, "Khronos Data Format
//! Specification", version 1.3 (the descriptor), and `KHR_texture_basisu`.

use uvgraft::{Averaging, Channels, Depth, Encoding, Filter, Size, Texels, Texture, TextureError};

use super::embed_error::EmbedError;
use super::ktx2_header::KTX2_IDENTIFIER;
use super::uastc::{self, Level};

/// Encodes an sRGB or data texture; returns the file and its size in texels.
///
/// Readers need only support sides that are multiples of 4; other sides are stretched to the next
/// multiple, which leaves every point of the image at its UV.
///
/// # Errors
/// [`EmbedError`] if a side is above 16384, or for lack of memory.
pub(crate) fn encode(texture: Texture, has_alpha: bool) -> Result<(Vec<u8>, Size), EmbedError> {
    let Size { width, height } = texture.size();
    if width.max(height) > uastc::MAX_SIDE {
        return Err(EmbedError::Ktx2 { problem: "must have at most 16384 texels a side" });
    }
    let is_color = texture.encoding() != Encoding::Data;
    let size = Size::new(width.next_multiple_of(4), height.next_multiple_of(4));
    let texture = texture.converted(Channels::Rgba, Depth::U8).resized(
        size,
        Filter::CatmullRom,
        Averaging::Encoded,
    )?;
    let levels = pyramid(texture, is_color)?;
    let blocks = uastc::encode(&levels, is_color)
        .ok_or(EmbedError::Ktx2 { problem: "could not be encoded" })?;
    Ok((file(size, is_color, has_alpha, &blocks), size))
}

/// The mip chain: the texture and smaller ones down to a single texel, each with half the
/// width and height, rounded down.
fn pyramid(mut texture: Texture, is_color: bool) -> Result<Vec<Level>, TextureError> {
    let averaging = if is_color { Averaging::Light } else { Averaging::Encoded };
    let mut levels = Vec::new();
    loop {
        let size = texture.size();
        let half = Size::new((size.width / 2).max(1), (size.height / 2).max(1));
        let next = match half == size {
            true => None,
            false => Some(texture.clone().resized(half, Filter::Bilinear, averaging)?),
        };
        if let Texels::U8(rgba) = texture.into_texels() {
            levels.push(Level { size, rgba });
        }
        match next {
            Some(next) => texture = next,
            None => return Ok(levels),
        }
    }
}

/// Assembles a file from the blocks of its levels, largest level first.
fn file(size: Size, is_color: bool, has_alpha: bool, levels: &[Vec<u8>]) -> Vec<u8> {
    const HEADER: usize = 80;
    const LEVEL: usize = 24;
    let descriptor = descriptor(is_color, has_alpha);
    let metadata = metadata();
    let descriptor_at = HEADER + LEVEL * levels.len();
    let metadata_at = descriptor_at + descriptor.len();
    // Levels are aligned to the block size and consist of whole blocks.
    let first = (metadata_at + metadata.len()).next_multiple_of(uastc::BLOCK);
    let mut out = KTX2_IDENTIFIER.to_vec();
    let mut words = |words: &[usize]| {
        out.extend(words.iter().flat_map(|&word| (word as u32).to_le_bytes()));
    };
    // vkFormat undefined, typeSize 1, width, height; no depth, no layers, one face, levels.
    words(&[0, 1, size.width as usize, size.height as usize, 0, 0, 1, levels.len()]);
    // No supercompression.
    words(&[0]);
    words(&[descriptor_at, descriptor.len(), metadata_at, metadata.len()]);
    // No supercompression global data.
    words(&[0; 4]);
    for index in 0..levels.len() {
        // The smallest level is stored first.
        let before: usize = levels[index + 1..].iter().map(Vec::len).sum();
        let len = levels[index].len();
        for value in [first + before, len, len] {
            out.extend((value as u64).to_le_bytes());
        }
    }
    out.extend(descriptor);
    out.extend(metadata);
    out.resize(first, 0);
    for level in levels.iter().rev() {
        out.extend(level);
    }
    out
}

/// The format of the blocks: a basic data format descriptor.
fn descriptor(is_color: bool, has_alpha: bool) -> Vec<u8> {
    const UASTC: u8 = 166;
    const UNSPECIFIED: u8 = 0;
    const BT709: u8 = 1;
    const LINEAR: u8 = 1;
    const SRGB: u8 = 2;
    const RGB: u8 = 0;
    const RGBA: u8 = 3;
    let (primaries, transfer) = if is_color { (BT709, SRGB) } else { (UNSPECIFIED, LINEAR) };
    let mut out = Vec::new();
    // Total length; vendor Khronos and the basic descriptor type; version 2; block length.
    out.extend(44_u32.to_le_bytes());
    out.extend(0_u32.to_le_bytes());
    out.extend(2_u16.to_le_bytes());
    out.extend(40_u16.to_le_bytes());
    // The last: alpha is not premultiplied.
    out.extend([UASTC, primaries, transfer, 0]);
    // Sides of a block minus one.
    out.extend([3, 3, 0, 0]);
    // Bytes in a block, for plane 0 of 8.
    out.extend([uastc::BLOCK as u8, 0, 0, 0, 0, 0, 0, 0]);
    // One sample: bit offset, bit length minus one, and channel.
    out.extend([0, 0, 127, if has_alpha { RGBA } else { RGB }]);
    // Sample position, lower and upper limit.
    out.extend(0_u32.to_le_bytes());
    out.extend(0_u32.to_le_bytes());
    out.extend(u32::MAX.to_le_bytes());
    out
}

/// Key/value data, sorted by key.
fn metadata() -> Vec<u8> {
    let mut out = Vec::new();
    // Texels run to the right, rows run down.
    for entry in ["KTXorientation\0rd\0", "KTXwriter\0uvgraft\0"] {
        out.extend((entry.len() as u32).to_le_bytes());
        out.extend(entry.as_bytes());
        out.resize(out.len().next_multiple_of(4), 0);
    }
    out
}

#[cfg(test)]
mod tests {
    use basis_universal::transcoding::{
        TranscodeParameters, Transcoder, TranscoderTextureFormat as TargetFormat,
    };

    use super::super::{EmbeddedFormat, EmbeddedImage};
    use super::*;

    /// Waves with a period of 256 texels, and an alpha ramp along X.
    fn smooth(size: Size, channels: Channels, encoding: Encoding) -> Texture {
        let mut values = Vec::new();
        for k in 0..size.texels() {
            let (x, y) = (k % size.width as usize, k / size.width as usize);
            let wave = |phase: f32| {
                let angle = (x as f32 + phase * y as f32) * std::f32::consts::TAU / 256.0;
                (127.5 + 90.0 * angle.sin()) as u8
            };
            let all = [wave(0.3), wave(1.0), wave(-0.5), (x * 255 / size.width as usize) as u8];
            values.extend(&all[..channels.count()]);
        }
        Texture::new(size, channels, encoding, Texels::U8(values)).unwrap()
    }

    fn word(file: &[u8], at: usize) -> u32 {
        u32::from_le_bytes(*file[at..].first_chunk().unwrap())
    }

    /// The levels of a file, decoded by the encoder's own decoder.
    ///
    /// That decoder reads `.basis` files. It reports where the blocks of a level are in one, and
    /// the KTX2 file must have the same blocks at the offset in its level index.
    fn decoded(file: &[u8], levels: &[Level], is_color: bool) -> Vec<Vec<u8>> {
        let basis = uastc::basis_file(levels, is_color).unwrap();
        let mut decoder = Transcoder::new();
        decoder.prepare_transcoding(&basis).unwrap();
        assert_eq!(word(file, 40) as usize, levels.len());
        let level = |(index, level): (usize, &Level)| {
            let side = |at: usize| (word(file, at) >> index).max(1);
            assert_eq!(level.size, Size::new(side(20), side(24)));
            let (at, len) = (word(file, 80 + 24 * index), word(file, 88 + 24 * index));
            let image_index = index as u32;
            let info = decoder.image_level_info(&basis, image_index, 0).unwrap();
            let wanted = &basis[info.m_rgb_file_ofs as usize..][..info.m_rgb_file_len as usize];
            assert!(file[at as usize..][..len as usize] == *wanted, "blocks of level {index}");
            let which = TranscodeParameters { image_index, ..TranscodeParameters::default() };
            decoder.transcode_image_level(&basis, TargetFormat::RGBA32, which).unwrap()
        };
        levels.iter().enumerate().map(level).collect()
    }

    /// PSNR over all four channels, in dB.
    fn psnr(found: &[u8], wanted: &[u8]) -> f64 {
        assert_eq!(found.len(), wanted.len());
        let squares =
            found.iter().zip(wanted).map(|(&a, &b)| (f64::from(a) - f64::from(b)).powi(2));
        10.0 * (255.0 * 255.0 * wanted.len() as f64 / squares.sum::<f64>().max(1e-9)).log10()
    }

    fn rgba(texture: Texture) -> Vec<u8> {
        match texture.converted(Channels::Rgba, Depth::U8).into_texels() {
            Texels::U8(values) => values,
            other => panic!("{} values that are not bytes", other.len()),
        }
    }

    #[test]
    fn every_level_decodes_to_the_image() {
        let size = Size::new(256, 128);
        for (channels, has_alpha) in [(Channels::Rgb, false), (Channels::Rgba, true)] {
            let texture = smooth(size, channels, Encoding::Srgb);
            let (file, _) = encode(texture.clone(), has_alpha).unwrap();
            let levels =
                pyramid(texture.clone().converted(Channels::Rgba, Depth::U8), true).unwrap();
            // 256, 128, 64, 32, 16, 8, 4, 2, 1.
            assert_eq!(levels.len(), 9);
            assert_eq!(levels[0].rgba, rgba(texture));
            let found = decoded(&file, &levels, true);
            // The waves' period halves with each level, which costs 5 dB; the first two levels are
            // smooth.
            for (index, level) in levels.iter().enumerate().take(2) {
                let psnr = psnr(&found[index], &level.rgba);
                assert!(psnr > 40.0, "level {index} of {channels:?}: {psnr} dB");
            }
        }
    }

    #[test]
    fn levels_are_means_of_light() {
        // Squares of 2 × 2 texels, one or two of them white. The means of linear light, 1/4 and
        // 1/2, are sRGB levels 137 and 188 (1.055 l^(1 / 2.4) - 0.055); those of data are 64 and 128.
        for (whites, encoding, mean) in [
            (1, Encoding::Srgb, 137),
            (2, Encoding::Srgb, 188),
            (1, Encoding::Data, 64),
            (2, Encoding::Data, 128),
        ] {
            let value = |k: usize| if k % 2 == 1 && (whites == 2 || k % 16 < 8) { 255 } else { 0 };
            let texels = Texels::U8((0..64).map(value).collect());
            let texture = Texture::new(Size::square(8), Channels::Grey, encoding, texels).unwrap();
            let is_color = encoding == Encoding::Srgb;
            let (file, _) = encode(texture.clone(), false).unwrap();
            let levels = pyramid(texture.converted(Channels::Rgba, Depth::U8), is_color).unwrap();
            let found = decoded(&file, &levels, is_color);
            // UASTC has a mode for single-colour blocks, which is exact.
            for (index, texels) in [(1, 16), (2, 4), (3, 1)] {
                let wanted = [mean, mean, mean, 255].repeat(texels);
                assert_eq!(found[index], wanted, "level {index} of {encoding:?}, {whites} white");
            }
        }
    }

    #[test]
    fn files_are_laid_out_as_specified() {
        let (file, size) =
            encode(smooth(Size::new(12, 8), Channels::Rgb, Encoding::Srgb), false).unwrap();
        assert_eq!(size, Size::new(12, 8));
        assert_eq!(file[..12], *b"\xabKTX 20\xbb\r\n\x1a\n");
        let words: Vec<u32> = (3..20).map(|k| word(&file, 4 * k)).collect();
        // Levels of 12x8, 6x4, 3x2 and 1x1; the index ends at 80 + 4 * 24.
        assert_eq!(words, [0, 1, 12, 8, 0, 0, 1, 4, 0, 176, 44, 220, 48, 0, 0, 0, 0]);
        let index: Vec<u32> = (20..44).map(|k| word(&file, 4 * k)).collect();
        let level = |at: u32, len: u32| [at, 0, len, 0, len, 0];
        // 3x2, 2x1, 1 and 1 blocks, the last first.
        let wanted = [level(336, 96), level(304, 32), level(288, 16), level(272, 16)];
        assert_eq!(index, wanted.as_flattened());
        assert_eq!(file.len(), 336 + 96);
        let wanted: [u8; 44] = [
            44, 0, 0, 0, 0, 0, 0, 0, 2, 0, 40, 0, 166, 1, 2, 0, 3, 3, 0, 0, 16, 0, 0, 0, 0, 0, 0,
            0, 0, 0, 127, 0, 0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255,
        ];
        assert_eq!(file[176..220], wanted);
        let facts = b"\x12\0\0\0KTXorientation\0rd\0\0\0\x12\0\0\0KTXwriter\0uvgraft\0\0\0";
        assert_eq!(file[220..268], *facts);
    }

    #[test]
    fn descriptors_distinguish_data_and_alpha() {
        assert_eq!(descriptor(false, false)[12..16], [166, 0, 1, 0]);
        assert_eq!(descriptor(true, true)[12..16], [166, 1, 2, 0]);
        assert_eq!((descriptor(true, true)[31], descriptor(true, false)[31]), (3, 0));
    }

    #[test]
    fn sides_become_multiples_of_4() {
        let texture = smooth(Size::new(63, 130), Channels::Rgba, Encoding::Srgb);
        let picture = EmbeddedImage::encode(texture, EmbeddedFormat::Ktx2, 90).unwrap();
        assert_eq!((picture.size(), picture.format()), (Size::new(64, 132), EmbeddedFormat::Ktx2));
        assert_eq!(EmbeddedImage::new(picture.bytes().to_vec()).unwrap(), picture);
        let wide = [0.5];
        let size = Size::new(uastc::MAX_SIDE + 1, 1);
        let wide = Texture::filled(size, Channels::Grey, Encoding::Srgb, Depth::U8, &wide).unwrap();
        let error = EmbeddedImage::encode(wide, EmbeddedFormat::Ktx2, 90).unwrap_err();
        assert_eq!(error.to_string(), "a KTX2 image must have at most 16384 texels a side");
    }
}
