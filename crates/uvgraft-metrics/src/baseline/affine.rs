//! One affine warp per triangle, the way scripts use the functions of image libraries.
//!
//! Corners are truncated to whole texels; for each triangle the whole source is warped, and
//! the whole result is masked and pasted over the picture. A 17 × 17 median at the end
//! hides the cracks.

use std::borrow::Cow;

use uvgraft::pair::{Direction, Pair};
use uvgraft::piece::{Extent, Piece};
use uvgraft::texture::{Channels, Depth, Size, Sizes, Texels, TexelsMut, Texture};
use uvgraft::threads::for_each_chunk;

use super::median::median;

/// Side of the median window, in texels.
pub const MEDIAN_PX: u32 = 17;

/// The triangles for one direction of a pair, at fixed source and target sizes.
#[derive(Debug, Clone)]
pub struct Affine {
    triangles: Vec<Triangle>,
    source_size: Size,
    target_size: Size,
}

#[derive(Debug, Clone)]
struct Triangle {
    /// Corners in whole texels, wound so that the inside is on the positive side of each edge.
    target: [[i64; 2]; 3],
    /// Affine map from target to source: `source = offset + slope · target`.
    offset: [f64; 2],
    slope: [[f64; 2]; 2],
}

/// Ranges of columns and rows, both inclusive.
#[derive(Debug, Clone, Copy)]
struct Bounds {
    x: [u32; 2],
    y: [u32; 2],
}

impl Affine {
    /// The triangles whose area is not zero once their corners are truncated to whole texels.
    pub fn new(pair: &Pair, direction: Direction, sizes: Sizes) -> Self {
        let Sizes { from: source_size, to: target_size } = sizes;
        let mut pieces: Vec<Piece> = pair.pieces().collect();
        if direction == Direction::Reverse {
            // Triangles are drawn in the order of the faces that they fill, later ones on top.
            pieces.sort_by_key(|piece| piece.source);
        }
        let triangles = pieces.iter().filter_map(|piece| {
            let [mut target, mut source] = piece.uv(pair.target(), pair.source());
            if direction == Direction::Reverse {
                std::mem::swap(&mut target, &mut source);
                if let Extent::Whole(corners) = piece.extent {
                    // In corner order of the face that is filled.
                    let at = |corner: u8| corners.iter().position(|&other| other == corner);
                    let order = [0, 1, 2].map(|corner| at(corner).unwrap_or(usize::from(corner)));
                    target = order.map(|at| target[at]);
                    source = order.map(|at| source[at]);
                }
            }
            Triangle::new(
                source.map(|uv| whole_texel(uv, source_size)),
                target.map(|uv| whole_texel(uv, target_size)),
            )
        });
        Self { triangles: triangles.collect(), source_size, target_size }
    }

    /// Number of triangles that are drawn.
    pub fn triangles(&self) -> usize {
        self.triangles.len()
    }

    /// Transfers a texture, as 8-bit RGB. Only the bounding rectangle of each triangle is warped
    /// and pasted, which gives the same picture faster. The median runs over the resulting picture
    /// and replaces the texels that a triangle covers; elsewhere the base is unchanged.
    ///
    /// # Panics
    /// If a texture differs in size from the sizes given to [`Affine::new`].
    pub fn transfer(&self, source: &Texture, base: Texture) -> Texture {
        let (source, mut base) = self.rgb(source, base);
        let width = self.target_size.width as usize;
        let mut drawn = vec![false; self.target_size.texels()];
        let (Texels::U8(source), TexelsMut::U8(values)) = (source.texels(), base.texels_mut())
        else {
            unreachable!("converted to 8 bits")
        };
        for triangle in &self.triangles {
            let Some(bounds) = triangle.bounds(self.target_size) else { continue };
            for y in bounds.y[0]..=bounds.y[1] {
                for x in bounds.x[0]..=bounds.x[1] {
                    if triangle.contains(x, y) {
                        let texel = y as usize * width + x as usize;
                        drawn[texel] = true;
                        values[texel * 3..texel * 3 + 3].copy_from_slice(&triangle.warped(
                            x,
                            y,
                            source,
                            self.source_size,
                        ));
                    }
                }
            }
        }
        let smooth = median(values, self.target_size, MEDIAN_PX);
        for (texel, _) in drawn.into_iter().enumerate().filter(|(_, drawn)| *drawn) {
            values[texel * 3..texel * 3 + 3].copy_from_slice(&smooth[texel * 3..texel * 3 + 3]);
        }
        base
    }

