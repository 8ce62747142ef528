//! Landmarks of the face, from the profile on the midline and the outline of the head.
//!
//! Each landmark is an extremum of the depth map within a range of heights relative to
//! landmarks found before. Thresholds are in distances between the eyes; where an extremum
//! is missing, the proportions of an average face are used instead.

use glam::DVec3;

use super::frame::HeadFrame;
use super::points::Points;
use super::relief::{Local, Relief};
use super::search::Eyes;

/// Landmarks and sizes that areas are defined by, in the head's coordinates.
pub(super) struct Face {
    pub local: Local,
    pub eyes: Eyes,
    pub nose_tip: DVec3,
    pub nose_base: DVec3,
    pub mouth: DVec3,
    /// The left corner; the right one mirrors it.
    pub mouth_corner: DVec3,
    pub chin: DVec3,
    /// Where the underside of the chin begins.
    pub jaw_bottom: DVec3,
    pub brow: DVec3,
    pub crown: DVec3,
    /// The outermost points of the left and right ear.
    pub ears: [Option<DVec3>; 2],
    /// Whether each component is the skin, or has the position and size of an ear.
    pub may_be_ear: Vec<bool>,
    /// Half the width of the head in front of the ears.
    pub half_width: f64,
    /// Half its width above the ears.
    pub upper_half_width: f64,
    pub neck_base: Option<DVec3>,
    /// The height of the mesh's lowest point.
    pub bottom: f64,
}

impl Face {
    /// Finds the landmarks from the nose downwards, then brow, crown, ears and neck; each search is
    /// bounded by the landmarks found before.
    pub fn new(points: &Points, frame: &HeadFrame, eyes: &Eyes, relief: &Relief) -> Self {
        let local = Local {
            positions: points.positions.iter().map(|&at| frame.to_local(at)).collect(),
            normals: points.normals.iter().map(|&normal| frame.local_direction(normal)).collect(),
        };
        let eyes = Eyes {
            centers: eyes.centers,
            radius: eyes.radius,
            components: eyes.components.clone(),
            skin: eyes.skin,
        };
        let skin: Vec<DVec3> = (local.positions.iter().zip(&points.component))
            .filter(|&(_, &component)| component == eyes.skin)
            .map(|(&at, _)| at)
            .collect();
        let bottom = points.triangles.as_flattened().iter();
        let bottom = bottom.map(|&point| local.positions[point as usize].y).fold(0.0, f64::min);

        let nose_tip = foremost(relief, [-1.05, -0.2]).unwrap_or(DVec3::new(0.0, -0.6, 0.7));
        let mouth = mouth(relief, nose_tip);
        let nose_base = nose_base(relief, nose_tip, mouth);
        let mouth_corner = mouth_corner(relief, mouth);
        let chin = chin(relief, mouth);
        let jaw_bottom = jaw_bottom(relief, chin);
        let brow = foremost(relief, [0.18, 0.5]).unwrap_or(DVec3::new(0.0, 0.35, nose_tip.z - 0.3));
        let crown = crown(&skin);
        let upper_half_width = widest(&skin, [0.3, 0.8], [-2.2, -0.5]).max(0.7);
        // Depths in front of the ears only.
        let half_width = widest(&skin, [-0.5, 0.9], [-0.75, 0.1]).max(0.7);
        let may_be_ear = may_be_ear(&local.positions, points, eyes.skin);
        let ears = ears(&local.positions, points, &may_be_ear, half_width);
        let neck_base = neck_base(&skin, relief, jaw_bottom);
        Self {
            local,
            eyes,
            nose_tip,
            nose_base,
            mouth,
            mouth_corner,
            chin,
            jaw_bottom,
            brow,
            crown,
            ears,
            may_be_ear,
            half_width,
            upper_half_width,
            neck_base,
            bottom,
        }
    }

    /// In the order of [`super::Landmark`].
    pub fn landmarks(&self) -> [Option<DVec3>; 13] {
        [
            Some(self.eyes.centers[0]),
            Some(self.eyes.centers[1]),
            Some(self.nose_tip),
            Some(self.nose_base),
            Some(self.mouth),
            Some(self.mouth_corner),
            Some(self.mouth_corner.with_x(-self.mouth_corner.x)),
            Some(self.chin),
            Some(self.brow),
            Some(self.crown),
            self.ears[0],
            self.ears[1],
            self.neck_base,
        ]
    }
}

