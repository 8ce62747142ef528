//! Groups as written by Python, and malicious ones.

use super::*;

/// `{"face": numpy.array([9, 2, 5]), "scalp": [1, numpy.int32(4)], "rim": numpy.array([[300], [7]],
/// ">u2")}`, as written by Python 3 with NumPy 2, in protocols 0, 2, 4 and 5.
const WRITTEN: [&[u8]; 4] = [
    b"(dp0\nVface\np1\ncnumpy._core.multiarray\n_reconstruct\np2\n(cnumpy\nndarray\np3\n(I0\ntp4\n\
      c_codecs\nencode\np5\n(Vb\np6\nVlatin1\np7\ntp8\nRp9\ntp10\nRp11\n(I1\n(I3\ntp12\ncnumpy\ndt\
      ype\np13\n(Vi8\np14\nI00\nI01\ntp15\nRp16\n(I3\nV<\np17\nNNNI-1\nI-1\nI0\ntp18\nbI00\ng5\n(V\
      \t\\u0000\\u0000\\u0000\\u0000\\u0000\\u0000\\u0000\x02\\u0000\\u0000\\u0000\\u0000\\u0000\\\
      u0000\\u0000\x05\\u0000\\u0000\\u0000\\u0000\\u0000\\u0000\\u0000\np19\ng7\ntp20\nRp21\ntp22\
      \nbsVscalp\np23\n(lp24\nI1\nacnumpy._core.multiarray\nscalar\np25\n(g13\n(Vi4\np26\nI00\nI01\
      \ntp27\nRp28\n(I3\ng17\nNNNI-1\nI-1\nI0\ntp29\nbg5\n(V\x04\\u0000\\u0000\\u0000\np30\ng7\ntp\
      31\nRp32\ntp33\nRp34\nasVrim\np35\ng2\n(g3\n(I0\ntp36\ng9\ntp37\nRp38\n(I1\n(I2\nI1\ntp39\ng\
      13\n(Vu2\np40\nI00\nI01\ntp41\nRp42\n(I3\nV>\np43\nNNNI-1\nI-1\nI0\ntp44\nbI00\ng5\n(V\x01,\
      \\u0000\x07\np45\ng7\ntp46\nRp47\ntp48\nbs.",
    b"\x80\x02}q\0(X\x04\0\0\0faceq\x01cnumpy._core.multiarray\n_reconstruct\nq\x02cnumpy\nndarray\
      \nq\x03K\0\x85q\x04c_codecs\nencode\nq\x05X\x01\0\0\0bq\x06X\x06\0\0\0latin1q\x07\x86q\x08Rq\
      \t\x87q\nRq\x0b(K\x01K\x03\x85q\x0ccnumpy\ndtype\nq\rX\x02\0\0\0i8q\x0e\x89\x88\x87q\x0fRq\
      \x10(K\x03X\x01\0\0\0<q\x11NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\0tq\x12b\x89h\x05X\x18\0\0\
      \0\t\0\0\0\0\0\0\0\x02\0\0\0\0\0\0\0\x05\0\0\0\0\0\0\0q\x13h\x07\x86q\x14Rq\x15tq\x16bX\x05\
      \0\0\0scalpq\x17]q\x18(K\x01cnumpy._core.multiarray\nscalar\nq\x19h\rX\x02\0\0\0i4q\x1a\x89\
      \x88\x87q\x1bRq\x1c(K\x03h\x11NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\0tq\x1dbh\x05X\x04\0\0\
      \0\x04\0\0\0q\x1eh\x07\x86q\x1fRq \x86q!Rq\"eX\x03\0\0\0rimq#h\x02h\x03K\0\x85q$h\t\x87q%Rq&\
      (K\x01K\x02K\x01\x86q'h\rX\x02\0\0\0u2q(\x89\x88\x87q)Rq*(K\x03X\x01\0\0\0>q+NNNJ\xff\xff\
      \xff\xffJ\xff\xff\xff\xffK\0tq,b\x89h\x05X\x04\0\0\0\x01,\0\x07q-h\x07\x86q.Rq/tq0bu.",
    b"\x80\x04\x95D\x01\0\0\0\0\0\0}\x94(\x8c\x04face\x94\x8c\x16numpy._core.multiarray\x94\x8c\
      \x0c_reconstruct\x94\x93\x94\x8c\x05numpy\x94\x8c\x07ndarray\x94\x93\x94K\0\x85\x94C\x01b\
      \x94\x87\x94R\x94(K\x01K\x03\x85\x94h\x05\x8c\x05dtype\x94\x93\x94\x8c\x02i8\x94\x89\x88\x87\
      \x94R\x94(K\x03\x8c\x01<\x94NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\0t\x94b\x89C\x18\t\0\0\0\
      \0\0\0\0\x02\0\0\0\0\0\0\0\x05\0\0\0\0\0\0\0\x94t\x94b\x8c\x05scalp\x94]\x94(K\x01h\x02\x8c\
      \x06scalar\x94\x93\x94h\x0e\x8c\x02i4\x94\x89\x88\x87\x94R\x94(K\x03h\x12NNNJ\xff\xff\xff\
      \xffJ\xff\xff\xff\xffK\0t\x94bC\x04\x04\0\0\0\x94\x86\x94R\x94e\x8c\x03rim\x94h\x04h\x07K\0\
      \x85\x94h\t\x87\x94R\x94(K\x01K\x02K\x01\x86\x94h\x0e\x8c\x02u2\x94\x89\x88\x87\x94R\x94(K\
      \x03\x8c\x01>\x94NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\0t\x94b\x89C\x04\x01,\0\x07\x94t\x94\
      bu.",
    b"\x80\x05\x95A\x01\0\0\0\0\0\0}\x94(\x8c\x04face\x94\x8c\x13numpy._core.numeric\x94\x8c\x0b_f\
      rombuffer\x94\x93\x94(\x96\x18\0\0\0\0\0\0\0\t\0\0\0\0\0\0\0\x02\0\0\0\0\0\0\0\x05\0\0\0\0\0\
      \0\0\x94\x8c\x05numpy\x94\x8c\x05dtype\x94\x93\x94\x8c\x02i8\x94\x89\x88\x87\x94R\x94(K\x03\
      \x8c\x01<\x94NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\0t\x94bK\x03\x85\x94\x8c\x01C\x94t\x94R\
      \x94\x8c\x05scalp\x94]\x94(K\x01\x8c\x16numpy._core.multiarray\x94\x8c\x06scalar\x94\x93\x94\
      h\x08\x8c\x02i4\x94\x89\x88\x87\x94R\x94(K\x03h\x0cNNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\0t\
      \x94bC\x04\x04\0\0\0\x94\x86\x94R\x94e\x8c\x03rim\x94h\x04(\x96\x04\0\0\0\0\0\0\0\x01,\0\x07\
      \x94h\x08\x8c\x02u2\x94\x89\x88\x87\x94R\x94(K\x03\x8c\x01>\x94NNNJ\xff\xff\xff\xffJ\xff\xff\
      \xff\xffK\0t\x94bK\x02K\x01\x86\x94h\x0ft\x94R\x94u.",
];

