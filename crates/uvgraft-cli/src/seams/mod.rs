//! `uvgraft seams`: how visible the seams of a texture are.

mod crops;
mod face;
mod lines;
mod picture;
mod region;
mod report;
mod tone;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use anyhow::Context;
use uvgraft::{Anatomy, Direction, Ground};
use uvgraft_io::{image, pair_file};
use uvgraft_metrics::seams::{Offset, SeamOptions, measure};
use uvgraft_pipeline::{Length, Outputs, Unit};

use crate::failure::{Notes, OrBadInput};
use crate::picture::check_name;
use crate::region::RegionArgs;
use face::Face;

/// Measures how visible seams are in a texture
///
/// Looks at the colours on both sides of edges and tells how different they look (CIEDE2000): along
/// UV seams, where the surface goes on in another island; along the rim of the region, which is what
/// the pair's links reach; and for comparison along ordinary edges, where the texture's own detail is
/// all there is. Every edge counts with its length on the surface.
///
/// Where the mesh has a head, its tone is judged too: how different cheeks and chest look, beside the
/// base's own with --onto; and with --face how far hair and brows were shifted, and how much skin was
/// clipped. A blend hides the border even of a face whose colour is wrong.
///
/// Colours are compared as sRGB, whatever their opacity; where one side has none, nothing is compared.
/// Colour profiles are not applied. Textures that hold no colours, such as normals, have no answer.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// The pair file
    pair: PathBuf,
    /// The texture, in the layout of the pair's target
    texture: PathBuf,
    /// The texture is in the layout of the pair's source
    #[arg(long)]
    reverse: bool,
    /// Take colours this many texels from the edge on each side, without leaving the island
    /// [default: 1]
    #[arg(long, value_name = "TEXELS", value_parser = parse_distance, conflicts_with = "distance")]
    offset: Option<f64>,
    /// Take colours this far from the edge on each side, on the surface, such as 3mm
    #[arg(long, value_name = "LENGTH", value_parser = Length::parse_distance)]
    #[arg(allow_hyphen_values = true)]
    distance: Option<Length>,
    /// Name the worst edges, by their mean: this many UV seams, and as many of the rim
    #[arg(long, value_name = "N", default_value_t = 5)]
    #[arg(value_parser = clap::value_parser!(u16).range(0..=1000))]
    worst: u16,
    /// Draw the layout with its seams, the worst places from close by, and the face, into an image
    #[arg(long, value_name = "out.png")]
    picture: Option<PathBuf>,
    /// Print the result as JSON. Under `edges` there are `uv_seams`, `uv_seams_inside` the region,
    /// `rim`, ordinary edges `beside_` each of these, and all that are `ordinary`, with `edges`,
    /// `length`, `points` and `delta_e`: null where no point could be measured. Lengths are in the
    /// mesh's unit, `uv` is in the texture's unit square, from its top left corner. Under `tone` there
    /// are `cheek_to_chest`, `own`, `hair_shift`, `clipped` (0 to 1) and `fits`; null where the mesh has
    /// no head
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    tone: tone::ToneArgs,
    #[command(flatten)]
    region: RegionArgs,
}

fn parse_distance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(distance) if distance.is_finite() && distance >= 0.0 => Ok(distance),
        _ => Err("wanted a number from 0".to_owned()),
    }
}

impl Args {
    fn offset(&self, unit: Unit) -> Offset {
        match (self.distance, self.offset) {
            (Some(distance), _) => Offset::Distance(distance.in_unit(unit)),
            (None, texels) => Offset::Texels(texels.unwrap_or(1.0)),
        }
    }
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    if let Some(picture) = &args.picture {
        check_name(picture, "a picture of seams")?;
        let inputs = [&*args.pair, &*args.texture].into_iter();
        let inputs = inputs.chain(args.tone.inputs()).chain(args.region.inputs());
        Outputs::new(inputs).check(picture)?;
    }
    let file = pair_file::read(&args.pair).or_bad_input()?;
    let texture = image::read(&args.texture).or_bad_input()?.texture;
    let references = args.tone.read(texture.size())?;
    let direction = if args.reverse { Direction::Reverse } else { Direction::Forward };
    let ground = Ground::new(Arc::clone(&file.pair), direction);
    let region = args.region.region();
    let unit = region.unit(&ground, args.distance, &Notes);
    let region = region::of(&region, &ground, unit)?;
    let options = SeamOptions::default().offset(args.offset(unit)).worst(usize::from(args.worst));
    let mesh = &region.cut.mesh;
    let seams = measure(mesh, &texture, &region.cut.inside, &options)
        .with_context(|| args.texture.display().to_string())
        .or_bad_input()?;
    let anatomy = Anatomy::find(mesh).ok();
    let tone = tone::measured(anatomy.as_ref(), &ground, &region, &texture, &references)?;
    let mesh_name = match direction {
        Direction::Forward => &file.target_name,
        Direction::Reverse => &file.source_name,
    };
    let subject = report::Subject {
        texture: args.texture.display().to_string(),
        mesh: mesh_name.clone(),
        region: region.name.to_owned(),
        size: texture.size(),
        offset: options.offset,
    };
    report::print(&subject, &seams, tone.as_ref(), args.json)?;
    if let Some(path) = &args.picture {
        let face = anatomy.zip(tone).and_then(|(anatomy, tone)| {
            Face::new(mesh, &anatomy, &texture, references.base.as_ref(), &tone)
        });
        picture::draw(&subject, mesh, &texture, &seams, face.as_ref())?.write(path)?;
    }
    Ok(ExitCode::SUCCESS)
}
