//! The demo figure as an avatar: its files, and pictures of it in motion.

use std::io;
use std::path::Path;

use anyhow::Context;
use uvgraft::{Size, Texture};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::eyes::SeparatedEyes;
use uvgraft_avatar::mouth::Mouth;
use uvgraft_figure::Figure;
use uvgraft_figure::motion::as_amass;
use uvgraft_files::output::write_atomically;
use uvgraft_gltf::glb::{
    self, AvatarMaterial, EmbeddedFormat, EmbeddedImage, Export, Permissions, VrmMeta,
};
use uvgraft_gltf::scene::{PoseRequest, Scene};
use uvgraft_image::animation::write_gif;
use uvgraft_io::arrays::{NamedArrays, NumericArray};
use uvgraft_render::{Perspective, RenderOptions, Renderer};

use uvgraft_assembly::drawing::Sheet;

const PANEL: Size = Size::new(400, 540);
const TURNTABLE: Size = Size::new(300, 450);
const TURNTABLE_FRAMES: u16 = 36;
const TURNTABLE_FPS: f32 = 10.0;

/// The avatar's files, in memory.
pub(super) struct Files {
    pub(super) glb: Vec<u8>,
    pub(super) vrm: Vec<u8>,
    /// The wave as an AMASS file has it.
    pub(super) motion: NamedArrays,
    /// A description for the step report.
    pub(super) summary: String,
}

impl Files {
    /// - `body`: the body's texture with the face.
    pub(super) fn new(figure: &Figure, mut body: Texture) -> anyhow::Result<Self> {
        let mut avatar = figure.avatar().standing()?;
        if let Some(parted) = SeparatedEyes::find(&avatar.mesh)? {
            parted.copy(&mut body);
            avatar.mesh = parted.mesh;
        }
        let mouth = Mouth::fit(&avatar)?;
        mouth.paint(&avatar, &mut body);
        let avatar = mouth.attach(avatar)?;
        let looks = AvatarMaterial::new(EmbeddedImage::encode(body, EmbeddedFormat::Png, 92)?);
        let export = Export { name: "uvgraft's figure".to_owned(), ..Export::default() };
        let file = glb::write(&avatar, &looks, &export)?;
        let authors = vec!["The uvgraft developers".to_owned()];
        let meta = VrmMeta::new(&*export.name, authors, Permissions::EVERYONE);
        let vrm = glb::write(&avatar, &looks, &Export { vrm: Some(meta), ..export })?;
        let summary = format!(
            "GLB and VRM: {} joints, {} expressions, {} animations",
            file.report.joints,
            avatar.expressions.len(),
            file.report.clips
        );
        Ok(Self { glb: file.bytes, vrm: vrm.bytes, motion: amass(&avatar, "wave")?, summary })
    }
}

/// A clip of the figure as an AMASS recording.
pub(super) fn amass(avatar: &Avatar, name: &str) -> anyhow::Result<NamedArrays> {
    let clip = avatar.clips.iter().find(|clip| clip.name == name);
    let clip = clip.with_context(|| format!("a clip `{name}`"))?;
    let amass = as_amass(&avatar.skeleton, clip);
    let mut arrays = NamedArrays::new();
    let mut insert = |name, shape, values| {
        let array = NumericArray::new_f32(shape, values).context("numbers for each frame")?;
        arrays.insert(name, array);
        anyhow::Ok(())
    };
    insert("poses", vec![amass.frames, 156], amass.poses)?;
    insert("trans", vec![amass.frames, 3], amass.trans)?;
    insert("mocap_framerate", vec![], vec![amass.mocap_framerate])?;
    arrays.insert_text("gender", "neutral");
    Ok(arrays)
}

