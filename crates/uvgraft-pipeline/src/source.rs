//! Textures to transfer: files, or encoded images in memory.

use std::path::Path;

use uvgraft::Texture;
use uvgraft_files::input::Input;
use uvgraft_image::{BandDecoder, BandReader, DeclaredSpace, TextureSpec};

use crate::failure::{Blame, Context, Failure, Result};

/// An encoded texture.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Source<'a> {
    File(&'a Path),
    /// - `name`: stands for a path in messages.
    Bytes {
        name: &'a Path,
        bytes: &'a [u8],
    },
}

/// A texture whose header is read.
pub(crate) enum OpenSource<'a> {
    File(BandReader),
    Bytes { name: &'a Path, decoder: BandDecoder<'a> },
}

impl<'a> From<&'a Input> for Source<'a> {
    fn from(input: &'a Input) -> Self {
        match input {
            Input::File(path) => Self::File(path),
            Input::Bytes { name, bytes } => Self::Bytes { name, bytes },
        }
    }
}

impl<'a> Source<'a> {
    /// What messages call it.
    pub(crate) fn name(&self) -> &'a Path {
        match *self {
            Self::File(path) => path,
            Self::Bytes { name, .. } => name,
        }
    }

    /// Reads everything before the texels.
    ///
    /// - `space`: whether colours are converted from the colour space that the file declares.
    pub(crate) fn open(&self, space: DeclaredSpace) -> Result<OpenSource<'a>> {
        match *self {
            Self::File(path) => BandReader::with(path, space).or_input().map(OpenSource::File),
            Self::Bytes { name, bytes } => {
                let decoder = BandDecoder::with(bytes, space).or_input();
                let decoder = decoder.context(name.display())?;
                Ok(OpenSource::Bytes { name, decoder })
            }
        }
    }
}

impl OpenSource<'_> {
    pub(crate) fn spec(&self) -> TextureSpec {
        match self {
            Self::File(reader) => reader.spec(),
            Self::Bytes { decoder, .. } => decoder.spec(),
        }
    }

    pub(crate) fn icc(&self) -> Option<&[u8]> {
        match self {
            Self::File(reader) => reader.icc(),
            Self::Bytes { decoder, .. } => decoder.icc(),
        }
    }

    /// As [`BandDecoder::read_while`].
    pub(crate) fn read_while(
        self,
        is_wanted: impl FnMut(u32) -> bool,
    ) -> Result<(Texture, Option<(u32, Failure)>)> {
        match self {
            Self::File(reader) => {
                let (texture, damage) = reader.read_while(is_wanted).or_input()?;
                Ok((texture, damage.map(|(row, error)| (row, Failure::input(error)))))
            }
            Self::Bytes { name, decoder } => {
                let name = name.display();
                let (texture, damage) = decoder.read_while(is_wanted).or_input().context(&name)?;
                let input = |error| Failure::input(error).context(&name);
                Ok((texture, damage.map(|(row, error)| (row, input(error)))))
            }
        }
    }
}
