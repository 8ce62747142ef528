//! A painted skin in the body's own layout: of any tone, with lips, nails, brows, eyes, and shorts
//! and a top.
//!
//! Colours are functions of the point in space at rest, so the borders of UV islands don't show.

mod clothes;
mod eyes;
mod face;
mod nails;
mod tone;

use glam::Vec3;
use uvgraft::{Mesh, Size, Texture};
use uvgraft_avatar::body::Shaped;
use uvgraft_avatar::paint::bake::{Spot, bake};
use uvgraft_avatar::paint::texel::{Color, blend};

use clothes::Clothes;
use eyes::Eye;
use face::Face;
use nails::Nails;
pub use tone::SkinTone;

/// Centimetres in a metre.
const CM: f32 = 100.0;

/// What to paint.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SkinOptions {
    /// Colour of the skin.
    pub tone: SkinTone,
    /// Colour of the hair painted on the scalp, in sRGB; none for a bald head.
    pub hair: Option<[f32; 3]>,
    /// Colour of the brows and lashes, in sRGB.
    pub brows: [f32; 3],
    /// Colour of the irises, in sRGB.
    pub iris: [f32; 3],
    /// Colours of the top and the shorts, in sRGB.
    pub clothes: [[f32; 3]; 2],
}

impl SkinOptions {
    /// Brows, irises and clothes that suit most tones, and no hair.
    pub const fn new(tone: SkinTone) -> Self {
        Self {
            tone,
            hair: None,
            brows: [0.16, 0.11, 0.085],
            iris: [0.36, 0.24, 0.14],
            clothes: [[0.36, 0.42, 0.50], [0.20, 0.23, 0.28]],
        }
    }
}

/// The parts of the body that are painted differently.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Skin,
    /// Inside the mouth, or behind the lids.
    Inside,
    Eye(usize),
    Teeth,
    Tongue,
    Lashes,
}

impl Part {
    fn named(name: &str) -> Self {
        match name {
            "left_eye" => Self::Eye(0),
            "right_eye" => Self::Eye(1),
            "upper_teeth" | "lower_teeth" => Self::Teeth,
            "tongue" => Self::Tongue,
            "left_lashes" | "right_lashes" => Self::Lashes,
            _ => Self::Skin,
        }
    }
}

/// Paints the skin of the open body.
///
/// - `mesh`: as read from the model file, in its own layout, with the parts of its groups.
/// - `body`: the body at rest, with as many vertices.
///
/// # Panics
/// If `mesh` has another number of vertices than `body`.
pub fn paint_skin(mesh: &Mesh, body: &Shaped<'_>, size: Size, options: &SkinOptions) -> Texture {
    assert_eq!(mesh.positions().len(), body.positions().len(), "a mesh of the body");
    let joint = |at: usize| Vec3::from(body.skeleton().joints()[at].position) * CM;
    let mut parts = parts(mesh);
    let (face, nails) = (Face::new(&joint, options), Nails::new(body));
    let clothes = Clothes::new(&joint, options);
    mark_inside(mesh, &mut parts, &[face.mouth(), joint(23), joint(24)]);
    let eyes = [23, 24].map(|at| Eye::new(joint(at), options));
    let skin = |spot: &Spot| {
        let mut color = options.tone.at(spot.position, face.flush(spot.position));
        color = nails.over(color, spot, &options.tone);
        color = face.over(color, spot, &options.tone);
        clothes.over(color, spot)
    };
    let color = |spot: &Spot| match parts[spot.face] {
        Part::Skin => skin(spot),
        Part::Inside => face.inside(spot.position, &options.tone),
        Part::Eye(side) => eyes[side].color(spot.position),
        Part::Teeth => eyes::teeth(spot.position, face.mouth()),
        Part::Tongue => eyes::tongue(spot.position),
        Part::Lashes => options.brows,
    };
    bake(mesh, 0..mesh.faces().len(), size, blend(options.tone.color(), [0.5; 3], 0.2), color)
}

/// The part of each triangle.
fn parts(mesh: &Mesh) -> Vec<Part> {
    let mut parts = vec![Part::Skin; mesh.faces().len()];
    for part in mesh.parts() {
        for polygon in part.polygons.clone() {
            parts[mesh.polygon(polygon as usize)].fill(Part::named(&part.group));
        }
    }
    parts
}

/// Marks the skin of small islands around the mouth and the eyes, which are inside.
///
/// - `openings`: their middles, in centimetres.
fn mark_inside(mesh: &Mesh, parts: &mut [Part], openings: &[Vec3; 3]) {
    /// All parts of an opening are within this, in centimetres.
    const NEAR: f32 = 9.0;
    let mut island: Vec<u32> = (0..mesh.uv().len() as u32).collect();
    let find = |island: &[u32], mut at: u32| {
        while island[at as usize] != at {
            at = island[at as usize];
        }
        at
    };
    for corners in mesh.uv_faces() {
        let roots = corners.map(|corner| find(&island, corner));
        let least = roots.into_iter().min().unwrap_or_default();
        for at in roots.into_iter().chain(*corners) {
            island[at as usize] = least;
        }
    }
    let islands: Vec<u32> =
        mesh.uv_faces().iter().map(|corners| find(&island, corners[0])).collect();
    let is_near = |vertex: u32| {
        let place = Vec3::from(mesh.positions()[vertex as usize]) * CM;
        openings.iter().any(|opening| opening.distance(place) < NEAR)
    };
    // An island that leaves the neighbourhood is outside.
    let mut is_outside = vec![false; mesh.uv().len()];
    for (corners, &island) in mesh.faces().iter().zip(&islands) {
        is_outside[island as usize] |= !corners.iter().all(|&vertex| is_near(vertex));
    }
    for (part, island) in parts.iter_mut().zip(islands) {
        if *part == Part::Skin && !is_outside[island as usize] {
            *part = Part::Inside;
        }
    }
}

/// Multiplies a colour's brightness.
fn scaled(color: Color, factor: f32) -> Color {
    color.map(|value| (value * factor).clamp(0.0, 1.0))
}
