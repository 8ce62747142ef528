//! `uvgraft avatar`: an animated full-body avatar from a head texture.

mod betas;
mod body;
mod carried;
mod dress;
mod expressions;
mod face;
mod features;
mod layout;
mod lods;
mod map_transfer;
mod maps;
mod materials;
mod meta;
mod motions;
mod pair;
mod plan;
mod selfie;
mod summary;
mod thumbnail;

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use anyhow::Context;
use clap::Arg;
use clap::builder::{PossibleValue, PossibleValuesParser, StyledStr};
use uvgraft::{MapOptions, Size};
use uvgraft_gltf::glb::{self, Export, PictureFormat, VrmError};
use uvgraft_gltf::preset::{self, FittedAvatar, Preset};
use uvgraft_io::output;

use crate::blending::BlendArgs;
use crate::body::shape;
use crate::failure::{OrBadInput, bad_input};
use crate::filters::FilterName;
use crate::heading;
use crate::number::whole_number;
use crate::preference::PreferName;
use crate::region::RegionArgs;
use crate::report::{grouped, parse_size};
use crate::terminal;
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
use selfie::SelfieArgs;

/// JPEG quality: textures are looked at closely, and base colours have no blur to hide blocks.
const JPEG_QUALITY: u8 = 92;

/// Build an animated full-body avatar from a head texture
///
/// The face is transferred onto the body's texture as by `uvgraft transfer`, with a membrane that
/// hides the boundary unless --blend says otherwise. The body gets its skeleton, expressions and
/// animations. The result is a GLB file, or a VRM 1.0 file if the output ends in .vrm.
#[derive(clap::Args)]
#[command(mut_arg("blend", |blend| default_in_help(blend, "membrane")))]
#[command(mut_arg("tone", |tone| default_in_help(tone, "source")))]
pub(crate) struct Args {
    /// Pair file that links the head to the body
    ///
    /// With --selfie, the built-in figure and the open body need none.
    #[arg(required_unless_present = "photos")]
    pair: Option<PathBuf>,
    /// Face texture in the head's layout, or the output of FATE
    ///
    /// An image, a FATE texture dump (.pth), or a FATE workspace: a folder that contains
    /// baking*/dump_texture/ or visualize_texture/. None with --selfie.
    #[arg(required_unless_present = "photos", conflicts_with = "photos")]
    face: Option<PathBuf>,
    /// Avatar to write: .glb, or .vrm for VRM 1.0
    #[arg(short, long, value_name = "OUT.glb|OUT.vrm", help_heading = heading::FILES)]
    output: PathBuf,
    /// Body texture, or a colour such as #c08a70
    ///
    /// An image in the body's layout, or a colour. Repeat the option as ROLE=IMAGE for the body's
    /// other maps: see --map for the roles. With --selfie, the built-in figure and the open body have
    /// a painted skin of their own if no texture is given.
    #[arg(long, value_name = "[ROLE=]IMAGE|COLOUR", help_heading = heading::FILES)]
    #[arg(required_unless_present = "photos")]
    onto: Vec<String>,
    /// List the unused arrays of the body model file
    #[arg(short, long, help_heading = heading::FILES)]
    verbose: bool,
    #[command(flatten)]
    selfie: SelfieArgs,
    /// Body model file, or `demo` for the built-in figure
    ///
    /// A model of the SMPL family (SMPL, SMPL-H, SMPL-X or FLAME) as .npz or .pkl, or the figure
    /// that `uvgraft demo` uses.
    #[arg(long, value_name = "MODEL|demo", help_heading = heading::BODY)]
    body: PathBuf,
    /// Shape coefficients, such as 0.5,-1.2, or a file that holds them
    ///
    /// A file (.npz, .pkl) must contain an array `betas`.
    #[arg(long, value_name = "NUMBERS|FILE", allow_hyphen_values = true, help_heading = heading::BODY)]
    betas: Option<String>,
    /// Shape by name, such as gender=0.2,weight=0.6,age=0.4,height=1.75
    ///
    /// For the open body: see `uvgraft body shape` for the names.
    #[arg(long, value_name = "NAME=VALUE,...", value_parser = shape::parse, conflicts_with = "betas")]
    #[arg(help_heading = heading::BODY)]
    shape: Option<shape::NamedValues>,
    /// Model file whose named expressions are carried to the body, such as the open body
    ///
    /// They become morph targets and expressions, with ARKit's names in the case of the open body. VRM's
    /// presets are made of them where the body's own model cannot make them. The heads are registered
    /// to each other, which takes some seconds.
    #[arg(long, value_name = "MODEL", help_heading = heading::BODY)]
    expressions: Option<PathBuf>,
    #[command(flatten)]
    playing: PlayArgs,
    /// Size of the body texture in texels [default: the base's, within the preset]
    #[arg(long, value_name = "N|WxH", value_parser = parse_size, allow_negative_numbers = true, help_heading = heading::TEXTURE)]
    size: Option<Size>,
    #[command(flatten)]
    layout: LayoutArgs,
    /// Format of embedded textures [default: the preset's, or png]
    #[arg(long, value_enum, value_name = "FORMAT", help_heading = heading::TEXTURE)]
    texture: Option<TextureName>,
    /// Quality of JPEG textures [default: 92]
    #[arg(long, value_name = "1-100", value_parser = whole_number::<u8>(1..=100), allow_negative_numbers = true)]
    #[arg(help_heading = heading::TEXTURE)]
    quality: Option<u8>,
    /// Interpolation filter [default: lanczos3]
    #[arg(long, value_enum, help_heading = heading::TEXTURE)]
    filter: Option<FilterName>,
    /// Width of the gutter around UV islands, in texels
    #[arg(long, value_name = "TEXELS", default_value_t = MapOptions::default().gutter_px)]
    #[arg(value_parser = whole_number::<u32>(0..=256), allow_negative_numbers = true, help_heading = heading::TEXTURE)]
    gutter: u32,
    /// UV island that owns texels shared by several islands
    ///
    /// Matters for layouts with overlapping islands, such as two eyes that share one disc.
    #[arg(long, value_enum, value_name = "ISLAND", default_value_t = PreferName::First)]
    #[arg(help_heading = heading::TEXTURE)]
    prefer: PreferName,
    #[command(flatten)]
    materials: MaterialArgs,
    #[command(flatten)]
    features: FeatureArgs,
    #[command(flatten)]
    region: RegionArgs,
    #[command(flatten)]
    blending: BlendArgs,
    #[command(flatten)]
    lods: LodArgs,
    /// Platform to target
    ///
    /// Limits texture size and number of triangles, and reports how the avatar compares with the
    /// platform's published limits. visionos is for AR Quick
    /// Look, which opens USDZ files only: convert the avatar afterwards.
    #[arg(long, help_heading = heading::PLATFORM)]
    #[arg(value_parser = presets())]
    preset: Option<String>,
    /// Maximum number of triangles [default: the preset's, or unlimited]
    ///
    /// Hidden triangles, such as the backs of the eyeballs, are removed first; the rest is
    /// simplified.
    #[arg(long, value_name = "N", value_parser = whole_number::<u32>(1000..=u64::from(u32::MAX)), allow_negative_numbers = true)]
    #[arg(help_heading = heading::PLATFORM)]
    triangles: Option<u32>,
    #[command(flatten)]
    meta: MetaArgs,
}

