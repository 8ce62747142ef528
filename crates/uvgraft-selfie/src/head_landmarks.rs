//! The landmarks of photographs on a head's mesh: the head is drawn from several sides, a network
//! finds landmarks in the pictures, and these are cast back onto the mesh.
//!
//! The network was made for photographs, so the drawing need not look like one, but has what it
//! looks for: lips and brows of another tone, dark irises, and shading.

use glam::{DMat3, DVec3};
use uvgraft::surface_index::{SurfaceIndex, SurfacePoint};
use uvgraft::threads::map_indices;
use uvgraft::{Anatomy, Area, Channels, Depth, Encoding, Mesh, Size, Texels, Texture};

use crate::camera::Camera;
use crate::components::Components;
use crate::depth_map::{DepthMap, NOTHING};
use crate::head::LandmarkDetector;
use crate::landmarks::regions::{FACE_OVAL, LEFT_BROW, LIPS_INNER, LIPS_OUTER, RIGHT_BROW};
use crate::normals::normals;

/// Sides of the head that are drawn: turned to the left and up, in degrees.
const SIDES: [[f64; 2]; 9] = [
    [-45.0, 0.0],
    [-30.0, 0.0],
    [-15.0, 0.0],
    [0.0, 0.0],
    [15.0, 0.0],
    [30.0, 0.0],
    [45.0, 0.0],
    [0.0, 12.0],
    [0.0, -12.0],
];

/// Width and height of a drawing.
const SIZE: Size = Size::square(640);

/// Distance of the camera from the eyes, and focal length as a share of the drawing's side: a head
/// is about 4.5 eye distances high, and fills two thirds.
const DISTANCE: f64 = 16.0;
const FOCAL: f64 = 2.1;

/// A landmark on the head's mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadLandmark {
    /// Its place.
    pub at: SurfacePoint,
    /// How sure the place is, from 0 to 1.
    pub certainty: f64,
}

/// Why landmarks were not found on a mesh.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum HeadLandmarkError {
    /// In too few of the drawings.
    #[error(
        "no face was found in drawings of the head: must be in at least {needed} of {drawn}, was in \
         {found}"
    )]
    NotFound {
        /// Number of drawings with a face.
        found: usize,
        /// Number of drawings.
        drawn: usize,
        /// Number that are needed.
        needed: usize,
    },
}

/// Landmarks that say less about the surface. Brows are where a person has them, wherever they are
/// drawn on the head; and the edge of the face is where the surface turns away, which is another
/// place from every side.
const LESS_CERTAIN: [(&[usize], f64); 3] =
    [(&LEFT_BROW, 0.05), (&RIGHT_BROW, 0.05), (&FACE_OVAL, 0.4)];

/// Landmarks with the inner edges of the lips, which touch in a closed mouth, a share of the way
/// towards the outer edges: the surface of which lip they belong to must not depend on a hair's
/// breadth.
pub(crate) fn steadied(landmarks: &[DVec3]) -> Vec<DVec3> {
    const SHARE: f64 = 0.35;
    let mut steady = landmarks.to_vec();
    for (inner, outer) in LIPS_INNER.into_iter().zip(LIPS_OUTER) {
        if let (Some(&from), Some(&to)) = (landmarks.get(inner), landmarks.get(outer)) {
            steady[inner] = from + (to - from) * SHARE;
        }
    }
    steady
}

/// How sure a landmark is whose places on the drawings differ, and whose mean is off the surface;
/// both in eye distances.
fn certainty(spread: f64, off_surface: f64) -> f64 {
    let fade = |value: f64, full: f64, none: f64| ((none - value) / (none - full)).clamp(0.0, 1.0);
    fade(spread, 0.04, 0.15) * fade(off_surface, 0.04, 0.15)
}

/// A landmark cast onto the mesh from one side, and its weight.
type Cast = Option<(DVec3, f64)>;

