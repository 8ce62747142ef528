//! Shape coefficients of body models.

use std::fmt::{self, Display};
use std::path::Path;

use uvgraft_files::input::Input;
use uvgraft_io::arrays;
use uvgraft_pipeline::{Blame, Failure, Result};

/// Shape coefficients, or a file (.npz, .pkl) with an array `betas`.
#[derive(Debug, Clone, PartialEq)]
pub enum Betas {
    /// The coefficients, in standard deviations.
    Numbers(Vec<f32>),
    /// The file.
    File(Input),
}

impl Betas {
    /// Parses numbers separated by commas or spaces, or else the path of a file.
    ///
    /// # Errors
    /// As bad input if it is neither.
    pub fn parse(text: &str) -> Result<Self> {
        let numbers: std::result::Result<Vec<f32>, _> =
            text.split([',', ' ']).filter(|part| !part.is_empty()).map(str::parse).collect();
        match numbers {
            Ok(numbers) => checked(numbers, text).map(Self::Numbers),
            Err(_) if Path::new(text).exists() => Ok(Self::File(text.into())),
            Err(_) => Err(refused(text, "no such file")),
        }
    }

    /// The coefficients.
    pub(super) fn values(&self) -> Result<Vec<f32>> {
        let values = match self {
            Self::Numbers(numbers) => numbers.clone(),
            Self::File(file) => {
                let found = arrays::read(file).or_input()?;
                let array = found.require("betas").map_err(|error| refused(file, error))?;
                // Betas of one person, possibly as a matrix of one row.
                if !matches!(array.shape(), [_] | [1, _]) {
                    let shape = array.shape();
                    return Err(refused(file, format_args!("an array of shape {shape:?}")));
                }
                array.f32s().into_owned()
            }
        };
        checked(values, self)
    }

    pub(super) fn input(&self) -> Option<&Input> {
        match self {
            Self::Numbers(_) => None,
            Self::File(file) => Some(file),
        }
    }
}

/// As they can be given.
impl Display for Betas {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(file) => file.fmt(f),
            Self::Numbers(numbers) => {
                let numbers: Vec<String> = numbers.iter().map(f32::to_string).collect();
                f.write_str(&numbers.join(","))
            }
        }
    }
}

fn checked(values: Vec<f32>, given: impl Display) -> Result<Vec<f32>> {
    match values.iter().find(|value| !value.is_finite()) {
        Some(value) => Err(refused(given, value)),
        None if values.is_empty() => Err(refused(given, "none")),
        None => Ok(values),
    }
}

fn refused(given: impl Display, found: impl Display) -> Failure {
    Failure::option(format!(
        "`betas` {given}: must be numbers such as 0.5,-1.2, or a file that holds them; got "
    ))
    .found(found)
}

/// The people that body models are learnt from are within this many standard deviations.
const MAX_BETA: f32 = 5.0;

/// A warning about coefficients far beyond those of the training data.
pub(super) fn far_from_people(betas: &[f32]) -> Option<String> {
    let (at, beta) = betas.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    (beta.abs() > MAX_BETA).then(|| {
        format!(
            "coefficient {} of {} is {beta}; bodies are distorted beyond ±{MAX_BETA} standard \
             deviations",
            at + 1,
            betas.len()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn betas_are_numbers_or_a_file() {
        assert_eq!(Betas::parse("0.5,-1.2").unwrap(), Betas::Numbers(vec![0.5, -1.2]));
        assert_eq!(Betas::parse("0.5, -1.2").unwrap().to_string(), "0.5,-1.2");
        for (bad, found) in [("", "none"), ("nan", "NaN"), ("no/such.npz", "no such file")] {
            let refused = Betas::parse(bad).unwrap_err().to_string();
            assert!(refused.ends_with(&format!("got {found}")), "{refused}");
        }
    }
}
