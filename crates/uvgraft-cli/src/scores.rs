//! Metrics of two textures, by region, as a table and as JSON.

use std::fmt::Write as _;

use serde::{Serialize, Serializer};
use uvgraft::{Choice, Size};
use uvgraft_metrics::lpips::Lpips;
use uvgraft_metrics::{Colors, Mask, Metric, MetricError};

use crate::failure::bad_input;
use crate::table::{Align, table};
use crate::weights;

/// Compares two textures in each of the regions.
fn scores_of(
    metric: Metric,
    a: &Colors,
    b: &Colors,
    regions: &[ScoredRegion],
    networks: &Networks,
) -> Vec<Score> {
    if let Some(reason) = missing(metric, networks) {
        return unavailable(regions, reason);
    }
    match metric.measure() {
        Some(measure) => {
            regions.iter().map(|region| measure(a, b, region.mask.as_ref()).into()).collect()
        }
        // Missing networks were handled above.
        None => networks.of(metric).map_or_else(Vec::new, |it| lpips(it, a, b, regions)),
    }
}

/// Why a metric cannot be computed at all, if so.
fn missing(metric: Metric, networks: &Networks) -> Option<&'static str> {
    match metric.network() {
        Some(_) if networks.of(metric).is_none() => {
            Some("weights not imported; see `uvgraft weights --help`")
        }
        None if metric.measure().is_none() => Some("this build lacks the feature `flip`"),
        _ => None,
    }
}

/// The direction of improvement.
fn arrow(metric: Metric) -> &'static str {
    if metric.higher_is_better() { "↑" } else { "↓" }
}

/// A metric's heading in a row or column.
pub(crate) fn title_with_arrow(metric: Metric) -> String {
    format!("{} {}", metric.title(), arrow(metric))
}

/// The better of two values of a metric.
pub(crate) fn better(metric: Metric, a: f64, b: f64) -> f64 {
    if metric.higher_is_better() { a.max(b) } else { a.min(b) }
}

/// A value of a metric with its significant digits.
pub(crate) fn formatted(metric: Metric, value: f64) -> String {
    format!("{value:.*}", metric.decimals())
}

fn unavailable(regions: &[ScoredRegion], reason: &str) -> Vec<Score> {
    regions.iter().map(|_| Score::Unavailable(reason.to_owned())).collect()
}

/// A network processes the whole textures once; its maps then serve all regions.
fn lpips(network: &Lpips, a: &Colors, b: &Colors, regions: &[ScoredRegion]) -> Vec<Score> {
    match network.compare(a, b) {
        Ok(maps) => regions
            .iter()
            .map(|region| match &region.mask {
                Some(mask) => maps.masked_mean(mask).into(),
                None => Score::Value(maps.mean()),
            })
            .collect(),
        Err(error) => unavailable(regions, &error.to_string()),
    }
}

/// The LPIPS networks that a selection needs, if imported.
struct Networks(Vec<Lpips>);

impl Networks {
    fn load(selection: &Selection) -> anyhow::Result<Self> {
        let mut networks = Self(Vec::new());
        for network in selection.metrics.iter().filter_map(|metric| metric.network()) {
            networks.0.extend(weights::lpips(network)?);
        }
        Ok(networks)
    }

    /// The network of a metric, if it needs one that is imported.
    fn of(&self, metric: Metric) -> Option<&Lpips> {
        self.0.iter().find(|lpips| Some(lpips.network()) == metric.network())
    }
}

/// The selected metrics without duplicates, in the order of [`Metric::ALL`].
#[derive(Debug, Clone, PartialEq, Eq)]
struct Selection {
    metrics: Vec<Metric>,
    /// Whether they were named explicitly, so that one that cannot be computed is an error.
    named: bool,
}

impl Default for Selection {
    /// All metrics that are available and fast.
    fn default() -> Self {
        let is_default = |metric: Metric| match metric.network() {
            Some(_) => !metric.is_slow(),
            None => metric.measure().is_some(),
        };
        Self::of(is_default, false)
    }
}

impl Selection {
    fn of(chosen: impl Fn(Metric) -> bool, named: bool) -> Self {
        let metrics = Metric::ALL.iter().copied().filter(|metric| chosen(*metric)).collect();
        Self { metrics, named }
    }

