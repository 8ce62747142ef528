//! NPY, NPZ and pickles of NumPy and of scripts: vertex maps, and body models as meshes.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use uvgraft_io::arrays::{NamedArrays, NumericArray, save_npz_compressed};

use super::meshes::{self, Sheet, difference};
use super::{Case, Expected, Near, Refused, Same, case, check};
use crate::bench::{Bench, SHEET_VERTICES, target_of};

/// An NPY file.
fn npy(dtype: &str, is_fortran: bool, shape: &[usize], data: &[u8]) -> Vec<u8> {
    let order = if is_fortran { "True" } else { "False" };
    let shape: String = shape.iter().map(|length| format!("{length}, ")).collect();
    let mut header =
        format!("{{'descr': '{dtype}', 'fortran_order': {order}, 'shape': ({shape}), }}");
    header += &" ".repeat(63 - (header.len() + 10) % 64);
    header += "\n";
    [b"\x93NUMPY\x01\0", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), data].concat()
}

/// A ZIP archive of stored members.
fn zip(members: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let (mut file, mut directory) = (Vec::new(), Vec::new());
    for (name, content) in members {
        let name = format!("{name}.npy");
        let size = (content.len() as u32).to_le_bytes();
        let mut common = b"\x14\0\0\0\0\0\0\0\0\0".to_vec();
        common.extend(crc(content).to_le_bytes());
        common.extend([size, size].concat());
        common.extend((name.len() as u16).to_le_bytes());
        common.extend([0, 0]);
        directory.extend(b"PK\x01\x02\x14\0");
        directory.extend(&common);
        directory.extend([0; 10]);
        directory.extend((file.len() as u32).to_le_bytes());
        directory.extend(name.bytes());
        file.extend(b"PK\x03\x04");
        file.extend(common);
        file.extend(name.bytes());
        file.extend(content);
    }
    let count = (members.len() as u16).to_le_bytes();
    let end = [
        &count[..],
        &count,
        &(directory.len() as u32).to_le_bytes(),
        &(file.len() as u32).to_le_bytes(),
    ]
    .concat();
    [file, directory, b"PK\x05\x06\0\0\0\0".to_vec(), end, vec![0, 0]].concat()
}

fn crc(bytes: &[u8]) -> u32 {
    let shift = |crc: u32| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), |crc, _| shift(crc)))
}

/// The array of a model: its name, whether it holds integers, its rows and their width.
struct Field {
    name: &'static str,
    is_integer: bool,
    values: Vec<f64>,
    width: usize,
}

/// The sheet as a body model has it.
fn model() -> [Field; 4] {
    let sheet = Sheet::new();
    let floats = |values: &[f32]| values.iter().copied().map(f64::from).collect();
    let corners = |which: fn((u32, u32)) -> u32| {
        sheet
            .triangles()
            .into_iter()
            .flat_map(|it| it.map(|corner| f64::from(which(corner))))
            .collect()
    };
    [
        Field {
            name: "v_template",
            is_integer: false,
            values: floats(sheet.positions.as_flattened()),
            width: 3,
        },
        Field { name: "f", is_integer: true, values: corners(|(vertex, _)| vertex), width: 3 },
        Field { name: "vt", is_integer: false, values: floats(sheet.uv.as_flattened()), width: 2 },
        Field { name: "ft", is_integer: true, values: corners(|(_, uv)| uv), width: 3 },
    ]
}

impl Field {
    fn shape(&self) -> [usize; 2] {
        [self.values.len() / self.width, self.width]
    }

    /// Its values column by column.
    fn columns(&self) -> Vec<f64> {
        let column = |k: usize| self.values.iter().skip(k).step_by(self.width).copied();
        (0..self.width).flat_map(column).collect()
    }
}

fn encoded(values: &[f64], bytes: impl Fn(f64) -> Vec<u8>) -> Vec<u8> {
    values.iter().flat_map(|&value| bytes(value)).collect()
}

/// The model with floats and integers of these types.
fn npz(floats: (&str, fn(f64) -> Vec<u8>), integers: (&str, fn(f64) -> Vec<u8>)) -> Vec<u8> {
    let member = |field: &Field| {
        let (dtype, bytes) = if field.is_integer { integers } else { floats };
        (field.name, npy(dtype, false, &field.shape(), &encoded(&field.values, bytes)))
    };
    zip(&model().each_ref().map(member))
}

/// The model with one array replaced by another file.
fn with(name: &str, file: impl Fn(&Field) -> Vec<u8>) -> Vec<u8> {
    let member = |field: &Field| {
        let (dtype, bytes) = if field.is_integer { I64 } else { F32 };
        let usual = || npy(dtype, false, &field.shape(), &encoded(&field.values, bytes));
        (field.name, if field.name == name { file(field) } else { usual() })
    };
    zip(&model().each_ref().map(member))
}

const F32: (&str, fn(f64) -> Vec<u8>) = ("<f4", |value| (value as f32).to_le_bytes().to_vec());
const I64: (&str, fn(f64) -> Vec<u8>) = ("<i8", |value| (value as i64).to_le_bytes().to_vec());

