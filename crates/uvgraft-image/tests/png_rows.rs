//! PNGs decode to the same values as with the `png` crate, and are damaged where they are for it.

#![expect(clippy::unwrap_used, reason = "a test stops at what should not fail")]

use std::io::Cursor;

use png::{BitDepth, ColorType, Compression, Encoder, Filter};
use uvgraft::texture::{Channels, Depth, Size, Texels};
use uvgraft::{Encoding, Texture};
use uvgraft_image::{self as image, BandDecoder, Format, Image, ImageError, WriteOptions};

const COLORS: [(ColorType, usize); 4] = [
    (ColorType::Grayscale, 1),
    (ColorType::GrayscaleAlpha, 2),
    (ColorType::Rgb, 3),
    (ColorType::Rgba, 4),
];
const FILTERS: [Filter; 7] = [
    Filter::NoFilter,
    Filter::Sub,
    Filter::Up,
    Filter::Avg,
    Filter::Paeth,
    Filter::Adaptive,
    Filter::MinEntropy,
];

/// Smooth with some grain, as 8-bit values.
fn values(count: usize, random: &mut fastrand::Rng) -> Vec<u8> {
    let grain = [0, 3, 255][random.usize(..3)];
    (0..count).map(|at| ((at / 7 % 251) as u8).wrapping_add(random.u8(..=grain))).collect()
}

struct Kind {
    color: (ColorType, usize),
    depth: BitDepth,
    filter: Filter,
    compression: Compression,
    /// Bytes of an IDAT chunk.
    chunk: usize,
}

impl Kind {
    fn any(random: &mut fastrand::Rng) -> Self {
        Self {
            color: COLORS[random.usize(..4)],
            depth: [BitDepth::Eight, BitDepth::Sixteen][random.usize(..2)],
            filter: FILTERS[random.usize(..FILTERS.len())],
            compression: [Compression::Fast, Compression::NoCompression, Compression::Balanced]
                [random.usize(..3)],
            chunk: random.usize(1..5000),
        }
    }

    fn row(&self, width: usize) -> usize {
        self.color.1 * width * if self.depth == BitDepth::Sixteen { 2 } else { 1 }
    }

    fn encode(&self, width: usize, height: usize, values: &[u8]) -> Vec<u8> {
        use std::io::Write;
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, width as u32, height as u32);
        encoder.set_color(self.color.0);
        encoder.set_depth(self.depth);
        encoder.set_compression(self.compression);
        encoder.set_filter(self.filter);
        let mut writer = encoder.write_header().unwrap();
        let mut stream = writer.stream_writer_with_size(self.chunk).unwrap();
        stream.write_all(values).unwrap();
        stream.finish().unwrap();
        drop(writer);
        bytes
    }
}

/// With the `png` crate; `None` for an error.
fn reference(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().ok()?;
    // A damaged header may claim any size.
    let len = reader.output_buffer_size().filter(|&len| len < 1 << 26)?;
    let mut values = vec![0; len];
    for row in values.chunks_exact_mut(reader.output_line_size(reader.info().width)?) {
        reader.read_row(row).ok()?;
    }
    reader.finish().ok()?;
    Some(values)
}

fn decode(bytes: &[u8], band: u32) -> Result<Vec<u8>, ImageError> {
    let mut decoder = BandDecoder::new(bytes)?;
    let mut values = Vec::new();
    while let Some(rows) = decoder.next_band(band)? {
        match rows.texels() {
            Texels::U8(texels) => values.extend(texels),
            Texels::U16(texels) => values.extend(texels.iter().flat_map(|x| x.to_be_bytes())),
            Texels::F32(_) => unreachable!("PNG holds integers"),
        }
        decoder.recycle(rows);
    }
    Ok(values)
}

