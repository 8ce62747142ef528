//! Images in KTX2 files of Basis Universal: UASTC, uncompressed or with Zstandard, and ETC1S.
//!
//! Our transcoder reads `.basis` files, so one is assembled from the parts of the KTX2 file. Its call
//! for bare blocks of UASTC takes the width in blocks for that in texels, and writes out of bounds.
//!
//! # Source
//! Khronos, "KTX File Format Specification", version 2.0, "BasisLZ Global Data"; Binomial,
//! "basis_file_headers.h".

use std::io::Read as _;

use basis_universal::transcoding::{TranscodeParameters, Transcoder, TranscoderTextureFormat};
use uvgraft::{Channels, Encoding, Size, Texels, Texture};

use crate::glb::Ktx2Header;

/// Size of a block of 4 × 4 texels, in bytes.
const UASTC_BLOCK: usize = 16;

/// Size of an image's description in the global data of ETC1S, in bytes.
const PICTURE: usize = 20;

/// What images of ETC1S share: endpoints, selectors and tables.
#[derive(Default)]
struct Codebooks<'a> {
    /// Number of endpoints in the lower 16 bits, and of selectors in the upper.
    counts: u32,
    parts: [&'a [u8]; 3],
}

/// A file's header, its largest image, and the data shared by all images.
struct Ktx2<'a> {
    size: Size,
    supercompression: u32,
    model: u8,
    is_srgb: bool,
    level: &'a [u8],
    global: &'a [u8],
    /// Number of images: levels × layers × faces.
    pictures: usize,
}

const NO_SUPERCOMPRESSION: u32 = 0;
const BASIS_LZ: u32 = 1;
const ZSTANDARD: u32 = 2;
const ETC1S: u8 = 163;
const UASTC: u8 = 166;

/// The image size from the header, without decoding.
pub(super) fn size(bytes: &[u8]) -> Result<Size, String> {
    Ktx2::new(bytes).map(|file| file.size)
}

/// A file's largest image, as 8-bit RGBA. The caller has limited its size.
pub(super) fn decode(bytes: &[u8]) -> Result<Texture, String> {
    let file = Ktx2::new(bytes)?;
    let rgba = match (file.model, file.supercompression) {
        (UASTC, NO_SUPERCOMPRESSION) => file.uastc(file.level)?,
        (UASTC, ZSTANDARD) => file.uastc(&file.inflated()?)?,
        (ETC1S, BASIS_LZ) => file.etc1s()?,
        (model, scheme) => {
            return Err(format!(
                "texels must be UASTC or ETC1S, got colour model {model} with \
                 supercompression {scheme}"
            ));
        }
    };
    let encoding = if file.is_srgb { Encoding::Srgb } else { Encoding::Data };
    Texture::new(file.size, Channels::Rgba, encoding, Texels::U8(rgba))
        .map_err(|error| error.to_string())
}

fn word(bytes: &[u8], at: usize) -> Result<u32, String> {
    let four = bytes.get(at..).and_then(|rest| rest.first_chunk());
    four.map(|four| u32::from_le_bytes(*four)).ok_or_else(cut_short)
}

fn long(bytes: &[u8], at: usize) -> Result<u64, String> {
    let eight = bytes.get(at..).and_then(|rest| rest.first_chunk());
    eight.map(|eight| u64::from_le_bytes(*eight)).ok_or_else(cut_short)
}

fn part(bytes: &[u8], [offset, length]: [u64; 2]) -> Result<&[u8], String> {
    let end = offset.checked_add(length).filter(|&end| end <= bytes.len() as u64);
    end.map(|end| &bytes[offset as usize..end as usize]).ok_or_else(cut_short)
}

fn cut_short() -> String {
    "truncated KTX2 file".to_owned()
}

impl<'a> Ktx2<'a> {
    fn new(bytes: &'a [u8]) -> Result<Self, String> {
        let header = Ktx2Header::read(bytes).ok_or_else(cut_short)?;
        let Ktx2Header { sides: [width, height, depth], layers, faces, levels, .. } = header;
        if width == 0 || height == 0 || depth != 0 || layers > 1 || faces != 1 || levels > 32 {
            return Err("a KTX2 file must hold a single 2D image".to_owned());
        }
        // The transcoder takes 16-bit sizes.
        if width.max(height) > u32::from(u16::MAX) {
            return Err(format!(
                "a KTX2 image must have sides of at most 65535 texels, got {width} x {height}"
            ));
        }
        let descriptor = part(bytes, header.descriptor)?;
        let [model, transfer] = [12, 14].map(|at| descriptor.get(at).copied().unwrap_or_default());
        Ok(Self {
            size: Size::new(width, height),
            supercompression: header.supercompression,
            model,
            is_srgb: transfer == 2,
            level: part(bytes, [long(bytes, 80)?, long(bytes, 88)?])?,
            global: part(bytes, header.global)?,
            pictures: levels.max(1) as usize,
        })
    }

