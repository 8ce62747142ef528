//! EXIF blocks: what they say about orientation and focal length. All else, such as the place where
//! a photo was taken, is never read.
//!
//! A malformed block is ignored: the image itself may still be fine.
//!
//! Source: EXIF 2.32 (CIPA DC-008), sections 4.5 and 4.6; a block is a small TIFF file.

use uvgraft::texture::Size;

const ORIENTATION: u16 = 274;
pub(super) const EXIF_DIRECTORY: u16 = 34_665;
pub(super) const FOCAL_LENGTH: u16 = 37_386;
pub(super) const PIXEL_X_DIMENSION: u16 = 40_962;
pub(super) const PIXEL_Y_DIMENSION: u16 = 40_963;
pub(super) const FOCAL_PLANE_X_RESOLUTION: u16 = 41_486;
pub(super) const FOCAL_PLANE_RESOLUTION_UNIT: u16 = 41_488;
pub(super) const FOCAL_LENGTH_IN_35MM_FILM: u16 = 41_989;

const SHORT: u16 = 3;
const LONG: u16 = 4;
const RATIONAL: u16 = 5;

/// The diagonal of 35 mm film, whose frames have 36 × 24 mm.
const FILM_DIAGONAL_MM: f64 = 43.266_615;

/// Focal lengths beyond these multiples of the longer side are not believed: a fisheye's field of
/// view of 136°, and a telescope's of 1°.
const PLAUSIBLE: std::ops::RangeInclusive<f64> = 0.2..=50.0;

/// A block.
#[derive(Clone, Copy)]
struct Block<'a> {
    bytes: &'a [u8],
    big_endian: bool,
}

/// An entry of a directory.
#[derive(Clone, Copy)]
struct Entry {
    kind: u16,
    count: u32,
    /// Position of the value, or of the position of longer ones.
    value: usize,
}

impl<'a> Block<'a> {
    /// A block with or without the prefix `Exif\0\0`.
    fn new(exif: &'a [u8]) -> Option<Self> {
        let bytes = exif.strip_prefix(b"Exif\0\0").unwrap_or(exif);
        match bytes.first_chunk::<4>()? {
            b"II*\0" => Some(Self { bytes, big_endian: false }),
            b"MM\0*" => Some(Self { bytes, big_endian: true }),
            _ => None,
        }
    }

    fn short(self, at: usize) -> Option<u16> {
        let bytes = *self.bytes.get(at..)?.first_chunk()?;
        Some(if self.big_endian { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) })
    }

    fn long(self, at: usize) -> Option<u32> {
        let bytes = *self.bytes.get(at..)?.first_chunk()?;
        Some(if self.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    /// The position of the first directory.
    fn first_directory(self) -> Option<usize> {
        Some(self.long(4)? as usize)
    }

    fn find(self, directory: usize, tag: u16) -> Option<Entry> {
        let entries = usize::from(self.short(directory)?);
        let at = (0..entries)
            .map_while(|index| directory.checked_add(2 + index * 12))
            .find(|&entry| self.short(entry) == Some(tag))?;
        Some(Entry { kind: self.short(at + 2)?, count: self.long(at + 4)?, value: at + 8 })
    }

    /// A single number, if it has one of EXIF's unsigned types.
    fn number(self, directory: usize, tag: u16) -> Option<f64> {
        match self.find(directory, tag)? {
            Entry { kind: SHORT, count: 1, value } => self.short(value).map(f64::from),
            Entry { kind: LONG, count: 1, value } => self.long(value).map(f64::from),
            Entry { kind: RATIONAL, count: 1, value } => {
                let at = self.long(value)? as usize;
                Some(f64::from(self.long(at)?) / f64::from(self.long(at.checked_add(4)?)?))
            }
            _ => None,
        }
    }
}

/// The orientation tag of the first directory.
pub(super) fn orientation(exif: &[u8]) -> Option<u64> {
    let block = Block::new(exif)?;
    match block.find(block.first_directory()?, ORIENTATION)? {
        Entry { kind: SHORT, count: 1, value } => block.short(value).map(u64::from),
        _ => None,
    }
}

/// A block, without the prefix `Exif\0\0`, whose one tag is the orientation.
pub(super) fn of_orientation(tag: u16) -> Vec<u8> {
    let mut block = b"MM\0*\0\0\0\x08\0\x01".to_vec();
    // The value is left-aligned in four bytes; no directory follows.
    block.extend([ORIENTATION, SHORT, 0, 1, tag, 0, 0, 0].map(u16::to_be_bytes).concat());
    block
}

/// What a camera says about its focal length.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FocalLength {
    /// On film of 35 mm, in millimetres, with the same diagonal field of view.
    film_mm: Option<f64>,
    /// The actual one, in millimetres.
    lens_mm: Option<f64>,
    /// Pixels per unit on the sensor.
    resolution: Option<f64>,
    /// The unit, by its number.
    unit: Option<f64>,
    /// The sides of the image as the camera stored it, in pixels.
    sides: [Option<f64>; 2],
}

