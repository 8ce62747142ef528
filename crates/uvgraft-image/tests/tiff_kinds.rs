//! Kinds of TIFF that other programs write and uvgraft does not: each is read as it is meant, or refused with what to do.

use uvgraft::texture::{Channels, Depth, Size, Texels};
use uvgraft_image::{ImageError, decode};
use weezl::BitOrder;

use crate::tiff_file::*;

#[test]
fn tiles_of_planes() {
    let (width, height) = (21, 10);
    let values = rgb(width, height);
    let wanted = (Channels::Rgb, values.clone());
    for side in [[16, 16], [7, 3], [32, 2]] {
        let sides =
            |tiff: Tiff| tiff.tag(TILE_WIDTH, [side[0] as u32]).tag(TILE_LENGTH, [side[1] as u32]);
        let chunks = tiles(&values, width as usize, 3, side);
        assert_eq!(sides(Tiff::new(width, height, 3, chunks)).read_u8(), wanted, "{side:?}");
        let of_plane = |plane: &Vec<u8>| tiles(plane, width as usize, 1, side);
        let chunks: Vec<_> = planes(&values, 3).iter().flat_map(of_plane).collect();
        let packed = chunks.iter().map(|chunk| deflated(chunk)).collect();
        let planar = sides(Tiff::new(width, height, 3, chunks)).tag(PLANAR, [2]);
        assert_eq!(planar.read_u8(), wanted, "{side:?}");
        let planar = Tiff { chunks: packed, ..planar }.tag(COMPRESSION, [8]);
        assert_eq!(planar.read_u8(), wanted, "{side:?}");
    }
    // Turned upright as a whole: stored as lying on its left side.
    let turned = Tiff::new(width, height, 3, tiles(&values, width as usize, 3, [16, 16]))
        .tag(TILE_WIDTH, [16])
        .tag(TILE_LENGTH, [16])
        .tag(ORIENTATION, [6])
        .read();
    assert_eq!(turned.size(), Size::new(height, width));
    assert_eq!(turned.get(height - 1, 0, 0), f32::from(values[0]) / 255.0);
}

#[test]
fn the_lowest_bit_first() {
    let values = rgb(5, 4);
    let wanted = (Channels::Rgb, values.clone());
    let mut random = fastrand::Rng::with_seed(2);
    let lzw = weezl::encode::Encoder::with_tiff_size_switch(BitOrder::Msb, 8).encode(&values);
    let pack_bits: Vec<u8> =
        values.chunks(4).flat_map(|chunk| [&[chunk.len() as u8 - 1], chunk].concat()).collect();
    for (compression, bytes) in [
        (1, values.clone()),
        (5, lzw.unwrap()),
        (8, deflated(&values)),
        (32_946, deflated(&values)),
        (32_773, pack_bits),
    ] {
        let tiff = Tiff::new(5, 4, 3, vec![bytes.clone()]).tag(COMPRESSION, [compression]);
        assert_eq!(tiff.read_u8(), wanted, "{compression}");
        let reversed = vec![bytes.iter().map(|byte| byte.reverse_bits()).collect()];
        let tiff = Tiff { chunks: reversed, ..tiff }.tag(FILL_ORDER, [2]);
        assert_eq!(tiff.read_u8(), wanted, "{compression}");
    }
    // By hand: 10 texels of one bit, of which the first two are white.
    let tiff = Tiff::new(10, 1, 1, vec![vec![0b11, 0b10]]).tag(BITS, [1]).tag(FILL_ORDER, [2]);
    assert_eq!(tiff.read_u8().1, [255, 255, 0, 0, 0, 0, 0, 0, 0, 255]);
    let error = decode(&tiff.tag(FILL_ORDER, [random.u32(3..9)]).bytes()).unwrap_err();
    assert!(error.to_string().starts_with("damaged TIFF: FillOrder must be 1 or 2"), "{error}");
}

#[test]
fn lzw_of_the_first_libtiff() {
    let values = rgb(40, 40);
    let old = weezl::encode::Encoder::new(BitOrder::Lsb, 8).encode(&values).unwrap();
    let tiff = Tiff::new(40, 40, 3, vec![old]).tag(COMPRESSION, [5]);
    assert_eq!(tiff.read_u8(), (Channels::Rgb, values));
}

