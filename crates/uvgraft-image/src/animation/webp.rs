//! Animated WebP of lossless frames.
//!
//! # Source
//! Google, "WebP Container Specification": `VP8X`, `ANIM`, and an `ANMF` chunk for each frame,
//! which stores only the part that changes.

use std::io::{Cursor, Write};

use uvgraft::{Channels, Encoding, Size, Texels, Texture, threads};

use super::{Animation, AnimationError, bytes_of, changed_region, durations};
use crate::webp::riff_chunk;
use crate::{Format, Image, WriteOptions};

pub(super) const ANIMATION: Animation = Animation {
    name: "WebP",
    extension: "webp",
    max_fps: None,
    has_hard_edges: false,
    write: |frames, fps, out| write_webp(frames, fps, out),
};

/// Writes frames as a lossless animated WebP that loops forever.
///
/// - `fps`: frames per second, above 0. Times are rounded to milliseconds.
///
/// # Errors
/// [`AnimationError`] for frames of different formats or larger than 16,383 pixels a side, and for
/// errors of the encoder or of `out`.
pub fn write_webp(frames: &[Texture], fps: f32, mut out: impl Write) -> Result<(), AnimationError> {
    const MAX_SIDE: u32 = 16_383;
    let (bytes, alpha) = bytes_of(frames)?;
    let size = frames[0].size();
    if size.width.max(size.height) > MAX_SIDE {
        return Err(AnimationError::TooLarge { format: "WebP", found: size, max: MAX_SIDE });
    }
    let width = size.width as usize;
    let encoded = threads::map_indices(frames.len(), |index| {
        let before = index.checked_sub(1).map(|before| bytes[before]).filter(|_| !alpha);
        match before {
            Some(before) => ChangedRegion::changed(bytes[index], before, width),
            None => ChangedRegion::whole(&frames[index]),
        }
    });
    let encoded: Vec<ChangedRegion> = encoded.into_iter().collect::<Result<_, AnimationError>>()?;
    let mut body = b"WEBP".to_vec();
    // Animation and alpha, which partial frames have where nothing changes.
    const FLAGS: u8 = 0b1_0010;
    let sides = [size.width, size.height].map(|side| three_bytes(side - 1)).concat();
    riff_chunk(&mut body, *b"VP8X", &[&[FLAGS, 0, 0, 0], &sides[..]].concat());
    // A transparent background, and an unlimited loop.
    riff_chunk(&mut body, *b"ANIM", &[0; 6]);
    for (part, milliseconds) in encoded.iter().zip(durations(frames.len(), fps, 1000.0)) {
        // The frame stays; it either replaces what was there, or is blended over it.
        let flags = if part.replaces { 0b10 } else { 0 };
        let [left, top] = part.corner.map(|at| three_bytes(at / 2));
        let [width, height] = part.size.map(|side| three_bytes(side - 1));
        let time = three_bytes(milliseconds.min((1 << 24) - 1));
        let mut frame = [left, top, width, height, time].concat();
        frame.push(flags);
        riff_chunk(&mut frame, *b"VP8L", &part.bits);
        riff_chunk(&mut body, *b"ANMF", &frame);
    }
    let length = u32::try_from(body.len())
        .map_err(|_| AnimationError::Encode("WebP holds at most 4 GiB".to_owned()))?;
    out.write_all(b"RIFF")?;
    out.write_all(&length.to_le_bytes())?;
    out.write_all(&body)?;
    Ok(())
}

/// The stored part of a frame.
struct ChangedRegion {
    /// Left and top, both even.
    corner: [u32; 2],
    size: [u32; 2],
    replaces: bool,
    bits: Vec<u8>,
}

impl ChangedRegion {
    fn whole(frame: &Texture) -> Result<Self, AnimationError> {
        let size = [frame.size().width, frame.size().height];
        Ok(Self { corner: [0; 2], size, replaces: true, bits: still(frame)? })
    }