    /// Parses a comma-separated list of names, or `all`.
    fn parse(list: &str) -> Result<Self, String> {
        let list = list.to_lowercase();
        let names: Vec<&str> = list.split(',').map(str::trim).collect();
        for name in &names {
            if *name != "all" && Metric::named(name).is_none() {
                let known: Vec<&str> = Metric::ALL.iter().map(|metric| metric.name()).collect();
                let known = known.join(", ");
                return Err(format!("metrics must be some of {known}, or all, got `{name}`"));
            }
        }
        let all = names.contains(&"all");
        Ok(Self::of(|metric| all || names.contains(&metric.name()), !all))
    }
}

/// The option that selects metrics.
#[derive(clap::Args)]
pub(crate) struct MetricsOption {
    /// Comma-separated metrics, or `all` [default: all but the slow ones]
    ///
    /// Known metrics: l1, psnr, ssim, ssim-uniform, ssimulacra2, flip, lpips-alex, lpips-vgg.
    /// lpips-vgg takes minutes on large textures, so it runs only when named. flip is an optional
    /// feature of the build, and both lpips metrics need weights: see `uvgraft weights`.
    #[arg(long, value_name = "LIST", value_parser = Selection::parse)]
    metrics: Option<Selection>,
}

impl MetricsOption {
    /// Loads what the metrics need; see [`Judge::new`].
    pub(crate) fn judge(&self) -> anyhow::Result<Judge> {
        Judge::new(self.metrics.clone().unwrap_or_default())
    }
}

/// The selected metrics and their networks.
pub(crate) struct Judge {
    selection: Selection,
    networks: Networks,
}

impl Judge {
    /// Loads what the metrics need. Damaged weights are an error, and so is a metric named
    /// explicitly that cannot be computed.
    fn new(selection: Selection) -> anyhow::Result<Self> {
        let networks = Networks::load(&selection)?;
        for metric in selection.metrics.iter().filter(|_| selection.named) {
            if let Some(reason) = missing(*metric, &networks) {
                return Err(bad_input(format!("--metrics {}: {reason}", metric.name())));
            }
        }
        Ok(Self { selection, networks })
    }

    /// Memory that the most demanding metric takes at most beside the colours, in bytes.
    pub(crate) fn scratch_bytes(&self, size: Size, of_levels: bool) -> u64 {
        let metrics = self.selection.metrics.iter();
        metrics.map(|metric| metric.scratch_bytes(size, of_levels)).max().unwrap_or(0)
    }
}

/// A named [`Mask`], for a row of the report.
pub(crate) struct ScoredRegion {
    /// Its name.
    pub(crate) name: String,
    /// Its texels; `None` for all.
    pub(crate) mask: Option<Mask>,
}

/// The result of a metric.
#[derive(Debug, Clone, PartialEq)]
enum Score {
    Value(f64),
    /// Why there is no value.
    Unavailable(String),
}

impl From<Result<f64, MetricError>> for Score {
    fn from(result: Result<f64, MetricError>) -> Self {
        match result {
            Ok(value) => Self::Value(value),
            Err(error) => Self::Unavailable(error.to_string()),
        }
    }
}

impl Serialize for Score {
    /// A number, `"inf"`, which JSON has no number for, or an object with the reason.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Value(value) if value.is_infinite() => serializer.serialize_str("inf"),
            Self::Value(value) => serializer.serialize_f64(*value),
            Self::Unavailable(reason) => serializer.collect_map([("unavailable", reason)]),
        }
    }
}

/// The scores of two textures, by region.
#[derive(Debug, Serialize)]
#[serde(transparent)]
pub(crate) struct Scores {
    regions: Vec<RegionScores>,
}

#[derive(Debug, Serialize)]
struct RegionScores {
    region: String,
    texels: usize,
    #[serde(serialize_with = "as_map")]
    scores: Vec<(Metric, Score)>,
}

