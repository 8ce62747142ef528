//! Images that are opened once: first the header, then the texels.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Seek};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::codec::Decode;
use super::{
    BandDecoder, BandReader, DeclaredSpace, Format, Header, Image, ImageError, MAX_FILE_BYTES,
    ReadError, camera_header_of,
};
use uvgraft_files::input::{self, Input};

/// An image whose header was read: [`open`].
pub struct OpenImage {
    name: PathBuf,
    content: Content,
    header: Header,
    focal_length_px: Option<f64>,
}

/// Opens an image and reads its header. The texels are read from the same opening, so that a pipe
/// can be opened too, and a file cannot be replaced in between.
///
/// # Errors
/// [`ReadError`], with the path or name, if the file cannot be read or its header is one that
/// [`decode`](super::decode) rejects.
pub fn open(input: impl Into<Input>) -> Result<OpenImage, ReadError> {
    OpenImage::open(&input.into())
}

impl OpenImage {
    fn open(input: &Input) -> Result<Self, ReadError> {
        let name = input.name().to_path_buf();
        let mut content = match Content::open(input) {
            Ok(content) => content,
            Err(reason) => return Err(ReadError::Io { path: name, reason }),
        };
        match content.header() {
            Ok((header, focal_length_px)) => Ok(Self { name, content, header, focal_length_px }),
            Err(reason) => Err(ReadError::Content { path: name, reason }),
        }
    }

    /// Its path, or the name that stands for it.
    pub fn name(&self) -> &Path {
        &self.name
    }

    /// Format, size, channels and depth.
    pub fn header(&self) -> Header {
        self.header
    }

    /// The focal length of a photo's camera in pixels; see
    /// [`decode_focal_length_px`](super::decode_focal_length_px).
    pub fn focal_length_px(&self) -> Option<f64> {
        self.focal_length_px
    }

    /// The texels, upright, and the ICC profile.
    ///
    /// # Errors
    /// [`ReadError`], with the path or name, if the file cannot be read or
    /// [`decode`](super::decode) rejects it.
    pub fn decode(self) -> Result<Image, ReadError> {
        self.bands()?.read_whole()
    }

    /// The texels in bands of rows.
    ///
    /// # Errors
    /// As [`BandReader::open`].
    pub fn bands(self) -> Result<BandReader, ReadError> {
        BandReader::of(self.name, self.content, DeclaredSpace::Honoured)
    }
}

/// The bytes of an image.
pub(super) enum Content {
    /// A file that is read on demand.
    File { file: BufReader<File>, length: u64 },
    /// All that a pipe gave.
    Read(Vec<u8>),
    /// In memory from the start.
    Bytes(Arc<[u8]>),
}

impl Content {
    pub(super) fn open(input: &Input) -> io::Result<Self> {
        /// Chunks up to this size are skipped without another read.
        const BUFFER: usize = 1 << 16;
        let path = match input {
            Input::File(path) => path,
            Input::Bytes { bytes, .. } => {
                input.read(MAX_FILE_BYTES)?;
                return Ok(Self::Bytes(Arc::clone(bytes)));
            }
        };
        let (file, told) = input::open(path)?;
        let length = told.len();
        // The end of a pipe cannot be checked first.
        if !told.is_file() || length > MAX_FILE_BYTES {
            return input::read_rest(file, length, MAX_FILE_BYTES).map(Self::Read);
        }
        Ok(Self::File { file: BufReader::with_capacity(BUFFER, file), length })
    }

    fn header(&mut self) -> Result<(Header, Option<f64>), ImageError> {
        match self {
            Self::File { file, .. } => camera_header_of(file),
            Self::Read(bytes) => camera_header_of(&mut Cursor::new(&bytes[..])),
            Self::Bytes(bytes) => camera_header_of(&mut Cursor::new(&bytes[..])),
        }
    }

    /// Reads everything before the texels if they are decoded in rows, and all of any other image.
    pub(super) fn into_decoder(
        self,
        space: DeclaredSpace,
    ) -> io::Result<Result<BandDecoder<'static>, ImageError>> {
        match self {
            Self::File { mut file, length } => {
                file.rewind()?;
                if let Some(format) = Format::detect(file.fill_buf()?)
                    && let Decode::Rows(open) = format.codec().decode
                {
                    let source = Box::new(file);
                    return Ok(BandDecoder::in_rows(format, open, source, length, space));
                }
                // Without the copy through the buffer.
                let mut file = file.into_inner();
                file.rewind()?;
                let bytes = input::read_rest(file, length, MAX_FILE_BYTES)?;
                Ok(BandDecoder::among(Format::ALL, bytes, space))
            }
            Self::Read(bytes) => Ok(BandDecoder::among(Format::ALL, bytes, space)),
            Self::Bytes(bytes) => Ok(BandDecoder::among(Format::ALL, bytes, space)),
        }
    }
}
