//! `uvgraft map`: the sampling map in the formats of other tools.

mod format;

use std::path::PathBuf;
use std::process::ExitCode;

use uvgraft::{
    Choice, Direction, Filter, Graft, MapOptions, Prefer, SamplingMap, Size, Sizes, choices,
};
use uvgraft_io::pair_file;
use uvgraft_io::sampling_map::{self, Convention, CsrError};
use uvgraft_pipeline::Outputs;

use self::format::MapFormat;
use crate::choice::choice;
use crate::failure::{OrBadInput, bad_input};
use crate::files::OrCannotWrite;
use crate::number::whole_number;
use crate::outcome;
use crate::report::parse_size;

/// Export the sampling map of a pair for other tools
///
/// The extension decides what is written:
///
///   .npy      float32 (height, width, 2): for the centre of each texel of the output layout the
///             coordinates u and v in the input layout, with the origin at the top left; NaN where
///             nothing is covered.
///   .npz      the file of the reference implementation (Song et al., arXiv 2508.19518): uv_grid,
///             float32 (1, height, width, 2), and pix_to_face, int64 (height, width), -1 where
///             nothing is covered. See --convention.
///   .exr      ST map, 32-bit float: R and G are u and v with the origin at the bottom left, B and A
///             are 1 where covered. For Nuke's STMap, Blender's Map UV and Fusion's Texture.
///   .csr.npz  the whole transfer as a sparse matrix H for scipy.sparse.load_npz: H @ texels, with
///             a row for each texel of the output and a column for each texel of the input. It
///             includes the filter, averaging where textures are minified, and padding. Needs
///             --source-size.
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
/// Except for the matrix, tools take one sample per texel. `uvgraft transfer` also averages where a
/// texture shrinks, and keeps texels outside the UV islands from bleeding into the result.
///
/// `uvgraft transfer --with-map` reads .npy, .npz and .exr.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Args {
    /// Pair file that links the two meshes
    pair: PathBuf,
    /// File to write: .npy, .npz, .exr or .csr.npz
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Format of the file [default: by its extension]
    #[arg(long, value_parser = choice::<MapFormat>())]
    format: Option<MapFormat>,
    /// Size of the output texture in texels
    #[arg(long, value_name = "N|WxH", value_parser = parse_size, allow_negative_numbers = true)]
    size: Size,
    /// Size of the input texture in texels, for .csr.npz and --convention exact
    #[arg(long, value_name = "N|WxH", value_parser = parse_size, allow_negative_numbers = true)]
    source_size: Option<Size>,
    /// Sampling convention of .npz files [default: reference]
    ///
    /// Both are for grid_sample with align_corners=True, as the reference implementation calls it.
    #[arg(long, value_parser = choice::<ConventionKind>())]
    convention: Option<ConventionKind>,
    /// Interpolation filter of .csr.npz files [default: lanczos3]
    #[arg(long, value_parser = choice::<Filter>())]
    filter: Option<Filter>,
    /// Map from the target layout to the source layout
    #[arg(long)]
    reverse: bool,
    /// Width of the gutter around UV islands, in texels
    #[arg(long, value_name = "TEXELS", default_value_t = MapOptions::default().gutter_px)]
    #[arg(value_parser = whole_number::<u32>(0..=256), allow_negative_numbers = true)]
    gutter: u32,
    /// UV island that owns texels shared by several islands
    #[arg(long, value_name = "ISLAND", default_value = Prefer::First.name(), value_parser = choice::<Prefer>())]
    prefer: Prefer,
}

/// Which [`Convention`].
#[derive(Clone, Copy, PartialEq, Eq)]
enum ConventionKind {
    Reference,
    Exact,
}

choices!(ConventionKind {
    Reference => "reference", "2u - 1, as in the reference implementation: up to half a texel off";
    Exact => "exact", "2 (u W - 1/2) / (W - 1) - 1, exact for inputs of --source-size";
});

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let content = args.content()?;
    Outputs::new([&*args.pair]).check(&args.output)?;
    let pair = pair_file::read(&args.pair).or_bad_input()?.pair;
    let direction = if args.reverse { Direction::Reverse } else { Direction::Forward };
    let options = MapOptions::with_gutter(args.gutter).prefer(args.prefer);
    let path = &*args.output;
    let map = || SamplingMap::new(&pair, direction, args.size, &options);
    match content {
        Content::Positions => sampling_map::save_npy(&map(), path).or_cannot_write(path)?,
        Content::Grid(convention) => {
            sampling_map::save_npz(&map(), convention, path).or_cannot_write(path)?;
        }
        Content::StMap => sampling_map::save_st_map(&map(), path).or_cannot_write(path)?,
        Content::Matrix(from) => {
            let sizes = Sizes { from, to: args.size };
            let graft = Graft::builder(pair, sizes).direction(direction).map_options(options);
            let filter = args.filter.unwrap_or_default();
            let operator = graft.filter(filter).build().or_bad_input()?.operator();
            match sampling_map::save_csr(&operator, path) {
                Err(error @ CsrError::TooMany) => {
                    return Err(error).or_bad_input().or_cannot_write(path);
                }
                result => result.map(drop).or_cannot_write(path)?,
            }
        }
    }
    outcome::wrote(path);
    Ok(ExitCode::SUCCESS)
}

/// What is written.
enum Content {
    Positions,
    Grid(Convention),
    StMap,
    /// For sources of this size.
    Matrix(Size),
}

impl Args {
    /// What is written, once all options are known to apply to it.
    fn content(&self) -> anyhow::Result<Content> {
        let format = match self.format {
            Some(format) => format,
            None => MapFormat::of_path(&self.output)?,
        };
        if self.convention.is_some() && format != MapFormat::Npz {
            return Err(bad_input("--convention is for the format npz only"));
        }
        if self.filter.is_some() && format != MapFormat::Csr {
            return Err(bad_input(
                "--filter is for the format csr only: other tools filter positions themselves",
            ));
        }
        let required =
            || bad_input("--source-size is required for the format csr and for --convention exact");
        let is_exact = self.convention == Some(ConventionKind::Exact);
        match (format, self.source_size) {
            (MapFormat::Csr, size) => Ok(Content::Matrix(size.ok_or_else(required)?)),
            (MapFormat::Npz, size) if is_exact => {
                Ok(Content::Grid(Convention::Exact(size.ok_or_else(required)?)))
            }
            (_, Some(_)) => Err(bad_input(
                "--source-size is for the format csr and for --convention exact only: other \
                 positions hold for inputs of any size",
            )),
            (MapFormat::Npy, None) => Ok(Content::Positions),
            (MapFormat::Npz, None) => Ok(Content::Grid(Convention::Reference)),
            (MapFormat::Exr, None) => Ok(Content::StMap),
        }
    }
}
