//! JPEGs: sides, components, segments that are there many times, and scans over scans.

use std::io::Cursor;
use std::sync::LazyLock;

use arbitrary::Arbitrary;
use uvgraft::{Channels, Encoding, Size, Texels, Texture};
use uvgraft_image::{Format, WriteOptions, encode};

use super::number::{Many, Number, Patch};
use super::{choose, reading};

#[derive(Debug, Arbitrary)]
struct Choices {
    is_rgb: bool,
    sides: Option<[Many; 2]>,
    side: Option<(bool, Number)>,
    sampling: Option<(u8, u8)>,
    segment: Option<(Segment, Many)>,
    scans: Option<Scans>,
    data: Option<Many>,
    restart: Option<Number>,
    patch: Option<Patch>,
}

#[derive(Debug, Clone, Copy, Arbitrary)]
enum Segment {
    Comment,
    Exif,
    /// Parts of a profile.
    Profile,
    Xmp,
    /// The same tables, over and over.
    Quantization,
    Huffman,
    Repeated,
    /// Fill bytes.
    Fill,
}

/// Scans that say that each refines what was before, in a progressive file.
#[derive(Debug, Clone, Copy, Arbitrary)]
struct Scans {
    count: Many,
    is_progressive: bool,
    is_direct: bool,
    bits: u8,
}

/// A segment: its marker and its content.
type Part = (u8, Vec<u8>);

/// The segments of a file of our own, and the entropy-coded data behind them.
fn parts(is_rgb: bool) -> (Vec<Part>, Vec<u8>) {
    static SEEDS: LazyLock<[Vec<u8>; 2]> = LazyLock::new(|| {
        [Channels::Grey, Channels::Rgb].map(|channels| {
            let size = Size::new(19, 11);
            let texels =
                Texels::U8((0..size.texels() * channels.count()).map(|at| at as u8).collect());
            let texture = Texture::new(size, channels, Encoding::Srgb, texels).expect("a texture");
            let mut out = Cursor::new(Vec::new());
            let options = WriteOptions::default();
            encode(&texture.into(), Format::JPEG, &options, &mut out).map(drop).expect("a JPEG");
            out.into_inner()
        })
    });
    let bytes = &SEEDS[usize::from(is_rgb)];
    let (mut parts, mut at) = (Vec::new(), 2);
    loop {
        let length = usize::from(u16::from_be_bytes([bytes[at + 2], bytes[at + 3]]));
        parts.push((bytes[at + 1], bytes[at + 4..at + 2 + length].to_vec()));
        at += 2 + length;
        if parts.last().is_some_and(|part| part.0 == SCAN) {
            return (parts, bytes[at..bytes.len() - 2].to_vec());
        }
    }
}

const SCAN: u8 = 0xda;
const FRAME: u8 = 0xc0;

fn add(file: &mut Vec<u8>, (marker, content): &Part) {
    file.extend([0xff, *marker]);
    file.extend((content.len() as u16).wrapping_add(2).to_be_bytes());
    file.extend(content);
}

impl Segment {
    fn parts(self, many: Many, known: &[Part]) -> Vec<Part> {
        let again = |marker: u8| {
            let part =
                known.iter().find(|part| part.0 == marker).cloned().unwrap_or((0xfe, Vec::new()));
            let count = many.of(part.1.len() + 4);
            vec![part; count]
        };
        let filled = |start: &[u8]| [start, &vec![0; many.of(1).min(65_000)]].concat();
        match self {
            Self::Comment => vec![(0xfe, filled(b""))],
            Self::Exif => {
                let entry = b"\x87\x69\0\x04\0\xff\xff\xff\0\0\0\x08";
                let count = many.of(12).min(5_000);
                let start = b"Exif\0\0MM\0\x2a\0\0\0\x08";
                let entries = entry.repeat(count);
                vec![(0xe1, [start, &(count as u16).to_be_bytes()[..], &entries].concat())]
            }
            Self::Profile => {
                let count = many.of(40).min(255) as u8;
                let part = |at: u8| (0xe2, [b"ICC_PROFILE\0", &[at, count][..], &[0; 9]].concat());
                (1..=count).map(part).collect()
            }
            Self::Xmp => vec![(0xe1, filled(b"http://ns.adobe.com/xap/1.0/\0"))],
            Self::Quantization => again(0xdb),
            Self::Huffman => again(0xc4),
            Self::Repeated => vec![(0xfe, Vec::new()); many.of(4)],
            Self::Fill => Vec::new(),
        }
    }
}

impl Choices {
    fn file(&self) -> Vec<u8> {
        let (mut parts, mut data) = parts(self.is_rgb);
        let known = parts.clone();
        let (_, scan) = parts.pop().unwrap_or_default();
        for (marker, content) in parts.iter_mut().filter(|part| part.0 == FRAME) {
            for (at, side) in self.sides.into_iter().flatten().enumerate() {
                content[1 + 2 * at..][..2].copy_from_slice(&(side.0 as u16).to_be_bytes());
            }
            if let Some((side, to)) = self.side {
                to.patch(content, 1 + 2 * usize::from(side), 2, true);
            }
            if let Some((component, factors)) = self.sampling {
                let at = 7 + 3 * (usize::from(component) % 3);
                content.get_mut(at).into_iter().for_each(|it| *it = factors);
            }
            if self.scans.is_some_and(|scans| scans.is_progressive) {
                *marker = 0xc2;
            }
        }
        let mut file = vec![0xff, 0xd8];
        parts.iter().for_each(|part| add(&mut file, part));
        if let Some((segment, many)) = self.segment {
            segment.parts(many, &known).iter().for_each(|part| add(&mut file, part));
            if matches!(segment, Segment::Fill) {
                file.resize(file.len() + many.of(1), 0xff);
            }
        }
        if let Some(to) = self.restart {
            add(&mut file, &(0xdd, (to.instead_of(4) as u16).to_be_bytes().to_vec()));
        }
        if let Some(many) = self.data {
            data = data.repeat(many.of(data.len()).max(1));
        }
        match self.scans {
            None => add(&mut file, &(SCAN, scan.clone())),
            Some(scans) => {
                let mut scan = scan.clone();
                if scans.is_progressive {
                    let end = scan.len() - 3;
                    let (first, last) = if scans.is_direct { (0, 0) } else { (1, 63) };
                    scan.splice(end.., [first, last, scans.bits & 0x33]);
                }
                // The data of the last one follows; the others have a byte.
                for _ in 0..scans.count.of(scan.len() + 5) {
                    add(&mut file, &(SCAN, scan.clone()));
                    file.push(0);
                }
                add(&mut file, &(SCAN, scan));
            }
        }
        file.extend(data);
        file.extend([0xff, 0xd9]);
        self.patch.into_iter().for_each(|patch| patch.apply(&mut file, true));
        file
    }
}

pub(crate) fn file(bytes: &[u8]) -> Vec<u8> {
    choose::<Choices>(bytes).map_or_else(Vec::new, |choices| choices.file())
}

pub(crate) fn run(bytes: &[u8]) {
    reading::image(&file(bytes));
}
