//! Reports on pairs.

use std::fmt::Write as _;

use serde::Serialize;
use uvgraft::correspond::surface::SurfaceReport;
use uvgraft::correspond::table::{TableReport, TableRows};
use uvgraft::mesh::TileFaces;
use uvgraft::report::{LayoutReport, Percentiles};
use uvgraft::{PairReport, Recognition, Size, Tile, correspond};
use uvgraft_io::pair_file::{PairFile, layout_fingerprint};

use uvgraft_assembly::recognition;
pub(crate) use uvgraft_assembly::report::grouped;

use crate::outcome;
use crate::terminal;

/// Texture sizes that a report's texel counts and densities are for.
#[derive(clap::Args)]
pub(crate) struct Sizes {
    /// Texture size assumed for the source layout in the report
    #[arg(long, default_value = "2048", value_name = "N|WxH", value_parser = parse_size, allow_negative_numbers = true)]
    source_size: Size,
    /// Texture size assumed for the target layout in the report
    #[arg(long, default_value = "4096", value_name = "N|WxH", value_parser = parse_size, allow_negative_numbers = true)]
    target_size: Size,
}

impl Sizes {
    fn texels(&self) -> uvgraft::Sizes {
        uvgraft::Sizes { from: self.source_size, to: self.target_size }
    }
}

/// Parses `N` or `WxH` within the limits of textures.
pub(crate) fn parse_size(text: &str) -> Result<Size, String> {
    let side = |text: &str| match text.parse::<u32>() {
        Ok(side) if (1..=uvgraft::Texture::MAX_SIDE).contains(&side) => Ok(side),
        _ => Err(format!("must be N or WxH with sides from 1 to {}", uvgraft::Texture::MAX_SIDE)),
    };
    match text.split_once(['x', 'X', '×']) {
        Some((width, height)) => Ok(Size::new(side(width)?, side(height)?)),
        None => side(text).map(Size::square),
    }
}

#[derive(Serialize)]
struct Document<'a> {
    source_name: &'a str,
    target_name: &'a str,
    source_fingerprint: String,
    target_fingerprint: String,
    source_recognition: &'a Recognition,
    target_recognition: &'a Recognition,
    note: &'a str,
    #[serde(flatten)]
    linked: Option<&'a Linked>,
    #[serde(flatten)]
    report: &'a PairReport,
}

/// How two meshes were linked.
#[derive(Debug, Serialize)]
pub(crate) struct Linked {
    /// The method, with what it reports.
    pub(crate) linked_by: Method,
    /// Why the methods before it did not link the meshes.
    pub(crate) not_linked_by: Vec<String>,
}

/// A way to link two meshes.
#[derive(Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Method {
    /// The target vertex of each source vertex was given.
    VertexMap,
    /// A table of where the vertices of one mesh lie on the other was given.
    Table(LinkedTable),
    /// It was found by the meshes alone.
    #[serde(untagged)]
    Found(correspond::Method),
}

/// A table by which meshes were linked.
#[derive(Debug, Serialize)]
pub(crate) struct LinkedTable {
    #[serde(flatten)]
    pub(crate) report: TableReport,
    /// Rows with weights that are not those of a point on a face.
    pub(crate) unusable: usize,
}

impl LinkedTable {
    fn text(&self) -> String {
        let TableReport { rows, vertices, points, faces_without_points, .. } = self.report;
        let (mesh, other) = match rows {
            TableRows::Source => ("source", "target"),
            TableRows::Target => ("target", "source"),
        };
        let places = if self.report.is_vertex_map { "vertices" } else { "points" };
        let mut text = format!(
            "the table: {} of the {mesh}'s {} vertices at {places} of the {other}; {:.1} % of the \
             {mesh}'s area",
            grouped(points),
            grouped(vertices),
            100.0 * self.report.covered,
        );
        if self.unusable > 0 {
            let _ = write!(text, "; {} rows are not points on a face", grouped(self.unusable));
        }
        if faces_without_points > 0 {
            let faces = recognition::triangles(faces_without_points);
            let _ = write!(text, "; {faces} not linked because corners have no row");
        }
        text
    }
}

impl Linked {
    /// What registration found, if the meshes were linked by it.
    pub(crate) fn registered(&self) -> Option<&SurfaceReport> {
        match &self.linked_by {
            Method::Found(found) => found.registered(),
            _ => None,
        }
    }

