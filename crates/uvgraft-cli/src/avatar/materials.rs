//! Options for additional maps and for shading.

use std::path::{Path, PathBuf};

use uvgraft::NormalY;
use uvgraft_gltf::glb::ShadingModel;
use uvgraft_pipeline::BaseSource;

use crate::failure::bad_input;
use crate::heading;
use crate::role_file::{NormalYName, RoleFile};

/// Options for maps of the face, and for shading.
#[derive(clap::Args)]
#[command(next_help_heading = heading::MATERIALS)]
pub(super) struct MaterialArgs {
    /// Additional map of the face, by its role; repeatable
    ///
    /// In the head's layout, such as normal=face_normal.png. Roles: normal, roughness, metallic,
    /// occlusion, orm (occlusion, roughness and metallic in red, green and blue) and emissive. Use
    /// --onto ROLE=IMAGE for the body's map of the same role.
    #[arg(long = "map", value_name = "ROLE=FILE", value_parser = RoleFile::parse)]
    maps: Vec<RoleFile>,
    /// Green channel convention of input normal maps
    ///
    /// Normal maps of the avatar follow glTF, which is opengl.
    #[arg(long, value_enum, value_name = "CONVENTION", default_value = "opengl")]
    normal_y: NormalYName,
    /// Shading model
    #[arg(long, value_enum, default_value_t = LookName::Pbr)]
    look: LookName,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum LookName {
    /// Physically based, supported everywhere
    Pbr,
    /// Toon shading (MToon 1.0, .vrm only); readers without support use pbr
    Mtoon,
    /// No lighting, for textures with baked light
    Unlit,
}

/// The role of a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MapRole {
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

/// The glTF default for a missing map, as in [`AvatarMaterial::new`].
pub(super) const ROUGHNESS: f32 = 0.7;

impl MapRole {
    fn named(name: &str) -> Option<Self> {
        ROLES.into_iter().find(|(known, _)| *known == name).map(|(_, role)| role)
    }

