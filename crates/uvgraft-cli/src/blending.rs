//! How a texture becomes one with what it is laid over, as options say it.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use uvgraft::blend::{Blend, BlendMap, BlendOptions, Ground, Tone};
use uvgraft::fill::{self, FillError};
use uvgraft::{SamplingMap, Texture};
use uvgraft_io::image;

use crate::failure::{OrBadInput, bad_input};
use crate::length::Length;
use crate::region::{RegionArgs, side_from};

#[derive(Clone, clap::Args)]
#[command(next_help_heading = "Blending")]
pub(crate) struct BlendArgs {
    /// How the region's rim is hidden [default: none, with --feather feather]
    #[arg(long, value_enum)]
    blend: Option<BlendName>,
    /// Over which length along the surface the base gives way to the texture, inwards from the rim
    /// [default: 10mm where --blend is]
    #[arg(long, value_name = "LENGTH", value_parser = Length::parse_distance)]
    #[arg(allow_hyphen_values = true)]
    feather: Option<Length>,
    /// Which side the tone of the skin is taken from, with --blend membrane and --match
    #[arg(long, value_enum, default_value = "base")]
    tone: ToneName,
    /// Which texels of the base are skin, white on black, with --tone source [default: estimated from the
    /// colours beside the rim]
    #[arg(long, value_name = "IMAGE")]
    pub(crate) skin: Option<PathBuf>,
    /// Give one side's skin the mean and the covariance of the other's
    #[arg(long = "match", value_enum, value_name = "WHAT")]
    matched: Option<MatchName>,
    /// Where the texture can be trusted, white on black, in its own layout; the base shows elsewhere
    #[arg(long, value_name = "IMAGE")]
    pub(crate) source_mask: Option<PathBuf>,
    /// A mean texture, in the texture's layout, for what the texture lacks: where it is clear, and where
    /// --source-mask is dark
    #[arg(long, value_name = "IMAGE")]
    pub(crate) fill: Option<PathBuf>,
    /// Draw what is transferred, and how much, on both layouts
    #[arg(long, value_name = "OUT.png")]
    pub(crate) preview: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum BlendName {
    /// A hard border
    None,
    /// The base shows through near the rim
    Feather,
    /// Feathered, and the ratio of the colours along the rim goes on over the surface, so that one side
    /// takes on the other's tone
    Membrane,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ToneName {
    /// The texture takes on the base's tone
    Base,
    /// The base's skin takes on the texture's tone
    Source,
    /// Neither
    None,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MatchName {
    /// Of skin, as it is estimated
    Skin,
}

/// What is blended, and with what.
pub(crate) struct Blending<'a> {
    blend: Blend<'a>,
    skin: Option<Texture>,
}

impl BlendArgs {
    fn mode(&self) -> BlendName {
        self.blend.unwrap_or(match self.feather {
            Some(_) => BlendName::Feather,
            None => BlendName::None,
        })
    }

    fn feather(&self) -> Length {
        let default = match self.mode() {
            BlendName::None => 0.0,
            BlendName::Feather | BlendName::Membrane => 10.0,
        };
        self.feather.unwrap_or(Length::millimeters(default))
    }

    fn tone(&self) -> Option<Tone> {
        match self.tone {
            ToneName::Base => Some(Tone::Base),
            ToneName::Source => Some(Tone::Source),
            ToneName::None => None,
        }
    }

    /// The same, with a membrane if no other way is named.
    pub(crate) fn or_membrane(mut self) -> Self {
        self.blend = self.blend.or(Some(BlendName::Membrane));
        self
    }

    /// Whether colours of the base are looked at before anything is laid over it.
    pub(crate) fn needs_colors(&self) -> bool {
        self.tone().is_some() && (self.mode() == BlendName::Membrane || self.matched.is_some())
    }

    /// The images that are named.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        [&self.skin, &self.source_mask, &self.fill].into_iter().flatten().map(|path| &**path)
    }

    /// Whether anything is asked for, here or by the region, that is done on the surface.
    pub(crate) fn blends(&self, region: &RegionArgs) -> bool {
        !region.is_everything()
            || self.blend.is_some()
            || self.feather.is_some()
            || self.matched.is_some()
            || self.preview.is_some()
    }

    /// Refuses options that contradict each other.
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        if self.mode() == BlendName::None && self.feather.is_some() {
            return Err(bad_input("--feather says how wide, --blend none says not: leave one out"));
        }
        if self.skin.is_some() && !(self.needs_colors() && self.tone() == Some(Tone::Source)) {
            return Err(bad_input(
                "--skin says which part of the base changes, which takes --tone source and --blend membrane \
                 or --match skin",
            ));
        }
        if self.tone() == Some(Tone::Source) && !self.needs_colors() {
            return Err(bad_input("--tone source needs --blend membrane or --match skin"));
        }
        if self.tone().is_none() && self.matched.is_some() {
            return Err(bad_input(
                "--match skin changes one side's tone, --tone none says neither",
            ));
        }
        Ok(())
    }
}

