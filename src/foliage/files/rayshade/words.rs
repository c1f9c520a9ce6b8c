//! Words, numbers and points, with the errors of their lines.

use std::collections::VecDeque;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::super::pictures::Folder;
use super::super::remedies::{COMPLETE, NUMBER, Wrong};
use super::super::tokens::{LARGEST_NUMBER, quoted};
use super::source::{Place, Source, Word};
use quadratura_base::error::{Error, Result};

/// The words of a plant, some of which are known before they are taken.
pub struct Words<'a> {
    source: Source<'a>,
    ahead: VecDeque<Word>,
    /// Where the word is that was taken last.
    place: Place,
    /// The values of `define`.
    pub(super) values: FxHashMap<String, f64>,
}

impl<'a> Words<'a> {
    /// Begins a source.
    pub fn new(source: Source<'a>) -> Self {
        let place = source.place();
        Self { source, ahead: VecDeque::new(), place, values: FxHashMap::default() }
    }

    /// Returns the folder of the plant.
    pub fn folder(&mut self) -> &mut Folder {
        self.source.folder
    }

    /// Returns a word that is not taken yet, counting from 0; `None` beyond the end.
    ///
    /// # Errors
    /// Those of [`Source::next`].
    pub fn peek(&mut self, index: usize) -> Result<Option<&str>> {
        while self.ahead.len() <= index {
            match self.source.next()? {
                Some(word) => self.ahead.push_back(word),
                None => return Ok(None),
            }
        }
        Ok(Some(&self.ahead[index].text))
    }

    /// Takes the next word; `None` at the end.
    ///
    /// # Errors
    /// Those of [`Source::next`].
    pub fn next(&mut self) -> Result<Option<String>> {
        self.peek(0)?;
        let Some(Word { text, place }) = self.ahead.pop_front() else { return Ok(None) };
        self.place = place;
        Ok(Some(text))
    }

    /// Takes the next word where it is this one.
    ///
    /// # Errors
    /// Those of [`Source::next`].
    pub fn take(&mut self, word: &str) -> Result<bool> {
        let is_next = self.peek(0)? == Some(word);
        if is_next {
            self.next()?;
        }
        Ok(is_next)
    }

    /// Takes a word that is needed.
    ///
    /// # Errors
    /// [`Error::Input`] at the end.
    pub fn word(&mut self, what: &str) -> Result<String> {
        let word = self.next()?;
        word.ok_or_else(|| self.wrong((format!("the file ends; expected {what}"), COMPLETE)))
    }

    /// Returns where the word is that was taken last.
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// Makes the error of the line of the word that was taken last.
    pub fn wrong(&self, found: impl Into<Wrong>) -> Error {
        self.place.wrong(found)
    }

    /// Returns true where the next word begins a number.
    ///
    /// # Errors
    /// Those of [`Source::next`].
    pub fn is_number(&mut self) -> Result<bool> {
        Ok(self.peek(0)?.is_some_and(begins_number))
    }

    /// Takes a number, or an expression in parentheses.
    ///
    /// # Errors
    /// [`Error::Input`] where there is none, or one that is not finite or beyond [`LARGEST_NUMBER`].
    pub fn number(&mut self, what: &str) -> Result<f64> {
        let word = self.word(what)?;
        let number = match word.as_str() {
            "(" => self.expression()?,
            "-" if self.take("(")? => -self.expression()?,
            _ => {
                let number = word.parse().ok().filter(|_| begins_number(&word));
                let found =
                    || format!("{}, expected {what}: a number, or an expression in ( )", quoted(&word));
                number.ok_or_else(|| self.wrong((found(), NUMBER)))?
            }
        };
        if !number.is_finite() || number.abs() > LARGEST_NUMBER {
            let found = format!("{number}, expected {what}: a finite number up to 1e15");
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

    /// Takes a point or a direction.
    ///
    /// # Errors
    /// Those of [`Self::number`].
    pub fn point(&mut self, what: &str) -> Result<DVec3> {
        self.numbers(what).map(DVec3::from_array)
    }

    /// Takes numbers up to the next word that is none.
    ///
    /// # Errors
    /// Those of [`Self::number`], and for more than `most` numbers.
    pub fn all_numbers(&mut self, what: &str, most: usize) -> Result<Vec<f64>> {
        let mut numbers = Vec::new();
        while self.is_number()? {
            numbers.push(self.number(what)?);
            if numbers.len() > most {
                return Err(self.wrong(format!("more than {most} numbers in {what}")));
            }
        }
        Ok(numbers)
    }
}

/// Returns true for numbers, and for the parenthesis before an expression; names begin with a letter.
fn begins_number(word: &str) -> bool {
    let digits = word.strip_prefix(['+', '-']).unwrap_or(word);
    let digits = digits.strip_prefix('.').unwrap_or(digits);
    digits.starts_with(|c: char| c.is_ascii_digit()) || matches!(word, "(" | "-")
}
