//! The texture of a head from photographs: projected, freed of light and of what is not the face,
//! fused, and completed where nothing was seen.

use glam::DVec3;
use uvgraft::easing::smoothstep;
use uvgraft::labels::{Labeller, Labels};
use uvgraft::statistics::median_color;
use uvgraft::threads::map_indices;
use uvgraft::{Area, Channels, Encoding, LabelError, Size, Texels, Texture, TextureError};
use uvgraft_avatar::eyes::clean_head;

use crate::completion::Completion;
use crate::fit::{Fit, FittedPhoto};
use crate::fusion::{Fused, Fusion, Layer};
use crate::head::Head;
use crate::iris::eye_colors;
use crate::layout_texels::LayoutTexels;
use crate::light::{Light, Relight, SkinSample};
use crate::outline::FaceOutlines;
use crate::projection::{Projection, ProjectionError, project};
use crate::segmentation::{Evidence, Segmentation};

/// How textures are made.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct TextureOptions {
    /// Size of the texture in texels.
    pub size: Size,
    /// How much of the photographs' light is taken out.
    pub relight: Relight,
}

impl Default for TextureOptions {
    fn default() -> Self {
        Self { size: Size::square(2048), relight: Relight::default() }
    }
}

/// Why no texture was made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SelfieError {
    /// A photograph cannot be transferred.
    #[error(transparent)]
    Projection(#[from] ProjectionError),
    /// What a photograph shows cannot be labelled.
    #[error(transparent)]
    Label(#[from] LabelError),
    /// The texture cannot be made.
    #[error(transparent)]
    Texture(#[from] TextureError),
}

/// A head's texture from photographs.
#[derive(Debug, Clone)]
pub struct SelfieTexture {
    /// Colours, complete: RGB, 8-bit sRGB.
    pub texture: Texture,
    /// What the photographs show, grey data: 255 where a texel is known fully. Eyes, which are painted,
    /// and the rims of lids are not.
    pub known: Texture,
}

/// The texture of a head from the photographs that it was fitted to.
///
/// # Errors
/// [`SelfieError`]
///
/// # Panics
/// If there are not as many photographs as in the fit.
pub fn textured(
    head: &Head,
    fit: &Fit,
    photos: &[Texture],
    options: &TextureOptions,
) -> Result<SelfieTexture, SelfieError> {
    assert_eq!(fit.photos.len(), photos.len(), "photographs");
    let texels = LayoutTexels::new(&head.mesh, options.size);
    let labeller = Labeller::with_anatomy(&head.mesh, head.anatomy.clone());
    let mut fusion = Fusion::new(options.size);
    let mut scalps = Vec::new();
    let mut colors_of_eyes = None;
    for index in by_frontality(head, fit) {
        let fitted = &fit.photos[index];
        let seen = project(head, &texels, &photos[index], &fitted.camera, &fitted.posed)?;
        let labels = labelled(&labeller, &seen, options.size);
        let (layer, scalp) = layer(head, &texels, seen, labels.as_ref(), fitted, options.relight);
        fusion.add(layer);
        colors_of_eyes = colors_of_eyes.or_else(|| {
            let outlines = FaceOutlines::new(&fitted.landmarks);
            eye_colors(&photos[index], &outlines, unit_px(head, fitted))
        });
        scalps.extend(scalp);
    }
    let Fused { colors, known, certain } = fusion.finish();
    let completed = Completion::new(head, &texels).complete(colors, &known, median_color(scalps));
    let bytes = |value: f32| (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    let colors = Texels::U8(completed.iter().flat_map(|color| color.map(bytes)).collect());
    let mut texture = Texture::new(options.size, Channels::Rgb, Encoding::Srgb, colors)?;
    let eyes: Vec<&[u32]> =
        head.components.eyeballs.iter().map(|ball| ball.vertices.as_slice()).collect();
    let at = |x: u32, y: u32| y as usize * options.size.width as usize + x as usize;
    let is_seen = |x, y| known[at(x, y)] > 0.5;
    clean_head(&head.mesh, &eyes, &mut texture, is_seen, colors_of_eyes);
    // Eyes are painted anew.
    let of_texel = |(at, &certain): (usize, &f32)| {
        let is_eye = texels.face(at).is_some_and(|face| head.components.is_eye(&head.mesh, face));
        if is_eye { 0 } else { bytes(certain) }
    };
    let taken = certain.iter().enumerate().map(of_texel).collect();
    let known = Texture::new(options.size, Channels::Grey, Encoding::Data, Texels::U8(taken))?;
    Ok(SelfieTexture { texture, known })
}

/// The photographs, those that see the face from the front first.
fn by_frontality(head: &Head, fit: &Fit) -> Vec<usize> {
    let forward = DVec3::from(head.anatomy.frame().axes[2]);
    let ahead = |index: &usize| fit.photos[*index].camera.rotation.transpose().z_axis.dot(forward);
    let mut order: Vec<usize> = (0..fit.photos.len()).collect();
    // Cameras look backwards along the face's forward axis.
    order.sort_by(|a, b| ahead(a).total_cmp(&ahead(b)));
    order
}

/// Labels of what is seen; `None` if the cheeks are not seen well enough.
fn labelled(labeller: &Labeller, seen: &Projection, size: Size) -> Option<Labels> {
    let texels = seen
        .colors
        .iter()
        .zip(&seen.seen)
        .flat_map(|(&[r, g, b], &seen)| [r, g, b, (255.0 * smoothstep(0.0, 0.15, seen)) as u8]);
    let texels = Texels::U8(texels.collect());
    let texture = Texture::new(size, Channels::Rgba, Encoding::Srgb, texels).ok()?;
    labeller.label(&texture).ok()
}

/// What a photograph tells of each texel, and the colour of the scalp in it.
fn layer(
    head: &Head,
    texels: &LayoutTexels,
    seen: Projection,
    labels: Option<&Labels>,
    photo: &FittedPhoto,
    relight: Relight,
) -> (Layer, Option<[f32; 3]>) {
    let normal = |texel: usize| {
        let place = texels.place(texel)?;
        let corners = head.mesh.faces()[place.face as usize];
        let sum: DVec3 = (0..3).map(|k| seen.normals[corners[k] as usize] * place.weights[k]).sum();
        Some(sum.normalize_or_zero())
    };
    let light = light(head, texels, &seen, &normal);
    let colors = map_indices(seen.seen.len(), |texel| {
        let color = unit_color(seen.colors[texel]);
        if seen.seen[texel] <= 0.0 {
            return color;
        }
        match (&light, normal(texel)) {
            (Some(light), Some(normal)) => light.removed(color, normal, relight),
            _ => color,
        }
    });
    let frame = head.anatomy.frame();
    let height = |position: &[f32; 3]| frame.local(position.map(f64::from))[1] as f32;
    let heights: Vec<f32> = head.mesh.positions().iter().map(height).collect();
    let evidence = Evidence {
        head,
        texels,
        colors: &colors,
        seen: &seen.seen,
        facing: &seen.facing,
        px: &seen.px,
        outlines: &FaceOutlines::new(&photo.landmarks),
        unit_px: unit_px(head, photo),
        labels,
        heights: &heights,
    };
    let Segmentation { face, scalp } = evidence.segment();
    let shares = || seen.seen.iter().zip(&face);
    let known = shares().map(|(seen, face)| seen * face).collect();
    let denied = shares().map(|(seen, face)| seen * (1.0 - face)).collect();
    (Layer { colors, known, denied, apart: seen.apart, facing: seen.facing }, scalp)
}

/// The distance between the eyes in a photograph, in pixels.
fn unit_px(head: &Head, photo: &FittedPhoto) -> f64 {
    let middle = photo.camera.view(DVec3::from(head.anatomy.frame().origin));
    photo.camera.scale(middle.z) * head.unit()
}

fn unit_color(color: [u8; 3]) -> [f32; 3] {
    color.map(|value| f32::from(value) / 255.0)
}

/// The light on plain skin.
fn light(
    head: &Head,
    texels: &LayoutTexels,
    seen: &Projection,
    normal: &impl Fn(usize) -> Option<DVec3>,
) -> Option<Light> {
    const SAMPLES: usize = 20_000;
    const PLAIN: [Area; 4] = [Area::Cheeks, Area::Forehead, Area::Nose, Area::Jaw];
    let is_plain = |face: &[u32; 3]| {
        face.iter()
            .all(|&vertex| PLAIN.iter().any(|&area| head.anatomy.area(area)[vertex as usize] > 0.5))
    };
    let plain: Vec<bool> = head.mesh.faces().iter().map(is_plain).collect();
    let is_sample = |&texel: &usize| {
        seen.seen[texel] > 0.3 && texels.face(texel).is_some_and(|face| plain[face as usize])
    };
    let clear: Vec<usize> = (0..seen.seen.len()).filter(is_sample).collect();
    let step = clear.len().div_ceil(SAMPLES).max(1);
    let sample = |texel: usize| {
        let color = unit_color(seen.colors[texel]);
        Some(SkinSample { normal: normal(texel)?, color, weight: seen.seen[texel].into() })
    };
    let samples: Vec<SkinSample> = clear.into_iter().step_by(step).filter_map(sample).collect();
    Light::of_skin(&samples, DVec3::from(head.anatomy.frame().axes[2]))
}
