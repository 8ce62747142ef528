//! Torch files: tensors whose shapes, strides and storages do not fit each other, and storages that
//! many tensors share.

use std::io::{Cursor, Write as _};

use arbitrary::Arbitrary;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::number::{Many, Number};
use super::{choose, reading};

#[derive(Debug, Arbitrary)]
struct Choices {
    storage: u8,
    values: Many,
    columns: u8,
    /// All values are the first one.
    is_repeated: Option<bool>,
    changes: [Option<(Place, Number)>; 2],
    tensors: Option<Many>,
    is_deflated: bool,
}

/// A number of all tensors.
#[derive(Debug, Clone, Copy, PartialEq, Arbitrary)]
enum Place {
    Stated,
    Offset,
    Rows,
    Columns,
    RowStride,
    ColumnStride,
}

const STORAGES: [(&str, usize); 8] = [
    ("Float", 4),
    ("Double", 8),
    ("Half", 2),
    ("BFloat16", 2),
    ("Long", 8),
    ("Byte", 1),
    ("Bool", 1),
    ("Int", 4),
];

fn long(number: u64, out: &mut Vec<u8>) {
    out.extend([0x8a, 9]);
    out.extend(number.to_le_bytes());
    out.push(0);
}

fn text(text: &str, out: &mut Vec<u8>) {
    out.push(b'X');
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(text.as_bytes());
}

impl Choices {
    /// A number, changed if it is chosen.
    fn number(&self, place: Place, was: u64) -> u64 {
        let changes = self.changes.iter().flatten().filter(|change| change.0 == place);
        changes.fold(was, |was, change| change.1.instead_of(was))
    }

    fn pickle(&self) -> Vec<u8> {
        let (storage, width) = STORAGES[usize::from(self.storage) % STORAGES.len()];
        let values = self.values.of(width) as u64;
        let columns = u64::from(self.columns % 4 + 1).min(values);
        let steps = if self.is_repeated == Some(true) { [0, 0] } else { [columns, 1] };
        let mut out = b"\x80\x02}".to_vec();
        for tensor in 0..self.tensors.map_or(1, |many| many.of(200)) {
            let name = match tensor {
                0 => "color".to_owned(),
                1 => "opacity".to_owned(),
                _ => tensor.to_string(),
            };
            text(&name, &mut out);
            out.extend(b"ctorch._utils\n_rebuild_tensor_v2\n((");
            text("storage", &mut out);
            out.extend(format!("ctorch\n{storage}Storage\n").bytes());
            text("0", &mut out);
            text("cpu", &mut out);
            long(self.number(Place::Stated, values), &mut out);
            out.extend(b"tQ");
            long(self.number(Place::Offset, 0), &mut out);
            for [(rows, was_rows), (columns, was_columns)] in [
                [(Place::Rows, values / columns), (Place::Columns, columns)],
                [(Place::RowStride, steps[0]), (Place::ColumnStride, steps[1])],
            ] {
                out.push(b'(');
                long(self.number(rows, was_rows), &mut out);
                long(self.number(columns, was_columns), &mut out);
                out.push(b't');
            }
            out.extend(b"\x89ccollections\nOrderedDict\n)RtRs");
        }
        out.push(b'.');
        out
    }

    fn file(&self) -> Vec<u8> {
        let method =
            if self.is_deflated { CompressionMethod::Deflated } else { CompressionMethod::Stored };
        let options = SimpleFileOptions::default().compression_method(method);
        let (_, width) = STORAGES[usize::from(self.storage) % STORAGES.len()];
        let values = vec![0; width * self.values.of(width)];
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, content) in [("data.pkl", self.pickle()), ("data/0", values)] {
            let _ = archive.start_file(format!("archive/{name}"), options);
            let _ = archive.write_all(&content);
        }
        archive.finish().map(Cursor::into_inner).unwrap_or_default()
    }
}

pub(crate) fn file(bytes: &[u8]) -> Vec<u8> {
    choose::<Choices>(bytes).map_or_else(Vec::new, |choices| choices.file())
}

pub(crate) fn run(bytes: &[u8]) {
    reading::tensors(&file(bytes));
}
