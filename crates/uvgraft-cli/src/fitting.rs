//! Fits whose progress is shown.

use serde::Serialize;
use uvgraft::{Fit, FitProgress, Overlay, TexelFormat, Texture, TransferError};

use crate::progress;

/// How a fit went.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct FitSummary {
    pub(crate) steps: u32,
    /// Root mean square difference to the source after the way back, in levels of 255, before
    /// rounding: of the sampled texture, and of the fitted one.
    pub(crate) sampled_rms_levels: f64,
    pub(crate) fitted_rms_levels: f64,
    /// Which share of the source's linked texels these are over; the others read what another
    /// island owns.
    pub(crate) share_met: f64,
}

impl std::fmt::Display for FitSummary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { steps, sampled_rms_levels: before, fitted_rms_levels: after, share_met } = self;
        let steps_word = if *steps == 1 { "step" } else { "steps" };
        write!(f, "{steps} {steps_word}, error when read back {before:.2} → {after:.2} of 255")?;
        if *share_met < 0.9995 {
            let lost = 100.0 * (1.0 - share_met);
            write!(
                f,
                ", not counting {lost:.1} % of the source that is lost where islands overlap"
            )?;
        }
        Ok(())
    }
}

/// Fits a texture, with a bar on standard error if that is a terminal, and lays it over a base.
pub(crate) fn fit(
    fit: &Fit,
    source: Texture,
    base: Texture,
) -> Result<(Texture, FitSummary), TransferError> {
    let (overlay, summary) = overlay(fit, source, base.format())?;
    Ok((overlay.lay(0, base)?, summary))
}

/// Fits a texture that is to be laid over a base of some format, with a bar as [`fit`].
pub(crate) fn overlay(
    fit: &Fit,
    source: Texture,
    base: TexelFormat,
) -> Result<(Overlay<'_>, FitSummary), TransferError> {
    let bar = progress::bar(0, "fitting {bar:24} step {pos} of at most {len}: {msg}");
    let levels = |progress: FitProgress| progress.rms * 255.0;
    let mut course: Option<FitSummary> = None;
    let overlay = fit.overlay(source, base, &mut |progress| {
        bar.set_length(progress.max_steps.into());
        bar.set_position(progress.step.into());
        bar.set_message(format!("error {:.2} of 255", levels(progress)));
        course = Some(FitSummary {
            steps: progress.step,
            sampled_rms_levels: course.map_or(levels(progress), |first| first.sampled_rms_levels),
            fitted_rms_levels: levels(progress),
            share_met: fit.share_met(),
        });
    })?;
    bar.finish_and_clear();
    let nothing =
        FitSummary { steps: 0, sampled_rms_levels: 0.0, fitted_rms_levels: 0.0, share_met: 1.0 };
    Ok((overlay, course.unwrap_or(nothing)))
}
