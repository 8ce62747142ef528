//! Body models of the SMPL family: shape, expression and pose, by linear blend skinning with pose
//! correctives.
//!
//! A [`BodyModel`] is read from arrays that the user has; [`BodyModel::shaped`] is one person,
//! and [`Shaped::posed`] that person in a pose. [`Shaped::avatar`] makes a rig of it that any viewer
//! plays.
//!
//! # Source
//! Loper et al., "SMPL: A Skinned Multi-Person Linear Model", 2015; Romero et al., "Embodied Hands",
//! 2017 (SMPL-H); Li et al., "Learning a model of facial shape and expression from 4D scans", 2017
//! (FLAME); Pavlakos et al., "Expressive Body Capture", 2019 (SMPL-X). Files are read as the Python
//! package `smplx` reads them, and results agree with its.

mod correctives;
mod expressive;
mod fields;
mod file;
mod gender;
mod hands;
mod kind;
mod model;
mod pose;
mod rigged;
mod shaped;

pub use expressive::Expressiveness;
pub use file::{ModelFile, Needs};
pub use gender::Gender;
pub use hands::Side;
pub use kind::BodyKind;
pub(crate) use kind::{BODY, JointEntry};
pub use model::{BodyModel, Shape};
pub use pose::BodyPose;
pub use rigged::Apart;
pub use shaped::Shaped;

use uvgraft_io::arrays::ArraysError;

use crate::rig::RigError;

/// Why a body model, its parameters or a mesh for it were refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BodyError {
    /// An array that every model of the kind has is not there, or was not read.
    #[error("not a body model: {0}")]
    Arrays(#[from] ArraysError),
    /// The file is damaged, or of another format.
    #[error("{0}")]
    File(ArraysError),
    /// An array has another shape than the others ask for.
    #[error("`{key}` must have shape {wanted}, got {found:?}")]
    Shape {
        /// Its name.
        key: &'static str,
        /// The lengths of its axes.
        found: Vec<usize>,
        /// What they must be.
        wanted: String,
    },
    /// A value is NaN or infinite.
    #[error("`{key}` must be finite, got {found} at index {at}")]
    NotFinite {
        /// The array's name.
        key: &'static str,
        /// Which value, counted from 0 with the last axis running fastest.
        at: usize,
        /// What was found.
        found: f32,
    },
    /// Indices are floats, or larger than 64 bits hold.
    #[error("`{key}` must hold integers")]
    NotIntegers {
        /// The array's name.
        key: &'static str,
    },
    /// An index names what is not there.
    #[error(
        "`{key}` must hold indices of at least 0 and less than {below}, got {found} at index {at}"
    )]
    Index {
        /// The array's name.
        key: &'static str,
        /// Which value, counted from 0 with the last axis running fastest.
        at: usize,
        /// The index.
        found: i64,
        /// How many there are to be named.
        below: usize,
    },
    /// No kind of model has so many joints.
    #[error(
        "`kintree_table` must have 24 (SMPL), 52 (SMPL-H), 55 (SMPL-X) or 5 (FLAME) joints, got \
         {found}"
    )]
    Joints {
        /// How many.
        found: usize,
    },
    /// A joint hangs on another one than in models of the kind.
    #[error(
        "`kintree_table`: the parent of joint {joint} ({name}) of {kind} must be {wanted}, got \
         {found}"
    )]
    Parent {
        /// The joint's number.
        joint: usize,
        /// Its name.
        name: &'static str,
        /// The kind that has so many joints.
        kind: &'static str,
        /// The parent's number.
        found: i64,
        /// What it must be.
        wanted: usize,
    },
    /// More vertices or components than any model has.
    #[error("`{key}` must have at most {most} {what}, got {found}")]
    TooMany {
        /// The array's name.
        key: &'static str,
        /// Of what.
        what: &'static str,
        /// How many.
        found: usize,
        /// The most that is accepted.
        most: usize,
    },
    /// More coefficients than the model has components.
    #[error("this {kind} model takes at most {most} {what}, got {found}")]
    Coefficients {
        /// `"betas"`, `"expression coefficients"` or `"hand components"`.
        what: &'static str,
        /// How many were given.
        found: usize,
        /// How many components there are.
        most: usize,
        /// The model's kind.
        kind: &'static str,
    },
    /// A coefficient is NaN or infinite.
    #[error("{what} must be finite, got {found} at index {at}")]
    Coefficient {
        /// As in [`BodyError::Coefficients`].
        what: &'static str,
        /// Which, counted from 0.
        at: usize,
        /// What was found.
        found: f32,
    },
    /// A list has another length than the model asks for.
    #[error("must have {wanted} {what}, got {found}")]
    Count {
        /// Of what.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there must be.
        wanted: usize,
    },
    /// A mesh with as many vertices but other triangles than the model.
    #[error(
        "the mesh does not match this {kind} model: {only_mesh} of its {mesh} triangles are \
         missing in the model, and {only_model} of the model's {model} triangles are missing in \
         the mesh"
    )]
    Triangles {
        /// The model's kind.
        kind: &'static str,
        /// Triangles of the mesh that the model has not.
        only_mesh: usize,
        /// Triangles of the mesh.
        mesh: usize,
        /// Triangles of the model that the mesh has not.
        only_model: usize,
        /// Triangles of the model.
        model: usize,
    },
    /// The parts do not make a rig: weights that are negative, say.
    #[error("{0}")]
    Rig(#[from] RigError),
}
