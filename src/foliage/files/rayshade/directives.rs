//! The lines of the preprocessor: `# 12 "file"`, `#include`, `#define` and `#ifdef`.

use std::path::Path;

use super::super::tokens::quoted;
use super::source::{Condition, Frame, Kind, Source};
use quadratura_base::error::Result;

impl Source<'_> {
    /// Obeys a line that began with `#`.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] with file and line.
    pub(super) fn directive(&mut self, line: &str) -> Result<()> {
        let (name, rest) = split(line);
        match name {
            "ifdef" | "ifndef" | "else" | "endif" | "if" | "elif" => return self.condition(name, rest),
            _ if self.conditions.last().is_some_and(|condition| !condition.is_met) => {}
            "include" => {
                let Some(file) = included(rest) else {
                    let found = format!("`#include` of {}, expected \"FILE\" or <FILE>", quoted(rest));
                    return Err(self.place().wrong(found));
                };
                self.include(file)?;
            }
            "define" => self.define(rest)?,
            "undef" => drop(self.macros.remove(split(rest).0)),
            "line" => self.mark(rest),
            "" | "pragma" | "ident" => {}
            _ if name.bytes().all(|byte| byte.is_ascii_digit()) => self.mark(line),
            _ => {
                let found = format!(
                    "`#{}`, expected include, define, undef, ifdef, ifndef, else, endif or a line number; preprocess the \
                     file with cpp",
                    name.chars().take(40).collect::<String>()
                );
                return Err(self.place().wrong(found));
            }
        }
        Ok(())
    }

    fn define(&mut self, rest: &str) -> Result<()> {
        let is_part = |c: char| c.is_alphanumeric() || c == '_';
        let end = rest.find(|c: char| !is_part(c)).unwrap_or(rest.len());
        let (name, body) = rest.split_at(end);
        if name.is_empty() || name.starts_with(|c: char| c.is_ascii_digit()) {
            let found = format!("`#define` of {}, expected a name", quoted(rest));
            return Err(self.place().wrong(found));
        }
        if body.starts_with('(') {
            let found = format!("`#define {name}(...)`, expected a macro without arguments");
            return Err(self.place().wrong(found + "; preprocess the file with cpp"));
        }
        self.macros.insert(name.to_owned(), body.trim().into());
        Ok(())
    }

    /// `# 12 "file"`: the next line is line 12 of that file, for messages.
    fn mark(&mut self, rest: &str) {
        let (number, file) = split(rest);
        let Some(Frame { kind: Kind::File { place, .. }, .. }) = self.frames.last_mut() else { return };
        if let Ok(line) = number.parse::<u32>() {
            place.line = (line as usize).saturating_sub(1);
        }
        if let Some(file) = included(file).filter(|file| !file.is_empty()) {
            place.file = Path::new(file).into();
        }
    }

    fn condition(&mut self, name: &str, rest: &str) -> Result<()> {
        let place = self.place();
        let is_read = self.conditions.last().is_none_or(|outer| outer.is_met);
        match name {
            "ifdef" | "ifndef" => {
                let is_defined = self.macros.contains_key(split(rest).0);
                // Inside of what is skipped everything is.
                let is_met = is_read && is_defined == (name == "ifdef");
                let frames = self.frames.len();
                self.conditions.push(Condition { is_met, has_else: !is_read, place, frames });
            }
            "if" | "elif" if is_read || name == "elif" => {
                return Err(
                    place.wrong(format!("`#{name}`, which is not read; preprocess the file with cpp"))
                );
            }
            "if" => {
                let frames = self.frames.len();
                self.conditions.push(Condition { is_met: false, has_else: true, place, frames });
            }
            _ => {
                let frames = self.frames.len();
                let Some(open) = self.conditions.last_mut().filter(|open| open.frames == frames) else {
                    return Err(place.wrong(format!("`#{name}` without `#ifdef` or `#ifndef` before it")));
                };
                if name == "endif" {
                    self.conditions.pop();
                } else if !open.has_else {
                    (open.is_met, open.has_else) = (!open.is_met, true);
                } else {
                    open.is_met = false;
                }
            }
        }
        Ok(())
    }
}

/// Returns the first word of a line and the rest.
fn split(line: &str) -> (&str, &str) {
    let line = line.trim();
    let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    (word, rest.trim())
}

/// Returns the name between quotation marks or angle brackets.
fn included(text: &str) -> Option<&str> {
    let quoted = text.strip_prefix('"').and_then(|rest| rest.split_once('"'));
    let quoted = quoted.or_else(|| text.strip_prefix('<').and_then(|rest| rest.split_once('>')));
    quoted.map(|(name, _)| name)
}