/// For each landmark the weighted mean of its places, their total weight and spread.
fn means(sides: &[Vec<Cast>], count: usize) -> Vec<(DVec3, f64, f64)> {
    let of_landmark = |index: usize| {
        let casts = || sides.iter().filter_map(|side| side[index]);
        let total: f64 = casts().map(|(_, weight)| weight).sum();
        if total <= 0.0 {
            return (DVec3::ZERO, 0.0, 0.0);
        }
        let mean = casts().map(|(point, weight)| point * weight).sum::<DVec3>() / total;
        let squares = casts().map(|(point, weight)| point.distance_squared(mean) * weight);
        (mean, total, (squares.sum::<f64>() / total).sqrt())
    };
    (0..count).map(of_landmark).collect()
}

/// What is drawn of a head.
pub(crate) struct Drawing<'a> {
    mesh: &'a Mesh,
    texture: Option<&'a Texture>,
    anatomy: &'a Anatomy,
    components: &'a Components,
    colors: Vec<[f32; 3]>,
    normals: Vec<DVec3>,
}

impl<'a> Drawing<'a> {
    /// - `texture`: in the mesh's layout, as [`plain`]; without one, parts of the face are told apart
    ///   by colours.
    pub fn new(
        mesh: &'a Mesh,
        anatomy: &'a Anatomy,
        components: &'a Components,
        texture: Option<&'a Texture>,
    ) -> Self {
        Self {
            mesh,
            texture,
            anatomy,
            components,
            colors: colors(mesh, anatomy, components),
            normals: normals(mesh.positions(), mesh.faces()),
        }
    }

    /// Finds the landmarks of photographs on the mesh.
    ///
    /// - `mates`: for each landmark, that of the other side of the face; itself on the midline.
    /// - `detect`: finds the landmarks in a picture, `[x, y, z]` in pixels each; as many as `mates`.
    pub fn landmarks(
        &self,
        mates: &[usize],
        detect: &LandmarkDetector,
    ) -> Result<Vec<HeadLandmark>, HeadLandmarkError> {
        const NEEDED: usize = 3;
        let found: Vec<Vec<Cast>> = map_indices(SIDES.len(), |side| {
            let (picture, camera, depths) = self.at_side(SIDES[side]);
            let landmarks = detect(&picture).filter(|found| found.len() == mates.len())?;
            let landmarks: Vec<DVec3> = landmarks.into_iter().map(DVec3::from).collect();
            Some(self.cast(&camera, &depths, &steadied(&landmarks)))
        })
        .into_iter()
        .flatten()
        .collect();
        if found.len() < NEEDED {
            let (found, drawn) = (found.len(), SIDES.len());
            return Err(HeadLandmarkError::NotFound { found, drawn, needed: NEEDED });
        }
        let means = means(&found, mates.len());
        let frame = self.anatomy.frame();
        let mirrored = |point: DVec3| {
            let [x, y, z] = frame.local(point.to_array());
            DVec3::from(frame.world([-x, y, z]))
        };
        let index = SurfaceIndex::new(self.mesh);
        let on_skin = |face: u32, _: [f64; 3]| self.is_skin(face);
        let landmarks = means.iter().zip(mates).map(|(&(point, weight, spread), &mate)| {
            // Both sides together are twice as sure, and neither is drawn to one side.
            let (of_mate, mate_weight, mate_spread) = means[mate];
            let total = (weight + mate_weight).max(f64::MIN_POSITIVE);
            let point = (point * weight + mirrored(of_mate) * mate_weight) / total;
            let spread = (spread * weight + mate_spread * mate_weight) / total / frame.unit;
            let reach = 0.5 * frame.unit;
            let (at, distance) = index
                .nearest(point.to_array(), reach, on_skin)
                .filter(|_| total > 1e-9)
                .unwrap_or((SurfacePoint { face: 0, weights: [1.0, 0.0, 0.0] }, f64::INFINITY));
            HeadLandmark { at, certainty: certainty(spread, distance / frame.unit) }
        });
        let mut landmarks: Vec<HeadLandmark> = landmarks.collect();
        for (indices, share) in LESS_CERTAIN {
            for &index in indices {
                if let Some(landmark) = landmarks.get_mut(index) {
                    landmark.certainty *= share;
                }
            }
        }
        Ok(landmarks)
    }

