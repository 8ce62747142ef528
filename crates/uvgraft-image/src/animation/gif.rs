//! GIF: one palette for all frames, with ordered dithering, so that still areas neither flicker nor
//! need to be stored again.
//!
//! # Source
//! CompuServe, "Graphics Interchange Format", version 89a. Bayer, "An Optimum Method for Two-Level
//! Rendition of Continuous-Tone Pictures", 1973, for the dither pattern.

use std::io::Write;

use gif::{DisposalMethod, Encoder, EncodingError, Frame, Repeat};
use uvgraft::{Texture, threads};

use super::palette::Palette;
use super::{Animation, AnimationError, bytes_of, changed_region, durations};

/// The last index: transparent, so that the previous frame shows.
const CLEAR: u8 = 255;

/// Maximum number of pixels sampled for the palette.
const SAMPLES: usize = 1 << 21;

pub(super) const ANIMATION: Animation = Animation {
    name: "GIF",
    extension: "gif",
    // Delays are hundredths of a second, and browsers take a single one for ten.
    max_fps: Some(50.0),
    has_hard_edges: true,
    write: |frames, fps, out| write_gif(frames, fps, out),
};

/// Writes frames as a GIF that loops forever.
///
/// GIF has no partial transparency: pixels with an alpha of at least one half are opaque.
///
/// - `fps`: frames per second, above 0. Times are rounded to hundredths of a second, at least two
///   per frame, because viewers treat shorter times as errors.
///
/// # Errors
/// [`AnimationError`] for frames of different formats or larger than 65,535 pixels a side, and for
/// errors of `out`.
pub fn write_gif(frames: &[Texture], fps: f32, out: impl Write) -> Result<(), AnimationError> {
    const MAX_SIDE: u32 = 65_535;
    let (bytes, alpha) = bytes_of(frames)?;
    let size = frames[0].size();
    if size.width.max(size.height) > MAX_SIDE {
        return Err(AnimationError::TooLarge { format: "GIF", found: size, max: MAX_SIDE });
    }
    let channels = if alpha { 4 } else { 3 };
    let total = size.texels() * frames.len();
    // An odd step is coprime with most common widths.
    let step = (total / SAMPLES).max(1) | 1;
    let pixels = bytes.iter().flat_map(|bytes| bytes.chunks_exact(channels)).step_by(step);
    let opaque = pixels.filter(|pixel| !alpha || pixel[3] >= 128);
    let palette = Palette::new(opaque.map(|pixel| [pixel[0], pixel[1], pixel[2]]));
    let indexed = threads::map_indices(frames.len(), |frame| {
        indices(bytes[frame], channels, size.width as usize, &palette)
    });

    let (width, height) = (size.width as u16, size.height as u16);
    let mut encoder =
        Encoder::new(out, width, height, &palette.colors().concat()).map_err(from_gif)?;
    encoder.set_repeat(Repeat::Infinite).map_err(from_gif)?;
    let delays = durations(frames.len(), fps.min(50.0), 100.0);
    for (index, delay) in delays.enumerate() {
        let before = index.checked_sub(1).map(|before| &indexed[before]).filter(|_| !alpha);
        let mut frame = changed(&indexed[index], before.map(Vec::as_slice), size.width as usize);
        frame.delay = delay.clamp(2, 65_535) as u16;
        // Where pixels can become transparent again, each frame is stored as a whole.
        frame.dispose = if alpha { DisposalMethod::Background } else { DisposalMethod::Keep };
        encoder.write_frame(&frame).map_err(from_gif)?;
    }
    Ok(())
}

fn from_gif(error: EncodingError) -> AnimationError {
    match error {
        EncodingError::Io(error) => AnimationError::Io(error),
        error => AnimationError::Encode(error.to_string()),
    }
}

/// The palette indices of a frame, with ordered dithering.
fn indices(bytes: &[u8], channels: usize, width: usize, palette: &Palette) -> Vec<u8> {
    // The amplitude of the dithering: the palette's colours are a few levels apart where they are
    // dense.
    const SPREAD: i32 = 10;
    let mut indices = vec![CLEAR; bytes.len() / channels];
    let rows = indices.chunks_mut(width).zip(bytes.chunks(width * channels));
    threads::for_each(rows, |y, (indices, pixels)| {
        for (x, (index, pixel)) in indices.iter_mut().zip(pixels.chunks_exact(channels)).enumerate()
        {
            if channels == 4 && pixel[3] < 128 {
                continue;
            }
            // From -31 to 32, in units of 1/64.
            let threshold = bayer(x as u32, y as u32) as i32 - 31;
            let shift = threshold * SPREAD / 64;
            *index = palette.nearest([0, 1, 2].map(|k| i32::from(pixel[k]) + shift));
        }
    });
    indices
}

