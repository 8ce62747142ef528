//! `uvgraft pair`: links two meshes.

mod correspondence;
mod landmarks;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use uvgraft::{Choice, PairReport, Side};
use uvgraft_image::Format;
use uvgraft_io::pair_file;
use uvgraft_pipeline::Outputs;

use crate::choice::choice;
use crate::failure::{Notes, bad_input, note};
use crate::files::OrCannotWrite;
use crate::{outcome, progress, report};
use uvgraft_assembly::drawing::check_name;
use uvgraft_assembly::mesh_file::{self, LoadedMesh, MeshFile};
use uvgraft_assembly::pair_picture;
use uvgraft_assembly::pairing::{self, Outside, UvReading};
use uvgraft_assembly::recognition;

/// Link the triangles of two meshes and save the links as a pair file
///
/// Without a vertex map or a table it is found out how the meshes correspond: whether they have the same faces,
/// whether one's connectivity is found in the other, or else where their surfaces lie over each
/// other.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Source mesh: OBJ, PLY, GLB, glTF or a body model with UV coordinates
    ///
    /// The format is detected from the content. `FILE#1` reads the UV set TEXCOORD_1 of a GLB or
    /// glTF file. `FILE#NAME` reads only a part: nodes, meshes or materials of that name, or objects,
    /// groups or materials of an OBJ file. `FILE#NAME/1` does both. `FILE#head` reads the head of
    /// the open body in a layout of its own.
    #[arg(value_name = "SOURCE")]
    source: PathBuf,
    /// Target mesh, as SOURCE
    #[arg(value_name = "TARGET")]
    target: PathBuf,
    #[command(flatten)]
    correspondence: correspondence::Options,
    /// What becomes of triangles with UV coordinates outside the unit square
    #[arg(long, value_name = "HOW", default_value = Outside::default().name(), value_parser = choice::<Outside>())]
    outside: Outside,
    /// Count V from the other side in the source, the target or both (source,target)
    ///
    /// For meshes exported with V upside down: faces come out standing on their heads.
    #[arg(long, value_name = "SIDE", value_delimiter = ',', value_parser = choice::<Side>())]
    flip_v: Vec<Side>,
    /// Count U from the other side in the source, the target or both (source,target)
    #[arg(long, value_name = "SIDE", value_delimiter = ',', value_parser = choice::<Side>())]
    flip_u: Vec<Side>,
    /// Pair file to write
    #[arg(short, long, value_name = "OUT.uvpair")]
    output: PathBuf,
    /// Note to store in the pair file, such as the licence of the meshes
    #[arg(long, value_name = "TEXT")]
    note: Option<String>,
    /// Draw both layouts, with linked triangles in matching colours
    #[arg(long, value_name = "OUT.png")]
    preview: Option<PathBuf>,
    #[command(flatten)]
    sizes: report::Sizes,
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    if let Some(format) = Format::from_path(&args.output) {
        let output = args.output.display();
        return Err(bad_input(format!(
            "{output}: the extension is that of a {format} image; use .uvpair"
        )));
    }
    args.correspondence.check()?;
    let [source_file, target_file] =
        [&args.source, &args.target].map(|path| MeshFile::parse(&path.into()));
    let meshes = [&source_file, &target_file].into_iter().filter_map(|it| it.file.path());
    let mut outputs = Outputs::new(meshes.into_iter().chain(args.correspondence.inputs()));
    outputs.check(&args.output)?;
    if let Some(registered) = args.correspondence.registered() {
        outputs.check(registered)?;
    }
    if let Some(preview) = &args.preview {
        check_name(preview, "a preview")?;
        outputs.check(preview)?;
    }
    let [source, target] = [mesh_file::read(&args.source)?, mesh_file::read(&args.target)?];
    [&source, &target].into_iter().filter_map(LoadedMesh::left_out).for_each(note);
    let reading = UvReading {
        flip_u: args.flip_u.clone(),
        flip_v: args.flip_v.clone(),
        outside: args.outside,
    };
    let source = reading.apply(source, Side::Source, &Notes);
    let target = reading.apply(target, Side::Target, &Notes);
    let (source_name, target_name) = (source.name, target.name);
    let note = args.note.clone().unwrap_or_else(|| {
        format!("made from {source_name} and {target_name}, whose licences hold for this file too")
    });
    progress::step("linking the meshes");
    let linked = args.correspondence.link(source.mesh, target.mesh)?;
    args.correspondence.save_registered(&linked.pair, &linked.linked)?;
    let pair = Arc::new(linked.pair);
    let file = pair_file::PairFile { pair, source_name, target_name, note };
    progress::step("counting texels");
    let report = report::of_pair(&file, &args.sizes);
    check_reach(&file, &report)?;
    pair_file::write(&file, &args.output).or_cannot_write(&args.output)?;
    let registered = linked.linked.registered();
    let recognised = recognition::recognised(&file);
    pairing::remark(&file, registered, &linked.other_layouts, &recognised, &Notes);
    outcome::wrote(&args.output);
    args.correspondence.registered().into_iter().for_each(outcome::wrote);
    if let Some(path) = &args.preview {
        progress::step("drawing the preview");
        pair_picture::of_pair(&file, registered)?.write(path)?;
        outcome::wrote(path);
    }
    let preview = outcome::free(args.output.with_extension("png"));
    let [pair, preview] = [&*args.output, &*preview].map(outcome::argument);
    outcome::look_by(format_args!("inspect {pair} --preview {preview}"));
    report::print(&file, Some(&linked.linked), &recognised, &report)?;
    Ok(ExitCode::SUCCESS)
}

/// Refuses a pair that no texture would be transferred by.
fn check_reach(file: &pair_file::PairFile, report: &PairReport) -> anyhow::Result<()> {
    for (side, name) in [(&report.source, &file.source_name), (&report.target, &file.target_name)] {
        if side.texels.linked == 0 {
            let why = side.texels.why_nothing_is_linked();
            return Err(bad_input(format!(
                "{name}: {} triangles are linked, but none owns a texel of a {} texture: {why}",
                report::grouped(side.linked),
                side.size
            )));
        }
    }
    Ok(())
}
