//! Synthetic heads built of rings, in many poses and topologies, and shapes that are not heads.

use glam::{DMat3, DVec3};

use super::*;

/// The value at `at` of a polyline through `[position, value]`, in ascending order of position.
fn line(line: &[[f64; 2]], at: f64) -> f64 {
    let next = line.iter().position(|place| place[0] > at);
    let Some(next) = next.filter(|&next| next > 0) else {
        return if next.is_some() { line[0][1] } else { line[line.len() - 1][1] };
    };
    let [[from, a], [to, b]] = [line[next - 1], line[next]];
    a + (b - a) * (at - from) / (to - from)
}

/// The surface point at a height and an angle around the head, in distances between the eyes.
fn skin(y: f64, angle: f64) -> [f64; 3] {
    let width = [[-3.0, 0.8], [-2.0, 0.75], [-1.2, 1.0], [0.0, 1.2], [0.6, 1.25], [1.2, 1.05]];
    let width = line(&[&width[..], &[[1.6, 0.7], [1.9, 0.02]]].concat(), y);
    let front = [[-3.0, -0.45], [-2.0, -0.4], [-1.85, 0.2], [-1.65, 0.37], [-1.4, 0.33]];
    let lips = [[-1.2, 0.46], [-1.11, 0.41], [-1.02, 0.49], [-0.82, 0.42]];
    let top = [[0.0, 0.36], [0.35, 0.43], [0.8, 0.34], [1.2, 0.12], [1.6, -0.3], [1.9, -1.2]];
    let front = line(&[&front[..], &lips, &top].concat(), y);
    let back = [[-3.0, -1.6], [-1.2, -1.7], [-0.5, -2.3], [0.5, -2.6], [1.2, -2.3], [1.9, -1.25]];
    let back = line(&back, y);
    let x = width * angle.sin();
    let nose = line(&[[-0.85, 0.0], [-0.6, 0.36], [0.0, 0.02], [0.1, 0.0]], y);
    let nose = if angle.cos() > 0.0 { nose * (-(x / 0.16).powi(2)).exp() } else { 0.0 };
    [x, y, 0.5 * (front + back) + 0.5 * (front - back) * angle.cos() + nose]
}

/// Adds a tube of quads.
fn tube(
    positions: &mut Vec<[f64; 3]>,
    faces: &mut Vec<[u32; 3]>,
    [rows, columns]: [u32; 2],
    at: impl Fn(f64, f64) -> [f64; 3],
) {
    let first = positions.len() as u32;
    for row in 0..=rows {
        for column in 0..columns {
            let angle = f64::from(column) / f64::from(columns) * std::f64::consts::TAU;
            positions.push(at(f64::from(row) / f64::from(rows), angle));
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let next = (column + 1) % columns;
            let [a, b] = [column, next].map(|column| first + row * columns + column);
            faces.extend([[a, b, b + columns], [a, b + columns, a + columns]]);
        }
    }
}

/// A head, with eyeballs of radius `eye` if it is not 0.
fn head(eye: f64) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    tube(&mut positions, &mut faces, [160, 90], |v, angle| skin(-3.0 + 4.9 * v, angle));
    for side in [0.5, -0.5] {
        if eye > 0.0 {
            tube(&mut positions, &mut faces, [12, 16], |v, angle| {
                let polar = std::f64::consts::PI * (0.02 + 0.96 * v);
                let ring = eye * polar.sin();
                [side + ring * angle.cos(), eye * polar.cos(), ring * angle.sin()]
            });
        }
    }
    (positions, faces)
}

fn mesh(positions: &[[f64; 3]], faces: &[[u32; 3]]) -> Mesh {
    let positions: Vec<[f32; 3]> = positions.iter().map(|p| p.map(|x| x as f32)).collect();
    let uv_faces = vec![[0; 3]; faces.len()];
    Mesh::from_triangles(positions, vec![[0.0; 2]], faces, &uv_faces).unwrap()
}

/// Rotates around an axis by an angle in degrees, shifts, then scales.
fn posed(positions: &[[f64; 3]], axis: [f64; 3], degrees: f64, scale: f64) -> Vec<[f64; 3]> {
    let turn = DMat3::from_axis_angle(DVec3::from(axis).normalize(), degrees.to_radians());
    let shift = DVec3::new(0.7, 1.9, -0.4);
    let pose = |&p: &[f64; 3]| ((turn * DVec3::from(p) + shift) * scale).to_array();
    positions.iter().map(pose).collect()
}

/// The largest mean difference over all areas.
fn difference(a: &Anatomy, b: &Anatomy) -> f64 {
    let mean = |area| {
        let pairs = a.area(area).iter().zip(b.area(area));
        pairs.map(|(a, b)| f64::from((a - b).abs())).sum::<f64>() / a.area(area).len() as f64
    };
    Area::ALL.into_iter().map(mean).fold(0.0, f64::max)
}

#[test]
fn landmarks_match_the_head() {
    for (eye, tolerance) in [(0.2, 0.06), (0.32, 0.06), (0.0, 0.15)] {
        let (positions, faces) = head(eye);
        let found = Anatomy::find(&mesh(&positions, &faces)).unwrap();
        for (landmark, wanted) in [
            (Landmark::LeftEye, [0.5, 0.0, 0.0]),
            (Landmark::NoseTip, [0.0, -0.6, 0.75]),
            (Landmark::Mouth, [0.0, -1.11, 0.41]),
            (Landmark::Chin, [0.0, -1.65, 0.37]),
            (Landmark::BrowCenter, [0.0, 0.35, 0.43]),
        ] {
            let at = DVec3::from(found.point(landmark).unwrap());
            let distance = at.distance(DVec3::from(wanted));
            assert!(distance < tolerance, "{eye}: {landmark:?} is at {at}");
        }
    }
}

