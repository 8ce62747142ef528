//! Malicious array files: truncated, larger than stated, and programs.

#![expect(clippy::unwrap_used, reason = "a test stops at what should not fail")]

use std::io::{Cursor, Write as _};
use std::path::Path;

use uvgraft_io::arrays::{self, ArraysError, NamedArrays, NumericArray};
use uvgraft_io::{fate, torch};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

fn sample(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/array_samples");
    std::fs::read(folder.join(name)).unwrap()
}

const SAMPLES: [&str; 6] = [
    "python2_protocol0.pkl",
    "python2_protocol2.pkl",
    "python3_protocol4.pkl",
    "deflated.npz",
    "tensors.pth",
    "fate_tex_dump.pth",
];

fn error(bytes: &[u8]) -> String {
    arrays::parse(bytes).unwrap_err().to_string()
}

#[test]
fn every_cut_is_an_error() {
    for name in SAMPLES {
        let bytes = sample(name);
        for length in 0..bytes.len() {
            assert!(arrays::parse(&bytes[..length]).is_err(), "{name} cut to {length}");
            assert!(torch::parse(&bytes[..length]).is_err(), "{name} cut to {length}");
            assert!(fate::parse_dump(&bytes[..length], 2).is_err(), "{name} cut to {length}");
        }
    }
}

#[test]
fn changed_bytes_are_no_panic() {
    let mut random = fastrand::Rng::with_seed(7);
    for name in SAMPLES {
        let bytes = sample(name);
        for at in 0..bytes.len() {
            for _ in 0..3 {
                let mut changed = bytes.clone();
                changed[at] = random.u8(..);
                let _ = arrays::parse(&changed);
            }
        }
    }
}

fn archive(entries: &[(&str, &[u8])], method: CompressionMethod) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in entries {
        let options = SimpleFileOptions::default().compression_method(method);
        archive.start_file(*name, options).unwrap();
        archive.write_all(content).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

fn npz(entries: &[(&str, &[u8])]) -> Vec<u8> {
    archive(entries, CompressionMethod::Deflated)
}

fn npy(descr: &str, shape: &str, values: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}}}\n");
    let mut bytes = b"\x93NUMPY\x01\0".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(values);
    bytes
}

/// Sets a field of four bytes in both headers of an archive's only entry.
fn with_field(mut bytes: Vec<u8>, local: usize, central: usize, value: u32) -> Vec<u8> {
    let directory = bytes.windows(4).rposition(|at| at == b"PK\x01\x02").unwrap();
    for at in [local, directory + central] {
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
    }
    bytes
}

#[test]
fn archives_unpack_to_what_they_say() {
    let sound = npz(&[("a.npy", &npy("'|u1'", "(9000,)", &[7; 9000]))]);
    assert_eq!(arrays::parse(&sound).unwrap().get("a").unwrap().shape(), [9000]);
    // More than stated: the unpacked bytes are counted, whatever the header says.
    let less = with_field(sound.clone(), 22, 24, 100);
    assert!(error(&less).starts_with("array `a.npy`: "), "{}", error(&less));
    // Less than stated, within what so few bytes can expand to.
    let more = with_field(sound.clone(), 22, 24, 10_000);
    assert!(error(&more).starts_with("array `a.npy`: "), "{}", error(&more));
    // More than they can expand to: nothing is reserved for it.
    let claimed = with_field(sound.clone(), 22, 24, 1 << 29);
    assert!(
        error(&claimed).contains("compressed bytes cannot expand to 536870912"),
        "{}",
        error(&claimed)
    );
    let beyond = with_field(sound.clone(), 22, 24, (1 << 30) + 1);
    let wanted = "must have at most 1073741824 uncompressed bytes";
    assert_eq!(error(&beyond), wanted);
    let checksum = with_field(sound, 14, 16, 5);
    assert!(error(&checksum).contains("checksum"), "{}", error(&checksum));
}

#[test]
fn names_come_once() {
    let array = npy("'|u1'", "(1,)", &[7]);
    let mut twice = npz(&[("a.npy", &array), ("b.npy", &array)]);
    for at in 0..twice.len() - 5 {
        if twice[at..].starts_with(b"b.npy") {
            twice[at] = b'a';
        }
    }
    assert!(error(&twice).contains("duplicate entry names"), "{}", error(&twice));
    let beside = npz(&[("a.npy", &array), ("notes.txt", b"text"), ("folder/c.npy", &array)]);
    let found = arrays::parse(&beside).unwrap();
    assert_eq!(found.names().collect::<Vec<_>>(), ["a", "folder/c"]);
    assert_eq!(found.left_out("notes.txt"), Some("not a .npy file"));
}