    /// The neutral value of a map.
    pub(super) const fn nothing(self) -> [f32; 3] {
        match self {
            Self::Normal => [0.5, 0.5, 1.0],
            Self::Roughness => [ROUGHNESS; 3],
            Self::Metallic | Self::Emissive => [0.0; 3],
            Self::Occlusion => [1.0; 3],
            Self::Orm => [1.0, ROUGHNESS, 0.0],
        }
    }
}

/// A map to transfer.
pub(super) struct MapRequest {
    pub(super) role: MapRole,
    /// In the head's layout.
    pub(super) face: Option<PathBuf>,
    /// In the body's layout.
    pub(super) onto: Option<BaseSource>,
}

/// Validated material options.
pub(super) struct Materials {
    pub(super) maps: Vec<MapRequest>,
    pub(super) normal_y: NormalY,
    pub(super) style: ShadingModel,
}

/// Parsed `--onto` options: the body's colour, and bases of maps.
pub(super) struct Bases {
    /// None for a body with a painted skin of its own.
    pub(super) color: Option<BaseSource>,
    maps: Vec<(MapRole, BaseSource)>,
}

impl Bases {
    /// - `texts`: an image or a colour, and any number of `ROLE=IMAGE` or `ROLE=COLOUR`.
    /// - `needs_color`: whether the body's colours must be among them.
    pub(super) fn parse(texts: &[String], needs_color: bool) -> anyhow::Result<Self> {
        let (mut color, mut maps) = (None, Vec::<(MapRole, BaseSource)>::new());
        for text in texts {
            let named = text.split_once('=');
            match named
                .and_then(|(name, base)| Some((MapRole::named(&name.to_ascii_lowercase())?, base)))
            {
                Some((role, _)) if maps.iter().any(|(known, _)| *known == role) => {
                    return Err(bad_input(format!("--onto {text}: role given twice")));
                }
                Some((role, base)) => maps.push((role, BaseSource::parse(base)?)),
                None if color.is_some() => {
                    return Err(bad_input(format!(
                        "--onto {text}: colour texture given twice; for other maps use \
                         ROLE=IMAGE, where ROLE is one of {}",
                        role_names()
                    )));
                }
                None => color = Some(BaseSource::parse(text)?),
            }
        }
        if color.is_none() && needs_color {
            return Err(bad_input(
                "--onto must include the body's colours: an image in its layout, or a colour such \
                 as #c08a70",
            ));
        }
        Ok(Self { color, maps })
    }
}

fn role_names() -> String {
    ROLES.map(|(name, _)| name).join(", ")
}

impl MaterialArgs {
    /// Validates the options.
    pub(super) fn check(&self, bases: Bases, is_vrm: bool) -> anyhow::Result<Materials> {
        let mut maps: Vec<MapRequest> = Vec::new();
        for RoleFile { role: name, file } in &self.maps {
            let role = MapRole::named(name).ok_or_else(|| {
                bad_input(format!("--map {name}: role must be one of {}", role_names()))
            })?;
            if maps.iter().any(|map| map.role == role) {
                return Err(bad_input(format!("--map {name}={file}: role given twice")));
            }
            maps.push(MapRequest { role, face: Some(PathBuf::from(file)), onto: None });
        }
        for (role, onto) in bases.maps {
            match maps.iter_mut().find(|map| map.role == role) {
                Some(map) => map.onto = Some(onto),
                None => maps.push(MapRequest { role, face: None, onto: Some(onto) }),
            }
        }
        let has = |role| maps.iter().any(|map| map.role == role);
        let parts = [MapRole::Occlusion, MapRole::Roughness, MapRole::Metallic];
        if has(MapRole::Orm) && parts.into_iter().any(has) {
            return Err(bad_input(
                "--map orm cannot be used with --map occlusion, roughness or metallic, which it \
                 contains",
            ));
        }
        let style = self.look.style();
        let ignored = maps.iter().find(|map| match style {
            ShadingModel::Pbr => false,
            ShadingModel::MToon => !matches!(map.role, MapRole::Normal | MapRole::Emissive),
            ShadingModel::Unlit => true,
        });
        if let Some(map) = ignored {
            let name =
                ROLES.iter().find(|(_, role)| *role == map.role).map_or("", |(name, _)| name);
            return Err(bad_input(match style {
                ShadingModel::Unlit => {
                    format!("--look unlit cannot be used with the map {name}")
                }
                _ => format!("--look mtoon supports normal and emissive maps only, got {name}"),
            }));
        }
        if style == ShadingModel::MToon && !is_vrm {
            return Err(bad_input(
                "--look mtoon needs a .vrm output; for a .glb use --look unlit or --look pbr",
            ));
        }
        Ok(Materials { maps, normal_y: self.normal_y.into(), style })
    }
}

impl LookName {
    const fn style(self) -> ShadingModel {
        match self {
            Self::Pbr => ShadingModel::Pbr,
            Self::Mtoon => ShadingModel::MToon,
            Self::Unlit => ShadingModel::Unlit,
        }
    }
}

impl Materials {
    /// The input files.
    pub(super) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.maps.iter().flat_map(|map| {
            map.face.as_deref().into_iter().chain(map.onto.as_ref().and_then(BaseSource::path))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bases_are_told_by_their_roles() {
        let owned = |texts: &[&str]| texts.iter().map(|&t| t.to_owned()).collect::<Vec<_>>();
        let parse = |texts: &[&str]| Bases::parse(&owned(texts), true);
        let bases = parse(&["normal=n.png", "a=b.png", "ORM=#ff8000"]).unwrap();
        assert_eq!(bases.color, Some(BaseSource::Image("a=b.png".into())));
        assert_eq!(bases.maps[0], (MapRole::Normal, BaseSource::Image("n.png".into())));
        assert_eq!(bases.maps[1].0, MapRole::Orm);
        assert!(parse(&["normal=n.png"]).is_err() && parse(&["a.png", "b.png"]).is_err());
        assert!(parse(&["a.png", "ao=n.png", "occlusion=n.png"]).is_err());
        let maps_alone = Bases::parse(&owned(&["normal=n.png"]), false).unwrap();
        assert_eq!(maps_alone.color, None);
    }
}
