//! Regions of a pair's surface.
//!
//! The class `Region` of the package is a recipe in plain Python values, so that it belongs to no
//! pair and can be pickled; here it is followed on the surface of one.

use pyo3::prelude::*;
use pyo3::types::PyTuple;
use uvgraft::blend::Growth;
use uvgraft::{BlendDomain, Encoding, Selection};
use uvgraft_pipeline::{grown, spelled};

use crate::arguments::chosen;
use crate::arrays::{numbers, texture};
use crate::error::{bad_value, failed, warn_caller};

/// Regions in each other; deeper recipes are refused.
const MAX_DEPTH: usize = 100;

/// The selection that a `uvgraft.Region` describes.
///
/// # Errors
/// `ValueError` if shrinking leaves nothing, or growing covers everything; next to nothing is warned of.
pub(crate) fn selection(domain: &BlendDomain, region: &Bound<'_, PyAny>) -> PyResult<Selection> {
    let recipe = region.getattr("_recipe").map_err(|_| {
        crate::error::bad_type(format_args!("region must be a uvgraft.Region, got {region}"))
    })?;
    follow(domain, &recipe.cast_into::<PyTuple>()?, 0)
}

fn follow(domain: &BlendDomain, recipe: &Bound<'_, PyTuple>, depth: usize) -> PyResult<Selection> {
    if depth > MAX_DEPTH {
        return Err(bad_value("region is made of too many others in each other"));
    }
    let inner = |index: usize| -> PyResult<Selection> {
        follow(domain, &recipe.get_item(index)?.cast_into::<PyTuple>()?, depth + 1)
    };
    let kind: String = recipe.get_item(0)?.extract()?;
    match kind.as_str() {
        "linked" => Ok(domain.linked()),
        "vertices" => {
            let side = chosen("side", &recipe.get_item(1)?.extract::<String>()?)?;
            let (_, ids) = numbers::<i64>(&recipe.get_item(2)?, "vertices", "int64")?;
            let id = |id: i64| {
                u32::try_from(id)
                    .map_err(|_| bad_value(format_args!("vertices: {id} is not a vertex index")))
            };
            let ids = ids.into_iter().map(id).collect::<PyResult<Vec<u32>>>()?;
            domain.vertices(side, &ids).map_err(bad_value)
        }
        "mask" => {
            let side = chosen("side", &recipe.get_item(1)?.extract::<String>()?)?;
            let mask = texture(&recipe.get_item(2)?, "mask", Encoding::Data)?;
            domain.painted(side, &mask.texture).map_err(failed)
        }
        "union" => inner(1)?.union(&inner(2)?).map_err(failed),
        "difference" => inner(1)?.difference(&inner(2)?).map_err(failed),
        "intersection" => inner(1)?.intersection(&inner(2)?).map_err(failed),
        "length" => {
            let by: f64 = recipe.get_item(2)?.extract()?;
            if !by.is_finite() {
                return Err(bad_value(format_args!(
                    "Region.grown(): length must be finite, got {by}"
                )));
            }
            resized(recipe.py(), &inner(1)?, Growth::Length(by))
        }
        "rings" => resized(recipe.py(), &inner(1)?, Growth::Rings(recipe.get_item(2)?.extract()?)),
        other => Err(bad_value(format_args!("unknown kind of region {other:?}"))),
    }
}

fn resized(py: Python<'_>, selection: &Selection, by: Growth) -> PyResult<Selection> {
    let in_python = |name: &str| (name == "grow").then(|| "Region.grown()".to_owned());
    let grown =
        grown(selection, by, None).map_err(|failure| bad_value(failure.spelled(in_python)))?;
    let warning = grown.warning.map(|warning| spelled(&warning, in_python));
    warn_caller(py, warning.into_iter().collect())?;
    Ok(grown.selection)
}
