//! A mesh from the texels of its layout: faces, and the UV coordinates of their corners.

use uvgraft::correspond::table::UvLocator;
use uvgraft::{Mesh, MeshError, Weights};

use super::layout::{LayoutUv, TexelLayout};

/// Corners of neighbours that are this close, in texels, are one UV coordinate.
const SHARED_PX: f64 = 0.5;

/// Texels of one triangle that are further than this from where its corners put them, in texels, do
/// not belong together.
const MOST_RESIDUAL_PX: f64 = 0.5;

/// The same for a triangle that takes its corners from neighbours: they are exact, so that anything
/// more is a corner on another island.
const MOST_RESIDUAL_OF_KNOWN_PX: f64 = 0.02;

/// A corner is not verified by texels that have less of its weight.
const LEAST_WEIGHT: f64 = 0.05;

/// Rounds in which triangles take corners from neighbours.
const MOST_ROUNDS: usize = 32;

/// A mesh recovered from a layout.
#[derive(Debug, Clone, PartialEq)]
pub struct LayoutMesh {
    /// Its faces, by the vertices of the file, and their UV coordinates. All positions are 0.
    pub mesh: Mesh,
    /// Whether the UV coordinates are the file's own rather than recovered from texels.
    pub is_exact: bool,
    /// Faces of the layout, or of its texels, whose corners were not found.
    pub left_out: usize,
}

/// The texels of one triangle.
struct Triangle {
    vertices: [u32; 3],
    /// Indices into the layout's texels.
    texels: Vec<u32>,
}

/// The mesh of a layout. It has as many vertices as the largest index needs, all at the origin, so it
/// serves where only faces and UV coordinates matter.
///
/// With the file's own UV coordinates, faces keep their order, and a face's vertices are those of a
/// texel inside of it; faces without texels take them from their neighbours. Without, faces are in the
/// order of their vertices, and corners are found by least squares from the texels of each triangle:
/// with three texels or more that are not in a line exactly, others through their neighbours' corners.
///
/// # Errors
/// [`MeshError`]; [`MeshError::NoFaces`] if no corners were found.
pub fn layout_mesh(layout: &TexelLayout) -> Result<LayoutMesh, MeshError> {
    let triangles = triangles(layout);
    if let Some(uv) = &layout.uv
        && let Some(made) = with_uv(layout, uv, &triangles)?
    {
        return Ok(made);
    }
    from_texels(layout, &triangles)
}

fn triangles(layout: &TexelLayout) -> Vec<Triangle> {
    let mut order: Vec<u32> = (0..layout.vertices.len() as u32).collect();
    let vertices = |texel: u32| layout.vertices[texel as usize];
    order.sort_by_key(|&texel| vertices(texel));
    let same = order.chunk_by(|&a, &b| vertices(a) == vertices(b));
    same.map(|texels| Triangle { vertices: vertices(texels[0]), texels: texels.to_vec() }).collect()
}

fn positions(layout: &TexelLayout) -> Vec<[f32; 3]> {
    let most = layout.vertices.as_flattened().iter().max();
    vec![[0.0; 3]; most.map_or(0, |&most| most as usize + 1)]
}

