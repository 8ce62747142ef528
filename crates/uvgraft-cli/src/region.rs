//! Options for regions of the surface.

use uvgraft_pipeline::{Grow, Region, RegionPart, Unit};

use crate::choice::choice;
use crate::heading;

#[derive(Clone, clap::Args)]
#[command(next_help_heading = heading::REGION)]
pub(crate) struct RegionArgs {
    /// Use only a part of the linked surface; repeatable
    ///
    /// A vertex list (.npy, .txt), a painted mask (an image), or named groups of a vertex-group
    /// file (.pkl, .json), such as masks.pkl#face,neck. Files refer to the pair's source, or with
    /// the prefix `target:` to its target. Several regions are merged.
    #[arg(long, value_name = "[SIDE:]FILE[#GROUPS]", value_parser = parse_part)]
    pub(crate) region: Vec<RegionPart>,
    /// Exclude a part of the surface, given as for --region; repeatable
    #[arg(long, value_name = "[SIDE:]FILE[#GROUPS]", value_parser = parse_part)]
    pub(crate) exclude: Vec<RegionPart>,
    /// Grow the region, or shrink it if negative
    ///
    /// By a distance along the surface, such as 5mm or -5mm, or by rings of triangles, such as
    /// 2rings. What is linked is the limit, so growing needs --region.
    #[arg(long, value_name = "LENGTH|RINGS", value_parser = Grow::parse, allow_hyphen_values = true)]
    grow: Option<Grow>,
    /// Unit of the mesh coordinates, for lengths [default: m]
    #[arg(long, value_parser = choice::<Unit>())]
    unit: Option<Unit>,
}

fn parse_part(text: &str) -> Result<RegionPart, String> {
    let part = RegionPart::parse(text);
    if part.input.name().as_os_str().is_empty() {
        Err("must be a file such as face.npy, target:mask.png or groups.json#face".to_owned())
    } else {
        Ok(part)
    }
}

impl RegionArgs {
    /// The region that the options describe.
    pub(crate) fn region(&self) -> Region {
        let mut region = Region::default();
        region.include.clone_from(&self.region);
        region.exclude.clone_from(&self.exclude);
        region.grow = self.grow;
        region.unit = self.unit;
        region
    }
}
