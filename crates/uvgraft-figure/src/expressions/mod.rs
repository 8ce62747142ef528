//! The figure's morph targets, and the expressions that combine them.
//!
//! A morph is a function of the position in head space: skin slides over the head's contour, lids
//! over the eyes, and the jaw rotates about its hinge.

mod brows;
mod lids;
mod mouth;

use glam::{Vec3, vec3};
use uvgraft::threads;
use uvgraft_avatar::rig::{Expression, ExpressionPreset as Preset, Morph};

use super::Figure;
use super::head_shape::{EYE_LEVEL, contour};
use super::sdf::meet;
use super::surface::PartKind;

/// A skin vertex of the face at rest, in head space, in centimetres.
#[derive(Debug, Clone, Copy)]
struct Spot {
    p: Vec3,
    /// Coordinate across the lips; see [`Figure::lips`].
    lip: Option<f32>,
    /// Depth (Z) of the head's contour in front of or behind it.
    contour_z: f32,
}

impl Spot {
    fn new(p: Vec3, lip: Option<f32>) -> Self {
        Self { p, lip, contour_z: contour_z(p.x, p.y, 12.0) }
    }

    /// Offset by `dx` to the left and `dy` upwards that stays on the head's contour.
    fn slid(&self, dx: f32, dy: f32) -> Vec3 {
        let length = (dx * dx + dy * dy).sqrt();
        if length < 1e-4 {
            return Vec3::default();
        }
        // Where the head turns away from the front, depth changes too fast to follow:
        // limit the slope.
        let steepest = 1.5 * length;
        let z = contour_z(self.p.x + dx, self.p.y + dy, self.contour_z + 2.0 * steepest);
        vec3(dx, dy, (z - self.contour_z).clamp(-steepest, steepest))
    }
}

/// Depth at which a ray along -Z from `from` meets the head's contour.
fn contour_z(x: f32, y: f32, from: f32) -> f32 {
    meet(contour, vec3(x, y, from), vec3(0.0, 0.0, -1.0), 12.0).z
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

/// The morphs and weights of each expression.
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
    let lips = figure.lips_of_vertices();
    let positions = figure.body.positions();
    let spots = threads::map_indices(positions.len(), |vertex| {
        let p = Vec3::from(positions[vertex]) * 100.0 - vec3(0.0, EYE_LEVEL, 0.0);
        let face = parts[vertex].kind == PartKind::Face && p.z > BEHIND;
        face.then(|| Spot::new(p, lips[vertex]))
    });
    SHAPES
        .into_iter()
        .map(|(name, shape)| {
            let offset = |vertex: usize| {
                spots[vertex].map_or([0.0; 3], |spot| (shape(spot) * METRES).into())
            };
            Morph::from_dense(name, &threads::map_indices(spots.len(), offset))
        })
        .collect()
}

