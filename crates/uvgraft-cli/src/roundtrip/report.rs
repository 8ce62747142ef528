//! The report of a round trip, as Markdown and JSON.

use std::fmt::Write as _;

use serde::Serialize;
use uvgraft::Size;
use uvgraft_metrics::baseline::affine::MEDIAN_PX;

use super::method::{Method, RoundTrip, Times, WholePicture};
use crate::fitting::FitSummary;
use crate::report::grouped;
use crate::scores::{Scores, better, formatted, title_with_arrow};
use crate::table::{Align, table};
use crate::terminal;

/// The whole report.
#[derive(Serialize)]
pub(super) struct Report {
    pub(super) texture: String,
    pub(super) pair: String,
    /// The texture's layout and the other.
    pub(super) layouts: [String; 2],
    pub(super) size: Size,
    pub(super) via: Size,
    /// Texels transferred there and back.
    pub(super) linked: usize,
    pub(super) threads: usize,
    pub(super) outcomes: Vec<Outcome>,
}

/// The results of one method.
#[derive(Serialize)]
pub(super) struct Outcome {
    method: String,
    #[serde(skip)]
    runs_on_our_maps: bool,
    #[serde(flatten)]
    times: Times,
    #[serde(skip_serializing_if = "Option::is_none")]
    fit: Option<FitSummary>,
    #[serde(skip_serializing_if = "Option::is_none")]
    whole_picture: Option<WholePicture>,
    regions: Scores,
}

impl Outcome {
    pub(super) fn new(method: Method, trip: &RoundTrip, regions: Scores) -> Self {
        Self {
            method: method.title(),
            runs_on_our_maps: method == Method::Grid,
            times: trip.times,
            fit: trip.fit,
            whole_picture: trip.whole_picture,
            regions,
        }
    }
}

impl Report {
    /// Scores over the whole image, scores over the transferred region, and times.
    pub(super) fn markdown(&self) -> String {
        let [from, other] = self.layouts.each_ref().map(|name| terminal::inline(name));
        let mut text = format!(
            "# Round trip of {} ({from})\n\n{} → {} ({other}) → {}, pair {}\n",
            terminal::inline(&self.texture),
            self.size,
            self.via,
            self.size,
            terminal::inline(&self.pair)
        );
        let share = 100.0 * self.linked as f64 / self.size.texels() as f64;
        let titles = [
            "Whole image, laid over the original".to_owned(),
            format!("Transferred region: {} texels, {share:.1} %", grouped(self.linked)),
        ];
        for (region, title) in titles.into_iter().enumerate() {
            let _ = write!(text, "\n## {title}\n\n{}", self.scores(region));
        }
        if let Some(first) = self.outcomes.first() {
            for reason in first.regions.reasons() {
                let _ = writeln!(text, "\n– {reason}");
            }
        }
        let threads = if self.threads == 1 { "thread" } else { "threads" };
        let _ = writeln!(text, "\n## Times on {} {threads}\n\n{}", self.threads, self.times());
        let _ = writeln!(text, "{}", self.notes().join("\n\n"));
        text
    }

    /// A row for each metric and a column for each method; the best of each row is set in bold.
    fn scores(&self, region: usize) -> String {
        let metrics = self.outcomes.first().map(|first| first.regions.metrics());
        let mut rows = vec![vec!["metric".to_owned()]];
        rows[0].extend(self.outcomes.iter().map(|outcome| outcome.method.clone()));
        for (index, metric) in metrics.into_iter().flatten().enumerate() {
            let values: Vec<Option<f64>> =
                self.outcomes.iter().map(|outcome| outcome.regions.value(region, index)).collect();
            let best = values.iter().flatten().copied().reduce(|a, b| better(metric, a, b));
            let mut row = vec![title_with_arrow(metric)];
            row.extend(values.into_iter().map(|value| match value {
                Some(value) if Some(value) == best && self.outcomes.len() > 1 => {
                    format!("**{}**", formatted(metric, value))
                }
                Some(value) => formatted(metric, value),
                None => "–".to_owned(),
            }));
            rows.push(row);
        }
        table(&rows, &[Align::Left])
    }

    fn times(&self) -> String {
        let head = ["method", "maps", "padding", "there", "back", "total"].map(str::to_owned);
        let mut rows = vec![head.to_vec()];
        for Outcome { method, times, .. } in &self.outcomes {
            rows.push(vec![
                method.clone(),
                seconds(times.maps_s),
                times.padding_s.map_or_else(|| "–".to_owned(), seconds),
                seconds(times.there_s),
                seconds(times.back_s),
                seconds(times.total_s()),
            ]);
        }
        table(&rows, &[Align::Left])
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = vec![
            "Maps and padding are prepared once for a pair and its texture sizes, for both \
             directions together; there and back exclude reading and writing files."
                .to_owned(),
        ];
        for outcome in &self.outcomes {
            if let Some(fit) = &outcome.fit {
                notes.push(format!("{}: {fit}.", outcome.method));
            }
            if outcome.runs_on_our_maps {
                notes.push(format!(
                    "{}: the convention of the published reference, aligned corners and truncated \
                     values, run here on uvgraft's maps; its own code first builds a grid of \
                     positions, so these times are not its own.",
                    outcome.method
                ));
            }
            if let Some(whole) = &outcome.whole_picture {
                notes.push(format!(
                    "{}: an affine warp per triangle with integer corners, and a final median \
                     filter over {MEDIAN_PX} texels that hides cracks but removes detail. Run \
                     on the bounding box of each triangle. As in scripts, where each of {} warps \
                     covers the whole image, it would take about {}: extrapolated from {} \
                     triangles measured that way, without the median filter.",
                    outcome.method,
                    grouped(whole.triangles),
                    seconds(whole.extrapolated_s),
                    whole.measured,
                ));
            }
        }
        notes
    }
}

/// A duration in a suitable unit.
fn seconds(seconds: f64) -> String {
    match seconds {
        s if s < 0.1 => format!("{:.1} ms", s * 1e3),
        s if s < 1.0 => format!("{:.0} ms", s * 1e3),
        s if s < 120.0 => format!("{s:.1} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
