//! Reads the bytes of a glTF file: its JSON, and its buffers.

use std::borrow::Cow;
use std::fs;
use std::path::{Component, Path, PathBuf};

use gltf::json;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::Value;

use super::super::limits::{LARGEST_FILE, check_file_size};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::alike::difference;
use quadratura_files::named_file::{NamedFile, NamedFiles};

/// Maximum number of values in the JSON part: a list of empty braces takes a hundred times its text once
/// parsed.
const MOST_VALUES: usize = 8_000_000;

const EXPORT_AGAIN: &str = "export the model again";

/// The JSON part, and the binary chunk of a GLB.
pub(super) struct Container<'a> {
    pub json: &'a [u8],
    pub binary: Option<&'a [u8]>,
}

/// Splits a GLB into its chunks; anything else is JSON as a whole.
pub(super) fn split<'a>(path: &Path, bytes: &'a [u8]) -> Result<Container<'a>> {
    if !bytes.starts_with(b"glTF") {
        return Ok(Container { json: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), binary: None });
    }
    let word = |at: usize| {
        let word = bytes.get(at..at + 4).map(|word| word.try_into().expect("four bytes were taken"));
        word.map(u32::from_le_bytes).ok_or_else(|| truncated(path, bytes.len(), at + 4))
    };
    let version = word(4)?;
    if version != 2 {
        let found = format!("GLB version {version}; only version 2 is supported");
        return Err(Error::input(path, "byte 4", found, "export the model as glTF 2.0"));
    }
    let whole = (word(8).unwrap_or_default() as usize).max(SHORTEST_GLB);
    if bytes.len() < SHORTEST_GLB {
        return Err(truncated(path, bytes.len(), whole));
    }
    let mut container = Container { json: &[], binary: None };
    let mut at = 12;
    while at + 8 <= bytes.len() {
        let (length, kind) = (word(at)? as usize, &bytes[at + 4..at + 8]);
        let end = at + 8 + length;
        let chunk = bytes.get(at + 8..end).ok_or_else(|| truncated(path, bytes.len(), whole.max(end)))?;
        match kind {
            b"JSON" if container.json.is_empty() => container.json = chunk,
            b"BIN\0" if container.binary.is_none() => container.binary = Some(chunk),
            _ => {}
        }
        at += 8 + length.next_multiple_of(4);
    }
    if container.json.is_empty() {
        return Err(Error::input(
            path,
            "byte 12",
            "no chunk of JSON, which every GLB begins with",
            EXPORT_AGAIN,
        ));
    }
    Ok(container)
}

/// The length of a GLB's header and of that of its first chunk.
const SHORTEST_GLB: usize = 20;

fn truncated(path: &Path, length: usize, expected: usize) -> Error {
    let found = format!("the file is truncated: it has {length} bytes, expected {expected} at least");
    Error::input(path, format!("byte {length}"), found, "copy or export it again")
}

/// What a file says about its own format, in 2.0 and in 1.0.
#[derive(Deserialize)]
struct Described {
    #[serde(default)]
    asset: Option<Asset>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Asset {
    #[serde(default)]
    version: Value,
    #[serde(default)]
    min_version: Value,
}

/// Refuses files of other versions of glTF. Those of 2.1 and later are read where they say that a reader of 2.0 can, with a
/// note.
///
/// # Errors
/// [`Error::Input`] when the file says that it is none of 2.0, and the errors of its JSON.
pub(super) fn check_version(path: &Path, json: &[u8]) -> Result<Option<String>> {
    let Described { asset } = super::parse(path, json)?;
    let Some(Asset { version, min_version }) = asset else { return Ok(None) };
    let number = |value: &Value| match value {
        Value::String(text) => text.trim().parse::<f64>().ok(),
        value => value.as_f64(),
    };
    let of = |key: &str, value: &Value| {
        let found = format!("glTF {}, of which 2.0 is read", value.as_str().unwrap_or(&value.to_string()));
        Error::input(path, format!("asset.{key}"), found, "export the model as glTF 2.0")
    };
    if number(&min_version).is_some_and(|least| least > 2.0) {
        return Err(of("minVersion", &min_version));
    }
    match number(&version) {
        Some(number) if !(2.0..3.0).contains(&number) => Err(of("version", &version)),
        Some(number) if number > 2.0 => {
            Ok(Some(format!("the file is glTF {number}; what is newer than 2.0 in it is not read")))
        }
        None if version.is_string() => Err(of("version", &version)),
        _ => Ok(None),
    }
}

/// Maximum number of entries of all top-level lists together (nodes, meshes, accessors, ...): each takes some
/// hundred bytes once parsed, however short its text is. A hundred thousand objects have 800,000.
const MOST_ENTRIES: usize = 1_000_000;

/// The top-level lists. Their entries are not kept, so counting takes no memory.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct GltfLists {
    accessors: Vec<IgnoredAny>,
    animations: Vec<IgnoredAny>,
    buffers: Vec<IgnoredAny>,
    buffer_views: Vec<IgnoredAny>,
    cameras: Vec<IgnoredAny>,
    images: Vec<IgnoredAny>,
    materials: Vec<IgnoredAny>,
    meshes: Vec<IgnoredAny>,
    nodes: Vec<IgnoredAny>,
    samplers: Vec<IgnoredAny>,
    scenes: Vec<IgnoredAny>,
    skins: Vec<IgnoredAny>,
    textures: Vec<IgnoredAny>,
}

