//! Shapes by name: parameters such as gender, age and height, and the coefficients that they stand
//! for.
//!
//! A model file describes its parameters in the string `shape_parameters`, which is JSON:
//!
//! - `axes`: each has a `name` and either `knots`, ascending values of a parameter of that name,
//!   and its `default`; or a `mixture`, a list of parameters whose values, divided by their sum,
//!   are the weights.
//! - `grids`: each is a list of names of axes. The array `shape_grid_0` of the first grid has an
//!   axis for each of them, as long as there are knots or parts, and a last one for the components
//!   of `shapedirs`; it holds the coefficients of the grid's points. Between knots, coefficients
//!   are interpolated linearly along each axis. Those of all grids are added.
//! - `stature`, optional: the name of the axis whose parameter is given as the height of the body
//!   in metres instead.
//!
//! Coefficients are relative to the template, which has the defaults.

use serde::Deserialize;
use uvgraft_io::arrays::NamedArrays;

use super::{BodyError, BodyModel, Shape};

/// Name of the description in a model file.
pub(super) const PARAMETERS: &str = "shape_parameters";
/// Names of the grids in a model file.
pub(super) const GRIDS: [&str; 8] = [
    "shape_grid_0",
    "shape_grid_1",
    "shape_grid_2",
    "shape_grid_3",
    "shape_grid_4",
    "shape_grid_5",
    "shape_grid_6",
    "shape_grid_7",
];

/// Limit of the number of coefficients in a grid.
const MAX_COEFFICIENTS: usize = 1 << 22;

/// Parameters by name, and the shape coefficients that they stand for.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedShapes {
    axes: Vec<Axis>,
    grids: Vec<Grid>,
    stature: Option<usize>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
struct Axis {
    name: String,
    #[serde(default)]
    knots: Vec<f32>,
    #[serde(default)]
    default: f32,
    #[serde(default)]
    mixture: Vec<String>,
}

#[derive(Debug, Clone, PartialEq)]
struct Grid {
    axes: Vec<usize>,
    coefficients: Vec<f32>,
}

#[derive(Deserialize)]
struct Description {
    axes: Vec<Axis>,
    grids: Vec<Vec<String>>,
    stature: Option<String>,
}

/// Why named values are not a shape.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NamedShapeError {
    /// The model has no named shapes.
    #[error("this {kind} model has no named shapes; use betas instead")]
    None {
        /// The model's kind.
        kind: &'static str,
    },
    /// There is no such parameter.
    #[error("`{name}` must be one of {}", known.join(", "))]
    Unknown {
        /// The name.
        name: String,
        /// The names of all parameters.
        known: Vec<String>,
    },
    /// A parameter is given twice.
    #[error("`{name}` must be given once")]
    Twice {
        /// Its name.
        name: String,
    },
    /// A value is out of range.
    #[error("`{name}` must be from {from} to {to}, got {found}")]
    Range {
        /// Name of the parameter.
        name: String,
        /// The smallest value.
        from: f32,
        /// The largest value.
        to: f32,
        /// The value.
        found: f32,
    },
    /// No weight is left in a mixture.
    #[error("at least one of {} must be greater than 0", parts.join(", "))]
    Empty {
        /// Names of its parts.
        parts: Vec<String>,
    },
    /// No body of this height has the other values.
    #[error("`{name}` must be from {from:.2} to {to:.2} m with these values, got {found}")]
    Stature {
        /// Name of the parameter.
        name: String,
        /// Height of the smallest body, in metres.
        from: f32,
        /// Height of the tallest body, in metres.
        to: f32,
        /// The value.
        found: f32,
    },
}

