//! An avatar of the open body for the demo.

use std::path::Path;

use anyhow::Context;
use serde_json::Map;
use uvgraft::{Size, Texture};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::body::{BodyModel, Shape};
use uvgraft_avatar::motion::{ClipOptions, GroundMode, Motion};
use uvgraft_figure::Figure;
use uvgraft_gltf::glb::{
    self, AvatarMaterial, EmbeddedFormat, EmbeddedImage, Export, Permissions, VrmMeta,
};
use uvgraft_io::arrays::{self, NamedArrays};
use uvgraft_io::model_mesh;
use uvgraft_open_body::WHEEL_NAME;
use uvgraft_open_body::skin::{SkinOptions, SkinTone, paint_skin};

use super::avatar::{Studio, amass, body, head};
use super::{Outputs, bytes, fetched, row};
use crate::failure::{OrBadInput, bad_input};
use uvgraft_assembly::drawing::Sheet;
use uvgraft_assembly::skin::HAIR;

/// Imports the body from the fetched wheel.
const OPEN: &str = "open";
const TONE: f32 = 0.35;
const PANEL: Size = Size::new(400, 540);

/// The avatar's files, in memory.
pub(super) struct Files {
    pub(super) glb: Vec<u8>,
    pub(super) vrm: Vec<u8>,
    /// Stills of the avatar.
    pub(super) sheet: Sheet,
    /// A description for the step report.
    pub(super) summary: String,
}

impl Files {
    /// - `model`: a model file, or `open`.
    pub(super) fn new(model: &Path, size: Size) -> anyhow::Result<Self> {
        let arrays = read(model)?;
        let (avatar, skin) =
            avatar(&arrays, size).with_context(|| model.display().to_string()).or_bad_input()?;
        let looks = AvatarMaterial::new(EmbeddedImage::encode(skin, EmbeddedFormat::Png, 92)?);
        let license = arrays.text("license").unwrap_or_default();
        let lines: Vec<&str> = license.lines().collect();
        let extras = Map::from_iter([("madeFrom".to_owned(), lines.clone().into())]);
        let export = Export {
            name: "the open body".to_owned(),
            copyright: Some(lines.join("; ")),
            extras,
            ..Export::default()
        };
        let file = glb::write(&avatar, &looks, &export)?;
        let authors = vec!["The uvgraft developers".to_owned()];
        let mut meta = VrmMeta::new(&*export.name, authors, Permissions::EVERYONE);
        meta.third_party_licenses = Some(license.to_owned());
        let export = Export { vrm: Some(meta), extras: Map::new(), ..export };
        let vrm = glb::write(&avatar, &looks, &export)?;
        let summary = format!(
            "{} triangles, {} joints, {} expressions",
            avatar.mesh.faces().len(),
            file.report.joints,
            avatar.expressions.len()
        );
        let sheet = sheet(&file.bytes)?;
        Ok(Self { glb: file.bytes, vrm: vrm.bytes, sheet, summary })
    }
}

impl Files {
    pub(super) fn write(self, outputs: &mut Outputs<'_>) -> anyhow::Result<()> {
        outputs
            .file("open_body.glb", "avatar of the open body", |path| bytes(path, &self.glb))?
            .file("open_body.vrm", "the same as VRM", |path| bytes(path, &self.vrm))?
            .file("open_body.png", "stills of the open body", |path| {
                Ok(self.sheet.write(path)?)
            })?;
        Ok(())
    }
}

fn read(model: &Path) -> anyhow::Result<NamedArrays> {
    if model != Path::new(OPEN) || model.exists() {
        return arrays::read(model).or_bad_input();
    }
    let wheel = fetched(WHEEL_NAME);
    if !wheel.is_file() {
        return Err(bad_input(format!(
            "{} is missing; scripts/fetch-test-data.sh open-body fetches it",
            wheel.display()
        )));
    }
    uvgraft_open_body::read(&wheel).or_bad_input()
}

/// The body with its skin, expressions and the figure's animations.
fn avatar(arrays: &NamedArrays, size: Size) -> anyhow::Result<(Avatar, Texture)> {
    let model = BodyModel::from_arrays(arrays)?;
    let mesh = model_mesh::from_arrays(arrays)?;
    let shaped = model.shaped(&Shape::default())?;
    let mut options = SkinOptions::new(SkinTone::on_scale(TONE));
    options.hair = Some(HAIR);
    let skin = paint_skin(&mesh, &shaped, size, &options);
    let mut avatar = shaped.avatar(mesh)?;
    shaped.add_expressions(&mut avatar)?;
    let mut avatar = avatar.standing()?;
    let soles = avatar.soles();
    let performer = Figure::new().avatar();
    for clip in &performer.clips {
        let motion = Motion::from_arrays(&amass(&performer, &clip.name)?)?;
        let options = ClipOptions {
            ground: GroundMode::Feet,
            soles: soles.as_ref(),
            ..ClipOptions::default()
        };
        avatar.clips.push(motion.clip(&avatar.skeleton, &clip.name, &options)?.0);
    }
    Ok((avatar, skin))
}

fn sheet(glb: &[u8]) -> anyhow::Result<Sheet> {
    let studio = Studio::new(glb)?;
    let smile = [("mouthSmileLeft", 0.8), ("mouthSmileRight", 0.8), ("cheekSquintLeft", 0.5)];
    let surprise = [("jawOpen", 0.6), ("browInnerUp", 1.0)];
    let pictures = [
        studio.shot(("wave", 1.2), &[], &body(15.0), PANEL)?,
        studio.shot(("walk", 0.15), &[], &body(55.0), PANEL)?,
        studio.shot(("idle", 0.0), &smile, &head(20.0), PANEL)?,
        studio.shot(("idle", 0.0), &surprise, &head(-25.0), PANEL)?,
    ];
    Ok(row(&pictures, PANEL))
}
