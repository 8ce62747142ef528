//! Frames of tracked videos: their cameras, masks and FLAME parameters.

use glam::{DMat3, DVec3};
use uvgraft::{Averaging, Channels, Depth, Encoding, Filter, Size, Texels, Texture, TextureError};
use uvgraft_avatar::body::{
    BodyError, BodyKind, BodyModel, BodyPose, ModelFile, ReadOptions, Shape,
};
use uvgraft_files::input::Input;
use uvgraft_image as image;
use uvgraft_io::tracking::{TrackedCamera, TrackedFrame};
use uvgraft_pipeline::{Blame, Result};
use uvgraft_selfie::{Camera, Fit, Head, TrackedPhoto};

use super::photo::Photo;

/// The model that a head's file holds, if it is one whose parameters head trackers find.
pub(super) fn flame(file: &Input) -> Option<BodyModel> {
    let file = ModelFile::read(file, &ReadOptions::ALL).ok()?;
    (file.model.kind() == BodyKind::Flame).then_some(file.model)
}

/// A fit by the cameras and parameters of a tracker instead of landmarks; `None` if some parameters
/// are not stored.
pub(super) fn fit(head: &Head, model: &BodyModel, photos: &[Photo]) -> Result<Option<Fit>> {
    let frames: Option<Vec<&TrackedFrame>> =
        photos.iter().map(|photo| photo.tracked.as_ref()).collect();
    let Some(frames) = frames.filter(|frames| !frames.is_empty()) else { return Ok(None) };
    if head.mesh().positions().len() != model.vertices() {
        return Ok(None);
    }
    let shape =
        Shape { betas: of_model(&frames[0].flame.shape, model.betas()), ..Shape::default() };
    let shaped = wide(model.shaped(&shape).or_input()?.positions(), [0.0; 3], 1.0);
    let mut tracked = Vec::with_capacity(photos.len());
    for (photo, frame) in photos.iter().zip(frames) {
        let Some(posed) = posed(model, frame).or_input()? else { return Ok(None) };
        let camera = camera(&frame.camera.for_size(photo.landmarks.size));
        let landmarks = Some(photo.landmarks.points.clone());
        tracked.push(TrackedPhoto { camera, posed, landmarks });
    }
    Ok(Fit::from_tracked(head, shaped, tracked))
}

/// The head of a frame in the tracker's world; `None` if the jaw's rotation is not stored.
fn posed(
    model: &BodyModel,
    frame: &TrackedFrame,
) -> std::result::Result<Option<Vec<DVec3>>, BodyError> {
    let flame = &frame.flame;
    let (Some(jaw), Some([left, right])) = (flame.jaw, flame.eyes) else { return Ok(None) };
    let shape = Shape {
        betas: of_model(&flame.shape, model.betas()),
        expression: of_model(&flame.expression, model.expressions()),
    };
    let turns = vec![flame.rotation, flame.neck, jaw, left, right];
    let pose = BodyPose { translation: [0.0; 3], turns }.to_pose();
    let posed = model.shaped(&shape)?.posed(&pose)?;
    Ok(Some(wide(&posed, flame.translation, flame.scale)))
}

/// Coefficients that a model has.
fn of_model(coefficients: &[f32], most: usize) -> Vec<f32> {
    coefficients[..coefficients.len().min(most)].to_vec()
}

fn wide(positions: &[[f32; 3]], shift: [f32; 3], scale: f32) -> Vec<DVec3> {
    let at = |&position: &[f32; 3]| {
        (glam::Vec3::from(position).as_dvec3() + glam::Vec3::from(shift).as_dvec3())
            * f64::from(scale)
    };
    positions.iter().map(at).collect()
}

/// A tracker's camera. One whose pixels are not square gets the mean of both focal lengths.
fn camera(tracked: &TrackedCamera) -> Camera {
    let [a, b, c, _] = tracked.camera_from_world;
    let row = |[x, y, z, _]: [f64; 4]| DVec3::new(x, y, z);
    Camera {
        rotation: DMat3::from_cols(row(a), row(b), row(c)).transpose(),
        translation: DVec3::new(a[3], b[3], c[3]),
        focal_px: focal_px(tracked),
        center_px: [tracked.cx, tracked.cy],
    }
}

pub(super) fn focal_px(tracked: &TrackedCamera) -> f64 {
    (tracked.fx * tracked.fy).sqrt()
}

/// A frame without what its mask or its own transparency leaves out: that becomes a green which no
/// face or hair has.
pub(super) fn masked(texture: Texture, mask: Option<&Input>) -> Result<Texture> {
    let size = texture.size();
    let opacity = match mask {
        Some(mask) => {
            let mask = image::read_with(mask, Encoding::Data.into())
                .or_input()?
                .texture
                .with_encoding(Encoding::Data);
            let mask = mask.converted(Channels::Grey, Depth::U8);
            Some(mask.resized(size, Filter::Bilinear, Averaging::Encoded).or_input()?)
        }
        None if texture.channels().has_alpha() => Some(alpha(&texture).or_input()?),
        None => None,
    };
    let Some(opacity) = opacity else { return Ok(texture) };
    over_green(texture, &opacity, size).or_input()
}

fn alpha(texture: &Texture) -> std::result::Result<Texture, TextureError> {
    let (size, last) = (texture.size(), texture.channels().count() - 1);
    let Texels::U8(values) = texture.clone().converted(texture.channels(), Depth::U8).into_texels()
    else {
        unreachable!("converted to 8 bits")
    };
    let texels = values.chunks_exact(last + 1).map(|texel| texel[last]).collect();
    Texture::new(size, Channels::Grey, Encoding::Data, Texels::U8(texels))
}

fn over_green(
    texture: Texture,
    opacity: &Texture,
    size: Size,
) -> std::result::Result<Texture, TextureError> {
    const GREEN: [u16; 3] = [0, 200, 90];
    let colors = texture.encoded_as(Encoding::Srgb).converted(Channels::Rgb, Depth::U8);
    let (Texels::U8(mut values), Texels::U8(opacity)) = (colors.into_texels(), opacity.texels())
    else {
        unreachable!("converted to 8 bits")
    };
    for (texel, &opacity) in values.chunks_exact_mut(3).zip(opacity) {
        let share = u16::from(opacity);
        for (value, green) in texel.iter_mut().zip(GREEN) {
            *value = ((u16::from(*value) * share + green * (255 - share) + 127) / 255) as u8;
        }
    }
    Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(values))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_mask_leaves_out_becomes_green() {
        let size = Size::new(2, 1);
        let texels = Texels::U8(vec![10, 20, 30, 255, 10, 20, 30, 0]);
        let picture = Texture::new(size, Channels::Rgba, Encoding::Srgb, texels).unwrap();
        let Texels::U8(values) = masked(picture, None).unwrap().into_texels() else { panic!() };
        assert_eq!(values, [10, 20, 30, 0, 200, 90]);
    }

    #[test]
    fn cameras_project_alike() {
        let tracked = TrackedCamera {
            fx: 900.0,
            fy: 900.0,
            cx: 310.0,
            cy: 260.0,
            size: Size::new(640, 480),
            camera_from_world: [
                [0.0, 0.0, -1.0, 0.1],
                [0.0, 1.0, 0.0, -0.2],
                [1.0, 0.0, 0.0, 2.0],
                [0.0, 0.0, 0.0, 1.0],
            ],
        };
        let point = [0.3, -0.1, 0.2];
        let [x, y] = tracked.project(point).unwrap();
        let [u, v, _] = camera(&tracked).project(point.into());
        assert!((x - u).abs() < 1e-9 && (y - v).abs() < 1e-9);
    }
}
