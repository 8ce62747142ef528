//! Options for additional maps and for shading, and the bases of maps.

use uvgraft::{Choice, NormalY};
use uvgraft_assembly::Input;
use uvgraft_assembly::avatar::{MapRole, MaterialOptions};
use uvgraft_gltf::glb::ShadingModel;
use uvgraft_pipeline::BaseSource;

use crate::choice::choice;
use crate::failure::bad_input;
use crate::heading;
use crate::role_file::RoleFile;

/// Options for maps of the face, and for shading.
#[derive(clap::Args)]
#[command(next_help_heading = heading::MATERIALS)]
pub(super) struct MaterialArgs {
    /// Additional map of the face, by its role; repeatable
    ///
    /// In the head's layout, such as normal=face_normal.png. Roles: normal, roughness, metallic,
    /// occlusion, orm (occlusion, roughness and metallic in red, green and blue) and emissive. Use
    /// --onto ROLE=IMAGE for the body's map of the same role.
    #[arg(long = "map", id = "map", value_name = "ROLE=FILE", value_parser = RoleFile::parse)]
    maps: Vec<RoleFile>,
    /// Green channel convention of input normal maps
    ///
    /// Normal maps of the avatar follow glTF, which is opengl.
    #[arg(long, value_name = "CONVENTION", value_parser = choice::<NormalY>())]
    #[arg(default_value = NormalY::OpenGl.name())]
    normal_y: NormalY,
    /// Shading model
    #[arg(long, value_parser = choice::<ShadingModel>(), default_value = ShadingModel::Pbr.name())]
    look: ShadingModel,
}

/// Parsed `--onto` options: the body's colour, and bases of maps.
pub(super) struct Bases {
    pub(super) color: Option<BaseSource>,
    maps: Vec<(MapRole, BaseSource)>,
}

impl Bases {
    /// - `texts`: an image or a colour, and any number of `ROLE=IMAGE` or `ROLE=COLOUR`.
    pub(super) fn parse(texts: &[String]) -> anyhow::Result<Self> {
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
                        MapRole::names()
                    )));
                }
                None => color = Some(BaseSource::parse(text)?),
            }
        }
        Ok(Self { color, maps })
    }
}

impl MaterialArgs {
    /// The options with the bases of maps.
    pub(super) fn options(&self, bases: Bases) -> anyhow::Result<MaterialOptions> {
        let mut maps = Vec::<(MapRole, Input)>::new();
        for RoleFile { role: name, file } in &self.maps {
            let role = MapRole::named(name).ok_or_else(|| {
                bad_input(format!("--map {name}: role must be one of {}", MapRole::names()))
            })?;
            if maps.iter().any(|(known, _)| *known == role) {
                return Err(bad_input(format!("--map {name}={file}: role given twice")));
            }
            maps.push((role, file.into()));
        }
        let (normal_y, look) = (self.normal_y, self.look);
        Ok(MaterialOptions { maps, base_maps: bases.maps, normal_y, look })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bases_are_reported_by_their_roles() {
        let parse = |texts: &[&str]| {
            Bases::parse(&texts.iter().map(|&text| text.to_owned()).collect::<Vec<_>>())
        };
        let bases = parse(&["normal=n.png", "a=b.png", "ORM=#ff8000"]).unwrap();
        assert_eq!(bases.color, Some(BaseSource::Image("a=b.png".into())));
        assert_eq!(bases.maps[0], (MapRole::Normal, BaseSource::Image("n.png".into())));
        assert_eq!(bases.maps[1].0, MapRole::Orm);
        assert!(parse(&["a.png", "b.png"]).is_err());
        assert!(parse(&["a.png", "ao=n.png", "occlusion=n.png"]).is_err());
        assert_eq!(parse(&["normal=n.png"]).unwrap().color, None);
    }
}