    fn is_skin(&self, face: u32) -> bool {
        let vertex = self.mesh.faces()[face as usize][0];
        self.components.of_vertex[vertex as usize] == self.components.skin
    }

    fn at_side(&self, [yaw, pitch]: [f64; 2]) -> (Texture, Camera, DepthMap) {
        let frame = self.anatomy.frame();
        let [left, up, forward] = frame.axes.map(DVec3::from);
        // Looking at the face, the person's left is to the right.
        let front = DMat3::from_cols(left, -up, -forward).transpose();
        let turn =
            DMat3::from_rotation_x(pitch.to_radians()) * DMat3::from_rotation_y(yaw.to_radians());
        let rotation = turn * front;
        // Half an eye distance below the eyes is the middle of the face.
        let center = DVec3::from(frame.world([0.0, -0.5, 0.0]));
        let away = DVec3::new(0.0, 0.0, DISTANCE * frame.unit);
        let [width, height] = [SIZE.width, SIZE.height].map(f64::from);
        let camera = Camera {
            rotation,
            translation: away - rotation * center,
            focal_px: FOCAL * width,
            center_px: [width / 2.0, height / 2.0],
        };
        let (picture, depths) = self.drawn(&camera);
        (picture, camera, depths)
    }

    /// The head as a camera sees it.
    fn drawn(&self, camera: &Camera) -> (Texture, DepthMap) {
        let project = |position: &[f32; 3]| camera.project(glam::Vec3::from(*position).as_dvec3());
        let projected: Vec<[f64; 3]> = self.mesh.positions().iter().map(project).collect();
        let depths = DepthMap::new(SIZE, &projected, self.mesh.faces());
        let texels = map_indices(SIZE.texels(), |at| {
            let (x, y) = (at as i64 % i64::from(SIZE.width), at as i64 / i64::from(SIZE.width));
            self.shade(camera, &depths, x, y)
        });
        let texels = Texels::U8(texels.into_flattened());
        let picture = Texture::new(SIZE, Channels::Rgb, Encoding::Srgb, texels);
        (picture.expect("the size is fixed"), depths)
    }

    /// The landmarks as they are found from a camera's side, in its perspective.
    ///
    /// - `known`: from all sides; they stay where the drawing shows none.
    pub fn seen_by(
        &self,
        camera: &Camera,
        known: &[HeadLandmark],
        detect: &LandmarkDetector,
    ) -> Option<Vec<HeadLandmark>> {
        /// The weight of a landmark that is only known from other sides.
        const UNSEEN: f64 = 0.2;
        let frame = self.anatomy.frame();
        let center = DVec3::from(frame.world([0.0, -0.5, 0.0]));
        let [x, y, depth] = camera.project(center);
        if depth.is_nan() || depth <= 0.0 {
            return None;
        }
        // The same picture, enlarged and moved so that the head fills it.
        let [width, height] = [SIZE.width, SIZE.height].map(f64::from);
        let zoom = FOCAL * width / DISTANCE / (camera.scale(depth) * frame.unit);
        let zoomed = Camera {
            focal_px: camera.focal_px * zoom,
            center_px: [
                width / 2.0 + (camera.center_px[0] - x) * zoom,
                height / 2.0 + (camera.center_px[1] - y) * zoom,
            ],
            ..*camera
        };
        let (picture, depths) = self.drawn(&zoomed);
        let found = detect(&picture).filter(|found| found.len() == known.len())?;
        let found: Vec<DVec3> = found.into_iter().map(DVec3::from).collect();
        let casts = self.cast(&zoomed, &depths, &steadied(&found));
        let index = SurfaceIndex::new(self.mesh);
        let landmarks = casts.into_iter().zip(known).enumerate().map(|(at, (cast, known))| {
            // Which of two lips that touch a single drawing hits is a matter of luck.
            if LIPS_INNER.contains(&at) {
                return *known;
            }
            let unseen = HeadLandmark { certainty: known.certainty * UNSEEN, ..*known };
            let Some((point, weight)) = cast.filter(|(_, weight)| *weight > 1e-4) else {
                return unseen;
            };
            let on_skin = |face: u32, _: [f64; 3]| self.is_skin(face);
            match index.nearest(point.to_array(), 0.2 * frame.unit, on_skin) {
                Some((at, _)) => {
                    let certainty = known.certainty * (0.3 + 0.7 * weight.min(1.0));
                    HeadLandmark { at, certainty }
                }
                None => unseen,
            }
        });
        Some(landmarks.collect())
    }

