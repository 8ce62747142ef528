//! The region whose rim is measured.

use uvgraft::blend::CutMesh;
use uvgraft::{Blend, BlendOptions, Ground};
use uvgraft_pipeline::Unit;

use crate::failure::bad_input;

/// A part of a layout.
pub(super) struct Region {
    /// What it is, for people.
    pub name: &'static str,
    /// The mesh of the layout, cut along the region's rim, and which triangles are in the region.
    pub cut: CutMesh,
}

/// What options select of what transfers reach.
pub(super) fn of(
    wanted: &uvgraft_pipeline::Region,
    ground: &Ground,
    unit: Unit,
) -> anyhow::Result<Region> {
    let selection = wanted.select(ground, unit)?;
    let blend = Blend::new(&selection, BlendOptions::default()).map_err(bad_input)?;
    let name = if wanted.is_everything() { "the linked triangles" } else { "the selected part" };
    Ok(Region { name, cut: blend.cut()? })
}
