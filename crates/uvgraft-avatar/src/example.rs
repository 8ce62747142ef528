//! The synthetic figure as an avatar of this crate, for the unit tests.
//!
//! `uvgraft-figure` depends on this crate, so in unit tests its avatars belong to another build of
//! the crate: distinct types with the same contents, which are converted here.

use uvgraft_figure::Figure;

use crate::Avatar;
use crate::rig::{Clip, Expression, HumanBone, Joint, Morph, Pose, Skeleton, Skin};

/// The figure's avatar. No expression is a VRM preset; they only have names.
pub(crate) fn avatar() -> Avatar {
    let figure = Figure::new().avatar();
    let joints: Vec<Joint> = figure
        .skeleton
        .joints()
        .iter()
        .map(|joint| Joint {
            name: joint.name.clone(),
            parent: joint.parent,
            position: joint.position,
            human: joint.human.and_then(|bone| HumanBone::named(bone.name())),
        })
        .collect();
    let influences = (0..figure.skin.vertices()).map(|vertex| {
        figure.skin.of(vertex).iter().map(|&(joint, weight)| (usize::from(joint), weight))
    });
    let skin = Skin::new(influences, joints.len()).unwrap();
    let morphs = figure.morphs.into_iter();
    let expressions = figure.expressions.into_iter();
    let clips = figure.clips.into_iter().map(|clip| {
        let poses = clip
            .poses
            .into_iter()
            .map(|pose| Pose { translation: pose.translation, rotations: pose.rotations });
        Clip { name: clip.name, times: clip.times, poses: poses.collect() }
    });
    Avatar {
        mesh: figure.mesh,
        materials: figure.materials,
        skeleton: Skeleton::new(joints).unwrap(),
        skin,
        morphs: morphs.map(|morph| Morph { name: morph.name, offsets: morph.offsets }).collect(),
        expressions: expressions
            .map(|mix| Expression { name: mix.name, preset: None, morphs: mix.morphs })
            .collect(),
        clips: clips.collect(),
    }
}
