//! Compressed strips and tiles.

use std::io::{self, Read, Seek};

use flate2::bufread::ZlibDecoder;
use weezl::BitOrder;
use weezl::decode::Configuration;

use super::directory::Directory;
use super::embedded_jpeg::EmbeddedJpeg;
use super::layout::{Color, Samples};
use super::tags::{self, compression};
use super::unsupported;
use crate::ImageError;

/// How strips and tiles are compressed.
#[derive(Debug)]
pub(super) enum Compression {
    None,
    Lzw,
    Deflate,
    PackBits,
    Jpeg(EmbeddedJpeg),
}

impl Compression {
    /// # Errors
    /// [`ImageError::Unsupported`], with the name of a compression that isn't read.
    pub(super) fn read<R: Read + Seek>(
        directory: &mut Directory<R>,
        samples: &Samples,
        color: &Color,
    ) -> Result<Self, ImageError> {
        let number = directory.short(tags::COMPRESSION)?.unwrap_or(compression::NONE);
        Ok(match number {
            compression::NONE => Self::None,
            compression::LZW => Self::Lzw,
            compression::DEFLATE | compression::OLD_DEFLATE => Self::Deflate,
            compression::PACK_BITS => Self::PackBits,
            compression::JPEG => Self::Jpeg(EmbeddedJpeg::read(directory, samples, color)?),
            other => {
                let wanted = "save it with ZIP (Deflate), LZW or no compression, for example by \
                              `magick IN.tif -compress zip OUT.tif`";
                let found = name(other).map_or_else(
                    || format!("compression {other}"),
                    |name| format!("{name} compression"),
                );
                return Err(unsupported(found, wanted));
            }
        })
    }

    pub(super) fn is_jpeg(&self) -> bool {
        matches!(self, Self::Jpeg(_))
    }
}

/// The name of a compression that isn't read.
fn name(number: u16) -> Option<&'static str> {
    Some(match number {
        2 => "fax (CCITT RLE)",
        3 => "fax (CCITT group 3)",
        4 => "fax (CCITT group 4)",
        6 => "old-style JPEG",
        9 | 10 | 34_661 => "JBIG",
        22_610 | 34_934 => "JPEG XR",
        32_766 => "NeXT",
        32_809 => "ThunderScan",
        33_003 | 33_004 | 33_005 | 34_712 => "JPEG 2000",
        34_676 | 34_677 => "SGI LogLuv",
        34_887 => "LERC",
        34_892 => "lossy JPEG (DNG)",
        34_925 => "LZMA",
        34_926 | 50_000 => "Zstandard",
        34_927 | 50_001 => "WebP",
        34_933 => "PNG",
        50_002 | 52_546 => "JPEG XL",
        _ => return None,
    })
}

/// Decompresses a strip or tile, but for JPEG.
pub(super) fn reader<'a>(compression: &Compression, bytes: &'a [u8]) -> Box<dyn Read + 'a> {
    match compression {
        Compression::None | Compression::Jpeg(_) => Box::new(bytes),
        Compression::Lzw => Box::new(Lzw::new(bytes)),
        Compression::Deflate => Box::new(ZlibDecoder::new(bytes)),
        Compression::PackBits => Box::new(PackBits { bytes, run: Run::Literal(0) }),
    }
}

/// # Source
/// TIFF 6.0, section 13; libtiff for the files of its first versions, which have codes from the lowest bit of a byte on
/// and lengthen them one code later.
struct Lzw<'a> {
    bytes: &'a [u8],
    decoder: weezl::decode::Decoder,
}

impl<'a> Lzw<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        // Both begin with code 256 of 9 bits.
        let is_old = matches!(bytes, [0, second, ..] if second & 1 == 1);
        let configuration = if is_old {
            Configuration::new(BitOrder::Lsb, 8)
        } else {
            Configuration::with_tiff_size_switch(BitOrder::Msb, 8)
        };
        Self { bytes, decoder: configuration.with_yield_on_full_buffer(true).build() }
    }
}

