//! The pair that links the head to the body: a file, or for bodies that contain a head of their own,
//! none.

use std::path::Path;

use uvgraft::Pair;
use uvgraft_figure::Figure;
use uvgraft_io::pair_file::{self, PairFile};

use super::Args;
use crate::failure::{OrBadInput, bad_input};

impl Args {
    /// Reads the pair, or makes that of the body.
    pub(super) fn read_pair(&self) -> anyhow::Result<PairFile> {
        match &self.pair {
            Some(path) => pair_file::read(path).or_bad_input(),
            None if self.is_figure() => demo(),
            None => Err(self.pair_is_missing()),
        }
    }

    /// What to call the pair in messages.
    pub(super) fn pair_name(&self) -> String {
        match &self.pair {
            Some(path) => path.display().to_string(),
            None => "the demo's pair".to_owned(),
        }
    }

    /// Whether the body is the built-in figure.
    pub(super) fn is_figure(&self) -> bool {
        self.body == Path::new("demo")
    }

    pub(super) fn pair_is_missing(&self) -> anyhow::Error {
        bad_input(format!(
            "{}: a pair file that links a head to this body is required; only --body demo needs none",
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
