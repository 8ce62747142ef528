//! Numbers as options.

use std::ops::RangeInclusive;

/// A parser of whole numbers within a range.
pub(crate) fn whole_number<T: TryFrom<u64>>(
    range: RangeInclusive<u64>,
) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| {
        let number = text.trim().parse().ok().filter(|number| range.contains(number));
        number.and_then(|number| T::try_from(number).ok()).ok_or_else(|| {
            let (least, most) = (range.start(), range.end());
            // A bound that is the type's own says nothing about the option.
            if most.checked_add(1).is_some_and(|beyond| T::try_from(beyond).is_ok()) {
                format!("must be a whole number from {least} to {most}")
            } else {
                format!("must be a whole number of at least {least}")
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_outside_the_range_are_refused() {
        let gutter = whole_number::<u8>(1..=100);
        assert_eq!([gutter("1"), gutter("100")], [Ok(1), Ok(100)]);
        for text in ["0", "101", "-1", "1.5", "x", "", "99999999999999999999"] {
            assert_eq!(gutter(text).unwrap_err(), "must be a whole number from 1 to 100", "{text}");
        }
        let triangles = whole_number::<u32>(1000..=u64::from(u32::MAX));
        assert_eq!(triangles("4000000000"), Ok(4_000_000_000));
        assert_eq!(triangles("999").unwrap_err(), "must be a whole number of at least 1000");
    }
}
