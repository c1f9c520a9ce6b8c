//! The statements of a file: surfaces, numbers, and what is placed or defined.

use rustc_hash::FxHashMap;

use super::super::notes::Notes;
use super::super::tokens::quoted;
use super::keywords::{begins_statement, passed_over};
use super::objects::{Object, ObjectId};
use super::surfaces::{SurfaceId, Surfaces};
use super::textures::Pictures;
use super::words::Words;
use quadratura_base::error::Result;
use quadratura_base::task::Task;

/// The reader of a plant.
pub struct Statements<'a> {
    pub(super) words: Words<'a>,
    pub(super) surfaces: Surfaces,
    pub(super) pictures: Pictures,
    /// The objects that are finished.
    pub(super) objects: Vec<Object>,
    pub(super) named: FxHashMap<String, ObjectId>,
    /// The sphere that all spheres are.
    pub(super) sphere: Option<ObjectId>,
    /// The surface of `applysurf` in the present list.
    pub(super) current: Option<SurfaceId>,
    pub(super) notes: Notes,
    pub(super) corners: u64,
    pub(super) uses: usize,
    task: &'a Task,
}

impl<'a> Statements<'a> {
    /// Begins a plant.
    pub fn new(words: Words<'a>, task: &'a Task) -> Self {
        Self {
            words,
            surfaces: Surfaces::default(),
            pictures: Pictures::default(),
            objects: Vec::new(),
            named: FxHashMap::default(),
            sphere: None,
            current: None,
            notes: Notes::default(),
            corners: 0,
            uses: 0,
            task,
        }
    }

    /// Reads the file, whose objects outside of definitions make the one that is returned.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] with file and line; [`quadratura_base::Error::Cancelled`].
    pub fn read(&mut self, name: String) -> Result<Object> {
        let mut root = Object::new(name);
        while let Some(word) = self.words.next()? {
            if word == "end" {
                return Err(self.words.wrong("`end` without a list before it"));
            }
            self.statement(&word, &mut root, 0)?;
        }
        if root.is_empty() {
            self.note("nothing is placed outside of definitions, so that the plant is empty; `object NAME` places one");
        }
        Ok(root)
    }

    /// Reads a statement that stands in a file or in a list, which is `depth` lists deep.
    pub(super) fn statement(&mut self, word: &str, into: &mut Object, depth: usize) -> Result<()> {
        self.task.go_on()?;
        match word {
            "surface" => self.surface(),
            "applysurf" => self.applysurf(),
            "define" => self.words.define(),
            "name" => self.name(depth),
            _ => match self.instance(word, depth)? {
                Some(instance) => self.place(instance, into),
                None => self.pass_over(word),
            },
        }
    }

    /// Passes over a statement that has no effect, and notes one that is unknown.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] with file and line.
    fn pass_over(&mut self, word: &str) -> Result<()> {
        match passed_over(word) {
            Some(true) => drop(self.words.next()?),
            Some(false) => {}
            None => {
                let place = self.words.place();
                let place = format!("{}, line {}, {}", place.file.display(), place.line, quoted(word));
                self.notes.add("an unknown statement is left out", || place);
            }
        }
        while self.words.peek(0)?.is_some_and(|word| !begins_statement(word)) {
            self.words.next()?;
        }
        Ok(())
    }

    /// Notes something at the word that was taken last.
    pub(super) fn note(&mut self, what: &'static str) {
        let place = self.words.place();
        self.notes.add(what, || format!("{}, line {}", place.file.display(), place.line));
    }
}
