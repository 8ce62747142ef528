//! `uvgraft seams`: the visibility of the seams of a texture.

mod colors;
mod crops;
mod face;

mod picture;
mod region;
mod report;
mod style;
mod tone;
mod verdict;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use anyhow::Context;
use uvgraft::layout_match::{LayoutPoints, LayoutProbe};
use uvgraft::{Anatomy, BlendDomain, Direction, Texture};
use uvgraft_image::{self as image, OpenImage};
use uvgraft_io::pair_file::{self, PairFile};
use uvgraft_metrics::seams::{Offset, SeamOptions, measure};
use uvgraft_pipeline::{Input, Length, Outputs, Unit, decoded_bytes};

use crate::failure::{Notes, OrBadInput, warn};
use crate::heading;
use crate::memory::MemoryOption;
use crate::number::whole_number;
use crate::outcome;
use crate::region::RegionArgs;
use face::Face;
use uvgraft_assembly::drawing::check_name;

/// Measure how visible the seams of a texture are
///
/// Samples the colours on both sides of mesh edges and reports their difference (CIEDE2000): along
/// UV seams, along the boundary of the linked region, and, for comparison, along ordinary edges,
/// where the texture's own detail is the only difference. Edges are weighted by their length on the
/// surface.
///
/// If the mesh has a head, the skin tone is assessed too: the difference between cheeks and chest,
/// alongside the base's own if --onto is given; with --face also the colour shift of hair and brows
/// and the share of clipped skin. A good blend hides the boundary even where the face has the wrong
/// colour.
///
/// Colours are compared in sRGB, ignoring alpha and colour profiles. Edges with no colour on one
/// side are skipped. The measure has no meaning for textures without colours, such as normal maps.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Pair file that links the two meshes
    pair: PathBuf,
    /// Texture to measure, in the target layout
    texture: PathBuf,
    /// Treat the texture as one in the source layout
    #[arg(long, help_heading = heading::MEASUREMENT)]
    reverse: bool,
    /// Sampling distance from the edge on each side, in texels [default: 1]
    ///
    /// Samples stay inside the UV island.
    #[arg(long, value_name = "TEXELS", value_parser = parse_distance, allow_negative_numbers = true, conflicts_with = "distance")]
    #[arg(help_heading = heading::MEASUREMENT)]
    offset: Option<f64>,
    /// Sampling distance from the edge on each side along the surface, such as 3mm
    ///
    /// At most the mesh's largest dimension.
    #[arg(long, value_name = "LENGTH", value_parser = Length::parse_distance)]
    #[arg(allow_hyphen_values = true, help_heading = heading::MEASUREMENT)]
    distance: Option<Length>,
    #[command(flatten)]
    region: RegionArgs,
    #[command(flatten)]
    tone: tone::ToneArgs,
    /// Number of worst edges to list, for UV seams and for the boundary
    #[arg(long, value_name = "N", default_value_t = 5)]
    #[arg(value_parser = whole_number::<u16>(0..=1000), allow_negative_numbers = true, help_heading = heading::REPORT)]
    worst: u16,
    /// Draw the layout with its seams, the worst edges in detail, and the face
    #[arg(long, value_name = "OUT.png", help_heading = heading::REPORT)]
    picture: Option<PathBuf>,
    #[command(flatten)]
    memory: MemoryOption,
}

/// Memory that measuring takes at most, in bytes: the textures, one of them while it is decoded, and what each
/// texel shows.
fn needed<'a>(images: impl Iterator<Item = &'a OpenImage>) -> u64 {
    let (mut kept, mut passing) = (0, 0);
    for image in images {
        let header = image.header();
        let texels = header.size.texels() as u64;
        kept += texels * (header.channels.count() * header.depth.bytes() + 4) as u64;
        passing = passing.max(decoded_bytes(Some(&image.name().into()), &header));
    }
    kept + passing
}

fn parse_distance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(distance) if distance.is_finite() && distance >= 0.0 => Ok(distance),
        _ => Err("must be a number of at least 0".to_owned()),
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
        let region = args.region.region();
        let parts = region.inputs().filter_map(Input::path);
        let inputs = inputs.chain(args.tone.inputs()).chain(parts);
        Outputs::new(inputs).check(picture)?;
    }
    let file = pair_file::read(&args.pair).or_bad_input()?;
    let texture = image::open(&args.texture).or_bad_input()?;
    let references = args.tone.open(texture.header().size)?;
    args.memory.check("measuring", needed([&texture].into_iter().chain(references.images())))?;
    let texture = texture.decode().or_bad_input()?.texture;
    let references = references.decode()?;
    let direction = if args.reverse { Direction::Reverse } else { Direction::Forward };
    warn_of_misfit(&file, direction, &texture, &args.texture);
    let domain = BlendDomain::new(Arc::clone(&file.pair), direction);
    let region = args.region.region();
    region.check()?;
    let unit = region.unit(&domain, args.distance, &Notes);
    if let Some(distance) = args.distance {
        distance.check_within("distance", domain.extent(), unit)?;
    }
    let region = region::of(&region, &domain, unit)?;
    let options = SeamOptions::default().offset(args.offset(unit)).worst(usize::from(args.worst));
    let mesh = &region.cut.mesh;
    let seams = measure(mesh, &texture, &region.cut.inside, &options)
        .with_context(|| args.texture.display().to_string())
        .or_bad_input()?;
    let anatomy = Anatomy::find(mesh).ok();
    let tone = tone::measured(anatomy.as_ref(), &domain, &region, &texture, &references)?;
    if anatomy.is_none() && args.tone.inputs().next().is_some() {
        warn("`onto` and `face` have no effect: the mesh has no head");
    }
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
    if let Some(path) = &args.picture {
        let face = anatomy.zip(tone.as_ref()).and_then(|(anatomy, tone)| {
            Face::new(mesh, &anatomy, &texture, references.base.as_ref(), tone)
        });
        picture::draw(&subject, mesh, &texture, &seams, face.as_ref())?.write(path)?;
        outcome::wrote(path);
    }
    report::print(&subject, &seams, tone.as_ref())?;
    Ok(ExitCode::SUCCESS)
}

/// Warns of a texture that was not made for the layout whose seams are measured.
fn warn_of_misfit(file: &PairFile, direction: Direction, texture: &Texture, path: &Path) {
    let [this, other] = [direction, direction.opposite()];
    let layouts = [this, other].map(|direction| LayoutPoints::new(file.pair.to(direction)));
    let mut probe = LayoutProbe::new([&layouts[0], &layouts[1]], texture.size());
    probe.look(0, texture);
    if let Some(misfit) = probe.misfit() {
        let [mesh, other] = match direction {
            Direction::Forward => [&file.target_name, &file.source_name],
            Direction::Reverse => [&file.source_name, &file.target_name],
        };
        let text = misfit.text(&path.display().to_string(), mesh, other);
        let hint = "; is `reverse` missing or too much?";
        warn(text + if misfit.fits_other { hint } else { "" });
    }
}
