use ::exr::block::chunk::CompressedScanLineBlock;
use ::exr::math::RoundingMode;
use ::exr::meta::attribute::{LevelMode, TileDescription};
use ::exr::meta::{Requirements, magic_number};
use uvgraft::texture::{Channels, Depth, Size, Texture};

use super::*;
use crate::color_space::Chromaticities;
use crate::{Format, decode, decode_header};

/// Not multiples of the blocks of any codec, and neither is the corner of the data window at 0.
const SIZE: Vec2<usize> = Vec2(22, 38);
const CORNER: Vec2<i32> = Vec2(-4, 6);

fn channel(name: &str, sample_type: SampleType, sampling: usize) -> ChannelDescription {
    let named = ChannelDescription::named(name, sample_type);
    let sampling = Vec2(sampling, sampling);
    ChannelDescription { sampling, quantize_linearly: false, ..named }
}

/// Chroma of half, luminance of float.
fn channels() -> Vec<ChannelDescription> {
    let (half, float) = (SampleType::F16, SampleType::F32);
    vec![channel("BY", half, 2), channel("RY", half, 2), channel("Y", float, 1)]
}

fn header(list: Vec<ChannelDescription>, size: Vec2<usize>, compression: Compression) -> Header {
    let list: SmallVec<[_; 5]> = list.into_iter().collect();
    let mut header = Header::new(Text::from("chroma"), size, list).with_encoding(
        compression,
        BlockDescription::ScanLines,
        LineOrder::Increasing,
    );
    header.own_attributes.layer_position = CORNER;
    header.shared_attributes.display_window = IntegerBounds::new(CORNER, size);
    header
}

/// A file of blocks that are compressed already.
fn file(header: &Header, blocks: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = Vec::new();
    magic_number::write(&mut bytes).unwrap();
    let requirements = Requirements {
        file_format_version: 2,
        is_single_layer_and_tiled: header.blocks.has_tiles(),
        has_long_names: false,
        has_deep_data: false,
        has_multiple_layers: false,
    };
    requirements.write(&mut bytes).unwrap();
    Header::write_all(std::slice::from_ref(header), &mut bytes, false).unwrap();
    let mut offset = bytes.len() + 8 * blocks.len();
    let mut chunks = Vec::new();
    for (index, block) in blocks.iter().enumerate() {
        bytes.extend((offset as u64).to_le_bytes());
        let before = chunks.len();
        let y_coordinate = block_area(header, index).position.1;
        let block = CompressedScanLineBlock { y_coordinate, compressed_pixels_le: block.clone() };
        let compressed_block = CompressedBlock::ScanLine(block);
        Chunk { layer_index: 0, compressed_block }.write(&mut chunks, 1).unwrap();
        offset += chunks.len() - before;
    }
    [bytes, chunks].concat()
}

/// BY, RY and Y at a texel of the data window. Half holds its values for chroma, and cubics give them back in between.
fn color(x: usize, y: usize) -> [f32; 3] {
    let (x, y) = (x as f32, y as f32);
    [(y - x) / 64.0, (x + 3.0 * y) / 128.0, 1.0 + (x * 7.0 + y * 5.0) % 16.0 / 16.0]
}

/// A file of [`channels`] of the texels of [`color`].
fn smooth(compression: Compression) -> Vec<u8> {
    let mut header = header(channels(), SIZE, compression);
    let blocks: Vec<_> = (0..header.chunk_count)
        .map(|index| {
            let area = block_area(&header, index);
            let mut block = Vec::new();
            let top = (area.position.1 - CORNER.1) as usize;
            for y in top..top + area.size.1 {
                for channel in 0..2 {
                    let xs = (0..SIZE.0).step_by(2).filter(|_| y % 2 == 0);
                    block
                        .extend(xs.flat_map(|x| f16::from_f32(color(x, y)[channel]).to_ne_bytes()));
                }
                block.extend((0..SIZE.0).flat_map(|x| color(x, y)[2].to_ne_bytes()));
            }
            header.channels.bytes_per_pixel = block.len() / area.size.area();
            compression.compress_image_section_to_le(&header, block, area).unwrap()
        })
        .collect();
    file(&header, &blocks)
}

/// BY, RY and Y of a decoded texel.
fn chroma(texture: &Texture, x: usize, y: usize) -> [f32; 3] {
    let luminances = Chromaticities::SRGB.luminances().unwrap();
    let rgb: [f32; 3] = std::array::from_fn(|channel| texture.get(x as u32, y as u32, channel));
    let y: f32 = rgb.iter().zip(luminances).map(|(value, part)| value * part as f32).sum();
    [rgb[2] / y - 1.0, rgb[0] / y - 1.0, y]
}

#[test]
fn chroma_is_read_from_blocks_of_any_compression() {
    use Compression::{PIZ, RLE, Uncompressed, ZIP1, ZIP16};
    let longest = smooth(Uncompressed).len();
    for compression in [Uncompressed, RLE, ZIP1, ZIP16, PIZ] {
        let bytes = smooth(compression);
        assert!(compression == Uncompressed || bytes.len() < longest, "{compression:?}");
        let header = decode_header(&bytes).unwrap();
        let size = Size::new(SIZE.0 as u32, SIZE.1 as u32);
        assert_eq!((header.size, header.channels, header.depth), (size, Channels::Rgb, Depth::F32));
        let texture = decode(&bytes).unwrap().texture;
        // Near the border the nearest texels are interpolated from repeated ones.
        for (x, y) in (2..SIZE.0 - 4).flat_map(|x| (2..SIZE.1 - 4).map(move |y| (x, y))) {
            for (found, wanted) in chroma(&texture, x, y).iter().zip(color(x, y)) {
                assert!(
                    (found - wanted).abs() < 1e-5,
                    "{compression:?} at {x}, {y}: {found} {wanted}"
                );
            }
        }
    }
}

