//! Decoded sheets that are kept for a while, as far as memory allows.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use crate::projection::SheetId;
use crate::projection::pyramid::Pyramid;

/// Pyramids, the least recently used of which leave first.
#[derive(Debug)]
pub struct PyramidCache {
    kept: FxHashMap<SheetId, (Arc<Pyramid>, u64)>,
    bytes: u64,
    most_bytes: u64,
    now: u64,
}

impl PyramidCache {
    /// An empty one for so many bytes.
    pub fn new(most_bytes: u64) -> Self {
        Self { kept: FxHashMap::default(), bytes: 0, most_bytes, now: 0 }
    }

    /// The pyramid of a sheet, if it is here.
    pub fn get(&mut self, sheet: SheetId) -> Option<Arc<Pyramid>> {
        self.now += 1;
        let (pyramid, used) = self.kept.get_mut(&sheet)?;
        *used = self.now;
        Some(pyramid.clone())
    }

    /// Keeps a pyramid, in place of the sheet's old one. The newest is kept however large it is.
    pub fn keep(&mut self, sheet: SheetId, pyramid: Arc<Pyramid>) {
        self.now += 1;
        self.bytes += pyramid.bytes();
        if let Some((old, _)) = self.kept.insert(sheet, (pyramid, self.now)) {
            self.bytes -= old.bytes();
        }
        while self.bytes > self.most_bytes && self.kept.len() > 1 {
            let oldest = self.kept.iter().min_by_key(|(_, (_, used))| *used).map(|(sheet, _)| *sheet);
            let Some((gone, _)) = oldest.and_then(|sheet| self.kept.remove(&sheet)) else { return };
            self.bytes -= gone.bytes();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::PixelRect;
    use crate::projection::SheetPixels;
    use crate::projection::pyramid::{PyramidOptions, pyramid};

    fn square(side: u32) -> Arc<Pyramid> {
        let rect = PixelRect { x: 0, y: 0, w: side, h: side };
        let texels = rect.area() as usize;
        let pixels = SheetPixels { rect, rgba: vec![255; 4 * texels], needed: vec![1; texels] };
        Arc::new(pyramid(rect, &pixels, &PyramidOptions::default()))
    }

    #[test]
    fn what_was_not_used_for_longest_leaves() {
        let one = square(64);
        let mut cache = PyramidCache::new(2 * one.bytes());
        (0..2).for_each(|i| cache.keep(SheetId(i), one.clone()));
        assert!(cache.get(SheetId(0)).is_some());
        cache.keep(SheetId(2), one.clone());
        let there: Vec<bool> = (0..3).map(|i| cache.get(SheetId(i)).is_some()).collect();
        assert_eq!(there, [true, false, true]);
        cache.keep(SheetId(2), one.clone());
        assert!(cache.get(SheetId(0)).is_some() && cache.bytes == 2 * one.bytes());
    }

    #[test]
    fn what_is_larger_than_the_cache_is_kept_alone() {
        let mut cache = PyramidCache::new(1);
        cache.keep(SheetId(0), square(8));
        cache.keep(SheetId(1), square(16));
        assert!(cache.get(SheetId(0)).is_none() && cache.get(SheetId(1)).is_some());
    }
}
