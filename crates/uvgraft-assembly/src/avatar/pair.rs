//! The pair that links the head to the body: a file, or for bodies that contain a head of their own,
//! none.

use std::fmt::Display;

use uvgraft::Pair;
use uvgraft_figure::Figure;
use uvgraft_files::input::{Input, ReadError};
use uvgraft_io::pair_file::{self, PairFile};
use uvgraft_io::{arrays, model_mesh};
use uvgraft_pipeline::{Blame, Failure, Result};

use super::request::{AvatarRequest, Body};

impl AvatarRequest {
    /// Reads the pair, or makes that of the body.
    pub(super) fn read_pair(&self) -> Result<PairFile> {
        match (&self.pair, &self.body) {
            (Some(pair), _) => pair_file::read(pair).or_input(),
            (None, Body::Figure) => demo(),
            (None, Body::Model(model)) => of_model(model)?.ok_or_else(|| {
                Failure::option(format!(
                    "{model}: a pair file that links a head to this body is required; only `body` \
                     demo and the open body need none"
                ))
            }),
        }
    }

    /// What to call the pair in messages.
    pub(super) fn pair_name(&self) -> String {
        match (&self.pair, &self.body) {
            (Some(pair), _) => pair.to_string(),
            (None, Body::Figure) => "the demo's pair".to_owned(),
            (None, Body::Model(_)) => "the model's own head".to_owned(),
        }
    }
}

fn demo() -> Result<PairFile> {
    let figure = Figure::new();
    let ids: Vec<i64> = figure.vertex_map.iter().map(|&id| i64::from(id)).collect();
    let pair = Pair::by_vertex_map(figure.head, figure.body, &ids).or_work()?;
    Ok(PairFile {
        pair: pair.into(),
        source_name: "the demo's head".to_owned(),
        target_name: "the demo's body".to_owned(),
        note: String::new(),
    })
}

/// The pair of a model whose head has a layout of its own, as the open body's; `None` for others.
fn of_model(file: &Input) -> Result<Option<PairFile>> {
    let head = match model_mesh::read_head(file) {
        Ok(head) => head,
        Err(error @ ReadError::Io { .. }) => return Err(error).or_input(),
        Err(_) => return Ok(None),
    };
    let arrays = arrays::read(file).or_input()?;
    let refused = |error: &dyn Display| Failure::input(format!("{file}: {error}"));
    let body = model_mesh::from_arrays(&arrays).map_err(|error| refused(&error))?;
    let vertices = model_mesh::head_vertices(&arrays).map_err(|error| refused(&error))?;
    let ids: Vec<i64> = vertices.into_iter().map(i64::from).collect();
    let pair = Pair::by_vertex_map(head, body, &ids).map_err(|error| refused(&error))?;
    let name = file.name().file_name().unwrap_or_default().to_string_lossy();
    Ok(Some(PairFile {
        pair: pair.into(),
        source_name: format!("the head of {name}"),
        target_name: name.into_owned(),
        note: String::new(),
    }))
}
