//! Maps other than colours: their roles, and which of them go together.

use uvgraft::{Choice, NormalY};
use uvgraft_files::input::Input;
use uvgraft_gltf::glb::ShadingModel;
use uvgraft_pipeline::{BaseSource, Failure, Result};

use super::request::MaterialOptions;

/// The role of a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MapRole {
    /// Tangent-space normals.
    Normal,
    /// Roughness.
    Roughness,
    /// Metalness.
    Metallic,
    /// Ambient occlusion.
    Occlusion,
    /// Occlusion, roughness and metallic in red, green and blue.
    Orm,
    /// Emitted light, in colour.
    Emissive,
}

/// Names of the roles, `ao` among them.
const ROLES: [(&str, MapRole); 7] = [
    ("normal", MapRole::Normal),
    ("roughness", MapRole::Roughness),
    ("metallic", MapRole::Metallic),
    ("occlusion", MapRole::Occlusion),
    ("ao", MapRole::Occlusion),
    ("orm", MapRole::Orm),
    ("emissive", MapRole::Emissive),
];

/// The glTF default for a missing map, as in [`uvgraft_gltf::glb::AvatarMaterial::new`].
pub(super) const ROUGHNESS: f32 = 0.7;

impl MapRole {
    /// All roles.
    pub const ALL: [Self; 6] =
        [Self::Normal, Self::Roughness, Self::Metallic, Self::Occlusion, Self::Orm, Self::Emissive];

    /// The role of a name, in lower case.
    pub fn named(name: &str) -> Option<Self> {
        ROLES.into_iter().find(|(known, _)| *known == name).map(|(_, role)| role)
    }

    /// The name of the role.
    pub fn name(self) -> &'static str {
        ROLES.into_iter().find(|(_, role)| *role == self).map_or("", |(name, _)| name)
    }

    /// All names of roles, for messages.
    pub fn names() -> String {
        ROLES.map(|(name, _)| name).join(", ")
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
pub(super) struct MapRequest<'a> {
    pub(super) role: MapRole,
    /// In the head's layout.
    pub(super) face: Option<&'a Input>,
    /// In the body's layout.
    pub(super) onto: Option<&'a BaseSource>,
}

impl MaterialOptions {
    /// The maps of all roles that the face or the body have.
    pub(super) fn requested(&self) -> Vec<MapRequest<'_>> {
        let mut maps: Vec<MapRequest<'_>> = Vec::new();
        for (role, face) in &self.maps {
            maps.push(MapRequest { role: *role, face: Some(face), onto: None });
        }
        for (role, onto) in &self.base_maps {
            match maps.iter_mut().find(|map| map.role == *role) {
                Some(map) => map.onto = Some(onto),
                None => maps.push(MapRequest { role: *role, face: None, onto: Some(onto) }),
            }
        }
        maps
    }

    /// Rejects roles that are given twice or contain each other, and maps that are not shown.
    pub(super) fn check(&self, is_vrm: bool) -> Result<()> {
        let faces: Vec<MapRole> = self.maps.iter().map(|(role, _)| *role).collect();
        let bases: Vec<MapRole> = self.base_maps.iter().map(|(role, _)| *role).collect();
        for (option, roles) in [("map", &faces), ("onto", &bases)] {
            if let Some(role) = repeated(roles) {
                let name = role.name();
                return Err(Failure::option(format!("`{option}` {name}: role given twice")));
            }
        }
        let has = |role| faces.contains(&role) || bases.contains(&role);
        let parts = [MapRole::Occlusion, MapRole::Roughness, MapRole::Metallic];
        if has(MapRole::Orm) && parts.into_iter().any(has) {
            return Err(Failure::option(
                "`map` orm cannot be used with `map` occlusion, roughness or metallic, which it \
                 contains",
            ));
        }
        let ignored = faces.iter().chain(&bases).find(|&&role| match self.look {
            ShadingModel::Pbr => false,
            ShadingModel::MToon => !matches!(role, MapRole::Normal | MapRole::Emissive),
            ShadingModel::Unlit => true,
        });
        if let Some(role) = ignored {
            let name = role.name();
            return Err(Failure::option(match self.look {
                ShadingModel::Unlit => format!("`look` unlit cannot be used with the map {name}"),
                _ => format!("`look` mtoon supports normal and emissive maps only, got {name}"),
            }));
        }
        if self.normal_y != NormalY::OpenGl && !has(MapRole::Normal) {
            let name = self.normal_y.name();
            return Err(Failure::option(format!(
                "`normal_y` {name} has no effect without a normal map: add `map` normal=FILE or \
                 `onto` normal=IMAGE"
            )));
        }
        if self.look == ShadingModel::MToon && !is_vrm {
            return Err(Failure::option(
                "`look` mtoon needs a .vrm output; for a .glb use `look` unlit or `look` pbr",
            ));
        }
        Ok(())
    }
}

fn repeated(roles: &[MapRole]) -> Option<MapRole> {
    let is_repeated = |(index, role): &(usize, &MapRole)| roles[..*index].contains(role);
    roles.iter().enumerate().find(is_repeated).map(|(_, &role)| role)
}
