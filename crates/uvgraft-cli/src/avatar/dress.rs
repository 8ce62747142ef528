//! A face on a body's texture.

use std::path::Path;
use std::sync::Arc;

use uvgraft::{Averaging, Direction, Filter, Graft, Ground, Overlay, Size, Sizes, Texture};
use uvgraft_avatar::preset::Preset;
use uvgraft_io::image;
use uvgraft_io::pair_file::PairFile;
use uvgraft_pipeline::{KnownTexels, Onto, Unit, Values};

use super::Args;
use super::face::Face;
use crate::blending::BlendArgs;
use crate::failure::{Notes, OrBadInput, bad_input, warn};
use crate::preview;

/// The texture that a face is laid over, at the size that is wanted.
///
/// - `preset`: what says how large the result may be.
pub(super) fn base(args: &Args, onto: &Onto, preset: Option<&Preset>) -> anyhow::Result<Texture> {
    let fit = |size: Size| preset.map_or(size, |preset| preset.texture_size(size));
    match onto {
        Onto::Image(path) => {
            let texture = image::read(path).or_bad_input()?.texture;
            let size = fit(args.size.unwrap_or(texture.size()));
            let texture =
                texture.resized(size, Filter::Lanczos3, Averaging::Encoded).or_bad_input()?;
            let depth = texture.depth();
            Ok(texture.converted(uvgraft::Channels::Rgb, depth))
        }
        Onto::Color(unit) => {
            let size = args.size.ok_or_else(|| {
                bad_input("a colour has no size: give --size N, or --onto an image")
            })?;
            let [colors @ .., _] = *unit;
            let (channels, encoding) = (uvgraft::Channels::Rgb, uvgraft::Encoding::Srgb);
            let depth = uvgraft::Depth::U8;
            Texture::filled(fit(size), channels, encoding, depth, &colors).or_bad_input()
        }
    }
}

/// Carries a face onto a base, and hides the border as the options say.
pub(super) fn dress(
    args: &Args,
    file: &PairFile,
    face: Face,
    base: Texture,
) -> anyhow::Result<Texture> {
    let path = &*face.file;
    let BlendArgs { source_mask, fill, .. } = &args.blending;
    let known = KnownTexels::read(source_mask.as_deref(), fill.as_deref())?;
    let known = known.or_mask(face.confidence, path);
    let face = known.complete(face.texture, Values::Albedo, path)?;
    let how = args.blending.clone().or_membrane();
    how.check()?;
    let ground = Ground::new(Arc::clone(&file.pair), Direction::Forward);
    let mut region = args.region.region();
    // Bodies are in metres, and as long as people are; others are asked about.
    if (0.2..3.0).contains(&ground.extent()) {
        region.unit = region.unit.or(Some(Unit::M));
    }
    let blending = how.blending(args.gutter);
    let blend = blending.prepare(&region, &ground, &known, false, &Notes)?;
    let graft =
        Graft::builder(Arc::clone(&file.pair), Sizes { from: face.size(), to: base.size() })
            .filter(args.filter.map_or(Filter::default(), Filter::from))
            .gutter_px(args.gutter)
            .prefer(args.prefer.into())
            .shared_blend(Arc::clone(&blend))
            .build()?;
    let toning = graft.toning(&face, &base, base.format()).unwrap_or_else(|why| {
        warn(format_args!("{}: {why}; colours are left as they are", path.display()));
        None
    });
    if let Some(preview) = &args.blending.preview {
        preview::write_region(file, &blend, preview)?;
    }
    let plain = graft.overlay(face, base.format())?.opaque();
    let dressed = match &toning {
        Some(toning) => {
            let toned = plain.clone().toned(toning)?;
            warn_of_tint(&plain, &toned, &base, path)?;
            toned.lay(0, base)?
        }
        None => plain.lay(0, base)?,
    };
    let channels = uvgraft::Channels::Rgb;
    Ok(dressed.encoded_as(uvgraft::Encoding::Srgb).converted(channels, uvgraft::Depth::U8))
}

/// Says so if a tone changes the face as no skin differs from another: then the face has something else
/// at the rim, such as a collar, that is taken for its skin.
fn warn_of_tint(
    plain: &Overlay,
    toned: &Overlay,
    base: &Texture,
    path: &Path,
) -> anyhow::Result<()> {
    /// One row of so many tells enough.
    const ROWS: u32 = 16;
    /// Of the strongest gain to the weakest, as values are encoded: skins stay below 1.3.
    const STRONG: f32 = 1.35;
    let mut gains: [Vec<f32>; 3] = Default::default();
    for row in (0..base.size().height).step_by(ROWS as usize) {
        let band = base.rows(row..row + 1);
        let (before, after) = (plain.lay(row, band.clone())?, toned.lay(row, band.clone())?);
        for x in 0..base.size().width {
            let of = |texture: &Texture| std::array::from_fn(|k| texture.get(x, 0, k));
            let [beneath, before, after]: [[f32; 3]; 3] = [&band, &before, &after].map(of);
            if before != beneath && before != after {
                for channel in 0..3 {
                    gains[channel].push(after[channel] / before[channel].max(1.0 / 255.0));
                }
            }
        }
    }
    let medians = gains.map(|mut gains| {
        let middle = gains.len() / 2;
        if gains.is_empty() { 1.0 } else { *gains.select_nth_unstable_by(middle, f32::total_cmp).1 }
    });
    let most = medians.iter().copied().fold(f32::MIN, f32::max);
    let least = medians.iter().copied().fold(f32::MAX, f32::min);
    if most > STRONG * least {
        warn(format_args!(
            "{}: the body's tone tints the face strongly; if its neck shows a collar or hair, leave that out, \
             as by --grow -60mm",
            path.display()
        ));
    }
    Ok(())
}
