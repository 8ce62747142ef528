//! Parsers of option values.

use uvgraft_assembly::render::parse_number;

/// Number of frames of a turntable, unless another one is given.
pub(super) const TURNTABLE: u16 = 36;

pub(super) fn rate(text: &str) -> Result<f32, String> {
    within(text, 0.1, 240.0).map_err(|_| "must be 0.1 to 240 frames per second".to_owned())
}

fn within(text: &str, least: f32, most: f32) -> Result<f32, String> {
    let value = parse_number(text)?;
    let sound = (least..=most).contains(&value);
    if sound { Ok(value) } else { Err(format!("must be {least} to {most}")) }
}

pub(super) fn elevation(text: &str) -> Result<f32, String> {
    within(text, -89.0, 89.0)
}

pub(super) fn field_of_view(text: &str) -> Result<f32, String> {
    within(text, 1.0, 120.0)
}

pub(super) fn zoom(text: &str) -> Result<f32, String> {
    within(text, 0.1, 50.0)
}

pub(super) fn seconds(text: &str) -> Result<f32, String> {
    within(text, 0.0, f32::MAX).map_err(|_| "must be at least 0 seconds".to_owned())
}

pub(super) fn turntable(text: &str) -> Result<u16, String> {
    let count = text.parse().ok().filter(|count| (2..=3600).contains(count));
    count.ok_or_else(|| "must be 2 to 3600 frames; put the avatar before this option".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_within_their_ranges() {
        assert!(rate("0").is_err() && rate("12").is_ok());
        assert_eq!((elevation("-89"), zoom("0.1")), (Ok(-89.0), Ok(0.1)));
        assert!(elevation("90").is_err() && field_of_view("0").is_err() && zoom("0").is_err());
        assert!(seconds("-1").is_err() && seconds("1e9").is_ok());
    }
}