/// Pictures of the avatar, rendered from the written file by the renderer of `uvgraft render`.
pub(super) struct Pictures {
    panels: Vec<(&'static str, Texture)>,
    turntable: Vec<Texture>,
}

impl Pictures {
    pub(super) fn new(glb: &[u8]) -> anyhow::Result<Self> {
        let studio = Studio::new(glb)?;
        let surprise = [("jaw_open", 0.8), ("brows_up", 1.0)];
        let panels = vec![
            ("wave", studio.shot(("wave", 1.2), &[], &body(15.0), PANEL)?),
            ("walk", studio.shot(("walk", 0.15), &[], &body(55.0), PANEL)?),
            ("happy", studio.shot(("idle", 0.0), &[("smile", 1.0)], &head(20.0), PANEL)?),
            ("aa, surprised", studio.shot(("idle", 0.0), &surprise, &head(-25.0), PANEL)?),
        ];
        let mut turntable = Vec::new();
        for frame in 0..TURNTABLE_FRAMES {
            let share = f32::from(frame) / f32::from(TURNTABLE_FRAMES);
            let moment = ("wave", f32::from(frame) / TURNTABLE_FPS);
            turntable.push(studio.shot(moment, &[], &body(15.0 + 360.0 * share), TURNTABLE)?);
        }
        Ok(Self { panels, turntable })
    }

    pub(super) fn write_turntable(&self, path: &Path) -> anyhow::Result<()> {
        write_atomically::<io::Error>(path, |out| {
            write_gif(&self.turntable, TURNTABLE_FPS, out).map_err(io::Error::other)
        })?;
        Ok(())
    }

    pub(super) fn sheet(&self) -> Sheet {
        const CAPTION: u32 = 44;
        const GAP: u32 = 8;
        let columns = self.panels.len() as u32;
        let width = columns * PANEL.width + (columns - 1) * GAP;
        let mut sheet = Sheet::new(Size::new(width, CAPTION + PANEL.height), [24, 26, 30]);
        for (column, (caption, panel)) in (0..).zip(&self.panels) {
            let left = column * (PANEL.width + GAP);
            sheet.paste(panel, left, CAPTION);
            let space = PANEL.width.saturating_sub(Sheet::text_width(caption, 2));
            sheet.text(caption, left + space / 2, 14, 2, [236, 238, 242]);
        }
        sheet
    }
}

/// An avatar on a floor, to be drawn at moments of its clips.
pub(super) struct Studio {
    scene: Scene,
    renderer: Renderer,
}

impl Studio {
    pub(super) fn new(glb: &[u8]) -> anyhow::Result<Self> {
        let scene = Scene::read(glb)?;
        let renderer = Renderer::for_scene(&scene);
        Ok(Self { scene, renderer })
    }

    /// - `weights`: of expressions.
    pub(super) fn shot(
        &self,
        (clip, seconds): (&str, f32),
        weights: &[(&str, f32)],
        camera: &Perspective,
        size: Size,
    ) -> anyhow::Result<Texture> {
        let found = self.scene.clips().iter().position(|found| found.name == clip);
        let found = found.with_context(|| format!("a clip `{clip}`"))?;
        let weights = weights.iter().map(|&(name, weight)| (name.to_owned(), weight)).collect();
        let posing = PoseRequest { clip: Some((found, seconds)), weights, ..Default::default() };
        let options = RenderOptions { floor: Some(0.0), ..RenderOptions::default() };
        Ok(self.renderer.render(&self.scene.pose(&posing)?, camera, &options, size))
    }
}

/// The whole figure, seen from an angle in degrees.
pub(super) fn body(azimuth: f32) -> Perspective {
    around(azimuth, [0.0, 0.93, 0.0], 5.6, 0.5)
}

/// Its head.
pub(super) fn head(azimuth: f32) -> Perspective {
    around(azimuth, [0.0, 1.60, 0.0], 1.25, 0.03)
}

fn around(azimuth: f32, target: [f32; 3], distance: f32, rise: f32) -> Perspective {
    let (sin, cos) = azimuth.to_radians().sin_cos();
    let eye = [target[0] + sin * distance, target[1] + rise, target[2] + cos * distance];
    Perspective { eye, target, up: [0.0, 1.0, 0.0], fov_y: 21.0, near: 0.05, far: 50.0 }
}
