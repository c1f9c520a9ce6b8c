//! Reads and writes JSON files that people read and compare: one item per line, errors with line and column.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::ser::{Formatter, Serializer};

use super::text::not_utf16;
use quadratura_base::error::{Error, Message, Result};

/// Containers nested deeper than this are written on one line.
const BROKEN_LEVELS: usize = 2;

/// The number of bytes on either side of a mistake that a message quotes.
const NEAR_BYTES: usize = 16;

/// Returns `value` as JSON text: the outer two levels with one item per line, deeper ones on their item's
/// line, and a line feed at the end.
///
/// # Panics
/// When `value` has a map whose keys are not strings, which is a fault of the type.
pub fn to_json(value: &impl Serialize) -> Vec<u8> {
    let mut text = Vec::new();
    let mut serializer = Serializer::with_formatter(&mut text, ByLines::default());
    value.serialize(&mut serializer).expect("a vector takes every byte, and our types have string keys");
    text.push(b'\n');
    text
}

/// Reads a JSON file of at most `limit` bytes. `remedy` is the advice in errors about its content.
///
/// # Errors
/// [`Error::Io`] when it cannot be read; [`Error::Input`] with line and column when it is too large, is not
/// JSON, or lacks the fields of `T`.
pub fn read_json<T: DeserializeOwned>(file: &Path, limit: u64, remedy: impl Into<Message>) -> Result<T> {
    let remedy = remedy.into();
    let text = read_limited(file, limit, remedy.clone())?;
    parse_json(file, &text, remedy)
}

/// Reads a file of at most `limit` bytes.
///
/// # Errors
/// [`Error::Io`]; [`Error::Input`] when it is too large.
pub fn read_limited(file: &Path, limit: u64, remedy: Message) -> Result<Vec<u8>> {
    let size = fs::metadata(file).map_err(Error::io(file, "read it"))?.len();
    if size > limit {
        let found = format!("{size} bytes, but such a file has at most {limit}");
        return Err(Error::input(file, "", found, remedy));
    }
    fs::read(file).map_err(Error::io(file, "read it"))
}

/// Parses JSON text that was read from `file`.
///
/// # Errors
/// [`Error::Input`] with line and column.
pub fn parse_json<T: DeserializeOwned>(file: &Path, text: &[u8], remedy: impl Into<Message>) -> Result<T> {
    serde_json::from_slice(text)
        .map_err(|error| wrong_at(file, text, &error, error.line(), error.column(), remedy))
}

/// Makes the error about a place in the text of `file`, line and column counted from 1.
pub(super) fn wrong_at(
    file: &Path,
    text: &[u8],
    error: &serde_json::Error,
    line: usize,
    column: usize,
    remedy: impl Into<Message>,
) -> Error {
    let place = format!("line {line} column {column}");
    let message = error.to_string();
    let found = message.split(" at line ").next().unwrap_or(&message);
    if text.iter().all(u8::is_ascii_whitespace) {
        return Error::input(file, "", "the file is empty; expected JSON", remedy);
    }
    if let Some((found, remedy)) = not_utf16(text) {
        return Error::input(file, "", found, remedy);
    }
    if error.is_eof() {
        let found = "the file ends before its JSON does: it was cut short, or a bracket is missing";
        return Error::input(file, place, found, remedy);
    }
    let found = match near(text, line, column) {
        Some(near) if error.is_syntax() => format!("{found} near {near:?}"),
        _ => in_words(found),
    };
    Error::input(file, place, found, remedy)
}

/// Returns a message of the parser about JSON that is none of the expected kind, without the names that kinds have in the program:
/// what was found there, and what was expected.
pub fn in_words(message: &str) -> String {
    let wrong = ["invalid type: ", "invalid value: ", "invalid length "];
    let Some(rest) = wrong.iter().find_map(|start| message.strip_prefix(start)) else {
        return message.to_owned();
    };
    let Some((found, expected)) = rest.split_once(", expected ") else { return message.to_owned() };
    let found = match message.strip_prefix("invalid length ") {
        Some(_) => format!("a list of {found} values"),
        None => found_in_words(found),
    };
    format!("{found}, expected {}", expected_in_words(expected))
}

fn found_in_words(found: &str) -> String {
    let quoted = |start: &str| found.strip_prefix(start).map(|value| value.replace('`', ""));
    match found {
        "sequence" => "a list".to_owned(),
        "map" => "an object".to_owned(),
        _ => quoted("integer ")
            .or_else(|| quoted("floating point "))
            .map(|number| format!("the number {number}"))
            // What stands for no number in JSON of other programs is marked by this sign.
            .or_else(|| found.strip_prefix("string \"\\u{7f}")?.strip_suffix('"').map(str::to_owned))
            .or_else(|| found.strip_prefix("string ").map(|text| format!("the text {text}")))
            .or_else(|| quoted("boolean "))
            .unwrap_or_else(|| found.to_owned()),
    }
}

fn expected_in_words(expected: &str) -> String {
    let first = expected.split(' ').next().unwrap_or_default();
    let is_whole = |name: &str| {
        name.strip_prefix(['u', 'i'])
            .is_some_and(|bits| ["8", "16", "32", "64", "128", "size"].contains(&bits))
    };
    let list = ["an array of length ", "a tuple of size ", "tuple of size "];
    match expected {
        "a sequence" => "a list".to_owned(),
        "a map" | "map" => "an object, {...}".to_owned(),
        "string or map" | "a string" => "a text".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "f32" | "f64" => "a number".to_owned(),
        _ if is_whole(first) => "a whole number that fits there".to_owned(),
        _ if first == "struct" => "an object, {...}".to_owned(),
        _ if first == "enum" => "a word".to_owned(),
        _ => match list.iter().find_map(|start| expected.strip_prefix(start)) {
            Some(length) => format!("a list of {length} values"),
            None => expected.to_owned(),
        },
    }
}

