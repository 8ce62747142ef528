//! Stages of a transfer.

use clap::ValueEnum;
use serde::Serialize;
use uvgraft::Filter;

/// A stage of a transfer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum StageKind {
    /// Read and validate the pair file
    ReadPair,
    /// Build the sampling map
    Map,
    /// Prepare the padding of the source around its UV islands
    Padding,
    /// Resample the source into the base, padding included
    Resample,
    /// Decode the PNG files of source and base
    Decode,
    /// Encode the result as PNG
    Encode,
    /// Run `uvgraft transfer` from file to file, in this process
    File,
}

impl StageKind {
    /// All, in the order in which a transfer meets them, the whole at the end.
    pub(crate) const ALL: [Self; 7] = [
        Self::ReadPair,
        Self::Map,
        Self::Padding,
        Self::Decode,
        Self::Resample,
        Self::Encode,
        Self::File,
    ];
}

impl std::fmt::Display for StageKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.to_possible_value() {
            Some(value) => f.write_str(value.get_name()),
            None => Ok(()),
        }
    }
}

/// One thing that is measured.
pub(super) struct Stage<'a> {
    pub(super) kind: StageKind,
    /// What tells it from others of its kind: the filter, or which file.
    pub(super) variant: Option<Variant>,
    /// What its speed is counted in.
    pub(super) texels: Option<usize>,
    /// Bytes of texels and files that have to be read or written.
    pub(super) moved_bytes: Option<usize>,
    /// Does it once; gives the seconds it took, whatever it prepared before not counted.
    pub(super) work: Box<dyn FnMut() -> anyhow::Result<f64> + 'a>,
}

/// What a stage is done with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub(super) enum Variant {
    Filter(Filter),
    Image(InputImage),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum InputImage {
    Source,
    Base,
}

impl Variant {
    /// For tables.
    pub(super) fn title(self) -> String {
        match self {
            Self::Filter(filter) => filter.to_string(),
            Self::Image(InputImage::Source) => "source".to_owned(),
            Self::Image(InputImage::Base) => "base".to_owned(),
        }
    }
}
