//! `uvgraft avatar`: an animated full-body avatar from a head texture.

mod features;
mod lods;
mod materials;
mod meta;
mod motions;
mod selfie;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Arg;
use clap::builder::{PossibleValue, PossibleValuesParser, StyledStr, TypedValueParser};
use uvgraft::{Choice, Filter, MapOptions, Prefer, Size};
use uvgraft_assembly::avatar::{Betas, TextureLayout, TextureOptions, level_file};
use uvgraft_assembly::{AvatarRequest, Body, Input, drawing};
use uvgraft_gltf::glb::EmbeddedFormat;
use uvgraft_gltf::preset::Preset;
use uvgraft_image::{self as image, WriteOptions};
use uvgraft_pipeline::Outputs;
use uvgraft_viewer::PAGE;

use self::features::FeatureArgs;
use self::lods::LodArgs;
use self::materials::{Bases, MaterialArgs};
use self::meta::MetaArgs;
use self::motions::PlayArgs;
use self::selfie::SelfieArgs;
use crate::blending::BlendArgs;
use crate::body::shape;
use crate::choice::choice;
use crate::failure::{Notes, warn};
use crate::files;
use crate::heading;
use crate::number::whole_number;
use crate::outcome;
use crate::region::RegionArgs;
use crate::report::{grouped, parse_size};

/// The options that most people need.
const COMMON: [&str; 10] = [
    "output",
    "onto",
    "photos",
    "body",
    "expressions",
    "motion",
    "blend",
    "tone",
    "size",
    "preset",
];

/// Build an animated full-body avatar from a head texture
///
/// The face is transferred onto the body's texture as by `uvgraft transfer`, with a membrane that
/// hides the boundary unless --blend says otherwise. The body gets its skeleton, expressions and
/// animations. The result is a GLB file, or a VRM 1.0 file if the output ends in .vrm.
#[derive(clap::Args)]
#[command(mut_arg("blend", |blend| default_in_help(blend, "membrane")))]
#[command(mut_arg("tone", |tone| default_in_help(tone, "source")))]
#[command(mut_args(|option| heading::common(&COMMON, option)))]
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
    /// Layout of the avatar's textures
    #[arg(long, value_name = "LAYOUT", value_parser = choice::<TextureLayout>())]
    #[arg(default_value = TextureLayout::Atlas.name(), help_heading = heading::TEXTURE)]
    texture_layout: TextureLayout,
    /// Format of embedded textures [default: the preset's, or png]
    #[arg(id = "texture_format", long = "texture", value_name = "FORMAT")]
    #[arg(value_parser = choice::<EmbeddedFormat>(), help_heading = heading::TEXTURE)]
    texture: Option<EmbeddedFormat>,
    /// Quality of JPEG textures [default: 92]
    #[arg(long, value_name = "1-100", value_parser = whole_number::<u8>(1..=100), allow_negative_numbers = true)]
    #[arg(help_heading = heading::TEXTURE)]
    quality: Option<u8>,
    /// Interpolation filter [default: lanczos3]
    #[arg(long, value_parser = choice::<Filter>(), help_heading = heading::TEXTURE)]
    filter: Option<Filter>,
    /// Width of the gutter around UV islands, in texels
    #[arg(long, value_name = "TEXELS", default_value_t = MapOptions::default().gutter_px)]
    #[arg(value_parser = whole_number::<u32>(0..=256), allow_negative_numbers = true, help_heading = heading::TEXTURE)]
    gutter: u32,
    /// UV island that owns texels shared by several islands
    ///
    /// Matters for layouts with overlapping islands, such as two eyes that share one disc.
    #[arg(long, value_name = "ISLAND", value_parser = choice::<Prefer>())]
    #[arg(default_value = Prefer::First.name(), help_heading = heading::TEXTURE)]
    prefer: Prefer,
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
    preset: Option<&'static Preset>,
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
fn presets() -> impl TypedValueParser<Value = &'static Preset> {
    PossibleValuesParser::new(Preset::ALL.map(|preset| {
        let (platform, side) = (preset.limits.platform, preset.texture_side);
        let triangles = grouped(preset.triangles);
        PossibleValue::new(preset.name)
            .help(format!("{platform}: {triangles} triangles, textures of {side} texels a side"))
    }))
    .map(|name| Preset::named(&name).expect("a name that the parser lists"))
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let request = args.request()?;
    request.check()?;
    args.check_outputs(&request)?;
    let made = request.make(&Notes)?;
    if let (Some(path), Some(labels)) = (args.blending.drawn_labels(), made.labels) {
        let written = image::write(&labels.into(), path, &WriteOptions::default())?;
        written.losses.iter().for_each(warn);
        outcome::wrote(path);
    }
    if let (Some(path), Some(preview)) = (&args.blending.preview, made.preview) {
        drawing::write(preview, path)?;
        outcome::wrote(path);
    }
    files::write(&args.output, &made.file)?;
    for (index, file) in made.levels.iter().enumerate() {
        files::write(&level_file(&args.output, index + 1), file)?;
    }
    outcome::report(|| &made.report, || made.report.to_string())?;
    match PAGE {
        Some(_) => outcome::look_by(format_args!("view {}", outcome::argument(&args.output))),
        None => outcome::look_by_picture(&args.output, None, false),
    }
    Ok(ExitCode::SUCCESS)
}