#[test]
fn palettes() {
    let colors = [[0, 10, 255], [1, 128, 3], [200, 0, 9], [77, 66, 55]];
    let map = |to_16: fn(u32) -> u32, bits: u32| -> Vec<u32> {
        let color = |index: usize| colors[index % 4];
        let channel =
            |channel: usize| (0..1 << bits).map(move |index| to_16(color(index)[channel]));
        (0..3).flat_map(channel).collect()
    };
    let wanted: Vec<u8> =
        [0, 1, 2, 3, 1].iter().flat_map(|&it: &usize| colors[it].map(|it| it as u8)).collect();
    for (bits, row) in [
        (2, vec![0b0001_1011, 0b0100_0000]),
        (4, vec![0x01, 0x23, 0x10]),
        (8, vec![0, 1, 2, 3, 1]),
        (16, vec![0, 0, 1, 0, 2, 0, 3, 0, 1, 0]),
    ] {
        // As it should be, as Pillow does, and as programs that confuse the ranges do.
        for to_16 in [|it| it * 257, |it| it << 8, |it| it] {
            let tiff = Tiff::new(5, 1, 1, vec![row.clone()])
                .tag(BITS, [bits])
                .tag(PHOTOMETRIC, [3])
                .tag(COLOR_MAP, map(to_16, bits));
            assert_eq!(tiff.read_u8(), (Channels::Rgb, wanted.clone()), "{bits}");
        }
    }
    let tiff = Tiff::new(9, 1, 1, vec![vec![0b1000_0001, 0x80]])
        .tag(BITS, [1])
        .tag(PHOTOMETRIC, [3])
        .tag(COLOR_MAP, [0, 65_535, 0, 0, 257, 514]);
    let (_, values) = tiff.read_u8();
    assert_eq!(values[..6], [255, 0, 2, 0, 0, 1]);
    assert_eq!(values[21..], [255, 0, 2, 255, 0, 2]);
    let with_alpha = Tiff::new(2, 1, 2, vec![vec![1, 200, 2, 100]])
        .tag(PHOTOMETRIC, [3])
        .tag(EXTRA, [2])
        .tag(COLOR_MAP, map(|it| it << 8, 8));
    assert_eq!(with_alpha.read_u8(), (Channels::Rgba, vec![1, 128, 3, 200, 200, 0, 9, 100]));
    let error = decode(&tiff.tag(COLOR_MAP, [1; 5]).bytes()).unwrap_err().to_string();
    assert_eq!(error, "damaged TIFF: a palette must have 6 numbers, got 5");
}

#[test]
fn strips_and_tiles_of_jpeg() {
    let size = Size::new(32, 16);
    let near = |found: &[u8], wanted: &[u8]| {
        assert_eq!(found.len(), wanted.len());
        let off = found.iter().zip(wanted).map(|(&a, &b)| a.abs_diff(b)).max();
        // Rounding of two colour spaces and the coefficients of quality 98.
        assert!(off.unwrap() <= 4, "{off:?}");
    };
    let (file, values) = jpeg(size, Channels::Rgb);
    let [jpeg_tables, bare] = split_tables(&file);
    // Two strips of the same texels.
    let twice = [&values[..], &values].concat();
    let strips = |chunk: &Vec<u8>| {
        Tiff::new(32, 32, 3, vec![chunk.clone(); 2])
            .tag(COMPRESSION, [7])
            .tag(PHOTOMETRIC, [6])
            .tag(SUBSAMPLING, [1, 1])
            .tag(ROWS_PER_STRIP, [16])
    };
    near(&strips(&file).read_u8().1, &twice);
    let with_tables = Tiff { jpeg_tables, ..strips(&bare) };
    near(&with_tables.read_u8().1, &twice);
    // A tile that is larger than the image.
    let cut: Vec<u8> = values.chunks(96).take(9).flat_map(|row| &row[..60]).copied().collect();
    let tile = Tiff::new(20, 9, 3, vec![file.clone()])
        .tag(COMPRESSION, [7])
        .tag(PHOTOMETRIC, [6])
        .tag(TILE_WIDTH, [32])
        .tag(TILE_LENGTH, [16]);
    near(&tile.read_u8().1, &cut);
    // What is stored as RGB is not converted: so luma and differences come out as they are.
    let raw = strips(&file).tag(PHOTOMETRIC, [2]).read_u8().1;
    let [r, g, b] = [values[0], values[1], values[2]].map(f32::from);
    near(&raw[..1], &[(0.299 * r + 0.587 * g + 0.114 * b).round() as u8]);
    let (file, values) = jpeg(size, Channels::Grey);
    let grey = Tiff::new(32, 16, 1, vec![file.clone()]).tag(COMPRESSION, [7]);
    near(&grey.read_u8().1, &values);
    let planes = Tiff::new(32, 16, 3, vec![file.clone(); 3]).tag(COMPRESSION, [7]).tag(PLANAR, [2]);
    near(&planes.read_u8().1, &values.iter().flat_map(|&it| [it; 3]).collect::<Vec<_>>());
    // Fewer texels than the strip must have, and not all of them.
    let error = decode(&Tiff::new(32, 17, 1, vec![file.clone()]).tag(COMPRESSION, [7]).bytes())
        .unwrap_err();
    let wanted = "damaged TIFF: a strip or tile must have 32×17 texels, its JPEG has 32×16";
    assert_eq!(error.to_string(), wanted);
    let cut = file[..file.len() * 2 / 3].to_vec();
    let error = decode(&Tiff { chunks: vec![cut], ..grey.clone() }.bytes()).unwrap_err();
    assert!(matches!(error, ImageError::Truncated { .. }), "{error}");
    let error = decode(&Tiff { chunks: vec![vec![1, 2, 3]], ..grey }.bytes()).unwrap_err();
    assert_eq!(error.to_string(), "damaged TIFF: a strip or tile does not start as a JPEG");
}

