//! Values that wait outside of memory, in a file without a name: it is gone with the program, however that ends.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::cached::{from_bytes, to_bytes};
use quadratura_base::error::{Error, Result};

/// A file for values, which is made when the first one is written.
pub struct Scratch {
    /// The folder that the file is in, for messages.
    folder: PathBuf,
    opened: Mutex<Option<OpenedFile>>,
}

struct OpenedFile {
    file: File,
    /// The number of bytes that are taken.
    end: u64,
}

/// Where a value is in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ScratchPlace {
    /// The offset in bytes.
    at: u64,
    /// The bytes that belong to the place, and those of them that the value takes.
    room: u64,
    length: u64,
}

impl Scratch {
    /// Makes an empty one in `folder`, or in the system's folder for such files where that cannot be written to.
    pub fn new(folder: &Path) -> Self {
        Self { folder: folder.to_owned(), opened: Mutex::default() }
    }

    /// Writes a value, in the place of a former one if it fits there, and returns where it is.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn write(&self, value: &impl Serialize, former: Option<ScratchPlace>) -> Result<ScratchPlace> {
        let bytes = to_bytes(value);
        let length = bytes.len() as u64;
        self.with_file(|opened| {
            let place = match former.filter(|former| former.room >= length) {
                Some(former) => ScratchPlace { length, ..former },
                None => ScratchPlace { at: opened.end, room: length, length },
            };
            opened.file.seek(SeekFrom::Start(place.at))?;
            opened.file.write_all(&bytes)?;
            opened.end = opened.end.max(place.at + length);
            Ok(place)
        })
        .map_err(Error::io(&self.folder, "write what does not fit into memory"))
    }

    /// Reads the value at a place.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn read<T: DeserializeOwned>(&self, place: ScratchPlace) -> Result<T> {
        let read = |opened: &mut OpenedFile| {
            let mut bytes = vec![0; place.length as usize];
            opened.file.seek(SeekFrom::Start(place.at))?;
            opened.file.read_exact(&mut bytes)?;
            from_bytes(&bytes).ok_or_else(|| std::io::ErrorKind::InvalidData.into())
        };
        self.with_file(read).map_err(Error::io(&self.folder, "read back what did not fit into memory"))
    }

    fn with_file<T>(&self, work: impl FnOnce(&mut OpenedFile) -> std::io::Result<T>) -> std::io::Result<T> {
        let mut opened = self.opened.lock().expect("no holder of this lock panics");
        if opened.is_none() {
            let file =
                std::fs::create_dir_all(&self.folder).and_then(|()| tempfile::tempfile_in(&self.folder));
            *opened = Some(OpenedFile { file: file.or_else(|_| tempfile::tempfile())?, end: 0 });
        }
        work(opened.as_mut().expect("it was opened just now"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_come_back_whole_and_take_the_place_of_former_ones_where_they_fit() {
        let folder = tempfile::tempdir().unwrap();
        let scratch = Scratch::new(&folder.path().join("cache"));
        let values: Vec<Vec<f32>> = vec![vec![0.1, f32::MIN_POSITIVE, -0.0], vec![7.5; 9], Vec::new()];
        let places: Vec<ScratchPlace> =
            values.iter().map(|value| scratch.write(value, None).unwrap()).collect();
        let shorter = scratch.write(&vec![2.5f32], Some(places[1])).unwrap();
        let longer = scratch.write(&vec![3.5f32; 20], Some(places[0])).unwrap();
        assert_eq!((shorter.at, longer.at), (places[1].at, places[2].at + places[2].room));
        let read = |place| scratch.read::<Vec<f32>>(place).unwrap();
        assert_eq!((read(shorter), read(longer), read(places[2])), (vec![2.5], vec![3.5; 20], Vec::new()));
        assert_eq!(read(places[0]), values[0], "nothing else was written there");
        assert_eq!(std::fs::read_dir(folder.path().join("cache")).unwrap().count(), 0, "it has no name");
    }

    #[test]
    fn a_folder_that_cannot_be_made_gives_way_to_that_of_the_system() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let scratch = Scratch::new(&file.path().join("cache"));
        let place = scratch.write(&"kept", None).unwrap();
        assert_eq!(scratch.read::<String>(place).unwrap(), "kept");
    }
}
