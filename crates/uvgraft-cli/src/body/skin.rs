//! `uvgraft body skin`: a painted skin for the open body.

use std::path::PathBuf;

use uvgraft::{Choice, Size, choices};
use uvgraft_assembly::Input;
use uvgraft_assembly::drawing::check_name;
use uvgraft_assembly::skin::{HAIR, painted};
use uvgraft_image::{self as image, Image, WriteOptions};
use uvgraft_open_body::skin::{SkinOptions, SkinTone};
use uvgraft_pipeline::Outputs;

use crate::choice::choice;
use crate::failure::bad_input;
use crate::files::OrCannotWrite;
use crate::outcome;
use crate::report::parse_size;

/// Paint a skin for the open body, with shorts and a top
#[derive(clap::Args)]
pub(super) struct Args {
    /// Model file, as written by `uvgraft body import`
    model: PathBuf,
    /// Tone of the skin from very light, 0, to very dark, 1; or a colour such as #c08a70
    #[arg(long, value_name = "0..1|COLOUR", default_value = "0.35", value_parser = tone, allow_negative_numbers = true)]
    tone: SkinTone,
    /// Hair on the scalp
    #[arg(long, value_name = "HAIR", default_value = Hair::Cap.name(), value_parser = choice::<Hair>())]
    hair: Hair,
    /// Colour of the hair cap [default: #2b1d16]
    #[arg(long, value_name = "COLOUR", value_parser = color)]
    hair_color: Option<[f32; 3]>,
    /// Colour of the irises [default: #5c3d24]
    #[arg(long, value_name = "COLOUR", value_parser = color)]
    eye_color: Option<[f32; 3]>,
    /// Size of the texture in texels
    #[arg(long, value_name = "N|WxH", default_value = "2048", value_parser = parse_size, allow_negative_numbers = true)]
    size: Size,
    /// Image to write
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
}

/// The hair of a skin.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Hair {
    Cap,
    None,
}

choices!(Hair {
    Cap => "cap", "Painted on the scalp";
    None => "none", "None";
});

fn color(text: &str) -> Result<[f32; 3], String> {
    let wrong = || format!("must be a colour such as #c08a70, got `{text}`");
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6).ok_or_else(wrong)?;
    let value = u32::from_str_radix(digits, 16).map_err(|_| wrong())?;
    let [_, red, green, blue] = value.to_be_bytes();
    Ok([red, green, blue].map(|byte| f32::from(byte) / 255.0))
}

fn tone(text: &str) -> Result<SkinTone, String> {
    if text.starts_with('#') {
        return color(text).map(SkinTone::from_color);
    }
    let value = text.parse().ok().filter(|value| (0.0..=1.0).contains(value));
    let wrong =
        || format!("must be a number from 0 to 1 or a colour such as #c08a70, got `{text}`");
    value.map(SkinTone::on_scale).ok_or_else(wrong)
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    check_name(&args.output, "a skin")?;
    if args.hair == Hair::None && args.hair_color.is_some() {
        return Err(bad_input("--hair-color needs --hair cap"));
    }
    Outputs::new([&*args.model]).check(&args.output)?;
    let mut options = SkinOptions::new(args.tone);
    options.hair = (args.hair == Hair::Cap).then_some(args.hair_color.unwrap_or(HAIR));
    options.iris = args.eye_color.unwrap_or(options.iris);
    let skin = painted(&Input::from(&args.model), args.size, &options)?;
    let _ = image::write(&Image::from(skin), &args.output, &WriteOptions::default())
        .or_cannot_write(&args.output)?;
    outcome::wrote(&args.output);
    outcome::look_by_picture(&args.model, Some(&args.output), false);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tones_are_numbers_or_colours() {
        assert_eq!(color("#ff0033"), Ok([1.0, 0.0, 0.2]));
        assert_eq!(tone("0.5"), Ok(SkinTone::on_scale(0.5)));
        assert_eq!(tone("#ff0033").unwrap().color(), [1.0, 0.0, 0.2]);
        for bad in ["2", "-0.1", "light", "#fff", "#12345g", "NaN"] {
            let error = tone(bad).unwrap_err();
            assert!(error.ends_with(&format!("got `{bad}`")), "{error}");
        }
    }
}
