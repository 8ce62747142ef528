//! Maps beside the colour, and how surfaces are lit.

use std::path::{Path, PathBuf};

use uvgraft::{
    Averaging, Channels, Content, Depth, Encoding, Filter, NormalOptions, NormalY, Size, Texels,
    TexelsMut, Texture,
};
use uvgraft_avatar::glb::{Looks, Picture, PictureError, PictureFormat, Style};
use uvgraft_io::image;
use uvgraft_pipeline::Onto;

use super::carried::{Carried, Carrier};
use crate::failure::{OrBadInput, bad_input};
use crate::role_file::{NormalYName, RoleFile};

/// Maps of the face, and how surfaces are lit.
#[derive(clap::Args)]
#[command(next_help_heading = "Materials")]
pub(super) struct MaterialArgs {
    /// A further map of the face, in the head's layout, and what it is: normal, roughness, metallic, occlusion, orm
    /// (occlusion, roughness and metallic in red, green and blue) or emissive, such as normal=face_normal.png; may
    /// be repeated. --onto ROLE=IMAGE is the body's own
    #[arg(long = "map", value_name = "ROLE=FILE", value_parser = RoleFile::parse)]
    maps: Vec<RoleFile>,
    /// Which way the green channel of normal maps points; the avatar's points up, as glTF has it
    #[arg(long, value_enum, default_value = "opengl")]
    normal_y: NormalYName,
    /// How surfaces are lit
    #[arg(long, value_enum, default_value_t = LookName::Pbr)]
    look: LookName,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum LookName {
    /// Physically, which everything knows
    Pbr,
    /// As drawings are, in a .vrm (MToon 1.0); what does not know it lights it as pbr
    Mtoon,
    /// Not at all: plain colours, for textures with light in them
    Unlit,
}

/// What a map is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum MapRole {
    Normal,
    Roughness,
    Metallic,
    Occlusion,
    Orm,
    Emissive,
}

const ROLES: [(&str, MapRole); 7] = [
    ("normal", MapRole::Normal),
    ("roughness", MapRole::Roughness),
    ("metallic", MapRole::Metallic),
    ("occlusion", MapRole::Occlusion),
    ("ao", MapRole::Occlusion),
    ("orm", MapRole::Orm),
    ("emissive", MapRole::Emissive),
];

/// As glTF takes it where there is no map; [`Looks::new`] has it too.
const ROUGHNESS: f32 = 0.7;

impl MapRole {
    fn named(name: &str) -> Option<Self> {
        ROLES.into_iter().find(|(known, _)| *known == name).map(|(_, role)| role)
    }

    /// What a map is of where nothing is known.
    const fn nothing(self) -> [f32; 3] {
        match self {
            Self::Normal => [0.5, 0.5, 1.0],
            Self::Roughness => [ROUGHNESS; 3],
            Self::Metallic | Self::Emissive => [0.0; 3],
            Self::Occlusion => [1.0; 3],
            Self::Orm => [1.0, ROUGHNESS, 0.0],
        }
    }
}

/// A map that is asked for.
struct Wanted {
    role: MapRole,
    /// In the head's layout.
    face: Option<PathBuf>,
    /// In the body's.
    onto: Option<Onto>,
}

/// What materials are to be made of, checked.
pub(super) struct Materials {
    maps: Vec<Wanted>,
    normal_y: NormalY,
    pub(super) style: Style,
}

/// What `--onto` says: the body's colour, and bases of maps.
pub(super) struct Bases {
    pub(super) color: Onto,
    maps: Vec<(MapRole, Onto)>,
}

impl Bases {
    /// - `texts`: an image or a colour, and any number of them after `ROLE=`.
    pub(super) fn parse(texts: &[String]) -> anyhow::Result<Self> {
        let (mut color, mut maps) = (None, Vec::<(MapRole, Onto)>::new());
        for text in texts {
            let named = text.split_once('=');
            match named
                .and_then(|(name, base)| Some((MapRole::named(&name.to_ascii_lowercase())?, base)))
            {
                Some((role, _)) if maps.iter().any(|(known, _)| *known == role) => {
                    return Err(bad_input(format!(
                        "--onto {text}: there is a base for that map already"
                    )));
                }
                Some((role, base)) => maps.push((role, Onto::parse(base)?)),
                None if color.is_some() => {
                    return Err(bad_input(format!(
                        "--onto {text}: a body has one colour texture; bases of maps are ROLE=IMAGE, ROLE being {}",
                        role_names()
                    )));
                }
                None => color = Some(Onto::parse(text)?),
            }
        }
        let color = color.ok_or_else(|| {
            bad_input("--onto: the body's colours are missing: an image in its layout, or a colour such as #c08a70")
        })?;
        Ok(Self { color, maps })
    }
}

