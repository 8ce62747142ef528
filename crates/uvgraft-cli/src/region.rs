//! Options for regions of the surface.

use uvgraft_pipeline::{Grow, Length, Region, RegionPart, Unit};

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
    /// 2rings.
    #[arg(long, value_name = "LENGTH|RINGS", value_parser = parse_growth, allow_hyphen_values = true)]
    grow: Option<Grow>,
    /// Unit of the mesh coordinates, for lengths with a unit [default: m]
    #[arg(long, value_parser = choice::<Unit>())]
    unit: Option<Unit>,
}

fn parse_growth(text: &str) -> Result<Grow, String> {
    let rings = text.strip_suffix("rings").or_else(|| text.strip_suffix("ring"));
    match rings {
        Some(count) => match count.trim_end().parse() {
            Ok(count) if (-1000..=1000).contains(&count) => Ok(Grow::Rings(count)),
            _ => Err("must be -1000 to 1000 rings, such as 2rings or -1ring".to_owned()),
        },
        None => Length::parse(text)
            .map(Grow::By)
            .map_err(|wanted| format!("{wanted}; or rings, such as 2rings")),
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth() {
        assert_eq!(parse_growth("-2rings"), Ok(Grow::Rings(-2)));
        assert_eq!(parse_growth("1ring"), Ok(Grow::Rings(1)));
        assert_eq!(parse_growth("-3mm"), Ok(Grow::By(Length::millimeters(-3.0))));
        for bad in ["", "ring", "3.5rings", "99999rings", "x"] {
            assert!(parse_growth(bad).is_err(), "{bad}");
        }
    }
}
