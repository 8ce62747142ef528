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
    /// Resample a source that must stay as it is, and is copied, into the base
    Apply,
    /// Decode the PNG files of source and base
    Decode,
    /// Encode the result as PNG
    Encode,
    /// Run `uvgraft transfer` from file to file, in this process
    File,
    /// Resample on a graphics processor, where all textures are and stay
    #[cfg(feature = "gpu")]
    #[value(skip)]
    Gpu,
    /// The same with the way to the graphics processor and back
    #[cfg(feature = "gpu")]
    #[value(skip)]
    GpuCarry,
}

impl StageKind {
    /// All stages in the order of a transfer, the complete transfer last.
    pub(crate) const ALL: [Self; 8] = [
        Self::ReadPair,
        Self::Map,
        Self::Padding,
        Self::Decode,
        Self::Resample,
        Self::Apply,
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

/// One measured stage.
pub(super) struct Stage<'a> {
    pub(super) kind: StageKind,
    /// Distinguishes stages of one kind: the filter, or the input image.
    pub(super) variant: Option<Variant>,
    /// Number of texels for the throughput.
    pub(super) texels: Option<usize>,
    /// Bytes of texels and files to be read or written.
    pub(super) moved_bytes: Option<usize>,
    /// Runs the stage once and returns the seconds it took, without preparation.
    pub(super) work: Box<dyn FnMut() -> anyhow::Result<f64> + 'a>,
}

/// The variant of a stage.
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
    /// Label for tables.
    pub(super) fn title(self) -> String {
        match self {
            Self::Filter(filter) => filter.to_string(),
            Self::Image(InputImage::Source) => "source".to_owned(),
            Self::Image(InputImage::Base) => "base".to_owned(),
        }
    }
}
