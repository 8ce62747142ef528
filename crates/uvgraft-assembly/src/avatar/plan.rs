//! The plan of an avatar: a request is validated before any large file is read.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use uvgraft::Size;
use uvgraft_files::input::Input;
use uvgraft_gltf::glb::{EmbeddedFormat, VrmMeta};
use uvgraft_gltf::preset::Preset;
use uvgraft_pipeline::{BaseSource, Failure, Observer, Result};

use super::request::{AvatarRequest, Body, LevelStorage};
use crate::existing;
use crate::selfie::Frames;

/// What follows from a valid request.
pub(super) struct Plan {
    /// The preset, with overrides by options.
    pub(super) preset: Option<Preset>,
    /// Maximum number of triangles.
    pub(super) triangles: Option<usize>,
    pub(super) format: EmbeddedFormat,
    /// Metadata, if the output is a VRM file.
    pub(super) vrm: Option<VrmMeta>,
    /// Photographs, if the face is made of them.
    pub(super) frames: Option<Frames>,
}

impl AvatarRequest {
    /// Rejects options that contradict each other, and inputs that do not exist, before anything
    /// large is read. [`AvatarRequest::make`] does so itself.
    ///
    /// # Errors
    /// As bad input.
    pub fn check(&self) -> Result<()> {
        Plan::new(self).map(drop)
    }

    /// All inputs, the frames of a folder of photographs among them.
    ///
    /// # Errors
    /// As bad input for a folder that cannot be read.
    pub fn inputs(&self) -> Result<Vec<Input>> {
        let frames = self.frames()?;
        Ok(self.read(frames.as_ref()).cloned().collect())
    }

    /// Whether the output is a VRM file.
    ///
    /// # Errors
    /// As bad input for another extension than `.glb` and `.vrm`.
    pub fn is_vrm(&self) -> Result<bool> {
        match self.file_name.extension().map(OsStr::to_ascii_lowercase) {
            Some(extension) if extension == "glb" => Ok(false),
            Some(extension) if extension == "vrm" => Ok(true),
            _ => {
                let name = self.file_name.display();
                Err(Failure::input(format!("{name}: extension must be .glb or .vrm")))
            }
        }
    }

    /// Number of levels that are files of their own.
    pub fn level_files(&self) -> usize {
        match self.levels.storage {
            LevelStorage::Files => self.levels.count.into(),
            LevelStorage::Msft => 0,
        }
    }

    /// The photographs; `None` if the face is a texture.
    fn frames(&self) -> Result<Option<Frames>> {
        if self.photos.is_empty() {
            return Ok(None);
        }
        Frames::new(&self.photos, self.photo_options.frames).map(Some)
    }

    fn read<'a>(&'a self, frames: Option<&'a Frames>) -> impl Iterator<Item = &'a Input> {
        let base_maps = self.materials.base_maps.iter().map(|(_, base)| base);
        [&self.pair, &self.face]
            .into_iter()
            .flatten()
            .chain(frames.into_iter().flat_map(Frames::inputs))
            .chain(self.onto.iter().chain(base_maps).filter_map(BaseSource::as_image))
            .chain(self.materials.maps.iter().map(|(_, map)| map))
            .chain(self.model())
            .chain(&self.expressions)
            .chain(&self.motions.recordings)
            .chain(self.blending.inputs())
            .chain([&self.source_mask, &self.fill].into_iter().flatten())
            .chain(self.region.inputs())
            .chain(self.betas.iter().filter_map(|betas| betas.input()))
            .chain(&self.photo_options.head_texture)
    }
}

impl Plan {
    /// Rejects conflicting options and missing inputs.
    pub(super) fn new(request: &AvatarRequest) -> Result<Self> {
        let is_vrm = request.is_vrm()?;
        let (file_name, metadata) = (&request.file_name, &request.metadata);
        let vrm = is_vrm.then(|| metadata.vrm(file_name)).transpose()?;
        if !is_vrm {
            metadata.check_glb()?;
        }
        check_face(request)?;
        request.materials.check(is_vrm)?;
        check_levels(request, is_vrm)?;
        request.blending.clone().of_avatar().check()?;
        request.region.check()?;
        check_body(request)?;
        let triangles = request.triangles.map(|count| count as usize);
        let preset = request.preset.map(|preset| Preset {
            triangles: triangles.unwrap_or(preset.triangles),
            format: request.textures.format.unwrap_or(preset.format),
            ..*preset
        });
        let format = check_textures(request, preset.as_ref())?;
        let frames = request.frames()?;
        existing::check(request.read(frames.as_ref()))?;
        let triangles = preset.as_ref().map(|preset| preset.triangles).or(triangles);
        Ok(Self { preset, triangles, format, vrm, frames })
    }

