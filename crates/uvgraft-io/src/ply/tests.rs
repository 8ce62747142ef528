use uvgraft::Mesh;

use super::*;

/// A quad and a triangle over five vertices, of which the last is not used by the quad.
const HEADER: &str = "comment made by hand
element vertex 5
property float x
property double y
property float z
property uchar red
property float s
property float t
element edge 1
property int vertex1
property list uchar short more
element face 2
property uchar flag
property list uchar int vertex_indices
end_header
";
const ROWS: &str = "0 0 0 255 0 0
1 0 0 255 1 0
1 1 0 255 1 0.75
0 1 0 255 0 1
0 2 0.5 255 0.5 0.25
7 2 -1 1
1 4 0 1 2 3
0 3 2 4 3
";

fn ascii() -> String {
    format!("ply\nformat ascii 1.0\n{HEADER}{ROWS}")
}

/// The same in binary.
fn binary(big: bool) -> Vec<u8> {
    let name = if big { "big" } else { "little" };
    let mut bytes = format!("ply\nformat binary_{name}_endian 1.0\n{HEADER}").into_bytes();
    let mut put = |value: f64, kind: char| {
        let mut word = match kind {
            'b' => vec![value as u8],
            'h' => (value as i16).to_le_bytes().to_vec(),
            'i' => (value as i32).to_le_bytes().to_vec(),
            'f' => (value as f32).to_le_bytes().to_vec(),
            _ => value.to_le_bytes().to_vec(),
        };
        if big {
            word.reverse();
        }
        bytes.extend(word);
    };
    let kinds = ["fdfbff"; 5].into_iter().chain(["ibhh", "bbiiii", "bbiii"]);
    for (line, kinds) in ROWS.lines().zip(kinds) {
        for (word, kind) in line.split(' ').zip(kinds.chars()) {
            put(word.parse().unwrap(), kind);
        }
    }
    bytes
}

fn check(mesh: &Mesh) {
    assert_eq!(mesh.positions().len(), 5);
    assert_eq!(mesh.positions()[4], [0.0, 2.0, 0.5]);
    // Flipped once.
    assert_eq!(mesh.uv(), [[0.0, 1.0], [1.0, 1.0], [1.0, 0.25], [0.0, 0.0], [0.5, 0.75]]);
    let corners = |polygon| -> Vec<[u32; 2]> {
        mesh.polygon_corners(polygon).iter().map(|corner| [corner.vertex, corner.uv]).collect()
    };
    assert_eq!(mesh.polygon_count(), 2);
    assert_eq!(corners(0), [[0, 0], [1, 1], [2, 2], [3, 3]]);
    assert_eq!(corners(1), [[2, 2], [4, 4], [3, 3]]);
    assert!(mesh.parts().is_empty());
}

#[test]
fn every_format_gives_the_same_mesh() {
    check(&parse(ascii().as_bytes()).unwrap().mesh);
    check(&parse(&binary(false)).unwrap().mesh);
    check(&parse(&binary(true)).unwrap().mesh);
    check(&parse(ascii().replace('\n', "\r\n").as_bytes()).unwrap().mesh);
    check(&parse(ascii().replace('\n', "\r").as_bytes()).unwrap().mesh);
    for names in [["u", "v"], ["texture_u", "texture_v"]] {
        let renamed = ascii()
            .replace("float s\n", &format!("float {}\n", names[0]))
            .replace("float t\n", &format!("float {}\n", names[1]))
            .replace("vertex_indices", "vertex_index");
        check(&parse(renamed.as_bytes()).unwrap().mesh);
    }
}

#[test]
fn the_first_value_of_a_binary_file_may_look_like_a_line_end() {
    let header = "ply\rformat binary_little_endian 1.0\relement vertex 3\rproperty uchar x\r\
                  property uchar y\rproperty uchar z\rproperty uchar u\rproperty uchar v\r\
                  element face 1\rproperty list uchar uchar vertex_index\rend_header\r";
    let rows = [10, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 3, 0, 1, 2];
    let mesh = parse(&[header.as_bytes(), &rows].concat()).unwrap().mesh;
    assert_eq!(mesh.positions()[0], [10.0, 0.0, 0.0]);
}

