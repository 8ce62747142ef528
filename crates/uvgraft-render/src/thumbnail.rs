//! Thumbnails: a picture of an avatar's head, for lists of avatars.

use glam::Vec3;
use uvgraft::{Size, Texture};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::rig::HumanBone;
use uvgraft_gltf::glb::{self, AvatarMaterial, Export, GlbError};
use uvgraft_gltf::scene::{PoseRequest, PoseRequestError, Scene, SceneError};

use crate::{Bounds, Perspective, RenderOptions, Renderer};

/// Why a thumbnail could not be rendered.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ThumbnailError {
    /// The avatar cannot be written as a GLB file.
    #[error(transparent)]
    Glb(#[from] GlbError),
    /// The renderer cannot read the avatar as a scene, for example because of textures in an
    /// unsupported format.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The avatar cannot be posed.
    #[error(transparent)]
    PoseRequest(#[from] PoseRequestError),
}

/// Renders an avatar's head in the rest pose, slightly from the side, as a square of `side` texels.
/// An avatar without a head is shown as a whole.
///
/// - `materials`: as for [`glb::write()`], in formats that the renderer reads: PNG, JPEG and WebP.
///
/// # Errors
/// [`ThumbnailError`] if the avatar cannot be rendered.
///
/// # Panics
/// If `side` is 0, or larger than a quarter of [`Texture::MAX_SIDE`].
pub fn thumbnail(
    avatar: &Avatar,
    materials: &[AvatarMaterial],
    side: u32,
) -> Result<Texture, ThumbnailError> {
    const AZIMUTH: f32 = 12.0;
    const ELEVATION: f32 = 2.0;
    const FOV_Y: f32 = 18.0;
    let still = Avatar { clips: Vec::new(), ..avatar.clone() };
    let scene = Scene::read(&glb::write(&still, materials, &Export::default())?.bytes)?;
    let bounds = head(avatar).or_else(|| Bounds::of(avatar.mesh.positions().iter().copied()));
    let bounds = bounds.unwrap_or(Bounds { low: [-1.0; 3], high: [1.0; 3] });
    let camera = Perspective::framing(&bounds, AZIMUTH, ELEVATION, FOV_Y, 1.0, 1.0);
    let drawn = scene.pose(&PoseRequest::default())?;
    // 4 × 4 samples would take four times as long, for a difference nobody sees at this size.
    let options = RenderOptions { samples: 2, ..RenderOptions::default() };
    Ok(Renderer::for_scene(&scene).render(&drawn, &camera, &options, Size::square(side)))
}

/// The bounding box of the vertices that mostly follow the head, extended downwards to include some
/// of the neck.
fn head(avatar: &Avatar) -> Option<Bounds> {
    let head = avatar.skeleton.human(HumanBone::Head)?;
    let weights = avatar.skin.weights_below(&avatar.skeleton, head);
    let mut is_used = vec![false; avatar.mesh.positions().len()];
    for &vertex in avatar.mesh.faces().as_flattened() {
        is_used[vertex as usize] = true;
    }
    let of_head = (0..weights.len()).filter(|&vertex| is_used[vertex] && weights[vertex] > 0.5);
    let bounds = Bounds::of(of_head.map(|vertex| avatar.mesh.positions()[vertex]))?;
    let (low, high) = (Vec3::from(bounds.low), Vec3::from(bounds.high));
    let neck = Vec3::new(0.0, 0.12 * (high - low).y, 0.0);
    Some(Bounds { low: (low - neck).into(), high: bounds.high })
}

#[cfg(test)]
mod tests {
    use uvgraft::{Channels, Depth, Encoding};
    use uvgraft_figure::Figure;
    use uvgraft_gltf::glb::{EmbeddedFormat, EmbeddedImage};

    use super::*;

    #[test]
    fn the_head_fills_the_picture() {
        let avatar = Figure::new().avatar();
        let red = [0.9, 0.1, 0.1];
        let texture =
            Texture::filled(Size::square(8), Channels::Rgb, Encoding::Srgb, Depth::U8, &red);
        let picture = EmbeddedImage::encode(texture.unwrap(), EmbeddedFormat::Png, 90).unwrap();
        let picture = thumbnail(&avatar, &[AvatarMaterial::new(picture)], 64).unwrap();
        assert_eq!(picture.size(), Size::square(64));
        // The background is grey.
        let is_head = |x, y| picture.get(x, y, 0) > picture.get(x, y, 1) + 0.1;
        let middle: Vec<u32> = (0..64).filter(|&y| is_head(32, y)).collect();
        assert!(middle.len() > 50 && middle[0] > 0 && middle[0] < 8, "{middle:?}");
        let wide = (0..64).filter(|&x| is_head(x, 26)).count();
        assert!((28..60).contains(&wide), "{wide}");
        assert!(!is_head(1, 1) && !is_head(62, 1));
    }
}