#[test]
fn areas_are_where_they_belong() {
    let (positions, faces) = head(0.2);
    let found = Anatomy::find(&mesh(&positions, &faces)).unwrap();
    let middle = |area: Area| {
        let (mut sum, mut all) = (DVec3::ZERO, 0.0);
        for (p, &value) in positions.iter().zip(found.area(area)) {
            assert!((0.0..=1.0).contains(&value));
            let value = f64::from(value);
            sum += DVec3::new(p[0].abs(), p[1], p[2]) * value;
            all += value;
        }
        sum / all
    };
    for (area, wanted) in [
        (Area::Cheeks, [0.7, -0.55, 0.0]),
        (Area::Forehead, [0.45, 0.75, 0.25]),
        (Area::Lips, [0.2, -1.1, 0.43]),
        (Area::Eyes, [0.5, 0.0, 0.0]),
        (Area::Nose, [0.1, -0.35, 0.55]),
        (Area::Brows, [0.5, 0.4, 0.2]),
    ] {
        let at = middle(area);
        assert!(at.distance(DVec3::from(wanted)) < 0.25, "{area:?} is at {at}");
    }
    for area in [Area::Hands, Area::Feet, Area::MouthInterior] {
        assert!(found.area(area).iter().all(|&value| value == 0.0), "{area:?}");
    }
}

#[test]
fn orientation_and_unit_do_not_matter() {
    for (eye, tolerance) in [(0.2, 0.01), (0.0, 0.04)] {
        let (positions, faces) = head(eye);
        let upright = Anatomy::find(&mesh(&positions, &faces)).unwrap();
        for (axis, degrees, scale) in [
            ([1.0, 0.0, 0.0], 90.0, 1000.0),
            ([0.0, 1.0, 0.0], 180.0, 0.01),
            ([0.0, 0.0, 1.0], -90.0, 63.0),
            ([0.3, -0.5, 0.8], 37.0, 0.06),
        ] {
            let posed = posed(&positions, axis, degrees, scale);
            let found = Anatomy::find(&mesh(&posed, &faces)).unwrap();
            let difference = difference(&upright, &found);
            assert!(difference < tolerance, "{eye}, {axis:?}, {degrees}: {difference}");
            assert!((found.frame().unit / upright.frame().unit / scale - 1.0).abs() < 0.05);
        }
    }
}

#[test]
fn numbering_and_seams_do_not_matter() {
    let (positions, faces) = head(0.2);
    let whole = Anatomy::find(&mesh(&positions, &faces)).unwrap();
    // Unshared vertices for every triangle, in reverse order.
    let corners: Vec<u32> = faces.iter().rev().flatten().copied().collect();
    let apart: Vec<[f64; 3]> = corners.iter().map(|&vertex| positions[vertex as usize]).collect();
    let own: Vec<[u32; 3]> =
        (0..faces.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    let split = Anatomy::find(&mesh(&apart, &own)).unwrap();
    for area in Area::ALL {
        for (corner, &vertex) in corners.iter().enumerate() {
            let [a, b] = [whole.area(area)[vertex as usize], split.area(area)[corner]];
            assert!((a - b).abs() < 1e-3, "{area:?}: {a} and {b}");
        }
    }
}

#[test]
fn shapes_without_a_face_are_refused() {
    let refused = |name: &str, positions: &[[f64; 3]], faces: &[[u32; 3]]| {
        let found = Anatomy::find(&mesh(positions, faces));
        assert!(found.is_err(), "{name} was taken for a head: {:?}", found.map(|f| f.frame));
    };
    let shape = |name: &str, at: &dyn Fn(f64, f64) -> [f64; 3]| {
        let (mut positions, mut faces) = (Vec::new(), Vec::new());
        tube(&mut positions, &mut faces, [40, 60], at);
        refused(name, &positions, &faces);
    };
    let pi = std::f64::consts::PI;
    shape("sphere", &|v, a| [(v * pi).sin() * a.cos(), (v * pi).cos(), (v * pi).sin() * a.sin()]);
    shape("torus", &|v, a| {
        let ring = 1.0 + 0.3 * (2.0 * pi * v).cos();
        [ring * a.cos(), 0.3 * (2.0 * pi * v).sin(), ring * a.sin()]
    });
    shape("plane", &|v, a| [a, v, 0.0]);
    shape("cube", &|v, a| {
        let side = [a.cos(), 2.0 * v - 1.0, a.sin()];
        let largest = side[0].abs().max(side[2].abs());
        [side[0] / largest, side[1], side[2] / largest]
    });
    shape("point", &|_, _| [1.0; 3]);
    shape("line", &|v, _| [v, 2.0 * v, 0.0]);
    let mut random = fastrand::Rng::with_seed(7);
    let soup: Vec<[f64; 3]> = (0..3000).map(|_| [(); 3].map(|()| random.f64())).collect();
    let own: Vec<[u32; 3]> = (0..1000).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    refused("soup", &soup, &own);
    // The eyeballs alone.
    let (positions, faces) = head(0.2);
    let balls = |p: &[u32; 3]| p[0] as usize >= 161 * 90;
    let two: Vec<[u32; 3]> = faces.iter().copied().filter(balls).collect();
    refused("two balls", &positions, &two);
}
