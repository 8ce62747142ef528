//! Drawings of a head, in which networks find landmarks.
//!
//! The networks were made for photographs, so a drawing need not look like one, but has what they
//! look for: lips and brows of another tone, dark irises, and shading. Where landmarks are to be
//! compared with those of a photograph, it has the photograph's light and background, and what covers
//! the face there, too: networks put landmarks at places that depend on all of these.

use glam::DVec3;
use uvgraft::color::{linear_from_srgb, srgb_from_linear};
use uvgraft::statistics::median;
use uvgraft::surface_index::{SurfaceIndex, SurfacePoint};
use uvgraft::threads::map_indices;
use uvgraft::{Anatomy, Area, Channels, Depth, Encoding, Mesh, Size, Texels, Texture};

use crate::camera::Camera;
use crate::components::Components;
use crate::depth_map::{DepthMap, NOTHING};
use crate::light::{Irradiance, Reflection};
use crate::normals::normals;
use crate::pixels;

/// Width and height of a drawing.
pub(crate) const SIZE: Size = Size::square(640);

/// A head that is drawn.
pub(crate) struct Drawing<'a> {
    mesh: &'a Mesh,
    texture: Option<&'a Texture>,
    anatomy: &'a Anatomy,
    components: &'a Components,
    colors: Vec<[f32; 3]>,
    normals: Vec<DVec3>,
    index: SurfaceIndex,
}

/// A head as a camera sees it.
pub(crate) struct View<'a> {
    drawing: &'a Drawing<'a>,
    camera: Camera,
    depths: DepthMap,
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
            index: SurfaceIndex::new(mesh),
        }
    }

    pub const fn mesh(&self) -> &Mesh {
        self.mesh
    }

    pub const fn anatomy(&self) -> &Anatomy {
        self.anatomy
    }

    /// The head as a camera sees it in an image of [`SIZE`].
    pub fn seen_by(&self, camera: Camera) -> View<'_> {
        let project = |position: &[f32; 3]| camera.project(glam::Vec3::from(*position).as_dvec3());
        let projected: Vec<[f64; 3]> = self.mesh.positions().iter().map(project).collect();
        let depths = DepthMap::new(SIZE, &projected, self.mesh.faces());
        View { drawing: self, camera, depths }
    }

    /// The place of the skin nearest to a point within reach, and its distance.
    pub fn nearest(&self, point: DVec3, reach: f64) -> Option<(SurfacePoint, f64)> {
        self.index.nearest(point.to_array(), reach, |face, _| self.is_skin(face))
    }

    /// Whether a triangle belongs to the skin, not to eyes or teeth.
    pub fn is_skin(&self, face: u32) -> bool {
        let vertex = self.mesh.faces()[face as usize][0];
        self.components.of_vertex[vertex as usize] == self.components.skin
    }

    /// Whether a place belongs to an area of plain skin.
    fn is_in(&self, areas: &[Area], at: &SurfacePoint) -> bool {
        let vertex = self.mesh.faces()[at.face as usize][0] as usize;
        self.is_skin(at.face)
            && areas.iter().map(|&area| self.anatomy.area(area)[vertex]).sum::<f32>() > 0.5
    }

    pub fn normal(&self, at: &SurfacePoint) -> DVec3 {
        let corners = self.mesh.faces()[at.face as usize].map(|vertex| vertex as usize);
        let normal: DVec3 = (0..3).map(|k| self.normals[corners[k]] * at.weights[k]).sum();
        normal.normalize_or_zero()
    }

    /// The colour of a place, sRGB with 1.0 for white.
    fn color(&self, at: &SurfacePoint) -> [f32; 3] {
        if let Some(texture) = self.texture {
            let uv = self.mesh.uv_triangle(at.face as usize);
            let sides = [texture.size().width, texture.size().height];
            let at_px = std::array::from_fn(|axis| {
                let uv = (0..3).map(|k| at.weights[k] * f64::from(uv[k][axis])).sum::<f64>();
                uv * f64::from(sides[axis])
            });
            return pixels::color(texture, at_px);
        }
        let corners = self.mesh.faces()[at.face as usize].map(|vertex| vertex as usize);
        std::array::from_fn(|channel| {
            (0..3).map(|k| self.colors[corners[k]][channel] * at.weights[k] as f32).sum()
        })
    }
}

