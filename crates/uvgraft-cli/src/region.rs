//! Which part of the surface is meant, as options say it.

use std::path::{Path, PathBuf};

use uvgraft::blend::{Ground, Growth, Selection, Side};
use uvgraft::{Direction, Mesh, Pair};
use uvgraft_io::image::{self, Format};
use uvgraft_io::{vertex_groups, vertex_list};

use crate::failure::{OrBadInput, bad_input, note};
use crate::length::{Length, Unit, assumption};

#[derive(Clone, clap::Args)]
#[command(next_help_heading = "Region")]
pub(crate) struct RegionArgs {
    /// Only this part of what is linked: vertices (.npy, .txt), a painted mask (an image), or parts of a
    /// file of vertex groups (.pkl, .json): masks.pkl#face,neck. They are of the pair's source, or with
    /// `target:` before them of its target. Several add up
    #[arg(long, value_name = "[SIDE:]FILE[#PARTS]", value_parser = parse_part)]
    pub(crate) region: Vec<String>,
    /// Not this part; given like --region
    #[arg(long, value_name = "[SIDE:]FILE[#PARTS]", value_parser = parse_part)]
    pub(crate) exclude: Vec<String>,
    /// Widen the region, or narrow it: by a length along the surface such as 5mm or -5mm, or by rings of
    /// triangles such as 2rings
    #[arg(long, value_name = "LENGTH|RINGS", value_parser = parse_growth, allow_hyphen_values = true)]
    grow: Option<Grow>,
    /// The unit that the meshes are in, for lengths that have one [default: m]
    #[arg(long, value_enum)]
    unit: Option<Unit>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Grow {
    By(Length),
    Rings(i32),
}

fn parse_growth(text: &str) -> Result<Grow, String> {
    let rings = text.strip_suffix("rings").or_else(|| text.strip_suffix("ring"));
    match rings {
        Some(count) => match count.trim_end().parse() {
            Ok(count) if (-1000..=1000).contains(&count) => Ok(Grow::Rings(count)),
            _ => Err("wanted from -1000 to 1000 rings such as 2rings or -1ring".to_owned()),
        },
        None => Length::parse(text).map(Grow::By).map_err(|wanted| format!("{wanted}; or 2rings")),
    }
}

fn parse_part(text: &str) -> Result<String, String> {
    if Part::parse(text).path.as_os_str().is_empty() {
        Err("wanted a file such as face.npy, target:mask.png or parts.json#face".to_owned())
    } else {
        Ok(text.to_owned())
    }
}

/// A part as an option names it.
#[derive(Debug, PartialEq)]
struct Part<'a> {
    side: Side,
    path: &'a Path,
    names: Vec<&'a str>,
}

impl<'a> Part<'a> {
    fn parse(text: &'a str) -> Self {
        let (side, rest) = match text.split_once(':') {
            Some(("source", rest)) => (Side::Source, rest),
            Some(("target", rest)) => (Side::Target, rest),
            _ => (Side::Source, text),
        };
        // A file may have that sign in its name.
        match rest.rsplit_once('#') {
            Some((path, names)) if !Path::new(rest).exists() => {
                let names = names.split(',').filter(|name| !name.is_empty()).collect();
                Self { side, path: Path::new(path), names }
            }
            _ => Self { side, path: Path::new(rest), names: Vec::new() },
        }
    }
}

impl RegionArgs {
    /// Whether everything that is linked is meant.
    pub(crate) fn is_everything(&self) -> bool {
        self.region.is_empty() && self.exclude.is_empty() && self.grow.is_none()
    }

    /// The same, with a unit if none is named.
    pub(crate) fn or_unit(mut self, unit: Unit) -> Self {
        self.unit = self.unit.or(Some(unit));
        self
    }

