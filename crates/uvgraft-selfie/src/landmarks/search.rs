//! Finds faces of any size and orientation in a photograph, with a detector that only finds those that
//! fill a good part of its input.
//!
//! The whole photograph is searched first. If no large face is found, tiles of half its size follow;
//! finer tiles, and the photograph on its sides and upside down, only while nothing is found. Every
//! candidate is then looked at again in a crop of its own, upright and of one size, so that scores can
//! be compared, and by the landmark network, which is harder to deceive.

use uvgraft::threads;

use super::FoundFace;
use super::detector::{self, Detection};
use super::mesh;
use super::photo_pyramid::{Crop, PhotoPyramid};
use crate::network::Network;

/// Least score of a candidate, and of a face when it is looked at again. MediaPipe's default; see
/// [`super::refusal`] for what was measured.
const LEAST_SCORE: f64 = 0.5;

/// Side of the crop in which a candidate is looked at again, in sides of its box: about what the head
/// fills in a selfie.
const CLOSER: f64 = 2.5;

/// Tiles are not made smaller than this: a face of 64 pixels fills a third of it.
const LEAST_TILE: f64 = 192.0;

/// Tiles along the longer side of the finest division. With 8 there are up to 225 tiles, which take
/// seconds; with 16 there would be a thousand, to find faces of a fortieth of the photograph.
const MAX_DIVISION: usize = 8;

/// Where the largest face takes this part of the photograph's longer side, it is what the photograph is
/// of, and tiles are not searched for others.
const LARGE: f64 = 1.0 / 6.0;

/// Least score of the landmark network. Of faces from 19 to 800 pixels, tilted, grey, cropped and
/// stylised, it was 0.99 and more; of cloth, wheels and a smiley up to 0.63. Lower than
/// [`super::refusal::LEAST_SCORE`], so that a face that is half hidden is called unclear, not missing.
const LEAST_LANDMARK_SCORE: f64 = 0.7;

/// Score of the landmark network from which a face is surely not upside down. Of fifteen people it was
/// 0.999998 and more; upside down it was 0.98.
const UPRIGHT_SCORE: f64 = 0.9999;

/// The networks that a search needs.
#[derive(Clone, Copy)]
pub(super) struct Searcher<'a> {
    pub(super) detector: &'a Network,
    pub(super) mesh: &'a Network,
    pub(super) picture: &'a PhotoPyramid<'a>,
}

/// A face that both networks confirm.
#[derive(Clone)]
pub(super) struct Confirmed {
    pub(super) face: FoundFace,
    pub(super) points: Vec<[f64; 3]>,
    /// That of the landmark network.
    pub(super) score: f64,
}

impl AsRef<FoundFace> for Confirmed {
    fn as_ref(&self) -> &FoundFace {
        &self.face
    }
}

impl AsRef<FoundFace> for FoundFace {
    fn as_ref(&self) -> &FoundFace {
        self
    }
}

