//! `uvgraft transfer`: carries textures across.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use uvgraft::{
    Channels, Depth, Direction, Encoding, Filter, MapOptions, Pair, Size, Texture, Transfer,
    TransferOptions,
};
use uvgraft_io::image::{self, EncodeError, Format, Image, WriteError, WriteOptions};
use uvgraft_io::pair_file;

use crate::failure::{self, OrBadInput, bad_input, warn};
use crate::outputs::Outputs;
use crate::report::parse_size;

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
    /// Size of the result [default: the base's]
    #[arg(long, value_name = "N|WxH", value_parser = parse_size)]
    size: Option<Size>,
    /// How values between texels are made
    #[arg(long, value_enum, default_value_t = FilterName::Lanczos3)]
    filter: FilterName,
    /// Texels beyond the UV islands that are filled
    #[arg(long, value_name = "TEXELS", default_value_t = MapOptions::default().gutter_px)]
    #[arg(value_parser = clap::value_parser!(u32).range(0..=1024))]
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
    /// Write small files rather than fast
    #[arg(long)]
    compress: bool,
    /// Quality of JPEG files, 1 to 100
    #[arg(long, default_value_t = 95, value_parser = clap::value_parser!(u8).range(1..=100))]
    quality: u8,
}

#[derive(Clone, Copy, ValueEnum)]
enum FilterName {
    /// One texel, never blended; for labels
    Nearest,
    /// Two texels an axis; fastest that is smooth
    Bilinear,
    /// Four texels an axis; sharp
    CatmullRom,
    /// Six texels an axis; keeps most of a texture there and back
    Lanczos3,
}

