//! The frame header of a JPEG: which process, size and components.
//!
//! Source: ITU-T T.81, B.2.2.

use uvgraft::texture::{Channels, Depth, Size};

use super::FORMAT;
use crate::ImageError;
use crate::header::check_size;

/// What a frame header says.
pub(super) struct Frame {
    /// The marker, which stands for the process.
    marker: u8,
    bits: u8,
    height: u16,
    width: u16,
    components: u8,
    /// Horizontal and vertical sampling factors of the first three components, in the halves of a byte.
    sampling: [u8; 3],
}

impl Frame {
    /// The content of a segment; `None` if its marker is that of no frame.
    pub(super) fn new(marker: u8, content: &[u8]) -> Option<Self> {
        // DHT, JPG and DAC are in the range of the frames' markers.
        let is_frame = matches!(marker, 0xc0..=0xcf) && ![0xc4, 0xc8, 0xcc].contains(&marker);
        let (&[bits, h0, h1, w0, w1, components], rest) = content.split_first_chunk()?;
        let sampling = |index: usize| rest.get(index * 3 + 1).copied().unwrap_or(0x11);
        is_frame.then(|| Self {
            marker,
            bits,
            height: u16::from_be_bytes([h0, h1]),
            width: u16::from_be_bytes([w0, w1]),
            components,
            sampling: [0, 1, 2].map(sampling),
        })
    }

    /// The size and the channels, if they can be read.
    pub(super) fn layout(&self) -> Result<(Size, Channels), ImageError> {
        let unsupported = |found| {
            let wanted = "supported are baseline and progressive JPEGs of 8 bits, greyscale or RGB; \
                          convert it first";
            Err(ImageError::Unsupported { format: FORMAT, found, wanted })
        };
        let channels = match (self.bits, self.components) {
            _ if self.process() != "" => {
                return unsupported(format!("{} of {} bits", self.process(), self.bits));
            }
            (8, 1) => Channels::Grey,
            (8, 3) => Channels::Rgb,
            (8, 4) => return unsupported("CMYK colours".to_owned()),
            (bits, components) => {
                return unsupported(format!("{components} channels of {bits} bits"));
            }
        };
        if self.height == 0 && self.width > 0 {
            return unsupported("a height that follows the image (DNL)".to_owned());
        }
        let sides = (self.width.into(), self.height.into());
        Ok((check_size(FORMAT, sides, channels, Depth::U8)?, channels))
    }

    /// Memory beside the texels: progressive scans are collected as coefficients of 16 bits.
    pub(super) fn scratch_bytes(&self) -> u64 {
        if self.marker != 0xc2 {
            return 0;
        }
        let components = usize::from(self.components).min(self.sampling.len());
        let factors =
            self.sampling[..components].iter().map(|&it| (u64::from(it >> 4), u64::from(it & 15)));
        let (mut across, mut down, mut blocks) = (1, 1, 0);
        for (x, y) in factors {
            (across, down, blocks) = (across.max(x), down.max(y), blocks + x * y);
        }
        let units =
            u64::from(self.width).div_ceil(8 * across) * u64::from(self.height).div_ceil(8 * down);
        units * blocks * 64 * 2
    }

    /// Whether the chroma has half as many columns as the luma, and as many rows or half as many.
    pub(super) fn has_chroma_of_half_width(&self) -> bool {
        matches!(self.sampling, [0x21 | 0x22, 0x11, 0x11])
    }

    /// Whether the chroma has half as many rows as the luma, if it has half as many columns.
    pub(super) fn has_chroma_of_half_height(&self) -> bool {
        self.sampling[0] == 0x22
    }

    /// The name of a process that is not supported, or nothing.
    fn process(&self) -> &'static str {
        match self.marker {
            0xc0..=0xc2 => "",
            0xc3 => "lossless coding",
            0xc5..=0xc7 => "hierarchical coding",
            0xc9 | 0xca => "arithmetic coding",
            0xcb => "lossless arithmetic coding",
            _ => "hierarchical arithmetic coding",
        }
    }
}
