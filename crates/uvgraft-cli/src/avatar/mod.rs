//! `uvgraft avatar`: a head's texture on a full body that moves.

mod body;
mod carried;
mod dress;
mod expressions;
mod face;
mod features;
mod layout;
mod lods;
mod maps;
mod materials;
mod meta;
mod motions;
mod plan;
mod summary;
mod thumbnail;

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use anyhow::Context;
use uvgraft::{MapOptions, Size};
use uvgraft_gltf::glb::{self, Export, PictureFormat, VrmError};
use uvgraft_gltf::preset::{self, Fitted, Preset};
use uvgraft_io::{output, pair_file};

use crate::blending::BlendArgs;
use crate::failure::{OrBadInput, bad_input};
use crate::filters::FilterName;
use crate::preference::PreferName;
use crate::region::RegionArgs;
use crate::report::{parse_size, to_stdout};
use body::Body;
use dress::Dressed;
use face::Face;
use features::FeatureArgs;
use layout::LayoutArgs;
use lods::LodArgs;
use maps::Encoder;
use materials::MaterialArgs;
use meta::MetaArgs;
use motions::PlayArgs;
use plan::Plan;

/// The quality of JPEGs: a texture is looked at closely, and base colours have no blur to hide blocks.
const JPEG_QUALITY: u8 = 92;

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
    /// The body's texture: an image in the body's layout, or a colour such as #c08a70. Further maps of the body's
    /// are named by what they are, as ROLE=IMAGE: see --map
    #[arg(long, required = true, value_name = "[ROLE=]IMAGE|COLOUR")]
    onto: Vec<String>,
    /// The body: a model of the SMPL family (SMPL, SMPL-H, SMPL-X or FLAME, .npz or .pkl), or `demo` for the
    /// figure that `uvgraft demo` makes
    #[arg(long, value_name = "MODEL|demo")]
    body: PathBuf,
    /// The body's shape: numbers such as 0.5,-1.2, or a file (.npz, .pkl) with an array `betas`
    #[arg(long, value_name = "NUMBERS|FILE", allow_hyphen_values = true)]
    betas: Option<String>,
    /// Animations: AMASS files (.npz); several become several clips, in place of the demo figure's own
    #[arg(long, value_name = "AMASS.npz")]
    motion: Vec<PathBuf>,
    /// Make it fit a platform's limits: size of the texture, triangles. visionos is for AR Quick Look, which opens USDZ
    /// only: the file still has to be converted
    #[arg(long, value_parser = Preset::ALL.map(|preset| preset.name))]
    preset: Option<String>,
    /// The most triangles; what nobody sees goes first [default: the preset's, or all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1000..))]
    triangles: Option<u32>,
    /// Size of the body's texture [default: the image's, or as much of it as the preset takes]
    #[arg(long, value_name = "N|WxH", value_parser = parse_size)]
    size: Option<Size>,
    /// How the texture is stored [default: the preset's, or png]
    #[arg(long, value_enum, value_name = "FORMAT")]
    texture: Option<TextureName>,
    /// Quality of JPEG textures, 1 to 100 [default: 92]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=100))]
    quality: Option<u8>,
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
    /// Say what of the body model's file is not used
    #[arg(short, long)]
    verbose: bool,
    #[command(flatten)]
    playing: PlayArgs,
    #[command(flatten)]
    layout: LayoutArgs,
    #[command(flatten)]
    materials: MaterialArgs,
    #[command(flatten)]
    lods: LodArgs,
    #[command(flatten)]
    features: FeatureArgs,
    #[command(flatten)]
    meta: MetaArgs,
    #[command(flatten)]
    region: RegionArgs,
    #[command(flatten)]
    blending: BlendArgs,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum TextureName {
    /// Lossless, read by everything
    Png,
    /// Lossy and small, read by everything
    Jpeg,
    /// Lossless and smaller than PNG, read by browsers and Blender
    Webp,
    /// Compressed for graphics processors, which keep it so; in builds with the feature `ktx2`
    Ktx2,
}

