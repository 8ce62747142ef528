//! Normal maps baked from exactly known geometry: detail that is a function of the position in
//! space, evaluated at each texel's centre in the frame there. Independent of the code that rotates
//! normals; they share only the corner frames (MikkTSpace), which are a convention.

use uvgraft::raster::ScanTriangle;
use uvgraft::{Extent, Mesh, NormalY, Pair, Size, TangentFrame, TangentFrames};

type Vector = [f64; 3];

/// A triangle's corner on the baked surface: its position and smooth normal.
#[derive(Debug, Clone, Copy)]
pub struct Spot {
    /// Position in the space of the pair's target.
    pub place: Vector,
    /// Smooth normal there.
    pub normal: Vector,
}

/// The spots of each triangle's corners, if it has any.
pub type Spots = Vec<Option<[Spot; 3]>>;

/// The linked triangles, the target's first, and the source corner that corresponds to each target
/// corner.
///
/// # Panics
/// If a piece is not a whole triangle.
pub fn linked_faces(pair: &Pair) -> impl Iterator<Item = ([usize; 2], [usize; 3])> {
    pair.pieces().map(|piece| {
        let Extent::Whole(corners) = piece.extent else { panic!("whole triangles") };
        ([piece.target as usize, piece.source as usize], corners.map(usize::from))
    })
}

/// The spots of the linked triangles of both meshes of a pair, on the target's surface.
///
/// # Panics
/// If a piece is not a whole triangle.
pub fn spots(pair: &Pair) -> (Spots, Spots) {
    let target = pair.target();
    let frames = TangentFrames::new(target);
    let mut of_source: Spots = vec![None; pair.source().faces().len()];
    let mut of_target: Spots = vec![None; target.faces().len()];
    for ([face, of_face], corners) in linked_faces(pair) {
        let spots: [Spot; 3] = std::array::from_fn(|k| Spot {
            place: target.positions()[target.faces()[face][k] as usize].map(f64::from),
            normal: frames.faces()[face][k].normal.map(f64::from),
        });
        of_target[face] = Some(spots);
        let mut sorted = spots;
        for (spot, corner) in spots.into_iter().zip(corners) {
            sorted[corner] = spot;
        }
        of_source[of_face] = Some(sorted);
    }
    (of_source, of_target)
}

/// A baked normal map.
pub struct Baked {
    /// `[height * width]`, encoded; flat where nothing was baked.
    pub texels: Vec<[f32; 3]>,
    /// Whether each triangle shares texels with others.
    pub is_shared: Vec<bool>,
}

/// Bakes the detail of a surface into a mesh's layout.
///
/// - `own`: maps a triangle, a position and a normal, both in the target's space, to the normal in
///   the mesh's own space.
pub fn bake(
    mesh: &Mesh,
    spots: &Spots,
    size: Size,
    y: NormalY,
    own: impl Fn(usize, Vector, Vector) -> Vector,
) -> Baked {
    let frames = TangentFrames::new(mesh);
    let mut texels = vec![[0.5, 0.5, 1.0]; size.texels()];
    let mut owner: Vec<Option<usize>> = vec![None; size.texels()];
    let mut is_shared = vec![false; mesh.faces().len()];
    for (face, spots) in spots.iter().enumerate() {
        let corners = mesh.uv_triangle(face).map(|[u, v]| {
            [f64::from(u) * f64::from(size.width), f64::from(v) * f64::from(size.height)]
        });
        let Some(scan) = ScanTriangle::new(corners, size) else { continue };
        for row in scan.rows() {
            for column in scan.span(row) {
                let texel = (row * size.width + column) as usize;
                if let Some(other) = owner[texel].replace(face) {
                    is_shared[other] = true;
                    is_shared[face] = true;
                }
                let Some(spots) = spots else { continue };
                let px = [f64::from(column) + 0.5, f64::from(row) + 0.5];
                let weights = barycentric(corners, px);
                let place = mix(weights, spots.map(|spot| spot.place));
                let normal = detailed(place, mix(weights, spots.map(|spot| spot.normal)));
                let found = measured(&frames.faces()[face], weights, own(face, place, normal));
                texels[texel] = encode(found, y);
            }
        }
    }
    Baked { texels, is_shared }
}