    /// Does for one triangle what scripts do for each: warps the whole picture, then pastes it
    /// through a mask of the whole picture. Only for measuring its cost.
    ///
    /// # Panics
    /// If a texture differs in size from the sizes given to [`Affine::new`], or the triangle does
    /// not exist.
    pub fn draw_whole_picture(&self, triangle: usize, source: &Texture, base: Texture) -> Texture {
        let (source, mut base) = self.rgb(source, base);
        let triangle = &self.triangles[triangle];
        let width = self.target_size.width as usize;
        let (Texels::U8(source), TexelsMut::U8(values)) = (source.texels(), base.texels_mut())
        else {
            unreachable!("converted to 8 bits")
        };
        let mut warped = vec![0; values.len()];
        for_each_chunk(&mut warped, width * 3, |y, row| {
            for (x, texel) in (0..).zip(row.chunks_exact_mut(3)) {
                texel.copy_from_slice(&triangle.warped(x, y as u32, source, self.source_size));
            }
        });
        for_each_chunk(values, width * 3, |y, row| {
            let warped = &warped[y * width * 3..][..width * 3];
            for (x, (texel, warped)) in
                (0..).zip(row.chunks_exact_mut(3).zip(warped.chunks_exact(3)))
            {
                let mask = u8::from(triangle.contains(x, y as u32));
                for channel in 0..3 {
                    texel[channel] = texel[channel] * (1 - mask) + warped[channel] * mask;
                }
            }
        });
        base
    }

    fn rgb<'a>(&self, source: &'a Texture, base: Texture) -> (Cow<'a, Texture>, Texture) {
        assert_eq!(source.size(), self.source_size, "made for one size");
        assert_eq!(base.size(), self.target_size, "made for one size");
        let source = match (source.channels(), source.depth()) {
            (Channels::Rgb, Depth::U8) => Cow::Borrowed(source),
            _ => Cow::Owned(source.clone().converted(Channels::Rgb, Depth::U8)),
        };
        (source, base.converted(Channels::Rgb, Depth::U8))
    }
}

/// Texel coordinates of a UV position, truncated to integers.
fn whole_texel(uv: [f64; 2], size: Size) -> [i64; 2] {
    let cut = |value: f64, count: u32| {
        // Far beyond any texture, but small enough that products of two values do not overflow.
        const FAR: f64 = 1e6;
        (value * f64::from(count)).clamp(-FAR, FAR) as i64
    };
    [cut(uv[0], size.width), cut(uv[1], size.height)]
}

impl Triangle {
    fn new(source: [[i64; 2]; 3], mut target: [[i64; 2]; 3]) -> Option<Self> {
        let side =
            |points: &[[i64; 2]; 3], k: usize| [0, 1].map(|axis| points[k][axis] - points[0][axis]);
        let [p, q] = [1, 2].map(|k| side(&target, k));
        let doubled_area = p[0] * q[1] - p[1] * q[0];
        if doubled_area == 0 {
            return None;
        }
        let [s, t] = [1, 2].map(|k| side(&source, k));
        let slope = [0, 1].map(|axis| {
            [s[axis] * q[1] - t[axis] * p[1], t[axis] * p[0] - s[axis] * q[0]]
                .map(|product| product as f64 / doubled_area as f64)
        });
        let offset = [0, 1].map(|axis| {
            let [x, y] = target[0].map(|value| value as f64);
            source[0][axis] as f64 - slope[axis][0] * x - slope[axis][1] * y
        });
        if doubled_area < 0 {
            target.swap(1, 2);
        }
        Some(Self { target, offset, slope })
    }

    /// The bounding rectangle of the triangle, clipped to a texture.
    fn bounds(&self, size: Size) -> Option<Bounds> {
        let range = |axis: usize, count: u32| {
            let values = self.target.map(|corner| corner[axis]);
            let low = values.into_iter().min()?.max(0);
            let high = values.into_iter().max()?.min(i64::from(count) - 1);
            (low <= high).then_some([low as u32, high as u32])
        };
        Some(Bounds { x: range(0, size.width)?, y: range(1, size.height)? })
    }

    /// Whether a texel lies inside or on an edge.
    fn contains(&self, x: u32, y: u32) -> bool {
        (0..3).all(|k| {
            let (a, b) = (self.target[k], self.target[(k + 1) % 3]);
            (b[0] - a[0]) * (i64::from(y) - a[1]) >= (b[1] - a[1]) * (i64::from(x) - a[0])
        })
    }

