//! Arches of teeth with their gums: strips along ellipses, from the outer gum over the
//! edges of the teeth to the inner gum.

use std::f32::consts::FRAC_PI_2;

use glam::Vec3;
use uvgraft::easing::mix;

use super::cavity::Fit;
use super::piece::{Chart, Knot, Piece, Point};

/// Widths of the teeth of half an arch, from the midline, in millimetres.
///
/// # Source
/// Means after Wheeler, "Dental Anatomy, Physiology and Occlusion": central and lateral incisor,
/// canine, two premolars, first molar.
pub(super) const UPPER_MM: [f32; 6] = [8.5, 6.5, 7.5, 7.0, 7.0, 10.0];
pub(super) const LOWER_MM: [f32; 6] = [5.0, 5.5, 7.0, 7.0, 7.0, 11.0];

/// Number of teeth with two inner columns; those farther back have one.
const FINE: usize = 3;

/// Chart coordinates of the strip's rows: gum, edge of the gum, middle of the crown,
/// its outer and inner edges, and inner gum.
pub(super) const ROWS: [f32; 6] = [0.0, 0.34, 0.54, 0.74, 0.8, 1.0];

/// One arch.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arch {
    widths: [f32; 6],
    front_z: f32,
    half_width: f32,
    depth: f32,
    /// Heights of the edges of incisors and molars.
    edge_y: [f32; 2],
    /// 1 for the upper arch, whose gum is above the teeth; -1 for the lower one.
    up: f32,
    /// Height over which gums continue beyond the edges, into the walls.
    root_mm: f32,
}

impl Arch {
    pub fn upper(fit: &Fit) -> Self {
        Self {
            widths: UPPER_MM,
            front_z: fit.front_z,
            half_width: fit.half_width,
            depth: fit.depth,
            edge_y: [-1.2, 0.4],
            up: 1.0,
            root_mm: fit.roof_y + 4.0,
        }
    }

    /// Set back from the upper arch by the thickness of its edges.
    pub fn lower(fit: &Fit) -> Self {
        const OVERJET_MM: f32 = 2.6;
        Self {
            widths: LOWER_MM,
            front_z: fit.front_z - OVERJET_MM,
            half_width: fit.half_width - OVERJET_MM,
            depth: fit.depth - OVERJET_MM,
            edge_y: [-0.4, -0.6],
            up: -1.0,
            root_mm: 4.0 - fit.floor_y,
        }
    }

    /// The strip, with columns from the person's right to the left.
    pub fn piece(&self, chart: Chart) -> Piece {
        let mut piece = Piece::new(chart);
        let stations = self.stations();
        let (first, last) = (stations[0].along, stations[stations.len() - 1].along);
        let mut rows: Vec<Vec<(Knot, [f32; 2])>> = vec![Vec::new(); ROWS.len()];
        for station in &stations {
            let s = (station.along - first) / (last - first);
            for (row, position) in self.section(station).into_iter().enumerate() {
                let lower = if self.up > 0.0 { 0.0 } else { 1.0 };
                let knot = piece.point(Point { position, lower, rim: None });
                rows[row].push((knot, [s, ROWS[row]]));
            }
        }
        piece.grid(&rows, self.up > 0.0);
        piece
    }

    /// The columns of the strip.
    fn stations(&self) -> Vec<Station> {
        let mut half = vec![Station { along: 0.0, is_gap: true, back: 0.0 }];
        let mut along = 0.0;
        let total: f32 = self.widths.iter().sum();
        for (tooth, width) in self.widths.into_iter().enumerate() {
            let within: &[f32] = if tooth < FINE { &[0.22, 0.78] } else { &[0.5] };
            let station = |along: f32, is_gap| Station { along, is_gap, back: along / total };
            half.extend(within.iter().map(|share| station(along + share * width, false)));
            along += width;
            half.push(station(along, true));
        }
        let right = half[1..].iter().rev().map(|s| Station { along: -s.along, ..*s });
        right.chain(half.iter().copied()).collect()
    }

    /// The positions of the rows in a column.
    fn section(&self, station: &Station) -> [Vec3; 6] {
        let (position, out) = self.at(station.along);
        let back = station.back;
        let edge_y = mix(self.edge_y[0], self.edge_y[1], (2.0 * back).min(1.0));
        let crown = mix(9.0, 6.5, back) - if station.is_gap { 1.6 } else { 0.0 };
        let (bulge, edge) = if station.is_gap { (-0.5, 0.8) } else { (0.7, 0.0) };
        // Incisors are blades, molars are blocks.
        let thick = mix(1.5, 7.5, (1.6 * back).min(1.0));
        let at = |outwards: f32, y: f32| {
            position + out * outwards + Vec3::new(0.0, edge_y + self.up * y, 0.0)
        };
        [
            at(-1.5, self.root_mm),
            at(0.2, crown),
            at(bulge, 0.55 * crown),
            at(0.4 * bulge - 0.1, edge),
            at(0.4 * bulge - thick, edge + 0.2),
            at(-thick - 5.0, self.root_mm),
        ]
    }

    /// The point on the arch at a distance from the midline along it, at height 0, and
    /// the outward direction.
    fn at(&self, along: f32) -> (Vec3, Vec3) {
        let (a, b) = (self.half_width, self.depth);
        // The arc length of the ellipse is integrated numerically; beyond its widest
        // point the arch runs straight back.
        const STEPS: u32 = 64;
        let (mut angle, mut rest) = (0.0_f32, along.abs());
        let step = FRAC_PI_2 / STEPS as f32;
        while angle < FRAC_PI_2 - 0.5 * step {
            let mid = angle + 0.5 * step;
            let length = (a * mid.cos()).hypot(b * mid.sin()) * step;
            if length >= rest {
                angle += step * rest / length;
                rest = 0.0;
                break;
            }
            (angle, rest) = (angle + step, rest - length);
        }
        let (sin, cos) = angle.sin_cos();
        let position = Vec3::new(a * sin, 0.0, self.front_z - b * (1.0 - cos) - rest);
        let out = Vec3::new(b * sin, 0.0, a * cos).normalize();
        let side = Vec3::new(if along < 0.0 { -1.0 } else { 1.0 }, 1.0, 1.0);
        (position * side, out * side)
    }
}

/// A column of the strip.
#[derive(Debug, Clone, Copy)]
struct Station {
    /// Distance from the midline along the arch, to the person's left, in millimetres.
    along: f32,
    /// Whether it lies between two teeth rather than on one.
    is_gap: bool,
    /// 0 at the midline, 1 behind the last tooth.
    back: f32,
}
