//! The words of a file of the keyword format, with their lines.

use std::path::{Path, PathBuf};

use super::remedies::{COMPLETE, NUMBER, Wrong};
use quadratura_base::error::{Error, Result};
use quadratura_files::text::lines_of;

/// Numbers beyond this are refused.
pub const LARGEST_NUMBER: f64 = 1e15;

/// The words of a text. A word that begins with `#` begins a comment to the end of its line; braces are words of their own.
pub struct Tokens<'a> {
    file: PathBuf,
    /// What is left of the present line.
    rest: &'a str,
    lines: Box<dyn Iterator<Item = &'a str> + 'a>,
    /// The present line, from 1.
    pub line: usize,
}

impl<'a> Tokens<'a> {
    /// Begins a text of a file.
    pub fn new(file: &Path, text: &'a str) -> Self {
        Self { file: file.to_path_buf(), rest: "", lines: Box::new(lines_of(text)), line: 0 }
    }

    /// Returns the file.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Goes to the next word, if there is one.
    fn advance(&mut self) -> Option<()> {
        loop {
            self.rest = self.rest.trim_start();
            if !self.rest.is_empty() && !self.rest.starts_with('#') {
                return Some(());
            }
            self.rest = self.lines.next()?;
            self.line += 1;
        }
    }

    /// Returns the next word without taking it; `None` at the end of the text.
    pub fn peek(&mut self) -> Option<&'a str> {
        self.advance()?;
        if self.rest.starts_with(['{', '}']) {
            return Some(&self.rest[..1]);
        }
        let end = self.rest.find(|c: char| c.is_whitespace() || matches!(c, '{' | '}'));
        Some(&self.rest[..end.unwrap_or(self.rest.len())])
    }

    /// Takes the next word; `None` at the end of the text.
    pub fn next(&mut self) -> Option<&'a str> {
        let word = self.peek()?;
        self.rest = &self.rest[word.len()..];
        Some(word)
    }

    /// Makes the error of the present line.
    pub fn wrong(&self, found: impl Into<Wrong>) -> Error {
        self.wrong_in(self.line, found)
    }

    /// Makes the error of a line.
    pub fn wrong_in(&self, line: usize, found: impl Into<Wrong>) -> Error {
        let Wrong { found, remedy } = found.into();
        Error::input(&self.file, format!("line {}", line.max(1)), found, remedy)
    }

    /// Takes a word that is needed.
    ///
    /// # Errors
    /// [`Error::Input`] at the end of the text.
    pub fn word(&mut self, what: &str) -> Result<&'a str> {
        self.next().ok_or_else(|| self.wrong((format!("the file ends; expected {what}"), COMPLETE)))
    }

    /// Takes a number.
    ///
    /// # Errors
    /// [`Error::Input`] where the next word is none, is not finite, or is beyond [`LARGEST_NUMBER`].
    pub fn number(&mut self, what: &str) -> Result<f64> {
        let word = self.word(what)?;
        let number = word.parse::<f64>();
        let number = number
            .map_err(|_| self.wrong((format!("{}, expected {what}: a number", quoted(word)), NUMBER)))?;
        if !number.is_finite() || number.abs() > LARGEST_NUMBER {
            let found = format!("{}, expected {what}: a finite number up to 1e15", quoted(word));
            return Err(self.wrong((found, NUMBER)));
        }
        Ok(number)
    }

    /// Takes several numbers.
    ///
    /// # Errors
    /// Those of [`Self::number`], counting from 1.
    pub fn numbers<const N: usize>(&mut self, what: &str) -> Result<[f64; N]> {
        let mut numbers = [0.0; N];
        for (index, number) in numbers.iter_mut().enumerate() {
            *number = self.number(&format!("number {} of {N} of {what}", index + 1))?;
        }
        Ok(numbers)
    }

    /// Takes a whole number within a range.
    ///
    /// # Errors
    /// [`Error::Input`] where the next word is none.
    pub fn count(&mut self, what: &str, [low, high]: [u32; 2]) -> Result<u32> {
        let expected = format!("{what}: a whole number from {low} to {high}");
        let word = self.word(&expected)?;
        let count = word.parse().ok().filter(|count| (low..=high).contains(count));
        count.ok_or_else(|| self.wrong((format!("{}, expected {expected}", quoted(word)), NUMBER)))
    }

    /// Takes linear light or an alpha: numbers from 0 to 1.
    ///
    /// # Errors
    /// [`Error::Input`] where a word is none.
    pub fn shares<const N: usize>(&mut self, what: &str) -> Result<[f32; N]> {
        let numbers = self.numbers::<N>(what)?;
        match numbers.iter().find(|number| !(0.0..=1.0).contains(*number)) {
            Some(number) => {
                Err(self.wrong((format!("{number} in {what}, expected numbers from 0 to 1"), NUMBER)))
            }
            None => Ok(numbers.map(|number| number as f32)),
        }
    }
}

/// The longest part of a word that a message repeats, in characters.
const LONGEST_QUOTE: usize = 40;

/// Returns a word for a message.
pub fn quoted(word: &str) -> String {
    let more = if word.chars().count() > LONGEST_QUOTE { "..." } else { "" };
    format!("{:?}{more}", word.chars().take(LONGEST_QUOTE).collect::<String>())
}
