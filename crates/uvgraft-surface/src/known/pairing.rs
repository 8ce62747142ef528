//! Warnings of pairs that are likely to be a mistake.

use super::{Certainty, KnownLayout, LayoutMatch, MeshMatch, Recognition};
use crate::mesh::{Mesh, TileFaces};
use crate::pair::Side;

/// Something about a pair that one should know before textures are transferred.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum PairingWarning {
    /// A known mesh with another layout than its usual one: textures made for one do not fit the
    /// other.
    OtherLayout {
        /// Which side.
        side: Side,
        /// The layout that it has.
        layout: LayoutMatch,
        /// The usual layout of its mesh.
        usual: &'static KnownLayout,
    },
    /// A mesh with the counts of a known one but other connectivity: vertex maps and tables made for
    /// the known one do not fit.
    OtherConnectivity {
        /// Which side.
        side: Side,
        /// The known mesh.
        like: MeshMatch,
    },
    /// Faces outside the unit square, where the texture of this layout has no texels. In FLAME with
    /// HiFi3D++'s UVs these are the eyeballs.
    OtherTiles {
        /// Which side.
        side: Side,
        /// The tiles beyond the first, with the number of faces in each.
        tiles: Vec<TileFaces>,
    },
    /// Both sides have the same known layout: a texture fits both as it is.
    SameLayout {
        /// The layout.
        layout: &'static KnownLayout,
    },
}

/// Checks two meshes that are to be paired, source first.
///
/// - `recognised`: what [`recognise`](super::recognise) says of each.
pub fn pairing_warnings(meshes: [&Mesh; 2], recognised: [&Recognition; 2]) -> Vec<PairingWarning> {
    let mut warnings = Vec::new();
    for ((side, mesh), found) in
        [Side::Source, Side::Target].into_iter().zip(meshes).zip(recognised)
    {
        if let Some(like) = found.mesh.filter(|it| it.certainty == Certainty::OtherConnectivity) {
            warnings.push(PairingWarning::OtherConnectivity { side, like });
        }
        if let Some(&layout) = found.likely_layout() {
            let usual =
                layout.mesh.layouts.first().filter(|usual| usual.name != layout.layout.name);
            warnings.extend(usual.map(|usual| PairingWarning::OtherLayout { side, layout, usual }));
        }
        let tiles: Vec<TileFaces> =
            mesh.tiles().into_iter().filter(|faces| faces.tile != [0, 0]).collect();
        if !tiles.is_empty() {
            warnings.push(PairingWarning::OtherTiles { side, tiles });
        }
    }
    if let [Some(source), Some(target)] = recognised.map(Recognition::likely_layout)
        && source.layout.name == target.layout.name
    {
        warnings.push(PairingWarning::SameLayout { layout: source.layout });
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::super::{MESHES, recognise};
    use super::*;

    fn mesh(shift: f32) -> Mesh {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        let uv = vec![[0.1, 0.1], [0.4, 0.1], [0.1, 0.4], [0.4, 0.4]];
        let mut shifted = uv.clone();
        shifted.extend(uv.iter().map(|&[u, v]| [u + shift, v]));
        let faces = [[0, 1, 2], [1, 3, 2]];
        Mesh::from_triangles(positions, shifted, &faces, &[[0, 1, 2], [5, 7, 6]]).unwrap()
    }

    /// The layout of that name on the mesh of that name.
    fn known(mesh: &str, layout: &str, unknown: Recognition) -> Recognition {
        let mesh = MESHES.iter().find(|known| known.name == mesh).unwrap();
        let layout = mesh.layouts.iter().find(|known| known.name == layout).unwrap();
        let certainty = Certainty::Connectivity;
        Recognition { layout: Some(LayoutMatch { mesh, layout, certainty }), ..unknown }
    }

    #[test]
    fn islands_in_other_tiles_are_warned_of() {
        let [inside, outside] = [mesh(0.5), mesh(2.0)];
        let [a, b] = [&inside, &outside].map(recognise);
        assert_eq!(pairing_warnings([&inside, &inside], [&a, &a]), []);
        let [PairingWarning::OtherTiles { side: Side::Target, tiles }] =
            &pairing_warnings([&inside, &outside], [&a, &b])[..]
        else {
            panic!()
        };
        assert_eq!((tiles.len(), tiles[0].tile, tiles[0].faces), (1, [2, 0], 1));
    }

    #[test]
    fn layouts_of_other_names_are_warned_of() {
        let mesh = mesh(0.5);
        let unknown = recognise(&mesh);
        let [add_on, website] = ["SMPL-X Blender add-on", "SMPL-X website"]
            .map(|layout| known("SMPL-X", layout, unknown));
        let warnings = pairing_warnings([&mesh, &mesh], [&add_on, &website]);
        let [PairingWarning::OtherLayout { side: Side::Target, usual, .. }] = &warnings[..] else {
            panic!("{warnings:?}")
        };
        assert_eq!(usual.name, "SMPL-X Blender add-on");
        // HiFi3D++'s textures fit FLAME with HiFi3D++'s UVs as they are.
        let [head, flame] = ["HiFi3D++", "FLAME"].map(|mesh| known(mesh, "HiFi3D++", unknown));
        let warnings = pairing_warnings([&mesh, &mesh], [&head, &flame]);
        assert!(
            matches!(
                &warnings[..],
                [
                    PairingWarning::OtherLayout { side: Side::Target, .. },
                    PairingWarning::SameLayout { .. }
                ]
            ),
            "{warnings:?}"
        );
    }

    #[test]
    fn a_lookalike_is_warned_of() {
        let mesh = mesh(0.5);
        let unknown = recognise(&mesh);
        let flame = &MESHES[0];
        let certainty = Certainty::OtherConnectivity;
        let like = MeshMatch { mesh: flame, edition: &flame.editions[0], certainty };
        let lookalike = Recognition { mesh: Some(like), ..unknown };
        let warnings = pairing_warnings([&mesh, &mesh], [&lookalike, &unknown]);
        assert_eq!(warnings, [PairingWarning::OtherConnectivity { side: Side::Source, like }]);
    }
}
