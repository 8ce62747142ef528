//! WebPs: sides of lossless images of one colour, of canvases and animations; chunks of any length.

use arbitrary::Arbitrary;

use super::number::{Many, Number, Patch};
use super::{choose, reading};

#[derive(Debug, Arbitrary)]
struct Choices {
    sides: [Many; 2],
    is_extended: bool,
    flags: u8,
    kind: Kind,
    chunk: Option<(u8, Many)>,
    repeated: Option<Many>,
    damage: Option<Damage>,
}

/// What does not fit the rest.
#[derive(Debug, Clone, Copy, Arbitrary)]
enum Damage {
    Canvas([Number; 2]),
    Length(Number),
    Any(Patch),
}

#[derive(Debug, Clone, Copy, Arbitrary)]
enum Kind {
    Lossless,
    Lossy,
    /// Frames that each cover the canvas.
    Animated(Many),
    /// Alpha of one value, beside a lossy image.
    Alpha,
}

fn add(file: &mut Vec<u8>, name: &[u8; 4], content: &[u8]) {
    file.extend(name);
    file.extend((content.len() as u32).to_le_bytes());
    file.extend(content);
    file.resize(file.len().next_multiple_of(2), 0);
}

/// Texels that take no bits, however many there are: no transform, no cache, no groups, and then five
/// codes of one symbol, which has one bit and is 0.
const ONE_COLOR: [u8; 3] = [0b1000_1000, 0b1000_1000, 0b0000_1000];

/// A lossless image of one colour.
fn lossless([width, height]: [u32; 2]) -> Vec<u8> {
    let sides = width.wrapping_sub(1) & 0x3fff | (height.wrapping_sub(1) & 0x3fff) << 14;
    let mut stream = vec![0x2f];
    stream.extend(sides.to_le_bytes());
    stream.extend(ONE_COLOR);
    stream
}

/// The header of a lossy image, and partitions of zeros.
fn lossy([width, height]: [u32; 2]) -> Vec<u8> {
    let mut stream = vec![0x10, 0x02, 0, 0x9d, 0x01, 0x2a];
    [width, height].iter().for_each(|&side| stream.extend((side as u16 & 0x3fff).to_le_bytes()));
    stream.resize(stream.len() + 64, 0);
    stream
}

const EXTRA: [&[u8; 4]; 4] = [b"ICCP", b"EXIF", b"XMP ", b"ABCD"];

impl Choices {
    fn file(&self) -> Vec<u8> {
        let sides = self.sides.map(|side| side.0.min(1 << 14) as u32);
        let mut file = b"RIFF\0\0\0\0WEBP".to_vec();
        let is_extended = self.is_extended || !matches!(self.kind, Kind::Lossless | Kind::Lossy);
        if is_extended {
            let mut canvas = sides.map(u64::from);
            if let Some(Damage::Canvas(to)) = self.damage {
                canvas = [0, 1].map(|side| to[side].instead_of(canvas[side]));
            }
            let flags = match self.kind {
                Kind::Animated(_) => self.flags | 0x02,
                Kind::Alpha => self.flags | 0x10,
                _ => self.flags,
            };
            let [width, height] = canvas.map(|side| (side as u32).wrapping_sub(1).to_le_bytes());
            add(&mut file, b"VP8X", &[&[flags, 0, 0, 0], &width[..3], &height[..3]].concat());
        }
        if let Some((name, many)) = self.chunk {
            add(&mut file, EXTRA[usize::from(name) % EXTRA.len()], &vec![0; many.of(1)]);
        }
        for _ in 0..self.repeated.map_or(0, |many| many.of(10)) {
            add(&mut file, b"ABCD", b"");
        }
        match self.kind {
            Kind::Lossless => add(&mut file, b"VP8L", &lossless(sides)),
            Kind::Lossy => add(&mut file, b"VP8 ", &lossy(sides)),
            Kind::Alpha => {
                add(&mut file, b"ALPH", &[&[1], &ONE_COLOR[..]].concat());
                add(&mut file, b"VP8 ", &lossy(sides));
            }
            Kind::Animated(many) => {
                add(&mut file, b"ANIM", &[0; 6]);
                let [width, height] = sides.map(|side| side.wrapping_sub(1).to_le_bytes());
                let mut frame = [&[0; 6], &width[..3], &height[..3], &[9, 0, 0, 0]].concat();
                add(&mut frame, b"VP8L", &lossless(sides));
                (0..many.of(frame.len())).for_each(|_| add(&mut file, b"ANMF", &frame));
            }
        }
        let length = (file.len() as u32 - 8).to_le_bytes();
        file[4..8].copy_from_slice(&length);
        match self.damage {
            Some(Damage::Length(to)) => to.patch(&mut file, 4, 4, false),
            Some(Damage::Any(patch)) => patch.apply(&mut file, false),
            Some(Damage::Canvas(_)) | None => {}
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

#[cfg(test)]
mod tests {
    use uvgraft_image as image;

    use super::*;

    #[test]
    fn an_image_of_one_colour_is_one() {
        let mut file = b"RIFF\x14\0\0\0WEBP".to_vec();
        add(&mut file, b"VP8L", &lossless([70, 50]));
        let image = image::decode(&file).unwrap();
        assert_eq!((image.texture.size().width, image.texture.size().height), (70, 50));
    }
}
