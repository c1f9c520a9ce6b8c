//! Texture memory on the device: the pages of slots, and the page tables, which `shaders/texels.wgsl` reads.

use std::ops::Range;

use wgpu::{Buffer, BufferUsages, Extent3d, Origin3d, TexelCopyBufferLayout, TexelCopyTextureInfo};
use wgpu::{Texture, TextureFormat, TextureUsages, TextureView, TextureViewDescriptor, TextureViewDimension};

use super::bindings;
use super::blocks::compressed;
use super::device::Gpu;
use quadratura_base::error::{Error, Result};
use quadratura_projection::Storage;
use quadratura_projection::residency::{PAGE_SLOTS, Residency};
use quadratura_projection::tiles::SLOT;

/// The pages of slots, the page tables, and the table of layer textures.
#[derive(Debug)]
pub struct TileAtlas {
    gpu: Gpu,
    texture: Texture,
    /// Views that read colours in linear light, and as stored.
    views: [TextureView; 2],
    storage: Storage,
    /// The number of slots in a row, of rows of slots in a page, and of pages.
    size: [u32; 3],
    pages: Buffer,
    layer_textures: Buffer,
}

/// A strip of adjacent slots of one row of a page, ready for upload.
#[derive(Debug)]
pub struct SlotStrip {
    /// The first slot.
    pub slot: u32,
    /// The number of slots.
    pub count: u32,
    /// 68 rows of `68 * count` texels, or the blocks of these.
    pub bytes: Vec<u8>,
}

impl SlotStrip {
    /// Builds a strip from uncompressed texels.
    pub fn new(slot: u32, count: u32, texels: Vec<u8>, storage: Storage) -> Self {
        let bytes = match storage {
            Storage::Plain => texels,
            Storage::Compressed => compressed(&texels, count * SLOT, SLOT),
        };
        Self { slot, count, bytes }
    }
}

impl TileAtlas {
    /// Creates the tables for these layer textures, without slots.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`] when the device cannot hold the tables, or does not support the storage.
    pub fn new(gpu: &Gpu, residency: &Residency, storage: Storage) -> Result<Self> {
        if storage == Storage::Compressed && !gpu.has_compression() {
            let name = gpu.adapter_summary();
            return Err(Error::Gpu(format!("{name} does not support BC7; do not use compressed textures")));
        }
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        gpu.guarded("making page tables", || {
            let texture = texture(gpu, [1, 1, 1], storage);
            Ok(Self {
                gpu: gpu.clone(),
                views: views(&texture, storage),
                texture,
                storage,
                size: [0; 3],
                pages: bindings::filled(gpu, "pages", residency.entries(), usage),
                layer_textures: bindings::filled(gpu, "layer textures", residency.records(), usage),
            })
        })
    }

    /// Returns the format of texels in slots.
    pub fn storage(&self) -> Storage {
        self.storage
    }

    /// Returns the slots as an array of pages.
    pub fn view(&self) -> &TextureView {
        &self.views[0]
    }

    /// Returns the slots as an array of pages whose colours are read in sRGB: filtering is faster, and
    /// slightly incorrect.
    pub fn stored_view(&self) -> &TextureView {
        &self.views[1]
    }

    /// Returns the page tables, an array of words.
    pub fn pages(&self) -> &Buffer {
        &self.pages
    }

    /// Returns the table of layer textures (a `TextureRecord` each).
    pub fn layer_textures(&self) -> &Buffer {
        &self.layer_textures
    }

    /// Returns the size of all pages in bytes.
    pub fn bytes(&self) -> u64 {
        self.size.iter().map(|&side| u64::from(side)).product::<u64>() * self.storage.slot_bytes()
    }

    /// Returns the largest number of slots that the device can address.
    pub fn most_slots(gpu: &Gpu) -> u32 {
        let columns = columns(gpu);
        columns * columns * gpu.device.limits().max_texture_array_layers.min(1 << (24 - 10))
    }

    /// Makes room for at least `slots` slots where the device can, and keeps the present contents. Returns
    /// the numbers of the new slots.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`] when memory runs out; nothing has changed then.
    pub fn grow(&mut self, slots: u32) -> Result<Vec<Range<u32>>> {
        let size = shape(slots, columns(&self.gpu));
        let size = [size[0].max(self.size[0]), size[1].max(self.size[1]), size[2].max(self.size[2])];
        if size == self.size {
            return Ok(Vec::new());
        }
        let larger = self.gpu.guarded("making room for textures", || {
            let larger = texture(&self.gpu, size, self.storage);
            self.copy_to(&larger);
            Ok(larger)
        })?;
        let old = std::mem::replace(&mut self.size, size);
        self.views = views(&larger, self.storage);
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

    /// Writes slots; the write takes effect before any command submitted afterwards.
    pub fn write(&self, strip: &SlotStrip) {
        let [column, row, page] = place(strip.slot);
        let target = TexelCopyTextureInfo {
            origin: Origin3d { x: column * SLOT, y: row * SLOT, z: page },
            ..self.texture.as_image_copy()
        };
        // A row of blocks is four rows of texels.
        let rows = if self.storage == Storage::Plain { SLOT } else { SLOT / 4 };
        let layout = TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(strip.bytes.len() as u32 / rows),
            rows_per_image: Some(rows),
        };
        let size = Extent3d { width: strip.count * SLOT, height: SLOT, depth_or_array_layers: 1 };
        self.gpu.queue.write_texture(target, &strip.bytes, layout, size);
    }

    /// Writes a range of the page tables.
    pub fn write_entries(&self, entries: &[u32], range: Range<usize>) {
        let bytes = bytemuck::cast_slice(&entries[range.clone()]);
        self.gpu.queue.write_buffer(&self.pages, 4 * range.start as u64, bytes);
    }
}

/// Returns the column, row and page of a slot.
pub fn place(slot: u32) -> [u32; 3] {
    [slot % PAGE_SLOTS, slot / PAGE_SLOTS % PAGE_SLOTS, slot / (PAGE_SLOTS * PAGE_SLOTS)]
}

/// Returns the number of slots in a row of a page.
fn columns(gpu: &Gpu) -> u32 {
    (gpu.device.limits().max_texture_dimension_2d / SLOT).min(PAGE_SLOTS)
}

/// Returns columns, rows and pages for this many slots: one page grows by rows, then whole pages are added.
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

fn format(storage: Storage) -> TextureFormat {
    match storage {
        Storage::Plain => TextureFormat::Rgba8UnormSrgb,
        Storage::Compressed => TextureFormat::Bc7RgbaUnormSrgb,
    }
}

/// Returns the format by which values are read as stored, in sRGB.
fn stored_format(storage: Storage) -> TextureFormat {
    format(storage).remove_srgb_suffix()
}

fn texture(gpu: &Gpu, [columns, rows, pages]: [u32; 3], storage: Storage) -> Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("atlas"),
        size: Extent3d { width: columns * SLOT, height: rows * SLOT, depth_or_array_layers: pages },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: format(storage),
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST | TextureUsages::COPY_SRC,
        view_formats: &[stored_format(storage)],
    })
}

/// Creates the views in linear light and as stored; both are arrays even where there is one page.
fn views(texture: &Texture, storage: Storage) -> [TextureView; 2] {
    [format(storage), stored_format(storage)].map(|format| {
        texture.create_view(&TextureViewDescriptor {
            format: Some(format),
            dimension: Some(TextureViewDimension::D2Array),
            ..TextureViewDescriptor::default()
        })
    })
}
