//! Scores of two textures, by metric and region, as a table and as JSON.

use std::fmt::Write as _;

use serde::{Serialize, Serializer};
use uvgraft::metrics::{self, Colors, Mask, MetricError};

/// What textures are compared by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Metric {
    L1,
    Psnr,
    Ssim,
    SsimUniform,
    Ssimulacra2,
    Flip,
    LpipsAlex,
    LpipsVgg,
}

impl Metric {
    /// All metrics, in the order of a table's rows.
    const ALL: [Self; 8] = [
        Self::L1,
        Self::Psnr,
        Self::Ssim,
        Self::SsimUniform,
        Self::Ssimulacra2,
        Self::Flip,
        Self::LpipsAlex,
        Self::LpipsVgg,
    ];

    /// What it is called on the command line and in JSON.
    fn name(self) -> &'static str {
        match self {
            Self::L1 => "l1",
            Self::Psnr => "psnr",
            Self::Ssim => "ssim",
            Self::SsimUniform => "ssim-uniform",
            Self::Ssimulacra2 => "ssimulacra2",
            Self::Flip => "flip",
            Self::LpipsAlex => "lpips-alex",
            Self::LpipsVgg => "lpips-vgg",
        }
    }

    /// What it is called in a table.
    fn title(self) -> &'static str {
        match self {
            Self::L1 => "L1",
            Self::Psnr => "PSNR (dB)",
            Self::Ssim => "SSIM",
            Self::SsimUniform => "SSIM, uniform",
            Self::Ssimulacra2 => "SSIMULACRA 2",
            Self::Flip => "FLIP",
            Self::LpipsAlex => "LPIPS, AlexNet",
            Self::LpipsVgg => "LPIPS, VGG",
        }
    }

    fn higher_is_better(self) -> bool {
        matches!(self, Self::Psnr | Self::Ssim | Self::SsimUniform | Self::Ssimulacra2)
    }

    /// Digits after the point that a table shows.
    fn decimals(self) -> usize {
        match self {
            Self::Psnr | Self::Ssimulacra2 => 2,
            _ => 5,
        }
    }

    /// Whether it is computed without being asked for: VGG takes minutes on large textures.
    fn is_default(self) -> bool {
        self != Self::LpipsVgg && self.missing().is_none()
    }

    /// What this metric lacks to be computed at all.
    fn missing(self) -> Option<&'static str> {
        match self {
            Self::Flip if cfg!(not(feature = "flip")) => {
                Some("this uvgraft was built without FLIP (cargo feature `flip`)")
            }
            Self::LpipsAlex | Self::LpipsVgg => Some("this uvgraft was built without LPIPS"),
            _ => None,
        }
    }

    /// Compares two textures in each of the regions.
    fn scores(self, a: &Colors, b: &Colors, regions: &[Region]) -> Vec<Score> {
        type Measure = fn(&Colors, &Colors, Option<&Mask>) -> Result<f64, MetricError>;
        let unavailable =
            |reason: &str| regions.iter().map(|_| Score::Unavailable(reason.to_owned())).collect();
        if let Some(reason) = self.missing() {
            return unavailable(reason);
        }
        let measure: Measure = match self {
            Self::L1 => metrics::l1,
            Self::Psnr => metrics::psnr,
            Self::Ssim => metrics::ssim,
            Self::SsimUniform => metrics::ssim_uniform,
            Self::Ssimulacra2 => metrics::ssimulacra2,
            #[cfg(feature = "flip")]
            Self::Flip => metrics::flip,
            // A network looks at the whole textures once; its maps then answer for every region.
            _ => return unavailable("not part of this uvgraft"),
        };
        regions
            .iter()
            .map(|region| match measure(a, b, region.mask.as_ref()) {
                Ok(value) => Score::Value(value),
                Err(error) => Score::Unavailable(error.to_string()),
            })
            .collect()
    }
}

impl Serialize for Metric {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// The metrics that were chosen, each once, in the order of [`Metric::ALL`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Selection(Vec<Metric>);

impl Default for Selection {
    /// All that are there and quick.
    fn default() -> Self {
        Self::of(Metric::is_default)
    }
}

impl Selection {
    fn of(chosen: impl Fn(Metric) -> bool) -> Self {
        Self(Metric::ALL.into_iter().filter(|metric| chosen(*metric)).collect())
    }

    /// From a list of names with commas, or `all`.
    pub(crate) fn parse(list: &str) -> Result<Self, String> {
        let names: Vec<&str> = list.split(',').map(str::trim).collect();
        for name in &names {
            if *name != "all" && Metric::ALL.iter().all(|metric| metric.name() != *name) {
                let known = Metric::ALL.map(Metric::name).join(", ");
                return Err(format!("`{name}` is no metric; wanted some of {known}, or all"));
            }
        }
        let all = names.contains(&"all");
        Ok(Self::of(|metric| all || names.contains(&metric.name())))
    }
}

/// A part of the textures.
pub(crate) struct Region {
    /// What to call it.
    pub(crate) name: String,
    /// Its texels; `None` for all.
    pub(crate) mask: Option<Mask>,
}

/// How a metric answered.
#[derive(Debug, Clone, PartialEq)]
enum Score {
    Value(f64),
    /// Why there is no value.
    Unavailable(String),
}

impl Serialize for Score {
    /// A number, `"inf"` where JSON has no number for it, or an object with the reason.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Value(value) if value.is_infinite() => serializer.serialize_str("inf"),
            Self::Value(value) => serializer.serialize_f64(*value),
            Self::Unavailable(reason) => serializer.collect_map([("unavailable", reason)]),
        }
    }
}