impl From<FilterName> for Filter {
    fn from(name: FilterName) -> Self {
        match name {
            FilterName::Nearest => Self::Nearest,
            FilterName::Bilinear => Self::Bilinear,
            FilterName::CatmullRom => Self::CatmullRom,
            FilterName::Lanczos3 => Self::Lanczos3,
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
    let Plan { jobs, new_folder } = Plan::new(args)?;
    let base_path = args.onto.as_deref().filter(|onto| !onto.starts_with('#')).map(Path::new);
    let inputs = [&*args.pair].into_iter().chain(base_path);
    let mut outputs = Outputs::new(inputs.chain(jobs.iter().map(|job| &*job.source)));
    if new_folder.is_none() {
        jobs.iter().try_for_each(|job| outputs.check(&job.output))?;
    }
    if let Some(mask) = &args.mask {
        format_of(mask)?;
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

    let progress = if jobs.len() > 1 { bar(jobs.len()) } else { ProgressBar::hidden() };
    let mut worst = None;
    for job in &jobs {
        progress.set_message(job.source.display().to_string());
        let result = carrier.carry(job);
        progress.suspend(|| {
            carrier.warnings.drain(..).for_each(warn);
            if let Err(error) = &result {
                failure::report(error);
            }
        });
        if let Err(error) = result {
            // A failure at work weighs more than a bad file.
            let code = failure::exit_code(&error);
            worst = Some(worst.map_or(code, |worst: u8| worst.min(code)));
        }
        progress.inc(1);
    }
    progress.finish_and_clear();
    if let (Some(path), Some(mask)) = (&args.mask, carrier.mask()) {
        carrier.write(&Image::from(mask), path)?;
        carrier.warnings.drain(..).for_each(warn);
    }
    Ok(worst.map_or(ExitCode::SUCCESS, ExitCode::from))
}

/// A texture to carry and where its result goes.
struct Job {
    source: PathBuf,
    output: PathBuf,
}

/// What is to be done, and the folder that has to be made for it.
struct Plan<'a> {
    jobs: Vec<Job>,
    new_folder: Option<&'a Path>,
}

impl<'a> Plan<'a> {
    /// One job, or one for each of several sources or each image of a folder.
    fn new(args: &'a Args) -> anyhow::Result<Self> {
        let (sources, output) = (&args.sources, &*args.output);
        let single = sources.len() == 1 && !sources[0].is_dir();
        let says_folder = output.as_os_str().as_encoded_bytes().ends_with(b"/");
        if single && !output.is_dir() && !says_folder {
            let format = format_of(output)?;
            if let Some(name) = args.format.as_deref()
                && Format::from_extension(name) != Some(format)
            {
                let output = output.display();
                return Err(bad_input(format!("--format {name} contradicts the output {output}")));
            }
            let job = Job { source: sources[0].clone(), output: output.to_path_buf() };
            return Ok(Self { jobs: vec![job], new_folder: None });
        }
        let is_new = !output.is_dir();
        let says_file = Format::from_path(output).is_some() && !says_folder;
        if is_new && (output.exists() || says_file) {
            return Err(bad_input(format!(
                "output {} is no folder; several sources are written into one",
                output.display()
            )));
        }
        let mut paths = Vec::new();
        for source in sources {
            if source.is_dir() {
                paths.extend(images_in(source)?);
            } else {
                paths.push(source.clone());
            }
        }
        let mut taken: HashMap<PathBuf, PathBuf> = HashMap::new();
        let mut jobs = Vec::with_capacity(paths.len());
        for source in paths {
            let name = source.file_name().map(PathBuf::from).unwrap_or_default();
            let name = match &args.format {
                Some(format) => name.with_extension(format),
                None => name,
            };
            let output = output.join(&name);
            if Format::from_path(&name).is_none() {
                return Err(bad_input(format!(
                    "{}: its name says no format to write {} in; say --format png, for instance",
                    source.display(),
                    output.display()
                )));
            }
            if let Some(other) = taken.insert(output.clone(), source.clone()) {
                let (other, source) = (other.display(), source.display());
                return Err(bad_input(format!(
                    "{other} and {source} would both become {}",
                    output.display()
                )));
            }
            jobs.push(Job { source, output });
        }
        Ok(Self { jobs, new_folder: is_new.then_some(output) })
    }
}

/// The files of a folder whose names say that they are images, sorted. Hidden ones are left out:
/// some systems put a `._face.png`, which is no image, beside each `face.png`.
fn images_in(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let entries = folder.read_dir().and_then(Iterator::collect::<Result<Vec<_>, _>>);
    let entries = entries
        .with_context(|| format!("cannot read the folder {}", folder.display()))
        .or_bad_input()?;
    let mut images: Vec<PathBuf> = entries
        .into_iter()
        .map(|entry| entry.path())
        .filter(|path| path.is_file() && Format::from_path(path).is_some() && !is_hidden(path))
        .collect();
    if images.is_empty() {
        let wanted = Format::extension_list();
        return Err(bad_input(format!("{} holds no image ({wanted})", folder.display())));
    }
    images.sort();
    Ok(images)
}

fn is_hidden(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."))
}

fn format_of(path: &Path) -> anyhow::Result<Format> {
    Format::from_path(path).ok_or_else(|| {
        bad_input(format!(
            "{}: wanted a name that ends in {}",
            path.display(),
            Format::extension_list()
        ))
    })
}

/// What textures are laid over.
enum Base {
    Image(Image, String),
    Color { unit: [f32; 4], size: Size },
}

impl Base {
    fn new(args: &Args, path: Option<&Path>) -> anyhow::Result<Self> {
        if let Some(path) = path {
            let mut image = image::read(path).map_err(|error| match path.exists() {
                true => bad_input(error),
                false => {
                    bad_input(format!("{error}; --onto wants an image or a colour such as #808080"))
                }
            })?;
            image.texture = meant(image.texture, args);
            if let Some(size) = args.size {
                image.texture = image
                    .texture
                    .resized(size, args.filter.into(), args.linear_light)
                    .or_bad_input()?;
            }
            return Ok(Self::Image(image, path.display().to_string()));
        }
        let unit = args.onto.as_deref().map_or(Ok([0.0; 4]), parse_color)?;
        let size = args.size.ok_or_else(|| {
            bad_input("without a base image the result needs a size: give --size N or --onto IMAGE")
        })?;
        Ok(Self::Color { unit, size })
    }

    fn size(&self) -> Size {
        match self {
            Self::Image(image, _) => image.texture.size(),
            Self::Color { size, .. } => *size,
        }
    }

    /// What is worth knowing about the ICC profiles of the base and of a source.
    fn mismatch(&self, source: &Image, name: &Path) -> Option<String> {
        let Self::Image(base, base_name) = self else { return None };
        let name = name.display();
        let found = match (&source.icc, &base.icc) {
            (source, base) if source == base => return None,
            (Some(_), Some(_)) => {
                format!(
                    "{name} and {base_name} have different ICC profiles; the result has that of {base_name}"
                )
            }
            (Some(_), None) => {
                format!("{name} has an ICC profile, {base_name} has none; nor has the result")
            }
            (None, _) => {
                format!(
                    "{base_name} has an ICC profile, {name} has none; the result has that of {base_name}"
                )
            }
        };
        Some(format!("{found}, and values are carried as they are"))
    }

    /// The base to lay `source` over, and the ICC profile that goes with it.
    fn under(&self, source: &Image) -> anyhow::Result<(Texture, Option<Vec<u8>>)> {
        match self {
            Self::Image(base, _) => Ok((base.texture.clone(), base.icc.clone())),
            Self::Color { unit, size } => {
                let [r, g, b, alpha] = *unit;
                let texture = &source.texture;
                let colored = texture.channels().has_color() || r != g || g != b;
                let clear = texture.channels().has_alpha() || alpha < 1.0;
                let channels = Channels::new(colored, clear);
                let full = Texture::filled(*size, Channels::Rgba, Encoding::Srgb, Depth::U8, unit)?;
                let full = full.encoded_as(texture.encoding());
                Ok((full.converted(channels, texture.depth()), source.icc.clone()))
            }
        }
    }
}

/// `#RGB`, `#RRGGBB` or `#RRGGBBAA`, as values with 1.0 for full.
fn parse_color(text: &str) -> anyhow::Result<[f32; 4]> {
    let digits = text.strip_prefix('#').unwrap_or_default();
    let wanted = || bad_input(format!("colour {text:?}: wanted #RGB, #RRGGBB or #RRGGBBAA"));
    if !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return Err(wanted());
    }
    let value = |text: &str| u8::from_str_radix(text, 16).map_err(|_| wanted());
    let values = match digits.len() {
        3 => {
            (0..3).map(|k| Ok(value(&digits[k..=k])? * 17)).collect::<anyhow::Result<Vec<u8>>>()?
        }
        6 | 8 => (0..digits.len() / 2)
            .map(|k| value(&digits[2 * k..2 * k + 2]))
            .collect::<anyhow::Result<Vec<u8>>>()?,
        _ => return Err(wanted()),
    };
    let unit = |channel: usize| f32::from(values.get(channel).copied().unwrap_or(255)) / 255.0;
    Ok([unit(0), unit(1), unit(2), unit(3)])
}

/// A texture that is what the options say it is.
fn meant(texture: Texture, args: &Args) -> Texture {
    if args.data { texture.with_encoding(Encoding::Data) } else { texture }
}

/// Carries one texture after the other, keeping what they share.
struct Carrier<'a> {
    args: &'a Args,
    pair: &'a Pair,
    base: &'a Base,
    options: WriteOptions,
    /// What the user should know about the textures carried since this was last emptied.
    warnings: Vec<String>,
    transfers: HashMap<Size, Transfer>,
}