#[test]
fn all_filters_sizes_and_formats() {
    let mut random = fastrand::Rng::with_seed(2);
    for round in 0..1500 {
        let kind = Kind::any(&mut random);
        let (width, height) = (random.usize(1..70), random.usize(1..40));
        let values = values(kind.row(width) * height, &mut random);
        let bytes = kind.encode(width, height, &values);
        assert!(reference(&bytes).unwrap() == values);
        let band = random.u32(1..50);
        assert!(decode(&bytes, band).unwrap() == values, "{round}, {band} rows");
    }
}

#[test]
fn large_images_pass_the_window_many_times() {
    let mut random = fastrand::Rng::with_seed(3);
    for (width, height) in [(1000, 700), (3, 32_000), (32_000, 21), (9000, 40)] {
        for filter in [Filter::Paeth, Filter::Adaptive, Filter::Sub] {
            let color = COLORS[random.usize(..4)];
            let kind = Kind { color, filter, chunk: 1 << 15, ..Kind::any(&mut random) };
            let values = values(kind.row(width) * height, &mut random);
            let bytes = kind.encode(width, height, &values);
            for band in [1, 31, 32, u32::MAX] {
                assert!(decode(&bytes, band).unwrap() == values, "{width} × {height}, {band}");
            }
        }
    }
}

#[test]
fn skipped_rows_are_above_the_others() {
    let mut random = fastrand::Rng::with_seed(4);
    for _ in 0..200 {
        let kind = Kind::any(&mut random);
        let (width, height) = (random.usize(1..70), random.usize(1..40));
        let values = values(kind.row(width) * height, &mut random);
        let bytes = kind.encode(width, height, &values);
        let skipped = random.usize(..=height);
        let mut decoder = BandDecoder::new(&bytes).unwrap();
        decoder.skip(skipped as u32).unwrap();
        let Some(rows) = decoder.next_band(u32::MAX).unwrap() else {
            assert_eq!(skipped, height);
            continue;
        };
        let found: Vec<u8> = match rows.texels() {
            Texels::U8(texels) => texels.clone(),
            Texels::U16(texels) => texels.iter().flat_map(|x| x.to_be_bytes()).collect(),
            Texels::F32(_) => unreachable!("PNG holds integers"),
        };
        assert!(found == values[skipped * kind.row(width)..]);
    }
}

#[test]
fn truncated_and_damaged_files_are_errors_where_they_are_for_the_crate() {
    let mut random = fastrand::Rng::with_seed(5);
    let mut damaged = 0;
    for _ in 0..12 {
        let kind = Kind { chunk: random.usize(20..600), ..Kind::any(&mut random) };
        let (width, height) = (random.usize(1..20), random.usize(1..20));
        let values = values(kind.row(width) * height, &mut random);
        let bytes = kind.encode(width, height, &values);
        for len in 0..bytes.len() {
            assert!(decode(&bytes[..len], 3).is_err(), "{len} of {} bytes", bytes.len());
        }
        for at in 0..bytes.len() {
            let mut bytes = bytes.clone();
            bytes[at] ^= 1 << random.u8(..8);
            check_damaged(&bytes, at, Some(&values));
            damaged += 1;
        }
        // With correct checksums, so that the compressed data is damaged.
        for at in 0..bytes.len() {
            let mut bytes = bytes.clone();
            bytes[at] ^= 1 << random.u8(..8);
            fix_checksums(&mut bytes);
            check_damaged(&bytes, at, Some(&values));
        }
    }
    assert!(damaged > 1000);
}

/// The same values, or an error where the crate returns one.
///
/// - `intact`: the values of the image, if it is harmless to find them in spite of the damage, as
///   where only the end of the compressed data is damaged.
fn check_damaged(bytes: &[u8], at: usize, intact: Option<&[u8]>) {
    let found = decode(bytes, 7);
    let wanted = reference(bytes);
    // Palettes, fewer bits, and limits of our own are other tests' concern.
    let is_header = at < 33;
    match (found, wanted) {
        (Ok(found), Some(wanted)) => assert!(found == wanted || is_header, "byte {at}"),
        (Err(_), None) => {}
        (Ok(found), None) if intact == Some(&found[..]) => {}
        (found, wanted) => assert!(
            is_header,
            "byte {at}: {:?}, crate: {}",
            found.map(|_| "decoded"),
            if wanted.is_some() { "decoded" } else { "error" }
        ),
    }
}

