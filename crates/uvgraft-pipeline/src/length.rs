//! Lengths with units, and the unit of a mesh.

use uvgraft::{Choice, choices};

/// Longer than any mesh in any unit, and within the range of single precision.
const LONGEST: f64 = 1e9;

/// A unit of length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum Unit {
    /// Millimetres
    Mm,
    /// Centimetres
    Cm,
    /// Metres
    #[default]
    M,
    /// Inches
    In,
}

choices!(Unit {
    Mm => "mm", "Millimetres";
    Cm => "cm", "Centimetres";
    M => "m", "Metres";
    In => "in", "Inches";
});

impl Unit {
    fn meters(self) -> f64 {
        match self {
            Self::Mm => 0.001,
            Self::Cm => 0.01,
            Self::M => 1.0,
            Self::In => 0.0254,
        }
    }
}

/// A length with a unit, or in the unit of the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Length {
    value: f64,
    unit: Option<Unit>,
}

impl Length {
    /// A length in millimetres.
    pub const fn millimeters(value: f64) -> Self {
        Self { value, unit: Some(Unit::Mm) }
    }

    /// Parses a number with a unit such as `15mm`, or without one for the unit of the mesh.
    ///
    /// # Errors
    /// The requirements that the text does not meet.
    pub fn parse(text: &str) -> Result<Self, String> {
        let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
        let unit = match &text[digits.len()..] {
            "" => None,
            name => Some(Unit::named(name).ok_or_else(wanted)?),
        };
        match digits.trim_end().parse::<f64>() {
            Ok(value) if value.abs() <= LONGEST => Ok(Self { value, unit }),
            Ok(value) if value.is_finite() => Err(format!("{}, at most {LONGEST:e}", wanted())),
            _ => Err(wanted()),
        }
    }

    /// As [`Length::parse`], but at least 0.
    ///
    /// # Errors
    /// The requirements that the text does not meet.
    pub fn parse_distance(text: &str) -> Result<Self, String> {
        Self::parse(text).and_then(|length| {
            if length.value >= 0.0 { Ok(length) } else { Err(format!("{}, at least 0", wanted())) }
        })
    }

    /// Whether the unit of the mesh must be known to convert it.
    pub fn has_unit(self) -> bool {
        self.unit.is_some() && self.value != 0.0
    }

    /// The length in the unit of the mesh.
    pub fn in_unit(self, mesh: Unit) -> f64 {
        match self.unit {
            Some(unit) => self.value * unit.meters() / mesh.meters(),
            None => self.value,
        }
    }
}

fn wanted() -> String {
    "must be a length such as 15mm, 1.5cm, 0.015m or 0.6in, or a number in the unit of the mesh"
        .into()
}

/// The note that a unit was assumed for a mesh.
///
/// - `extent`: of the mesh, in the assumed unit.
pub(crate) fn assumption(extent: f64, unit: Unit) -> String {
    let longest = extent * unit.meters();
    let size = if longest >= 1.0 {
        format!("{longest:.2} m")
    } else {
        format!("{:.1} cm", longest * 100.0)
    };
    format!(
        "the mesh has no unit; assuming {}, which makes its largest dimension {size}; use `unit` \
         to change this",
        unit.summary().to_lowercase()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths() {
        let length = |text| Length::parse(text).map(|length| length.in_unit(Unit::M));
        for (text, wanted) in
            [("15mm", 0.015), ("-1.5 cm", -0.015), ("0.5m", 0.5), ("2in", 0.0508), ("7", 7.0)]
        {
            assert!((length(text).unwrap() - wanted).abs() < 1e-12, "{text}");
        }
        assert!((Length::parse("15mm").unwrap().in_unit(Unit::Cm) - 1.5).abs() < 1e-12);
        for bad in ["", "mm", "15 foot", "1e400", "1e10", "-1e308m", "nan", "inf", "15mmm", "ä"] {
            assert!(length(bad).is_err(), "{bad}");
        }
        assert!(Length::parse_distance("-1mm").is_err());
    }
}
