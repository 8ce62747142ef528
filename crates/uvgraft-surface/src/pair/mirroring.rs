//! Finds layouts that are mirrored as a whole: with V or U counted from the wrong side.

use super::{Direction, Pair, Side};
use crate::mesh::{Mesh, UvAxis, doubled_area, triangle_area};
use crate::piece::wide;

/// A pair of which most links mirror the texture.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Mirroring {
    /// Share of the linked area, in the layouts, that is mirrored, 0 to 1.
    pub share: f64,
    /// Whose layout is mirrored on its surface; `None` if the surfaces do not say.
    pub side: Option<Side>,
    /// The axis that is counted from the wrong side; `None` if islands are turned in all directions.
    pub axis: Option<UvAxis>,
}

impl Mirroring {
    /// Least share of a layout that is mirrored as a whole. In layouts whose halves lie over each other
    /// one half is mirrored; between FLAME and SMPL-X 1.5 % of the triangles are.
    const LEAST: f64 = 0.75;

    /// What is mirrored and the options that undo it.
    ///
    /// - `names`: of the source and the target.
    pub fn text(&self, names: [&str; 2]) -> String {
        let option = match self.axis {
            Some(UvAxis::V) => "`flip_v`",
            Some(UvAxis::U) => "`flip_u`",
            None => "`flip_v` (or `flip_u`)",
        };
        let axis = match self.axis {
            Some(UvAxis::V) => "the V axis",
            Some(UvAxis::U) => "the U axis",
            None => "V or U",
        };
        let (whose, side) = match self.side {
            Some(Side::Source) => (names[0].to_owned(), "source"),
            Some(Side::Target) => (names[1].to_owned(), "target"),
            None => (format!("{} or {}", names[0], names[1]), "source or target"),
        };
        format!(
            "{:.0} % of the linked area is mirrored: {axis} of {whose} seems to be flipped, which puts \
             the face upside down or mirrors it; {option} {side} flips it back",
            100.0 * self.share
        )
    }
}

impl Pair {
    /// Whether one of the two layouts is mirrored as a whole, as if V had been counted from the wrong
    /// side; `None` if not, or if so little has an area that it cannot be said.
    pub fn mirroring(&self) -> Option<Mirroring> {
        let (mut mirrored, mut total) = (0.0, 0.0);
        // Sum of the derivatives of the target's UV by the source's, as if all were of the same size.
        let mut jacobian = [0.0; 4];
        for piece in self.pieces() {
            let [target, source] = piece.uv(&self.target, &self.source);
            let [target_area, source_area] = [target, source].map(doubled_area);
            let weight = (target_area * source_area).abs().sqrt();
            if weight == 0.0 {
                continue;
            }
            total += weight;
            if target_area * source_area > 0.0 {
                continue;
            }
            mirrored += weight;
            // Of two sides each, by Cramer's rule.
            let side =
                |[a, b, c]: [[f64; 2]; 3]| [[b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]];
            let ([p, q], [s, t]) = (side(source), side(target));
            let turned = [
                s[0] * q[1] - t[0] * p[1],
                t[0] * p[0] - s[0] * q[0],
                s[1] * q[1] - t[1] * p[1],
                t[1] * p[0] - s[1] * q[0],
            ];
            for (sum, value) in jacobian.iter_mut().zip(turned) {
                *sum += value * source_area.signum();
            }
        }
        if total == 0.0 {
            return None;
        }
        let share = mirrored / total;
        if share < Mirroring::LEAST {
            return None;
        }
        let [uu, uv, vu, vv] = jacobian;
        let across = uv.abs().max(vu.abs());
        // Upright islands: both diagonal elements outweigh the others.
        let axis = match (uu, vv) {
            _ if uu.abs().min(vv.abs()) <= across => None,
            (1e-300.., ..0.0) => Some(UvAxis::V),
            (..0.0, 1e-300..) => Some(UvAxis::U),
            _ => None,
        };
        let is_mirrored = [Direction::Reverse, Direction::Forward]
            .map(|direction| is_mirrored_on_surface(self.to(direction), &self.linked(direction)));
        let side = match is_mirrored {
            [Some(true), Some(false)] => Some(Side::Source),
            [Some(false), Some(true)] => Some(Side::Target),
            _ => None,
        };
        Some(Mirroring { share, side, axis })
    }

    /// Share of a mesh's area whose faces are linked, 0 to 1; 1 for a mesh without area.
    ///
    /// - `direction`: the one that fills the mesh.
    pub fn linked_share(&self, direction: Direction) -> f64 {
        let mesh = self.to(direction);
        let area = |face| triangle_area(mesh.triangle(face));
        let all: f64 = (0..mesh.faces().len()).map(area).sum();
        if all > 0.0 {
            self.linked(direction).into_iter().map(area).sum::<f64>() / all
        } else {
            1.0
        }
    }

    /// The linked faces of the mesh that a direction fills.
    pub(crate) fn linked(&self, direction: Direction) -> Vec<usize> {
        let pieces = self.face_pieces(direction);
        (0..pieces.faces()).filter(|&face| !pieces.of_face(face).is_empty()).collect()
    }
}

/// Whether a texture appears mirrored on the outside of the surface that some faces enclose; `None` if
/// they enclose nothing.
fn is_mirrored_on_surface(mesh: &Mesh, faces: &[usize]) -> Option<bool> {
    /// Least volume, as a share of that of a ball with the same area: heads have 0.43 to 0.59, faces 0.32
    /// and more, bodies 0.24 to 0.32, a sheet nothing.
    const LEAST_VOLUME: f64 = 0.05;
    let mut center = glam::DVec3::ZERO;
    let (mut surface, mut layout) = (0.0, 0.0);
    for &face in faces {
        let [a, b, c] = mesh.triangle(face);
        let area = triangle_area([a, b, c]);
        center += area * (a + b + c) / 3.0;
        surface += area;
        layout += doubled_area(wide(mesh.uv_triangle(face)));
    }
    center /= surface;
    let volume: f64 = faces
        .iter()
        .map(|&face| {
            let [a, b, c] = mesh.triangle(face).map(|corner| corner - center);
            a.dot(b.cross(c)) / 6.0
        })
        .sum();
    let radius = (surface / (4.0 * std::f64::consts::PI)).sqrt();
    let ball = surface * radius / 3.0;
    // Counter-clockwise seen from outside is counter-clockwise in the texture, whose area is then negative.
    (volume.abs() > LEAST_VOLUME * ball).then_some(layout * volume > 0.0)
}
