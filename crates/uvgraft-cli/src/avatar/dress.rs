//! A face on a body's texture.

use uvgraft::blend::Ground;
use uvgraft::{Direction, Filter, MapOptions, Pair, Size, Texture, Transfer, TransferOptions};
use uvgraft_io::image;

use super::Args;
use super::face::Face;
use crate::blending::{Blending, Known, Values};
use crate::failure::{OrBadInput, bad_input, warn};
use crate::length::Unit;
use crate::onto::Onto;

/// The texture that a face is laid over, at the size that is wanted.
///
/// - `most`: the longest side that the result may have.
pub(super) fn base(args: &Args, onto: &Onto, most: Option<u32>) -> anyhow::Result<Texture> {
    let fit = |size: Size| match most.map(|most| (most, size.width.max(size.height))) {
        Some((most, side)) if side > most => {
            let shrunk =
                |length: u32| (u64::from(length) * u64::from(most) / u64::from(side)).max(1) as u32;
            Size::new(shrunk(size.width), shrunk(size.height))
        }
        _ => size,
    };
    match onto {
        Onto::Image(path) => {
            let texture = image::read(path).or_bad_input()?.texture;
            let size = fit(args.size.unwrap_or(texture.size()));
            texture.resized(size, Filter::Lanczos3, false).or_bad_input()
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
///
pub(super) fn dress(
    args: &Args,
    pair: &Pair,
    face: Face,
    base: Texture,
) -> anyhow::Result<Texture> {
    let path = &*face.file;
    let known = Known::new(&args.blending)?.or_mask(face.confidence, path);
    let face = known.complete(face.texture, Values::Albedo, path)?;
    let options = TransferOptions {
        filter: args.filter.map_or(Filter::Lanczos3, Filter::from),
        map: MapOptions { gutter_px: args.gutter, prefer: args.prefer.into() },
        ..TransferOptions::default()
    };
    let (direction, size) = (Direction::Forward, base.size());
    let transfer = Transfer::new(pair, direction, face.size(), size, &options);
    let ground = Ground::new(pair, direction);
    let how = args.blending.clone().or_membrane();
    how.check()?;
    let mut region = args.region.clone();
    // Bodies are in metres, and as long as people are; others are asked about.
    if (0.2..3.0).contains(&ground.extent()) {
        region = region.or_unit(Unit::M);
    }
    let blending = Blending::new(&how, &region, args.gutter, &ground, &known, false)?;
    let at = blending.on(transfer.map())?;
    let mut toning = None;
    if how.needs_colors() {
        let name = path.display();
        match blending.blend().toning(&face, &base, base.encoding()) {
            Ok(found) => toning = found,
            Err(why) => warn(format_args!("{name}: {why}; colours are left as they are")),
        }
    }
    let overlay = transfer.overlay(face, base.format())?.blended(&at, toning.as_ref()).opaque();
    let dressed = overlay.lay(0, base)?;
    let channels = uvgraft::Channels::Rgb;
    Ok(dressed.encoded_as(uvgraft::Encoding::Srgb).converted(channels, uvgraft::Depth::U8))
}
