//! A tiny builder of PSD files: what Photoshop, GIMP and Krita write and this project does not.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;

/// How a channel is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coding {
    Raw,
    Rle,
    Zip,
    Predicted,
}

/// A channel: its number, its coding, its samples.
pub type Channel = (i16, Coding, Vec<u16>);

#[derive(Debug, Clone)]
pub struct Layer {
    pub name: &'static str,
    /// x, y, width, height.
    pub rect: [i32; 4],
    pub channels: Vec<Channel>,
    pub blend: &'static [u8; 4],
    pub opacity: u8,
    pub clipping: u8,
    pub flags: u8,
    /// Rectangle, value outside, flags.
    pub mask: Option<([i32; 4], u8, u8)>,
    /// What follows in the mask's data; two zeros as a rule.
    pub mask_data: Vec<u8>,
    /// Blending ranges.
    pub ranges: Vec<u8>,
    pub blocks: Vec<(&'static [u8; 4], Vec<u8>)>,
}

impl Layer {
    pub fn new(name: &'static str, rect: [i32; 4], channels: Vec<Channel>) -> Self {
        Self {
            name,
            rect,
            channels,
            blend: b"norm",
            opacity: 255,
            clipping: 0,
            flags: 0,
            mask: None,
            mask_data: vec![0, 0],
            ranges: [0, 0, 255, 255].repeat(2),
            blocks: vec![],
        }
    }

    /// One of the two ends of a group: 1 above, 3 below.
    pub fn section(name: &'static str, kind: u32) -> Self {
        let blocks = vec![(b"lsct", kind.to_be_bytes().to_vec())];
        Self { blocks, ..Self::new(name, [0; 4], vec![]) }
    }
}

#[derive(Debug, Clone)]
pub struct File {
    /// Width and height.
    pub canvas: [u32; 2],
    pub depth: u16,
    /// 3: RGB, 1: grey.
    pub mode: u16,
    /// Layers in a block `Lr16` instead of the section's own list.
    pub in_block: bool,
    /// Zeros behind each block of a layer.
    pub padding: usize,
    pub resources: Vec<(u16, Vec<u8>)>,
    pub layers: Vec<Layer>,
}

impl File {
    pub fn new(depth: u16, layers: Vec<Layer>) -> Self {
        Self { canvas: [60, 50], depth, mode: 3, in_block: false, padding: 0, resources: vec![], layers }
    }

    pub fn bytes(&self) -> Vec<u8> {
        let mut out = b"8BPS\0\x01\0\0\0\0\0\0\0\x03".to_vec();
        for number in [self.canvas[1], self.canvas[0]] {
            out.extend(number.to_be_bytes());
        }
        out.extend(self.depth.to_be_bytes());
        out.extend(self.mode.to_be_bytes());
        out.extend([0; 4]);
        let mut resources = Vec::new();
        for (id, bytes) in &self.resources {
            resources.extend(b"8BIM");
            resources.extend(id.to_be_bytes());
            resources.extend([0, 0]);
            put_block(&mut resources, bytes);
            resources.resize(resources.len().next_multiple_of(2), 0);
        }
        put_block(&mut out, &resources);
        put_block(&mut out, &self.section());
        // The merged picture, which nobody reads: all black, as it is.
        let samples = 3 * self.canvas[0] as usize * self.canvas[1] as usize;
        out.resize(out.len() + 2 + samples * usize::from(self.depth / 8), 0);
        out
    }

    fn section(&self) -> Vec<u8> {
        let mut info = (self.layers.len() as i16).wrapping_neg().to_be_bytes().to_vec();
        let coded = |layer: &Layer| layer.channels.iter().map(|c| self.coded(layer, c)).collect::<Vec<_>>();
        let codes: Vec<Vec<Vec<u8>>> = self.layers.iter().map(coded).collect();
        self.layers.iter().zip(&codes).for_each(|(layer, codes)| self.put_record(&mut info, layer, codes));
        codes.iter().flatten().for_each(|code| info.extend(code));
        let mut section = Vec::new();
        if self.in_block {
            section.extend([0; 8]);
            section.extend(b"8BIMPatt\0\0\0\x03abc\0");
            section.extend(b"8BIMLr16");
            put_block(&mut section, &info);
        } else {
            put_block(&mut section, &info);
        }
        section
    }

