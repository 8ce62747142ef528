//! `uvgraft roundtrip`: the loss of transferring a texture there and back.

mod method;
mod report;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use uvgraft::{Choice, Depth, Direction, Filter, MapOptions, Side, Size, Texture, choices};
use uvgraft_files::output;
use uvgraft_image::{self as image, Header, Image, WriteOptions};
use uvgraft_io::pair_file::{self, PairFile};
use uvgraft_metrics::{Colors, Mask};
use uvgraft_pipeline::Outputs;

use crate::choice::choice;
use crate::failure::{OrBadInput, bad_input, warn};
use crate::files::OrCannotWrite;
use crate::heading;
use crate::heatmap;
use crate::memory::{self, MemoryOption};
use crate::number::whole_number;
use crate::opacity::{over_black, warn_unless_opaque};
use crate::report::parse_size;
use crate::scores::{Judge, MetricsOption, ScoredRegion, Scores};
use crate::terminal;
use crate::{outcome, progress};
use method::{Method, RoundTrip, RoundTripInput};
use report::{Outcome, Report};

/// Transfer a texture to the other layout and back, and measure the loss
///
/// The way back is laid over the original, so texels without a link stay unchanged. Scores are
/// reported for the whole image and for the transferred region alone.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Pair file that links the two meshes
    pair: PathBuf,
    /// Texture to transfer
    texture: PathBuf,
    /// Layout of the texture
    #[arg(long, value_name = "SIDE", default_value = Side::Target.name(), value_parser = choice::<Side>())]
    #[arg(help_heading = heading::FILES)]
    from: Side,
    /// Folder for textures, heatmaps and reports
    ///
    /// For each method: the texture in the other layout (via), the one that came back (back) and a
    /// heatmap of the differences; for all together: report.md and report.json.
    #[arg(short, long, value_name = "FOLDER", help_heading = heading::FILES)]
    output: Option<PathBuf>,
    /// Texture size in the other layout, up to 16384 texels a side
    #[arg(long, value_name = "N|WxH", value_parser = parse_size, allow_negative_numbers = true, help_heading = heading::SAMPLING)]
    via: Size,
    /// Interpolation filters to compare, comma-separated
    #[arg(
        long,
        value_parser = choice::<Filter>(),
        value_delimiter = ',',
        default_value = Filter::default().name(),
        value_name = "LIST",
        help_heading = heading::SAMPLING
    )]
    filter: Vec<Filter>,
    /// Width of the gutter around UV islands in the other layout, in texels
    #[arg(long, value_name = "TEXELS", default_value_t = MapOptions::default().gutter_px)]
    #[arg(value_parser = whole_number::<u32>(0..=256), allow_negative_numbers = true, help_heading = heading::SAMPLING)]
    gutter: u32,
    /// Also measure `transfer --fit` with each filter
    #[arg(long, help_heading = heading::SAMPLING)]
    fit: bool,
    /// Earlier methods to compare with, comma-separated
    #[arg(long, value_delimiter = ',', value_name = "LIST", help_heading = heading::SAMPLING)]
    #[arg(value_parser = choice::<Baseline>())]
    baseline: Vec<Baseline>,
    #[command(flatten, next_help_heading = heading::REPORT)]
    metrics: MetricsOption,
    /// Number of timed runs of fast stages; the median is reported
    #[arg(long, value_name = "N", default_value_t = 5, help_heading = heading::REPORT)]
    #[arg(value_parser = whole_number::<u32>(1..=1000), allow_negative_numbers = true)]
    repeats: u32,
    #[command(flatten)]
    memory: MemoryOption,
}

/// A method before ours.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Baseline {
    Grid,
    Affine,
}

choices!(Baseline {
    Grid => "grid", "Sampling as in the published reference: aligned corners, truncated values";
    Affine => "affine", "Affine warp per triangle with integer corners, then a median filter";
});

/// Longest side of a texture in either layout.
const MAX_SIDE: u32 = 16_384;

