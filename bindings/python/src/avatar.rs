//! Avatars from textures of heads, and from photographs.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use uvgraft::Encoding;
use uvgraft_assembly::avatar::{
    Betas, MapRole, MaterialOptions, Metadata, MotionOptions, TextureOptions, level_file,
};
use uvgraft_assembly::{AvatarRequest, Body, drawing};
use uvgraft_gltf::glb::Permissions;
use uvgraft_gltf::preset::{MAX_LEVELS, Preset};
use uvgraft_image::{self as image, WriteOptions};
use uvgraft_pipeline::{BaseSource, Input, Outputs};

use crate::arrays::floats;
use crate::error::{check_files, failed, of_option, of_pipeline, warn_caller};
use crate::inputs;
use crate::keywords::{Keywords, extracted};
use crate::{memory, work};

/// What `uvgraft.Avatar` is made of: its file, those of its levels, report and notes.
type AvatarTuple<'py> = (Bound<'py, PyBytes>, Vec<Bound<'py, PyBytes>>, String, Vec<String>);

/// Files beside the avatar.
#[derive(Default)]
struct Drawings {
    preview: Option<PathBuf>,
    /// Where labels are drawn, if none are there.
    labels: Option<PathBuf>,
}

/// The compiled part of `uvgraft.avatar` and `uvgraft.avatar_from_photos`.
///
/// - `file_name`: what the avatar's file is called.
#[pyfunction]
pub(crate) fn make_avatar<'py>(
    py: Python<'py>,
    file_name: PathBuf,
    arguments: &Bound<'py, PyDict>,
) -> PyResult<AvatarTuple<'py>> {
    let keywords = Keywords::new(arguments)?;
    let threads = keywords.threads()?;
    let output = keywords.path("output")?;
    let mut drawings = Drawings { preview: keywords.path("preview")?, labels: None };
    let request = keywords.avatar(file_name, &mut drawings)?;
    keywords.finish()?;
    let inputs = py.detach(|| request.inputs()).map_err(of_pipeline)?;
    check_files(py, &inputs)?;
    py.detach(|| {
        request.check()?;
        let mut outputs = Outputs::new(inputs.iter().filter_map(Input::path));
        if let Some(output) = &output {
            outputs.check(output)?;
            let mut levels = 1..=request.level_files();
            levels.try_for_each(|level| outputs.check(&level_file(output, level)))?;
        }
        drawings.check(&mut outputs)
    })
    .map_err(of_pipeline)?;
    let finished = work::run(py, threads, move |observer| request.make(observer))?;
    let files = finished.result;
    if let (Some(path), Some(labels)) = (&drawings.labels, files.labels) {
        let written = py.detach(|| image::write(&labels.into(), path, &WriteOptions::default()));
        let losses = written.map_err(failed)?.losses;
        warn_caller(py, losses.iter().map(ToString::to_string).collect())?;
    }
    if let (Some(path), Some(preview)) = (&drawings.preview, files.preview) {
        py.detach(|| drawing::write(preview, path)).map_err(of_pipeline)?;
    }
    let levels = files.levels.iter().map(|level| PyBytes::new(py, level)).collect();
    let file = PyBytes::new(py, &files.file);
    let report = files.report.to_string();
    drop((files.file, files.levels));
    memory::give_back(py);
    Ok((file, levels, report, finished.notes))
}

impl Drawings {
    fn check(&self, outputs: &mut Outputs) -> uvgraft_pipeline::Result<()> {
        for (path, what) in [(&self.preview, "a preview"), (&self.labels, "a label image")] {
            if let Some(path) = path {
                drawing::check_name(path, what)?;
                outputs.check(path)?;
            }
        }
        Ok(())
    }
}