/// A float of 16 bits; only for multiples of 1/64 below 4.
fn half(value: f64) -> u16 {
    if value == 0.0 {
        return 0;
    }
    let exponent = value.abs().log2().floor();
    let mantissa = (value.abs() / exponent.exp2() - 1.0) * 1024.0;
    u16::from(value < 0.0) << 15 | ((exponent as i32 + 15) as u16) << 10 | mantissa as u16
}

/// A pickled dictionary of arrays, protocol 2.
fn pickled() -> Vec<u8> {
    let mut file = b"\x80\x02}(".to_vec();
    let long = |bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes()[..], bytes].concat();
    for field in model() {
        let (kind, bytes) = if field.is_integer { (b"i8", I64.1) } else { (b"f4", F32.1) };
        let [rows, columns] = field.shape().map(|length| length as u8);
        file.extend([b"X", &long(field.name.as_bytes())[..]].concat());
        file.extend(b"cnumpy.core.multiarray\n_reconstruct\n(cnumpy\nndarray\nK\0\x85U\x01btR");
        file.extend(
            [b"(K\x01K", &[rows][..], b"K", &[columns], b"\x86cnumpy\ndtype\n(U\x02", kind]
                .concat(),
        );
        file.extend(b"K\0K\x01tR(K\x03U\x01<NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\0tb\x89T");
        file.extend(long(&encoded(&field.values, bytes)));
        file.extend(b"tb");
    }
    file.extend(b"u.");
    file
}

fn compressed() -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let mut arrays = NamedArrays::new();
    for field in model() {
        let (shape, values) = (field.shape().to_vec(), &field.values);
        let array = if field.is_integer {
            NumericArray::new_i64(shape, values.iter().map(|&value| value as i64).collect())
        } else {
            NumericArray::new_f32(shape, values.iter().map(|&value| value as f32).collect())
        };
        arrays.insert(field.name, array.unwrap());
    }
    let path = folder.path().join("a.npz");
    save_npz_compressed(&arrays, &path).unwrap();
    std::fs::read(path).unwrap()
}

fn models() -> Vec<Case> {
    let file =
        |name, content: Vec<u8>, expected: Expected| case(name, "model.npz", content, expected);
    let of_field = |dtype: &'static str, is_fortran, transposed: bool| {
        move |field: &Field| {
            let [rows, columns] = field.shape();
            let shape = if transposed { [columns, rows] } else { [rows, columns] };
            npy(
                dtype,
                is_fortran,
                &shape,
                &encoded(&field.columns(), if field.is_integer { I64.1 } else { F32.1 }),
            )
        }
    };
    let objects = |_: &Field| npy("|O", false, &[12, 3], b"\x80\x02]q\0.");
    vec![
        file("32 bits", npz(F32, I64), Same),
        file(
            "64 bits",
            npz(
                ("<f8", |value| value.to_le_bytes().to_vec()),
                ("<u4", |value| (value as u32).to_le_bytes().to_vec()),
            ),
            Same,
        ),
        file(
            "16 bits",
            npz(
                ("<f2", |value| half(value).to_le_bytes().to_vec()),
                ("<u2", |value| (value as u16).to_le_bytes().to_vec()),
            ),
            Near(1e-6),
        ),
        file(
            "big-endian",
            npz(
                (">f4", |value| (value as f32).to_be_bytes().to_vec()),
                (">i4", |value| (value as i32).to_be_bytes().to_vec()),
            ),
            Same,
        ),
        file("bytes as indices", npz(F32, ("|u1", |value| vec![value as u8])), Same),
        file("compressed", compressed(), Same),
        file("Fortran order", with("v_template", of_field("<f4", true, false)), Same),
        file("indices in Fortran order", with("f", of_field("<i8", true, false)), Same),
        file("a pickled dictionary", pickled(), Same),
        file(
            "transposed",
            with("v_template", of_field("<f4", false, true)),
            Refused("`v_template` must have shape [vertices, 3], got [3, 12]"),
        ),
        file(
            "transposed faces",
            with("f", of_field("<i8", false, true)),
            Refused("`f` must have shape"),
        ),
        file("objects", with("v_template", objects), Refused("`v_template`")),
        file(
            "floats as indices",
            with("f", |field| {
                npy(
                    "<f4",
                    false,
                    &field.shape(),
                    &encoded(&field.values, |value| (value as f32 + 0.5).to_le_bytes().to_vec()),
                )
            }),
            Refused("`f`"),
        ),
        file(
            "NaN",
            with("vt", |field| {
                npy(
                    "<f4",
                    false,
                    &field.shape(),
                    &encoded(&field.values, |_| f32::NAN.to_le_bytes().to_vec()),
                )
            }),
            Refused("must be finite"),
        ),
        file(
            "indices from 1",
            with("f", |field| {
                npy(
                    "<i8",
                    false,
                    &field.shape(),
                    &encoded(&field.values, |value| (value as i64 + 1).to_le_bytes().to_vec()),
                )
            }),
            Refused("uses vertex 12"),
        ),
        file("cut", npz(F32, I64)[..600].to_vec(), Refused("model.npz")),
        file(
            "many arrays",
            {
                let names: Vec<String> =
                    (0..300).map(|k| format!("an_array_with_a_long_name_{k:03}")).collect();
                zip(&names
                    .iter()
                    .map(|name| (name.as_str(), npy("<f4", false, &[1], &[0; 4])))
                    .collect::<Vec<_>>())
            },
            Refused("`an_array_with_a_long_name_009` and 290 more"),
        ),
    ]
}