/// Refuses JSON with too many values or entries.
///
/// # Errors
/// [`Error::Input`] when the JSON part is damaged or has too many values or entries.
pub(super) fn check_counts(path: &Path, json: &[u8]) -> Result<()> {
    check_value_count(path, json)?;
    let l: GltfLists = super::parse(path, json)?;
    let lists = [
        (&l.accessors, "accessors"),
        (&l.animations, "animations"),
        (&l.buffers, "buffers"),
        (&l.buffer_views, "bufferViews"),
        (&l.cameras, "cameras"),
        (&l.images, "images"),
        (&l.materials, "materials"),
        (&l.meshes, "meshes"),
        (&l.nodes, "nodes"),
        (&l.samplers, "samplers"),
        (&l.scenes, "scenes"),
        (&l.skins, "skins"),
        (&l.textures, "textures"),
    ];
    let total: usize = lists.iter().map(|(list, _)| list.len()).sum();
    if total > MOST_ENTRIES {
        let (longest, name) = lists.into_iter().max_by_key(|(list, _)| list.len()).expect("there are lists");
        let found =
            format!("{} {name} among {total} entries; at most {MOST_ENTRIES} are read", longest.len());
        return Err(Error::input(path, name, found, "export a coarser model, or a part of it"));
    }
    Ok(())
}

fn check_value_count(path: &Path, json: &[u8]) -> Result<()> {
    let mut inside_string = false;
    let mut escaped = false;
    let mut values = 0usize;
    for &byte in json {
        match byte {
            _ if escaped => escaped = false,
            b'\\' if inside_string => escaped = true,
            b'"' => inside_string = !inside_string,
            b'{' | b'[' | b',' if !inside_string => values += 1,
            _ => {}
        }
    }
    if values > MOST_VALUES {
        let found = format!("the JSON holds {values} values; at most {MOST_VALUES} are read");
        return Err(Error::input(path, "", found, "export a coarser model, or a part of it"));
    }
    Ok(())
}

/// Returns the bytes of all buffers, in order.
///
/// # Errors
/// [`Error::Input`] with the JSON path when one is missing, too short, or neither in the file itself nor in a
/// file in or below its folder.
pub(super) fn buffers<'a>(
    path: &Path,
    buffers: &[json::Buffer],
    binary: Option<&'a [u8]>,
) -> Result<Vec<Cow<'a, [u8]>>> {
    let mut total = 0u64;
    let mut loaded = Vec::new();
    for (i, buffer) in buffers.iter().enumerate() {
        let place = format!("buffers[{i}]");
        let bytes = load(path, &place, buffer.uri.as_deref(), binary.filter(|_| i == 0))?;
        let (has, needs) = (bytes.len() as u64, buffer.byte_length.0);
        if has < needs {
            let found = format!("{has} bytes where byteLength says {needs}");
            return Err(Error::input(path, place, found, "copy or export the file again"));
        }
        total += has;
        if total > LARGEST_FILE {
            let found = format!("buffers of more than {LARGEST_FILE} bytes together");
            return Err(Error::input(path, place, found, "export a coarser model, or a part of it"));
        }
        loaded.push(bytes);
    }
    Ok(loaded)
}

