//! A cache of the pixels of masks. Files of masks never change, so that the pixels of a file stay valid.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::Arc;

use super::keeping::Keeping;
use crate::state::running::JobId;
use quadratura_base::geometry::Spans;
use quadratura_document::Masks;
use quadratura_document::masks::Mask;

/// The number of cached files beyond which files of no current mask are dropped: a few hundred kilobytes each.
const MOST: usize = 200;

/// The cache of mask pixels.
#[derive(Default)]
pub struct MaskCache {
    by_file: BTreeMap<String, Arc<Spans>>,
    /// The job that reads masks.
    pub reading: Option<JobId>,
    covered: RefCell<Option<Covered>>,
    /// A number that changes with the cache and with the queue of edits.
    pub revision: u64,
}

/// All masked pixels of a photo.
struct Covered {
    photo: String,
    files: Vec<String>,
    revision: u64,
    pixels: Arc<Spans>,
}

impl MaskCache {
    /// Adds pixels that were read. A mask that could not be read counts as empty: its error is reported once.
    pub fn add(&mut self, read: impl IntoIterator<Item = (String, Spans)>, masks: &Masks) {
        self.by_file.extend(read.into_iter().map(|(file, pixels)| (file, Arc::new(pixels))));
        if self.by_file.len() > MOST {
            let named = masks.files();
            self.by_file.retain(|file, _| named.contains(file.as_str()));
        }
        self.revision += 1;
    }

    /// Returns those of these masks that are not loaded yet.
    pub fn missing(&self, masks: &[Mask]) -> Vec<Mask> {
        masks.iter().filter(|mask| !self.by_file.contains_key(&mask.file)).cloned().collect()
    }

    /// Returns the masked pixels of a photo as far as they are loaded, with the edits in the queue applied. They are
    /// computed once for each revision.
    pub fn covered(&self, photo: &str, masks: &[Mask], queue: &Keeping) -> Arc<Spans> {
        let files: Vec<String> = masks.iter().map(|mask| mask.file.clone()).collect();
        let same = |c: &&Covered| c.photo == *photo && c.files == files && c.revision == self.revision;
        if let Some(covered) = self.covered.borrow().as_ref().filter(same) {
            return covered.pixels.clone();
        }
        let of_files = files.iter().filter_map(|file| self.by_file.get(file));
        let of_files = of_files.fold(Spans::default(), |all, pixels| all.union(pixels));
        let pixels = Arc::new(queue.applied_to(of_files, photo));
        let covered =
            Covered { photo: photo.to_owned(), files, revision: self.revision, pixels: pixels.clone() };
        *self.covered.borrow_mut() = Some(covered);
        pixels
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::masking::keeping::{MaskWork, Waiting};
    use quadratura_base::geometry::PixelRect;
    use quadratura_document::masks::MaskOrigin;
    use quadratura_sites::masks::MaskEdit;

    fn block(x: i32, w: u32) -> Spans {
        Spans::of_pixels(PixelRect { x, y: 0, w, h: 1 }, |_, _| true)
    }

    fn mask(file: &str) -> Mask {
        Mask { from: MaskOrigin::Drawn, file: file.into(), pixels: 1 }
    }

    #[test]
    fn masks_are_missing_until_their_pixels_are_added() {
        let mut cache = MaskCache::default();
        let masks = [mask("one"), mask("two")];
        cache.add([("one".to_owned(), block(0, 4))], &Masks::default());
        assert_eq!(cache.missing(&masks), [mask("two")]);
        assert_eq!(cache.covered("a", &masks, &Keeping::default()).count(), 4);
        cache.add([("two".to_owned(), block(2, 4))], &Masks::default());
        assert!(cache.missing(&masks).is_empty());
        assert_eq!(cache.covered("a", &masks, &Keeping::default()).count(), 6);
    }

    #[test]
    fn masked_pixels_are_computed_again_only_when_something_has_changed() {
        let (mut cache, mut queue) = (MaskCache::default(), Keeping::default());
        cache.add([("one".to_owned(), block(0, 4))], &Masks::default());
        let before = cache.covered("a", &[mask("one")], &queue);
        assert!(Arc::ptr_eq(&before, &cache.covered("a", &[mask("one")], &queue)));
        let edit = MaskEdit::Clear { photo: "a".into() };
        let work = MaskWork::Edits(Arc::new(vec![edit]));
        queue.queue.push_back(Waiting { name: String::new(), work });
        cache.revision += 1;
        assert_eq!(cache.covered("a", &[mask("one")], &queue).count(), 0);
        assert_eq!(cache.covered("b", &[mask("one")], &queue).count(), 4, "of another photo");
    }

    #[test]
    fn pixels_that_no_mask_names_are_dropped_when_there_are_many() {
        let mut cache = MaskCache::default();
        cache.add((0..=MOST).map(|file| (file.to_string(), block(0, 1))), &Masks::default());
        assert_eq!(cache.missing(&[mask("0")]), [mask("0")]);
    }
}