fn ids() -> Vec<i64> {
    (0..SHEET_VERTICES).map(|vertex| i64::from(target_of(vertex))).collect()
}

fn maps() -> Vec<Case> {
    let count = ids().len();
    let file =
        |name, file, content: Vec<u8>, expected: Expected| case(name, file, content, expected);
    let array = |dtype: &str, shape: &[usize], bytes: fn(i64) -> Vec<u8>| {
        npy(dtype, false, shape, &ids().into_iter().flat_map(bytes).collect::<Vec<u8>>())
    };
    let wide: fn(i64) -> Vec<u8> = |id| id.to_le_bytes().to_vec();
    let text = |between: &str| ids().iter().map(i64::to_string).collect::<Vec<_>>().join(between);
    vec![
        file("64 bits", "map.npy", array("<i8", &[count], wide), Same),
        file(
            "big-endian",
            "map.npy",
            array(">i4", &[count], |id| (id as i32).to_be_bytes().to_vec()),
            Same,
        ),
        file("bytes", "map.npy", array("|u1", &[count], |id| vec![id as u8]), Same),
        file("a column", "map.npy", array("<i8", &[count, 1], wide), Same),
        file("lines", "map.txt", text("\n").into(), Same),
        file(
            "CR LF and a byte order mark",
            "map.txt",
            format!("\u{feff}{}\r\n", text("\r\n")).into(),
            Same,
        ),
        file("commas", "map.csv", text(", ").into(), Same),
        file(
            "floats",
            "map.npy",
            array("<f8", &[count], |id| (id as f64).to_le_bytes().to_vec()),
            Refused("must have dtype"),
        ),
        file("floats in text", "map.txt", text(".0\n").into(), Refused("must be an integer")),
        file(
            "two columns",
            "map.npy",
            array("<i8", &[5, 5], wide),
            Refused("must have shape (N,)"),
        ),
        file(
            "objects",
            "map.npy",
            npy("|O", false, &[count], b"\x80\x02]q\0."),
            Refused("must have dtype"),
        ),
        file(
            "an archive",
            "map.npz",
            zip(&[("ids", array("<i8", &[count], wide))]),
            Refused("must be a single array"),
        ),
        file(
            "too few",
            "map.txt",
            b"0 1 2".to_vec(),
            Refused("must have one entry per vertex of the source mesh, 25, got 3"),
        ),
        file(
            "from 1",
            "map.txt",
            ids().iter().map(|id| format!("{} ", id + 1)).collect::<String>().into(),
            Refused("are the indices 1-based?"),
        ),
    ]
}

#[test]
fn vertex_maps_count_vertices_before_others_were_appended() {
    let bench = Bench::new();
    let command = "pair longer.obj target.obj --vertex-map ids.npy -o new.uvpair";
    bench.derive("longer.obj", "source.obj", |text| text.extend(b"v 9 9 9\nv 8 9 9\nv 9 8 9\n"));
    let run = bench.run(command);
    let wanted = "note: ids.npy: taken for a map of the first 25 vertices (3 after them are left out) \
                  of the source mesh\n";
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), wanted));
    // One vertex before all others: its faces are those of the grid, one vertex further on.
    bench.derive("longer.obj", "source.obj", |text| {
        let shifted = |corner: &str| {
            let (vertex, uv) = corner.split_once('/').unwrap();
            format!("{}/{uv}", vertex.parse::<u32>().unwrap() + 1)
        };
        let line = |line: &str| match line.strip_prefix("f ") {
            Some(corners) => {
                format!("f {}", corners.split(' ').map(shifted).collect::<Vec<_>>().join(" "))
            }
            None => line.to_owned(),
        };
        let lines = std::str::from_utf8(text).unwrap().lines().map(line);
        *text = [vec!["v 9 9 9".to_owned()], lines.collect()].concat().join("\n").into_bytes();
    });
    bench.refuse(command, &["ids.npy: vertex map must have one entry per vertex", "26, got 25"]);
}

#[test]
fn model_files() {
    check(&Bench::new(), models(), meshes::COMMAND, difference);
}

#[test]
fn vertex_maps() {
    const OUT: &str = "new.uvpair";
    let bench = Bench::new();
    bench.succeed("pair source.obj target.obj --vertex-map ids.npy -o wanted.uvpair");
    let wanted = bench.bytes("wanted.uvpair");
    let same = |bench: &Bench| match bench.bytes(OUT) == wanted {
        true => Ok(0.0),
        false => Err("must be the same file".to_owned()),
    };
    let command = "pair source.obj target.obj --vertex-map FILE -o new.uvpair";
    check(&bench, maps(), (command, OUT), same);
}
