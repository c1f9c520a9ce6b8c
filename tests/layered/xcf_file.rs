//! A tiny builder of XCF files: what GIMP wrote in 25 years and this project does not.

use crate::psd_file::deflated;

/// How tiles are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coding {
    Raw = 0,
    Rle = 1,
    Zlib = 2,
}

#[derive(Debug, Clone)]
pub struct Layer {
    pub name: &'static str,
    pub size: (u32, u32),
    /// 0 RGB, 2 grey, 4 indexed; plus 1 with alpha.
    pub kind: u32,
    pub properties: Vec<(u32, Vec<u8>)>,
    /// Bytes as the file has them, pixel by pixel; none for a drawing of zeros.
    pub pixels: Vec<u8>,
    pub mask: Option<Vec<u8>>,
}

#[derive(Debug, Clone)]
pub struct File {
    pub version: u32,
    /// 0 RGB, 1 grey, 2 indexed.
    pub model: u32,
    pub precision: u32,
    /// Bytes of a sample.
    pub sample: usize,
    pub coding: Coding,
    pub properties: Vec<(u32, Vec<u8>)>,
    /// From the top.
    pub layers: Vec<Layer>,
}

impl Layer {
    pub fn new(name: &'static str, size: (u32, u32), kind: u32, pixels: Vec<u8>) -> Self {
        Self { name, size, kind, properties: vec![], pixels, mask: None }
    }
}

impl File {
    pub fn new(version: u32, layers: Vec<Layer>) -> Self {
        let (model, precision, sample, coding) = (0, 150, 1, Coding::Rle);
        Self { version, model, precision, sample, coding, properties: vec![], layers }
    }

    pub fn bytes(&self) -> Vec<u8> {
        let mut out = b"gimp xcf ".to_vec();
        out.extend(
            if self.version == 0 { "file\0".into() } else { format!("v{:03}\0", self.version) }.as_bytes(),
        );
        for number in [50, 60, self.model] {
            put(&mut out, number);
        }
        if self.version >= 4 {
            put(&mut out, self.precision);
        }
        let mut properties = vec![(17, vec![self.coding as u8])];
        properties.extend(self.properties.clone());
        put_properties(&mut out, &properties);
        let places_at = out.len();
        out.extend(vec![0; (self.layers.len() + 2) * self.pointer()]);
        for (number, layer) in self.layers.iter().enumerate() {
            let place = out.len();
            self.set_pointer(&mut out, places_at + number * self.pointer(), place);
            self.put_layer(&mut out, layer);
        }
        out
    }

    fn pointer(&self) -> usize {
        if self.version >= 11 { 8 } else { 4 }
    }

    fn set_pointer(&self, out: &mut [u8], at: usize, place: usize) {
        let bytes = (place as u64).to_be_bytes();
        out[at..at + self.pointer()].copy_from_slice(&bytes[8 - self.pointer()..]);
    }

    fn put_layer(&self, out: &mut Vec<u8>, layer: &Layer) {
        let samples = [3, 4, 1, 2, 1, 2][layer.kind as usize];
        for number in [layer.size.0, layer.size.1, layer.kind] {
            put(out, number);
        }
        put_text(out, layer.name);
        put_properties(out, &layer.properties);
        let pointers_at = out.len();
        out.extend(vec![0; 3 * self.pointer()]); // the last: no filters, since version 20
        let place = out.len();
        self.set_pointer(out, pointers_at, place);
        self.put_hierarchy(out, layer.size, samples * self.sample, &layer.pixels);
        if let Some(mask) = &layer.mask {
            let place = out.len();
            self.set_pointer(out, pointers_at + self.pointer(), place);
            put(out, layer.size.0);
            put(out, layer.size.1);
            put_text(out, "mask");
            put_properties(out, &[]);
            let pointer_at = out.len();
            out.extend(vec![0; self.pointer()]);
            let place = out.len();
            self.set_pointer(out, pointer_at, place);
            self.put_hierarchy(out, layer.size, self.sample, mask);
        }
    }

    /// With the second level that GIMP writes and nobody reads.
    fn put_hierarchy(&self, out: &mut Vec<u8>, (w, h): (u32, u32), bytes: usize, pixels: &[u8]) {
        for number in [w, h, bytes as u32] {
            put(out, number);
        }
        let pointers_at = out.len();
        out.extend(vec![0; 3 * self.pointer()]);
        let second = out.len();
        self.set_pointer(out, pointers_at + self.pointer(), second);
        put(out, w / 2);
        put(out, h / 2);
        out.extend(vec![0; self.pointer()]);
        let first = out.len();
        self.set_pointer(out, pointers_at, first);
        put(out, w);
        put(out, h);
        let tiles = tiles(w, h, bytes, pixels);
        let tiles_at = out.len();
        out.extend(vec![0; (tiles.len() + 1) * self.pointer()]);
        for (number, (tile, pixels)) in tiles.iter().enumerate() {
            let place = out.len();
            self.set_pointer(out, tiles_at + number * self.pointer(), place);
            out.extend(self.coded(tile, *pixels, bytes));
        }
    }

    fn coded(&self, tile: &[u8], pixels: usize, bytes: usize) -> Vec<u8> {
        match self.coding {
            Coding::Raw => tile.to_vec(),
            Coding::Zlib => deflated(tile),
            Coding::Rle => {
                let plane = |byte: usize| tile.iter().skip(byte).step_by(bytes).copied().collect::<Vec<u8>>();
                let literal = |plane: Vec<u8>| [&[128], &(pixels as u16).to_be_bytes()[..], &plane].concat();
                (0..bytes).flat_map(|byte| literal(plane(byte))).collect()
            }
        }
    }
}

/// Bytes of each tile and how many pixels it has.
fn tiles(w: u32, h: u32, bytes: usize, pixels: &[u8]) -> Vec<(Vec<u8>, usize)> {
    let mut tiles = Vec::new();
    for top in (0..h).step_by(64) {
        for left in (0..w).step_by(64) {
            let (right, bottom) = ((left + 64).min(w), (top + 64).min(h));
            let row = |y: u32| {
                let start = (y * w + left) as usize * bytes;
                pixels[start..start + (right - left) as usize * bytes].to_vec()
            };
            tiles.push(((top..bottom).flat_map(row).collect(), ((right - left) * (bottom - top)) as usize));
        }
    }
    tiles
}

fn put(out: &mut Vec<u8>, number: u32) {
    out.extend(number.to_be_bytes());
}

fn put_properties(out: &mut Vec<u8>, properties: &[(u32, Vec<u8>)]) {
    for (number, payload) in properties.iter().chain([&(0, vec![])]) {
        put(out, *number);
        put(out, payload.len() as u32);
        out.extend(payload);
    }
}

pub fn put_text(out: &mut Vec<u8>, text: &str) {
    put(out, text.len() as u32 + 1);
    out.extend(text.as_bytes());
    out.push(0);
}

/// The payload of a property that is a list of numbers.
pub fn numbers(numbers: &[u32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_be_bytes()).collect()
}

/// The payload of the property of parasites.
pub fn parasites(list: &[(&str, &[u8])]) -> Vec<u8> {
    let mut out = Vec::new();
    for (name, data) in list {
        put_text(&mut out, name);
        put(&mut out, 1);
        put(&mut out, data.len() as u32);
        out.extend(*data);
    }
    out
}