fn load<'a>(path: &Path, place: &str, uri: Option<&str>, binary: Option<&'a [u8]>) -> Result<Cow<'a, [u8]>> {
    let Some(uri) = uri else {
        let missing = "no uri, and the file has no binary chunk for it";
        return binary.map(Cow::Borrowed).ok_or_else(|| Error::input(path, place, missing, EXPORT_AGAIN));
    };
    resource(path, place, uri).map(Cow::Owned)
}

/// Returns the bytes of a URI: those that it holds itself, or those of a file in or below the folder of the file at
/// `path`.
///
/// # Errors
/// [`Error::Input`] with the JSON path `place` for other URIs; [`Error::Io`].
pub fn resource(path: &Path, place: &str, uri: &str) -> Result<Vec<u8>> {
    if let Some(data) = uri.strip_prefix("data:") {
        let decoded = data.split_once(";base64,").and_then(|(_, text)| decode_base64(text.as_bytes()));
        let broken = "a data URI that is not base64";
        return decoded.ok_or_else(|| Error::input(path, place, broken, EXPORT_AGAIN));
    }
    let short = || uri.chars().take(80).collect::<String>();
    let file = file_of_uri(path, uri).map_err(|fault| match fault {
        UriFault::Outside => {
            let found = format!("the uri `{}` leads out of the model's folder", short());
            Error::input(
                path,
                place,
                found,
                "keep buffers and pictures beside the model, or export it as GLB",
            )
        }
        UriFault::Several(files) => {
            let found = format!("several files could be `{}`: {}", short(), files.join(", "));
            Error::input(path, place, found, "give one of them exactly this name, or remove the others")
        }
    })?;
    let size = fs::metadata(&file).map_err(Error::io(&file, "find this file of the model"))?.len();
    check_file_size(&file, size)?;
    fs::read(&file).map_err(Error::io(&file, "read it"))
}

/// Returns a note for each buffer whose file is spelled differently on the disk.
pub(super) fn respelled(path: &Path, buffers: &[json::Buffer]) -> Vec<String> {
    let uris = buffers.iter().enumerate().filter_map(|(i, buffer)| Some((i, buffer.uri.as_deref()?)));
    let note = |(i, uri): (usize, &str)| {
        let file = file_of_uri(path, uri).ok().filter(|_| !uri.starts_with("data:"))?;
        let found = file.file_name()?.to_str()?;
        let name = name_of_uri(uri);
        let how = difference(name.rsplit(['/', '\\']).next()?, found);
        (!how.is_empty()).then(|| format!("buffers[{i}]: the file was found {how}, as {found}"))
    };
    uris.filter_map(note).collect()
}

/// Why a URI names no file.
#[derive(Debug, PartialEq)]
enum UriFault {
    /// It leads out of the model's folder.
    Outside,
    /// Several files are equally like it.
    Several(Vec<String>),
}

