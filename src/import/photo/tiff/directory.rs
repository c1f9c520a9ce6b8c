//! The directory of a TIFF: its first page's tags. Classic files have offsets of 32 bits, BigTIFF of 64.

use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom};

/// The most tags of a directory that are read; files of microscopes have about a hundred.
const MOST_TAGS: u64 = 4096;

/// The most bytes of a value: of a colour profile.
const LONGEST_VALUE: u64 = 16 << 20;

/// The most directories that are followed to count pages.
const MOST_PAGES: usize = 32;

/// What is wrong with a file, as a message says it.
pub type TiffDefect = String;

/// A file with its first directory.
pub struct Directory<R> {
    input: R,
    length: u64,
    big_endian: bool,
    is_big: bool,
    entries: BTreeMap<u16, Entry>,
    /// Where the next directory is; 0 for none.
    next: u64,
}

#[derive(Clone, Copy)]
struct Entry {
    kind: u16,
    count: u64,
    /// The value itself where it fits, else its offset; as stored.
    stored: [u8; 8],
}

impl<R: Read + Seek> Directory<R> {
    /// Reads the header and the first directory.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn open(mut input: R) -> Result<Self, TiffDefect> {
        let length = input.seek(SeekFrom::End(0)).map_err(|error| error.to_string())?;
        let mut file =
            Self { input, length, big_endian: false, is_big: false, entries: BTreeMap::new(), next: 0 };
        let start = file.bytes_at(0, 8)?;
        file.big_endian = start[0] == b'M';
        file.is_big = file.number_of(&start[2..4]) == 43;
        let first = match file.is_big {
            false => file.number_of(&start[4..8]),
            true if file.number_of(&start[4..6]) != 8 => return Err("a BigTIFF with unusual offsets".into()),
            true => file.number_at(8, 8)?,
        };
        file.next = file.read_directory(first)?;
        Ok(file)
    }

    /// Reads a directory into `entries`; returns where the next one is.
    fn read_directory(&mut self, at: u64) -> Result<u64, TiffDefect> {
        let (count_size, entry_size, offset_size) = if self.is_big { (8, 20, 8) } else { (2, 12, 4) };
        let count = self.number_at(at, count_size)?;
        if count > MOST_TAGS {
            return Err(format!("a directory of {count} tags"));
        }
        let first = at.saturating_add(count_size);
        let bytes = self.bytes_at(first, count * entry_size)?;
        self.entries.clear();
        for entry in bytes.chunks_exact(entry_size as usize) {
            let count_bytes = &entry[4..entry.len() - offset_size as usize];
            let mut stored = [0; 8];
            stored[..offset_size as usize].copy_from_slice(&entry[entry.len() - offset_size as usize..]);
            let read = Entry {
                kind: self.number_of(&entry[2..4]) as u16,
                count: self.number_of(count_bytes),
                stored,
            };
            self.entries.entry(self.number_of(&entry[..2]) as u16).or_insert(read);
        }
        self.number_at(first + count * entry_size, offset_size)
    }

    /// Returns the number of full pages of the file; copies of reduced size and masks are none.
    pub fn pages(&mut self) -> usize {
        let mine = std::mem::take(&mut self.entries);
        let (mut pages, mut next) = (1, self.next);
        for _ in 0..MOST_PAGES {
            if next == 0 {
                break;
            }
            let Ok(following) = self.read_directory(next) else { break };
            // NewSubfileType: bit 0 for a reduced copy, bit 2 for a mask.
            let kind = self.number(254).ok().flatten().unwrap_or(0);
            pages += usize::from(kind & 5 == 0);
            next = following;
        }
        self.entries = mine;
        pages
    }

    /// Returns the bytes at an offset.
    ///
    /// # Errors
    /// The file ends before.
    pub fn bytes_at(&mut self, at: u64, count: u64) -> Result<Vec<u8>, TiffDefect> {
        if at.checked_add(count).is_none_or(|end| end > self.length) {
            return Err(format!("the file is cut short: it has {} bytes", self.length));
        }
        let mut bytes = vec![0; count as usize];
        self.input.seek(SeekFrom::Start(at)).map_err(|error| error.to_string())?;
        self.input.read_exact(&mut bytes).map_err(|error| error.to_string())?;
        Ok(bytes)
    }

    fn number_at(&mut self, at: u64, size: u64) -> Result<u64, TiffDefect> {
        let bytes = self.bytes_at(at, size)?;
        Ok(self.number_of(&bytes))
    }

    /// Returns the number of up to eight bytes in the file's order.
    pub fn number_of(&self, bytes: &[u8]) -> u64 {
        let add = |number: u64, byte: &u8| number << 8 | u64::from(*byte);
        if self.big_endian { bytes.iter().fold(0, add) } else { bytes.iter().rev().fold(0, add) }
    }

    /// Returns whether numbers have their largest byte first.
    pub fn is_big_endian(&self) -> bool {
        self.big_endian
    }

    /// Returns whether there is a tag.
    pub fn has(&self, tag: u16) -> bool {
        self.entries.contains_key(&tag)
    }

    /// Returns the bytes of a tag's value, and the size of each of its elements.
    fn value(&mut self, tag: u16) -> Result<Option<(Vec<u8>, usize)>, TiffDefect> {
        let Some(&Entry { kind, count, stored }) = self.entries.get(&tag) else { return Ok(None) };
        let size = match kind {
            1 | 2 | 6 | 7 => 1,
            3 | 8 => 2,
            4 | 9 | 11 | 13 => 4,
            5 | 10 | 12 | 16..=18 => 8,
            _ => return Err(format!("tag {tag} has an unknown type {kind}")),
        };
        let bytes = count.checked_mul(size).filter(|bytes| *bytes <= LONGEST_VALUE);
        let bytes = bytes.ok_or_else(|| format!("tag {tag} has {count} values"))?;
        let inline = if self.is_big { 8 } else { 4 };
        let value = match bytes <= inline {
            true => stored[..bytes as usize].to_vec(),
            false => self.bytes_at(self.number_of(&stored[..inline as usize]), bytes)?,
        };
        Ok(Some((value, size as usize)))
    }

    /// Returns the bytes of a tag.
    ///
    /// # Errors
    /// It is too long, or not within the file.
    pub fn bytes(&mut self, tag: u16) -> Result<Option<Vec<u8>>, TiffDefect> {
        Ok(self.value(tag)?.map(|(bytes, _)| bytes))
    }

    /// Returns the numbers of a tag, empty without the tag.
    ///
    /// # Errors
    /// As [`Directory::bytes`].
    pub fn numbers(&mut self, tag: u16) -> Result<Vec<u64>, TiffDefect> {
        let Some((bytes, size)) = self.value(tag)? else { return Ok(Vec::new()) };
        Ok(bytes.chunks_exact(size).map(|number| self.number_of(number)).collect())
    }

    /// Returns the first number of a tag.
    ///
    /// # Errors
    /// As [`Directory::bytes`].
    pub fn number(&mut self, tag: u16) -> Result<Option<u64>, TiffDefect> {
        Ok(self.numbers(tag)?.first().copied())
    }
}
