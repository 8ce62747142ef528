//! `uvgraft map`: where each texel comes from, as an array for other tools.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use uvgraft::{Direction, MapOptions, SamplingMap, Size};
use uvgraft_io::{pair_file, sampling_map};
use uvgraft_pipeline::Outputs;

use crate::failure::{OrBadInput, bad_input};
use crate::preference::PreferName;
use crate::report::parse_size;

/// Writes where each texel of a texture comes from, as an array for other tools
///
/// The array is an NPY file of float32 with the shape (height, width, 2): u and v in the layout that
/// is read, from its top left corner, for the centre of each texel of the layout that is written.
/// Both are NaN where nothing is carried.
///
/// For OpenCV, positions count from the centre of the first texel:
///
///   grid = np.load("grid.npy")
///   height, width = source.shape[:2]
///   x = np.nan_to_num(grid[..., 0] * width - 0.5, nan=-100)
///   y = np.nan_to_num(grid[..., 1] * height - 0.5, nan=-100)
///   cv2.remap(source, x, y, cv2.INTER_LINEAR, dst=base, borderMode=cv2.BORDER_TRANSPARENT)
///
/// For PyTorch, np.nan_to_num(2 * grid - 1, nan=-2) is what grid_sample takes with align_corners=False.
///
/// Both read one sample for each texel; `uvgraft transfer` averages where a texture shrinks, and
/// keeps what lies beside UV islands out of the result.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Args {
    /// The pair file
    pair: PathBuf,
    /// Size of the texture that is written
    #[arg(long, value_name = "N|WxH", value_parser = parse_size)]
    size: Size,
    /// Map from the pair's target to its source
    #[arg(long)]
    reverse: bool,
    /// Texels beyond the UV islands that are carried too
    #[arg(long, value_name = "TEXELS", default_value_t = MapOptions::default().gutter_px)]
    #[arg(value_parser = clap::value_parser!(u32).range(0..=256))]
    gutter: u32,
    /// Which UV island is shown where several share texels, such as two eyes on one disc
    #[arg(long, value_enum, default_value_t = PreferName::First)]
    prefer: PreferName,
    /// Where to write the array
    #[arg(short, long, value_name = "grid.npy")]
    output: PathBuf,
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
    Err(bad_input(format!("cannot write {}: wanted a name that ends in .npy", path.display())))
}
