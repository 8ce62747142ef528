//! EXRs: windows, channels, attributes, tiles, levels and chunks of any number and size.

use arbitrary::Arbitrary;

use super::number::{Many, Number, Patch};
use super::{MAX_BYTES, choose, png, reading};
use crate::exr_seeds::attribute;

#[derive(Debug, Arbitrary)]
struct Choices {
    sides: [Many; 2],
    corner: Option<[i16; 2]>,
    channels: u8,
    repeated: Option<Many>,
    is_half: bool,
    compression: u8,
    tile: Option<([u8; 2], u8)>,
    attributes: Option<Many>,
    value: Option<Many>,
    changes: [Option<Change>; 2],
}

/// What does not fit the rest.
#[derive(Debug, Clone, Copy, Arbitrary)]
enum Change {
    Number(Place, Number),
    /// The length of the first channel's name.
    Name(Many),
    Any(Patch),
}

/// A number of the file.
#[derive(Debug, Clone, Copy, PartialEq, Arbitrary)]
enum Place {
    Width,
    Height,
    Display,
    Sampling,
    /// The length of an attribute.
    Attribute,
    /// Bytes of a block before it is compressed.
    Block,
    /// The length of a block.
    Length,
    /// Where the first block is.
    Offset,
}

const CHANNELS: [&[&str]; 5] =
    [&["Y"], &["B", "G", "R"], &["A", "B", "G", "R"], &["BY", "RY", "Y"], &["A", "Y"]];

impl Choices {
    fn channel(&self, name: &str, sampling: i32) -> Vec<u8> {
        let kind = if self.is_half { 1 } else { 2 };
        let numbers = [kind, 0, sampling, sampling].map(i32::to_le_bytes);
        [name.as_bytes(), b"\0", numbers.as_flattened()].concat()
    }

    /// A number, changed if it is chosen.
    fn number(&self, place: Place, was: u64) -> u64 {
        self.changes.iter().flatten().fold(was, |was, change| match *change {
            Change::Number(found, to) if found == place => to.instead_of(was),
            _ => was,
        })
    }

    fn channels(&self) -> Vec<Vec<u8>> {
        let names = CHANNELS[usize::from(self.channels) % CHANNELS.len()];
        let mut channels: Vec<Vec<u8>> = Vec::new();
        for (index, name) in names.iter().enumerate() {
            let sampling = if name.len() == 2 { 2 } else { 1 };
            let mut name = name.to_string();
            if index == 0 {
                for change in self.changes.iter().flatten() {
                    let Change::Name(many) = change else { continue };
                    name.extend(std::iter::repeat_n('x', many.of(1)));
                }
            }
            channels.push(self.channel(&name, self.number(Place::Sampling, sampling) as i32));
        }
        for at in 0..self.repeated.map_or(0, |many| many.of(24)) {
            channels.push(self.channel(&format!("Z{at:06}"), 1));
        }
        channels
    }

