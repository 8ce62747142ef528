//! Links by a table that somebody published.

use std::path::Path;

use uvgraft::correspond::surface::SurfaceOptions;
use uvgraft::correspond::table::{TableLinkError, TableReport, link as link_by_table};
use uvgraft::pair::OtherLayouts;
use uvgraft::{Mesh, Pair};
use uvgraft_io::correspondence_table::{self, FoundTable, vertex_tables};
use uvgraft_pipeline::{Blame, Context, Result};

/// A pair by a table, and how far the table went.
#[derive(Debug)]
pub struct TableLinks {
    /// The pair, in one layout on either side.
    pub pair: Pair,
    /// Parts that the pair does not have, since they have textures of their own.
    pub other_layouts: Vec<OtherLayouts>,
    /// What was linked.
    pub report: TableReport,
    /// Rows with weights that are not those of a point on a face.
    pub unusable: usize,
}

/// Links two meshes by the table in a file. Where its rows may be those of either mesh, the way that
/// links more of the mesh counts.
///
/// # Errors
/// For a file that cannot be read, and for a table of other meshes, as bad input.
pub fn link(
    path: &Path,
    source: &Mesh,
    target: &Mesh,
    options: &SurfaceOptions,
) -> Result<TableLinks> {
    let file = correspondence_table::read(path).or_input()?;
    let tables = vertex_tables(&file, source, target).or_input().context(path.display())?;
    let mut best: Option<TableLinks> = None;
    let mut refused: Option<TableLinkError> = None;
    for FoundTable { rows, table, unusable } in tables {
        let is_better = |report: &TableReport| {
            best.as_ref().is_none_or(|best| report.covered > best.report.covered)
        };
        match link_by_table(source.clone(), target.clone(), &table, rows, options) {
            Ok((pair, report)) if is_better(&report) => {
                let (pair, other_layouts) = pair.in_one_layout();
                best = Some(TableLinks { pair, other_layouts, report, unusable });
            }
            Ok(_) => {}
            Err(error) => refused = refused.or(Some(error)),
        }
    }
    best.ok_or(refused.unwrap_or(TableLinkError::Nothing)).or_input().context(path.display())
}
