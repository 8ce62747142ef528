//! `uvgraft map`: the sampling map as an array for other tools.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use uvgraft::{Direction, MapOptions, SamplingMap, Size};
use uvgraft_io::{pair_file, sampling_map};
use uvgraft_pipeline::Outputs;

use crate::failure::{OrBadInput, bad_input};
use crate::number::whole_number;
use crate::preference::PreferName;
use crate::report::parse_size;

/// Export the sampling map of a pair as an array for other tools
///
/// The map is an NPY array of float32 with the shape (height, width, 2). For the centre of each
/// texel of the output layout it holds the coordinates u and v in the input layout, with the origin
/// at the top left. Texels that are not covered are NaN.
///
/// With OpenCV, which counts positions from the centre of the first texel:
///
///   grid = np.load("grid.npy")
///   height, width = source.shape[:2]
///   x = np.nan_to_num(grid[..., 0] * width - 0.5, nan=-100)
///   y = np.nan_to_num(grid[..., 1] * height - 0.5, nan=-100)
///   cv2.remap(source, x, y, cv2.INTER_LINEAR, dst=base, borderMode=cv2.BORDER_TRANSPARENT)
///
/// With PyTorch, pass np.nan_to_num(2 * grid - 1, nan=-2) to grid_sample with align_corners=False.
///
/// Both take one sample per texel. `uvgraft transfer` also averages where a texture shrinks, and
/// keeps texels outside the UV islands from bleeding into the result.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Args {
    /// Pair file that links the two meshes
    pair: PathBuf,
    /// Array to write
    #[arg(short, long, value_name = "OUT.npy")]
    output: PathBuf,
    /// Size of the output texture in texels
    #[arg(long, value_name = "N|WxH", value_parser = parse_size, allow_negative_numbers = true)]
    size: Size,
    /// Map from the target layout to the source layout
    #[arg(long)]
    reverse: bool,
    /// Width of the gutter around UV islands, in texels
    #[arg(long, value_name = "TEXELS", default_value_t = MapOptions::default().gutter_px)]
    #[arg(value_parser = whole_number::<u32>(0..=256), allow_negative_numbers = true)]
    gutter: u32,
    /// UV island that owns texels shared by several islands
    #[arg(long, value_enum, value_name = "ISLAND", default_value_t = PreferName::First)]
    prefer: PreferName,
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    check_name(&args.output)?;
    Outputs::new([&*args.pair]).check(&args.output)?;
    let pair = pair_file::read(&args.pair).or_bad_input()?.pair;
    let direction = if args.reverse { Direction::Reverse } else { Direction::Forward };
    let options = MapOptions::with_gutter(args.gutter).prefer(args.prefer.into());
    let map = SamplingMap::new(&pair, direction, args.size, &options);
    sampling_map::save_npy(&map, &args.output)
        .with_context(|| format!("cannot write {}", args.output.display()))?;
    Ok(ExitCode::SUCCESS)
}

fn check_name(path: &Path) -> anyhow::Result<()> {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("npy")) {
        return Ok(());
    }
    Err(bad_input(format!("cannot write {}: extension must be .npy", path.display())))
}