impl<'a> Blending<'a> {
    /// - `always`: whether maps that have no opacity end where the mask of the source does.
    pub(crate) fn new(
        options: &BlendArgs,
        region: &RegionArgs,
        gutter_px: u32,
        ground: &'a Ground<'a>,
        known: &Known,
        always: bool,
    ) -> anyhow::Result<Self> {
        let unit = region.unit(ground, [options.feather()]);
        let feather = options.feather().in_unit(unit);
        let mut selection = region.select(ground, unit)?;
        if let Some(Named { path, texture }) = &known.mask
            && (always || feather > 0.0)
        {
            let known = ground.painted(side_from(ground.direction()), texture);
            let known = known.map_err(|error| bad_input(format!("{}: {error}", path.display())))?;
            selection = selection.within(&known, ground);
        }
        let skin =
            options.skin.as_ref().map(|path| image::read(path).or_bad_input()).transpose()?;
        let blend = Blend::new(
            ground,
            &selection,
            BlendOptions {
                feather,
                membrane: options.mode() == BlendName::Membrane && options.tone().is_some(),
                match_skin: options.matched.is_some() && options.tone().is_some(),
                tone: options.tone().unwrap_or(Tone::Base),
                skin_mask: skin.is_some(),
                gutter_px,
            },
        );
        let blend = blend.map_err(bad_input)?;
        Ok(Self { blend, skin: skin.map(|image| image.texture) })
    }

    pub(crate) fn blend(&self) -> &Blend<'a> {
        &self.blend
    }

    /// The blend at the texels of a map.
    pub(crate) fn on<'b>(&'b self, map: &SamplingMap) -> anyhow::Result<BlendMap<'b>>
    where
        'a: 'b,
    {
        let at = self.blend.on(map);
        Ok(match &self.skin {
            Some(mask) => at.with_skin(mask.clone(), map)?,
            None => at,
        })
    }
}

/// What the values of a texture are, as far as completing it goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Values {
    /// The surface's own colour, which takes part in finding a common tone.
    Albedo,
    /// Another colour.
    Color,
    /// No colour.
    Data,
}

/// What the source is known by, or made up from.
pub(crate) struct Known {
    mask: Option<Named>,
    mean: Option<Named>,
}

/// An image and the file that it was read from.
struct Named {
    path: PathBuf,
    texture: Texture,
}

impl Known {
    pub(crate) fn new(args: &BlendArgs) -> anyhow::Result<Self> {
        let read = |path: &Option<PathBuf>| {
            let image = path.as_ref().map(|path| {
                let texture = image::read(path).or_bad_input()?.texture;
                anyhow::Ok(Named { path: path.clone(), texture })
            });
            image.transpose()
        };
        Ok(Self { mask: read(&args.source_mask)?, mean: read(&args.fill)? })
    }

    /// The same, with a mask for a texture that brings one along; the options' own comes first.
    pub(crate) fn or_mask(mut self, texture: Option<Texture>, path: &Path) -> Self {
        let brought = texture.map(|texture| Named { path: path.to_path_buf(), texture });
        self.mask = self.mask.or(brought);
        self
    }

    /// Whether textures get an opacity that their files do not have.
    pub(crate) fn adds_opacity(&self) -> bool {
        self.mask.is_some() && self.mean.is_none()
    }

    /// A texture with what it lacks, or with opacity that says what it lacks.
    ///
    /// - `path`: the texture's file.
    pub(crate) fn complete(
        &self,
        texture: Texture,
        values: Values,
        path: &Path,
    ) -> anyhow::Result<Texture> {
        let mask = self.mask.as_ref().map(|mask| &mask.texture);
        let completed = match (mask, &self.mean) {
            (mask, Some(mean)) if values == Values::Albedo => {
                fill::fill(texture, mask, &mean.texture)
            }
            (Some(mask), None) if values != Values::Data => fill::with_confidence(texture, mask),
            _ => return Ok(texture),
        };
        completed.map_err(|error| self.refusal(&error, path))
    }

    /// Names the file that is meant.
    fn refusal(&self, error: &FillError, path: &Path) -> anyhow::Error {
        let FillError::Shape { found, .. } = error else {
            return bad_input(format!("{}: {error}", path.display()));
        };
        let mut named = self.mask.iter().chain(&self.mean);
        let culprit = named.find(|named| named.texture.size() == *found);
        let culprit = culprit.map_or(path, |named| &*named.path).display();
        bad_input(format!("{culprit}: {error} ({})", path.display()))
    }
}
