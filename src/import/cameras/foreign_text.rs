//! Whole files of text of other programs, limited in size: as text, as JSON, and as XML.

use std::path::Path;

use roxmltree::{Document, Node, ParsingOptions};
use serde_json::Value;

use super::photo_name::short;
use quadratura_base::error::{Error, Result};
use quadratura_files::foreign_json::{no_number, parse_foreign_json};
use quadratura_files::json::read_limited;
use quadratura_files::text::{BYTE_ORDER_MARK, Objection, SAVE_AS_UTF8, not_utf16};

/// The largest file that is read, in bytes: at some thousand bytes per photo a survey of a hundred thousand photos.
const LARGEST: u64 = 256 << 20;
/// The most elements and texts of an XML file, some ten for each photo, which also limits the memory that they take.
const MOST_NODES: u32 = 4_000_000;

/// Reads a file of text.
///
/// # Errors
/// [`Error::Io`]; [`Error::Input`] when it is too large, empty, or not UTF-8; `expected` completes the message.
pub(super) fn read_text(file: &Path, expected: &str, remedy: &'static str) -> Result<String> {
    checked_text(file, read_limited(file, LARGEST, "split it into several files".into())?, expected, remedy)
}

/// Returns bytes that were read from `file` as text.
///
/// # Errors
/// [`Error::Input`] when they are empty or not UTF-8.
pub(super) fn checked_text(
    file: &Path,
    mut bytes: Vec<u8>,
    expected: &str,
    remedy: &'static str,
) -> Result<String> {
    if bytes.starts_with(BYTE_ORDER_MARK) {
        bytes.drain(..BYTE_ORDER_MARK.len());
    }
    if let Some((found, remedy)) = not_utf16(&bytes) {
        return Err(Error::input(file, "", found, remedy));
    }
    if bytes.trim_ascii().is_empty() {
        return Err(Error::input(file, "", format!("it is empty, {expected}"), remedy));
    }
    String::from_utf8(bytes).map_err(|error| {
        let (valid, bytes) = (error.utf8_error().valid_up_to(), error.as_bytes());
        let line = 1 + bytes[..valid].iter().filter(|byte| **byte == b'\n').count();
        let found = format!("byte 0x{:02X}, expected UTF-8 text", bytes[valid]);
        Error::input(file, format!("line {line}"), found, SAVE_AS_UTF8)
    })
}

/// Reads a file of JSON, in which words may stand where there is no number.
///
/// # Errors
/// Those of [`read_text`], and [`Error::Input`] with line and column.
pub(super) fn read_value(file: &Path, expected: &str, remedy: &'static str) -> Result<Value> {
    let text = read_text(file, expected, remedy)?;
    parse_foreign_json(file, text.as_bytes(), remedy)
}

/// Parses XML that was read from `file`.
///
/// # Errors
/// [`Error::Input`] with line and column.
pub(super) fn parse_xml<'t>(file: &Path, text: &'t str, remedy: &'static str) -> Result<Document<'t>> {
    let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|error| {
        let at = error.pos();
        let place = format!("line {} column {}", at.row, at.col);
        Error::input(file, place, format!("it is not whole XML ({error})"), remedy)
    })
}

/// Returns the first element of this name directly below `node`.
pub(super) fn child<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|child| child.has_tag_name(name))
}

/// Returns all elements of this name directly below `node`.
pub(super) fn children<'a, 'i>(node: Node<'a, 'i>, name: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.has_tag_name(name))
}

/// Parses a number; `what` names it in the message.
///
/// # Errors
/// What was found instead of a finite number, and the remedy.
pub(super) fn number(text: &str, what: &str) -> Result<f64, Objection> {
    text.trim().parse::<f64>().ok().filter(|number| number.is_finite()).ok_or_else(|| {
        (format!("{what} is {}, expected a number", short(text.trim())), "export the cameras again")
    })
}

/// Parses N numbers, separated by white space or commas; `what` names them in the message.
///
/// # Errors
/// What was found instead, and the remedy.
pub(super) fn numbers<const N: usize>(text: &str, what: &str) -> Result<[f64; N], Objection> {
    let mut all = [0.0; N];
    let mut fields =
        text.split(|c: char| c.is_ascii_whitespace() || c == ',').filter(|field| !field.is_empty());
    for (index, to) in all.iter_mut().enumerate() {
        let field = fields.next().ok_or_else(|| {
            (format!("{what} has {index} numbers, expected {N}"), "export the cameras again")
        })?;
        *to = number(field, what)?;
    }
    match fields.next() {
        None => Ok(all),
        Some(_) => Err((format!("{what} has more than {N} numbers"), "export the cameras again")),
    }
}

/// Reads a number of JSON, which may be written as a text; `what` names it in the message.
///
/// # Errors
/// What was found instead of a finite number, and the remedy.
pub(super) fn json_number(value: Option<&Value>, what: &str) -> Result<f64, Objection> {
    match value {
        Some(Value::String(text)) if no_number(&Value::String(text.clone())).is_none() => number(text, what),
        Some(value) if value.is_number() => Ok(value.as_f64().unwrap_or_default()),
        other => Err((format!("{what} is {}, expected a number", kind(other)), "export the cameras again")),
    }
}

/// Reads a list of N numbers of JSON; `what` names it in the message.
///
/// # Errors
/// What was found instead, and the remedy.
pub(super) fn json_numbers<const N: usize>(value: Option<&Value>, what: &str) -> Result<[f64; N], Objection> {
    let mut all = [0.0; N];
    match value.and_then(Value::as_array) {
        Some(items) if items.len() == N => {
            for (to, item) in all.iter_mut().zip(items) {
                *to = json_number(Some(item), what)?;
            }
            Ok(all)
        }
        _ => Err((
            format!("{what} is {}, expected a list of {N} numbers", kind(value)),
            "export the cameras again",
        )),
    }
}

/// Describes a value for messages.
pub(super) fn kind(value: Option<&Value>) -> String {
    match value {
        None => "missing".into(),
        Some(Value::Null) => "null".into(),
        Some(Value::Array(items)) => format!("a list of {}", items.len()),
        Some(Value::Object(_)) => "an object".into(),
        Some(value) => {
            let text = no_number(value).map_or_else(|| value.to_string(), str::to_owned);
            let short: String = text.chars().take(40).collect();
            if short.len() < text.len() { format!("{short}…") } else { short }
        }
    }
}
