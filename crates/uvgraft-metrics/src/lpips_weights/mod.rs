//! Weights files of LPIPS (`lpips.safetensors`): both networks, in a safetensors container.
//!
//! - The header's `__metadata__` MUST hold the key `uvgraft-lpips` with a JSON object as its text:
//!   `version`, `source`, the SHA-256 of what the weights were imported from, and `checksum`, that
//!   of everything after the container's header.
//! - For each network, `alex` and `vgg`, there MUST be the tensors `NETWORK.conv1.kernel`
//!   (f32, HWIO: height, width, inputs, outputs), `NETWORK.conv1.bias` (f32, `[outputs]`)
//!   and so on for each convolution, and `NETWORK.linear1` (f32, `[channels]`) to
//!   `NETWORK.linear5`. Every value MUST be finite.
//! - Other tensors and keys MAY be present; readers of this version ignore them.

pub mod sdist;

use std::collections::HashMap;
use std::io::{self, Write as _};
use std::path::Path;

use crate::lpips::{ConvolutionWeights, LpipsNetwork, LpipsWeights, LpipsWeightsError};
use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use serde::{Deserialize, Serialize};

use uvgraft_files::checksum::sha256;
use uvgraft_files::input::{Input, ReadError};
use uvgraft_files::output::write_atomically;

/// The newest version of the format, which is the one that is written.
pub const VERSION: u32 = 1;

/// Files larger than this are refused; both networks take 69 MB.
pub const MAX_BYTES: u64 = 128 << 20;

const METADATA_KEY: &str = "uvgraft-lpips";

/// The weights of both networks.
#[derive(Debug, Clone, PartialEq)]
pub struct BothNetworks {
    /// AlexNet's.
    pub alex: LpipsWeights,
    /// VGG16's.
    pub vgg: LpipsWeights,
}

/// Why a weights file was rejected.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WeightsFileError {
    /// Another kind of file.
    #[error(
        "not a file of LPIPS weights: must be a safetensors file with `{METADATA_KEY}` in its \
         metadata"
    )]
    Foreign,
    /// Written by a later version of this program.
    #[error("LPIPS weights must be of version {VERSION} or older, got {found}; update uvgraft")]
    Version {
        /// The version that the file states.
        found: u32,
    },
    /// The container is malformed.
    #[error("truncated or damaged LPIPS weights: {0}")]
    Container(String),
    /// The content changed after it was written.
    #[error("damaged LPIPS weights: SHA-256 must be {stated} as the file states, got {found}")]
    Checksum {
        /// Computed from the values.
        found: String,
        /// Stated in the file.
        stated: String,
    },
    /// A tensor is missing or has the wrong type or shape.
    #[error("damaged LPIPS weights: tensor `{name}` {problem}")]
    Tensor {
        /// Which one.
        name: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The values do not fit the network.
    #[error("damaged LPIPS weights: {0}")]
    Values(#[from] LpipsWeightsError),
}

#[derive(Serialize, Deserialize)]
struct Header {
    version: u32,
    source: String,
    checksum: String,
}

/// Only the version, so that a later format can change everything else.
#[derive(Deserialize)]
struct VersionOnly {
    version: u32,
}

/// The bytes of a weights file; the same for the same weights.
///
/// # Errors
/// [`WeightsFileError::Container`] if the container's writer refuses.
pub fn encode(both: &BothNetworks) -> Result<Vec<u8>, WeightsFileError> {
    let mut tensors = Vec::new();
    for weights in [&both.alex, &both.vgg] {
        let network = weights.network();
        let mut add = |name: String, shape: Vec<usize>, values: &[f32]| {
            let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
            tensors.push((name, shape, bytes));
        };
        let convolutions = weights.convolutions().iter().zip(network.kernel_shapes());
        for (index, (convolution, shape)) in convolutions.enumerate() {
            add(kernel_name(network, index), shape.to_vec(), &convolution.kernel);
            add(bias_name(network, index), vec![shape[3]], &convolution.bias);
        }
        for (index, values) in weights.linear().iter().enumerate() {
            add(linear_name(network, index), vec![values.len()], values);
        }
    }
    let views = tensors
        .iter()
        .map(|(name, shape, bytes)| {
            Ok((name.as_str(), TensorView::new(Dtype::F32, shape.clone(), bytes)?))
        })
        .collect::<Result<Vec<_>, safetensors::SafeTensorError>>()
        .map_err(|error| container(&error))?;
    // The checksum does not cover the header, so it can be computed first.
    let plain = safetensors::serialize(views.clone(), None).map_err(|error| container(&error))?;
    let (source, checksum) = (sdist::SHA256.to_owned(), checksum(&plain));
    let header = Header { version: VERSION, source, checksum };
    let header = serde_json::to_string(&header).map_err(|error| container(&error))?;
    let metadata = HashMap::from([(METADATA_KEY.to_owned(), header)]);
    safetensors::serialize(views, Some(metadata)).map_err(|error| container(&error))
}

/// The SHA-256 of everything after a container's header, whose length comes first.
fn checksum(container: &[u8]) -> String {
    let length = container.first_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes));
    let start = usize::try_from(length).ok().and_then(|length| length.checked_add(8));
    sha256(start.and_then(|start| container.get(start..)).unwrap_or_default())
}

