//! `uvgraft inspect mesh`: the contents of a mesh file and its layout.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use serde::Serialize;
use uvgraft::Choice;
use uvgraft::MeshPart;
use uvgraft::mesh::TileFaces;
use uvgraft::mesh_report::{MeshReport, OVERLAP_SIDE, Subject};
use uvgraft_pipeline::Outputs;

use super::{layout_picture, listed};
use crate::failure::note;
use crate::outcome;
use crate::report::grouped;
use crate::terminal;
use uvgraft_assembly::drawing::check_name;
use uvgraft_assembly::mesh_file::{self, LoadedMesh, MeshFile};
use uvgraft_assembly::recognition::{self, triangles};

/// Print the report of a mesh and its UV layout
///
/// Says what the mesh consists of, what may be wrong with it, and which publicly known mesh and
/// layout it is; see `uvgraft layouts`.
#[derive(clap::Args)]
pub(super) struct Args {
    /// Mesh to inspect: OBJ, PLY, GLB, glTF or a body model with UV coordinates
    ///
    /// `FILE#1`, `FILE#NAME` and `FILE#NAME/1` select a UV set and a part, as for `uvgraft pair`.
    #[arg(value_name = "MESH")]
    mesh: PathBuf,
    /// Draw the UV layout, each island in a colour of its own
    #[arg(long, value_name = "OUT.png")]
    preview: Option<PathBuf>,
}

pub(super) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    if let Some(preview) = &args.preview {
        check_name(preview, "a preview")?;
        Outputs::new(MeshFile::parse(&(&args.mesh).into()).file.path()).check(preview)?;
    }
    let loaded = mesh_file::read(&args.mesh)?;
    loaded.left_out().into_iter().for_each(note);
    let LoadedMesh { mesh, name, .. } = loaded;
    let report = MeshReport::new(&mesh);
    let parts = part_names(mesh.parts());
    if let Some(path) = &args.preview {
        layout_picture::write(&mesh, &report, &name, path)?;
        outcome::wrote(path);
    }
    outcome::report(|| Document { parts: &parts, report: &report }, || text(&report, &parts))?;
    Ok(ExitCode::SUCCESS)
}

#[derive(Serialize)]
struct Document<'a> {
    parts: &'a [String],
    #[serde(flatten)]
    report: &'a MeshReport,
}

/// The distinct names of parts, in order: object, group and material, as far as the file has them.
fn part_names(parts: &[MeshPart]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for part in parts {
        let given = [&part.object, &part.group, &part.material];
        let given: Vec<&str> =
            given.into_iter().map(String::as_str).filter(|name| !name.is_empty()).collect();
        let name = given.join(" / ");
        if !name.is_empty() && !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

fn text(report: &MeshReport, parts: &[String]) -> String {
    let mut text = String::new();
    let mut row = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<26} {value}");
    };
    let [mesh, layout] = recognition::names(&report.recognition);
    row("mesh", mesh);
    row("layout", layout);
    row("vertices", counted(report.vertices, report.unused_vertices, "unused"));
    row("UV coordinates", grouped(report.uv_coordinates));
    row("triangles", grouped(report.triangles));
    if report.polygons != report.triangles {
        row("polygons", grouped(report.polygons));
    }
    if !parts.is_empty() {
        let names: Vec<_> = parts.iter().map(|name| terminal::inline(name).into_owned()).collect();
        row("parts", listed(&names));
    }
    row("connected components", grouped(report.components));
    row(
        "open edges",
        match (report.open_edges, report.boundaries) {
            (0, _) => "0".to_owned(),
            (edges, 1) => format!("{}, along 1 boundary", grouped(edges)),
            (edges, boundaries) => {
                format!("{}, along {} boundaries", grouped(edges), grouped(boundaries))
            }
        },
    );
    row("non-manifold edges", grouped(report.non_manifold_edges));
    row("degenerate triangles", grouped(report.degenerate));
    row("UV islands", grouped(report.islands));
    row("UV tiles", tiles(&report.tiles));
    row("outside unit square", triangles(report.outside));
    row("zero UV area", triangles(report.degenerate_uv));
    row(
        "texels overlapping",
        format!("{} at {OVERLAP_SIDE}×{OVERLAP_SIDE}", grouped(report.overlapping_texels)),
    );
    row("size", size(report));
    row(
        "shows",
        match report.subject {
            Some(Subject::Head) => "a head".to_owned(),
            Some(Subject::Body) => "a body".to_owned(),
            None => "no head was found".to_owned(),
        },
    );
    row("mesh fingerprint", report.recognition.surface_fingerprint.to_string());
    row("layout fingerprint", report.recognition.layout_fingerprint.to_string());
    text
}

/// A count, with how many of them are something else, if any.
fn counted(count: usize, part: usize, what: &str) -> String {
    match part {
        0 => grouped(count),
        part => format!("{} ({} {what})", grouped(count), grouped(part)),
    }
}

/// The UV tiles, by UDIM number where they have one.
fn tiles(tiles: &[TileFaces]) -> String {
    let names: Vec<String> = tiles
        .iter()
        .map(|tile| match tile.udim {
            Some(udim) => format!("{udim} ({})", triangles(tile.faces)),
            None => {
                let [column, row] = tile.tile;
                format!("column {column}, row {row} ({})", triangles(tile.faces))
            }
        })
        .collect();
    listed(&names)
}

fn size(report: &MeshReport) -> String {
    let [low, high] = report.bounds;
    let [x, y, z] = [0, 1, 2].map(|k| significant(high[k] - low[k]));
    let units: Vec<&str> = report.units.iter().map(|unit| unit.name()).collect();
    let unit = if units.is_empty() {
        "unknown".to_owned()
    } else {
        format!("probably {}", units.join(" or "))
    };
    format!("{x} × {y} × {z} (x × y × z), unit {unit}")
}

/// A length with three significant digits, or more where they are in front of the point.
fn significant(length: f32) -> String {
    let digits = match length {
        length if !(1e-3..1e6).contains(&length) => return format!("{length:.2e}"),
        length if length >= 100.0 => 0,
        length if length >= 10.0 => 1,
        length if length >= 1.0 => 2,
        _ => 3,
    };
    format!("{length:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_readable() {
        for (length, wanted) in
            [(0.3136, "0.314"), (1.794, "1.79"), (17.0, "17.0"), (322.06, "322"), (0.0, "0.00e0")]
        {
            assert_eq!(significant(length), wanted);
        }
    }

    #[test]
    fn long_lists_end() {
        let names: Vec<String> = (0..30).map(|k| format!("part {k}")).collect();
        let text = listed(&names);
        assert!(text.starts_with("part 0, part 1, "), "{text}");
        assert!(text.ends_with(" more") && text.chars().count() < 80, "{text}");
        assert_eq!(listed(&names[..1]), "part 0");
    }

    #[test]
    fn parts_are_named_once() {
        let part = |object: &str, material: &str| MeshPart {
            object: object.to_owned(),
            material: material.to_owned(),
            polygons: 0..1,
            ..MeshPart::default()
        };
        let parts = [part("head", "skin"), part("eyes", ""), part("head", "skin"), part("", "")];
        assert_eq!(part_names(&parts), ["head / skin", "eyes"]);
    }
}
