//! Reads maps that this program, the reference implementation or a compositor wrote.

use uvgraft::{SamplingMap, Size, Texture};

use super::{Convention, MapFileError};
use crate::arrays::{self, NamedArrays, NumericArray};
use crate::numpy;
use uvgraft_files::input::{Input, ReadError};
use uvgraft_image as image;

/// Larger files are rejected by [`read`] before they are loaded: enough for an uncompressed image of
/// the largest size.
pub const MAX_FILE_BYTES: u64 = image::MAX_BYTES + (1 << 26);

/// Reads a map. The format is detected from the content:
/// - NPY: `[height, width, 2]` floats, as [`write_npy`](super::write_npy) writes them. Texels with a
///   NaN are not covered.
/// - NPZ of the reference implementation: `uv_grid`, `[1, height, width, 2]` or without the first
///   axis, and `pix_to_face`, `[height, width]`, which is negative at texels that are not covered.
///   Positions follow the convention stated in the file, else [`Convention::Reference`].
/// - EXR: an ST map, with the position from the bottom left corner in R and G. With an alpha
///   channel, texels are covered where it is at least ½, and colours are divided by it; else
///   everywhere.
///
/// # Errors
/// [`MapFileError`]; among others for infinite positions and those beyond
/// [`SamplingMap::MAX_UV`], for more values than [`arrays::MAX_NUMBERS`], and if nothing is covered.
pub fn parse(bytes: &[u8]) -> Result<SamplingMap, MapFileError> {
    let (size, positions) = match bytes {
        _ if bytes.starts_with(numpy::MAGIC) => of_array(&arrays::parse_npy(bytes)?)?,
        [b'P', b'K', ..] => of_reference(&arrays::parse(bytes)?)?,
        #[cfg(feature = "exr")]
        _ if image::Format::detect(bytes) == Some(image::Format::EXR) => {
            // Positions are no colours.
            of_st_map(image::decode_with(bytes, image::DeclaredSpace::Ignored)?.texture)?
        }
        _ => {
            let start = bytes[..bytes.len().min(8)].to_vec();
            return Err(MapFileError::Foreign { start });
        }
    };
    Ok(SamplingMap::from_positions(size, &positions)?)
}

/// Reads a map from a file, regardless of its extension; see [`parse`].
///
/// # Errors
/// [`ReadError`] if the file cannot be read, is larger than [`MAX_FILE_BYTES`], or is rejected by
/// [`parse`]. Each names the file.
pub fn read(input: impl Into<Input>) -> Result<SamplingMap, ReadError<MapFileError>> {
    input.into().parse(MAX_FILE_BYTES, parse)
}

type Positions = (Size, Vec<[f32; 2]>);

fn of_array(array: &NumericArray) -> Result<Positions, MapFileError> {
    let size = grid_size("the array", array)?;
    Ok((size, array.f32s().as_chunks::<2>().0.to_vec()))
}

/// The size of a grid of shape `[height, width, 2]`, with or without a leading axis of length 1.
fn grid_size(name: &'static str, array: &NumericArray) -> Result<Size, MapFileError> {
    let wrong = || MapFileError::Shape {
        name,
        wanted: format!("(height, width, 2) with sides up to {}", Texture::MAX_SIDE),
        found: array.shape().to_vec(),
    };
    match *array.shape() {
        [height, width, 2] | [1, height, width, 2] => size_of_grid(width, height).ok_or_else(wrong),
        _ => Err(wrong()),
    }
}

fn size_of_grid(width: usize, height: usize) -> Option<Size> {
    let is_side = |side: usize| (1..=Texture::MAX_SIDE as usize).contains(&side);
    (is_side(width) && is_side(height)).then(|| Size::new(width as u32, height as u32))
}

fn of_reference(arrays: &NamedArrays) -> Result<Positions, MapFileError> {
    if arrays.get("uv_grid").is_none() && arrays.get("indptr").is_some() {
        return Err(MapFileError::Matrix);
    }
    let grid = arrays.require("uv_grid")?;
    let size = grid_size("uv_grid", grid)?;
    let faces = arrays.require("pix_to_face")?;
    let [height, width] = [size.height, size.width].map(|side| side as usize);
    if *faces.shape() != [height, width] && *faces.shape() != [1, height, width] {
        let (wanted, found) = (format!("({height}, {width})"), faces.shape().to_vec());
        return Err(MapFileError::Shape { name: "pix_to_face", wanted, found });
    }
    let convention = convention(arrays)?;
    let (grid, faces) = (grid.f32s(), faces.f32s());
    let positions = grid.as_chunks::<2>().0.iter().zip(faces.iter()).map(|(&grid, &face)| {
        if face >= 0.0 {
            convention.uv_from_grid(grid.map(f64::from)).map(|value| value as f32)
        } else {
            [f32::NAN; 2]
        }
    });
    Ok((size, positions.collect()))
}