/// The foremost point of the midline between two heights.
fn foremost(relief: &Relief, heights: [f64; 2]) -> Option<DVec3> {
    let column = relief.column(0.0, heights);
    let best = column.into_iter().reduce(|a, b| if b[1] > a[1] { b } else { a })?;
    Some(DVec3::new(0.0, best[0], best[1]))
}

/// The deepest notch of a column, such as that between the lips: its depth below the lower
/// of its two sides, and its height.
fn notch(relief: &Relief, x: f64, heights: [f64; 2]) -> Option<(f64, f64)> {
    /// Cells in which the sides of a notch are looked for: 11 mm where eyes are 63 mm apart.
    const REACH: usize = 9;
    let column = relief.column(x, heights);
    let mut best: Option<(f64, f64)> = None;
    for middle in 2..column.len().saturating_sub(2) {
        let depth = column[middle][1];
        let peak = |range: std::ops::Range<usize>| {
            column[range].iter().map(|point| point[1]).fold(f64::NEG_INFINITY, f64::max)
        };
        let below = peak(middle.saturating_sub(REACH)..middle);
        let above = peak(middle + 1..column.len().min(middle + 1 + REACH));
        let found = (below.min(above) - depth).min(0.3);
        if found > 0.0 && best.is_none_or(|best| found > best.0) {
            best = Some((found, column[middle][0]));
        }
    }
    best
}

/// The deepest notch between nose and chin, which lies between the lips.
fn mouth(relief: &Relief, nose_tip: DVec3) -> DVec3 {
    let heights = [nose_tip.y - 0.85, nose_tip.y - 0.28];
    // Columns off the midline may show the gap between lips that touch only at the centre.
    let found = [0.0, 0.06, 0.12].map(|x| notch(relief, x, heights));
    let best = found.into_iter().flatten().reduce(|a, b| if b.0 > a.0 * 1.5 { b } else { a });
    let y = best.filter(|best| best.0 > 0.004).map_or(nose_tip.y - 0.5, |best| best.1);
    let around = relief.column(0.0, [y - 0.06, y + 0.06]);
    let lowest = around.iter().map(|point| point[1]).fold(f64::INFINITY, f64::min);
    let highest = around.iter().map(|point| point[1]).fold(f64::NEG_INFINITY, f64::max);
    let depth = if highest.is_finite() { lowest.max(highest - 0.12) } else { nose_tip.z - 0.25 };
    DVec3::new(0.0, y, depth)
}

/// The point of the profile farthest behind the line from the tip of the nose to the upper lip.
fn nose_base(relief: &Relief, tip: DVec3, mouth: DVec3) -> DVec3 {
    let lip = foremost(relief, [mouth.y + 0.03, mouth.y + 0.2]).unwrap_or(mouth);
    let column = relief.column(0.0, [lip.y, tip.y - 0.04]);
    let behind = |&[y, depth]: &[f64; 2]| {
        let along = (y - lip.y) / (tip.y - lip.y).max(1e-6);
        lip.z + along * (tip.z - lip.z) - depth
    };
    let best = column.iter().copied().max_by(|a, b| behind(a).total_cmp(&behind(b)));
    let [y, depth] = best.unwrap_or([0.6 * tip.y + 0.4 * mouth.y, lip.z]);
    DVec3::new(0.0, y, depth)
}

/// Follows the notch between the lips outwards until it ends.
fn mouth_corner(relief: &Relief, mouth: DVec3) -> DVec3 {
    let mut corner = mouth;
    let mut misses = 0;
    for k in 1..=42 {
        let x = 0.02 * f64::from(k);
        let found = notch(relief, x, [corner.y - 0.14, corner.y + 0.14]);
        match found.filter(|found| found.0 > 0.006) {
            Some((_, y)) => {
                let y = corner.y + (y - corner.y).clamp(-0.03, 0.03);
                corner = DVec3::new(x, y, relief.both(x, y).unwrap_or(corner.z));
                misses = 0;
            }
            None => misses += 1,
        }
        if misses > 3 {
            break;
        }
    }
    // Lips are rarely narrower or wider; a corner outside this range means that the notch was lost.
    if !(0.25..0.75).contains(&corner.x) {
        let x = corner.x.clamp(0.38, 0.6);
        corner = DVec3::new(x, mouth.y, relief.both(x, mouth.y).unwrap_or(mouth.z));
    }
    corner
}

