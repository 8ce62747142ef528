//! What does not deform with the skin: eyeballs, teeth, tongue, lashes and hair.

use std::collections::BTreeMap;

use glam::{DMat3, DQuat, DVec3, Vec3};
use uvgraft::correspond::similarity::Similarity;
use uvgraft::deform::DeformationTransfer;
use uvgraft::{Anatomy, Mesh};

use crate::eyes::eyeball::{is_round, pieces, sphere};

/// Fewest vertices of an eyeball.
const FEWEST: usize = 12;
/// Radii of eyeballs, as shares of the size of what moves: real ones have 0.07.
const RADII: [f64; 2] = [0.02, 0.2];
/// Components of which a larger share of vertices is paired are skin.
const PAIRED: f64 = 0.15;
/// Farthest mean distance of counterparts inside the mouth, as a share of the size: about 15 mm.
const COUNTERPART: f64 = 0.09;
/// Farthest distance at which something follows the skin, as a share of the size: about 17 mm.
const FOLLOWS: f64 = 0.1;
/// Rotation of eyes whose source has none, in degrees.
const UP_DEG: f64 = 20.0;
const ACROSS_DEG: f64 = 25.0;

/// An eyeball of the target.
#[derive(Debug, Clone)]
pub(super) struct TargetEye {
    pub vertices: Vec<u32>,
    pub center: DVec3,
    pub radius: f64,
}

/// How a component of the target moves.
#[derive(Debug, Clone)]
enum Part {
    /// It turns about the centre of an eye: as these vertices of the source turn, or by the name of the
    /// expression if there are none. The side is 0 for left, 1 for right, where known.
    Eye { eye: usize, source: Vec<u32>, side: Option<usize> },
    /// As these vertices of the source, rigidly.
    Rigid { vertices: Vec<u32>, source: Vec<u32> },
    /// Each vertex as those of the skin beside it, with weights.
    Following(Vec<(u32, Vec<(u32, f32)>)>),
}

/// The components of the target that are no skin.
#[derive(Debug, Clone)]
pub(super) struct Parts {
    alignment: Similarity,
    source: Vec<DVec3>,
    target: Vec<DVec3>,
    pub eyes: Vec<TargetEye>,
    parts: Vec<Part>,
    /// The head's axes: left, up, forward.
    axes: Option<[DVec3; 3]>,
}

/// A component of a mesh.
struct Component {
    vertices: Vec<u32>,
    ball: Option<(DVec3, f64)>,
}

impl Parts {
    pub fn new(source: &Mesh, target: &Mesh, deform: &DeformationTransfer) -> Self {
        let alignment = *deform.alignment();
        let [from, to] = [source, target].map(places);
        let size = deform.size();
        let source_parts = components(source, size / alignment.scale);
        let largest = source_parts.iter().map(|part| part.vertices.len()).max().unwrap_or(0);
        let is_paired = deform.has_counterpart();
        let anatomy = Anatomy::find(target).ok();
        let frame = anatomy.as_ref().map(Anatomy::frame);
        let axes = frame.map(|frame| frame.axes.map(DVec3::from));
        let origin = frame.map(|frame| DVec3::from(frame.origin));
        let mut new =
            Self { alignment, source: from, target: to, eyes: Vec::new(), parts: Vec::new(), axes };
        let mut skin = vec![false; target.positions().len()];
        let mut loose = Vec::new();
        for part in components(target, size) {
            if let Some((center, radius)) = part.ball {
                let balls = source_parts.iter().filter_map(|part| Some((part, part.ball?)));
                let near = balls
                    .map(|(part, (at, _))| (alignment.apply(at).distance(center), part))
                    .filter(|&(distance, _)| distance < radius)
                    .min_by(|a, b| a.0.total_cmp(&b.0));
                let source = near.map(|(_, part)| part.vertices.clone()).unwrap_or_default();
                let side = axes
                    .zip(origin)
                    .map(|([left, ..], origin)| usize::from((center - origin).dot(left) < 0.0));
                new.parts.push(Part::Eye { eye: new.eyes.len(), source, side });
                new.eyes.push(TargetEye { vertices: part.vertices, center, radius });
                continue;
            }
            let paired = part.vertices.iter().filter(|&&v| is_paired[v as usize]).count();
            if paired as f64 > PAIRED * part.vertices.len() as f64 {
                part.vertices.iter().for_each(|&vertex| skin[vertex as usize] = true);
            } else {
                loose.push(part);
            }
        }
        new.concentric();
        let skin: Vec<u32> = (0..).zip(skin).filter(|(_, is)| *is).map(|(v, _)| v).collect();
        for part in loose {
            let inside = source_parts
                .iter()
                .filter(|other| other.ball.is_none() && other.vertices.len() < largest)
                .map(|other| (new.apart(&part.vertices, &other.vertices), other))
                .filter(|&(distance, _)| distance < COUNTERPART * size)
                .min_by(|a, b| a.0.total_cmp(&b.0));
            new.parts.push(match inside {
                Some((_, other)) => {
                    Part::Rigid { vertices: part.vertices, source: other.vertices.clone() }
                }
                None => Part::Following(new.following(&part.vertices, &skin, FOLLOWS * size)),
            });
        }
        new
    }

