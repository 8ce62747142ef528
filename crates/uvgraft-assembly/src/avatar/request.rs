//! What an avatar is made of, and how.

use std::path::PathBuf;

use uvgraft::{Filter, MapOptions, NormalY, Prefer, Size, choices};
use uvgraft_avatar::motion::{GroundMode, UpAxis};
use uvgraft_files::input::Input;
use uvgraft_gltf::glb::{EmbeddedFormat, Permissions, ShadingModel};
use uvgraft_gltf::preset::Preset;
use uvgraft_pipeline::{BaseSource, BlendSettings, Region};

use super::betas::Betas;
use super::materials::MapRole;
use crate::selfie::PhotoOptions;

/// A request for an animated full-body avatar, from the texture of a head or from photographs.
///
/// The face is transferred onto the body's texture and blended; the body gets its skeleton,
/// expressions, a mouth and animations. [`AvatarRequest::new`] has the defaults of all options.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct AvatarRequest {
    /// What the file will be called, for messages. The extension decides between GLB (`.glb`) and
    /// VRM 1.0 (`.vrm`); the stem is the avatar's name, unless the metadata have a title.
    pub file_name: PathBuf,
    /// The body.
    pub body: Body,
    /// The pair file that links the head to the body. Bodies that contain a head of their own need
    /// none with photographs: the built-in figure and the open body.
    pub pair: Option<Input>,
    /// The face's texture in the head's layout: an image, a texture dump of FATE (`.pth`), or the
    /// folder of a FATE workspace. This or [`AvatarRequest::photos`].
    pub face: Option<Input>,
    /// Photographs of one person, or a folder of frames, that the texture and the shape of the head
    /// are made of.
    pub photos: Vec<Input>,
    /// How photographs are read.
    pub photo_options: PhotoOptions,
    /// How much of the face's shape in photographs the head gets, 0 to 1.
    pub likeness: f64,
    /// The base of the body's colours: an image in its layout, or a colour. With photographs, bodies
    /// with a painted skin of their own need none.
    pub onto: Option<BaseSource>,
    /// Shape coefficients of the body.
    pub betas: Option<Betas>,
    /// The body's shape by names, of bodies that have some.
    pub shape: Option<Vec<(String, f32)>>,
    /// A model file whose named expressions are transferred to the body.
    pub expressions: Option<Input>,
    /// Animations.
    pub motions: MotionOptions,
    /// The textures.
    pub textures: TextureOptions,
    /// Maps other than colours, and shading.
    pub materials: MaterialOptions,
    /// The interior of the mouth.
    pub mouth: MouthStyle,
    /// The appearance of the eyes.
    pub eyes: EyeStyle,
    /// The region of the linked surface to use.
    pub region: Region,
    /// How the face is blended into the base; by default by a membrane, in the tone of the face.
    pub blending: BlendSettings,
    /// The trusted texels of the face: an image, white on black, in its layout.
    pub source_mask: Option<Input>,
    /// A mean texture, in the face's layout, for unseen areas.
    pub fill: Option<Input>,
    /// Whether a picture of the region and its weights on both layouts is wanted.
    pub preview: bool,
    /// Levels of detail.
    pub levels: LevelOptions,
    /// The platform whose limits the avatar keeps.
    pub preset: Option<&'static Preset>,
    /// Maximum number of triangles; by default the preset's, or unlimited.
    pub triangles: Option<u32>,
    /// Who made the avatar, and who may do what with it.
    pub metadata: Metadata,
    /// Whether arrays of the body model that are not used are noted.
    pub verbose: bool,
}

/// A body.
#[derive(Debug, Clone, PartialEq)]
pub enum Body {
    /// The built-in figure.
    Figure,
    /// A model file of the SMPL family (SMPL, SMPL-H, SMPL-X or FLAME), or the open body.
    Model(Input),
}

/// Recorded motions to add as animations.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MotionOptions {
    /// AMASS recordings. They replace the figure's own animations.
    pub recordings: Vec<Input>,
    /// Frame rate of the animations, 0 for that of the recording; by default 30. Also the rate of
    /// recordings that state none.
    pub fps: Option<u16>,
    /// Ground contact; by default [`GroundMode::Clip`].
    pub ground: Option<GroundMode>,
    /// Up axis of the recordings; by default detected.
    pub up: Option<UpAxis>,
}

/// The textures of an avatar.
#[derive(Debug, Clone, PartialEq)]
pub struct TextureOptions {
    /// Size of the body's texture; by default the base's, within the preset.
    pub size: Option<Size>,
    /// One texture, or the head's beside the body's.
    pub layout: TextureLayout,
    /// Image format of the textures; by default the preset's, or PNG.
    pub format: Option<EmbeddedFormat>,
    /// Quality of JPEG textures, 1 to 100; by default 92.
    pub quality: Option<u8>,
    /// The interpolation filter; by default Lanczos-3 for colours and bilinear for data.
    pub filter: Option<Filter>,
    /// Width of the gutter around UV islands, in texels.
    pub gutter_px: u32,
    /// The island that owns texels that several cover.
    pub prefer: Prefer,
}

