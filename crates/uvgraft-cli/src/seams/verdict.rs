//! Whether seams can be seen, in words.

use std::collections::HashMap;

use serde::Serialize;
use uvgraft::mesh::bits_of;
use uvgraft_metrics::seams::{EdgeGroup, SeamEdge, SeamReport, StepStatistics, ToneMatch};

/// A difference in CIEDE2000 that is barely seen, and one that is seen at a glance (Mahy, Van Eycken and
/// Oosterlinck 1994 found 2.3 in CIELAB). They are held against how much more edges differ than those beside
/// them: faces pasted on real bodies exceed them by 25 to 31, membranes by 0.1.
const BARELY: f64 = 1.0;
const AT_A_GLANCE: f64 = 2.3;

/// The shortest line that is seen, as a share of the length of all edges of its kind: five blends of real faces with a
/// line at the nape or stained lids have 3 to 6 %, two without 0.9 and 1.8 %.
const MIN_LINE: f64 = 0.02;

/// How well edges can be seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Visibility {
    /// Not more than the texture's own detail.
    Hidden,
    /// By those who look for it.
    Faint,
    /// Some of it is a line.
    InPlaces,
    Visible,
}

/// What is known of edges of a kind.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Figures {
    edges: StepStatistics,
    /// Of the edges next to them, where the texture's own detail is the only difference.
    beside: StepStatistics,
    /// The longest connected line of edges that differ more than those beside them nearly ever do, as a share of the
    /// length of all.
    line: f64,
}

impl Figures {
    /// `None` if nothing was measured.
    fn new<'a>(
        group: &EdgeGroup,
        beside: &EdgeGroup,
        all: impl Iterator<Item = &'a SeamEdge>,
    ) -> Option<Self> {
        let (edges, beside) = (group.delta_e?, beside.delta_e?);
        let seen = |edge: &&SeamEdge| edge.mean.is_some_and(|it| it > beside.p95 + BARELY);
        let line = longest_line(all.filter(seen)) / group.length.max(f64::MIN_POSITIVE);
        Some(Self { edges, beside, line })
    }

    fn visibility(&self) -> Visibility {
        match self.edges.median - self.beside.median {
            more if more > AT_A_GLANCE => Visibility::Visible,
            _ if self.line >= MIN_LINE => Visibility::InPlaces,
            more if more > BARELY => Visibility::Faint,
            _ => Visibility::Hidden,
        }
    }

    fn words(&self) -> String {
        let Self { edges, beside, line } = self;
        let median = format!("(median {:.2}, adjacent edges {:.2})", edges.median, beside.median);
        match self.visibility() {
            Visibility::Hidden => format!("hidden {median}"),
            Visibility::Faint => format!("faint {median}"),
            Visibility::InPlaces => format!(
                "visible in places (a line of {:.0} % of its length is above {:.1})",
                line * 100.0,
                beside.p95 + BARELY
            ),
            Visibility::Visible => format!("plainly visible {median}"),
        }
    }
}

/// The length of the longest line of edges that are connected by their ends.
fn longest_line<'a>(edges: impl Iterator<Item = &'a SeamEdge>) -> f64 {
    let edges: Vec<&SeamEdge> = edges.collect();
    let mut lines: Vec<usize> = (0..edges.len()).collect();
    fn first(lines: &mut [usize], mut line: usize) -> usize {
        while lines[line] != line {
            lines[line] = lines[lines[line]];
            line = lines[line];
        }
        line
    }
    let mut at: HashMap<[u32; 3], usize> = HashMap::new();
    for (index, edge) in edges.iter().enumerate() {
        for end in edge.ends {
            let other = *at.entry(bits_of(end)).or_insert(index);
            let (a, b) = (first(&mut lines, index), first(&mut lines, other));
            lines[a.max(b)] = a.min(b);
        }
    }
    let mut lengths = vec![0.0; edges.len()];
    for (index, edge) in edges.iter().enumerate() {
        lengths[first(&mut lines, index)] += edge.length;
    }
    lengths.into_iter().fold(0.0, f64::max)
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
    figures: [Option<Figures>; 2],
}

