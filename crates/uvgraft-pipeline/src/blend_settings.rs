//! Blending as users ask for it: options with their defaults, and which of them contradict each other.

use uvgraft::{BlendOptions, Tone, choices};
use uvgraft_files::input::Input;

use crate::blending::{Blending, DEFAULT_FEATHER};
use crate::failure::{Failure, Result};
use crate::length::Length;
use crate::region::Region;

/// How the boundary of a transferred region is hidden.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BlendMode {
    /// Not at all.
    None,
    /// By a feather.
    Feather,
    /// By a feather and a membrane.
    Membrane,
}

choices!(BlendMode {
    None => "none", "Hard edge";
    Feather => "feather", "Fade into the base near the boundary";
    Membrane => "membrane",
        "Feather, and adapt the tone of one side to the other's by a smooth gain";
});

/// The side that sets the skin tone, if any does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ToneSide {
    /// The base.
    Base,
    /// The texture.
    Source,
    /// Both.
    Both,
    /// None of them.
    None,
}

choices!(ToneSide {
    Base => "base", "The texture adapts to the base";
    Source => "source", "The skin of the base adapts to the texture";
    Both => "both", "Both meet halfway";
    None => "none", "Neither changes";
});

impl From<ToneSide> for Option<Tone> {
    fn from(side: ToneSide) -> Self {
        match side {
            ToneSide::Base => Some(Tone::Base),
            ToneSide::Source => Some(Tone::Source),
            ToneSide::Both => Some(Tone::Both),
            ToneSide::None => None,
        }
    }
}

/// Options of blending, of which those that are not given have defaults that depend on the others.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BlendSettings {
    /// How to hide the boundary; by default not at all, or by a feather if one is given.
    pub blend: Option<BlendMode>,
    /// Width of the feather; by default 10 mm where there is one.
    pub feather: Option<Length>,
    /// The side that sets the skin tone; by default the base.
    pub tone: Option<ToneSide>,
    /// Whether the colour statistics of skin are matched, too.
    pub match_skin: bool,
    /// Skin mask of the base, white on black; by default detected.
    pub skin: Option<Input>,
    /// Label image of the texture; by default detected.
    pub labels: Option<Input>,
    /// Whether an image of the detected labels is wanted.
    pub draw_labels: bool,
    /// Whether cloth and background at the neck stay in the region.
    pub keep_all: bool,
}

impl BlendSettings {
    /// The same with the defaults for avatars: a membrane, in the tone of the face, since the face
    /// shows a person's own skin and the body is generic.
    #[must_use]
    pub fn of_avatar(mut self) -> Self {
        self.blend = self.blend.or(Some(BlendMode::Membrane));
        if self.mode() == BlendMode::Membrane || self.match_skin {
            self.tone = self.tone.or(Some(ToneSide::Source));
        }
        self
    }

    fn mode(&self) -> BlendMode {
        self.blend.unwrap_or(match self.feather {
            Some(_) => BlendMode::Feather,
            None => BlendMode::None,
        })
    }

    fn feather(&self) -> Length {
        let default = match self.mode() {
            BlendMode::None => Length::millimeters(0.0),
            BlendMode::Feather | BlendMode::Membrane => DEFAULT_FEATHER,
        };
        self.feather.unwrap_or(default)
    }

    fn tone(&self) -> Option<Tone> {
        self.tone.unwrap_or(ToneSide::Base).into()
    }

    /// Whether colours of the base are analysed before compositing.
    fn needs_colors(&self) -> bool {
        self.tone().is_some() && (self.mode() == BlendMode::Membrane || self.match_skin)
    }

    /// The images that are read.
    pub fn inputs(&self) -> impl Iterator<Item = &Input> {
        self.skin.iter().chain(&self.labels)
    }

    /// The blending, including defaults.
    ///
    /// - `gutter_px`: of the result.
    pub fn blending(&self, gutter_px: u32) -> Blending {
        let tone = self.tone();
        let mut options = BlendOptions::default().gutter_px(gutter_px);
        options.membrane = self.mode() == BlendMode::Membrane && tone.is_some();
        options.match_skin = self.match_skin && tone.is_some();
        options.tone = tone.unwrap_or(options.tone);
        options.keep_all = self.keep_all;
        let (skin, labels) = (self.skin.clone(), self.labels.clone());
        Blending { feather: self.feather(), options, skin, labels }
    }

    /// The blending, if any option, here or of the region, requires blending on the surface.
    pub fn blending_if_any(&self, region: &Region, gutter_px: u32) -> Option<Blending> {
        let asks = !region.is_everything()
            || self.blend.is_some()
            || self.feather.is_some()
            || self.match_skin;
        asks.then(|| self.blending(gutter_px))
    }

    /// Checks for options that contradict each other.
    ///
    /// # Errors
    /// As bad input, with the options.
    pub fn check(&self) -> Result<()> {
        if self.mode() == BlendMode::None && self.feather.is_some() {
            return Err(Failure::option("`feather` cannot be used with `blend` none"));
        }
        let changes_base = matches!(self.tone(), Some(Tone::Source | Tone::Both));
        if self.skin.is_some() && !(self.needs_colors() && changes_base) {
            return Err(Failure::option(
                "`skin` needs `tone` source or both, with `blend` membrane or `match_skin`",
            ));
        }
        let matches = self.mode() == BlendMode::Membrane || self.match_skin;
        if self.tone.is_some() && !matches {
            return Err(Failure::option("`tone` needs `blend` membrane or `match_skin`"));
        }
        let is_blended = self.needs_colors() || !self.feather().is_zero();
        let has_labels = self.labels.is_some() || self.draw_labels;
        if !is_blended && (has_labels || self.keep_all) {
            return Err(Failure::option(
                "`labels` and `keep_all` need `blend` feather or membrane, and a `feather` or a `tone`",
            ));
        }
        if self.tone().is_none() && self.match_skin {
            return Err(Failure::option("`match_skin` cannot be used with `tone` none"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_feather_alone_blends_and_none_contradicts_it() {
        let feathered =
            BlendSettings { feather: Some(Length::millimeters(5.0)), ..BlendSettings::default() };
        assert_eq!(feathered.blending(4).feather, Length::millimeters(5.0));
        feathered.check().unwrap();
        let none = BlendSettings { blend: Some(BlendMode::None), ..feathered };
        assert!(none.check().unwrap_err().to_string().contains("`feather`"));
    }

    #[test]
    fn avatars_have_a_membrane_in_the_tone_of_the_face() {
        let blending = BlendSettings::default().of_avatar().blending(4);
        assert!(blending.options.membrane && blending.options.tone == Tone::Source);
        assert_eq!(blending.feather, Length::millimeters(10.0));
        let plain = BlendSettings { blend: Some(BlendMode::None), ..BlendSettings::default() };
        plain.clone().of_avatar().check().unwrap();
        assert!(!plain.of_avatar().blending(4).options.membrane);
    }
}
