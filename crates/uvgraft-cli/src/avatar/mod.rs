//! `uvgraft avatar`: a head's texture on a full body that moves.

mod body;
mod dress;
mod face;
mod meta;
mod summary;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use uvgraft::{MapOptions, Size};
use uvgraft_io::pair_file;

use crate::blending::BlendArgs;
use crate::failure::{OrBadInput, bad_input};
use crate::filters::FilterName;
use crate::onto::Onto;
use crate::outputs::Outputs;
use crate::preference::PreferName;
use crate::region::RegionArgs;
use crate::report::{parse_size, to_stdout};
use face::Face;
use meta::MetaArgs;

/// Makes an animated full-body avatar from a head's texture: a GLB or VRM file.
///
/// The face is carried onto the body's texture as `transfer` does, with a membrane to hide the border
/// unless --blend says otherwise, and the body gets its skeleton, expressions and animations.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// The pair file, from the head's layout to the body's
    pair: PathBuf,
    /// The face: an image in the head's layout, a FATE texture dump (.pth), or a FATE workspace, a
    /// folder with baking*/dump_texture/ or visualize_texture/
    face: PathBuf,
    /// The body's texture: an image in the body's layout, or a colour such as #c08a70
    #[arg(long, value_name = "IMAGE|COLOUR")]
    onto: String,
    /// The body: a model of the SMPL family (SMPL, SMPL-H, SMPL-X or FLAME, .npz or .pkl), or `demo` for the
    /// figure that `uvgraft demo` makes
    #[arg(long, value_name = "MODEL|demo")]
    body: PathBuf,
    /// The body's shape: numbers such as 0.5,-1.2, or a file (.npz, .npy, .pkl) with an array `betas`
    #[arg(long, value_name = "NUMBERS|FILE", allow_hyphen_values = true)]
    betas: Option<String>,
    /// Animations: AMASS files (.npz); several become several clips
    #[arg(long, value_name = "AMASS.npz")]
    motion: Vec<PathBuf>,
    /// Frames a second of animations; 0 keeps all of the file's
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u16).range(0..=240))]
    fps: u16,
    /// Make it fit a platform's limits: size of the texture, triangles
    #[arg(long, value_enum)]
    preset: Option<PresetName>,
    /// The most triangles [default: the preset's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(100..))]
    triangles: Option<u32>,
    /// Size of the body's texture [default: the image's, or as much of it as the preset takes]
    #[arg(long, value_name = "N|WxH", value_parser = parse_size)]
    size: Option<Size>,
    /// How the texture is stored [default: the preset's, or png]
    #[arg(long, value_enum, value_name = "FORMAT")]
    texture: Option<TextureName>,
    /// Quality of JPEG textures, 1 to 100
    #[arg(long, default_value_t = 92, value_parser = clap::value_parser!(u8).range(1..=100))]
    quality: u8,
    /// Where to write the avatar: .glb, or .vrm (VRM 1.0)
    #[arg(short, long, value_name = "OUT.glb|OUT.vrm")]
    output: PathBuf,
    /// How values between texels are made [default: lanczos3]
    #[arg(long, value_enum)]
    filter: Option<FilterName>,
    /// Texels beyond the UV islands that are filled
    #[arg(long, value_name = "TEXELS", default_value_t = MapOptions::default().gutter_px)]
    #[arg(value_parser = clap::value_parser!(u32).range(0..=256))]
    gutter: u32,
    /// Which UV island is shown where several share texels, such as two eyes on one disc
    #[arg(long, value_enum, default_value_t = PreferName::First)]
    prefer: PreferName,
    #[command(flatten)]
    meta: MetaArgs,
    #[command(flatten)]
    region: RegionArgs,
    #[command(flatten)]
    blending: BlendArgs,
}