/// Scores of two textures, region by region.
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
    /// Compares two textures; all masks must have their size.
    pub(crate) fn new(a: &Colors, b: &Colors, regions: &[Region], selection: &Selection) -> Self {
        let mut all: Vec<RegionScores> = regions
            .iter()
            .map(|Region { name, mask }| RegionScores {
                region: name.clone(),
                texels: mask.as_ref().map_or(a.size().texels(), Mask::count),
                scores: Vec::new(),
            })
            .collect();
        for &metric in &selection.0 {
            for (region, score) in all.iter_mut().zip(metric.scores(a, b, regions)) {
                region.scores.push((metric, score));
            }
        }
        Self { regions: all }
    }

    /// A table in Markdown, aligned for reading as it is: a row a metric, a column a region, and
    /// below it why values are missing.
    pub(crate) fn table(&self) -> String {
        let mut rows = vec![vec!["metric".to_owned(), "better".to_owned()]];
        rows[0].extend(self.regions.iter().map(|region| region.region.replace('|', "\\|")));
        let mut notes: Vec<String> = Vec::new();
        let metrics = self.regions.first().map_or(&[][..], |region| &region.scores);
        for (index, (metric, _)) in metrics.iter().enumerate() {
            let arrow = if metric.higher_is_better() { "↑" } else { "↓" };
            let mut row = vec![metric.title().to_owned(), arrow.to_owned()];
            for region in &self.regions {
                row.push(match &region.scores[index].1 {
                    Score::Value(value) => format!("{value:.*}", metric.decimals()),
                    Score::Unavailable(reason) => {
                        // Some reasons begin with the metric anyway.
                        let note = match reason.starts_with(metric.title()) {
                            true => reason.clone(),
                            false => format!("{}: {reason}", metric.title()),
                        };
                        if !notes.contains(&note) {
                            notes.push(note);
                        }
                        "–".to_owned()
                    }
                });
            }
            rows.push(row);
        }
        let mut text = aligned(&rows);
        if !notes.is_empty() {
            let _ = writeln!(text, "\n{}", notes.join("\n"));
        }
        text
    }
}

/// A Markdown table whose first row is its head: the first column to the left, the second in the
/// middle, numbers to the right.
fn aligned(rows: &[Vec<String>]) -> String {
    let columns = rows.first().map_or(0, Vec::len);
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max();
    let widths: Vec<usize> = (0..columns).map(|k| width(k).unwrap_or(0).max(3)).collect();
    let mut text = String::new();
    for (index, row) in rows.iter().enumerate() {
        for ((k, cell), width) in row.iter().enumerate().zip(&widths) {
            let _ = match k {
                0 => write!(text, "| {cell:<width$} "),
                1 => write!(text, "| {cell:^width$} "),
                _ => write!(text, "| {cell:>width$} "),
            };
        }
        text.push_str("|\n");
        if index == 0 {
            for (k, width) in widths.iter().enumerate() {
                let _ = match k {
                    0 => write!(text, "|:{}-", "-".repeat(*width)),
                    1 => write!(text, "|:{}:", "-".repeat(*width)),
                    _ => write!(text, "|-{}:", "-".repeat(*width)),
                };
            }
            text.push_str("|\n");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn selections() {
        let parse = |list: &str| Selection::parse(list).unwrap().0;
        assert_eq!(parse("psnr,l1, psnr"), [Metric::L1, Metric::Psnr]);
        assert_eq!(parse("all"), Metric::ALL);
        for bad in ["", "l1,", "lpips", "L1", "l1;psnr"] {
            assert!(Selection::parse(bad).is_err(), "{bad}");
        }
        assert!(!Selection::default().0.contains(&Metric::LpipsVgg));
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
            region("whole picture", 12, f64::INFINITY, "the moon is full"),
            region("a", 5, 31.237, "the moon is full"),
        ];
        let scores = Scores { regions };
        let wanted = "\
| metric    | better | whole picture |     a |
|:----------|:------:|--------------:|------:|
| PSNR (dB) |   ↑    |           inf | 31.24 |
| L1        |   ↓    |             – |     – |

L1: the moon is full
";
        assert_eq!(scores.table(), wanted);
        let wanted = r#"[{"region":"whole picture","texels":12,"scores":{"psnr":"inf","l1":{"unavailable":"the moon is full"}}},{"region":"a","texels":5,"scores":{"psnr":31.237,"l1":{"unavailable":"the moon is full"}}}]"#;
        assert_eq!(serde_json::to_string(&scores).unwrap(), wanted);
    }
}
