//! `uvgraft layouts`: the publicly known meshes and layouts.

use std::fmt::Write as _;
use std::process::ExitCode;

use serde::Serialize;
use uvgraft::known::{KnownMesh, MESHES};

use crate::outcome;
use crate::report::grouped;
use crate::table::{Align, table};

/// List the publicly known meshes and UV layouts that are recognised by name
///
/// `uvgraft inspect mesh` and `uvgraft pair` recognise them by connectivity, where a fingerprint is
/// known, or else by their counts. None of the meshes is part of uvgraft: the list says where they
/// are published and under which licences.
#[derive(clap::Args)]
pub(crate) struct Args {}

#[derive(Serialize)]
struct Document {
    meshes: &'static [KnownMesh],
}

pub(crate) fn run(_: &Args) -> anyhow::Result<ExitCode> {
    outcome::report(|| Document { meshes: MESHES }, text)?;
    Ok(ExitCode::SUCCESS)
}

fn text() -> String {
    let header = ["mesh or layout", "vertices", "UV coordinates", "triangles", "recognised by"];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    rows.extend(MESHES.iter().flat_map(rows_of));
    let mut text =
        table(&rows, &[Align::Left, Align::Right, Align::Right, Align::Right, Align::Left]);
    for mesh in MESHES {
        let _ = writeln!(text, "\n{}: {}", mesh.name, mesh.what);
        for layout in mesh.layouts.iter().filter(|layout| !layout.note.is_empty()) {
            let _ = writeln!(text, "  layout   {}: {}", layout.name, layout.note);
        }
        let _ = writeln!(text, "  source   {}", mesh.source);
        let _ = writeln!(text, "  licence  {}", mesh.licence);
        let _ = writeln!(text, "  counts   {}", mesh.counts_from);
    }
    text
}

/// A row for each edition and each layout of a mesh.
fn rows_of(mesh: &KnownMesh) -> Vec<Vec<String>> {
    let count = |count: Option<usize>| count.map_or_else(String::new, grouped);
    let certainty = |is_known: bool| if is_known { "connectivity" } else { "counts" }.to_owned();
    let editions = mesh.editions.iter().map(|edition| {
        vec![
            mesh.title(edition),
            grouped(edition.vertices),
            String::new(),
            count(edition.triangles),
            certainty(edition.fingerprint.is_some()),
        ]
    });
    let layouts = mesh.layouts.iter().map(|layout| {
        vec![
            format!("  layout {}", layout.name),
            String::new(),
            grouped(layout.uv_coordinates),
            count(layout.triangles),
            certainty(layout.fingerprint.is_some()),
        ]
    });
    editions.chain(layouts).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_fits_a_terminal() {
        for line in text().lines() {
            assert!(line.chars().count() <= 100, "{line}");
        }
    }
}
