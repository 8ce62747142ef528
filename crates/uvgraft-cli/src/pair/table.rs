//! Links by a table that somebody published.

use std::path::Path;

use anyhow::Context;
use uvgraft::Mesh;
use uvgraft::correspond::surface::SurfaceOptions;
use uvgraft::correspond::table::{TableLinkError, link as link_by_table};
use uvgraft_io::correspondence_table::{self, FoundTable, vertex_tables};

use super::correspondence::LinkedPair;
use crate::failure::OrBadInput;
use crate::report::{Linked, LinkedTable, Method};

/// Links two meshes by the table in a file. Where its rows may be those of either mesh, the way that
/// links more of the mesh counts.
pub(super) fn link(
    path: &Path,
    source: &Mesh,
    target: &Mesh,
    options: &SurfaceOptions,
) -> anyhow::Result<LinkedPair> {
    let file = correspondence_table::read(path).or_bad_input()?;
    let named = || path.display().to_string();
    let tables = vertex_tables(&file, source, target).with_context(named).or_bad_input()?;
    let mut best: Option<LinkedPair> = None;
    let mut best_covered = 0.0;
    let mut refused: Option<TableLinkError> = None;
    for FoundTable { rows, table, unusable } in tables {
        match link_by_table(source.clone(), target.clone(), &table, rows, options) {
            Ok((pair, report)) if best.is_none() || report.covered > best_covered => {
                best_covered = report.covered;
                let linked_by = Method::Table(LinkedTable { report, unusable });
                let linked = Linked { linked_by, not_linked_by: Vec::new() };
                let (pair, other_layouts) = pair.in_one_layout();
                best = Some(LinkedPair { pair, linked, other_layouts });
            }
            Ok(_) => {}
            Err(error) => refused = refused.or(Some(error)),
        }
    }
    let refused = refused.unwrap_or(TableLinkError::Nothing);
    best.ok_or(refused).with_context(named).or_bad_input()
}
