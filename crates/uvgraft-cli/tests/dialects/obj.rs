//! OBJ of modellers, scanners, scripts and spreadsheets.

use super::meshes::{COMMAND, Sheet, difference};
use super::{Case, Refused, Same, Warned, case, check};
use crate::bench::Bench;

/// How a file spells its statements.
struct Writer {
    vertex: fn([f32; 3]) -> String,
    coordinate: fn([f32; 2]) -> String,
    corner: fn(u32, u32) -> String,
    face: &'static str,
}

impl Writer {
    const PLAIN: Self = Self {
        vertex: |[x, y, z]| format!("v {x} {y} {z}"),
        coordinate: |[u, v]| format!("vt {u} {v}"),
        corner: |v, t| format!("{}/{}", v + 1, t + 1),
        face: "f",
    };

    fn lines(&self) -> [Vec<String>; 3] {
        let sheet = Sheet::new();
        let face = |corners: &[(u32, u32); 4]| {
            let corners = corners.map(|(vertex, uv)| (self.corner)(vertex, uv));
            format!("{} {}", self.face, corners.join(" "))
        };
        [
            sheet.positions.into_iter().map(self.vertex).collect(),
            sheet.uv.into_iter().map(self.coordinate).collect(),
            sheet.quads.iter().map(face).collect(),
        ]
    }

    fn text(&self) -> String {
        self.lines().concat().join("\n") + "\n"
    }
}

fn plain() -> String {
    Writer::PLAIN.text()
}

/// The sheet with a vertex for each coordinate, in triangles.
fn split() -> String {
    let (positions, uv, triangles) = Sheet::new().split();
    let mut text = String::from(
        "# https://github.com/mikedh/trimesh\nmtllib material.mtl\nusemtl material_0\n",
    );
    positions.iter().for_each(|[x, y, z]| text += &format!("v {x:.8} {y:.8} {z:.8}\n"));
    uv.iter().for_each(|[u, v]| text += &format!("vt {u:.8} {v:.8}\n"));
    for triangle in triangles {
        let corners = triangle.map(|k| format!("{0}/{0}", k + 1));
        text += &format!("f {}\n", corners.join(" "));
    }
    text
}

/// Text in 16-bit units, of either byte order, with its mark.
fn utf16(text: &str, bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
    std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(bytes).collect()
}

/// Cases that differ from the plain file by how text is written.
fn texts() -> Vec<Case> {
    let obj = |name, content: Vec<u8>, expected| case(name, "mesh.obj", content, expected);
    let text = |name, content: String| obj(name, content.into(), Same);
    vec![
        text("plain", plain()),
        text("CR LF", plain().replace('\n', "\r\n")),
        text("CR", plain().replace('\n', "\r")),
        text("byte order mark", format!("\u{feff}{}", plain())),
        text("tabs and blanks", plain().replace(' ', " \t ").replace('\n', " \t\n\n")),
        text("no end of line", plain().trim_end().to_owned()),
        text("continued lines", plain().replace(' ', " \\\n")),
        text("comments behind", plain().replace('\n', " # a comment\n")),
        text("long comments", plain().replace("\nf", "\n# C:\\meshes\\\nf")),
        obj("Latin-1", [b"# cr\xe9\xe9\no T\xeate\n", plain().as_bytes()].concat(), Same),
        obj("UTF-16, little-endian", utf16(&plain(), u16::to_le_bytes), Refused("got UTF-16")),
        obj("UTF-16, big-endian", utf16(&plain(), u16::to_be_bytes), Refused("got UTF-16")),
        obj(
            "decimal commas",
            plain().replace('.', ",").into(),
            Refused("must be a number, got `-0,75`"),
        ),
        obj(
            "decimal commas in vt only",
            Writer {
                coordinate: |[u, v]| format!("vt {u} {v}").replace('.', ","),
                ..Writer::PLAIN
            }
            .text()
            .into(),
            Refused("texture coordinate: must be a number, got `0,125`"),
        ),
        obj("cut in a face", plain().trim_end()[..plain().len() - 3].into(), Refused("must")),
        obj("empty", Vec::new(), Refused("the file is empty")),
        obj("a web page", b"<!DOCTYPE html>\n<html></html>\n".to_vec(), Refused("not an OBJ file")),
        obj("upper case", plain().to_uppercase().into(), Refused("not an OBJ file")),
        obj("compressed", b"\x1f\x8b\x08\0\0\0\0\0\0\x03v 0".to_vec(), Refused("not an OBJ file")),
    ]
}

