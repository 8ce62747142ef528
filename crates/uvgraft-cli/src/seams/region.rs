//! The region whose border is measured.

use uvgraft::blend::CutMesh;
use uvgraft::{Blend, BlendDomain, BlendOptions};
use uvgraft_pipeline::Unit;

use crate::failure::{Notes, bad_input};

/// A selection of the surface, with the mesh of its layout cut along its boundary.
pub(super) struct CutRegion {
    /// Its name for reports.
    pub name: &'static str,
    /// The cut mesh, and which of its triangles are selected.
    pub cut: CutMesh,
}

/// The selection by options within the transferred area.
pub(super) fn of(
    wanted: &uvgraft_pipeline::Region,
    domain: &BlendDomain,
    unit: Unit,
) -> anyhow::Result<CutRegion> {
    let selection = wanted.select(domain, unit, &Notes)?;
    let blend = Blend::new(&selection, BlendOptions::default()).map_err(bad_input)?;
    let name = if wanted.is_everything() { "the linked triangles" } else { "the selected part" };
    Ok(CutRegion { name, cut: blend.cut()? })
}
