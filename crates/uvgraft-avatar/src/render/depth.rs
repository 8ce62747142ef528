//! An orthographic camera, and which triangle is in front at every sample.

use std::f32::consts::TAU;

use rayon::prelude::*;
use uvgraft::Size;
use uvgraft::raster::ScanTriangle;

use super::View;
use crate::noise::random;
use crate::vector::{Vec3, smoothstep, vec3};

/// No triangle.
pub(crate) const EMPTY: u32 = u32::MAX;

/// Projects to sample coordinates, and to depth that grows towards the camera.
#[derive(Debug, Clone)]
pub(crate) struct Camera {
    pub right: Vec3,
    pub up: Vec3,
    /// From the mesh to the camera.
    pub towards: Vec3,
    target: Vec3,
    pub unit_per_px: f32,
    middle: [f32; 2],
}

impl Camera {
    pub fn new(view: &View, size: Size) -> Self {
        let (sin, cos) = view.azimuth.to_radians().sin_cos();
        let (rise, flat) = view.elevation.clamp(-89.0, 89.0).to_radians().sin_cos();
        let towards = vec3(sin * flat, rise, cos * flat);
        Self::looking(towards, view.target.into(), view.height / size.height as f32, size)
    }

    /// Seen from the direction `towards`, `target` in the middle.
    pub fn looking(towards: Vec3, target: Vec3, unit_per_px: f32, size: Size) -> Self {
        let right = vec3(0.0, 1.0, 0.0).cross(towards).normalized();
        let up = towards.cross(right);
        let middle = [size.width as f32 * 0.5, size.height as f32 * 0.5];
        Self { right, up, towards, target, unit_per_px, middle }
    }

    pub fn project(&self, p: Vec3) -> Vec3 {
        let q = p - self.target;
        vec3(
            self.middle[0] + q.dot(self.right) / self.unit_per_px,
            self.middle[1] - q.dot(self.up) / self.unit_per_px,
            q.dot(self.towards),
        )
    }
}

impl Camera {
    /// The point of the plane through the target that is seen at a sample.
    pub fn unproject(&self, x: f32, y: f32) -> Vec3 {
        self.target
            + self.right * ((x - self.middle[0]) * self.unit_per_px)
            + self.up * ((self.middle[1] - y) * self.unit_per_px)
    }
}

pub(crate) struct DepthBuffer {
    size: Size,
    depths: Vec<f32>,
    faces: Vec<u32>,
}

const BAND: u32 = 32;

impl DepthBuffer {
    pub fn new(camera: &Camera, positions: &[Vec3], faces: &[[u32; 3]], size: Size) -> Self {
        let projected: Vec<Vec3> = positions.iter().map(|&p| camera.project(p)).collect();
        let mut bands = vec![Vec::new(); size.height.div_ceil(BAND) as usize];
        let triangles: Vec<(u32, ScanTriangle)> = faces
            .iter()
            .enumerate()
            .filter_map(|(face, corners)| {
                let corners = corners.map(|vertex| {
                    let p = projected[vertex as usize];
                    [f64::from(p.x), f64::from(p.y)]
                });
                Some((face as u32, ScanTriangle::new(corners, size)?))
            })
            .collect();
        for (index, (_, scan)) in triangles.iter().enumerate() {
            for band in scan.rows().start / BAND..=(scan.rows().end - 1) / BAND {
                bands[band as usize].push(index);
            }
        }
        let width = size.width as usize;
        let mut depths = vec![f32::NEG_INFINITY; size.texels()];
        let mut owners = vec![EMPTY; size.texels()];
        depths
            .par_chunks_mut(width * BAND as usize)
            .zip(owners.par_chunks_mut(width * BAND as usize))
            .zip(bands.par_iter())
            .enumerate()
            .for_each(|(band, ((depths, owners), indices))| {
                let first = band as u32 * BAND;
                let end = (first + BAND).min(size.height);
                for &index in indices {
                    let (face, scan) = &triangles[index];
                    let plane = Plane::new(faces[*face as usize].map(|v| projected[v as usize]));
                    for row in scan.rows().start.max(first)..scan.rows().end.min(end) {
                        for column in scan.span(row) {
                            let depth = plane.depth(column, row);
                            let sample = (row - first) as usize * width + column as usize;
                            if depth > depths[sample] {
                                depths[sample] = depth;
                                owners[sample] = *face;
                            }
                        }
                    }
                }
            });
        Self { size, depths, faces: owners }
    }