    fn blocks(&self) -> [u32; 2] {
        [self.size.width.div_ceil(4), self.size.height.div_ceil(4)]
    }

    /// Size of the largest image's blocks, in bytes.
    fn block_bytes(&self) -> usize {
        self.blocks().map(|count| count as usize).iter().product::<usize>() * UASTC_BLOCK
    }

    fn inflated(&self) -> Result<Vec<u8>, String> {
        let bad = |error: &dyn std::fmt::Display| format!("Zstandard stream: {error}");
        let decoder = ruzstd::decoding::StreamingDecoder::new(self.level).map_err(|e| bad(&e))?;
        let mut blocks = Vec::new();
        let most = self.block_bytes() as u64 + 1;
        decoder.take(most).read_to_end(&mut blocks).map_err(|error| bad(&error))?;
        Ok(blocks)
    }

    fn uastc(&self, blocks: &[u8]) -> Result<Vec<u8>, String> {
        if blocks.len() != self.block_bytes() {
            let (found, wanted) = (blocks.len(), self.block_bytes());
            return Err(format!("UASTC blocks must have {wanted} bytes, got {found}"));
        }
        self.transcoded(&Codebooks::default(), &[blocks])
    }

    fn etc1s(&self) -> Result<Vec<u8>, String> {
        let global = self.global;
        let counts = word(global, 0)?;
        // Endpoints, selectors and tables are contiguous.
        let mut at = 20 + (PICTURE * self.pictures) as u64;
        let mut parts = [&[][..]; 3];
        for (index, codebook) in parts.iter_mut().enumerate() {
            let length = word(global, 4 + 4 * index)?.into();
            *codebook = part(global, [at, length])?;
            at += length;
        }
        // Colour, then alpha: each a slice of the level's bytes.
        let [color, color_len, alpha, alpha_len] =
            [word(global, 24)?, word(global, 28)?, word(global, 32)?, word(global, 36)?]
                .map(u64::from);
        let mut slices = vec![part(self.level, [color, color_len])?];
        if alpha_len > 0 {
            slices.push(part(self.level, [alpha, alpha_len])?);
        }
        self.transcoded(&Codebooks { counts, parts }, &slices)
    }

    fn transcoded(&self, codebooks: &Codebooks, slices: &[&[u8]]) -> Result<Vec<u8>, String> {
        let file = self.as_basis(codebooks, slices)?;
        let name = if self.model == ETC1S { "ETC1S" } else { "UASTC" };
        let bad = || format!("{name} texels cannot be decoded");
        let mut transcoder = Transcoder::new();
        transcoder.prepare_transcoding(&file).map_err(|()| bad())?;
        let format = TranscoderTextureFormat::RGBA32;
        let first = TranscodeParameters::default();
        transcoder.transcode_image_level(&file, format, first).map_err(|_| bad())
    }