/// Cases that differ by how statements are written.
fn statements() -> Vec<Case> {
    let with = |name, writer: &Writer| case(name, "mesh.obj", writer.text(), Same);
    let plain_writer = Writer::PLAIN;
    let numbered = |name, corner, expected| {
        case(name, "mesh.obj", Writer { corner, ..Writer::PLAIN }.text(), expected)
    };
    let [vertices, coordinates, faces] = plain_writer.lines();
    let named = format!(
        "mtllib a.mtl\no sheet\n{}\ng left\nusemtl skin\ns 1\n{}\ng right up\nusemtl cloth\ns off\n{}\n",
        [&vertices[..], &coordinates].concat().join("\n"),
        faces[..3].join("\n"),
        faces[3..].join("\n"),
    );
    let backwards = [&faces[..], &coordinates, &vertices].concat().join("\n");
    let alternating: Vec<String> =
        vertices.iter().zip(&coordinates).map(|(a, b)| format!("{a}\n{b}")).collect();
    let alternating =
        [&alternating[..], &coordinates[vertices.len()..], &faces].concat().join("\n");
    vec![
        with(
            "vertex colours",
            &Writer { vertex: |[x, y, z]| format!("v {x} {y} {z} 0.5 0.25 1.0"), ..Writer::PLAIN },
        ),
        with(
            "vertex colours in bytes",
            &Writer { vertex: |[x, y, z]| format!("v {x} {y} {z} 128 64 255"), ..Writer::PLAIN },
        ),
        with(
            "weights",
            &Writer { vertex: |[x, y, z]| format!("v {x} {y} {z} 1.0"), ..Writer::PLAIN },
        ),
        with(
            "three texture coordinates",
            &Writer { coordinate: |[u, v]| format!("vt {u} {v} 0.000"), ..Writer::PLAIN },
        ),
        with(
            "exponents",
            &Writer {
                vertex: |at| format!("v {}", at.map(|value| format!("{value:+e}")).join(" ")),
                ..Writer::PLAIN
            },
        ),
        with(
            "upper-case exponents",
            &Writer {
                coordinate: |uv| format!("vt {}", uv.map(|value| format!("{value:E}")).join(" ")),
                ..Writer::PLAIN
            },
        ),
        with(
            "points without digits",
            &Writer {
                vertex: |[x, y, z]| format!("v {x} {y} {z}").replace("0.", "."),
                ..Writer::PLAIN
            },
        ),
        with("face outlines", &Writer { face: "fo", ..Writer::PLAIN }),
        numbered(
            "relative indices",
            |v, t| format!("{}/{}", i64::from(v) - 12, i64::from(t) - 15),
            Same,
        ),
        numbered(
            "indices from 0",
            |v, t| format!("{v}/{t}"),
            Refused("vertex index must start at 1, got 0"),
        ),
        numbered(
            "texture indices from 0",
            |v, t| format!("{}/{t}", v + 1),
            Refused("index must start at 1"),
        ),
        numbered("normals", |v, t| format!("{}/{}/1", v + 1, t + 1), Same),
        numbered("empty normals", |v, t| format!("{}/{}/", v + 1, t + 1), Same),
        numbered(
            "floating-point indices",
            |v, t| format!("{}.0/{}.0", v + 1, t + 1),
            Refused("must be `v/vt`"),
        ),
        numbered(
            "no coordinates",
            |v, _| format!("{}", v + 1),
            Refused("must have a texture coordinate"),
        ),
        numbered(
            "only normals",
            |v, _| format!("{0}//{0}", v + 1),
            Refused("must have a texture coordinate"),
        ),
        numbered(
            "indices beyond the last",
            |v, t| format!("{}/{}", v + 9, t + 1),
            Refused("must be at most 12"),
        ),
        case("names and smoothing", "mesh.obj", named, Same),
        case("faces first", "mesh.obj", backwards, Same),
        case("coordinates between vertices", "mesh.obj", alternating, Same),
        case("split vertices", "mesh.obj", split(), Same),
        case(
            "NaN",
            "mesh.obj",
            plain().replacen("vt 0.125", "vt nan", 1),
            Refused("must be a finite"),
        ),
        case(
            "NaN of an old runtime",
            "mesh.obj",
            plain().replacen("v -0.75", "v -1.#IND", 1),
            Refused("must be a number"),
        ),
        case(
            "infinity",
            "mesh.obj",
            plain().replacen("v -0.75", "v inf", 1),
            Refused("must be a finite"),
        ),
        case("points and lines", "mesh.obj", plain() + "p 1\nl 1 2 3\n", Same),
        case(
            "a part without coordinates",
            "mesh.obj",
            plain() + "o hair\nf 1 2 6 5\nf 2 3 7\n",
            Warned("mesh.obj: 2 of 8 polygons have no UV coordinates and are left out: \"hair\""),
        ),
    ]
}

#[test]
fn obj_files() {
    let bench = Bench::new();
    check(&bench, texts(), COMMAND, difference);
    check(&bench, statements(), COMMAND, difference);
}
