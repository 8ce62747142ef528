//! Writes TIFFs of kinds that uvgraft does not write.

#![expect(clippy::unwrap_used, reason = "a test stops at what should not fail")]

use std::io::{Cursor, Write};

use flate2::Compression;
use flate2::write::ZlibEncoder;
use uvgraft::color::Encoding;
use uvgraft::texture::{Channels, Size, Texels, Texture};
use uvgraft_image::{Format, Image, ImageError, WriteOptions, decode, decode_header, encode};
use weezl::BitOrder;

pub(crate) const IMAGE_WIDTH: u16 = 256;
pub(crate) const IMAGE_LENGTH: u16 = 257;
pub(crate) const BITS: u16 = 258;
pub(crate) const COMPRESSION: u16 = 259;
pub(crate) const PHOTOMETRIC: u16 = 262;
pub(crate) const FILL_ORDER: u16 = 266;
pub(crate) const STRIP_OFFSETS: u16 = 273;
pub(crate) const ORIENTATION: u16 = 274;
pub(crate) const SAMPLES: u16 = 277;
pub(crate) const ROWS_PER_STRIP: u16 = 278;
pub(crate) const STRIP_BYTE_COUNTS: u16 = 279;
pub(crate) const PLANAR: u16 = 284;
pub(crate) const PREDICTOR: u16 = 317;
pub(crate) const COLOR_MAP: u16 = 320;
pub(crate) const TILE_WIDTH: u16 = 322;
pub(crate) const TILE_LENGTH: u16 = 323;
pub(crate) const TILE_OFFSETS: u16 = 324;
pub(crate) const TILE_BYTE_COUNTS: u16 = 325;
pub(crate) const EXTRA: u16 = 338;
pub(crate) const SAMPLE_FORMAT: u16 = 339;
pub(crate) const JPEG_TABLES: u16 = 347;
pub(crate) const SUBSAMPLING: u16 = 530;

/// A TIFF with one directory, of tags with 16-bit or 32-bit numbers.
#[derive(Clone)]
pub(crate) struct Tiff {
    pub(crate) is_big_endian: bool,
    pub(crate) tags: Vec<(u16, Vec<u32>)>,
    pub(crate) chunks: Vec<Vec<u8>>,
    pub(crate) jpeg_tables: Vec<u8>,
}

impl Tiff {
    /// Grey or RGB of 8 bits in one strip, without compression.
    pub(crate) fn new(width: u32, height: u32, samples: u32, chunks: Vec<Vec<u8>>) -> Self {
        let tags = vec![
            (IMAGE_WIDTH, vec![width]),
            (IMAGE_LENGTH, vec![height]),
            (BITS, vec![8; samples as usize]),
            (COMPRESSION, vec![1]),
            (PHOTOMETRIC, vec![if samples < 3 { 1 } else { 2 }]),
            (SAMPLES, vec![samples]),
        ];
        Self { is_big_endian: false, tags, chunks, jpeg_tables: Vec::new() }
    }

    pub(crate) fn tag(mut self, tag: u16, values: impl Into<Vec<u32>>) -> Self {
        self.tags.retain(|&(other, _)| other != tag);
        self.tags.push((tag, values.into()));
        self
    }

    pub(crate) fn without(mut self, tag: u16) -> Self {
        self.tags.retain(|&(other, _)| other != tag);
        self
    }

