//! Regions of the surface, read from files.

use std::path::Path;

use uvgraft::Choice;
use uvgraft::blend::{BlendDomain, Growth, Selection, Side};
use uvgraft::listing::listed;
use uvgraft_files::input::Input;
use uvgraft_image::{self as image, DeclaredSpace, Format};
use uvgraft_io::{vertex_groups, vertex_list};

use crate::failure::{Blame, Failure, Result};
use crate::growth::grown;
use crate::length::{Length, Unit, assume};
use crate::masks::Uniform;
use crate::observer::Observer;

/// A region of the linked surface as a request: files, names and lengths, of which [`Region::select`]
/// makes a [`Selection`] on the mesh. All of the surface by default.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Region {
    /// Parts to include; all if empty.
    pub include: Vec<RegionPart>,
    /// Parts to exclude.
    pub exclude: Vec<RegionPart>,
    /// How far the included part is grown.
    pub grow: Option<Grow>,
    /// Unit of the mesh coordinates, for lengths; metres if absent.
    pub unit: Option<Unit>,
}

/// How far a region is grown, or shrunk if negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Grow {
    /// A distance along the surface.
    By(Length),
    /// A number of rings of triangles.
    Rings(i32),
}

impl Grow {
    /// Parses a distance such as `5mm` or `-1cm`, or rings such as `2rings`.
    ///
    /// # Errors
    /// The requirements that the text does not meet.
    pub fn parse(text: &str) -> std::result::Result<Self, String> {
        let rings = text.strip_suffix("rings").or_else(|| text.strip_suffix("ring"));
        match rings {
            Some(count) => match count.trim_end().parse() {
                Ok(count) if (-1000..=1000).contains(&count) => Ok(Self::Rings(count)),
                _ => Err("must be -1000 to 1000 rings, such as 2rings or -1ring".to_owned()),
            },
            None => Length::parse(text)
                .map(Self::By)
                .map_err(|wanted| format!("{wanted}; or rings, such as 2rings")),
        }
    }
}

/// A part of a mesh read from a file: a vertex list (NPY, text), vertex groups (pickle, JSON), or a
/// painted mask (an image). The extension of its name says which.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct RegionPart {
    /// The mesh whose vertices or layout it refers to.
    pub side: Side,
    /// The file.
    pub input: Input,
    /// Names of the groups; for files of vertex groups only.
    pub names: Vec<String>,
}

impl RegionPart {
    /// `[SIDE:]FILE[#GROUP,GROUP]`, as in `target:body.json#head,neck`.
    pub fn parse(text: &str) -> Self {
        let with_side =
            text.split_once(':').and_then(|(name, rest)| Some((Side::named(name)?, rest)));
        let (side, rest) = with_side.unwrap_or((Side::Source, text));
        // File names may contain this character.
        match rest.rsplit_once('#') {
            Some((path, names)) if !Path::new(rest).exists() => {
                let names = names.split(',').filter(|name| !name.is_empty());
                Self { side, input: path.into(), names: names.map(str::to_owned).collect() }
            }
            _ => Self { side, input: rest.into(), names: Vec::new() },
        }
    }
}

impl Region {
    /// Checks for options that do nothing.
    ///
    /// # Errors
    /// As bad input, with the option.
    pub fn check(&self) -> Result<()> {
        let outwards = match self.grow {
            Some(Grow::By(length)) => length.in_unit(Unit::M) > 0.0,
            Some(Grow::Rings(rings)) => rings > 0,
            None => false,
        };
        if outwards && self.include.is_empty() {
            return Err(Failure::option(
                "`grow` needs `region` unless it is negative: everything linked cannot grow",
            ));
        }
        Ok(())
    }

    /// Whether it is the whole linked surface.
    pub fn is_everything(&self) -> bool {
        self.include.is_empty() && self.exclude.is_empty() && self.grow.is_none()
    }

    /// The files that it refers to.
    pub fn inputs(&self) -> impl Iterator<Item = &Input> {
        self.include.iter().chain(&self.exclude).map(|part| &part.input)
    }

    /// The unit of the meshes. Reports the assumed unit if a length depends on it and none was
    /// given.
    pub fn unit(
        &self,
        domain: &BlendDomain,
        lengths: impl IntoIterator<Item = Length>,
        observer: &dyn Observer,
    ) -> Unit {
        let grow = match self.grow {
            Some(Grow::By(length)) => Some(length),
            _ => None,
        };
        let matters = lengths.into_iter().chain(grow).any(|length| !length.is_zero());
        self.unit.unwrap_or_else(|| {
            let unit = Unit::default();
            if matters {
                assume(unit, domain.extent(), observer);
            }
            unit
        })
    }