/// As MeshLab writes it: texture coordinates at the corners, and two textures.
const CORNERS: &str = "ply
format ascii 1.0
comment VCGLIB generated
comment TextureFile skin of a face.png
comment TextureFile cloth.png
element vertex 4
property float x
property float y
property float z
element face 3
property list uchar int vertex_indices
property list uchar float texcoord
property int texnumber
end_header
0 0 0
1 0 0
1 1 0
0 1 0
3 0 1 2 6 0 0 1 0 1 1 0
3 0 2 3 6 0 0 1 1 0 1 0
3 0 1 2 6 0.5 0 1 0 1 1 1
";

#[test]
fn corners_may_have_their_own_texture_coordinates() {
    let mesh = parse(CORNERS.as_bytes()).unwrap().mesh;
    assert_eq!(mesh.faces(), [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
    // The first two faces are connected: they share the coordinates of their edge.
    assert_eq!(mesh.uv_faces(), [[0, 1, 2], [0, 2, 3], [4, 1, 2]]);
    assert_eq!(mesh.uv(), [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0], [0.5, 1.0]]);
    let parts: Vec<_> =
        mesh.parts().iter().map(|part| (&*part.material, part.polygons.clone())).collect();
    assert_eq!(parts, [("skin of a face.png", 0..2), ("cloth.png", 2..3)]);
    let unnamed = CORNERS.replace("comment TextureFile", "comment");
    assert_eq!(parse(unnamed.as_bytes()).unwrap().mesh.parts()[1].material, "texture 1");
}

#[test]
fn empty_lists_leave_it_to_the_vertices() {
    let both =
        ascii().replace("vertex_indices", "vertex_indices\nproperty list uchar float texcoord");
    let both = both.replace("1 4 0 1 2 3\n", "1 4 0 1 2 3 0\n").replace("3 2 4 3\n", "3 2 4 3 0\n");
    check(&parse(both.as_bytes()).unwrap().mesh);
}

#[test]
fn faces_without_coordinates_among_others_are_left_out() {
    for (row, bare, textured) in [
        ("3 0 2 3 6 0 0 1 1 0 1 0", "3 0 2 3 0 0", [[0, 1, 2], [0, 1, 2]]),
        ("3 0 1 2 6 0.5 0 1 0 1 1 1", "3 0 1 2 0 1", [[0, 1, 2], [0, 2, 3]]),
    ] {
        assert!(CORNERS.contains(row), "{row}");
        let found = parse(CORNERS.replace(row, bare).as_bytes()).unwrap();
        assert_eq!((found.mesh.faces(), found.without_uv.polygons), (&textured[..], 1), "{row}");
    }
    // The face of the second texture.
    let text = CORNERS.replace("3 0 1 2 6 0.5 0 1 0 1 1 1", "3 0 1 2 0 1");
    let found = parse(text.as_bytes()).unwrap();
    assert_eq!((found.without_uv.polygons, &*found.without_uv.listed(&[])), (1, "\"cloth.png\""));
    assert_eq!(found.mesh.parts()[0].material, "skin of a face.png");
    let short = CORNERS.replace("3 0 2 3 6 0 0 1 1 0 1 0", "3 0 2 3 4 0 0 1 1 0");
    let error = parse(short.as_bytes()).unwrap_err().to_string();
    let wanted = "row 1 of element `face`: `texcoord` must have 6 numbers, two for each corner, \
                  got 4";
    assert_eq!(error, wanted);
}

#[test]
fn invalid_files_are_refused_with_a_reason() {
    let from = |old: &str, new: &str| {
        let text = ascii();
        assert!(text.contains(old), "{old}");
        text.replacen(old, new, 1)
    };
    let cases = [
        (String::new(), "not a PLY file: must start with \"ply\", the file is empty"),
        ("plywood".to_owned(), "not a PLY file"),
        (from("format ascii", "format utf8"), "line 2: format must be ascii, binary"),
        (from("format ascii 1.0\n", ""), "header without `format`"),
        (from("end_header\n", ""), "line 17: not a line of a PLY header: `0 0 0 255 0 0`"),
        (from("vertex 5", "vertex many"), "must be a whole number, got `many`"),
        (from("vertex 5", "vertex -1"), "must be a whole number, got `-1`"),
        (from("vertex 5", "vertex 6"), "polygon 0 must have at least 3 corners, got 0"),
        (from("vertex 5", "vertex 18446744073709551615"), "truncated: element `vertex` of 184"),
        (from("vertex 5", "vertex 99999999"), "needs at least 1199999987 bytes"),
        (from("face 2", "face 3"), "truncated in row 2 of element `face`"),
        (from("face 2", "face 1"), "line 25: more values than the header declares"),
        (from("face 2", "face 0"), "line 24: more values"),
        (from("element face", "element wall"), "must have an element `face`"),
        (from("element edge", "element vertex"), "duplicate element `vertex`"),
        (from("double y", "double w"), "properties `x`, `y` and `z`; the file has `x`, `w`"),
        (from("double y", "real y"), "got `real`"),
        (from("list uchar int", "list float int"), "must be an integer type"),
        (from("uchar int vertex", "uchar float vertex"), "list of integers `vertex_indices`"),
        (from("float t\n", "float tt\n"), "no UV coordinates: vertices must have"),
        (from("3 2 4 3", "3 2 5 3"), "polygon 1 uses vertex 5, but the mesh has only 5"),
        (from("3 2 4 3", "3 2 -4 3"), "vertex index must be at least 0, got -4"),
        (from("3 2 4 3", "2 2 4"), "polygon 1 must have at least 3 corners, got 2"),
        (from("3 2 4 3", "-3 2 4 3"), "`vertex_indices` must have 0 or more items, got -3"),
        (from("3 2 4 3", "3 2 4.5 3"), "must be an integer, got `4.5` on line 25"),
        (from("1 0.75", "1 zero"), "row 2 of element `vertex`: must be a number, got `zero` on"),
        (from("1 0.75", "1 nan"), "UV coordinate 2 must be finite"),
        (from("1 0 0 255", "1e39 0 0 255"), "vertex 1 must be finite"),
    ];
    let mut other = Vec::new();
    for (text, wanted) in cases {
        let error = parse(text.as_bytes()).expect_err(wanted).to_string();
        if !error.contains(wanted) {
            other.push(format!("wanted {wanted:?}, got {error:?}"));
        }
    }
    assert!(other.is_empty(), "{other:#?}");
    let comments = format!("ply\nformat ascii 1.0\n{}", "comment\n".repeat(1 << 18));
    assert!(matches!(parse(comments.as_bytes()), Err(PlyError::Endless { .. })));
    // A list that claims more items than there are bytes.
    let mut long = binary(false);
    let at = long.len() - 13;
    long[at] = 255;
    let error = parse(&long).unwrap_err().to_string();
    assert_eq!(error, "truncated in row 1 of element `face`");
    for length in 0..binary(true).len() {
        assert!(parse(&binary(true)[..length]).is_err(), "{length}");
    }
}

#[test]
fn no_bytes_make_it_panic() {
    const PIECES: [&[u8]; 12] = [
        b"\n",
        b" ",
        b"-",
        b"9",
        b"\r",
        b"list",
        b"\xff\xff\xff\xff",
        b"element face 9\n",
        b"property list int int vertex_index\n",
        b"element x 99999999999999999\n",
        b"nan",
        b"end_header\n",
    ];
    let files = [ascii().into_bytes(), binary(false), binary(true), CORNERS.into()];
    let mut random = fastrand::Rng::with_seed(18);
    let mut accepted = [0; 4];
    for round in 0..40_000 {
        let mut bytes = files[round % 4].clone();
        for _ in 0..random.usize(1..3) {
            let at = random.usize(0..bytes.len());
            let end = random.usize(at..=bytes.len().min(at + 4));
            match random.u32(0..4) {
                0 => bytes[at] = random.u8(..),
                1 => drop(bytes.drain(at..end)),
                2 if random.bool() => bytes.truncate(at.max(1)),
                _ => drop(bytes.splice(at..end, random.choice(PIECES).unwrap().to_vec())),
            }
            if bytes.is_empty() {
                break;
            }
        }
        accepted[round % 4] += usize::from(parse(&bytes).is_ok());
    }
    for accepted in accepted {
        assert!((100..9_000).contains(&accepted), "{accepted} accepted: not a test of both ways");
    }
}

#[test]
fn files_are_named_in_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.ply");
    std::fs::write(&path, ascii()).unwrap();
    check(&read(&path).unwrap().mesh);
    std::fs::write(&path, "ply\nformat ascii 2\nelement\n").unwrap();
    let error = read(&path).unwrap_err().to_string();
    assert!(error.contains("face.ply: line 3: not a line of a PLY header: `element`"), "{error}");
}
