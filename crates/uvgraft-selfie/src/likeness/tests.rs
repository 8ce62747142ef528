//! On the demo's figure, whose head is also in its body.

use glam::{DMat3, DVec3};
use uvgraft::{Anatomy, HeadFrame, Pair};
use uvgraft_figure::Figure;

use super::*;

struct Example {
    pair: Pair,
    anatomy: Anatomy,
    head: Vec<DVec3>,
    body: Vec<[f32; 3]>,
}

impl Example {
    fn new() -> Self {
        let figure = Figure::new();
        let ids: Vec<i64> = figure.vertex_map.iter().map(|&id| id.into()).collect();
        let body = figure.body.positions().to_vec();
        let pair = Pair::by_vertex_map(figure.head, figure.body, &ids).unwrap();
        let anatomy = Anatomy::find(pair.source()).unwrap();
        let at = |at: &[f32; 3]| glam::Vec3::from(*at).as_dvec3();
        let head = pair.source().positions().iter().map(at).collect();
        Self { pair, anatomy, head, body }
    }

    /// The head with its surface moved, in eye distances.
    fn shaped(&self, by: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<DVec3> {
        let frame: &HeadFrame = self.anatomy.frame();
        let moved = |&at: &DVec3| {
            let local = frame.local(at.to_array());
            let by = by(local);
            DVec3::from(frame.world([0, 1, 2].map(|k| local[k] + by[k])))
        };
        self.head.iter().map(moved).collect()
    }

    fn carried(&self, shaped: &[DVec3]) -> Likeness {
        Likeness::new(&self.pair, &self.anatomy, shaped, &self.body).unwrap()
    }
}

/// A wider jaw and a longer nose; the same on both sides.
fn wider([x, y, z]: [f64; 3]) -> [f64; 3] {
    let jaw = (-((y + 1.3).powi(2)) / 0.5).exp();
    let nose = (-(x * x + (y + 0.6).powi(2)) / 0.1).exp() * smoothstep_f64(-0.3, 0.2, z);
    [0.15 * x * jaw, 0.0, 0.1 * nose]
}

#[test]
fn the_shape_at_rest_changes_nothing() {
    let example = Example::new();
    let likeness = example.carried(&example.head);
    assert_eq!(likeness.positions(1.0), example.body);
    let eye = example.anatomy.point(uvgraft::Landmark::LeftEye).unwrap().map(|value| value as f32);
    assert_eq!(likeness.point(eye, 1.0), eye);
}

#[test]
fn the_body_gets_the_shape_and_keeps_its_neck() {
    let example = Example::new();
    let shaped = example.shaped(wider);
    let likeness = example.carried(&shaped);
    let (whole, half) = (likeness.positions(1.0), likeness.positions(0.5));
    let frame = example.anatomy.frame();
    let (mut most, mut below) = (0.0_f64, 0.0_f64);
    for (vertex, rest) in example.body.iter().enumerate() {
        let at = |place: [f32; 3]| glam::Vec3::from(place).as_dvec3();
        let moved = at(whole[vertex]) - at(*rest);
        assert!((at(half[vertex]) - at(*rest) - moved * 0.5).length() < 1e-6);
        most = most.max(moved.length() / frame.unit);
        if frame.local(at(*rest).to_array())[1] < -3.5 {
            below = below.max(moved.length());
        }
    }
    assert!((0.05..0.3).contains(&most), "{most}");
    assert!(below < 1e-4, "{below}");
}

#[test]
fn both_sides_move_alike() {
    let example = Example::new();
    let positions = example.carried(&example.shaped(wider)).positions(1.0);
    let key = |[x, y, z]: [f32; 3]| [x, y, z].map(|value| (value * 1e5).round() as i64);
    let at: std::collections::HashMap<[i64; 3], usize> =
        example.body.iter().enumerate().map(|(vertex, &at)| (key(at), vertex)).collect();
    let mut mates = 0;
    for (vertex, &[x, y, z]) in example.body.iter().enumerate() {
        if let Some(&mate) = at.get(&key([-x, y, z])) {
            let ([a, b, c], [p, q, r]) = (positions[vertex], positions[mate]);
            let off = (a + p).abs().max((b - q).abs()).max((c - r).abs());
            assert!(off < 2e-4, "{vertex}: {off}");
            mates += 1;
        }
    }
    assert!(mates > example.head.len() / 2, "{mates}");
}

#[test]
fn no_triangle_is_turned_over_and_eyeballs_keep_their_shape() {
    let example = Example::new();
    let positions = example.carried(&example.shaped(wider)).positions(1.0);
    let normal = |positions: &[[f32; 3]], face: &[u32; 3]| {
        let [a, b, c] = face.map(|vertex| glam::Vec3::from(positions[vertex as usize]).as_dvec3());
        (b - a).cross(c - a).normalize_or_zero()
    };
    for face in example.pair.target().faces() {
        let cosine = normal(&example.body, face).dot(normal(&positions, face));
        assert!(cosine > 0.5 || cosine == 0.0, "{face:?}: {cosine}");
    }
    let mesh = example.pair.target();
    let eyes = mesh.parts().iter().filter(|part| part.group.starts_with("eye"));
    let mut count = 0;
    for part in eyes {
        let corners =
            part.polygons.clone().flat_map(|polygon| mesh.polygon_corners(polygon as usize));
        let moves = corners.map(|corner| {
            let vertex = corner.vertex as usize;
            glam::Vec3::from(positions[vertex]) - glam::Vec3::from(example.body[vertex])
        });
        let moves: Vec<glam::Vec3> = moves.collect();
        assert!(moves.iter().all(|by| (*by - moves[0]).length() < 1e-6));
        count += 1;
    }
    assert_eq!(count, 2);
}

#[test]
fn a_larger_body_that_faces_elsewhere_moves_accordingly() {
    let mut example = Example::new();
    let shaped = example.shaped(wider);
    let plain = example.carried(&shaped);
    let (turn, shift) = (DMat3::from_rotation_y(0.8), DVec3::new(0.3, -1.0, 2.0));
    let placed =
        |at: [f32; 3]| (turn * glam::Vec3::from(at).as_dvec3() * 2.0 + shift).as_vec3().to_array();
    let wanted: Vec<[f32; 3]> = plain.positions(1.0).into_iter().map(placed).collect();
    example.body = example.body.iter().map(|&at| placed(at)).collect();
    for (found, wanted) in example.carried(&shaped).positions(1.0).into_iter().zip(wanted) {
        assert!((glam::Vec3::from(found) - glam::Vec3::from(wanted)).length() < 1e-4);
    }
}
