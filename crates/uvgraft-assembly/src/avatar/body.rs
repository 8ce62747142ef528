//! The body: the demo figure, or a model of the SMPL family.

use std::fmt::Display;

use uvgraft::Mesh;
use uvgraft::listing::listed;
use uvgraft_avatar::Avatar;
use uvgraft_avatar::body::{BodyKind, Deviation, ExpressionReport, ModelFile, ReadOptions, Shape};
use uvgraft_figure::Figure;
use uvgraft_files::input::Input;
use uvgraft_pipeline::{Blame, Failure, Observer, Result};

use super::betas::{Betas, far_from_people};
use super::motions::{Performers, Recording};
use super::named_expressions;
use super::request::{AvatarRequest, Body};

/// A rigged body with its animations.
pub(super) struct RiggedBody {
    pub(super) avatar: Avatar,
    /// A description for the summary.
    pub(super) name: String,
    /// The deviation of each clip from the model, which glTF's lack of pose correctives causes;
    /// empty for models without any.
    pub(super) apart: Vec<(String, Deviation)>,
    /// The grounding of each clip, for the summary.
    pub(super) grounds: Vec<String>,
    /// How well the model's expressions could be solved.
    pub(super) solved: Option<(BodyKind, ExpressionReport)>,
    /// The terms of the model, if its file states them.
    pub(super) license: Option<String>,
    /// Whether the model has teeth and a tongue.
    pub(super) has_mouth: bool,
}

impl RiggedBody {
    /// - `mesh`: the mesh of the pair's target, which must be that of the body.
    pub(super) fn new(
        request: &AvatarRequest,
        mesh: &Mesh,
        observer: &dyn Observer,
    ) -> Result<Self> {
        let playing = &request.motions;
        let recordings = playing.recordings.iter().map(|file| Recording::read(file, playing));
        let recordings: Vec<Recording> = recordings.collect::<Result<_>>()?;
        observer.check()?;
        let mut body = match &request.body {
            Body::Figure => Self::figure(request, mesh, &recordings, observer)?,
            Body::Model(model) => Self::model(request, model, mesh, &recordings, observer)?,
        };
        if let Some(model) = &request.expressions {
            observer.begin("carrying the expressions")?;
            named_expressions::add(model, &mut body, observer)?;
        }
        Ok(body)
    }

    fn figure(
        request: &AvatarRequest,
        mesh: &Mesh,
        recordings: &[Recording],
        observer: &dyn Observer,
    ) -> Result<Self> {
        let figure = Figure::new();
        if !is_same(mesh, &figure.body) {
            let (found, wanted) = (mesh.positions().len(), figure.body.positions().len());
            return Err(Failure::option(format!(
                "{}: `body` demo needs the pair written by `uvgraft demo`, whose target must have \
                 {wanted} vertices in its own layout, got {found}; for other bodies, pass a model \
                 file",
                request.pair_name()
            )));
        }
        let mut avatar = figure.avatar();
        // A pair may split quads along the other diagonal, to match the head.
        let positions = avatar.mesh.positions().to_vec();
        avatar.mesh = mesh.clone().with_positions(positions).or_work()?;
        avatar = avatar.standing().or_work()?;
        if !recordings.is_empty() {
            avatar.clips.clear();
        }
        let mut grounds = Vec::new();
        for recording in recordings {
            let performers = Performers::None;
            grounds.push(recording.add(&request.motions, &mut avatar, &performers, observer)?);
        }
        Ok(Self {
            avatar,
            name: "the demo's figure".to_owned(),
            apart: Vec::new(),
            grounds,
            solved: None,
            license: None,
            has_mouth: false,
        })
    }

    fn model(
        request: &AvatarRequest,
        file: &Input,
        mesh: &Mesh,
        recordings: &[Recording],
        observer: &dyn Observer,
    ) -> Result<Self> {
        let refused = |error: &dyn Display| Failure::input(format!("{file}: {error}"));
        let betas = request.betas.as_ref().map(Betas::values).transpose()?.unwrap_or_default();
        if let Some(said) = far_from_people(&betas) {
            observer.warn(format_args!("`betas`: {said}"));
        }
        let of_clips = recordings.iter().filter_map(|recording| recording.motion.betas());
        let needs = ReadOptions {
            betas: of_clips.map(<[f32]>::len).fold(betas.len(), usize::max),
            // Clips are compared with the model, which uses all correctives.
            correctives: !recordings.is_empty(),
        };
        let ModelFile { model, gender, license, parts, unused } =
            ModelFile::read(file, &needs).or_input()?;
        if request.verbose && !unused.is_empty() {
            observer.note(format_args!("{file}: unused: {}", listed(unused)));
        }
        if let Some(why) = model.correctives_left_out() {
            observer.note(format_args!("{file}: pose correctives are left out: {why}"));
        }
        let shape = match &request.shape {
            Some(values) => model
                .named_shape(values)
                .map_err(|error| Failure::option(format!("{file}: `shape`: ")).found(error))?,
            None => Shape { betas, ..Shape::default() },
        };
        let shaped = model.shaped(&shape).map_err(|error| refused(&error))?;
        check_shape(request, shaped.positions())?;
        let mut avatar = shaped.avatar(mesh.clone()).map_err(|error| {
            let pair = request.pair_name();
            Failure::input(format!(
                "{file}: body does not match the target mesh of {pair}: {error}"
            ))
        })?;
        let solved = shaped.add_expressions(&mut avatar).or_work()?;
        let mut avatar = avatar.standing().or_work()?;
        let (mut apart, mut grounds) = (Vec::new(), Vec::new());
        let performers = Performers::Of { model: &model, gender, body: &shaped };
        for recording in recordings {
            observer.begin("retargeting the motions")?;
            grounds.push(recording.add(&request.motions, &mut avatar, &performers, observer)?);
            if let Some(clip) = avatar.clips.last().filter(|_| model.has_correctives()) {
                apart.push((clip.name.clone(), shaped.deviation(&avatar, clip).or_work()?));
            }
        }
        // Of the family, only the open body has named parts.
        let name = match parts.is_empty() {
            true => format!("{} of {file}", model.kind().name()),
            false => format!("the open body of {file}"),
        };
        let solved = Some((model.kind(), solved));
        let has_mouth = parts.iter().any(|part| part == "tongue");
        Ok(Self { avatar, name, apart, grounds, solved, license, has_mouth })
    }
}

/// Rejects a degenerate shape, as produced by extreme betas.
fn check_shape(request: &AvatarRequest, positions: &[[f32; 3]]) -> Result<()> {
    const FARTHEST_M: f32 = 10.0;
    let farthest = positions.iter().flatten().fold(0.0_f32, |most, value| most.max(value.abs()));
    if farthest < FARTHEST_M {
        return Ok(());
    }
    let body = request.body_name();
    let betas = request.betas.as_ref().map_or_else(|| "none".to_owned(), Betas::to_string);
    Err(Failure::option(format!(
        "{body} with `betas` {betas}: vertices must be within metres of the origin, got \
         {farthest} m"
    )))
}

/// Whether two meshes have the same vertices and layout, up to the precision of files.
fn is_same(a: &Mesh, b: &Mesh) -> bool {
    fn is_near<const N: usize>(a: &[[f32; N]], b: &[[f32; N]]) -> bool {
        const NEAR: f32 = 1e-5;
        let near = |(a, b): (&[f32; N], &[f32; N])| (0..N).all(|k| (a[k] - b[k]).abs() < NEAR);
        a.len() == b.len() && a.iter().zip(b).all(near)
    }
    is_near(a.positions(), b.positions()) && is_near(a.uv(), b.uv())
}