fn role_names() -> String {
    ROLES.map(|(name, _)| name).join(", ")
}

impl MaterialArgs {
    /// Checks what is asked for.
    pub(super) fn check(&self, bases: Bases, is_vrm: bool) -> anyhow::Result<Materials> {
        let mut maps: Vec<Wanted> = Vec::new();
        for RoleFile { role: name, file } in &self.maps {
            let role = MapRole::named(name).ok_or_else(|| {
                bad_input(format!(
                    "--map {name}: GLB and VRM files have no place for it; expected one of {}",
                    role_names()
                ))
            })?;
            if maps.iter().any(|map| map.role == role) {
                return Err(bad_input(format!("--map {name}={file}: that map is given already")));
            }
            maps.push(Wanted { role, face: Some(PathBuf::from(file)), onto: None });
        }
        for (role, onto) in bases.maps {
            match maps.iter_mut().find(|map| map.role == role) {
                Some(map) => map.onto = Some(onto),
                None => maps.push(Wanted { role, face: None, onto: Some(onto) }),
            }
        }
        let has = |role| maps.iter().any(|map| map.role == role);
        let parts = [MapRole::Occlusion, MapRole::Roughness, MapRole::Metallic];
        if has(MapRole::Orm) && parts.into_iter().any(has) {
            return Err(bad_input(
                "--map orm holds occlusion, roughness and metallic: give it or them, not both",
            ));
        }
        let style = self.look.style();
        let ignored = maps.iter().find(|map| match style {
            Style::Pbr => false,
            Style::MToon => !matches!(map.role, MapRole::Normal | MapRole::Emissive),
            Style::Unlit => true,
        });
        if let Some(map) = ignored {
            let name =
                ROLES.iter().find(|(_, role)| *role == map.role).map_or("", |(name, _)| name);
            return Err(bad_input(match style {
                Style::Unlit => {
                    format!("--look unlit shows plain colours: leave out the map {name}")
                }
                _ => format!("--look mtoon knows normal and emissive maps only: leave out {name}"),
            }));
        }
        if style == Style::MToon && !is_vrm {
            return Err(bad_input(
                "--look mtoon is for VRM: write a .vrm, or use --look unlit or --look pbr",
            ));
        }
        Ok(Materials { maps, normal_y: self.normal_y.into(), style })
    }
}

impl LookName {
    const fn style(self) -> Style {
        match self {
            Self::Pbr => Style::Pbr,
            Self::Mtoon => Style::MToon,
            Self::Unlit => Style::Unlit,
        }
    }
}

/// The maps of one material.
#[derive(Default)]
struct Set {
    normal: Option<Texture>,
    emissive: Option<Texture>,
    occlusion: Option<Texture>,
    roughness: Option<Texture>,
    metallic: Option<Texture>,
    orm: Option<Texture>,
}

/// The maps in the body's layout, and in the head's own where it keeps that.
pub(super) struct CarriedMaps {
    body: Set,
    head: Set,
}