    /// Gives shells around one eye (cornea, iris) the centre of the one with the most vertices.
    fn concentric(&mut self) {
        let mut order: Vec<usize> = (0..self.eyes.len()).collect();
        order.sort_by_key(|&eye| std::cmp::Reverse(self.eyes[eye].vertices.len()));
        for (rank, &eye) in order.iter().enumerate() {
            let around = order[..rank].iter().map(|&other| &self.eyes[other]);
            let (center, radius) = (self.eyes[eye].center, self.eyes[eye].radius);
            let inside = around
                .clone()
                .find(|other| other.center.distance(center) < 0.5 * other.radius.max(radius));
            if let Some(found) = inside.map(|other| other.center) {
                self.eyes[eye].center = found;
            }
        }
    }

    /// The mean distance of target vertices from the nearest of some source vertices, in the target.
    fn apart(&self, vertices: &[u32], source: &[u32]) -> f64 {
        const MOST: usize = 100;
        let placed: Vec<DVec3> =
            source.iter().map(|&v| self.alignment.apply(self.source[v as usize])).collect();
        let step = vertices.len().div_ceil(MOST).max(1);
        let chosen: Vec<u32> = vertices.iter().copied().step_by(step).collect();
        let distance = |&vertex: &u32| {
            let at = self.target[vertex as usize];
            let squares = placed.iter().map(|place| place.distance_squared(at));
            squares.fold(f64::INFINITY, f64::min).sqrt()
        };
        chosen.iter().map(distance).sum::<f64>() / chosen.len().max(1) as f64
    }

    /// The nearest vertices of the skin within a distance, by closeness; weights fade with distance.
    fn following(&self, vertices: &[u32], skin: &[u32], reach: f64) -> Vec<(u32, Vec<(u32, f32)>)> {
        const NEAREST: usize = 4;
        let near = |&vertex: &u32| {
            let at = self.target[vertex as usize];
            let mut near: Vec<(f64, u32)> = skin
                .iter()
                .map(|&other| (self.target[other as usize].distance(at), other))
                .filter(|&(distance, _)| distance < reach)
                .collect();
            near.sort_by(|a, b| a.0.total_cmp(&b.0));
            near.truncate(NEAREST);
            let fade = 1.0 - (near.first()?.0 / reach).powi(2);
            let closeness = |distance: f64| (distance + 1e-3 * reach).recip();
            let sum: f64 = near.iter().map(|&(distance, _)| closeness(distance)).sum();
            let weight = |distance: f64| (fade * closeness(distance) / sum) as f32;
            Some((vertex, near.iter().map(|&(d, other)| (other, weight(d))).collect()))
        };
        vertices.iter().filter_map(near).collect()
    }

