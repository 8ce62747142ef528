//! Warns of triangles whose UV coordinates lie outside the unit square.

use uvgraft::listing::listed;
use uvgraft::{Mesh, Tile};
use uvgraft_pipeline::Observer;

use crate::report::grouped;

/// The triangles of a mesh whose UV coordinates lie outside the unit square.
pub(crate) struct OutsideFaces {
    /// Their number, at least one.
    count: usize,
    /// The number of those that lie in a tile.
    in_tiles: usize,
    /// The tiles, in order.
    pub(crate) tiles: Vec<Tile>,
}

impl OutsideFaces {
    /// `None` if there are none.
    pub(crate) fn of(mesh: &Mesh) -> Option<Self> {
        let faces = || (0..mesh.faces().len()).filter(|&face| mesh.is_outside(face));
        let count = faces().count();
        let mut tiles: Vec<Tile> = faces().filter_map(|face| mesh.tile(face)).collect();
        let in_tiles = tiles.len();
        tiles.sort_unstable();
        tiles.dedup();
        (count > 0).then_some(Self { count, in_tiles, tiles })
    }

    /// How many there are, as the beginning of a message.
    pub(crate) fn message_start(&self, name: &str) -> String {
        let triangles = if self.count == 1 { "triangle has" } else { "triangles have" };
        let count = grouped(self.count);
        format!("{name}: {count} {triangles} UV coordinates outside the unit square")
    }
}

/// Warns of triangles that a texture of the unit square does not reach.
///
/// - `meshes`, `names`: of the source and the target.
pub(super) fn warn_of_outside(meshes: [&Mesh; 2], names: [&str; 2], observer: &dyn Observer) {
    for (mesh, name) in meshes.into_iter().zip(names) {
        let Some(outside) = OutsideFaces::of(mesh) else { continue };
        let mut text = outside.message_start(name);
        let OutsideFaces { count, in_tiles, tiles } = outside;
        if in_tiles > 0 {
            text += &format!(
                "; {} in UDIM tiles ({}) are linked only for textures with an image for each tile",
                grouped(in_tiles),
                listed(tiles)
            );
        }
        if in_tiles < count {
            text += &format!(
                "; {} cross borders of tiles or lie where there are none, and will not be linked",
                grouped(count - in_tiles)
            );
        }
        if 2 * in_tiles > mesh.faces().len() {
            text += "; `outside` repeat moves them into the unit square";
        }
        observer.warn(text);
    }
}

/// Warns of UV coordinates in which most triangles are larger than a tile.
pub(super) fn warn_of_size(mesh: &Mesh, name: &str, observer: &dyn Observer) {
    let crosses = |face: &usize| {
        let corners = mesh.uv_triangle(*face);
        (0..2).any(|axis| {
            let values = corners.map(|corner| corner[axis]);
            let low = values.into_iter().fold(f32::INFINITY, f32::min);
            let high = values.into_iter().fold(f32::NEG_INFINITY, f32::max);
            high.ceil() - low.floor() > 1.0
        })
    };
    let count = (0..mesh.faces().len()).filter(crosses).count();
    if 2 * count <= mesh.faces().len() {
        return;
    }
    let largest =
        mesh.uv().as_flattened().iter().fold(0.0_f32, |most, value| most.max(value.abs()));
    observer.warn(format!(
        "{name}: most triangles cross borders of UV tiles; coordinates go up to {largest:.1}, where \
         a texture is from 0 to 1: they may be in texels or per cent"
    ));
}
