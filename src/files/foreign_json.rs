//! JSON of other programs, whose numbers may be `NaN`, `Infinity` and other things that JSON has no numbers for.
//!
//! Such a value is read as a text that no file contains, so that it is an error only where it is used. [`no_number`] knows it.

use std::ops::Range;
use std::path::Path;

use serde::de::DeserializeOwned;
use serde_json::Value;

use super::json::{parse_json, wrong_at};
use super::text::is_no_number;
use quadratura_base::error::{Message, Result};

/// The beginning of texts that stand for no number: a control character that no program writes into a text.
const MARK: char = '\u{7f}';

/// The bytes by which a marked word is longer than the word itself: two quotation marks and [`MARK`].
const LONGER: usize = 3;

/// Reads a JSON file as [`super::json::read_json`] does.
///
/// # Errors
/// As there.
pub fn read_foreign_json<T: DeserializeOwned>(
    file: &Path,
    limit: u64,
    remedy: impl Into<Message>,
) -> Result<T> {
    let remedy = remedy.into();
    let text = super::json::read_limited(file, limit, remedy.clone())?;
    parse_foreign_json(file, &text, remedy)
}

/// Parses JSON text that was read from `file`.
///
/// # Errors
/// [`quadratura_base::Error::Input`] with line and column.
pub fn parse_foreign_json<T: DeserializeOwned>(
    file: &Path,
    text: &[u8],
    remedy: impl Into<Message>,
) -> Result<T> {
    let remedy = remedy.into();
    let strict = parse_json(file, text, remedy.clone());
    let words = match &strict {
        Ok(_) => Vec::new(),
        Err(_) => words_for_no_number(text),
    };
    if words.is_empty() {
        return strict;
    }
    serde_json::from_slice(&marked(text, &words)).map_err(|error| {
        let column = own_column(text, &words, error.line(), error.column());
        wrong_at(file, text, &error, error.line(), column, remedy)
    })
}

/// Returns what the file has where a number should be, if it is none of JSON: `NaN`, `-Infinity`.
pub fn no_number(value: &Value) -> Option<&str> {
    value.as_str()?.strip_prefix(MARK)
}

/// Returns the text of a value that is one.
pub fn text_of(value: &Value) -> Option<&str> {
    value.as_str().filter(|text| !text.starts_with(MARK))
}

/// Returns the first value below this one that is no number of JSON, with its path: `position[2]`.
pub fn first_no_number(value: &Value) -> Option<(String, &str)> {
    let below = |step: String, value| {
        let (path, word) = first_no_number(value)?;
        let between = if path.is_empty() || path.starts_with('[') { "" } else { "." };
        Some((format!("{step}{between}{path}"), word))
    };
    match value {
        Value::String(_) => Some((String::new(), no_number(value)?)),
        Value::Array(items) => {
            items.iter().enumerate().find_map(|(index, item)| below(format!("[{index}]"), item))
        }
        Value::Object(fields) => fields.iter().find_map(|(key, field)| below(key.clone(), field)),
        _ => None,
    }
}

/// Finds the words for no number outside of texts.
fn words_for_no_number(text: &[u8]) -> Vec<Range<usize>> {
    let is_of_word = |byte: &u8| {
        byte.is_ascii_alphanumeric() || matches!(byte, b'+' | b'-' | b'.' | b'#' | b'(' | b')' | b'_')
    };
    let mut words = Vec::new();
    let mut at = 0;
    while at < text.len() {
        if text[at] == b'"' {
            at += 1;
            while at < text.len() && text[at] != b'"' {
                at += if text[at] == b'\\' { 2 } else { 1 };
            }
            at += 1;
            continue;
        }
        let length = text[at..].iter().take_while(|byte| is_of_word(byte)).count();
        let word = &text[at..at + length];
        let number: Option<f64> = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        // 1e400 is JSON, but no number of 64 bits.
        if is_no_number(word) || number.is_some_and(f64::is_infinite) {
            words.push(at..at + length);
        }
        at += length.max(1);
    }
    words
}

/// Returns the text with each of the words marked.
fn marked(text: &[u8], words: &[Range<usize>]) -> Vec<u8> {
    let mut marked = Vec::with_capacity(text.len() + LONGER * words.len());
    let mut from = 0;
    for word in words {
        marked.extend_from_slice(&text[from..word.start]);
        marked.extend_from_slice(format!("\"{MARK}").as_bytes());
        marked.extend_from_slice(&text[word.clone()]);
        marked.push(b'"');
        from = word.end;
    }
    marked.extend_from_slice(&text[from..]);
    marked
}

/// Returns the column, from 1, in the text itself for one in the marked text.
fn own_column(text: &[u8], words: &[Range<usize>], line: usize, column: usize) -> usize {
    let before = text.split_inclusive(|byte| *byte == b'\n').take(line.saturating_sub(1));
    let start: usize = before.map(<[u8]>::len).sum();
    let mut column = column;
    for word in words.iter().skip_while(|word| word.start < start) {
        // A place within a marked word is that of the word.
        let within = (start + column).saturating_sub(word.start + 1);
        if start + column <= word.start {
            break;
        }
        column -= within.min(LONGER);
    }
    column
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<Value> {
        parse_foreign_json(Path::new("f.json"), text.as_bytes(), "mend it")
    }

    #[test]
    fn what_is_no_number_is_kept_with_its_place_and_texts_are_left_as_they_are() {
        assert_eq!(no_number(&parsed("[2e307, -1e400]").unwrap()[1]), Some("-1e400"));
        let text = r#"{"a": [1, NaN, {"b": -Infinity}], "NaN": "NaN, \"inf", "c": nan(ind), "d": -1.#IND00}"#;
        let value = parsed(text).unwrap();
        assert_eq!(no_number(&value["a"][1]), Some("NaN"));
        assert_eq!(no_number(&value["a"][2]["b"]), Some("-Infinity"));
        assert_eq!(text_of(&value["NaN"]), Some("NaN, \"inf"));
        assert_eq!((no_number(&value["c"]), no_number(&value["d"])), (Some("nan(ind)"), Some("-1.#IND00")));
        assert_eq!(text_of(&value["c"]), None);
        assert_eq!(first_no_number(&value), Some(("a[1]".into(), "NaN")));
        assert_eq!(first_no_number(&value["a"][2]), Some(("b".into(), "-Infinity")));
        assert_eq!(first_no_number(&value["NaN"]), None);
    }

    #[test]
    fn a_mistake_behind_such_values_is_reported_at_its_own_place() {
        let place = |text: &str| parsed(text).unwrap_err().to_string();
        let near = place("{\"a\": [NaN, NaN],\n \"b\": [NaN, inf, },\n \"c\": 1}");
        assert!(
            near.contains("line 2 column 18") && near.contains("near \"") && !near.contains('\u{7f}'),
            "{near}"
        );
        let whole = place("{\"a\": }");
        assert!(whole.contains("line 1 column 7"), "{whole}");
        let typed =
            parse_foreign_json::<Vec<f64>>(Path::new("f.json"), b"[0,\n 1, NaN, 2]", "mend it").unwrap_err();
        assert!(typed.to_string().contains("line 2 column 7: NaN, expected a number"), "{typed}");
    }
}
