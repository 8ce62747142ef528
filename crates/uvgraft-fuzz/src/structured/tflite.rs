//! Models of TensorFlow Lite: tables that are there many times, shapes and indices.

use arbitrary::Arbitrary;

use super::number::{Many, Number, Patch};
use super::{choose, reading};
use crate::tflite_seed::{Field, fields, written};

#[derive(Debug, Arbitrary)]
struct Choices {
    first: Change,
    further: [Option<Change>; 2],
    patch: Option<Patch>,
}

/// A change of one of the fields of a kind, by its number.
#[derive(Debug, Clone, Copy, Arbitrary)]
enum Change {
    Byte { which: u8, to: u8 },
    Int { which: u8, at: u8, to: Number },
    Ints { which: u8, count: Many },
    Bytes { which: u8, count: Many },
    Tables { which: u8, at: u8, count: Many },
}

impl Change {
    fn which(self) -> u8 {
        match self {
            Self::Byte { which, .. }
            | Self::Int { which, .. }
            | Self::Ints { which, .. }
            | Self::Bytes { which, .. }
            | Self::Tables { which, .. } => which,
        }
    }

    fn fits(self, field: &Field) -> bool {
        match (self, field) {
            (Self::Byte { .. }, Field::Byte(_)) | (Self::Bytes { .. }, Field::Bytes(_)) => true,
            (Self::Int { .. } | Self::Ints { .. }, Field::Ints(ints)) => !ints.is_empty(),
            (Self::Tables { .. }, Field::Tables(tables)) => !tables.is_empty(),
            _ => false,
        }
    }

    fn apply(self, root: &mut [Field]) {
        let count = all(root).filter(|field| self.fits(field)).count();
        if count > 0 {
            self.change(root, &mut (usize::from(self.which()) % count));
        }
    }

    /// Changes the field before which so many fit; returns whether it was there.
    fn change(self, fields: &mut [Field], before: &mut usize) -> bool {
        fields.iter_mut().any(|field| {
            if self.fits(field) {
                match before.checked_sub(1) {
                    Some(rest) => *before = rest,
                    None => {
                        self.change_field(field);
                        return true;
                    }
                }
            }
            match field {
                Field::Tables(tables) => tables.iter_mut().any(|table| self.change(table, before)),
                _ => false,
            }
        })
    }

    fn change_field(self, field: &mut Field) {
        match (self, field) {
            (Self::Byte { to, .. }, Field::Byte(byte)) => *byte = to,
            (Self::Int { at, to, .. }, Field::Ints(ints)) => {
                let at = usize::from(at) % ints.len();
                ints[at] = to.instead_of(ints[at] as u64) as i32;
            }
            (Self::Ints { count, .. }, Field::Ints(ints)) => ints.resize(count.of(4), ints[0]),
            (Self::Bytes { count, .. }, Field::Bytes(bytes)) => bytes.resize(count.of(1), 0),
            (Self::Tables { at, count, .. }, Field::Tables(tables)) => {
                let table = tables[usize::from(at) % tables.len()].clone();
                let each = 40 * all(&table).count();
                tables.extend(std::iter::repeat_n(table, count.of(each)));
            }
            _ => {}
        }
    }
}

/// Fields, and those of the tables in them.
fn all(fields: &[Field]) -> Box<dyn Iterator<Item = &Field> + '_> {
    Box::new(fields.iter().flat_map(|field| {
        let inner = match field {
            Field::Tables(tables) => &tables[..],
            _ => &[],
        };
        std::iter::once(field).chain(inner.iter().flat_map(|table| all(table)))
    }))
}

pub(crate) fn file(bytes: &[u8]) -> Vec<u8> {
    let Some(Choices { first, further, patch }) = choose(bytes) else { return Vec::new() };
    let mut root = fields();
    first.apply(&mut root);
    further.into_iter().flatten().for_each(|change| change.apply(&mut root));
    let mut file = written(&root);
    patch.into_iter().for_each(|patch| patch.apply(&mut file, false));
    file
}

pub(crate) fn run(bytes: &[u8]) {
    reading::network(&file(bytes));
}
