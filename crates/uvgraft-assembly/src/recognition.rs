//! The names of publicly known meshes and layouts, and warnings of pairs that look wrong, as text.

use uvgraft::Side;
use uvgraft::known::{self, Certainty, PairingWarning, Recognition, recognise};
use uvgraft_io::pair_file::PairFile;

use crate::report::grouped;

/// What the source and the target of a pair are.
pub fn recognised(file: &PairFile) -> [Recognition; 2] {
    [file.pair.source(), file.pair.target()].map(recognise)
}

/// The names of a mesh and of its layout, for a report.
pub fn names(found: &Recognition) -> [String; 2] {
    let unknown = || "unknown".to_owned();
    let mesh = found
        .mesh
        .as_ref()
        .map_or_else(unknown, |it| qualified(&it.mesh.title(it.edition), it.certainty));
    let layout =
        found.layout.as_ref().map_or_else(unknown, |it| qualified(it.layout.name, it.certainty));
    [mesh, layout]
}

/// The names of a mesh and of its layout where they are known, short enough for a column: a question
/// mark follows what is known by counts only.
pub fn short_names(found: &Recognition) -> [Option<String>; 2] {
    let marked = |name: &str, certainty| match certainty {
        Certainty::CountsOnly => format!("{name}?"),
        _ => name.to_owned(),
    };
    let mesh = found.likely_mesh().map(|it| marked(it.mesh.name, it.certainty));
    let layout = found.likely_layout().map(|it| marked(it.layout.name, it.certainty));
    [mesh, layout]
}

/// A number of triangles in words.
pub fn triangles(count: usize) -> String {
    let triangles = if count == 1 { "triangle" } else { "triangles" };
    format!("{} {triangles}", grouped(count))
}

fn qualified(name: &str, certainty: Certainty) -> String {
    match certainty {
        Certainty::Connectivity => format!("{name} (same connectivity)"),
        Certainty::CountsOnly => format!("{name} (by counts only)"),
        Certainty::OtherConnectivity => {
            format!("unknown (not {name}: same counts, other connectivity)")
        }
    }
}

/// Warnings of a pair that is likely to be a mistake.
///
/// - `found`: what the source and the target are.
pub fn pairing_warnings(file: &PairFile, found: &[Recognition; 2]) -> Vec<String> {
    texts(file, found, |_| true)
}

/// The same without triangles in other tiles, for who warns of triangles outside the unit square.
pub(crate) fn layout_warnings(file: &PairFile, found: &[Recognition; 2]) -> Vec<String> {
    texts(file, found, |warning| !matches!(warning, PairingWarning::OtherTiles { .. }))
}

fn texts(
    file: &PairFile,
    found: &[Recognition; 2],
    is_wanted: impl Fn(&PairingWarning) -> bool,
) -> Vec<String> {
    let meshes = [file.pair.source(), file.pair.target()];
    let names = [&*file.source_name, &*file.target_name];
    let warnings = known::pairing_warnings(meshes, found.each_ref());
    let wanted = warnings.iter().filter(|warning| is_wanted(warning));
    wanted.map(|warning| warning_text(warning, names)).collect()
}

fn warning_text(warning: &PairingWarning, names: [&str; 2]) -> String {
    let name = |side: &Side| if *side == Side::Source { names[0] } else { names[1] };
    match warning {
        PairingWarning::OtherLayout { side, layout, usual } => {
            let note = match layout.layout.note {
                "" => String::new(),
                note => format!(" ({note})"),
            };
            format!(
                "{}: {} with the layout {}{note}; textures for the layout {} do not fit it",
                name(side),
                layout.mesh.name,
                layout.layout.name,
                usual.name
            )
        }
        PairingWarning::OtherConnectivity { side, like } => {
            let like = like.mesh.title(like.edition);
            format!(
                "{}: has the counts of {like} but other connectivity; vertex maps for {like} do \
                 not fit it",
                name(side)
            )
        }
        PairingWarning::OtherTiles { side, tiles } => {
            let faces: usize = tiles.iter().map(|tile| tile.faces).sum();
            let lie = if faces == 1 { "lies" } else { "lie" };
            let tiles: Vec<String> = tiles
                .iter()
                .take(4)
                .map(|tile| match tile.udim {
                    Some(udim) => udim.to_string(),
                    None => format!("column {} row {}", tile.tile[0], tile.tile[1]),
                })
                .collect();
            format!(
                "{}: {} {lie} in other UV tiles ({}), for which a texture of the unit \
                 square has no texels",
                name(side),
                triangles(faces),
                tiles.join(", ")
            )
        }
        PairingWarning::SameLayout { layout } => format!(
            "{} and {} both have the layout {}: textures fit both without a transfer",
            names[0], names[1], layout.name
        ),
        _ => format!("{warning:?}"),
    }
}
