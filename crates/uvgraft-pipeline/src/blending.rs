//! How a texture becomes one with what it is laid over, from files.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use uvgraft::blend::Side;
use uvgraft::blend::{Blend, BlendOptions, Ground, Tone};
use uvgraft::fill::{self, FillError};
use uvgraft::{Direction, Labels, Texture, Toning};
use uvgraft_io::image;

use crate::failure::{Blame, Failure, Result};
use crate::length::Length;
use crate::material::Values;
use crate::observer::Observer;
use crate::region::Region;

/// How a texture becomes one with what it is laid over.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Blending {
    /// Over which length along the surface the base gives way to the texture, inwards from the rim.
    pub feather: Length,
    /// Whether a membrane takes the tone of one side along the rim to the other.
    pub membrane: bool,
    /// Whether one side's skin gets the mean and the covariance of the other's.
    pub match_skin: bool,
    /// Which side the tone is taken from.
    pub tone: Tone,
    /// Which texels of the base are skin, white on black; estimated where there is none.
    pub skin: Option<PathBuf>,
    /// A picture of labels that says what textures show; found out of each where there is none.
    pub labels: Option<PathBuf>,
    /// Whether cloth and background at a neck stay in the region.
    pub keep_all: bool,
    /// Texels beyond the islands in which a base's skin changes too.
    pub gutter_px: u32,
}

impl Default for Blending {
    /// A hard border, and no colour changed.
    fn default() -> Self {
        let BlendOptions { membrane, match_skin, tone, gutter_px, .. } = BlendOptions::default();
        let feather = Length::millimeters(0.0);
        Self {
            feather,
            membrane,
            match_skin,
            tone,
            skin: None,
            labels: None,
            keep_all: false,
            gutter_px,
        }
    }
}

impl Blending {
    /// Whether colours of the base are looked at before anything is laid over it.
    pub fn needs_colors(&self) -> bool {
        self.membrane || self.match_skin
    }

    /// Whether it matters what textures show.
    pub fn asks_for_labels(&self) -> bool {
        self.needs_colors() || self.feather != Length::millimeters(0.0)
    }

    /// Reads what it needs and prepares it.
    ///
    /// - `region`: which part of what is linked is meant.
    /// - `known`: what is known of textures. Where the base shows through a feather, or `ends_at_mask`, the region
    ///   ends where the mask of that does: maps without opacity have no other way to.
    /// - `observer`: told which unit was taken for granted, if that matters.
    ///
    /// # Errors
    /// For files that cannot be read, and if nothing that is linked is left of the region.
    pub fn prepare(
        &self,
        region: &Region,
        ground: &Ground,
        known: &KnownTexels,
        ends_at_mask: bool,
        observer: &dyn Observer,
    ) -> Result<Arc<Blend>> {
        let unit = region.unit(ground, [self.feather], observer);
        let feather = self.feather.in_unit(unit);
        let mut selection = region.select(ground, unit)?;
        if let Some(Named { path, texture }) = &known.mask
            && (ends_at_mask || feather > 0.0)
        {
            let known = ground.painted(side_from(ground.direction()), texture);
            let known =
                known.map_err(|error| Failure::input(format!("{}: {error}", path.display())))?;
            selection = selection.within(&known).or_input()?;
        }
        let skin = self.skin.as_ref().map(|path| image::read(path).or_input()).transpose()?;
        let mut options = BlendOptions::default();
        options.feather = feather;
        options.membrane = self.membrane;
        options.match_skin = self.match_skin;
        options.tone = self.tone;
        options.gutter_px = self.gutter_px;
        options.keep_all = self.keep_all;
        let mut blend = Blend::new(&selection, options).or_input()?;
        if let Some(skin) = skin {
            blend = blend.with_skin(skin.texture);
        }
        if let Some(path) = &self.labels {
            let picture = image::read(path).or_input()?.texture;
            let labels = Labels::from_picture(&picture)
                .map_err(|error| Failure::input(format!("{}: {error}", path.display())))?;
            blend = blend.with_labels(labels);
        }
        Ok(Arc::new(blend.prepared()))
    }
}

/// What of a texture is left out of the region, in words; nothing if it is next to nothing.
pub fn left_out(toning: &Toning) -> Option<String> {
    let share = toning.report().left_out;
    (toning.narrowed().is_some() && share > 5e-4).then(|| {
        format!(
            "{:.1} % of the region excluded as cloth or background at the neck; use --keep-all to \
             keep it",
            share * 100.0
        )
    })
}

/// The side of a pair whose layout textures come from.
fn side_from(direction: Direction) -> Side {
    match direction {
        Direction::Forward => Side::Source,
        Direction::Reverse => Side::Target,
    }
}

/// Which texels of a texture are known, and what stands for the others.
#[derive(Debug, Clone, Default)]
pub struct KnownTexels {
    mask: Option<Named>,
    mean: Option<Named>,
}

/// An image and the file that it was read from.
#[derive(Debug, Clone)]
struct Named {
    path: PathBuf,
    texture: Texture,
}

impl KnownTexels {
    /// Reads what says it.
    ///
    /// - `mask`: where textures can be trusted, white on black, in their layout.
    /// - `mean`: a mean texture, in the same layout, for what they lack.
    ///
    /// # Errors
    /// For files that cannot be read.
    pub fn read(mask: Option<&Path>, mean: Option<&Path>) -> Result<Self> {
        let read = |path: &Path| {
            let texture = image::read(path).or_input()?.texture;
            Ok(Named { path: path.to_path_buf(), texture })
        };
        Ok(Self { mask: mask.map(read).transpose()?, mean: mean.map(read).transpose()? })
    }

    /// The same, with a mask for a texture that brings one along; the options' own comes first.
    #[must_use]
    pub fn or_mask(mut self, texture: Option<Texture>, path: &Path) -> Self {
        let brought = texture.map(|texture| Named { path: path.to_path_buf(), texture });
        self.mask = self.mask.or(brought);
        self
    }

    /// Whether textures get an opacity that their files do not have.
    pub fn adds_opacity(&self) -> bool {
        self.mask.is_some() && self.mean.is_none()
    }

    /// A texture with what it lacks, or with opacity that says what it lacks.
    ///
    /// - `path`: the texture's file, for messages.
    ///
    /// # Errors
    /// If the mask or the mean texture has another shape.
    pub fn complete(&self, texture: Texture, values: Values, path: &Path) -> Result<Texture> {
        let mask = self.mask.as_ref().map(|mask| &mask.texture);
        let completed = match (mask, &self.mean) {
            (mask, Some(mean)) if values == Values::Albedo => {
                fill::fill(texture, mask, &mean.texture)
            }
            (Some(mask), None) if !values.is_data() => fill::with_confidence(texture, mask),
            _ => return Ok(texture),
        };
        completed.map_err(|error| self.refusal(&error, path))
    }

    /// Names the file that is meant.
    fn refusal(&self, error: &FillError, path: &Path) -> Failure {
        let FillError::Shape { found, .. } = error else {
            return Failure::input(format!("{}: {error}", path.display()));
        };
        let mut named = self.mask.iter().chain(&self.mean);
        let culprit = named.find(|named| named.texture.size() == *found);
        let culprit = culprit.map_or(path, |named| &*named.path).display();
        Failure::input(format!("{culprit}: {error} ({})", path.display()))
    }
}
