//! Layers, groups and masks of an XCF, each a head with properties and a place of its pixels.

use std::collections::HashMap;
use std::sync::Arc;

use super::head::Head;
use super::properties::Properties;
use super::tiles::{Model, TileTable};
use super::{modes, pointer, text};
use crate::error::Result;
use crate::geometry::PixelRect;
use crate::io::layered::bytes::FileBytes;
use crate::io::layered::groups::GroupTraits;
use crate::io::layered::place::rect_at;
use crate::io::layered::{EditedLayer, EditedMask, Lazy};

/// Reads all layers; `places` are theirs from the top, the result begins at the bottom.
///
/// # Errors
/// [`crate::Error::Input`] when one of them is damaged.
pub fn read_all(
    places: &[u64],
    head: &Head,
    image: &Properties,
    bytes: &Arc<FileBytes>,
    notes: &mut Vec<String>,
) -> Result<Vec<EditedLayer>> {
    let colours: Arc<[[u8; 3]]> = image.colour_map.as_slice().into();
    let mut reader =
        Reader { head, compression: image.compression, colours, bytes, tree: Tree::default(), notes };
    let mut layers = Vec::new();
    for place in places {
        layers.extend(reader.layer(*place)?);
    }
    layers.reverse();
    Ok(layers)
}

struct Reader<'a> {
    head: &'a Head,
    compression: u8,
    colours: Arc<[[u8; 3]]>,
    bytes: &'a Arc<FileBytes>,
    tree: Tree,
    notes: &'a mut Vec<String>,
}

impl Reader<'_> {
    /// The layer at byte `place`; none when it is a group or a floating selection.
    fn layer(&mut self, place: u64) -> Result<Option<EditedLayer>> {
        let wide = self.head.wide;
        let mut cursor = self.bytes.cursor(place);
        let (width, height, kind) = (cursor.u32()?, cursor.u32()?, cursor.u32()?);
        let name = text(&mut cursor)?;
        let properties = Properties::read(&mut cursor, wide)?;
        let (hierarchy, mask) = (pointer(&mut cursor, wide)?, pointer(&mut cursor, wide)?);
        if properties.floating.is_some() {
            let what = "is a floating selection; anchor it in GIMP to have it read";
            self.notes.push(format!("layer \"{name}\" {what}"));
            return Ok(None);
        }
        self.note_effects(&mut cursor, &name)?;
        let path = self.tree.path_of(&properties.path);
        if properties.group {
            self.group(name, path, &properties, mask != 0);
            return Ok(None);
        }
        let model = Model::of(kind)
            .ok_or_else(|| self.bytes.damaged(place + 8, format!("layer kind {kind}, expected 0 to 5")))?;
        let (x, y) = properties.offset;
        let rect = rect_at(x.into(), y.into(), width.into(), height.into()).ok_or_else(|| {
            self.bytes.damaged(place, format!("a layer of {width} x {height} pixels at ({x}, {y})"))
        })?;
        let table = self.table(hierarchy, rect, model)?;
        let (groups, hidden_by_group) = self.tree.groups_of(&path, &name, self.notes);
        Ok(Some(EditedLayer {
            groups,
            rect,
            visible: properties.visible,
            hidden_by_group,
            opacity: properties.opacity,
            blend: modes::blend(properties.mode),
            mask: self.mask(mask, rect, properties.apply_mask)?,
            id: properties.layer,
            locked: properties.locked,
            pixels: Lazy::new(move || table.raster()),
            name,
        }))
    }

    /// From version 20 on, filters that are computed anew each time hang on a layer.
    fn note_effects(&mut self, cursor: &mut crate::io::layered::bytes::Cursor, name: &str) -> Result<()> {
        const SINCE: u32 = 20;
        if self.head.version >= SINCE && pointer(cursor, self.head.wide)? != 0 {
            self.notes.push(format!("layer \"{name}\": its filters are not applied; merge them in GIMP"));
        }
        Ok(())
    }

    fn group(&mut self, name: String, path: Vec<u32>, properties: &Properties, has_mask: bool) {
        let group = GroupTraits {
            name,
            visible: properties.visible,
            opacity: properties.opacity,
            masked: has_mask && properties.apply_mask,
            blend: modes::blend(properties.mode),
        };
        group.note(self.notes);
        self.tree.groups.insert(path, group);
    }

    fn mask(&self, place: u64, rect: PixelRect, enabled: bool) -> Result<Option<EditedMask>> {
        if place == 0 {
            return Ok(None);
        }
        let mut cursor = self.bytes.cursor(place);
        let (width, height) = (cursor.u32()?, cursor.u32()?);
        if (width, height) != (rect.w, rect.h) {
            let found = format!("a mask of {width} x {height} pixels on a layer of {} x {}", rect.w, rect.h);
            return Err(self.bytes.damaged(place, found));
        }
        let _name = text(&mut cursor)?;
        Properties::read(&mut cursor, self.head.wide)?;
        let hierarchy = pointer(&mut cursor, self.head.wide)?;
        let table = self.table(hierarchy, rect, Model::Mask)?;
        Ok(Some(EditedMask { rect, outside: 1.0, enabled, pixels: Lazy::new(move || table.grey()) }))
    }

    fn table(&self, hierarchy: u64, rect: PixelRect, model: Model) -> Result<TileTable> {
        TileTable::find(self.bytes, hierarchy, (rect.w, rect.h), model, self.head, self.compression)
            .map(|table| table.with_colours(&self.colours))
    }
}

/// The tree of groups, by the ways through it.
#[derive(Default)]
struct Tree {
    /// How many items outside groups there were.
    outermost: u32,
    groups: HashMap<Vec<u32>, GroupTraits>,
}

impl Tree {
    /// The way to the next item. GIMP stores it within groups only; outside, items are counted.
    fn path_of(&mut self, stored: &[u32]) -> Vec<u32> {
        if stored.len() > 1 {
            return stored.to_vec();
        }
        self.outermost += 1;
        vec![self.outermost - 1]
    }

    /// The names of the groups on the way, and whether one of them is not shown.
    fn groups_of(&self, path: &[u32], layer: &str, notes: &mut Vec<String>) -> (Vec<String>, bool) {
        let ways = (1..path.len()).map(|length| self.groups.get(&path[..length]));
        let found: Vec<&GroupTraits> = ways.clone().flatten().collect();
        if found.len() < ways.count() {
            notes.push(format!("layer \"{layer}\" lies in a group that is not in the file"));
        }
        let hidden = found.iter().any(|group| !group.visible);
        (found.into_iter().map(|group| group.name.clone()).collect(), hidden)
    }
}