#[test]
fn luma_and_differences_without_jpeg() {
    // Two strips of 2 rows of 3 texels: grey, but for the right column of the first.
    let strip = |red| vec![10, 20, 30, 40, 128, 128, 76, 9, 76, 9, 85, red];
    let tiff = Tiff::new(3, 3, 3, vec![strip(255), strip(128)])
        .tag(PHOTOMETRIC, [6])
        .tag(ROWS_PER_STRIP, [2]);
    let (channels, values) = tiff.read_u8();
    assert_eq!((channels, values.len()), (Channels::Rgb, 27));
    assert_eq!(values[..9], [10, 10, 10, 20, 20, 20, 254, 0, 0]);
    assert_eq!(values[9..15], [30, 30, 30, 40, 40, 40]);
    assert_eq!(values[18..24], [10, 10, 10, 20, 20, 20]);
    let packed = vec![deflated(&strip(255)), deflated(&strip(128))];
    let packed = Tiff { chunks: packed, ..tiff.clone() }.tag(COMPRESSION, [8]);
    assert_eq!(packed.read_u8().1, values);
    let single = Tiff::new(2, 1, 3, vec![vec![10, 128, 128, 76, 85, 255]]).tag(PHOTOMETRIC, [6]);
    assert_eq!(single.tag(SUBSAMPLING, [1, 1]).read_u8().1, [10, 10, 10, 254, 0, 0]);
    let error = decode(&tiff.tag(SUBSAMPLING, [3, 1]).bytes()).unwrap_err().to_string();
    assert_eq!(error, "damaged TIFF: YCbCrSubSampling must be two of 1, 2 and 4, got [3, 1]");
}

#[test]
fn white_as_zero() {
    let tiff = Tiff::new(3, 1, 1, vec![vec![0, 55, 255]]).tag(PHOTOMETRIC, [0]);
    assert_eq!(tiff.read_u8().1, [255, 200, 0]);
    // Alpha is not inverted.
    let tiff = Tiff::new(2, 1, 2, vec![vec![0, 55, 255, 7]]).tag(PHOTOMETRIC, [0]);
    assert_eq!(tiff.clone().tag(EXTRA, [2]).read_u8(), (Channels::GreyAlpha, vec![255, 55, 0, 7]));
    assert!(tiff.tag(EXTRA, [1]).refusal().contains("premultiplied alpha"));
    let tiff = Tiff::new(4, 1, 1, vec![vec![0b0001_1011]]).tag(BITS, [2]).tag(PHOTOMETRIC, [0]);
    assert_eq!(tiff.read_u8().1, [255, 170, 85, 0]);
}