/// The expressions: all VRM presets except the gaze directions.
pub(crate) fn expressions(morphs: &[Morph]) -> Vec<Expression> {
    let index_of = |name: &str| morphs.iter().position(|morph| morph.name == name);
    EXPRESSIONS
        .into_iter()
        .map(|(preset, mix)| {
            let mix = mix.iter().filter_map(|&(name, weight)| Some((index_of(name)?, weight)));
            Expression::preset(preset, mix.collect())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::symmetry::Symmetry as _;

    #[test]
    fn expressions_mix_morphs_that_move_the_face_alone() {
        let figure = Figure::new();
        let avatar = figure.avatar();
        let parts = figure.parts_of_vertices();
        // Four gaze directions, and neutral.
        assert_eq!(avatar.expressions.len(), EXPRESSIONS.len() + 5);
        for (expression, (_, wanted)) in avatar.expressions.iter().zip(EXPRESSIONS) {
            assert_eq!(expression.morphs.len(), wanted.len(), "{}", expression.name);
        }
        for morph in &avatar.morphs[..SHAPES.len()] {
            let most =
                morph.offsets.iter().map(|(_, d)| Vec3::from(*d).length()).fold(0.0, f32::max);
            // From a few millimetres to a few centimetres.
            assert!((0.002..0.04).contains(&most), "{} moves {most} m", morph.name);
            for &(vertex, offset) in &morph.offsets {
                let [x, y, z] = figure.body.positions()[vertex as usize];
                assert_eq!(parts[vertex as usize].kind, PartKind::Face, "{}", morph.name);
                // Above the collar, in front of the ears.
                assert!(y > 1.47 && z > 0.0, "{} moves {x} {y} {z} by {offset:?}", morph.name);
            }
        }
    }

    #[test]
    fn shapes_are_symmetric() {
        let figure = Figure::new();
        let parts = figure.parts_of_vertices();
        let faces = (0..parts.len()).filter(|&vertex| parts[vertex].kind == PartKind::Face);
        let mirrored = |name: &str| match name {
            "blink_left" => "blink_right".to_owned(),
            "blink_right" => "blink_left".to_owned(),
            other => other.to_owned(),
        };
        for vertex in faces.step_by(7) {
            let p = Vec3::from(figure.body.positions()[vertex]) * 100.0 - vec3(0.0, EYE_LEVEL, 0.0);
            for (name, shape) in SHAPES {
                let other = SHAPES.into_iter().find(|(found, _)| *found == mirrored(name)).unwrap();
                let here = shape(Spot::new(p, None));
                let there = other.1(Spot::new(p.mirrored(), None)).mirrored();
                // In centimetres: 1e-4 m.
                assert!((here - there).length() < 1e-2, "{name} at {p:?}: {here:?} {there:?}");
            }
        }
    }

    /// The largest increase in the angle between neighbouring faces of the left cheek, in degrees.
    fn folded(figure: &Figure, morph: &Morph) -> f32 {
        let parts = figure.parts_of_vertices();
        let rest: Vec<Vec3> = figure.body.positions().iter().map(|&p| Vec3::from(p)).collect();
        let mut moved = rest.clone();
        for &(vertex, offset) in &morph.offsets {
            moved[vertex as usize] += Vec3::from(offset);
        }
        let on_cheek = |vertex: u32| {
            let p = rest[vertex as usize] * 100.0 - vec3(0.0, EYE_LEVEL, 0.0);
            // Lateral to the lips and the nose, and above the chin.
            parts[vertex as usize].kind == PartKind::Face
                && (3.2..6.5).contains(&p.x)
                && (-9.0..-2.0).contains(&p.y)
                && p.z > 2.0
        };
        let normal = |points: &[Vec3], face: [u32; 3]| {
            let [a, b, c] = face.map(|vertex| points[vertex as usize]);
            (b - a).cross(c - a).normalize_or_zero()
        };
        let mut seen = std::collections::HashMap::new();
        let mut most = 0.0_f32;
        for &face in figure.body.faces().iter().filter(|face| face.iter().all(|&v| on_cheek(v))) {
            let normals = [normal(&rest, face), normal(&moved, face)];
            for k in 0..3 {
                let mut edge = [face[k], face[(k + 1) % 3]];
                edge.sort_unstable();
                if let Some(others) = seen.insert(edge, normals) {
                    let fold = |at: usize| {
                        let others: [Vec3; 2] = others;
                        normals[at].dot(others[at]).clamp(-1.0, 1.0).acos().to_degrees()
                    };
                    most = most.max(fold(1) - fold(0));
                }
            }
        }
        assert!(seen.len() > 300, "{} edges", seen.len());
        most
    }

    #[test]
    fn round_lips_leave_no_crease_on_the_cheek() {
        let figure = Figure::new();
        let morphs = figure.avatar().morphs;
        let round = morphs.iter().find(|morph| morph.name == "lips_round").unwrap();
        let crease = folded(&figure, round);
        // It is 25 if lips push the cheek.
        assert!(crease < 8.0, "{crease} deg");
    }
}