impl Materials {
    /// The files that are read.
    pub(super) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.maps.iter().flat_map(|map| {
            map.face.as_deref().into_iter().chain(map.onto.as_ref().and_then(Onto::path))
        })
    }

    /// Carries all maps.
    ///
    /// - `size`: of maps whose base is no image.
    pub(super) fn carry(&self, carrier: &Carrier, size: Size) -> anyhow::Result<CarriedMaps> {
        let mut maps = CarriedMaps { body: Set::default(), head: Set::default() };
        for map in &self.maps {
            let Carried { body, head } = self.carry_one(map, carrier, size)?;
            maps.body.put(map.role, body);
            if let Some(head) = head {
                maps.head.put(map.role, head);
            }
        }
        Ok(maps)
    }

    fn carry_one(&self, map: &Wanted, carrier: &Carrier, size: Size) -> anyhow::Result<Carried> {
        let is_color = map.role == MapRole::Emissive;
        let encoding = if is_color { Encoding::Srgb } else { Encoding::Data };
        let read = |path: &Path| -> anyhow::Result<Texture> {
            let texture = image::read(path).or_bad_input()?.texture;
            if map.role == MapRole::Normal && !texture.channels().has_color() {
                return Err(bad_input(format!(
                    "{}: a normal map must have three channels, got a grey image",
                    path.display()
                )));
            }
            let channels = texture.channels().without_alpha();
            let depth = texture.depth();
            let texture = texture.converted(channels, depth);
            Ok(if is_color { texture } else { texture.with_encoding(Encoding::Data) })
        };
        let filled = |color: &[f32]| {
            Texture::filled(carrier.limited(size), Channels::Rgb, encoding, Depth::U8, color)
        };
        let base = match &map.onto {
            Some(Onto::Image(path)) => {
                let base = read(path)?;
                let size = carrier.limited(base.size());
                let base =
                    base.resized(size, Filter::Bilinear, Averaging::Encoded).or_bad_input()?;
                if map.role == MapRole::Normal { self.upward(base) } else { base }
            }
            Some(Onto::Color(color)) => filled(&color[..3]).or_bad_input()?,
            None => filled(&map.role.nothing()).or_bad_input()?,
        };
        let content = match map.role {
            MapRole::Normal => Content::Normals(NormalOptions::new(self.normal_y, NormalY::OpenGl)),
            MapRole::Emissive => Content::Color,
            _ => Content::Data,
        };
        let face = map.face.as_deref().map(read).transpose()?;
        carrier.carry(face, base, content)
    }

    /// A normal map of the body's with green up.
    fn upward(&self, mut texture: Texture) -> Texture {
        if self.normal_y == NormalY::OpenGl {
            return texture;
        }
        let channels = texture.channels().count();
        match texture.texels_mut() {
            TexelsMut::U8(values) => {
                values.chunks_exact_mut(channels).for_each(|texel| texel[1] = u8::MAX - texel[1]);
            }
            TexelsMut::U16(values) => {
                values.chunks_exact_mut(channels).for_each(|texel| texel[1] = u16::MAX - texel[1]);
            }
            TexelsMut::F32(values) => {
                values.chunks_exact_mut(channels).for_each(|texel| texel[1] = 1.0 - texel[1]);
            }
        }
        texture
    }
}

impl Set {
    fn put(&mut self, role: MapRole, texture: Texture) {
        let place = match role {
            MapRole::Normal => &mut self.normal,
            MapRole::Roughness => &mut self.roughness,
            MapRole::Metallic => &mut self.metallic,
            MapRole::Occlusion => &mut self.occlusion,
            MapRole::Orm => &mut self.orm,
            MapRole::Emissive => &mut self.emissive,
        };
        *place = Some(texture);
    }

    /// Puts the maps into a material.
    fn dress(self, looks: &mut Looks, how: &Encoder) -> Result<(), PictureError> {
        looks.normal = self.normal.map(|map| how.data(rgb(map))).transpose()?;
        looks.emissive = self.emissive.map(|map| how.color(rgb(map))).transpose()?;
        let has_occlusion = self.occlusion.is_some() || self.orm.is_some();
        let is_packed = self.roughness.is_some() || self.metallic.is_some() || self.orm.is_some();
        if is_packed {
            let packed = match self.orm {
                Some(orm) => rgb(orm),
                None => packed([
                    (self.occlusion, 1.0),
                    (self.roughness, ROUGHNESS),
                    (self.metallic, 0.0),
                ])?,
            };
            let picture = how.data(packed)?;
            // Factors are multiplied in.
            (looks.roughness_factor, looks.metallic_factor) = (1.0, 1.0);
            looks.occlusion = has_occlusion.then(|| picture.clone());
            looks.roughness = Some(picture);
        } else {
            looks.occlusion = self.occlusion.map(|map| how.data(grey(map))).transpose()?;
        }
        Ok(())
    }
}

