//! Expressions by name, carried to the body from another model.

use std::path::Path;

use anyhow::Context;
use uvgraft_avatar::body::{ModelFile, ReadOptions, Shape};
use uvgraft_avatar::face::add_named;
use uvgraft_avatar::face::transfer::transfer_between;
use uvgraft_io::model_mesh;

use super::body::Body;
use crate::failure::{OrBadInput, bad_input, note, warn};

/// Adds the named expressions of the model in `path` to a body, and the terms of the model.
pub(super) fn add(path: &Path, body: &mut Body) -> anyhow::Result<()> {
    let shown = path.display();
    let needs = ReadOptions { betas: 0, correctives: false };
    let ModelFile { model, license, .. } = ModelFile::read(path, &needs).or_bad_input()?;
    let shaped =
        model.shaped(&Shape::default()).map_err(|error| bad_input(format!("{shown}: {error}")))?;
    let morphs = shaped.named_expressions();
    if morphs.is_empty() {
        return Err(bad_input(format!(
            "{shown}: --expressions needs a model whose expressions have names, such as the open \
             body; those of {} models have none",
            model.kind().name()
        )));
    }
    let mesh = model_mesh::read(path).or_bad_input()?;
    let mesh =
        mesh.with_positions(shaped.positions().to_vec()).with_context(|| shown.to_string())?;
    let carried = transfer_between(&mesh, &morphs, &body.avatar.mesh)
        .map_err(|error| bad_input(format!("{shown}: {error}")))?;
    if let Some(error) = &carried.unmeasured {
        warn(format_args!("{}: {error}; lids and lips may not touch", body.name));
    }
    if !carried.unmoved.is_empty() {
        let names = carried.unmoved.join(", ");
        note(format_args!("{}: nothing moves in {names}; left out", body.name));
    }
    let added = add_named(&mut body.avatar, carried.morphs);
    if !added.taken.is_empty() {
        let names = added.taken.join(", ");
        note(format_args!("{}: already has expressions of these names: {names}", body.name));
    }
    let terms: Vec<String> = body.license.take().into_iter().chain(license).collect();
    let mut lines: Vec<&str> = Vec::new();
    for line in terms.iter().flat_map(|terms| terms.lines()) {
        if !lines.contains(&line) {
            lines.push(line);
        }
    }
    body.license = (!lines.is_empty()).then(|| lines.join("\n"));
    Ok(())
}
