//! `uvgraft avatar`: a head's texture on a full body that moves.

mod body;
mod dress;
mod face;
mod features;
mod meta;
mod summary;

use std::ffi::OsStr;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use anyhow::Context;
use uvgraft::{MapOptions, Size};
use uvgraft_avatar::glb::{self, Export, Looks, Picture, PictureFormat};
use uvgraft_avatar::preset::{Fitted, Preset};
use uvgraft_io::{output, pair_file};
use uvgraft_pipeline::{Onto, Outputs};

use crate::blending::BlendArgs;
use crate::failure::{OrBadInput, bad_input};
use crate::filters::FilterName;
use crate::picture::check_name;
use crate::preference::PreferName;
use crate::region::RegionArgs;
use crate::report::{parse_size, to_stdout};
use body::Body;
use face::Face;
use features::FeatureArgs;
use meta::MetaArgs;

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
    /// The body's texture: an image in the body's layout, or a colour such as #c08a70
    #[arg(long, value_name = "IMAGE|COLOUR")]
    onto: String,
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
    /// Frames a second of animations; 0 keeps all of the file's
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u16).range(0..=240))]
    fps: u16,
    /// Make it fit a platform's limits: size of the texture, triangles
    #[arg(long, value_parser = Preset::ALL.map(|preset| preset.name))]
    preset: Option<String>,
    /// The most triangles [default: the preset's]
    #[arg(long, value_name = "N", requires = "preset", value_parser = clap::value_parser!(u32).range(1000..))]
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
    let is_vrm = is_vrm(&args.output)?;
    let vrm = is_vrm.then(|| args.meta.vrm(&args.output)).transpose()?;
    if !is_vrm {
        args.meta.check_glb()?;
    }
    let onto = Onto::parse(&args.onto)?;
    if cfg!(not(feature = "ktx2")) && args.texture == Some(TextureName::Ktx2) {
        return Err(bad_input(
            "--texture ktx2: this build lacks the feature `ktx2`; wanted png, jpeg or webp",
        ));
    }
    let preset = args.preset.as_deref().and_then(Preset::named);
    let own = preset.map(|preset| Preset {
        triangles: args.triangles.map_or(preset.triangles, |count| count as usize),
        format: args.texture.map_or(preset.format, PictureFormat::from),
        ..*preset
    });
    let preset_format = own.as_ref().map(|preset| preset.format);
    let format = preset_format.or(args.texture.map(PictureFormat::from));
    let format = format.unwrap_or(PictureFormat::Png);
    if args.quality.is_some() && format != PictureFormat::Jpeg {
        return Err(bad_input("--quality is for JPEG textures: add --texture jpeg"));
    }
    if let (Some(size), Some(preset)) = (args.size, &own)
        && size.width.max(size.height) > preset.texture_side
    {
        let (name, side) = (preset.name, preset.texture_side);
        return Err(bad_input(format!(
            "--size {size}: --preset {name} has textures of {side} at most; leave one of them out"
        )));
    }
    check_outputs(args, &onto)?;

    let mut file = pair_file::read(&args.pair).or_bad_input()?;
    let given = Arc::clone(&file.pair);
    let parted = features::parted(&given)?;
    if let Some((pair, _)) = &parted {
        file.pair = Arc::clone(pair);
    }
    let (body, textures) = rayon::join(
        || Body::new(args, given.target()),
        || {
            let (face, base) =
                rayon::join(|| Face::read(&args.face), || dress::base(args, &onto, own.as_ref()));
            let mut base = base?;
            if let Some((_, parted)) = &parted {
                parted.copy(&mut base);
            }
            dress::dress(args, &file, face?, base)
        },
    );
    let (body, mut texture) = (body?, textures?);
    let Body { mut avatar, name, apart } = body;
    if let Some((_, parted)) = &parted {
        avatar = features::with_layout(avatar, &parted.mesh)?;
    }
    args.features.draw_eyes(&avatar, &mut texture, &name);
    let (mut avatar, mouth) = args.features.with_mouth(avatar, &mut texture, &name)?;
    let (mut fitted, mut normals) = (None, None);
    if let Some(preset) = &own {
        let fit = preset.fit(avatar).or_bad_input()?;
        let Fitted { before, hidden, after, wanted, .. } = fit;
        fitted = Some((before, hidden, after, wanted));
        (avatar, normals) = (fit.avatar, fit.normals);
    }
    // The texture has the preset's size already.
    let quality = args.quality.unwrap_or(JPEG_QUALITY);
    let picture = Picture::encode(texture, format, quality).or_bad_input()?;
    let looks = Looks::new(picture);
    let export = Export {
        name: args.meta.title(&args.output),
        copyright: args.meta.copyright(),
        normals,
        vrm,
        ..Export::default()
    };
    let exported = glb::write(&avatar, &looks, &export)
        .map_err(|error| bad_input(format!("{name} as {}: {error}", args.output.display())))?;
    output::write_atomically::<io::Error>(&args.output, |out| out.write_all(&exported.bytes))
        .with_context(|| format!("cannot write {}", args.output.display()))?;
    let made = summary::Made {
        output: &args.output,
        is_vrm,
        body: &name,
        avatar: &avatar,
        looks: &looks,
        report: &exported.report,
        apart: &apart,
        mouth,
        fitted,
        limits: own.as_ref().map(|preset| preset.limits),
    };
    to_stdout(&made.text())?;
    Ok(ExitCode::SUCCESS)
}

/// Whether the output is to be a VRM file, by its name.
fn is_vrm(output: &Path) -> anyhow::Result<bool> {
    match output.extension().map(OsStr::to_ascii_lowercase) {
        Some(extension) if extension == "glb" => Ok(false),
        Some(extension) if extension == "vrm" => Ok(true),
        _ => {
            Err(bad_input(format!("{}: wanted a name that ends in .glb or .vrm", output.display())))
        }
    }
}

fn check_outputs(args: &Args, onto: &Onto) -> anyhow::Result<()> {
    let models = Some(&*args.body).filter(|body| *body != Path::new("demo"));
    let shape = args.betas.as_deref().map(Path::new);
    let inputs = [&*args.pair, &*args.face]
        .into_iter()
        .chain(onto.path())
        .chain(models)
        .chain(shape)
        .chain(args.motion.iter().map(PathBuf::as_path))
        .chain(args.blending.inputs())
        .chain(args.region.inputs());
    let mut outputs = Outputs::new(inputs);
    outputs.check(&args.output)?;
    if let Some(preview) = &args.blending.preview {
        check_name(preview, "a preview")?;
        outputs.check(preview)?;
    }
    if let Some(labels) = args.blending.drawn_labels() {
        check_name(labels, "a picture of labels")?;
        outputs.check(labels)?;
    }
    Ok(())
}
