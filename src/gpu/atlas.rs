//! Texture memory on the device (`shaders/atlas.wgsl`): the pages of slots, and the page tables.

use std::ops::Range;

use wgpu::{Buffer, BufferUsages, Extent3d, Origin3d, TexelCopyBufferLayout, TexelCopyTextureInfo};
use wgpu::{Texture, TextureFormat, TextureUsages, TextureView, TextureViewDescriptor, TextureViewDimension};

use super::bindings;
use super::device::Gpu;
use crate::error::Result;
use crate::projection::residency::{PAGE_SLOTS, Residency};
use crate::projection::tiles::SLOT;

/// WGSL of the lookups.
pub const SOURCE: &str = include_str!("../../shaders/atlas.wgsl");

/// Bytes of a slot of plain texels.
pub const SLOT_BYTES: u64 = 4 * (SLOT * SLOT) as u64;

/// Pages, page tables, and the table of sheets.
#[derive(Debug)]
pub struct Atlas {
    gpu: Gpu,
    texture: Texture,
    view: TextureView,
    /// Slots in a row, rows of slots in a page, pages.
    size: [u32; 3],
    pages: Buffer,
    sheets: Buffer,
}

/// Neighbouring slots of one row of a page, with their texels: 68 rows.
#[derive(Debug)]
pub struct Strip {
    /// The first slot.
    pub slot: u32,
    /// How many.
    pub count: u32,
    /// `68 * count` texels a row.
    pub texels: Vec<u8>,
}

impl Strip {
    /// Room for so many slots.
    pub fn new(slot: u32, count: u32) -> Self {
        Self { slot, count, texels: vec![0; SLOT_BYTES as usize * count as usize] }
    }

    /// Bytes from one row to the next.
    pub fn row_bytes(&self) -> usize {
        (4 * SLOT * self.count) as usize
    }
}

impl Atlas {
    /// Tables for these sheets, and no slots yet.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] when the device cannot hold the tables.
    pub fn new(gpu: &Gpu, residency: &Residency) -> Result<Self> {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        gpu.guarded("making page tables", || {
            let texture = texture(gpu, [1, 1, 1]);
            Ok(Self {
                gpu: gpu.clone(),
                view: array_view(&texture),
                texture,
                size: [0; 3],
                pages: bindings::filled(gpu, "pages", residency.entries(), usage),
                sheets: bindings::filled(gpu, "sheets", residency.records(), usage),
            })
        })
    }

    /// The slots, as an array of pages.
    pub fn view(&self) -> &TextureView {
        &self.view
    }

    /// The page tables: words.
    pub fn pages(&self) -> &Buffer {
        &self.pages
    }

    /// `Sheet` for each sheet.
    pub fn sheets(&self) -> &Buffer {
        &self.sheets
    }

    /// Bytes of all pages.
    pub fn bytes(&self) -> u64 {
        self.size.iter().map(|&side| u64::from(side)).product::<u64>() * SLOT_BYTES
    }

    /// The most slots that the device can address.
    pub fn most_slots(gpu: &Gpu) -> u32 {
        let columns = columns(gpu);
        columns * columns * gpu.device.limits().max_texture_array_layers.min(1 << (24 - 10))
    }

    /// Makes room for at least `slots` slots where the device can, keeping what there is. Returns the
    /// numbers of the new ones.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] when memory runs out; everything is as it was then.
    pub fn grow(&mut self, slots: u32) -> Result<Vec<Range<u32>>> {
        let size = shape(slots, columns(&self.gpu));
        let size = [size[0].max(self.size[0]), size[1].max(self.size[1]), size[2].max(self.size[2])];
        if size == self.size {
            return Ok(Vec::new());
        }
        let larger = self.gpu.guarded("making room for textures", || {
            let larger = texture(&self.gpu, size);
            self.copy_to(&larger);
            Ok(larger)
        })?;
        let old = std::mem::replace(&mut self.size, size);
        self.view = array_view(&larger);
        self.texture = larger;
        Ok(new_slots(old, size))
    }

    fn copy_to(&self, larger: &Texture) {
        if self.size[2] == 0 {
            return;
        }
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let [width, height, layers] = [self.size[0] * SLOT, self.size[1] * SLOT, self.size[2]];
        let size = Extent3d { width, height, depth_or_array_layers: layers };
        encoder.copy_texture_to_texture(self.texture.as_image_copy(), larger.as_image_copy(), size);
        self.gpu.queue.submit([encoder.finish()]);
    }

    /// Writes slots; they are there before anything that is submitted afterwards.
    pub fn write(&self, strip: &Strip) {
        let [column, row, page] = place(strip.slot);
        let target = TexelCopyTextureInfo {
            origin: Origin3d { x: column * SLOT, y: row * SLOT, z: page },
            ..self.texture.as_image_copy()
        };
        let layout = TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(strip.row_bytes() as u32),
            rows_per_image: Some(SLOT),
        };
        let size = Extent3d { width: strip.count * SLOT, height: SLOT, depth_or_array_layers: 1 };
        self.gpu.queue.write_texture(target, &strip.texels, layout, size);
    }

    /// Writes a range of the page tables.
    pub fn write_entries(&self, entries: &[u32], range: Range<usize>) {
        let bytes = bytemuck::cast_slice(&entries[range.clone()]);
        self.gpu.queue.write_buffer(&self.pages, 4 * range.start as u64, bytes);
    }
}

/// Column, row and page of a slot.
pub fn place(slot: u32) -> [u32; 3] {
    [slot % PAGE_SLOTS, slot / PAGE_SLOTS % PAGE_SLOTS, slot / (PAGE_SLOTS * PAGE_SLOTS)]
}

/// Slots in a row of a page.
fn columns(gpu: &Gpu) -> u32 {
    (gpu.device.limits().max_texture_dimension_2d / SLOT).min(PAGE_SLOTS)
}

/// Columns, rows and pages for so many slots: one page grows by rows, then whole pages.
fn shape(slots: u32, columns: u32) -> [u32; 3] {
    let rows = slots.div_ceil(columns);
    if rows <= columns { [columns, rows, 1] } else { [columns, columns, rows.div_ceil(columns)] }
}

fn new_slots(old: [u32; 3], new: [u32; 3]) -> Vec<Range<u32>> {
    let rows = (0..new[2]).flat_map(|page| (0..new[1]).map(move |row| (page, row)));
    let is_old = |(page, row): (u32, u32)| page < old[2] && row < old[1];
    let first = |(page, row)| (page * PAGE_SLOTS + row) * PAGE_SLOTS;
    rows.filter(|row| !is_old(*row)).map(|row| first(row)..first(row) + new[0]).collect()
}

fn texture(gpu: &Gpu, [columns, rows, pages]: [u32; 3]) -> Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("atlas"),
        size: Extent3d { width: columns * SLOT, height: rows * SLOT, depth_or_array_layers: pages },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: TextureFormat::Rgba8UnormSrgb,
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST | TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// An array even where there is one page.
fn array_view(texture: &Texture) -> TextureView {
    texture.create_view(&TextureViewDescriptor {
        dimension: Some(TextureViewDimension::D2Array),
        ..TextureViewDescriptor::default()
    })
}
