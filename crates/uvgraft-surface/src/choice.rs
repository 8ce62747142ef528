//! Options that are one of a few named values.
//!
//! The names that users write, and what each means in a line, are stated once, beside the type. Every
//! way in reads them from here: the command's options and their help, Python's arguments, JSON and
//! messages.

/// A value of an option with few values, each of which has a name.
pub trait Choice: Copy + PartialEq + 'static {
    /// All values, in the order in which they are listed.
    const ALL: &'static [Self];

    /// The name that users write, such as `catmull-rom`.
    fn name(self) -> &'static str;

    /// What it means, in a line without a full stop; empty if the name says it.
    fn summary(self) -> &'static str;

    /// The value of a name.
    fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|value| value.name() == name)
    }

    /// All names, as messages list them: `first, left or right`.
    fn names() -> String {
        let names: Vec<&str> = Self::ALL.iter().map(|value| value.name()).collect();
        match &*names {
            [] => String::new(),
            [only] => (*only).to_owned(),
            [first @ .., last] => format!("{} or {last}", first.join(", ")),
        }
    }
}

/// Serialises a choice as its name.
#[cfg(feature = "serde")]
#[macro_export]
macro_rules! serialize_by_name {
    ($type:ty) => {
        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
                to.serialize_str($crate::Choice::name(*self))
            }
        }
    };
}

/// Implements [`Choice`] by a table: each value with its name and its summary.
///
/// ```
/// #[derive(Debug, Clone, Copy, PartialEq)]
/// enum Side {
///     Left,
///     Right,
/// }
///
/// uvgraft_surface::choices!(Side {
///     Left => "left", "The person's left";
///     Right => "right", "The person's right";
/// });
///
/// use uvgraft_surface::Choice;
/// assert_eq!(Side::named("right"), Some(Side::Right));
/// assert_eq!(Side::names(), "left or right");
/// ```
#[macro_export]
macro_rules! choices {
    ($type:ty { $($value:ident => $name:literal, $summary:literal;)+ }) => {
        impl $crate::Choice for $type {
            const ALL: &'static [Self] = &[$(Self::$value),+];

            fn name(self) -> &'static str {
                match self {
                    $(Self::$value => $name,)+
                }
            }

            fn summary(self) -> &'static str {
                match self {
                    $(Self::$value => $summary,)+
                }
            }
        }
    };
}
