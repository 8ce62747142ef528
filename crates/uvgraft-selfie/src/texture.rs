//! The texture of a head from photographs: projected, freed of light and of what is not the face,
//! fused, and completed where nothing was seen.

use glam::DVec3;
use uvgraft::easing::smoothstep;
use uvgraft::labels::{Labeller, Labels};
use uvgraft::threads::map_indices;
use uvgraft::{Area, Channels, Encoding, Label, LabelError, Size, Texels, Texture, TextureError};

use crate::completion::Completion;
use crate::fit::Fit;
use crate::fusion::{Fusion, Layer};
use crate::head::Head;
use crate::head_landmarks::normals;
use crate::layout_texels::LayoutTexels;
use crate::light::{Light, Relight, SkinSample};
use crate::projection::{Projection, ProjectionError, project};
use crate::raster::blurred;

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
    /// A photograph cannot be carried over.
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
    /// What the photographs show, grey data: 255 where a texel is known fully.
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
    let labeller = Labeller::new(&head.mesh)?;
    let mut fusion = Fusion::new(options.size);
    let mut hair = Vec::new();
    for index in by_frontality(head, fit) {
        let fitted = &fit.photos[index];
        let seen = project(head, &texels, &photos[index], &fitted.camera, &fitted.posed)?;
        let posed: Vec<[f32; 3]> = fitted.posed.iter().map(|at| at.as_vec3().to_array()).collect();
        let normals = normals(&posed, head.mesh.faces());
        let labels = labelled(&labeller, &seen, options.size);
        let (layer, of_hair) = layer(head, &texels, seen, labels.as_ref(), &normals, options);
        fusion.add(layer);
        hair.extend(of_hair);
    }
    let (colors, known) = fusion.finish();
    let completed = Completion::new(head, &texels).complete(colors, &known, median(&hair));
    let bytes = |value: f32| (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    let colors = Texels::U8(completed.iter().flat_map(|color| color.map(bytes)).collect());
    let known = Texels::U8(known.iter().map(|&known| bytes(known)).collect());
    Ok(SelfieTexture {
        texture: Texture::new(options.size, Channels::Rgb, Encoding::Srgb, colors)?,
        known: Texture::new(options.size, Channels::Grey, Encoding::Data, known)?,
    })
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

/// What a photograph tells of each texel, and the colours of hair in it.
fn layer(
    head: &Head,
    texels: &LayoutTexels,
    seen: Projection,
    labels: Option<&Labels>,
    normals: &[DVec3],
    options: &TextureOptions,
) -> (Layer, Vec<[f32; 3]>) {
    let size = options.size;
    let normal = |texel: usize| {
        let place = texels.place(texel)?;
        let corners = head.mesh.faces()[place.face as usize];
        let sum: DVec3 = (0..3).map(|k| normals[corners[k] as usize] * place.weights[k]).sum();
        Some(sum.normalize_or_zero())
    };
    let label = |label: Label, texel: usize| {
        labels
            .map_or(f32::from(label == Label::Skin), |labels| labels.at_uv(label, uv(size, texel)))
    };
    let wide = |[r, g, b]: [u8; 3]| [r, g, b].map(|value| f32::from(value) / 255.0);
    let light = light(head, &seen, &normal, &label, &wide);
    let kept = map_indices(size.texels(), |texel| {
        if seen.seen[texel] <= 0.0 {
            return [0.0];
        }
        let face: f32 = [Label::Skin, Label::Lip, Label::Brow, Label::Eye]
            .into_iter()
            .map(|of_face| label(of_face, texel))
            .sum();
        [smoothstep(0.5, 0.9, face)]
    });
    // What is beside hair or cloth is mixed with it.
    let radius = (size.width.max(size.height) as usize / 512).max(1);
    let around = blurred(size, &kept, radius);
    let known = (0..size.texels())
        .map(|texel| seen.seen[texel] * kept[texel][0] * smoothstep(0.5, 0.95, around[texel][0]))
        .collect();
    let hair = hair(head, texels, &seen, &label, &wide);
    let colors = map_indices(size.texels(), |texel| {
        let color = wide(seen.colors[texel]);
        match (&light, normal(texel)) {
            (Some(light), Some(normal)) if seen.seen[texel] > 0.0 => {
                light.removed(color, normal, options.relight)
            }
            _ => color,
        }
    });
    (Layer { colors, known, facing: seen.facing }, hair)
}

fn uv(size: Size, texel: usize) -> [f64; 2] {
    let width = size.width as usize;
    [
        ((texel % width) as f64 + 0.5) / f64::from(size.width),
        ((texel / width) as f64 + 0.5) / f64::from(size.height),
    ]
}

fn light(
    head: &Head,
    seen: &Projection,
    normal: &impl Fn(usize) -> Option<DVec3>,
    label: &impl Fn(Label, usize) -> f32,
    wide: &impl Fn([u8; 3]) -> [f32; 3],
) -> Option<Light> {
    const SAMPLES: usize = 20_000;
    let clear: Vec<usize> = (0..seen.seen.len()).filter(|&at| seen.seen[at] > 0.3).collect();
    let step = clear.len().div_ceil(SAMPLES).max(1);
    let samples: Vec<SkinSample> = clear
        .into_iter()
        .step_by(step)
        .filter(|&texel| label(Label::Skin, texel) > 0.8)
        .filter_map(|texel| {
            let weight = f64::from(seen.seen[texel]);
            Some(SkinSample { normal: normal(texel)?, color: wide(seen.colors[texel]), weight })
        })
        .collect();
    Light::of_skin(&samples, DVec3::from(head.anatomy.frame().axes[2]))
}

/// Colours of the hair of the head that is seen clearly.
fn hair(
    head: &Head,
    texels: &LayoutTexels,
    seen: &Projection,
    label: &impl Fn(Label, usize) -> f32,
    wide: &impl Fn([u8; 3]) -> [f32; 3],
) -> Vec<[f32; 3]> {
    const STEP: usize = 7;
    let scalp = head.anatomy.area(Area::Scalp);
    let is_scalp = |texel: usize| {
        texels.face(texel).is_some_and(|face| {
            head.mesh.faces()[face as usize].iter().all(|&vertex| scalp[vertex as usize] > 0.5)
        })
    };
    (0..seen.seen.len())
        .step_by(STEP)
        .filter(|&at| seen.seen[at] > 0.4 && label(Label::Hair, at) > 0.7 && is_scalp(at))
        .map(|texel| wide(seen.colors[texel]))
        .collect()
}

/// The median of each channel; `None` of too few.
fn median(colors: &[[f32; 3]]) -> Option<[f32; 3]> {
    const FEWEST: usize = 100;
    (colors.len() >= FEWEST).then(|| {
        std::array::from_fn(|k| {
            let mut values: Vec<f32> = colors.iter().map(|color| color[k]).collect();
            let middle = values.len() / 2;
            *values.select_nth_unstable_by(middle, f32::total_cmp).1
        })
    })
}