#[test]
fn shapes_that_do_not_fit() {
    let entry = |descr, shape, values: &[u8]| error(&npz(&[("a.npy", &npy(descr, shape, values))]));
    assert_eq!(
        entry("'<f4'", "(2,)", &[0; 7]),
        "array `a`: an array of shape [2] must have 8 bytes, got 7"
    );
    assert_eq!(
        entry("'<f4'", "(1,)", &[0; 7]),
        "array `a`: an array of shape [1] must have 4 bytes, got 7"
    );
    let huge = entry("'<f8'", "(4294967296, 4294967296)", &[0; 8]);
    assert!(huge.contains("must have 147573952589676412928 bytes, got 8"), "{huge}");
    assert!(entry("'<U9223372036854775807'", "(2,)", &[]).contains("must have more bytes"));
    for shape in ["(-1,)", "7", "(99999999999999999999,)", "(1.5,)"] {
        assert!(entry("'<f4'", shape, &[]).contains("shape must have"), "{shape}");
    }
    let axes = format!("({})", "1,".repeat(65));
    assert!(entry("'<f4'", &axes, &[]).contains("shape must have"));
    assert!(entry("'<U1'", "()", &[0, 0, 0x11, 0]).contains("invalid character"));
    assert!(error(&npz(&[("a.npy", b"text")])).contains("must be an NPY array, got `text`"));
    // Valid values other than numeric arrays are skipped.
    for (descr, shape, values, reason) in [
        ("'<c8'", "(1,)", 8, "an array of dtype `<c8`"),
        ("[('x', '<f4')]", "(1,)", 4, "a structured array"),
        ("'<U1'", "(2,)", 8, "an array of strings of shape [2]"),
        ("'<u8'", "(1,)", 8, "an array of integers beyond 63 bits"),
    ] {
        let bytes = npz(&[("a.npy", &npy(descr, shape, &[0xff; 8][..values]))]);
        assert_eq!(arrays::parse(&bytes).unwrap().left_out("a"), Some(reason));
    }
}

#[test]
fn programs_are_refused_by_name() {
    let system = b"\x80\x02cos\nsystem\nU\x04echo\x85R.";
    let refused = "refused: the pickle imports os.system, but only plain data may be loaded";
    assert_eq!(error(system), refused);
    assert_eq!(error(&npz(&[("archive/data.pkl", system)])), refused);
    let object = npz(&[("a.npy", &npy("'|O'", "(1,)", system))]);
    assert_eq!(arrays::parse(&object).unwrap().left_out("a"), Some(refused));
    for name in ["chumpy.ch_ops\nadd", "torch._utils\n_rebuild_sparse_tensor", "torch\nload"] {
        let bytes = format!("c{name}\n.");
        let wanted = format!("refused: the pickle imports {}, ", name.replace('\n', "."));
        assert!(error(bytes.as_bytes()).starts_with(&wanted), "{}", error(bytes.as_bytes()));
    }
    // Only known classes are created, and only based on `object`.
    let other = b"ccopy_reg\n_reconstructor\n(cnumpy\ndtype\nc__builtin__\nobject\nNtR.";
    assert!(error(other).contains("unknown class"), "{}", error(other));
    let base = b"ccopy_reg\n_reconstructor\n(cchumpy.ch\nCh\ncnumpy\ndtype\nNtR.";
    assert!(error(base).contains("unsupported call of Reconstructor"), "{}", error(base));
}

/// A pickle of a dict that has the result of some instructions under the name `a`.
fn pickle(value: &[u8]) -> Vec<u8> {
    [&b"\x80\x02}U\x01a"[..], value, b"s."].concat()
}

/// Instructions for a one-dimensional array of 64-bit integers.
fn list(numbers: &[i64]) -> Vec<u8> {
    let mut bytes = b"cnumpy.core.numeric\n_frombuffer\n(U".to_vec();
    bytes.push(8 * numbers.len() as u8);
    bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    bytes.extend(b"cnumpy\ndtype\nU\x02i8\x85RK");
    bytes.push(numbers.len() as u8);
    bytes.extend(b"\x85U\x01CtR");
    bytes
}

