//! What was made of photographs, printed and warned about.

use std::fmt::Write as _;
use std::path::Path;

use uvgraft_selfie::FittedPhoto;

use super::made::Selfie;
use super::photo::{FocalSource, Photo};
use crate::failure::warn;
use crate::report::grouped;
use crate::terminal;

impl Selfie {
    /// Prints warnings about what may look worse than it could.
    pub(crate) fn warn(&self) {
        /// In distances between the eyes. Photographs of people gave at most a third of it.
        const MOST_RESIDUAL: f64 = 0.04;
        const LEAST_KNOWN: f64 = 0.4;
        /// A texel is then about a pixel on a texture of 1024 texels.
        const SHARP_PX: f64 = 200.0;
        for (photo, fitted) in self.photos.iter().zip(&self.fit.photos) {
            let path = photo.path.display();
            let residual = self.relative_residual(fitted);
            if residual > MOST_RESIDUAL {
                warn(format_args!(
                    "{path}: landmarks are {:.1} % of the eye distance off the fitted head; should \
                     be at most {:.0} %",
                    100.0 * residual,
                    100.0 * MOST_RESIDUAL,
                ));
            }
            if self.photos.len() == 1 && photo.face_px() < SHARP_PX {
                warn(format_args!(
                    "{path}: the face is only {:.0} pixels high, so its texture is blurred; should be \
                     at least {SHARP_PX}",
                    photo.face_px()
                ));
            }
        }
        let known = self.known_share();
        if known < LEAST_KNOWN {
            warn(format_args!(
                "the photographs show only {:.0} % of the face; the rest is mirrored or filled",
                100.0 * known
            ));
        }
    }

    /// The residual of a photograph in distances between the eyes.
    fn relative_residual(&self, fitted: &FittedPhoto) -> f64 {
        let eyes = glam::DVec3::from(self.head.anatomy().frame().origin);
        fitted.residual_px / (fitted.camera.scale(fitted.camera.view(eyes).z) * self.head.unit())
    }

    /// The summary of a fit, a line for each photograph.
    pub(crate) fn text(&self, head: &str) -> String {
        let mut text = String::new();
        let mut row = |name: &str, value: String| {
            let _ = writeln!(text, "{name:<14} {value}");
        };
        let vertices = grouped(self.head.mesh().positions().len());
        row("head", format!("{head}, {vertices} vertices"));
        for (index, (photo, fitted)) in self.photos.iter().zip(&self.fit.photos).enumerate() {
            let name = match self.photos.len() {
                1 => "photograph".to_owned(),
                _ => format!("photograph {}", index + 1),
            };
            row(&name, self.photograph(photo, fitted));
        }
        row("known", format!("{:.0} % of the face", 100.0 * self.known_share()));
        text
    }

    fn photograph(&self, photo: &Photo, fitted: &FittedPhoto) -> String {
        let source = match photo.focal {
            FocalSource::Option => "as given",
            FocalSource::Exif => "from EXIF",
            FocalSource::Tracker => "as tracked",
            FocalSource::Assumed => "assumed",
        };
        format!(
            "{} pixels, face {:.0} pixels high, focal length {:.0} pixels ({source}), landmarks \
             {:.2} pixels off ({:.1} % of the eye distance)",
            photo.landmarks.size,
            photo.face_px(),
            fitted.camera.focal_px,
            fitted.residual_px,
            100.0 * self.relative_residual(fitted),
        )
    }
}

/// The line of an output.
pub(super) fn output(what: &str, path: &Path) -> String {
    format!("{what:<14} {}\n", terminal::path(path))
}
