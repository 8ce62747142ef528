//! Material maps as option values.

use clap::ValueEnum;
use uvgraft::NormalY;

/// A material map, or the base of one, with its role.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct RoleFile {
    pub(crate) role: String,
    pub(crate) file: String,
}

impl RoleFile {
    /// Parses `ROLE=FILE`.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((role, file)) if !role.is_empty() && !file.is_empty() => {
                Ok(Self { role: role.to_ascii_lowercase(), file: file.to_owned() })
            }
            _ => Err("must be ROLE=FILE, such as normal=face_normal.png".to_owned()),
        }
    }
}

/// Which way the green channel of a normal map points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum NormalYName {
    /// Y up, as in OpenGL, glTF, Unity and Blender
    Opengl,
    /// Y down, as in DirectX and Unreal
    Directx,
}

impl From<NormalYName> for NormalY {
    fn from(name: NormalYName) -> Self {
        match name {
            NormalYName::Opengl => Self::OpenGl,
            NormalYName::Directx => Self::DirectX,
        }
    }
}
