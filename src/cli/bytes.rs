//! Parses and formats amounts of memory.

/// Parses an amount such as `4G`, `1.5 GiB`, `800M` or `65536` to bytes; prefixes are powers of 1024.
///
/// # Errors
/// A sentence with the expected form, when the text is not an amount, or is 0.
pub fn parse_bytes(text: &str) -> Result<u64, String> {
    let expected = || "expected an amount such as 4G, 800M or 1.5GiB".to_string();
    let unit_at = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(unit_at);
    let factor = match unit.to_ascii_lowercase().trim_end_matches("ib").trim_end_matches('b') {
        "" => 0,
        "k" => 10,
        "m" => 20,
        "g" => 30,
        "t" => 40,
        _ => return Err(expected()),
    };
    let number: f64 = number.trim().parse().map_err(|_| expected())?;
    let bytes = number * (1u64 << factor) as f64;
    if (1.0..=1e18).contains(&bytes) { Ok(bytes as u64) } else { Err(expected()) }
}

/// Formats bytes with three significant digits and a unit: `12.3 MiB`.
pub fn readable_bytes(bytes: u64) -> String {
    const UNITS: [&str; 5] = ["B", "KiB", "MiB", "GiB", "TiB"];
    let mut amount = bytes as f64;
    let mut unit = 0;
    while amount >= 999.5 && unit + 1 < UNITS.len() {
        amount /= 1024.0;
        unit += 1;
    }
    let digits = if unit == 0 || amount >= 99.95 {
        0
    } else if amount >= 9.995 {
        1
    } else {
        2
    };
    format!("{amount:.digits$} {}", UNITS[unit])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_are_read_as_they_are_written() {
        for (text, bytes) in
            [("65536", 65536), ("1k", 1024), ("800M", 800 << 20), ("1.5 GiB", 3 << 29), ("4gb", 4 << 30)]
        {
            assert_eq!(parse_bytes(text), Ok(bytes), "{text}");
        }
        for text in ["", "much", "4X", "-1G", "0", "NaN", "1e30"] {
            assert!(parse_bytes(text).is_err(), "{text}");
        }
    }

    #[test]
    fn three_digits_are_enough() {
        for (bytes, text) in
            [(0, "0 B"), (999, "999 B"), (1000, "0.98 KiB"), (12_900_000, "12.3 MiB"), (3 << 29, "1.50 GiB")]
        {
            assert_eq!(readable_bytes(bytes), text);
        }
    }
}
