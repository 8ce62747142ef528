//! Blending options, and the files that they refer to.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use uvgraft::blend::{Blend, BlendDomain, BlendOptions, FeatherFit, Side};
use uvgraft::fill::{self, FillError};
use uvgraft::{Direction, Labels, Texture, ToneCorrection};
use uvgraft_files::input::Input;
use uvgraft_image as image;

use crate::failure::{Blame, Failure, Result};
use crate::length::{Length, Unit};
use crate::masks::Uniform;
use crate::material::Values;
use crate::observer::Observer;
use crate::region::Region;

/// The width of the feather of blends that have one.
pub(crate) const DEFAULT_FEATHER: Length = Length::millimeters(10.0);

/// How a texture is blended into its base.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Blending {
    /// Distance over which the texture fades into the base, inwards from the region's boundary.
    pub feather: Length,
    /// All other options of the core. Its own `feather` is set from the one above, once the mesh's
    /// unit is known.
    pub options: BlendOptions,
    /// Skin mask of the base, white on black; estimated if absent.
    pub skin: Option<Input>,
    /// Label image of the textures; detected for each texture if absent.
    pub labels: Option<Input>,
}

impl Default for Blending {
    /// A hard edge without colour changes.
    fn default() -> Self {
        let feather = Length::millimeters(0.0);
        Self { feather, options: BlendOptions::default(), skin: None, labels: None }
    }
}

impl Blending {
    /// Whether colours of the base are analysed before compositing.
    pub fn needs_colors(&self) -> bool {
        self.options.needs_colors()
    }

    /// Whether the labels of textures matter.
    pub fn needs_labels(&self) -> bool {
        self.needs_colors() || !self.feather.is_zero()
    }

    /// Reads the files it needs and prepares the blend.
    ///
    /// - `region`: the part of the linked surface to use.
    /// - `known`: the known texels of textures. With a feather, or if `ends_at_mask`, the region
    ///   ends at the boundary of their mask: maps without alpha cannot end there in any other way.
    /// - `observer`: receives a note if a mesh unit was assumed, and warnings about the region.
    ///
    /// # Errors
    /// For unreadable files, if nothing of the linked surface remains in the region, and if the feather is
    /// wider than the region.
    pub fn prepare(
        &self,
        region: &Region,
        domain: &BlendDomain,
        known: &KnownTexels,
        ends_at_mask: bool,
        observer: &dyn Observer,
    ) -> Result<Arc<Blend>> {
        let unit = region.unit(domain, [self.feather], observer);
        let feather = self.feather.in_unit(unit);
        let mut selection = region.select(domain, unit, observer)?;
        if let Some(Named { path, texture }) = &known.mask
            && (ends_at_mask || feather > 0.0)
        {
            let known = domain.painted(side_from(domain.direction()), texture);
            let known =
                known.map_err(|error| Failure::input(format!("{}: {error}", path.display())))?;
            selection = selection.intersection(&known).or_input()?;
        }
        let skin = self.skin.as_ref().map(|skin| image::read(skin).or_input()).transpose()?;
        if let (Some(name), Some(skin)) = (&self.skin, &skin)
            && Uniform::of(&skin.texture) == Some(Uniform::Black)
        {
            observer.warn(format_args!(
                "{name}: `skin` is black everywhere, so nothing of the base takes on the tone"
            ));
        }
        let mut blend = Blend::new(&selection, self.options.feather(feather)).or_input()?;
        self.check_feather(blend.feather_fit(), unit, observer)?;
        if let Some(skin) = skin {
            blend = blend.with_skin(skin.texture);
        }
        if let Some(input) = &self.labels {
            let picture = image::read(input).or_input()?.texture;
            let labels = Labels::from_picture(&picture)
                .map_err(|error| Failure::input(format!("{input}: {error}")))?;
            blend = blend.with_labels(labels);
        }
        Ok(Arc::new(blend.prepared()))
    }
}

