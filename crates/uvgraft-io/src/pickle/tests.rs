//! Pickles as written by Python, by protocol, and malicious ones.

use super::*;

/// `{"a": numpy.array([[1, 2], [3, 4]], "<f4")}`, as NumPy 2 writes it.
const ARRAYS: [&[u8]; 6] = [
    b"(dp0\nVa\np1\ncnumpy._core.multiarray\n_reconstruct\np2\n(cnumpy\nndarray\np3\n(I0\ntp4\n\
      c_codecs\nencode\np5\n(Vb\np6\nVlatin1\np7\ntp8\nRp9\ntp10\nRp11\n(I1\n(I2\nI2\ntp12\n\
      cnumpy\ndtype\np13\n(Vf4\np14\nI00\nI01\ntp15\nRp16\n(I3\nV<\np17\nNNNI-1\nI-1\nI0\ntp18\n\
      bI00\ng5\n(V\\u0000\\u0000\\u0080?\\u0000\\u0000\\u0000@\\u0000\\u0000@@\\u0000\\u0000\\u0080@\n\
      p19\ng7\ntp20\nRp21\ntp22\nbs.",
    b"}q\0X\x01\0\0\0aq\x01cnumpy._core.multiarray\n_reconstruct\nq\x02(cnumpy\nndarray\nq\x03(K\0tq\x04\
      c_codecs\nencode\nq\x05(X\x01\0\0\0bq\x06X\x06\0\0\0latin1q\x07tq\x08Rq\ttq\nRq\x0b(K\x01(K\x02K\x02t\
      q\x0ccnumpy\ndtype\nq\r(X\x02\0\0\0f4q\x0eI00\nI01\ntq\x0fRq\x10(K\x03X\x01\0\0\0<q\x11NNN\
      J\xff\xff\xff\xffJ\xff\xff\xff\xffK\0tq\x12bI00\nh\x05(X\x12\0\0\0\0\0\xc2\x80?\0\0\0@\0\0@@\0\0\xc2\x80@\
      q\x13h\x07tq\x14Rq\x15tq\x16bs.",
    b"\x80\x02}q\0X\x01\0\0\0aq\x01cnumpy._core.multiarray\n_reconstruct\nq\x02cnumpy\nndarray\nq\x03K\0\x85\
      q\x04c_codecs\nencode\nq\x05X\x01\0\0\0bq\x06X\x06\0\0\0latin1q\x07\x86q\x08Rq\t\x87q\nRq\x0b(K\x01K\x02\
      K\x02\x86q\x0ccnumpy\ndtype\nq\rX\x02\0\0\0f4q\x0e\x89\x88\x87q\x0fRq\x10(K\x03X\x01\0\0\0<q\x11NNN\
      J\xff\xff\xff\xffJ\xff\xff\xff\xffK\0tq\x12b\x89h\x05X\x12\0\0\0\0\0\xc2\x80?\0\0\0@\0\0@@\0\0\xc2\x80@\
      q\x13h\x07\x86q\x14Rq\x15tq\x16bs.",
    b"\x80\x03}q\0X\x01\0\0\0aq\x01cnumpy.core.multiarray\n_reconstruct\nq\x02cnumpy\nndarray\nq\x03K\0\x85\
      q\x04C\x01bq\x05\x87q\x06Rq\x07(K\x01K\x02K\x02\x86q\x08cnumpy\ndtype\nq\tX\x02\0\0\0f4q\n\x89\x88\x87\
      q\x0bRq\x0c(K\x03X\x01\0\0\0<q\rNNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\0tq\x0eb\x89C\x10\0\0\x80?\0\0\0@\
      \0\0@@\0\0\x80@q\x0ftq\x10bs.",
    b"\x80\x04\x95\xa2\0\0\0\0\0\0\0}\x94\x8c\x01a\x94\x8c\x16numpy._core.multiarray\x94\x8c\x0c_reconstruct\
      \x94\x93\x94\x8c\x05numpy\x94\x8c\x07ndarray\x94\x93\x94K\0\x85\x94C\x01b\x94\x87\x94R\x94(K\x01K\x02\
      K\x02\x86\x94h\x05\x8c\x05dtype\x94\x93\x94\x8c\x02f4\x94\x89\x88\x87\x94R\x94(K\x03\x8c\x01<\x94NNN\
      J\xff\xff\xff\xffJ\xff\xff\xff\xffK\0t\x94b\x89C\x10\0\0\x80?\0\0\0@\0\0@@\0\0\x80@\x94t\x94bs.",
    b"\x80\x05\x95\x8d\0\0\0\0\0\0\0}\x94\x8c\x01a\x94\x8c\x13numpy._core.numeric\x94\x8c\x0b_frombuffer\
      \x94\x93\x94(\x96\x10\0\0\0\0\0\0\0\0\0\x80?\0\0\0@\0\0@@\0\0\x80@\x94\x8c\x05numpy\x94\x8c\x05dtype\
      \x94\x93\x94\x8c\x02f4\x94\x89\x88\x87\x94R\x94(K\x03\x8c\x01<\x94NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xff\
      K\0t\x94bK\x02K\x02\x86\x94\x8c\x01C\x94t\x94R\x94s.",
];

