//! A small avatar for tests.

use uvgraft::Mesh;
use uvgraft_avatar::Avatar;
use uvgraft_avatar::rig::{Clip, Expression, ExpressionPreset, Joint, Morph, Pose, Skeleton, Skin};

pub(crate) const SIDES: usize = 8;
pub(crate) const RINGS: usize = 7;

/// A tube of 0.6 m with a seam along it; each vertex follows all of its six joints. Both morphs
/// have names; the clip rotates some joints, holds one constant, and leaves one at rest.
pub(crate) fn tube() -> Avatar {
    let mesh = tube_mesh();
    let joints = (0..6_usize).map(|k| Joint {
        name: format!("joint {k}"),
        parent: k.checked_sub(1),
        position: [0.01, 0.1 * k as f32, 0.02],
        human: None,
    });
    let weights = mesh.positions().iter().map(|&[x, y, _]| {
        (0..6).map(move |joint| {
            let distance = y - 0.1 * joint as f32;
            (joint, (-40.0 * distance * distance).exp() * (1.0 + x))
        })
    });
    let skin = Skin::new(weights, 6).unwrap();
    let turns = |t: f32| {
        let held = [0.0, 0.3, 0.0];
        [[0.0; 3], [0.4 * t, 0.0, 0.1], held, [0.0, 2.0 * t, 3.5 * t], [0.0; 3], [0.0, t, 0.0]]
    };
    let frame = |k: usize| {
        let t = k as f32 / 4.0;
        Pose::from_axis_angles([0.1 * t, 0.0, 0.2], &turns(t))
    };
    let all: Vec<[f32; 3]> = mesh.positions().iter().map(|&[x, _, z]| [x, 0.01, z]).collect();
    let morphs = vec![
        Morph { name: "bump".to_owned(), offsets: vec![(20, [0.0, 0.02, 0.01]), (5, [0.01; 3])] },
        Morph::from_dense("thick", &all),
    ];
    Avatar {
        mesh,
        materials: Vec::new(),
        skeleton: Skeleton::new(joints.collect()).unwrap(),
        skin,
        morphs,
        expressions: vec![
            Expression::preset(ExpressionPreset::Happy, vec![(0, 1.0)]),
            Expression { name: "huge".to_owned(), preset: None, morphs: vec![(1, 0.5)] },
        ],
        clips: vec![Clip {
            name: "wave".to_owned(),
            times: (0..5).map(|k| 0.25 * k as f32).collect(),
            poses: (0..5).map(frame).collect(),
        }],
    }
}

fn tube_mesh() -> Mesh {
    let (mut positions, mut uv) = (Vec::new(), Vec::new());
    for ring in 0..RINGS {
        let y = 0.1 * ring as f32;
        for side in 0..=SIDES {
            let around = side as f32 / SIDES as f32;
            let (sin, cos) = (around * std::f32::consts::TAU).sin_cos();
            uv.push([around, 1.0 - y]);
            if side < SIDES {
                positions.push([0.05 * sin, y, 0.05 * cos]);
            }
        }
    }
    let (mut faces, mut uv_faces) = (Vec::new(), Vec::new());
    for ring in 0..RINGS - 1 {
        for side in 0..SIDES {
            let v = |up: usize, on: usize| ((ring + up) * SIDES + (side + on) % SIDES) as u32;
            let t = |up: usize, on: usize| ((ring + up) * (SIDES + 1) + side + on) as u32;
            faces.extend([[v(0, 0), v(0, 1), v(1, 1)], [v(0, 0), v(1, 1), v(1, 0)]]);
            uv_faces.extend([[t(0, 0), t(0, 1), t(1, 1)], [t(0, 0), t(1, 1), t(1, 0)]]);
        }
    }
    Mesh::from_triangles(positions, uv, &faces, &uv_faces).unwrap()
}
