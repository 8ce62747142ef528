//! Animations: frames of one size, all shown for the same time, in a loop.

mod gif;
mod palette;
mod webp;

use std::io::Write;
use std::ops::Range;
use std::path::Path;

use uvgraft::{Texels, Texture};

pub use self::gif::write_gif;
pub use self::webp::write_webp;

/// A format of animations.
pub struct Animation {
    /// Its common name.
    pub name: &'static str,
    /// Its file extension, in lower case without the dot.
    pub extension: &'static str,
    /// The most frames per second that programs show; `None` for as many as they can.
    pub max_fps: Option<f32>,
    /// Whether pixels are either opaque or not there.
    pub has_hard_edges: bool,
    /// Writes frames that are shown at a rate above 0, in frames per second, in a loop.
    pub write: fn(&[Texture], f32, &mut dyn Write) -> Result<(), AnimationError>,
}

impl Animation {
    /// All formats, in the order of messages.
    pub const ALL: &'static [Self] = &[gif::ANIMATION, webp::ANIMATION];

    /// The format of a path, by its extension in any case.
    pub fn from_path(path: impl AsRef<Path>) -> Option<&'static Self> {
        let found = path.as_ref().extension()?;
        Self::ALL.iter().find(|format| found.eq_ignore_ascii_case(format.extension))
    }
}

/// Why frames were not written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AnimationError {
    /// There are no frames, they differ in size or channels, or they are not 8-bit RGB or RGBA.
    #[error("there must be at least one frame, and all must be 8-bit RGB or RGBA of the same size")]
    Frames,
    /// The format does not support frames of that size.
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

/// The duration of each frame in units of `1 / per_second`. Ends are rounded, so that errors do not
/// accumulate, and no frame has a duration of 0.
///
/// - `fps`: frames per second, above 0.
fn durations(frames: usize, fps: f32, per_second: f32) -> impl Iterator<Item = u32> {
    let ends = move |frame: usize| (frame as f32 * per_second / fps).round() as u32;
    (0..frames).map(move |frame| (ends(frame + 1) - ends(frame)).max(1))
}

/// The smallest rectangle with all pixels that differ from the previous frame: its columns and rows.
///
/// - `differs`: whether a pixel does.
fn changed_region(
    width: usize,
    height: usize,
    differs: impl Fn(usize) -> bool,
) -> [Range<usize>; 2] {
    let (mut left, mut top, mut right, mut bottom) = (width, height, 0, 0);
    for y in 0..height {
        for x in (0..width).filter(|x| differs(y * width + x)) {
            (left, right) = (left.min(x), right.max(x + 1));
            (top, bottom) = (top.min(y), y + 1);
        }
    }
    // A frame must have at least one pixel.
    if left >= right { [0..1, 0..1] } else { [left..right, top..bottom] }
}

/// The bytes of compatible frames, and whether they have alpha.
fn bytes_of(frames: &[Texture]) -> Result<(Vec<&[u8]>, bool), AnimationError> {
    let first = frames.first().ok_or(AnimationError::Frames)?;
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
            _ => return Err(AnimationError::Frames),
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
