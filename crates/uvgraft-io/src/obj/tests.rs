use uvgraft::mesh::{Corner, Mesh, MeshPart};

use super::*;

/// A quad and a triangle; every `v` is exact in binary.
const SMALL: &str = "\
# made by hand
mtllib small.mtl
o plate
v -1 -1 0
v 1 -1 0.5
v 1 1 0
v -1 1 0
v 0 2 .25
vt 0 0
vt 1 0
vt 1 0.75
vt 0 0.75
vt 0.5 1
vn 0 0 1
usemtl skin
s 1
f 1/1/1 2/2/1 3/3/1 4/4/1
g roof
f 4/4/1 3/3/1 5/5/1
";

fn small() -> Mesh {
    parse(SMALL.as_bytes()).unwrap()
}

fn part(object: &str, group: &str, material: &str, polygons: std::ops::Range<u32>) -> MeshPart {
    let [object, group, material] = [object, group, material].map(str::to_owned);
    MeshPart { object, group, material, image: None, polygons }
}

/// The error of a file whose line 9 is `line`, after four vertices and four texture coordinates.
fn error_at_9(line: &str) -> String {
    let text = format!("{}{}{line}\n", "v 0 0 0\n".repeat(4), "vt 0 0\n".repeat(4));
    parse(text.as_bytes()).unwrap_err().to_string()
}

fn text_of(mesh: &Mesh) -> Vec<u8> {
    let mut text = Vec::new();
    write(mesh, &mut text).unwrap();
    text
}

#[test]
fn reads_polygons_names_and_flipped_coordinates() {
    let mesh = small();
    assert_eq!(mesh.positions()[1], [1.0, -1.0, 0.5]);
    assert_eq!(mesh.positions()[4], [0.0, 2.0, 0.25]);
    assert_eq!(mesh.uv(), [[0.0, 1.0], [1.0, 1.0], [1.0, 0.25], [0.0, 0.25], [0.5, 0.0]]);
    assert_eq!(mesh.faces(), [[0, 1, 2], [0, 2, 3], [3, 2, 4]]);
    assert_eq!(mesh.uv_faces(), mesh.faces());
    assert_eq!(mesh.polygon_count(), 2);
    assert_eq!(
        mesh.parts(),
        [part("plate", "", "skin", 0..1), part("plate", "roof", "skin", 1..2)]
    );
}

#[test]
fn one_mesh_however_it_is_spelled() {
    let no_normals = SMALL.replace("/1 ", " ").replace("/1\n", "\n");
    let spellings = [
        SMALL.replace('\n', "\r\n"),
        SMALL.replace('\n', "\r"),
        SMALL.replace('\n', "\n\n  \t\n"),
        SMALL.replace(' ', " \t  ").replace('\n', "  \n  "),
        SMALL.replace(' ', " \\\n ").replace("# \\\n made \\\n by \\\n hand", "#"),
        SMALL.replace("v 1 1 0", "# C:\\objects\\\nv 1 1 0"),
        format!("\u{feff}{SMALL}"),
        SMALL.trim_end().to_owned(),
        SMALL.replace("0.5", "+5e-1").replace("v -1 -1 0", "v -1. -.1E1 -0.e+3"),
        no_normals.clone(),
        no_normals.replace("4/4 3/3 5/5", "-2/-2 -3/-3 -1/-1 # roof"),
        no_normals.replace("f ", "fo ").replace("-1 1 0\n", "-1 1 0 1.0 red\n"),
        SMALL.replace("0 0.75\n", "0 0.75 rubbish\n").replace("s 1", "blob 1 2\ns off\nl 1 2"),
    ];
    for text in spellings {
        let mesh = parse(text.as_bytes()).unwrap_or_else(|error| panic!("{error} in\n{text}"));
        assert_eq!(mesh, small(), "{text}");
    }
}

#[test]
fn faces_may_come_before_their_vertices() {
    let (vertices, faces): (Vec<&str>, Vec<&str>) =
        SMALL.lines().partition(|line| line.starts_with('v'));
    let text = format!("{}\n{}", faces.join("\n"), vertices.join("\n"));
    assert_eq!(parse(text.as_bytes()).unwrap(), small());

    // Line 2 is within the two vertices that follow; line 3 is the first that is not.
    let text = "vt 0 0\nf 1/1 2/1 2/1\nf 1/1 2/1 3/1\nf 9/1 1/1 1/1\nv 0 0 0\nv 0 0 0\n";
    let error = parse(text.as_bytes()).unwrap_err();
    let wanted = ObjError::Index { line: 3, corner: 3, what: "vertex", found: 3, count: 2 };
    assert_eq!(error, wanted);
    assert_eq!(error.to_string(), "line 3: corner 3: vertex index must be at most 2, got 3");
}

