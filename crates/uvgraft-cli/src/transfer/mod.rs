//! `uvgraft transfer`: carries textures across.

mod base;
mod batch;
mod carrier;
mod pipeline;
mod plan;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use uvgraft::{Filter, FitOptions, MapOptions, Size, TransferOptions};
use uvgraft_io::image::{self, Format, Image};
use uvgraft_io::pair_file;

use crate::failure::{OrBadInput, bad_input, warn};
use crate::filters::FilterName;
use crate::outputs::Outputs;
use crate::preference::PreferName;
use crate::report::{parse_size, to_stdout};
use base::Base;
use carrier::{Carrier, losses};
use plan::{Plan, format_of};

/// Carries textures from one layout onto a base in the other.
///
/// Formats are told by content when reading (PNG, JPEG, WebP, TIFF, EXR) and by extension when
/// writing. The result has all channels of source and base and the greater bit depth of both.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// The pair file
    pair: PathBuf,
    /// Textures in the source's layout, or one folder of them
    #[arg(required = true, value_name = "SRC")]
    sources: Vec<PathBuf>,
    /// What the texture is laid over: an image in the target's layout, or a colour such as #808080
    /// or #80808000 [default: transparent]
    #[arg(long, value_name = "IMAGE|COLOUR")]
    onto: Option<String>,
    /// Where to write the result: a file, or a folder for several sources
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Carry from the pair's target to its source
    #[arg(long)]
    reverse: bool,
    /// Size of the result; a base image is resized to it [default: the base image's]
    #[arg(long, value_name = "N|WxH", value_parser = parse_size)]
    size: Option<Size>,
    /// How values between texels are made [default: lanczos3, with --data bilinear]
    #[arg(long, value_enum)]
    filter: Option<FilterName>,
    /// Texels beyond the UV islands that are filled
    #[arg(long, value_name = "TEXELS", default_value_t = MapOptions::default().gutter_px)]
    #[arg(value_parser = clap::value_parser!(u32).range(0..=256))]
    gutter: u32,
    /// Which UV island is shown where several share texels, such as two eyes on one disc
    #[arg(long, value_enum, default_value_t = PreferName::First)]
    prefer: PreferName,
    /// Write which texels the textures are carried to, white on black; the gutter is black
    #[arg(long, value_name = "OUT_MASK.png")]
    mask: Option<PathBuf>,
    /// Average colours as light, not as they are encoded
    #[arg(long)]
    linear_light: bool,
    /// The textures are data (roughness, masks): never convert their values
    #[arg(long, conflicts_with = "linear_light")]
    data: bool,
    /// Format of the results when there are several [default: each source's own]
    #[arg(long, value_name = "EXTENSION", value_parser = parse_format)]
    format: Option<String>,
    /// Solve for the texture that reads back best, rather than sample: slower, and closest to the
    /// source when carried back with the same filter. Sharper, so that it may overshoot with any
    /// filter
    #[arg(long)]
    fit: bool,
    /// The most steps that --fit takes; it stops where another gains little
    #[arg(long, value_name = "N", requires = "fit", default_value_t = FitOptions::default().max_steps)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1000))]
    fit_steps: u32,
    /// Leave out outputs that are newer than their source, the base and the pair
    #[arg(long)]
    skip_existing: bool,
    /// How many textures are carried at once, where there are several [default: one a thread]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Memory for textures that are carried at once, such as 500M or 4G: fewer are, where they would
    /// not fit
    #[arg(long, value_name = "SIZE", default_value = "2G", value_parser = parse_bytes)]
    memory: u64,
    /// Write small files rather than fast
    #[arg(long)]
    compress: bool,
    /// Quality of JPEG files, 1 to 100
    #[arg(long, default_value_t = 95, value_parser = clap::value_parser!(u8).range(1..=100))]
    quality: u8,
}

impl Args {
    fn filter(&self) -> Filter {
        match self.filter {
            Some(name) => name.into(),
            // Overshoot would put values into data that none of its texels has.
            None if self.data => Filter::Bilinear,
            None => TransferOptions::default().filter,
        }
    }
}

/// Bytes, with K, M, G or T for powers of 1024.
fn parse_bytes(text: &str) -> Result<u64, String> {
    let wanted = || "wanted a size such as 500M or 4G".to_owned();
    let (digits, unit) = match text.char_indices().last() {
        Some((end, last)) if last.is_ascii_alphabetic() => (&text[..end], last),
        _ => (text, 'B'),
    };
    let power = match unit.to_ascii_uppercase() {
        'B' => 0,
        'K' => 1,
        'M' => 2,
        'G' => 3,
        'T' => 4,
        _ => return Err(wanted()),
    };
    let number: u64 = digits.parse().map_err(|_| wanted())?;
    number.checked_mul(1 << (10 * power)).filter(|&bytes| bytes > 0).ok_or_else(wanted)
}

fn parse_format(text: &str) -> Result<String, String> {
    let extension = text.strip_prefix('.').unwrap_or(text);
    Format::from_extension(extension)
        .map(|_| extension.to_owned())
        .ok_or_else(|| format!("wanted {}", Format::extension_list()))
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    if args.fit && args.filter() == Filter::Nearest {
        return Err(bad_input(
            "--fit would blend texels, and --filter nearest never does: leave one of them out",
        ));
    }
    let Plan { mut jobs, new_folder } = Plan::new(args)?;
    let base_path = args.onto.as_deref().filter(|onto| !onto.starts_with('#')).map(Path::new);
    let shared = || [&*args.pair].into_iter().chain(base_path);
    let mut outputs = Outputs::new(shared().chain(jobs.iter().map(|job| &*job.source)));
    if new_folder.is_none() {
        jobs.iter().try_for_each(|job| outputs.check(&job.output))?;
    }
    let planned = jobs.len();
    if args.skip_existing {
        jobs.retain(|job| !job.is_done(shared()));
    }
    if let Some(mask) = &args.mask {
        if format_of(mask)? == Format::Jpeg {
            let mask = mask.display();
            return Err(bad_input(format!("{mask}: JPEG would blur the mask; name it .png")));
        }
        outputs.check(mask)?;
    }
    if args.skip_existing {
        to_stdout(&format!("{} of {planned} were up to date\n", planned - jobs.len()))?;
        if jobs.is_empty() && args.mask.is_none() {
            return Ok(ExitCode::SUCCESS);
        }
    }
    let pair = pair_file::read(&args.pair).or_bad_input()?.pair;
    let base = Base::new(args, base_path, jobs.len() > 1)?;
    if let Some(folder) = new_folder {
        std::fs::create_dir(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))
            .or_bad_input()?;
    }
    let carrier = Carrier::new(args, &pair, &base);
    let carried = batch::run(&carrier, &jobs, &base, args)?;
    if let Some(path) = &args.mask
        && (carried.count > 0 || jobs.is_empty())
    {
        let mask = Image::from(carrier.mask(base.size()));
        losses(image::write(&mask, path, &carrier.write_options()), path)?.iter().for_each(warn);
    }
    Ok(carried.code.map_or(ExitCode::SUCCESS, ExitCode::from))
}
