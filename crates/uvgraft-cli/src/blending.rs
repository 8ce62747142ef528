//! Options for blending a texture into its base.

use std::path::{Path, PathBuf};

use uvgraft::choices;
use uvgraft_files::input::Input;
use uvgraft_pipeline::{BlendMode, BlendSettings, Blending, Length, Region, ToneSide};

use crate::choice::choice;
use crate::heading;

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
    #[arg(long, value_name = "MODE", value_parser = choice::<BlendMode>())]
    blend: Option<BlendMode>,
    /// Width of the feather, inwards from the boundary [default: 10mm if blended]
    ///
    /// Measured along the surface, with a unit (mm, cm, m or in), and at most as wide as the region.
    #[arg(long, value_name = "LENGTH", value_parser = Length::parse_distance)]
    #[arg(allow_hyphen_values = true)]
    feather: Option<Length>,
    /// Side that sets the skin tone [default: base]
    ///
    /// Applies to --blend membrane and --match skin.
    #[arg(long, value_name = "SIDE", value_parser = choice::<ToneSide>())]
    tone: Option<ToneSide>,
    /// Skin mask of the base, white on black [default: detected]
    ///
    /// Marks the texels of the base that change with --tone source or both. By default, skin is
    /// detected from the colours around the boundary of the region.
    #[arg(long, value_name = "IMAGE")]
    pub(crate) skin: Option<PathBuf>,
    /// Also match colour statistics (mean and covariance) between the two sides
    #[arg(id = "match_skin", long = "match", value_name = "WHAT")]
    #[arg(value_parser = choice::<Matched>())]
    matched: Option<Matched>,
    /// Label image of the texture (skin, hair, cloth, ...)
    ///
    /// Read if the file exists; otherwise the detected labels are written to it.
    #[arg(long, value_name = "IMAGE")]
    labels: Option<PathBuf>,
    /// Do not exclude clothing and background at the neck
    #[arg(long)]
    keep_all: bool,
}

/// What is matched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Matched {
    Skin,
}

choices!(Matched {
    Skin => "skin", "Detected skin";
});

impl BlendArgs {
    /// The options as they were given, without defaults.
    pub(crate) fn settings(&self) -> BlendSettings {
        BlendSettings {
            blend: self.blend,
            feather: self.feather,
            tone: self.tone,
            match_skin: self.matched.is_some(),
            skin: self.skin.as_ref().map(Input::from),
            labels: self.labels.as_ref().filter(|path| path.exists()).map(Input::from),
            draw_labels: self.drawn_labels().is_some(),
            keep_all: self.keep_all,
        }
    }

    /// The blending options, if any option, here or of the region, requires blending on the
    /// surface.
    pub(crate) fn blending_if_any(&self, region: &Region, gutter_px: u32) -> Option<Blending> {
        let settings = self.settings();
        let blending = settings.blending_if_any(region, gutter_px);
        blending.or_else(|| self.preview.as_ref().map(|_| settings.blending(gutter_px)))
    }

    /// Where to draw labels, if requested.
    pub(crate) fn drawn_labels(&self) -> Option<&Path> {
        self.labels.as_deref().filter(|path| !path.exists())
    }
}
