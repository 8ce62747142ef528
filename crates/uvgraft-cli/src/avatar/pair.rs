//! The pair that links the head to the body: a file, or for bodies that contain a head of their own,
//! none.

use std::path::Path;

use uvgraft::Pair;
use uvgraft_figure::Figure;
use uvgraft_io::input::ReadError;
use uvgraft_io::pair_file::{self, PairFile};
use uvgraft_io::{arrays, model_mesh};

use super::Args;
use crate::failure::{OrBadInput, bad_input};

impl Args {
    /// Reads the pair, or makes that of the body.
    pub(super) fn read_pair(&self) -> anyhow::Result<PairFile> {
        match &self.pair {
            Some(path) => pair_file::read(path).or_bad_input(),
            None if self.is_figure() => demo(),
            None => of_model(&self.body)?.ok_or_else(|| self.pair_is_missing()),
        }
    }

    /// What to call the pair in messages.
    pub(super) fn pair_name(&self) -> String {
        match &self.pair {
            Some(path) => path.display().to_string(),
            None if self.is_figure() => "the demo's pair".to_owned(),
            None => "the model's own head".to_owned(),
        }
    }

    /// Whether the body is the built-in figure.
    pub(super) fn is_figure(&self) -> bool {
        self.body == Path::new("demo")
    }

    fn pair_is_missing(&self) -> anyhow::Error {
        bad_input(format!(
            "{}: a pair file that links a head to this body is required; only --body demo and the open \
             body need none",
            self.body.display()
        ))
    }
}

fn demo() -> anyhow::Result<PairFile> {
    let figure = Figure::new();
    let ids: Vec<i64> = figure.vertex_map.iter().map(|&id| i64::from(id)).collect();
    let pair = Pair::by_vertex_map(figure.head, figure.body, &ids)?;
    Ok(PairFile {
        pair: pair.into(),
        source_name: "the demo's head".to_owned(),
        target_name: "the demo's body".to_owned(),
        note: String::new(),
    })
}

/// The pair of a model whose head has a layout of its own, as the open body's; `None` for others.
fn of_model(path: &Path) -> anyhow::Result<Option<PairFile>> {
    let head = match model_mesh::read_head(path) {
        Ok(head) => head,
        Err(error @ ReadError::Io { .. }) => return Err(error).or_bad_input(),
        Err(_) => return Ok(None),
    };
    let arrays = arrays::read(path).or_bad_input()?;
    let refused = |error: &dyn std::fmt::Display| bad_input(format!("{}: {error}", path.display()));
    let body = model_mesh::from_arrays(&arrays).map_err(|error| refused(&error))?;
    let vertices = model_mesh::head_vertices(&arrays).map_err(|error| refused(&error))?;
    let ids: Vec<i64> = vertices.into_iter().map(i64::from).collect();
    let pair = Pair::by_vertex_map(head, body, &ids).map_err(|error| refused(&error))?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    Ok(Some(PairFile {
        pair: pair.into(),
        source_name: format!("the head of {name}"),
        target_name: name.into_owned(),
        note: String::new(),
    }))
}
