//! PNGs: sides, depths, chunks that are there many times or unpack to much, with right checksums.

use std::io::Write as _;

use arbitrary::Arbitrary;
use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::number::{Many, Number};
use super::{MAX_BYTES, choose, reading};

#[derive(Debug, Arbitrary)]
struct Choices {
    sides: [Many; 2],
    side: Option<(bool, Number)>,
    kind: u8,
    depth: Option<u8>,
    is_interlaced: Option<bool>,
    data: Data,
    chunk: Option<(Chunk, Many)>,
    length: Option<Number>,
}

/// What the rows are.
#[derive(Debug, Clone, Copy, Arbitrary)]
enum Data {
    /// In as many chunks.
    Whole {
        parts: Many,
    },
    Short(Many),
    /// More than the image has.
    Long(Many),
}

/// Before the rows.
#[derive(Debug, Clone, Copy, Arbitrary)]
enum Chunk {
    Profile,
    CompressedText,
    Text,
    Xmp,
    Palette,
    Exif,
    Animation,
    Unknown,
    /// The same, over and over.
    Repeated,
}

pub(super) fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    let written = encoder.write_all(bytes).and_then(|()| encoder.finish());
    written.expect("memory can be written")
}

/// Color type, depth, and bytes of a texel.
const KINDS: [(u8, u8, usize); 8] =
    [(0, 8, 1), (2, 8, 3), (6, 8, 4), (4, 8, 2), (0, 16, 2), (6, 16, 8), (3, 8, 1), (0, 1, 1)];

fn add(file: &mut Vec<u8>, name: &[u8; 4], content: &[u8]) {
    file.extend((content.len() as u32).to_be_bytes());
    let start = file.len();
    file.extend(name);
    file.extend(content);
    file.extend(crc32fast::hash(&file[start..]).to_be_bytes());
}

impl Chunk {
    fn add(self, many: Many, file: &mut Vec<u8>) {
        // Zeros that unpack to a thousand times as much.
        let zeros = || zlib(&vec![0; (256 * many.0).min(32 * MAX_BYTES)]);
        match self {
            Self::Profile => add(file, b"iCCP", &[b"profile\0\0", &zeros()[..]].concat()),
            Self::CompressedText => add(file, b"zTXt", &[b"text\0\0", &zeros()[..]].concat()),
            Self::Xmp => {
                let start = b"XML:com.adobe.xmp\0\x01\0\0\0";
                add(file, b"iTXt", &[start, &zeros()[..]].concat());
            }
            Self::Text => add(file, b"tEXt", &[b"text\0", &vec![b'a'; many.of(1)][..]].concat()),
            Self::Palette => add(file, b"PLTE", &vec![9; 3 * many.of(3)]),
            Self::Exif => {
                // A directory of many entries, all of which say that they have many values.
                let entry = b"\x87\x69\0\x04\0\xff\xff\xff\0\0\0\x08";
                let count = many.of(12);
                let entries = entry.repeat(count);
                let start = b"MM\0\x2a\0\0\0\x08";
                add(file, b"eXIf", &[start, &(count as u16).to_be_bytes()[..], &entries].concat());
            }
            Self::Animation => {
                add(file, b"acTL", &[(many.0 as u32).to_be_bytes(), [0; 4]].concat());
            }
            Self::Unknown => add(file, b"abCd", &vec![0; many.of(1)]),
            Self::Repeated => (0..many.of(20)).for_each(|_| add(file, b"tEXt", b"text\0a")),
        }
    }
}

impl Choices {
    fn file(&self) -> Vec<u8> {
        let (kind, depth, width) = KINDS[usize::from(self.kind) % KINDS.len()];
        let mut sides = self.sides.map(|side| side.0 as u64);
        if let Some((side, to)) = self.side {
            sides[usize::from(side)] = to.instead_of(sides[usize::from(side)]);
        }
        let interlaced = u8::from(self.is_interlaced == Some(true));
        let [wide, high] = sides.map(|side| (side as u32).to_be_bytes());
        let depth = self.depth.map_or(depth, |depth| 1 << (depth % 5));
        let header = [&wide[..], &high, &[depth, kind, 0, 0, interlaced]].concat();
        let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
        add(&mut file, b"IHDR", &header);
        if kind == 3 {
            add(&mut file, b"PLTE", &[7; 30]);
        }
        if let Some((chunk, many)) = self.chunk {
            chunk.add(many, &mut file);
        }
        let row = (sides[0] as usize).saturating_mul(width).saturating_add(1).min(8 * MAX_BYTES);
        let whole = (sides[1] as usize).saturating_mul(row).min(8 * MAX_BYTES);
        let count = match self.data {
            Data::Whole { .. } => whole,
            Data::Short(many) => many.0.min(whole),
            Data::Long(many) => (whole + 16 * many.0).min(8 * MAX_BYTES),
        };
        let rows = zlib(&vec![0; count]);
        let parts = if let Data::Whole { parts } = self.data { parts.of(16) } else { 1 };
        for part in rows.chunks(rows.len().div_ceil(parts).max(1)) {
            add(&mut file, b"IDAT", part);
        }
        let last = file.len();
        add(&mut file, b"IEND", &[]);
        if let Some(to) = self.length {
            to.patch(&mut file, last.saturating_sub(rows.len() + 12), 4, true);
        }
        file
    }
}

pub(crate) fn file(bytes: &[u8]) -> Vec<u8> {
    choose::<Choices>(bytes).map_or_else(Vec::new, |choices| choices.file())
}

pub(crate) fn run(bytes: &[u8]) {
    reading::image(&file(bytes));
}
