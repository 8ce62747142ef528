//! PLY of scanners, MeshLab, Blender and scripts.

use super::meshes::{COMMAND, Sheet, difference};
use super::{Case, Refused, Same, Warned, case, check};
use crate::bench::Bench;

/// How values are written.
#[derive(Clone, Copy, PartialEq)]
enum Encoding {
    Text,
    Little,
    Big,
}

use Encoding::{Big, Little, Text};

/// A file under construction.
struct Ply {
    encoding: Encoding,
    header: String,
    body: Vec<u8>,
}

impl Ply {
    fn new(encoding: Encoding) -> Self {
        let name = match encoding {
            Text => "ascii",
            Little => "binary_little_endian",
            Big => "binary_big_endian",
        };
        Self { encoding, header: format!("ply\nformat {name} 1.0\n"), body: Vec::new() }
    }

    /// Lines of the header.
    fn says(mut self, lines: &str) -> Self {
        self.header += lines;
        self.header += "\n";
        self
    }

    fn put(&mut self, value: f64, kind: &str) {
        if self.encoding == Text {
            self.body.extend(format!("{value} ").bytes());
            return;
        }
        let mut bytes = match kind {
            "uchar" => vec![value as u8],
            "ushort" => (value as u16).to_le_bytes().to_vec(),
            "int" => (value as i32).to_le_bytes().to_vec(),
            "uint" => (value as u32).to_le_bytes().to_vec(),
            "float" => (value as f32).to_le_bytes().to_vec(),
            "double" => value.to_le_bytes().to_vec(),
            _ => panic!("{kind}"),
        };
        if self.encoding == Big {
            bytes.reverse();
        }
        self.body.extend(bytes);
    }

