//! Avatars for platforms: how large their textures and how many triangles they may have, and where that
//! stands against what the platforms publish ([`Limits`]).
//!
//! | preset | texture | triangles | what for |
//! |---|---|---|---|
//! | [`QUEST`] | 1024, PNG | 10,000 | VRChat's mobile ranks: "Good", which every headset shows |
//! | [`PCVR`] | 2048, PNG | 32,000 | VRChat's PC ranks: "Excellent" |
//! | [`WEB`] | 2048, JPEG | 50,000 | pages on phones: a small download; some 27,000 vertices of the 30,000 that are advised |
//! | [`VISIONOS`] | 2048, PNG | 100,000 | AR Quick Look, which opens USDZ only: files need conversion |
//!
//! Unity compresses textures at import, so VRChat's get them lossless.

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
pub use self::levels::{Level, MOST_LEVELS, levels};
pub use self::limits::{
    AR_QUICK_LOOK, Figure, Limits, Line, Measured, SCENE_VIEWER, VRCHAT_MOBILE, VRCHAT_PC,
};
#[cfg(feature = "simplify")]
pub use self::simplify::{Simplified, simplify};
use crate::glb::{Picture, PictureError, PictureFormat};

/// What a platform wants.
#[derive(Debug, PartialEq)]
pub struct Preset {
    /// What users call it.
    pub name: &'static str,
    /// The longest side of a texture, in texels.
    pub texture_side: u32,
    /// How textures are encoded.
    pub format: PictureFormat,
    /// The most triangles.
    pub triangles: usize,
    /// What the platform publishes.
    pub limits: &'static Limits,
}

/// VRChat on phones and headsets of their own.
pub const QUEST: Preset = Preset {
    name: "quest",
    texture_side: 1024,
    format: PictureFormat::Png,
    triangles: 10_000,
    limits: &VRCHAT_MOBILE,
};

/// VRChat on Windows.
pub const PCVR: Preset = Preset {
    name: "pcvr",
    texture_side: 2048,
    format: PictureFormat::Png,
    triangles: 32_000,
    limits: &VRCHAT_PC,
};

/// Web pages.
pub const WEB: Preset = Preset {
    name: "web",
    texture_side: 2048,
    format: PictureFormat::Jpeg,
    triangles: 50_000,
    limits: &SCENE_VIEWER,
};

/// Apple's headset.
pub const VISIONOS: Preset = Preset {
    name: "visionos",
    texture_side: 2048,
    format: PictureFormat::Png,
    triangles: 100_000,
    limits: &AR_QUICK_LOOK,
};

/// The quality of JPEGs: a texture is looked at closely, and base colours have no blur to hide blocks.
const JPEG_QUALITY: u8 = 92;

/// Why an avatar does not fit a preset.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PresetError {
    /// This build cannot simplify.
    #[error(
        "the avatar must have at most {wanted} triangles, got {found}; simplifying needs a build \
         with the feature `simplify`"
    )]
    Budget {
        /// How many there are.
        found: usize,
        /// How many there may be.
        wanted: usize,
    },
    /// Nothing is left of the mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The texture cannot be resized.
    #[error(transparent)]
    Texture(#[from] TextureError),
    /// The texture cannot be encoded.
    #[error(transparent)]
    Picture(#[from] PictureError),
}

/// An avatar within a budget of triangles.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// The avatar.
    pub avatar: Avatar,
    /// What [`Export::normals`](crate::glb::Export::normals) should be if it was changed.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Its triangles before.
    pub before: usize,
    /// Triangles that are gone because nobody sees them.
    pub hidden: usize,
    /// Triangles that are left.
    pub after: usize,
    /// How many it may have. Simplifying may miss it, by 5 % at most in most cases.
    pub wanted: usize,
}

/// Brings an avatar within a budget of triangles: first by leaving out what nobody sees, then by
/// simplifying. One that is within it stays as it is.
///
/// # Errors
/// [`PresetError::Budget`] if that is not enough and the feature `simplify` is off.
pub fn fit(avatar: Avatar, wanted: usize) -> Result<Fitted, PresetError> {
    let before = avatar.mesh.faces().len();
    if before <= wanted {
        return Ok(Fitted { avatar, normals: None, before, hidden: 0, after: before, wanted });
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
    simplified(Fitted { avatar, normals: None, before, hidden, after, wanted })
}

#[cfg(feature = "simplify")]
fn simplified(fitted: Fitted) -> Result<Fitted, PresetError> {
    let Simplified { avatar, normals, after, .. } = simplify(fitted.avatar, fitted.wanted)?;
    Ok(Fitted { avatar, normals: Some(normals), after, ..fitted })
}

#[cfg(not(feature = "simplify"))]
fn simplified(fitted: Fitted) -> Result<Fitted, PresetError> {
    let (found, wanted) = (fitted.after, fitted.wanted);
    if found <= wanted {
        return Ok(fitted);
    }
    Err(PresetError::Budget { found, wanted })
}

impl Preset {
    /// All of them.
    pub const ALL: [&'static Self; 4] = [&QUEST, &PCVR, &WEB, &VISIONOS];

    /// The preset with this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        Self::ALL.into_iter().find(|preset| preset.name == name)
    }

    /// Brings an avatar within the budget of triangles; see [`fit`].
    ///
    /// # Errors
    /// As [`fit`].
    pub fn fit(&self, avatar: Avatar) -> Result<Fitted, PresetError> {
        fit(avatar, self.triangles)
    }

    /// A texture's size within the preset's: the same, or shrunk until its longest side fits.
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

    /// Brings a texture to the preset's size, unless it is smaller, and encodes it.
    ///
    /// # Errors
    /// [`PresetError`] if the texture cannot be encoded.
    pub fn picture(&self, texture: Texture) -> Result<Picture, PresetError> {
        let found = texture.size();
        let longest = found.width.max(found.height);
        // In whole steps samples fall on texels, whatever the filter; this one is the fastest.
        let is_whole = longest.is_multiple_of(self.texture_side);
        let filter = if is_whole { Filter::Bilinear } else { Filter::CatmullRom };
        let texture = texture.resized(self.texture_size(found), filter, Averaging::Encoded)?;
        Ok(Picture::encode(texture, self.format, JPEG_QUALITY)?)
    }
}
