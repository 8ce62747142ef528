//! Pickles: lists, dicts and arrays of any size and depth, and values that are there many times.

use arbitrary::Arbitrary;

use super::number::{Many, Number, Patch};
use super::{MAX_BYTES, choose, reading};

/// A dict with a few values.
#[derive(Debug, Arbitrary)]
pub(super) struct Choices {
    keys: u8,
    values: [Option<Node>; 3],
    patch: Option<Patch>,
}

#[derive(Debug, Arbitrary)]
enum Node {
    Number(Number),
    Text {
        length: Many,
        stated: Option<Number>,
    },
    Bytes {
        length: Many,
        stated: Option<Number>,
    },
    /// A list of equal numbers.
    Numbers {
        length: Many,
    },
    /// A list of one value, many times.
    Shared {
        value: Box<Node>,
        times: Many,
    },
    /// The value under many names.
    Named {
        value: Box<Node>,
        times: Many,
    },
    /// Lists in lists.
    Nested {
        depth: Many,
        is_dict: bool,
    },
    /// A list of twice the list of twice the list, and so on.
    Doubled {
        levels: u8,
        value: Box<Node>,
    },
    /// NumPy's array.
    Array {
        rows: Many,
        columns: u8,
        dtype: u8,
        length: Option<(bool, Number)>,
        is_fortran_order: bool,
    },
    /// SciPy's matrix without values.
    Sparse {
        kind: u8,
        sides: [Number; 2],
        count: Many,
    },
    /// chumpy's selection.
    Select {
        a: Many,
        places: Many,
    },
    /// A list that holds itself.
    Cycle,
    Global(u8),
}

/// Names by which vertex groups, tables and models are found.
const KEYS: [[&str; 3]; 4] = [
    ["face", "neck", "ear"],
    ["lmk_face_idx", "lmk_b_coords", "c"],
    ["v_template", "f", "shapedirs"],
    ["faces", "weights", "vertices"],
];

const DTYPES: [(&str, usize); 8] =
    [("i4", 4), ("f8", 8), ("f4", 4), ("i8", 8), ("u1", 1), ("b1", 1), ("O8", 8), ("f2", 2)];

fn int(number: u64, out: &mut Vec<u8>) {
    match i32::try_from(number) {
        Ok(small) => {
            out.push(b'J');
            out.extend(small.to_le_bytes());
        }
        Err(_) => {
            out.extend([0x8a, 8]);
            out.extend(number.to_le_bytes());
        }
    }
}

fn text(text: &str, out: &mut Vec<u8>) {
    out.push(b'X');
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(text.as_bytes());
}

/// Remembers the value on top; returns its number.
///
/// - `memo`: how many are remembered.
fn remember(memo: &mut u32, out: &mut Vec<u8>) -> u32 {
    *memo += 1;
    out.push(b'r');
    out.extend(memo.to_le_bytes());
    *memo
}

/// Pushes a remembered value.
fn get(number: u32, out: &mut Vec<u8>) {
    out.push(b'j');
    out.extend(number.to_le_bytes());
}

/// - `length`: of the bytes.
fn sized(code: u8, length: usize, stated: Option<Number>, out: &mut Vec<u8>) {
    let reported = stated.map_or(length as u64, |to| to.instead_of(length as u64));
    out.push(code);
    out.extend(reported.to_le_bytes());
    out.resize(out.len() + length, b'a');
}

/// - `data`: bytes of the values.
fn array(shape: [u64; 2], (dtype, data): (&str, usize), is_fortran_order: bool, out: &mut Vec<u8>) {
    out.extend(
        b"cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK\x00\x85U\x01b\x87R(K\x01(",
    );
    shape.iter().for_each(|&length| int(length, out));
    out.extend(b"tcnumpy\ndtype\nU\x02");
    out.extend(dtype.as_bytes());
    out.extend(b"K\x00K\x01\x87R(K\x03U\x01<NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\x00tb");
    out.push(if is_fortran_order { 0x88 } else { 0x89 });
    if dtype == "O8" {
        out.push(b']');
        out.push(b'(');
        (0..data / 8).for_each(|_| out.push(b'N'));
        out.push(b'e');
    } else {
        out.push(b'T');
        out.extend((data as u32).to_le_bytes());
        out.resize(out.len() + data, 0);
    }
    out.extend(b"tb");
}

