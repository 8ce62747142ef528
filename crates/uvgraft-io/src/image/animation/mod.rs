//! Moving pictures: frames of one size, each shown for as long, over and over.

mod gif;
mod palette;
mod webp;

use uvgraft::{Texels, Texture};

pub use self::gif::write_gif;
pub use self::webp::write_webp;

/// Why frames were not written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FilmError {
    /// There are no frames, or they differ in size, or they do not have 8 bits of RGB or RGBA.
    #[error("there must be at least one frame, and all must be 8-bit RGB or RGBA of the same size")]
    Frames,
    /// The format holds no frames of that size.
    #[error("{format} supports at most {max} pixels a side, got {found}")]
    TooLarge {
        /// The format.
        format: &'static str,
        /// Size of the frames.
        found: uvgraft::Size,
        /// The longest side.
        max: u32,
    },
    /// Encoding a frame failed.
    #[error("cannot encode a frame: {0}")]
    Encode(String),
    /// Writing failed.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}

/// When each frame ends, in units of which there are `per_second`: rounded so that errors never add
/// up, and no frame has none.
///
/// - `fps`: frames a second; above 0.
fn durations(frames: usize, fps: f32, per_second: f32) -> impl Iterator<Item = u32> {
    let ends = move |frame: usize| (frame as f32 * per_second / fps).round() as u32;
    (0..frames).map(move |frame| (ends(frame + 1) - ends(frame)).max(1))
}

/// The bytes of frames that can be written together, and whether they have opacity.
fn bytes_of(frames: &[Texture]) -> Result<(Vec<&[u8]>, bool), FilmError> {
    let first = frames.first().ok_or(FilmError::Frames)?;
    let alpha = first.channels().has_alpha();
    let mut all = Vec::with_capacity(frames.len());
    for frame in frames {
        match frame.texels() {
            Texels::U8(bytes)
                if frame.size() == first.size()
                    && frame.channels() == first.channels()
                    && frame.channels().has_color() =>
            {
                all.push(bytes.as_slice());
            }
            _ => return Err(FilmError::Frames),
        }
    }
    Ok((all, alpha))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_kept_although_units_are_coarse() {
        let hundredths: Vec<u32> = durations(30, 30.0, 100.0).collect();
        assert_eq!(hundredths.iter().sum::<u32>(), 100);
        assert_eq!(hundredths[..4], [3, 4, 3, 3]);
        assert_eq!(durations(2, 1000.0, 100.0).collect::<Vec<_>>(), [1, 1]);
    }
}
