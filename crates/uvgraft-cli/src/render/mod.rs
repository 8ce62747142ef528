//! `uvgraft render`: images and animations of GLB, VRM and glTF files.

mod options;
mod output;

use std::path::PathBuf;
use std::process::ExitCode;

use uvgraft::{Choice, Size};
use uvgraft_assembly::RenderRequest;
use uvgraft_assembly::render::{
    Aim, PoseOption, Shot, parse_background, parse_expression, parse_number,
};
use uvgraft_avatar::motion::UpAxis;
use uvgraft_image::animation::Animation;
use uvgraft_pipeline::parse_memory;
use uvgraft_render::Background;

use self::output::Output;
use crate::choice::choice;
use crate::failure::{Notes, bad_input};
use crate::heading;
use crate::outcome;
use crate::report::parse_size;

/// Render an avatar, or a mesh with a texture, as an image or an animation
///
/// Shows GLB, VRM and glTF files with all that they have, and meshes (OBJ, PLY, body models, parts of
/// models) with --texture. The extension of the output selects the format: .png, .jpg, .webp, .tif, .exr or .gif. An animation
/// (--turntable, --motion) is written as a GIF, an animated WebP, or one numbered file per frame.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// GLB, VRM or glTF file, or a mesh (OBJ, PLY, body model)
    ///
    /// A part of a file, such as avatar.glb#Head, is shown alone, as a mesh.
    #[arg(value_name = "AVATAR|MESH[#PART]")]
    input: PathBuf,
    /// Texture to show; two are shown side by side, as before and after
    ///
    /// On a mesh, or in place of the colour texture of a model that has one.
    #[arg(short, long, value_name = "IMAGE", help_heading = heading::FILES)]
    texture: Vec<PathBuf>,
    /// Image or animation to write
    #[arg(short, long, value_name = "OUT", help_heading = heading::FILES)]
    output: PathBuf,
    /// Up axis of a mesh [default: y]
    #[arg(long, value_name = "AXIS", value_parser = choice::<UpAxis>(), help_heading = heading::FILES)]
    #[arg(allow_hyphen_values = true)]
    up: Option<UpAxis>,
    /// Size in pixels of the picture for each texture, at most 4096 a side
    #[arg(long, default_value = "768x1024", value_name = "N|WxH", value_parser = parse_size, allow_negative_numbers = true)]
    #[arg(help_heading = heading::FILES)]
    size: Size,
    /// Bound on memory, such as 500M or 4G [default: 1G and 200 times the size of the avatar]
    ///
    /// An avatar that could exceed it is refused.
    #[arg(long, value_name = "SIZE", value_parser = parse_memory, allow_negative_numbers = true)]
    #[arg(help_heading = heading::FILES)]
    memory: Option<u64>,
    /// Framing of the model
    #[arg(long, value_name = "SHOT", value_parser = choice::<Shot>())]
    #[arg(default_value = Shot::Body.name(), help_heading = heading::CAMERA)]
    camera: Shot,
    /// Frame a bone, a node or a box instead
    ///
    /// A bone by its VRM name (leftHand), any node by its name, or a box given by two corners in
    /// metres.
    #[arg(long, value_name = "BONE|X0,Y0,Z0,X1,Y1,Z1", value_parser = Aim::parse)]
    #[arg(conflicts_with = "camera", allow_hyphen_values = true, help_heading = heading::CAMERA)]
    look_at: Option<Aim>,
    /// Angle around the person: 0 in front, 90 on their left
    #[arg(long, default_value_t = 20.0, value_name = "DEGREES", allow_hyphen_values = true)]
    #[arg(value_parser = parse_number, help_heading = heading::CAMERA)]
    azimuth: f32,
    /// Angle above the horizon, from -89 to 89
    #[arg(long, default_value_t = 7.0, value_name = "DEGREES", allow_hyphen_values = true)]
    #[arg(value_parser = options::elevation, help_heading = heading::CAMERA)]
    elevation: f32,
    /// Vertical field of view, from 1 to 120
    #[arg(long, default_value_t = 24.0, value_name = "DEGREES", allow_hyphen_values = true)]
    #[arg(value_parser = options::field_of_view, help_heading = heading::CAMERA)]
    fov: f32,
    /// Magnification, from 0.1 to 50
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR", allow_hyphen_values = true)]
    #[arg(value_parser = options::zoom, help_heading = heading::CAMERA)]
    zoom: f32,
    /// Print the camera as JSON
    ///
    /// For the first frame: eye, target, up, fov_y in degrees, near and far.
    #[arg(long, help_heading = heading::CAMERA)]
    print_camera: bool,
    /// Pose by name, or rotation of one bone; repeatable
    ///
    /// Named poses: rest, t-pose, a-pose, stand, wave, walk. A bone is rotated by degrees about X,
    /// Y and Z, as in leftUpperArm=0,0,-40.
    #[arg(long, value_name = "NAME|BONE=X,Y,Z", value_parser = PoseOption::parse)]
    #[arg(help_heading = heading::POSE)]
    pose: Vec<PoseOption>,
    /// Expression or morph target and its weight, such as blink=0.8; repeatable
    #[arg(long, value_name = "NAME[=WEIGHT]", value_parser = parse_expression)]
    #[arg(help_heading = heading::POSE)]
    expression: Vec<(String, f32)>,
    /// Animation clip, by name or number [default: the first]
    #[arg(long, value_name = "NAME|N", help_heading = heading::POSE)]
    clip: Option<String>,
    /// Time in the animation clip, in seconds
    #[arg(long, value_name = "SECONDS", value_parser = options::seconds, allow_hyphen_values = true)]
    #[arg(help_heading = heading::POSE)]
    frame: Option<f32>,
    /// Turn the camera around the model, in N frames [default: 36]
    ///
    /// With --motion, once in the frames of the clip, without N.
    #[arg(long, value_name = "N", num_args = 0..=1)]
    #[arg(value_parser = options::turntable, help_heading = heading::MOVING)]
    turntable: Option<Option<u16>>,
    /// Play the animation clip
    #[arg(long, conflicts_with = "frame", help_heading = heading::MOVING)]
    motion: bool,
    /// Frame rate [default: 12 with --turntable, 25 with --motion]
    #[arg(long, value_name = "N", value_parser = options::rate, help_heading = heading::MOVING)]
    fps: Option<f32>,
    /// Background: studio, transparent, or a colour such as #ff8000
    #[arg(long, value_name = "BACKGROUND", value_parser = parse_background)]
    #[arg(help_heading = heading::APPEARANCE)]
    background: Option<Background>,
    /// Draw plain texture colours without lighting
    #[arg(long, help_heading = heading::APPEARANCE)]
    unlit: bool,
    /// Omit the floor and its shadow
    #[arg(long, help_heading = heading::APPEARANCE)]
    no_floor: bool,
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    if args.motion && args.turntable.flatten().is_some() {
        return Err(bad_input(
            "--turntable N cannot be used with --motion, which has the frames of the clip; use \
             --turntable without N",
        ));
    }
    let request = args.request();
    let rendering = request.open(&Notes)?;
    let output = Output::new(&args.output, &request, rendering.frames())?;
    output.write(&rendering)?;
    if args.print_camera {
        let camera = rendering.camera(0);
        let text = serde_json::to_string(camera)? + "\n";
        outcome::report(|| serde_json::json!({ "camera": camera }), || text)?;
    }
    Ok(ExitCode::SUCCESS)
}

impl Args {
    /// The pictures that the options describe.
    fn request(&self) -> RenderRequest {
        let mut request = RenderRequest::new(&self.input);
        request.textures = self.texture.iter().map(Into::into).collect();
        request.up = self.up;
        request.size = self.size;
        request.aim = self.look_at.clone().unwrap_or(Aim::Shot(self.camera));
        request.azimuth = self.azimuth;
        request.elevation = self.elevation;
        request.fov = self.fov;
        request.zoom = self.zoom;
        request.pose.clone_from(&self.pose);
        request.expressions.clone_from(&self.expression);
        request.clip.clone_from(&self.clip);
        request.frame = self.frame;
        request.motion = self.motion;
        request.turntable = self.turntable.map(|count| count.unwrap_or(options::TURNTABLE));
        request.fps = self.fps;
        request.background = self.background;
        request.unlit = self.unlit;
        request.floor = !self.no_floor;
        request.memory = self.memory;
        let animation = Animation::from_path(&self.output);
        request.hard_edges = animation.is_some_and(|animation| animation.has_hard_edges);
        request
    }
}
