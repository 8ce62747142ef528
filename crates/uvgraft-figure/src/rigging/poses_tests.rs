//! The figure in difficult poses: sitting, arms up, deep bends.

use std::collections::HashMap;

use super::*;
use crate::clothes::HEM;
use crate::symmetry::Symmetry as _;

/// Rotation about X, then about the fixed Y, then about the fixed Z axis, in degrees.
fn from_degrees(degrees: [f32; 3]) -> [f32; 4] {
    let [x, y, z] = degrees.map(f32::to_radians);
    (Quat::from_rotation_z(z) * Quat::from_rotation_y(y) * Quat::from_rotation_x(x)).into()
}

/// The figure in a pose, in centimetres.
struct Posed {
    figure: Figure,
    parts: Vec<BodyPart>,
    /// Modelled and posed positions.
    places: [Vec<Vec3>; 2],
}

impl Posed {
    /// - `turns`: bones with their rotations from the T-pose about X, Y and Z, in degrees.
    fn new(turns: &[(HumanBone, [f32; 3])]) -> Self {
        let figure = Figure::new();
        let avatar = figure.avatar();
        let mut pose = Pose::rest(BONES);
        for &(bone, degrees) in turns {
            pose.rotations[bone as usize] = from_degrees(degrees);
        }
        let posed = avatar.posed(&pose, &[]).unwrap();
        let cm = |places: &[[f32; 3]]| places.iter().map(|&p| Vec3::from(p) * 100.0).collect();
        let places = [cm(figure.body.positions()), cm(&posed)];
        Self { parts: figure.parts_of_vertices(), figure, places }
    }

    fn triangles(&self, kind: PartKind) -> Vec<[u32; 3]> {
        let parts = self.figure.body_parts.iter().filter(|part| part.part.kind == kind);
        parts.flat_map(|part| self.figure.body.faces()[part.faces.clone()].to_vec()).collect()
    }

    fn vertices(&self, kind: PartKind, keep: impl Fn(Vec3) -> bool) -> Vec<usize> {
        let modelled = &self.places[0];
        (0..self.parts.len())
            .filter(|&vertex| self.parts[vertex].kind == kind && keep(modelled[vertex]))
            .collect()
    }

    /// Distance of posed vertices outside a part, from the plane of its nearest triangle.
    fn outside(&self, vertices: &[usize], kind: PartKind) -> Vec<f32> {
        let places = &self.places[1];
        let planes: Vec<(Vec3, Vec3)> = self
            .triangles(kind)
            .into_iter()
            .map(|face| {
                let [a, b, c] = face.map(|vertex| places[vertex as usize]);
                ((a + b + c) * (1.0 / 3.0), (b - a).cross(c - a).normalize_or_zero())
            })
            .collect();
        let off = |vertex: &usize| {
            let p = places[*vertex];
            let distance = |plane: &&(Vec3, Vec3)| (p - plane.0).length();
            let nearest = planes.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
            nearest.map_or(0.0, |(middle, normal)| (p - *middle).dot(*normal))
        };
        vertices.iter().map(off).collect()
    }

    /// Angles between posed triangles that share an edge, in degrees, in ascending order.
    fn folds(&self, kind: PartKind, keep: impl Fn(Vec3) -> bool) -> Vec<f32> {
        let [modelled, places] = &self.places;
        let mut normals: HashMap<[u32; 2], Vec3> = HashMap::new();
        let mut folds = Vec::new();
        for face in self.triangles(kind) {
            let middle = face.iter().fold(Vec3::default(), |sum, &v| sum + modelled[v as usize]);
            if !keep(middle * (1.0 / 3.0)) {
                continue;
            }
            let [a, b, c] = face.map(|vertex| places[vertex as usize]);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            for k in 0..3 {
                let mut edge = [face[k], face[(k + 1) % 3]];
                edge.sort_unstable();
                match normals.get(&edge) {
                    Some(other) => folds.push(normal.dot(*other).clamp(-1.0, 1.0).acos()),
                    None => drop(normals.insert(edge, normal)),
                }
            }
        }
        folds.sort_by(f32::total_cmp);
        folds.into_iter().map(f32::to_degrees).collect()
    }
}

