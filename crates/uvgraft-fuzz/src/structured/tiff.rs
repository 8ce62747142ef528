//! TIFFs: sides, counts, offsets and lists of any length, in strips and tiles, of all compressions.

use arbitrary::Arbitrary;

use super::number::{Many, Number, Patch};
use super::{MAX_BYTES, choose, png, reading};

#[derive(Debug, Arbitrary)]
struct Choices {
    is_big_endian: bool,
    is_big: bool,
    sides: [Many; 2],
    kind: u8,
    compression: u8,
    rows_per_strip: Option<Many>,
    tile: Option<[u8; 2]>,
    is_planar: Option<bool>,
    predictor: Option<u8>,
    data: Option<Many>,
    profile: Option<Many>,
    tag: Option<(u8, Number)>,
    count: Option<(u8, Number)>,
    tags: Option<Many>,
    directories: Option<bool>,
    patch: Option<Patch>,
}

/// Photometric interpretation, bits of a channel, number of channels, kind of numbers.
const KINDS: [[u32; 4]; 8] = [
    [1, 8, 1, 1],
    [2, 8, 3, 1],
    [2, 8, 4, 1],
    [2, 16, 3, 1],
    [1, 32, 1, 3],
    [0, 1, 1, 1],
    [3, 8, 1, 1],
    [6, 8, 3, 1],
];

/// None, LZW, JPEG, Deflate, PackBits, and an unknown one.
const COMPRESSIONS: [u32; 8] = [1, 1, 8, 8, 32_773, 5, 7, 50_000];

/// A tag: its number, the width of its values in bytes, and these.
struct Tag(u16, usize, Vec<u32>);

impl Choices {
    fn number(&self, number: u64, width: usize) -> Vec<u8> {
        let (little, big) = (number.to_le_bytes(), number.to_be_bytes());
        if self.is_big_endian { big[8 - width..].to_vec() } else { little[..width].to_vec() }
    }

    /// Zeros, compressed.
    fn data(&self, compression: u32, count: usize) -> Vec<u8> {
        let count = self.data.map_or(count, |many| many.0).min(4 * MAX_BYTES);
        match compression {
            8 => png::zlib(&vec![0; count]),
            // Runs of 128 zeros.
            32_773 => [0x81, 0].repeat(count.div_ceil(128)),
            // Clear, then codes of zeros.
            5 => [&[0x80, 0x00][..], &vec![0; count / 64]].concat(),
            _ => vec![0; count.min(MAX_BYTES)],
        }
    }

    fn tags(&self, at: usize) -> (Vec<Tag>, Vec<u8>) {
        let [photometric, bits, channels, numbers] = KINDS[usize::from(self.kind) % KINDS.len()];
        let compression = COMPRESSIONS[usize::from(self.compression) % COMPRESSIONS.len()];
        let [width, height] = self.sides.map(|side| side.0);
        let is_planar = self.is_planar == Some(true);
        let mut tags = vec![
            Tag(256, 4, vec![width as u32]),
            Tag(257, 4, vec![height as u32]),
            Tag(258, 2, vec![bits; channels as usize]),
            Tag(259, 2, vec![compression]),
            Tag(262, 2, vec![photometric]),
            Tag(277, 2, vec![channels]),
            Tag(284, 2, vec![1 + u32::from(is_planar)]),
            Tag(317, 2, vec![self.predictor.map_or(1, |it| u32::from(it % 4))]),
            Tag(339, 2, vec![numbers; channels as usize]),
        ];
        if photometric == 3 {
            tags.push(Tag(320, 2, vec![5_000; 3 << bits]));
        }
        if let Some(profile) = self.profile {
            tags.push(Tag(34_675, 1, vec![0; profile.of(1)]));
        }
        let row = |width: usize| width.saturating_mul((bits * channels) as usize).div_ceil(8);
        let (each, count) = match self.tile {
            Some(sides) => {
                let [wide, high] = sides.map(|side| 16 * (usize::from(side % 64) + 1));
                tags.extend([Tag(322, 4, vec![wide as u32]), Tag(323, 4, vec![high as u32])]);
                (row(wide) * high, width.div_ceil(wide).saturating_mul(height.div_ceil(high)))
            }
            None => {
                let rows = self.rows_per_strip.map_or(height, |many| many.0).min(height.max(1));
                tags.push(Tag(278, 4, vec![rows as u32]));
                (row(width).saturating_mul(rows), height.div_ceil(rows.max(1)))
            }
        };
        let count = count.max(1) * if is_planar { channels as usize } else { 1 };
        let count = count.min(MAX_BYTES / 8);
        // All of them share their data.
        let data = self.data(compression, each);
        let [offsets, counts] = if self.tile.is_some() { [324, 325] } else { [273, 279] };
        tags.push(Tag(offsets, 4, vec![at as u32; count]));
        tags.push(Tag(counts, 4, vec![data.len() as u32; count]));
        for number in 0..self.tags.map_or(0, |many| many.of(12).min(60_000)) {
            tags.push(Tag(40_000 + (number % 20_000) as u16, 4, vec![1]));
        }
        if let Some((which, to)) = self.tag {
            let which = usize::from(which) % tags.len();
            tags[which]
                .2
                .iter_mut()
                .take(1)
                .for_each(|it| *it = to.instead_of((*it).into()) as u32);
        }
        tags.sort_by_key(|tag| tag.0);
        (tags, data)
    }

    fn file(&self) -> Vec<u8> {
        let word = if self.is_big { 8 } else { 4 };
        let mut file = if self.is_big_endian { b"MM".to_vec() } else { b"II".to_vec() };
        if self.is_big {
            [43, 8, 0].iter().for_each(|&number| file.extend(self.number(number, 2)));
        } else {
            file.extend(self.number(42, 2));
        }
        let first = file.len();
        file.resize(first + word, 0);
        let (tags, data) = self.tags(file.len());
        file.extend(data);
        let changed = self.count.map(|(which, to)| (usize::from(which) % tags.len(), to));
        let mut directory = self.number(tags.len() as u64, if self.is_big { 8 } else { 2 });
        for (index, Tag(tag, width, values)) in tags.iter().enumerate() {
            let kind = match width {
                1 => 1,
                2 => 3,
                _ => 4,
            };
            let count = values.len() as u64;
            let count =
                changed.filter(|it| it.0 == index).map_or(count, |it| it.1.instead_of(count));
            directory.extend(self.number((*tag).into(), 2));
            directory.extend(self.number(kind, 2));
            directory.extend(self.number(count, word));
            let mut value: Vec<u8> =
                values.iter().flat_map(|&value| self.number(value.into(), *width)).collect();
            if value.len() > word {
                let at = file.len() as u64;
                file.extend(value);
                value = self.number(at, word);
            }
            value.resize(word, 0);
            directory.extend(value);
        }
        let at = file.len() as u64;
        // The directory may be followed by itself.
        let next = if self.directories == Some(true) { at } else { 0 };
        directory.extend(self.number(next, word));
        file.extend(directory);
        file.splice(first..first + word, self.number(at, word));
        self.patch.into_iter().for_each(|patch| patch.apply(&mut file, self.is_big_endian));
        file
    }
}

pub(crate) fn file(bytes: &[u8]) -> Vec<u8> {
    choose::<Choices>(bytes).map_or_else(Vec::new, |choices| choices.file())
}

pub(crate) fn run(bytes: &[u8]) {
    reading::image(&file(bytes));
}
