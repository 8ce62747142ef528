//! How a motion becomes a clip, and what became of it.

use super::super::ground::Grounding;
use super::super::soles::Soles;
use super::super::up::Up;
use crate::rig::Skeleton;

/// Where a clip's feet are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ground {
    /// Translations stay as they were recorded, whoever plays them.
    #[default]
    Keep,
    /// Feet stand on y = 0 where the feet of the person who moved stood; ways are as much longer as the
    /// body's legs are. The first frame is at the body's place at rest and faces the front. Needs
    /// [`ClipOptions::performer`]; without, as [`Ground::Feet`].
    Clip,
    /// The same with nobody known: the body's own feet stand where they are low and slow.
    Feet,
}

/// A person who moved.
#[derive(Debug, Clone, Copy)]
pub struct Person<'a> {
    /// The person's joints at rest, in the model's own space.
    pub skeleton: &'a Skeleton,
    /// The person's feet.
    pub soles: Option<&'a Soles>,
}

/// How a motion becomes a clip.
#[derive(Debug, Clone, Copy)]
pub struct ClipOptions<'a> {
    /// Frames a second, at most the motion's own; nothing keeps all frames.
    pub fps: Option<f64>,
    /// Where the clip begins in the motion, in seconds.
    pub start_s: f64,
    /// How long it is at most, in seconds.
    pub seconds: Option<f64>,
    /// Where feet are.
    pub ground: Ground,
    /// Which axis of the recording points up; nothing finds out.
    pub up: Option<Up>,
    /// The person who moved, where it is known: a model with the motion's [`betas`](crate::motion::Motion::betas).
    /// With [`Ground::Keep`] and nobody, a body of the family is taken to be that person, in the space of
    /// its model, and others are set beside the family's mean body.
    pub performer: Option<Person<'a>>,
    /// The feet of the body that plays the clip; nothing takes them from its joints.
    pub soles: Option<&'a Soles>,
}

impl Default for ClipOptions<'_> {
    /// 30 frames a second, all of the motion, where it was recorded.
    fn default() -> Self {
        Self {
            fps: Some(30.0),
            start_s: 0.0,
            seconds: None,
            ground: Ground::Keep,
            up: None,
            performer: None,
            soles: None,
        }
    }
}

/// What became of a motion on a skeleton.
#[derive(Debug, Clone, PartialEq)]
pub struct Retarget {
    /// Joints of the motion that the skeleton lacks; those between others hand their rotations on.
    pub missing: Vec<&'static str>,
    /// Joints of the skeleton that the motion has not: they stay as at rest.
    pub still: Vec<String>,
    /// What translations were multiplied by: the ratio of leg lengths; 1 where they are kept.
    pub scale: f32,
    /// Which axis of the recording was taken to point up.
    pub up: Up,
    /// The motion left no doubt about it, or it was given.
    pub up_is_certain: bool,
    /// The file does not say where the body was: its clip stays in one place.
    pub in_place: bool,
    /// How far the whole clip was turned about the vertical to face the front at its start, in degrees.
    pub turned_deg: f32,
    /// What was done about the ground; nothing where translations are kept.
    pub grounding: Option<Grounding>,
    /// How far an arm at rest was turned to where the family has it, in degrees; 0 for a T.
    pub arms_deg: f32,
}
