//! Reports on seams.

use std::fmt::Write as _;

use serde::Serialize;
use uvgraft::Size;
use uvgraft_metrics::seams::{EdgeGroup, Offset, SeamEdge, SeamNotes, SeamReport, Step, ToneMatch};

use super::tone;
use super::verdict::Verdict;
use crate::report::grouped;
use crate::table::{Align, table};
use crate::{outcome, terminal};

/// The measurement.
pub(super) struct Subject {
    pub texture: String,
    pub mesh: String,
    pub region: String,
    pub size: Size,
    pub offset: Offset,
}

impl Subject {
    /// The sampling distance from the edge, as text.
    pub fn offset(&self) -> String {
        match self.offset {
            Offset::Texels(1.0) => "1 texel".to_owned(),
            Offset::Texels(texels) => format!("{texels} texels"),
            Offset::Distance(distance) => format!("{distance} of the mesh's unit"),
        }
    }
}

/// The name of an edge's kind.
pub(super) fn kind(edge: &SeamEdge) -> &'static str {
    match (edge.is_uv_seam, edge.is_rim) {
        (true, true) => "boundary seam",
        (true, false) => "UV seam",
        (false, _) => "boundary",
    }
}

/// The edges with the largest mean steps in descending order, and the largest step of each.
pub(super) fn worst(seams: &SeamReport) -> impl Iterator<Item = (&SeamEdge, Step)> {
    seams.worst.iter().filter_map(|&index| {
        let edge = seams.edges.get(index)?;
        Some((edge, edge.worst?))
    })
}

pub(super) fn print(
    subject: &Subject,
    seams: &SeamReport,
    tone: Option<&ToneMatch>,
) -> anyhow::Result<()> {
    outcome::report(|| Document::new(subject, seams, tone), || text(subject, seams, tone))
}

#[derive(Serialize)]
struct Document<'a> {
    texture: &'a str,
    mesh: &'a str,
    size: Size,
    /// The region whose border was measured.
    region: &'a str,
    /// `{"texels": number}` or `{"distance": number}`.
    offset: serde_json::Value,
    edges: Groups,
    /// The edges with the largest means, apart from each other.
    worst: Vec<WorstEdge>,
    /// Counts of edges, triangles and points that could not be measured as intended.
    notes: SeamNotes,
    /// Null if the mesh has no head.
    tone: Option<tone::Document>,
    verdict: Verdict,
}

#[derive(Serialize)]
struct Groups {
    uv_seams: EdgeGroup,
    uv_seams_inside: EdgeGroup,
    rim: EdgeGroup,
    beside_uv_seams: EdgeGroup,
    beside_uv_seams_inside: EdgeGroup,
    beside_rim: EdgeGroup,
    ordinary: EdgeGroup,
}

/// A bad edge, and its largest step. Pairs hold both sides, the region's first.
#[derive(Serialize)]
struct WorstEdge {
    /// Mean of the steps along the edge.
    edge_mean: f64,
    /// The largest step.
    delta_e: f64,
    /// The edge's length on the surface.
    edge_length: f64,
    is_uv_seam: bool,
    is_rim: bool,
    faces: [u32; 2],
    /// The end points of the edge on the surface.
    ends: [[f32; 3]; 2],
    /// Position of the largest step along the edge: 0 at its first end, 1 at its second.
    along: f64,
    /// The same position in the texture.
    uv: [[f64; 2]; 2],
    /// The sampling positions.
    sampled_uv: [[f64; 2]; 2],
    /// sRGB, 1.0 for full.
    colors: [[f32; 3]; 2],
}

impl<'a> Document<'a> {
    fn new(subject: &'a Subject, seams: &SeamReport, tone: Option<&ToneMatch>) -> Self {
        let place = |(edge, step): (&SeamEdge, Step)| WorstEdge {
            edge_mean: edge.mean.unwrap_or(step.delta_e),
            delta_e: step.delta_e,
            edge_length: edge.length,
            is_uv_seam: edge.is_uv_seam,
            is_rim: edge.is_rim,
            faces: edge.sides.map(|side| side.face),
            ends: edge.ends,
            along: step.along,
            uv: step.uv,
            sampled_uv: step.sampled,
            colors: step.colors,
        };
        Self {
            texture: &subject.texture,
            mesh: &subject.mesh,
            size: subject.size,
            region: &subject.region,
            offset: match subject.offset {
                Offset::Texels(texels) => serde_json::json!({ "texels": texels }),
                Offset::Distance(distance) => serde_json::json!({ "distance": distance }),
            },
            edges: Groups {
                uv_seams: seams.uv_seams,
                uv_seams_inside: seams.uv_seams_inside,
                rim: seams.rim,
                beside_uv_seams: seams.beside_uv_seams,
                beside_uv_seams_inside: seams.beside_uv_seams_inside,
                beside_rim: seams.beside_rim,
                ordinary: seams.ordinary,
            },
            worst: worst(seams).map(place).collect(),
            notes: seams.notes,
            tone: tone.map(tone::Document::new),
            verdict: Verdict::new(seams, tone),
        }
    }
}

