//! Where results go: into files, or into memory.

use std::io::Cursor;
use std::path::Path;

use uvgraft::Texture;
use uvgraft_image::{
    BandEncoder, BandWriter, EncodeError, Format, Segment, Segments, TextureSpec, WriteError,
    WriteOptions, Written,
};

/// Where an encoded result goes.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Target<'a> {
    /// A file that appears when it is whole.
    File(&'a Path),
    /// - `name`: stands for a path in messages.
    Bytes { name: &'a Path, format: Format },
}

/// A result that is encoded while its bands arrive.
pub(crate) enum Sink<'a> {
    File { path: &'a Path, writer: BandWriter },
    Bytes { name: &'a Path, encoder: BandEncoder<Cursor<Vec<u8>>> },
}

/// An encoded result.
pub(crate) struct Encoded {
    pub(crate) written: Written,
    /// Length of the encoded image in bytes.
    pub(crate) bytes: u64,
    /// The encoded image; empty if it is in a file.
    pub(crate) image: Vec<u8>,
}

impl<'a> Target<'a> {
    /// What messages call it.
    pub(crate) fn name(&self) -> &'a Path {
        match *self {
            Self::File(path) => path,
            Self::Bytes { name, .. } => name,
        }
    }

    /// The image format; `None` if that of a file is unknown.
    pub(crate) fn format(&self) -> Option<Format> {
        match *self {
            Self::File(path) => Format::from_path(path),
            Self::Bytes { format, .. } => Some(format),
        }
    }

    /// Starts the image.
    pub(crate) fn create(
        &self,
        spec: TextureSpec,
        icc: Option<&[u8]>,
        options: &WriteOptions,
    ) -> Result<Sink<'a>, WriteError> {
        match *self {
            Self::File(path) => {
                let writer = BandWriter::create(path, spec, icc, options)?;
                Ok(Sink::File { path, writer })
            }
            Self::Bytes { name, format } => {
                let encoder = BandEncoder::new(Cursor::default(), format, spec, icc, options);
                Ok(Sink::Bytes { name, encoder: encoder.map_err(named(name))? })
            }
        }
    }
}

impl Sink<'_> {
    /// As [`BandEncoder::push`].
    pub(crate) fn push(&mut self, band: &Texture) -> Result<(), WriteError> {
        match self {
            Self::File { writer, .. } => writer.push(band),
            Self::Bytes { name, encoder } => encoder.push(band).map_err(named(name)),
        }
    }

    /// As [`BandEncoder::segments`].
    pub(crate) fn segments(&self) -> Option<Segments> {
        match self {
            Self::File { writer, .. } => writer.segments(),
            Self::Bytes { encoder, .. } => encoder.segments(),
        }
    }

    /// As [`BandEncoder::push_segment`].
    pub(crate) fn push_segment(&mut self, segment: &Segment) -> Result<(), WriteError> {
        match self {
            Self::File { writer, .. } => writer.push_segment(segment),
            Self::Bytes { name, encoder } => encoder.push_segment(segment).map_err(named(name)),
        }
    }

    /// Writes the remaining data, and moves a file into place.
    pub(crate) fn finish(self) -> Result<Encoded, WriteError> {
        match self {
            Self::File { path, writer } => {
                let written = writer.finish()?;
                let bytes = path.metadata().map_or(0, |found| found.len());
                Ok(Encoded { written, bytes, image: Vec::new() })
            }
            Self::Bytes { name, encoder } => {
                let (written, image) = encoder.finish().map_err(named(name))?;
                let image = image.into_inner();
                Ok(Encoded { written, bytes: image.len() as u64, image })
            }
        }
    }
}

fn named(name: &Path) -> impl Fn(EncodeError) -> WriteError {
    move |reason| WriteError::Encode { path: name.to_path_buf(), reason }
}
