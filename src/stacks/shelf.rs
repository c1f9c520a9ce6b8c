//! What is prepared of each photo for a computation over the whole site: as many as fit into the memory stay there, those that were
//! used last; the others wait in a file.

use std::path::Path;
use std::sync::{Arc, Mutex};

use serde::Serialize;
use serde::de::DeserializeOwned;

use quadratura_base::error::Result;
use quadratura_files::scratch::{Scratch, ScratchPlace};

/// What can be put on a shelf.
pub(super) trait Shelved: Serialize + DeserializeOwned + Clone + Send + Sync {
    /// Returns the memory that it takes, in bytes.
    fn bytes(&self) -> u64;
}

/// Prepared values by number.
pub(super) struct Shelf<T> {
    memory: u64,
    scratch: Scratch,
    state: Mutex<ShelfState<T>>,
}

struct ShelfState<T> {
    entries: Vec<Entry<T>>,
    /// The bytes in memory, and how often something was asked for.
    held: u64,
    now: u64,
}

/// One value. It is in memory, in the file, in both, or there is none.
struct Entry<T> {
    here: Option<Arc<T>>,
    bytes: u64,
    used: u64,
    place: Option<ScratchPlace>,
    /// Whether the file has the value as it is now.
    is_written: bool,
}

impl<T: Shelved> Shelf<T> {
    /// Makes a shelf for so many values, none of which is there. `memory` is what may stay in memory, in bytes; the file is made in
    /// `folder`.
    pub fn new(count: usize, memory: u64, folder: &Path) -> Self {
        let none = || Entry { here: None, bytes: 0, used: 0, place: None, is_written: false };
        let entries = std::iter::repeat_with(none).take(count).collect();
        let state = Mutex::new(ShelfState { entries, held: 0, now: 0 });
        Self { memory, scratch: Scratch::new(folder), state }
    }

    /// Puts a value in the place of the one with this number.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Io`] where others cannot make way.
    pub fn put(&self, number: usize, value: T) -> Result<()> {
        let mut state = self.state.lock().expect("no holder of this lock panics");
        state.entries[number].is_written = false;
        state.hold(number, Arc::new(value));
        self.make_way(&mut state)
    }

    /// Returns a value; `None` where none was put.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Io`].
    pub fn get(&self, number: usize) -> Result<Option<Arc<T>>> {
        let mut state = self.state.lock().expect("no holder of this lock panics");
        state.now += 1;
        let now = state.now;
        let entry = &mut state.entries[number];
        entry.used = now;
        if entry.here.is_some() {
            return Ok(entry.here.clone());
        }
        let Some(place) = entry.place else { return Ok(None) };
        let value: Arc<T> = Arc::new(self.scratch.read(place)?);
        state.hold(number, value.clone());
        self.make_way(&mut state)?;
        Ok(Some(value))
    }

    /// Changes a value, if there is one.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Io`].
    pub fn change(&self, number: usize, change: impl FnOnce(&mut T)) -> Result<()> {
        let Some(mut value) = self.get(number)? else { return Ok(()) };
        // What was read is not kept twice while it is changed.
        self.state.lock().expect("no holder of this lock panics").release(number);
        change(Arc::make_mut(&mut value));
        let mut state = self.state.lock().expect("no holder of this lock panics");
        state.entries[number].is_written = false;
        state.hold(number, value);
        self.make_way(&mut state)
    }

    /// Writes the values that were not used for the longest time, until the others fit into the memory.
    fn make_way(&self, state: &mut ShelfState<T>) -> Result<()> {
        while state.held > self.memory {
            let held = state.entries.iter().enumerate().filter(|(_, entry)| entry.here.is_some());
            let Some((number, _)) = held.min_by_key(|(_, entry)| entry.used) else { break };
            let entry = &mut state.entries[number];
            if let Some(value) = entry.here.as_ref().filter(|_| !entry.is_written) {
                entry.place = Some(self.scratch.write(&**value, entry.place)?);
                entry.is_written = true;
            }
            state.release(number);
        }
        Ok(())
    }
}

impl<T: Shelved> ShelfState<T> {
    fn hold(&mut self, number: usize, value: Arc<T>) {
        self.release(number);
        self.now += 1;
        let (bytes, used) = (value.bytes(), self.now);
        self.held += bytes;
        let entry = &mut self.entries[number];
        (entry.here, entry.bytes, entry.used) = (Some(value), bytes, used);
    }

    fn release(&mut self, number: usize) {
        let entry = &mut self.entries[number];
        if entry.here.take().is_some() {
            self.held -= entry.bytes;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Shelved for Vec<u8> {
        fn bytes(&self) -> u64 {
            self.len() as u64
        }
    }

    #[test]
    fn what_does_not_fit_comes_back_as_it_was_changed_last() {
        let folder = tempfile::tempdir().unwrap();
        for memory in [0, 10, 25, 1000] {
            let shelf = Shelf::new(9, memory, folder.path());
            (0..8).for_each(|number| shelf.put(number, vec![number as u8; 5]).unwrap());
            for number in (0..8).rev() {
                shelf.change(number, |value| value.push(100 + number as u8)).unwrap();
            }
            shelf.put(3, vec![1]).unwrap();
            assert!(shelf.state.lock().unwrap().held <= memory);
            for number in [0, 7, 2, 2, 5] {
                let mut expected = vec![number as u8; 5];
                expected.push(100 + number as u8);
                assert_eq!(*shelf.get(number).unwrap().unwrap(), expected);
            }
            assert_eq!(*shelf.get(3).unwrap().unwrap(), [1]);
            assert_eq!(shelf.get(8).unwrap(), None);
            shelf.change(8, |_| panic!("there is none")).unwrap();
            assert!(shelf.state.lock().unwrap().held <= memory);
        }
    }
}
