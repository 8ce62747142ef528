//! Our own decoder for buffer views compressed by meshoptimizer.
//!
//! # Source
//! Khronos, "EXT_meshopt_compression" and "KHR_meshopt_compression", appendices A (bitstream) and B
//! (filters). The latter adds a version of the bitstream for attributes and a filter for colours, so
//! one decoder reads both.

mod filters;
mod indices;
mod vertices;

use crate::scene::document::Compressed;

impl Compressed {
    /// Size of the decoded data, in bytes.
    pub fn decoded_length(&self) -> u64 {
        self.count.saturating_mul(self.byte_stride)
    }

    /// Decodes the elements, concatenated; the caller has limited their number.
    ///
    /// - `bytes`: the compressed stream.
    ///
    /// # Errors
    /// A description of the problem, if the stream or its parameters are invalid.
    pub fn decode(&self, bytes: &[u8]) -> Result<Vec<u8>, String> {
        let (count, stride) = (self.count as usize, self.byte_stride as usize);
        let mut decoded = match self.mode.as_str() {
            "ATTRIBUTES" => vertices::decode(bytes, count, stride)?,
            "TRIANGLES" => indices::triangles(bytes, count, stride)?,
            "INDICES" => indices::sequence(bytes, count, stride)?,
            other => {
                return Err(format!(
                    "mode must be ATTRIBUTES, TRIANGLES or INDICES, got {other:?}"
                ));
            }
        };
        match self.filter.as_deref().unwrap_or("NONE") {
            "NONE" => {}
            _ if self.mode != "ATTRIBUTES" => return Err("indices cannot have a filter".to_owned()),
            "OCTAHEDRAL" => filters::octahedral(&mut decoded, stride)?,
            "QUATERNION" => filters::quaternion(&mut decoded, stride)?,
            "EXPONENTIAL" => filters::exponential(&mut decoded, stride)?,
            "COLOR" => filters::color(&mut decoded, stride)?,
            other => {
                return Err(format!(
                    "filter must be OCTAHEDRAL, QUATERNION, EXPONENTIAL or COLOR, got {other:?}"
                ));
            }
        }
        Ok(decoded)
    }
}

/// A byte stream, read front to back.
struct Stream<'a>(&'a [u8]);

impl<'a> Stream<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or("truncated stream")?;
        self.0 = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Result<u8, String> {
        Ok(self.take(1)?[0])
    }

    /// A variable-length integer (LEB128): seven bits in each byte, lowest first; the
    /// highest bit marks continuation.
    fn number(&mut self) -> Result<u32, String> {
        let mut number = 0;
        for shift in (0..35).step_by(7) {
            let byte = self.byte()?;
            number |= u32::from(byte & 127).wrapping_shl(shift);
            if byte < 128 {
                break;
            }
        }
        Ok(number)
    }

    fn finish(self) -> Result<(), String> {
        if self.0.is_empty() {
            Ok(())
        } else {
            Err(format!("stream has {} excess bytes", self.0.len()))
        }
    }
}

/// Zigzag decoding: 0, 1, 2, 3, … stand for 0, -1, 1, -2, …
const fn signed(zigzag: u32) -> u32 {
    (zigzag >> 1) ^ (zigzag & 1).wrapping_neg()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_modes_and_filters_are_named() {
        let view = |mode: &str, filter: Option<&str>| Compressed {
            buffer: 0,
            byte_offset: 0,
            byte_length: 0,
            byte_stride: 4,
            count: 0,
            mode: mode.to_owned(),
            filter: filter.map(str::to_owned),
        };
        assert!(view("MEAN", None).decode(&[]).unwrap_err().contains("\"MEAN\""));
        let empty = [&[0xa0][..], &[0; 32]].concat();
        assert_eq!(view("ATTRIBUTES", None).decode(&empty), Ok(Vec::new()));
        assert!(view("ATTRIBUTES", Some("SOFT")).decode(&empty).unwrap_err().contains("SOFT"));
        let indices = [&[0xd1][..], &[0; 4]].concat();
        assert!(view("INDICES", Some("OCTAHEDRAL")).decode(&indices).is_err());
        assert!(view("ATTRIBUTES", None).decode(&empty[..20]).is_err());
    }

    #[test]
    fn numbers_have_seven_bits_a_byte() {
        assert_eq!(Stream(&[0x05]).number(), Ok(5));
        assert_eq!(Stream(&[0x80, 0x01]).number(), Ok(128));
        assert!(Stream(&[0x80]).number().is_err());
        assert_eq!([0, 1, 2, 3].map(signed), [0, u32::MAX, 1, u32::MAX - 1]);
    }
}
