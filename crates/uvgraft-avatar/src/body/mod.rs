//! Body models of the SMPL family: shape, expression and pose, by linear blend skinning
//! with pose correctives.
//!
//! A [`BodyModel`] is built from arrays that the user supplies; [`BodyModel::shaped`]
//! is one person, and [`Shaped::posed`] that person in a pose. [`Shaped::avatar`] turns
//! it into a rig that any viewer plays.
//!
//! # Source
//! Loper et al., "SMPL: A Skinned Multi-Person Linear Model", 2015; Romero et al., "Embodied
//! Hands", 2017 (SMPL-H); Li et al., "Learning a model of facial shape and expression from 4D
//! scans", 2017 (FLAME); Pavlakos et al., "Expressive Body Capture", 2019 (SMPL-X). Files are
//! interpreted as in the Python package `smplx`, and results agree with it.

mod correctives;
mod expressive;
mod fields;
mod file;
mod gender;
mod hands;
mod kind;
mod model;
mod named_expressions;
mod named_shapes;
mod pose;
mod posedirs;
mod rigged;
mod shaped;

pub use expressive::ExpressionReport;
pub use file::{ModelFile, ReadOptions};
pub use gender::Gender;
pub use hands::Hand;
pub use kind::BodyKind;
pub(crate) use kind::{BODY, JointEntry};
pub use model::{BodyModel, Shape};
pub use named_shapes::{NamedShapeError, NamedShapes};
pub use pose::BodyPose;
pub use rigged::Deviation;
pub use shaped::Shaped;

use uvgraft_io::arrays::ArraysError;

use crate::rig::RigError;

/// Why a body model, its parameters or a mesh for it were refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BodyError {
    /// An array that every model of the kind has is missing, or was not read.
    #[error("not a body model: {0}")]
    Arrays(#[from] ArraysError),
    /// The file is damaged, or in another format.
    #[error("{0}")]
    File(ArraysError),
    /// The shape of an array does not agree with the others.
    #[error("`{key}` must have shape {wanted}, got {found:?}")]
    Shape {
        /// Its name.
        key: &'static str,
        /// The lengths of its axes.
        found: Vec<usize>,
        /// The required shape.
        wanted: String,
    },
    /// A value is NaN or infinite.
    #[error("`{key}` must be finite, got {found} at index {at}")]
    NotFinite {
        /// The array's name.
        key: &'static str,
        /// Flat index of the value, with the last axis running fastest.
        at: usize,
        /// The value.
        found: f32,
    },
    /// Indices are floats, or don't fit in 64 bits.
    #[error("`{key}` must hold integers")]
    NotIntegers {
        /// The array's name.
        key: &'static str,
    },
    /// An index is out of range.
    #[error(
        "`{key}` must hold indices of at least 0 and less than {below}, got {found} at index {at}"
    )]
    Index {
        /// The array's name.
        key: &'static str,
        /// Flat index of the value, with the last axis running fastest.
        at: usize,
        /// The value.
        found: i64,
        /// Indices must be less than this.
        below: usize,
    },
    /// No kind of model has this number of joints.
    #[error(
        "`kintree_table` must have 24 (SMPL), 52 (SMPL-H), 55 (SMPL-X) or 5 (FLAME) joints, got \
         {found}"
    )]
    Joints {
        /// Number of joints.
        found: usize,
    },
    /// A joint's parent differs from that in models of the kind.
    #[error(
        "`kintree_table`: the parent of joint {joint} ({name}) of {kind} must be {wanted}, got \
         {found}"
    )]
    Parent {
        /// The joint's index.
        joint: usize,
        /// Its name.
        name: &'static str,
        /// The kind with this number of joints.
        kind: &'static str,
        /// The parent's index.
        found: i64,
        /// The index that it must be.
        wanted: usize,
    },
    /// More vertices or components than any model has.
    #[error("`{key}` must have at most {most} {what}, got {found}")]
    TooMany {
        /// The array's name.
        key: &'static str,
        /// `"vertices"`, for example.
        what: &'static str,
        /// Their number.
        found: usize,
        /// Upper limit.
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
        /// Index of the coefficient.
        at: usize,
        /// The value.
        found: f32,
    },
    /// The length of a list does not match the model.
    #[error("must have {wanted} {what}, got {found}")]
    Count {
        /// What the list holds.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The required length.
        wanted: usize,
    },
    /// The mesh has as many vertices as the model but other triangles.
    #[error(
        "the mesh does not match this {kind} model: {only_mesh} of its {mesh} triangles are \
         missing in the model, and {only_model} of the model's {model} triangles are missing in \
         the mesh"
    )]
    Triangles {
        /// The model's kind.
        kind: &'static str,
        /// Triangles of the mesh that are missing in the model.
        only_mesh: usize,
        /// Triangles of the mesh.
        mesh: usize,
        /// Triangles of the model that are missing in the mesh.
        only_model: usize,
        /// Triangles of the model.
        model: usize,
    },
    /// The description of named shapes, or a grid of theirs, is malformed.
    #[error("`shape_parameters`: {problem}")]
    NamedShapes {
        /// What is wrong.
        problem: String,
    },
    /// The parts do not form a valid rig: weights are negative, say.
    #[error("{0}")]
    Rig(#[from] RigError),
}