#[test]
fn samples_beyond_the_colour() {
    let tiff = Tiff::new(2, 1, 5, vec![vec![1, 2, 3, 4, 5, 6, 7, 8, 9, 10]]).tag(PHOTOMETRIC, [2]);
    let rgba = |kinds: [u32; 2]| tiff.clone().tag(EXTRA, kinds).read_u8();
    assert_eq!(rgba([0, 0]), (Channels::Rgb, vec![1, 2, 3, 6, 7, 8]));
    assert_eq!(rgba([2, 0]), (Channels::Rgba, vec![1, 2, 3, 4, 6, 7, 8, 9]));
    assert_eq!(rgba([0, 2]), (Channels::Rgba, vec![1, 2, 3, 5, 6, 7, 8, 10]));
    let message = tiff.refusal();
    assert!(message.contains("5 samples a texel, without a meaning from number 4 on"), "{message}");
    // A single one is alpha, unless it is said to be something else.
    let four = Tiff::new(1, 1, 4, vec![vec![1, 2, 3, 4]]);
    assert_eq!(four.read_u8(), (Channels::Rgba, vec![1, 2, 3, 4]));
    assert_eq!(four.clone().tag(EXTRA, [0]).read_u8(), (Channels::Rgb, vec![1, 2, 3]));
    let premultiplied = Tiff::new(1, 1, 4, vec![vec![50, 25, 0, 100]]).tag(EXTRA, [1]);
    assert_eq!(premultiplied.read_u8(), (Channels::Rgba, vec![128, 64, 0, 100]));
    // Bands, such as those of a map, aren't a grey picture.
    let bands = Tiff::new(1, 1, 2, vec![vec![1, 2]]).tag(EXTRA, [0]);
    assert!(bands.refusal().contains("2 samples a texel, without a meaning from number 2 on"));
    // The predictor goes by all samples.
    let differences = deflated(&[10, 20, 30, 40, 1, 2, 3, 4]);
    let predicted = Tiff::new(2, 1, 4, vec![differences])
        .tag(EXTRA, [0])
        .tag(COMPRESSION, [8])
        .tag(PREDICTOR, [2]);
    assert_eq!(predicted.read_u8().1, [10, 20, 30, 11, 22, 33]);
}

#[test]
fn predictors_and_byte_orders() {
    let sixteen = |bytes: &[u8]| {
        Tiff::new(3, 1, 1, vec![deflated(bytes)])
            .tag(BITS, [16])
            .tag(COMPRESSION, [8])
            .tag(PREDICTOR, [2])
    };
    // 511, 512 and 510.
    let wanted = Texels::U16(vec![511, 512, 510]);
    assert_eq!(*sixteen(&[255, 1, 1, 0, 254, 255]).read().texels(), wanted);
    assert_eq!(*sixteen(&[1, 255, 0, 1, 255, 254]).big_endian().read().texels(), wanted);
    // 1.0 and 2.0 are 0x3f800000 and 0x40000000: the bytes of each place, as differences.
    let float = Tiff::new(2, 1, 1, vec![deflated(&[0x3f, 1, 0x40, 0x80, 0, 0, 0, 0])])
        .tag(BITS, [32])
        .tag(SAMPLE_FORMAT, [3])
        .tag(COMPRESSION, [8])
        .tag(PREDICTOR, [3]);
    assert_eq!(*float.read().texels(), Texels::F32(vec![1.0, 2.0]));
    assert_eq!(*float.big_endian().read().texels(), Texels::F32(vec![1.0, 2.0]));
    // As 32-bit integers, as GDAL may do.
    let bits = [1f32.to_bits(), 2f32.to_bits() - 1f32.to_bits()];
    let words = deflated(&bits.map(u32::to_le_bytes).concat());
    let float = Tiff::new(2, 1, 1, vec![words])
        .tag(BITS, [32])
        .tag(SAMPLE_FORMAT, [3])
        .tag(COMPRESSION, [8])
        .tag(PREDICTOR, [2]);
    assert_eq!(*float.read().texels(), Texels::F32(vec![1.0, 2.0]));
    let doubles = [0.5f64, -3.25].map(f64::to_be_bytes).concat();
    let double = Tiff::new(2, 1, 1, vec![doubles]).tag(BITS, [64]).tag(SAMPLE_FORMAT, [3]);
    assert_eq!(*double.big_endian().read().texels(), Texels::F32(vec![0.5, -3.25]));
    // libtiff ignores it without LZW or Deflate.
    let plain = Tiff::new(3, 1, 1, vec![vec![5, 6, 7]]).tag(PREDICTOR, [2]);
    assert_eq!(plain.read_u8().1, [5, 6, 7]);
    let bilevel = Tiff::new(8, 1, 1, vec![deflated(&[5])]).tag(BITS, [1]).tag(COMPRESSION, [8]);
    assert!(bilevel.tag(PREDICTOR, [2]).refusal().contains("predictor 2 with these samples"));
}