#[test]
fn arrays_of_objects_have_as_many_as_they_say() {
    let objects = |shape: &[u8]| {
        let new = &b"cnumpy.core.multiarray\n_reconstruct\n(cnumpy\nndarray\nK\0\x85U\x01btR"[..];
        let state = [b"(K\x01", shape, b"cnumpy\ndtype\nU\x02O8\x85R\x89](K\x01K\x02e"].concat();
        pickle(&[new, &state, b"tb"].concat())
    };
    assert!(arrays::parse(&objects(b"K\x02\x85")).is_ok());
    for other in [&b"K\x03\x85"[..], b"K\x01\x85", b"K\x02K\x02\x86"] {
        assert!(error(&objects(other)).contains("does not match the shape of their array"));
    }
}

/// An object with attributes, given the instructions that create them.
fn object(class: &str, attributes: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = format!("c{class}\n)\x00}}(").into_bytes();
    let newobj = bytes.iter().position(|&byte| byte == 0).unwrap();
    bytes[newobj] = 0x81;
    for (name, value) in attributes {
        bytes.push(b'U');
        bytes.push(name.len() as u8);
        bytes.extend(name.as_bytes());
        bytes.extend(value);
    }
    bytes.extend(b"ub");
    bytes
}

fn columns(shape: &[u8], starts: &[i64], rows: &[i64], data: &[i64]) -> Vec<u8> {
    let attributes = [
        ("_shape", shape.to_vec()),
        ("indptr", list(starts)),
        ("indices", list(rows)),
        ("data", list(data)),
    ];
    pickle(&object("scipy.sparse.csc\ncsc_matrix", &attributes))
}

#[test]
fn sparse_matrices_that_are_not_what_they_say() {
    let shape = b"K\x02K\x02\x86";
    let sound = arrays::parse(&columns(shape, &[0, 1, 3], &[1, 0, 0], &[5, 6, 7])).unwrap();
    // Two values at the same coordinates are summed.
    assert_eq!(sound.get("a").unwrap().f64s()[..], [0.0, 13.0, 5.0, 0.0]);
    // More was reserved than is used.
    let spare = arrays::parse(&columns(shape, &[0, 1, 1], &[1, 9], &[5, 6])).unwrap();
    assert_eq!(spare.get("a").unwrap().f64s()[..], [0.0, 0.0, 5.0, 0.0]);
    for (starts, rows, data, wanted) in [
        (&[0, 1][..], &[0][..], &[1][..], "`indptr` of a sparse matrix does not match"),
        (&[0, 2, 1], &[0, 0], &[1, 1], "`indptr` of a sparse matrix does not match"),
        (&[1, 1, 1], &[0], &[1], "`indptr` of a sparse matrix does not match"),
        (&[0, 1, 9], &[0], &[1], "`indptr` of a sparse matrix does not match"),
        (&[0, i64::MIN, i64::MAX], &[0], &[1], "`indptr` of a sparse matrix does not match"),
        (&[0, 1, 2], &[0], &[1, 1], "fewer `indices` than values"),
        (&[0, 1, 1], &[2], &[1], "2 x 2 has a value at 2, 0"),
        (&[0, 1, 1], &[-1], &[1], "2 x 2 has a value at -1, 0"),
    ] {
        let found = error(&columns(shape, starts, rows, data));
        assert!(found.starts_with("array `a`: ") && found.contains(wanted), "{found}");
    }
    let max = b"\x8a\x08\xff\xff\xff\xff\xff\xff\xff\x7f";
    for shape in [[&max[..], max, b"\x86"].concat(), b"M\xff\xffM\xff\xff\x86".to_vec()] {
        let found = arrays::parse(&columns(&shape, &[0], &[], &[])).unwrap();
        assert!(found.left_out("a").unwrap().contains("at most 2097152 values are supported"));
    }
    let flat = [&b"K\0"[..], max, b"\x86"].concat();
    assert!(error(&columns(&flat, &[0], &[], &[])).contains("`indptr`"));
    assert!(error(&columns(b"K\x02\x85", &[0], &[], &[])).contains("must have two dimensions"));
    let empty = pickle(&object("scipy.sparse.csc\ncsc_matrix", &[("_shape", shape.to_vec())]));
    assert!(error(&empty).contains("must have `data`"));
}

