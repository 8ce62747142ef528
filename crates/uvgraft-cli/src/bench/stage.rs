//! Stages of a transfer.

use serde::Serialize;
use uvgraft::{Choice, Filter, choices};

/// A stage of a transfer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum StageKind {
    ReadPair,
    Map,
    Padding,
    Resample,
    Apply,
    Decode,
    Encode,
    File,
}

choices!(StageKind {
    ReadPair => "read-pair", "Read and validate the pair file";
    Map => "map", "Build the sampling map";
    Padding => "padding", "Prepare the padding of the source around its UV islands";
    Resample => "resample", "Resample the source into the base, padding included";
    Apply => "apply", "Resample a source that must stay as it is, and is copied, into the base";
    Decode => "decode", "Decode the PNG files of source and base";
    Encode => "encode", "Encode the result as PNG";
    File => "file", "Run `uvgraft transfer` from file to file, in this process";
});

impl StageKind {
    /// Whether it depends on the interpolation filter.
    pub(super) fn is_filtered(self) -> bool {
        !matches!(self, Self::ReadPair | Self::Map | Self::Decode | Self::Encode)
    }

    /// All stages in the order of a transfer, the complete transfer last.
    pub(crate) const IN_ORDER: [Self; 8] = [
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

/// What is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Measured {
    Stage(StageKind),
    /// Resampling on a graphics processor, where all textures are and stay.
    #[cfg(feature = "gpu")]
    Gpu,
    /// The same with the way to the graphics processor and back.
    #[cfg(feature = "gpu")]
    GpuRoundTrip,
}

impl Measured {
    /// Its name in JSON.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Stage(kind) => kind.name(),
            #[cfg(feature = "gpu")]
            Self::Gpu => "gpu",
            #[cfg(feature = "gpu")]
            Self::GpuRoundTrip => "gpu-carry",
        }
    }

    /// Its label for tables.
    pub(super) fn title(self) -> &'static str {
        match self {
            Self::Stage(StageKind::ReadPair) => "read pair",
            Self::Stage(StageKind::Map) => "build map",
            Self::Stage(StageKind::Padding) => "prepare padding",
            Self::Stage(StageKind::Resample) => "resample",
            Self::Stage(StageKind::Apply) => "resample a copy",
            Self::Stage(StageKind::Decode) => "decode PNG",
            Self::Stage(StageKind::Encode) => "encode PNG",
            Self::Stage(StageKind::File) => "file to file",
            #[cfg(feature = "gpu")]
            Self::Gpu => "resample on the GPU",
            #[cfg(feature = "gpu")]
            Self::GpuRoundTrip => "to the GPU and back",
        }
    }
}

impl Serialize for Measured {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(self.name())
    }
}

/// One measured stage.
pub(super) struct Stage<'a> {
    pub(super) measured: Measured,
    /// Distinguishes those of one kind: the filter, or the input image.
    pub(super) variant: Option<Variant>,
    /// Number of texels for the throughput.
    pub(super) texels: Option<usize>,
    /// Bytes of texels and files to be read or written.
    pub(super) moved_bytes: Option<usize>,
    /// Runs the stage once and returns the seconds it took, without preparation.
    pub(super) work: Box<dyn FnMut() -> anyhow::Result<f64> + 'a>,
}

/// The variant of a stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Variant {
    Filter(Filter),
    Image(InputImage),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum InputImage {
    Source,
    Base,
}

impl Variant {
    /// Its name in tables and in JSON.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Filter(filter) => filter.name(),
            Self::Image(InputImage::Source) => "source",
            Self::Image(InputImage::Base) => "base",
        }
    }
}

impl Serialize for Variant {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(self.name())
    }
}
