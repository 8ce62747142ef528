//! `uvgraft pair`: links two meshes.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use anyhow::Context;
use uvgraft::Pair;
use uvgraft_io::image::Format;
use uvgraft_io::{pair_file, vertex_map};
use uvgraft_pipeline::Outputs;

use crate::failure::{OrBadInput, bad_input, warn};
use crate::mesh_file::{self, MeshFile};
use crate::picture::check_name;
use crate::report::grouped;
use crate::{preview, report};

/// Link the triangles of two meshes and save the links as a pair file
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Source mesh: OBJ, PLY, GLB, glTF or a body model with UV coordinates
    ///
    /// The format is detected from the content. `FILE#1` reads the UV set TEXCOORD_1 of a GLB or
    /// glTF file. `FILE#NAME` reads only a part: nodes, meshes or materials of that name, or objects,
    /// groups or materials of an OBJ file. `FILE#NAME/1` does both.
    #[arg(value_name = "SOURCE")]
    source: PathBuf,
    /// Target mesh, as SOURCE
    #[arg(value_name = "TARGET")]
    target: PathBuf,
    /// Target vertex index for each source vertex, -1 for none (.npy or text)
    #[arg(long, value_name = "IDS")]
    vertex_map: PathBuf,
    /// Pair file to write
    #[arg(short, long, value_name = "OUT.uvpair")]
    output: PathBuf,
    /// Note to store in the pair file, such as the licence of the meshes
    #[arg(long, value_name = "TEXT")]
    note: Option<String>,
    /// Draw both layouts, with linked triangles in matching colours
    #[arg(long, value_name = "OUT.png")]
    preview: Option<PathBuf>,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
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
    let mut outputs = Outputs::new([
        &*MeshFile::parse(&args.source).path,
        &*MeshFile::parse(&args.target).path,
        &*args.vertex_map,
    ]);
    outputs.check(&args.output)?;
    if let Some(preview) = &args.preview {
        check_name(preview, "a preview")?;
        outputs.check(preview)?;
    }
    let source = mesh_file::read(&args.source)?;
    let target = mesh_file::read(&args.target)?;
    let ids = vertex_map::read(&args.vertex_map).or_bad_input()?;
    let (source_name, target_name) = (source.name, target.name);
    let note = args.note.clone().unwrap_or_else(|| {
        format!("made from {source_name} and {target_name}, whose licences hold for this file too")
    });
    let pair = Pair::by_vertex_map(source.mesh, target.mesh, &ids)
        .with_context(|| args.vertex_map.display().to_string())
        .or_bad_input()?;
    let pair = Arc::new(pair);
    let file = pair_file::PairFile { pair, source_name, target_name, note };
    pair_file::write(&file, &args.output)
        .with_context(|| format!("cannot write {}", args.output.display()))?;
    warn_of_outside(&file);
    report::print(&file, &args.sizes, args.json)?;
    if let Some(path) = &args.preview {
        preview::write(&file, path)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Warns of triangles that are not linked because they lie outside the unit square.
fn warn_of_outside(file: &pair_file::PairFile) {
    let sides = [(file.pair.source(), &file.source_name), (file.pair.target(), &file.target_name)];
    for (mesh, name) in sides {
        let count = (0..mesh.faces().len()).filter(|&face| mesh.is_outside(face)).count();
        if count > 0 {
            let triangles = if count == 1 { "triangle has" } else { "triangles have" };
            warn(format!(
                "{name}: {} {triangles} UV coordinates outside the unit square and will not be \
                 linked",
                grouped(count)
            ));
        }
    }
}
