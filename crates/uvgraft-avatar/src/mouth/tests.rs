//! A mouth on the example figure, where it replaces the sack behind the lips.

use std::collections::HashMap;

use glam::{Quat, Vec3};
use uvgraft::{Mesh, Size};
use uvgraft_figure::Figure;
use uvgraft_figure::paint_body;

use super::piece::{Chart, Knot};
use super::*;
use crate::example;
use crate::rig::HumanBone;

struct Subject {
    before: Avatar,
    mouth: Mouth,
    after: Avatar,
}

fn subject() -> Subject {
    let before = example::avatar();
    let mouth = Mouth::fit(&before).unwrap();
    let after = mouth.attach(before.clone()).unwrap();
    Subject { before, mouth, after }
}

impl Subject {
    /// Vertices of a part in the mesh.
    fn vertices(&self, chart: Chart) -> std::ops::Range<usize> {
        let mut first = self.before.mesh.positions().len();
        for (piece, _) in &self.mouth.pieces {
            let range = first..first + piece.points.len();
            if piece.chart == chart {
                return range;
            }
            first = range.end;
        }
        first..first
    }

    fn offsets(&self, morph: &str) -> HashMap<u32, Vec3> {
        let morph = self.after.morphs.iter().find(|found| found.name == morph).unwrap();
        morph.offsets.iter().map(|&(vertex, offset)| (vertex, offset.into())).collect()
    }
}

/// Edges whose uses in the two directions don't cancel out, with the difference.
fn open_edges(mesh: &Mesh) -> HashMap<(u32, u32), i32> {
    let mut edges = HashMap::new();
    for &[a, b, c] in mesh.faces() {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((from.min(to), from.max(to))).or_insert(0) +=
                if from < to { 1 } else { -1 };
        }
    }
    edges.retain(|_, count| *count != 0);
    edges
}

#[test]
fn walls_close_the_head_where_the_sack_was() {
    let subject = subject();
    subject.after.check().unwrap();
    assert!(subject.mouth.rim.is_sack.contains(&true));
    let rim = &subject.mouth.rim.vertices;
    let open = open_edges(&subject.after.mesh);
    for (a, b) in open.keys() {
        assert!(!(rim.contains(a) && rim.contains(b)), "open between {a} and {b}");
    }
    let cavity = subject.vertices(Chart::Cavity);
    assert!(
        !open
            .keys()
            .any(|&(a, b)| cavity.contains(&(a as usize)) || cavity.contains(&(b as usize)))
    );
    assert!((700..1600).contains(&subject.mouth.triangles()), "{}", subject.mouth.triangles());
    // Behind the lips, and no wider than a mouth.
    for (piece, _) in &subject.mouth.pieces {
        assert!(piece.points.iter().all(|point| point.position.is_finite()));
        let most = piece.points.iter().map(|point| point.position.x.abs()).fold(0.0, f32::max);
        assert!(most < 40.0, "{:?} is {most} mm wide", piece.chart);
    }
}

#[test]
fn teeth_follow_skull_and_jaw() {
    let subject = subject();
    let joint = subject.after.skeleton.human(HumanBone::Jaw).unwrap();
    let hinge = Vec3::from(subject.after.skeleton.joints()[joint].position);
    let open = subject.offsets("jaw_open");
    let turn = Quat::from_rotation_x(0.24);
    for vertex in subject.vertices(Chart::Lower).chain(subject.vertices(Chart::Tongue)) {
        let arm = Vec3::from(subject.after.mesh.positions()[vertex]) - hinge;
        let off = open[&(vertex as u32)].distance(turn * arm - arm);
        assert!(off < 2.5e-3, "{vertex}: {off}");
        let share = subject.after.skin.of(vertex).iter().find(|(j, _)| usize::from(*j) == joint);
        assert!(
            share.is_some_and(|(_, weight)| *weight > 0.9),
            "{:?}",
            subject.after.skin.of(vertex)
        );
    }
    for morph in &subject.after.morphs {
        for &(vertex, offset) in &morph.offsets {
            let is_upper = subject.vertices(Chart::Upper).contains(&(vertex as usize));
            assert!(!is_upper, "{} moves the upper teeth by {offset:?}", morph.name);
        }
    }
    // Eyelids don't move the mouth.
    let blink = subject.offsets("blink_left");
    let first = subject.before.mesh.positions().len() as u32;
    assert!(blink.iter().all(|(vertex, offset)| *vertex < first || offset.length() < 2e-5));
}

#[test]
fn walls_follow_the_lips_at_the_rim() {
    let subject = subject();
    let first = subject.vertices(Chart::Cavity).start;
    let (cavity, _) = subject.mouth.pieces.iter().find(|(p, _)| p.chart == Chart::Cavity).unwrap();
    for name in ["smile", "lips_round", "jaw_open"] {
        let offsets = subject.offsets(name);
        let of = |vertex: u32| offsets.get(&vertex).copied().unwrap_or_default();
        // The first ring after the rim follows most of its motion.
        for (k, &rim) in subject.mouth.rim.vertices.iter().enumerate() {
            let Knot::Own(at) = cavity.corners[subject.mouth.rim.vertices.len() + 1 + k].0 else {
                panic!("the second row is the first ring");
            };
            let (lip, wall) = (of(rim), of((first + at) as u32));
            assert!(wall.distance(lip) < 0.4 * lip.length() + 2e-3, "{name} {k}: {lip} {wall}");
        }
    }
}

#[test]
fn its_islands_use_free_space_and_are_painted() {
    let figure = Figure::new();
    let subject = subject();
    let mut texture = paint_body(&figure, Size::square(1024));
    let before = texture.clone();
    subject.mouth.paint(&subject.before, &mut texture);
    // The body's own texels are unchanged.
    for face in 0..subject.before.mesh.faces().len() {
        let uv = subject.before.mesh.uv_triangle(face);
        let middle: [f32; 2] =
            std::array::from_fn(|k| uv.iter().map(|uv| uv[k]).sum::<f32>() / 3.0);
        let [x, y] = middle.map(|value| (value * 1024.0) as u32);
        for channel in 0..3 {
            assert_eq!(before.get(x, y, channel), texture.get(x, y, channel), "face {face}");
        }
    }
    // Incisors are the lightest part.
    let (upper, place) = &subject.mouth.pieces[0];
    assert_eq!(upper.chart, Chart::Upper);
    let [u, v] = place.uv([0.53, 0.6]);
    let texel = |value: f32| (value * 1024.0) as u32;
    assert!(texture.get(texel(u), texel(v), 1) > 0.75);
}

#[test]
fn heads_without_an_opening_get_no_mouth() {
    let mut avatar = example::avatar();
    let sphere = avatar.mesh.positions().iter().map(|&position| {
        let direction = Vec3::from(position) - Vec3::new(0.0, 1.0, 0.0);
        direction.normalize_or(Vec3::X).to_array()
    });
    avatar.mesh = avatar.mesh.clone().with_positions(sphere.collect()).unwrap();
    assert!(Mouth::fit(&avatar).is_err());
}
