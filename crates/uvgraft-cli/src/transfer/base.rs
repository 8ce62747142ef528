//! What textures are laid over: an image, a colour, or nothing.

use std::path::Path;

use uvgraft::{Channels, Depth, Encoding, Size, Texture};
use uvgraft_io::image::{self, Image};

use super::Args;
use crate::failure::{OrBadInput, bad_input};

/// What textures are laid over.
pub(super) enum Base {
    Image(Image, String),
    Color { unit: [f32; 4], size: Size },
}

impl Base {
    pub(super) fn new(args: &Args, path: Option<&Path>) -> anyhow::Result<Self> {
        if let Some(path) = path {
            let mut image = image::read(path).map_err(|error| match path.exists() {
                true => bad_input(error),
                false => {
                    bad_input(format!("{error}; --onto wants an image or a colour such as #808080"))
                }
            })?;
            image.texture = meant(image.texture, args);
            if let Some(size) = args.size {
                image.texture =
                    image.texture.resized(size, args.filter(), args.linear_light).or_bad_input()?;
            }
            return Ok(Self::Image(image, path.display().to_string()));
        }
        let unit = args.onto.as_deref().map_or(Ok([0.0; 4]), parse_color)?;
        let size = args.size.ok_or_else(|| {
            bad_input("without a base image the result needs a size: give --size N or --onto IMAGE")
        })?;
        Ok(Self::Color { unit, size })
    }

    pub(super) fn size(&self) -> Size {
        match self {
            Self::Image(image, _) => image.texture.size(),
            Self::Color { size, .. } => *size,
        }
    }

    /// What is worth knowing about the ICC profiles of the base and of a source.
    pub(super) fn mismatch(&self, source: &Image, name: &Path) -> Option<String> {
        let Self::Image(base, base_name) = self else { return None };
        let name = name.display();
        let found = match (&source.icc, &base.icc) {
            (source, base) if source == base => return None,
            (Some(_), Some(_)) => {
                format!(
                    "{name} and {base_name} have different ICC profiles; the result has that of {base_name}"
                )
            }
            (Some(_), None) => {
                format!("{name} has an ICC profile, {base_name} has none; nor has the result")
            }
            (None, _) => {
                format!(
                    "{base_name} has an ICC profile, {name} has none; the result has that of {base_name}"
                )
            }
        };
        Some(format!("{found}, and values are carried as they are"))
    }

    /// The base to lay `source` over, and the ICC profile that goes with it.
    pub(super) fn under(&self, source: &Image) -> anyhow::Result<(Texture, Option<Vec<u8>>)> {
        match self {
            Self::Image(base, _) => Ok((base.texture.clone(), base.icc.clone())),
            Self::Color { unit, size } => {
                let [r, g, b, alpha] = *unit;
                let texture = &source.texture;
                let colored = texture.channels().has_color() || r != g || g != b;
                let clear = texture.channels().has_alpha() || alpha < 1.0;
                let channels = Channels::new(colored, clear);
                let full = Texture::filled(*size, Channels::Rgba, Encoding::Srgb, Depth::U8, unit)?;
                let full = full.encoded_as(texture.encoding());
                Ok((full.converted(channels, texture.depth()), source.icc.clone()))
            }
        }
    }
}

/// `#RGB`, `#RRGGBB` or `#RRGGBBAA`, as values with 1.0 for full.
fn parse_color(text: &str) -> anyhow::Result<[f32; 4]> {
    let digits = text.strip_prefix('#').unwrap_or_default();
    let wanted = || bad_input(format!("colour {text:?}: wanted #RGB, #RRGGBB or #RRGGBBAA"));
    if !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return Err(wanted());
    }
    let value = |text: &str| u8::from_str_radix(text, 16).map_err(|_| wanted());
    let values = match digits.len() {
        3 => {
            (0..3).map(|k| Ok(value(&digits[k..=k])? * 17)).collect::<anyhow::Result<Vec<u8>>>()?
        }
        6 | 8 => (0..digits.len() / 2)
            .map(|k| value(&digits[2 * k..2 * k + 2]))
            .collect::<anyhow::Result<Vec<u8>>>()?,
        _ => return Err(wanted()),
    };
    let unit = |channel: usize| f32::from(values.get(channel).copied().unwrap_or(255)) / 255.0;
    Ok([unit(0), unit(1), unit(2), unit(3)])
}

/// A texture that is what the options say it is.
pub(super) fn meant(texture: Texture, args: &Args) -> Texture {
    if args.data { texture.with_encoding(Encoding::Data) } else { texture }
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