impl View<'_> {
    pub const fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The place of the mesh at a position in pixels.
    pub fn place(&self, [px, py]: [f64; 2]) -> Option<SurfacePoint> {
        let (x, y) = (px.floor() as i64, py.floor() as i64);
        let face = self.depths.face(x, y);
        if face == NOTHING {
            return None;
        }
        let point = self.camera.unproject([px, py], f64::from(self.depths.depth(x, y)));
        let mesh = self.drawing.mesh;
        let corners = mesh.faces()[face as usize]
            .map(|vertex| glam::Vec3::from(mesh.positions()[vertex as usize]).as_dvec3());
        Some(SurfacePoint { face, weights: barycentric(corners, point) })
    }

    /// Draws the head in light from above and in front, so that neither side looks different.
    pub fn drawn(&self) -> Texture {
        const BACKGROUND: [f32; 3] = [0.785, 0.805, 0.825];
        const TOWARDS_LIGHT: DVec3 = DVec3::new(0.0, -0.42, -0.9075);
        self.picture(|px| {
            let Some(at) = self.place(px) else { return BACKGROUND };
            let facing = (self.camera.rotation * self.drawing.normal(&at)).dot(TOWARDS_LIGHT);
            let light = (0.4 + 0.6 * facing.max(0.0)) as f32;
            self.drawing.color(&at).map(|value| value * light)
        })
    }

    /// Draws the head as it would look in a photograph.
    ///
    /// - `photo`: the photograph's colours, sRGB with 1.0 for white, at positions of the drawing in
    ///   pixels.
    pub fn drawn_in(&self, photo: impl Fn([f64; 2]) -> [f32; 3] + Sync) -> Texture {
        /// Distances of colours at which something covers the skin: perhaps, and certainly. Origin
        /// not recorded.
        const COVERED: [f32; 2] = [0.25, 0.4];
        let Some(light) = self.light(&photo) else { return self.drawn() };
        self.picture(|px| {
            let Some(at) = self.place(px) else { return photo(px) };
            let albedo = self.drawing.color(&at);
            let light = light.at(self.drawing.normal(&at));
            let lit: [f32; 3] = std::array::from_fn(|k| {
                srgb_from_linear(linear_from_srgb(albedo[k]) * light[k].max(0.0) as f32)
            });
            if !self.drawing.is_in(&PLAIN, &at) {
                return lit;
            }
            let seen = photo(px);
            let distance = (0..3).map(|k| (lit[k] - seen[k]).powi(2)).sum::<f32>().sqrt();
            let covered = ((distance - COVERED[0]) / (COVERED[1] - COVERED[0])).clamp(0.0, 1.0);
            std::array::from_fn(|k| lit[k] + (seen[k] - lit[k]) * covered)
        })
    }

    /// The light in which a photograph shows the head; `None` if it shows too little of it.
    fn light(&self, photo: impl Fn([f64; 2]) -> [f32; 3]) -> Option<Irradiance> {
        /// Distance of the samples, in pixels.
        const STEP: usize = 4;
        /// Least cosine between normal and line of sight: 78°.
        const FACING: f64 = 0.2;
        /// What reflects less than this share of what cheeks, nose and jaw reflect is no skin: hair
        /// that covers all of a forehead would pass for darkness.
        const DARKEST: f64 = 0.3;
        let drawing = self.drawing;
        let mut reflections = Vec::new();
        let mut below_forehead = Vec::new();
        for y in (0..SIZE.height).step_by(STEP) {
            for x in (0..SIZE.width).step_by(STEP) {
                let px = [x, y].map(|at| f64::from(at) + 0.5);
                let at = self.place(px).filter(|at| drawing.is_in(&PLAIN, at));
                let Some(at) = at else { continue };
                let normal = drawing.normal(&at);
                let facing = (self.camera.rotation * normal).dot(DVec3::NEG_Z);
                if facing < FACING {
                    continue;
                }
                let (albedo, seen) = (drawing.color(&at), photo(px));
                let factors = std::array::from_fn(|k| {
                    f64::from(linear_from_srgb(seen[k]) / linear_from_srgb(albedo[k]).max(0.02))
                });
                reflections.push(Reflection { normal, factors, weight: facing });
                if !drawing.is_in(&[Area::Forehead], &at) {
                    below_forehead.push(factors[1]);
                }
            }
        }
        let usual = median(below_forehead)?;
        reflections.retain(|reflection| reflection.factors[1] > DARKEST * usual);
        Irradiance::new(&reflections)
    }

    /// A picture of colours at positions in pixels.
    fn picture(&self, color: impl Fn([f64; 2]) -> [f32; 3] + Sync) -> Texture {
        let width = SIZE.width as usize;
        let texels = map_indices(SIZE.texels(), |index| {
            let color = color([index % width, index / width].map(|at| at as f64 + 0.5));
            color.map(|value| (255.0 * value.clamp(0.0, 1.0) + 0.5) as u8)
        });
        let texels = Texels::U8(texels.into_flattened());
        Texture::new(SIZE, Channels::Rgb, Encoding::Srgb, texels).expect("the size is fixed")
    }
}

/// Where skin has one colour, and covers are told from it.
const PLAIN: [Area; 4] = [Area::Cheeks, Area::Forehead, Area::Nose, Area::Jaw];

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
