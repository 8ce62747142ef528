//! How a tone changes colours, in numbers.

use crate::labels::{LabelError, lab};

/// What a tone does to a texture and its base, for people to judge.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct ToneReport {
    /// By how much the lightness of the texture's cheeks changes, and that of the body's skin: L* of CIELAB.
    pub lightness: [f64; 2],
    /// The share of skin that becomes full in a channel, of the texture and of the base, 0 to 1.
    pub clipped: [f64; 2],
    /// How different both sides still look along the rim where cheeks look alike, ΔE 2000; `None` where no skin meets
    /// skin there. That is what fades out near the rim.
    pub at_rim: Option<f64>,
    /// The share of what is carried that is left out for being cloth or background, 0 to 1 of its surface.
    pub left_out: f64,
    /// Why the rim alone decides on the tone of a head, where that is so.
    pub rim_alone: Option<LabelError>,
}

/// Cheeks that change their lightness by more than this are another person's, L* of CIELAB.
const MOST_LIGHTNESS: f64 = 25.0;
/// So much of the skin may become full.
const MOST_CLIPPED: f64 = 0.01;
/// A rim that differs by more than this, ΔE 2000, is hardly of the skin that cheeks show.
const MOST_AT_RIM: f64 = 20.0;

impl ToneReport {
    /// What is not plausible, a sentence each.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if let Some(reason) = &self.rim_alone {
            warnings.push(format!("{reason}; using the tone along the border alone"));
        }
        for (change, what) in
            self.lightness.into_iter().zip(["the face's cheeks", "the body's skin"])
        {
            if change.abs() > MOST_LIGHTNESS {
                let how = if change > 0.0 { "lighter" } else { "darker" };
                warnings.push(format!(
                    "the tone change makes {what} {how} by {:.0} L* (more than \
                     {MOST_LIGHTNESS:.0} suggests another person)",
                    change.abs()
                ));
            }
        }
        for (share, what) in self.clipped.into_iter().zip(["face", "body"]) {
            if share > MOST_CLIPPED {
                warnings.push(format!(
                    "the tone change clips {:.1} % of the {what}'s skin (should be at most {:.0} %)",
                    share * 100.0,
                    MOST_CLIPPED * 100.0
                ));
            }
        }
        if let Some(at_rim) = self.at_rim.filter(|&at_rim| at_rim > MOST_AT_RIM) {
            warnings.push(format!(
                "border and cheeks disagree on the tone: with matching cheeks, the border differs \
                 by ΔE {at_rim:.0} (shading explains at most {MOST_AT_RIM:.0})"
            ));
        }
        warnings
    }
}

/// L* of an sRGB colour.
pub(super) fn lightness(rgb: [f32; 3]) -> f64 {
    f64::from(lab(rgb)[0])
}
