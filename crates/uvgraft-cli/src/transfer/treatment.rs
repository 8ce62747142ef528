//! What kind of map a texture is, and what is done to it for that.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use uvgraft::{Depth, Encoding, Filter, NormalOptions, NormalY, TexelFormat, TransferOptions};
use uvgraft_io::image::Format;

use super::Args;
use crate::blending::Values;
use crate::failure::bad_input;

/// What is done to a texture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Treatment {
    kind: Kind,
    normals: NormalOptions,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Takes part in finding a common tone.
    Albedo,
    Color,
    Data,
    Normal,
    /// Data that is worked on as floats where the output can hold them.
    Displacement,
}

const ROLES: [(&str, Kind); 27] = [
    ("albedo", Kind::Albedo),
    ("base-color", Kind::Albedo),
    ("color", Kind::Albedo),
    ("diffuse", Kind::Albedo),
    ("emissive", Kind::Color),
    ("sheen-color", Kind::Color),
    ("specular-color", Kind::Color),
    ("subsurface-color", Kind::Color),
    ("alpha", Kind::Data),
    ("ao", Kind::Data),
    ("cavity", Kind::Data),
    ("clearcoat", Kind::Data),
    ("curvature", Kind::Data),
    ("data", Kind::Data),
    ("gloss", Kind::Data),
    ("mask", Kind::Data),
    ("metallic", Kind::Data),
    ("occlusion", Kind::Data),
    ("opacity", Kind::Data),
    ("orm", Kind::Data),
    ("roughness", Kind::Data),
    ("specular", Kind::Data),
    ("subsurface", Kind::Data),
    ("thickness", Kind::Data),
    ("normal", Kind::Normal),
    ("displacement", Kind::Displacement),
    ("height", Kind::Displacement),
];

/// Which way the green channel of a normal map points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum NormalYName {
    /// Up, as in OpenGL, glTF, Unity and Blender
    Opengl,
    /// Down, as in DirectX and Unreal
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

impl Treatment {
    /// Of textures that no role is named for.
    pub(super) fn plain(args: &Args) -> Self {
        Self::new(if args.data { Kind::Data } else { Kind::Albedo }, args)
    }

    fn new(kind: Kind, args: &Args) -> Self {
        let source = args.normal_y.into();
        let target = args.normal_y_out.map_or(source, NormalY::from);
        Self { kind, normals: NormalOptions { source, target } }
    }

    /// Of a role that `--map` names.
    pub(super) fn of_role(role: &str, args: &Args) -> anyhow::Result<Self> {
        let found = ROLES.iter().find(|(name, _)| *name == role);
        found.map(|&(_, kind)| Self::new(kind, args)).ok_or_else(|| {
            let names: Vec<&str> = ROLES.iter().map(|(name, _)| *name).collect();
            bad_input(format!("--map {role}: wanted one of {}", names.join(", ")))
        })
    }

    /// What its values are.
    pub(super) fn values(self) -> Values {
        match self.kind {
            Kind::Albedo => Values::Albedo,
            Kind::Color => Values::Color,
            Kind::Data | Kind::Normal | Kind::Displacement => Values::Data,
        }
    }

    pub(super) fn is_data(self) -> bool {
        !matches!(self.kind, Kind::Albedo | Kind::Color)
    }

    pub(super) fn is_toned(self) -> bool {
        self.kind == Kind::Albedo
    }

    /// How normals are written, if it holds normals.
    pub(super) fn normals(self) -> Option<NormalOptions> {
        (self.kind == Kind::Normal).then_some(self.normals)
    }

    /// What a base is where none is named: as values, with 1.0 for full.
    pub(super) fn nothing(self) -> [f32; 4] {
        match self.kind {
            Kind::Normal => [0.5, 0.5, 1.0, 1.0],
            // No channel of data says that there is nothing.
            Kind::Data | Kind::Displacement => [0.0, 0.0, 0.0, 1.0],
            Kind::Albedo | Kind::Color => [0.0; 4],
        }
    }

    pub(super) fn filter(self, args: &Args) -> Filter {
        match args.filter {
            Some(name) => name.into(),
            // Overshoot would put values into data that none of its texels has.
            None if self.is_data() => Filter::Bilinear,
            None => TransferOptions::default().filter,
        }
    }

    /// What a texture of some format is taken for.
    pub(super) fn meant(self, format: TexelFormat) -> TexelFormat {
        if self.is_data() { TexelFormat { encoding: Encoding::Data, ..format } } else { format }
    }

    /// The depth that a texture is worked on in, where it is to be written to `output`.
    pub(super) fn depth(self, found: Depth, output: &Path) -> Depth {
        let holds_floats = matches!(Format::from_path(output), Some(Format::Exr | Format::Tiff));
        if self.kind == Kind::Displacement && holds_floats { Depth::F32 } else { found }
    }
}

/// A map of a material: its role and its file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct RoleFile {
    pub(super) role: String,
    pub(super) path: PathBuf,
}

impl RoleFile {
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((role, path)) if !role.is_empty() && !path.is_empty() => {
                Ok(Self { role: role.to_ascii_lowercase(), path: PathBuf::from(path) })
            }
            _ => Err("wanted ROLE=FILE, such as normal=face_normal.png".to_owned()),
        }
    }
}