impl FocalLength {
    /// That of an EXIF block, with or without the prefix `Exif\0\0`. What is malformed is ignored.
    pub fn from_exif(exif: &[u8]) -> Self {
        let directory = || {
            let block = Block::new(exif)?;
            let entry = block.find(block.first_directory()?, EXIF_DIRECTORY)?;
            (entry.kind == LONG && entry.count == 1).then_some(())?;
            Some((block, block.long(entry.value)? as usize))
        };
        match directory() {
            Some((block, directory)) => Self::from_numbers(|tag| block.number(directory, tag)),
            None => Self::default(),
        }
    }

    /// - `number`: the value of a tag of the EXIF directory.
    pub(super) fn from_numbers(mut number: impl FnMut(u16) -> Option<f64>) -> Self {
        // A zero denominator gives infinity or NaN; 0 stands for unknown values.
        let mut positive = |tag| number(tag).filter(|&value| value > 0.0 && value.is_finite());
        Self {
            film_mm: positive(FOCAL_LENGTH_IN_35MM_FILM),
            lens_mm: positive(FOCAL_LENGTH),
            resolution: positive(FOCAL_PLANE_X_RESOLUTION),
            unit: positive(FOCAL_PLANE_RESOLUTION_UNIT),
            sides: [positive(PIXEL_X_DIMENSION), positive(PIXEL_Y_DIMENSION)],
        }
    }