fn fix_checksums(bytes: &mut [u8]) {
    let mut at = 8;
    while let Some(length) = bytes.get(at..at + 4) {
        let length = u32::from_be_bytes(length.try_into().unwrap()) as usize;
        let Some(data) = bytes.get(at + 4..(at + 8).saturating_add(length)) else { return };
        let checksum = crc32fast::hash(data).to_be_bytes();
        let end = at + 8 + length;
        let Some(stored) = bytes.get_mut(end..end + 4) else { return };
        stored.copy_from_slice(&checksum);
        at = end + 4;
    }
}

#[test]
fn too_few_rows_and_what_follows_the_rows() {
    let mut random = fastrand::Rng::with_seed(6);
    let kind = Kind { chunk: 1 << 20, compression: Compression::Fast, ..Kind::any(&mut random) };
    let values = values(kind.row(9) * 12, &mut random);
    // The header claims fewer or more rows.
    for height in [1_u32, 11, 13, 40] {
        let mut bytes = kind.encode(9, 12, &values);
        bytes[20..24].copy_from_slice(&height.to_be_bytes());
        fix_checksums(&mut bytes);
        match decode(&bytes, 5) {
            Ok(found) => assert!(found == values[..kind.row(9) * height as usize] && height < 12),
            Err(error) => assert!(matches!(error, ImageError::Damaged { .. }) && height > 12),
        }
    }
    let bytes = kind.encode(9, 12, &values);
    let end = bytes.len() - 12;
    let with = |kind: &[u8; 4], data: &[u8]| {
        let mut bytes = bytes.clone();
        let chunk = [&(data.len() as u32).to_be_bytes()[..], kind, data, &[0; 4]].concat();
        bytes.splice(end..end, chunk);
        fix_checksums(&mut bytes);
        bytes
    };
    let chunks: [(&[u8; 4], &[u8]); 8] = [
        (b"tEXt", b"a\0b"),
        (b"abCd", &[0; 9]),
        (b"ABCD", &[0; 9]),
        (b"IDAT", b""),
        (b"IDAT", b"anything"),
        (b"PLTE", &[0; 6]),
        (b"IHDR", &[0; 13]),
        (b"gAMA", &[0; 5]),
    ];
    for (kind, data) in chunks {
        check_damaged(&with(kind, data), end, None);
    }
    // Separated chunks of image data.
    let mut bytes = with(b"tEXt", b"a\0b");
    let end = bytes.len() - 12;
    bytes.splice(end..end, *b"\0\0\0\0IDAT\0\0\0\0");
    fix_checksums(&mut bytes);
    assert!(decode(&bytes, 5).is_err() && reference(&bytes).is_none());
    assert_eq!(decode(&with(b"IEND", b"x"), 5).is_err(), reference(&with(b"IEND", b"x")).is_none());
    assert_eq!(
        BandDecoder::new(&with(b"tEXt", b"a\0b")).unwrap().spec().depth,
        match kind.depth {
            BitDepth::Sixteen => Depth::U16,
            _ => Depth::U8,
        }
    );
}

