//! FLAME's parameters in one convention.

use std::sync::Arc;

use super::error::TrackingError;
use super::rotation::{axis_angle, from_six};
use crate::arrays::NumericArray;

/// Maximum number of coefficients of shape or expression. FLAME has 300 and 100.
pub(super) const MAX_COEFFICIENTS: usize = 1000;

/// Maximum number of vertices with an offset. FLAME has 5,023.
const MAX_VERTICES: usize = 1 << 18;

/// FLAME's parameters of a frame. The tracked head in the world is
/// `scale * (FLAME(shape, expression, rotation, neck, jaw, eyes) + translation)`, in which FLAME is
/// in metres, turns about its own joints, and has `static_offset` added to its shaped vertices
/// before they are posed.
///
/// Rotations are axis-angle vectors, in radians. Values that a tracker does not estimate are 0, as
/// they were when it fitted the others; those that a folder does not store are `None` or empty.
#[derive(Debug, Clone, PartialEq)]
pub struct FlameParameters {
    /// Shape coefficients in the order of FLAME's components, as many as the tracker uses (100 to
    /// 300). Shared by frames that have the same. Empty for INSTA, which stores the shaped mesh
    /// instead ([`Tracking::canonical_mesh`](super::Tracking::canonical_mesh)).
    pub shape: Arc<[f32]>,
    /// Expression coefficients, as many as the tracker uses (50 to 100).
    pub expression: Vec<f32>,
    /// Global rotation, about FLAME's root joint.
    pub rotation: [f32; 3],
    /// Translation, before [`FlameParameters::scale`], in metres.
    pub translation: [f32; 3],
    /// Rotation of the neck joint.
    pub neck: [f32; 3],
    /// Rotation of the jaw joint; `None` if it was tracked but is not stored (INSTA).
    pub jaw: Option<[f32; 3]>,
    /// Rotations of the left and the right eyeball of the person; `None` if they were tracked but
    /// are not stored (INSTA).
    pub eyes: Option<[[f32; 3]; 2]>,
    /// Weights of the left and the right blend shape that closes an eyelid, which metrical-tracker
    /// adds to FLAME.
    pub eyelids: Option<[f32; 2]>,
    /// Size of the world relative to metres: 4 for IMavatar, otherwise 1.
    pub scale: f32,
    /// Offsets of vertices in metres that VHAP adds to FLAME. More than FLAME's 5,023 are those of
    /// the teeth that VHAP appends.
    pub static_offset: Option<Arc<[[f32; 3]]>>,
}

impl FlameParameters {
    /// A head of the shape in its rest pose.
    pub(super) fn at_rest(shape: Arc<[f32]>) -> Self {
        Self {
            shape,
            expression: Vec::new(),
            rotation: [0.0; 3],
            translation: [0.0; 3],
            neck: [0.0; 3],
            jaw: Some([0.0; 3]),
            eyes: Some([[0.0; 3]; 2]),
            eyelids: None,
            scale: 1.0,
            static_offset: None,
        }
    }
}

/// Values that are finite, and not more than a head has.
pub(super) fn coefficients(name: &'static str, values: &[f32]) -> Result<(), TrackingError> {
    if values.len() > MAX_COEFFICIENTS {
        let wanted = format!("at most {MAX_COEFFICIENTS} numbers");
        return Err(TrackingError::value(name, wanted, values.len()));
    }
    finite(name, values)
}

fn finite(name: &'static str, values: &[f32]) -> Result<(), TrackingError> {
    match values.iter().find(|value| !value.is_finite()) {
        Some(value) => Err(TrackingError::value(name, "finite", value)),
        None => Ok(()),
    }
}

/// Exactly `N` finite values.
pub(super) fn fixed<const N: usize>(
    name: &'static str,
    values: &[f32],
) -> Result<[f32; N], TrackingError> {
    let fixed = values
        .try_into()
        .map_err(|_| TrackingError::value(name, format!("{N} numbers"), values.len()))?;
    finite(name, values)?;
    Ok(fixed)
}

/// The coefficients in an array of shape `[n]` or `[1, n]`.
pub(super) fn row(name: &'static str, array: &NumericArray) -> Result<Vec<f32>, TrackingError> {
    match array.shape() {
        [_] | [1, _] if array.shape().iter().all(|&length| length <= MAX_COEFFICIENTS) => {}
        shape => {
            let wanted = format!("of shape [n] or [1, n], with n up to {MAX_COEFFICIENTS}");
            return Err(TrackingError::value(name, wanted, format_args!("{shape:?}")));
        }
    }
    let values = array.f32s().into_owned();
    finite(name, &values)?;
    Ok(values)
}

/// The offsets in an array of shape `[n, 3]` or `[1, n, 3]`.
pub(super) fn offsets(
    name: &'static str,
    array: &NumericArray,
) -> Result<Vec<[f32; 3]>, TrackingError> {
    match *array.shape() {
        [count, 3] | [1, count, 3] if count <= MAX_VERTICES => {}
        ref shape => {
            let wanted = format!("of shape [1, n, 3], with n up to {MAX_VERTICES}");
            return Err(TrackingError::value(name, wanted, format_args!("{shape:?}")));
        }
    }
    let values = array.f32s();
    finite(name, &values)?;
    Ok(values.as_chunks::<3>().0.to_vec())
}

/// The axis-angle form of rotations stored as six numbers each.
pub(super) fn from_six_numbers<const N: usize>(
    name: &'static str,
    values: &[f32],
) -> Result<[[f32; 3]; N], TrackingError> {
    let (sixes, rest) = values.as_chunks::<6>();
    let sixes: [[f32; 6]; N] =
        sixes.try_into().ok().filter(|_| rest.is_empty()).ok_or_else(|| {
            TrackingError::value(name, format!("{} numbers", 6 * N), values.len())
        })?;
    let mut turns = [[0.0; 3]; N];
    for (turn, six) in turns.iter_mut().zip(sixes) {
        let matrix = from_six(six.map(f64::from)).ok_or_else(|| {
            let wanted = "two independent directions for each rotation";
            TrackingError::value(name, wanted, format_args!("{six:?}"))
        })?;
        *turn = axis_angle(&matrix).map(|value| value as f32);
    }
    Ok(turns)
}

/// Keeps one copy of equal values in a row, as most frames share their shape.
#[derive(Debug, Default)]
pub(super) struct Shared<T>(Option<Arc<[T]>>);

impl<T: PartialEq> Shared<T> {
    pub(super) fn get(&mut self, values: Vec<T>) -> Arc<[T]> {
        match &self.0 {
            Some(last) if **last == *values => Arc::clone(last),
            _ => {
                let values: Arc<[T]> = values.into();
                self.0 = Some(Arc::clone(&values));
                values
            }
        }
    }
}