/// Returns the text around a place that a message names by line and column, both counted from 1. A program's file is
/// often one long line, in which a column is hard to find.
fn near(text: &[u8], line: usize, column: usize) -> Option<String> {
    let line = text.split(|byte| *byte == b'\n').nth(line.checked_sub(1)?)?;
    let at = column.saturating_sub(1).min(line.len());
    let around = &line[at.saturating_sub(NEAR_BYTES)..line.len().min(at + NEAR_BYTES)];
    let near = String::from_utf8_lossy(around).trim().replace('"', "'");
    (!near.is_empty()).then_some(near)
}

/// A formatter that breaks lines in the outer [`BROKEN_LEVELS`] levels only.
#[derive(Default)]
struct ByLines {
    level: usize,
    has_items: bool,
}

impl ByLines {
    fn open<W: ?Sized + Write>(&mut self, out: &mut W, bracket: &[u8]) -> io::Result<()> {
        self.level += 1;
        self.has_items = false;
        out.write_all(bracket)
    }

    fn close<W: ?Sized + Write>(&mut self, out: &mut W, bracket: &[u8]) -> io::Result<()> {
        self.level -= 1;
        if self.has_items && self.level < BROKEN_LEVELS {
            self.new_line(out)?;
        }
        self.has_items = true;
        out.write_all(bracket)
    }

    fn item<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        self.has_items = true;
        if !first {
            out.write_all(b",")?;
        }
        match self.level <= BROKEN_LEVELS {
            true => self.new_line(out),
            false if first => Ok(()),
            false => out.write_all(b" "),
        }
    }

    fn new_line<W: ?Sized + Write>(&self, out: &mut W) -> io::Result<()> {
        out.write_all(b"\n")?;
        (0..self.level).try_for_each(|_| out.write_all(b"  "))
    }
}

impl Formatter for ByLines {
    fn begin_array<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.open(out, b"[")
    }

    fn end_array<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.close(out, b"]")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        self.item(out, first)
    }

    fn begin_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.open(out, b"{")
    }

    fn end_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.close(out, b"}")
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        self.item(out, first)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        out.write_all(b": ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    #[test]
    fn the_outer_levels_have_a_line_an_item_and_the_inner_ones_share_it() {
        let value = json!({"a": [[1, 2], {"b": [3, []]}], "c": [], "d": {"e": 1.5}});
        let text = String::from_utf8(to_json(&value)).unwrap();
        let expected = "{\n  \"a\": [\n    [1, 2],\n    {\"b\": [3, []]}\n  ],\n  \"c\": [],\n  \"d\": {\n    \"e\": 1.5\n  }\n}\n";
        assert_eq!(text, expected);
        assert_eq!(serde_json::from_str::<Value>(&text).unwrap(), value);
    }

    #[test]
    fn broken_text_is_reported_with_its_line_and_what_is_there() {
        let error = parse_json::<Value>(Path::new("p.json"), b"{\n \"a\": }", "mend it").unwrap_err();
        assert_eq!(error.to_string(), "p.json, line 2 column 7: expected value near \"'a': }\"; mend it");
        // The rest of a long line is not quoted, and where the text ends there is nothing to quote.
        let long = format!("[{}NaN{}]", "0, ".repeat(1000), ", 0".repeat(1000));
        let error =
            parse_json::<Value>(Path::new("p.json"), long.as_bytes(), "mend it").unwrap_err().to_string();
        assert!(error.contains("line 1 column 3002: expected value near \"") && error.len() < 100, "{error}");
        let error = parse_json::<Value>(Path::new("p.json"), b"{\"a\": ", "mend it").unwrap_err().to_string();
        assert!(
            error.contains("the file ends before its JSON does") && error.ends_with("; mend it"),
            "{error}"
        );
    }

    #[derive(Debug, serde::Deserialize)]
    #[allow(dead_code)]
    struct Wheel {
        spokes: u8,
        hub: [f64; 3],
        colour: Option<String>,
    }

    #[test]
    fn what_is_of_another_kind_is_told_without_the_names_of_types() {
        let told = |text: &str| {
            let error = parse_json::<Wheel>(Path::new("w.json"), text.as_bytes(), "mend it").unwrap_err();
            error.to_string().split(": ").nth(1).unwrap().split(';').next().unwrap().to_owned()
        };
        for (text, words) in [
            ("[]", "a list of 0 values, expected an object, {...}"),
            ("7", "the number 7, expected an object, {...}"),
            (r#"{"spokes": "six"}"#, "the text \"six\", expected a whole number that fits there"),
            (r#"{"spokes": -1}"#, "the number -1, expected a whole number that fits there"),
            (r#"{"spokes": 2.5}"#, "the number 2.5, expected a whole number that fits there"),
            (r#"{"hub": {}}"#, "an object, expected a list of 3 values"),
            (r#"{"hub": [1, 2]}"#, "a list of 2 values, expected a list of 3 values"),
            (r#"{"hub": [1, 2, true]}"#, "true, expected a number"),
            (r#"{"colour": []}"#, "a list, expected a text"),
            (r#"{"spokes": 3}"#, "missing field `hub`"),
        ] {
            assert_eq!(told(text), words, "{text}");
        }
    }

    #[test]
    fn a_file_that_is_too_large_is_not_read() {
        let file = tempfile::NamedTempFile::new().unwrap();
        fs::write(file.path(), "[1, 2, 3]").unwrap();
        let error = read_json::<Value>(file.path(), 5, "make it smaller").unwrap_err();
        assert!(error.to_string().contains("9 bytes"), "{error}");
    }
}