    /// The place of the mesh at a pixel.
    fn place(
        &self,
        camera: &Camera,
        depths: &DepthMap,
        [px, py]: [f64; 2],
    ) -> Option<SurfacePoint> {
        let (x, y) = (px.floor() as i64, py.floor() as i64);
        let face = depths.face(x, y);
        if face == NOTHING {
            return None;
        }
        let point = camera.unproject([px, py], f64::from(depths.depth(x, y)));
        let corners = self.mesh.faces()[face as usize]
            .map(|vertex| glam::Vec3::from(self.mesh.positions()[vertex as usize]).as_dvec3());
        Some(SurfacePoint { face, weights: barycentric(corners, point) })
    }

    fn shade(&self, camera: &Camera, depths: &DepthMap, x: i64, y: i64) -> [u8; 3] {
        const BACKGROUND: [u8; 3] = [200, 205, 210];
        let Some(at) = self.place(camera, depths, [x as f64 + 0.5, y as f64 + 0.5]) else {
            return BACKGROUND;
        };
        let corners = self.mesh.faces()[at.face as usize].map(|vertex| vertex as usize);
        let normal: DVec3 = (0..3).map(|k| self.normals[corners[k]] * at.weights[k]).sum();
        // From above and in front, so that neither side looks different.
        let light = DVec3::new(0.0, -0.42, -0.9075);
        let facing = (camera.rotation * normal.normalize_or_zero()).dot(light).max(0.0);
        let light = 0.4 + 0.6 * facing;
        self.color(&at).map(|value| (255.0 * f64::from(value) * light).clamp(0.0, 255.0) as u8)
    }

    /// The colour of a place.
    fn color(&self, at: &SurfacePoint) -> [f32; 3] {
        if let Some(texture) = self.texture {
            let uv = self.mesh.uv_triangle(at.face as usize);
            let uv: [f32; 2] = std::array::from_fn(|axis| {
                (0..3).map(|k| at.weights[k] as f32 * uv[k][axis]).sum()
            });
            return nearest_four(texture, uv);
        }
        let corners = self.mesh.faces()[at.face as usize].map(|vertex| vertex as usize);
        std::array::from_fn(|channel| {
            (0..3).map(|k| self.colors[corners[k]][channel] * at.weights[k] as f32).sum()
        })
    }

    /// Casts landmarks onto the mesh.
    fn cast(&self, camera: &Camera, depths: &DepthMap, landmarks: &[DVec3]) -> Vec<Cast> {
        let eye = camera.eye();
        let cast = |&DVec3 { x, y, .. }: &DVec3| {
            let at = self.place(camera, depths, [x, y])?;
            let corners = self.mesh.faces()[at.face as usize].map(|vertex| vertex as usize);
            let normal: DVec3 = (0..3).map(|k| self.normals[corners[k]] * at.weights[k]).sum();
            let position =
                |vertex: usize| glam::Vec3::from(self.mesh.positions()[vertex]).as_dvec3();
            let point: DVec3 = (0..3).map(|k| position(corners[k]) * at.weights[k]).sum();
            let facing = (eye - point).normalize().dot(normal.normalize_or_zero());
            // Landmarks of the lids that fell onto the ball behind say little.
            let weight = if self.is_skin(at.face) { 1.0 } else { 1e-3 };
            Some((point, weight * facing.max(0.0).powi(3)))
        };
        landmarks.iter().map(cast).collect()
    }
}

