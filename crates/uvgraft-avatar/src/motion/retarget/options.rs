//! Options for converting a motion to a clip, and a report of the result.

use super::super::ground::Grounding;
use super::super::soles::Soles;
use super::super::up::UpAxis;
use crate::rig::Skeleton;

/// How a clip relates to the ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum GroundMode {
    /// Translations stay as recorded, whatever body plays them.
    #[default]
    Keep,
    /// Feet stand on y = 0 where the performer's feet stood; paths are scaled by the ratio of leg
    /// lengths. The first frame is at the body's rest position and faces the front. Needs
    /// [`ClipOptions::performer`]; without, the same as [`GroundMode::Feet`].
    Clip,
    /// The same without a performer: the body's own feet stand where they are low and slow.
    Feet,
}

uvgraft::choices!(GroundMode {
    Keep => "keep", "Keep translations as recorded";
    Clip => "clip", "Put y = 0 at the ground of the recording, found from the recorded person's feet";
    Feet => "feet", "Put y = 0 at the ground found from the avatar's own feet";
});

/// The performer of a motion.
#[derive(Debug, Clone, Copy)]
pub struct Performer<'a> {
    /// The person's joints at rest, in the space of the body model.
    pub skeleton: &'a Skeleton,
    /// The person's soles.
    pub soles: Option<&'a Soles>,
}

/// Options for converting a motion to a clip.
#[derive(Debug, Clone, Copy)]
pub struct ClipOptions<'a> {
    /// Frames a second, at most those of the motion; `None` keeps all frames.
    pub fps: Option<f64>,
    /// Where the clip begins in the motion, in seconds.
    pub start_s: f64,
    /// Maximum length of the clip, in seconds.
    pub seconds: Option<f64>,
    /// How the clip relates to the ground.
    pub ground: GroundMode,
    /// Which axis of the recording points up; `None` detects it.
    pub up: Option<UpAxis>,
    /// The performer, if known: a model with the motion's [`betas`](crate::motion::Motion::betas).
    /// With [`GroundMode::Keep`] and no performer, a body of the SMPL family is taken to be the
    /// performer, in the space of its model; other bodies are placed as the family's mean body.
    pub performer: Option<Performer<'a>>,
    /// The soles of the body that plays the clip; `None` derives them from its joints.
    pub soles: Option<&'a Soles>,
}

impl Default for ClipOptions<'_> {
    /// The whole motion at 30 frames a second, where it was recorded.
    fn default() -> Self {
        Self {
            fps: Some(30.0),
            start_s: 0.0,
            seconds: None,
            ground: GroundMode::Keep,
            up: None,
            performer: None,
            soles: None,
        }
    }
}

/// Report of how a motion was retargeted.
#[derive(Debug, Clone, PartialEq)]
pub struct Retarget {
    /// Joints of the motion that the skeleton lacks; their rotations are passed on to
    /// their descendants.
    pub missing: Vec<&'static str>,
    /// Joints of the skeleton that the motion lacks: they keep their rest rotation.
    pub still: Vec<String>,
    /// Factor of the translations: the ratio of leg lengths; 1 where they are kept.
    pub scale: f32,
    /// The axis of the recording that was taken to point up.
    pub up: UpAxis,
    /// Whether that axis was given or unambiguous.
    pub up_is_certain: bool,
    /// The file lacks the body's position: its clip stays in place.
    pub in_place: bool,
    /// Rotation of the whole clip about the vertical so that it starts facing the front, in
    /// degrees.
    pub turned_deg: f32,
    /// The corrections of ground contact; `None` where translations are kept.
    pub grounding: Option<Grounding>,
    /// The largest rotation of an arm from its rest direction to the family's, in degrees; 0 for a
    /// T-pose.
    pub arms_deg: f32,
}
