//! A second, naive implementation of the transfer: barycentric coordinates in 64 bits for every
//! texel in every triangle's bounding box, then bilinear sampling. It shares nothing with the map
//! or the kernels except the pieces and the stated conventions.

use uvgraft::{Direction, Extent, Pair, Size, Texels, Texture};

/// The naive implementation's result for one texel.
#[derive(Clone, Copy, Default)]
pub struct Texel {
    /// The value in 8-bit levels: red, green, blue.
    pub value: [f64; 3],
    /// Number of target triangles, linked or not, that contain the texel's centre.
    pub covering: u32,
    /// Whether a linked triangle contains the centre.
    pub linked: bool,
    /// Whether all texels read lie inside the source's islands.
    pub inside_source: bool,
}

/// Barycentric coordinates of a point in a triangle; `None` if the triangle has no area.
fn barycentric(point: [f64; 2], [a, b, c]: [[f64; 2]; 3]) -> Option<[f64; 3]> {
    let cross = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    };
    let area = cross(a, b, c);
    (area != 0.0)
        .then(|| [cross(point, b, c) / area, cross(a, point, c) / area, cross(a, b, point) / area])
}

fn mix(weights: [f64; 3], points: [[f64; 2]; 3]) -> [f64; 2] {
    [0, 1].map(|axis| (0..3).map(|k| weights[k] * points[k][axis]).sum())
}

fn scaled(triangle: [[f32; 2]; 3], size: Size) -> [[f64; 2]; 3] {
    triangle
        .map(|[u, v]| [f64::from(u) * f64::from(size.width), f64::from(v) * f64::from(size.height)])
}

/// Calls `visit` with every texel that overlaps a triangle's bounding box.
fn box_texels(triangle: [[f64; 2]; 3], size: Size, mut visit: impl FnMut(u32, u32)) {
    let bounds = |axis: usize, count: u32| {
        let values = triangle.map(|corner| corner[axis]);
        let low = values.iter().copied().fold(f64::MAX, f64::min).floor().max(0.0) as u32;
        let high = values.iter().copied().fold(f64::MIN, f64::max).ceil().max(0.0) as u32;
        low..high.min(count)
    };
    for y in bounds(1, size.height) {
        for x in bounds(0, size.width) {
            visit(x, y);
        }
    }
}

/// Transfers an 8-bit RGB texture bilinearly, supersampled where a texel spans several source
/// texels.
///
/// Along each axis of the target, a texel takes as many samples as a step of one texel covers
/// source texels, rounded and clamped to `1..=16`; its value is their mean. Where triangles
/// overlap, the last linked one wins.
///
/// # Panics
/// If the texture is not 8-bit RGB, or a piece is not a whole triangle.
pub fn transfer(pair: &Pair, direction: Direction, source: &Texture, size: Size) -> Vec<Texel> {
    let Texels::U8(values) = source.texels() else { panic!("8 bits") };
    assert_eq!(source.channels().count(), 3);
    let (from, to) = (pair.from(direction), pair.to(direction));
    let source_size = source.size();
    let mut in_source = vec![false; source_size.texels()];
    for face in 0..from.faces().len() {
        let triangle = scaled(from.uv_triangle(face), source_size);
        box_texels(triangle, source_size, |x, y| {
            let centre = [f64::from(x) + 0.5, f64::from(y) + 0.5];
            if barycentric(centre, triangle).is_some_and(|w| w.iter().all(|&w| w >= 0.0)) {
                in_source[(y * source_size.width + x) as usize] = true;
            }
        });
    }
    // Index of a source texel, clamped to the texture.
    let texel = |x: f64, y: f64| -> usize {
        let x = x.clamp(0.0, f64::from(source_size.width - 1)) as usize;
        let y = y.clamp(0.0, f64::from(source_size.height - 1)) as usize;
        y * source_size.width as usize + x
    };
    let mut piece_of = vec![None; to.faces().len()];
    for piece in pair.pieces() {
        let Extent::Whole(corners) = piece.extent else { panic!("whole triangles") };
        let face = match direction {
            Direction::Forward => piece.target,
            Direction::Reverse => piece.source,
        };
        piece_of[face as usize].get_or_insert((piece, corners));
    }
    let mut found = vec![Texel::default(); size.texels()];
    for face in 0..to.faces().len() {
        let triangle = scaled(to.uv_triangle(face), size);
        let source_triangle = piece_of[face].map(|(piece, permutation)| {
            let mut corners = [[0.0; 2]; 3];
            for k in 0..3 {
                let other = permutation[k] as usize;
                match direction {
                    Direction::Forward => {
                        corners[k] =
                            scaled(from.uv_triangle(piece.source as usize), source_size)[other];
                    }
                    Direction::Reverse => {
                        corners[other] =
                            scaled(from.uv_triangle(piece.target as usize), source_size)[k];
                    }
                }
            }
            corners
        });
        box_texels(triangle, size, |x, y| {
            let centre = [f64::from(x) + 0.5, f64::from(y) + 0.5];
            let Some(weights) = barycentric(centre, triangle) else { return };
            if weights.iter().any(|&weight| weight < 0.0) {
                return;
            }
            let found = &mut found[(y * size.width + x) as usize];
            found.covering += 1;
            let Some(corners) = source_triangle else { return };
            let source_at = |dx: f64, dy: f64| {
                let point = [centre[0] + dx, centre[1] + dy];
                barycentric(point, triangle).map_or([0.0; 2], |weights| mix(weights, corners))
            };
            let here = source_at(0.0, 0.0);
            let samples = [source_at(1.0, 0.0), source_at(0.0, 1.0)].map(|next| {
                (next[0] - here[0]).hypot(next[1] - here[1]).round().clamp(1.0, 16.0) as u32
            });
            let mut sum = [0.0; 3];
            found.linked = true;
            found.inside_source = true;
            for b in 0..samples[1] {
                for a in 0..samples[0] {
                    let offset = |k: u32, n: u32| (f64::from(k) + 0.5) / f64::from(n) - 0.5;
                    let at = source_at(offset(a, samples[0]), offset(b, samples[1]));
                    let [x, y] = at.map(|position| position - 0.5);
                    for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
                        let (column, row) = (x.floor() + dx, y.floor() + dy);
                        let weight = (1.0 - (x - column).abs()) * (1.0 - (y - row).abs());
                        let index = texel(column, row);
                        found.inside_source &= in_source[index];
                        for (channel, sum) in sum.iter_mut().enumerate() {
                            *sum += weight * f64::from(values[index * 3 + channel]);
                        }
                    }
                }
            }
            found.value = sum.map(|sum| sum / f64::from(samples[0] * samples[1]));
        });
    }
    found
}