/// Weights of a triangle's corners at the point of its plane nearest to `point`, kept inside.
fn barycentric([a, b, c]: [DVec3; 3], point: DVec3) -> [f64; 3] {
    let normal = (b - a).cross(c - a);
    let area = normal.length_squared().max(f64::MIN_POSITIVE);
    let second = ((point - a).cross(c - a).dot(normal) / area).clamp(0.0, 1.0);
    let third = ((b - a).cross(point - a).dot(normal) / area).clamp(0.0, 1.0 - second);
    [1.0 - second - third, second, third]
}

/// A texture as drawings read it: RGB, 8-bit sRGB.
pub(crate) fn plain(texture: &Texture) -> Texture {
    texture.clone().encoded_as(Encoding::Srgb).converted(Channels::Rgb, Depth::U8)
}

/// The bilinear mean of the texels around a UV coordinate.
fn nearest_four(texture: &Texture, uv: [f32; 2]) -> [f32; 3] {
    let size = texture.size();
    let (x, y) = (uv[0] * size.width as f32 - 0.5, uv[1] * size.height as f32 - 0.5);
    let (left, top) = (x.floor(), y.floor());
    let (fx, fy) = (x - left, y - top);
    let at = |dx: f32, dy: f32, channel: usize| {
        let x = (left + dx).clamp(0.0, (size.width - 1) as f32) as u32;
        let y = (top + dy).clamp(0.0, (size.height - 1) as f32) as u32;
        texture.get(x, y, channel)
    };
    std::array::from_fn(|k| {
        let above = at(0.0, 0.0, k) * (1.0 - fx) + at(1.0, 0.0, k) * fx;
        let below = at(0.0, 1.0, k) * (1.0 - fx) + at(1.0, 1.0, k) * fx;
        above * (1.0 - fy) + below * fy
    })
}

/// The colour of each vertex.
fn colors(mesh: &Mesh, anatomy: &Anatomy, components: &Components) -> Vec<[f32; 3]> {
    const SKIN: [f32; 3] = [0.86, 0.67, 0.56];
    const AREAS: [(Area, [f32; 3], f32); 5] = [
        (Area::Lips, [0.66, 0.36, 0.34], 1.0),
        (Area::Brows, [0.34, 0.24, 0.18], 0.8),
        (Area::Scalp, [0.33, 0.24, 0.18], 1.0),
        (Area::MouthInterior, [0.3, 0.12, 0.12], 1.0),
        (Area::Eyes, [0.82, 0.8, 0.78], 1.0),
    ];
    let mut colors = vec![SKIN; mesh.positions().len()];
    for (area, color, strength) in AREAS {
        for (mixed, &weight) in colors.iter_mut().zip(anatomy.area(area)) {
            let weight = weight * strength;
            for k in 0..3 {
                mixed[k] += (color[k] - mixed[k]) * weight;
            }
        }
    }
    let forward = DVec3::from(anatomy.frame().axes[2]);
    for ball in &components.eyeballs {
        for &vertex in &ball.vertices {
            let position = glam::Vec3::from(mesh.positions()[vertex as usize]).as_dvec3();
            let ahead = (position - ball.center).normalize_or_zero().dot(forward);
            // An iris is half as wide as its eyeball.
            colors[vertex as usize] = match ahead {
                ahead if ahead > 0.975 => [0.05, 0.04, 0.04],
                ahead if ahead > 0.88 => [0.3, 0.2, 0.14],
                _ => [0.88, 0.86, 0.84],
            };
        }
    }
    colors
}
