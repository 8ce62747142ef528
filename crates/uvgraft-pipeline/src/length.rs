//! Lengths with units, and the unit of a mesh.

use std::fmt::{self, Display};

use uvgraft::{Choice, choices};

use crate::failure::Failure;
use crate::observer::Observer;

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

/// A length with a unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Length {
    value: f64,
    unit: Unit,
}

impl Length {
    /// A length in millimetres.
    pub const fn millimeters(value: f64) -> Self {
        Self { value, unit: Unit::Mm }
    }

    /// Parses a number with a unit, such as `15mm`. Only 0 needs none: a bare 10 would be metres to
    /// the mesh and millimetres to whoever wrote it.
    ///
    /// # Errors
    /// The requirements that the text does not meet.
    pub fn parse(text: &str) -> Result<Self, String> {
        let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
        let (number, name) = (digits.trim_end(), &text[digits.len()..]);
        let value =
            number.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(wanted)?;
        let unit = match (Unit::named(name), name) {
            (Some(unit), _) => unit,
            (None, "") if value == 0.0 => Unit::default(),
            (None, "") => {
                return Err(format!(
                    "must have a unit, without a space before it, such as {number}mm, {number}cm, \
                     {number}m or {number}in"
                ));
            }
            (None, name) => {
                return Err(format!(
                    "must have the unit mm, cm, m or in, such as 15mm, got `{name}`"
                ));
            }
        };
        if value.abs() <= LONGEST {
            Ok(Self { value, unit })
        } else {
            Err(format!("{}, at most {LONGEST:e}", wanted()))
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

    /// Whether it is 0, in any unit.
    pub fn is_zero(self) -> bool {
        self.value == 0.0
    }

    /// The length in the unit of the mesh.
    pub fn in_unit(self, mesh: Unit) -> f64 {
        self.value * self.unit.meters() / mesh.meters()
    }

    /// Checks that it is no longer than a mesh.
    ///
    /// - `option`: what the length is for.
    /// - `extent`: the mesh's largest dimension, in its unit.
    ///
    /// # Errors
    /// As bad input, with the dimension.
    pub fn check_within(self, option: &str, extent: f64, mesh: Unit) -> Result<(), Failure> {
        if self.in_unit(mesh).abs() <= extent {
            return Ok(());
        }
        let largest = Self::measured(extent, mesh);
        Err(Failure::option(format!(
            "`{option}` must be at most {largest}, the mesh's largest dimension, got {self}"
        )))
    }

    /// A length in the unit of a mesh, for people to read: in millimetres, or inches for a mesh in
    /// inches.
    pub(crate) fn measured(value: f64, mesh: Unit) -> Self {
        let unit = if mesh == Unit::In { Unit::In } else { Unit::Mm };
        let value = value * mesh.meters() / unit.meters();
        // Three digits will do to choose another length.
        let step = 10_f64.powf((value.abs().max(1e-9).log10() - 2.0).floor());
        Self { value: (value / step).round() * step, unit }
    }
}

impl Display for Length {
    /// As it is parsed.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Without the noise of floating point.
        let value = format!("{:.9}", self.value);
        let value = value.trim_end_matches('0').trim_end_matches('.');
        write!(f, "{value}{}", self.unit.name())
    }
}

fn wanted() -> String {
    "must be a number with a unit, such as 15mm, 1.5cm, 0.015m or 0.6in".into()
}

/// Tells that a unit was assumed for a mesh, and warns of an implausible size.
///
/// - `extent`: of the mesh, in the assumed unit.
pub(crate) fn assume(unit: Unit, extent: f64, observer: &dyn Observer) {
    /// Largest dimensions in metres: a head is some 0.3, a person 1.7, a figure of fantasy a few.
    const PLAUSIBLE: std::ops::RangeInclusive<f64> = 0.05..=10.0;
    let size = |unit: Unit| extent * unit.meters();
    let text = format!(
        "the mesh has no unit; assuming {}, which makes its largest dimension {}",
        unit.summary().to_lowercase(),
        large(size(unit))
    );
    if PLAUSIBLE.contains(&size(unit)) {
        observer.note(format!("{text}; use `unit` to change this"));
        return;
    }
    // The one in which it is most like a person or a head.
    let unlikeness = |unit: Unit| {
        let unlike = |meters: f64| (size(unit) / meters).ln().abs();
        unlike(1.7).min(unlike(0.3))
    };
    let likely = Unit::ALL.iter().copied();
    let likely = likely.min_by(|&a, &b| unlikeness(a).total_cmp(&unlikeness(b))).unwrap_or(unit);
    let hint = if PLAUSIBLE.contains(&size(likely)) {
        format!("; `unit` {} would make it {}", likely.name(), large(size(likely)))
    } else {
        "; `unit` can change this".to_owned()
    };
    observer.warn(format!("{text}, implausible for a person{hint}"));
}

/// A length in metres, as people say it.
fn large(meters: f64) -> String {
    if meters >= 1.0 { format!("{meters:.2} m") } else { format!("{:.1} cm", meters * 100.0) }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;
    use crate::observer::Event;

    #[test]
    fn lengths() {
        let length = |text| Length::parse(text).map(|length| length.in_unit(Unit::M));
        for (text, wanted) in [
            ("15mm", 0.015),
            ("-1.5 cm", -0.015),
            ("0.5m", 0.5),
            ("2in", 0.0508),
            ("1e3mm", 1.0),
            ("+10 mm", 0.01),
            ("0", 0.0),
            ("-0.0", 0.0),
            ("0mm", 0.0),
        ] {
            assert!((length(text).unwrap() - wanted).abs() < 1e-12, "{text}");
        }
        assert!((Length::parse("15mm").unwrap().in_unit(Unit::Cm) - 1.5).abs() < 1e-12);
        assert!(Length::parse_distance("-1mm").is_err());
    }

    #[test]
    fn implausible_sizes_are_warned_of_with_the_likely_unit() {
        let message = |extent: f64| {
            let log = Recorder::default();
            assume(Unit::M, extent, &log);
            log.0.into_inner().unwrap()
        };
        for (extent, unit) in
            [(179.4, "cm"), (30.0, "cm"), (1794.0, "mm"), (300.0, "mm"), (70.6, "in"), (12.0, "in")]
        {
            let message = message(extent);
            assert!(message.starts_with("warning: the mesh has no unit"), "{message}");
            assert!(
                message.contains(&format!("; `unit` {unit} would make it ")),
                "{extent}: {message}"
            );
        }
        assert!(message(1e7).ends_with("implausible for a person; `unit` can change this"));
        assert!(message(0.01).starts_with("warning"));
        assert!([0.28, 1.79, 4.0].map(message).iter().all(|message| message.starts_with("note: ")));
    }

    /// The last message to an observer.
    #[derive(Default)]
    struct Recorder(Mutex<String>);

    impl Observer for Recorder {
        fn event(&self, event: Event<'_>) {
            *self.0.lock().unwrap() = match event {
                Event::Note(text) => format!("note: {text}"),
                Event::Warning(text) => format!("warning: {text}"),
                _ => return,
            };
        }
    }

    #[test]
    fn what_is_not_a_length_is_reported_what_it_lacks() {
        let cases = [
            ("must have a unit", &["10", "-0.02", "1e3", "0.01 ", "10 ", "1e-300"][..]),
            (
                "mm, cm, m or in, such as 15mm, got `",
                &["5inches", "5 inches", "10px", "15mmm", "10MM"],
            ),
            ("such as 15mm, 1.5cm", &["", "mm", "nan", "nanmm", "inf", "infm", "0,5mm", "10mm mm"]),
            ("such as 15mm, 1.5cm", &["1e400mm", "ä", "five", "1_000mm", "0x10mm", "--5mm"]),
            ("at most 1e9", &["1e10mm", "-1e308m"]),
        ];
        for (wanted, texts) in cases {
            for text in texts {
                let said = Length::parse(text).unwrap_err();
                assert!(said.contains(wanted), "{text}: {said}");
            }
        }
        let said = Length::parse("10").unwrap_err();
        assert!(said.ends_with("such as 10mm, 10cm, 10m or 10in"), "{said}");
    }

    #[test]
    fn lengths_are_shown_as_they_are_written() {
        for text in ["15mm", "-1.5cm", "0.015m", "0.6in", "1000mm"] {
            assert_eq!(Length::parse(text).unwrap().to_string(), text);
        }
        for (value, mesh, wanted) in [
            (0.314_159, Unit::M, "314mm"),
            (0.001_239_9, Unit::M, "1.24mm"),
            (3.999, Unit::M, "4000mm"),
            (2.5, Unit::In, "2.5in"),
            (0.0, Unit::Cm, "0mm"),
        ] {
            assert_eq!(Length::measured(value, mesh).to_string(), wanted);
        }
    }
}
