//! How a texture becomes one with what it is laid over, as options say it.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use uvgraft::Tone;
use uvgraft_pipeline::{Blending, Length};

use crate::failure::bad_input;
use crate::region::RegionArgs;

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
    /// Which side the tone of the skin is taken from, with --blend membrane and --match [default: base, for
    /// avatars source]
    #[arg(long, value_enum)]
    tone: Option<ToneName>,
    /// Which texels of the base are skin, white on black, with --tone source [default: estimated from the
    /// colours beside the rim]
    #[arg(long, value_name = "IMAGE")]
    pub(crate) skin: Option<PathBuf>,
    /// Give one side's skin the mean and the covariance of the other's
    #[arg(long = "match", value_enum, value_name = "WHAT")]
    matched: Option<MatchName>,
    /// What the texture shows (skin, hair, cloth ...), as a picture of labels: read if the file is there, drawn
    /// into it if not
    #[arg(long, value_name = "IMAGE")]
    labels: Option<PathBuf>,
    /// Keep cloth and background at the neck, which blending leaves out
    #[arg(long)]
    keep_all: bool,
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
    /// Both give way half
    Both,
    /// Neither
    None,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MatchName {
    /// Of skin, as it is estimated
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

    /// The same for an avatar, as far as nothing else is said: with a membrane, and in the tone of the face. A person's
    /// colour is its own, and the body is nobody's.
    pub(crate) fn of_avatar(mut self) -> Self {
        self.blend = self.blend.or(Some(BlendName::Membrane));
        if self.mode() == BlendName::Membrane || self.matched.is_some() {
            self.tone = self.tone.or(Some(ToneName::Source));
        }
        self
    }

    /// Whether colours of the base are looked at before anything is laid over it.
    fn needs_colors(&self) -> bool {
        self.tone().is_some() && (self.mode() == BlendName::Membrane || self.matched.is_some())
    }

    /// The images that are named.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        let labels = self.labels.as_deref().filter(|path| path.exists());
        let images = [&self.skin, &self.source_mask, &self.fill].into_iter().flatten();
        images.map(PathBuf::as_path).chain(labels)
    }

    /// How it is blended, whatever is asked for.
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

    /// How it is blended, if anything is asked for, here or by the region, that is done on the surface.
    pub(crate) fn blending_if_any(&self, region: &RegionArgs, gutter_px: u32) -> Option<Blending> {
        let asks = !region.is_everything()
            || self.blend.is_some()
            || self.feather.is_some()
            || self.matched.is_some()
            || self.preview.is_some();
        asks.then(|| self.blending(gutter_px))
    }

    /// Where labels are drawn, if they are.
    pub(crate) fn drawn_labels(&self) -> Option<&Path> {
        self.labels.as_deref().filter(|path| !path.exists())
    }

    /// Refuses options that contradict each other.
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        if self.mode() == BlendName::None && self.feather.is_some() {
            return Err(bad_input("--feather says how wide, --blend none says not: leave one out"));
        }
        let changes_base = matches!(self.tone(), Some(Tone::Source | Tone::Both));
        if self.skin.is_some() && !(self.needs_colors() && changes_base) {
            return Err(bad_input(
                "--skin says which part of the base changes, which takes --tone source or both, and --blend membrane \
                 or --match skin",
            ));
        }
        if changes_base && !self.needs_colors() {
            return Err(bad_input("--tone source and both need --blend membrane or --match skin"));
        }
        let is_blended = self.needs_colors() || self.mode() != BlendName::None;
        if !is_blended && (self.labels.is_some() || self.keep_all) {
            return Err(bad_input(
                "--labels and --keep-all say what is blended: add --blend feather or --blend membrane",
            ));
        }
        if self.tone().is_none() && self.matched.is_some() {
            return Err(bad_input(
                "--match skin changes one side's tone, --tone none says neither",
            ));
        }
        Ok(())
    }
}
