//! The images of a texture's tiles.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use uvgraft::{Channels, Depth, Direction, Encoding, Pair, Size, Tile, TileAtlas, tile_atlas};
use uvgraft_image::{self as image, Image, WriteOptions};

use super::has_placeholder;
use super::names::{Pattern, numbered};
use crate::failure::{Blame, Context, Failure, Result};
use crate::observer::Observer;
use crate::texture_transfer::write_failure;

/// A texture with an image for each tile.
pub(super) struct TiledSource {
    /// As the user named it.
    name: PathBuf,
    files: BTreeMap<Tile, PathBuf>,
}

impl TiledSource {
    /// The images by a name with a placeholder, or the only one by its own name: of the tile whose
    /// number it has, or else of the unit square.
    pub(super) fn find(name: &Path) -> Result<Self> {
        let files = if has_placeholder(name) {
            Pattern::parse(name)?.files()?
        } else {
            let tile = numbered(name).map_or(Tile::FIRST, |(_, tile)| tile);
            BTreeMap::from([(tile, name.to_path_buf())])
        };
        Ok(Self { name: name.to_path_buf(), files })
    }

    pub(super) fn name(&self) -> &Path {
        &self.name
    }

    pub(super) fn files(&self) -> &BTreeMap<Tile, PathBuf> {
        &self.files
    }

    /// Warns of linked faces whose tile has no image.
    pub(super) fn report_missing(
        &self,
        pair: &Pair,
        direction: Direction,
        observer: &dyn Observer,
    ) {
        let mut missing: BTreeMap<Tile, BTreeSet<u32>> = BTreeMap::new();
        for (piece, [read, _]) in pair.tiles(direction) {
            if !self.files.contains_key(&read) {
                let face = match direction {
                    Direction::Forward => piece.target,
                    Direction::Reverse => piece.source,
                };
                missing.entry(read).or_default().insert(face);
            }
        }
        for (tile, faces) in missing {
            let (name, count) = (self.name.display(), faces.len());
            let triangles = if count == 1 { "triangle is" } else { "triangles are" };
            observer.warn(format_args!(
                "{name}: no image for tile {tile}, so {count} {triangles} left unlinked"
            ));
        }
    }

    /// The first image, and the size of all.
    fn first_and_size(&self) -> Result<(&PathBuf, Size)> {
        let mut size = None;
        for path in self.files.values() {
            let found = image::read_header(path).or_input()?.size;
            let (first, first_size) = *size.get_or_insert((path, found));
            if found != first_size {
                return Err(Failure::input(format!(
                    "images of tiles must have the same size, but {} has {first_size} and {} has \
                     {found} texels",
                    first.display(),
                    path.display()
                )));
            }
        }
        size.ok_or_else(|| Failure::input(format!("{}: no images", self.name.display())))
    }

    /// The channels and depth that hold the values of all images.
    fn common_format(&self, first_path: &Path, images: &[Image]) -> Result<(Channels, Depth)> {
        let first = &images[0];
        let (mut channels, mut depth) = (first.texture.channels(), first.texture.depth());
        for (path, image) in self.files.values().zip(images) {
            if image.texture.encoding() != first.texture.encoding() || image.icc != first.icc {
                return Err(Failure::input(format!(
                    "images of tiles must have the same colour space, but {} and {} differ in their \
                     encoding or ICC profile",
                    first_path.display(),
                    path.display()
                )));
            }
            channels = channels.union(image.texture.channels());
            depth = depth.max(image.texture.depth());
        }
        Ok((channels, depth))
    }

    /// Joins the images into one file in a folder; a single image stays as it is.
    ///
    /// # Errors
    /// For images that cannot be read, of different sizes, or too large together.
    pub(super) fn join(&self, folder: &Path) -> Result<(TileAtlas, PathBuf)> {
        let (first, size) = self.first_and_size()?;
        let name = self.name.display();
        let atlas = TileAtlas::new(self.files.keys().copied().collect(), size);
        let atlas = atlas.or_input().context(&name)?;
        if self.files.len() == 1 {
            return Ok((atlas, first.clone()));
        }
        let images: Vec<Image> = (self.files.values())
            .map(|path| image::read(path).or_input())
            .collect::<Result<_>>()?;
        let (channels, depth) = self.common_format(first, &images)?;
        let (icc, encoding) = (images[0].icc.clone(), images[0].texture.encoding());
        let textures: Vec<_> =
            images.into_iter().map(|image| image.texture.converted(channels, depth)).collect();
        let texture = tile_atlas::stitch(&atlas, &textures).or_input().context(&name)?;
        drop(textures);
        // Formats that keep every value.
        let file_name = match (depth, encoding) {
            (Depth::U8 | Depth::U16, _) => "atlas.png",
            (Depth::F32, Encoding::Linear) => "atlas.exr",
            (Depth::F32, _) => "atlas.tiff",
        };
        let path = folder.join(file_name);
        let image = Image { texture, icc };
        let written = image::write(&image, &path, &WriteOptions::default());
        // What the atlas cannot keep, such as the ICC profile of an EXR, is not worth a warning.
        let _ = written.map_err(write_failure).context(name)?;
        Ok((atlas, path))
    }
}