    /// Replaces the offsets of these components.
    ///
    /// - `from`, `to`: offsets of the source's and of the target's vertices; those of the skin are read.
    pub fn place(&self, name: &str, from: &[[f32; 3]], to: &mut [[f32; 3]]) {
        for part in &self.parts {
            match part {
                Part::Eye { eye, source, side } => {
                    let turn = if source.is_empty() {
                        side.and_then(|side| self.gaze(name, side))
                    } else {
                        self.rigid(source, from).map(|motion| motion.0)
                    };
                    let turn = turn.unwrap_or(DMat3::IDENTITY);
                    let TargetEye { vertices, center, .. } = &self.eyes[*eye];
                    self.move_rigidly(vertices, |at| turn * (at - center) + center, to);
                }
                Part::Rigid { vertices, source } => {
                    let (turn, shift) =
                        self.rigid(source, from).unwrap_or((DMat3::IDENTITY, DVec3::ZERO));
                    self.move_rigidly(vertices, |at| turn * at + shift, to);
                }
                Part::Following(vertices) => {
                    for (vertex, near) in vertices {
                        let sum = near.iter().map(|&(v, w)| Vec3::from(to[v as usize]) * w);
                        to[*vertex as usize] = sum.sum::<Vec3>().to_array();
                    }
                }
            }
        }
    }

    fn move_rigidly(&self, vertices: &[u32], motion: impl Fn(DVec3) -> DVec3, to: &mut [[f32; 3]]) {
        for &vertex in vertices {
            let at = self.target[vertex as usize];
            to[vertex as usize] = (motion(at) - at).as_vec3().to_array();
        }
    }

    /// The rigid motion of source vertices, as a rotation and a translation in the target's space; `None`
    /// if they stay.
    fn rigid(&self, vertices: &[u32], from: &[[f32; 3]]) -> Option<(DMat3, DVec3)> {
        if vertices.iter().all(|&vertex| from[vertex as usize] == [0.0; 3]) {
            return None;
        }
        let pair = |&vertex: &u32| {
            let at = self.source[vertex as usize];
            let moved = at + Vec3::from(from[vertex as usize]).as_dvec3();
            [at, moved].map(|place| self.alignment.apply(place))
        };
        let pairs: Vec<[DVec3; 2]> = vertices.iter().map(pair).collect();
        let found = Similarity::between(&pairs, &vec![1.0; pairs.len()], false)?;
        Some((found.rotation, found.translation))
    }

    /// The rotation of an eye in one of ARKit's expressions of gaze.
    fn gaze(&self, name: &str, side: usize) -> Option<DMat3> {
        let [left, up, _] = self.axes?;
        let way = name.strip_prefix("eyeLook")?.strip_suffix(["Left", "Right"][side])?;
        let outward = [1.0, -1.0][side];
        let (axis, degrees) = match way {
            "Up" => (left, -UP_DEG),
            "Down" => (left, UP_DEG),
            "Out" => (up, outward * ACROSS_DEG),
            "In" => (up, -outward * ACROSS_DEG),
            _ => return None,
        };
        Some(DMat3::from_quat(DQuat::from_axis_angle(axis, degrees.to_radians())))
    }
}

fn places(mesh: &Mesh) -> Vec<DVec3> {
    mesh.positions().iter().map(|&place| Vec3::from(place).as_dvec3()).collect()
}

/// The components of a mesh, by their first vertex; those that are spheres of the size of an eye.
fn components(mesh: &Mesh, size: f64) -> Vec<Component> {
    let mut vertices: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (vertex, piece) in (0..).zip(pieces(mesh)) {
        vertices.entry(piece).or_default().push(vertex);
    }
    let component = |vertices: Vec<u32>| {
        let points: Vec<Vec3> =
            vertices.iter().map(|&vertex| mesh.positions()[vertex as usize].into()).collect();
        let ball = (points.len() >= FEWEST).then(|| sphere(&points)).flatten();
        let ball = ball.filter(|&ball| is_round(&points, ball));
        let ball = ball.map(|(center, radius)| (center.as_dvec3(), f64::from(radius)));
        let ball = ball.filter(|(_, radius)| (RADII[0]..RADII[1]).contains(&(radius / size)));
        Component { vertices, ball }
    };
    vertices.into_values().map(component).collect()
}