impl Keywords<'_> {
    /// The avatar that the arguments describe.
    ///
    /// - `drawings`: gets the labels to draw.
    fn avatar(&self, file_name: PathBuf, drawings: &mut Drawings) -> PyResult<AvatarRequest> {
        let body: PathBuf = extracted(&self.required("body")?, "body", "a path")?;
        let body = match body {
            demo if demo == Path::new("demo") => Body::Figure,
            model => Body::Model(model.into()),
        };
        let mut request = AvatarRequest::new(body, file_name);
        request.pair = self.take("pair")?.map(|pair| inputs::pair(&pair, "pair")).transpose()?;
        request.face = self.image("face")?;
        if self.has("photos")? {
            request.photos = self.photos()?;
            request.photo_options = self.photo_options()?;
            request.likeness = self.number("likeness")?.unwrap_or(request.likeness);
        }
        let onto = self.take("onto")?;
        request.onto = onto.map(|it| inputs::base(&it, "onto", Encoding::Srgb)).transpose()?;
        request.betas = self.betas()?;
        request.shape = self.shape()?;
        request.expressions = self.path("expressions")?.map(Input::from);
        request.motions = self.motions()?;
        request.textures = self.textures(request.textures)?;
        request.materials = self.materials(request.materials)?;
        request.mouth = self.choice("mouth")?.unwrap_or(request.mouth);
        request.eyes = self.choice("eyes")?.unwrap_or(request.eyes);
        request.region = self.region()?;
        request.blending = self.blending()?;
        if let Some(given) = self.take("labels")? {
            match given.extract::<PathBuf>() {
                Ok(path) if !path.exists() => drawings.labels = Some(path),
                _ => {
                    let labels = inputs::image(&given, "labels", Encoding::Srgb)?;
                    request.blending.labels = Some(labels);
                }
            }
        }
        request.blending.draw_labels = drawings.labels.is_some();
        request.source_mask = self.image("source_mask")?;
        request.fill = self.image("fill")?;
        request.preview = drawings.preview.is_some();
        self.needs("lods_as", "lods")?;
        let levels = &mut request.levels;
        levels.count = self.whole("lods", 1..=MAX_LEVELS as u8)?.unwrap_or(levels.count);
        levels.storage = self.choice("lods_as")?.unwrap_or(levels.storage);
        let preset = |name: String| {
            let names = || Preset::ALL.map(|preset| preset.name).join(", ");
            Preset::named(&name).ok_or_else(|| {
                of_option("preset", format_args!("must be one of {}, got {name:?}", names()))
            })
        };
        request.preset = self.text("preset")?.map(preset).transpose()?;
        request.triangles = self.whole("triangles", 1000..=u32::MAX)?;
        request.metadata = self.metadata()?;
        request.verbose = self.flag("verbose")?;
        Ok(request)
    }

    fn betas(&self) -> PyResult<Option<Betas>> {
        let Some(given) = self.take("betas")? else { return Ok(None) };
        match given.extract::<PathBuf>() {
            Ok(path) => match path.to_str().map(Betas::parse) {
                Some(Ok(numbers @ Betas::Numbers(_))) => Ok(Some(numbers)),
                _ => Ok(Some(Betas::File(path.into()))),
            },
            Err(_) => floats(&given, "betas").map(Betas::Numbers).map(Some),
        }
    }

    fn shape(&self) -> PyResult<Option<Vec<(String, f32)>>> {
        self.take("shape")?.map(|given| inputs::named_numbers(&given, "shape")).transpose()
    }

    fn motions(&self) -> PyResult<MotionOptions> {
        for name in ["fps", "ground", "up"] {
            self.needs(name, "motion")?;
        }
        Ok(MotionOptions {
            recordings: self.paths("motion")?.into_iter().map(Input::from).collect(),
            fps: self.whole("fps", 0..=240)?,
            ground: self.choice("ground")?,
            up: self.choice("up")?,
        })
    }

    fn textures(&self, default: TextureOptions) -> PyResult<TextureOptions> {
        Ok(TextureOptions {
            size: self.size("size")?,
            layout: self.choice("texture_layout")?.unwrap_or(default.layout),
            format: self.choice("texture_format")?,
            quality: self.whole("quality", 1..=100)?,
            filter: self.choice("filter")?,
            gutter_px: self.whole("gutter", 0..=256)?.unwrap_or(default.gutter_px),
            prefer: self.choice("prefer")?.unwrap_or(default.prefer),
        })
    }

    fn materials(&self, default: MaterialOptions) -> PyResult<MaterialOptions> {
        let maps = self.take("maps")?.map(|given| inputs::by_role(&given, "maps", inputs::image));
        let bases = self.take("base_maps")?;
        let bases = bases.map(|given| inputs::by_role(&given, "base_maps", inputs::base));
        Ok(MaterialOptions {
            maps: with_roles::<Input>("maps", maps.transpose()?)?,
            base_maps: with_roles::<BaseSource>("base_maps", bases.transpose()?)?,
            normal_y: self.choice("normal_y")?.unwrap_or(default.normal_y),
            look: self.choice("look")?.unwrap_or(default.look),
        })
    }

    fn metadata(&self) -> PyResult<Metadata> {
        let license = |name: String| {
            let names = || Permissions::NAMED.map(|(name, _)| name).join(", ");
            Permissions::named(&name).ok_or_else(|| {
                of_option("license", format_args!("must be one of {}, got {name:?}", names()))
            })
        };
        Ok(Metadata {
            title: self.text("title")?,
            authors: self.texts("author")?,
            license: self.text("license")?.map(license).transpose()?,
            license_url: self.text("license_url")?,
            made_from: self.text("made_from")?,
        })
    }
}

/// Maps by their roles, of which each is there once: several names may stand for one.
fn with_roles<T>(name: &str, maps: Option<Vec<(String, T)>>) -> PyResult<Vec<(MapRole, T)>> {
    let mut with_roles: Vec<(MapRole, T)> = Vec::new();
    for (role_name, map) in maps.into_iter().flatten() {
        let role = MapRole::named(&role_name.to_ascii_lowercase()).ok_or_else(|| {
            let known = MapRole::names();
            of_option(
                name,
                format_args!("must have roles that are one of {known}, got {role_name:?}"),
            )
        })?;
        if with_roles.iter().any(|(known, _)| *known == role) {
            return Err(of_option(name, format_args!("has the role {} twice", role.name())));
        }
        with_roles.push((role, map));
    }
    Ok(with_roles)
}
