//! Expressions by name, transferred to the body from another model.

use uvgraft::listing::listed;
use uvgraft_avatar::body::{ModelFile, ReadOptions, Shape};
use uvgraft_avatar::face::add_named;
use uvgraft_avatar::face::transfer::transfer_between;
use uvgraft_files::input::Input;
use uvgraft_io::model_mesh;
use uvgraft_pipeline::{Blame, Context, Failure, Observer, Result};

use super::body::RiggedBody;

/// Adds the named expressions of a model file to a body, and the terms of the model.
pub(super) fn add(file: &Input, body: &mut RiggedBody, observer: &dyn Observer) -> Result<()> {
    let needs = ReadOptions { betas: 0, correctives: false };
    let ModelFile { model, license, .. } = ModelFile::read(file, &needs).or_input()?;
    let shaped = model
        .shaped(&Shape::default())
        .map_err(|error| Failure::input(format!("{file}: {error}")))?;
    let morphs = shaped.named_expressions();
    if morphs.is_empty() {
        return Err(Failure::option(format!(
            "{file}: `expressions` needs a model whose expressions have names, such as the open \
             body; those of {} models have none",
            model.kind().name()
        )));
    }
    let mesh = model_mesh::read(file).or_input()?;
    let mesh = mesh.with_positions(shaped.positions().to_vec()).or_work().context(file)?;
    observer.check()?;
    let transferred = transfer_between(&mesh, &morphs, &body.avatar.mesh)
        .map_err(|error| Failure::input(format!("{file}: {error}")))?;
    if let Some(error) = &transferred.unmeasured {
        observer.warn(format_args!("{}: {error}; lids and lips may not touch", body.name));
    }
    if !transferred.unmoved.is_empty() {
        let names = listed(&transferred.unmoved);
        observer.note(format_args!("{}: nothing moves in {names}; left out", body.name));
    }
    let added = add_named(&mut body.avatar, transferred.morphs);
    if !added.taken.is_empty() {
        let names = listed(&added.taken);
        observer
            .note(format_args!("{}: already has expressions of these names: {names}", body.name));
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
