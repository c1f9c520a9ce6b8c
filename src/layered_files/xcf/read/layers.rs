//! Reads layers, groups and masks of an XCF, each a head with properties and the position of its pixels.

use std::collections::HashMap;
use std::sync::Arc;

use super::head::XcfHeader;
use super::properties::Properties;
use super::tiles::{PixelModel, TileTable};
use super::{modes, pointer, text};
use crate::bytes::FileBytes;
use crate::groups::{GroupContext, GroupProperties};
use crate::place::rect_at;
use crate::{EditedLayer, EditedMask, Lazy};
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;

/// Reads all layers; `places` are their positions from top to bottom, the result is from bottom to top.
///
/// # Errors
/// [`quadratura_base::Error::Input`] when one of them is damaged.
pub fn read_all(
    positions: &[u64],
    head: &XcfHeader,
    image: &Properties,
    bytes: &Arc<FileBytes>,
    notes: &mut Vec<String>,
) -> Result<Vec<EditedLayer>> {
    let colours: Arc<[[u8; 3]]> = image.colour_map.as_slice().into();
    let mut reader = XcfLayerReader {
        head,
        compression: image.compression,
        colours,
        bytes,
        tree: GroupTree::default(),
        notes,
    };
    let mut layers = Vec::new();
    for position in positions {
        layers.extend(reader.layer(*position)?);
    }
    layers.reverse();
    Ok(layers)
}

struct XcfLayerReader<'a> {
    head: &'a XcfHeader,
    compression: u8,
    colours: Arc<[[u8; 3]]>,
    bytes: &'a Arc<FileBytes>,
    tree: GroupTree,
    notes: &'a mut Vec<String>,
}

impl XcfLayerReader<'_> {
    /// Reads the layer at byte `place`; `None` when it is a group or a floating selection.
    fn layer(&mut self, position: u64) -> Result<Option<EditedLayer>> {
        let wide = self.head.wide;
        let mut cursor = self.bytes.cursor(position);
        let width = cursor.u32()?;
        let height = cursor.u32()?;
        let kind = cursor.u32()?;
        let name = text(&mut cursor)?;
        let properties = Properties::read(&mut cursor, wide)?;
        let (hierarchy, mask) = (pointer(&mut cursor, wide)?, pointer(&mut cursor, wide)?);
        if properties.floating.is_some() {
            let what = "is a floating selection; anchor it in GIMP, so that it is read";
            self.notes.push(format!("layer \"{name}\" {what}"));
            return Ok(None);
        }
        self.note_effects(&mut cursor, &name)?;
        let path = self.tree.path_of(&properties.path);
        if properties.group {
            self.group(name, path, &properties, mask, width, height)?;
            return Ok(None);
        }
        if properties.is_text {
            self.notes
                .push(format!("layer \"{name}\" is a text layer: its pixels are read as GIMP drew them"));
        }
        let model = PixelModel::from_kind(kind)
            .ok_or_else(|| self.bytes.damaged(position + 8, format!("layer kind {kind}, expected 0 to 5")))?;
        let (x, y) = properties.offset;
        let rect = rect_at(x.into(), y.into(), width.into(), height.into()).ok_or_else(|| {
            self.bytes.damaged(position, format!("a layer of {width} x {height} pixels at ({x}, {y})"))
        })?;
        let table = self.table(hierarchy, rect, model)?;
        let same = table.clone();
        let own = self.mask(mask, rect, properties.apply_mask)?;
        let around = self.tree.around(&path, &name, self.notes);
        Ok(Some(EditedLayer {
            masks: around.masks(own),
            rect,
            visible: properties.visible,
            hidden_by_group: around.hidden,
            opacity: properties.opacity * around.opacity,
            blend: around.blend(modes::blend(properties.mode, properties.composite)),
            groups: around.names,
            id: properties.layer,
            locked: properties.locked,
            colours: model.colours(),
            pixels: Lazy::new(move || table.raster()).with_stored_hash(move || same.hash_of_code()),
            name,
        }))
    }

    /// Reports filters of a layer, which files have from version 20 on and which GIMP computes anew each
    /// time.
    fn note_effects(&mut self, cursor: &mut crate::bytes::Cursor, name: &str) -> Result<()> {
        const SINCE: u32 = 20;
        if self.head.version >= SINCE && pointer(cursor, self.head.wide)? != 0 {
            self.notes.push(format!("layer \"{name}\": its filters are not applied; merge them in GIMP"));
        }
        Ok(())
    }

    fn group(
        &mut self,
        name: String,
        path: Vec<u32>,
        properties: &Properties,
        mask: u64,
        width: u32,
        height: u32,
    ) -> Result<()> {
        let (x, y) = properties.offset;
        let rect = rect_at(x.into(), y.into(), width.into(), height.into());
        let mask = rect.map(|rect| self.mask(mask, rect, properties.apply_mask)).transpose()?.flatten();
        let group = GroupProperties {
            name,
            visible: properties.visible,
            opacity: properties.opacity,
            mask: mask.map(Arc::new),
            blend: modes::blend(properties.mode, properties.composite),
        };
        self.tree.groups.insert(path, group);
        Ok(())
    }

    fn mask(&self, position: u64, rect: PixelRect, enabled: bool) -> Result<Option<EditedMask>> {
        if position == 0 {
            return Ok(None);
        }
        let mut cursor = self.bytes.cursor(position);
        let (width, height) = (cursor.u32()?, cursor.u32()?);
        if (width, height) != (rect.w, rect.h) {
            let found = format!("a mask of {width} x {height} pixels on a layer of {} x {}", rect.w, rect.h);
            return Err(self.bytes.damaged(position, found));
        }
        let _name = text(&mut cursor)?;
        Properties::read(&mut cursor, self.head.wide)?;
        let hierarchy = pointer(&mut cursor, self.head.wide)?;
        let table = self.table(hierarchy, rect, PixelModel::Mask)?;
        let same = table.clone();
        let pixels = Lazy::new(move || table.grey()).with_stored_hash(move || same.hash_of_code());
        Ok(Some(EditedMask { rect, outside: 1.0, enabled, lowest_with: None, pixels }))
    }

    fn table(&self, hierarchy: u64, rect: PixelRect, model: PixelModel) -> Result<TileTable> {
        TileTable::find(self.bytes, hierarchy, (rect.w, rect.h), model, self.head, self.compression)
            .map(|table| table.with_colours(&self.colours))
    }
}

/// The tree of groups by their paths.
#[derive(Default)]
struct GroupTree {
    /// The number of items outside groups so far.
    outermost: u32,
    groups: HashMap<Vec<u32>, GroupProperties>,
}

impl GroupTree {
    /// Returns the path of the next item. GIMP stores it within groups only; outside, items are counted.
    fn path_of(&mut self, stored: &[u32]) -> Vec<u32> {
        if stored.len() > 1 {
            return stored.to_vec();
        }
        self.outermost += 1;
        vec![self.outermost - 1]
    }

    /// Returns the combined effect of the groups on the path.
    fn around(&self, path: &[u32], layer: &str, notes: &mut Vec<String>) -> GroupContext {
        let ways = (1..path.len()).map(|length| self.groups.get(&path[..length]));
        let found: Vec<&GroupProperties> = ways.clone().flatten().collect();
        if found.len() < ways.count() {
            notes.push(format!("layer \"{layer}\" belongs to a group that is not in the file"));
        }
        GroupContext::from_groups(found.into_iter())
    }
}