/// States another default in the help of an option than the command that it is shared with.
fn default_in_help(option: Arg, default: &str) -> Arg {
    let stated = |help: &StyledStr| {
        let help = help.to_string();
        let start = help.find("[default: ").expect("help that states the default");
        let end = start + help[start..].find(']').expect("a closing bracket");
        format!("{}[default: {default}{}", &help[..start], &help[end..])
    };
    let (short, long) = (option.get_help().map(stated), option.get_long_help().map(stated));
    let option = option.help(short.expect("help"));
    if let Some(long) = long { option.long_help(long) } else { option }
}

/// The names of presets, with their limits as help.
fn presets() -> PossibleValuesParser {
    PossibleValuesParser::new(Preset::ALL.map(|preset| {
        let (platform, side) = (preset.limits.platform, preset.texture_side);
        let triangles = grouped(preset.triangles);
        PossibleValue::new(preset.name)
            .help(format!("{platform}: {triangles} triangles, textures of {side} texels a side"))
    }))
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum TextureName {
    /// Lossless, supported everywhere
    Png,
    /// Lossy and small, supported everywhere
    Jpeg,
    /// Lossless and smaller than PNG, supported by browsers and Blender
    Webp,
    /// Stays compressed on the GPU; needs a build with the feature `ktx2`
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
    terminal::print(&make(args)?)?;
    Ok(ExitCode::SUCCESS)
}

/// Writes the avatar, and describes it.
pub(crate) fn make(args: &Args) -> anyhow::Result<String> {
    let plan = Plan::new(args)?;
    let mut file = args.read_pair()?;
    let given = Arc::clone(&file.pair);
    let (body, selfie) = rayon::join(
        || Body::new(args, given.target()),
        || {
            let fit = |frames| args.selfie.fit(frames, &given, &file.source_name);
            plan.frames.as_ref().map(fit).transpose()
        },
    );
    let (mut body, selfie) = (body?, selfie?);
    let parted = features::parted(&given)?;
    if let Some((pair, _)) = &parted {
        file.pair = Arc::clone(pair);
    }
    let limits = plan.preset.as_ref();
    let (body, dressed) = rayon::join(
        || {
            if let Some(selfie) = &selfie {
                body.avatar = args.selfie.shape(selfie, &given, body.avatar, &body.name)?;
            }
            if let Some((_, parted)) = &parted {
                body.avatar = features::with_layout(body.avatar, &parted.mesh)?;
            }
            let mouth = match body.has_mouth {
                true => None,
                false => args.features.fit_mouth(&body.avatar),
            };
            anyhow::Ok((body, mouth))
        },
        || {
            let (face, base) = rayon::join(
                || match (&selfie, &args.face) {
                    (Some(selfie), _) => Ok(Face::of_selfie(selfie)),
                    (None, Some(path)) => Face::read(path),
                    (None, None) => Err(bad_input("a face texture or --selfie is required")),
                },
                || dress::base(args, plan.onto.as_ref(), limits),
            );
            let mut base = base?;
            if let Some((_, parted)) = &parted {
                parted.copy(&mut base);
            }
            dress::dress(args, &file, face?, base, limits)
        },
    );
    let ((body, mouth), dressed) = (body?, dressed?);
    let Body { avatar, name, apart, grounds, solved, license, .. } = body;
    let license = license.as_deref();
    let missing = avatar.skeleton.missing_bones();
    if plan.vrm.is_some() && !missing.is_empty() {
        // Comes before messages about a face that will never be in a file.
        let (output, why) = (args.output.display(), VrmError::MissingBones { bones: missing });
        return Err(bad_input(format!("{name} as {output}: {why}")));
    }
    if let Some((kind, solved)) = &solved {
        expressions::report(&args.body, *kind, solved);
    }
    let Dressed { body: mut color, head, map_transfer } = dressed;
    args.features.draw_eyes(&avatar, &mut color, &name);
    let (mut avatar, mouth) = match mouth {
        Some(mouth) => features::with_mouth(avatar, mouth, &mut color, &name)?,
        None => (avatar, None),
    };
    if let Some(layout) = &map_transfer.head {
        layout.apply(&mut avatar)?;
    }
    let maps = plan.materials.carry(&map_transfer, color.size())?;
    let (mut fitted, mut normals) = (None, None);
    if let Some(triangles) = plan.triangles {
        let fit = preset::fit(avatar, triangles).or_bad_input()?;
        let FittedAvatar { before, hidden, after, wanted, .. } = fit;
        fitted = Some((before, hidden, after, wanted));
        // Simplifying may have removed the lowest vertex.
        (avatar, normals) = (fit.avatar.standing()?, fit.normals);
    }
    let levels = args.lods.levels(&avatar, normals.as_deref())?;
    let is_vrm = plan.vrm.is_some();
    let shown =
        is_vrm.then(|| thumbnail::Colors::new([Some(&color), head.as_ref()].into_iter().flatten()));
    // Textures already have the preset's size.
    let quality = args.quality.unwrap_or(JPEG_QUALITY);
    let encoder = Encoder { format: plan.format, quality, style: plan.materials.style };
    let looks = maps.looks((color, head), &encoder).or_bad_input()?;
    let export = Export {
        name: args.meta.title(&args.output),
        copyright: args.meta.copyright(license),
        extras: if is_vrm { Default::default() } else { args.meta.extras(license) },
        thumbnail: shown.and_then(|shown| shown.thumbnail(&avatar, &looks)),
        normals,
        vrm: plan.vrm.map(|vrm| meta::made_from(vrm, license)),
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
    let of_photographs = selfie.map(|selfie| selfie.text(&file.source_name)).unwrap_or_default();
    Ok(of_photographs + &made.text())
}

fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    output::write_atomically::<io::Error>(path, |out| out.write_all(bytes))
        .with_context(|| format!("cannot write {}", path.display()))?;
    Ok(())
}