    pub fn face(&self, x: u32, y: u32) -> u32 {
        self.faces[(y * self.size.width + x) as usize]
    }

    /// Depth at a sample; nothing is infinitely far away. Clamped to the edge.
    pub fn depth(&self, x: i32, y: i32) -> f32 {
        let x = x.clamp(0, self.size.width as i32 - 1) as usize;
        let y = y.clamp(0, self.size.height as i32 - 1) as usize;
        self.depths[y * self.size.width as usize + x]
    }

    /// For each pixel of a coarser picture of the same view, how open its surroundings are: 1 where
    /// nothing is in front, towards 0 in folds.
    pub fn occlusion(&self, unit_per_px: f32, size: Size) -> Vec<f32> {
        const TAPS: usize = 14;
        let scale = (self.size.width / size.width) as i32;
        let mut open = vec![1.0; size.texels()];
        open.par_chunks_mut(size.width as usize).enumerate().for_each(|(y, row)| {
            for (x, open) in row.iter_mut().enumerate() {
                let (cx, cy) = (x as i32 * scale, y as i32 * scale);
                let here = self.depth(cx, cy);
                if here == f32::NEG_INFINITY {
                    continue;
                }
                let turn = random((x % 4) as i32, (y % 4) as i32, 0, 101) * TAU;
                let mut hidden = 0.0;
                for tap in 0..TAPS {
                    let angle = turn + tap as f32 * 2.4;
                    // From a few millimetres to a few centimetres.
                    let reach = 0.004 + 0.05 * ((tap as f32 + 0.5) / TAPS as f32).powi(2);
                    let steps = reach / unit_per_px;
                    let depth = self.depth(
                        cx + (angle.cos() * steps) as i32,
                        cy + (angle.sin() * steps) as i32,
                    );
                    let rise = (depth - here) / reach;
                    // What is far in front casts no such shade.
                    hidden += smoothstep(0.15, 1.3, rise) * smoothstep(4.0, 2.0, rise);
                }
                *open = 1.0 - hidden / TAPS as f32;
            }
        });
        self.smoothed(&open, scale, size)
    }

    /// Evens out the pattern that the turned taps leave, which repeats every 4 × 4 pixels.
    fn smoothed(&self, open: &[f32], scale: i32, size: Size) -> Vec<f32> {
        const NEAR: f32 = 0.008;
        let mut result = vec![1.0; size.texels()];
        result.par_chunks_mut(size.width as usize).enumerate().for_each(|(y, row)| {
            for (x, result) in row.iter_mut().enumerate() {
                let here = self.depth(x as i32 * scale, y as i32 * scale);
                if here == f32::NEG_INFINITY {
                    continue;
                }
                let (mut sum, mut count) = (0.0, 0.0);
                for py in (y as i32 - 2).max(0)..(y as i32 + 2).min(size.height as i32) {
                    for px in (x as i32 - 2).max(0)..(x as i32 + 2).min(size.width as i32) {
                        if (self.depth(px * scale, py * scale) - here).abs() < NEAR {
                            sum += open[py as usize * size.width as usize + px as usize];
                            count += 1.0;
                        }
                    }
                }
                *result = sum / f32::max(count, 1.0);
            }
        });
        result
    }
}

/// Depth as an affine function of the sample.
struct Plane {
    origin: Vec3,
    slope: [f32; 2],
}

impl Plane {
    fn new([a, b, c]: [Vec3; 3]) -> Self {
        let (ab, ac) = (b - a, c - a);
        let area = ab.x * ac.y - ab.y * ac.x;
        let slope = [(ab.z * ac.y - ac.z * ab.y) / area, (ac.z * ab.x - ab.z * ac.x) / area];
        Self { origin: a, slope }
    }

    fn depth(&self, x: u32, y: u32) -> f32 {
        let (dx, dy) = (x as f32 + 0.5 - self.origin.x, y as f32 + 0.5 - self.origin.y);
        self.origin.z + dx * self.slope[0] + dy * self.slope[1]
    }
}
