//! Outlines of the parts of a face in a photograph, from its landmarks.

use uvgraft::Size;

use crate::landmarks::regions::{
    CHIN, FACE_OVAL, FOREHEAD, LEFT_BROW, LEFT_EYE, LIPS_INNER, LIPS_OUTER, RIGHT_BROW, RIGHT_EYE,
};

/// A closed line in a photograph, in pixels.
#[derive(Debug, Clone)]
pub(crate) struct Outline {
    points: Vec<[f64; 2]>,
    bounds: [f64; 4],
}

impl Outline {
    fn new(landmarks: &[[f64; 3]], indices: &[usize]) -> Self {
        let points: Vec<[f64; 2]> = indices
            .iter()
            .filter_map(|&index| landmarks.get(index))
            .map(|&[x, y, _]| [x, y])
            .collect();
        let mut bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        for &[x, y] in &points {
            bounds = [bounds[0].min(x), bounds[1].min(y), bounds[2].max(x), bounds[3].max(y)];
        }
        Self { points, bounds }
    }

    /// The centres of the pixels in the outline's bounding box, within a photograph.
    pub fn pixels(&self, size: Size) -> impl Iterator<Item = [f64; 2]> + use<> {
        let [left, top, right, bottom] = self.bounds;
        let range = |from: f64, to: f64, side: u32| {
            let limit = |at: f64| at.clamp(0.0, f64::from(side)) as u32;
            limit(from.floor())..limit(to.ceil())
        };
        let (columns, rows) = (range(left, right, size.width), range(top, bottom, size.height));
        rows.flat_map(move |y| {
            columns.clone().map(move |x| [f64::from(x) + 0.5, f64::from(y) + 0.5])
        })
    }

    /// How far a pixel is inside (positive) or outside, up to `reach`; farther out it is `-reach`.
    pub fn depth(&self, [x, y]: [f64; 2], reach: f64) -> f64 {
        let [left, top, right, bottom] = self.bounds;
        if x < left - reach || x > right + reach || y < top - reach || y > bottom + reach {
            return -reach;
        }
        let mut is_inside = false;
        let mut nearest = f64::INFINITY;
        for (k, &[ax, ay]) in self.points.iter().enumerate() {
            let [bx, by] = self.points[(k + 1) % self.points.len()];
            let (dx, dy) = (bx - ax, by - ay);
            let along = ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy).max(1e-12);
            let along = along.clamp(0.0, 1.0);
            nearest = nearest.min((ax + along * dx - x).hypot(ay + along * dy - y));
            // A ray to the right crosses the edge.
            if (ay > y) != (by > y) && x < ax + (y - ay) / dy * dx {
                is_inside = !is_inside;
            }
        }
        if is_inside { nearest } else { (-nearest).max(-reach) }
    }
}

/// The parts of a face that are neither skin nor hair.
#[derive(Debug, Clone)]
pub(crate) struct FaceOutlines {
    pub eyes: [Outline; 2],
    pub brows: [Outline; 2],
    pub lips: Outline,
    /// The edge of the face, from ear to ear and from the forehead to the chin.
    pub oval: Outline,
    /// The opening between the lips.
    pub mouth: Outline,
    /// Unit vector from the chin to the forehead.
    pub up: [f64; 2],
}

impl FaceOutlines {
    /// - `landmarks`: 468 points in pixels.
    pub fn new(landmarks: &[[f64; 3]]) -> Self {
        let outline = |indices: &[usize]| Outline::new(landmarks, indices);
        let at = |index: usize| landmarks.get(index).copied().unwrap_or([0.0; 3]);
        let ([ax, ay, _], [bx, by, _]) = (at(CHIN), at(FOREHEAD));
        let length = (bx - ax).hypot(by - ay).max(1e-9);
        let up = [(bx - ax) / length, (by - ay) / length];
        Self {
            eyes: [outline(&LEFT_EYE), outline(&RIGHT_EYE)],
            brows: [outline(&LEFT_BROW), outline(&RIGHT_BROW)],
            lips: outline(&LIPS_OUTER),
            oval: outline(&FACE_OVAL),
            mouth: outline(&LIPS_INNER),
            up,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_is_the_signed_distance_from_a_square() {
        let square = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0]];
        let outline = Outline::new(&square, &[0, 1, 2, 3]);
        assert_eq!(outline.depth([2.0, 1.0], 9.0), 1.0);
        assert_eq!(outline.depth([-3.0, 2.0], 9.0), -3.0);
        assert_eq!(outline.depth([7.0, 8.0], 9.0), -5.0);
        assert_eq!(outline.depth([-3.0, 2.0], 2.0), -2.0);
    }
}
