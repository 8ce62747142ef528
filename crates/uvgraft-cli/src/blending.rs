//! Options for blending a texture into its base.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use uvgraft::Tone;
use uvgraft_pipeline::{Blending, Length};

use crate::failure::bad_input;
use crate::heading;
use crate::region::RegionArgs;

#[derive(Clone, clap::Args)]
#[command(next_help_heading = heading::BLENDING)]
pub(crate) struct BlendArgs {
    /// Source mask: white where the texture can be trusted
    ///
    /// It is in the texture's layout. The base shows everywhere else, or the texture given by --fill.
    #[arg(long, value_name = "IMAGE", help_heading = heading::REGION)]
    pub(crate) source_mask: Option<PathBuf>,
    /// Mean texture that fills unseen areas
    ///
    /// The mean texture is in the texture's layout. It fills transparent texels and those that
    /// --source-mask excludes.
    #[arg(long, value_name = "IMAGE", help_heading = heading::REGION)]
    pub(crate) fill: Option<PathBuf>,
    /// Draw the transferred region and its weights on both layouts
    #[arg(long, value_name = "OUT.png", help_heading = heading::REGION)]
    pub(crate) preview: Option<PathBuf>,
    /// How to hide the boundary of the region [default: none; feather if --feather is given]
    #[arg(long, value_enum, value_name = "MODE")]
    blend: Option<BlendName>,
    /// Width of the feather, inwards from the boundary [default: 10mm if blended]
    ///
    /// Measured along the surface.
    #[arg(long, value_name = "LENGTH", value_parser = Length::parse_distance)]
    #[arg(allow_hyphen_values = true)]
    feather: Option<Length>,
    /// Side that sets the skin tone [default: base]
    ///
    /// Applies to --blend membrane and --match skin.
    #[arg(long, value_enum, value_name = "SIDE")]
    tone: Option<ToneName>,
    /// Skin mask of the base, white on black [default: detected]
    ///
    /// Marks the texels of the base that change with --tone source or both. By default, skin is
    /// detected from the colours around the boundary of the region.
    #[arg(long, value_name = "IMAGE")]
    pub(crate) skin: Option<PathBuf>,
    /// Also match colour statistics (mean and covariance) between the two sides
    #[arg(long = "match", value_enum, value_name = "WHAT")]
    matched: Option<MatchName>,
    /// Label image of the texture (skin, hair, cloth, ...)
    ///
    /// Read if the file exists; otherwise the detected labels are written to it.
    #[arg(long, value_name = "IMAGE")]
    labels: Option<PathBuf>,
    /// Do not exclude clothing and background at the neck
    #[arg(long)]
    keep_all: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum BlendName {
    /// Hard edge
    None,
    /// Fade into the base near the boundary
    Feather,
    /// Feather, and adapt the tone of one side to the other's by a smooth gain
    Membrane,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ToneName {
    /// The texture adapts to the base
    Base,
    /// The skin of the base adapts to the texture
    Source,
    /// Both meet halfway
    Both,
    /// Neither changes
    None,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MatchName {
    /// Detected skin
    Skin,
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
        match self.tone.unwrap_or(ToneName::Base) {
            ToneName::Base => Some(Tone::Base),
            ToneName::Source => Some(Tone::Source),
            ToneName::Both => Some(Tone::Both),
            ToneName::None => None,
        }
    }

    /// The same with the defaults for avatars: a membrane, in the tone of the face, since the face
    /// shows a person's own skin and the body is generic.
    pub(crate) fn of_avatar(mut self) -> Self {
        self.blend = self.blend.or(Some(BlendName::Membrane));
        if self.mode() == BlendName::Membrane || self.matched.is_some() {
            self.tone = self.tone.or(Some(ToneName::Source));
        }
        self
    }

    /// Whether colours of the base are analysed before compositing.
    fn needs_colors(&self) -> bool {
        self.tone().is_some() && (self.mode() == BlendName::Membrane || self.matched.is_some())
    }

    /// The input images.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        let labels = self.labels.as_deref().filter(|path| path.exists());
        let images = [&self.skin, &self.source_mask, &self.fill].into_iter().flatten();
        images.map(PathBuf::as_path).chain(labels)
    }

    /// The blending options, including defaults.
    ///
    /// - `gutter_px`: of the result.
    pub(crate) fn blending(&self, gutter_px: u32) -> Blending {
        let mut blending = Blending::default();
        blending.feather = self.feather();
        blending.membrane = self.mode() == BlendName::Membrane && self.tone().is_some();
        blending.match_skin = self.matched.is_some() && self.tone().is_some();
        blending.tone = self.tone().unwrap_or(Tone::Base);
        blending.skin.clone_from(&self.skin);
        blending.labels = self.labels.clone().filter(|path| path.exists());
        blending.keep_all = self.keep_all;
        blending.gutter_px = gutter_px;
        blending
    }

    /// The blending options, if any option, here or of the region, requires blending on the
    /// surface.
    pub(crate) fn blending_if_any(&self, region: &RegionArgs, gutter_px: u32) -> Option<Blending> {
        let asks = !region.is_everything()
            || self.blend.is_some()
            || self.feather.is_some()
            || self.matched.is_some()
            || self.preview.is_some();
        asks.then(|| self.blending(gutter_px))
    }

    /// Where to draw labels, if requested.
    pub(crate) fn drawn_labels(&self) -> Option<&Path> {
        self.labels.as_deref().filter(|path| !path.exists())
    }

    /// Checks for conflicting options.
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        if self.mode() == BlendName::None && self.feather.is_some() {
            return Err(bad_input("--feather cannot be used with --blend none"));
        }
        let changes_base = matches!(self.tone(), Some(Tone::Source | Tone::Both));
        if self.skin.is_some() && !(self.needs_colors() && changes_base) {
            return Err(bad_input(
                "--skin needs --tone source or both, with --blend membrane or --match skin",
            ));
        }
        if changes_base && !self.needs_colors() {
            return Err(bad_input("--tone source and both need --blend membrane or --match skin"));
        }
        let is_blended = self.needs_colors() || self.mode() != BlendName::None;
        if !is_blended && (self.labels.is_some() || self.keep_all) {
            return Err(bad_input(
                "--labels and --keep-all need --blend feather or --blend membrane",
            ));
        }
        if self.tone().is_none() && self.matched.is_some() {
            return Err(bad_input("--match skin cannot be used with --tone none"));
        }
        Ok(())
    }
}
