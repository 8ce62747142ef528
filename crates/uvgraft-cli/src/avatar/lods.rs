//! Levels of detail: coarser versions of the avatar.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use uvgraft_avatar::Avatar;
use uvgraft_gltf::glb::{self, AvatarMaterial, CoarserLevel, Export, Exported};
use uvgraft_gltf::preset::{self, Level, MAX_LEVELS};

use crate::failure::{OrBadInput, bad_input};
use crate::heading;
use crate::number::whole_number;
use crate::report::grouped;
use crate::terminal;

/// Options for coarser levels.
#[derive(clap::Args)]
#[command(next_help_heading = heading::LODS)]
pub(super) struct LodArgs {
    /// Number of additional levels, each with about half the triangles of the one before
    #[arg(long, value_name = "N", value_parser = whole_number::<u8>(1..=MAX_LEVELS as u64), allow_negative_numbers = true)]
    lods: Option<u8>,
    /// How to store the levels [default: files]
    #[arg(long, value_enum, value_name = "STORAGE", requires = "lods")]
    lods_as: Option<LodsAs>,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum LodsAs {
    /// Separate files: NAME.lod1.glb, NAME.lod2.glb, ...
    Files,
    /// One .glb with MSFT_lod; readers without support show the finest level
    Msft,
}

impl LodArgs {
    fn count(&self) -> usize {
        self.lods.map_or(0, usize::from)
    }

    fn is_one_file(&self) -> bool {
        self.lods_as == Some(LodsAs::Msft)
    }

    /// Checks that the options fit the output and the build.
    pub(super) fn check(&self, is_vrm: bool) -> anyhow::Result<()> {
        if self.count() > 0 && cfg!(not(feature = "simplify")) {
            return Err(bad_input("--lods needs a build with the feature `simplify`"));
        }
        if is_vrm && self.is_one_file() {
            return Err(bad_input(
                "--lods-as msft cannot be used with .vrm, whose readers do not support MSFT_lod; \
                 use --lods-as files, or write a .glb",
            ));
        }
        Ok(())
    }

    /// The output files of the levels.
    pub(super) fn files(&self, output: &Path) -> Vec<PathBuf> {
        let count = if self.is_one_file() { 0 } else { self.count() };
        let stem = output.file_stem().unwrap_or_default().to_string_lossy();
        let extension = output.extension().unwrap_or_default().to_string_lossy();
        (1..=count)
            .map(|level| output.with_file_name(format!("{stem}.lod{level}.{extension}")))
            .collect()
    }

    /// Builds the levels.
    ///
    /// - `normals`: those of the finest level.
    pub(super) fn levels(
        &self,
        avatar: &Avatar,
        normals: Option<&[[f32; 3]]>,
    ) -> anyhow::Result<Levels> {
        let levels = preset::levels(avatar, normals, self.count()).or_bad_input()?;
        Ok(Levels { levels, is_one_file: self.is_one_file() })
    }
}

/// The coarser levels of an avatar.
pub(super) struct Levels {
    levels: Vec<Level>,
    is_one_file: bool,
}

impl Levels {
    /// The levels stored in the avatar's own file.
    pub(super) fn inside(&self) -> Vec<CoarserLevel> {
        let coarser = |level: &Level| CoarserLevel {
            avatar: level.avatar.clone(),
            normals: Some(level.normals.clone()),
        };
        self.levels.iter().filter(|_| self.is_one_file).map(coarser).collect()
    }

    /// The files of those that are not.
    pub(super) fn files(
        &self,
        looks: &[AvatarMaterial],
        export: &Export,
    ) -> anyhow::Result<Vec<Exported>> {
        let mut files = Vec::new();
        for level in self.levels.iter().filter(|_| !self.is_one_file) {
            let normals = Some(level.normals.clone());
            let export = Export { normals, levels: Vec::new(), ..export.clone() };
            files.push(glb::write(&level.avatar, looks, &export)?);
        }
        Ok(files)
    }

    /// Rows for the summary: the name of each level and its description.
    ///
    /// - `files`: of the levels that have one.
    pub(super) fn rows(&self, files: &[(PathBuf, usize)]) -> Vec<(String, String)> {
        let row = |(index, level): (usize, &Level)| {
            let mut text = format!(
                "{} triangles, deviation {:.1} mm mean, {:.1} mm max",
                grouped(level.triangles),
                1e3 * level.deviation.mean,
                1e3 * level.deviation.most,
            );
            if let Some((path, bytes)) = files.get(index) {
                let _ = write!(text, ", {}, {:.1} MB", terminal::path(path), *bytes as f64 / 1e6);
            }
            (format!("level {}", index + 1), text)
        };
        self.levels.iter().enumerate().map(row).collect()
    }
}
