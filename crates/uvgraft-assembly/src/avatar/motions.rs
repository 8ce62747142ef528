//! Recorded motions, and their ground contact.

use std::fmt::Write as _;

use uvgraft::Choice;
use uvgraft::listing::listed;
use uvgraft_avatar::Avatar;
use uvgraft_avatar::body::{BodyModel, Gender, Shape, Shaped};
use uvgraft_avatar::motion::{
    ClipOptions, GroundMode, Motion, MotionError, Performer, Retarget, Soles, UpAxis,
};
use uvgraft_avatar::rig::{Clip, HumanBone, Skeleton};
use uvgraft_files::input::Input;
use uvgraft_io::arrays;
use uvgraft_pipeline::{Blame, Failure, Observer, Result};

use super::betas::far_from_people;
use super::request::MotionOptions;

/// Default frame rate of animations.
const FPS: f64 = 30.0;

/// Who may have performed a recording.
pub(super) enum Performers<'a> {
    /// Unknown.
    None,
    /// People as a body model describes them.
    Of {
        model: &'a BodyModel,
        /// The gender of the model, if its file states one.
        gender: Option<Gender>,
        /// The body that plays the clip.
        body: &'a Shaped<'a>,
    },
}

/// Skeleton and soles of a performer, in model space.
struct OwnedPerformer {
    skeleton: Skeleton,
    soles: Option<Soles>,
}

/// A motion read from a file.
pub(super) struct Recording {
    file: Input,
    pub(super) motion: Motion,
}

impl Recording {
    pub(super) fn read(file: &Input, playing: &MotionOptions) -> Result<Self> {
        let found = arrays::read(file).or_input()?;
        let rate = playing.fps.filter(|&fps| fps > 0).map(f64::from);
        let motion = Motion::with_rate(&found, rate).map_err(|error| match error {
            MotionError::NoRate { wanted, found } => Failure::option(
                "use `fps` to state the frame rate of the recording, which has none of ",
            )
            .found(format_args!("{wanted}, but {found}"))
            .context(file),
            error => Failure::input(format!("{file}: {error}")),
        })?;
        Ok(Self { file: file.clone(), motion })
    }

    /// Adds the motion to the clips of an avatar, and returns the summary of its grounding.
    pub(super) fn add(
        &self,
        playing: &MotionOptions,
        avatar: &mut Avatar,
        performers: &Performers<'_>,
        observer: &dyn Observer,
    ) -> Result<String> {
        let file = &self.file;
        let mut ground = playing.ground.unwrap_or(GroundMode::Clip);
        let (person, why) = match self.person(performers, observer) {
            Ok(person) => (Some(person), None),
            Err(why) => (None, Some(why).filter(|_| ground == GroundMode::Clip)),
        };
        if why.is_some() {
            ground = GroundMode::Feet;
        }
        // "As recorded" is relative to the model's own rest pose, which does not stand on y = 0.
        let own = match (performers, ground) {
            (Performers::Of { body, .. }, GroundMode::Keep) => {
                Some(Performer { skeleton: body.skeleton(), soles: None })
            }
            _ => None,
        };
        let known = person
            .as_ref()
            .map(|person| Performer { skeleton: &person.skeleton, soles: person.soles.as_ref() });
        let soles = avatar.soles();
        let options = ClipOptions {
            fps: Some(playing.fps.map_or(FPS, f64::from)).filter(|&fps| fps > 0.0),
            ground,
            up: playing.up,
            performer: known.or(own),
            soles: soles.as_ref(),
            ..ClipOptions::default()
        };
        let name = self.free_name(avatar);
        let (clip, report) = self
            .motion
            .clip(&avatar.skeleton, &name, &options)
            .map_err(|error| Failure::input(format!("{file}: {error}")))?;
        if let Some(why) = why {
            observer.note(format_args!("{file}: falling back to `ground` feet: {why}"));
        }
        self.doubt(&report, observer);
        self.note(playing, observer);
        if ground == GroundMode::Keep {
            self.note_distance(&avatar.skeleton, &clip, observer);
        }
        let frames = clip.poses.len();
        avatar.clips.push(clip);
        Ok(format!("{name}: {}", said(&report, ground, frames)))
    }

    /// Warns of what is implausible, uncertain or not used.
    fn doubt(&self, report: &Retarget, observer: &dyn Observer) {
        let file = &self.file;
        if !report.missing.is_empty() {
            let missing = report.missing.join(", ");
            observer.note(format_args!("{file}: skipped joints that the body lacks: {missing}"));
        }
        if !report.up_is_certain {
            let up = axis(report.up);
            observer.warn(format_args!(
                "{file}: cannot tell the up axis from the motion; assuming {up}; use `up` to state \
                 it"
            ));
        }
        for doubt in self.motion.doubts(report.up) {
            observer.warn(format_args!("{file}: {doubt}"));
        }
        if !self.motion.unused().is_empty() {
            observer.warn(format_args!(
                "{file}: not used, so the face or the hands will not move as recorded: {}",
                listed(self.motion.unused())
            ));
        }
    }

