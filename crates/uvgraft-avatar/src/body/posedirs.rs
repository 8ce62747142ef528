//! The array of a model's pose correctives, in the arrangements that files have.
//!
//! Published files have `[V, 3, P]`; `smplx` holds `[P, 3 V]` in memory, from where converters save
//! it. STAR's correctives are functions of quaternions and of one shape coefficient instead of
//! rotation matrices; they and any others are left out.
//!
//! # Source
//! Osman et al., "STAR: Sparse Trained Articulated Human Body Regressor", 2020, section 3.

use std::borrow::Cow;
use std::ops::Range;

use uvgraft_io::arrays::ArraySelection;

use super::correctives::Correctives;
use super::fields::{Axis, Fields};
use super::{BodyError, BodyKind};

pub(super) const KEY: &str = "posedirs";
/// Features of STAR: a quaternion for each of SMPL's joints but the root, and a shape coefficient.
const STAR_FEATURES: usize = 4 * 23 + 1;

/// The correctives of a model, and why they were left out, if they were.
pub(super) type Found = (Correctives, Option<String>);

/// The order of an array's axes.
enum Arrangement {
    /// `[V, 3, P]` or `[3 V, P]`.
    FeaturesLast,
    /// `[P, V, 3]` or `[P, 3 V]`.
    FeaturesFirst,
}

impl Arrangement {
    fn of(shape: &[usize], vertices: usize, features: usize) -> Option<Self> {
        match *shape {
            [a, 3, c] if (a, c) == (vertices, features) => Some(Self::FeaturesLast),
            [a, b] if (a, b) == (3 * vertices, features) => Some(Self::FeaturesLast),
            [a, b, 3] if (a, b) == (features, vertices) => Some(Self::FeaturesFirst),
            [a, b] if (a, b) == (features, 3 * vertices) => Some(Self::FeaturesFirst),
            _ => None,
        }
    }
}

/// What to read of the array of this shape for some of the features.
pub(super) fn selection(
    shape: &[usize],
    kind: BodyKind,
    vertices: usize,
    wanted: &Range<usize>,
) -> ArraySelection {
    match *shape {
        [a, 3, c] if (a, c) == (vertices, kind.features()) => {
            ArraySelection::Columns(vec![wanted.clone()])
        }
        _ => ArraySelection::All,
    }
}

/// Reads the pose correctives, if the file has any that are understood.
///
/// - `wanted`: the features to keep. The array has all of them, or is `[V, 3, wanted]`.
///
/// # Errors
/// [`BodyError`] for arrays that cannot be read, and for values that are not finite.
pub(super) fn read(
    fields: &Fields<'_>,
    kind: BodyKind,
    vertices: usize,
    wanted: Range<usize>,
) -> Result<Found, BodyError> {
    let features = kind.features();
    let none = || Correctives::none(vertices, features);
    if !fields.has(KEY) {
        return Ok((none(), None));
    }
    let shape = fields.0.require(KEY)?.shape();
    let part = [vertices, 3, wanted.len()];
    if *shape == part {
        let values = fields.floats(KEY, &part.map(Axis::Is))?.0;
        return Ok((Correctives::new(&values, wanted, features), None));
    }
    let Some(arrangement) = Arrangement::of(shape, vertices, features) else {
        return Ok((none(), Some(left_out(shape, kind, vertices))));
    };
    let axes: Vec<Axis> = shape.iter().copied().map(Axis::Is).collect();
    let values = fields.floats(KEY, &axes)?.0;
    let offsets = columns(&values, &arrangement, features, wanted.clone());
    Ok((Correctives::new(&offsets, wanted, features), None))
}

/// Some of the features as `[V][3][wanted]`.
fn columns<'a>(
    values: &'a [f32],
    arrangement: &Arrangement,
    features: usize,
    wanted: Range<usize>,
) -> Cow<'a, [f32]> {
    let coordinates = values.len() / features;
    match arrangement {
        Arrangement::FeaturesLast if wanted.len() == features => Cow::Borrowed(values),
        Arrangement::FeaturesLast => {
            values.chunks_exact(features).flat_map(|row| &row[wanted.clone()]).copied().collect()
        }
        Arrangement::FeaturesFirst => (0..coordinates)
            .flat_map(|at| wanted.clone().map(move |feature| values[feature * coordinates + at]))
            .collect(),
    }
}

fn left_out(shape: &[usize], kind: BodyKind, vertices: usize) -> String {
    let features = kind.features();
    let of_star = matches!(*shape, [.., STAR_FEATURES]) && kind == BodyKind::Smpl;
    let why = if of_star { ", as in STAR, whose correctives are not supported" } else { "" };
    format!("`{KEY}` must have shape [{vertices}, 3, {features}], got {shape:?}{why}")
}
