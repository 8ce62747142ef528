//! Transfers the face onto the body's texture.

use std::path::Path;
use std::sync::Arc;

use uvgraft::{
    Averaging, BlendDomain, Direction, Filter, Graft, Size, Sizes, Texture, ToneCorrection,
};
use uvgraft_figure::{Figure, paint_body};
use uvgraft_gltf::preset::Preset;
use uvgraft_image as image;
use uvgraft_io::pair_file::PairFile;
use uvgraft_pipeline::{
    BaseSource, Blame, Failure, KnownTexels, Observer, Region, Result, Unit, Values,
    exclusion_note, toned,
};

use super::face::Face;
use super::layout::HeadLayout;
use super::map_transfer::MapTransfer;
use super::request::{AvatarRequest, Body, TextureLayout};
use crate::{pair_picture, skin};

/// The textures of an avatar.
pub(super) struct AvatarTextures<'a> {
    /// The body's colours with the face.
    pub(super) body: Texture,
    /// The head's own texture, if it keeps its layout.
    pub(super) head: Option<Texture>,
    /// How to transfer the other maps.
    pub(super) map_transfer: MapTransfer<'a>,
    /// The region and its weights on both layouts, if wanted.
    pub(super) preview: Option<Texture>,
    /// The detected labels of the face, if wanted.
    pub(super) labels: Option<Texture>,
}

/// The base texture, at the requested size.
///
/// - `preset`: limits the size of the result.
pub(super) fn base_texture(request: &AvatarRequest, preset: Option<&Preset>) -> Result<Texture> {
    let asked = request.textures.size;
    let fit = |size: Size| preset.map_or(size, |preset| preset.texture_size(size));
    match &request.onto {
        None => own_skin(request, fit(asked.unwrap_or(Size::square(2048)))),
        Some(BaseSource::Image(image)) => {
            let texture = image::read(image).or_input()?.texture;
            let size = fit(asked.unwrap_or(texture.size()));
            let texture = texture.resized(size, Filter::Lanczos3, Averaging::Encoded).or_input()?;
            let depth = texture.depth();
            Ok(texture.converted(uvgraft::Channels::Rgb, depth))
        }
        Some(BaseSource::Color(unit)) => {
            // Plans without a size are rejected earlier.
            let size = asked.unwrap_or(Size::square(1024));
            let [colors @ .., _] = *unit;
            let (channels, encoding) = (uvgraft::Channels::Rgb, uvgraft::Encoding::Srgb);
            let depth = uvgraft::Depth::U8;
            Texture::filled(fit(size), channels, encoding, depth, &colors).or_input()
        }
    }
}

/// The painted skin of bodies that have one: the figure and the open body.
fn own_skin(request: &AvatarRequest, size: Size) -> Result<Texture> {
    let model = match &request.body {
        Body::Figure => return Ok(paint_body(&Figure::new(), size)),
        Body::Model(model) => model,
    };
    skin::usual(model, size)?.ok_or_else(|| {
        Failure::option(format!(
            "{model}: `onto` is required: the texture of this body, or a colour such as #c08a70"
        ))
    })
}

/// Transfers a face onto a base and blends the border according to the options.
///
/// - `preset`: limits the size of the head's own texture.
pub(super) fn transfer_face<'a>(
    request: &AvatarRequest,
    file: &PairFile,
    face: Face,
    base: Texture,
    preset: Option<&Preset>,
    observer: &'a dyn Observer,
) -> Result<AvatarTextures<'a>> {
    let path = &*face.name;
    let known = KnownTexels::read(request.source_mask.as_ref(), request.fill.as_ref())?;
    let known = known.with_default_mask(face.confidence, path);
    let face = known.complete(face.texture, Values::Albedo, path)?;
    let how = request.blending.clone().of_avatar();
    let domain = BlendDomain::new(Arc::clone(&file.pair), Direction::Forward);
    let region = in_metres(request.region.clone(), &domain);
    let textures = &request.textures;
    let blending = how.blending(textures.gutter_px);
    let blend = blending.prepare(&region, &domain, &known, false, observer)?;
    let graft =
        Graft::builder(Arc::clone(&file.pair), Sizes { from: face.size(), to: base.size() })
            .filter(textures.filter.unwrap_or_default())
            .gutter_px(textures.gutter_px)
            .prefer(textures.prefer)
            .shared_blend(Arc::clone(&blend))
            .build()
            .or_work()?;
    let toning = graft.toning(&face, &base, base.format()).unwrap_or_else(|why| {
        observer.warn(format_args!("{}: {why}; colours left unchanged", path.display()));
        graft.exclusion(&face)
    });
    let labels = request.blending.draw_labels.then(|| domain.labels(&face)).transpose();
    let labels = labels.map_err(|error| Failure::input(format!("{}: {error}", path.display())))?;
    toning.iter().for_each(|toning| report_toning(toning, path, observer));
    let shown = toning.as_ref().and_then(ToneCorrection::narrowed).unwrap_or(&blend);
    let preview = request.preview.then(|| pair_picture::of_region(file, shown)?.into_texture());
    let preview = preview.transpose()?;
    let has_own = textures.layout == TextureLayout::HeadBody;
    let head = has_own.then(|| HeadLayout::new(request, file, &blend, shown, toning.as_ref()));
    let head = head.transpose()?;
    let overlay = graft.overlay(&face, base.format()).or_work()?.opaque();
    let overlay = toned(overlay, toning.as_ref(), true).or_work()?;
    let body = srgb(overlay.lay(0, base).or_work()?);
    let map_transfer = MapTransfer {
        pair: Arc::clone(&file.pair),
        blend,
        toning,
        head,
        filter: textures.filter,
        gutter_px: textures.gutter_px,
        prefer: textures.prefer,
        preset: preset.map(|preset| preset.texture_side),
        observer,
    };
    let head = map_transfer.head_color(face, &body)?.map(srgb);
    let labels = labels.map(|labels| labels.picture());
    Ok(AvatarTextures { body, head, map_transfer, preview, labels })
}

/// Bodies are in metres and of human size; otherwise the unit must be given.
fn in_metres(mut region: Region, domain: &BlendDomain) -> Region {
    if (0.2..3.0).contains(&domain.extent()) {
        region.unit = region.unit.or(Some(Unit::M));
    }
    region
}

fn report_toning(toning: &ToneCorrection, face: &Path, observer: &dyn Observer) {
    let name = face.display();
    exclusion_note(toning)
        .into_iter()
        .for_each(|said| observer.note(format_args!("{name}: {said}")));
    let warnings = toning.report().warnings().into_iter();
    warnings.for_each(|warning| observer.warn(format_args!("{name}: {warning}")));
}

/// With the encoding that files have.
fn srgb(texture: Texture) -> Texture {
    let channels = uvgraft::Channels::Rgb;
    texture.encoded_as(uvgraft::Encoding::Srgb).converted(channels, uvgraft::Depth::U8)
}
