//! `uvgraft render`: pictures of GLB, VRM and glTF files.

mod camera;
mod options;
mod output;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context;
use uvgraft::Size;
use uvgraft_gltf::scene::{Drawn, Posing, Scene};
use uvgraft_render::{Background, Look, Renderer};

pub(crate) use self::camera::Aim;
use self::camera::{Cameras, Shot};
pub(crate) use self::options::aim;
use self::options::{Part, Weight};
use self::output::Output;
use crate::failure::{OrBadInput, bad_input};
use crate::report::{parse_size, to_stdout};

/// Draws a picture of a GLB, VRM or glTF file, or a moving one.
///
/// The extension decides what is written: .png, .jpg, .webp, .tif or .gif. A moving picture
/// (--turntable, --motion) is a GIF, an animated WebP, or a numbered file for each frame.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// GLB, VRM or glTF file
    #[arg(value_name = "AVATAR")]
    input: PathBuf,
    /// File to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Size of the picture, at most 4096 a side
    #[arg(long, default_value = "768x1024", value_name = "N|WxH", value_parser = parse_size)]
    size: Size,
    /// What fills the picture
    #[arg(long, value_enum, default_value_t = Shot::Body)]
    camera: Shot,
    /// What fills the picture instead: a bone by VRM's name (leftHand), any node by its name, or a
    /// box by two corners in metres
    #[arg(long, value_name = "BONE|X0,Y0,Z0,X1,Y1,Z1", value_parser = options::aim)]
    #[arg(conflicts_with = "camera", allow_hyphen_values = true)]
    look_at: Option<Aim>,
    /// Degrees around the person: 0 in front, 90 at the left side
    #[arg(long, default_value_t = 20.0, value_name = "DEGREES", allow_hyphen_values = true)]
    #[arg(value_parser = options::finite)]
    azimuth: f32,
    /// Degrees above the horizon, from -89 to 89
    #[arg(long, default_value_t = 7.0, value_name = "DEGREES", allow_hyphen_values = true)]
    #[arg(value_parser = options::elevation)]
    elevation: f32,
    /// Angle of view from top to bottom in degrees, from 1 to 120
    #[arg(long, default_value_t = 24.0, value_name = "DEGREES", allow_hyphen_values = true)]
    #[arg(value_parser = options::field_of_view)]
    fov: f32,
    /// How many times as large, from 0.1 to 50
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR", allow_hyphen_values = true)]
    #[arg(value_parser = options::zoom)]
    zoom: f32,
    /// A pose (rest, t-pose, a-pose, stand, wave, walk), or a bone turned by degrees about X, Y and
    /// Z, as leftUpperArm=0,0,-40; may be given several times
    #[arg(long, value_name = "NAME|BONE=X,Y,Z", value_parser = options::part)]
    pose: Vec<Part>,
    /// An expression or morph target and its weight, as blink=0.8; may be given several times
    #[arg(long, value_name = "NAME[=WEIGHT]", value_parser = options::weight)]
    expression: Vec<Weight>,
    /// Which animation, by its name or number; the first one unless told
    #[arg(long, value_name = "NAME|N")]
    clip: Option<String>,
    /// Time in the animation, in seconds
    #[arg(long, value_name = "SECONDS", value_parser = options::seconds, allow_hyphen_values = true)]
    frame: Option<f32>,
    /// A moving picture from all around, of N frames
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "36")]
    #[arg(value_parser = options::turntable)]
    turntable: Option<u16>,
    /// A moving picture of the animation
    #[arg(long, conflicts_with = "frame")]
    motion: bool,
    /// Frames a second of a moving picture; 12 for a turntable, 25 for a motion unless told
    #[arg(long, value_name = "N", value_parser = options::rate)]
    fps: Option<f32>,
    /// studio, transparent, or a colour as #rrggbb
    #[arg(long, value_name = "WHAT", value_parser = options::background)]
    background: Option<Background>,
    /// No light: plain colours of textures, as for comparing with other renderers
    #[arg(long)]
    unlit: bool,
    /// No floor that takes the shadow
    #[arg(long)]
    no_floor: bool,
    /// Print the camera as JSON, the first frame's: eye, target, up, fov_y in degrees, near, far
    #[arg(long)]
    print_camera: bool,
}