    /// The pixels of an RGB frame that differ from the previous one.
    fn changed(now: &[u8], before: &[u8], width: usize) -> Result<Self, AnimationError> {
        let (now, before) = (now.as_chunks::<3>().0, before.as_chunks::<3>().0);
        let differs = |at: usize| now[at] != before[at];
        let [columns, rows] = changed_region(width, now.len() / width, differs);
        let (left, top) = (columns.start / 2 * 2, rows.start / 2 * 2);
        let (right, bottom) = (columns.end, rows.end);
        let mut pixels = Vec::with_capacity((right - left) * (bottom - top) * 4);
        for y in top..bottom {
            for at in y * width + left..y * width + right {
                let [r, g, b] = now[at];
                pixels.extend(if differs(at) { [r, g, b, 255] } else { [0; 4] });
            }
        }
        let size = Size::new((right - left) as u32, (bottom - top) as u32);
        let texels = Texels::U8(pixels);
        let part = Texture::new(size, Channels::Rgba, Encoding::Srgb, texels)
            .map_err(|error| AnimationError::Encode(error.to_string()))?;
        let corner = [left as u32, top as u32];
        Ok(Self { corner, size: [size.width, size.height], replaces: false, bits: still(&part)? })
    }
}

/// The lossless bitstream of an image.
fn still(frame: &Texture) -> Result<Vec<u8>, AnimationError> {
    let mut file = Cursor::new(Vec::new());
    let image = Image::from(frame.clone());
    // 8-bit RGB and RGBA lose nothing.
    let _ = crate::encode(&image, Format::WEBP, &WriteOptions::default(), &mut file)
        .map_err(|error| AnimationError::Encode(error.to_string()))?;
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
    Err(AnimationError::Encode("WebP without a lossless bitstream".to_owned()))
}

fn three_bytes(value: u32) -> [u8; 3] {
    let [a, b, c, _] = value.to_le_bytes();
    [a, b, c]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_where_readers_look_for_them() {
        let frame = |value: u8| {
            let texels = Texels::U8(vec![value; 5 * 3 * 4]);
            Texture::new(Size::new(5, 3), Channels::Rgba, Encoding::Srgb, texels).unwrap()
        };
        let mut bytes = Vec::new();
        write_webp(&[frame(200), frame(90)], 4.0, &mut bytes).unwrap();
        // The image reader returns the first frame of an animation.
        let first = crate::decode(&bytes).unwrap().texture;
        assert_eq!(first, frame(200));
        assert_eq!(bytes.len() as u32 - 8, u32::from_le_bytes(bytes[4..8].try_into().unwrap()));
        let anmf: Vec<usize> =
            (0..bytes.len() - 4).filter(|&at| bytes[at..].starts_with(b"ANMF")).collect();
        assert_eq!(anmf.len(), 2);
        // 250 ms, after position and size.
        assert_eq!(bytes[anmf[1] + 8 + 6..][..9], [4, 0, 0, 2, 0, 0, 250, 0, 0]);
    }

    #[test]
    fn only_changes_are_stored() {
        let frame = |at: [usize; 2]| {
            let mut pixels = vec![9; 8 * 6 * 3];
            pixels[(at[1] * 8 + at[0]) * 3] = 77;
            let texels = Texels::U8(pixels);
            Texture::new(Size::new(8, 6), Channels::Rgb, Encoding::Srgb, texels).unwrap()
        };
        let (a, b) = (frame([3, 3]), frame([5, 4]));
        let frames = [a.clone(), b, a];
        let (bytes, _) = bytes_of(&frames).unwrap();
        let part = ChangedRegion::changed(bytes[1], bytes[0], 8).unwrap();
        assert_eq!((part.corner, part.size, part.replaces), ([2, 2], [4, 3], false));
        let none = ChangedRegion::changed(bytes[2], bytes[0], 8).unwrap();
        assert_eq!((none.corner, none.size), ([0, 0], [1, 1]));
        let mut file = Vec::new();
        write_webp(&frames, 10.0, &mut file).unwrap();
        assert_eq!(crate::decode(&file).unwrap().texture.get(3, 3, 0), 77.0 / 255.0);
    }
}
