//! Options that say how two meshes correspond, and the links that follow from them.

use std::path::{Path, PathBuf};

use uvgraft::correspond::split_vertices::{MapLinks, MapUse, link_by_vertex_map};
use uvgraft::correspond::surface::Align;
use uvgraft::correspond::{self, By, FindOptions};
use uvgraft::pair::OtherLayouts;
use uvgraft::{Choice, LinkError, Mesh, Pair};
use uvgraft_assembly::pairing::table::{self, TableLinks};
use uvgraft_io::{obj, vertex_map};
use uvgraft_pipeline::Failure;

use super::landmarks;
use crate::choice::choice;
use crate::failure::{OrBadInput, bad_input, note};
use crate::files::OrCannotWrite;
use crate::heading;
use crate::report::{Linked, LinkedTable, Method};

/// How the meshes correspond.
#[derive(clap::Args)]
#[command(next_help_heading = heading::CORRESPONDENCE)]
pub(super) struct Options {
    /// Target vertex index for each source vertex, -1 for none (.npy or text)
    #[arg(long, value_name = "IDS")]
    vertex_map: Option<PathBuf>,
    /// Published table of where the vertices of one mesh lie on the other
    ///
    /// A matrix (pickled SciPy matrix, scipy.sparse.save_npz), faces and barycentric weights for each
    /// vertex (NPZ, NPY), TF_FLAME's texture_data_*.npy, or `uv_grid` and `pix_to_face` (NPZ).
    #[arg(long, value_name = "FILE", conflicts_with = "vertex_map")]
    table: Option<PathBuf>,
    /// How to find corresponding triangles
    #[arg(long, value_name = "METHOD", default_value = Chosen::AUTO.name(), value_parser = choice::<Chosen>())]
    by: Chosen,
    /// How to align the target with the source before registration
    #[arg(long, value_name = "HOW", default_value = Align::default().name(), value_parser = choice::<Align>())]
    align: Align,
    /// Corresponding vertices (.npy or text), or two images with painted dots
    ///
    /// The two lists hold corresponding vertex indices in the same order. Images are laid over the two
    /// layouts; dots of the same colour correspond. They are painted on a
    /// transparent background, or on one of a single colour, and must not touch each other.
    #[arg(long, num_args = 2, value_names = ["SOURCE", "TARGET"])]
    landmarks: Vec<PathBuf>,
    /// Largest distance between registered surfaces, as a share of the height of the head
    #[arg(long, value_name = "SHARE", default_value_t = FindOptions::default().surface.reach)]
    #[arg(value_parser = share, allow_negative_numbers = true)]
    reach: f64,
    /// Smallest cosine of the angle between the normals of corresponding triangles
    #[arg(long, value_name = "COSINE", default_value_t = FindOptions::default().surface.visibility)]
    #[arg(value_parser = share, allow_negative_numbers = true)]
    visibility: f64,
    /// Save the target as registered to the source
    #[arg(long, value_name = "OUT.obj")]
    registered: Option<PathBuf>,
}

/// How to find corresponding triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Chosen {
    VertexMap,
    Table,
    /// By the meshes alone.
    Found(By),
}

impl Chosen {
    const AUTO: Self = Self::Found(By::Any);
}

impl Choice for Chosen {
    const ALL: &'static [Self] = &[
        Self::AUTO,
        Self::VertexMap,
        Self::Table,
        Self::Found(By::Faces),
        Self::Found(By::Topology),
        Self::Found(By::Surface),
    ];

    fn name(self) -> &'static str {
        match self {
            Self::VertexMap => "vertex-map",
            Self::Table => "table",
            Self::Found(by) => by.name(),
        }
    }

    fn summary(self) -> &'static str {
        match self {
            Self::AUTO => {
                "The vertex map or table if given, otherwise the first method below that works"
            }
            Self::VertexMap => "The vertex map given by --vertex-map",
            Self::Table => "The table given by --table",
            Self::Found(by) => by.summary(),
        }
    }
}

/// A pair, and how it was linked.
pub(super) struct LinkedPair {
    pub(super) pair: Pair,
    pub(super) linked: Linked,
    /// Parts that the pair does not have, since they have textures of their own.
    pub(super) other_layouts: Vec<OtherLayouts>,
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..=1.0).contains(&value) => Ok(value),
        _ => Err("must be a number from 0 to 1".to_owned()),
    }
}