impl Args {
    /// Memory that the round trip takes at most, in bytes: measured at 4096² there and back, with a margin of a
    /// quarter.
    fn needed(&self, header: &Header, judge: &Judge) -> u64 {
        let texels = header.size.texels() as u64;
        let channels = header.channels.without_alpha().count();
        let texel = (channels * header.depth.bytes()) as u64;
        let there_and_back = texels + self.via.texels() as u64;
        let (reading, colors) = memory::of_colors(&(&self.texture).into(), header);
        // The original, its result, and bases of runs that are measured.
        let textures = 5 * texels * texel + 3 * self.via.texels() as u64 * texel;
        // Of the solver, and of pictures and their filters.
        let fit = if self.fit { there_and_back * 8 * (channels as u64 + 1) } else { 0 };
        let baseline = if self.baseline.is_empty() { 0 } else { there_and_back * 8 };
        let measuring = judge.scratch_bytes(header.size, memory::is_of_levels(header));
        textures + 2 * colors + reading.max(fit).max(baseline).max(measuring)
    }

    /// The names of the texture's layout and of the other.
    fn layouts<'a>(&self, file: &'a PairFile) -> [&'a String; 2] {
        match self.from {
            Side::Source => [&file.source_name, &file.target_name],
            Side::Target => [&file.target_name, &file.source_name],
        }
    }

    /// The opaque texture, and what judges the results.
    fn read_texture(&self) -> anyhow::Result<(Texture, Judge)> {
        let opened = image::open(&self.texture).or_bad_input()?;
        check_sides(opened.header().size, self.via)?;
        let judge = self.metrics.judge()?;
        self.memory.check("the round trip", self.needed(&opened.header(), &judge))?;
        let texture = opened.decode().or_bad_input()?.texture;
        // The baselines ignore opacity, and metrics compare colours only.
        warn_unless_opaque(&texture, &self.texture);
        Ok((over_black(texture), judge))
    }

    /// The requested methods without duplicates, our own first.
    fn methods(&self) -> Vec<Method> {
        let sampled = self.filter.iter().copied().map(Method::Sampled);
        let fitted = self.filter.iter().copied().filter(|_| self.fit).map(Method::Fitted);
        let baselines = self.baseline.iter().map(|baseline| match baseline {
            Baseline::Grid => Method::Grid,
            Baseline::Affine => Method::Affine,
        });
        let mut methods = Vec::new();
        for method in sampled.chain(fitted).chain(baselines) {
            if !methods.contains(&method) {
                methods.push(method);
            }
        }
        methods
    }
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    if args.fit && args.filter.contains(&Filter::Nearest) {
        return Err(bad_input(
            "--fit cannot be used with --filter nearest, which does not blend texels",
        ));
    }
    let methods = args.methods();
    let folder =
        args.output.as_deref().map(|path| Folder::new(path, args, &methods)).transpose()?;
    let file = pair_file::read(&args.pair).or_bad_input()?;
    let (texture, judge) = args.read_texture()?;
    let course = RoundTripInput {
        pair: &file.pair,
        there: match args.from {
            Side::Source => Direction::Forward,
            Side::Target => Direction::Reverse,
        },
        texture: &texture,
        via: args.via,
        gutter_px: args.gutter,
        repeats: args.repeats,
    };
    let mask = Mask::from_map(&course.map_back()).map_err(|_| {
        bad_input(format!("{}: no link covers a texel at {}", args.pair.display(), texture.size()))
    })?;
    let linked = mask.count();
    let regions = [
        ScoredRegion { name: "whole image".to_owned(), mask: None },
        ScoredRegion { name: "transferred region".to_owned(), mask: Some(mask) },
    ];
    let original = Colors::new(texture.clone())
        .with_context(|| args.texture.display().to_string())
        .or_bad_input()?;
    if let Some(folder) = &folder {
        folder.make()?;
    }

    let outcomes = compare(methods, &course, (&original, &regions, &judge), folder.as_ref())?;
    let report = Report {
        texture: terminal::file_name(&args.texture),
        pair: terminal::file_name(&args.pair),
        layouts: args.layouts(&file).map(Clone::clone),
        size: texture.size(),
        via: args.via,
        linked,
        threads: rayon::current_num_threads(),
        outcomes,
    };
    let (markdown, json) = (report.markdown(), terminal::json(&report)?);
    if let Some(folder) = &folder {
        folder.save("report.md", &markdown)?;
        folder.save("report.json", &json)?;
    }
    if let Some(path) = &args.output {
        outcome::wrote(path);
    }
    outcome::report(|| &report, || markdown)?;
    Ok(ExitCode::SUCCESS)
}

