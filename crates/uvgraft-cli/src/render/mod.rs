//! `uvgraft render`: images and animations of GLB, VRM and glTF files.

mod camera;
mod options;
mod output;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context;
use uvgraft::Size;
use uvgraft_gltf::scene::{PoseRequest, PosedPrimitive, Scene};
use uvgraft_render::{Background, RenderOptions, Renderer};

pub(crate) use self::camera::Aim;
use self::camera::{Cameras, Shot};
pub(crate) use self::options::aim;
use self::options::{PoseOption, Weight};
use self::output::Output;
use crate::failure::{OrBadInput, bad_input};
use crate::heading;
use crate::report::parse_size;
use crate::terminal;

/// Render a GLB, VRM or glTF file as an image or an animation
///
/// The extension of the output selects the format: .png, .jpg, .webp, .tif, .exr or .gif. An animation
/// (--turntable, --motion) is written as a GIF, an animated WebP, or one numbered file per frame.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// GLB, VRM or glTF file
    #[arg(value_name = "AVATAR")]
    input: PathBuf,
    /// Image or animation to write
    #[arg(short, long, value_name = "OUT", help_heading = heading::FILES)]
    output: PathBuf,
    /// Size in pixels, at most 4096 a side
    #[arg(long, default_value = "768x1024", value_name = "N|WxH", value_parser = parse_size, allow_negative_numbers = true)]
    #[arg(help_heading = heading::FILES)]
    size: Size,
    /// Framing of the model
    #[arg(long, value_enum, value_name = "SHOT", default_value_t = Shot::Body)]
    #[arg(help_heading = heading::CAMERA)]
    camera: Shot,
    /// Frame a bone, a node or a box instead
    ///
    /// A bone by its VRM name (leftHand), any node by its name, or a box given by two corners in
    /// metres.
    #[arg(long, value_name = "BONE|X0,Y0,Z0,X1,Y1,Z1", value_parser = options::aim)]
    #[arg(conflicts_with = "camera", allow_hyphen_values = true, help_heading = heading::CAMERA)]
    look_at: Option<Aim>,
    /// Angle around the person: 0 in front, 90 on their left
    #[arg(long, default_value_t = 20.0, value_name = "DEGREES", allow_hyphen_values = true)]
    #[arg(value_parser = options::finite, help_heading = heading::CAMERA)]
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
    #[arg(long, value_name = "NAME|BONE=X,Y,Z", value_parser = options::pose)]
    #[arg(help_heading = heading::POSE)]
    pose: Vec<PoseOption>,
    /// Expression or morph target and its weight, such as blink=0.8; repeatable
    #[arg(long, value_name = "NAME[=WEIGHT]", value_parser = options::weight)]
    #[arg(help_heading = heading::POSE)]
    expression: Vec<Weight>,
    /// Animation clip, by name or number [default: the first]
    #[arg(long, value_name = "NAME|N", help_heading = heading::POSE)]
    clip: Option<String>,
    /// Time in the animation clip, in seconds
    #[arg(long, value_name = "SECONDS", value_parser = options::seconds, allow_hyphen_values = true)]
    #[arg(help_heading = heading::POSE)]
    frame: Option<f32>,
    /// Turn the camera around the model, in N frames [default: 36]
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "36")]
    #[arg(value_parser = options::turntable, help_heading = heading::MOVING)]
    turntable: Option<u16>,
    /// Play the animation clip
    #[arg(long, conflicts_with = "frame", help_heading = heading::MOVING)]
    motion: bool,
    /// Frame rate [default: 12 with --turntable, 25 with --motion]
    #[arg(long, value_name = "N", value_parser = options::rate, help_heading = heading::MOVING)]
    fps: Option<f32>,
    /// Background: studio, transparent, or a colour such as #ff8000
    #[arg(long, value_name = "BACKGROUND", value_parser = options::background)]
    #[arg(help_heading = heading::APPEARANCE)]
    background: Option<Background>,
    /// Draw plain texture colours without lighting
    #[arg(long, help_heading = heading::APPEARANCE)]
    unlit: bool,
    /// Omit the floor and its shadow
    #[arg(long, help_heading = heading::APPEARANCE)]
    no_floor: bool,
}