impl Args {
    /// The avatar that the options describe.
    fn request(&self) -> anyhow::Result<AvatarRequest> {
        let body = match &*self.body {
            demo if demo == Path::new("demo") => Body::Figure,
            model => Body::Model(model.into()),
        };
        let bases = Bases::parse(&self.onto)?;
        let mut request = AvatarRequest::new(body, &self.output);
        request.pair = self.pair.as_ref().map(Input::from);
        request.face = self.face.as_ref().map(Input::from);
        request.photos = self.selfie.photos.iter().map(Input::from).collect();
        request.photo_options = self.selfie.photographs.options();
        request.likeness = self.selfie.likeness.unwrap_or(1.0);
        request.onto.clone_from(&bases.color);
        request.betas = self.betas.as_deref().map(Betas::parse).transpose()?;
        request.shape = self.shape.as_ref().map(|values| values.0.clone());
        request.expressions = self.expressions.as_ref().map(Input::from);
        request.motions = self.playing.options();
        request.textures = TextureOptions {
            size: self.size,
            layout: self.texture_layout,
            format: self.texture,
            quality: self.quality,
            filter: self.filter,
            gutter_px: self.gutter,
            prefer: self.prefer,
        };
        request.materials = self.materials.options(bases)?;
        request.mouth = self.features.mouth;
        request.eyes = self.features.eyes;
        request.region = self.region.region();
        request.blending = self.blending.settings();
        request.source_mask = self.blending.source_mask.as_ref().map(Input::from);
        request.fill = self.blending.fill.as_ref().map(Input::from);
        request.preview = self.blending.preview.is_some();
        request.levels = self.lods.options();
        request.preset = self.preset;
        request.triangles = self.triangles;
        request.metadata = self.meta.metadata();
        request.verbose = self.verbose;
        Ok(request)
    }

    /// Rejects outputs that cannot be written, before any work.
    fn check_outputs(&self, request: &AvatarRequest) -> anyhow::Result<()> {
        let inputs = request.inputs()?;
        let mut outputs = Outputs::new(inputs.iter().filter_map(Input::path));
        outputs.check(&self.output)?;
        for level in 1..=request.level_files() {
            outputs.check(&level_file(&self.output, level))?;
        }
        if let Some(preview) = &self.blending.preview {
            drawing::check_name(preview, "a preview")?;
            outputs.check(preview)?;
        }
        if let Some(labels) = self.blending.drawn_labels() {
            drawing::check_name(labels, "a label image")?;
            outputs.check(labels)?;
        }
        Ok(())
    }
}
