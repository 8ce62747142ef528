//! `uvgraft transfer`: transfers textures from one layout to the other.

mod progress;
mod rows;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use uvgraft::{
    Anatomy, Averaging, Choice, Direction, Filter, FitOptions, MapOptions, NormalOptions, NormalY,
    Overlap, Prefer, Size,
};
use uvgraft_assembly::drawing::check_name;
use uvgraft_assembly::pair_picture;
use uvgraft_image::{Format, WriteOptions};
use uvgraft_io::pair_file::PairFile;
use uvgraft_pipeline::{
    BaseSource, Correspondence, Existing, Fault, Input, Inputs, MaterialMap, Role, Shard,
    TextureList, Transfer, Transferred, Values, parse_memory,
};

use crate::blending::BlendArgs;
use crate::choice::choice;
use crate::failure::{bad_input, exit_code_of};
use crate::heading;
use crate::number::whole_number;
use crate::outcome;
use crate::progress::Activity;
use crate::region::RegionArgs;
use crate::report::parse_size;
use crate::role_file::RoleFile;
use progress::Progress;
use rows::Rows;

/// The options that most people need.
const COMMON: [&str; 10] = [
    "output",
    "onto",
    "size",
    "blend",
    "tone",
    "region",
    "reverse",
    "filter",
    "map",
    "skip_existing",
];