fn check_sides(texture: Size, via: Size) -> anyhow::Result<()> {
    for (what, size) in [("the texture", texture), ("--via", via)] {
        if size.width.max(size.height) > MAX_SIDE {
            return Err(bad_input(format!(
                "{what} must be at most {MAX_SIDE} texels a side, got {size}"
            )));
        }
    }
    Ok(())
}

/// Runs the round trip by each method, compares the results with the original, and writes their
/// pictures to a folder, if there is one.
fn compare(
    methods: Vec<Method>,
    course: &RoundTripInput<'_>,
    (original, regions, judge): (&Colors, &[ScoredRegion; 2], &Judge),
    folder: Option<&Folder<'_>>,
) -> anyhow::Result<Vec<Outcome>> {
    let progress = progress::bar(methods.len() as u64, "{bar:24} {pos}/{len} {wide_msg}");
    let mut outcomes = Vec::new();
    let mut top = None;
    for method in methods {
        progress.set_message(format!("{}: round trip", method.title()));
        let trip = method.run(course)?;
        progress.set_message(format!("{}: comparing", method.title()));
        let back = Colors::new(trip.back.clone())?;
        let scores = Scores::new(original, &back, regions, judge);
        if let Some(folder) = folder {
            // All heatmaps share the scale of the first one, so that they can be compared.
            let errors = heatmap::Errors::new(original, &back, &regions[1..]);
            let top = *top.get_or_insert_with(|| errors.top());
            folder.write(method, &trip, &errors, top)?;
        }
        outcomes.push(Outcome::new(method, &trip, scores));
        progress.inc(1);
    }
    progress.finish_and_clear();
    Ok(outcomes)
}

/// The output folder; checked before any work starts.
struct Folder<'a> {
    path: &'a Path,
}

impl<'a> Folder<'a> {
    fn new(path: &'a Path, args: &Args, methods: &[Method]) -> anyhow::Result<Self> {
        let folder = Self { path };
        if !path.exists() {
            // Its parent must be writable.
            Outputs::new([]).check(path)?;
            return Ok(folder);
        }
        if !path.is_dir() {
            return Err(bad_input(format!("cannot write {}: not a folder", path.display())));
        }
        let mut outputs = Outputs::new([&*args.pair, &*args.texture]);
        let pictures = methods
            .iter()
            .flat_map(|method| PICTURES.map(|(name, kind)| folder.picture(*method, name, kind)));
        let reports = ["report.md", "report.json"].map(|name| path.join(name));
        pictures.chain(reports).try_for_each(|path| outputs.check(&path))?;
        Ok(folder)
    }

    fn make(&self) -> anyhow::Result<()> {
        if self.path.is_dir() {
            return Ok(());
        }
        std::fs::create_dir(self.path)
            .with_context(|| format!("cannot create the folder {}", self.path.display()))
            .or_bad_input()
    }

    fn picture(&self, method: Method, picture: &str, extension: &str) -> PathBuf {
        self.path.join(format!("{}-{picture}.{extension}", method.slug()))
    }

    fn write(
        &self,
        method: Method,
        trip: &RoundTrip,
        errors: &heatmap::Errors,
        top: f32,
    ) -> anyhow::Result<()> {
        for (texture, picture) in [(&trip.via, "via"), (&trip.back, "back")] {
            // PNG does not support floats.
            let extension = if texture.depth() == Depth::F32 { "exr" } else { "png" };
            self.write_texture(texture, &self.picture(method, picture, extension))?;
        }
        let title = format!("There and back: {}", method.title());
        Ok(errors.draw(&title, top).write(&self.picture(method, "heatmap", "png"))?)
    }

    fn write_texture(&self, texture: &Texture, path: &Path) -> anyhow::Result<()> {
        let image = Image::from(texture.clone());
        let written = image::write(&image, path, &WriteOptions::default())?;
        for loss in written.losses {
            warn(format!("{}: {loss}", path.display()));
        }
        Ok(())
    }

    fn save(&self, name: &str, text: &str) -> anyhow::Result<()> {
        let path = self.path.join(name);
        output::write_atomically(&path, |out| std::io::Write::write_all(out, text.as_bytes()))
            .or_cannot_write(&path)
    }
}

/// The files that may be written for each method: names and extensions.
const PICTURES: [(&str, &str); 5] =
    [("via", "png"), ("via", "exr"), ("back", "png"), ("back", "exr"), ("heatmap", "png")];