    /// The selection, restricted to the linked surface.
    ///
    /// - `observer`: receives a warning if shrinking leaves next to nothing, and notes on parts that
    ///   change nothing.
    ///
    /// # Errors
    /// For files that cannot be read or do not match the meshes, and as [`grown`].
    pub fn select(
        &self,
        domain: &BlendDomain,
        unit: Unit,
        observer: &dyn Observer,
    ) -> Result<Selection> {
        let linked = domain.linked();
        let mut selection = match united(domain, &self.include, observer)? {
            Some(selection) => selection,
            None => linked.clone(),
        };
        if let Some(grow) = self.grow {
            let by = match grow {
                Grow::By(length) => Growth::Length(length.in_unit(unit)),
                Grow::Rings(rings) => Growth::Rings(rings),
            };
            let grown = grown(&selection.intersection(&linked).or_input()?, by, Some(unit))?;
            grown.warning.into_iter().for_each(|warning| observer.warn(warning));
            selection = grown.selection;
        }
        // Exclusions come last, so that growing does not bring them back.
        for part in &self.exclude {
            let excluded = part_of(domain, part)?.selection;
            if selection.intersection(&excluded).or_input()?.is_empty() {
                observer.note(format_args!(
                    "`exclude` {} has no effect: outside of the region",
                    part.input
                ));
            }
            selection = selection.difference(&excluded).or_input()?;
        }
        selection.intersection(&linked).or_input()
    }
}

/// The union of parts, `None` without any.
///
/// - `observer`: receives a note if they are everything linked.
fn united(
    domain: &BlendDomain,
    parts: &[RegionPart],
    observer: &dyn Observer,
) -> Result<Option<Selection>> {
    let mut all: Option<Selection> = None;
    let mut is_white = false;
    for part in parts {
        let selected = part_of(domain, part)?;
        is_white |= selected.is_white;
        all = Some(match all {
            Some(all) => all.union(&selected.selection).or_input()?,
            None => selected.selection,
        });
    }
    if let Some(all) = &all
        && (is_white || domain.linked().difference(all).or_input()?.is_empty())
    {
        observer.note("`region` has no effect: it covers everything linked");
    }
    Ok(all)
}

/// A part as a selection.
struct Part {
    selection: Selection,
    /// Whether it is a mask that is white everywhere. Such a mask leaves out the triangles in corners of
    /// the boundary, as every mask does.
    is_white: bool,
}

impl From<Selection> for Part {
    fn from(selection: Selection) -> Self {
        Self { selection, is_white: false }
    }
}

fn part_of(domain: &BlendDomain, part: &RegionPart) -> Result<Part> {
    let RegionPart { side, input, names } = part;
    let mesh = domain.mesh_of(*side);
    let vertices = mesh.positions().len();
    let extension = input.name().extension().unwrap_or_default().to_ascii_lowercase();
    let name = input;
    let refused = |error| Failure::input(format!("{name}: {error}"));
    let of_vertices = |ids: &[u32]| domain.vertices(*side, ids).map(Part::from).map_err(refused);
    match extension.to_str().unwrap_or_default() {
        "pkl" | "pickle" | "json" => {
            let groups = vertex_groups::read(input).or_input()?;
            if names.is_empty() {
                return Err(Failure::input(format!(
                    "{name} holds named groups; select some, such as {name}#{}; known groups: {}",
                    groups.names().next().unwrap_or("face"),
                    listed(groups.names())
                )));
            }
            let mut ids = Vec::new();
            for group in names {
                let found = groups.vertices(group, vertices);
                ids.extend(found.map_err(|error| Failure::input(format!("{name}: {error}")))?);
            }
            of_vertices(&ids)
        }
        _ if !names.is_empty() => Err(Failure::input(format!(
            "{name} holds no named groups, so #{} cannot be selected; use a .pkl or .json file of \
             vertex groups",
            names.join(",")
        ))),
        extension if Format::from_extension(extension).is_some() => {
            let mask = image::read_with(input, DeclaredSpace::Ignored).or_input()?.texture;
            let selection = domain.painted(*side, &mask).map_err(refused)?;
            Ok(Part { selection, is_white: Uniform::of(&mask) == Some(Uniform::White) })
        }
        "npy" | "txt" | "csv" | "" => of_vertices(&vertex_list::read(input, vertices).or_input()?),
        _ => Err(Failure::input(format!(
            "{name}: must be a vertex list (.npy, .txt), vertex groups (.pkl, .json) or a painted \
             mask ({})",
            Format::extension_list()
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth() {
        assert_eq!(Grow::parse("-2rings"), Ok(Grow::Rings(-2)));
        assert_eq!(Grow::parse("1ring"), Ok(Grow::Rings(1)));
        assert_eq!(Grow::parse("-3mm"), Ok(Grow::By(Length::millimeters(-3.0))));
        for bad in ["", "ring", "3.5rings", "99999rings", "x"] {
            assert!(Grow::parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn parts_are_parsed() {
        let part = |side, path: &str, names: &[&str]| RegionPart {
            side,
            input: path.into(),
            names: names.iter().map(|&name| name.to_owned()).collect(),
        };
        assert_eq!(RegionPart::parse("a.npy"), part(Side::Source, "a.npy", &[]));
        assert_eq!(
            RegionPart::parse("target:b.pkl#face,neck"),
            part(Side::Target, "b.pkl", &["face", "neck"])
        );
        assert_eq!(RegionPart::parse("C:\\x.txt"), part(Side::Source, "C:\\x.txt", &[]));
    }
}
