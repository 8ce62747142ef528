//! `uvgraft body shape`: a shaped body as a mesh or as a model file; and shapes on the command line.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::Context;
use uvgraft_avatar::body::{BodyModel, ModelFile, ReadOptions, Shape};
use uvgraft_io::arrays::{self, NumericArray, save_npz_compressed};
use uvgraft_io::{model_mesh, obj};
use uvgraft_pipeline::Outputs;

use crate::failure::{OrBadInput, bad_input};
use crate::files::{OrCannotWrite, check_extension};
use crate::{outcome, terminal};

/// Shape the open body, and write it as a mesh or a model
#[derive(clap::Args)]
pub(super) struct Args {
    /// Model file, as written by `uvgraft body import`
    model: PathBuf,
    /// Shape by name, such as gender=0.2,weight=0.6,age=0.4,height=1.75
    ///
    /// From 0 to 1: gender (female to male), age (0.19 is a child of 12, 0.5 an adult of 25), muscle,
    /// weight, proportions; african, asian and caucasian are shares. height is in metres.
    #[arg(long, value_name = "NAME=VALUE,...", value_parser = parse)]
    shape: NamedValues,
    /// Mesh (.obj) or model (.npz) to write
    ///
    /// A model has the shape as its template, and no shapes by name.
    #[arg(short, long, value_name = "OUT.obj|OUT.npz")]
    output: PathBuf,
}

/// Values by name.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NamedValues(pub(crate) Vec<(String, f32)>);

/// Parses values by name, separated by commas.
pub(crate) fn parse(text: &str) -> Result<NamedValues, String> {
    let value = |part: &str| {
        let (name, value) = part.split_once('=')?;
        let value: f32 = value.trim().parse().ok()?;
        value.is_finite().then(|| (name.trim().to_owned(), value))
    };
    let values = text.split(',').map(|part| {
        value(part).ok_or_else(|| format!("must be NAME=NUMBER, got `{}`", part.trim()))
    });
    values.collect::<Result<_, _>>().map(NamedValues)
}

impl NamedValues {
    /// The shape of a model.
    ///
    /// - `path`: of the model, for messages.
    pub(crate) fn of(&self, model: &BodyModel, path: &Path) -> anyhow::Result<Shape> {
        let shape = model.named_shape(&self.0);
        shape.map_err(|error| bad_input(format!("{}: --shape: {error}", path.display())))
    }
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let (path, output) = (&*args.model, &*args.output);
    let extension = output.extension().map(OsStr::to_ascii_lowercase).unwrap_or_default();
    check_extension(output, &["obj", "npz"])?;
    Outputs::new([path]).check(output)?;
    let needs = ReadOptions { betas: usize::MAX, correctives: false };
    let file = ModelFile::read(path, &needs).or_bad_input()?;
    let shape = args.shape.of(&file.model, path)?;
    let refused = |error: &dyn std::fmt::Display| bad_input(format!("{}: {error}", path.display()));
    let shaped = file.model.shaped(&shape).map_err(|error| refused(&error))?;
    let positions = shaped.positions().to_vec();
    let heights = || positions.iter().map(|place| place[1]);
    let height = heights().fold(f32::MIN, f32::max) - heights().fold(f32::MAX, f32::min);
    if extension == "obj" {
        let mesh = model_mesh::read(path).or_bad_input()?.with_positions(positions)?;
        obj::save(&mesh, output).or_cannot_write(output)?;
    } else {
        let mut arrays = arrays::read(path).or_bad_input()?;
        let template = NumericArray::new_f32(vec![positions.len(), 3], positions.concat());
        arrays.insert("v_template", template.context("three coordinates for each vertex")?);
        let joints: Vec<f32> =
            shaped.skeleton().joints().iter().flat_map(|joint| joint.position).collect();
        if arrays.take("J_template").is_some() {
            let template = NumericArray::new_f32(vec![joints.len() / 3, 3], joints);
            arrays.insert("J_template", template.context("three coordinates for each joint")?);
        }
        arrays.remove("shape_parameters");
        for grid in 0.. {
            if arrays.take(&format!("shape_grid_{grid}")).is_none() {
                break;
            }
        }
        save_npz_compressed(&arrays, output).or_cannot_write(output)?;
    }
    outcome::wrote(output);
    outcome::look_by_picture(output, None, false);
    terminal::print(&format!("{height:.2} m tall\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_given_by_name() {
        let wanted = vec![("gender".to_owned(), 0.2), ("height".to_owned(), 1.75)];
        assert_eq!(parse("gender=0.2, height=1.75"), Ok(NamedValues(wanted)));
        for bad in ["", "gender", "gender=x", "gender=0.2,", "age=nan"] {
            let error = parse(bad).unwrap_err();
            assert!(error.starts_with("must be NAME=NUMBER, got `"), "{error}");
        }
    }
}