fn error(bytes: &[u8]) -> String {
    parse(bytes).unwrap_err().to_string()
}

#[test]
fn arrays_of_every_protocol() {
    for (protocol, bytes) in ARRAYS.iter().enumerate() {
        let pickle = parse(bytes).unwrap_or_else(|error| panic!("protocol {protocol}: {error}"));
        let array = pickle.root().get("a").unwrap().as_array().unwrap();
        assert_eq!(array.shape(), [2, 2], "protocol {protocol}");
        assert_eq!(array.f32s().unwrap(), [1.0, 2.0, 3.0, 4.0], "protocol {protocol}");
    }
}

#[test]
fn every_cut_and_every_changed_byte_is_survived() {
    for bytes in ARRAYS {
        for end in 0..bytes.len() {
            assert!(parse(&bytes[..end]).is_err(), "cut at {end}");
        }
        for place in 0..bytes.len() {
            for value in 0..=255 {
                let mut changed = bytes.to_vec();
                changed[place] = value;
                // Some changes result in a pickle of something else.
                if let Ok(pickle) = parse(&changed) {
                    drop(
                        pickle.root().get("a").and_then(Value::as_array).map(|array| array.f32s()),
                    );
                }
            }
        }
    }
    assert_eq!(error(b""), "truncated pickle: byte 0 must be followed by 1 bytes, got 0");
    assert_eq!(error(b"N.N."), "unexpected 2 bytes after the end of the pickle");
}