fn convention(arrays: &NamedArrays) -> Result<Convention, MapFileError> {
    match arrays.text("convention") {
        None | Some("reference") => Ok(Convention::Reference),
        Some("exact") => {
            let sides = arrays.get("source_size").and_then(NumericArray::integers);
            let sides = sides.unwrap_or_default();
            let &[width, height] = &sides[..] else { return Err(MapFileError::SourceSize) };
            let side = |side: i64| usize::try_from(side).unwrap_or(0);
            let size = size_of_grid(side(width), side(height)).ok_or(MapFileError::SourceSize)?;
            Ok(Convention::Exact(size))
        }
        Some(other) => Err(MapFileError::Convention { found: other.chars().take(32).collect() }),
    }
}

#[cfg(feature = "exr")]
fn of_st_map(texture: Texture) -> Result<Positions, MapFileError> {
    let (size, channels) = (texture.size(), texture.channels());
    let uvgraft::Texels::F32(values) = texture.into_texels() else {
        return Err(MapFileError::Channels);
    };
    if !channels.has_color() {
        return Err(MapFileError::Channels);
    }
    let mut most = 0.0_f32;
    let positions: Vec<[f32; 2]> = values
        .chunks_exact(channels.count())
        .map(|texel| {
            let alpha = if channels.has_alpha() { texel[3] } else { 1.0 };
            most = most.max(alpha);
            if alpha >= 0.5 { [texel[0], 1.0 - texel[1]] } else { [f32::NAN; 2] }
        })
        .collect();
    if most < 0.5 {
        return Err(MapFileError::Transparent { found: most });
    }
    Ok((size, positions))
}

#[cfg(test)]
#[cfg(feature = "exr")]
mod tests {
    use std::io::Cursor;

    use uvgraft::{Direction, MapOptions, Mesh, Pair};

    use super::*;
    use crate::arrays::write_npz as write_arrays;
    use crate::sampling_map::{write_npy, write_npz, write_st_map};

    const SIZE: Size = Size::new(21, 13);

    /// Two turned triangles of one quad; a part of the target stays empty.
    fn map() -> SamplingMap {
        let source = vec![[0.9, 0.1], [0.8, 0.9], [0.1, 0.7], [0.2, 0.2]];
        let target = vec![[0.1, 0.1], [0.8, 0.2], [0.7, 0.9], [0.2, 0.6]];
        let faces = [[0, 1, 2], [0, 2, 3]];
        let mesh = |uv| Mesh::from_triangles(vec![[0.0; 3]; 4], uv, &faces, &faces).unwrap();
        let pair = Pair::by_vertex_map(mesh(source), mesh(target), &[0, 1, 2, 3]).unwrap();
        SamplingMap::new(&pair, Direction::Forward, SIZE, &MapOptions::with_gutter(1))
    }

    fn positions(map: &SamplingMap) -> Vec<[f64; 2]> {
        let mut positions = vec![[f64::NAN; 2]; map.size().texels()];
        for row in 0..map.size().height {
            let first = (row * map.size().width) as usize;
            crate::sampling_map::for_each_texel(map, row, |x, uv, _| positions[first + x] = uv);
        }
        positions
    }

    /// The map in each format.
    fn files() -> Vec<Vec<u8>> {
        let map = map();
        let mut npy = Vec::new();
        write_npy(&map, &mut npy).unwrap();
        let npz =
            [Convention::Reference, Convention::Exact(Size::new(300, 70))].map(|convention| {
                let mut npz = Cursor::new(Vec::new());
                write_npz(&map, convention, &mut npz).unwrap();
                npz.into_inner()
            });
        let mut exr = Cursor::new(Vec::new());
        write_st_map(&map, &mut exr).unwrap();
        let [reference, exact] = npz;
        vec![npy, reference, exact, exr.into_inner()]
    }

    #[test]
    fn every_format_comes_back() {
        let wanted = positions(&map());
        for (format, file) in files().iter().enumerate() {
            let found = parse(file).unwrap();
            assert_eq!(found.size(), SIZE);
            for (wanted, found) in wanted.iter().zip(positions(&found)) {
                assert_eq!(wanted[0].is_nan(), found[0].is_nan(), "{format}");
                let is_near = (0..2).all(|k| (wanted[k] - found[k]).abs() < 3e-7);
                assert!(is_near || wanted[0].is_nan(), "{format}: {wanted:?} {found:?}");
            }
        }
    }