impl Options {
    /// Refuses options that contradict each other.
    pub(super) fn check(&self) -> anyhow::Result<()> {
        for (file, method, name) in [
            (&self.vertex_map, Chosen::VertexMap, "a vertex map"),
            (&self.table, Chosen::Table, "a table"),
        ] {
            // The option with the file is called as the method is.
            let option = method.name();
            match file {
                None if self.by == method => {
                    return Err(bad_input(format!("--by {option} needs --{option}")));
                }
                Some(_) if ![Chosen::AUTO, method].contains(&self.by) => {
                    let message = format!("--{option} is used only with --by {option} or auto");
                    return Err(bad_input(message));
                }
                Some(_) if self.registered.is_some() => {
                    let message = format!("--registered is for surfaces; {name} registers nothing");
                    return Err(bad_input(message));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// The files that it reads.
    pub(super) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.vertex_map.iter().chain(&self.table).chain(&self.landmarks).map(|path| &**path)
    }

    /// Where to save the registered target.
    pub(super) fn registered(&self) -> Option<&Path> {
        self.registered.as_deref()
    }

    /// Links two meshes.
    pub(super) fn link(&self, source: Mesh, target: Mesh) -> anyhow::Result<LinkedPair> {
        if let Some(path) = &self.vertex_map {
            let ids = vertex_map::read(path).or_bad_input()?;
            let MapLinks { pair, used, .. } = link_by_vertex_map(&source, &target, &ids)
                .map_err(|error| match error {
                    // Of the meshes, not of the map.
                    LinkError::Outside => Failure::option(error.to_string()),
                    _ => Failure::option(error.to_string()).context(path.display()),
                })
                .or_bad_input()?;
            if let Some(assumed) = used.assumed() {
                note(format_args!("{}: {assumed}", path.display()));
            }
            let linked_by = match used {
                MapUse::Connectivity(report) => Method::Found(correspond::Method::Topology(report)),
                _ => Method::VertexMap,
            };
            let (pair, other_layouts) = pair.in_one_layout();
            let linked = Linked { linked_by, not_linked_by: Vec::new() };
            return Ok(LinkedPair { pair, linked, other_layouts });
        }
        if let Some(path) = &self.table {
            let options = self.find_options([&source, &target])?;
            let TableLinks { pair, other_layouts, report, unusable } =
                table::link(path, &source, &target, &options.surface)?;
            let linked_by = Method::Table(LinkedTable { report, unusable });
            let linked = Linked { linked_by, not_linked_by: Vec::new() };
            return Ok(LinkedPair { pair, linked, other_layouts });
        }
        let options = self.find_options([&source, &target])?;
        let found = correspond::find(source, target, &options)
            .map_err(|error| Failure::option(error.to_string()))
            .or_bad_input()?;
        let linked = Linked {
            linked_by: Method::Found(found.method),
            not_linked_by: found.refused.iter().map(ToString::to_string).collect(),
        };
        Ok(LinkedPair { pair: found.pair, linked, other_layouts: found.other_layouts })
    }

    fn find_options(&self, meshes: [&Mesh; 2]) -> anyhow::Result<FindOptions> {
        let mut options = FindOptions::default();
        options.by = match self.by {
            Chosen::Found(by) => by,
            Chosen::VertexMap | Chosen::Table => By::Any,
        };
        options.surface.align = self.align;
        options.surface.reach = self.reach;
        options.surface.visibility = self.visibility;
        if let [source, target] = &self.landmarks[..] {
            landmarks::read([source, target], meshes, &mut options.surface)?;
        }
        Ok(options)
    }

    /// Saves the registered target, if that was asked for.
    pub(super) fn save_registered(&self, pair: &Pair, linked: &Linked) -> anyhow::Result<()> {
        let Some(path) = &self.registered else { return Ok(()) };
        let Some(report) = linked.registered() else {
            return Err(bad_input(format!(
                "cannot write {}: the meshes were not registered, since their triangles correspond; \
                 --by surface registers them all the same",
                path.display()
            )));
        };
        let mesh = pair.target().clone().with_positions(report.registered.clone())?;
        obj::save(&mesh, path).or_cannot_write(path)
    }
}
