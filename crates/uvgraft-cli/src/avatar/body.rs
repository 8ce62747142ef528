//! The body: the demo figure, or a model of the SMPL family.

use std::path::Path;

use uvgraft::Mesh;
use uvgraft_avatar::Avatar;
use uvgraft_avatar::body::{BodyKind, Deviation, ExpressionReport, ModelFile, ReadOptions, Shape};
use uvgraft_figure::Figure;
use uvgraft_io::arrays;

use super::Args;
use super::betas::far_from_people;
use super::carried;
use super::motions::{Performers, Recording};
use crate::failure::{OrBadInput, bad_input, note, warn};

/// A rigged body with its animations.
pub(super) struct Body {
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

impl Body {
    /// - `mesh`: the mesh of the pair's target, which must be that of the body.
    pub(super) fn new(args: &Args, mesh: &Mesh) -> anyhow::Result<Self> {
        let recordings: Vec<Recording> = args
            .playing
            .motion
            .iter()
            .map(|path| Recording::read(path))
            .collect::<Result<_, _>>()?;
        let mut body = if args.is_figure() {
            Self::figure(args, mesh, &recordings)?
        } else {
            Self::model(args, mesh, &recordings)?
        };
        if let Some(path) = &args.expressions {
            carried::add(path, &mut body)?;
        }
        Ok(body)
    }

    fn figure(args: &Args, mesh: &Mesh, recordings: &[Recording]) -> anyhow::Result<Self> {
        let figure = Figure::new();
        if !is_same(mesh, &figure.body) {
            let (found, wanted) = (mesh.positions().len(), figure.body.positions().len());
            return Err(bad_input(format!(
                "{}: --body demo needs the pair written by `uvgraft demo`, whose target must have \
                 {wanted} vertices in its own layout, got {found}; for other bodies, pass a model \
                 file",
                args.pair_name()
            )));
        }
        let mut avatar = figure.avatar();
        // A pair may split quads along the other diagonal, to match the head.
        avatar.mesh = mesh.clone().with_positions(avatar.mesh.positions().to_vec())?;
        avatar = avatar.standing()?;
        if !recordings.is_empty() {
            avatar.clips.clear();
        }
        let mut grounds = Vec::new();
        for recording in recordings {
            let ground = recording.add(&args.playing, &mut avatar, &Performers::None)?;
            grounds.push(ground);
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

    fn model(args: &Args, mesh: &Mesh, recordings: &[Recording]) -> anyhow::Result<Self> {
        let path = &args.body;
        let refused =
            |error: &dyn std::fmt::Display| bad_input(format!("{}: {error}", path.display()));
        let betas = args.betas.as_deref().map(betas).transpose()?.unwrap_or_default();
        if let Some(said) = far_from_people(&betas) {
            warn(format_args!("--betas: {said}"));
        }
        let of_clips = recordings.iter().filter_map(|recording| recording.motion.betas());
        let needs = ReadOptions {
            betas: of_clips.map(<[f32]>::len).fold(betas.len(), usize::max),
            // Clips are compared with the model, which uses all correctives.
            correctives: !recordings.is_empty(),
        };
        let ModelFile { model, gender, license, parts, unused } =
            ModelFile::read(path, &needs).or_bad_input()?;
        if args.verbose && !unused.is_empty() {
            note(format_args!("{}: unused: {}", path.display(), unused.join(", ")));
        }
        let shape = match &args.shape {
            Some(values) => values.of(&model, path)?,
            None => Shape { betas, ..Shape::default() },
        };
        let shaped = model.shaped(&shape).map_err(|error| refused(&error))?;
        check_shape(args, shaped.positions())?;
        let mut avatar = shaped.avatar(mesh.clone()).map_err(|error| {
            let (body, pair) = (path.display(), args.pair_name());
            bad_input(format!("{body}: body does not match the target mesh of {pair}: {error}"))
        })?;
        let solved = shaped.add_expressions(&mut avatar)?;
        let mut avatar = avatar.standing()?;
        let (mut apart, mut grounds) = (Vec::new(), Vec::new());
        let performers = Performers::Of { model: &model, gender, body: &shaped };
        for recording in recordings {
            grounds.push(recording.add(&args.playing, &mut avatar, &performers)?);
            if let Some(clip) = avatar.clips.last().filter(|_| model.has_correctives()) {
                apart.push((clip.name.clone(), shaped.deviation(&avatar, clip)?));
            }
        }
        let name = format!("{} of {}", model.kind().name(), path.display());
        let solved = Some((model.kind(), solved));
        let has_mouth = parts.iter().any(|part| part == "tongue");
        Ok(Self { avatar, name, apart, grounds, solved, license, has_mouth })
    }
}

/// Rejects a degenerate shape, as produced by extreme betas.
fn check_shape(args: &Args, positions: &[[f32; 3]]) -> anyhow::Result<()> {
    const FARTHEST_M: f32 = 10.0;
    let farthest = positions.iter().flatten().fold(0.0_f32, |most, value| most.max(value.abs()));
    if farthest < FARTHEST_M {
        return Ok(());
    }
    let (body, betas) = (args.body.display(), args.betas.as_deref().unwrap_or("none"));
    Err(bad_input(format!(
        "{body} with --betas {betas}: vertices must be within metres of the origin, got \
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

/// Parses numbers, or reads the array `betas` of a file.
pub(super) fn betas(text: &str) -> anyhow::Result<Vec<f32>> {
    let wanted = |found: &str| {
        let wanted = "must be numbers such as 0.5,-1.2, or a file that holds them";
        bad_input(format!("--betas {text}: {wanted}; got {found}"))
    };
    let numbers: Result<Vec<f32>, _> =
        text.split([',', ' ']).filter(|part| !part.is_empty()).map(str::parse).collect();
    let values = match numbers {
        Ok(numbers) => numbers,
        Err(_) if Path::new(text).exists() => {
            let found = arrays::read(Path::new(text)).or_bad_input()?;
            let array = found.require("betas").map_err(|error| wanted(&error.to_string()))?;
            // Betas of one person, possibly as a matrix of one row.
            if !matches!(array.shape(), [_] | [1, _]) {
                return Err(wanted(&format!("`betas` of shape {:?}", array.shape())));
            }
            array.f32s().into_owned()
        }
        Err(_) => return Err(wanted("no such file")),
    };
    match values.iter().find(|value| !value.is_finite()) {
        Some(value) => Err(wanted(&value.to_string())),
        None if values.is_empty() => Err(wanted("none")),
        None => Ok(values),
    }
}