    /// Warns of options that undo what others ask for.
    pub(super) fn warn(request: &AvatarRequest, observer: &dyn Observer) {
        if let (Some(count), Some(preset)) = (request.triangles, request.preset)
            && count as usize > preset.triangles
        {
            let (name, most) = (preset.name, preset.triangles);
            observer.warn(format_args!(
                "`triangles` {count} is more than the {most} of `preset` {name}, which it overrides"
            ));
        }
    }
}

fn check_face(request: &AvatarRequest) -> Result<()> {
    match (&request.face, &*request.photos) {
        (None, []) => return Err(Failure::option("a face texture or `photos` is required")),
        (Some(_), [_, ..]) => {
            return Err(Failure::option("a face texture cannot be used with `photos`"));
        }
        _ => {}
    }
    if !(0.0..=1.0).contains(&request.likeness) {
        let found = request.likeness;
        return Err(Failure::option(format!("`likeness` must be 0 to 1, got {found}")));
    }
    if request.onto.is_none() && request.photos.is_empty() {
        return Err(Failure::option(
            "`onto` must include the body's colours: an image in its layout, or a colour such as \
             #c08a70",
        ));
    }
    Ok(())
}

fn check_levels(request: &AvatarRequest, is_vrm: bool) -> Result<()> {
    if request.levels.count > 0 && cfg!(not(feature = "simplify")) {
        return Err(Failure::option("`lods` needs a build with the feature `simplify`"));
    }
    if is_vrm && request.levels.storage == LevelStorage::Msft {
        return Err(Failure::option(
            "`lods_as` msft cannot be used with .vrm, whose readers do not support MSFT_lod; use \
             `lods_as` files, or write a .glb",
        ));
    }
    Ok(())
}

fn check_body(request: &AvatarRequest) -> Result<()> {
    let given = [("betas", request.betas.is_some()), ("shape", request.shape.is_some())];
    let mut given = given.iter().filter(|(_, is_given)| *is_given).map(|(name, _)| name);
    match (given.next(), given.next(), &request.body) {
        (Some(name), _, Body::Figure) => Err(Failure::option(format!(
            "`{name}` cannot be used with `body` demo, whose shape is fixed"
        ))),
        (Some(name), Some(other), _) => {
            Err(Failure::option(format!("`{name}` cannot be used with `{other}`")))
        }
        _ => Ok(()),
    }
}

/// The format of embedded textures.
fn check_textures(request: &AvatarRequest, preset: Option<&Preset>) -> Result<EmbeddedFormat> {
    let textures = &request.textures;
    if cfg!(not(feature = "ktx2")) && textures.format == Some(EmbeddedFormat::Ktx2) {
        return Err(Failure::option(
            "`texture_format` ktx2 needs a build with the feature `ktx2`; use png, jpeg or webp",
        ));
    }
    let format = preset.map(|preset| preset.format).or(textures.format);
    let format = format.unwrap_or(EmbeddedFormat::Png);
    match textures.quality {
        Some(_) if format != EmbeddedFormat::Jpeg => {
            return Err(Failure::option(
                "`quality` needs JPEG textures: add `texture_format` jpeg",
            ));
        }
        Some(quality) if !(1..=100).contains(&quality) => {
            return Err(Failure::option(format!("`quality` must be 1 to 100, got {quality}")));
        }
        _ => {}
    }
    let is_constant = matches!(request.onto, Some(BaseSource::Color(_)));
    if is_constant && textures.size.is_none() {
        return Err(Failure::option("`size` is required where `onto` is a colour"));
    }
    if let (Some(size), Some(preset)) = (textures.size, preset)
        && too_large(size, preset)
    {
        let (name, side) = (preset.name, preset.texture_side);
        return Err(Failure::option(format!(
            "`size` must be at most {side} with `preset` {name}, got {size}"
        )));
    }
    Ok(format)
}

fn too_large(size: Size, preset: &Preset) -> bool {
    size.width.max(size.height) > preset.texture_side
}

/// The files of coarser levels beside an avatar's: `NAME.lod1.glb` and so on.
pub fn level_file(output: &Path, level: usize) -> PathBuf {
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    let extension = output.extension().unwrap_or_default().to_string_lossy();
    output.with_file_name(format!("{stem}.lod{level}.{extension}"))
}
