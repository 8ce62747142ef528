//! The region whose rim is measured.

use uvgraft::blend::{CutMesh, Ground};
use uvgraft::{Blend, BlendOptions};

use crate::failure::bad_input;
use crate::length::Unit;
use crate::region::RegionArgs;

/// A part of a layout.
pub(super) struct Region {
    /// What it is, for people.
    pub name: &'static str,
    /// The mesh of the layout, cut along the region's rim, and which triangles are in the region.
    pub cut: CutMesh,
}

/// What options select of what transfers reach.
pub(super) fn of(args: &RegionArgs, ground: &Ground<'_>, unit: Unit) -> anyhow::Result<Region> {
    let selection = args.select(ground, unit)?;
    let blend = Blend::new(ground, &selection, BlendOptions::default()).map_err(bad_input)?;
    let name = if args.is_everything() { "the linked triangles" } else { "the selected part" };
    Ok(Region { name, cut: blend.cut()? })
}
