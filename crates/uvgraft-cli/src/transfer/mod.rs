//! `uvgraft transfer`: carries textures across.

mod base;
mod batch;
mod carrier;
mod pipeline;
mod plan;
mod treatment;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use uvgraft::blend::Ground;
use uvgraft::{Direction, Filter, FitOptions, MapOptions, Overlap, Size};
use uvgraft_io::image::{self, Format, Image};
use uvgraft_io::pair_file;

use crate::blending::{BlendArgs, Blending, Known};
use crate::failure::{OrBadInput, bad_input, warn};
use crate::filters::FilterName;
use crate::onto::Onto;
use crate::outputs::Outputs;
use crate::picture::check_name;
use crate::preference::PreferName;
use crate::preview;
use crate::region::RegionArgs;
use crate::report::{parse_size, to_stdout};
use base::Base;
use carrier::{Carrier, losses};
use plan::{Job, Plan, format_of};
use treatment::{NormalYName, RoleFile, Treatment};

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
    /// Leave out outputs that are newer than everything they are made from: source, base, pair, masks
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

/// Textures that are treated alike and laid over one base.
struct Batch {
    treatment: Treatment,
    onto: Option<Onto>,
    jobs: Vec<Job>,
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    check(args)?;
    let (mut batches, mut new_folder) = batches(args)?;
    let sources = batches.iter().flat_map(|batch| &batch.jobs).map(|job| job.source.clone());
    let regions = args.region.inputs();
    let bases =
        batches.iter().filter_map(|batch| batch.onto.as_ref()?.path()).map(Path::to_path_buf);
    let masks = args.blending.inputs().map(Path::to_path_buf);
    let shared: Vec<PathBuf> =
        [args.pair.clone()].into_iter().chain(regions).chain(bases).chain(masks).collect();
    let inputs: Vec<PathBuf> = shared.iter().cloned().chain(sources).collect();
    let mut outputs = Outputs::new(inputs.iter().map(PathBuf::as_path));
    if new_folder.is_none() {
        let mut jobs = batches.iter().flat_map(|batch| &batch.jobs);
        jobs.try_for_each(|job| outputs.check(&job.output))?;
    }
    let count = |batches: &[Batch]| batches.iter().map(|batch| batch.jobs.len()).sum::<usize>();
    let planned = count(&batches);
    if args.skip_existing {
        for batch in &mut batches {
            batch.jobs.retain(|job| !job.is_done(shared.iter().map(PathBuf::as_path)));
        }
    }
    let left = count(&batches);
    if let Some(mask) = &args.mask {
        if format_of(mask)? == Format::Jpeg {
            let mask = mask.display();
            return Err(bad_input(format!("{mask}: JPEG would blur the mask; name it .png")));
        }
        outputs.check(mask)?;
    }
    if let Some(preview) = &args.blending.preview {
        check_name(preview, "a preview")?;
        outputs.check(preview)?;
    }
    if args.skip_existing {
        to_stdout(&format!("{} of {planned} were up to date\n", planned - left))?;
        if left == 0 && args.mask.is_none() && args.blending.preview.is_none() {
            return Ok(ExitCode::SUCCESS);
        }
    }
    let file = pair_file::read(&args.pair).or_bad_input()?;
    let blends = args.blending.blends(&args.region);
    let ground = blends.then(|| Ground::new(&file.pair, direction(args)));
    let with_maps = !args.maps.is_empty();
    let known = Known::new(&args.blending)?;
    let blending = ground.as_ref().map(|ground| {
        Blending::new(&args.blending, &args.region, args.gutter, ground, &known, with_maps)
    });
    let blending = blending.transpose()?;
    if batches.len() > 1 {
        batches.iter().try_for_each(|batch| Base::check(args, batch.onto.as_ref()))?;
    }
    let (mut code, mut count) = (None, 0);
    let mut mask = args.mask.as_deref();
    for Batch { treatment, onto, jobs } in batches {
        let in_memory = jobs.len() > 1 || (treatment.is_toned() && args.blending.needs_colors());
        let base = Base::new(args, treatment, onto.as_ref(), in_memory)?;
        if let Some(folder) = new_folder.take() {
            std::fs::create_dir(folder)
                .with_context(|| format!("cannot make the folder {}", folder.display()))
                .or_bad_input()?;
        }
        let carrier = Carrier::new(args, treatment, &file.pair, &base, blending.as_ref(), &known);
        let carried = batch::run(&carrier, &jobs, &base, args)?;
        // A failure at work weighs more than a bad file.
        code = code.into_iter().chain(carried.code).min();
        count += carried.count;
        if carried.count > 0 || left == 0 {
            // The same for all: of the first that was carried.
            if let Some(path) = mask.take() {
                let mask = Image::from(carrier.mask(base.size())?);
                let written = image::write(&mask, path, &carrier.write_options());
                losses(written, path)?.iter().for_each(warn);
            }
        }
    }
    if let (Some(path), Some(blending)) = (&args.blending.preview, &blending)
        && (count > 0 || left == 0)
    {
        preview::write_region(&file, direction(args), blending.blend(), path)?;
    }
    Ok(code.map_or(ExitCode::SUCCESS, ExitCode::from))
}

