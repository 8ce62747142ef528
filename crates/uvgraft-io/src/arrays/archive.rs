//! ZIP archives in memory or in files, unpacked within limits.

use std::collections::HashSet;
use std::io::{Cursor, Read, Seek};

use zip::ZipArchive;
use zip::result::ZipError;

use super::error::{ArraysError, Unread};
use crate::obj::shown;

/// Maximum expansion factor of a deflated entry: a block of 258 equal bytes takes two bits. Larger
/// claims are rejected before anything is allocated.
const MAX_GROWTH: u64 = 1032;

/// A ZIP archive whose stated entry sizes stay within a limit in total.
pub(crate) struct Archive<R> {
    archive: ZipArchive<R>,
    names: Vec<String>,
    unpacked: usize,
}

/// An archive held in memory.
pub(crate) type ArchiveInMemory<'a> = Archive<Cursor<&'a [u8]>>;

fn damaged(error: &ZipError) -> ArraysError {
    ArraysError::Archive { problem: error.to_string() }
}

impl<'a> ArchiveInMemory<'a> {
    /// Reads the directory of an archive whose entries may have `most` bytes in total.
    pub(crate) fn open(bytes: &'a [u8], most: u64) -> Result<Self, ArraysError> {
        Self::new(Cursor::new(bytes), most)
    }
}

impl<R: Read + Seek> Archive<R> {
    /// Reads the directory of an archive whose entries may have `most` bytes in total.
    pub(crate) fn new(bytes: R, most: u64) -> Result<Self, ArraysError> {
        // The directory is at the end of the file, so an incomplete download fails here.
        let mut archive = ZipArchive::new(bytes).map_err(|error| {
            let problem = format!("truncated or damaged: {error}");
            ArraysError::Archive { problem }
        })?;
        if archive.has_duplicate_names() {
            let problem = "duplicate entry names".to_owned();
            return Err(ArraysError::Archive { problem });
        }
        if archive.len() > super::MAX_NAMES {
            return Err(ArraysError::TooMany { what: "entries", most: super::MAX_NAMES as u64 });
        }
        let mut names = Vec::with_capacity(archive.len());
        let mut distinct = HashSet::with_capacity(archive.len());
        let (mut total, mut unpacked) = (0_u64, 0_u64);
        for index in 0..archive.len() {
            let entry = archive.by_index_raw(index).map_err(|error| damaged(&error))?;
            let name = String::from_utf8_lossy(entry.name_raw()).into_owned();
            total = total.saturating_add(entry.size());
            unpacked += entry.size().min(entry.compressed_size().saturating_mul(MAX_GROWTH));
            if total > most {
                return Err(ArraysError::TooMany { what: "uncompressed bytes", most });
            }
            if !distinct.insert(name.clone()) {
                return Err(ArraysError::Duplicate { name: shown(name.as_bytes()) });
            }
            names.push(name);
        }
        // At most `total`, which was never more than `most` after an entry.
        Ok(Self { archive, names, unpacked: usize::try_from(unpacked).unwrap_or(usize::MAX) })
    }

    /// The bytes that all entries unpack to at most, as far as the sizes that they state can be true.
    pub(crate) const fn unpacked(&self) -> usize {
        self.unpacked
    }

    /// The names of the entries, in order.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// The bytes of an entry, checked against its stated size and checksum.
    pub(crate) fn read(&mut self, index: usize) -> Result<Vec<u8>, ArraysError> {
        self.stream(index, |entry, size| {
            let too_large = || Unread::broken(format!("not enough memory for {size} bytes"));
            let capacity = usize::try_from(size).map_err(|_| too_large())?;
            let mut bytes = Vec::new();
            bytes.try_reserve_exact(capacity).map_err(|_| too_large())?;
            entry.read_to_end(&mut bytes).map_err(|error| Unread::broken(error.to_string()))?;
            Ok(bytes)
        })?
        .map_err(|unread| unread.into_error(&self.names[index]))
    }

    /// Passes the stream of an entry and its stated size to a function, which may read all of it or
    /// a part. If it was read to the end, its size and checksum are verified.
    ///
    /// # Errors
    /// [`ArraysError`] for a damaged entry; otherwise the result of `read`.
    pub(crate) fn stream<T>(
        &mut self,
        index: usize,
        read: impl FnOnce(&mut dyn Read, u64) -> Result<T, Unread>,
    ) -> Result<Result<T, Unread>, ArraysError> {
        let name = self.shown(index);
        let broken = |problem: String| ArraysError::Array { name: name.clone(), problem };
        let mut entry = self.archive.by_index(index).map_err(|error| broken(error.to_string()))?;
        let (packed, size) = (entry.compressed_size(), entry.size());
        if size > packed.saturating_mul(MAX_GROWTH) {
            return Err(broken(format!("{packed} compressed bytes cannot expand to {size}")));
        }
        let mut limited = entry.by_ref().take(size);
        let result = read(&mut limited, size);
        let missing = limited.limit();
        if missing > 0 && result.is_err() {
            return Ok(result);
        }
        // If a part was left unread, it was on purpose, unless the entry is too short. Otherwise
        // the checksum is verified only at the end of the entry.
        let mut further = [0];
        let more = if missing > 0 { limited.read(&mut further) } else { entry.read(&mut further) };
        let more = more.map_err(|error| broken(error.to_string()))? as u64;
        if (more > 0) != (missing > 0) {
            let found = size - missing + more;
            return Err(broken(format!("must have {size} bytes as its entry states, got {found}")));
        }
        Ok(result)
    }

    fn shown(&self, index: usize) -> String {
        shown(self.names.get(index).map_or(&[][..], |name| name.as_bytes()))
    }
}