impl Read for Lzw<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        loop {
            let result = self.decoder.decode_bytes(self.bytes, out);
            self.bytes = &self.bytes[result.consumed_in..];
            match result.status {
                Err(error) => return Err(io::Error::new(io::ErrorKind::InvalidData, error)),
                // Neither input nor output: the end.
                Ok(weezl::LzwStatus::NoProgress | weezl::LzwStatus::Done) => {
                    return Ok(result.consumed_out);
                }
                Ok(weezl::LzwStatus::Ok) if result.consumed_out > 0 || out.is_empty() => {
                    return Ok(result.consumed_out);
                }
                Ok(weezl::LzwStatus::Ok) => {}
            }
        }
    }
}

/// # Source
/// TIFF 6.0, section 9.
struct PackBits<'a> {
    bytes: &'a [u8],
    run: Run,
}

/// What is left of a run.
#[derive(Debug, Clone, Copy)]
enum Run {
    Literal(usize),
    Repeated(usize, u8),
}

impl PackBits<'_> {
    fn byte(&mut self) -> Option<u8> {
        let (&byte, rest) = self.bytes.split_first()?;
        self.bytes = rest;
        Some(byte)
    }
}

impl Read for PackBits<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        while let Run::Literal(0) | Run::Repeated(0, _) = self.run {
            let Some(header) = self.byte() else { return Ok(0) };
            self.run = match header {
                0..=127 => Run::Literal(usize::from(header) + 1),
                128 => continue,
                129..=255 => match self.byte() {
                    Some(byte) => Run::Repeated(257 - usize::from(header), byte),
                    None => return Ok(0),
                },
            };
        }
        match &mut self.run {
            Run::Repeated(left, byte) => {
                let count = out.len().min(*left);
                out[..count].fill(*byte);
                *left -= count;
                Ok(count)
            }
            Run::Literal(left) => {
                let wanted = out.len().min(*left);
                let count = self.bytes.read(&mut out[..wanted])?;
                *left -= count;
                Ok(count)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(reader: impl Read) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut reader = reader;
        reader.read_to_end(&mut bytes).unwrap();
        bytes
    }

    #[test]
    fn runs_of_bytes() {
        // The example of TIFF 6.0, section 9, with a header that means nothing.
        let packed = [
            0xfe, 0xaa, 0x02, 0x80, 0x00, 0x2a, 0x80, 0xfd, 0xaa, 0x03, 0x80, 0x00, 0x2a, 0x22,
            0xf7, 0xaa,
        ];
        let wanted = [
            0xaa, 0xaa, 0xaa, 0x80, 0x00, 0x2a, 0xaa, 0xaa, 0xaa, 0xaa, 0x80, 0x00, 0x2a, 0x22,
            0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa,
        ];
        let unpacked = |end| all(PackBits { bytes: &packed[..end], run: Run::Literal(0) });
        assert_eq!(unpacked(packed.len()), wanted);
        assert_eq!(unpacked(packed.len() - 1), wanted[..14]);
        assert_eq!(unpacked(4), wanted[..4]);
    }

    #[test]
    fn both_kinds_of_lzw() {
        let mut random = fastrand::Rng::with_seed(3);
        let bytes: Vec<u8> = (0..20_000).map(|at| random.u8(..8) + (at / 100) as u8).collect();
        let new = weezl::encode::Encoder::with_tiff_size_switch(BitOrder::Msb, 8).encode(&bytes);
        assert_eq!(all(Lzw::new(&new.unwrap())), bytes);
        let old = weezl::encode::Encoder::new(BitOrder::Lsb, 8).encode(&bytes).unwrap();
        assert_eq!((old[0], old[1] & 1), (0, 1));
        assert_eq!(all(Lzw::new(&old)), bytes);
    }
}