#[test]
fn plain_values() {
    let int = |bytes: &[u8]| parse(bytes).unwrap().root().as_int();
    assert_eq!(int(b"I-7\n."), Some(-7));
    assert_eq!(int(b"L9223372036854775807L\n."), Some(i64::MAX));
    assert_eq!(int(b"K\xff."), Some(255));
    assert_eq!(int(b"M\x01\xff."), Some(65_281));
    assert_eq!(int(b"J\xfe\xff\xff\xff."), Some(-2));
    assert_eq!(int(b"\x80\x02\x8a\0."), Some(0));
    assert_eq!(int(b"\x80\x02\x8a\x02\0\x80."), Some(-32_768));
    assert_eq!(int(b"\x80\x02\x8b\x0a\0\0\0\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff."), Some(-1));
    let float = |bytes: &[u8]| parse(bytes).unwrap().root().as_float();
    assert_eq!(float(b"F-1.5\n."), Some(-1.5));
    assert_eq!(float(b"G\x3f\xe0\0\0\0\0\0\0."), Some(0.5));
    let text = |bytes: &[u8]| parse(bytes).unwrap().root().as_str().map(str::to_owned);
    assert_eq!(text("X\x04\0\0\0öß.".as_bytes()).as_deref(), Some("öß"));
    assert_eq!(text(b"V\xf6\\u00df\\U0001f600\\n\n.").as_deref(), Some("öß😀\\n"));
    assert_eq!(text(b"S'it\\'s\\x41\\n'\n.").as_deref(), Some("it'sA\n"));
    assert_eq!(text(b"U\x02ab.").as_deref(), Some("ab"));
    assert_eq!(parse(b"C\x02\xff\0.").unwrap().root().as_bytes(), Some(&[255, 0][..]));
    assert_eq!(parse(b"c__builtin__\nbytes\n)R.").unwrap().root().as_bytes(), Some(&[][..]));
    assert_eq!(parse(b"I01\n.").unwrap().root().as_bool(), Some(true));
    assert!(parse(b"N.").unwrap().root().is_none());

    let pickle = parse(b"(lp0\nI1\na(dp1\nVk\nI2\nsag1\na.").unwrap();
    let held: Vec<_> = pickle.root().items().unwrap().collect();
    assert_eq!(held[0].as_int(), Some(1));
    for dict in &held[1..] {
        assert_eq!(dict.get("k").and_then(Value::as_int), Some(2));
    }
    // Popping drops a mark too.
    assert_eq!(int(b"K\x01(0."), Some(1));
    assert_eq!(int(b"K\x01(NN1."), Some(1));
    assert_eq!(parse(b"K\x012\x86.").unwrap().root().items().unwrap().len(), 2);
    let pickle = parse(b"}(X\x01\0\0\0kK\x05X\x01\0\0\0k](K\x01\x88t\x85au.").unwrap();
    let root = pickle.root();
    assert_eq!(root.entries().unwrap().len(), 2);
    let last = root.get("k").unwrap();
    let inner = last.items().unwrap().next().unwrap().items().unwrap().next().unwrap();
    let kinds: Vec<_> = inner.items().unwrap().map(Value::kind).collect();
    assert_eq!((last.kind(), kinds), ("a list", vec!["an int", "a bool"]));
}

#[test]
fn whatever_could_run_is_refused_by_name() {
    let cases: [(&[u8], &str); 8] = [
        (b"cos\nsystem\n(S'echo'\ntR.", "os.system"),
        (b"cposix\nsystem\n.", "posix.system"),
        (b"\x80\x04\x8c\x08builtins\x8c\x04eval\x93\x8c\x011\x85R.", "builtins.eval"),
        (b"(S'1'\nios\nsystem\n.", "os.system"),
        (b"(cos\nsystem\nS'1'\no.", "os.system"),
        (b"csubprocess\nPopen\n)\x81.", "subprocess.Popen"),
        (b"cnumpy\nload\n.", "numpy.load"),
        (b"cnumpy.core.multiarray\n_reconstruct \n.", "numpy.core.multiarray._reconstruct "),
    ];
    for (bytes, name) in cases {
        let found = error(bytes);
        assert!(found.starts_with(&format!("refused: the pickle imports {name}, ")), "{found}");
    }
    let long = [&b"c"[..], &b"x".repeat(10_000), b"\nsystem\n."].concat();
    assert!(error(&long).len() < 200);
    // Persistent identifiers, extensions, out-of-band buffers, and unknown instructions.
    for instruction in *b"PQ\x82\x83\x84\x92\x97\x98\x00\xff?" {
        let found = error(&[b'N', instruction, 0, 0, 0, 0, b'\n']);
        let wanted = format!("unsupported instruction 0x{instruction:02x}");
        assert_eq!(found, format!("byte 1 of the pickle: {wanted}"));
    }
}