    /// Notes options without effect, and what is assumed.
    fn note(&self, playing: &MotionOptions, observer: &dyn Observer) {
        let (file, rate) = (&self.file, self.motion.rate());
        if self.motion.frames() == 1 {
            observer.note(format_args!("{file}: one frame, so the animation is a pose"));
        } else if self.motion.is_rate_assumed() {
            observer.note(format_args!(
                "{file}: states no frame rate; using {rate} frames per second, as given by `fps`"
            ));
        } else if playing.fps.is_some_and(|fps| f64::from(fps) > rate) {
            observer.note(format_args!(
                "{file}: `fps` has no effect: the recording has {rate} frames per second, and none \
                 are added"
            ));
        }
    }

    /// Tells of a clip that plays elsewhere than where the avatar stands.
    fn note_distance(&self, skeleton: &Skeleton, clip: &Clip, observer: &dyn Observer) {
        /// Beyond the volumes of most capture systems.
        const FAR_M: f32 = 10.0;
        /// More than people lie, sit or jump below and above their hips at rest.
        const HIGH_M: f32 = 1.5;
        let Some(pose) = clip.poses.first() else { return };
        let [x, up, z] = pose.translation;
        let rest = skeleton.human(HumanBone::Hips).map(|hips| skeleton.joints()[hips].position);
        let [rest_x, _, rest_z] = rest.unwrap_or_default();
        let aside = (x + rest_x).hypot(z + rest_z);
        let start = match up.abs() {
            _ if aside > FAR_M => format!("{aside:.1} m from the origin"),
            height if height > HIGH_M => {
                let side = if up < 0.0 { "below" } else { "above" };
                format!("{height:.1} m {side} where the avatar stands")
            }
            _ => return,
        };
        let file = &self.file;
        observer.note(format_args!(
            "{file}: starts {start}; use `ground` clip or feet to start on the ground at the origin"
        ));
    }

    /// The recorded person, as a shape of the body's model; or why it is unknown.
    fn person(
        &self,
        performers: &Performers<'_>,
        observer: &dyn Observer,
    ) -> std::result::Result<OwnedPerformer, String> {
        let Performers::Of { model, gender, .. } = performers else {
            return Err("the demo figure cannot take the shape of the recorded person".to_owned());
        };
        let betas = self.motion.betas().ok_or("the recording has no betas")?;
        if model.named_shapes().is_some() {
            return Err("the recording's betas are for another model than the body".to_owned());
        }
        let (body, clip) = (model.kind(), self.motion.kind());
        if !clip.is_some_and(|clip| clip.shares_shapes_with(body)) {
            let clip = clip.map_or("an unknown model", |kind| kind.name());
            return Err(format!(
                "the recording's betas are for {clip}, but the body is {}",
                body.name()
            ));
        }
        match (self.motion.gender(), gender) {
            (Some(clip), Some(body)) if clip != *body => {
                let (clip, body) = (clip.name(), body.name());
                return Err(format!(
                    "the recorded person uses the {clip} model, but the body the {body} one"
                ));
            }
            (Some(clip), None) => {
                let clip = clip.name();
                return Err(format!(
                    "the recorded person uses the {clip} model, but neither the body's file nor \
                     its name states a gender"
                ));
            }
            (None, Some(body)) => {
                let body = body.name();
                return Err(format!(
                    "the body uses the {body} model, but the recording states no gender"
                ));
            }
            _ => {}
        }
        if let Some(said) = far_from_people(betas) {
            observer.warn(format_args!("{}: betas: {said}", self.file));
        }
        let betas = betas[..betas.len().min(model.betas())].to_vec();
        let shaped = model.shaped(&Shape { betas, ..Shape::default() });
        let shaped =
            shaped.map_err(|error| format!("cannot shape a body by its betas: {error}"))?;
        Ok(OwnedPerformer { skeleton: shaped.skeleton().clone(), soles: shaped.soles() })
    }

    /// The stem of the file name, with a number if another clip has the same name.
    fn free_name(&self, avatar: &Avatar) -> String {
        let stem = self.file.name().file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let taken = |name: &str| avatar.clips.iter().any(|clip| clip.name == name);
        (1..)
            .map(|count| if count == 1 { stem.clone() } else { format!("{stem} {count}") })
            .find(|name| !taken(name))
            .unwrap_or_default()
    }
}

fn axis(up: UpAxis) -> String {
    up.name().to_uppercase()
}

/// Summary of a clip's grounding.
fn said(report: &Retarget, ground: GroundMode, frames: usize) -> String {
    let mut text = match (ground, &report.grounding) {
        (GroundMode::Keep, _) | (_, None) => "translations as recorded".to_owned(),
        (_, Some(_)) if report.in_place => {
            "feet on y = 0; the recording has no translations".to_owned()
        }
        (_, Some(done)) => {
            let whose = if ground == GroundMode::Clip {
                "the recorded person"
            } else {
                "the avatar's feet"
            };
            let mut text = format!(
                "from {whose}; feet planted in {} of {frames} frames, corrected by at most {:.1} cm",
                done.planted,
                done.max_shift_m * 100.0
            );
            if let Some(height) = done.ground_m.filter(|_| ground == GroundMode::Clip) {
                let _ = write!(text, "; recorded ground at {:.1} cm", height * 100.0);
            }
            text
        }
    };
    if (report.scale - 1.0).abs() > 0.0005 {
        let _ = write!(text, ", path scaled by {:.3}", report.scale);
    }
    if report.turned_deg != 0.0 {
        let _ = write!(text, ", turned by {:.0}°", report.turned_deg);
    }
    if report.up != UpAxis::Z {
        let _ = write!(text, ", {} up", axis(report.up));
    }
    text
}
