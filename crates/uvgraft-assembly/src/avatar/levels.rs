//! Levels of detail: coarser versions of the avatar.

use std::fmt::Write as _;
use std::path::Path;

use uvgraft_avatar::Avatar;
use uvgraft_gltf::glb::{self, AvatarMaterial, CoarserLevel, Export, Exported};
use uvgraft_gltf::preset::{self, Level};
use uvgraft_pipeline::{Blame, Result};

use super::plan::level_file;
use super::request::{LevelOptions, LevelStorage};
use crate::report::{grouped, megabytes};

/// The coarser levels of an avatar.
pub(super) struct Levels {
    levels: Vec<Level>,
    storage: LevelStorage,
}

impl Levels {
    /// Builds the levels.
    ///
    /// - `normals`: those of the finest level.
    pub(super) fn new(
        options: LevelOptions,
        avatar: &Avatar,
        normals: Option<&[[f32; 3]]>,
    ) -> Result<Self> {
        let levels = preset::levels(avatar, normals, options.count.into()).or_input()?;
        Ok(Self { levels, storage: options.storage })
    }

    /// The levels stored in the avatar's own file.
    pub(super) fn inside(&self) -> Vec<CoarserLevel> {
        let coarser = |level: &Level| CoarserLevel {
            avatar: level.avatar.clone(),
            normals: Some(level.normals.clone()),
        };
        self.levels.iter().filter(|_| self.storage == LevelStorage::Msft).map(coarser).collect()
    }

    /// The files of those that are not.
    pub(super) fn files(
        &self,
        looks: &[AvatarMaterial],
        export: &Export,
    ) -> std::result::Result<Vec<Exported>, glb::GlbError> {
        let mut files = Vec::new();
        for level in self.levels.iter().filter(|_| self.storage == LevelStorage::Files) {
            let normals = Some(level.normals.clone());
            let export = Export { normals, levels: Vec::new(), ..export.clone() };
            files.push(glb::write(&level.avatar, looks, &export)?);
        }
        Ok(files)
    }

    /// Rows for the report: the name of each level and its description.
    ///
    /// - `files`: of the levels that have one.
    /// - `output`: what the avatar's file is called.
    pub(super) fn rows(&self, files: &[Vec<u8>], output: &Path) -> Vec<(String, String)> {
        let row = |(index, level): (usize, &Level)| {
            let mut text = format!(
                "{} triangles, deviation {:.1} mm mean, {:.1} mm max",
                grouped(level.triangles),
                1e3 * level.deviation.mean,
                1e3 * level.deviation.most,
            );
            if let Some(file) = files.get(index) {
                let path = level_file(output, index + 1);
                let _ = write!(text, ", {}, {}", path.display(), megabytes(file.len()));
            }
            (format!("level {}", index + 1), text)
        };
        self.levels.iter().enumerate().map(row).collect()
    }
}
