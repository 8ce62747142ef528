//! Animated WebP of lossless frames.
//!
//! # Source
//! Google, "WebP Container Specification": `VP8X`, `ANIM` and one `ANMF` for each frame.

use std::io::{Cursor, Write};

use rayon::prelude::*;
use uvgraft::Texture;
use uvgraft_io::image::{self, Format, Image, WriteOptions};

use super::{FilmError, bytes_of, durations};

/// Writes frames as an animated WebP that starts again at its end, without any loss.
///
/// - `fps`: frames a second, above 0; times are rounded to milliseconds.
///
/// # Errors
/// [`FilmError`] for frames that do not belong together or are larger than 16,383 pixels a side, and
/// for what encoding and writing give.
pub fn write_webp(frames: &[Texture], fps: f32, mut out: impl Write) -> Result<(), FilmError> {
    const MAX_SIDE: u32 = 16_383;
    let (_, alpha) = bytes_of(frames)?;
    let size = frames[0].size();
    if size.width.max(size.height) > MAX_SIDE {
        return Err(FilmError::TooLarge { format: "WebP", found: size, max: MAX_SIDE });
    }
    let encoded: Vec<Vec<u8>> = frames.par_iter().map(still).collect::<Result<_, FilmError>>()?;
    let mut body = b"WEBP".to_vec();
    // Animation, and opacity if there is any.
    let flags = 0b10 | u8::from(alpha) << 4;
    let sides = [size.width - 1, size.height - 1].map(three_bytes).concat();
    chunk(&mut body, *b"VP8X", &[&[flags, 0, 0, 0], &sides[..]].concat());
    // A clear background, and no end.
    chunk(&mut body, *b"ANIM", &[0; 6]);
    for (frame, milliseconds) in encoded.iter().zip(durations(frames.len(), fps, 1000.0)) {
        // At the top left corner; it replaces what was there, and stays.
        const REPLACE: u8 = 0b10;
        let mut part = [0; 6].to_vec();
        part.extend(&sides);
        part.extend(three_bytes(milliseconds.min((1 << 24) - 1)));
        part.push(REPLACE);
        chunk(&mut part, *b"VP8L", frame);
        chunk(&mut body, *b"ANMF", &part);
    }
    let length = u32::try_from(body.len())
        .map_err(|_| FilmError::Encode("WebP holds at most 4 GiB".to_owned()))?;
    out.write_all(b"RIFF")?;
    out.write_all(&length.to_le_bytes())?;
    out.write_all(&body)?;
    Ok(())
}

/// A frame's lossless bitstream.
fn still(frame: &Texture) -> Result<Vec<u8>, FilmError> {
    let mut file = Cursor::new(Vec::new());
    let image = Image::from(frame.clone());
    // Nothing is lost of 8-bit RGB and RGBA.
    let _ = image::encode(&image, Format::WebP, &WriteOptions::default(), &mut file)
        .map_err(|error| FilmError::Encode(error.to_string()))?;
    let file = file.into_inner();
    let mut at = 12;
    while let Some(header) = file.get(at..at + 8) {
        let length = u32::from_le_bytes([header[4], header[5], header[6], header[7]]) as usize;
        if &header[..4] == b"VP8L"
            && let Some(data) = file.get(at + 8..at + 8 + length)
        {
            return Ok(data.to_vec());
        }
        at += 8 + length + length % 2;
    }
    Err(FilmError::Encode("WebP without a lossless bitstream".to_owned()))
}

fn three_bytes(value: u32) -> [u8; 3] {
    let [a, b, c, _] = value.to_le_bytes();
    [a, b, c]
}

fn chunk(out: &mut Vec<u8>, name: [u8; 4], data: &[u8]) {
    out.extend(name);
    out.extend((data.len() as u32).to_le_bytes());
    out.extend(data);
    if data.len() % 2 == 1 {
        out.push(0);
    }
}

#[cfg(test)]
mod tests {
    use uvgraft::{Channels, Encoding, Size, Texels};

    use super::*;

    #[test]
    fn frames_are_where_readers_look_for_them() {
        let frame = |value: u8| {
            let texels = Texels::U8(vec![value; 5 * 3 * 4]);
            Texture::new(Size::new(5, 3), Channels::Rgba, Encoding::Srgb, texels).unwrap()
        };
        let mut bytes = Vec::new();
        write_webp(&[frame(200), frame(90)], 4.0, &mut bytes).unwrap();
        // The reader of images takes the first frame of an animation.
        let first = image::decode(&bytes).unwrap().texture;
        assert_eq!(first, frame(200));
        assert_eq!(bytes.len() as u32 - 8, u32::from_le_bytes(bytes[4..8].try_into().unwrap()));
        let anmf: Vec<usize> =
            (0..bytes.len() - 4).filter(|&at| bytes[at..].starts_with(b"ANMF")).collect();
        assert_eq!(anmf.len(), 2);
        // 250 ms, after the place and the size.
        assert_eq!(bytes[anmf[1] + 8 + 6..][..9], [4, 0, 0, 2, 0, 0, 250, 0, 0]);
    }
}
