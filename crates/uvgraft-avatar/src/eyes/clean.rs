//! Painted eyes: sclera, iris, limbal ring and pupil, without the baked-in highlights
//! and lids of captures.

use std::f32::consts::TAU;

use glam::Vec3;
use uvgraft::easing::{bell, mix, smoothstep};
use uvgraft::{Mesh, Texture};

use super::eyeball::{Eyeball, eyeballs, is_round, pieces, sphere};
use super::gaze::Gaze;
use super::iris::{Iris, irises, sample, white};
use super::texels;
use crate::Avatar;
use crate::atlas::ChartRect;
use crate::paint::noise::noise2;
use crate::paint::texel::{Color, blend, put, srgb};
use crate::rig::HumanBone;

const SCLERA: Color = [0.82, 0.785, 0.76];
const RIM: Color = [0.62, 0.45, 0.41];
const VEIN: Color = [0.72, 0.36, 0.33];
const PUPIL: Color = [0.022, 0.02, 0.02];

/// Luma of the painted sclera, and the lower limit of the factor that darkens it for a
/// dark capture.
const WHITE: f32 = 0.79;
const DARKEST: f32 = 0.6;

/// Radius of the pupil, in iris radii.
const PUPIL_EDGE: f32 = 0.36;

/// The result of painting eyes.
#[derive(Debug, Clone, PartialEq)]
pub struct CleanedEyes {
    /// The iris of each eye, the left one first.
    pub irises: Vec<Iris>,
}

/// Paints an avatar's eyes over its texture, with the iris colour that the texture shows.
///
/// Eyeballs are round connected components that follow the eye joints; without any,
/// nothing is painted.
pub fn clean(avatar: &Avatar, texture: &mut Texture) -> CleanedEyes {
    let pieces = pieces(&avatar.mesh);
    let bones = [HumanBone::LeftEye, HumanBone::RightEye];
    let eyeballs: Vec<Eyeball> =
        bones.into_iter().flat_map(|bone| eyeballs(avatar, bone, &pieces)).collect();
    paint(&avatar.mesh, &pieces, &eyeballs, texture, |_, _| true, None)
}

/// What a photograph shows of eyes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EyeColors {
    /// Colour of the irises, sRGB with 1.0 for white.
    pub iris: [f32; 3],
    /// Luma of the lightest part of the sclera, in the same range.
    pub white: f32,
}

/// As [`clean`], for the eyes of a head that looks along z with y up.
///
/// - `eyes`: vertices of each eyeball, which must be a connected component of the mesh; those that
///   are not round are not painted.
/// - `is_seen`: whether a texel, by column and row, shows the eye; others say nothing of its colour.
/// - `colors`: of both eyes, if they are known better than the texture shows them.
pub fn clean_head(
    mesh: &Mesh,
    eyes: &[&[u32]],
    texture: &mut Texture,
    is_seen: impl Fn(u32, u32) -> bool,
    colors: Option<EyeColors>,
) -> CleanedEyes {
    let pieces = pieces(mesh);
    let eyeball = |vertices: &&[u32]| {
        let points: Vec<Vec3> =
            vertices.iter().map(|&vertex| mesh.positions()[vertex as usize].into()).collect();
        let (center, radius) = sphere(&points).filter(|&ball| is_round(&points, ball))?;
        let piece = pieces[*vertices.first()? as usize];
        Some(Eyeball { piece, vertices: vertices.to_vec(), center, radius })
    };
    let eyeballs: Vec<Eyeball> = eyes.iter().filter_map(eyeball).collect();
    paint(mesh, &pieces, &eyeballs, texture, is_seen, colors)
}

/// - `pieces`: of [`pieces()`].
fn paint(
    mesh: &Mesh,
    pieces: &[u32],
    eyeballs: &[Eyeball],
    texture: &mut Texture,
    is_seen: impl Fn(u32, u32) -> bool,
    colors: Option<EyeColors>,
) -> CleanedEyes {
    let eyes: Vec<(Gaze, Vec<usize>)> = eyeballs
        .iter()
        .map(|eyeball| {
            let is_own = |face: &usize| pieces[mesh.faces()[*face][0] as usize] == eyeball.piece;
            let faces = (0..mesh.faces().len()).filter(is_own).collect();
            (Gaze::new(mesh, eyeball), faces)
        })
        .collect();
    let size = texture.size();
    let samples: Vec<_> = eyes
        .iter()
        .map(|(gaze, faces)| {
            let mut samples = Vec::new();
            texels::each(mesh, faces, size, 0, |x, y, point| {
                if is_seen(x, y) {
                    samples.push(sample(gaze, point, srgb(texture, x, y)));
                }
            });
            samples
        })
        .collect();
    let irises = match colors {
        Some(EyeColors { iris, .. }) => vec![Iris { color: iris, is_found: true }; eyes.len()],
        None => irises(&samples),
    };
    let white = colors.map(|colors| colors.white).or_else(|| white(&samples));
    let light = white.map_or(1.0, |seen| (1.15 * seen / WHITE).clamp(DARKEST, 1.0));
    let gutter = ((ChartRect::GUTTER * size.width.max(size.height) as f32) as u32).max(1);
    for (seed, ((gaze, faces), iris)) in (0..).zip(eyes.iter().zip(&irises)) {
        texels::each(mesh, faces, size, gutter, |x, y, point| {
            let (distance, around) = gaze.around(point);
            let color = color(distance, around, iris.color, seed).map(|value| light * value);
            put(texture, x, y, color);
        });
    }
    CleanedEyes { irises }
}

