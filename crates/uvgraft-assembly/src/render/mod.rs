//! Pictures of GLB, VRM and glTF files and of meshes: one, or one for each frame of an animation.

mod camera;
mod frames;
mod panels;
mod parse;

use std::collections::BTreeMap;

use uvgraft::listing::listed;
use uvgraft::{Size, Texture};
use uvgraft_avatar::motion::UpAxis;
use uvgraft_files::input::Input;
use uvgraft_gltf::scene::{NamedPose, PoseRequest, Scene};
use uvgraft_pipeline::{Blame, Context, Failure, Observer, Result};
use uvgraft_render::{Background, Perspective, RenderOptions, Renderer};

use self::camera::Cameras;
pub use self::camera::{Aim, Shot};
use self::frames::Frame;
pub use self::frames::MAX_FRAMES;
pub use self::parse::{parse_background, parse_expression, parse_number};
use crate::scene_memory::Bound;
use crate::shown::{self, Shown};

/// A request for pictures of a GLB, VRM or glTF file of any origin, or of a mesh.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct RenderRequest {
    /// The file: a model, a mesh, or a part of a file such as `me.glb#Head`, which is shown as a mesh.
    pub avatar: Input,
    /// Textures to show on it in place of its own, at most two: each in a picture of its own, side by side.
    pub textures: Vec<Input>,
    /// The axis of a mesh that points up; by default Y, as always in models.
    pub up: Option<UpAxis>,
    /// Size of the picture for each texture in pixels, at most 4096 a side.
    pub size: Size,
    /// What fills the picture.
    pub aim: Aim,
    /// Angle around the person in degrees: 0 in front, 90 on their left.
    pub azimuth: f32,
    /// Angle above the horizon in degrees, -89 to 89.
    pub elevation: f32,
    /// Vertical field of view in degrees, 1 to 120.
    pub fov: f32,
    /// Magnification, 0.1 to 50.
    pub zoom: f32,
    /// Poses by name, and rotations of bones, in order.
    pub pose: Vec<PoseOption>,
    /// Expressions and morph targets, with their weights.
    pub expressions: Vec<(String, f32)>,
    /// Animation clip, by name or number; by default the first, if it is played.
    pub clip: Option<String>,
    /// Time in the clip in seconds, at least 0; by default the clip is not played.
    pub frame: Option<f32>,
    /// Whether the clip is played: a picture for each of its frames.
    pub motion: bool,
    /// Number of frames in which the camera goes around the model.
    pub turntable: Option<u16>,
    /// Frame rate, 0.1 to 240; by default 25 for clips and 12 for turntables.
    pub fps: Option<f32>,
    /// The background; by default a studio, or white if unlit.
    pub background: Option<Background>,
    /// Whether textures are shown without lighting.
    pub unlit: bool,
    /// Whether there is a floor, with a shadow.
    pub floor: bool,
    /// Bound on the memory of the process, in bytes: a file that could exceed it is refused. By default a file may
    /// take memory by its size, a gibibyte and 200 times as much.
    pub memory: Option<u64>,
    /// Whether pictures will have no partial opacity, as in a GIF: transparent ones then have no floor,
    /// whose shadow has soft edges.
    pub hard_edges: bool,
}

/// A pose by name, or the rotation of one bone.
#[derive(Debug, Clone, PartialEq)]
pub enum PoseOption {
    /// A pose that is known by name.
    Named(NamedPose),
    /// A bone and its rotation about x, y and z in degrees.
    Bone(String, [f32; 3]),
}

/// Textures that are shown side by side.
const MAX_TEXTURES: usize = 2;

/// Longest side in pixels.
const MAX_SIDE: u32 = 4096;

/// Bytes of a picture while it is drawn and encoded, by pixel and for shadows and bands of samples; measured at
/// 768×1024 and 4096².
const PIXEL: u64 = 32;
const PICTURE: u64 = 80 << 20;

