//! Parsers of numbers whose messages say what is possible.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// Returns a parser of whole numbers of a range.
pub fn whole<T>(
    range: RangeInclusive<T>,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static
where
    T: FromStr + PartialOrd + Display + Clone + Send + Sync + 'static,
{
    move |text| {
        let number = text.trim().parse().ok().filter(|number| range.contains(number));
        number.ok_or_else(|| format!("expected a whole number, {} to {}", range.start(), range.end()))
    }
}

/// Parses an angle in degrees.
pub fn degrees(text: &str) -> Result<f64, String> {
    let angle = text.trim().parse().ok().filter(|angle: &f64| angle.is_finite());
    angle.ok_or_else(|| "expected a number of degrees such as -22.5".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_outside_of_a_range_is_answered_with_the_range() {
        let parse = whole::<u32>(1..=64);
        assert_eq!((parse("1"), parse("64")), (Ok(1), Ok(64)));
        for text in ["0", "65", "-5", "99999999999999999999", "1.5", "many", ""] {
            assert_eq!(parse(text).unwrap_err(), "expected a whole number, 1 to 64", "{text}");
        }
    }

    #[test]
    fn angles_are_finite() {
        assert_eq!(degrees("-22.5"), Ok(-22.5));
        assert!(degrees("inf").is_err() && degrees("north").unwrap_err().contains("degrees"));
    }
}
