//! The figure's morph targets, and the expressions that mix them.
//!
//! A morph is a function of the place in head space: skin slides over the head's contour, lids over
//! the eyes, and the jaw turns about its hinge.

mod brows;
mod lids;
mod mouth;

use super::Figure;
use super::head_shape::{EYE_LEVEL, contour};
use super::rigging::head::is_lower;
use super::sdf::meet;
use super::surface::Kind;
use crate::rig::{Expression, ExpressionPreset as Preset, Morph};
use crate::vector::{Vec3, vec3};

/// A vertex of the face's skin at rest, in head space, in centimetres.
#[derive(Debug, Clone, Copy)]
struct Spot {
    p: Vec3,
    /// Whether it belongs to the lower lip or what is below; closed lips lie in one place.
    lower: bool,
}

type Shape = fn(Spot) -> Vec3;

const SHAPES: [(&str, Shape); 10] = [
    ("jaw_open", mouth::jaw_open),
    ("smile", mouth::smile),
    ("frown", mouth::frown),
    ("lips_round", mouth::lips_round),
    ("lips_wide", mouth::lips_wide),
    ("blink_left", |spot| lids::blink(spot, 1.0)),
    ("blink_right", |spot| lids::blink(spot, -1.0)),
    ("brows_up", brows::up),
    ("brows_angry", brows::angry),
    ("brows_sad", brows::sad),
];

/// What each expression mixes.
const EXPRESSIONS: [(Preset, &[(&str, f32)]); 13] = [
    (Preset::Happy, &[("smile", 1.0)]),
    (Preset::Angry, &[("brows_angry", 1.0), ("frown", 0.6)]),
    (Preset::Sad, &[("brows_sad", 1.0), ("frown", 1.0)]),
    (Preset::Relaxed, &[("smile", 0.45), ("blink_left", 0.3), ("blink_right", 0.3)]),
    (Preset::Surprised, &[("brows_up", 1.0), ("jaw_open", 0.5), ("lips_round", 0.3)]),
    (Preset::Aa, &[("jaw_open", 1.0)]),
    (Preset::Ih, &[("jaw_open", 0.3), ("lips_wide", 0.4)]),
    (Preset::Ou, &[("jaw_open", 0.2), ("lips_round", 1.0)]),
    (Preset::Ee, &[("jaw_open", 0.15), ("lips_wide", 1.0)]),
    (Preset::Oh, &[("jaw_open", 0.55), ("lips_round", 0.6)]),
    (Preset::Blink, &[("blink_left", 1.0), ("blink_right", 1.0)]),
    (Preset::BlinkLeft, &[("blink_left", 1.0)]),
    (Preset::BlinkRight, &[("blink_right", 1.0)]),
];

/// The morph targets of the figure's body.
pub(crate) fn morphs(figure: &Figure) -> Vec<Morph> {
    const METRES: f32 = 0.01;
    /// Nothing behind the ears moves.
    const BEHIND: f32 = 0.0;
    let parts = figure.parts_of_vertices();
    let lower_lip = figure.in_lower_lip();
    let spots: Vec<Option<Spot>> = figure
        .body
        .positions()
        .iter()
        .enumerate()
        .map(|(vertex, &position)| {
            let p = Vec3::from(position) * 100.0 - vec3(0.0, EYE_LEVEL, 0.0);
            let face = parts[vertex].kind == Kind::Face && p.z > BEHIND;
            face.then(|| Spot { p, lower: is_lower(p, lower_lip[vertex]) })
        })
        .collect();
    SHAPES
        .into_iter()
        .map(|(name, shape)| {
            let offset =
                |spot: &Option<Spot>| spot.map_or([0.0; 3], |spot| (shape(spot) * METRES).into());
            Morph::from_dense(name, &spots.iter().map(offset).collect::<Vec<_>>())
        })
        .collect()
}

/// The expressions, all of VRM's presets but those for where the eyes look.
pub(crate) fn expressions(morphs: &[Morph]) -> Vec<Expression> {
    let number = |name: &str| morphs.iter().position(|morph| morph.name == name);
    EXPRESSIONS
        .into_iter()
        .map(|(preset, mix)| {
            let mix = mix.iter().filter_map(|&(name, weight)| Some((number(name)?, weight)));
            Expression::preset(preset, mix.collect())
        })
        .collect()
}

/// What takes a point of the skin to the left and up, and with it along the head's contour.
fn slid(p: Vec3, dx: f32, dy: f32) -> Vec3 {
    if dx * dx + dy * dy < 1e-8 {
        return Vec3::default();
    }
    let depth = |x: f32, y: f32| meet(contour, vec3(x, y, 11.0), vec3(0.0, 0.0, -1.0), 11.0).z;
    vec3(dx, dy, depth(p.x + dx, p.y + dy) - depth(p.x, p.y))
}