#[test]
fn lengths_are_checked_before_they_are_believed() {
    for bytes in [
        &b"X\xff\xff\xff\xffab"[..],
        b"B\xff\xff\xff\xff",
        b"T\xff\xff\xff\x7f",
        b"\x8d\xff\xff\xff\xff\xff\xff\xff\xff",
        b"\x8e\xff\xff\xff\xff\xff\xff\xff\x7f",
        b"\x96\0\0\0\0\x01\0\0\0",
        b"\x8b\xff\xff\xff\xff",
        b"\x8a\xff",
    ] {
        assert!(error(bytes).contains("truncated"), "{bytes:?}");
    }
    assert!(
        error(b"\x95\xff\xff\xff\xff\xff\xff\xff\xff.")
            .contains("a frame must have 18446744073709551615 bytes, got")
    );
    assert!(error(b"\x80\x06N.").contains("protocol must be at most 5, got 6"));
    assert!(error(b"\x8a\x09\0\0\0\0\0\0\0\0\x01.").contains("does not fit 64 bits"));
    assert!(error(b"\x8a\x09\0\0\0\0\0\0\0\x80\0.").contains("does not fit 64 bits"));
    assert!(error(b"I99999999999999999999\n.").contains("got `99999999999999999999`"));
    assert!(error(b"p-1\n.").contains("must be a number"));
    assert!(error(b"X\x01\0\0\0\xff.").contains("UTF-8"));
    for broken in
        [&b"V\\u12\n."[..], b"V\\ud800\n.", b"S'a\n.", b"S'\\x4'\n.", b"S'\\q'\n.", b"S'\n."]
    {
        assert!(parse(broken).is_err(), "{broken:?}");
    }
}

#[test]
fn instructions_that_do_not_fit_are_refused() {
    for (bytes, wanted) in [
        (&b"."[..], "stack underflow"),
        (b"t.", "missing mark"),
        (b"N(0.N.", "after the end"),
        (b"(N.", "values left on the stack"),
        (b"NN.", "values left on the stack"),
        (b"N(a.", "stack underflow"),
        (b"h\x05.", "memo 5 is used before"),
        (b"K\x01K\x02a.", "must append to a list, got an int"),
        (b"](NNu.", "must append to a dict, got a list"),
        (b"}(Nu.", "key without a value"),
        (b"(NNNd.", "key without a value"),
        (b"K\x01)R.", "must call a global, got an int"),
        (b"cnumpy\ndtype\nNR.", "must be a tuple, got None"),
        (b"cnumpy\nndarray\n)R.", "unsupported call of Ndarray"),
        (b"K\x01K\x02\x93.", "a name must be a string"),
        (b"N)b.", "None is built although it takes no state"),
        (b"cnumpy\ndtype\nU\x02f4\x85R)b.", "unsupported state of a dtype"),
    ] {
        let found = error(bytes);
        assert!(found.contains(wanted), "{bytes:?}\nfound:  {found}\nwanted: {wanted}");
    }
}

/// `_frombuffer(data, dtype(name), shape, order)`.
fn array_of(data: &[u8], dtype: &[u8], shape: &[u8], order: u8) -> Vec<u8> {
    let length = u8::try_from(data.len()).unwrap();
    let mut bytes = b"\x80\x03cnumpy.core.numeric\n_frombuffer\n(C".to_vec();
    bytes.push(length);
    bytes.extend(data);
    bytes.extend(b"cnumpy\ndtype\nU");
    bytes.push(dtype.len() as u8);
    bytes.extend(dtype);
    bytes.extend(b"\x89\x88\x87R");
    bytes.extend(shape);
    bytes.extend([b'U', 1, order]);
    bytes.extend(b"tR.");
    bytes
}

