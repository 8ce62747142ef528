//! `uvgraft transfer`: carries textures across.

mod progress;

use std::path::PathBuf;
use std::process::ExitCode;

use uvgraft::{
    Averaging, Direction, FitOptions, MapOptions, NormalOptions, NormalY, Overlap, Size,
};
use uvgraft_io::image::{Format, WriteOptions};
use uvgraft_pipeline::{Existing, Inputs, MaterialMap, Onto, Role, Transfer, Values};

use crate::blending::BlendArgs;
use crate::failure::{bad_input, exit_code_of};
use crate::filters::FilterName;
use crate::picture::check_name;
use crate::preference::PreferName;
use crate::preview;
use crate::region::RegionArgs;
use crate::report::parse_size;
use crate::role_file::{NormalYName, RoleFile};
use progress::Progress;

/// Carries textures from one layout onto a base in the other.
///
/// Formats are told by content when reading (PNG, JPEG, WebP, TIFF, EXR) and by extension when
/// writing. The result has all channels of source and base and the greater bit depth of both.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// The pair file
    pair: PathBuf,
    /// Textures in the source's layout, or one folder of them
    #[arg(required_unless_present = "maps", conflicts_with = "maps", value_name = "SRC")]
    sources: Vec<PathBuf>,
    /// A map of a material and what it is, such as albedo=a.png, normal=n.png, roughness=r.png or
    /// displacement=d.exr; each is treated accordingly and written to the output folder under that name
    #[arg(long = "map", value_name = "ROLE=FILE", value_parser = RoleFile::parse)]
    maps: Vec<RoleFile>,
    /// What the texture is laid over: an image in the target's layout, or a colour such as #808080
    /// or #80808000; with --map for each role, as ROLE=IMAGE [default: transparent, for data 0, for
    /// normals flat]
    #[arg(long, value_name = "[ROLE=]IMAGE|COLOUR")]
    onto: Vec<String>,
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
    /// Write which texels the textures are carried to, white on black, and grey where the base shows
    /// through a feather; the gutter is black
    #[arg(long, value_name = "OUT_MASK.png")]
    mask: Option<PathBuf>,
    /// What shows where islands overlap, as two eyes do that share one disc
    #[arg(long, value_enum, default_value = "first")]
    overlap: OverlapName,
    /// Which way the green channel of normal maps points, with --map normal
    #[arg(long, value_enum, default_value = "opengl")]
    normal_y: NormalYName,
    /// Which way it points in the base and in the result [default: as --normal-y]
    #[arg(long, value_enum)]
    normal_y_out: Option<NormalYName>,
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
    /// Leave out outputs that are up to date: as they were written, from inputs with the same content, with the
    /// same options. What each was made from is noted in .uvgraft-manifest.jsonl beside them
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
    #[command(flatten)]
    region: RegionArgs,
    #[command(flatten)]
    blending: BlendArgs,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum OverlapName {
    /// The island that --prefer says
    First,
    /// The mean of both
    Average,
}

impl From<OverlapName> for Overlap {
    fn from(name: OverlapName) -> Self {
        match name {
            OverlapName::First => Self::First,
            OverlapName::Average => Self::Average,
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
    args.blending.check()?;
    let done = args.transfer()?.run(&Progress::new())?;
    if let (Some(path), Some(blend), Some(file)) = (&args.blending.preview, &done.blend, &done.pair)
        && (done.written > 0 || done.failures.is_empty())
    {
        preview::write_region(file, blend, path)?;
    }
    Ok(done.worst().map_or(ExitCode::SUCCESS, exit_code_of))
}

impl Args {
    /// What the options ask for.
    fn transfer(&self) -> anyhow::Result<Transfer> {
        let mut transfer = Transfer::new(&self.pair, self.inputs()?, &self.output);
        transfer.direction = if self.reverse { Direction::Reverse } else { Direction::Forward };
        transfer.size = self.size;
        transfer.filter = self.filter.map(Into::into);
        transfer.map = MapOptions::with_gutter(self.gutter).prefer(self.prefer.into());
        transfer.overlap = self.overlap.into();
        transfer.averaging = if self.linear_light { Averaging::Light } else { Averaging::Encoded };
        let normal_y = self.normal_y.into();
        let normal_y_out = self.normal_y_out.map_or(normal_y, NormalY::from);
        transfer.normals = NormalOptions::new(normal_y, normal_y_out);
        transfer.fit = self.fit.then(|| FitOptions::default().max_steps(self.fit_steps));
        transfer.region = self.region.region();
        transfer.blending = self.blending.blending_if_any(&self.region, self.gutter);
        transfer.source_mask.clone_from(&self.blending.source_mask);
        transfer.fill.clone_from(&self.blending.fill);
        transfer.format.clone_from(&self.format);
        transfer.write = WriteOptions::default().compress(self.compress).jpeg_quality(self.quality);
        transfer.mask.clone_from(&self.mask);
        if let Some(labels) = self.blending.drawn_labels() {
            check_name(labels, "a picture of labels")?;
            if self.sources.len() > 1 || self.sources.iter().any(|source| source.is_dir()) {
                return Err(bad_input("--labels draws what one texture shows, not several"));
            }
            transfer.draw_labels = Some(labels.to_path_buf());
        }
        transfer.existing =
            if self.skip_existing { Existing::KeepUpToDate } else { Existing::Replace };
        transfer.jobs = self.jobs;
        transfer.memory = self.memory;
        if let Some(preview) = &self.blending.preview {
            check_name(preview, "a preview")?;
            transfer.also_written.push(preview.clone());
        }
        Ok(transfer)
    }

    /// The textures, and what they are laid over.
    fn inputs(&self) -> anyhow::Result<Inputs> {
        if self.maps.is_empty() {
            if let [_, second, ..] = &self.onto[..] {
                return Err(bad_input(format!("--onto {second}: textures are laid over one base")));
            }
            let onto = self.onto.first().map(|text| Onto::parse(text)).transpose()?;
            let values = if self.data { Values::Data } else { Values::Albedo };
            return Ok(Inputs::Textures { sources: self.sources.clone(), onto, values });
        }
        if self.data {
            return Err(bad_input("--map says what each texture is: leave out --data"));
        }
        let mut bases = Vec::with_capacity(self.onto.len());
        for text in &self.onto {
            let base = RoleFile::parse(text).map_err(|_| {
                bad_input(format!("--onto {text}: with --map wanted ROLE=IMAGE or ROLE=COLOUR"))
            })?;
            if !self.maps.iter().any(|map| map.role == base.role) {
                return Err(bad_input(format!("--onto {text}: there is no --map {}", base.role)));
            }
            bases.push(base);
        }
        let maps = self.maps.iter().map(|map| {
            let mut of_role = bases.iter().filter(|base| base.role == map.role);
            let onto = of_role.next().map(|base| Onto::parse(&base.file)).transpose()?;
            if of_role.next().is_some() {
                return Err(bad_input(format!("--onto {}= is given twice", map.role)));
            }
            let (role, source) = (Role::named(&map.role)?, PathBuf::from(&map.file));
            Ok(MaterialMap { role, source, onto })
        });
        Ok(Inputs::Material(maps.collect::<anyhow::Result<_>>()?))
    }
}