impl Verdict {
    pub(super) fn new(seams: &SeamReport, tone: Option<&ToneMatch>) -> Self {
        let edges = || seams.edges.iter();
        // Of seams, those that are in the region or at its boundary: the first side is.
        let figures = [
            Figures::new(&seams.rim, &seams.beside_rim, edges().filter(|edge| edge.is_rim)),
            Figures::new(
                &seams.uv_seams_inside,
                &seams.beside_uv_seams_inside,
                edges().filter(|edge| edge.is_uv_seam && edge.is_inside),
            ),
        ];
        let [boundary, uv_seams] = figures.map(|it| it.as_ref().map(Figures::visibility));
        let has_head = tone.is_some();
        let tone = tone.and_then(|tone| {
            let is_known = tone.excess().is_some() || tone.is_clipped();
            is_known.then(|| tone.matches_body() && !tone.is_clipped())
        });
        Self { boundary, uv_seams, tone, has_head, figures }
    }

    /// The lines of a report.
    pub(super) fn text(&self) -> String {
        let mut text = String::from("verdict (whether the picture is right, only eyes can tell)\n");
        let names = ["boundary of the region", "UV seams in the region"];
        for (name, figures) in names.into_iter().zip(&self.figures) {
            let words = figures.as_ref().map_or_else(|| "none measured".to_owned(), Figures::words);
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

#[cfg(test)]
mod tests {
    use uvgraft_metrics::seams::SeamSide;

    use super::*;

    fn steps(median: f64, p95: f64) -> StepStatistics {
        StepStatistics { mean: median, median, p95, p99: p95, max: p95 }
    }

    /// An edge of length 1 along X.
    fn edge(x: f32, mean: f64) -> SeamEdge {
        let side = SeamSide { face: 0, corner: 0, uv: [[0.0; 2]; 2] };
        SeamEdge {
            sides: [side; 2],
            ends: [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0]],
            length: 1.0,
            is_uv_seam: true,
            is_rim: false,
            is_inside: true,
            mean: Some(mean),
            worst: None,
        }
    }

    #[test]
    fn edges_are_seen_by_what_they_differ_more_than_those_beside_them() {
        let beside = steps(0.4, 1.1);
        let visibility = |edges, line| Figures { edges, beside, line }.visibility();
        for (edges, line, wanted) in [
            (steps(0.5, 1.2), 0.0, Visibility::Hidden),
            // Places that no line connects.
            (steps(0.5, 3.5), 0.01, Visibility::Hidden),
            (steps(0.5, 3.5), 0.04, Visibility::InPlaces),
            (steps(1.6, 2.5), 0.0, Visibility::Faint),
            (steps(1.6, 3.5), 0.3, Visibility::InPlaces),
            (steps(25.6, 26.7), 1.0, Visibility::Visible),
        ] {
            assert_eq!(visibility(edges, line), wanted);
        }
    }

    #[test]
    fn a_line_is_what_its_ends_connect() {
        let edges = [edge(0.0, 5.0), edge(1.0, 5.0), edge(3.0, 5.0), edge(2.0, 1.0)];
        assert_eq!(longest_line(edges[..3].iter()), 2.0);
        assert_eq!(longest_line(edges.iter()), 4.0);
        assert_eq!(longest_line([].iter()), 0.0);
        // What differs no more than the edges beside it is no part of one.
        let delta_e = |median, p95| Some(steps(median, p95));
        let group = |delta_e| EdgeGroup { edges: 4, length: 4.0, points: 4, delta_e };
        let figures =
            Figures::new(&group(delta_e(2.0, 5.0)), &group(delta_e(0.5, 1.5)), edges.iter());
        assert_eq!(figures.unwrap().line, 0.5);
    }

    #[test]
    fn all_that_can_give_a_transfer_away_is_named() {
        let figures = Figures { edges: steps(0.5, 3.5), beside: steps(0.4, 1.1), line: 0.04 };
        let verdict = Verdict {
            boundary: Some(Visibility::InPlaces),
            uv_seams: None,
            tone: Some(false),
            has_head: true,
            figures: [Some(figures), None],
        };
        let text = verdict.text();
        assert!(text.ends_with(
            "  boundary of the region   visible in places (a line of 4 % of its length is above 2.1)\n  \
             UV seams in the region   none measured\n  \
             tone of the face         does not match the body's\n"
        ), "{text}");
        let without_head = Verdict { has_head: false, tone: None, ..verdict };
        assert!(!without_head.text().contains("tone of"));
    }
}