impl RenderRequest {
    /// A request with the defaults of all options: the whole model, from the front and somewhat above.
    pub fn new(avatar: impl Into<Input>) -> Self {
        Self {
            avatar: avatar.into(),
            textures: Vec::new(),
            up: None,
            size: Size::new(768, 1024),
            aim: Aim::Shot(Shot::Body),
            azimuth: 20.0,
            elevation: 7.0,
            fov: 24.0,
            zoom: 1.0,
            pose: Vec::new(),
            expressions: Vec::new(),
            clip: None,
            frame: None,
            motion: false,
            turntable: None,
            fps: None,
            background: None,
            unlit: false,
            floor: true,
            memory: None,
            hard_edges: false,
        }
    }

    /// All inputs.
    pub fn inputs(&self) -> impl Iterator<Item = &Input> {
        [&self.avatar].into_iter().chain(&self.textures)
    }

    /// Size of a frame in pixels: as wide as all pictures side by side.
    pub fn frame_size(&self) -> Size {
        panels::size(self.size, self.textures.len())
    }

    /// Reads the file and finds the cameras of all frames.
    ///
    /// # Errors
    /// As bad input for a file that cannot be drawn, and for values outside of their ranges.
    pub fn open(&self, observer: &dyn Observer) -> Result<Rendering> {
        self.check()?;
        let textures = self.textures.iter();
        let textures = textures.map(|it| shown::texture(it, self.memory, observer));
        let textures = textures.collect::<Result<Vec<_>>>()?;
        let bound = Bound::new(self.memory, PICTURE + self.frame_size().texels() as u64 * PIXEL);
        let scene = match Shown::read(&self.avatar, self.up, !textures.is_empty(), observer)? {
            Shown::Model(input) => bound.loaded(Scene::load_within(&input, bound.budget()))?,
            Shown::Mesh { mesh, name } => {
                let model = shown::model(&mesh, &name, Vec::new())?;
                bound.read(Scene::read_within(&model, bound.budget()))?
            }
        };
        let name = &self.avatar;
        if scene.triangles() == 0 {
            return Err(Failure::input(format!("{name}: no triangles to draw")));
        }
        let frames = self.frames(&scene).context(name)?;
        let mut cameras = Cameras::new(self.aim.clone());
        for Frame { posing, .. } in &frames {
            let drawn = scene.pose(posing).or_input().context(name)?;
            cameras.look_at(&scene, posing, &drawn).context(name)?;
        }
        let angles: Vec<f32> = frames.iter().map(|frame| frame.azimuth).collect();
        let views = cameras.views(&angles, self.elevation, self.fov, self.size, self.zoom);
        let views = views.ok_or_else(|| {
            Failure::input(format!("{name}: no triangle has a finite position in this pose"))
        })?;
        let background = self.background();
        let is_cut_out = background == Background::Transparent && self.hard_edges;
        let has_floor = self.floor && self.aim.shows_floor() && !is_cut_out;
        let floor = has_floor.then_some(cameras.lowest());
        let options = RenderOptions { lit: !self.unlit, background, floor, ..Default::default() };
        let renderers = match textures.is_empty() {
            true => vec![Renderer::for_scene(&scene)],
            false => retextured(&scene, &textures).context(name)?,
        };
        let (name, size) = (name.to_string(), self.size);
        Ok(Rendering { name, scene, renderers, frames, views, options, size })
    }

    /// The background, with its default.
    pub fn background(&self) -> Background {
        self.background.unwrap_or(if self.unlit {
            Background::Plain([255; 3])
        } else {
            Background::Studio
        })
    }

    /// The frame rate of an animation; `None` for a still picture.
    pub fn rate(&self) -> Option<f32> {
        let rate = self.fps.unwrap_or(if self.motion { 25.0 } else { 12.0 });
        (self.motion || self.turntable.is_some()).then_some(rate)
    }

