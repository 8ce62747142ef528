//! Avatars with mouths, and checks for teeth or walls that come out of a head or show through it.

use std::f32::consts::TAU;

use glam::Vec3;
use uvgraft::{Anatomy, Channels, Depth, Encoding, Landmark, Mesh, Size, Texture};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::body::{BodyModel, Shape};
use uvgraft_avatar::mouth::Mouth;
use uvgraft_avatar::rig::{HumanBone, Morph, Pose};
use uvgraft_figure::Figure;
use uvgraft_gltf::glb::{self, AvatarMaterial, EmbeddedFormat, EmbeddedImage, Export};
use uvgraft_gltf::scene::{PoseRequest, Scene};
use uvgraft_render::{Background, Perspective, RenderOptions, Renderer};

use crate::made_up::{self, Entanglement, MadeUp};

/// An avatar before and after it was given a mouth.
#[derive(Debug, Clone)]
pub struct Subject {
    /// Name in messages.
    pub name: &'static str,
    /// Without the mouth.
    pub before: Avatar,
    /// With the mouth.
    pub after: Avatar,
}

/// An expression: morphs with their weights, and the rotation of the jaw's joint in radians.
#[derive(Debug, Clone, Copy)]
pub struct Face<'a>(pub &'a [(&'a str, f32)], pub f32);

impl Subject {
    /// Gives an avatar a mouth.
    ///
    /// # Panics
    /// If the avatar's lips are closed.
    pub fn new(name: &'static str, before: Avatar) -> Self {
        let mouth = Mouth::fit(&before).unwrap_or_else(|why| panic!("{name}: {why}"));
        let after = mouth.attach(before.clone()).expect("a mesh that is not too large");
        Self { name, before, after }
    }

    /// The figure and, with real data, SMPL-X and FLAME with known movements as morphs.
    ///
    /// # Panics
    /// If a model is invalid.
    pub fn all() -> Vec<Self> {
        let few = Entanglement { components: 20, ..Entanglement::default() };
        let mut all = vec![Self::new("figure", Figure::new().avatar())];
        all.extend(made_up::smplx(&few).map(|made_up| Self::new("SMPL-X", avatar(&made_up))));
        all.extend(made_up::flame(&few).map(|made_up| Self::new("FLAME", avatar(&made_up))));
        all
    }

    /// With real data, SMPL-X and FLAME avatars with solved expressions.
    ///
    /// # Panics
    /// If a model is invalid.
    pub fn expressive() -> Vec<Self> {
        let full = Entanglement::default();
        let models = [("SMPL-X", made_up::smplx(&full)), ("FLAME", made_up::flame(&full))];
        let subject = |(name, made_up): (&'static str, Option<MadeUp>)| {
            let made_up = made_up?;
            let model = BodyModel::from_arrays(&made_up.arrays).expect("a model");
            let shaped = model.shaped(&Shape::default()).expect("the mean shape");
            let mut avatar = shaped.avatar(made_up.mesh).expect("the model's own mesh");
            shaped.add_expressions(&mut avatar).expect("a sound jaw");
            Some(Self::new(name, avatar))
        };
        models.into_iter().filter_map(subject).collect()
    }

    /// Positions of the vertices.
    ///
    /// # Panics
    /// If the pose is invalid.
    pub fn posed(&self, face: Face<'_>) -> Vec<Vec3> {
        let weight = |morph: &Morph| {
            face.0.iter().find(|(name, _)| *name == morph.name).map_or(0.0, |&(_, weight)| weight)
        };
        let weights: Vec<f32> = self.after.morphs.iter().map(weight).collect();
        let joints = self.after.skeleton.joints().len();
        let mut turns = vec![[0.0; 3]; joints];
        if let Some(jaw) = self.after.skeleton.human(HumanBone::Jaw) {
            turns[jaw] = [face.1, 0.0, 0.0];
        }
        let pose = Pose::from_axis_angles([0.0; 3], &turns);
        let posed = self.after.posed(&pose, &weights).expect("a sound pose");
        posed.into_iter().map(Vec3::from).collect()
    }

    /// The mouth's vertices that are outside the head, with their winding numbers: 1 within a
    /// closed surface, 0 outside. The surface is the head's own, with the boundary of the lips
    /// closed by a fan. Teeth are visible through the lips, so vertices slightly in front of the
    /// fan are within the mouth all the same.
    pub fn outside(&self, face: Face<'_>) -> Vec<(usize, f32)> {
        let places = self.posed(face);
        let own = self.before.mesh.positions().len();
        let is_new = |face: &[u32; 3]| face.iter().any(|&vertex| vertex as usize >= own);
        let faces = || self.after.mesh.faces().iter();
        let mut surface: Vec<[Vec3; 3]> = faces()
            .filter(|face| !is_new(face))
            .map(|face| face.map(|vertex| places[vertex as usize]))
            .collect();
        let rim: Vec<[Vec3; 2]> = faces()
            .filter(|face| is_new(face))
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .filter(|edge| edge.iter().all(|&vertex| (vertex as usize) < own))
            .map(|edge| edge.map(|vertex| places[vertex as usize]))
            .collect();
        let centre = rim.iter().map(|edge| edge[0]).sum::<Vec3>() / rim.len().max(1) as f32;
        let fan: Vec<[Vec3; 3]> = rim.into_iter().map(|[a, b]| [a, b, centre]).collect();
        surface.extend_from_slice(&fan);
        // Distant triangles subtend small solid angles at the mouth.
        surface.retain(|corners| corners[0].distance(centre) < HEAD_M);
        let is_in_opening =
            |place: Vec3| fan.iter().any(|corners| distance(place, corners) < OPENING_M);
        (own..places.len())
            .step_by(STRIDE)
            .map(|vertex| (vertex, winding(&surface, places[vertex])))
            .filter(|&(vertex, winding)| winding < 0.5 && !is_in_opening(places[vertex]))
            .collect()
    }

    /// Number of pixels, in pictures of the mouth from 24 directions, that show the background
    /// through the head: only back faces cover them.
    ///
    /// # Panics
    /// If the avatar cannot be rendered.
    pub fn seen_through(avatar: &Avatar, faces: &[Face<'_>]) -> usize {
        let scenes = [false, true].map(|double_sided| scene(avatar, double_sided));
        let renderers = [Renderer::for_scene(&scenes[0]), Renderer::for_scene(&scenes[1])];
        let anatomy = Anatomy::find(&avatar.mesh).expect("a head");
        let mouth = anatomy.point(Landmark::Mouth).expect("a mouth");
        let target = mouth.map(|value| value as f32);
        let options = RenderOptions {
            lit: false,
            background: Background::Plain([255, 0, 255]),
            samples: 2,
            ..RenderOptions::default()
        };
        let mut pixels = 0;
        for face in faces {
            let posing = PoseRequest {
                weights: face.0.iter().map(|&(name, weight)| (name.to_owned(), weight)).collect(),
                rotations: vec![("jaw".to_owned(), [face.1.to_degrees(), 0.0, 0.0])],
                ..PoseRequest::default()
            };
            let drawn = [0, 1].map(|k: usize| scenes[k].pose(&posing).expect("a sound pose"));
            for view in 0..24 {
                let camera = camera(target, view);
                let pictures = [0, 1].map(|k: usize| {
                    renderers[k].render(&drawn[k], &camera, &options, Size::square(120))
                });
                pixels += differing(&pictures);
            }
        }
        pixels
    }
}

/// Eight directions from ear to ear, each from below, level and from above. Farther behind,
/// shoulders and sleeves are in the way.
fn camera(target: [f32; 3], view: u16) -> Perspective {
    let azimuth = (f32::from(view % 8) - 3.5) * 24.0_f32.to_radians();
    let elevation = (f32::from(view / 8) - 1.0) * 28.0_f32.to_radians();
    let distance = 0.6;
    let eye = [
        target[0] + distance * elevation.cos() * azimuth.sin(),
        target[1] + distance * elevation.sin(),
        target[2] + distance * elevation.cos() * azimuth.cos(),
    ];
    Perspective { eye, target, up: [0.0, 1.0, 0.0], fov_y: 8.0, near: 0.05, far: 5.0 }
}

fn scene(avatar: &Avatar, double_sided: bool) -> Scene {
    let grey =
        Texture::filled(Size::square(4), Channels::Rgb, Encoding::Srgb, Depth::U8, &[0.5; 3]);
    let picture = EmbeddedImage::encode(grey.expect("a small texture"), EmbeddedFormat::Png, 90);
    let looks = AvatarMaterial { double_sided, ..AvatarMaterial::new(picture.expect("a picture")) };
    let file = glb::write(avatar, &looks, &Export::default()).expect("a sound avatar");
    Scene::read(&file.bytes).expect("a file of ours")
}

/// Pixels that are pure background in the first picture and pure surface in the second.
fn differing([single, double]: &[Texture; 2]) -> usize {
    let Size { width, height } = single.size();
    let is_background = |picture: &Texture, x, y| {
        picture.get(x, y, 0) > 0.95 && picture.get(x, y, 1) < 0.05 && picture.get(x, y, 2) > 0.95
    };
    let is_grey =
        |picture: &Texture, x, y| (picture.get(x, y, 0) - picture.get(x, y, 1)).abs() < 0.02;
    (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .filter(|&(x, y)| is_background(single, x, y) && is_grey(double, x, y))
        .count()
}

fn avatar(made_up: &MadeUp) -> Avatar {
    let model = BodyModel::from_arrays(&made_up.arrays).expect("a model");
    let shaped = model.shaped(&Shape::default()).expect("the mean shape");
    let mesh: Mesh = made_up.mesh.clone();
    let mut avatar = shaped.avatar(mesh).expect("the model's own mesh");
    avatar.morphs = shaped.components(0).expect("a jaw");
    for truth in &made_up.truths {
        avatar.morphs.push(Morph::from_dense(truth.name, &truth.offsets));
    }
    avatar
}

/// Distance from the mouth within which triangles belong to the head, and the stride at which the
/// mouth's vertices are checked.
const HEAD_M: f32 = 0.25;
const STRIDE: usize = 3;

/// Teeth may be this far in front of the lips' boundary; lips are thicker.
const OPENING_M: f32 = 0.004;

/// Distance of a point from a triangle: from its plane if the projection is inside, else from its
/// nearest edge.
fn distance(place: Vec3, &[a, b, c]: &[Vec3; 3]) -> f32 {
    let normal = (b - a).cross(c - a);
    let inside = |from: Vec3, to: Vec3| (to - from).cross(place - from).dot(normal) >= 0.0;
    if inside(a, b) && inside(b, c) && inside(c, a) && normal.length() > 0.0 {
        return (place - a).dot(normal.normalize()).abs();
    }
    let to_edge = |from: Vec3, to: Vec3| {
        let along = (place - from).dot(to - from) / (to - from).length_squared().max(1e-20);
        place.distance(from.lerp(to, along.clamp(0.0, 1.0)))
    };
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}

/// The generalised winding number of a surface around a point: the sum of the triangles' solid
/// angles over 4π.
///
/// Based on Jacobson et al., "Robust Inside-Outside Segmentation using Generalized Winding
/// Numbers", 2013, with the solid angle after Van Oosterom and Strackee, 1983.
fn winding(surface: &[[Vec3; 3]], place: Vec3) -> f32 {
    let angle = |corners: &[Vec3; 3]| {
        let [a, b, c] = corners.map(|corner| corner - place);
        let [x, y, z] = [a.length(), b.length(), c.length()];
        let over = a.dot(b.cross(c));
        let under = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
        2.0 * over.atan2(under)
    };
    surface.iter().map(angle).sum::<f32>() / (2.0 * TAU)
}