/// Longest side of a picture.
const MAX_SIDE: u32 = 4096;

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    if args.size.width.max(args.size.height) > MAX_SIDE {
        let found = args.size;
        return Err(bad_input(format!("--size {found}: at most {MAX_SIDE} pixels a side")));
    }
    let scene = Scene::load(&args.input).or_bad_input()?;
    let name = args.input.display();
    if scene.triangles() == 0 {
        return Err(bad_input(format!("{name}: it has no triangles to draw")));
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
        return Err(bad_input(format!("{name}: none of its triangles is anywhere in this pose")));
    };
    // A GIF has no soft edges of shadows where one sees through it.
    let has_floor = !args.no_floor && shows_floor && !(transparent && output.is_gif());
    let floor = has_floor.then_some(cameras.lowest());
    let look = Look { lit: !args.unlit, background, floor, ..Look::default() };
    let renderer = Renderer::of(&scene);
    output.write(frames.len(), |index| {
        let drawn: Vec<Drawn> = pose(&frames[index])?;
        Ok(renderer.render(&drawn, &views[index], &look, args.size))
    })?;
    if args.print_camera {
        to_stdout(&format!("{}\n", serde_json::to_string(&views[0])?))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// A frame of what is drawn.
struct Frame {
    posing: Posing,
    azimuth: f32,
}

/// All frames; one for a still picture.
fn frames(args: &Args, scene: &Scene) -> anyhow::Result<Vec<Frame>> {
    let mut posing = Posing::default();
    for part in &args.pose {
        match part {
            Part::Stance(stance) => posing.stance = *stance,
            Part::Bone(bone, degrees) => posing.rotations.push((bone.clone(), *degrees)),
        }
    }
    posing.weights = args.expression.iter().map(|Weight(name, w)| (name.clone(), *w)).collect();
    let clip = clip(args, scene)?;
    if let (Some(clip), Some(frame)) = (clip, args.frame) {
        let uvgraft_gltf::scene::Clip { name, seconds, .. } = &scene.clips()[clip];
        // A little more than the end is the end, as printed with one place.
        if frame > seconds + 0.05 {
            anyhow::bail!("--frame {frame}: the clip {name:?} is {seconds:.2} s long");
        }
    }
    posing.clip = clip.map(|clip| (clip, args.frame.unwrap_or(0.0)));
    let mut count = usize::from(args.turntable.unwrap_or(1));
    let fps = args.fps.unwrap_or(25.0);
    if args.motion {
        let seconds = clip.map_or(0.0, |clip| scene.clips()[clip].seconds);
        // At the end it is where it starts again.
        let wanted = (seconds * fps).round().max(1.0);
        if wanted > output::MAX_FRAMES as f32 {
            let max = output::MAX_FRAMES;
            anyhow::bail!(
                "{seconds} s at {fps} frames a second are {wanted} frames, at most {max} are \
                 drawn; choose a lower --fps"
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

/// The animation that is asked for; none where none is.
fn clip(args: &Args, scene: &Scene) -> anyhow::Result<Option<usize>> {
    let clips = scene.clips();
    let Some(name) = &args.clip else {
        if clips.is_empty() && (args.motion || args.frame.is_some()) {
            anyhow::bail!("it has no animation");
        }
        return Ok((args.motion || args.frame.is_some()).then_some(0));
    };
    let by_name = clips.iter().position(|clip| clip.name == *name);
    let by_number = || name.parse().ok().filter(|&index: &usize| index < clips.len());
    match by_name.or_else(by_number) {
        Some(clip) => Ok(Some(clip)),
        None if clips.is_empty() => anyhow::bail!("there is no clip {name:?}: it has none"),
        None => {
            let numbered = clips.iter().enumerate();
            let known: Vec<String> =
                numbered.take(40).map(|(index, clip)| format!("{index} ({})", clip.name)).collect();
            anyhow::bail!("there is no clip {name:?}; choose one of {}", known.join(", "))
        }
    }
}
