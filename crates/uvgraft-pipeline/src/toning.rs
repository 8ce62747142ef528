//! How a blend changes a texture: its tone on the base, and what is left out of it.

use std::borrow::Cow;

use uvgraft::{Graft, Overlay, TexelFormat, Texture, ToneCorrection, ToneError};

/// The tone of a texture on its base and what is left out of the texture, and warnings. Where no tone
/// can be found, colours stay as they are.
///
/// - `is_toned`: whether the texture holds colours. Other maps take labels from the albedo, if it has
///   any.
/// - `format`: that of the base.
/// - `colors`: those of the base, if they are needed.
///
/// # Errors
/// Those of `colors`.
pub fn toning<'b, E>(
    graft: &Graft,
    texture: &Texture,
    is_toned: bool,
    format: TexelFormat,
    colors: impl FnOnce() -> Result<Cow<'b, Texture>, E>,
) -> Result<(Option<ToneCorrection>, Vec<String>), E> {
    let mut warnings = Vec::new();
    let Some(blend) = graft.blend().filter(|blend| blend.options().needs_labels()) else {
        return Ok((None, warnings));
    };
    let toning = if is_toned && blend.options().needs_colors() {
        graft.toning(texture, &*colors()?, format).unwrap_or_else(|why| {
            warnings.push(format!("{why}; colours left unchanged"));
            graft.exclusion(texture)
        })
    } else if is_toned || blend.has_labels() {
        graft.exclusion(texture)
    } else {
        None
    };
    warnings.extend(toning.iter().flat_map(|toning| toning.report().warnings()));
    Ok((toning, warnings))
}

/// An overlay with its tone, if it holds colours, and without what is left out.
///
/// # Errors
/// As [`Overlay::with_tone`].
pub fn toned(
    overlay: Overlay,
    toning: Option<&ToneCorrection>,
    is_toned: bool,
) -> Result<Overlay, ToneError> {
    match toning {
        None => Ok(overlay),
        Some(toning) if is_toned => overlay.with_tone(toning),
        Some(toning) => overlay.with_exclusion(toning),
    }
}