const LEGS: [(HumanBone, f32); 2] = [(LEFT.upper_leg, -90.0), (RIGHT.upper_leg, -90.0)];

#[test]
fn thighs_stay_under_the_hem_when_seated() {
    let bend = |degrees: f32| LEGS.map(|(bone, full)| (bone, [full * degrees / 90.0, 0.0, 0.0]));
    for turns in [bend(45.0).to_vec(), bend(90.0).to_vec(), bend(80.0)[..1].to_vec()] {
        let posed = Posed::new(&turns);
        let hem = posed.vertices(PartKind::Shirt, |p| (HEM - 0.5..HEM + 0.5).contains(&p.y));
        let shirt = posed.vertices(PartKind::Shirt, |p| (HEM - 0.5..98.0).contains(&p.y));
        assert!(hem.len() > 40 && shirt.len() > 200);
        let least = |vertices: &[usize]| {
            posed.outside(vertices, PartKind::Leg).into_iter().fold(f32::INFINITY, f32::min)
        };
        // In centimetres. Folds in the loose shirt dip as deep when standing up.
        let (hem, shirt) = (least(&hem), least(&shirt));
        assert!(hem > -0.3 && shirt > -1.0, "hem {hem}, shirt {shirt} outside of the trousers");
    }
}

#[test]
fn sleeves_stay_in_the_shirt_with_arms_up() {
    let turns = [(LEFT.upper_arm, [0.0, 0.0, 75.0]), (RIGHT.upper_arm, [0.0, 0.0, -75.0])];
    let posed = Posed::new(&turns);
    let root = posed.vertices(PartKind::Sleeve, |p| crate::arms::in_arm(p.folded()).x < 1.6);
    assert!(root.len() > 100);
    let most = posed.outside(&root, PartKind::Shirt).into_iter().fold(0.0, f32::max);
    // The same as at rest, where the root bulges over the seam; 1.8 if sleeves follow only the arm.
    assert!(most < 1.1, "a root is {most} cm outside of the shirt");
    // Cloth stretched to twice its length would show the texels of its texture.
    let [modelled, places] = &posed.places;
    let mut stretched: Vec<f32> = posed
        .triangles(PartKind::Shirt)
        .into_iter()
        .flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|edge| {
            let length =
                |places: &[Vec3]| (places[edge[0] as usize] - places[edge[1] as usize]).length();
            length(places) / length(modelled)
        })
        .collect();
    stretched.sort_by(f32::total_cmp);
    let (most, many) = (stretched[stretched.len() - 1], stretched[stretched.len() * 99 / 100]);
    assert!(most < 2.3 && many < 1.6, "cloth is {most} times as long, a hundredth {many} times");
}

#[test]
fn knees_and_elbows_are_round() {
    let turns = [
        (LEFT.upper_leg, [-70.0, 0.0, 0.0]),
        (LEFT.lower_leg, [120.0, 0.0, 0.0]),
        (LEFT.lower_arm, [0.0, -100.0, 0.0]),
    ];
    let posed = Posed::new(&turns);
    let knee = posed.folds(PartKind::Leg, |p| p.x > 0.0 && p.z > 1.0 && (p.y - 50.0).abs() < 14.0);
    let most = knee[knee.len() - 1];
    // Seven rings share 120°; at its sharpest the outline bends over two of them.
    assert!(most < 52.0 && knee[knee.len() * 95 / 100] < 29.0, "a knee has a corner of {most} deg");
    let elbow = posed.folds(PartKind::Arm, |p| {
        p.x > 0.0 && (crate::arms::in_arm(p).x - joints::ELBOW).abs() < 10.0
    });
    let most = elbow[elbow.len() - 1];
    // On the inside of the elbow skin meets skin.
    assert!(most < 80.0, "an elbow has a corner of {most} deg");
}