/// Returns the file that a relative URI refers to, which must be in or below the model's folder, by its text and, where it exists,
/// after resolving links. It may have `\` between folders, and be spelled differently on the disk ([`NamedFiles`]).
fn file_of_uri(path: &Path, uri: &str) -> Result<PathBuf, UriFault> {
    let name = name_of_uri(uri).replace('\\', "/");
    let is_plain = |c: Component| matches!(c, Component::Normal(_) | Component::CurDir);
    if name.is_empty() || name.contains([':', '\0']) || !Path::new(&name).components().all(is_plain) {
        return Err(UriFault::Outside);
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let file = match NamedFiles::default().find(folder, &name) {
        NamedFile::Missing => folder.join(name),
        NamedFile::Found(name) => folder.join(name),
        NamedFile::Several(files) => return Err(UriFault::Several(files)),
    };
    match (file.canonicalize(), folder.canonicalize()) {
        (Ok(file_itself), Ok(folder)) if !file_itself.starts_with(&folder) => Err(UriFault::Outside),
        _ => Ok(file),
    }
}

/// Returns the name that a URI encodes; programs that do not encode names write them as they are.
fn name_of_uri(uri: &str) -> String {
    percent_decoded(uri).and_then(|name| String::from_utf8(name).ok()).unwrap_or_else(|| uri.to_owned())
}

fn percent_decoded(uri: &str) -> Option<Vec<u8>> {
    let mut bytes = uri.bytes();
    let mut decoded = Vec::with_capacity(uri.len());
    while let Some(byte) = bytes.next() {
        decoded.push(match byte {
            b'%' => {
                let mut digit = || char::from(bytes.next()?).to_digit(16);
                (digit()? * 16 + digit()?) as u8
            }
            _ => byte,
        });
    }
    Some(decoded)
}

fn decode_base64(text: &[u8]) -> Option<Vec<u8>> {
    let mut decoded = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut count) = (0u32, 0);
    for &byte in text.iter().filter(|b| !matches!(b, b'=' | b'\n' | b'\r')) {
        let six = match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return None,
        };
        bits = bits << 6 | u32::from(six);
        count += 6;
        if count >= 8 {
            count -= 8;
            decoded.push((bits >> count) as u8);
        }
    }
    Some(decoded)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_and_percent_signs_are_decoded() {
        assert_eq!(decode_base64(b"UXVhZHJhdHVyYQ==").unwrap(), b"Quadratura");
        assert_eq!(decode_base64(b"UXVh*"), None);
        assert_eq!(percent_decoded("a%20b%2Ebin").unwrap(), b"a b.bin");
        assert_eq!(percent_decoded("a%2"), None);
        assert_eq!(name_of_uri("100%.bin"), "100%.bin");
    }

    #[test]
    fn uris_stay_in_the_models_folder() {
        let model = Path::new("site/model.gltf");
        for uri in ["parts/roof%201.bin", ".\\parts\\roof 1.bin"] {
            let file = file_of_uri(model, uri).unwrap();
            assert!(file.ends_with("parts/roof 1.bin") && file.starts_with("site"), "{}", file.display());
        }
        for uri in [
            "../a.bin",
            "a/../../b",
            "/etc/passwd",
            "http://x/y",
            "file:a",
            "c:a",
            "%2e%2e/a",
            "..\\a",
            "",
            "a%00",
        ] {
            assert_eq!(file_of_uri(model, uri), Err(UriFault::Outside), "{uri}");
        }
    }

    #[test]
    fn a_file_is_found_in_another_unicode_form_and_none_is_guessed_among_several() {
        let folder = tempfile::tempdir().unwrap();
        let model = folder.path().join("model.gltf");
        let file = folder.path().join("me\u{301}tal.BIN");
        fs::write(&file, "x").unwrap();
        assert_eq!(file_of_uri(&model, "m%C3%A9tal.bin"), Ok(file));
        let buffers: Vec<json::Buffer> = serde_json::from_str(
            r#"[{"byteLength": 1, "uri": "me%CC%81tal.BIN"}, {"byteLength": 1, "uri": "m%C3%A9tal.BIN"}]"#,
        )
        .unwrap();
        let notes = respelled(&model, &buffers);
        assert!(
            notes.len() == 1
                && notes[0].starts_with("buffers[1]: the file was found under another Unicode form"),
            "{notes:?}"
        );
        fs::write(folder.path().join("me\u{301}tal.Bin"), "x").unwrap();
        assert!(
            matches!(file_of_uri(&model, "m%C3%A9tal.bin"), Err(UriFault::Several(files)) if files.len() == 2)
        );
    }

    #[test]
    fn strings_count_as_one_value() {
        assert!(check_value_count(Path::new("a"), br#"{"a":"\",,,,{{{["}"#).is_ok());
        assert!(check_value_count(Path::new("a"), &vec![b'['; MOST_VALUES + 1]).is_err());
    }

    #[test]
    fn empty_braces_by_the_million_are_counted_before_they_are_read() {
        let bomb = format!("{{\"nodes\":[{}{{}}]}}", "{},".repeat(MOST_ENTRIES));
        let said = check_counts(Path::new("a"), bomb.as_bytes()).unwrap_err().to_string();
        assert!(said.contains("nodes: 1000001 nodes among"), "{said}");
    }
}
