//! Recorded motions, and their ground contact.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use uvgraft_avatar::Avatar;
use uvgraft_avatar::body::{BodyModel, Gender, Shape, Shaped};
use uvgraft_avatar::motion::{ClipOptions, GroundMode, Motion, Performer, Retarget, Soles, UpAxis};
use uvgraft_avatar::rig::Skeleton;
use uvgraft_io::arrays;

use super::betas::far_from_people;
use crate::failure::{OrBadInput, bad_input, note, warn};
use crate::heading;
use crate::number::whole_number;

/// Default frame rate of animations.
const FPS: f64 = 30.0;

/// Options for playing recordings.
#[derive(clap::Args)]
#[command(next_help_heading = heading::ANIMATION)]
pub(super) struct PlayArgs {
    /// AMASS recording to add as an animation (.npz); repeatable
    ///
    /// Recordings replace the demo figure's own animations.
    #[arg(long, value_name = "AMASS.npz")]
    pub(super) motion: Vec<PathBuf>,
    /// Frame rate of the animations, 0 for that of the recording [default: 30]
    #[arg(long, value_name = "N", requires = "motion", value_parser = whole_number::<u16>(0..=240), allow_negative_numbers = true)]
    fps: Option<u16>,
    /// Ground contact of the animations [default: clip]
    ///
    /// `clip` and `feet` scale the path by leg length, keep planted feet planted, and start at the
    /// origin, facing forward. `keep` leaves translations as recorded.
    #[arg(long, value_enum, value_name = "GROUND", requires = "motion")]
    ground: Option<GroundName>,
    /// Up axis of the recordings [default: detected from the motion]
    #[arg(long, value_enum, value_name = "AXIS", requires = "motion")]
    up: Option<UpName>,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum GroundName {
    /// Keep translations as recorded
    Keep,
    /// Put y = 0 at the ground of the recording, found from the recorded person's feet
    Clip,
    /// Put y = 0 at the ground found from the avatar's own feet
    Feet,
}

impl From<GroundName> for GroundMode {
    fn from(name: GroundName) -> Self {
        match name {
            GroundName::Keep => Self::Keep,
            GroundName::Clip => Self::Clip,
            GroundName::Feet => Self::Feet,
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum UpName {
    /// Y up
    Y,
    /// Z up
    Z,
}

impl From<UpName> for UpAxis {
    fn from(name: UpName) -> Self {
        match name {
            UpName::Y => Self::Y,
            UpName::Z => Self::Z,
        }
    }
}

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
    path: PathBuf,
    pub(super) motion: Motion,
}

impl Recording {
    pub(super) fn read(path: &Path) -> anyhow::Result<Self> {
        let found = arrays::read(path).or_bad_input()?;
        let motion = Motion::from_arrays(&found)
            .map_err(|error| bad_input(format!("{}: {error}", path.display())))?;
        Ok(Self { path: path.to_path_buf(), motion })
    }

    /// Adds the motion to the clips of an avatar, and returns the summary of its grounding.
    pub(super) fn add(
        &self,
        playing: &PlayArgs,
        avatar: &mut Avatar,
        performers: &Performers<'_>,
    ) -> anyhow::Result<String> {
        let path = self.path.display();
        let mut ground = playing.ground.map_or(GroundMode::Clip, GroundMode::from);
        let (person, why) = match self.person(performers) {
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
            up: playing.up.map(UpAxis::from),
            performer: known.or(own),
            soles: soles.as_ref(),
            ..ClipOptions::default()
        };
        let name = self.free_name(avatar);
        let (clip, report) = self
            .motion
            .clip(&avatar.skeleton, &name, &options)
            .map_err(|error| bad_input(format!("{path}: {error}")))?;
        if let Some(why) = why {
            note(format_args!("{path}: falling back to --ground feet: {why}"));
        }
        if !report.missing.is_empty() {
            let missing = report.missing.join(", ");
            note(format_args!("{path}: skipped joints that the body lacks: {missing}"));
        }
        if !report.up_is_certain {
            let up = axis(report.up);
            warn(format_args!(
                "{path}: cannot tell the up axis from the motion; assuming {up}; use --up y or \
                 --up z"
            ));
        }
        let frames = clip.poses.len();
        avatar.clips.push(clip);
        Ok(format!("{name}: {}", said(&report, ground, frames)))
    }

    /// The recorded person, as a shape of the body's model; or why it is unknown.
    fn person(&self, performers: &Performers<'_>) -> Result<OwnedPerformer, String> {
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
            warn(format_args!("{}: betas: {said}", self.path.display()));
        }
        let betas = betas[..betas.len().min(model.betas())].to_vec();
        let shaped = model.shaped(&Shape { betas, ..Shape::default() });
        let shaped =
            shaped.map_err(|error| format!("cannot shape a body by its betas: {error}"))?;
        Ok(OwnedPerformer { skeleton: shaped.skeleton().clone(), soles: shaped.soles() })
    }

    /// The stem of the file name, with a number if another clip has the same name.
    fn free_name(&self, avatar: &Avatar) -> String {
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let taken = |name: &str| avatar.clips.iter().any(|clip| clip.name == name);
        (1..)
            .map(|count| if count == 1 { stem.clone() } else { format!("{stem} {count}") })
            .find(|name| !taken(name))
            .unwrap_or_default()
    }
}

const fn axis(up: UpAxis) -> &'static str {
    match up {
        UpAxis::Y => "Y",
        UpAxis::Z => "Z",
    }
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
    if report.up == UpAxis::Y {
        text.push_str(", Y up");
    }
    text
}