/// The rotation of each linked triangle from the target's space to the source's: that of its first
/// edge and its plane.
///
/// # Panics
/// If a piece is not a whole triangle.
pub fn face_rotations(pair: &Pair) -> Vec<Option<[Vector; 3]>> {
    let axes = |mesh: &Mesh, vertices: [u32; 3]| {
        let [a, b, c] = vertices.map(|vertex| mesh.positions()[vertex as usize].map(f64::from));
        let [p, q] = [b, c].map(|to| [0, 1, 2].map(|k| to[k] - a[k]));
        let normal = unit(cross(p, q));
        let along = unit(p);
        [along, cross(normal, along), normal]
    };
    let mut rotations = vec![None; pair.source().faces().len()];
    for ([target_face, source_face], corners) in linked_faces(pair) {
        let source = pair.source().faces()[source_face];
        let from = axes(pair.target(), pair.target().faces()[target_face]);
        let to = axes(pair.source(), corners.map(|corner| source[corner]));
        rotations[source_face] = Some(
            [0, 1, 2].map(|row| [0, 1, 2].map(|k| (0..3).map(|a| to[a][row] * from[a][k]).sum())),
        );
    }
    rotations
}

/// The product of a matrix, given by its rows, and a vector.
pub fn rotated(matrix: &[Vector; 3], vector: Vector) -> Vector {
    matrix.map(|row| dot(row, vector))
}

/// The normal of a surface of about a metre with wrinkles of a few centimetres, tilted by up to
/// 50°.
pub fn detailed(place: Vector, normal: Vector) -> Vector {
    let [x, y, z] = place.map(|value| value * 9.0);
    let lean = [(y + 0.5 * z).sin(), (z + x).cos(), (x - 0.7 * y).sin()];
    let normal = unit(normal);
    unit([0, 1, 2].map(|k| normal[k] + 0.7 * lean[k]))
}

/// An object-space normal in an interpolated frame, by Cramer's rule. If the mesh faces away from
/// the surface, the normal is flipped: it sees the surface's back.
fn measured(frames: &[TangentFrame; 3], weights: [f64; 3], normal: Vector) -> Vector {
    let to_f64 = |vector: [f32; 3]| vector.map(f64::from);
    let n = mix(weights, [0, 1, 2].map(|k| to_f64(frames[k].normal)));
    let t = mix(weights, [0, 1, 2].map(|k| to_f64(frames[k].tangent)));
    let b = cross(n, t).map(|value| value * f64::from(frames[0].sign));
    let side = dot(normal, n).signum();
    let normal = normal.map(|value| value * side);
    let determinant = dot(t, cross(b, n));
    let along = |a: Vector, b: Vector| dot(normal, cross(a, b)) / determinant;
    unit([along(b, n), along(n, t), along(t, b)])
}

fn encode(normal: Vector, y: NormalY) -> [f32; 3] {
    let green = if y == NormalY::OpenGl { normal[1] } else { -normal[1] };
    [normal[0], green, normal[2]].map(|value| (value * 0.5 + 0.5) as f32)
}

/// The angle between two encoded normals, in degrees.
pub fn angle(a: &[f32], b: &[f32]) -> f64 {
    let decoded = |texel: &[f32]| unit([0, 1, 2].map(|k| f64::from(texel[k]) * 2.0 - 1.0));
    let (a, b) = (decoded(a), decoded(b));
    let across = cross(a, b);
    dot(across, across).sqrt().atan2(dot(a, b)).to_degrees()
}

fn barycentric([a, b, c]: [[f64; 2]; 3], px: [f64; 2]) -> [f64; 3] {
    let area = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    };
    let whole = area(a, b, c);
    [area(px, b, c) / whole, area(a, px, c) / whole, area(a, b, px) / whole]
}

fn mix(weights: [f64; 3], vectors: [Vector; 3]) -> Vector {
    [0, 1, 2].map(|axis| (0..3).map(|k| weights[k] * vectors[k][axis]).sum())
}

fn dot(a: Vector, b: Vector) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

fn cross(a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3])
}

fn unit(vector: Vector) -> Vector {
    let length = dot(vector, vector).sqrt();
    vector.map(|value| value / length)
}
