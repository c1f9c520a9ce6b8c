//! The words of a file, after what the C preprocessor does: comments, includes and macros.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::super::pictures::Folder;
use super::super::remedies::{FILE, Wrong};
use super::lexing::{Lexeme, lexeme};
use crate::MOST_LEVELS;
use quadratura_base::error::{Error, Result};
use quadratura_files::text::lines_of;

/// The largest size of all files of a plant together in bytes, counting each time that one is included.
const LARGEST: u64 = 1 << 30;
/// The most files that are included.
const MOST_INCLUDES: usize = 10_000;
/// The most words that macros are replaced by. Macros of macros double with each line of a file.
const MOST_REPLACED: usize = 1_000_000;

/// A line of a file.
#[derive(Debug, Clone)]
pub struct Place {
    /// The file, as messages call it.
    pub file: Arc<Path>,
    /// The line, from 1.
    pub line: usize,
}

impl Place {
    /// Makes the error of this line.
    pub fn wrong(&self, found: impl Into<Wrong>) -> Error {
        let Wrong { found, remedy } = found.into();
        Error::input(&*self.file, format!("line {}", self.line.max(1)), found, remedy)
    }
}

/// A word with its place.
#[derive(Debug, Clone)]
pub struct Word {
    /// The text, without quotation marks.
    pub text: String,
    /// Where it is; for a word of a macro, where the macro is used.
    pub place: Place,
}

/// A text that is being read: a file, or what a macro is replaced by.
pub(super) struct Frame {
    pub text: Arc<str>,
    /// The byte that is next.
    pub at: usize,
    /// True until something other than white space is met in the present line.
    pub is_line_start: bool,
    pub kind: Kind,
}

pub(super) enum Kind {
    /// A file: where it is on the disk, relative to the plant's folder, and the line that is being read.
    File { name: String, place: Place },
    /// A macro.
    Macro(String),
}

/// An `#ifdef` that is open.
pub(super) struct Condition {
    /// True where its present branch is read.
    pub is_met: bool,
    /// True in the branch after `#else`.
    pub has_else: bool,
    pub place: Place,
    /// The number of texts that were being read.
    pub frames: usize,
}

/// The texts of a plant, one inside the other.
pub struct Source<'a> {
    pub(super) folder: &'a mut Folder,
    pub(super) frames: Vec<Frame>,
    pub(super) conditions: Vec<Condition>,
    pub(super) macros: FxHashMap<String, Arc<str>>,
    /// The number of parentheses that are open: signs are words of their own within.
    depth: usize,
    bytes: u64,
    includes: usize,
    replaced: usize,
}

impl<'a> Source<'a> {
    /// Opens the file of a plant.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Input`] for one that is too large.
    pub fn open(path: &Path, folder: &'a mut Folder) -> Result<Self> {
        let mut source = Self {
            folder,
            frames: Vec::new(),
            conditions: Vec::new(),
            macros: FxHashMap::default(),
            depth: 0,
            bytes: 0,
            includes: 0,
            replaced: 0,
        };
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        source.push_file(path, name)?;
        Ok(source)
    }

    fn push_file(&mut self, path: &Path, name: String) -> Result<()> {
        let bytes = fs::metadata(path).map_err(Error::io(path, "read it"))?.len();
        self.bytes = self.bytes.saturating_add(bytes);
        if self.bytes > LARGEST {
            let found = format!("{} bytes with all that is included, at most {LARGEST} are read", self.bytes);
            return Err(Error::input(path, "", found, "include less"));
        }
        let bytes = fs::read(path).map_err(Error::io(path, "read it"))?;
        // Comments of that time are in all kinds of encodings.
        let text = self.folder.decoded(path, &bytes)?;
        let text = lines_of(&text).collect::<Vec<_>>().join("\n").into();
        let kind = Kind::File { name, place: Place { file: path.into(), line: 1 } };
        self.frames.push(Frame { text, at: 0, is_line_start: true, kind });
        Ok(())
    }

    /// Returns where reading is.
    pub(super) fn place(&self) -> Place {
        let place = |frame: &Frame| match &frame.kind {
            Kind::File { place, .. } => Some(place.clone()),
            Kind::Macro(_) => None,
        };
        self.frames.iter().rev().find_map(place).expect("the first text is a file")
    }