    /// What a reader of the report wants to know, in a few lines.
    fn text(&self) -> String {
        let how = match &self.linked_by {
            Method::VertexMap => "the vertex map".to_owned(),
            Method::Table(table) => table.text(),
            Method::Found(found) => found_by(found),
        };
        let mut text = format!("linked by {how}\n");
        for reason in &self.not_linked_by {
            let _ = writeln!(text, "  not by {reason}");
        }
        text
    }
}

fn found_by(method: &correspond::Method) -> String {
    use correspond::faces::SameFaces;
    match method {
        correspond::Method::Faces(SameFaces::Vertices) => {
            "the same faces: they have the same vertex indices".to_owned()
        }
        correspond::Method::Faces(SameFaces::Order) => {
            "the same faces: they come in the same order".to_owned()
        }
        correspond::Method::Topology(report) => {
            let mut text = format!(
                "connectivity: {} of {} polygons of the smaller mesh are connected alike",
                grouped(report.matched),
                grouped(report.of)
            );
            if report.is_mirrored {
                text += ", with opposite winding";
            }
            if report.with_added_centre > 0 {
                let centres = grouped(report.with_added_centre);
                let _ = write!(text, "; {centres} have an added centre vertex in one mesh");
            }
            if report.components_left_out > 0 {
                let _ = write!(text, "; {} components left out", report.components_left_out);
            }
            text
        }
        correspond::Method::Surface(report) => {
            let mut text = format!(
                "surfaces, aligned by {}: {:.1} % of the target's area; median distance {}, 95th \
                 percentile {} (in the source's unit); {} triangles turned over and left out",
                report.aligned_by,
                100.0 * report.covered,
                significant(report.distance_median),
                significant(report.distance_p95),
                grouped(report.flipped),
            );
            if report.worn > 0 {
                let worn = grouped(report.worn);
                let _ = write!(text, "; {worn} over the skin (hair, glasses, clothes) left out");
            }
            text
        }
        _ => "another method".to_owned(),
    }
}

/// A length of unknown unit with three digits that count.
fn significant(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = (2.0 - value.abs().log10().floor()).clamp(0.0, 12.0);
    format!("{value:.*}", digits as usize)
}

/// The report of a pair for textures of some sizes.
pub(crate) fn of_pair(file: &PairFile, sizes: &Sizes) -> PairReport {
    PairReport::new(&file.pair, sizes.texels())
}

/// Prints the report of a pair to standard output: as text, or as JSON.
///
/// - `linked`: how the meshes were linked, if they just were.
/// - `recognised`: what the source and the target are.
pub(crate) fn print(
    file: &PairFile,
    linked: Option<&Linked>,
    recognised: &[Recognition; 2],
    report: &PairReport,
) -> anyhow::Result<()> {
    let document = || Document {
        source_name: &file.source_name,
        target_name: &file.target_name,
        source_fingerprint: layout_fingerprint(file.pair.source()),
        target_fingerprint: layout_fingerprint(file.pair.target()),
        source_recognition: &recognised[0],
        target_recognition: &recognised[1],
        note: &file.note,
        linked,
        report,
    };
    outcome::report(document, || {
        let linked = linked.map_or_else(String::new, |linked| linked.text() + "\n");
        linked + &text(file, report, recognised)
    })
}