/// The rank of a cell in the 8 × 8 Bayer pattern: interleaved bits, the lowest first.
fn bayer(x: u32, y: u32) -> u32 {
    (0..3).fold(0, |sum, bit| {
        let (x, y) = (x >> bit & 1, y >> bit & 1);
        sum | (2 * (x ^ y) + y) << (4 - 2 * bit)
    })
}

/// The part of a frame that differs from the previous one, transparent where it does not.
fn changed(now: &[u8], before: Option<&[u8]>, width: usize) -> Frame<'static> {
    let differs = |at: usize| before.is_none_or(|before| before[at] != now[at]);
    let [columns, rows] = changed_region(width, now.len() / width, differs);
    let mut buffer = Vec::with_capacity(columns.len() * rows.len());
    for y in rows.clone() {
        buffer.extend(columns.clone().map(|x| {
            let at = y * width + x;
            if differs(at) { now[at] } else { CLEAR }
        }));
    }
    Frame {
        left: columns.start as u16,
        top: rows.start as u16,
        width: columns.len() as u16,
        height: rows.len() as u16,
        transparent: Some(CLEAR),
        buffer: buffer.into(),
        ..Frame::default()
    }
}

#[cfg(test)]
mod tests {
    use uvgraft::{Channels, Encoding, Size, Texels};

    use super::*;

    fn frame(channels: Channels, value: impl Fn(u32, u32) -> Vec<u8>) -> Texture {
        let size = Size::new(16, 8);
        let pixels = (0..128).flat_map(|k| value(k % 16, k / 16)).collect();
        Texture::new(size, channels, Encoding::Srgb, Texels::U8(pixels)).unwrap()
    }

    /// What a viewer shows of each frame, and for how long.
    fn shown(bytes: &[u8]) -> Vec<(Vec<u8>, u16)> {
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(bytes).unwrap();
        let width = usize::from(decoder.width());
        let mut screen = vec![0; width * usize::from(decoder.height()) * 4];
        let mut frames = Vec::new();
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            let rows = frame.buffer.chunks_exact(usize::from(frame.width) * 4);
            for (row, pixels) in rows.enumerate() {
                for (column, pixel) in pixels.chunks_exact(4).enumerate() {
                    let (x, y) = (column + usize::from(frame.left), row + usize::from(frame.top));
                    if pixel[3] > 0 {
                        screen[(y * width + x) * 4..][..4].copy_from_slice(pixel);
                    }
                }
            }
            frames.push((screen.clone(), frame.delay));
            if frame.dispose == DisposalMethod::Background {
                screen.fill(0);
            }
        }
        frames
    }

    #[test]
    fn frames_come_back_although_only_changes_are_stored() {
        let dot = |at: u32| {
            frame(Channels::Rgb, move |x, y| {
                if (x, y) == (at, 3) { vec![250, 20, 30] } else { vec![40, 40, 200] }
            })
        };
        let frames = [dot(2), dot(5), dot(5)];
        let mut bytes = Vec::new();
        write_gif(&frames, 12.5, &mut bytes).unwrap();
        let shown = shown(&bytes);
        assert_eq!(shown.len(), 3);
        for ((screen, delay), frame) in shown.iter().zip(&frames) {
            assert_eq!(*delay, 8);
            let Texels::U8(pixels) = frame.texels() else { panic!() };
            for (a, b) in screen.chunks_exact(4).zip(pixels.chunks_exact(3)) {
                assert_eq!(a[..3], *b);
            }
        }
    }

    #[test]
    fn what_is_clear_stays_clear_from_frame_to_frame() {
        let half = |from: u32| {
            frame(Channels::Rgba, move |x, _| {
                vec![200, 100, 50, if (from..from + 8).contains(&x) { 255 } else { 100 }]
            })
        };
        let mut bytes = Vec::new();
        write_gif(&[half(0), half(8)], 10.0, &mut bytes).unwrap();
        let shown = shown(&bytes);
        for (frame, from) in [(0, 0), (1, 8)] {
            for x in 0..16 {
                let opaque = shown[frame].0[x * 4 + 3] == 255;
                assert_eq!(opaque, (from..from + 8).contains(&x), "frame {frame}, {x}");
            }
        }
    }

    #[test]
    fn the_pattern_has_every_threshold_once() {
        let mut seen: Vec<u32> = (0..64).map(|k| bayer(k % 8, k / 8)).collect();
        assert_eq!((seen[0], bayer(1, 1), bayer(1, 0)), (0, 16, 32));
        seen.sort_unstable();
        assert_eq!(seen, (0..64).collect::<Vec<_>>());
    }

    #[test]
    fn frames_of_two_sizes_are_refused() {
        let small = frame(Channels::Rgb, |_, _| vec![0; 3]);
        let other = frame(Channels::Rgba, |_, _| vec![0; 4]);
        for frames in [&[][..], &[small, other]] {
            assert!(matches!(write_gif(frames, 10.0, Vec::new()), Err(AnimationError::Frames)));
        }
    }
}