impl CarriedMaps {
    /// Makes the materials: the body's, then the head's own, if it has one.
    pub(super) fn looks(
        self,
        colors: (Texture, Option<Texture>),
        how: &Encoder,
    ) -> Result<Vec<Looks>, PictureError> {
        let style = how.style;
        let mut body = Looks { style, ..Looks::new(how.color(colors.0)?) };
        self.body.dress(&mut body, how)?;
        let mut all = vec![body];
        if let Some(color) = colors.1 {
            let color = how.color(color)?;
            let mut head =
                Looks { style, is_head: true, name: "head".to_owned(), ..Looks::new(color) };
            self.head.dress(&mut head, how)?;
            all.push(head);
        }
        Ok(all)
    }
}

/// How textures become files.
pub(super) struct Encoder {
    pub(super) format: PictureFormat,
    pub(super) quality: u8,
    pub(super) style: Style,
}

impl Encoder {
    fn color(&self, texture: Texture) -> Result<Picture, PictureError> {
        Picture::encode(texture, self.format, self.quality)
    }

    /// A JPEG's blocks would show in highlights, so what is to be JPEG is PNG.
    fn data(&self, texture: Texture) -> Result<Picture, PictureError> {
        let format = match self.format {
            PictureFormat::Jpeg => PictureFormat::Png,
            other => other,
        };
        Picture::encode(texture.with_encoding(Encoding::Data), format, self.quality)
    }
}

fn rgb(texture: Texture) -> Texture {
    texture.converted(Channels::Rgb, Depth::U8)
}

fn grey(texture: Texture) -> Texture {
    texture.converted(Channels::Grey, Depth::U8)
}

/// Three maps as the channels of one, of the size of the largest.
///
/// - `maps`: each with what it is where it is missing.
fn packed(maps: [(Option<Texture>, f32); 3]) -> Result<Texture, PictureError> {
    let sizes = maps.iter().filter_map(|(map, _)| Some(map.as_ref()?.size()));
    let size = sizes.max_by_key(|size| size.texels()).unwrap_or(Size::square(1));
    let mut values = vec![0_u8; 3 * size.texels()];
    for (channel, (map, missing)) in maps.into_iter().enumerate() {
        let map = match map {
            Some(map) => grey(map).resized(size, Filter::Bilinear, Averaging::Encoded)?,
            None => Texture::filled(size, Channels::Grey, Encoding::Data, Depth::U8, &[missing])?,
        };
        let Texels::U8(levels) = map.texels() else { continue };
        for (texel, &level) in values.chunks_exact_mut(3).zip(levels) {
            texel[channel] = level;
        }
    }
    Ok(Texture::new(size, Channels::Rgb, Encoding::Data, Texels::U8(values))?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_are_packed_into_the_largest() {
        let filled = |side, level: f32| {
            let size = Size::square(side);
            Texture::filled(size, Channels::Grey, Encoding::Data, Depth::U8, &[level]).unwrap()
        };
        let both = packed([(None, 1.0), (Some(filled(4, 0.6)), 0.7), (Some(filled(8, 0.2)), 0.0)]);
        let both = both.unwrap();
        assert_eq!((both.size(), both.encoding()), (Size::square(8), Encoding::Data));
        let texel = [0, 1, 2].map(|channel| (255.0 * both.get(3, 5, channel)).round());
        assert_eq!(texel, [255.0, 153.0, 51.0]);
    }

    #[test]
    fn bases_are_told_by_their_roles() {
        let parse =
            |texts: &[&str]| Bases::parse(&texts.iter().map(|&t| t.to_owned()).collect::<Vec<_>>());
        let bases = parse(&["normal=n.png", "a=b.png", "ORM=#ff8000"]).unwrap();
        assert_eq!(bases.color, Onto::Image("a=b.png".into()));
        assert_eq!(bases.maps[0], (MapRole::Normal, Onto::Image("n.png".into())));
        assert_eq!(bases.maps[1].0, MapRole::Orm);
        assert!(parse(&["normal=n.png"]).is_err() && parse(&["a.png", "b.png"]).is_err());
        assert!(parse(&["a.png", "ao=n.png", "occlusion=n.png"]).is_err());
    }
}
