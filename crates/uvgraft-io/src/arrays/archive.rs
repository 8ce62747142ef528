//! ZIP archives in memory, unpacked within bounds.

use std::collections::HashSet;
use std::io::{Cursor, Read};

use zip::ZipArchive;
use zip::result::ZipError;

use super::ArraysError;
use crate::obj::shown;

/// An entry of a deflated archive grows by this factor at most: a block of 258 equal bytes takes two
/// bits. Larger claims are wrong, and are told apart before anything is reserved.
const MOST_GROWTH: u64 = 1032;

/// A ZIP archive whose entries are no more than a limit together, as far as they say.
pub(crate) struct Archive<'a> {
    archive: ZipArchive<Cursor<&'a [u8]>>,
    names: Vec<String>,
}

fn damaged(error: &ZipError) -> ArraysError {
    ArraysError::Archive { problem: error.to_string() }
}

impl<'a> Archive<'a> {
    /// Reads the directory of an archive, whose entries may be `most` bytes together.
    pub(crate) fn open(bytes: &'a [u8], most: u64) -> Result<Self, ArraysError> {
        // The directory is at the end, so this is what a download that broke off meets.
        let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| {
            let problem =
                format!("cut short or damaged, its list of entries is not found ({error})");
            ArraysError::Archive { problem }
        })?;
        if archive.has_duplicate_names() {
            let problem = "two entries have one name".to_owned();
            return Err(ArraysError::Archive { problem });
        }
        if archive.len() > super::MOST_NAMES {
            return Err(ArraysError::TooMany { what: "entries", most: super::MOST_NAMES as u64 });
        }
        let mut names = Vec::with_capacity(archive.len());
        let mut distinct = HashSet::with_capacity(archive.len());
        let mut total = 0_u64;
        for index in 0..archive.len() {
            let entry = archive.by_index_raw(index).map_err(|error| damaged(&error))?;
            let name = String::from_utf8_lossy(entry.name_raw()).into_owned();
            total = total.saturating_add(entry.size());
            if total > most {
                return Err(ArraysError::TooMany { what: "bytes when unpacked", most });
            }
            if !distinct.insert(name.clone()) {
                return Err(ArraysError::Twice { name: shown(name.as_bytes()) });
            }
            names.push(name);
        }
        Ok(Self { archive, names })
    }

    /// The names of the entries, in order.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// The bytes of an entry, which are as many as it says, with the checksum that it says.
    pub(crate) fn read(&mut self, index: usize) -> Result<Vec<u8>, ArraysError> {
        let name = shown(self.names.get(index).map_or(&[][..], |name| name.as_bytes()));
        let broken = |problem: String| ArraysError::Array { name: name.clone(), problem };
        let mut entry = self.archive.by_index(index).map_err(|error| broken(error.to_string()))?;
        let (packed, size) = (entry.compressed_size(), entry.size());
        if size > packed.saturating_mul(MOST_GROWTH) {
            return Err(broken(format!("{packed} packed bytes cannot hold {size}")));
        }
        let too_large = || broken(format!("{size} bytes do not fit into memory"));
        let capacity = usize::try_from(size).map_err(|_| too_large())?;
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(capacity).map_err(|_| too_large())?;
        let mut limited = entry.by_ref().take(size);
        limited.read_to_end(&mut bytes).map_err(|error| broken(error.to_string()))?;
        // Only at the end of the entry is its checksum compared.
        let mut further = [0];
        let more = entry.read(&mut further).map_err(|error| broken(error.to_string()))?;
        if more > 0 || bytes.len() as u64 != size {
            let found = bytes.len() + more;
            return Err(broken(format!("it says that it has {size} bytes, found {found}")));
        }
        Ok(bytes)
    }
}
