//! Base textures, as given in options.

use std::path::Path;

use uvgraft_files::input::Input;

use crate::failure::{Failure, Result};

/// Parses `#RGB`, `#RRGGBB` or `#RRGGBBAA` into values with 1.0 for full intensity.
fn parse_color(text: &str) -> Result<[f32; 4]> {
    let digits = text.strip_prefix('#').unwrap_or_default();
    let wanted =
        || Failure::input(format!("colour must be #RGB, #RRGGBB or #RRGGBBAA, got {text:?}"));
    if !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return Err(wanted());
    }
    let value = |text: &str| u8::from_str_radix(text, 16).map_err(|_| wanted());
    let values = match digits.len() {
        3 => (0..3).map(|k| Ok(value(&digits[k..=k])? * 17)).collect::<Result<Vec<u8>>>()?,
        6 | 8 => (0..digits.len() / 2)
            .map(|k| value(&digits[2 * k..2 * k + 2]))
            .collect::<Result<Vec<u8>>>()?,
        _ => return Err(wanted()),
    };
    let unit = |channel: usize| f32::from(values.get(channel).copied().unwrap_or(255)) / 255.0;
    Ok([unit(0), unit(1), unit(2), unit(3)])
}

/// The base that textures are composited onto: an image in the target layout, or a colour.
#[derive(Debug, Clone, PartialEq)]
pub enum BaseSource {
    /// An image.
    Image(Input),
    /// sRGB-encoded red, green, blue and alpha, 1.0 for full intensity.
    Color([f32; 4]),
}

impl BaseSource {
    /// An image, of a path or in memory.
    pub fn image(input: impl Into<Input>) -> Self {
        Self::Image(input.into())
    }

    /// Parses a colour (`#RGB`, `#RRGGBB` or `#RRGGBBAA`), or else a path.
    ///
    /// # Errors
    /// If the text starts with `#` but is not a colour.
    pub fn parse(text: &str) -> Result<Self> {
        if text.starts_with('#') {
            parse_color(text).map(Self::Color)
        } else {
            Ok(Self::image(text))
        }
    }

    /// The image, if it is one.
    pub fn as_image(&self) -> Option<&Input> {
        match self {
            Self::Image(image) => Some(image),
            Self::Color(_) => None,
        }
    }

    /// The path of the image, if it is one in a file.
    pub fn path(&self) -> Option<&Path> {
        self.as_image()?.path()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors() {
        let grey = 128.0 / 255.0;
        assert_eq!(parse_color("#808080").unwrap(), [grey, grey, grey, 1.0]);
        assert_eq!(parse_color("#f00").unwrap(), [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(parse_color("#00ff0000").unwrap(), [0.0, 1.0, 0.0, 0.0]);
        for bad in ["#", "#12", "##123", "#12345", "#gggggg", "#ééé"] {
            assert!(parse_color(bad).unwrap_err().to_string().contains(bad), "{bad}");
        }
    }
}