fn text(subject: &Subject, seams: &SeamReport, tone: Option<&ToneMatch>) -> String {
    let mut text = format!(
        "{}, {} texels, on {}; the region is {}\n\
         colour differences (CIEDE2000) across edges, sampled {} from the edge on either side\n\n",
        terminal::inline(&subject.texture),
        subject.size,
        terminal::inline(&subject.mesh),
        subject.region,
        subject.offset(),
    );
    text += &groups(seams);
    text += "\nAdjacent edges share a vertex with those above them; differences there are the texture's\n\
             own detail. A difference of about 1 is barely visible, one of about 2.3 at a glance.\n";
    let places = places(subject, seams);
    if !places.is_empty() {
        let _ = write!(
            text,
            "\nThe worst edges, and the position of their largest difference in texels:\n\n{places}"
        );
    }
    let notes = notes(&seams.notes);
    if !notes.is_empty() {
        let _ = write!(text, "\n{notes}");
    }
    if let Some(tone) = tone {
        text += &tone_lines(tone);
    }
    text + "\n" + &Verdict::new(seams, tone).text()
}

fn tone_lines(tone: &ToneMatch) -> String {
    let lines = tone::lines(tone);
    if lines.is_empty() {
        return String::new();
    }
    let mut text = format!("\ntone: {}\n", lines.join("\n"));
    if let Some(verdict) = tone::verdict(tone) {
        text += &verdict;
        text.push('\n');
    }
    text
}

fn groups(seams: &SeamReport) -> String {
    let head = ["edges", "count", "length", "mean", "median", "95 %", "99 %", "largest"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for (name, group) in [
        ("UV seams", &seams.uv_seams),
        ("adjacent edges", &seams.beside_uv_seams),
        ("UV seams in the region", &seams.uv_seams_inside),
        ("adjacent edges", &seams.beside_uv_seams_inside),
        ("boundary of the region", &seams.rim),
        ("adjacent edges", &seams.beside_rim),
        ("all ordinary edges", &seams.ordinary),
    ] {
        let mut row = vec![name.to_owned(), grouped(group.edges), length(group.length)];
        match &group.delta_e {
            Some(steps) => row.extend(
                [steps.mean, steps.median, steps.p95, steps.p99, steps.max]
                    .map(|step| format!("{step:.2}")),
            ),
            None => row.extend(["–"; 5].map(str::to_owned)),
        }
        rows.push(row);
    }
    table(&rows, &[Align::Left])
}

/// A length in an unknown unit, with about four significant digits.
fn length(length: f64) -> String {
    let decimals = match length {
        l if l >= 1000.0 || l == 0.0 => 0,
        l if l >= 100.0 => 1,
        l if l >= 10.0 => 2,
        l if l >= 1.0 => 3,
        _ => 4,
    };
    format!("{length:.decimals$}")
}

fn places(subject: &Subject, seams: &SeamReport) -> String {
    let head = ["", "mean", "largest", "what", "triangles", "one side", "other side"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for (index, (edge, step)) in worst(seams).enumerate() {
        let [a, b] = edge.sides.map(|side| side.face);
        let [here, there] = step.uv.map(|uv| {
            let [x, y] = texel(uv, subject.size);
            format!("{x:.1}, {y:.1}")
        });
        rows.push(vec![
            (index + 1).to_string(),
            format!("{:.2}", edge.mean.unwrap_or(step.delta_e)),
            format!("{:.2}", step.delta_e),
            kind(edge).to_owned(),
            format!("{a}, {b}"),
            here,
            there,
        ]);
    }
    if rows.len() == 1 {
        return String::new();
    }
    table(&rows, &[Align::Right, Align::Right, Align::Right, Align::Left])
}

/// Converts a position in the unit square to texels.
pub(super) fn texel([u, v]: [f64; 2], size: Size) -> [f64; 2] {
    [u * f64::from(size.width), v * f64::from(size.height)]
}

fn notes(notes: &SeamNotes) -> String {
    let SeamNotes {
        single_edges,
        collapsed_triangles,
        no_area,
        clear,
        not_finite,
        shortened,
        outside,
    } = *notes;
    let mut text = String::new();
    for (count, what) in [
        (no_area, "points skipped: a triangle has no area"),
        (clear, "points skipped: one side is transparent"),
        (not_finite, "points skipped: a colour is NaN or infinite"),
        (
            shortened,
            "points measured closer to the edge, because their surface or island ends there",
        ),
        (outside, "points outside the texture, where its edge texels were sampled"),
        (collapsed_triangles, "triangles skipped: two corners coincide"),
        (single_edges, "open mesh edges skipped"),
    ] {
        if count > 0 {
            let _ = writeln!(text, "{} {what}", grouped(count));
        }
    }
    text
}