#[test]
fn blocks_of_b44_are_read_channel_by_channel() {
    let mut list = channels();
    list[2].sample_type = SampleType::F16;
    list.insert(0, channel("A", SampleType::F32, 1));
    // Equal samples in each block of 4 × 4, which then takes 3 bytes.
    let header = header(list, Vec2(6, 2), Compression::B44A);
    let flat = |value: f32| {
        let bits = f16::from_f32(value).to_bits();
        let ordered = if bits & 0x8000 == 0 { bits | 0x8000 } else { !bits };
        [&ordered.to_be_bytes()[..], &[0xfc]].concat()
    };
    let alpha = [1.0f32; 12].map(f32::to_le_bytes).concat();
    let block = [alpha, flat(-0.5), flat(0.25), flat(2.0), flat(4.0)].concat();
    let texture = decode(&file(&header, std::slice::from_ref(&block))).unwrap().texture;
    assert_eq!(texture.channels(), Channels::Rgba);
    for (x, wanted) in [2.0f32, 2.0, 2.0, 2.0, 4.0, 4.0].into_iter().enumerate() {
        for (found, wanted) in chroma(&texture, x, 1).iter().zip([-0.5, 0.25, wanted]) {
            assert!((found - wanted).abs() < 1e-5, "{x}: {found} {wanted}");
        }
    }
    for length in 1..block.len() {
        assert!(decode(&file(&header, &[block[..length].to_vec()])).is_err(), "{length}");
    }
}

#[test]
fn damaged_files_are_refused() {
    for compression in [Compression::Uncompressed, Compression::ZIP16, Compression::PIZ] {
        let bytes = smooth(compression);
        for length in 4..bytes.len() {
            assert!(decode(&bytes[..length]).is_err(), "{compression:?} cut at {length}");
        }
    }
    let header = header(channels(), SIZE, Compression::ZIP16);
    let short = file(&header, &[vec![7; 5], vec![7; 5], vec![7; 5]]);
    assert!(decode(&short).unwrap_err().to_string().starts_with("damaged EXR"));
    let mut bytes = smooth(Compression::ZIP16);
    let first = bytes.windows(4).rposition(|at| at == 22i32.to_le_bytes()).unwrap();
    bytes[first] = 6;
    let error = decode(&bytes).unwrap_err().to_string();
    assert_eq!(error, "damaged EXR: block 1 must start at row 22, got 6");
}

#[test]
fn other_subsampling_is_refused_by_name() {
    let refused = |list: Vec<ChannelDescription>, size| {
        let bytes = file(&header(list, size, Compression::ZIP16), &[vec![0; 4]]);
        let error = decode(&bytes).unwrap_err().to_string();
        assert_eq!(decode_header(&bytes).unwrap_err().to_string(), error);
        error
    };
    let changed = |index: usize, change: fn(&mut ChannelDescription)| {
        let mut list = channels();
        change(&mut list[index]);
        list
    };
    let error = refused(changed(1, |channel| channel.sampling = Vec2(4, 4)), SIZE);
    let wanted =
        "supported are scan lines with RY and BY at half the resolution in both directions";
    assert_eq!(error, format!("unsupported EXR: channel RY, subsampled 4×4; {wanted}"));
    let error = refused(changed(2, |channel| channel.sampling = Vec2(2, 2)), SIZE);
    assert!(error.contains("channel Y, subsampled 2×2"), "{error}");
    let error = refused(changed(0, |channel| channel.sampling = Vec2(0, 2)), SIZE);
    assert!(error.contains("channel BY, subsampled 0×2"), "{error}");
    let error = refused(changed(0, |channel| channel.sample_type = SampleType::F32), SIZE);
    assert!(error.contains("other than a pair of one type"), "{error}");
    let error = refused(channels(), Vec2(22, 37));
    let window = "the data window must be divisible by 2, got 22×37 texels at (-4, 6)";
    assert_eq!(error, format!("damaged {}: {window}", Format::EXR));
}

#[test]
fn another_part_may_be_subsampled_beside_scan_lines() {
    let grey = || vec![channel("Y", SampleType::F32, 1)];
    // Odd sizes are for the first part to have, whatever another's channels are.
    let mut parts =
        [header(grey(), Vec2(5, 3), Compression::RLE), header(channels(), SIZE, Compression::RLE)];
    assert!(any(&parts));
    check(&parts).unwrap();
    let tiles = TileDescription {
        tile_size: Vec2(8, 8),
        level_mode: LevelMode::Singular,
        rounding_mode: RoundingMode::Down,
    };
    parts[0].blocks = BlockDescription::Tiles(tiles);
    let error = check(&parts).unwrap_err().to_string();
    assert!(error.starts_with("unsupported EXR: tiles and subsampled channel BY;"), "{error}");
    parts.swap(0, 1);
    check(&parts).unwrap();
}