impl NamedShapes {
    /// Reads the parameters of a model file, if it has any.
    ///
    /// - `betas`: number of shape components.
    pub(super) fn read(arrays: &NamedArrays, betas: usize) -> Result<Option<Self>, BodyError> {
        let Some(text) = arrays.text(PARAMETERS) else { return Ok(None) };
        let wrong = |problem: String| BodyError::NamedShapes { problem };
        let found: Description =
            serde_json::from_str(text).map_err(|error| wrong(error.to_string()))?;
        if let Some(axis) = found.axes.iter().find(|axis| !axis.is_sound()) {
            return Err(wrong(format!(
                "axis `{}` must have either a mixture, or ascending knots and a default within \
                 them",
                axis.name
            )));
        }
        let axis = |name: &String| {
            let at = found.axes.iter().position(|axis| axis.name == *name);
            at.ok_or_else(|| wrong(format!("must have an axis `{name}`")))
        };
        if found.grids.len() > GRIDS.len() {
            return Err(wrong(format!("must have at most {} grids", GRIDS.len())));
        }
        let mut grids = Vec::new();
        for (names, key) in found.grids.iter().zip(GRIDS) {
            let axes = names.iter().map(axis).collect::<Result<Vec<_>, _>>()?;
            let mut wanted: Vec<usize> = axes.iter().map(|&at| found.axes[at].count()).collect();
            wanted.push(betas);
            let array = arrays.require(key)?;
            let is_finite = array.f32s().iter().all(|value| value.is_finite());
            if array.shape() != wanted || array.f32s().len() > MAX_COEFFICIENTS || !is_finite {
                let found = array.shape();
                return Err(wrong(format!(
                    "`{key}` must be finite and have shape {wanted:?}, got {found:?}"
                )));
            }
            grids.push(Grid { axes, coefficients: array.f32s().into_owned() });
        }
        let stature = found.stature.as_ref().map(axis).transpose()?;
        if stature.is_some_and(|at| found.axes[at].knots.is_empty()) {
            return Err(wrong("the axis of the stature must have knots".to_owned()));
        }
        Ok(Some(Self { axes: found.axes, grids, stature }))
    }

    /// Names of the parameters.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.axes.iter().flat_map(|axis| axis.names().iter().map(String::as_str))
    }

    /// The coefficients of values by name. A value of the stature's parameter is one of its axis
    /// here; see [`BodyModel::named_shape`].
    fn betas(&self, values: &[(String, f32)]) -> Result<Vec<f32>, NamedShapeError> {
        for (at, (name, _)) in values.iter().enumerate() {
            if values[..at].iter().any(|(other, _)| other == name) {
                return Err(NamedShapeError::Twice { name: name.clone() });
            }
            if !self.names().any(|known| known == name) {
                let known = self.names().map(str::to_owned).collect();
                return Err(NamedShapeError::Unknown { name: name.clone(), known });
            }
        }
        let weights = |values: &[(String, f32)]| {
            self.axes.iter().map(|axis| axis.weights(values)).collect::<Result<Vec<_>, _>>()
        };
        let (chosen, defaults) = (weights(values)?, weights(&[])?);
        let mut betas = Vec::new();
        for grid in &self.grids {
            grid.add(&chosen, 1.0, &mut betas);
            grid.add(&defaults, -1.0, &mut betas);
        }
        Ok(betas.into_iter().map(|beta| beta as f32).collect())
    }
}

impl Axis {
    fn is_sound(&self) -> bool {
        let ascending = self.knots.windows(2).all(|pair| pair[0] < pair[1]);
        let range = self.knots.first().zip(self.knots.last());
        let has_knots = ascending
            && self.knots.len() > 1
            && self.knots.iter().all(|knot| knot.is_finite())
            && range.is_some_and(|(from, to)| (from..=to).contains(&&self.default));
        if self.mixture.is_empty() { has_knots } else { self.knots.is_empty() }
    }

    /// Number of points.
    const fn count(&self) -> usize {
        if self.mixture.is_empty() { self.knots.len() } else { self.mixture.len() }
    }

    /// The names of its parameters.
    fn names(&self) -> &[String] {
        if self.mixture.is_empty() { std::slice::from_ref(&self.name) } else { &self.mixture }
    }

    /// The weights of its points.
    fn weights(&self, values: &[(String, f32)]) -> Result<Vec<f64>, NamedShapeError> {
        let given = |name: &String| values.iter().find(|(other, _)| other == name);
        let range = |name: &String, [from, to]: [f32; 2], found: f32| {
            if (from..=to).contains(&found) {
                return Ok(f64::from(found));
            }
            Err(NamedShapeError::Range { name: name.clone(), from, to, found })
        };
        if self.mixture.is_empty() {
            let ends = [self.knots[0], self.knots[self.knots.len() - 1]];
            let value = given(&self.name).map_or(self.default, |&(_, value)| value);
            let value = range(&self.name, ends, value)?;
            return Ok(hats(&self.knots, value));
        }
        // Parts that are not mentioned have no share, unless none is mentioned.
        let is_given = self.mixture.iter().any(|name| given(name).is_some());
        let share = |name: &String| match given(name) {
            Some(&(_, value)) => range(name, [0.0, 1.0], value),
            None => Ok(if is_given { 0.0 } else { 1.0 }),
        };
        let shares = self.mixture.iter().map(share).collect::<Result<Vec<_>, _>>()?;
        let sum: f64 = shares.iter().sum();
        if sum <= 0.0 {
            return Err(NamedShapeError::Empty { parts: self.mixture.clone() });
        }
        Ok(shares.into_iter().map(|share| share / sum).collect())
    }
}