impl Searcher<'_> {
    /// All faces, the largest first.
    pub(super) fn search(self) -> Vec<Confirmed> {
        let [width, height] = self.picture.size();
        let side = width.max(height);
        let whole = Crop { center: [width / 2.0, height / 2.0], side, angle: 0.0 };
        let mut faces = self.search_crops(&[whole]);
        if faces.first().is_some_and(|found| found.face.size() >= LARGE * side) {
            return faces;
        }
        let mut division = 2;
        while division <= MAX_DIVISION && (division == 2 || side / division as f64 >= LEAST_TILE) {
            faces.extend(self.search_crops(&tiles([width, height], division)));
            if !faces.is_empty() {
                return by_size(distinct(faces));
            }
            division *= 2;
        }
        let turned = [1.0, -1.0, 2.0].map(|quarters| {
            let angle = quarters * std::f64::consts::FRAC_PI_2;
            Crop { angle, ..whole }
        });
        self.search_crops(&turned)
    }

    fn search_crops(self, crops: &[Crop]) -> Vec<Confirmed> {
        let candidates = threads::map_indices(crops.len(), |index| {
            let crop = crops[index];
            let found = detector::detect(self.detector, self.picture, &crop, LEAST_SCORE);
            found.into_iter().map(|found| placed(&found, &crop)).collect::<Vec<_>>()
        });
        let candidates = distinct(candidates.concat());
        let closer =
            threads::map_indices(candidates.len(), |index| self.look_closer(&candidates[index]));
        by_size(distinct(closer.into_iter().flatten().collect()))
    }

    /// The candidate again, in the middle of a crop that is upright, or upside down if the face is that
    /// way up rather: forehead and eyes look like chin and mouth. `None` if there is no face then.
    fn look_closer(self, candidate: &FoundFace) -> Option<Confirmed> {
        let (center, side) = (candidate.center, candidate.size());
        let confirmed = |turn: f64| {
            let angle = candidate.eye_angle() + turn;
            let crop = Crop { center, side, angle }.scaled(CLOSER);
            let found = detector::detect(self.detector, self.picture, &crop, LEAST_SCORE);
            // The face of a neighbour may be in sight, too.
            let is_near = |found: &Detection| {
                (0..2).all(|axis| (found.center[axis] - 0.5).abs() < 0.5 / CLOSER)
            };
            let face =
                found.iter().find(|found| is_near(found)).map(|found| placed(found, &crop))?;
            let (points, score) = mesh::find(self.mesh, self.picture, &face);
            (score >= LEAST_LANDMARK_SCORE).then_some(Confirmed { face, points, score })
        };
        let found = confirmed(0.0)?;
        if found.score >= UPRIGHT_SCORE {
            return Some(found);
        }
        let turned = confirmed(std::f64::consts::PI).filter(|turned| turned.score > found.score);
        Some(turned.unwrap_or(found))
    }
}

fn by_size(mut faces: Vec<Confirmed>) -> Vec<Confirmed> {
    faces.sort_by(|a, b| b.face.size().total_cmp(&a.face.size()));
    faces
}

/// Overlapping squares that cover the photograph, `1 / division` of its longer side each.
fn tiles([width, height]: [f64; 2], division: usize) -> Vec<Crop> {
    let side = width.max(height) / division as f64;
    let places = |length: f64| -> Vec<f64> {
        // Half a tile apart or less, so that a face of half a tile is whole in one of them.
        let steps = ((length - side).max(0.0) / (side / 2.0)).ceil();
        (0..=steps as usize)
            .map(|step| {
                let along = if steps > 0.0 { step as f64 / steps } else { 0.5 };
                side / 2.0 + (length - side) * along
            })
            .collect()
    };
    let columns = places(width);
    let row = |y: f64| columns.iter().map(move |&x| Crop { center: [x, y], side, angle: 0.0 });
    places(height).into_iter().flat_map(row).collect()
}

/// A detection of a crop, in the photograph.
fn placed(found: &Detection, crop: &Crop) -> FoundFace {
    FoundFace {
        score: found.score,
        center: crop.position(found.center),
        box_size: found.size.map(|side| side * crop.side),
        angle: crop.angle,
        keypoints: found.keypoints.map(|point| crop.position(point)),
    }
}

/// Each face once, where several crops show it: the best score stays.
fn distinct<T: AsRef<FoundFace>>(mut faces: Vec<T>) -> Vec<T> {
    faces.sort_by(|a, b| b.as_ref().score.total_cmp(&a.as_ref().score));
    let mut kept: Vec<T> = Vec::new();
    for candidate in faces {
        let face = candidate.as_ref();
        // Where one of the two only sees a part of the face, its box is smaller but near.
        let is_same = |other: &T| {
            let other = other.as_ref();
            let apart = (0..2).map(|axis| (other.center[axis] - face.center[axis]).powi(2));
            apart.sum::<f64>().sqrt() < 0.5 * other.size().max(face.size())
        };
        if face.size() > 0.0 && !kept.iter().any(is_same) {
            kept.push(candidate);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_the_photograph_and_overlap_by_half() {
        let found = tiles([400.0, 200.0], 2);
        assert_eq!(found.len(), 3);
        assert_eq!(found[1], Crop { center: [200.0, 100.0], side: 200.0, angle: 0.0 });
        let found = tiles([400.0, 100.0], 2);
        assert!(found.iter().all(|tile| tile.center[1] == 50.0), "{found:?}");
        let found = tiles([300.0, 310.0], 4);
        assert_eq!(found.len(), 49);
        assert_eq!(found[0].center, [38.75; 2]);
        assert!((found[48].center[0] - 261.25).abs() < 1e-9);
    }
}
