//! ST maps: images whose red and green channels are source positions, as compositors use them.
//!
//! Nuke's STMap, Blender's Map UV and Fusion's Texture count from the bottom left corner: (0, 0) and
//! (1, 1) are the corners of the source, so that an image of coordinates is the identity if each
//! texel has those of its own centre, ((x + ½) / width, (y + ½) / height). Blender takes the blue
//! channel for opacity, as render engines write it in UV passes; the others ignore it.

use std::io::{Seek, Write};
use std::path::Path;

use uvgraft::{Channels, Depth, Encoding, SamplingMap, Size, Texels, Texture};

use super::for_each_texel;
use uvgraft_files::output::write_atomically;
use uvgraft_image::{BandEncoder, EncodeError, Format, TextureSpec, WriteOptions};

/// Writes a map as an ST map: an OpenEXR image of 32-bit floats with ZIP compression.
///
/// R = u and G = 1 − v are the source position of the centre of each texel, from the bottom left
/// corner of the source; B and A are 1 at covered texels. Elsewhere all four are 0.
///
/// Only a few rows are held in memory.
///
/// # Errors
/// [`EncodeError`], in practice that of `out`.
pub fn write_st_map(map: &SamplingMap, out: &mut (impl Write + Seek)) -> Result<(), EncodeError> {
    let Size { width, height } = map.size();
    let (channels, depth, encoding) = (Channels::Rgba, Depth::F32, Encoding::Data);
    let spec = TextureSpec { size: map.size(), channels, depth, encoding };
    let options = WriteOptions::default().compress(true);
    let mut encoder = BandEncoder::new(out, Format::EXR, spec, None, &options)?;
    for row in 0..height {
        let mut values = vec![0.0; 4 * width as usize];
        for_each_texel(map, row, |x, [u, v], _| {
            values[4 * x..4 * x + 4].copy_from_slice(&[u as f32, (1.0 - v) as f32, 1.0, 1.0]);
        });
        let size = Size::new(width, 1);
        let row = Texture::new(size, channels, encoding, Texels::F32(values));
        encoder.push(&row.expect("four values a texel"))?;
    }
    encoder.finish().map(drop)
}

/// Writes a map to an EXR file atomically; see [`write_st_map`].
///
/// # Errors
/// Those of creating, writing and renaming the file; an existing file is then unchanged.
pub fn save_st_map(map: &SamplingMap, path: impl AsRef<Path>) -> Result<(), EncodeError> {
    write_atomically(path.as_ref(), |out| write_st_map(map, out))
}