#[test]
fn parts_merge_split_and_lose_their_names_again() {
    let head = "v 0 0 0\nvt 0 0\n";
    let face = "f 1/1 1/1 1/1\n";
    let parts = |body: &str| {
        let text = format!("{head}{}", body.replace('F', face));
        parse(text.as_bytes()).unwrap().parts().to_vec()
    };
    assert_eq!(parts("FF"), []);
    assert_eq!(parts("o\nF"), []);
    assert_eq!(parts("usemtl a\nF\nusemtl b\nusemtl a\nF"), [part("", "", "a", 0..2)]);
    assert_eq!(
        parts("F\ng left  arm # both\nF\ng\nF"),
        [part("", "", "", 0..1), part("", "left  arm # both", "", 1..2), part("", "", "", 2..3)]
    );
    let latin1 = [head.as_bytes(), b"# \xe4\no Kopf\xe4\n", face.as_bytes()].concat();
    assert_eq!(parse(&latin1).unwrap().parts(), [part("Kopfä", "", "", 0..1)]);
}

#[test]
fn errors_name_the_line_what_was_found_and_what_was_wanted() {
    for (line, wanted) in [
        ("f 1/1 2 3/3", "line 9: corner 2 must have a texture coordinate (`v/vt`)"),
        ("f 1/1 2/2 3//3", "line 9: corner 3 must have a texture coordinate (`v/vt`)"),
        ("f 1/1 2/ 3/3", "line 9: corner 2 must have a texture coordinate (`v/vt`)"),
        ("f 1/1 2/2", "line 9: face must have at least 3 corners, got 2"),
        ("f", "line 9: face must have at least 3 corners, got 0"),
        ("f 1/1 2/2 # 3/3", "line 9: face must have at least 3 corners, got 2"),
        ("f 1/1 0/2 3/3", "line 9: corner 2: vertex index must start at 1, got 0"),
        ("f 1/1 2/-0 3/3", "line 9: corner 2: texture coordinate index must start at 1, got 0"),
        ("f 1/1 2/2 5/3", "line 9: corner 3: vertex index must be at most 4, got 5"),
        ("f 1/1 2/5 5/3", "line 9: corner 2: texture coordinate index must be at most 4, got 5"),
        ("f -5/1 2/2 3/3", "line 9: corner 1: relative vertex index must be at least -4, got -5"),
        (
            "f 1/99999999999999999999 2/2 3/3",
            "line 9: corner 1: texture coordinate index must be at most 4, got 9223372036854775807",
        ),
        ("f 1/1 2/x 3/3", "line 9: corner 2 must be `v/vt` or `v/vt/vn`, got `2/x`"),
        ("f 1/1 2/2/n 3/3", "line 9: corner 2 must be `v/vt` or `v/vt/vn`, got `2/2/n`"),
        ("f 1/1 2/2/2/2 3/3", "line 9: corner 2 must be `v/vt` or `v/vt/vn`, got `2/2/2/2`"),
        ("f 1/1 /2 3/3", "line 9: corner 2 must be `v/vt` or `v/vt/vn`, got `/2`"),
        ("f 1.0/1 2/2 3/3", "line 9: corner 1 must be `v/vt` or `v/vt/vn`, got `1.0/1`"),
        ("f 1/- 2/2 3/3", "line 9: corner 1 must be `v/vt` or `v/vt/vn`, got `1/-`"),
        ("v 0 0,5 0", "line 9: vertex: must be a number, got `0,5`"),
        ("v 0 0 0x1p3", "line 9: vertex: must be a number, got `0x1p3`"),
        ("vt 0 ä", "line 9: texture coordinate: must be a number, got `\\xc3\\xa4`"),
        ("v 0 nan 0", "line 9: vertex: must be a finite 32-bit number, got `nan`"),
        ("v 0 0 -inf", "line 9: vertex: must be a finite 32-bit number, got `-inf`"),
        ("v 0 0 1e39", "line 9: vertex: must be a finite 32-bit number, got `1e39`"),
        ("vt 1e999 0", "line 9: texture coordinate: must be a finite 32-bit number, got `1e999`"),
        ("v 0 0", "line 9: vertex must have 3 numbers, got 2"),
        ("vt 0 # 0", "line 9: texture coordinate must have 2 numbers, got 1"),
        ("\x1a\0", "not an OBJ file: byte 0x1a in a keyword on line 9"),
        ("", "mesh must have faces, got 4 vertices and no `f` line"),
    ] {
        assert_eq!(error_at_9(line), wanted, "{line}");
    }
    let long = error_at_9(&format!("v {}", "9x".repeat(1000)));
    assert_eq!(long, format!("line 9: vertex: must be a number, got `{}…`", "9x".repeat(16)));
}