/// Weights of linear interpolation between knots.
fn hats(knots: &[f32], value: f64) -> Vec<f64> {
    let mut weights = vec![0.0; knots.len()];
    let upper = knots.partition_point(|&knot| f64::from(knot) < value).clamp(1, knots.len() - 1);
    let [from, to] = [knots[upper - 1], knots[upper]].map(f64::from);
    let share = (value - from) / (to - from);
    weights[upper - 1] = 1.0 - share;
    weights[upper] = share;
    weights
}

impl Grid {
    /// Adds the coefficients between the grid's points.
    ///
    /// - `weights`: of the points of every axis.
    fn add(&self, weights: &[Vec<f64>], factor: f64, betas: &mut Vec<f64>) {
        let points: usize = self.axes.iter().map(|&axis| weights[axis].len()).product();
        let width = self.coefficients.len() / points.max(1);
        betas.resize(width, 0.0);
        for (point, row) in self.coefficients.chunks_exact(width.max(1)).enumerate() {
            let (mut weight, mut rest) = (factor, point);
            for &axis in self.axes.iter().rev() {
                weight *= weights[axis][rest % weights[axis].len()];
                rest /= weights[axis].len();
            }
            if weight != 0.0 {
                betas.iter_mut().zip(row).for_each(|(sum, &beta)| *sum += weight * f64::from(beta));
            }
        }
    }
}

impl BodyModel {
    /// The parameters by which a shape can be given; models that were learnt from scans have none.
    pub const fn named_shapes(&self) -> Option<&NamedShapes> {
        self.named_shapes.as_ref()
    }

    /// The shape of values by name, such as `gender` = 0.2. Missing ones have their defaults.
    ///
    /// The value of the parameter for the body's height, if there is one, is in metres, from the
    /// lowest to the highest vertex at rest.
    ///
    /// # Errors
    /// [`NamedShapeError`] for unknown names, values out of range and heights that no body has.
    pub fn named_shape(&self, values: &[(String, f32)]) -> Result<Shape, NamedShapeError> {
        let kind = self.kind.name();
        let Some(shapes) = &self.named_shapes else { return Err(NamedShapeError::None { kind }) };
        let shape = |betas| Shape { betas, ..Shape::default() };
        let axis = shapes.stature.map(|axis| &shapes.axes[axis]);
        let at = axis.and_then(|axis| values.iter().position(|(name, _)| *name == axis.name));
        let (Some(axis), Some(at)) = (axis, at) else { return shapes.betas(values).map(shape) };
        // Checks the other values before the search for this one.
        let mut values = values.to_vec();
        let wanted = std::mem::replace(&mut values[at].1, axis.default);
        shapes.betas(&values)?;
        let mut stature = |value: f32| {
            values[at].1 = value;
            let betas = shapes.betas(&values)?;
            Ok((self.stature(&betas), betas))
        };
        let [mut low, mut high] = [axis.knots[0], axis.knots[axis.knots.len() - 1]];
        let [from, to] = [stature(low)?.0, stature(high)?.0];
        // A hair's breadth for limits that are written in centimetres.
        const NEAR_M: f32 = 0.006;
        if !(from - NEAR_M..=to + NEAR_M).contains(&wanted) {
            let name = axis.name.clone();
            return Err(NamedShapeError::Stature { name, from, to, found: wanted });
        }
        for _ in 0..24 {
            let middle = f32::midpoint(low, high);
            let is_taller = stature(middle)?.0 > wanted;
            *(if is_taller { &mut high } else { &mut low }) = middle;
        }
        stature(f32::midpoint(low, high)).map(|(_, betas)| shape(betas))
    }

