//! The mesh that all formats describe, and comparing what was read with it.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use uvgraft::Mesh;
use uvgraft_io::pair_file;

use crate::bench::Bench;

/// Vertices of the sheet: 4 columns, 3 rows, none of which lie in a plane.
const COLUMNS: u32 = 4;
const ROWS: u32 = 3;

/// What a pair is made of: the file with itself, as there is no other mesh to go by.
pub(super) const COMMAND: (&str, &str) = ("pair FILE FILE --by faces -o new.uvpair", "new.uvpair");

/// A curved sheet of 3×2 quads in two islands, whose columns 0 to 1 and 2 have separate coordinates
/// along the edge that they share. All numbers are multiples of 1/64, exact in text and binary.
pub(super) struct Sheet {
    pub positions: Vec<[f32; 3]>,
    /// Origin at the bottom left, as in OBJ and PLY.
    pub uv: Vec<[f32; 2]>,
    /// A vertex and a coordinate for each corner.
    pub quads: Vec<[(u32, u32); 4]>,
}

/// Positions, coordinates and triangles.
type Split = (Vec<[f32; 3]>, Vec<[f32; 2]>, Vec<[u32; 3]>);

impl Sheet {
    pub(super) fn new() -> Self {
        let cell = |k: u32, width: u32| [k % width, k / width];
        let position = |k: u32| {
            let [x, y] = cell(k, COLUMNS).map(|value| value as f32);
            [x * 0.5 - 0.75, y * 0.75 + 0.25, (x * x + 3.0 * y) / 16.0]
        };
        // The column of vertices at the seam has two columns of coordinates.
        let coordinate = |k: u32| {
            let [x, y] = cell(k, COLUMNS + 1).map(|value| value as f32);
            [
                if x < 3.0 { 0.125 + x * 0.1875 } else { 0.625 + (x - 3.0) * 0.25 },
                0.0625 + y * 0.3125,
            ]
        };
        let quad = |k: u32| {
            let [x, y] = cell(k, COLUMNS - 1);
            let corner = |dx: u32, dy: u32| {
                let shift = u32::from(x == 2);
                (x + dx + (y + dy) * COLUMNS, x + dx + shift + (y + dy) * (COLUMNS + 1))
            };
            [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]
        };
        Self {
            positions: (0..COLUMNS * ROWS).map(position).collect(),
            uv: (0..(COLUMNS + 1) * ROWS).map(coordinate).collect(),
            quads: (0..(COLUMNS - 1) * (ROWS - 1)).map(quad).collect(),
        }
    }

    /// The corners of its triangles.
    pub(super) fn triangles(&self) -> Vec<[(u32, u32); 3]> {
        self.quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect()
    }

    /// The same with a vertex for each coordinate: positions, coordinates with the origin at the
    /// bottom left, and triangles.
    pub(super) fn split(&self) -> Split {
        let mut positions = vec![[0.0; 3]; self.uv.len()];
        for &(vertex, uv) in self.quads.as_flattened() {
            positions[uv as usize] = self.positions[vertex as usize];
        }
        let triangles = self.triangles().iter().map(|it| it.map(|(_, uv)| uv)).collect();
        (positions, self.uv.clone(), triangles)
    }
}

/// Position and coordinate of a corner, the latter with the origin at the top left.
type Corner = [f32; 5];

/// The triangles of the file's mesh as the sheet's are: from their lowest corner on, in order.
fn soup(corners: impl Iterator<Item = [Corner; 3]>) -> Vec<[Corner; 3]> {
    let key = |corner: &Corner| corner.map(|value| (value * 64.0).round() as i32);
    let mut all: Vec<[Corner; 3]> = corners
        .map(|mut triangle| {
            let first = (0..3).min_by_key(|&k| key(&triangle[k])).unwrap();
            triangle.rotate_left(first);
            triangle
        })
        .collect();
    all.sort_by_key(|triangle| triangle.each_ref().map(key));
    all
}

fn joined([x, y, z]: [f32; 3], [u, v]: [f32; 2]) -> Corner {
    [x, y, z, u, v]
}

/// How far the mesh in the pair file is from the sheet, at most.
pub(super) fn difference(bench: &Bench) -> Result<f32, String> {
    let file = pair_file::read(bench.path(COMMAND.1)).map_err(|error| error.to_string())?;
    let mesh: &Mesh = file.pair.source();
    let of_mesh = mesh.faces().iter().zip(mesh.uv_faces()).map(|(face, uv)| {
        let corner =
            |k: usize| joined(mesh.positions()[face[k] as usize], mesh.uv()[uv[k] as usize]);
        [corner(0), corner(1), corner(2)]
    });
    let sheet = Sheet::new();
    let of_sheet = sheet.triangles().into_iter().map(|triangle| {
        triangle.map(|(vertex, uv)| {
            let [u, v] = sheet.uv[uv as usize];
            joined(sheet.positions[vertex as usize], [u, 1.0 - v])
        })
    });
    let [found, wanted] = [soup(of_mesh), soup(of_sheet)];
    if found.len() != wanted.len() {
        return Err(format!("has {} triangles, must have {}", found.len(), wanted.len()));
    }
    let values = |all: &[[Corner; 3]]| all.as_flattened().as_flattened().to_vec();
    let pairs = values(&found).into_iter().zip(values(&wanted));
    Ok(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max))
}