/// Our own files, whose pieces are inflated in parallel, also where the pieces end early.
#[test]
fn pieces_of_our_own_come_back_on_any_number_of_threads() {
    let mut random = fastrand::Rng::with_seed(8);
    for (width, height, channels) in [(1500, 1300, Channels::Rgb), (30_000, 31, Channels::Rgba)] {
        let size = Size::new(width, height);
        let values = values(size.texels() * channels.count(), &mut random);
        let texture =
            Texture::new(size, channels, Encoding::Srgb, Texels::U8(values.clone())).unwrap();
        let mut bytes = Cursor::new(Vec::new());
        let _ =
            image::encode(&Image::from(texture), Format::PNG, &WriteOptions::default(), &mut bytes)
                .unwrap();
        let bytes = bytes.into_inner();
        let starts = data_chunks(&bytes);
        assert!(starts.len() > 5, "{} chunks", starts.len());
        let row = width as usize * channels.count() + 1;
        let mut files = vec![bytes.clone()];
        for &[first, second] in starts.array_windows() {
            // Two pieces in one chunk, a cut piece, and a damaged one.
            files.push(with_data(&bytes, &starts, |chunks| {
                let at = starts.iter().position(|&start| start == first).unwrap();
                let next = chunks.remove(at + 1);
                chunks[at].extend(next);
            }));
            files.push(with_data(&bytes, &starts, |chunks| {
                let at = starts.iter().position(|&start| start == second).unwrap();
                let half = chunks[at].len() / 2;
                let rest = chunks[at].split_off(half);
                chunks.insert(at + 1, rest);
            }));
            let mut damaged = bytes.clone();
            damaged[second + 20] ^= 16;
            files.push(damaged);
        }
        // From the third piece on a stream that refers to the rows before it.
        let filtered = fdeflate::decompress_to_vec(
            &starts.iter().flat_map(|&start| data(&bytes, start)).copied().collect::<Vec<_>>(),
        )
        .unwrap();
        let rows = ((1 << 19) / (row - 1)).max(1);
        let (done, rest) = filtered.split_at(2 * rows * row);
        let mut stream = flate2::Compress::new(flate2::Compression::best(), false);
        let mut before = Vec::with_capacity(2 * done.len() + 100);
        stream.compress_vec(done, &mut before, flate2::FlushCompress::Sync).unwrap();
        let mut tail = Vec::with_capacity(2 * rest.len() + 100);
        stream.compress_vec(rest, &mut tail, flate2::FlushCompress::Finish).unwrap();
        tail.extend(simd_adler32::adler32(&filtered.as_slice()).to_be_bytes());
        files.push(with_data(&bytes, &starts, |chunks| {
            chunks.truncate(2);
            chunks.push(tail.clone());
        }));
        for (index, file) in files.iter().enumerate() {
            let wanted = reference(file);
            for threads in [1, 4, 5, 16] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let found = pool.install(|| decode(file, [7, 500][index % 2])).ok();
                assert!(found == wanted, "{width} × {height}, file {index}, {threads} threads");
            }
        }
        assert!(reference(&files[0]).unwrap() == values);
        assert!(reference(files.last().unwrap()).unwrap() == values);
    }
}

/// Where the IDAT chunks start.
fn data_chunks(bytes: &[u8]) -> Vec<usize> {
    let mut at = 8;
    let mut starts = Vec::new();
    while at < bytes.len() {
        if &bytes[at + 4..at + 8] == b"IDAT" {
            starts.push(at);
        }
        at += 12 + u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    }
    starts
}

fn data(bytes: &[u8], start: usize) -> &[u8] {
    let length = u32::from_be_bytes(bytes[start..start + 4].try_into().unwrap()) as usize;
    &bytes[start + 8..][..length]
}

/// The file with the image data in other chunks.
fn with_data(bytes: &[u8], starts: &[usize], change: impl Fn(&mut Vec<Vec<u8>>)) -> Vec<u8> {
    let mut chunks = starts.iter().map(|&start| data(bytes, start).to_vec()).collect();
    change(&mut chunks);
    let last = *starts.last().unwrap();
    let mut file = bytes[..starts[0]].to_vec();
    for data in chunks {
        file.extend((data.len() as u32).to_be_bytes());
        file.extend(b"IDAT");
        file.extend(data);
        file.extend([0; 4]);
    }
    file.extend(&bytes[last + 12 + data(bytes, last).len()..]);
    fix_checksums(&mut file);
    file
}