impl Node {
    /// - `memo`: how many values are remembered.
    fn write(&self, memo: &mut u32, out: &mut Vec<u8>) {
        match self {
            Self::Number(number) => int(number.instead_of(7), out),
            Self::Text { length, stated } => sized(0x8d, length.of(1), *stated, out),
            Self::Bytes { length, stated } => sized(0x8e, length.of(1), *stated, out),
            Self::Numbers { length } => {
                out.extend(b"](");
                (0..length.of(2)).for_each(|_| out.extend(b"K\x01"));
                out.push(b'e');
            }
            Self::Shared { value, times } => {
                value.write(memo, out);
                let value = remember(memo, out);
                out.extend(b"0](");
                (0..times.of(5)).for_each(|_| get(value, out));
                out.push(b'e');
            }
            Self::Named { value, times } => {
                value.write(memo, out);
                let value = remember(memo, out);
                out.extend(b"0}(");
                for name in 0..times.of(16) {
                    text(&name.to_string(), out);
                    get(value, out);
                }
                out.push(b'u');
            }
            Self::Nested { depth, is_dict } => {
                let depth = depth.of(4);
                for _ in 0..depth {
                    out.extend(if *is_dict { &b"}I1\n"[..] } else { b"]" });
                }
                out.push(b'N');
                (0..depth).for_each(|_| out.push(if *is_dict { b's' } else { b'a' }));
            }
            Self::Doubled { levels, value } => {
                value.write(memo, out);
                for _ in 0..levels % 64 {
                    let value = remember(memo, out);
                    out.extend(b"0](");
                    get(value, out);
                    get(value, out);
                    out.push(b'e');
                }
            }
            &Self::Array { rows, columns, dtype, length, is_fortran_order } => {
                let (dtype, width) = DTYPES[usize::from(dtype) % DTYPES.len()];
                let columns = usize::from(columns % 4) + 1;
                let rows = rows.of(width * columns);
                let mut shape = [rows as u64, columns as u64];
                if let Some((axis, to)) = length {
                    shape[usize::from(axis)] = to.instead_of(shape[usize::from(axis)]);
                }
                array(shape, (dtype, width * rows * columns), is_fortran_order, out);
            }
            &Self::Sparse { kind, sides, count } => {
                let module = ["csc", "csr", "coo"][usize::from(kind) % 3];
                let [height, width] = sides.map(|side| side.instead_of(64));
                let count = count.of(16);
                out.extend(
                    format!(
                        "ccopy_reg\n_reconstructor\n(cscipy.sparse.{module}\n{module}_matrix\n\
                    c__builtin__\nobject\nNtR}}("
                    )
                    .bytes(),
                );
                text("_shape", out);
                int(height, out);
                int(width, out);
                out.push(0x86);
                text("data", out);
                array([count as u64, 1], ("f8", 8 * count), false, out);
                let lines = if module == "csc" { width } else { height };
                let lines = (lines as usize).min(MAX_BYTES / 4) + 1;
                for (name, count) in
                    [("indices", count), ("indptr", lines), ("row", count), ("col", count)]
                {
                    text(name, out);
                    array([count as u64, 1], ("i4", 4 * count), false, out);
                }
                out.extend(b"ub");
            }
            &Self::Select { a, places } => {
                out.extend(b"ccopy_reg\n_reconstructor\n(cchumpy.reordering\nSelect\nc__builtin__\nobject\n\
                    NtR}(");
                text("a", out);
                array([a.of(8) as u64, 1], ("f8", 8 * a.of(8)), false, out);
                text("idxs", out);
                array([places.of(4) as u64, 1], ("i4", 4 * places.of(4)), false, out);
                out.extend(b"ub");
            }
            Self::Cycle => {
                out.push(b']');
                let list = remember(memo, out);
                get(list, out);
                out.push(b'a');
            }
            Self::Global(which) => out.extend(
                [
                    &b"ccollections\nOrderedDict\n)R"[..],
                    b"cos\nsystem\n",
                    b"c__builtin__\nset\n](K\x01e\x85R",
                ][usize::from(*which) % 3],
            ),
        }
    }
}

impl Choices {
    pub fn file(&self) -> Vec<u8> {
        let mut file = b"\x80\x02}(".to_vec();
        let mut memo = 0;
        let keys = KEYS[usize::from(self.keys) % KEYS.len()];
        for (value, key) in self.values.iter().zip(keys) {
            let Some(value) = value else { continue };
            text(key, &mut file);
            value.write(&mut memo, &mut file);
        }
        file.extend(b"u.");
        self.patch.into_iter().for_each(|patch| patch.apply(&mut file, false));
        file
    }
}

pub(crate) fn file(bytes: &[u8]) -> Vec<u8> {
    choose::<Choices>(bytes).map_or_else(Vec::new, |choices| choices.file())
}

pub(crate) fn run(bytes: &[u8]) {
    reading::pickled(&file(bytes));
}
