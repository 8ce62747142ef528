//! WebP, through the `image-webp` crate.

use std::io::{BufRead, Cursor, Read, Seek};

use image_webp::{ColorType, DecodingError, EncodingError, WebPDecoder, WebPEncoder};
use uvgraft::color::Encoding;
use uvgraft::texture::{Channels, Depth, Size, Texels, Texture};

use super::codec::{Codec, Decode, Decoded, Encode, Sink};
use super::convert::Conversion;
use super::exif::FocalLength;
use super::header::{MAX_ICC_BYTES, StoredHeader, check_size};
use super::orientation::Orientation;
use super::{EncodeError, Format, ImageError, Loss, TextureSpec};

impl Format {
    /// 8 bits, alpha, ICC profile; written lossless. At most 16,383 texels a side.
    pub const WEBP: Self = Self::new(&CODEC);
}

const FORMAT: Format = Format::WEBP;

static CODEC: Codec = Codec {
    name: "WebP",
    extensions: &["webp"],
    media_type: "image/webp",
    is_start: |bytes| {
        matches!(bytes, [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..])
    },
    depths: &[(Depth::U8, Encoding::Srgb)],
    has_alpha: true,
    is_premultiplied: false,
    is_lossy: false,
    compresses: false,
    max_side: MAX_SIDE,
    header: |reader| Ok(open(reader)?.1),
    decode: Decode::Whole(|bytes, _| decode(bytes)),
    encode: Encode::Whole(|texture, icc, _, out| encode(texture, icc, out)),
    segments: None,
    without_metadata: Some(stripped),
};

/// Sides have 14 bits. The lossless bitstream stores them minus 1 and could represent one texel
/// more, but readers, including the crate's own, interpret that as 0.
const MAX_SIDE: u32 = (1 << 14) - 1;

fn open<R: BufRead + Seek>(mut reader: R) -> Result<(WebPDecoder<R>, StoredHeader), ImageError> {
    check_canvas(&mut reader)?;
    let mut decoder = WebPDecoder::new(reader).map_err(from_webp)?;
    let (width, height) = decoder.dimensions();
    let channels = if decoder.has_alpha() { Channels::Rgba } else { Channels::Rgb };
    let size = check_size(FORMAT, (width.into(), height.into()), channels, Depth::U8)?;
    // Of the chunks read as a whole, only the profile is large.
    decoder.set_memory_limit(4 * MAX_ICC_BYTES);
    let exif = decoder.exif_metadata().map_err(from_webp)?.unwrap_or_default();
    let xmp = decoder.xmp_metadata().map_err(from_webp)?.unwrap_or_default();
    let orientation = Orientation::from_blocks(&exif, &xmp);
    let focal = FocalLength::from_exif(&exif);
    let scratch_bytes = scratch_bytes(&mut decoder, size.texels() as u64);
    let depth = Depth::U8;
    let header = StoredHeader { size, channels, depth, orientation, focal, scratch_bytes };
    Ok((decoder, header))
}

/// What the crate allocates beside the texels, by reading its version 0.2.4.
fn scratch_bytes<R: BufRead + Seek>(decoder: &mut WebPDecoder<R>, texels: u64) -> u64 {
    // Transforms and codes for blocks of 4×4 texels, four of them at most, with four bytes each.
    let transforms = texels;
    let [lossless, lossy, alpha] =
        [4 * texels + transforms, 3 * texels / 2, 5 * texels + transforms];
    if decoder.is_animated() {
        // The canvas and the frame, which may be of either kind.
        8 * texels + lossless.max(lossy + alpha)
    } else if !decoder.is_lossy() {
        if decoder.has_alpha() { transforms } else { lossless }
    } else {
        lossy + if decoder.has_alpha() { alpha } else { 0 }
    }
}

/// Checks the size in the extended header, because the crate rejects the largest without naming it.
fn check_canvas(reader: &mut (impl BufRead + Seek)) -> Result<(), ImageError> {
    let io = |error| ImageError::from_io(FORMAT, &error);
    let mut start = Vec::new();
    reader.by_ref().take(30).read_to_end(&mut start).map_err(io)?;
    reader.rewind().map_err(io)?;
    if let [.., w0, w1, w2, h0, h1, h2] = start[..]
        && start.len() == 30
        && start[12..].starts_with(b"VP8X")
    {
        // 24 bits, stored minus 1.
        let side = |bytes: [u8; 3]| {
            let [b0, b1, b2] = bytes;
            u64::from(u32::from_le_bytes([b0, b1, b2, 0])) + 1
        };
        let sides = (side([w0, w1, w2]), side([h0, h1, h2]));
        check_size(FORMAT, sides, Channels::Rgb, Depth::U8)?;
    }
    Ok(())
}