/// One network's weights from the bytes of a weights file.
///
/// # Errors
/// [`WeightsFileError`]
pub fn decode(bytes: &[u8], network: LpipsNetwork) -> Result<LpipsWeights, WeightsFileError> {
    // A safetensors file starts with the length of its header, and the header with a brace.
    if bytes.get(8) != Some(&b'{') {
        return Err(WeightsFileError::Foreign);
    }
    let tensors = SafeTensors::deserialize(bytes).map_err(|error| container(&error))?;
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(|error| container(&error))?;
    let header = metadata.metadata().as_ref().and_then(|metadata| metadata.get(METADATA_KEY));
    let header = header.ok_or(WeightsFileError::Foreign)?;
    let VersionOnly { version } =
        serde_json::from_str(header).map_err(|error| container(&error))?;
    if version > VERSION {
        return Err(WeightsFileError::Version { found: version });
    }
    let header: Header = serde_json::from_str(header).map_err(|error| container(&error))?;
    let found = checksum(bytes);
    if found != header.checksum {
        return Err(WeightsFileError::Checksum { found, stated: header.checksum });
    }
    let convolutions = network
        .kernel_shapes()
        .into_iter()
        .enumerate()
        .map(|(index, shape)| {
            Ok(ConvolutionWeights {
                kernel: f32s(&tensors, &kernel_name(network, index), &shape)?,
                bias: f32s(&tensors, &bias_name(network, index), &shape[3..])?,
            })
        })
        .collect::<Result<_, WeightsFileError>>()?;
    let linear = network
        .compared_channels()
        .into_iter()
        .enumerate()
        .map(|(index, channels)| f32s(&tensors, &linear_name(network, index), &[channels]))
        .collect::<Result<_, _>>()?;
    Ok(LpipsWeights::new(network, convolutions, linear)?)
}

/// Reads one network's weights.
///
/// # Errors
/// [`ReadError`] with the path and what is wrong.
pub fn read(
    input: impl Into<Input>,
    network: LpipsNetwork,
) -> Result<LpipsWeights, ReadError<WeightsFileError>> {
    input.into().parse(MAX_BYTES, |bytes| decode(bytes, network))
}

/// Writes a weights file; after a crash, an existing file is unchanged.
///
/// # Errors
/// Those of encoding or writing.
pub fn write(both: &BothNetworks, path: impl AsRef<Path>) -> io::Result<()> {
    let bytes = encode(both).map_err(io::Error::other)?;
    write_atomically(path.as_ref(), |out| out.write_all(&bytes))
}

fn kernel_name(network: LpipsNetwork, index: usize) -> String {
    format!("{network}.conv{}.kernel", index + 1)
}

fn bias_name(network: LpipsNetwork, index: usize) -> String {
    format!("{network}.conv{}.bias", index + 1)
}

fn linear_name(network: LpipsNetwork, index: usize) -> String {
    format!("{network}.linear{}", index + 1)
}

fn f32s(
    tensors: &SafeTensors<'_>,
    name: &str,
    shape: &[usize],
) -> Result<Vec<f32>, WeightsFileError> {
    let bad = |problem: String| WeightsFileError::Tensor { name: name.to_owned(), problem };
    let view = tensors.tensor(name).map_err(|_| bad("is missing".to_owned()))?;
    if view.dtype() != Dtype::F32 || view.shape() != shape {
        let (found, found_shape) = (view.dtype(), view.shape());
        return Err(bad(format!("must be F32 {shape:?}, got {found:?} {found_shape:?}")));
    }
    Ok(view.data().as_chunks::<4>().0.iter().map(|&word| f32::from_le_bytes(word)).collect())
}

fn container(error: &dyn std::error::Error) -> WeightsFileError {
    WeightsFileError::Container(error.to_string())
}

#[cfg(test)]
mod tests;
