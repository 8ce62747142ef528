//! `uvgraft compare`: metrics of two textures.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use serde::Serialize;
use uvgraft::{Encoding, Size};
use uvgraft_files::input::Input;
use uvgraft_image::{self as image, Header};
use uvgraft_metrics::{Colors, Mask};
use uvgraft_pipeline::{Outputs, decoded_bytes};

use crate::failure::{OrBadInput, bad_input, note};
use crate::heatmap;
use crate::memory::{self, MemoryOption};
use crate::opacity::warn_unless_opaque;
use crate::scores::{Judge, MetricsOption, ScoredRegion, Scores};
use crate::{outcome, terminal};
use uvgraft_assembly::drawing::check_name;

/// Compare two textures of the same size
///
/// Colours are compared as displayed: in sRGB, composited over black where they are transparent.
/// Greyscale counts as three equal channels. Colour profiles are ignored.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Reference texture
    #[arg(value_name = "REFERENCE")]
    a: PathBuf,
    /// Texture to compare with it
    #[arg(value_name = "TEXTURE")]
    b: PathBuf,
    /// Compare only where this image is white; repeatable
    ///
    /// Texels count where the first channel is at least one half. Each mask adds a column to the
    /// table; with masks, the column of the whole image is omitted.
    #[arg(long, value_name = "IMAGE")]
    mask: Vec<PathBuf>,
    #[command(flatten)]
    metrics: MetricsOption,
    /// Draw a heatmap of the differences
    #[arg(long, value_name = "OUT.png")]
    heatmap: Option<PathBuf>,
    #[command(flatten)]
    memory: MemoryOption,
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let inputs = [&args.a, &args.b].into_iter().chain(&args.mask).map(|path| &**path);
    if let Some(heatmap) = &args.heatmap {
        check_name(heatmap, "a heatmap")?;
        Outputs::new(inputs.clone()).check(heatmap)?;
    }
    let headers = same_sizes(inputs)?;
    let judge = args.metrics.judge()?;
    args.memory.check("the comparison", needed(&headers, &judge))?;
    let [a, b] = [read_colors(&args.a)?, read_colors(&args.b)?];
    let regions = match args.mask.as_slice() {
        [] => vec![ScoredRegion { name: "whole image".to_owned(), mask: None }],
        masks => read_masks(masks)?,
    };
    for (path, region) in args.mask.iter().zip(&regions) {
        if region.mask.as_ref().is_some_and(|mask| mask.count() == mask.size().texels()) {
            note(format_args!("{}: `mask` has no effect: white everywhere", path.display()));
        }
    }
    let scores = Scores::new(&a, &b, &regions, &judge);
    if let Some(path) = &args.heatmap {
        let title =
            format!("{} against {}", terminal::file_name(&args.a), terminal::file_name(&args.b));
        heatmap::write(&a, &b, &regions, &title, path)?;
        outcome::wrote(path);
    }
    print(args, a.size(), &scores)
}

/// Reads headers, and rejects images of different sizes.
fn same_sizes<'a>(
    paths: impl IntoIterator<Item = &'a Path>,
) -> anyhow::Result<Vec<(Input, Header)>> {
    let mut first: Option<(&Path, Size)> = None;
    let mut headers = Vec::new();
    for path in paths {
        let header = image::read_header(path).or_bad_input()?;
        let size = header.size;
        headers.push((path.into(), header));
        let (of, wanted) = *first.get_or_insert((path, size));
        if size != wanted {
            return Err(bad_input(format!(
                "{}: must be {wanted} like {}, got {size}",
                path.display(),
                of.display()
            )));
        }
    }
    Ok(headers)
}

/// Memory that comparing takes at most, in bytes.
///
/// - `headers`: of both textures, and of the masks.
fn needed(headers: &[(Input, Header)], judge: &Judge) -> u64 {
    let (textures, masks) = headers.split_at(2);
    let size = headers[0].1.size;
    let of_levels = textures.iter().all(|(_, header)| memory::is_of_levels(header));
    let textures = textures.iter().map(|(input, header)| memory::of_colors(input, header));
    let (reading, kept): (Vec<u64>, Vec<u64>) = textures.unzip();
    let of_masks = masks.iter().map(|(input, header)| decoded_bytes(Some(input), header));
    let passing = reading.into_iter().chain(of_masks).chain([judge.scratch_bytes(size, of_levels)]);
    kept.iter().sum::<u64>() + (masks.len() * size.texels()) as u64 + passing.max().unwrap_or(0)
}

fn read_colors(path: &Path) -> anyhow::Result<Colors> {
    let texture = image::read(path).or_bad_input()?.texture;
    warn_unless_opaque(&texture, path);
    Colors::new(texture).with_context(|| path.display().to_string()).or_bad_input()
}

/// A region for each mask, named after its file, or its path where file names coincide.
fn read_masks(paths: &[PathBuf]) -> anyhow::Result<Vec<ScoredRegion>> {
    let mut regions = Vec::new();
    for path in paths {
        let mut region = read_mask(path)?;
        let name = path.file_name();
        if paths.iter().filter(|other| other.file_name() == name).count() > 1 {
            region.name = path.display().to_string();
        }
        regions.push(region);
    }
    Ok(regions)
}

fn read_mask(path: &Path) -> anyhow::Result<ScoredRegion> {
    // A mask is data, so one half is one half regardless of the encoding that the format states.
    let read = image::read_with(path, Encoding::Data.into()).or_bad_input()?;
    let texture = read.texture.with_encoding(Encoding::Data);
    let mask =
        Mask::from_texture(&texture).with_context(|| path.display().to_string()).or_bad_input()?;
    Ok(ScoredRegion { name: terminal::file_name(path), mask: Some(mask) })
}

#[derive(Serialize)]
struct Document<'a> {
    a: String,
    b: String,
    size: Size,
    regions: &'a Scores,
}

fn print(args: &Args, size: Size, scores: &Scores) -> anyhow::Result<ExitCode> {
    let [a, b] = [&args.a, &args.b].map(|path| path.display().to_string());
    outcome::report(
        || Document { a, b, size, regions: scores },
        || {
            let [a, b] = [&args.a, &args.b].map(|path| terminal::path(path));
            format!("{a} and {b}, {size} texels\n\n{}", scores.table())
        },
    )?;
    Ok(ExitCode::SUCCESS)
}