    /// The files that are named.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = PathBuf> {
        self.region.iter().chain(&self.exclude).map(|text| Part::parse(text).path.to_path_buf())
    }

    /// The unit of the meshes. Says which one is taken, if a length depends on it and none was named.
    pub(crate) fn unit(
        &self,
        ground: &Ground<'_>,
        lengths: impl IntoIterator<Item = Length>,
    ) -> Unit {
        let grow = match self.grow {
            Some(Grow::By(length)) => Some(length),
            _ => None,
        };
        let matters = lengths.into_iter().chain(grow).any(Length::has_unit);
        self.unit.unwrap_or_else(|| {
            if matters {
                note(assumption(ground.extent(), Unit::M));
            }
            Unit::M
        })
    }

    /// What is selected, within what is linked.
    pub(crate) fn select(&self, ground: &Ground<'_>, unit: Unit) -> anyhow::Result<Selection> {
        let linked = ground.linked();
        let mut selection = match united(ground, &self.region)? {
            Some(selection) => selection,
            None => linked.clone(),
        };
        if let Some(grow) = self.grow {
            let by = match grow {
                Grow::By(length) => Growth::Length(length.in_unit(unit)),
                Grow::Rings(rings) => Growth::Rings(rings),
            };
            selection = ground.grown(&selection.within(&linked, ground), by);
        }
        // Last, so that what is widened does not come back to it.
        if let Some(excluded) = united(ground, &self.exclude)? {
            selection = selection.without(&excluded, ground);
        }
        Ok(selection.within(&linked, ground))
    }
}

fn united(ground: &Ground<'_>, parts: &[String]) -> anyhow::Result<Option<Selection>> {
    let mut all: Option<Selection> = None;
    for text in parts {
        let part = selection(ground, &Part::parse(text))?;
        all = Some(match all {
            Some(all) => all.and(&part, ground),
            None => part,
        });
    }
    Ok(all)
}

fn selection(ground: &Ground<'_>, part: &Part<'_>) -> anyhow::Result<Selection> {
    let Part { side, path, names } = part;
    let mesh = mesh_of(ground.pair(), *side);
    let vertices = mesh.positions().len();
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let name = path.display();
    let of_vertices = |ids: &[u32]| {
        ground.vertices(*side, ids).map_err(|error| bad_input(format!("{name}: {error}")))
    };
    match extension.to_str().unwrap_or_default() {
        "pkl" | "pickle" | "json" => {
            let groups = vertex_groups::read(path).or_bad_input()?;
            if names.is_empty() {
                let known: Vec<&str> = groups.names().collect();
                return Err(bad_input(format!(
                    "{name} holds named parts; say which, as in {name}#{}; there are: {}",
                    known.first().unwrap_or(&"face"),
                    known.join(", ")
                )));
            }
            let mut ids = Vec::new();
            for group in names {
                let found = groups.vertices(group, vertices);
                ids.extend(found.map_err(|error| bad_input(format!("{name}: {error}")))?);
            }
            of_vertices(&ids)
        }
        _ if !names.is_empty() => Err(bad_input(format!(
            "{name} has no named parts, so #{} says nothing; a .pkl or .json of vertex groups has",
            names.join(",")
        ))),
        extension if Format::from_extension(extension).is_some() => {
            let mask = image::read(path).or_bad_input()?.texture;
            ground.painted(*side, &mask).map_err(|error| bad_input(format!("{name}: {error}")))
        }
        "npy" | "txt" | "csv" | "" => {
            of_vertices(&vertex_list::read(path, vertices).or_bad_input()?)
        }
        _ => Err(bad_input(format!(
            "{name}: wanted vertices (.npy, .txt), vertex groups (.pkl, .json) or a painted mask ({})",
            Format::extension_list()
        ))),
    }
}

fn mesh_of(pair: &Pair, side: Side) -> &Mesh {
    match side {
        Side::Source => pair.source(),
        Side::Target => pair.target(),
    }
}

/// The side of a pair whose layout textures come from.
pub(crate) fn side_from(direction: Direction) -> Side {
    match direction {
        Direction::Forward => Side::Source,
        Direction::Reverse => Side::Target,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_and_growth() {
        let part = |side, path: &'static str, names: &[&'static str]| Part {
            side,
            path: Path::new(path),
            names: names.to_vec(),
        };
        assert_eq!(Part::parse("a.npy"), part(Side::Source, "a.npy", &[]));
        assert_eq!(
            Part::parse("target:b.pkl#face,neck"),
            part(Side::Target, "b.pkl", &["face", "neck"])
        );
        assert_eq!(Part::parse("C:\\x.txt"), part(Side::Source, "C:\\x.txt", &[]));
        assert_eq!(parse_growth("-2rings"), Ok(Grow::Rings(-2)));
        assert_eq!(parse_growth("1ring"), Ok(Grow::Rings(1)));
        assert_eq!(parse_growth("-3mm"), Ok(Grow::By(Length::millimeters(-3.0))));
        for bad in ["", "ring", "3.5rings", "99999rings", "x"] {
            assert!(parse_growth(bad).is_err(), "{bad}");
        }
    }
}