/// `{"face": numpy.array([9, 2, 5]), "left_ear": numpy.array([7, 300])}`, as written by Python 2:
/// strings are bytes, and the bytes of arrays are strings.
const BY_PYTHON_2: &[u8] =
    b"\x80\x02}q\x01(U\x04faceq\x02cnumpy.core.multiarray\n_reconstruct\nq\x03cnumpy\nndarray\nq\
      \x04K\0\x85U\x01b\x87Rq\x05(K\x01K\x03\x85cnumpy\ndtype\nq\x06U\x02i8K\0K\x01\x87Rq\x07(K\
      \x03U\x01<NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\0tb\x89U\x18\t\0\0\0\0\0\0\0\x02\0\0\0\0\0\
      \0\0\x05\0\0\0\0\0\0\0tbU\x08left_earq\x08h\x03h\x04K\0\x85U\x01b\x87Rq\t(K\x01\x8a\x01\x02\
      \x85h\x07\x89U\x10\x07\0\0\0\0\0\0\0,\x01\0\0\0\0\0\0tbu.";

fn error(bytes: &[u8]) -> String {
    parse(bytes).unwrap_err().to_string()
}

/// A pickle of a dict that has the result of some instructions under the name `face`.
fn face(ids: &[u8]) -> Vec<u8> {
    [&b"}X\x04\0\0\0face"[..], ids, b"s."].concat()
}

