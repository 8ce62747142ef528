//! Validation of the input before anything is written.

use uvgraft::Size;
use uvgraft_avatar::Avatar;
use uvgraft_avatar::rig::RigError;

use super::vrm;
use super::{AvatarMaterial, EmbeddedFormat, Export};
use crate::container::TooLarge;

/// Why an avatar cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GlbError {
    /// The avatar's parts are inconsistent.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// Every triangle is degenerate: it has a vertex twice.
    #[error("the mesh must have a triangle with three distinct vertices")]
    NoTriangles,
    /// Two morphs or two expressions share a name.
    #[error("duplicate name `{name}` of {what}")]
    Name {
        /// What has the name.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// A material factor is out of range.
    #[error("the {what} must be 0 to 1, got {found}")]
    Factor {
        /// Name of the factor.
        what: &'static str,
        /// Value of the factor.
        found: f32,
    },
    /// A triangle refers to a material that does not exist.
    #[error("triangle materials must be less than {materials}, got {found}")]
    Material {
        /// Index of the material.
        found: u8,
        /// Number of materials.
        materials: usize,
    },
    /// VRM does not support levels of detail.
    #[error("VRM does not support levels of detail; write each level as a separate file")]
    VrmLevels,
    /// A thumbnail must be a square PNG or JPEG.
    #[error("a thumbnail must be a square PNG or JPEG image, got {found:?} of {size}")]
    Thumbnail {
        /// Its format.
        found: EmbeddedFormat,
        /// Its size.
        size: Size,
    },
    /// The file is too large: lengths in GLB files are 32-bit.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    /// A requirement of VRM is not met.
    #[error(transparent)]
    Vrm(#[from] vrm::VrmError),
    /// The JSON could not be serialised.
    #[error("cannot write the JSON: {0}")]
    Json(#[from] serde_json::Error),
}

/// Checks that an avatar, its materials and its levels can be written.
pub(super) fn check(
    avatar: &Avatar,
    materials: &[AvatarMaterial],
    export: &Export,
) -> Result<(), GlbError> {
    avatar.check()?;
    check_normals(avatar, export.normals.as_deref())?;
    let factors = materials
        .iter()
        .flat_map(|own| [("roughness", own.roughness_factor), ("metalness", own.metallic_factor)]);
    for (what, found) in factors {
        if !(0.0..=1.0).contains(&found) {
            return Err(GlbError::Factor { what, found });
        }
    }
    let avatars = || std::iter::once(avatar).chain(export.levels.iter().map(|level| &level.avatar));
    for found in avatars().flat_map(|avatar| avatar.materials.iter().copied().max()) {
        if usize::from(found) >= materials.len() {
            return Err(GlbError::Material { found, materials: materials.len() });
        }
    }
    if materials.is_empty() {
        return Err(GlbError::Material { found: 0, materials: 0 });
    }
    check_levels(avatar, export)?;
    if let Some(picture) = &export.thumbnail {
        let size = picture.size();
        let is_plain = matches!(picture.format(), EmbeddedFormat::Png | EmbeddedFormat::Jpeg);
        if size.width != size.height || !is_plain {
            return Err(GlbError::Thumbnail { found: picture.format(), size });
        }
    }
    unique("morphs", avatar.morphs.iter().map(|morph| &morph.name))?;
    unique("expressions", avatar.expressions.iter().map(|expression| &expression.name))
}

/// Checks that levels have the avatar's joints and morphs, so that they animate alike.
fn check_levels(avatar: &Avatar, export: &Export) -> Result<(), GlbError> {
    if !export.levels.is_empty() && export.vrm.is_some() {
        return Err(GlbError::VrmLevels);
    }
    for level in &export.levels {
        level.avatar.check()?;
        for (what, found, wanted) in [
            (
                "joints of a level",
                level.avatar.skeleton.joints().len(),
                avatar.skeleton.joints().len(),
            ),
            ("morphs of a level", level.avatar.morphs.len(), avatar.morphs.len()),
        ] {
            if found != wanted {
                return Err(RigError::Count { what, found, wanted }.into());
            }
        }
        check_normals(&level.avatar, level.normals.as_deref())?;
    }
    Ok(())
}

fn check_normals(avatar: &Avatar, normals: Option<&[[f32; 3]]>) -> Result<(), GlbError> {
    let wanted = avatar.mesh.positions().len();
    match normals.map(<[_]>::len) {
        Some(found) if found != wanted => {
            Err(RigError::Count { what: "normals", found, wanted }.into())
        }
        _ => Ok(()),
    }
}

fn unique<'a>(what: &'static str, names: impl Iterator<Item = &'a String>) -> Result<(), GlbError> {
    let mut known = std::collections::HashSet::new();
    for name in names {
        if !known.insert(name) {
            return Err(GlbError::Name { what, name: name.clone() });
        }
    }
    Ok(())
}