#[test]
fn chumpy_arrays_that_are_not_what_they_say() {
    let ch = |x: Vec<u8>| object("chumpy.ch\nCh", &[("x", x)]);
    let select = |a: Vec<u8>, places: &[i64], shape: &[u8]| {
        let attributes = [("a", a), ("idxs", list(places)), ("preferred_shape", shape.to_vec())];
        pickle(&object("chumpy.reordering\nSelect", &attributes))
    };
    let sound = arrays::parse(&select(ch(list(&[5, 6, 7])), &[2, -3], b"K\x02\x85")).unwrap();
    assert_eq!(sound.get("a").unwrap().integers().unwrap(), [7, 5]);
    for (places, shape, wanted) in [
        (&[3][..], &b"K\x01\x85"[..], "indices out of range"),
        (&[-4], b"K\x01\x85", "indices out of range"),
        (&[i64::MIN], b"K\x01\x85", "indices out of range"),
        (&[0], b"K\x02\x85", "does not match its values"),
        (&[0], b"J\xff\xff\xff\xff\x85", "does not match its values"),
    ] {
        let found = error(&select(ch(list(&[5, 6, 7])), places, shape));
        assert!(found.contains(wanted), "{found}");
    }
    assert!(error(&pickle(&object("chumpy.ch\nCh", &[]))).contains("must have an `x`"));
    // An object that contains itself.
    let own = pickle(b"cchumpy.ch\nCh\n)\x81q\0}U\x01xh\0sb");
    let found = arrays::parse(&own).unwrap();
    assert_eq!(found.left_out("a"), Some("arrays nested too deeply in lists or objects"));
}

#[test]
fn what_holds_itself_or_doubles_ends() {
    let own = arrays::parse(b"\x80\x02}q\0U\x01ah\0s.").unwrap();
    let left: Vec<&str> = own.names().collect();
    assert!(left.is_empty(), "{left:?}");
    // Each dict contains the previous one twice, 40 levels deep.
    let mut doubled = b"\x80\x02}q\0".to_vec();
    for _ in 0..40 {
        doubled.extend(b"0}(U\x01ah\0U\x01bh\0uq\0");
    }
    doubled.push(b'.');
    assert!(error(&doubled).ends_with(" names"), "{}", error(&doubled));
    // The same with lists, and with objects.
    let mut doubled = b"(K\x01K\x01lq\0".to_vec();
    doubled.extend(b"0(h\0h\0lq\0".repeat(12));
    assert_eq!(arrays::parse(&pickle(&doubled)).unwrap().get("a").unwrap().shape().len(), 13);
    let mut wide = [&b"("[..], &b"N".repeat(2000), b"lq\0"].concat();
    wide.extend([&b"0("[..], &b"h\0".repeat(2000), b"l"].concat());
    assert_eq!(arrays::parse(&pickle(&wide)).unwrap().left_out("a"), Some("None"));
    let mut wide = [&b"("[..], &b"K\x01".repeat(2000), b"lq\0"].concat();
    wide.extend([&b"0("[..], &b"h\0".repeat(2000), b"l"].concat());
    assert!(error(&pickle(&wide)).ends_with(" list items"));
    // One array of a megabyte under a thousand names is a gigabyte.
    let mut many = b"\x80\x02cnumpy.core.numeric\n_frombuffer\n(B\0\0\x10\0".to_vec();
    many.extend(vec![0; 1 << 20]);
    many.extend(b"cnumpy\ndtype\nU\x02u1\x85RJ\0\0\x10\0\x85U\x01CtRq\x000}(");
    for name in 0..1000_u16 {
        many.push(b'M');
        many.extend(name.to_le_bytes());
        many.extend(b"h\0");
    }
    many.extend(b"u.");
    assert!(error(&many).ends_with(" numbers"), "{}", error(&many));
    // One of a kilobyte under ten thousand is ten megabytes, of a file of 60 kB.
    let repeated = |names: u16| {
        let mut many = b"\x80\x02cnumpy.core.numeric\n_frombuffer\n(B\0\x04\0\0".to_vec();
        many.extend(vec![0; 1 << 10]);
        many.extend(b"cnumpy\ndtype\nU\x02u1\x85RM\0\x04\x85U\x01CtRq\x000}(");
        for name in 0..names {
            many.push(b'M');
            many.extend(name.to_le_bytes());
            many.extend(b"h\0");
        }
        many.extend(b"u.");
        many
    };
    assert!(arrays::parse(&repeated(1_000)).is_ok());
    assert!(error(&repeated(10_000)).ends_with(" numbers"), "{}", error(&repeated(10_000)));
}