    /// The source's colour for a target texel: bilinear between integer positions, black outside.
    fn warped(&self, x: u32, y: u32, source: &[u8], size: Size) -> [u8; 3] {
        let (x, y) = (f64::from(x), f64::from(y));
        let at = [0, 1].map(|k| self.offset[k] + self.slope[k][0] * x + self.slope[k][1] * y);
        let low = at.map(f64::floor);
        let fraction = [0, 1].map(|k| at[k] - low[k]);
        let texel = |dx: i64, dy: i64, channel: usize| {
            let (x, y) = (low[0] as i64 + dx, low[1] as i64 + dy);
            let inside =
                (0..i64::from(size.width)).contains(&x) && (0..i64::from(size.height)).contains(&y);
            let index = || (y as usize * size.width as usize + x as usize) * 3 + channel;
            if inside { f64::from(source[index()]) } else { 0.0 }
        };
        [0, 1, 2].map(|channel| {
            let row = |dy: i64| {
                texel(0, dy, channel) * (1.0 - fraction[0]) + texel(1, dy, channel) * fraction[0]
            };
            (row(0) * (1.0 - fraction[1]) + row(1) * fraction[1]).round() as u8
        })
    }
}

#[cfg(test)]
mod tests {
    use uvgraft::color::Encoding;
    use uvgraft::mesh::Mesh;

    use super::*;

    fn noise(size: Size, seed: u64) -> Texture {
        let mut rng = fastrand::Rng::with_seed(seed);
        let values = (0..size.texels() * 3).map(|_| rng.u8(..)).collect();
        Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(values)).unwrap()
    }

    fn square(corners: [[f32; 2]; 4]) -> Mesh {
        let faces = [[0, 1, 2], [0, 2, 3]];
        Mesh::from_triangles(vec![[0.0; 3]; 4], corners.to_vec(), &faces, &faces).unwrap()
    }

    fn pair(target: [[f32; 2]; 4]) -> Pair {
        let source = square([[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]]);
        Pair::by_vertex_map(source, square(target), &[0, 1, 2, 3]).unwrap()
    }

    #[test]
    fn moves_whole_texels_and_smooths_them() {
        let size = Size::square(40);
        let (source, base) = (noise(size, 1), noise(size, 2));
        // The same square, moved ten texels to the right and five down.
        let moved = [[0.25, 0.125], [0.75, 0.125], [0.75, 0.625], [0.25, 0.625]];
        let affine = Affine::new(&pair(moved), Direction::Forward, Sizes { from: size, to: size });
        assert_eq!(affine.triangles(), 2);
        let result = affine.transfer(&source, base.clone());
        // Without the median: the pasted square, including its right and bottom edges.
        let sharp =
            (0..2).fold(base.clone(), |base, k| affine.draw_whole_picture(k, &source, base));
        for (x, y) in [(10, 5), (30, 25), (20, 15), (11, 24)] {
            assert_eq!(sharp.get(x, y, 1), source.get(x - 10, y - 5, 1), "{x} {y}");
        }
        for (x, y) in [(9, 10), (31, 10), (20, 4), (20, 26)] {
            assert_eq!(sharp.get(x, y, 1), base.get(x, y, 1), "{x} {y}");
            assert_eq!(result.get(x, y, 1), base.get(x, y, 1), "{x} {y}");
        }
        let mut window: Vec<f32> = (12..29)
            .flat_map(|x| (7..24).map(move |y| (x, y)))
            .map(|(x, y)| sharp.get(x, y, 1))
            .collect();
        window.sort_unstable_by(f32::total_cmp);
        assert_eq!(result.get(20, 15, 1), window[17 * 17 / 2]);
    }

    #[test]
    fn mirrored_triangles_are_drawn_and_collapsed_ones_left_out() {
        let size = Size::square(40);
        let mirrored = [[0.5, 0.0], [0.0, 0.0], [0.0, 0.5], [0.5, 0.5]];
        let affine =
            Affine::new(&pair(mirrored), Direction::Forward, Sizes { from: size, to: size });
        let source = noise(size, 1);
        let result =
            (0..2).fold(noise(size, 2), |base, k| affine.draw_whole_picture(k, &source, base));
        assert_eq!(result.get(3, 7, 0), source.get(17, 7, 0));
        // Less than a texel wide.
        let thin = [[0.5, 0.0], [0.51, 0.0], [0.51, 0.5], [0.5, 0.5]];
        let affine = Affine::new(&pair(thin), Direction::Forward, Sizes { from: size, to: size });
        assert_eq!(affine.triangles(), 0);
    }
}