/// The foremost point below the fold under the lower lip, relative to a line that slopes
/// back as chins do.
fn chin(relief: &Relief, mouth: DVec3) -> DVec3 {
    let column = relief.column(0.0, [mouth.y - 1.0, mouth.y - 0.1]);
    let lean = |&[y, depth]: &[f64; 2]| depth + 0.25 * (mouth.y - y).max(0.0);
    let fold = column
        .iter()
        .filter(|point| point[0] > mouth.y - 0.5)
        .min_by(|a, b| lean(a).total_cmp(&lean(b)))
        .map_or(mouth.y - 0.3, |point| point[0]);
    let below = column.iter().filter(|point| point[0] < fold - 0.04);
    let best = below.max_by(|a, b| lean(a).total_cmp(&lean(b)));
    let [y, depth] = best.copied().unwrap_or([mouth.y - 0.55, mouth.z - 0.1]);
    DVec3::new(0.0, y, depth)
}

/// The first point below the chin where the profile is well behind it.
fn jaw_bottom(relief: &Relief, chin: DVec3) -> DVec3 {
    let column = relief.column(0.0, [chin.y - 0.7, chin.y]);
    let behind = column.iter().rev().find(|point| point[1] < chin.z - 0.22);
    let otherwise = DVec3::new(0.0, chin.y - 0.25, chin.z - 0.2);
    behind.map_or(otherwise, |&[y, depth]| DVec3::new(0.0, y, depth.max(chin.z - 0.4)))
}

/// The highest point near the midline, within the height of a head.
fn crown(skin: &[DVec3]) -> DVec3 {
    let near = |p: &&DVec3| p.x.abs() < 0.5 && (0.6..3.2).contains(&p.y) && p.z > -3.5;
    let best = skin.iter().filter(near).max_by(|a, b| a.y.total_cmp(&b.y));
    best.map_or(DVec3::new(0.0, 1.8, -1.2), |p| p.with_x(0.0))
}

/// The largest distance from the midline within a range of heights and depths.
fn widest(skin: &[DVec3], [low, high]: [f64; 2], [back, front]: [f64; 2]) -> f64 {
    let near = skin.iter().filter(|p| (low..high).contains(&p.y) && (back..front).contains(&p.z));
    near.map(|p| p.x.abs()).filter(|x| *x < 2.2).fold(0.0, f64::max)
}

/// Whether each component is the skin, or an ear by its position and size.
fn may_be_ear(at: &[DVec3], points: &Points, skin: u32) -> Vec<bool> {
    let mut reach = vec![[f64::INFINITY, f64::NEG_INFINITY]; points.component_count];
    for (p, &component) in at.iter().zip(&points.component) {
        let [low, high] = &mut reach[component as usize];
        *low = low.min(p.y);
        *high = high.max(p.y);
    }
    let is_small = |[low, high]: [f64; 2]| high - low < 1.8 && low > -1.7 && high < 1.0;
    (0..).zip(reach).map(|(component, reach)| component == skin || is_small(reach)).collect()
}

/// The outermost points of the left and the right ear.
fn ears(at: &[DVec3], points: &Points, may_be_ear: &[bool], half_width: f64) -> [Option<DVec3>; 2] {
    let outermost = |side: f64| {
        let near = |&(index, p): &(usize, &DVec3)| {
            let x = p.x * side;
            let is_beside = x > half_width * 0.8 && x < half_width + 1.2;
            is_beside
                && (-1.0..0.5).contains(&p.y)
                && (-2.4..-0.5).contains(&p.z)
                && may_be_ear[points.component[index] as usize]
        };
        let found = at.iter().enumerate().filter(near);
        let best = found.max_by(|a, b| (a.1.x * side).total_cmp(&(b.1.x * side)))?;
        Some(*best.1).filter(|p| p.x * side > half_width + 0.08)
    };
    [outermost(1.0), outermost(-1.0)]
}

/// The hollow between the collar bones, about as far below the chin as the eyes are above it.
fn neck_base(skin: &[DVec3], relief: &Relief, jaw_bottom: DVec3) -> Option<DVec3> {
    let lowest = skin.iter().filter(|p| p.x.abs() < 0.3 && p.z > -1.6).map(|p| p.y);
    let lowest = lowest.fold(f64::INFINITY, f64::min);
    let y = (jaw_bottom.y - 1.25).max(lowest + 0.03);
    if y > jaw_bottom.y - 0.25 {
        return None;
    }
    let depth = relief.column(0.0, [y - 0.04, y + 0.06]).first().map(|point| point[1]);
    let nearest = || {
        let near = skin.iter().filter(|p| p.x.abs() < 0.3 && (p.y - y).abs() < 0.3);
        near.map(|p| p.z).reduce(f64::max)
    };
    Some(DVec3::new(0.0, y, depth.or_else(nearest)?))
}