#[test]
fn polygons_without_coordinates_are_left_out_where_that_is_asked_for() {
    let text = SMALL.replace("f 4/4/1 3/3/1 5/5/1", "f 4 3 5\nf 4//1 3//1 5//1\no cap\nf 1/ 2/ 3/");
    let error = parse(text.as_bytes()).unwrap_err();
    let first = ObjError::NoTextureCoordinate { line: 19, corner: 1 };
    assert_eq!(error, first);
    let found = parse_textured(text.as_bytes()).unwrap();
    assert_eq!((found.mesh.positions(), found.mesh.uv()), (small().positions(), small().uv()));
    assert_eq!(found.mesh.faces(), [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(found.mesh.parts(), [part("plate", "", "skin", 0..1)]);
    let wanted = [part("plate", "roof", "skin", 0..2), part("cap", "roof", "skin", 2..3)];
    assert_eq!((found.without_uv.polygons, &found.without_uv.parts[..]), (3, &wanted[..]));
    // Nothing is left, or one corner is an oversight.
    let bare = text.replace("f 1/1/1 2/2/1 3/3/1 4/4/1", "f 1 2 3 4");
    assert_eq!(
        parse_textured(bare.as_bytes()).unwrap_err().to_string(),
        "line 17: corner 1 must have a texture coordinate (`v/vt`)"
    );
    let odd = text.replace("f 4 3 5", "f 4 3/3 5/5");
    assert_eq!(parse_textured(odd.as_bytes()).unwrap_err(), first);
    let far = text.replace("f 4 3 5", "f 4 3 6");
    let far = parse_textured(far.as_bytes()).unwrap_err().to_string();
    assert_eq!(far, "line 19: corner 3: vertex index must be at most 5, got 6");
    assert_eq!(parse_textured(SMALL.as_bytes()).unwrap().mesh, small());
}

#[test]
fn refuses_files_of_other_kinds() {
    assert_eq!(parse(b""), Err(ObjError::Empty));
    for text in ["\n", "# nothing", "\u{feff}", "ply\nformat ascii 1.0\n", "{\"asset\": {}}\n"] {
        assert_eq!(parse(text.as_bytes()), Err(ObjError::NotObj), "{text}");
    }
    assert_eq!(parse(b"glTF\x02\0\0\0"), Err(ObjError::Binary { line: 1, byte: 2 }));
    assert_eq!(
        parse(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"),
        Err(ObjError::Binary { line: 2, byte: 0x1a })
    );
    assert_eq!(parse(b"\xff\xfev\0 \x001\0"), Err(ObjError::Utf16));
    assert_eq!(parse(b"\xfe\xff\0v\0 \x001"), Err(ObjError::Utf16));
}

#[test]
fn names_that_multiply_are_refused() {
    let mut text = b"v 0 0 0\nvt 0 0\no ".to_vec();
    text.resize(text.len() + (1 << 20), b'x');
    for group in 0..70 {
        text.extend(format!("\ng {group}\nf 1/1 1/1 1/1").into_bytes());
    }
    let refused = parse(&text).unwrap_err();
    assert_eq!(refused, ObjError::Names { line: 3 + 2 * 64, max: 1 << 26 });
}

#[test]
fn writes_what_it_reads() {
    let mesh = small();
    assert_eq!(parse(&text_of(&mesh)).unwrap(), mesh);
    let text = String::from_utf8(text_of(&mesh)).unwrap();
    assert!(text.starts_with("v -1 -1 0\nv 1 -1 0.5\n"), "{text}");
    assert!(text.contains("\nvt 1 0.75\n"), "{text}");
    let wanted = "o plate\nusemtl skin\nf 1/1 2/2 3/3 4/4\ng roof\nf 4/4 3/3 5/5\n";
    assert!(text.ends_with(wanted), "{text}");
}

#[test]
fn random_meshes_survive_the_round_trip() {
    let mut random = fastrand::Rng::with_seed(7);
    for _ in 0..50 {
        let count = random.usize(1..40);
        let exponent = random.i32(-30..30);
        let mut number = || (random.f32() - 0.5) * 2_f32.powi(exponent);
        let positions = (0..count).map(|_| [number(), number(), number()]).collect();
        let uv = (0..count).map(|_| [random.f32(), random.f32()]).collect();
        let sizes: Vec<u32> = (0..random.usize(1..30)).map(|_| random.u32(3..9)).collect();
        let mut index = || random.u32(0..count as u32);
        let corners: Vec<Corner> =
            (0..sizes.iter().sum()).map(|_| Corner { vertex: index(), uv: index() }).collect();
        let mesh = Mesh::from_polygons(positions, uv, &corners, &sizes).unwrap();
        assert_eq!(parse(&text_of(&mesh)).unwrap(), mesh);
    }
}

#[test]
fn odd_names_stay_on_their_line() {
    let mesh =
        small().with_parts(vec![part("a\nf 1/1", "", "end\\", 0..1), part("", "  #  ", "", 1..2)]);
    let parts = parse(&text_of(&mesh)).unwrap().parts().to_vec();
    assert_eq!(parts, [part("a_f 1/1", "", "end_", 0..1), part("", "#", "", 1..2)]);
}

#[test]
fn no_bytes_make_it_panic() {
    const PIECES: [&[u8]; 22] = [
        b"v",
        b"vt",
        b"f",
        b"o",
        b"g",
        b"usemtl",
        b"#",
        b"/",
        b"//",
        b"-",
        b"\\",
        b"\\\n",
        b"\r",
        b"\n",
        b" ",
        b"0",
        b"1e9",
        b"nan",
        b"99999999999999999999",
        b"-9223372036854775808",
        b"\0",
        b"\xe4",
    ];
    let mut random = fastrand::Rng::with_seed(1);
    let mut accepted = 0;
    for _ in 0..20_000 {
        let mut text = SMALL.as_bytes().to_vec();
        for _ in 0..random.usize(1..4) {
            let at = random.usize(0..text.len());
            let end = random.usize(at..=text.len().min(at + 8));
            match random.u32(0..4) {
                0 => text[at] = random.u8(..),
                1 => drop(text.drain(at..end)),
                2 => text.truncate(at.max(1)),
                _ => drop(text.splice(at..end, random.choice(PIECES).unwrap().iter().copied())),
            }
            text.push(b'\n');
        }
        accepted += usize::from(parse(&text).is_ok());
    }
    assert!((1_000..19_000).contains(&accepted), "{accepted} accepted: not a test of both ways");
    for _ in 0..2_000 {
        let bytes: Vec<u8> = (0..random.usize(1..200)).map(|_| random.u8(..)).collect();
        let _ = parse(&bytes);
        let soup: Vec<u8> =
            (0..100).flat_map(|_| random.choice(PIECES).unwrap().to_vec()).collect();
        let _ = parse(&soup);
    }
}

#[test]
fn files_are_named_in_errors_and_replaced_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("small.obj");
    save(&small(), &path).unwrap();
    assert_eq!(read(&path).unwrap(), small());
    std::fs::write(&path, "v 0 0\n").unwrap();
    let error = read(&path).unwrap_err().to_string();
    let wanted = "small.obj: line 1: vertex must have 3 numbers, got 2";
    assert!(error.ends_with(wanted), "{error}");
    let missing = folder.path().join("missing.obj");
    assert!(read(&missing).unwrap_err().to_string().contains("missing.obj: "));

    let file = std::fs::File::options().write(true).open(&path).unwrap();
    file.set_len(MAX_FILE_BYTES + 1).unwrap();
    let error = read(&path).unwrap_err().to_string();
    assert!(
        error.contains("got 2147483649 or more") && error.contains("at most 2147483648 bytes"),
        "{error}"
    );
}