    pub(crate) fn big_endian(self) -> Self {
        Self { is_big_endian: true, ..self }
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        let Self { is_big_endian, chunks, jpeg_tables, .. } = self;
        let order = |value: u32, bytes: usize| {
            if *is_big_endian {
                value.to_be_bytes()[4 - bytes..].to_vec()
            } else {
                value.to_le_bytes()[..bytes].to_vec()
            }
        };
        let mut file = if *is_big_endian { b"MM\0*".to_vec() } else { b"II*\0".to_vec() };
        file.extend([0; 4]);
        let mut places = Vec::new();
        for chunk in chunks {
            places.push(file.len() as u32);
            file.extend(chunk);
        }
        let counts = chunks.iter().map(|chunk| chunk.len() as u32).collect();
        let is_tiled = self.tags.iter().any(|&(tag, _)| tag == TILE_WIDTH);
        let [offsets_tag, counts_tag] = if is_tiled {
            [TILE_OFFSETS, TILE_BYTE_COUNTS]
        } else {
            [STRIP_OFFSETS, STRIP_BYTE_COUNTS]
        };
        let mut tags = self.tags.clone();
        tags.extend([(offsets_tag, places), (counts_tag, counts)]);
        tags.sort();
        let mut entries = Vec::new();
        for (tag, values) in &tags {
            let is_long = [offsets_tag, counts_tag, IMAGE_WIDTH].contains(tag);
            let (kind, each) = if is_long { (4, 4) } else { (3, 2) };
            let value: Vec<u8> = values.iter().flat_map(|&value| order(value, each)).collect();
            entries.push((*tag, kind, values.len(), value));
        }
        if !jpeg_tables.is_empty() {
            entries.push((JPEG_TABLES, 7, jpeg_tables.len(), jpeg_tables.clone()));
        }
        let mut directory = order(entries.len() as u32, 2);
        for (tag, kind, count, mut value) in entries {
            if value.len() > 4 {
                let at = file.len() as u32;
                file.extend(value);
                value = order(at, 4);
            }
            value.resize(4, 0);
            directory.extend(
                [order(tag.into(), 2), order(kind, 2), order(count as u32, 4), value].concat(),
            );
        }
        let at = file.len() as u32;
        file.extend([directory, vec![0; 4]].concat());
        file.splice(4..8, order(at, 4));
        file
    }

    pub(crate) fn read(&self) -> Texture {
        let bytes = self.bytes();
        let texture = decode(&bytes).unwrap().texture;
        let header = decode_header(&bytes).unwrap();
        assert_eq!(header.size, texture.size());
        assert_eq!((header.channels, header.depth), (texture.channels(), texture.depth()));
        texture
    }

    pub(crate) fn read_u8(&self) -> (Channels, Vec<u8>) {
        let texture = self.read();
        match texture.texels() {
            Texels::U8(values) => (texture.channels(), values.clone()),
            _ => panic!("{:?}", texture.depth()),
        }
    }

    /// The message of the error, which is the same for the header.
    pub(crate) fn refusal(&self) -> String {
        let bytes = self.bytes();
        let error = decode(&bytes).unwrap_err();
        assert!(matches!(error, ImageError::Unsupported { .. }), "{error}");
        assert_eq!(decode_header(&bytes).unwrap_err().to_string(), error.to_string());
        error.to_string()
    }
}

pub(crate) fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// RGB texels whose values are all different in a small image.
pub(crate) fn rgb(width: u32, height: u32) -> Vec<u8> {
    (0..width * height * 3).map(|at| (at * 7 % 251) as u8).collect()
}

/// The tiles of an image with `channels` values a texel, padded with 99, row by row.
pub(crate) fn tiles(
    values: &[u8],
    width: usize,
    channels: usize,
    side: [usize; 2],
) -> Vec<Vec<u8>> {
    let height = values.len() / width / channels;
    let tile = |left: usize, top: usize| {
        let texel = |x: usize, y: usize, channel: usize| {
            if x < width && y < height { values[(y * width + x) * channels + channel] } else { 99 }
        };
        let mut tile = Vec::new();
        for (y, x) in (0..side[1]).flat_map(|y| (0..side[0]).map(move |x| (y, x))) {
            tile.extend((0..channels).map(|channel| texel(left + x, top + y, channel)));
        }
        tile
    };
    let tops = (0..height).step_by(side[1]);
    tops.flat_map(|top| (0..width).step_by(side[0]).map(move |left| (left, top)))
        .map(|(left, top)| tile(left, top))
        .collect()
}

pub(crate) fn planes(values: &[u8], channels: usize) -> Vec<Vec<u8>> {
    let plane = |channel: usize| values.iter().skip(channel).step_by(channels).copied().collect();
    (0..channels).map(plane).collect()
}