/// The colour of a point of an eye.
///
/// - `distance`: from the gaze axis, in iris radii.
/// - `around`: the angle around the axis; a quarter turn is up.
fn color(distance: f32, around: f32, iris: Color, seed: u32) -> Color {
    let white = sclera(distance, around, seed);
    let within = self::iris(distance, around, iris, seed);
    let color = blend(within, white, smoothstep(0.96, 1.06, distance));
    // The shadow of the upper lid, which renderers don't cast on anything so small.
    let shadow = 0.34 * smoothstep(0.1, 1.3, distance * around.sin());
    color.map(|value| value * (1.0 - shadow))
}

fn sclera(distance: f32, around: f32, seed: u32) -> Color {
    let out = smoothstep(1.2, 2.4, distance);
    let base = blend(SCLERA, RIM, 0.55 * out * out);
    // Veins meander from the corners towards the iris and fade out.
    let turns = around / TAU * 17.0 + 0.9 * noise2(distance * 3.0, around * 2.0, 40 + seed);
    let vein = bell((turns - turns.round()) / (0.035 + 0.02 * out), 1.0);
    let patch = noise2(distance * 1.6, around * 1.9, 60 + seed);
    let strength = 0.3 * smoothstep(1.45, 2.4, distance) * smoothstep(-0.1, 0.5, patch);
    blend(base, VEIN, vein * strength)
}

fn iris(distance: f32, around: f32, color: Color, seed: u32) -> Color {
    // Fibres run radially; sampling the noise on circles makes them periodic in the angle.
    let fine = noise2(around.cos() * 14.0 + distance, around.sin() * 14.0, 80 + seed);
    let coarse = noise2(around.cos() * 5.0, around.sin() * 5.0 + distance * 1.5, 90 + seed);
    let fibres = 0.16 * fine + 0.12 * coarse;
    // Lighter around the pupil, darker outwards, with a dark ring at the edge.
    let collar = 0.16 * bell(distance - 0.52, 0.12);
    let depth = mix(1.08, 0.86, smoothstep(0.5, 0.95, distance));
    let light = depth + collar + fibres;
    let lit = color.map(|value| (value * light).clamp(0.0, 1.0));
    let ring = smoothstep(0.8, 0.97, distance);
    let dark = blend(lit, color.map(|value| 0.3 * value), 0.75 * ring);
    blend(PUPIL, dark, smoothstep(PUPIL_EDGE - 0.04, PUPIL_EDGE + 0.05, distance))
}

#[cfg(test)]
mod tests {
    use std::f32::consts::{FRAC_PI_2 as UP, PI};

    use uvgraft::Size;
    use uvgraft::color::luma;
    use uvgraft_figure::{Figure, paint_body};

    use super::*;
    use crate::example;

    const GREEN: Color = [0.35, 0.45, 0.3];

    #[test]
    fn an_eye_has_a_dark_pupil_a_coloured_iris_and_a_white_sclera() {
        for around in [-UP, 0.0, 1.0, PI] {
            let at = |distance| color(distance, around, GREEN, 0);
            assert!(luma(at(0.1)) < 0.05);
            let iris = at(0.65);
            assert!(iris[1] > iris[0] && iris[1] > iris[2], "{iris:?}");
            assert!(luma(at(0.97)) < luma(iris));
            assert!(luma(at(1.3)) > 0.5);
        }
        // Under the lid.
        assert!(luma(color(1.4, UP, GREEN, 0)) < luma(color(1.4, -UP, GREEN, 0)));
    }

    #[test]
    fn only_the_figures_eyes_are_painted() {
        let figure = Figure::new();
        let parted = super::super::SeparatedEyes::find(&figure.body).unwrap().unwrap();
        let mut avatar = example::avatar();
        avatar.mesh = parted.mesh.clone().with_positions(avatar.mesh.positions().to_vec()).unwrap();
        let size = Size::square(1024);
        let mut texture = paint_body(&figure, size);
        parted.copy(&mut texture);
        let before = texture.clone();
        let cleaned = clean(&avatar, &mut texture);
        assert_eq!(cleaned.irises.len(), 2);
        // The eyes of the painted body are blank.
        assert!(cleaned.irises.iter().all(|iris| !iris.is_found), "{cleaned:?}");
        let changed = (0..size.texels() as u32)
            .filter(|texel| {
                let (x, y) = (texel % 1024, texel / 1024);
                (0..3).any(|channel| before.get(x, y, channel) != texture.get(x, y, channel))
            })
            .count();
        // Two discs of 82 texels with their gutters, out of a million texels.
        assert!((8_000..17_000).contains(&changed), "{changed}");
    }
}
