//! `uvgraft transfer`: carries textures across.

mod base;
mod plan;

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use indicatif::ProgressBar;
use uvgraft::{
    Direction, Filter, Fit, FitOptions, MapOptions, Pair, Size, Texture, Transfer, TransferError,
    TransferOptions,
};
use uvgraft_io::image::{self, EncodeError, Format, Image, WriteError, WriteOptions};
use uvgraft_io::pair_file;

use crate::failure::{self, OrBadInput, bad_input, warn};
use crate::filters::FilterName;
use crate::fitting::{self, FitSummary};
use crate::outputs::Outputs;
use crate::progress;
use crate::report::{parse_size, to_stdout};
use base::{Base, meant};
use plan::{Job, Plan, format_of};

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
    let Plan { jobs, new_folder } = Plan::new(args)?;
    let base_path = args.onto.as_deref().filter(|onto| !onto.starts_with('#')).map(Path::new);
    let inputs = [&*args.pair].into_iter().chain(base_path);
    let mut outputs = Outputs::new(inputs.chain(jobs.iter().map(|job| &*job.source)));
    if new_folder.is_none() {
        jobs.iter().try_for_each(|job| outputs.check(&job.output))?;
    }
    if let Some(mask) = &args.mask {
        if format_of(mask)? == Format::Jpeg {
            let mask = mask.display();
            return Err(bad_input(format!("{mask}: JPEG would blur the mask; name it .png")));
        }
        outputs.check(mask)?;
    }
    let pair = pair_file::read(&args.pair).or_bad_input()?.pair;
    let base = Base::new(args, base_path)?;
    if let Some(folder) = new_folder {
        std::fs::create_dir(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))
            .or_bad_input()?;
    }
    let mut carrier = Carrier::new(args, &pair, &base);

    let progress = match jobs.len() {
        1 => ProgressBar::hidden(),
        count => progress::bar(count as u64, "{bar:32} {pos}/{len} {eta:>4} {wide_msg}"),
    };
    let mut worst = None;
    let mut failed = 0;
    for job in &jobs {
        progress.set_message(job.source.display().to_string());
        let result = carrier.carry(job);
        progress.suspend(|| {
            carrier.warnings.drain(..).for_each(warn);
            if let Err(error) = &result {
                failure::report(error);
            }
        });
        if let Ok(Some(fit)) = &result {
            progress.suspend(|| to_stdout(&format!("{}: {fit}\n", job.output.display())))?;
        }
        if let Err(error) = result {
            // A failure at work weighs more than a bad file.
            failed += 1;
            let code = failure::exit_code(&error);
            worst = Some(worst.map_or(code, |worst: u8| worst.min(code)));
        }
        progress.inc(1);
    }
    progress.finish_and_clear();
    if failed > 0 && jobs.len() > 1 {
        warn(format!("{} of {} textures were carried across", jobs.len() - failed, jobs.len()));
    }
    if let (Some(path), Some(mask)) = (&args.mask, carrier.mask()) {
        carrier.write(&Image::from(mask), path)?;
        carrier.warnings.drain(..).for_each(warn);
    }
    Ok(worst.map_or(ExitCode::SUCCESS, ExitCode::from))
}

/// Carries one texture after the other, keeping what they share.
struct Carrier<'a> {
    args: &'a Args,
    pair: &'a Pair,
    base: &'a Base,
    options: WriteOptions,
    /// What the user should know about the textures carried since this was last emptied.
    warnings: Vec<String>,
    carriages: HashMap<Size, Carriage>,
}

impl<'a> Carrier<'a> {
    fn new(args: &'a Args, pair: &'a Pair, base: &'a Base) -> Self {
        let options = WriteOptions { compress: args.compress, jpeg_quality: args.quality };
        Self { args, pair, base, options, warnings: Vec::new(), carriages: HashMap::new() }
    }

    /// Carries a texture and says how its fit went, if it was fitted.
    fn carry(&mut self, job: &Job) -> anyhow::Result<Option<FitSummary>> {
        let mut source = image::read(&job.source).or_bad_input()?;
        source.texture = meant(source.texture, self.args);
        self.warnings.extend(self.base.mismatch(&source, &job.source));
        let (base, mut icc) = self.base.under(&source)?;
        let owner = if let Base::Image(..) = self.base { &base } else { &source.texture };
        let owner_has_color = owner.channels().has_color();
        let (texture, fit) = self.carriage(source.texture.size()).apply(source.texture, base)?;
        let output = job.output.display();
        // A profile is for grey or for RGB; readers refuse images that have the other one.
        if texture.channels().has_color() != owner_has_color && icc.take().is_some() {
            let warning = "the ICC profile was dropped: it is for grey and the result has colours";
            self.warnings.push(format!("{output}: {warning}"));
        }
        if texture.channels().has_alpha() && Format::from_path(&job.output) == Some(Format::Jpeg) {
            let hint = match self.base {
                Base::Color { unit: [.., alpha], .. } if *alpha < 1.0 => {
                    "lay it over a colour, such as --onto '#808080', or choose"
                }
                _ => "choose",
            };
            return Err(bad_input(format!(
                "cannot write {output}: the result has an alpha channel, which JPEG cannot hold; \
                 {hint} PNG, WebP, TIFF or EXR"
            )));
        }
        self.write(&Image { texture, icc }, &job.output)?;
        Ok(fit)
    }

    fn write(&mut self, image: &Image, path: &Path) -> anyhow::Result<()> {
        let written = image::write(image, path, &self.options).map_err(|error| match error {
            // The place was found to be writable before: now the disk is full, or gone.
            WriteError::Encode { reason: EncodeError::Io(_), .. } => anyhow::anyhow!("{error}"),
            error => bad_input(error),
        })?;
        let losses = written.losses.into_iter();
        self.warnings.extend(losses.map(|loss| format!("{}: {loss}", path.display())));
        Ok(())
    }

    /// The carriage for sources of `size`, made at the first of them.
    fn carriage(&mut self, size: Size) -> &Carriage {
        let (args, pair, target) = (self.args, self.pair, self.base.size());
        self.carriages.entry(size).or_insert_with(|| {
            let direction = if args.reverse { Direction::Reverse } else { Direction::Forward };
            let options = TransferOptions {
                filter: args.filter(),
                map: MapOptions { gutter_px: args.gutter },
                linear_light: args.linear_light,
            };
            if args.fit {
                let fit = FitOptions { max_steps: args.fit_steps, ..FitOptions::default() };
                Carriage::Fitted(Box::new(Fit::new(pair, direction, size, target, &options, fit)))
            } else {
                Carriage::Sampled(Transfer::new(pair, direction, size, target, &options))
            }
        })
    }

    /// Which texels are covered, the same for sources of every size; `None` if none was readable.
    fn mask(&self) -> Option<Texture> {
        Some(self.carriages.values().next()?.transfer().map().mask())
    }
}

/// What textures of one size are carried by.
enum Carriage {
    Sampled(Transfer),
    Fitted(Box<Fit>),
}

impl Carriage {
    fn transfer(&self) -> &Transfer {
        match self {
            Self::Sampled(transfer) => transfer,
            Self::Fitted(fit) => fit.transfer(),
        }
    }

    fn apply(
        &self,
        source: Texture,
        base: Texture,
    ) -> Result<(Texture, Option<FitSummary>), TransferError> {
        match self {
            Self::Sampled(transfer) => Ok((transfer.apply(source, base)?, None)),
            Self::Fitted(fit) => fitting::fit(fit, source, base).map(|(t, how)| (t, Some(how))),
        }
    }
}