/// A torch file of one tensor in a storage of six 32-bit floats.
fn tensor(offset: &[u8], shape: &[u8], strides: &[u8], storage: &[u8]) -> Vec<u8> {
    let pickle = [
        b"\x80\x02ctorch._utils\n_rebuild_tensor_v2\n((U\x07storagectorch\nFloatStorage\nU\x010U\x03cpuK\x06tQ",
        offset,
        shape,
        strides,
        b"\x89ccollections\nOrderedDict\n)RtR.",
    ]
    .concat();
    let entries = [("x/data.pkl", &pickle[..]), ("x/byteorder", b"big"), ("x/data/0", storage)];
    archive(&entries, CompressionMethod::Stored)
}

#[test]
fn tensors_stay_in_their_storage() {
    let storage: Vec<u8> = (0..6).flat_map(|number| (number as f32).to_be_bytes()).collect();
    let read = |offset: &[u8], shape: &[u8], strides: &[u8]| {
        torch::parse(&tensor(offset, shape, strides, &storage)).map_err(|error| error.to_string())
    };
    let sound = read(b"K\x01", b"K\x02K\x02\x86", b"K\x03K\x01\x86").unwrap();
    assert_eq!(sound.get("").unwrap().f32s()[..], [1.0, 2.0, 4.0, 5.0]);
    let repeated = read(b"K\x05", b"K\x03\x85", b"K\0\x85").unwrap();
    assert_eq!(repeated.get("").unwrap().f32s()[..], [5.0; 3]);
    let none = read(b"K\x09", b"K\0K\x03\x86", b"K\x07K\x07\x86").unwrap();
    assert_eq!(none.get("").unwrap().shape(), [0, 3]);
    let max = b"\x8a\x08\xff\xff\xff\xff\xff\xff\xff\x7f";
    let long = [&max[..], b"\x85"].concat();
    let both = [&max[..], max, b"\x86"].concat();
    let beyond = "exceeds its storage of 6 values";
    for (offset, shape, strides, wanted) in [
        (&b"K\x02"[..], &b"K\x02K\x02\x86"[..], &b"K\x03K\x01\x86"[..], beyond),
        (b"K\x06", b")", b")", beyond),
        (max, b")", b")", beyond),
        (b"K\0", b"K\x02\x85", &long, beyond),
        (b"K\0", &long, b"K\0\x85", " numbers"),
        (b"K\0", b"J\0\0\x40\0\x85", b"K\0\x85", " numbers"),
        (b"K\0", &both, b"K\0K\0\x86", "has too many values"),
        (b"K\0", b"K\x02\x85", b")", "stride for each dimension"),
        (b"J\xff\xff\xff\xff", b")", b")", "without an offset"),
        (b"K\0", b"J\xff\xff\xff\xff\x85", b"K\x01\x85", "without a shape"),
        (b"K\0", b"K\x01\x85", b"J\xff\xff\xff\xff\x85", "stride for each dimension"),
    ] {
        let found = read(offset, shape, strides).unwrap_err();
        assert!(found.contains(wanted), "{found}, not {wanted}");
    }
    let short = torch::parse(&tensor(b"K\0", b")", b")", &storage[..20])).unwrap_err().to_string();
    assert!(short.contains("a storage of 6 values of 4 bytes cannot have 20 bytes"), "{short}");
    // Only torch files may refer to data outside of a pickle.
    let outside = pickle(b"K\x01Q");
    assert!(error(&outside).contains("unsupported instruction 0x51"));
    let missing = archive(&[("data.pkl", &outside)], CompressionMethod::Stored);
    let found = torch::parse(&missing).unwrap();
    assert_eq!(found.left_out("a"), Some("an external object"));
}

#[test]
fn other_files_are_reported_apart() {
    for (bytes, wanted) in [
        (&b""[..], "must be an NPZ archive or a pickle of arrays by name, got an empty file"),
        (b"v 0 0 0\n", "got a file that starts with `v 0 0 0\\n`"),
        (&npy("'<f4'", "()", &[0; 4]), "got a single NPY array"),
        (b"(N.", "values left on the stack"),
        (b"(lp0\nNa.", "the pickle must hold a dict of arrays by name, got None"),
        (b"c__builtin__\nset\n)R.", "the pickle must hold a dict of arrays by name, got a set"),
    ] {
        assert!(error(bytes).contains(wanted), "{}, not {wanted}", error(bytes));
    }
    // A bare list is an array without a name.
    assert_eq!(arrays::parse(b"]q\0.").unwrap().get("").unwrap().shape(), [0]);
    let mut arrays = NamedArrays::new();
    arrays.insert("a", NumericArray::new_i64(vec![], vec![1]).unwrap());
    assert!(matches!(arrays.require("b"), Err(ArraysError::Missing { .. })));
}