    fn check(&self) -> Result<()> {
        if self.textures.len() > MAX_TEXTURES {
            let found = self.textures.len();
            return Err(Failure::option(format!(
                "`texture` must be given at most {MAX_TEXTURES} times, for before and after, got {found}"
            )));
        }
        if self.size.width.max(self.size.height) > MAX_SIDE {
            let found = self.size;
            return Err(Failure::option(format!(
                "`size` must be at most {MAX_SIDE} pixels a side, got {found}"
            )));
        }
        if self.fps.is_some() && self.rate().is_none() {
            return Err(Failure::option(
                "`fps` has no effect on a still picture: it needs `motion` or a turntable",
            ));
        }
        self.check_pose()?;
        let seconds = self.frame.unwrap_or(0.0);
        for (name, value, least, most) in [
            ("azimuth", self.azimuth, f32::MIN, f32::MAX),
            ("elevation", self.elevation, -89.0, 89.0),
            ("fov", self.fov, 1.0, 120.0),
            ("zoom", self.zoom, 0.1, 50.0),
            ("frame", seconds, 0.0, f32::MAX),
        ] {
            if !(least..=most).contains(&value) {
                let wanted = if most == f32::MAX {
                    "a finite number, and not negative for times".to_owned()
                } else {
                    format!("{least} to {most}")
                };
                return Err(Failure::option(format!("`{name}` must be {wanted}, got {value}")));
            }
        }
        Ok(())
    }
}

impl RenderRequest {
    /// Rejects poses and weights that others would replace.
    fn check_pose(&self) -> Result<()> {
        let named: Vec<&str> = self
            .pose
            .iter()
            .filter_map(|part| match part {
                PoseOption::Named(pose) => Some(pose.name()),
                PoseOption::Bone(..) => None,
            })
            .collect();
        if let [first, second, ..] = *named {
            return Err(Failure::option(format!(
                "`pose` must name one pose, got {first} and {second}"
            )));
        }
        for (index, (name, _)) in self.expressions.iter().enumerate() {
            if self.expressions[..index].iter().any(|(other, _)| other == name) {
                return Err(Failure::option(format!("`expression` {name}: given twice")));
            }
        }
        Ok(())
    }
}

/// Renderers of a scene, each with another texture in place of the scene's.
fn retextured(scene: &Scene, textures: &[Texture]) -> Result<Vec<Renderer>> {
    let drawn = scene.pose(&PoseRequest::default()).or_work()?;
    let materials = drawn.iter().map(|primitive| &scene.materials()[primitive.material]);
    let replaced: BTreeMap<usize, &str> =
        materials.filter_map(|it| Some((it.texture?.index, &*it.name))).collect();
    let Some((&index, _)) = replaced.first_key_value() else {
        return Err(Failure::input("has no colour texture that `texture` could replace"));
    };
    if replaced.len() > 1 {
        let names = listed(replaced.values().map(|name| format!("{name:?}")));
        return Err(Failure::input(format!(
            "has {} colour textures, of the materials {names}, and `texture` would replace one: add \
             `#` and a node, mesh or material to its name, which is then shown alone",
            replaced.len()
        )));
    }
    Ok(textures.iter().map(|texture| Renderer::with_texture(scene, index, texture)).collect())
}

/// A model whose frames can be drawn, in any order.
pub struct Rendering {
    name: String,
    scene: Scene,
    /// One for each picture of a frame.
    renderers: Vec<Renderer>,
    frames: Vec<Frame>,
    views: Vec<Perspective>,
    options: RenderOptions,
    size: Size,
}

impl Rendering {
    /// Number of pictures, at least one.
    pub fn frames(&self) -> usize {
        self.frames.len()
    }

    /// The camera of a frame.
    ///
    /// # Panics
    /// If there is no such frame.
    pub fn camera(&self, frame: usize) -> &Perspective {
        &self.views[frame]
    }

    /// Draws frames: 8-bit sRGB, with opacity if the background is transparent.
    pub fn pictures(&self) -> impl Iterator<Item = Result<Texture>> {
        self.frames.iter().zip(&self.views).map(|(frame, view)| {
            let drawn = self.scene.pose(&frame.posing).or_work().context(&self.name)?;
            let renderers = self.renderers.iter();
            let panels = renderers.map(|it| it.render(&drawn, view, &self.options, self.size));
            panels::joined(panels.collect())
        })
    }
}
