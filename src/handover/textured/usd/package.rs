//! `.usdz`: an archive without compression whose files begin at multiples of 64 bytes, the stage first.

use std::io::{Cursor, Write};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use crate::textured::WrittenFile;

/// What the start of every file's content is a multiple of, in bytes.
pub(super) const ALIGNMENT: u16 = 64;

/// Packs files in their order.
pub(super) fn package(files: &[WrittenFile]) -> Vec<u8> {
    // The same files give the same bytes at any time.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::default())
        .with_alignment(ALIGNMENT);
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for file in files {
        let written = archive.start_file(file.name.as_str(), options).map_err(std::io::Error::other);
        written
            .and_then(|()| archive.write_all(&file.bytes))
            .expect("memory does not fail, and names are short");
    }
    archive.finish().expect("memory does not fail").into_inner()
}
