//! Pictures of avatars, and the page that shows one.

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyMapping, PyString};
use uvgraft_assembly::render::{Aim, PoseOption, parse_background, parse_expression};
use uvgraft_assembly::{RenderRequest, ViewRequest};
use uvgraft_pipeline::{Failure, parse_memory};

use crate::arrays::{array, floats};
use crate::error::{check_files, of_option};
use crate::inputs;
use crate::keywords::{Keywords, extracted, of_type};
use crate::work;

/// The compiled part of `uvgraft.render`.
#[pyfunction]
pub(crate) fn make_picture<'py>(
    py: Python<'py>,
    arguments: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    let keywords = Keywords::new(arguments)?;
    let threads = keywords.threads()?;
    let request = keywords.picture()?;
    keywords.finish()?;
    check_files(py, request.inputs())?;
    let drawn = work::run(py, threads, move |observer| {
        let rendering = request.open(observer)?;
        observer.check()?;
        let picture = rendering.pictures().next();
        picture.unwrap_or_else(|| Err(Failure::work("a picture has no frame")))
    })?;
    array(py, drawn.result, false)
}

/// The compiled part of `uvgraft.Avatar.html`.
#[pyfunction]
pub(crate) fn make_page<'py>(
    py: Python<'py>,
    arguments: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyBytes>> {
    let keywords = Keywords::new(arguments)?;
    let mut request = ViewRequest::new(inputs::avatar(&keywords.required("avatar")?, "avatar")?);
    request.memory = keywords.memory()?;
    keywords.finish()?;
    check_files(py, request.inputs())?;
    let page = work::run(py, None, move |observer| request.make(observer))?;
    Ok(PyBytes::new(py, &page.result))
}

impl Keywords<'_> {
    fn picture(&self) -> PyResult<RenderRequest> {
        let mut request = RenderRequest::new(inputs::shown(&self.required("avatar")?, "avatar")?);
        if let Some(textures) = self.take("texture")? {
            request.textures = inputs::images(&textures, "texture")?;
        }
        request.up = self.choice("up")?;
        request.size = self.size("size")?.unwrap_or(request.size);
        let shot = self.choice("camera")?.map(Aim::Shot);
        request.aim = self.look_at()?.or(shot).unwrap_or(request.aim);
        for (name, value) in [
            ("azimuth", &mut request.azimuth),
            ("elevation", &mut request.elevation),
            ("fov", &mut request.fov),
            ("zoom", &mut request.zoom),
        ] {
            *value = self.number(name)?.map_or(*value, |number| number as f32);
        }
        if let Some(pose) = self.take("pose")? {
            add_poses(&pose, &mut request.pose)?;
        }
        request.expressions = self.expressions()?;
        request.clip = self.take("clip")?.map(|clip| clip_of(&clip)).transpose()?;
        request.frame = self.number("frame")?.map(|seconds| seconds as f32);
        request.background = self.parsed("background", parse_background)?;
        request.unlit = self.flag("unlit")?;
        request.floor = self.flag("floor")?;
        request.memory = self.memory()?;
        Ok(request)
    }

    /// A bound on memory: bytes, or text such as 500M.
    fn memory(&self) -> PyResult<Option<u64>> {
        let Some(given) = self.take("memory")? else { return Ok(None) };
        let text = match given.extract::<u64>() {
            Ok(bytes) => bytes.to_string(),
            Err(_) => extracted(&given, "memory", "an int or a str")?,
        };
        let refused = |wanted| of_option("memory", format_args!("{wanted}, got {text}"));
        parse_memory(&text).map(Some).map_err(refused)
    }

    fn look_at(&self) -> PyResult<Option<Aim>> {
        let Some(given) = self.take("look_at")? else { return Ok(None) };
        let refused = |wanted| of_option("look_at", wanted);
        if let Ok(text) = given.extract::<String>() {
            return Aim::parse(&text).map(Some).map_err(refused);
        }
        let numbers = floats(&given, "look_at")?;
        let corners = <[f32; 6]>::try_from(numbers).map_err(|numbers| {
            refused(format!("must be six numbers, two corners in metres, got {}", numbers.len()))
        })?;
        Ok(Some(Aim::between(corners)))
    }

    fn expressions(&self) -> PyResult<Vec<(String, f32)>> {
        let Some(given) = self.take("expression")? else { return Ok(Vec::new()) };
        let parsed = |text: String| {
            parse_expression(&text).map_err(|wanted| of_option("expression", wanted))
        };
        if let Ok(text) = given.extract::<String>() {
            return Ok(vec![parsed(text)?]);
        }
        if given.cast::<PyMapping>().is_ok() {
            return inputs::named_numbers(&given, "expression");
        }
        let wanted = "a str, a mapping of these to numbers, or a sequence of str";
        let names = given.try_iter().map_err(|_| of_type(&given, "expression", wanted))?;
        names.map(|name| parsed(extracted(&name?, "expression", wanted)?)).collect()
    }
}

/// Adds a pose by name, rotations of bones, or several of these.
fn add_poses(given: &Bound<'_, PyAny>, poses: &mut Vec<PoseOption>) -> PyResult<()> {
    let refused = |wanted| of_option("pose", wanted);
    if let Ok(text) = given.extract::<String>() {
        poses.push(PoseOption::parse(&text).map_err(refused)?);
        return Ok(());
    }
    let wanted = "a str, a mapping of bones to angles, or a sequence of these";
    if let Ok(bones) = given.cast::<PyMapping>() {
        for item in bones.items()? {
            let (bone, angles): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
            let bone: String = extracted(&bone, "pose", wanted)?;
            let angles = floats(&angles, &format!("pose of {bone}"))?;
            let angles = <[f32; 3]>::try_from(angles).map_err(|angles| {
                refused(format!(
                    "must have three angles in degrees for {bone}, got {}",
                    angles.len()
                ))
            })?;
            poses.push(PoseOption::Bone(bone, angles));
        }
        return Ok(());
    }
    let mut parts = given.try_iter().map_err(|_| of_type(given, "pose", wanted))?;
    parts.try_for_each(|part| add_poses(&part?, poses))
}

/// A clip by its name or its number.
fn clip_of(given: &Bound<'_, PyAny>) -> PyResult<String> {
    match given.cast::<PyString>() {
        Ok(name) => name.extract(),
        Err(_) => {
            extracted::<usize>(given, "clip", "a str or an int").map(|number| number.to_string())
        }
    }
}
