//! NPY files: shapes, dtypes and lengths of headers that differ from what follows.

use arbitrary::Arbitrary;

use super::number::{Many, Number, Patch};
use super::{choose, reading};

/// An array of any type; its values are zeros.
#[derive(Debug, Clone, Arbitrary)]
pub(super) struct Array {
    dtype: u8,
    version: u8,
    is_fortran_order: bool,
    rows: Many,
    columns: u8,
    /// Axes that are 1 long.
    axes: Option<Many>,
    length: Option<(u8, Number)>,
    padding: Option<Many>,
    header: Option<Number>,
}

/// Numbers of all kinds, strings, objects, and what is not supported.
const DTYPES: [(&str, usize); 16] = [
    ("<f4", 4),
    ("<f8", 8),
    ("<f2", 2),
    (">f4", 4),
    ("<i4", 4),
    ("<i8", 8),
    ("|i1", 1),
    ("<u2", 2),
    ("|u1", 1),
    ("|b1", 1),
    ("<i8", 8),
    ("<f4", 4),
    ("<U7", 28),
    ("|S5", 5),
    ("|O", 8),
    ("<c8", 8),
];

impl Array {
    pub fn file(&self) -> Vec<u8> {
        let (dtype, width) = DTYPES[usize::from(self.dtype) % DTYPES.len()];
        let columns = usize::from(self.columns % 5);
        let rows = self.rows.of(width * columns.max(1));
        let values = width * rows * columns.max(1);
        let mut shape =
            if columns == 0 { vec![rows as u64] } else { vec![rows as u64, columns as u64] };
        if let Some(axes) = self.axes {
            shape.resize(shape.len() + axes.of(3), 1);
        }
        if let Some((axis, to)) = self.length {
            let axis = usize::from(axis) % shape.len();
            shape[axis] = to.instead_of(shape[axis]);
        }
        let shape: String = shape.iter().map(|length| format!("{length}, ")).collect();
        let order = if self.is_fortran_order { "True" } else { "False" };
        let text =
            format!("{{'descr': '{dtype}', 'fortran_order': {order}, 'shape': ({shape}), }}");
        let padding = self.padding.map_or(1, |padding| padding.of(1));
        let header = format!("{text}{}\n", " ".repeat(padding));
        let length =
            self.header.map_or(header.len() as u64, |to| to.instead_of(header.len() as u64));
        let version = self.version % 3 + 1;
        let mut file = vec![0x93, b'N', b'U', b'M', b'P', b'Y', version, 0];
        match version {
            1 => file.extend((length as u16).to_le_bytes()),
            _ => file.extend((length as u32).to_le_bytes()),
        }
        file.extend(header.bytes());
        file.resize(file.len() + values, 0);
        file
    }
}

pub(crate) fn file(bytes: &[u8]) -> Vec<u8> {
    let Some((array, patch)) = choose::<(Array, Option<Patch>)>(bytes) else { return Vec::new() };
    let mut file = array.file();
    patch.into_iter().for_each(|patch| patch.apply(&mut file, false));
    file
}

pub(crate) fn run(bytes: &[u8]) {
    reading::array(&file(bytes));
}
