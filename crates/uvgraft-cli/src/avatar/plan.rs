//! The plan of an avatar: options are validated before any large file is read.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use uvgraft::Size;
use uvgraft_gltf::glb::{PictureFormat, VrmMeta};
use uvgraft_gltf::preset::Preset;
use uvgraft_pipeline::{BaseSource, Outputs};

use super::materials::{Bases, Materials};
use super::{Args, TextureName, body};
use crate::failure::bad_input;
use crate::picture::check_name;
use crate::selfie::Frames;

/// A validated request.
pub(super) struct Plan {
    /// The base of the body's colours; its own painted skin if there is none.
    pub(super) onto: Option<BaseSource>,
    pub(super) materials: Materials,
    /// The preset, with overrides by options.
    pub(super) preset: Option<Preset>,
    /// Maximum number of triangles.
    pub(super) triangles: Option<usize>,
    pub(super) format: PictureFormat,
    /// Metadata, if the output is a VRM file.
    pub(super) vrm: Option<VrmMeta>,
    /// Output files of coarser levels.
    pub(super) level_files: Vec<PathBuf>,
    /// Photographs, if the face is made of them.
    pub(super) frames: Option<Frames>,
}

impl Plan {
    /// Rejects conflicting options, missing inputs, and outputs that cannot be written.
    pub(super) fn new(args: &Args) -> anyhow::Result<Self> {
        let is_vrm = is_vrm(&args.output)?;
        let vrm = is_vrm.then(|| args.meta.vrm(&args.output)).transpose()?;
        if !is_vrm {
            args.meta.check_glb()?;
        }
        let bases = Bases::parse(&args.onto, args.selfie.photos.is_empty())?;
        let onto = bases.color.clone();
        let materials = args.materials.check(bases, is_vrm)?;
        args.lods.check(is_vrm)?;
        args.blending.clone().of_avatar().check()?;
        check_body(args)?;
        let triangles = args.triangles.map(|count| count as usize);
        let preset = args.preset.as_deref().and_then(Preset::named).map(|preset| Preset {
            triangles: triangles.unwrap_or(preset.triangles),
            format: args.texture.map_or(preset.format, PictureFormat::from),
            ..*preset
        });
        let format = check_textures(args, onto.as_ref(), preset.as_ref())?;
        let level_files = args.lods.files(&args.output);
        let frames = args.selfie.frames()?;
        check_files(args, onto.as_ref(), &materials, &level_files, frames.as_ref())?;
        let triangles = preset.as_ref().map(|preset| preset.triangles).or(triangles);
        Ok(Self { onto, materials, preset, triangles, format, vrm, level_files, frames })
    }
}

/// Whether the output is a VRM file, by its extension.
fn is_vrm(output: &Path) -> anyhow::Result<bool> {
    match output.extension().map(OsStr::to_ascii_lowercase) {
        Some(extension) if extension == "glb" => Ok(false),
        Some(extension) if extension == "vrm" => Ok(true),
        _ => Err(bad_input(format!("{}: extension must be .glb or .vrm", output.display()))),
    }
}

fn check_body(args: &Args) -> anyhow::Result<()> {
    let given = [("--betas", args.betas.is_some()), ("--shape", args.shape.is_some())];
    if let Some((option, _)) = given.iter().find(|(_, is_given)| *is_given)
        && args.is_figure()
    {
        let why = "cannot be used with --body demo, whose shape is fixed";
        return Err(bad_input(format!("{option} {why}")));
    }
    let Some(betas) = &args.betas else { return Ok(()) };
    if !Path::new(betas).exists() {
        body::betas(betas)?;
    }
    Ok(())
}

/// The format of embedded textures.
fn check_textures(
    args: &Args,
    onto: Option<&BaseSource>,
    preset: Option<&Preset>,
) -> anyhow::Result<PictureFormat> {
    if cfg!(not(feature = "ktx2")) && args.texture == Some(TextureName::Ktx2) {
        return Err(bad_input(
            "--texture ktx2 needs a build with the feature `ktx2`; use png, jpeg or webp",
        ));
    }
    let preset_format = preset.map(|preset| preset.format);
    let format = preset_format.or(args.texture.map(PictureFormat::from));
    let format = format.unwrap_or(PictureFormat::Png);
    if args.quality.is_some() && format != PictureFormat::Jpeg {
        return Err(bad_input("--quality needs JPEG textures: add --texture jpeg"));
    }
    if onto.is_some_and(|onto| onto.path().is_none()) && args.size.is_none() {
        return Err(bad_input("--size is required where --onto is a colour"));
    }
    if let (Some(size), Some(preset)) = (args.size, preset)
        && too_large(size, preset)
    {
        let (name, side) = (preset.name, preset.texture_side);
        return Err(bad_input(format!(
            "--size must be at most {side} with --preset {name}, got {size}"
        )));
    }
    Ok(format)
}

fn too_large(size: Size, preset: &Preset) -> bool {
    size.width.max(size.height) > preset.texture_side
}

fn check_files(
    args: &Args,
    onto: Option<&BaseSource>,
    materials: &Materials,
    level_files: &[PathBuf],
    frames: Option<&Frames>,
) -> anyhow::Result<()> {
    let models = Some(&*args.body).filter(|_| !args.is_figure());
    let read: Vec<&Path> = [&args.pair, &args.face]
        .into_iter()
        .flatten()
        .map(PathBuf::as_path)
        .chain(frames.iter().flat_map(|frames| frames.files()))
        .chain(onto.and_then(BaseSource::path))
        .chain(materials.inputs())
        .chain(models)
        .chain(args.expressions.as_deref())
        .chain(args.playing.motion.iter().map(PathBuf::as_path))
        .chain(args.blending.inputs())
        .chain(args.region.inputs())
        .collect();
    for path in &read {
        if let Err(error) = fs::metadata(path) {
            return Err(bad_input(format!("{}: {error}", path.display())));
        }
    }
    // Betas may also be numbers.
    let shape = args.betas.as_deref().map(Path::new);
    let mut outputs = Outputs::new(read.into_iter().chain(shape));
    outputs.check(&args.output)?;
    for file in level_files {
        outputs.check(file)?;
    }
    if let Some(preview) = &args.blending.preview {
        check_name(preview, "a preview")?;
        outputs.check(preview)?;
    }
    if let Some(labels) = args.blending.drawn_labels() {
        check_name(labels, "a label image")?;
        outputs.check(labels)?;
    }
    Ok(())
}