#[test]
fn planes_of_bits() {
    // Three planes of 9×1 bits: red, green and blue at one texel each.
    let chunks = vec![vec![0x80, 0], vec![0, 0x80], vec![0x01, 0]];
    let tiff = Tiff::new(9, 1, 3, chunks).tag(BITS, [1, 1, 1]).tag(PLANAR, [2]);
    let mut wanted = vec![0; 27];
    wanted[0] = 255;
    wanted[25] = 255;
    wanted[23] = 255;
    assert_eq!(tiff.read_u8(), (Channels::Rgb, wanted));
    // The same side by side: bits 0, 25 and 23, of which the last row of bytes is padded.
    let tiff = Tiff::new(9, 1, 3, vec![vec![0x80, 0, 0x01, 0x40]]).tag(BITS, [1]);
    let (_, values) = tiff.read_u8();
    let white: Vec<_> = (0..27).filter(|&at| values[at] == 255).collect();
    assert_eq!(white, [0, 23, 25]);
}

#[test]
fn what_tags_leave_out() {
    // One number of bits for three samples, an undefined format, and no lengths of strips.
    let values = rgb(4, 4);
    let tiff =
        Tiff::new(4, 4, 3, vec![values.clone()]).tag(BITS, [8]).tag(SAMPLE_FORMAT, [4, 4, 4]);
    assert_eq!(tiff.read_u8().1, values);
    let mut bytes = tiff.bytes();
    let entry = STRIP_BYTE_COUNTS.to_le_bytes();
    let at = bytes.windows(4).rposition(|it| it[..2] == entry && it[2..] == [4, 0]).unwrap();
    // A private tag instead.
    bytes[at..at + 2].copy_from_slice(&65_000u16.to_le_bytes());
    assert_eq!(*decode(&bytes).unwrap().texture.texels(), Texels::U8(values));
    let error = decode(&tiff.clone().without(PHOTOMETRIC).bytes()).unwrap_err();
    assert_eq!(error.to_string(), "damaged TIFF: tag 262 is missing");
    let error = decode(&tiff.tag(ROWS_PER_STRIP, [2]).bytes()).unwrap_err();
    assert_eq!(error.to_string(), "damaged TIFF: must have 2 strips or tiles, got 1");
}

#[test]
fn what_is_not_read_says_what_to_do() {
    let plain = || Tiff::new(2, 2, 3, vec![vec![0; 12]]);
    for (number, name) in [
        (2, "fax (CCITT RLE) compression"),
        (3, "fax (CCITT group 3) compression"),
        (4, "fax (CCITT group 4) compression"),
        (6, "old-style JPEG compression"),
        (34_712, "JPEG 2000 compression"),
        (34_887, "LERC compression"),
        (50_000, "Zstandard compression"),
        (50_001, "WebP compression"),
        (52_546, "JPEG XL compression"),
        (12_345, "compression 12345"),
    ] {
        let message = plain().tag(COMPRESSION, [number]).refusal();
        let wanted =
            format!("unsupported TIFF: {name}; save it with ZIP (Deflate), LZW or no compression");
        assert!(message.starts_with(&wanted), "{message}");
    }
    for (interpretation, name) in [
        (4, "a transparency mask"),
        (5, "CMYK colours"),
        (8, "CIELab colours"),
        (32_803, "a raw photo (colour filter array)"),
        (777, "colours of kind 777"),
    ] {
        let message = plain().tag(PHOTOMETRIC, [interpretation]).refusal();
        let wanted = format!("unsupported TIFF: {name}; convert it to greyscale or RGB");
        assert!(message.starts_with(&wanted), "{message}");
    }
    for (bits, format, name) in [
        (8, 2, "8-bit signed integers"),
        (12, 1, "12-bit integers"),
        (32, 1, "32-bit integers"),
        (64, 1, "64-bit integers"),
        (24, 3, "24-bit floats"),
        (64, 6, "complex numbers"),
    ] {
        let message = plain().tag(BITS, [bits]).tag(SAMPLE_FORMAT, [format]).refusal();
        let wanted = format!("unsupported TIFF: {name}; save it with 8 or 16 bits or as float");
        assert!(message.starts_with(&wanted), "{message}");
    }
    assert!(plain().tag(BITS, [5, 6, 5]).refusal().contains("samples of bits [5, 6, 5]"));
    let jpeg = Tiff::new(2, 2, 4, vec![vec![0; 16]]).tag(COMPRESSION, [7]);
    assert!(jpeg.refusal().contains("JPEG of 4 samples a texel"));
    let message = plain().tag(TILE_WIDTH, [60_000]).tag(TILE_LENGTH, [16]).refusal();
    assert!(message.contains("tiles of 60000×16 texels"), "{message}");
    assert_eq!(plain().read().depth(), Depth::U8);
}