/// The mesh with the file's own UV coordinates; `None` if texels contradict them.
fn with_uv(
    layout: &TexelLayout,
    uv: &LayoutUv,
    triangles: &[Triangle],
) -> Result<Option<LayoutMesh>, MeshError> {
    let flat = vec![[0.0; 3]; uv.uv.len()];
    let flat = Mesh::from_triangles(flat, uv.uv.clone(), &uv.faces, &uv.faces)?;
    let locator = UvLocator::new(&flat);
    let mut faces: Vec<Option<[u32; 3]>> = vec![None; uv.faces.len()];
    let mut found = 0;
    for triangle in triangles {
        if let Some((face, vertices)) = face_of(layout, &locator, triangle) {
            faces[face as usize] = Some(vertices);
            found += 1;
        }
    }
    // Texels and coordinates of different layouts agree by accident only.
    if 2 * found < triangles.len() {
        return Ok(None);
    }
    let mut vertex_of_uv = vec![None; uv.uv.len()];
    for (corners, vertices) in uv.faces.iter().zip(&faces) {
        for (&corner, &vertex) in corners.iter().zip(vertices.iter().flatten()) {
            vertex_of_uv[corner as usize] = Some(vertex);
        }
    }
    let of_neighbours = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| vertex_of_uv[corner as usize]);
        Some([a?, b?, c?])
    };
    let known = faces.iter().zip(&uv.faces).filter_map(|(vertices, corners)| {
        Some(((*vertices).or_else(|| of_neighbours(corners))?, *corners))
    });
    let (faces, uv_faces): (Vec<_>, Vec<_>) = known.unzip();
    let left_out = uv.faces.len() - faces.len();
    let mesh = Mesh::from_triangles(positions(layout), uv.uv.clone(), &faces, &uv_faces)?;
    Ok(Some(LayoutMesh { mesh, is_exact: true, left_out }))
}