impl Default for TextureOptions {
    fn default() -> Self {
        Self {
            size: None,
            layout: TextureLayout::Atlas,
            format: None,
            quality: None,
            filter: None,
            gutter_px: MapOptions::default().gutter_px,
            prefer: Prefer::First,
        }
    }
}

/// The layout of an avatar's textures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TextureLayout {
    /// The body's, with the face in it.
    Atlas,
    /// The body's, and the head's own beside it.
    HeadBody,
}

choices!(TextureLayout {
    Atlas => "atlas", "One texture in the body's layout: one material, one draw call";
    HeadBody => "head+body",
        "The head keeps its layout, so the face is not resampled: two materials";
});

/// Maps other than colours, and shading.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MaterialOptions {
    /// Maps of the face, in the head's layout.
    pub maps: Vec<(MapRole, Input)>,
    /// Maps of the body, in its layout, or constants.
    pub base_maps: Vec<(MapRole, BaseSource)>,
    /// Green channel convention of the maps; those of the avatar follow glTF.
    pub normal_y: NormalY,
    /// Shading model.
    pub look: ShadingModel,
}

/// The interior of the mouth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MouthStyle {
    /// A fitted cavity with teeth and tongue.
    Fitted,
    /// As the body has it.
    None,
}

choices!(MouthStyle {
    Fitted => "fitted",
        "Fit a cavity with teeth and tongue where the mesh is open between the lips";
    None => "none", "Add nothing to the body's mesh";
});

/// The appearance of the eyes. Either way, each eye gets a UV island of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum EyeStyle {
    /// As in the face's texture.
    Keep,
    /// Redrawn.
    Clean,
}

choices!(EyeStyle {
    Keep => "keep", "Keep the eyes of the face texture";
    Clean => "clean",
        "Redraw sclera, iris and pupil in the eye colour of the face texture";
});

/// Coarser levels of detail, each with about half the triangles of the one before.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LevelOptions {
    /// Number of levels besides the finest.
    pub count: u8,
    /// Where they are.
    pub storage: LevelStorage,
}

/// Where levels of detail are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum LevelStorage {
    /// In files of their own.
    #[default]
    Files,
    /// In the avatar's file.
    Msft,
}

choices!(LevelStorage {
    Files => "files", "Separate files: NAME.lod1.glb, NAME.lod2.glb, ...";
    Msft => "msft",
        "One .glb with MSFT_lod; readers without support show the finest level";
});

/// Who made an avatar, and who may do what with it. A VRM file must say so, and has no defaults.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Metadata {
    /// Name of the avatar; by default the stem of the file's name.
    pub title: Option<String>,
    /// The authors; at least one for VRM.
    pub authors: Vec<String>,
    /// What others may do with the avatar; for VRM, which must have it, and for VRM only.
    pub license: Option<Permissions>,
    /// URL of further terms; for VRM only.
    pub license_url: Option<String>,
    /// Third-party content and its licences; for VRM only.
    pub made_from: Option<String>,
}

impl AvatarRequest {
    /// A request with the defaults of all options, and without a face, which must be given.
    ///
    /// - `file_name`: see [`AvatarRequest::file_name`].
    pub fn new(body: Body, file_name: impl Into<PathBuf>) -> Self {
        Self {
            file_name: file_name.into(),
            body,
            pair: None,
            face: None,
            photos: Vec::new(),
            photo_options: PhotoOptions::default(),
            likeness: 1.0,
            onto: None,
            betas: None,
            shape: None,
            expressions: None,
            motions: MotionOptions::default(),
            textures: TextureOptions::default(),
            materials: MaterialOptions::default(),
            mouth: MouthStyle::Fitted,
            eyes: EyeStyle::Keep,
            region: Region::default(),
            blending: BlendSettings::default(),
            source_mask: None,
            fill: None,
            preview: false,
            levels: LevelOptions::default(),
            preset: None,
            triangles: None,
            metadata: Metadata::default(),
            verbose: false,
        }
    }

    /// The body's model file, unless it is the figure.
    pub(super) fn model(&self) -> Option<&Input> {
        match &self.body {
            Body::Figure => None,
            Body::Model(model) => Some(model),
        }
    }

    /// What to call the body in messages.
    pub(super) fn body_name(&self) -> String {
        self.model().map_or_else(|| "demo".to_owned(), Input::to_string)
    }
}
