//! Options for photographs, shared by `selfie` and `avatar --selfie`.

use std::path::PathBuf;

use uvgraft::{Mesh, Size, Texture};
use uvgraft_figure::{Figure, paint_head};
use uvgraft_io::image;
use uvgraft_selfie::Relight;
use uvgraft_selfie::landmarks::FaceChoice;

use crate::failure::OrBadInput;
use crate::heading;
use crate::number::whole_number;

#[derive(Clone, clap::Args)]
#[command(next_help_heading = heading::PHOTOGRAPHS)]
pub(crate) struct PhotoArgs {
    /// Face to use where a photograph shows several, 1 for the largest
    #[arg(id = "face_number", long = "face", value_name = "N")]
    #[arg(value_parser = whole_number::<u16>(1..=1000), allow_negative_numbers = true)]
    #[arg(requires = "photos")]
    face: Option<u16>,
    /// Focal length in pixels, or as on 35 mm film, such as 28mm [default: from EXIF]
    ///
    /// Pixels are those of the upright image. The length on film is taken to have the same diagonal
    /// field of view. Photographs that don't state a focal length are taken to have one of 1.2 times
    /// their longer side, about 43 mm on film.
    #[arg(long, value_name = "PX|MM", value_parser = FocalLength::parse, requires = "photos")]
    #[arg(allow_hyphen_values = true)]
    focal: Option<FocalLength>,
    /// Usual texture of the head, such as a mean texture [default: for `demo` its own]
    ///
    /// An image in the head's UV layout. Landmarks are found on drawings of the head, and those with
    /// a texture look more like photographs than those without. Nothing of it gets into the result.
    #[arg(long, value_name = "IMAGE", requires = "photos")]
    head_texture: Option<PathBuf>,
    /// How much of the light in the photographs to remove
    #[arg(long, value_enum, value_name = "HOW", default_value_t = RelightName::Soft)]
    #[arg(requires = "photos")]
    relight: RelightName,
    /// Maximum number of frames used of a folder, evenly spaced
    #[arg(long, value_name = "N", default_value_t = 9, requires = "photos")]
    #[arg(value_parser = whole_number::<u16>(1..=64), allow_negative_numbers = true)]
    pub(super) frames: u16,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum RelightName {
    /// None of it: the colours of the photographs
    Off,
    /// Most of the differences in brightness
    Soft,
    /// All differences in brightness and colour
    Full,
}

/// A focal length given by the user.
#[derive(Debug, Clone, Copy, PartialEq)]
enum FocalLength {
    Pixels(f64),
    /// On 35 mm film.
    Film(f64),
}

impl FocalLength {
    fn parse(text: &str) -> Result<Self, String> {
        let wanted =
            || "must be pixels above 0, such as 1800, or millimetres such as 28mm".to_owned();
        let (digits, is_film) = match text.trim().strip_suffix("mm") {
            Some(digits) => (digits, true),
            None => (text.trim().trim_end_matches("px"), false),
        };
        let value: f64 = digits.trim().parse().map_err(|_| wanted())?;
        if !(value.is_finite() && value > 0.0) {
            return Err(wanted());
        }
        Ok(if is_film { Self::Film(value) } else { Self::Pixels(value) })
    }

    fn pixels(self, size: Size) -> f64 {
        /// Diagonal of a frame of 36 by 24 mm.
        const FILM_DIAGONAL_MM: f64 = 43.266_615_305_567_87;
        match self {
            Self::Pixels(pixels) => pixels,
            Self::Film(mm) => {
                f64::from(size.width).hypot(size.height.into()) * mm / FILM_DIAGONAL_MM
            }
        }
    }
}

impl PhotoArgs {
    /// What the head usually looks like.
    ///
    /// # Errors
    /// As bad input for an image that cannot be read.
    pub(super) fn head_texture(&self, head: &Mesh) -> anyhow::Result<Option<Texture>> {
        /// More than drawings show.
        const SIDE: u32 = 1024;
        if let Some(path) = &self.head_texture {
            return Ok(Some(image::read(path).or_bad_input()?.texture));
        }
        let figure = Figure::new();
        let is_figure = head.faces() == figure.head.faces() && head.uv() == figure.head.uv();
        Ok(is_figure.then(|| paint_head(&figure, Size::square(SIDE))))
    }

    /// Which face of a photograph is meant.
    pub(super) fn choice(&self) -> FaceChoice {
        self.face.map_or(FaceChoice::Only, |number| FaceChoice::Number(number.into()))
    }

    /// The focal length given for a photograph, in pixels.
    pub(super) fn focal_px(&self, size: Size) -> Option<f64> {
        self.focal.map(|focal| focal.pixels(size))
    }

    pub(super) fn relight(&self) -> Relight {
        match self.relight {
            RelightName::Off => Relight::Off,
            RelightName::Soft => Relight::Soft,
            RelightName::Full => Relight::Full,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn focal_lengths_are_pixels_or_millimetres_on_film() {
        let size = Size::new(3600, 2400);
        let px = |text| FocalLength::parse(text).map(|focal| focal.pixels(size).round());
        assert_eq!(px("1800"), Ok(1800.0));
        assert_eq!(px("1800px"), Ok(1800.0));
        // 100 pixels per millimetre of film.
        assert_eq!(px("28mm"), Ok(2800.0));
        assert_eq!(px("28.5 mm"), Ok(2850.0));
        for bad in ["", "mm", "0", "-5", "nan", "inf", "28cm", "0mm"] {
            assert!(px(bad).is_err(), "{bad}");
        }
    }
}
