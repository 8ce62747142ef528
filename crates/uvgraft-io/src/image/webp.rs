//! WebP, through the `image-webp` crate.

use std::io::{BufRead, Cursor, Read, Seek, Write};

use image_webp::{ColorType, DecodingError, EncodingError, WebPDecoder, WebPEncoder};
use uvgraft::texture::{Channels, Depth, Texels, Texture};

use super::convert::Conversion;
use super::exif::FocalLength;
use super::header::{MAX_ICC_BYTES, StoredHeader, check_size};
use super::orientation::Orientation;
use super::{Decoded, EncodeError, Format, ImageError, Loss, TextureSpec};

const FORMAT: Format = Format::WebP;

/// Sides have 14 bits. The lossless bitstream stores them minus 1 and could represent one texel
/// more, but readers, including the crate's own, interpret that as 0.
pub(super) const MAX_SIDE: u32 = (1 << 14) - 1;

pub(super) fn header(reader: &mut (impl BufRead + Seek)) -> Result<StoredHeader, ImageError> {
    Ok(open(reader)?.1)
}

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
    Ok((decoder, StoredHeader { size, channels, depth: Depth::U8, orientation, focal }))
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

pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, ImageError> {
    if let Some(length) = bytes.get(4..).and_then(|rest| rest.first_chunk())
        && (bytes.len() as u64) < u64::from(u32::from_le_bytes(*length)) + 8
    {
        return Err(ImageError::Truncated { format: FORMAT });
    }
    let (mut decoder, header) = open(Cursor::new(bytes))?;
    let mut values = vec![0; header.values()];
    if decoder.output_buffer_size() != Some(values.len()) {
        return Err(ImageError::damaged(FORMAT, "size and channels do not match"));
    }
    decoder.read_image(&mut values).map_err(from_webp)?;
    let icc = decoder.icc_profile().map_err(from_webp)?;
    Ok(Decoded { header, texels: Texels::U8(values), icc })
}

fn from_webp(error: DecodingError) -> ImageError {
    match error {
        DecodingError::IoError(error) => ImageError::from_io(FORMAT, &error),
        error => ImageError::damaged(FORMAT, error),
    }
}

/// Encodes a texture that was checked, and returns the losses.
pub(super) fn encode(
    texture: &Texture,
    mut icc: Option<&[u8]>,
    out: &mut impl Write,
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