impl Blending {
    /// Refuses a feather that leaves the texture opaque nowhere, and warns of one that does nothing.
    fn check_feather(&self, fit: FeatherFit, unit: Unit, observer: &dyn Observer) -> Result<()> {
        match fit {
            FeatherFit::Opaque => {}
            // Each texture gets a warning that there is no boundary.
            FeatherFit::NoBoundary if self.needs_colors() => {}
            FeatherFit::NoBoundary => {
                observer.warn("`feather` has no effect: the region has no boundary");
            }
            FeatherFit::TooWide { depth } => {
                let default = if self.feather == DEFAULT_FEATHER { ", the default" } else { "" };
                return Err(Failure::option(format!(
                    "`feather` must be at most {}, the distance of the region's innermost point from its \
                     boundary, got {}{default}",
                    Length::measured(depth, unit),
                    self.feather
                )));
            }
        }
        Ok(())
    }
}

/// A message with the share of a texture excluded from the region; `None` if it is negligible.
pub fn exclusion_note(toning: &ToneCorrection) -> Option<String> {
    let share = toning.report().left_out;
    (toning.narrowed().is_some() && share > 5e-4).then(|| {
        format!(
            "{:.1} % of the region excluded as cloth or background at the neck; use `keep_all` to \
             keep it",
            share * 100.0
        )
    })
}

/// The side of the pair whose layout textures are read in.
fn side_from(direction: Direction) -> Side {
    match direction {
        Direction::Forward => Side::Source,
        Direction::Reverse => Side::Target,
    }
}

/// The known texels of a texture, and the replacement for the others.
#[derive(Debug, Clone, Default)]
pub struct KnownTexels {
    mask: Option<Named>,
    mean: Option<Named>,
}

/// An image and the path it was read from, or the name that stands for it.
#[derive(Debug, Clone)]
struct Named {
    path: PathBuf,
    texture: Texture,
}

impl KnownTexels {
    /// Reads the mask and the mean texture.
    ///
    /// - `mask`: the trusted texels, white on black, in the layout of the textures.
    /// - `mean`: a mean texture in the same layout that fills unseen areas.
    ///
    /// # Errors
    /// For unreadable files.
    pub fn read(mask: Option<&Input>, mean: Option<&Input>) -> Result<Self> {
        let read = |input: &Input| {
            let texture = image::read(input).or_input()?.texture;
            Ok(Named { path: input.name().to_path_buf(), texture })
        };
        Ok(Self { mask: mask.map(read).transpose()?, mean: mean.map(read).transpose()? })
    }

    /// Adds the mask that comes with a texture; a mask set by the options takes precedence.
    #[must_use]
    pub fn with_default_mask(mut self, texture: Option<Texture>, path: &Path) -> Self {
        let brought = texture.map(|texture| Named { path: path.to_path_buf(), texture });
        self.mask = self.mask.or(brought);
        self
    }

    /// Checks that the mask means something.
    ///
    /// - `observer`: receives a note if it trusts everything.
    ///
    /// # Errors
    /// As bad input if it trusts nothing.
    pub fn check(&self, observer: &dyn Observer) -> Result<()> {
        let Some(Named { path, texture }) = &self.mask else { return Ok(()) };
        let path = path.display();
        match Uniform::of(texture) {
            Some(Uniform::Black) => {
                return Err(Failure::option(format!(
                    "{path}: `source_mask` must be white where textures can be trusted, got black everywhere"
                )));
            }
            Some(Uniform::White) => {
                observer
                    .note(format_args!("{path}: `source_mask` has no effect: white everywhere"));
            }
            None => {}
        }
        Ok(())
    }

    /// A note on a texture that the mean texture has nothing to fill in; `None` if it may have.
    pub(crate) fn unused_fill(
        &self,
        texture: &Texture,
        values: Values,
        path: &Path,
    ) -> Option<String> {
        let is_unused = self.mean.is_some()
            && self.mask.is_none()
            && values == Values::Albedo
            && !texture.channels().has_alpha();
        let path = path.display();
        is_unused.then(|| format!("{path}: `fill` has no effect: no alpha, and no `source_mask`"))
    }

    /// Whether textures get an alpha channel that their files do not have.
    pub fn adds_alpha(&self) -> bool {
        self.mask.is_some() && self.mean.is_none()
    }

    /// Fills the unknown texels of a texture, or marks them in its alpha channel.
    ///
    /// - `path`: the texture's file, for messages.
    ///
    /// # Errors
    /// If the aspect ratio of the mask or the mean texture differs from the texture's.
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

    /// Attributes the error to the file that causes it.
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