fn as_map<S: Serializer>(scores: &[(Metric, Score)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(scores.iter().map(|(metric, score)| (metric, score)))
}

impl Scores {
    /// Compares two textures; all masks must have the same size.
    pub(crate) fn new(a: &Colors, b: &Colors, regions: &[ScoredRegion], judge: &Judge) -> Self {
        let mut all: Vec<RegionScores> = regions
            .iter()
            .map(|ScoredRegion { name, mask }| RegionScores {
                region: name.clone(),
                texels: mask.as_ref().map_or(a.size().texels(), Mask::count),
                scores: Vec::new(),
            })
            .collect();
        for &metric in &judge.selection.metrics {
            let scores = scores_of(metric, a, b, regions, &judge.networks);
            for (region, score) in all.iter_mut().zip(scores) {
                region.scores.push((metric, score));
            }
        }
        Self { regions: all }
    }

    /// The metrics of the table, in order.
    pub(crate) fn metrics(&self) -> Vec<Metric> {
        let first = self.regions.first();
        first.map_or_else(Vec::new, |region| region.scores.iter().map(|(m, _)| *m).collect())
    }

    /// The value of a metric by the indices of region and metric, if it has one.
    pub(crate) fn value(&self, region: usize, metric: usize) -> Option<f64> {
        match self.regions[region].scores[metric].1 {
            Score::Value(value) => Some(value),
            Score::Unavailable(_) => None,
        }
    }

    /// The reasons for missing values, without duplicates.
    pub(crate) fn reasons(&self) -> Vec<String> {
        let mut reasons = Vec::new();
        for (metric, score) in self.regions.iter().flat_map(|region| &region.scores) {
            if let Score::Unavailable(reason) = score {
                // Some reasons already start with the metric.
                let reason = match reason.starts_with(metric.title()) {
                    true => reason.clone(),
                    false => format!("{}: {reason}", metric.title()),
                };
                if !reasons.contains(&reason) {
                    reasons.push(reason);
                }
            }
        }
        reasons
    }

    /// A Markdown table, aligned to be readable as text: a row for each metric, a column for each
    /// region, and the reasons for missing values below.
    pub(crate) fn table(&self) -> String {
        let mut rows = vec![vec!["metric".to_owned(), "better".to_owned()]];
        rows[0].extend(self.regions.iter().map(|region| region.region.replace('|', "\\|")));
        for (index, metric) in self.metrics().into_iter().enumerate() {
            let mut row = vec![metric.title().to_owned(), arrow(metric).to_owned()];
            row.extend((0..self.regions.len()).map(|region| match self.value(region, index) {
                Some(value) => formatted(metric, value),
                None => "–".to_owned(),
            }));
            rows.push(row);
        }
        let mut text = table(&rows, &[Align::Left, Align::Centre]);
        let reasons = self.reasons();
        if !reasons.is_empty() {
            let _ = writeln!(text, "\n{}", reasons.join("\n"));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn selections() {
        let parse = |list: &str| Selection::parse(list).unwrap().metrics;
        assert_eq!(parse("psnr,l1, psnr"), [Metric::L1, Metric::Psnr]);
        assert_eq!(parse("all"), Metric::ALL);
        assert_eq!(parse("PSNR"), [Metric::Psnr]);
        for bad in ["", "l1,", "lpips", "l1;psnr"] {
            assert!(Selection::parse(bad).is_err(), "{bad}");
        }
        assert!(!Selection::default().metrics.contains(&Metric::LpipsVgg));
    }

    #[test]
    fn the_help_names_all_metrics() {
        let command = <MetricsOption as clap::Args>::augment_args(clap::Command::new("compare"));
        let option = command.get_arguments().find(|option| option.get_id() == "metrics").unwrap();
        let help = option.get_long_help().unwrap().to_string().replace('\n', " ");
        let names: Vec<&str> = Metric::ALL.iter().map(|metric| metric.name()).collect();
        assert!(help.contains(&format!("Known metrics: {}.", names.join(", "))), "{help}");
    }

    #[test]
    fn a_table_and_json() {
        let region = |name: &str, texels, value, reason: &str| RegionScores {
            region: name.to_owned(),
            texels,
            scores: vec![
                (Metric::Psnr, Score::Value(value)),
                (Metric::L1, Score::Unavailable(reason.to_owned())),
            ],
        };
        let regions = vec![
            region("whole image", 12, f64::INFINITY, "the moon is full"),
            region("a", 5, 31.237, "the moon is full"),
        ];
        let scores = Scores { regions };
        let wanted = "\
| metric    | better | whole image |     a |
|:----------|:------:|------------:|------:|
| PSNR (dB) |   ↑    |         inf | 31.24 |
| L1        |   ↓    |           – |     – |

L1: the moon is full
";
        assert_eq!(scores.table(), wanted);
        let wanted = r#"[{"region":"whole image","texels":12,"scores":{"psnr":"inf","l1":{"unavailable":"the moon is full"}}},{"region":"a","texels":5,"scores":{"psnr":31.237,"l1":{"unavailable":"the moon is full"}}}]"#;
        assert_eq!(serde_json::to_string(&scores).unwrap(), wanted);
    }
}