/// Transfer textures from one UV layout onto a base texture in the other
///
/// Input formats (PNG, JPEG, WebP, TIFF, EXR) are detected from the content of the files; output
/// formats follow from their extensions. The result has the channels of both source and base, and
/// the greater bit depth of the two.
///
/// A texture may have an image for each UDIM tile: face_<UDIM>.png stands for face_1001.png,
/// face_1002.png and so on, in textures, bases and outputs.
#[derive(clap::Args)]
#[command(mut_args(|option| heading::common(&COMMON, option)))]
pub(crate) struct Args {
    /// Pair file that links the two meshes; none with --with-map
    #[arg(required_unless_present = "with_map")]
    pair: Option<PathBuf>,
    /// Textures in the source layout, or one folder of them
    #[arg(required_unless_present_any = ["map", "with_map", "manifest"], conflicts_with = "map")]
    #[arg(value_name = "TEXTURE")]
    sources: Vec<PathBuf>,
    /// Output file, or folder for several textures
    #[arg(short, long, value_name = "OUT", help_heading = heading::FILES)]
    output: PathBuf,
    /// Use a map of positions in place of a pair
    ///
    /// An NPY array of `uvgraft map`, the NPZ of the reference implementation, or an ST map (EXR). All
    /// other arguments are textures then. Results have the size of the map. A map knows no meshes:
    /// textures are not padded around their UV islands before they are read, taps beyond the edge
    /// read the edge texels, the footprint of filters is estimated from neighbouring texels, and
    /// --gutter and --prefer are those of the map.
    #[arg(long, value_name = "MAP", help_heading = heading::FILES)]
    #[arg(conflicts_with_all = ["gutter", "prefer"])]
    with_map: Option<PathBuf>,
    /// Base texture or colour beneath the result [default: transparent]
    ///
    /// An image in the target layout, or a colour such as #808080 or #80808000. With --map, repeat
    /// the option for each role, as ROLE=IMAGE or ROLE=COLOUR. Without a base, data maps start from
    /// 0 and normal maps from flat normals.
    #[arg(long, value_name = "[ROLE=]IMAGE|COLOUR", help_heading = heading::FILES)]
    onto: Vec<String>,
    /// Also write a mask of the texels that the transfer covers
    ///
    /// White where the texture covers the base, grey where the base shows through a feather, and
    /// black elsewhere, including the gutter.
    #[arg(long, value_name = "OUT.png", help_heading = heading::FILES)]
    mask: Option<PathBuf>,
    /// Transfer from the target layout to the source layout
    #[arg(long, help_heading = heading::FILES)]
    reverse: bool,
    /// Size of the result in texels [default: the base's size]
    ///
    /// A base image of another size is resized. Required without a base image.
    #[arg(long, value_name = "N|WxH", value_parser = parse_size, allow_negative_numbers = true, help_heading = heading::FILES)]
    size: Option<Size>,
    /// Interpolation filter [default: lanczos3; bilinear with --data]
    #[arg(long, value_parser = choice::<Filter>(), help_heading = heading::SAMPLING)]
    filter: Option<Filter>,
    /// Width of the gutter around UV islands, in texels
    ///
    /// The texture continues into the gutter, so that filtering and mip levels do not pick up the
    /// background.
    #[arg(long, value_name = "TEXELS", default_value_t = MapOptions::default().gutter_px)]
    #[arg(value_parser = whole_number::<u32>(0..=256), allow_negative_numbers = true, help_heading = heading::SAMPLING)]
    gutter: u32,
    /// UV island that owns texels shared by several islands
    ///
    /// Matters for layouts with overlapping islands, such as two eyes that share one disc.
    #[arg(long, value_name = "ISLAND", default_value = Prefer::First.name(), value_parser = choice::<Prefer>())]
    #[arg(help_heading = heading::SAMPLING)]
    prefer: Prefer,
    /// How to combine overlapping UV islands
    #[arg(long, value_name = "MODE", default_value = Overlap::First.name(), value_parser = choice::<Overlap>())]
    #[arg(help_heading = heading::SAMPLING)]
    overlap: Overlap,
    /// Average colours in linear light instead of as encoded
    #[arg(long, help_heading = heading::SAMPLING)]
    linear_light: bool,
    /// Treat textures as data such as roughness or masks, and never convert their values
    #[arg(long, conflicts_with = "linear_light", help_heading = heading::SAMPLING)]
    data: bool,
    /// Solve for the texture that best reproduces the source when transferred back
    ///
    /// A least-squares fit, slower than sampling. Assumes the same filter on the way back. The
    /// result is sharper and may overshoot with any filter.
    #[arg(long, help_heading = heading::SAMPLING)]
    fit: bool,
    /// Maximum number of steps for --fit
    ///
    /// The solver stops earlier when another step gains little.
    #[arg(long, value_name = "N", requires = "fit", default_value_t = FitOptions::default().max_steps)]
    #[arg(value_parser = whole_number::<u32>(1..=1000), allow_negative_numbers = true, help_heading = heading::SAMPLING)]
    fit_steps: u32,
    #[command(flatten)]
    region: RegionArgs,
    #[command(flatten)]
    blending: BlendArgs,
    /// Material map to transfer, by its role; repeatable
    ///
    /// For example albedo=a.png, normal=n.png, roughness=r.png or displacement=d.exr. The role
    /// decides how the map is filtered and converted. Each map is written to the output folder
    /// under the name of its role.
    #[arg(id = "map", long = "map", value_name = "ROLE=FILE", value_parser = RoleFile::parse)]
    #[arg(help_heading = heading::MATERIALS)]
    maps: Vec<RoleFile>,
    /// Green channel convention of input normal maps [default: opengl]
    #[arg(long, value_name = "CONVENTION", value_parser = choice::<NormalY>(), help_heading = heading::MATERIALS)]
    normal_y: Option<NormalY>,
    /// Green channel convention of the base and the result [default: as --normal-y]
    #[arg(long, value_name = "CONVENTION", value_parser = choice::<NormalY>(), help_heading = heading::MATERIALS)]
    normal_y_out: Option<NormalY>,
    /// Read the textures from a list, one path per line, or - for standard input
    ///
    /// A UTF-8 text file. Relative paths are relative to the current directory. A line may name its
    /// output after a tab: a path within the output folder, whose subfolders are created. Blank
    /// lines and lines that start with # are skipped. A texture that does not exist fails without
    /// stopping the others.
    #[arg(long, value_name = "LIST.txt|-", help_heading = heading::BATCHES)]
    #[arg(conflicts_with_all = ["sources", "map"])]
    manifest: Option<PathBuf>,
    /// Transfer only one of several parts of the textures, such as 0/64
    ///
    /// Shards are numbered from 0, and may run at the same time on several machines with the same
    /// output folder. The name of a texture's output decides on its shard, whatever other textures
    /// there are: the first 8 bytes of its SHA-256, as a big-endian number, modulo the number of
    /// shards.
    #[arg(long, value_name = "I/N", value_parser = parse_shard, allow_hyphen_values = true)]
    #[arg(help_heading = heading::BATCHES)]
    shard: Option<Shard>,
    /// Append a line of JSON for each texture to a file
    ///
    /// Lines are written as textures finish, to the file itself: source, output, status (written,
    /// up to date or failed), error, boundary_delta_e, ms and bytes. Shards should have a file each.
    #[arg(long, value_name = "ROWS.jsonl", help_heading = heading::BATCHES)]
    report: Option<PathBuf>,
    /// Skip outputs that are up to date
    ///
    /// An output is up to date if it is unchanged and was made from inputs with the same content
    /// and with the same options. A record of both is kept in .uvgraft-manifest.jsonl in the output
    /// folder, and for each shard in a file of its own. All of these records are read.
    #[arg(long, help_heading = heading::BATCHES)]
    skip_existing: bool,
    /// Number of textures to process in parallel [default: one per thread]
    #[arg(long, value_name = "N", value_parser = whole_number::<u16>(1..=1024), allow_negative_numbers = true)]
    #[arg(help_heading = heading::BATCHES)]
    jobs: Option<u16>,
    /// Bound on memory, such as 500M or 4G [default: 2G for textures in parallel]
    ///
    /// Fewer textures than --jobs are processed in parallel where they would exceed the bound, and a
    /// transfer that could exceed it alone is refused. Without this option it is processed alone.
    #[arg(long, value_name = "SIZE", value_parser = parse_memory, allow_negative_numbers = true)]
    #[arg(help_heading = heading::BATCHES)]
    memory: Option<u64>,
    /// Output format for several textures [default: each source's format]
    #[arg(long, value_name = "EXTENSION", value_parser = parse_format, help_heading = heading::ENCODING)]
    format: Option<String>,
    /// Write smaller PNG, TIFF and EXR files, more slowly
    #[arg(long, help_heading = heading::ENCODING)]
    compress: bool,
    /// Quality of JPEG files [default: 95]
    #[arg(long, value_name = "1-100", help_heading = heading::ENCODING)]
    #[arg(value_parser = whole_number::<u8>(1..=100), allow_negative_numbers = true)]
    quality: Option<u8>,
}