/// The face of a layout in which a triangle's texel lies, and the vertices of its corners.
fn face_of(
    layout: &TexelLayout,
    locator: &UvLocator,
    triangle: &Triangle,
) -> Option<(u32, [u32; 3])> {
    // The weights of a texel are the same in the file's triangle and in the face, if it is that one.
    const MOST_DIFFERENCE: f64 = 0.1;
    // Corners in the same order, as in all known files, differ by rounding only. Texels on a symmetry
    // axis of a triangle may agree with another order as well.
    const ROUNDING: f64 = 1e-3;
    const ORDERS: [[usize; 3]; 6] =
        [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let smallest = |texel: u32| {
        let [a, b, c] = layout.weights[texel as usize];
        a.min(b).min(c)
    };
    // The texel furthest inside.
    let inner = |&a: &u32, &b: &u32| smallest(a).total_cmp(&smallest(b));
    let texel = triangle.texels.iter().copied().max_by(inner)? as usize;
    let sides = [layout.size.width, layout.size.height].map(f64::from);
    let uv_at = |texel: usize| {
        let centre = layout.centres_px[texel];
        [0, 1].map(|axis| f64::from(centre[axis]) / sides[axis])
    };
    let face = locator.locate(uv_at(texel), 1.5 / sides[0].min(sides[1]))?.face;
    let all = triangle.texels.iter().map(|&texel| texel as usize);
    let pairs =
        all.map(|texel| Some((layout.weights[texel], locator.weights(face, uv_at(texel))?)));
    let pairs: Vec<[Weights; 2]> =
        pairs.map(|pair| pair.map(<[_; 2]>::from)).collect::<Option<_>>()?;
    let difference = |order: &[usize; 3]| {
        let of_pair = |[file, here]: &[Weights; 2]| {
            (0..3).map(|k| (file[order[k]] - here[k]).abs()).fold(0.0, f64::max)
        };
        pairs.iter().map(of_pair).fold(0.0, f64::max)
    };
    let [same, ..] = &ORDERS;
    let order = match difference(same) {
        rounding if rounding < ROUNDING => same,
        _ => ORDERS.iter().min_by(|a, b| difference(a).total_cmp(&difference(b)))?,
    };
    (difference(order) <= MOST_DIFFERENCE).then(|| (face, order.map(|k| triangle.vertices[k])))
}

/// The mesh with UV coordinates from texels.
fn from_texels(layout: &TexelLayout, triangles: &[Triangle]) -> Result<LayoutMesh, MeshError> {
    let positions = positions(layout);
    let mut corners = Corners::new(positions.len());
    let mut uv_faces: Vec<Option<[u32; 3]>> = vec![None; triangles.len()];
    let samples = |triangle: &Triangle| -> Vec<(Weights, [f64; 2])> {
        let sample = |&texel: &u32| {
            let texel = texel as usize;
            (layout.weights[texel], layout.centres_px[texel].map(f64::from))
        };
        triangle.texels.iter().map(sample).collect()
    };
    // Triangles with most texels come first, so that others share their corners.
    let mut order: Vec<usize> = (0..triangles.len()).collect();
    order.sort_by_key(|&index| std::cmp::Reverse(triangles[index].texels.len()));
    let mut rest = Vec::new();
    for index in order {
        let triangle = &triangles[index];
        match fitted(&samples(triangle)) {
            Some(found) => {
                let pairs = [0, 1, 2].map(|k| (triangle.vertices[k], found[k]));
                uv_faces[index] = Some(pairs.map(|(vertex, at)| corners.shared(vertex, at)));
            }
            None => rest.push(index),
        }
    }
    // The others in rounds, since each may give its neighbours a corner.
    for _ in 0..MOST_ROUNDS {
        let before = rest.len();
        rest.retain(|&index| {
            uv_faces[index] =
                corners.of_neighbours(triangles[index].vertices, &samples(&triangles[index]));
            uv_faces[index].is_none()
        });
        if rest.len() == before {
            break;
        }
    }
    let known = triangles.iter().zip(&uv_faces);
    let known = known.filter_map(|(triangle, corners)| Some((triangle.vertices, (*corners)?)));
    let (faces, uv_faces): (Vec<_>, Vec<_>) = known.unzip();
    let sides = [layout.size.width, layout.size.height].map(f64::from);
    let uv = corners.uv.iter().map(|&[x, y]| [(x / sides[0]) as f32, (y / sides[1]) as f32]);
    let mesh = Mesh::from_triangles(positions, uv.collect(), &faces, &uv_faces)?;
    Ok(LayoutMesh { left_out: triangles.len() - mesh.faces().len(), mesh, is_exact: false })
}

/// The UV coordinates of vertices, in texels: several where islands meet.
struct Corners {
    uv: Vec<[f64; 2]>,
    /// Indices into `uv` for each vertex.
    of_vertex: Vec<Vec<u32>>,
}

impl Corners {
    fn new(vertices: usize) -> Self {
        Self { uv: Vec::new(), of_vertex: vec![Vec::new(); vertices] }
    }

    /// The corner of a vertex at a place, which is added if no other is near.
    fn shared(&mut self, vertex: u32, at: [f64; 2]) -> u32 {
        let known = &mut self.of_vertex[vertex as usize];
        let near = known.iter().copied().find(|&corner| {
            let other = self.uv[corner as usize];
            (other[0] - at[0]).hypot(other[1] - at[1]) < SHARED_PX
        });
        near.unwrap_or_else(|| {
            let corner = self.uv.len() as u32;
            self.uv.push(at);
            known.push(corner);
            corner
        })
    }

    /// The corners of a triangle with few texels: of those that its vertices have in other triangles,
    /// the ones that put its texels where they are.
    fn of_neighbours(
        &mut self,
        vertices: [u32; 3],
        samples: &[(Weights, [f64; 2])],
    ) -> Option<[u32; 3]> {
        /// Islands that meet at a vertex; a file may claim thousands.
        const MOST: usize = 6;
        let is_seen = |k: usize| samples.iter().any(|(weights, _)| weights[k] >= LEAST_WEIGHT);
        if !(0..3).all(is_seen) {
            return None;
        }
        let options = vertices.map(|vertex| {
            let known = &self.of_vertex[vertex as usize];
            known[..known.len().min(MOST)].to_vec()
        });
        let mut best: Option<(f64, [u32; 3])> = None;
        for &a in &options[0] {
            for &b in &options[1] {
                for &c in &options[2] {
                    let corners = [a, b, c].map(|corner| self.uv[corner as usize]);
                    let residual = residual(&corners, samples);
                    if residual <= MOST_RESIDUAL_OF_KNOWN_PX
                        && best.is_none_or(|best| residual < best.0)
                    {
                        best = Some((residual, [a, b, c]));
                    }
                }
            }
        }
        if let Some((_, corners)) = best {
            return Some(corners);
        }
        self.with_third(vertices, &options, samples)
    }

    /// The corners of a triangle of which two are known: one texel puts the third, others verify it.
    fn with_third(
        &mut self,
        vertices: [u32; 3],
        options: &[Vec<u32>; 3],
        samples: &[(Weights, [f64; 2])],
    ) -> Option<[u32; 3]> {
        let third = (0..3).find(|&k| options[k].is_empty())?;
        let [k, l] = [(third + 1) % 3, (third + 2) % 3];
        // With several islands it would be a guess, and so it would with a single texel.
        let (&[b], &[c], 2..) = (&options[k][..], &options[l][..], samples.len()) else {
            return None;
        };
        let heavier =
            |a: &&(Weights, [f64; 2]), b: &&(Weights, [f64; 2])| a.0[third].total_cmp(&b.0[third]);
        let (weights, at) = samples.iter().max_by(heavier)?;
        let mut places = [[0.0; 2]; 3];
        (places[k], places[l]) = (self.uv[b as usize], self.uv[c as usize]);
        places[third] = [0, 1].map(|axis| {
            (at[axis] - weights[k] * places[k][axis] - weights[l] * places[l][axis])
                / weights[third]
        });
        if residual(&places, samples) > MOST_RESIDUAL_OF_KNOWN_PX {
            return None;
        }
        let mut corners = [0; 3];
        (corners[k], corners[l]) = (b, c);
        corners[third] = self.shared(vertices[third], places[third]);
        Some(corners)
    }
}

fn placed(corners: &[[f64; 2]; 3], weights: Weights) -> [f64; 2] {
    [0, 1].map(|axis| (0..3).map(|k| weights[k] * corners[k][axis]).sum())
}

/// The largest distance of a texel from where the corners put it.
fn residual(corners: &[[f64; 2]; 3], samples: &[(Weights, [f64; 2])]) -> f64 {
    let off = |(weights, at): &(Weights, [f64; 2])| {
        let [x, y] = placed(corners, *weights);
        (x - at[0]).hypot(y - at[1])
    };
    samples.iter().map(off).fold(0.0, f64::max)
}

/// The corners that put texels where they are, by least squares: `(BᵀB) C = BᵀP` with weights `B` and
/// centres `P`. `None` if the texels don't determine them.
fn fitted(samples: &[(Weights, [f64; 2])]) -> Option<[[f64; 2]; 3]> {
    if samples.len() < 3 {
        return None;
    }
    let (mut gram, mut right) = ([[0.0; 3]; 3], [[0.0; 2]; 3]);
    for (weights, at) in samples {
        for k in 0..3 {
            (0..3).for_each(|l| gram[k][l] += weights[k] * weights[l]);
            (0..2).for_each(|axis| right[k][axis] += weights[k] * at[axis]);
        }
    }
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    // Rows of the inverse times the determinant; the matrix is symmetric.
    let [a, b, c] = gram;
    let inverse = [cross(b, c), cross(c, a), cross(a, b)];
    let determinant = dot(a, inverse[0]);
    let scale = (gram[0][0] + gram[1][1] + gram[2][2]) / 3.0;
    // Texels in a line leave rounding only.
    if determinant.is_nan() || determinant <= 1e-7 * scale.powi(3) {
        return None;
    }
    let column = |axis: usize| [right[0][axis], right[1][axis], right[2][axis]];
    let corners = inverse.map(|row| [0, 1].map(|axis| dot(row, column(axis)) / determinant));
    let is_fit = residual(&corners, samples) <= MOST_RESIDUAL_PX;
    (is_fit && corners.as_flattened().iter().all(|value| value.is_finite())).then_some(corners)
}