impl From<TextureName> for PictureFormat {
    fn from(name: TextureName) -> Self {
        match name {
            TextureName::Png => Self::Png,
            TextureName::Jpeg => Self::Jpeg,
            TextureName::Webp => Self::WebP,
            TextureName::Ktx2 => Self::Ktx2,
        }
    }
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let plan = Plan::new(args)?;
    let mut file = pair_file::read(&args.pair).or_bad_input()?;
    let given = Arc::clone(&file.pair);
    let parted = features::parted(&given)?;
    if let Some((pair, _)) = &parted {
        file.pair = Arc::clone(pair);
    }
    let limits = plan.preset.as_ref();
    let (body, dressed) = rayon::join(
        || {
            let mut body = Body::new(args, given.target())?;
            if let Some((_, parted)) = &parted {
                body.avatar = features::with_layout(body.avatar, &parted.mesh)?;
            }
            let mouth = args.features.fit_mouth(&body.avatar);
            anyhow::Ok((body, mouth))
        },
        || {
            let (face, base) =
                rayon::join(|| Face::read(&args.face), || dress::base(args, &plan.onto, limits));
            let mut base = base?;
            if let Some((_, parted)) = &parted {
                parted.copy(&mut base);
            }
            dress::dress(args, &file, face?, base, limits)
        },
    );
    let ((body, mouth), dressed) = (body?, dressed?);
    let Body { avatar, name, apart, grounds, told } = body;
    let missing = avatar.skeleton.missing_bones();
    if plan.vrm.is_some() && !missing.is_empty() {
        // Before anything is said of a face that no file will have.
        let (output, why) = (args.output.display(), VrmError::MissingBones { bones: missing });
        return Err(bad_input(format!("{name} as {output}: {why}")));
    }
    if let Some((kind, told)) = &told {
        expressions::tell(&args.body, *kind, told);
    }
    let Dressed { body: mut color, head, carrier } = dressed;
    args.features.draw_eyes(&avatar, &mut color, &name);
    let (mut avatar, mouth) = match mouth {
        Some(mouth) => features::with_mouth(avatar, mouth, &mut color, &name)?,
        None => (avatar, None),
    };
    if let Some(layout) = &carrier.head {
        layout.apply(&mut avatar)?;
    }
    let maps = plan.materials.carry(&carrier, color.size())?;
    let (mut fitted, mut normals) = (None, None);
    if let Some(triangles) = plan.triangles {
        let fit = preset::fit(avatar, triangles).or_bad_input()?;
        let Fitted { before, hidden, after, wanted, .. } = fit;
        fitted = Some((before, hidden, after, wanted));
        // Fewer triangles may have lost the lowest vertex.
        (avatar, normals) = (fit.avatar.standing()?, fit.normals);
    }
    let levels = args.lods.levels(&avatar, normals.as_deref())?;
    let is_vrm = plan.vrm.is_some();
    let shown =
        is_vrm.then(|| thumbnail::Colors::new([Some(&color), head.as_ref()].into_iter().flatten()));
    // Textures have the preset's size already.
    let quality = args.quality.unwrap_or(JPEG_QUALITY);
    let encoder = Encoder { format: plan.format, quality, style: plan.materials.style };
    let looks = maps.looks((color, head), &encoder).or_bad_input()?;
    let export = Export {
        name: args.meta.title(&args.output),
        copyright: args.meta.copyright(),
        extras: if is_vrm { Default::default() } else { args.meta.extras() },
        thumbnail: shown.and_then(|shown| shown.thumbnail(&avatar, &looks)),
        normals,
        vrm: plan.vrm,
        levels: levels.inside(),
    };
    let refused = |error: &dyn std::fmt::Display| {
        bad_input(format!("{name} as {}: {error}", args.output.display()))
    };
    let exported = glb::write(&avatar, &looks, &export).map_err(|error| refused(&error))?;
    let coarser = levels.files(&looks, &export).map_err(|error| refused(&error))?;
    write(&args.output, &exported.bytes)?;
    let mut level_files = Vec::with_capacity(coarser.len());
    for (path, file) in plan.level_files.into_iter().zip(coarser) {
        write(&path, &file.bytes)?;
        level_files.push((path, file.bytes.len()));
    }
    let made = summary::Made {
        output: &args.output,
        is_vrm,
        body: &name,
        avatar: &avatar,
        looks: &looks,
        report: &exported.report,
        apart: &apart,
        grounds: &grounds,
        mouth,
        fitted,
        levels: levels.rows(&level_files),
        limits: plan.preset.as_ref().map(|preset| preset.limits),
    };
    to_stdout(&made.text())?;
    Ok(ExitCode::SUCCESS)
}

fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    output::write_atomically::<io::Error>(path, |out| out.write_all(bytes))
        .with_context(|| format!("cannot write {}", path.display()))?;
    Ok(())
}