    fn file(&self) -> Vec<u8> {
        let [width, height] = self.sides.map(|side| side.0 as u64);
        let sides = [self.number(Place::Width, width), self.number(Place::Height, height)];
        let [x, y] = self.corner.unwrap_or_default().map(i32::from);
        let last = [(x, sides[0]), (y, sides[1])]
            .map(|(from, side)| from.wrapping_add(side as i32).wrapping_sub(1));
        let window = [x, y, last[0], last[1]].map(i32::to_le_bytes);
        let display = [x, y, self.number(Place::Display, last[0] as u64) as i32, last[1]];
        let display = display.map(i32::to_le_bytes);
        let channels = self.channels();
        let bytes_each = channels.len() * if self.is_half { 2 } else { 4 };
        // The decoder of B44 panics on some halves.
        let compression = match self.compression % 11 {
            6 | 7 if self.is_half => 4,
            other => other,
        };
        let one = 1_f32.to_le_bytes();
        let version = if self.tile.is_some() { 0x202 } else { 2 };
        let mut file = [
            [0x0131_2f76, version].map(u32::to_le_bytes).as_flattened().to_vec(),
            attribute("channels", "chlist", &[channels.concat(), vec![0]].concat()),
            attribute("compression", "compression", &[compression]),
            attribute("dataWindow", "box2i", window.as_flattened()),
            attribute("displayWindow", "box2i", display.as_flattened()),
            attribute("lineOrder", "lineOrder", &[0]),
            attribute("pixelAspectRatio", "float", &one),
            attribute("screenWindowCenter", "v2f", &[0; 8]),
            attribute("screenWindowWidth", "float", &one),
        ]
        .concat();
        if let Some(([width, height], mode)) = self.tile {
            let sides =
                [width, height].map(|side| 16 * u32::from(side % 32 + 1)).map(u32::to_le_bytes);
            let tiles = [sides.as_flattened(), &[mode % 3]].concat();
            file.extend(attribute("tiles", "tiledesc", &tiles));
        }
        if let Some(many) = self.value {
            let mut long = attribute("comment", "string", &vec![b'a'; many.of(1)]);
            // The length of the value is behind both names.
            let length = self.number(Place::Attribute, many.of(1) as u64) as u32;
            long[15..19].copy_from_slice(&length.to_le_bytes());
            file.extend(long);
        }
        for at in 0..self.attributes.map_or(0, |many| many.of(24)) {
            file.extend(attribute(&at.to_string(), "int", &[0; 4]));
        }
        file.push(0);
        self.chunks(&mut file, sides, y, bytes_each, compression);
        for change in self.changes.iter().flatten() {
            if let Change::Any(patch) = change {
                patch.apply(&mut file, false);
            }
        }
        file
    }

    /// The table of offsets, and blocks of zeros.
    fn chunks(
        &self,
        file: &mut Vec<u8>,
        [width, height]: [u64; 2],
        top: i32,
        each: usize,
        kind: u8,
    ) {
        let rows = match kind {
            3 | 5 => 16,
            4 | 6 | 7 | 8 => 32,
            9 => 256,
            _ => 1,
        };
        let count = match self.tile {
            Some(([wide, high], _)) => {
                let [wide, high] = [wide, high].map(|side| 16 * u64::from(side % 32 + 1));
                width.div_ceil(wide).saturating_mul(height.div_ceil(high))
            }
            None => height.div_ceil(rows),
        };
        let count = count.min((MAX_BYTES / 32) as u64) as usize;
        let plain = (width as usize).saturating_mul(each).saturating_mul(rows as usize);
        let plain = self.number(Place::Block, plain as u64);
        let plain = plain.min((2 * MAX_BYTES / count.max(1) + 64) as u64) as usize;
        let block = match kind {
            2 | 3 => png::zlib(&vec![0; plain]),
            1 => [127, 0].repeat(plain.div_ceil(128)),
            _ => vec![0; plain],
        };
        let head = if self.tile.is_some() { 20 } else { 8 };
        let first = file.len() + 8 * count;
        for index in 0..count {
            let at = (first + index * (head + block.len())) as u64;
            let at = if index == 0 { self.number(Place::Offset, at) } else { at };
            file.extend(at.to_le_bytes());
        }
        for index in 0..count {
            if self.tile.is_some() {
                file.extend([index as i32, 0, 0, 0].map(i32::to_le_bytes).as_flattened());
            } else {
                file.extend(top.wrapping_add(index as i32 * rows as i32).to_le_bytes());
            }
            let length = block.len() as u64;
            let length = if index == 0 { self.number(Place::Length, length) } else { length };
            file.extend((length as u32).to_le_bytes());
            file.extend(&block);
        }
    }
}

pub(crate) fn file(bytes: &[u8]) -> Vec<u8> {
    choose::<Choices>(bytes).map_or_else(Vec::new, |choices| choices.file())
}

pub(crate) fn run(bytes: &[u8]) {
    reading::image(&file(bytes));
}