    /// Height from the lowest to the highest vertex at rest, in metres.
    fn stature(&self, betas: &[f32]) -> f32 {
        let coefficients: Vec<(usize, f32)> = (0..).zip(betas.iter().copied()).collect();
        let mut positions = self.template.clone();
        self.directions.add(&coefficients, positions.as_flattened_mut());
        let heights = || positions.iter().map(|place| place[1]);
        heights().fold(f32::MIN, f32::max) - heights().fold(f32::MAX, f32::min)
    }
}

#[cfg(test)]
mod tests {
    use uvgraft_io::arrays::NumericArray;

    use super::*;

    /// Two grids: gender × age, and three kinds of height.
    fn arrays() -> NamedArrays {
        let mut arrays = NamedArrays::new();
        arrays.insert_text(
            PARAMETERS,
            r#"{"axes": [{"name": "gender", "knots": [0, 1], "default": 0.5},
                {"name": "age", "knots": [0, 0.25, 1], "default": 0.25},
                {"name": "origin", "mixture": ["north", "south"]}],
                "grids": [["gender", "age"], ["origin"]]}"#,
        );
        let mut put = |name, shape, values: &[f32]| {
            arrays.insert(name, NumericArray::new_f32(shape, values.to_vec()).unwrap());
        };
        let values = [0.0, 0.0, 1.0, 0.0, 2.0, 0.0, 10.0, 0.0, 20.0, 0.0, 40.0, 0.0];
        put(GRIDS[0], vec![2, 3, 2], &values);
        put(GRIDS[1], vec![2, 2], &[0.0, 3.0, 0.0, 5.0]);
        arrays
    }

    fn betas(values: &[(&str, f32)]) -> Result<Vec<f32>, String> {
        let shapes = NamedShapes::read(&arrays(), 2).unwrap().unwrap();
        let values: Vec<_> = values.iter().map(|&(name, v)| (name.to_owned(), v)).collect();
        shapes.betas(&values).map_err(|error| error.to_string())
    }

    #[test]
    fn values_between_knots_are_interpolated_along_each_axis() {
        assert_eq!(betas(&[]).unwrap(), [0.0, 0.0]);
        // At the defaults: (1 + 20) / 2.
        assert_eq!(betas(&[("gender", 1.0)]).unwrap(), [20.0 - 10.5, 0.0]);
        assert_eq!(betas(&[("gender", 0.0), ("age", 0.125)]).unwrap(), [0.5 - 10.5, 0.0]);
        let corner = (2.0 + 3.0 * 40.0) / 4.0;
        assert_eq!(betas(&[("age", 1.0), ("gender", 0.75)]).unwrap(), [corner - 10.5, 0.0]);
        assert_eq!(betas(&[("north", 0.2)]).unwrap(), [0.0, -1.0]);
        let found = betas(&[("north", 0.1), ("south", 0.3)]).unwrap();
        assert!((found[1] - 0.5).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn other_values_are_refused() {
        for (values, wanted) in [
            (&[("sex", 0.0)][..], "`sex` must be one of gender, age, north, south"),
            (&[("age", 0.1), ("age", 0.1)], "`age` must be given once"),
            (&[("age", 1.5)], "`age` must be from 0 to 1, got 1.5"),
            (&[("south", f32::NAN)], "`south` must be from 0 to 1, got NaN"),
            (&[("south", 0.0)], "at least one of north, south must be greater than 0"),
        ] {
            assert_eq!(betas(values).unwrap_err(), wanted);
        }
    }

    #[test]
    fn malformed_descriptions_are_refused() {
        let description = arrays().text(PARAMETERS).unwrap().to_owned();
        for (from, to, wanted) in [
            ("\"axes\"", "\"axis\"", "missing field `axes`"),
            ("[0, 0.25, 1]", "[0, 2, 1]", "axis `age` must have either a mixture, or ascending"),
            ("\"default\": 0.25", "\"default\": 2", "axis `age` must have"),
            ("[[\"gender\"", "[[\"sex\"", "must have an axis `sex`"),
            ("[0, 1]", "[0, 0.5, 1]", "`shape_grid_0` must be finite and have shape [3, 3, 2]"),
        ] {
            let mut arrays = arrays();
            arrays.insert_text(PARAMETERS, description.replace(from, to));
            let error = NamedShapes::read(&arrays, 2).unwrap_err().to_string();
            assert!(error.contains(wanted), "{error}");
        }
        assert_eq!(NamedShapes::read(&NamedArrays::new(), 2), Ok(None));
    }
}
