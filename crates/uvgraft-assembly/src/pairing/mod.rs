//! What the command and Python share in pairing two meshes: how UV coordinates are read, and what to
//! tell of a pair that may be a mistake.

mod outside;
pub mod table;

use uvgraft::correspond::surface::SurfaceReport;
use uvgraft::mesh::UvAxis;
use uvgraft::pair::OtherLayouts;
use uvgraft::{Direction, Mesh, Recognition, Side, choices};
use uvgraft_io::pair_file::PairFile;
use uvgraft_pipeline::Observer;

pub(crate) use self::outside::OutsideFaces;
use self::outside::warn_of_outside;
use crate::mesh_file::LoadedMesh;
use crate::recognition;
use crate::report::grouped;

/// What becomes of triangles outside the unit square.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Outside {
    /// Linked only between UDIM tiles.
    #[default]
    Unlinked,
    /// Clamped to the unit square.
    Clamp,
    /// Moved into the unit square.
    Repeat,
}

choices!(Outside {
    Unlinked => "unlinked",
        "Link them in their UDIM tiles alone, never to a texture of the unit square";
    Clamp => "clamp", "Clamp their UV coordinates to the unit square";
    Repeat => "repeat",
        "Move whole polygons into the unit square; leave those that cross its border unlinked";
});

/// How the UV coordinates of two meshes are read.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct UvReading {
    /// The meshes whose U is counted from the other side.
    pub flip_u: Vec<Side>,
    /// The meshes whose V is counted from the other side.
    pub flip_v: Vec<Side>,
    /// What becomes of triangles that are then outside the unit square.
    pub outside: Outside,
}

impl UvReading {
    /// Applies it to one of the meshes, notes what was moved, and warns of coordinates that seem to be in
    /// another unit.
    pub fn apply(&self, loaded: LoadedMesh, side: Side, observer: &dyn Observer) -> LoadedMesh {
        let LoadedMesh { mut mesh, name, without_uv } = loaded;
        for (axis, flipped) in [(UvAxis::U, &self.flip_u), (UvAxis::V, &self.flip_v)] {
            if flipped.contains(&side) {
                mesh = mesh.flipped(axis);
            }
        }
        outside::warn_of_size(&mesh, &name, observer);
        let before = count_outside(&mesh);
        let (mesh, what) = match self.outside {
            _ if before == 0 => return LoadedMesh { mesh, name, without_uv },
            Outside::Unlinked => return LoadedMesh { mesh, name, without_uv },
            Outside::Clamp => (mesh.clamped(), "clamped to"),
            Outside::Repeat => (mesh.repeated(), "moved into"),
        };
        let changed = before - count_outside(&mesh);
        let triangles = if changed == 1 { "triangle" } else { "triangles" };
        let changed = grouped(changed);
        observer.note(format!("{name}: {changed} {triangles} {what} the unit square"));
        LoadedMesh { mesh, name, without_uv }
    }
}

fn count_outside(mesh: &Mesh) -> usize {
    (0..mesh.faces().len()).filter(|&face| mesh.is_outside(face)).count()
}

/// Warns of what is likely to be a mistake in a pair, and notes which parts were left out.
///
/// - `registered`: what registration found, if the pair was made by it.
/// - `recognised`: what the source and the target are.
pub fn remark(
    file: &PairFile,
    registered: Option<&SurfaceReport>,
    other_layouts: &[OtherLayouts],
    recognised: &[Recognition; 2],
    observer: &dyn Observer,
) {
    let PairFile { pair, source_name, target_name, .. } = file;
    let meshes = [pair.source(), pair.target()];
    let names = [&**source_name, &**target_name];
    warn_of_outside(meshes, names, observer);
    for others in other_layouts {
        let text = others.text(names[usize::from(others.side == Side::Target)]);
        if others.is_loss() { observer.warn(&text) } else { observer.note(&text) }
    }
    if let Some(mirroring) = pair.mirroring() {
        observer.warn(mirroring.text(names));
    }
    registered.and_then(SurfaceReport::warning).into_iter().for_each(|it| observer.warn(it));
    let linked = [Direction::Reverse, Direction::Forward].map(|to| pair.linked_share(to));
    if linked.iter().all(|&share| share < FEW) {
        let [source, target] = linked.map(|share| format!("{:.2} %", 100.0 * share));
        observer.warn(format!(
            "only {source} of the area of {} and {target} of that of {} are linked; do they show the \
             same thing?",
            names[0], names[1]
        ));
    }
    recognition::layout_warnings(file, recognised).into_iter().for_each(|it| observer.warn(it));
}

/// Least share of either mesh's area that a pair links. A face on a whole body with clothes and hair is
/// some 2 % of the body's area, but then nearly all of the face's.
const FEW: f64 = 0.01;
