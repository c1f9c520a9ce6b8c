//! Text files of other programs: the ends of their lines, their encodings, and what they write where there is no number.

use std::borrow::Cow;
use std::io::{self, BufRead};

use chardetng::{EncodingDetector, Iso2022JpDetection, Utf8Detection};
use encoding_rs::{Encoding, WINDOWS_1252};

/// The byte order mark that some editors write before the first line.
pub const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// The remedy for a text in another encoding.
pub const SAVE_AS_UTF8: &str = "save it as UTF-8 in a text editor";

/// The lines of a text, ended by LF, CR LF, or CR alone as programs of old Macintosh wrote it; one at a time in memory.
pub struct Lines<R> {
    input: R,
    /// The number of the last line, from 1.
    pub number: u64,
    /// The number of bytes that were read.
    pub bytes: u64,
    /// The number of empty lines that are next: those of several CR in a row that no LF follows.
    empty: u64,
}

impl<R: BufRead> Lines<R> {
    /// Begins a text.
    pub fn new(input: R) -> Self {
        Self { input, number: 0, bytes: 0, empty: 0 }
    }

    /// Appends the next line to `line`, without its end; false at the end of the text. A line that makes `line` longer than
    /// `most` bytes is not read to its end.
    ///
    /// # Errors
    /// Those of the input.
    pub fn append_next(&mut self, line: &mut Vec<u8>, most: usize) -> io::Result<bool> {
        if self.empty > 0 {
            self.empty -= 1;
            self.number += 1;
            return Ok(true);
        }
        let before = self.bytes;
        loop {
            let buffer = filled(&mut self.input)?;
            let end = buffer.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
            let length = end.unwrap_or(buffer.len());
            line.extend_from_slice(&buffer[..length]);
            let ends_in_cr = end.map(|end| buffer[end] == b'\r');
            let (used, is_over) = (length + usize::from(end.is_some()), buffer.is_empty());
            self.take(used);
            if ends_in_cr == Some(true) {
                self.rest_of_end()?;
            }
            if end.is_some() || line.len() > most || (is_over && self.bytes > before) {
                self.number += 1;
                return Ok(true);
            }
            if is_over {
                return Ok(false);
            }
        }
    }

    /// Takes what belongs to the end of a line behind a CR.
    fn rest_of_end(&mut self) -> io::Result<()> {
        let mut more = 0;
        loop {
            match filled(&mut self.input)?.first() {
                Some(b'\r') => more += 1,
                Some(b'\n') => {
                    self.take(1);
                    return Ok(());
                }
                _ => {
                    self.empty = more;
                    return Ok(());
                }
            }
            self.take(1);
        }
    }

    fn take(&mut self, bytes: usize) {
        self.input.consume(bytes);
        self.bytes += bytes as u64;
    }
}

/// Returns the bytes that can be read without waiting; none at the end.
fn filled<R: BufRead>(input: &mut R) -> io::Result<&[u8]> {
    loop {
        match input.fill_buf() {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            // Asked once more, because the borrow of a result that is returned would last for the whole loop.
            Ok(_) => return input.fill_buf(),
            Err(error) => return Err(error),
        }
    }
}

/// Returns the lines of a text without their ends, which are those of [`Lines`].
pub fn lines_of(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let (line, behind) = rest.split_at(rest.find(['\n', '\r']).unwrap_or(rest.len()));
        let without_cr = behind.trim_start_matches('\r');
        rest = without_cr.strip_prefix('\n').unwrap_or(behind.get(1..).unwrap_or_default());
        Some(line)
    })
}

/// Returns the number of ends of lines in a text.
pub fn line_ends(text: &str) -> usize {
    let bytes = text.as_bytes();
    let ends = |at: &usize| match bytes[*at] {
        b'\n' => true,
        b'\r' => bytes.get(at + 1) != Some(&b'\n'),
        _ => false,
    };
    (0..bytes.len()).filter(ends).count()
}

/// A problem and its remedy.
pub type Objection = (String, &'static str);

/// Returns the objection to a text in UTF-16 or UTF-32, judged by its first bytes, and the remedy.
pub fn not_utf16(text: &[u8]) -> Option<Objection> {
    // Without a byte order mark, most bytes of ASCII text in these are 0.
    let encoding = match text {
        [0xFF, 0xFE, 0, 0, ..] | [0, 0, 0xFE, 0xFF, ..] | [0, 0, 0, 1..=127, ..] | [1..=127, 0, 0, 0, ..] => {
            "UTF-32"
        }
        [0xFF, 0xFE, ..]
        | [0xFE, 0xFF, ..]
        | [0, 1..=127, 0, 1..=127, ..]
        | [1..=127, 0, 1..=127, 0, ..]
        | [0, 1..=127]
        | [1..=127, 0]
        | [0, 1..=127, 0]
        | [1..=127, 0, 1..=127] => "UTF-16",
        _ => return None,
    };
    Some((format!("it is text in {encoding}, expected UTF-8"), SAVE_AS_UTF8))
}

/// The encoding of names or texts that are not UTF-8, which nothing in them says: a guess.
#[derive(Debug, Clone, Copy)]
pub struct Guess(&'static Encoding);

impl Guess {
    /// Guesses the encoding of pieces of text.
    pub fn of<'a>(pieces: impl IntoIterator<Item = &'a [u8]>) -> Self {
        let mut detector = EncodingDetector::new(Iso2022JpDetection::Deny);
        for piece in pieces {
            detector.feed(piece, false);
            detector.feed(b"\n", false);
        }
        detector.feed(b"", true);
        Self(detector.guess(None, Utf8Detection::Deny))
    }

    /// Returns the name of the encoding for messages: `GBK`.
    pub fn name(self) -> &'static str {
        self.0.name()
    }

    /// Returns the text of bytes. What the guess cannot be the encoding of is taken for Windows' Western European one, in which
    /// each byte is a character.
    pub fn decode(self, bytes: &[u8]) -> String {
        let decoded = self.0.decode_without_bom_handling_and_without_replacement(bytes);
        decoded.unwrap_or_else(|| WINDOWS_1252.decode_without_bom_handling(bytes).0).into_owned()
    }
}