#[test]
fn pickles_of_every_kind() {
    for bytes in WRITTEN {
        let groups = parse(bytes).unwrap();
        assert_eq!(groups.names().collect::<Vec<_>>(), ["face", "rim", "scalp"]);
        let found = ["face", "rim", "scalp"].map(|name| groups.vertices(name, 301).unwrap());
        assert_eq!(found, [vec![2, 5, 9], vec![7, 300], vec![1, 4]]);
    }
    let groups = parse(BY_PYTHON_2).unwrap();
    assert_eq!(groups.names().collect::<Vec<_>>(), ["face", "left_ear"]);
    assert_eq!(groups.vertices("face", 10), Ok(vec![2, 5, 9]));
    assert_eq!(groups.vertices("left_ear", 301), Ok(vec![7, 300]));
    // Of a duplicate name, the last one is used.
    let twice = parse(b"}(X\x01\0\0\0a]K\x05aX\x01\0\0\0a]K\x06au.").unwrap();
    assert_eq!(twice.vertices("a", 9), Ok(vec![6]));
}

#[test]
fn json_of_the_same_shape() {
    let groups = parse(b"\xef\xbb\xbf {\"head\": [3, 1, 3],\n \"neck\": []}\n").unwrap();
    assert_eq!(groups.names().collect::<Vec<_>>(), ["head", "neck"]);
    assert_eq!(groups.vertices("head", 4), Ok(vec![1, 3]));
    for (text, wanted) in [
        (
            "{\"head\": [1.0]}",
            "invalid JSON: invalid type: floating point `1.0`, expected i64 at line 1",
        ),
        ("{\"head\": 7}", "invalid JSON: invalid type: integer `7`, expected a sequence at line 1"),
        (
            "[1, 2]",
            "invalid JSON: invalid type: sequence, expected an object of lists of integers at line",
        ),
        ("{\"head\": [1, 2", "invalid JSON: EOF while parsing a list at line 1 column 14"),
        ("{\"head\": [1]} x", "invalid JSON: trailing characters at line 1 column 15"),
        ("{}", "must have at least one vertex group"),
    ] {
        let found = error(text.as_bytes());
        assert!(found.starts_with(wanted), "found:  {found}\nwanted: {wanted}");
    }
    let deep = format!("{{\"a\": {}", "[".repeat(100_000));
    assert!(error(deep.as_bytes()).starts_with("invalid JSON: "));
}

#[test]
fn errors_say_what_there_is() {
    let groups = parse(BY_PYTHON_2).unwrap();
    let unknown = groups.vertices("Face", 999).unwrap_err().to_string();
    assert_eq!(unknown, "no group `Face`; the file has `face`, `left_ear`");
    let beyond = groups.vertices("left_ear", 300).unwrap_err().to_string();
    let wanted = "group `left_ear`: entry 2: must be a vertex of the mesh, from 0 to 299, got 300";
    assert_eq!(beyond, wanted);
    let negative = parse(b"{\"a\": [2, -2]}").unwrap().vertices("a", 5).unwrap_err().to_string();
    assert!(negative.starts_with("group `a`: entry 2: must be"), "{negative}");
    let empty = parse(b"{\"a\": []}").unwrap().vertices("a", 5).unwrap_err().to_string();
    assert_eq!(empty, "group `a`: must have at least one vertex");
    let many: Vec<String> = (0..70).map(|k| format!("\"group {k:02}\": [0]")).collect();
    let many = parse(format!("{{{}}}", many.join(",")).as_bytes()).unwrap();
    let unknown = many.vertices("none", 5).unwrap_err().to_string();
    assert!(unknown.ends_with("`group 08`, `group 09` and 60 more"), "{unknown}");
}

