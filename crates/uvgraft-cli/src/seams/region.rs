//! The region whose border is measured.

use uvgraft::blend::CutMesh;
use uvgraft::{Blend, BlendDomain, BlendOptions};
use uvgraft_pipeline::Unit;

use crate::failure::{Notes, bad_input};

/// A region of a layout.
pub(super) struct Region {
    /// Its name for reports.
    pub name: &'static str,
    /// The mesh of the layout, cut along the boundary of the region, and which triangles belong to
    /// it.
    pub cut: CutMesh,
}

/// The selection by options within the transferred area.
pub(super) fn of(
    wanted: &uvgraft_pipeline::Region,
    domain: &BlendDomain,
    unit: Unit,
) -> anyhow::Result<Region> {
    let selection = wanted.select(domain, unit, &Notes)?;
    let blend = Blend::new(&selection, BlendOptions::default()).map_err(bad_input)?;
    let name = if wanted.is_everything() { "the linked triangles" } else { "the selected part" };
    Ok(Region { name, cut: blend.cut()? })
}
