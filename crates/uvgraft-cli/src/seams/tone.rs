//! How well the tone of the face matches that of the body.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::Context;
use serde::Serialize;
use uvgraft::{Anatomy, Area, BlendDomain, Size, Texture};
use uvgraft_image::{self as image, OpenImage};
use uvgraft_metrics::seams::{
    SkinColors, ToneMatch, ToneReferences, TransferredFace, measure_tone,
};

use super::region::CutRegion;
use crate::failure::{OrBadInput, bad_input};
use crate::heading;

#[derive(clap::Args)]
#[command(next_help_heading = heading::TONE)]
pub(super) struct ToneArgs {
    /// Base texture before the transfer, for comparing its tone
    ///
    /// In the layout and size of the measured texture. Its own face must show skin: a blank head
    /// has no tone.
    #[arg(long, value_name = "BASE")]
    onto: Option<PathBuf>,
    /// Face texture before the transfer, for comparing its colours
    ///
    /// In the pair's other layout, of any size.
    #[arg(long, value_name = "SOURCE")]
    face: Option<PathBuf>,
}

/// What the tone of the texture is compared with.
pub(super) struct References {
    pub base: Option<Texture>,
    face: Option<Texture>,
}

impl ToneArgs {
    /// The input files.
    pub fn inputs(&self) -> impl Iterator<Item = &Path> {
        [&self.onto, &self.face].into_iter().filter_map(|path| path.as_deref())
    }

    /// Opens the textures to compare with.
    ///
    /// - `size`: of the measured texture.
    pub fn open(&self, size: Size) -> anyhow::Result<OpenReferences> {
        let open =
            |path: &Option<PathBuf>| path.as_deref().map(image::open).transpose().or_bad_input();
        let base = open(&self.onto)?;
        if let Some(base) = &base
            && base.header().size != size
        {
            let (name, found) = (base.name().display(), base.header().size);
            return Err(bad_input(format!(
                "{name}: base must have the size of the texture, {size}, got {found}"
            )));
        }
        Ok(OpenReferences { base, face: open(&self.face)? })
    }
}

/// Textures whose headers were read.
pub(super) struct OpenReferences {
    base: Option<OpenImage>,
    face: Option<OpenImage>,
}

impl OpenReferences {
    /// The images.
    pub fn images(&self) -> impl Iterator<Item = &OpenImage> {
        [&self.base, &self.face].into_iter().flatten()
    }

    pub fn decode(self) -> anyhow::Result<References> {
        let decoded = |image: Option<OpenImage>| {
            let image = image.map(OpenImage::decode).transpose().or_bad_input()?;
            anyhow::Ok(image.map(|image| image.texture))
        };
        Ok(References { base: decoded(self.base)?, face: decoded(self.face)? })
    }
}

/// Measures the tone on the mesh of a head; `None` if it has none.
pub(super) fn measured(
    anatomy: Option<&Anatomy>,
    domain: &BlendDomain,
    region: &CutRegion,
    texture: &Texture,
    references: &References,
) -> anyhow::Result<Option<ToneMatch>> {
    let Some(anatomy) = anatomy else { return Ok(None) };
    let paste = |face| TransferredFace::new(domain, face, texture.size());
    let face =
        references.face.as_ref().map(paste).transpose().context("cannot transfer the face")?;
    let references = ToneReferences { base: references.base.as_ref(), face: face.as_ref() };
    let cut = &region.cut;
    let tone = measure_tone(&cut.mesh, anatomy, texture, &cut.inside, references).or_bad_input()?;
    Ok(Some(tone))
}

/// The JSON report.
#[derive(Serialize)]
pub(super) struct Document {
    /// CIEDE2000 between the mean colours of cheeks and chest.
    cheek_to_chest: Option<f64>,
    /// The same for the base.
    own: Option<f64>,
    /// `"chest"`, or `"neck"` for meshes without a chest.
    chest: Option<&'static str>,
    /// Median CIEDE2000 between hair and brows and those of the face.
    hair_shift: Option<f64>,
    /// Share of clipped skin, 0 to 1.
    clipped: Option<f64>,
    /// Whether nothing warrants a warning.
    fits: bool,
}

impl Document {
    pub fn new(tone: &ToneMatch) -> Self {
        Self {
            cheek_to_chest: tone.skin.map(|skin| skin.delta_e()),
            own: tone.own.map(|own| own.delta_e()),
            chest: tone.skin.map(chest),
            hair_shift: tone.hair_shift,
            clipped: tone.clipped,
            fits: tone.matches_body() && !tone.is_clipped(),
        }
    }
}

/// The area that the cheeks are compared with.
pub(super) fn chest(skin: SkinColors) -> &'static str {
    if skin.chest_area == Area::Neck { "neck" } else { "chest" }
}

/// The text report, one line for each known measure.
pub(super) fn lines(tone: &ToneMatch) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(skin) = tone.skin {
        let mut line = format!("cheek to {}: ΔE {:.1}", chest(skin), skin.delta_e());
        if let Some(own) = tone.own {
            let _ = write!(line, " (base: {:.1})", own.delta_e());
        }
        lines.push(line);
    }
    if let Some(shift) = tone.hair_shift {
        lines.push(format!("hair and brows: shifted by ΔE {shift:.1} from the source"));
    }
    if let Some(clipped) = tone.clipped {
        lines.push(format!("clipped: {:.2} % of the transferred skin", clipped * 100.0));
    }
    lines
}

/// What is wrong with the tone, if anything.
pub(super) fn verdict(tone: &ToneMatch) -> Option<String> {
    let mut reasons = Vec::new();
    if let (Some(skin), Some(excess), false) = (tone.skin, tone.excess(), tone.matches_body()) {
        let more = if excess > 0.0 { "more" } else { "less" };
        reasons.push(format!(
            "its cheeks differ from the {} by ΔE {:.1} {more} than the base's",
            chest(skin),
            excess.abs()
        ));
    }
    if tone.is_clipped() {
        reasons.push("its highlights are clipped".to_owned());
    }
    (!reasons.is_empty())
        .then(|| format!("The face does not match the body's tone: {}.", reasons.join(", and ")))
}