/// A JPEG file of smooth colours, and its texels.
pub(crate) fn jpeg(size: Size, channels: Channels) -> (Vec<u8>, Vec<u8>) {
    let count = channels.count() as u32;
    let values: Vec<u8> = (0..size.width * size.height * count)
        .map(|at| {
            (at / count % size.width * 4 + at / count / size.width * 3 + at % count * 40) as u8
        })
        .collect();
    let texture = Texture::new(size, channels, Encoding::Srgb, Texels::U8(values.clone())).unwrap();
    let options = WriteOptions::default().jpeg_quality(98);
    let mut out = Cursor::new(Vec::new());
    let _ = encode(&Image::from(texture), Format::JPEG, &options, &mut out).unwrap();
    (out.into_inner(), values)
}

/// The segments of a JPEG that hold tables, as a file of their own, and the rest.
pub(crate) fn split_tables(jpeg: &[u8]) -> [Vec<u8>; 2] {
    let (mut tables, mut rest) = (jpeg[..2].to_vec(), jpeg[..2].to_vec());
    let mut at = 2;
    loop {
        let length = usize::from(u16::from_be_bytes([jpeg[at + 2], jpeg[at + 3]]));
        let segment = &jpeg[at..at + 2 + length];
        match segment[1] {
            0xdb | 0xc4 => tables.extend(segment),
            0xda => break,
            _ => rest.extend(segment),
        }
        at += segment.len();
    }
    rest.extend(&jpeg[at..]);
    tables.extend([0xff, 0xd9]);
    [tables, rest]
}

/// Small files of many kinds, with names that end with "tif".
pub(crate) fn kinds() -> Vec<(String, Vec<u8>)> {
    let values = rgb(21, 10);
    let tiled = |chunks| Tiff::new(21, 10, 3, chunks).tag(TILE_WIDTH, [16]).tag(TILE_LENGTH, [16]);
    let of_plane = |plane: &Vec<u8>| tiles(plane, 21, 1, [16, 16]);
    let planar: Vec<_> = planes(&values, 3).iter().flat_map(of_plane).collect();
    let packed = tiles(&values, 21, 3, [16, 16]).iter().map(|tile| deflated(tile)).collect();
    let [jpeg_tables, bare] = split_tables(&jpeg(Size::new(32, 16), Channels::Rgb).0);
    let jpeg = Tiff { jpeg_tables, ..Tiff::new(32, 16, 3, vec![bare]) };
    let blocks = (0..66).map(|at| at * 3).collect();
    let old = weezl::encode::Encoder::new(BitOrder::Lsb, 8).encode(&values).unwrap();
    let kinds = [
        ("planar tiles", tiled(planar).tag(PLANAR, [2])),
        ("predicted tiles", tiled(packed).tag(COMPRESSION, [8]).tag(PREDICTOR, [2])),
        ("jpeg", jpeg.tag(COMPRESSION, [7]).tag(PHOTOMETRIC, [6])),
        ("blocks", Tiff::new(21, 1, 3, vec![blocks]).tag(PHOTOMETRIC, [6])),
        ("old lzw", Tiff::new(21, 10, 3, vec![old]).tag(COMPRESSION, [5]).tag(EXTRA, [0])),
        ("palette", {
            let map: Vec<u32> = (0..48).map(|at| at * 1_000).collect();
            let tiff = Tiff::new(21, 5, 1, vec![values[..55].to_vec()]);
            tiff.tag(PHOTOMETRIC, [3]).tag(BITS, [4]).tag(COLOR_MAP, map).big_endian()
        }),
        ("pack bits", {
            let bytes = vec![[0xfd, 7, 2, 1, 2, 3].repeat(10)];
            Tiff::new(7, 10, 1, bytes).tag(COMPRESSION, [32_773]).tag(PHOTOMETRIC, [0])
        }),
    ];
    kinds.map(|(name, tiff)| (format!("{name}.tif"), tiff.bytes())).into()
}