/// Which way the options say.
fn direction(args: &Args) -> Direction {
    if args.reverse { Direction::Reverse } else { Direction::Forward }
}

fn check(args: &Args) -> anyhow::Result<()> {
    if args.fit && Treatment::plain(args).filter(args) == Filter::Nearest {
        return Err(bad_input(
            "--fit would blend texels, and --filter nearest never does: leave one of them out",
        ));
    }
    if args.fit && args.overlap == OverlapName::Average {
        return Err(bad_input(
            "--fit solves for one of the islands that overlap: leave out --overlap",
        ));
    }
    if args.fit && !args.maps.is_empty() {
        return Err(bad_input("--fit is for textures that are named without --map"));
    }
    if args.data && !args.maps.is_empty() {
        return Err(bad_input("--map says what each texture is: leave out --data"));
    }
    if args.data && args.blending.inputs().next().is_some() {
        return Err(bad_input(
            "--data has no opacity and no tone: leave out --skin, --source-mask, --fill",
        ));
    }
    if args.data && args.blending.needs_colors() {
        return Err(bad_input(
            "--data has no tone: leave out --match, and say --blend feather or --tone none",
        ));
    }
    args.blending.check()
}

/// What is to be done, and the folder that has to be made for it.
fn batches(args: &Args) -> anyhow::Result<(Vec<Batch>, Option<&Path>)> {
    if args.maps.is_empty() {
        if let [_, second, ..] = &args.onto[..] {
            return Err(bad_input(format!("--onto {second}: textures are laid over one base")));
        }
        let Plan { jobs, new_folder } = Plan::new(args)?;
        let onto = args.onto.first().map(|text| Onto::parse(text)).transpose()?;
        return Ok((vec![Batch { treatment: Treatment::plain(args), onto, jobs }], new_folder));
    }
    let mut bases = Vec::with_capacity(args.onto.len());
    for text in &args.onto {
        let base = RoleFile::parse(text).map_err(|_| {
            bad_input(format!("--onto {text}: with --map wanted ROLE=IMAGE or ROLE=COLOUR"))
        })?;
        if !args.maps.iter().any(|map| map.role == base.role) {
            return Err(bad_input(format!("--onto {text}: there is no --map {}", base.role)));
        }
        bases.push(base);
    }
    let (jobs, new_folder) = plan::of_maps(args)?;
    let mut batches = Vec::with_capacity(jobs.len());
    for (map, job) in args.maps.iter().zip(jobs) {
        let mut of_role = bases.iter().filter(|base| base.role == map.role);
        let onto =
            of_role.next().map(|base| Onto::parse(&base.path.to_string_lossy())).transpose()?;
        if of_role.next().is_some() {
            return Err(bad_input(format!("--onto {}= is given twice", map.role)));
        }
        let treatment = Treatment::of_role(&map.role, args)?;
        batches.push(Batch { treatment, onto, jobs: vec![job] });
    }
    Ok((batches, new_folder))
}
