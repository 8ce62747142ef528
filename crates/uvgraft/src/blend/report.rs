//! Figures on how a tone changes colours.

use crate::color::lab;
use crate::labels::LabelError;

/// How a tone changes a texture and its base, for people to judge.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct ToneReport {
    /// Change in lightness of the texture's cheeks and of the body's skin, in L* of CIELAB.
    pub lightness: [f64; 2],
    /// Fraction of the skin that newly clips in a channel, in the texture and in the base, 0 to 1.
    pub clipped: [f64; 2],
    /// How much both sides still differ along the boundary once their cheeks match, ΔE 2000; `None`
    /// where no skin meets skin. This remainder fades out near the boundary.
    pub boundary_delta_e: Option<f64>,
    /// Fraction of the transferred surface that is left out as cloth or background, 0 to 1.
    pub left_out: f64,
    /// Why a head's tone is taken from the boundary alone, if it is.
    pub boundary_only: Option<LabelError>,
}

/// Cheeks whose lightness changes by more than this belong to another person, L* of CIELAB. Origin
/// not recorded.
const MAX_LIGHTNESS: f64 = 25.0;
/// Greatest fraction of the skin that may clip. The bench of looks demands the same of all its
/// results.
const MAX_CLIPPED: f64 = 0.01;
/// A boundary that differs by more than this, ΔE 2000, is hardly the skin that the cheeks show.
/// Origin not recorded.
const MAX_BOUNDARY_DELTA_E: f64 = 20.0;

impl ToneReport {
    /// Warnings about implausible figures, one sentence each.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if let Some(reason) = &self.boundary_only {
            warnings.push(format!("{reason}; using the tone along the boundary alone"));
        }
        for (change, what) in
            self.lightness.into_iter().zip(["the face's cheeks", "the body's skin"])
        {
            if change.abs() > MAX_LIGHTNESS {
                let how = if change > 0.0 { "lighter" } else { "darker" };
                warnings.push(format!(
                    "matching the tone makes {what} {how} by {:.1} L* (more than {MAX_LIGHTNESS:.0} is \
                     implausible for one person); `tone` both shares the change between face and body",
                    change.abs()
                ));
            }
        }
        for (share, what) in self.clipped.into_iter().zip(["face", "body"]) {
            if share > MAX_CLIPPED {
                warnings.push(format!(
                    "matching the tone clips {:.1} % of the {what}'s skin (should be at most {:.0} %)",
                    share * 100.0,
                    MAX_CLIPPED * 100.0
                ));
            }
        }
        if let Some(boundary_delta_e) = self
            .boundary_delta_e
            .filter(|&boundary_delta_e| boundary_delta_e > MAX_BOUNDARY_DELTA_E)
        {
            warnings.push(format!(
                "boundary and cheeks disagree on the tone: ΔE {boundary_delta_e:.0} remains at the boundary \
                 once the cheeks match (shading accounts for at most {MAX_BOUNDARY_DELTA_E:.0})"
            ));
        }
        warnings
    }
}

/// L* of an sRGB colour.
pub(super) fn lightness(rgb: [f32; 3]) -> f64 {
    f64::from(lab(rgb)[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_warn_beyond_what_one_person_explains() {
        let plausible = ToneReport {
            lightness: [25.0, -25.0],
            clipped: [0.01; 2],
            boundary_delta_e: Some(20.0),
            ..ToneReport::default()
        };
        assert_eq!(plausible.warnings(), [""; 0]);
        let warned = |report: ToneReport, wanted: &str| {
            let found = report.warnings();
            assert!(found.len() == 1 && found[0].contains(wanted), "{found:?}, not {wanted}");
        };
        let report = || plausible.clone();
        warned(ToneReport { lightness: [25.4, 0.0], ..report() }, "cheeks lighter by 25.4 L*");
        warned(ToneReport { lightness: [0.0, -31.0], ..report() }, "skin darker by 31.0 L*");
        warned(ToneReport { clipped: [0.013, 0.0], ..report() }, "clips 1.3 % of the face's");
        warned(ToneReport { clipped: [0.0, 0.5], ..report() }, "clips 50.0 % of the body's");
        warned(ToneReport { boundary_delta_e: Some(21.0), ..report() }, "ΔE 21 remains");
    }
}
