//! The names of objects: told apart by their bytes, and shown as text.

use std::collections::BTreeSet;

use rustc_hash::FxHashMap;

use quadratura_base::scene::builder::not_reserved;
use quadratura_base::scene::{ModelBuilder, ObjectId};
use quadratura_files::text::Guess;

/// The names of a file, in the order in which objects began.
#[derive(Default)]
pub(super) struct ObjectNames {
    ids: FxHashMap<Vec<u8>, ObjectId>,
    names: Vec<Vec<u8>>,
}

impl ObjectNames {
    /// Returns the object of a name, which is added if it is new. Until [`Self::show`] it has a number for its name.
    pub fn object(&mut self, name: Vec<u8>, builder: &mut ModelBuilder) -> ObjectId {
        if let Some(&known) = self.ids.get(&name) {
            return known;
        }
        let id = builder.object(&self.names.len().to_string());
        self.names.push(name.clone());
        self.ids.insert(name, id);
        id
    }

    /// Names the objects: as they are called where that is UTF-8, and else in the encoding that all other names of the file
    /// seem to have. A name that another object has already gets a number. Returns notes about both.
    pub fn show(&self, builder: &mut ModelBuilder) -> Vec<String> {
        let foreign: Vec<&[u8]> =
            self.names.iter().map(Vec::as_slice).filter(|name| std::str::from_utf8(name).is_err()).collect();
        let guess = Guess::of(foreign.iter().copied());
        let text = |name: &Vec<u8>| match std::str::from_utf8(name) {
            Ok(name) => name.to_owned(),
            Err(_) => guess.decode(name),
        };
        // White space within a name counts as one space, unless names differ in nothing else.
        let words = |name: String| {
            name.split([' ', '\t', '\x0b', '\x0c'])
                .filter(|word| !word.is_empty())
                .collect::<Vec<_>>()
                .join(" ")
        };
        let shown: Vec<String> = self.names.iter().map(|name| words(text(name))).collect();
        let is_exact = |index: &usize| shown[*index].as_bytes() == self.names[*index];
        let (exact, others): (Vec<usize>, Vec<usize>) = (0..shown.len()).partition(is_exact);
        let mut taken: BTreeSet<String> = BTreeSet::new();
        let mut unique = vec![String::new(); shown.len()];
        for index in exact.into_iter().chain(others) {
            let name = not_reserved(&shown[index]);
            let numbered = (2..).map(|number| format!("{name} ({number})"));
            let mut names = std::iter::once(name.to_owned()).chain(numbered);
            unique[index] =
                names.find(|name| !taken.contains(name)).expect("there are more numbers than objects");
            taken.insert(unique[index].clone());
        }
        let numbered: Vec<usize> = (0..shown.len()).filter(|index| unique[*index] != shown[*index]).collect();
        let mut notes = Vec::new();
        if let Some(first) = foreign.first().map(|name| guess.decode(name)) {
            let (count, all, guess) = (foreign.len(), self.names.len(), guess.name());
            notes.push(format!(
                "{count} of {all} names of objects are not UTF-8: they are shown as {guess}, which is a guess, such as {first:?}"
            ));
        }
        if let Some(first) = numbered.first().map(|index| &unique[*index]) {
            let count = numbered.len();
            notes.push(format!(
                "{count} objects look like others by name: they are numbered, such as {first:?}"
            ));
        }
        builder.name_objects(unique);
        notes
    }
}