fn parse_format(text: &str) -> Result<String, String> {
    let extension = text.strip_prefix('.').unwrap_or(text);
    Format::from_extension(extension)
        .map(|_| extension.to_owned())
        .ok_or_else(|| format!("must be one of {}", Format::extension_list()))
}

fn parse_shard(text: &str) -> Result<Shard, String> {
    Shard::parse(text).map_err(|failure| failure.to_string())
}

fn list_at(path: &Path) -> TextureList {
    if path.as_os_str() == "-" {
        TextureList::StandardInput
    } else {
        TextureList::File(path.to_path_buf())
    }
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let transfer = args.checked_transfer()?;
    let rows = args.report.as_deref().map(|path| Rows::new(path, &transfer)).transpose()?;
    let progress = Progress::new(rows, args.shard);
    // Batches and fits have bars.
    let is_alone = matches!(&args.sources()[..], [file] if file.is_file()) && !args.fit;
    let activity = is_alone.then(|| Activity::start("transferring"));
    let done = transfer.run(&progress)?;
    drop(activity);
    if let (Some(path), Some(blend), Some(file)) = (&args.blending.preview, &done.blend, &done.pair)
        && (done.written > 0 || done.failures.is_empty())
    {
        pair_picture::of_region(file, blend)?.write(path)?;
        outcome::wrote(path);
    }
    args.report_outputs(&progress, &done);
    let unsaid = progress.is_silenced().then_some(Fault::Work);
    Ok(done.worst().or(unsaid).map_or(ExitCode::SUCCESS, exit_code_of))
}

