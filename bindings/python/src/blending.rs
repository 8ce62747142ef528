//! Options of regions and of blending, which transfers of files and avatars share.

use std::path::PathBuf;

use pyo3::prelude::*;
use uvgraft_pipeline::{BlendSettings, Grow, Length, Region, RegionPart};

use crate::error::of_option;
use crate::keywords::Keywords;

impl Keywords<'_> {
    /// The region that the arguments describe.
    pub(crate) fn region(&self) -> PyResult<Region> {
        let mut region = Region::default();
        region.include = self.parts("region")?;
        region.exclude = self.parts("exclude")?;
        region.grow = self.parsed("grow", Grow::parse)?;
        region.unit = self.choice("unit")?;
        Ok(region)
    }

    fn parts(&self, name: &str) -> PyResult<Vec<RegionPart>> {
        let part = |path: PathBuf| match path.to_str() {
            Some(text) if !text.is_empty() => Ok(RegionPart::parse(text)),
            _ => Err(of_option(
                name,
                format_args!(
                    "must be a file such as face.npy, target:mask.png or groups.json#face, got \
                     {path:?}"
                ),
            )),
        };
        self.paths(name)?.into_iter().map(part).collect()
    }

    /// The blending that the arguments describe, but for labels.
    pub(crate) fn blending(&self) -> PyResult<BlendSettings> {
        Ok(BlendSettings {
            blend: self.choice("blend")?,
            feather: self.parsed("feather", Length::parse_distance)?,
            tone: self.choice("tone")?,
            match_skin: self.flag("match_skin")?,
            skin: self.image("skin")?,
            keep_all: self.flag("keep_all")?,
            ..BlendSettings::default()
        })
    }
}