fn text(file: &PairFile, report: &PairReport, recognised: &[Recognition; 2]) -> String {
    let (source, target) = (&report.source, &report.target);
    let mut text = String::new();
    let mut row = |name: &str, source: String, target: String| {
        let _ = writeln!(text, "{name:<22} {source:>24} {target:>24}");
    };
    row(
        "",
        format!("source {}", short(&file.source_name)),
        format!("target {}", short(&file.target_name)),
    );
    let [source_names, target_names] = recognised.each_ref().map(recognition::short_names);
    for (k, name) in ["known mesh", "known layout"].into_iter().enumerate() {
        let [source, target] = [&source_names, &target_names].map(|names| names[k].as_deref());
        if source.or(target).is_some() {
            row(name, source.unwrap_or("").to_owned(), target.unwrap_or("").to_owned());
        }
    }
    let mut both = |name: &str, value: &dyn Fn(&LayoutReport) -> String| {
        row(name, value(source), value(target));
    };
    both("vertices", &|side| grouped(side.vertices));
    both("UV coordinates", &|side| grouped(side.uv_coordinates));
    both("triangles", &|side| grouped(side.faces));
    if source.polygons != source.faces || target.polygons != target.faces {
        both("polygons", &|side| grouped(side.polygons));
    }
    both("UV islands", &|side| grouped(side.islands));
    both("linked", &|side| {
        format!("{} ({})", grouped(side.linked), percent(side.linked, side.faces))
    });
    if source.linked_in_other_tiles + target.linked_in_other_tiles > 0 {
        both("linked in other tiles", &|side| grouped(side.linked_in_other_tiles));
    }
    both("not linked", &|side| grouped(side.faces - side.linked - side.linked_in_other_tiles));
    both("linked, zero UV area", &|side| grouped(side.degenerate));
    both("linked, mirrored", &|side| grouped(side.mirrored));
    if source.outside + target.outside > 0 {
        both("outside unit square", &|side| grouped(side.outside));
        both("across tile borders", &|side| grouped(side.in_no_tile));
        both("UV tiles", &tiles);
    }
    both("at texture size", &|side| side.size.to_string());
    both("texels covered", &|side| share(side.texels.covered, side.size));
    both("texels linked", &|side| share(side.texels.linked, side.size));
    both("texels overlapping", &|side| grouped(side.texels.overlapping));
    let _ = writeln!(
        text,
        "\n{} links; {} change winding, {} change handedness in UV space",
        grouped(report.links),
        grouped(report.opposite_windings),
        grouped(report.mirrored),
    );
    text += &densities(report);
    text += &streaks(report);
    if !file.note.is_empty() {
        let _ = writeln!(text, "\nnote: {}", terminal::inline(&file.note));
    }
    text
}

/// How densely each layout's texels lie in the other's, for linked triangles.
fn densities(report: &PairReport) -> String {
    let mut text = String::new();
    let _ = writeln!(text, "\nlinear texel density        min     5 %  median    95 %     max");
    for (name, density) in [
        ("target per source", report.forward_density),
        ("source per target", report.reverse_density),
    ] {
        if let Some(Percentiles { min, p5, median, p95, max }) = density {
            let _ = writeln!(
                text,
                "{name:<22} {min:>8.3} {p5:>7.3} {median:>7.3} {p95:>7.3} {max:>7.3}"
            );
        }
    }
    text
}

/// Warnings of linked triangles without area in the layout that is read: they have a single colour or
/// a streak of colours.
fn streaks(report: &PairReport) -> String {
    let mut text = String::new();
    for (side, layout, transfers) in
        [(&report.source, "source", "transfers"), (&report.target, "target", "reverse transfers")]
    {
        if side.degenerate > 0 {
            let count = grouped(side.degenerate);
            let _ = writeln!(
                text,
                "\n{count} linked triangles have no UV area in the {layout} layout and show as streaks \
                 in {transfers}"
            );
        }
    }
    text
}

/// The numbers of a layout's tiles, as many as fit a column.
fn tiles(side: &LayoutReport) -> String {
    const SHOWN: usize = 3;
    if side.tiles.is_empty() {
        return Tile::FIRST.to_string();
    }
    let name = |tile: &TileFaces| match tile.udim {
        Some(udim) => udim.to_string(),
        None => format!("{}:{}", tile.tile[0], tile.tile[1]),
    };
    let mut names: Vec<String> = side.tiles.iter().take(SHOWN).map(name).collect();
    if side.tiles.len() > SHOWN {
        names.push("…".to_owned());
    }
    names.join(", ")
}

fn share(texels: usize, size: Size) -> String {
    format!("{} ({})", grouped(texels), percent(texels, size.texels()))
}

fn percent(part: usize, whole: usize) -> String {
    format!("{:.1} %", 100.0 * part as f64 / whole.max(1) as f64)
}

/// A name shortened to fit a column.
fn short(name: &str) -> String {
    const LENGTH: usize = 17;
    let name = terminal::inline(name);
    if name.chars().count() <= LENGTH {
        return name.into_owned();
    }
    name.chars().take(LENGTH - 1).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_one_number_or_two() {
        assert_eq!(parse_size("512"), Ok(Size::square(512)));
        assert_eq!(parse_size("1000x1537"), Ok(Size::new(1000, 1537)));
        for bad in ["", "0", "x", "12x", "1x0", "-3", "40000", "3.5"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
    }
}
