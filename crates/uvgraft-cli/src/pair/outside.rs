//! What becomes of triangles whose UV coordinates lie outside the unit square.

use uvgraft::{Mesh, Tile, choices};
use uvgraft_io::pair_file::PairFile;

use crate::failure::{note, warn};
use crate::report::grouped;

/// What becomes of triangles outside the unit square.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Outside {
    Unlinked,
    Clamp,
    Repeat,
}

choices!(Outside {
    Unlinked => "unlinked",
        "Link them in their UDIM tiles alone, never to a texture of the unit square";
    Clamp => "clamp", "Clamp their UV coordinates to the unit square";
    Repeat => "repeat",
        "Move whole polygons into the unit square; leave those that cross its border unlinked";
});

impl Outside {
    /// Applies it to a mesh, and says to how many triangles.
    pub(super) fn apply(self, mesh: Mesh, name: &str) -> Mesh {
        let outside =
            |mesh: &Mesh| (0..mesh.faces().len()).filter(|&face| mesh.is_outside(face)).count();
        let before = outside(&mesh);
        if self == Self::Unlinked || before == 0 {
            return mesh;
        }
        let (mesh, what) = match self {
            Self::Unlinked => return mesh,
            Self::Clamp => (mesh.clamped(), "clamped to"),
            Self::Repeat => (mesh.repeated(), "moved into"),
        };
        let changed = before - outside(&mesh);
        let triangles = if changed == 1 { "triangle" } else { "triangles" };
        note(format!("{name}: {} {triangles} {what} the unit square", grouped(changed)));
        mesh
    }
}

/// Warns of triangles that a texture of the unit square does not reach.
pub(super) fn warn_of_outside(file: &PairFile) {
    let sides = [(file.pair.source(), &file.source_name), (file.pair.target(), &file.target_name)];
    for (mesh, name) in sides {
        let faces = || (0..mesh.faces().len()).filter(|&face| mesh.is_outside(face));
        let count = faces().count();
        if count == 0 {
            continue;
        }
        let mut tiles: Vec<Tile> = faces().filter_map(|face| mesh.tile(face)).collect();
        let in_tiles = tiles.len();
        tiles.sort_unstable();
        tiles.dedup();
        let tiles: Vec<String> = tiles.iter().map(ToString::to_string).collect();
        let triangles = if count == 1 { "triangle has" } else { "triangles have" };
        let mut text = format!(
            "{name}: {} {triangles} UV coordinates outside the unit square",
            grouped(count)
        );
        if in_tiles > 0 {
            text += &format!(
                "; {} in UDIM tiles ({}) are linked only for textures with an image for each tile",
                grouped(in_tiles),
                tiles.join(", ")
            );
        }
        if in_tiles < count {
            text += &format!(
                "; {} cross borders of tiles or lie where there are none, and will not be linked",
                grouped(count - in_tiles)
            );
        }
        warn(text);
    }
}
