//! Progress and summaries of fits.

use indicatif::ProgressBar;
use serde::Serialize;
use uvgraft::FitProgress;

use crate::progress;

/// Summary of a fit.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct FitSummary {
    pub(crate) steps: u32,
    /// Root mean square round-trip error in levels of 255, before rounding: of the sampled texture,
    /// and of the fitted one.
    pub(crate) sampled_rms_levels: f64,
    pub(crate) fitted_rms_levels: f64,
    /// The share of the source's linked texels that the errors are computed over; the others read
    /// texels owned by another island.
    pub(crate) share_met: f64,
}

impl From<&uvgraft::FitSummary> for FitSummary {
    fn from(summary: &uvgraft::FitSummary) -> Self {
        Self {
            steps: summary.steps,
            sampled_rms_levels: levels(summary.sampled_rms),
            fitted_rms_levels: levels(summary.fitted_rms),
            share_met: summary.share_met,
        }
    }
}

fn levels(rms: f64) -> f64 {
    rms * 255.0
}

impl std::fmt::Display for FitSummary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { steps, sampled_rms_levels: before, fitted_rms_levels: after, share_met } = self;
        let steps_word = if *steps == 1 { "step" } else { "steps" };
        write!(f, "{steps} {steps_word}, round-trip RMSE {before:.2} → {after:.2} of 255")?;
        if *share_met < 0.9995 {
            let lost = 100.0 * (1.0 - share_met);
            write!(f, ", excluding {lost:.1} % of the source that overlapping islands hide")?;
        }
        Ok(())
    }
}

/// A progress bar on standard error, if that is a terminal.
pub(crate) struct FitBar(ProgressBar);

impl Default for FitBar {
    fn default() -> Self {
        Self(progress::bar(0, "fitting {bar:24} step {pos} of at most {len}: {msg}"))
    }
}

impl FitBar {
    /// Updates the progress.
    pub(crate) fn show(&self, progress: FitProgress) {
        self.0.set_length(progress.max_steps.into());
        self.0.set_position(progress.step.into());
        self.0.set_message(format!("error {:.2} of 255", levels(progress.rms)));
    }

    /// Removes the bar.
    pub(crate) fn finish(self) {
        self.0.finish_and_clear();
    }
}
