//! The face on the body's texture.

use std::sync::Arc;

use uvgraft::{Averaging, BlendDomain, Direction, Filter, Graft, Size, Sizes, Texture};
use uvgraft_figure::{Figure, paint_body};
use uvgraft_gltf::preset::Preset;
use uvgraft_io::image::{self, WriteOptions};
use uvgraft_io::pair_file::PairFile;
use uvgraft_pipeline::{BaseSource, KnownTexels, Unit, Values, exclusion_note};

use super::Args;
use super::face::Face;
use super::layout::HeadLayout;
use super::map_transfer::MapTransfer;
use crate::blending::BlendArgs;
use crate::body::skin;
use crate::failure::{Notes, OrBadInput, bad_input, note, warn};
use crate::preview;

/// The textures of an avatar.
pub(super) struct Dressed {
    /// The body's colours with the face.
    pub(super) body: Texture,
    /// The head's own texture, if it keeps its layout.
    pub(super) head: Option<Texture>,
    /// How to transfer the other maps.
    pub(super) map_transfer: MapTransfer,
}

/// The base texture, at the requested size.
///
/// - `preset`: limits the size of the result.
pub(super) fn base(
    args: &Args,
    onto: Option<&BaseSource>,
    preset: Option<&Preset>,
) -> anyhow::Result<Texture> {
    let fit = |size: Size| preset.map_or(size, |preset| preset.texture_size(size));
    match onto {
        None => own_skin(args, fit(args.size.unwrap_or(Size::square(2048)))),
        Some(BaseSource::Image(path)) => {
            let texture = image::read(path).or_bad_input()?.texture;
            let size = fit(args.size.unwrap_or(texture.size()));
            let texture =
                texture.resized(size, Filter::Lanczos3, Averaging::Encoded).or_bad_input()?;
            let depth = texture.depth();
            Ok(texture.converted(uvgraft::Channels::Rgb, depth))
        }
        Some(BaseSource::Color(unit)) => {
            // Plans without a size are rejected earlier.
            let size = args.size.unwrap_or(Size::square(1024));
            let [colors @ .., _] = *unit;
            let (channels, encoding) = (uvgraft::Channels::Rgb, uvgraft::Encoding::Srgb);
            let depth = uvgraft::Depth::U8;
            Texture::filled(fit(size), channels, encoding, depth, &colors).or_bad_input()
        }
    }
}

/// The painted skin of bodies that have one: the figure and the open body.
fn own_skin(args: &Args, size: Size) -> anyhow::Result<Texture> {
    if args.is_figure() {
        return Ok(paint_body(&Figure::new(), size));
    }
    skin::usual(&args.body, size)?.ok_or_else(|| {
        let body = args.body.display();
        bad_input(format!(
            "{body}: --onto is required: the texture of this body, or a colour such as #c08a70"
        ))
    })
}

/// Transfers a face onto a base and blends the border according to the options.
///
/// - `preset`: limits the size of the head's own texture.
pub(super) fn dress(
    args: &Args,
    file: &PairFile,
    face: Face,
    base: Texture,
    preset: Option<&Preset>,
) -> anyhow::Result<Dressed> {
    let path = &*face.file;
    let BlendArgs { source_mask, fill, .. } = &args.blending;
    let known = KnownTexels::read(source_mask.as_deref(), fill.as_deref())?;
    let known = known.with_default_mask(face.confidence, path);
    let face = known.complete(face.texture, Values::Albedo, path)?;
    let how = args.blending.clone().of_avatar();
    let domain = BlendDomain::new(Arc::clone(&file.pair), Direction::Forward);
    let mut region = args.region.region();
    // Bodies are in metres and of human size; otherwise the unit must be given.
    if (0.2..3.0).contains(&domain.extent()) {
        region.unit = region.unit.or(Some(Unit::M));
    }
    let blending = how.blending(args.gutter);
    let blend = blending.prepare(&region, &domain, &known, false, &Notes)?;
    let graft =
        Graft::builder(Arc::clone(&file.pair), Sizes { from: face.size(), to: base.size() })
            .filter(args.filter.map_or(Filter::default(), Filter::from))
            .gutter_px(args.gutter)
            .prefer(args.prefer.into())
            .shared_blend(Arc::clone(&blend))
            .build()?;
    let toning = graft.toning(&face, &base, base.format()).unwrap_or_else(|why| {
        warn(format_args!("{}: {why}; colours left unchanged", path.display()));
        graft.exclusion(&face)
    });
    if let Some(labels) = args.blending.drawn_labels() {
        let found = domain.labels(&face);
        let found = found.map_err(|error| bad_input(format!("{}: {error}", path.display())))?;
        image::write(&found.picture().into(), labels, &WriteOptions::default())?
            .losses
            .iter()
            .for_each(warn);
    }
    let mut shown = &blend;
    if let Some(toning) = &toning {
        let name = path.display();
        exclusion_note(toning).into_iter().for_each(|said| note(format_args!("{name}: {said}")));
        let warnings = toning.report().warnings().into_iter();
        warnings.for_each(|warning| warn(format_args!("{name}: {warning}")));
        shown = toning.narrowed().unwrap_or(shown);
    }
    if let Some(preview) = &args.blending.preview {
        preview::write_region(file, shown, preview)?;
    }
    let head = match args.layout.keeps_head() {
        true => Some(HeadLayout::new(args, file, &blend, shown, toning.as_ref())?),
        false => None,
    };
    let mut overlay = graft.overlay(&face, base.format())?.opaque();
    if let Some(toning) = &toning {
        overlay = overlay.with_tone(toning)?;
    }
    let body = srgb(overlay.lay(0, base)?);
    let map_transfer = MapTransfer {
        pair: Arc::clone(&file.pair),
        blend,
        toning,
        head,
        filter: args.filter.map(Filter::from),
        gutter_px: args.gutter,
        prefer: args.prefer.into(),
        preset: preset.map(|preset| preset.texture_side),
    };
    let head = map_transfer.head_color(face, &body)?.map(srgb);
    Ok(Dressed { body, head, map_transfer })
}

/// With the encoding that files have.
fn srgb(texture: Texture) -> Texture {
    let channels = uvgraft::Channels::Rgb;
    texture.encoded_as(uvgraft::Encoding::Srgb).converted(channels, uvgraft::Depth::U8)
}
