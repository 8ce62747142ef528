//! What a head texture is made of, and how.

use uvgraft::{Mesh, Size, Texture};
use uvgraft_avatar::body::BodyModel;
use uvgraft_figure::{Figure, paint_head};
use uvgraft_files::input::Input;
use uvgraft_image as image;
use uvgraft_pipeline::{Blame, Failure, Observer, Result};
use uvgraft_selfie::Relight;
use uvgraft_selfie::landmarks::FaceChoice;

use super::fitted::{FittedSelfie, GivenHead};
use super::frames::Frames;
use super::tracked;
use crate::{existing, mesh_file};

/// A request for the texture and the shape of a head from photographs of a face.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct SelfieRequest {
    /// The head, whose UV layout the texture will have.
    pub head: Head,
    /// Photographs of one person, or a folder of frames.
    pub photos: Vec<Input>,
    /// Size of the texture; by default 2048×2048, at most 4096×4096 texels.
    pub size: Size,
    /// How photographs are read.
    pub photo_options: PhotoOptions,
}

/// A head.
#[derive(Debug, Clone)]
pub enum Head {
    /// That of the built-in figure.
    Figure,
    /// A mesh with a head and UV coordinates in a file: a head, a bust, a whole body, or a body model.
    File(Input),
    /// Such a mesh in memory.
    Mesh {
        /// The mesh.
        mesh: Mesh,
        /// What to call it in messages.
        name: String,
    },
}

/// Number of frames that are used of a folder, unless another one is given.
pub(super) const FRAMES: u16 = 9;

/// How photographs are read.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PhotoOptions {
    /// The face to use where a photograph shows several, 1 for the largest.
    pub face_number: Option<u16>,
    /// Focal length; by default from EXIF.
    pub focal: Option<FocalLength>,
    /// The usual texture of the head, such as a mean texture: an image in the head's layout. By
    /// default, for the figure's head, its own.
    pub head_texture: Option<Input>,
    /// How much of the light in the photographs is removed.
    pub relight: Relight,
    /// Maximum number of frames used of a folder, evenly spaced; by default 9.
    pub frames: Option<u16>,
    /// The networks that find faces.
    pub networks: Networks,
}

/// The networks that find faces, which are not part of uvgraft.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Networks {
    /// Those that were imported once, in the user's data folder.
    #[default]
    Imported,
    /// A file that an import wrote.
    File(Input),
}

/// A focal length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FocalLength {
    /// In pixels of the upright photograph.
    Pixels(f64),
    /// In millimetres, on 35 mm film with the same diagonal field of view.
    Film(f64),
}

impl FocalLength {
    /// Parses pixels, such as `1800`, or millimetres on film, such as `28mm`.
    ///
    /// # Errors
    /// With what it must be, to follow the option's name.
    pub fn parse(text: &str) -> std::result::Result<Self, String> {
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

impl PhotoOptions {
    /// What the head usually looks like.
    ///
    /// # Errors
    /// As bad input for an image that cannot be read.
    pub(super) fn usual_texture(&self, head: &Mesh) -> Result<Option<Texture>> {
        /// More than drawings show.
        const SIDE: u32 = 1024;
        if let Some(image) = &self.head_texture {
            return Ok(Some(image::read(image).or_input()?.texture));
        }
        let figure = Figure::new();
        let is_figure = head.faces() == figure.head.faces() && head.uv() == figure.head.uv();
        Ok(is_figure.then(|| paint_head(&figure, Size::square(SIDE))))
    }

    /// Which face of a photograph is meant.
    pub(super) fn choice(&self) -> FaceChoice {
        self.face_number.map_or(FaceChoice::Only, |number| FaceChoice::Number(number.into()))
    }

    /// The focal length given for a photograph, in pixels.
    pub(super) fn focal_px(&self, size: Size) -> Option<f64> {
        self.focal.map(|focal| focal.pixels(size))
    }
}

/// Largest number of texels of a texture: each needs some 150 bytes while it is made.
const MOST_TEXELS: usize = 4096 * 4096;

impl SelfieRequest {
    /// A request with the defaults of all options.
    pub fn new(head: Head, photos: impl IntoIterator<Item = impl Into<Input>>) -> Self {
        Self {
            head,
            photos: photos.into_iter().map(Into::into).collect(),
            size: Size::square(2048),
            photo_options: PhotoOptions::default(),
        }
    }

    /// Rejects sizes that are too large, and inputs that do not exist. [`SelfieRequest::make`] does so
    /// itself.
    ///
    /// # Errors
    /// As bad input.
    pub fn check(&self) -> Result<()> {
        self.checked().map(drop)
    }

    /// All inputs, the frames of a folder of photographs among them.
    ///
    /// # Errors
    /// As bad input for a folder that cannot be read.
    pub fn inputs(&self) -> Result<Vec<Input>> {
        let mut inputs: Vec<Input> = self.frames()?.inputs().cloned().collect();
        if let Head::File(file) = &self.head {
            // Without the selector of a part.
            inputs.push(mesh_file::file_of(file));
        }
        inputs.extend(self.photo_options.head_texture.clone());
        Ok(inputs)
    }

    /// Finds the face in the photographs, fits the head's shape to it, and makes the texture.
    ///
    /// - `observer`: receives warnings of frames that are left out; what may look worse than it could is
    ///   reported by [`FittedSelfie::warn`]. It may cancel the work between its steps.
    ///
    /// # Errors
    /// As bad input for photographs without a usable face, a mesh without a head, and networks that
    /// were not imported.
    pub fn make(&self, observer: &dyn Observer) -> Result<FittedSelfie> {
        let frames = self.checked()?;
        let head = self.given_head(observer)?;
        FittedSelfie::new(head, &frames, &self.photo_options, self.size, observer)
    }

    fn checked(&self) -> Result<Frames> {
        if self.size.texels() > MOST_TEXELS {
            let found = self.size;
            return Err(Failure::option(format!(
                "`size` must be at most 4096×4096 texels, got {found}"
            )));
        }
        let frames = self.frames()?;
        existing::check(frames.inputs())?;
        Ok(frames)
    }

    fn frames(&self) -> Result<Frames> {
        Frames::new(&self.photos, self.photo_options.frames)
    }

    fn given_head(&self, observer: &dyn Observer) -> Result<GivenHead> {
        let (mesh, name, flame) = match &self.head {
            Head::Figure => (Figure::new().head, "the demo's figure".to_owned(), None),
            Head::Mesh { mesh, name } => (mesh.clone(), name.clone(), None),
            Head::File(file) => {
                let loaded = mesh_file::read_noting(file, observer)?;
                let flame = tracked::flame(file);
                if let Some(why) = flame.as_ref().and_then(BodyModel::correctives_left_out) {
                    observer.warn(format_args!("{file}: pose correctives are left out: {why}"));
                }
                (loaded.mesh, loaded.name, flame)
            }
        };
        Ok(GivenHead { mesh, name, flame })
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