/// A text, and the guess at its encoding where it is not UTF-8.
type Decoded<'a> = (Cow<'a, str>, Option<Guess>);

/// Returns a text without its byte order mark, and the guess at its encoding where it is not UTF-8.
///
/// # Errors
/// The objection to UTF-16, and the remedy.
pub fn decoded(text: &[u8]) -> Result<Decoded<'_>, Objection> {
    if let Some(objection) = not_utf16(text) {
        return Err(objection);
    }
    let text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
    match std::str::from_utf8(text) {
        Ok(text) => Ok((text.into(), None)),
        Err(_) => {
            let guess = Guess::of([text]);
            Ok((guess.decode(text).into(), Some(guess)))
        }
    }
}

/// Returns true for what programs write where they could not compute a number: `nan`, `-inf`, `Infinity`, `nan(ind)`, and
/// `-1.#IND00`, `1.#QNAN`, `1.#INF` of Microsoft's runtime library.
pub fn is_no_number(word: &[u8]) -> bool {
    let word = word.to_ascii_lowercase();
    let word = word.strip_prefix(b"-").or_else(|| word.strip_prefix(b"+")).unwrap_or(&word);
    matches!(word, b"nan" | b"inf" | b"infinity") || word.starts_with(b"nan(") || word.starts_with(b"1.#")
}

#[cfg(test)]
mod tests {
    use std::io::BufReader;

    use proptest::prelude::*;

    use super::*;

    fn streamed(text: &[u8], buffer: usize) -> Vec<Vec<u8>> {
        let mut lines = Lines::new(BufReader::with_capacity(buffer, text));
        let mut all = Vec::new();
        let mut line = Vec::new();
        while lines.append_next(&mut line, 1000).unwrap() {
            all.push(std::mem::take(&mut line));
        }
        assert_eq!((lines.number, lines.bytes), (all.len() as u64, text.len() as u64));
        all
    }

    #[test]
    fn every_end_of_a_line_is_one() {
        let lines = |text: &str| lines_of(text).map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(lines("a\nb\r\nc\rd\r\r\ne\r\rf\n"), ["a", "b", "c", "d", "e", "", "f"]);
        assert_eq!(lines("a\n\n"), ["a", ""]);
        assert_eq!(lines("\r\n\rb"), ["", "", "b"]);
        assert!(lines("").is_empty());
    }

    #[test]
    fn a_line_that_is_too_long_is_not_read_to_its_end() {
        let text = [b'x'; 4000];
        let mut lines = Lines::new(BufReader::with_capacity(16, &text[..]));
        let mut line = Vec::new();
        assert!(lines.append_next(&mut line, 100).unwrap() && (101..200).contains(&line.len()));
    }

    #[test]
    fn the_encoding_is_guessed_and_different_bytes_stay_different() {
        let (text, guess) = decoded(b"\xef\xbb\xbfcaf\xc3\xa9").unwrap();
        assert!(text == "café" && guess.is_none());
        let (western, _, _) = WINDOWS_1252.encode("façade côté rivière, épi de faîtage");
        let (text, guess) = decoded(&western).unwrap();
        assert_eq!((&*text, guess.unwrap().name()), ("façade côté rivière, épi de faîtage", "windows-1252"));
        let (kana, _, _) = encoding_rs::SHIFT_JIS.encode("本堂の屋根、東側の壁、鐘楼");
        assert_eq!(decoded(&kana).unwrap().0, "本堂の屋根、東側の壁、鐘楼");
        let broken = Guess(encoding_rs::GBK);
        assert_ne!(broken.decode(b"\xff\xfe"), broken.decode(b"\xff\xfd"));
        assert!(decoded(b"\xff\xfea\0").unwrap_err().0.contains("UTF-16"));
        assert!(decoded(b"v\0 \x000\0").is_err() && decoded(b"\0\x9f\x92").is_ok());
    }

    #[test]
    fn what_stands_for_no_number_is_known_in_all_its_spellings() {
        for word in ["nan", "NaN", "-nan", "-nan(ind)", "inf", "+Inf", "-Infinity", "1.#QNAN0", "-1.#IND00"] {
            assert!(is_no_number(word.as_bytes()), "{word}");
        }
        assert!(!["1.0", "name", "info", "", "-", "1e999"].iter().any(|word| is_no_number(word.as_bytes())));
    }

    proptest! {
        #[test]
        fn lines_are_the_same_from_a_file_and_from_a_text(text in "[ab\n\r]{0,40}", buffer in 1..9usize) {
            let of_text: Vec<Vec<u8>> = lines_of(&text).map(|line| line.as_bytes().to_vec()).collect();
            prop_assert_eq!(streamed(text.as_bytes(), buffer), of_text);
        }
    }
}
