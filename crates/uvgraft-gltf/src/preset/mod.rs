//! Presets for platforms: limits for textures and triangles, and how they compare with the limits
//! that the platforms publish ([`Limits`]).
//!
//! | preset | texture | triangles | use |
//! |---|---|---|---|
//! | [`QUEST`] | 1024, PNG | 10,000 | VRChat's mobile ranks: "Good", which every headset shows |
//! | [`PCVR`] | 2048, PNG | 32,000 | VRChat's PC ranks: "Excellent" |
//! | [`WEB`] | 2048, JPEG | 50,000 | pages on phones: a small download; about 27,000 vertices of the recommended 30,000 |
//! | [`VISIONOS`] | 2048, PNG | 100,000 | AR Quick Look, which opens only USDZ: files need conversion |
//!
//! Unity compresses textures at import, so VRChat's presets use a lossless format.

mod deviation;
mod hidden;
mod levels;
mod limits;
#[cfg(feature = "simplify")]
mod simplify;
#[cfg(feature = "simplify")]
mod slivers;
mod subset;
#[cfg(all(test, feature = "simplify"))]
pub(crate) mod testing;
#[cfg(test)]
mod tests;

use uvgraft::{Averaging, Filter, MeshError, Size, Texture, TextureError};
use uvgraft_avatar::Avatar;

pub use self::deviation::Deviation;
pub use self::hidden::hidden;
pub use self::levels::{Level, MAX_LEVELS, levels};
pub use self::limits::{
    AR_QUICK_LOOK, LimitCheck, Limits, Measurements, Quantity, SCENE_VIEWER, VRCHAT_MOBILE,
    VRCHAT_PC,
};
#[cfg(feature = "simplify")]
pub use self::simplify::{Simplified, simplify};
use crate::glb::{EmbedError, EmbeddedFormat, EmbeddedImage};

/// Limits for avatars on a platform.
#[derive(Debug, PartialEq)]
pub struct Preset {
    /// Name for users.
    pub name: &'static str,
    /// Longest side of a texture, in texels.
    pub texture_side: u32,
    /// Image format of textures.
    pub format: EmbeddedFormat,
    /// Maximum number of triangles.
    pub triangles: usize,
    /// The limits that the platform publishes.
    pub limits: &'static Limits,
}

/// VRChat on phones and standalone headsets.
pub const QUEST: Preset = Preset {
    name: "quest",
    texture_side: 1024,
    format: EmbeddedFormat::Png,
    triangles: 10_000,
    limits: &VRCHAT_MOBILE,
};

/// VRChat on Windows.
pub const PCVR: Preset = Preset {
    name: "pcvr",
    texture_side: 2048,
    format: EmbeddedFormat::Png,
    triangles: 32_000,
    limits: &VRCHAT_PC,
};

/// Web pages.
pub const WEB: Preset = Preset {
    name: "web",
    texture_side: 2048,
    format: EmbeddedFormat::Jpeg,
    triangles: 50_000,
    limits: &SCENE_VIEWER,
};

/// Apple's headset, through AR Quick Look.
pub const VISIONOS: Preset = Preset {
    name: "visionos",
    texture_side: 2048,
    format: EmbeddedFormat::Png,
    triangles: 100_000,
    limits: &AR_QUICK_LOOK,
};

/// JPEG quality: textures are seen close up, and base colours have no blur to hide block artefacts.
const JPEG_QUALITY: u8 = 92;