#[test]
fn refuses_what_are_no_groups() {
    for (bytes, wanted) in [
        (
            &b""[..],
            "must be a pickle or a JSON object of vertex indices by name, got an empty file",
        ),
        (
            b"\x93NUMPY\x01\0",
            "must be a pickle or a JSON object of vertex indices by name, got an NPY array",
        ),
        (
            b"PK\x03\x04",
            "must be a pickle or a JSON object of vertex indices by name, got an archive such as .npz",
        ),
        (b"]K\x01a.", "the pickle must hold a dict of vertex indices by name, got a list"),
        (b"}.", "must have at least one vertex group"),
        (b"}K\x01]s.", "group 1: name must be a string"),
        (b"hello", "byte 0 of the pickle"),
    ] {
        let found = error(bytes);
        assert!(found.starts_with(wanted), "found:  {found}\nwanted: {wanted}");
    }
    let array = |dtype: &str, shape: &[u8], data: &[u8]| {
        let mut bytes = b"cnumpy.core.numeric\n_frombuffer\n(C".to_vec();
        bytes.push(data.len() as u8);
        bytes.extend(data);
        bytes.extend(b"cnumpy\ndtype\nU");
        bytes.push(dtype.len() as u8);
        bytes.extend(dtype.as_bytes());
        bytes.extend(b"\x89\x88\x87R");
        bytes.extend(shape);
        bytes.extend(b"U\x01CtR");
        bytes
    };
    for (ids, wanted) in [
        (b"K\x07".to_vec(), "an int"),
        (b"]G\x3f\xf0\0\0\0\0\0\0a".to_vec(), "a float in a list"),
        (b"]\x88a".to_vec(), "a bool in a list"),
        (b"]]K\x01aa".to_vec(), "a list in a list"),
        (array("f4", b"K\x02\x85", &[0; 8]), "an array of floating-point numbers"),
        (array("b1", b"K\x02\x85", &[0; 2]), "an array of bools"),
        (array("u8", b"K\x01\x85", &[255; 8]), "an array of integers beyond 63 bits"),
        (array("u1", b"K\x02K\x02\x86", &[0; 4]), "an array of shape [2, 2]"),
    ] {
        let wanted = format!("group `face`: must be a list of integers, got {wanted}");
        assert_eq!(error(&face(&ids)), wanted);
    }
    let long = format!("{{\"{}\": [0]}}", "x".repeat(257));
    assert!(error(long.as_bytes()).contains("group 1: name must be a string"));
}

#[test]
fn hostile_files_are_refused() {
    let evil = face(b"cos\nsystem\n(S'echo'\ntR");
    assert!(
        error(&evil).starts_with(
            "refused: the pickle imports os.system, but only plain data may be loaded"
        )
    );
    // One list of 70,000 indices under 300 names.
    let mut bytes = b"](".to_vec();
    bytes.extend(b"K\x01".repeat(70_000));
    bytes.extend(b"eq\x000}(");
    for name in 0..300_u32 {
        bytes.extend(b"X\x04\0\0\0");
        bytes.extend(format!("{name:04}").as_bytes());
        bytes.extend(b"h\0");
    }
    bytes.extend(b"u.");
    assert_eq!(error(&bytes), "must have at most 16777216 vertex indices");
    let mut many = b"}(".to_vec();
    many.extend(b"X\x01\0\0\0a]".repeat(MAX_GROUPS + 1));
    many.extend(b"u.");
    assert_eq!(error(&many), "must have at most 4096 groups");
    let many: Vec<String> = (0..=MAX_GROUPS).map(|k| format!("\"{k}\": []")).collect();
    let found = error(format!("{{{}}}", many.join(",")).as_bytes());
    assert!(found.contains("must have at most 4096 groups"), "{found}");
}

#[test]
fn every_cut_and_every_changed_byte_is_survived() {
    for bytes in WRITTEN.into_iter().chain([BY_PYTHON_2, b"{\"a\": [1, 2]}"]) {
        for end in 0..bytes.len() {
            assert!(parse(&bytes[..end]).is_err(), "cut at {end}");
        }
        for place in 0..bytes.len() {
            for value in 0..=255 {
                let mut changed = bytes.to_vec();
                changed[place] = value;
                // Some changes result in groups of something else.
                if let Ok(groups) = parse(&changed) {
                    let _ = groups.vertices("face", 400);
                }
            }
        }
    }
}

#[test]
fn files_are_read_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("masks.pkl");
    std::fs::write(&path, BY_PYTHON_2).unwrap();
    let groups = read(&path).unwrap();
    assert_eq!((groups.names().len(), groups.vertices("face", 10)), (2, Ok(vec![2, 5, 9])));
    std::fs::write(&path, &BY_PYTHON_2[..9]).unwrap();
    let error = read(&path).unwrap_err().to_string();
    assert!(error.contains("masks.pkl: "), "{error}");
}