    /// The largest image as a single-image `.basis` file.
    ///
    /// Layout: header, slice descriptions (colour, then alpha if present), endpoints,
    /// selectors, tables, slices. All but the header and the descriptions are copied unchanged
    /// from the KTX2 file. Entries of `header` and `described` are pairs of value and width in
    /// bytes.
    fn as_basis(&self, codebooks: &Codebooks, slices: &[&[u8]]) -> Result<Vec<u8>, String> {
        const HEADER: usize = 77;
        const SLICE: usize = 23;
        const HAS_ALPHA: u32 = 4;
        let parts: Vec<_> = codebooks.parts.iter().chain(slices).copied().collect();
        if parts[..2].iter().any(|part| part.len() >= 1 << 24) {
            return Err("endpoints and selectors must be smaller than 16 MiB each".to_owned());
        }
        let mut offset = HEADER + SLICE * slices.len();
        let mut offsets = Vec::new();
        for part in &parts {
            offsets.push(offset as u32);
            offset += part.len();
        }
        if u32::try_from(offset).is_err() {
            return Err("texels must be smaller than 4 GiB".to_owned());
        }
        let size = |part: usize| parts[part].len() as u32;
        let (format, flags) = match self.model {
            ETC1S => (0, 1 | if slices.len() > 1 { HAS_ALPHA } else { 0 }),
            _ => (1, HAS_ALPHA),
        };
        let header = [
            // Signature "sB", version 0x13, header length, and zero checksums, which are not
            // verified.
            [(0x4273, 2), (0x13, 2), (HEADER as u32, 2), (0, 2)],
            [((offset - HEADER) as u32, 4), (0, 2), (slices.len() as u32, 3), (1, 3)],
            // Format, flags, and texture type 2D, not video.
            [(format, 1), (flags, 2), (0, 1), (0, 3)],
            [(0, 4), (0, 4), (0, 4), (codebooks.counts & 0xffff, 2)],
            [(offsets[0], 4), (size(0), 3), (codebooks.counts >> 16, 2), (offsets[1], 4)],
            [(size(1), 3), (offsets[2], 4), (size(2), 4), (HEADER as u32, 4)],
            [(0, 4), (0, 4), (0, 0), (0, 0)],
        ];
        let [width, height] = [self.size.width, self.size.height];
        let [columns, rows] = self.blocks();
        let described = slices.iter().enumerate().flat_map(|(index, slice)| {
            // Image and level 0; whether it is alpha.
            [
                [(0, 3), (0, 1), (index as u32, 1), (width, 2)],
                [(height, 2), (columns, 2), (rows, 2), (offsets[3 + index], 4)],
                [(slice.len() as u32, 4), (0, 2), (0, 0), (0, 0)],
            ]
        });
        let mut out = Vec::with_capacity(offset);
        for (value, bytes) in header.into_iter().chain(described).flatten() {
            out.extend(&u32::to_le_bytes(value)[..bytes]);
        }
        parts.iter().for_each(|part| out.extend(*part));
        Ok(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A two-coloured image, written by our own encoder.
    fn file() -> Vec<u8> {
        let texels = (0..16 * 8_u32)
            .flat_map(|k| if k % 16 < 8 { [200, 40, 20, 255] } else { [10, 90, 160, 255] });
        let texels = Texels::U8(texels.collect());
        let texture =
            Texture::new(Size::new(16, 8), Channels::Rgba, Encoding::Srgb, texels).unwrap();
        crate::glb::encode_ktx2(texture, false).unwrap().0
    }

    #[test]
    fn written_uastc_is_read() {
        let file = file();
        assert_eq!(size(&file), Ok(Size::new(16, 8)));
        let texture = decode(&file).unwrap();
        for (x, wanted) in [(2, [200, 40, 20, 255]), (12, [10, 90, 160, 255])] {
            for (k, wanted) in wanted.into_iter().enumerate() {
                let found = (texture.get(x, 3, k) * 255.0).round() as i32;
                // Blocks of one colour are kept within their precision of 5 to 8 bits.
                assert!((found - wanted).abs() <= 4, "{x} {k}: {found} {wanted}");
            }
        }
    }

    #[test]
    fn sides_need_not_be_multiples_of_4() {
        let mut cut = file();
        let whole = decode(&cut).unwrap();
        [cut[20], cut[24]] = [15, 6];
        let cut = decode(&cut).unwrap();
        assert_eq!(cut.size(), Size::new(15, 6));
        for (x, y) in (0..6).flat_map(|y| (0..15).map(move |x| (x, y))) {
            assert!((0..4).all(|k| cut.get(x, y, k) == whole.get(x, y, k)), "{x} {y}");
        }
    }

    #[test]
    fn damaged_files_never_panic() {
        let file = file();
        for length in 0..file.len() {
            // The smaller levels, which come first, are not read.
            let _ = decode(&file[..length]);
        }
        assert!(decode(&file[..60]).unwrap_err().contains("truncated"));
        for at in 0..file.len() {
            for flip in [1, 0x80, 0xff] {
                let mut bytes = file.clone();
                bytes[at] ^= flip;
                if size(&bytes).is_ok_and(|size| size.texels() < 1 << 20) {
                    let _ = decode(&bytes);
                }
            }
        }
    }
}
