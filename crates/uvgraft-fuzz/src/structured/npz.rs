//! NPZ files: archives whose entries, names and sizes are stretched; their checksums are right.

use std::io::{Cursor, Write as _};

use arbitrary::Arbitrary;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::number::{Many, Number, Patch};
use super::{MAX_BYTES, choose, npy, pickle, reading};

#[derive(Debug, Arbitrary)]
struct Choices {
    entries: [Option<Entry>; 3],
    repeated: Option<Many>,
    /// Names as maps, tables and motions have them.
    names: u8,
    name: Option<Many>,
    is_deflated: bool,
    stated: Option<(Stated, Number)>,
    patch: Option<Patch>,
}

#[derive(Debug, Arbitrary)]
enum Entry {
    Array(npy::Array),
    /// Zeros, which take a thousandth when compressed.
    Zeros(Many),
    Objects(pickle::Choices),
}

/// A number of the archive's directory.
#[derive(Debug, Clone, Copy, Arbitrary)]
enum Stated {
    Packed,
    Unpacked,
    NameLength,
    Offset,
    Entries,
    Checksum,
}

const NAMES: [[&str; 3]; 5] = [
    ["a", "b", "c"],
    ["poses", "trans", "betas"],
    ["data", "indices", "indptr"],
    ["map", "mask", "shape"],
    ["faces", "weights", "vertices"],
];

impl Entry {
    fn bytes(&self) -> Vec<u8> {
        match self {
            Self::Array(array) => array.file(),
            Self::Zeros(many) => {
                // As much as can be unpacked in milliseconds.
                let count = (64 * many.0).min(4 * MAX_BYTES);
                let header =
                    format!("{{'descr': '|u1', 'fortran_order': False, 'shape': ({count},), }}\n");
                let length = (header.len() as u16).to_le_bytes();
                let mut file = [b"\x93NUMPY\x01\0", &length[..], header.as_bytes()].concat();
                file.resize(file.len() + count, 0);
                file
            }
            Self::Objects(choices) => {
                let header = b"{'descr': '|O', 'fortran_order': False, 'shape': (), }\n";
                let length = (header.len() as u16).to_le_bytes();
                [b"\x93NUMPY\x01\0", &length[..], header, &choices.file()].concat()
            }
        }
    }
}

impl Choices {
    fn file(&self) -> Vec<u8> {
        let method =
            if self.is_deflated { CompressionMethod::Deflated } else { CompressionMethod::Stored };
        let options = SimpleFileOptions::default().compression_method(method);
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        let names = NAMES[usize::from(self.names) % NAMES.len()];
        for (entry, name) in self.entries.iter().zip(names) {
            let Some(entry) = entry else { continue };
            let longer = "n".repeat(self.name.map_or(0, |many| many.of(1).min(60_000)));
            let _ = archive.start_file(format!("{name}{longer}.npy"), options);
            let _ = archive.write_all(&entry.bytes());
        }
        for at in 0..self.repeated.map_or(0, |many| many.of(400)) {
            let _ = archive.start_file(format!("{at}.npy"), options);
            let _ = archive.write_all(&[b"\x93NUMPY\x01\0\x3d\0", SCALAR].concat());
        }
        let mut file = archive.finish().map(Cursor::into_inner).unwrap_or_default();
        if let Some((what, to)) = self.stated {
            what.change(&mut file, to);
        }
        self.patch.into_iter().for_each(|patch| patch.apply(&mut file, false));
        file
    }
}

/// The header and the value of a scalar.
const SCALAR: &[u8] = b"{'descr': '<f4', 'fortran_order': False, 'shape': (), }     \n\0\0\0\0";

impl Stated {
    /// Changes the number where the directory has it, and where the entry has.
    fn change(self, file: &mut [u8], to: Number) {
        let (central, local, width) = match self {
            Self::Packed => (20, Some(18), 4),
            Self::Unpacked => (24, Some(22), 4),
            Self::NameLength => (28, Some(26), 2),
            Self::Offset => (42, None, 4),
            Self::Checksum => (16, Some(14), 4),
            Self::Entries => {
                let end = file.len().saturating_sub(22);
                to.patch(file, end + 8, 2, false);
                return to.patch(file, end + 10, 2, false);
            }
        };
        let first = |file: &[u8], mark: &[u8]| file.windows(4).position(|bytes| bytes == mark);
        if let Some(at) = first(file, b"PK\x01\x02") {
            to.patch(file, at + central, width, false);
        }
        if let (Some(at), Some(local)) = (first(file, b"PK\x03\x04"), local) {
            to.patch(file, at + local, width, false);
        }
    }
}

pub(crate) fn file(bytes: &[u8]) -> Vec<u8> {
    choose::<Choices>(bytes).map_or_else(Vec::new, |choices| choices.file())
}

pub(crate) fn run(bytes: &[u8]) {
    reading::arrays(&file(bytes));
}