#[test]
fn arrays_that_are_not_what_they_say() {
    let floats = [0, 0, 128, 63, 0, 0, 0, 64];
    let bytes = array_of(&floats, b"f4", b"K\x02K\x01\x86", b'F');
    assert_eq!(parse(&bytes).unwrap().root().as_array().unwrap().f32s().unwrap(), [1.0, 2.0]);
    let big = array_of(&[63, 128, 0, 0], b">f4", b"K\x01\x85", b'C');
    assert_eq!(parse(&big).unwrap().root().as_array().unwrap().f32s().unwrap(), [1.0]);
    let whole = array_of(&floats, b"i4", b"K\x02\x85", b'C');
    assert_eq!(parse(&whole).unwrap().root().as_array().unwrap().f32s(), None);
    for dtype in [&b"O"[..], b"O8", b"V8", b"U2", b"S8", b"c8", b"datetime64"] {
        let found = error(&array_of(&floats, dtype, b"K\x01\x85", b'C'));
        assert!(found.contains("must be num"), "{found}");
    }
    // Lengths beyond the address space are no shape.
    let huge = if usize::BITS == 64 { "cannot have 8 bytes" } else { "without a shape" };
    for (shape, wanted) in [
        (&b"K\x03\x85"[..], "shape [3] with 4 bytes per value cannot have 8 bytes"),
        (b"K\x01\x85", "cannot have 8 bytes"),
        (b")", "shape [] with"),
        (b"J\xff\xff\xff\xff\x85", "without a shape"),
        (b"K\x02", "without a shape"),
        (b"U\x01a\x85", "without a shape"),
        (b"\x8a\x08\0\0\0\0\0\0\0\x40K\x08\x86", huge),
    ] {
        let found = error(&array_of(&floats, b"f4", shape, b'C'));
        assert!(found.contains(wanted), "found:  {found}\nwanted: {wanted}");
    }
    let axes = [&b"("[..], &b"K\x01".repeat(65), b"t"].concat();
    assert!(error(&array_of(&floats, b"f8", &axes, b'C')).contains("without a shape"));
    assert!(error(&array_of(&floats, b"f4", b"K\x02\x85", b'A')).contains("C or F"));
    let number = b"cnumpy.core.multiarray\nscalar\n(cnumpy\ndtype\nU\x02f4\x85RC\x04\0\0\x80?tR.";
    let pickle = parse(number).unwrap();
    let number = pickle.root().as_array().unwrap();
    assert_eq!((number.shape(), number.f32s().unwrap()), (&[][..], vec![1.0]));
    // An array that was never initialised is not an array.
    let empty = b"cnumpy.core.multiarray\n_reconstruct\n(cnumpy\nndarray\n)NtR.";
    assert!(parse(empty).unwrap().root().as_array().is_none());
}

#[test]
fn bombs() {
    // A tuple in a tuple in a tuple, half a million deep; dropped without recursion too.
    let deep = [&b")"[..], &b"\x85".repeat(500_000), b"."].concat();
    assert_eq!(parse(&deep).unwrap().root().kind(), "a tuple");
    let marks = [&b"(".repeat(500_000)[..], b"N."].concat();
    assert!(error(&marks).contains("left on the stack"));
    // Each tuple contains the previous one twice: 2^100 leaves if expanded.
    let doubled = [&b"K\x01q\0"[..], &b"0h\0h\0\x86q\0".repeat(100), b"."].concat();
    assert_eq!(parse(&doubled).unwrap().root().items().unwrap().len(), 2);
    // A list that contains itself.
    let own = parse(b"]q\0h\0a.").unwrap();
    assert_eq!(own.root().items().unwrap().next().unwrap().kind(), "a list");
    // More instructions than any file has.
    let long = b"N0".repeat(MAX_INSTRUCTIONS / 2 + 1);
    let wanted = "pickle must have at most 1048576 instructions";
    assert_eq!(error(&long), wanted);
    // One long string that is converted to bytes repeatedly.
    let mut decoded = b"\x80\x02c_codecs\nencode\nq\0X\0\0\x10\0".to_vec();
    decoded.extend(b"a".repeat(1 << 20));
    decoded.extend(b"U\x06latin1\x86q\x01(");
    decoded.extend(b"h\0h\x01R".repeat(50_000));
    decoded.extend(b"t.");
    assert!(error(&decoded).contains("decoded bytes"));
    // One long tuple of arguments that is used for repeated calls.
    let mut called = b"(".to_vec();
    called.extend(b"N".repeat(300_000));
    called.extend(b"tq\0cnumpy\ndtype\nh\0R.");
    assert!(error(&called).contains("too many arguments: 300000"));
}
