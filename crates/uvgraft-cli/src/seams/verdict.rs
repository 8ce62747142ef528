//! Whether seams can be seen, in words.

use serde::Serialize;
use uvgraft_metrics::seams::{EdgeGroup, SeamReport, StepStatistics, ToneMatch};

/// A difference in CIEDE2000 that is barely seen, and one that is seen at a glance (Mahy, Van Eycken and
/// Oosterlinck 1994 found 2.3 in CIELAB). They are held against how much more edges differ than those beside
/// them: faces pasted on real bodies exceed them by 25 to 31, membranes by 0.1.
const BARELY: f64 = 1.0;
const AT_A_GLANCE: f64 = 2.3;

/// How well edges can be seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Visibility {
    /// Not more than the texture's own detail.
    Hidden,
    /// By those who look for it.
    Faint,
    /// Along a twentieth of its length or more, but not most of it.
    InPlaces,
    Visible,
}

impl Visibility {
    /// - `edges`: of a seam.
    /// - `beside`: next to it, where the texture's own detail is the only difference.
    fn of(edges: &StepStatistics, beside: &StepStatistics) -> Self {
        match edges.median - beside.median {
            more if more > AT_A_GLANCE => Self::Visible,
            _ if edges.p95 - beside.p95 > AT_A_GLANCE => Self::InPlaces,
            more if more > BARELY => Self::Faint,
            _ => Self::Hidden,
        }
    }

    const fn words(self) -> &'static str {
        match self {
            Self::Hidden => "hidden",
            Self::InPlaces => "visible in places",
            Self::Faint => "faint",
            Self::Visible => "plainly visible",
        }
    }
}

/// A verdict on each of what can give a transfer away; `None` for what there is not, or is not known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Verdict {
    /// The boundary of the region.
    boundary: Option<Visibility>,
    /// UV seams in the region.
    uv_seams: Option<Visibility>,
    /// Whether the face has the body's tone.
    tone: Option<bool>,
    #[serde(skip)]
    has_head: bool,
    #[serde(skip)]
    figures: [Option<[StepStatistics; 2]>; 2],
}

impl Verdict {
    pub(super) fn new(seams: &SeamReport, tone: Option<&ToneMatch>) -> Self {
        let both = |edges: &EdgeGroup, beside: &EdgeGroup| Some([edges.delta_e?, beside.delta_e?]);
        let figures = [
            both(&seams.rim, &seams.beside_rim),
            both(&seams.uv_seams_inside, &seams.beside_uv_seams_inside),
        ];
        let visibility = |both: &Option<[StepStatistics; 2]>| {
            both.as_ref().map(|[edges, beside]| Visibility::of(edges, beside))
        };
        let [boundary, uv_seams] = figures.each_ref().map(visibility);
        let has_head = tone.is_some();
        let tone = tone.and_then(|tone| {
            let is_known = tone.excess().is_some() || tone.is_clipped();
            is_known.then(|| tone.matches_body() && !tone.is_clipped())
        });
        Self { boundary, uv_seams, tone, has_head, figures }
    }

    /// The lines of a report.
    pub(super) fn text(&self) -> String {
        let mut text = String::from("verdict\n");
        let names = ["boundary of the region", "UV seams in the region"];
        for ((name, visibility), figures) in
            names.into_iter().zip([self.boundary, self.uv_seams]).zip(self.figures)
        {
            let words = match visibility.zip(figures) {
                Some((visibility, [edges, beside])) => {
                    let words = visibility.words();
                    let [what, edges, beside] = match visibility {
                        Visibility::InPlaces => ["95 %", &two(edges.p95), &two(beside.p95)],
                        _ => ["median", &two(edges.median), &two(beside.median)],
                    };
                    format!("{words} ({what} {edges}, adjacent edges {beside})")
                }
                None => "none measured".to_owned(),
            };
            text += &format!("  {name:<24} {words}\n");
        }
        if !self.has_head {
            return text;
        }
        let tone = match self.tone {
            Some(true) => "matches the body's",
            Some(false) => "does not match the body's",
            None => "not known: compare with the body's texture by --onto",
        };
        text + &format!("  {:<24} {tone}\n", "tone of the face")
    }
}

fn two(value: f64) -> String {
    format!("{value:.2}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(median: f64, p95: f64) -> StepStatistics {
        StepStatistics { mean: median, median, p95, p99: p95, max: p95 }
    }

    #[test]
    fn edges_are_seen_by_what_they_differ_more_than_those_beside_them() {
        let beside = steps(0.4, 1.1);
        for (edges, wanted) in [
            (steps(0.5, 1.2), Visibility::Hidden),
            (steps(0.5, 3.5), Visibility::InPlaces),
            (steps(1.6, 2.5), Visibility::Faint),
            (steps(1.6, 3.5), Visibility::InPlaces),
            (steps(25.6, 26.7), Visibility::Visible),
        ] {
            assert_eq!(Visibility::of(&edges, &beside), wanted);
        }
        // Detail hides a seam.
        assert_eq!(Visibility::of(&steps(4.0, 9.0), &steps(3.5, 8.0)), Visibility::Hidden);
    }

    #[test]
    fn all_that_can_give_a_transfer_away_is_named() {
        let verdict = Verdict {
            boundary: Some(Visibility::InPlaces),
            uv_seams: None,
            tone: Some(false),
            has_head: true,
            figures: [Some([steps(0.5, 3.5), steps(0.4, 1.1)]), None],
        };
        assert_eq!(
            verdict.text(),
            "verdict\n  \
             boundary of the region   visible in places (95 % 3.50, adjacent edges 1.10)\n  \
             UV seams in the region   none measured\n  \
             tone of the face         does not match the body's\n"
        );
        let without_head = Verdict { has_head: false, tone: None, ..verdict };
        assert!(!without_head.text().contains("tone"));
    }
}