    fn put_record(&self, out: &mut Vec<u8>, layer: &Layer, codes: &[Vec<u8>]) {
        put_rect(out, layer.rect);
        out.extend((layer.channels.len() as u16).to_be_bytes());
        for ((id, ..), code) in layer.channels.iter().zip(codes) {
            out.extend(id.to_be_bytes());
            out.extend((code.len() as u32).to_be_bytes());
        }
        out.extend(b"8BIM");
        out.extend(layer.blend);
        out.extend([layer.opacity, layer.clipping, layer.flags, 0]);
        let mut extra = Vec::new();
        let mut mask = Vec::new();
        if let Some((rect, outside, flags)) = layer.mask {
            put_rect(&mut mask, rect);
            mask.extend([outside, flags]);
            mask.extend(&layer.mask_data);
        }
        put_block(&mut extra, &mask);
        put_block(&mut extra, &layer.ranges);
        extra.push(layer.name.len() as u8);
        extra.extend(layer.name.as_bytes());
        extra.resize(extra.len().next_multiple_of(4), 0);
        for (key, bytes) in &layer.blocks {
            extra.extend(b"8BIM");
            extra.extend(*key);
            put_block(&mut extra, bytes);
            extra.extend(vec![0; self.padding]);
        }
        put_block(out, &extra);
    }

    fn coded(&self, layer: &Layer, (id, coding, samples): &Channel) -> Vec<u8> {
        let width = if *id <= -2 { layer.mask.unwrap().0[2] } else { layer.rect[2] } as usize;
        let wide = self.depth == 16;
        let stored = |samples: &[u16]| -> Vec<u8> {
            let bytes = samples.iter().flat_map(|s| s.to_be_bytes());
            if wide { bytes.collect() } else { samples.iter().map(|s| *s as u8).collect() }
        };
        let mut out = (*coding as u16).to_be_bytes().to_vec();
        match coding {
            Coding::Raw => out.extend(stored(samples)),
            Coding::Rle => {
                // Literals only, in headers of at most 128.
                let rows: Vec<Vec<u8>> = samples.chunks(width).map(|row| literals(&stored(row))).collect();
                rows.iter().for_each(|row| out.extend((row.len() as u16).to_be_bytes()));
                rows.iter().for_each(|row| out.extend(row));
            }
            Coding::Zip => out.extend(deflated(&stored(samples))),
            Coding::Predicted => {
                let differences: Vec<u16> = samples.chunks(width).flat_map(differences).collect();
                out.extend(deflated(&stored(&differences)));
            }
        }
        out
    }
}

fn differences(row: &[u16]) -> Vec<u16> {
    (0..row.len()).map(|i| if i == 0 { row[0] } else { row[i].wrapping_sub(row[i - 1]) }).collect()
}

fn literals(bytes: &[u8]) -> Vec<u8> {
    bytes.chunks(128).flat_map(|part| [&[part.len() as u8 - 1], part].concat()).collect()
}

pub fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// Top, left, bottom, right.
fn put_rect(out: &mut Vec<u8>, [x, y, w, h]: [i32; 4]) {
    [y, x, y + h, x + w].iter().for_each(|edge| out.extend(edge.to_be_bytes()));
}

fn put_block(out: &mut Vec<u8>, bytes: &[u8]) {
    out.extend((bytes.len() as u32).to_be_bytes());
    out.extend(bytes);
}

/// A name in Unicode, as a block holds it.
pub fn unicode(name: &str) -> Vec<u8> {
    let units: Vec<u16> = name.encode_utf16().collect();
    let mut out = (units.len() as u32).to_be_bytes().to_vec();
    units.iter().for_each(|unit| out.extend(unit.to_be_bytes()));
    out
}