/// Longest side in pixels.
const MAX_SIDE: u32 = 4096;

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    if args.size.width.max(args.size.height) > MAX_SIDE {
        let found = args.size;
        return Err(bad_input(format!(
            "--size must be at most {MAX_SIDE} pixels a side, got {found}"
        )));
    }
    let scene = Scene::load(&args.input).or_bad_input()?;
    let name = args.input.display();
    if scene.triangles() == 0 {
        return Err(bad_input(format!("{name}: no triangles to draw")));
    }
    let frames = frames(args, &scene).with_context(|| name.to_string()).or_bad_input()?;
    let fps = args.fps.unwrap_or(if args.motion { 25.0 } else { 12.0 });
    let moving = (args.motion || args.turntable.is_some()).then_some(fps);
    let background = args.background.unwrap_or(if args.unlit {
        Background::Plain([255; 3])
    } else {
        Background::Studio
    });
    let transparent = background == Background::Transparent;
    let output =
        Output::new(&args.output, &args.input, frames.len(), args.size, transparent, moving)?;

    let pose = |frame: &Frame| scene.pose(&frame.posing).with_context(|| name.to_string());
    let aim = args.look_at.clone().unwrap_or(Aim::Shot(args.camera));
    let shows_floor = aim.shows_floor();
    let mut cameras = Cameras::new(aim);
    for frame in &frames {
        let drawn = pose(frame).or_bad_input()?;
        cameras
            .look_at(&scene, &frame.posing, &drawn)
            .with_context(|| name.to_string())
            .or_bad_input()?;
    }
    let angles: Vec<f32> = frames.iter().map(|frame| frame.azimuth).collect();
    let Some(views) = cameras.views(&angles, args.elevation, args.fov, args.size, args.zoom) else {
        return Err(bad_input(format!("{name}: no triangle has a finite position in this pose")));
    };
    // A GIF has no partial transparency for the soft edges of shadows.
    let has_floor = !args.no_floor && shows_floor && !(transparent && output.is_gif());
    let floor = has_floor.then_some(cameras.lowest());
    let options = RenderOptions { lit: !args.unlit, background, floor, ..RenderOptions::default() };
    let renderer = Renderer::for_scene(&scene);
    output.write(frames.len(), |index| {
        let drawn: Vec<PosedPrimitive> = pose(&frames[index])?;
        Ok(renderer.render(&drawn, &views[index], &options, args.size))
    })?;
    if args.print_camera {
        terminal::print(&format!("{}\n", serde_json::to_string(&views[0])?))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// A frame to draw.
struct Frame {
    posing: PoseRequest,
    azimuth: f32,
}

/// All frames; one for a still image.
fn frames(args: &Args, scene: &Scene) -> anyhow::Result<Vec<Frame>> {
    let mut posing = PoseRequest::default();
    for part in &args.pose {
        match part {
            PoseOption::NamedPose(stance) => posing.stance = *stance,
            PoseOption::Bone(bone, degrees) => posing.rotations.push((bone.clone(), *degrees)),
        }
    }
    posing.weights = args.expression.iter().map(|Weight(name, w)| (name.clone(), *w)).collect();
    let clip = clip(args, scene)?;
    if let (Some(clip), Some(frame)) = (clip, args.frame) {
        let uvgraft_gltf::scene::Clip { name, seconds, .. } = &scene.clips()[clip];
        // A little more than the end is the end, as printed with one place.
        if frame > seconds + 0.05 {
            anyhow::bail!(
                "--frame must be within the clip {name:?}, which is {seconds:.2} s long, got \
                 {frame}"
            );
        }
    }
    posing.clip = clip.map(|clip| (clip, args.frame.unwrap_or(0.0)));
    let mut count = usize::from(args.turntable.unwrap_or(1));
    let fps = args.fps.unwrap_or(25.0);
    if args.motion {
        let seconds = clip.map_or(0.0, |clip| scene.clips()[clip].seconds);
        // The last frame would repeat the first.
        let wanted = (seconds * fps).round().max(1.0);
        if wanted > output::MAX_FRAMES as f32 {
            let max = output::MAX_FRAMES;
            anyhow::bail!(
                "{seconds} s at {fps} frames per second must be at most {max} frames, got \
                 {wanted}; use a lower --fps"
            );
        }
        count = wanted as usize;
    }
    let turn = if args.turntable.is_some() { 360.0 / count as f32 } else { 0.0 };
    let frame = |index: usize| {
        let mut posing = posing.clone();
        if let (true, Some((_, seconds))) = (args.motion, &mut posing.clip) {
            *seconds = index as f32 / fps;
        }
        Frame { posing, azimuth: args.azimuth + turn * index as f32 }
    };
    Ok((0..count).map(frame).collect())
}

/// The requested animation clip, if any.
fn clip(args: &Args, scene: &Scene) -> anyhow::Result<Option<usize>> {
    let clips = scene.clips();
    let Some(name) = &args.clip else {
        if clips.is_empty() && (args.motion || args.frame.is_some()) {
            anyhow::bail!("the file has no animations");
        }
        return Ok((args.motion || args.frame.is_some()).then_some(0));
    };
    let by_name = clips.iter().position(|clip| clip.name == *name);
    let by_number = || name.parse().ok().filter(|&index: &usize| index < clips.len());
    match by_name.or_else(by_number) {
        Some(clip) => Ok(Some(clip)),
        None if clips.is_empty() => anyhow::bail!("no clip {name:?}: the file has no animations"),
        None => {
            let numbered = clips.iter().enumerate();
            let known: Vec<String> =
                numbered.take(40).map(|(index, clip)| format!("{index} ({})", clip.name)).collect();
            anyhow::bail!("no clip {name:?}; must be one of {}", known.join(", "))
        }
    }
}