/// The transfer alone: nothing is printed, neither on the textures nor on what was written.
pub(crate) fn run_silently(args: &Args) -> anyhow::Result<()> {
    let done = args.checked_transfer()?.run(&())?;
    done.failures.into_iter().next().map_or(Ok(()), |failure| Err(failure.into()))
}

impl Args {
    /// Lists what was written, and how to look at the first of it: on the mesh, if it has colours.
    fn report_outputs(&self, progress: &Progress, done: &Transferred) {
        let written = progress.written();
        match done.written > written.len() {
            true => outcome::wrote(&self.output),
            false => written.iter().for_each(|path| outcome::wrote(path)),
        }
        let others = [self.mask.as_deref(), self.blending.drawn_labels()];
        others.into_iter().flatten().for_each(outcome::wrote);
        let is_color = |path: &&PathBuf| {
            self.maps.is_empty() || path.file_stem().is_some_and(|stem| stem == "albedo")
        };
        let shown = written.iter().find(is_color).filter(|path| !self.data && path.is_file());
        if let (Some(pair), Some(shown)) = (&self.pair, shown)
            && self.with_map.is_none()
            && outcome::has_closing_lines()
        {
            let mesh = format!("{}{}", pair.display(), if self.reverse { "#source" } else { "" });
            let has_head = |file: &PairFile| Anatomy::find(file.pair.to(self.direction())).is_ok();
            let is_head = done.pair.as_ref().is_some_and(has_head);
            outcome::look_by_picture(Path::new(&mesh), Some(shown), is_head);
        }
    }

    /// The transfer that the options describe, if none of them conflict.
    fn checked_transfer(&self) -> anyhow::Result<Transfer> {
        self.blending.settings().check()?;
        self.transfer()
    }

    /// The transfer that the options describe.
    fn transfer(&self) -> anyhow::Result<Transfer> {
        let correspondence = self.correspondence()?;
        let mut transfer = Transfer::by(correspondence, self.inputs()?, &self.output);
        transfer.direction = self.direction();
        transfer.size = self.size;
        transfer.filter = self.filter;
        transfer.map = MapOptions::with_gutter(self.gutter).prefer(self.prefer);
        transfer.overlap = self.overlap;
        transfer.averaging = if self.linear_light { Averaging::Light } else { Averaging::Encoded };
        transfer.normals = self.normals()?;
        transfer.fit = self.fit.then(|| FitOptions::default().max_steps(self.fit_steps));
        transfer.region = self.region.region();
        transfer.blending = self.blending.blending_if_any(&transfer.region, self.gutter);
        transfer.source_mask = self.blending.source_mask.as_ref().map(Input::from);
        transfer.fill = self.blending.fill.as_ref().map(Input::from);
        transfer.format.clone_from(&self.format);
        transfer.write = WriteOptions::default().compress(self.compress);
        transfer.write.jpeg_quality = self.quality;
        transfer.mask.clone_from(&self.mask);
        if let Some(labels) = self.blending.drawn_labels() {
            check_name(labels, "a label image")?;
            let sources = self.sources();
            if sources.len() > 1 || sources.iter().any(|source| source.is_dir()) {
                return Err(bad_input("--labels cannot be used with several textures"));
            }
            transfer.draw_labels = Some(labels.to_path_buf());
        }
        transfer.existing =
            if self.skip_existing { Existing::KeepUpToDate } else { Existing::Replace };
        transfer.shard = self.shard;
        transfer.jobs = self.jobs;
        transfer.memory = self.memory;
        if let Some(preview) = &self.blending.preview {
            check_name(preview, "a preview")?;
            transfer.extra_outputs.push(preview.clone());
        }
        Ok(transfer)
    }