    /// The focal length in pixels of an image that shows all of what the camera stored, in any
    /// size; `None` if the camera doesn't say, or says nonsense.
    ///
    /// The equivalent on film is preferred: the actual focal length takes the density of pixels on
    /// the sensor, which few cameras state.
    pub(super) fn pixels(&self, size: Size) -> Option<f64> {
        let (width, height) = (f64::from(size.width), f64::from(size.height));
        let longer = width.max(height);
        let plausible = |pixels: &f64| PLAUSIBLE.contains(&(pixels / longer));
        let by_film = self.film_mm.map(|film| film * width.hypot(height) / FILM_DIAGONAL_MM);
        let by_sensor = || {
            // Inches are the default.
            let unit_mm = match self.unit.unwrap_or(2.0) as u32 {
                2 => 25.4,
                3 => 10.0,
                4 => 1.0,
                5 => 1e-3,
                _ => return None,
            };
            let scale = match self.sides {
                [Some(x), Some(y)] => longer / x.max(y),
                _ => 1.0,
            };
            Some(self.lens_mm? * self.resolution? / unit_mm * scale)
        };
        by_film.filter(plausible).or_else(|| by_sensor().filter(plausible))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A directory entry, and what lies outside of it.
    enum Stored {
        Short(u16, u16),
        Long(u16, u32),
        Rational(u16, u32, u32),
    }

    /// A block in big-endian order: a first directory that leads to the EXIF directory.
    fn block(entries: &[Stored]) -> Vec<u8> {
        let mut bytes =
            b"Exif\0\0MM\0*\0\0\0\x08\0\x01\x87\x69\0\x04\0\0\0\x01\0\0\0\x1a\0\0\0\0".to_vec();
        let mut outside = Vec::new();
        let after = 26 + 2 + 12 * entries.len() + 4;
        bytes.extend((entries.len() as u16).to_be_bytes());
        for entry in entries {
            let (tag, kind) = match *entry {
                Stored::Short(tag, _) => (tag, SHORT),
                Stored::Long(tag, _) => (tag, LONG),
                Stored::Rational(tag, ..) => (tag, RATIONAL),
            };
            bytes.extend([tag, kind, 0, 1].map(u16::to_be_bytes).concat());
            match *entry {
                Stored::Short(_, value) => bytes.extend([value, 0].map(u16::to_be_bytes).concat()),
                Stored::Long(_, value) => bytes.extend(value.to_be_bytes()),
                Stored::Rational(_, over, under) => {
                    bytes.extend(((after + outside.len()) as u32).to_be_bytes());
                    outside.extend([over, under].map(u32::to_be_bytes).concat());
                }
            }
        }
        bytes.extend([0; 4]);
        bytes.extend(outside);
        bytes
    }

    fn pixels(entries: &[Stored], size: Size) -> Option<f64> {
        FocalLength::from_exif(&block(entries)).pixels(size)
    }

    fn near(found: Option<f64>, wanted: f64) -> bool {
        found.is_some_and(|found| (found / wanted - 1.0).abs() < 1e-6)
    }

    #[test]
    fn by_film_with_the_diagonal() {
        // A phone of 26 mm: 5000 pixels along the diagonal of 43.27 mm.
        let film = [Stored::Short(FOCAL_LENGTH_IN_35MM_FILM, 26)];
        for size in [Size::new(4000, 3000), Size::new(3000, 4000)] {
            assert!(near(pixels(&film, size), 26.0 * 5000.0 / 43.266_615));
        }
    }

    #[test]
    fn by_sensor_in_every_unit() {
        // 50 mm, 200 pixels per mm: 10,000 pixels of an image of 6000, 2000 of one of 1200.
        for (unit, over, under) in [(2, 5080, 1), (3, 2000, 1), (4, 400, 2), (5, 2, 10)] {
            let entries = [
                Stored::Rational(FOCAL_LENGTH, 500, 10),
                Stored::Long(PIXEL_X_DIMENSION, 6000),
                Stored::Short(PIXEL_Y_DIMENSION, 4000),
                Stored::Rational(FOCAL_PLANE_X_RESOLUTION, over, under),
                Stored::Short(FOCAL_PLANE_RESOLUTION_UNIT, unit),
                Stored::Short(FOCAL_LENGTH_IN_35MM_FILM, 0),
            ];
            assert!(near(pixels(&entries, Size::new(6000, 4000)), 10_000.0), "unit {unit}");
            assert!(near(pixels(&entries, Size::new(800, 1200)), 2000.0), "unit {unit}");
        }
        let in_inches = [
            Stored::Rational(FOCAL_LENGTH, 50, 1),
            Stored::Rational(FOCAL_PLANE_X_RESOLUTION, 5080, 1),
        ];
        assert!(near(pixels(&in_inches, Size::new(6000, 4000)), 10_000.0));
        // The actual focal length alone says nothing.
        assert_eq!(pixels(&in_inches[..1], Size::new(6000, 4000)), None);
    }

    #[test]
    fn nonsense_is_none() {
        let size = Size::new(4000, 3000);
        let rational = |over, under| {
            let entries = [
                Stored::Rational(FOCAL_LENGTH, over, under),
                Stored::Rational(FOCAL_PLANE_X_RESOLUTION, 5080, 1),
            ];
            pixels(&entries, size)
        };
        assert!(rational(50, 1).is_some());
        for (over, under) in [(0, 0), (1, 0), (0, 1), (1, u32::MAX), (u32::MAX, 1)] {
            assert_eq!(rational(over, under), None, "{over} / {under}");
        }
        assert_eq!(pixels(&[Stored::Short(FOCAL_LENGTH_IN_35MM_FILM, u16::MAX)], size), None);
        assert_eq!(pixels(&[Stored::Short(FOCAL_LENGTH_IN_35MM_FILM, 1)], size), None);
        let unit = [
            Stored::Rational(FOCAL_LENGTH, 50, 1),
            Stored::Rational(FOCAL_PLANE_X_RESOLUTION, 5080, 1),
            Stored::Short(FOCAL_PLANE_RESOLUTION_UNIT, 9),
        ];
        assert_eq!(pixels(&unit, size), None);
    }

    #[test]
    fn every_cut_and_every_changed_byte_is_survived() {
        let whole = block(&[
            Stored::Rational(FOCAL_LENGTH, 50, 1),
            Stored::Rational(FOCAL_PLANE_X_RESOLUTION, 5080, 1),
        ]);
        let size = Size::new(4000, 3000);
        for at in 0..whole.len() {
            assert_eq!(FocalLength::from_exif(&whole[..at]).pixels(size), None, "cut at {at}");
            for value in [0, 1, 0x7f, 0xff] {
                let mut changed = whole.clone();
                changed[at] = value;
                let found = FocalLength::from_exif(&changed).pixels(size);
                assert!(found.is_none_or(f64::is_finite));
            }
        }
    }
}