/// Checks the sizes of lossy frames, which the crate compares with the canvas only after it has decoded them.
///
/// - `rest`: chunks.
/// - `is_frame`: whether they are those of a frame of an animation.
fn check_frames(mut rest: &[u8], canvas: Size, is_frame: bool) -> Result<(), ImageError> {
    while let Some((start, content)) = rest.split_first_chunk::<8>() {
        let [.., l0, l1, l2, l3] = *start;
        let length = u32::from_le_bytes([l0, l1, l2, l3]) as usize;
        let content = &content[..length.min(content.len())];
        match &start[..4] {
            b"VP8 " => {
                let sides = content.get(6..).and_then(<[u8]>::first_chunk::<4>);
                let sides = sides.map(|&[w0, w1, h0, h1]| {
                    // 14 bits, and two for a scale that nobody applies.
                    [[w0, w1], [h0, h1]].map(|side| u32::from(u16::from_le_bytes(side) & 0x3fff))
                });
                if let Some([width, height]) = sides
                    && (width > canvas.width || height > canvas.height)
                {
                    let found = format_args!("a frame of {width}×{height} texels, of {canvas}");
                    return Err(ImageError::damaged(FORMAT, found));
                }
            }
            b"ANMF" if !is_frame => {
                check_frames(content.get(16..).unwrap_or_default(), canvas, true)?;
            }
            _ => {}
        }
        rest = rest.get(8..).and_then(|rest| rest.get(length..)).unwrap_or_default();
        rest = rest.get(length % 2..).unwrap_or_default();
    }
    Ok(())
}

fn decode(bytes: &[u8]) -> Result<Decoded, ImageError> {
    if let Some(length) = bytes.get(4..).and_then(|rest| rest.first_chunk())
        && (bytes.len() as u64) < u64::from(u32::from_le_bytes(*length)) + 8
    {
        return Err(ImageError::Truncated { format: FORMAT });
    }
    let (mut decoder, header) = open(Cursor::new(bytes))?;
    check_frames(bytes.get(12..).unwrap_or_default(), header.size, false)?;
    let mut values = vec![0; header.values()];
    if decoder.output_buffer_size() != Some(values.len()) {
        return Err(ImageError::damaged(FORMAT, "size and channels do not match"));
    }
    decoder.read_image(&mut values).map_err(from_webp)?;
    let icc = decoder.icc_profile().map_err(from_webp)?;
    Ok(Decoded { header, texels: Texels::U8(values), icc })
}

/// See [`without_metadata`](super::without_metadata).
///
/// - `exif`: a block to write instead of the file's.
fn stripped(bytes: &[u8], exif: Option<&[u8]>) -> Option<Vec<u8>> {
    /// The bits of the extended header that say that there is EXIF, and XMP.
    const HAS_EXIF: u8 = 0x08;
    const HAS_XMP: u8 = 0x04;
    let length = u32::from_le_bytes(*bytes.get(4..)?.first_chunk()?) as usize;
    let mut rest = bytes.get(12..length.checked_add(8)?)?;
    let mut out = bytes[..12].to_vec();
    while !rest.is_empty() {
        let (header, content) = rest.split_at_checked(8)?;
        let length = u32::from_le_bytes(*header[4..].first_chunk()?) as usize;
        let content = content.get(..length)?;
        let start = out.len();
        if matches!(
            &header[..4],
            b"VP8X" | b"VP8 " | b"VP8L" | b"ALPH" | b"ANIM" | b"ANMF" | b"ICCP"
        ) {
            riff_chunk(&mut out, *header.first_chunk()?, content);
        }
        if header.starts_with(b"VP8X") {
            let flags = out.get_mut(start + 8)?;
            *flags &= !(HAS_EXIF | HAS_XMP);
            *flags |= exif.map_or(0, |_| HAS_EXIF);
        }
        // Chunks have an even number of bytes. The last one's padding may be missing.
        rest = rest.get(8 + length + length % 2..).unwrap_or_default();
    }
    if let Some(exif) = exif {
        // Only in files with an extended header, since no others had any.
        riff_chunk(&mut out, *b"EXIF", exif);
    }
    let length = u32::try_from(out.len() - 8).ok()?;
    out[4..8].copy_from_slice(&length.to_le_bytes());
    Some(out)
}

/// Appends a chunk of a RIFF file.
pub(super) fn riff_chunk(out: &mut Vec<u8>, name: [u8; 4], data: &[u8]) {
    out.extend(name);
    out.extend((data.len() as u32).to_le_bytes());
    out.extend(data);
    if data.len() % 2 == 1 {
        out.push(0);
    }
}

fn from_webp(error: DecodingError) -> ImageError {
    match error {
        DecodingError::IoError(error) => ImageError::from_io(FORMAT, &error),
        error => ImageError::damaged(FORMAT, error),
    }
}

/// Encodes a texture that was checked, and returns the losses.
fn encode(
    texture: &Texture,
    mut icc: Option<&[u8]>,
    out: &mut dyn Sink,
) -> Result<Vec<Loss>, EncodeError> {
    let mut conversion = Conversion::<u8>::new(&TextureSpec::from(texture), FORMAT, &mut icc);
    let values = conversion.apply(texture.texels(), 0..texture.texels().len());
    let color = match texture.channels() {
        Channels::Grey => ColorType::L8,
        Channels::GreyAlpha => ColorType::La8,
        Channels::Rgb => ColorType::Rgb8,
        Channels::Rgba => ColorType::Rgba8,
    };
    let mut encoder = WebPEncoder::new(out);
    if let Some(icc) = icc {
        encoder.set_icc_profile(icc.to_vec());
    }
    let size = texture.size();
    encoder.encode(&values, size.width, size.height, color).map_err(|error| match error {
        EncodingError::IoError(error) => EncodeError::Io(error),
        error => EncodeError::encoder(FORMAT, error),
    })?;
    Ok(conversion.losses())
}