    fn row(mut self, values: impl IntoIterator<Item = (f64, &'static str)>) -> Self {
        values.into_iter().for_each(|(value, kind)| self.put(value, kind));
        if self.encoding == Text {
            self.body.push(b'\n');
        }
        self
    }

    fn bytes(self) -> Vec<u8> {
        [self.header.into_bytes(), b"end_header\n".to_vec(), self.body].concat()
    }
}

/// A number of a vertex: 0 to 2 for its position, 3 and 4 for its coordinates, others for looks.
type Column = (&'static str, usize);

const POSITIONS: [Column; 3] = [("x", 0), ("y", 1), ("z", 2)];

/// The sheet with coordinates at the vertices.
///
/// - `kind`: the type of the numbers; `index`: those of the lists' counts and items.
fn at_vertices(
    encoding: Encoding,
    columns: &[Column],
    kind: &'static str,
    index: [&'static str; 2],
    list: &str,
) -> Ply {
    let (positions, uv, triangles) = Sheet::new().split();
    let properties: Vec<String> =
        columns.iter().map(|(name, _)| format!("property {kind} {name}")).collect();
    let mut ply = Ply::new(encoding)
        .says(&format!("element vertex {}\n{}", positions.len(), properties.join("\n")))
        .says(&format!("element face {}", triangles.len()))
        .says(&format!("property list {} {} {list}", index[0], index[1]));
    for ([x, y, z], [u, v]) in positions.into_iter().zip(uv) {
        let numbers = [x, y, z, u, v, 0.5, 1.0].map(f64::from);
        ply = ply.row(columns.iter().map(|&(_, at)| (numbers[at], kind)));
    }
    for corners in triangles {
        let corners = corners.map(|corner| (f64::from(corner), index[1]));
        ply = ply.row([(3.0, index[0])].into_iter().chain(corners));
    }
    ply
}

/// The sheet in quads with coordinates at the corners, as MeshLab writes them, and `bare` more faces
/// without.
fn at_corners(encoding: Encoding, bare: usize) -> Vec<u8> {
    let sheet = Sheet::new();
    let mut ply = Ply::new(encoding)
        .says("comment TextureFile skin of a face.png")
        .says(&format!("element vertex {}", sheet.positions.len()))
        .says("property float x\nproperty float y\nproperty float z")
        .says(&format!("element face {}", sheet.quads.len() + bare))
        .says("property list uchar int vertex_indices\nproperty list uchar float texcoord");
    for position in &sheet.positions {
        ply = ply.row(position.map(|value| (f64::from(value), "float")));
    }
    let face = |quad: &[(u32, u32); 4], has_uv: bool| {
        let mut row = vec![(4.0, "uchar")];
        row.extend(quad.map(|(vertex, _)| (f64::from(vertex), "int")));
        let uv = quad.iter().filter(|_| has_uv).flat_map(|&(_, uv)| sheet.uv[uv as usize]);
        let uv: Vec<_> = uv.map(|value| (f64::from(value), "float")).collect();
        row.push((uv.len() as f64, "uchar"));
        row.extend(uv);
        row
    };
    for quad in &sheet.quads {
        ply = ply.row(face(quad, true));
    }
    for quad in &sheet.quads[..bare] {
        ply = ply.row(face(quad, false));
    }
    ply.bytes()
}

fn cases() -> Vec<Case> {
    let st = |u, v| [POSITIONS.to_vec(), vec![(u, 3), (v, 4)]].concat();
    let usual = |encoding| {
        at_vertices(encoding, &st("s", "t"), "float", ["uchar", "int"], "vertex_indices")
    };
    let named =
        |u, v| at_vertices(Text, &st(u, v), "float", ["uchar", "int"], "vertex_indices").bytes();
    let ply = |name, content: Vec<u8>, expected| case(name, "mesh.ply", content, expected);
    let text = || String::from_utf8_lossy(&usual(Text).bytes()).into_owned();
    let colored =
        [POSITIONS.to_vec(), vec![("nx", 5), ("red", 6), ("t", 4), ("s", 3), ("alpha", 6)]]
            .concat();
    let cut = |content: Vec<u8>| content[..content.len() - 9].to_vec();
    vec![
        ply("text", usual(Text).bytes(), Same),
        ply("little-endian", usual(Little).bytes(), Same),
        ply("big-endian", usual(Big).bytes(), Same),
        ply(
            "doubles",
            at_vertices(Little, &st("s", "t"), "double", ["uchar", "int"], "vertex_indices")
                .bytes(),
            Same,
        ),
        ply(
            "big-endian doubles",
            at_vertices(Big, &st("u", "v"), "double", ["uint", "uint"], "vertex_index").bytes(),
            Same,
        ),
        ply(
            "counts of 16 bits",
            at_vertices(Little, &st("s", "t"), "float", ["ushort", "ushort"], "vertex_indices")
                .bytes(),
            Same,
        ),
        ply(
            "counts of 32 bits",
            at_vertices(Big, &st("s", "t"), "float", ["int", "uint"], "vertex_index").bytes(),
            Same,
        ),
        ply("u and v", named("u", "v"), Same),
        ply("texture_u and texture_v", named("texture_u", "texture_v"), Same),
        ply("texture_s and texture_t", named("texture_s", "texture_t"), Same),
        ply(
            "other properties between",
            at_vertices(Little, &colored, "float", ["uchar", "int"], "vertex_indices").bytes(),
            Same,
        ),
        ply("CR LF", text().replace('\n', "\r\n").into(), Same),
        ply("CR", text().replace('\n', "\r").into(), Same),
        ply(
            "comments",
            text().replacen("element", "comment by hand\nobj_info 3 scans\nelement", 1).into(),
            Same,
        ),
        ply(
            "sized types",
            text()
                .replace("property float", "property float32")
                .replace("uchar int", "uint8 int32")
                .into(),
            Same,
        ),
        ply("corners", at_corners(Text, 0), Same),
        ply("little-endian corners", at_corners(Little, 0), Same),
        ply("big-endian corners", at_corners(Big, 0), Same),
        ply(
            "faces without coordinates",
            at_corners(Little, 2),
            Warned(
                "2 of 8 polygons have no UV coordinates and are left out: \"skin of a face.png\"",
            ),
        ),
        ply("no coordinates", named("a", "b"), Refused("no UV coordinates: vertices must have")),
        ply(
            "decimal commas",
            text().replace("0.5", "0,5").into(),
            Refused("must be a number, got"),
        ),
        ply("NaN", text().replacen("-0.75", "nan", 1).into(), Refused("must be finite")),
        ply(
            "strips",
            text().replace("element face", "element tristrips").into(),
            Refused("must have an element `face`"),
        ),
        ply("cut", cut(usual(Little).bytes()), Refused("truncated")),
        ply("cut text", cut(text().into()), Refused("truncated")),
        ply(
            "converted line ends of a binary file",
            {
                let content = usual(Little).bytes();
                content
                    .into_iter()
                    .flat_map(|byte| if byte == b'\n' { vec![13, 10] } else { vec![byte] })
                    .collect()
            },
            Refused("but the mesh has only 15"),
        ),
    ]
}

#[test]
fn ply_files() {
    check(&Bench::new(), cases(), COMMAND, difference);
}