    fn direction(&self) -> Direction {
        if self.reverse { Direction::Reverse } else { Direction::Forward }
    }

    /// The conventions of normal maps, which mean nothing to others.
    fn normals(&self) -> anyhow::Result<NormalOptions> {
        let is_given = self.normal_y.is_some() || self.normal_y_out.is_some();
        if is_given && !self.maps.iter().any(|map| map.role == "normal") {
            return Err(bad_input("--normal-y and --normal-y-out need --map normal=FILE"));
        }
        let normal_y = self.normal_y.unwrap_or(NormalY::OpenGl);
        Ok(NormalOptions::new(normal_y, self.normal_y_out.unwrap_or(normal_y)))
    }

    /// The pair or the map.
    fn correspondence(&self) -> anyhow::Result<Correspondence> {
        match (&self.with_map, &self.pair) {
            (None, Some(pair)) => Ok(Correspondence::Pair(pair.into())),
            (None, None) => Err(bad_input("a pair file or --with-map is required")),
            (Some(_), Some(first)) if !self.maps.is_empty() => Err(bad_input(format!(
                "--with-map and --map leave nothing for {}: leave it out",
                first.display()
            ))),
            (Some(_), Some(first)) if first.extension().is_some_and(|end| end == "uvpair") => {
                Err(bad_input(format!(
                    "--with-map takes the place of a pair: leave out {}",
                    first.display()
                )))
            }
            (Some(map), _) => Ok(Correspondence::Map(map.into())),
        }
    }

    /// The textures: with a map, the first argument is one too.
    fn sources(&self) -> Vec<PathBuf> {
        let first = self.pair.iter().filter(|_| self.with_map.is_some());
        first.chain(&self.sources).cloned().collect()
    }

    /// The textures and their bases.
    fn inputs(&self) -> anyhow::Result<Inputs> {
        if self.maps.is_empty() {
            if let [_, second, ..] = &self.onto[..] {
                return Err(bad_input(format!("--onto {second}: base given twice")));
            }
            let onto = self.onto.first().map(|text| BaseSource::parse(text)).transpose()?;
            let values = if self.data { Values::Data } else { Values::Albedo };
            let sources = self.sources();
            return match (&self.manifest, sources.first()) {
                (None, _) => {
                    let sources = sources.into_iter().map(Input::File).collect();
                    Ok(Inputs::Textures { sources, onto, values })
                }
                (Some(list), None) => Ok(Inputs::Listed { list: list_at(list), onto, values }),
                // With a map, no other argument is a pair.
                (Some(_), Some(first)) => Err(bad_input(format!(
                    "--manifest lists the textures: leave out {}",
                    first.display()
                ))),
            };
        }
        if self.data {
            return Err(bad_input(
                "--data cannot be used with --map, whose roles state what each texture holds",
            ));
        }
        let mut bases = Vec::with_capacity(self.onto.len());
        for text in &self.onto {
            let base = RoleFile::parse(text).map_err(|_| {
                bad_input(format!(
                    "--onto must be ROLE=IMAGE or ROLE=COLOUR with --map, got {text}"
                ))
            })?;
            if !self.maps.iter().any(|map| map.role == base.role) {
                return Err(bad_input(format!(
                    "--onto {text}: no --map has the role {}",
                    base.role
                )));
            }
            bases.push(base);
        }
        let maps = self.maps.iter().map(|map| {
            let mut of_role = bases.iter().filter(|base| base.role == map.role);
            let onto = of_role.next().map(|base| BaseSource::parse(&base.file)).transpose()?;
            if of_role.next().is_some() {
                return Err(bad_input(format!("--onto {}: role given twice", map.role)));
            }
            let (role, source) = (Role::named(&map.role)?, Input::from(&map.file));
            Ok(MaterialMap { role, source, onto })
        });
        Ok(Inputs::Material(maps.collect::<anyhow::Result<_>>()?))
    }
}