impl<'a> Carrier<'a> {
    fn new(args: &'a Args, pair: &'a Pair, base: &'a Base) -> Self {
        let options = WriteOptions { compress: args.compress, jpeg_quality: args.quality };
        Self { args, pair, base, options, warnings: Vec::new(), transfers: HashMap::new() }
    }

    fn carry(&mut self, job: &Job) -> anyhow::Result<()> {
        let mut source = image::read(&job.source).or_bad_input()?;
        source.texture = meant(source.texture, self.args);
        self.warnings.extend(self.base.mismatch(&source, &job.source));
        let (base, mut icc) = self.base.under(&source)?;
        let owner = if let Base::Image(..) = self.base { &base } else { &source.texture };
        let owner_has_color = owner.channels().has_color();
        let texture = self.transfer(source.texture.size()).apply(source.texture, base)?;
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
        self.write(&Image { texture, icc }, &job.output)
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

    /// The transfer for sources of `size`, made at the first of them.
    fn transfer(&mut self, size: Size) -> &Transfer {
        let (args, pair, target) = (self.args, self.pair, self.base.size());
        self.transfers.entry(size).or_insert_with(|| {
            let direction = if args.reverse { Direction::Reverse } else { Direction::Forward };
            let options = TransferOptions {
                filter: args.filter.into(),
                map: MapOptions { gutter_px: args.gutter },
                linear_light: args.linear_light,
            };
            Transfer::new(pair, direction, size, target, &options)
        })
    }

    /// Which texels are covered, the same for sources of every size; `None` if none was readable.
    fn mask(&self) -> Option<Texture> {
        Some(self.transfers.values().next()?.map().mask())
    }
}

fn bar(count: usize) -> ProgressBar {
    // Drawn on standard error, and only if that is a terminal.
    let bar = ProgressBar::new(count as u64);
    match ProgressStyle::with_template("{bar:32} {pos}/{len} {eta:>4} {wide_msg}") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors() {
        let grey = 128.0 / 255.0;
        assert_eq!(parse_color("#808080").unwrap(), [grey, grey, grey, 1.0]);
        assert_eq!(parse_color("#f00").unwrap(), [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(parse_color("#00ff0000").unwrap(), [0.0, 1.0, 0.0, 0.0]);
        for bad in ["#", "#12", "##123", "#12345", "#gggggg", "#ééé"] {
            assert!(parse_color(bad).unwrap_err().to_string().contains(bad), "{bad}");
        }
    }
}