    #[test]
    fn an_st_map_by_hand() {
        // The identity of 2x1 texels from the bottom left, the second half transparent.
        let values = vec![0.25, 0.5, 0.0, 1.0, 0.75, 0.5, 0.0, 0.4];
        let (channels, encoding) = (uvgraft::Channels::Rgba, uvgraft::Encoding::Linear);
        let texture =
            Texture::new(Size::new(2, 1), channels, encoding, uvgraft::Texels::F32(values));
        let mut exr = Cursor::new(Vec::new());
        let options = image::WriteOptions::default();
        let _ = image::encode(&texture.unwrap().into(), image::Format::EXR, &options, &mut exr)
            .unwrap();
        let map = parse(exr.get_ref()).unwrap();
        assert_eq!(map.stats().linked, 1);
        assert_eq!(positions(&map)[0], [0.25, 0.5]);
    }

    #[test]
    fn what_is_refused() {
        let floats = |shape: &[usize], value: f32| {
            let count = shape.iter().product();
            NumericArray::new_f32(shape.to_vec(), vec![value; count]).unwrap()
        };
        let npz = |arrays: &[(&str, NumericArray)], convention: &str| {
            let mut named = NamedArrays::new();
            arrays.iter().for_each(|(name, array)| named.insert(*name, array.clone()));
            named.insert_text("convention", convention);
            let mut bytes = Cursor::new(Vec::new());
            write_arrays(&named, &mut bytes).unwrap();
            parse(bytes.get_ref()).map(|_| ()).unwrap_err().to_string()
        };
        let grid = ("uv_grid", floats(&[1, 2, 3, 2], 0.0));
        let faces = ("pix_to_face", floats(&[2, 3], 0.0));
        let cases = [
            (npz(std::slice::from_ref(&grid), "reference"), "no array `pix_to_face`"),
            (
                npz(&[grid.clone(), ("pix_to_face", floats(&[3, 2], 0.0))], "reference"),
                "pix_to_face must have the shape (2, 3), got [3, 2]",
            ),
            (npz(&[("uv_grid", floats(&[2, 2, 3, 2], 0.0)), faces.clone()], "reference"), "shape"),
            (npz(&[("uv_grid", floats(&[2, 3, 3], 0.0)), faces.clone()], "reference"), "shape"),
            (npz(&[("uv_grid", floats(&[0, 3, 2], 0.0)), faces.clone()], "reference"), "sides"),
            (npz(&[grid.clone(), faces.clone()], "other"), "must be reference or exact, got"),
            (npz(&[grid.clone(), faces.clone()], "exact"), "source_size must be"),
            (
                npz(&[grid.clone(), ("pix_to_face", floats(&[2, 3], -1.0))], "reference"),
                "at least one texel",
            ),
            (
                npz(&[("uv_grid", floats(&[2, 3, 2], f32::INFINITY)), faces], "reference"),
                "the position of texel (0, 0) must be NaN or lie between",
            ),
            (npz(&[("indptr", floats(&[3], 0.0))], "reference"), "got a sparse matrix"),
            (parse(b"v 0 0 0\n").map(|_| ()).unwrap_err().to_string(), "starts with \"v 0 0"),
            (parse(b"").map(|_| ()).unwrap_err().to_string(), "the file is empty"),
        ];
        for (found, wanted) in cases {
            assert!(found.contains(wanted), "{found}\nwanted: {wanted}");
        }
        let long =
            b"\x93NUMPY\x01\0v\0{'descr': '<f4', 'fortran_order': False, 'shape': (9999999, \
            9999999, 2), }                            \n";
        let why = parse(long).map(|_| ()).unwrap_err().to_string();
        assert!(why.contains("bytes"), "{why}");
    }

    #[test]
    fn no_bytes_make_it_panic() {
        let files = files();
        let mut random = fastrand::Rng::with_seed(6);
        let mut accepted = [0; 4];
        for round in 0..8_000 {
            let mut bytes = files[round % 4].clone();
            for _ in 0..random.usize(1..3) {
                let at = random.usize(0..bytes.len());
                match random.u32(0..8) {
                    0 => bytes.truncate(at.max(1)),
                    1 => drop(bytes.drain(at..bytes.len().min(at + 4))),
                    // Headers are short; values are long.
                    2..5 => {
                        let at = at % bytes.len().min(300);
                        bytes[at] = random.u8(..);
                    }
                    _ => bytes[at] = random.u8(..),
                }
            }
            accepted[round % 4] += usize::from(parse(&bytes).is_ok());
        }
        // Archives and compressed images have checksums.
        assert!((100..1_900).contains(&accepted[0]), "{accepted:?}");
    }
}