    /// Takes the next word; `None` at the end of the file that was opened.
    ///
    /// # Errors
    /// [`Error::Input`] with file and line, for what the preprocessor refuses.
    pub fn next(&mut self) -> Result<Option<Word>> {
        while let Some(frame) = self.frames.last_mut() {
            let is_skipped = self.conditions.last().is_some_and(|condition| !condition.is_met);
            match lexeme(frame, self.depth > 0, is_skipped) {
                Lexeme::End => {
                    if self.end_of_text()? {
                        return Ok(None);
                    }
                }
                Lexeme::OpenComment(place) => return Err(place.wrong("a comment `/*` without `*/`")),
                Lexeme::Directive(text) => self.directive(&text)?,
                Lexeme::Quoted(text) => {
                    let place = self.place();
                    return Ok(Some(Word { text, place }));
                }
                Lexeme::Word(text) => {
                    if self.replace(&text)? {
                        continue;
                    }
                    match text.as_str() {
                        "(" => self.depth += 1,
                        ")" => self.depth = self.depth.saturating_sub(1),
                        _ => {}
                    }
                    let place = self.place();
                    return Ok(Some(Word { text, place }));
                }
            }
        }
        Ok(None)
    }

    /// Leaves a text that has ended. Returns true for the first one, which stays for messages.
    fn end_of_text(&mut self) -> Result<bool> {
        if let Some(open) = self.conditions.last()
            && open.frames == self.frames.len()
        {
            return Err(open.place.wrong("`#ifdef` or `#ifndef` without `#endif`"));
        }
        if self.frames.len() == 1 {
            return Ok(true);
        }
        self.frames.pop();
        Ok(false)
    }

    /// Begins the text of a macro, where a word is one. A macro within itself is left as it is, as in C.
    fn replace(&mut self, word: &str) -> Result<bool> {
        let is_macro = matches!(self.frames.last(), Some(Frame { kind: Kind::Macro(_), .. }));
        let name = word.strip_prefix('-').unwrap_or(word);
        let body = self.macros.get(name);
        if is_macro || body.is_some() {
            self.replaced += 1;
        }
        if self.replaced > MOST_REPLACED {
            let found = format!("macros that are replaced by more than {MOST_REPLACED} words");
            return Err(self.place().wrong(found));
        }
        let is_within = |frame: &Frame| matches!(&frame.kind, Kind::Macro(within) if within == name);
        let Some(body) = body.filter(|_| !self.frames.iter().any(is_within)) else {
            return Ok(false);
        };
        let text = if name == word { body.clone() } else { format!("-{body}").into() };
        if self.frames.len() > MOST_LEVELS {
            return Err(self.place().wrong(format!("macros within macros, more than {MOST_LEVELS} deep")));
        }
        let kind = Kind::Macro(name.to_owned());
        self.frames.push(Frame { text, at: 0, is_line_start: false, kind });
        Ok(true)
    }

    /// `#include`: reads another file of the plant's folder here.
    pub(super) fn include(&mut self, name: &str) -> Result<()> {
        let place = self.place();
        let wrong = |found: Wrong| place.wrong(found);
        let beside = self.frames.last().and_then(|frame| match &frame.kind {
            Kind::File { name, .. } => name.rsplit_once('/').map(|(folder, _)| folder.to_owned()),
            Kind::Macro(_) => None,
        });
        let names = beside.map(|folder| format!("{folder}/{name}")).into_iter().chain([name.to_owned()]);
        let mut found = None;
        for inside in names {
            let file = self.folder.file(&inside);
            let file = file.ok_or_else(|| {
                wrong((format!("`#include` of {name:?}, outside of the plant's folder"), FILE).into())
            })?;
            if file.is_file() {
                found = Some((inside, file));
                break;
            }
        }
        let (inside, file) = found.ok_or_else(|| {
            wrong((format!("`#include` of {name:?}, which is not in the folder"), FILE).into())
        })?;
        let open: Vec<&str> = self.frames.iter().filter_map(Frame::file_name).collect();
        if let Some(first) = open.iter().position(|open| *open == inside) {
            let way: Vec<String> =
                open[first..].iter().chain([&&*inside]).map(|name| format!("{name:?}")).collect();
            return Err(wrong(format!("a file includes itself: {}", way.join(" includes ")).into()));
        }
        self.includes += 1;
        if open.len() > MOST_LEVELS || self.includes > MOST_INCLUDES {
            let found = format!("more than {MOST_INCLUDES} files, or files more than {MOST_LEVELS} deep");
            return Err(wrong(format!("`#include` of {found}").into()));
        }
        self.push_file(&file, inside)
    }
}

impl Frame {
    fn file_name(&self) -> Option<&str> {
        match &self.kind {
            Kind::File { name, .. } => Some(name),
            Kind::Macro(_) => None,
        }
    }
}
