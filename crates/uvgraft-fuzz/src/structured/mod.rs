//! Files built by structure: valid ones in which a few numbers are stretched.
//!
//! Mutated bytes rarely get past the first check of a reader, or ask for much. So generators build
//! whole files, whose lengths and checksums are right, and choose what is stretched: a count, a side,
//! an offset, how often an element is repeated, how long a string is. All choices come from bytes, by
//! the crate `arbitrary`, so that a seeded generator and a fuzzer make them alike.
//!
//! The readers of these files may take no more memory than the file's size, or the sizes of images and
//! arrays that it declares, allow for (`reading.rs`).

pub(crate) mod draco;
pub(crate) mod exr;
mod gltf;
pub(crate) mod jpeg;
mod json;
pub(crate) mod ktx2;
pub(crate) mod npy;
pub(crate) mod npz;
mod number;
pub(crate) mod pickle;
pub(crate) mod png;
mod reading;
pub(crate) mod scene;
pub(crate) mod tflite;
pub(crate) mod tiff;
pub(crate) mod torch;
pub(crate) mod vrm0;
pub(crate) mod vrm1;
pub(crate) mod vrma;
pub(crate) mod webp;

use arbitrary::{Arbitrary, Unstructured};

/// Files grow to about this many bytes.
const MAX_BYTES: usize = 1 << 20;

/// Makes choices of bytes; those for which there are no bytes left are the first ones.
fn choose<'a, T: Arbitrary<'a>>(bytes: &'a [u8]) -> Option<T> {
    Unstructured::new(bytes).arbitrary().ok()
}

/// Bytes that make choices, for a start.
pub(crate) fn choices() -> Vec<Vec<u8>> {
    let mut random = fastrand::Rng::with_seed(11);
    (0..64).map(|_| random_choices(&mut random)).collect()
}

/// Bytes that make choices.
pub fn random_choices(random: &mut fastrand::Rng) -> Vec<u8> {
    let count = random.usize(24..160);
    (0..count).map(|_| random.u8(..)).collect()
}

#[cfg(test)]
mod tests {
    use uvgraft_gltf::scene::Scene;
    use uvgraft_image as image;
    use uvgraft_io::{arrays, torch as tensors};
    use uvgraft_selfie::tflite as models;

    use super::*;
    use crate::Builder;

    type Reader = fn(&[u8]) -> bool;

    /// Files that are all refused at the first check would test nothing.
    #[test]
    fn many_files_are_read() {
        let is_scene: Reader = |bytes| Scene::read(bytes).is_ok();
        let is_image: Reader = |bytes| image::decode(bytes).is_ok();
        let is_arrays: Reader = |bytes| arrays::parse(bytes).is_ok();
        let kinds: [(&str, Builder, Reader); 15] = [
            ("scene", scene::file, is_scene),
            ("vrm0", vrm0::file, is_scene),
            ("vrm1", vrm1::file, is_scene),
            ("vrma", vrma::file, is_scene),
            ("draco", draco::file, is_scene),
            ("npy", npy::file, |bytes| arrays::parse_npy(bytes).is_ok()),
            ("npz", npz::file, is_arrays),
            ("pickle", pickle::file, is_arrays),
            ("torch", torch::file, |bytes| tensors::parse(bytes).is_ok()),
            ("tflite", tflite::file, |bytes| models::parse(bytes).is_ok()),
            ("png", png::file, is_image),
            ("jpeg", jpeg::file, is_image),
            ("webp", webp::file, is_image),
            ("tiff", tiff::file, is_image),
            ("exr", exr::file, is_image),
        ];
        for (name, file, is_read) in kinds {
            let count = choices().iter().filter(|choices| is_read(&file(choices))).count();
            assert!(count >= 4, "{name}: {count} of 64 are read");
        }
    }
}
