//! Rows into a PNG, top to bottom.

use std::io::{self, Write};
use std::sync::{Arc, Mutex, PoisonError};

use ::png::{BitDepth, ColorType, Compression, Encoder, EncodingError, Filter, Info, StreamWriter};
use uvgraft::texture::{Channels, Depth, Texels};

use super::FORMAT;
use crate::image::convert::Conversion;
use crate::image::{EncodeError, Loss, TextureSpec};

/// A PNG that is written as its rows arrive.
pub(in crate::image) struct RowEncoder {
    values: Values,
    stream: StreamWriter<'static, Pipe>,
    pipe: Pipe,
}

/// The conversion to what the file holds.
enum Values {
    U8(Conversion<u8>),
    U16(Conversion<u16>, Vec<u8>),
}

impl RowEncoder {
    pub(in crate::image) fn new(
        spec: &TextureSpec,
        mut icc: Option<&[u8]>,
        compress: bool,
    ) -> Result<Self, EncodeError> {
        let (depth, values) = match spec.depth {
            Depth::U8 => (BitDepth::Eight, Values::U8(Conversion::new(spec, FORMAT, &mut icc))),
            Depth::U16 | Depth::F32 => {
                let conversion = Conversion::new(spec, FORMAT, &mut icc);
                (BitDepth::Sixteen, Values::U16(conversion, Vec::new()))
            }
        };
        let mut info = Info::with_size(spec.size.width, spec.size.height);
        info.bit_depth = depth;
        info.color_type = match spec.channels {
            Channels::Grey => ColorType::Grayscale,
            Channels::GreyAlpha => ColorType::GrayscaleAlpha,
            Channels::Rgb => ColorType::Rgb,
            Channels::Rgba => ColorType::Rgba,
        };
        info.icc_profile = icc.map(|icc| icc.to_vec().into());
        let pipe = Pipe::default();
        let mut encoder = Encoder::with_info(pipe.clone(), info).map_err(to_encode_error)?;
        // Measured for 4096² RGB texels on one core, smooth and with grain: Fast with Sub takes 0.04 and
        // 0.09 s for 5.8 and 33 MB; Adaptive takes a third more for 4.9 and 31 MB, Up and Avg a little
        // more, and Paeth doubles the time of reading. Balanced with Adaptive takes 0.3 and 2.9 s for
        // 1.1 and 15 MB; no single filter is both faster and smaller there.
        if compress {
            encoder.set_compression(Compression::Balanced);
            encoder.set_filter(Filter::Adaptive);
        } else {
            encoder.set_compression(Compression::Fast);
            encoder.set_filter(Filter::Sub);
        }
        let writer = encoder.write_header().map_err(to_encode_error)?;
        let stream = writer.into_stream_writer_with_size(1 << 18).map_err(to_encode_error)?;
        Ok(Self { values, stream, pipe })
    }

    /// Encodes whole rows.
    pub(in crate::image) fn write(
        &mut self,
        texels: &Texels,
        out: &mut impl Write,
    ) -> Result<(), EncodeError> {
        match &mut self.values {
            Values::U8(conversion) => self.stream.write_all(&conversion.apply(texels)),
            Values::U16(conversion, bytes) => {
                bytes.clear();
                bytes.extend(conversion.apply(texels).iter().flat_map(|value| value.to_be_bytes()));
                self.stream.write_all(bytes)
            }
        }?;
        self.pipe.drain(out)
    }

    /// Writes what is left and says what the file does not hold.
    pub(in crate::image) fn finish(self, out: &mut impl Write) -> Result<Vec<Loss>, EncodeError> {
        self.stream.finish().map_err(to_encode_error)?;
        self.pipe.drain(out)?;
        Ok(match self.values {
            Values::U8(conversion) => conversion.losses(),
            Values::U16(conversion, _) => conversion.losses(),
        })
    }
}

/// Takes what the crate writes, because its stream keeps its output for good.
#[derive(Clone, Default)]
struct Pipe(Arc<Mutex<Vec<u8>>>);

impl Pipe {
    fn drain(&self, out: &mut impl Write) -> Result<(), EncodeError> {
        let mut bytes = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        out.write_all(&bytes)?;
        bytes.clear();
        Ok(())
    }
}

impl Write for Pipe {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn to_encode_error(error: EncodingError) -> EncodeError {
    match error {
        EncodingError::IoError(error) => EncodeError::Io(error),
        error => EncodeError::encoder(FORMAT, error),
    }
}
