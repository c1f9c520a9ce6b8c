//! Reads a list of photos: a text file with one name per line.

use std::path::Path;

use quadratura_base::error::{Error, Result};
use quadratura_files::text::{lines_of, not_utf16};

const LARGEST_LIST: u64 = 16 << 20;

/// Returns the names in `file` with their line numbers, counted from 1. Empty lines and lines that begin with
/// `#` are skipped.
///
/// # Errors
/// [`Error::Io`]; [`Error::Input`] when it is not text, is far too large, or has no names.
pub fn read_photo_list(file: &Path) -> Result<Vec<(usize, String)>> {
    let remedy = "write the name of one photo per line";
    let size = std::fs::metadata(file).map_err(Error::io(file, "read it"))?.len();
    if size > LARGEST_LIST {
        return Err(Error::input(file, "", format!("{size} bytes, too large for a list of photos"), remedy));
    }
    let bytes = std::fs::read(file).map_err(Error::io(file, "read it"))?;
    if let Some((found, remedy)) = not_utf16(&bytes) {
        return Err(Error::input(file, "", found, remedy));
    }
    let text =
        String::from_utf8(bytes).map_err(|_| Error::input(file, "", "it is not UTF-8 text", remedy))?;
    let lines = lines_of(text.trim_start_matches('\u{feff}')).map(str::trim_ascii).zip(1..);
    let names: Vec<_> = lines
        .filter(|(line, _)| !line.is_empty() && !line.starts_with('#'))
        .map(|(line, number)| (number, line.to_owned()))
        .collect();
    if names.is_empty() { Err(Error::input(file, "", "it lists no photo", remedy)) } else { Ok(names) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8]) -> Result<Vec<(usize, String)>> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), bytes).unwrap();
        read_photo_list(file.path())
    }

    #[test]
    fn names_come_with_their_lines_and_comments_are_left_out() {
        let names = read(b"# north\na b.jpg\r\n\n  c.png\n").unwrap();
        assert_eq!(names, [(2, "a b.jpg".to_owned()), (4, "c.png".to_owned())]);
        let names = read("\u{feff}a#1.jpg\r# south\rb.jpg \t".as_bytes()).unwrap();
        assert_eq!(names, [(1, "a#1.jpg".to_owned()), (3, "b.jpg".to_owned())]);
    }

    #[test]
    fn an_empty_list_and_a_picture_are_refused() {
        assert!(read(b"# nothing\n").unwrap_err().to_string().contains("lists no photo"));
        assert!(read(b"a\0.\0j\0").unwrap_err().to_string().contains("UTF-16"));
        assert!(read(&[0xff, 0xd8, 0xff]).unwrap_err().to_string().contains("UTF-8"));
    }
}
