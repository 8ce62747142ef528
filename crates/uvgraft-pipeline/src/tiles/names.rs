//! File names with the number of a tile, or with a placeholder for it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use uvgraft::Tile;
use uvgraft::listing::listed;

use crate::failure::{Blame, Context, Failure, Result};

/// Stands for the number of a tile.
pub(crate) const PLACEHOLDER: &str = "<UDIM>";

/// A path whose file name has one placeholder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Pattern {
    path: PathBuf,
    before: String,
    after: String,
}

impl Pattern {
    /// # Errors
    /// If there is no placeholder, or one that is not in the file name, or several.
    pub(super) fn parse(path: &Path) -> Result<Self> {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let folder = path.parent().and_then(Path::to_str).unwrap_or_default();
        let bad = || {
            Failure::input(format!(
                "{}: must have {PLACEHOLDER} exactly once, in the file name",
                path.display()
            ))
        };
        let (before, after) = name.split_once(PLACEHOLDER).ok_or_else(bad)?;
        if after.contains(PLACEHOLDER) || folder.contains(PLACEHOLDER) {
            return Err(bad());
        }
        let (before, after) = (before.to_owned(), after.to_owned());
        Ok(Self { path: path.to_path_buf(), before, after })
    }

    /// The path of a tile.
    pub(super) fn of(&self, tile: Tile) -> PathBuf {
        self.path.with_file_name(format!("{}{tile}{}", self.before, self.after))
    }

    /// The files that exist, by tile.
    ///
    /// # Errors
    /// If there are none, if the folder cannot be read, or if four digits are not those of a tile.
    pub(super) fn files(&self) -> Result<BTreeMap<Tile, PathBuf>> {
        let folder = self.path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new("."));
        let name = self.path.display();
        let what = format_args!("{name}: cannot read the folder {}", folder.display());
        let entries = folder.read_dir().or_input().context(what)?;
        let mut files = BTreeMap::new();
        for entry in entries {
            let entry = entry.or_input().context(&name)?;
            let found = entry.file_name();
            let digits = found
                .to_str()
                .and_then(|found| found.strip_prefix(&self.before)?.strip_suffix(&self.after))
                .filter(|digits| digits.len() == 4 && digits.bytes().all(|it| it.is_ascii_digit()));
            let Some(digits) = digits else { continue };
            let path = self.path.with_file_name(&found);
            // A pipe would block.
            if !path.is_file() {
                return Err(Failure::input(format!("{}: must be a file", path.display())));
            }
            let tile: Tile = digits.parse().or_input().context(path.display())?;
            files.insert(tile, path);
        }
        if files.is_empty() {
            return Err(Failure::input(format!(
                "{name}: no file with the number of a tile in place of {PLACEHOLDER}, such as {}",
                self.of(Tile::FIRST).display()
            )));
        }
        Ok(files)
    }
}

/// A path whose name must have a placeholder because there are several tiles.
pub(super) fn with_placeholder(path: &Path) -> Result<Pattern> {
    Pattern::parse(path)
}

/// A file name such as `face.1003.png` as a pattern, and the tile; `None` for other names.
pub(super) fn numbered(path: &Path) -> Option<(PathBuf, Tile)> {
    let (rest, extension) = path.file_name()?.to_str()?.rsplit_once('.')?;
    let (stem, digits) = rest.rsplit_once('.')?;
    let tile = digits.parse().ok().filter(|_| !stem.is_empty())?;
    Some((path.with_file_name(format!("{stem}.{PLACEHOLDER}.{extension}")), tile))
}

/// The outputs for some tiles. A name without a placeholder is that of the only tile.
///
/// - `is_chosen_here`: whether the name is not the user's own, so that it can get a number.
pub(super) fn of_tiles(
    output: &Path,
    tiles: &BTreeSet<Tile>,
    is_chosen_here: bool,
) -> Result<BTreeMap<Tile, PathBuf>> {
    let pattern = if output.to_str().is_some_and(|name| name.contains(PLACEHOLDER)) {
        Pattern::parse(output)?
    } else if tiles.len() <= 1 {
        return Ok(tiles.iter().map(|&tile| (tile, output.to_path_buf())).collect());
    } else if let (true, Some(stem), Some(extension)) = (
        is_chosen_here,
        output.file_stem().and_then(|stem| stem.to_str()),
        output.extension().and_then(|extension| extension.to_str()),
    ) {
        Pattern::parse(&output.with_file_name(format!("{stem}.{PLACEHOLDER}.{extension}")))?
    } else {
        return Err(Failure::input(format!(
            "{}: the target has several tiles ({}), so the name must have {PLACEHOLDER} where their \
             numbers go",
            output.display(),
            listed(tiles)
        )));
    };
    Ok(tiles.iter().map(|&tile| (tile, pattern.of(tile))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_numbers() {
        let tile: Tile = "1003".parse().unwrap();
        let pattern = Pattern::parse(Path::new("maps/face_<UDIM>.png")).unwrap();
        assert_eq!(pattern.of(tile), Path::new("maps/face_1003.png"));
        for bad in ["face.png", "<UDIM>_<UDIM>.png", "<UDIM>/face_<UDIM>.png"] {
            assert!(Pattern::parse(Path::new(bad)).is_err(), "{bad}");
        }
        let of =
            |name: &str| numbered(Path::new(name)).map(|it| (it.0.display().to_string(), it.1));
        assert_eq!(of("a/face.1003.png"), Some(("a/face.<UDIM>.png".to_owned(), tile)));
        for other in
            ["face_1003.png", "face.0999.png", "face.png", "1003.png", ".1003.png", "f.x.png"]
        {
            assert_eq!(of(other), None, "{other}");
        }
    }

    #[test]
    fn outputs_of_several_tiles_need_a_placeholder() {
        let tiles = |numbers: &[&str]| -> BTreeSet<Tile> {
            numbers.iter().map(|number| number.parse().unwrap()).collect()
        };
        let of = |name: &str, numbers: &[&str], is_chosen_here| {
            let named = of_tiles(Path::new(name), &tiles(numbers), is_chosen_here)?;
            Ok(named.into_values().map(|path| path.display().to_string()).collect::<Vec<_>>())
        };
        assert_eq!(of("out.png", &["1002"], false), Ok(vec!["out.png".to_owned()]));
        let two = ["1001", "1003"];
        assert_eq!(of("o_<UDIM>.png", &two, false).unwrap(), ["o_1001.png", "o_1003.png"]);
        assert_eq!(of("d/out.png", &two, true).unwrap(), ["d/out.1001.png", "d/out.1003.png"]);
        let error: Failure = of("out.png", &two, false).unwrap_err();
        assert!(error.to_string().contains("several tiles (1001, 1003)"), "{error}");
    }
}
