//! Files of a line of JSON and packed bytes.

use std::io::{Read, Write};

use flate2::Compression;
use flate2::read::DeflateDecoder;
use flate2::write::DeflateEncoder;
use serde::de::DeserializeOwned;

/// The longest first line.
const LONGEST_LINE: usize = 1024;
/// Deflate makes at most this many bytes of one.
const MOST_EXPANSION: u64 = 1032;

/// What is wrong with a file: where, and what was found.
pub type Fault = (&'static str, String);

/// Reads the first line; returns it with what follows.
///
/// # Errors
/// Where it is no line of this JSON.
pub fn first_line<T: DeserializeOwned>(bytes: &[u8]) -> Result<(T, &[u8]), Fault> {
    let line = bytes.iter().take(LONGEST_LINE).position(|byte| *byte == b'\n');
    let Some(line) = line else {
        return Err(("line 1", format!("no line feed within {LONGEST_LINE} bytes, expected a line of JSON")));
    };
    let header = serde_json::from_slice(&bytes[..line]).map_err(|error| ("line 1", error.to_string()))?;
    Ok((header, &bytes[line + 1..]))
}

/// Packs bytes.
pub fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).and_then(|()| encoder.finish()).expect("a vector takes every byte")
}

/// Unpacks a stream that has to have `wanted` bytes.
///
/// # Errors
/// What was found instead.
pub fn inflated(packed: &[u8], wanted: u64) -> Result<Vec<u8>, String> {
    if wanted > MOST_EXPANSION * (packed.len() as u64 + 1) {
        return Err(format!("{} packed bytes, which cannot hold the expected {wanted}", packed.len()));
    }
    let mut bytes = Vec::with_capacity(wanted as usize);
    let read = DeflateDecoder::new(packed).take(wanted + 1).read_to_end(&mut bytes);
    match read {
        Ok(_) if bytes.len() as u64 == wanted => Ok(bytes),
        Ok(_) => Err(format!("{} bytes or more, expected {wanted}", bytes.len())),
        Err(error) => Err(format!("damaged packed data ({error})")),
    }
}
