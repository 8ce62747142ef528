//! NumPy's NPZ: a ZIP archive with an NPY file for each array.

use std::io::{Read, Seek};

use super::archive::Archive;
use super::archive::ArchiveInMemory;
use super::collect::Collector;
use super::error::ArraysError;
use super::named::NamedArrays;
use super::npy::{self, Content};
use crate::obj::shown;
use crate::pickle;

/// Reads all arrays. An entry that contains objects is a pickle.
pub(super) fn read(archive: &mut ArchiveInMemory<'_>) -> Result<NamedArrays, ArraysError> {
    each(archive, |archive, index, name, collector| {
        let bytes = archive.read(index)?;
        add(name, &bytes, collector)
    })
}

/// Collects the arrays of an archive.
///
/// - `read`: reads an entry, an NPY file, as the array of a name.
pub(super) fn each<R: Read + Seek>(
    archive: &mut Archive<R>,
    mut read: impl FnMut(&mut Archive<R>, usize, &str, &mut Collector<'_>) -> Result<(), ArraysError>,
) -> Result<NamedArrays, ArraysError> {
    let mut collector = Collector::new(None, archive.unpacked());
    for index in 0..archive.names().len() {
        let file = archive.names()[index].clone();
        let Some(name) = file.strip_suffix(".npy") else {
            // Folders and other files next to the arrays.
            collector.leave_out(&file, "not a .npy file".to_owned());
            continue;
        };
        if collector.has(name) {
            return Err(ArraysError::Duplicate { name: shown(name.as_bytes()) });
        }
        read(archive, index, name, &mut collector)?;
    }
    Ok(collector.finish())
}

/// Adds the content of a whole NPY file.
pub(super) fn add(
    name: &str,
    bytes: &[u8],
    collector: &mut Collector<'_>,
) -> Result<(), ArraysError> {
    match npy::read(bytes, |count| collector.spend(count)) {
        Ok(Content::Held(held)) => collector.hold(name, held),
        Ok(Content::Pickle(bytes)) => match pickle::parse(bytes) {
            Ok(pickle) => collector.add(name, pickle.root())?,
            Err(reason) => collector.leave_out(name, reason.to_string()),
        },
        Err(unread) => collector.unread(name, unread)?,
    }
    Ok(())
}