/// Why an avatar could not be fitted to a preset.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PresetError {
    /// The avatar has too many triangles and this build cannot simplify.
    #[error(
        "the avatar must have at most {wanted} triangles, got {found}; simplifying needs a build \
         with the feature `simplify`"
    )]
    Budget {
        /// Number of triangles.
        found: usize,
        /// The budget.
        wanted: usize,
    },
    /// No triangle would be left.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The texture cannot be resized.
    #[error(transparent)]
    Texture(#[from] TextureError),
    /// The texture cannot be encoded.
    #[error(transparent)]
    EmbeddedImage(#[from] EmbedError),
}

/// An avatar fitted to a triangle budget.
#[derive(Debug, Clone)]
pub struct FittedAvatar {
    /// The avatar.
    pub avatar: Avatar,
    /// Value for [`Export::normals`](crate::glb::Export::normals), if the avatar was simplified.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Number of triangles before fitting.
    pub before: usize,
    /// Number of triangles removed because they are never visible.
    pub hidden: usize,
    /// Number of triangles left.
    pub after: usize,
    /// The triangle budget. Simplifying may exceed it, usually by 5 % at most.
    pub wanted: usize,
}

/// Fits an avatar to a triangle budget: first by removing triangles that are never visible, then by
/// simplifying. An avatar within the budget is returned unchanged.
///
/// # Errors
/// [`PresetError::Budget`] if removing hidden triangles is not enough and the feature `simplify` is
/// off.
pub fn fit(avatar: Avatar, wanted: usize) -> Result<FittedAvatar, PresetError> {
    let before = avatar.mesh.faces().len();
    if before <= wanted {
        return Ok(FittedAvatar {
            avatar,
            normals: None,
            before,
            hidden: 0,
            after: before,
            wanted,
        });
    }
    let is_hidden = hidden(&avatar);
    fn seen<T: Copy>(values: &[T], is_hidden: &[bool]) -> Vec<T> {
        let seen = values.iter().zip(is_hidden).filter(|(_, is_hidden)| !**is_hidden);
        seen.map(|(&value, _)| value).collect()
    }
    let faces = seen(avatar.mesh.faces(), &is_hidden);
    let uv_faces = seen(avatar.mesh.uv_faces(), &is_hidden);
    let hidden = before - faces.len();
    let avatar = if hidden == 0 {
        avatar
    } else {
        let materials = seen(&avatar.materials, &is_hidden);
        let triangles = subset::Triangles { faces: &faces, uv_faces: &uv_faces, materials };
        subset::with_faces(avatar, triangles)?
    };
    let after = before - hidden;
    simplified(FittedAvatar { avatar, normals: None, before, hidden, after, wanted })
}

#[cfg(feature = "simplify")]
fn simplified(fitted: FittedAvatar) -> Result<FittedAvatar, PresetError> {
    let Simplified { avatar, normals, after, .. } = simplify(fitted.avatar, fitted.wanted)?;
    Ok(FittedAvatar { avatar, normals: Some(normals), after, ..fitted })
}

#[cfg(not(feature = "simplify"))]
fn simplified(fitted: FittedAvatar) -> Result<FittedAvatar, PresetError> {
    let (found, wanted) = (fitted.after, fitted.wanted);
    if found <= wanted {
        return Ok(fitted);
    }
    Err(PresetError::Budget { found, wanted })
}

impl Preset {
    /// All presets.
    pub const ALL: [&'static Self; 4] = [&QUEST, &PCVR, &WEB, &VISIONOS];

    /// The preset with this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        Self::ALL.into_iter().find(|preset| preset.name == name)
    }

    /// Fits an avatar to the preset's triangle budget; see [`fit`].
    ///
    /// # Errors
    /// As [`fit`].
    pub fn fit(&self, avatar: Avatar) -> Result<FittedAvatar, PresetError> {
        fit(avatar, self.triangles)
    }

    /// Size of a texture under this preset: unchanged, or scaled down until its longest side fits.
    pub fn texture_size(&self, size: Size) -> Size {
        let longest = size.width.max(size.height);
        if longest <= self.texture_side {
            return size;
        }
        let scaled = |side: u32| {
            let scaled = u64::from(side) * u64::from(self.texture_side) / u64::from(longest);
            (scaled as u32).max(1)
        };
        Size::new(scaled(size.width), scaled(size.height))
    }

    /// Scales a texture down to the preset's size if it is larger, and encodes it.
    ///
    /// # Errors
    /// [`PresetError`] if the texture cannot be encoded.
    pub fn picture(&self, texture: Texture) -> Result<EmbeddedImage, PresetError> {
        let found = texture.size();
        let longest = found.width.max(found.height);
        // At integer ratios the samples coincide with texels, whatever the filter; bilinear is the
        // fastest.
        let is_whole = longest.is_multiple_of(self.texture_side);
        let filter = if is_whole { Filter::Bilinear } else { Filter::CatmullRom };
        let texture = texture.resized(self.texture_size(found), filter, Averaging::Encoded)?;
        Ok(EmbeddedImage::encode(texture, self.format, JPEG_QUALITY)?)
    }
}
