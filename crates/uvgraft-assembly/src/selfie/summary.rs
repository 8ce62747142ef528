//! What was made of photographs: figures and warnings.

use uvgraft_pipeline::Observer;
use uvgraft_selfie::FittedPhoto;

use super::fitted::FittedSelfie;
use super::photo::{FocalSource, Photo};
use crate::report::{Report, grouped};

impl FittedSelfie {
    /// Warns an observer of what may look worse than it could.
    pub fn warn(&self, observer: &dyn Observer) {
        /// In distances between the eyes. Photographs of people gave at most a third of it.
        const MOST_RESIDUAL: f64 = 0.04;
        const LEAST_KNOWN: f64 = 0.4;
        /// A texel is then about a pixel on a texture of 1024 texels.
        const SHARP_PX: f64 = 200.0;
        for (photo, fitted) in self.photos.iter().zip(&self.fit.photos) {
            let path = photo.name.display();
            let residual = self.relative_residual(fitted);
            if residual > MOST_RESIDUAL {
                observer.warn(format_args!(
                    "{path}: landmarks are {:.1} % of the eye distance off the fitted head; should \
                     be at most {:.0} %",
                    100.0 * residual,
                    100.0 * MOST_RESIDUAL,
                ));
            }
            if self.photos.len() == 1 && photo.face_px() < SHARP_PX {
                observer.warn(format_args!(
                    "{path}: the face is only {:.0} pixels high, so its texture is blurred; should be \
                     at least {SHARP_PX}",
                    photo.face_px()
                ));
            }
        }
        let known = self.known_share();
        if known < LEAST_KNOWN {
            observer.warn(format_args!(
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

    /// The figures of the fit, a line for each photograph.
    pub fn figures(&self) -> Report {
        self.report(&self.name)
    }

    /// - `head`: what to call the head.
    pub(crate) fn report(&self, head: &str) -> Report {
        let mut report = Report::default();
        let mut row = |name: &str, value: String| report.row(name, value);
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
        report
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
