//! A writer of TIFFs of every layout that is read, for the tests of the reader.

use std::io::Write;

use flate2::Compression as Level;
use flate2::write::ZlibEncoder;
use weezl::BitOrder;

/// How a file is laid out.
#[derive(Debug, Clone)]
pub struct Written {
    pub big_endian: bool,
    pub is_big: bool,
    pub tiled: bool,
    pub planar: bool,
    pub compression: u16,
    pub differences: bool,
    pub bits: u16,
    pub samples: u16,
    pub photometric: u16,
    pub extra: Vec<u16>,
    /// More tags: number, type (3 for 16 bits, 4 for 32, 7 for bytes) and values. They replace those of the same number.
    pub more: Vec<(u16, u16, Vec<u32>)>,
}

/// Width and height: no multiple of a tile's side.
pub const SIZE: [u32; 2] = [37, 21];
const TILE: [u32; 2] = [16, 16];
const ROWS: u32 = 8;

impl Default for Written {
    fn default() -> Self {
        Self {
            big_endian: false,
            is_big: false,
            tiled: false,
            planar: false,
            compression: 1,
            differences: false,
            bits: 8,
            samples: 3,
            photometric: 2,
            extra: Vec::new(),
            more: Vec::new(),
        }
    }
}

impl Written {
    /// Returns a file whose sample `s` at (x, y) is `value(x, y, s)`.
    pub fn file(&self, value: impl Fn(u32, u32, u16) -> u16) -> Vec<u8> {
        let [width, height] = SIZE;
        let chunk = if self.tiled { TILE } else { [width, ROWS] };
        let planes: Vec<Vec<u16>> = match self.planar {
            true => (0..self.samples).map(|s| vec![s]).collect(),
            false => vec![(0..self.samples).collect()],
        };
        let mut chunks = Vec::new();
        for plane in &planes {
            for top in (0..height).step_by(chunk[1] as usize) {
                for left in (0..width).step_by(chunk[0] as usize) {
                    let rows = if self.tiled { chunk[1] } else { chunk[1].min(height - top) };
                    let row = |y: u32| {
                        let of = |x: u32, s: u16| if x < width && y < height { value(x, y, s) } else { 0 };
                        let samples =
                            (left..left + chunk[0]).flat_map(|x| plane.iter().map(move |s| of(x, *s)));
                        self.row(samples.collect(), plane.len())
                    };
                    chunks.push(self.compressed(&(top..top + rows).flat_map(row).collect::<Vec<u8>>()));
                }
            }
        }
        self.assembled(chunk, &chunks)
    }

    /// Returns the bytes of a row.
    fn row(&self, mut samples: Vec<u16>, step: usize) -> Vec<u8> {
        if self.differences {
            for at in (step..samples.len()).rev() {
                samples[at] = samples[at].wrapping_sub(samples[at - step]);
            }
        }
        match self.bits {
            16 => samples.iter().flat_map(|sample| self.number(u64::from(*sample), 2)).collect(),
            8 => samples.iter().map(|sample| *sample as u8).collect(),
            bits => {
                let per_byte = usize::from(8 / bits);
                let packed = samples.chunks(per_byte).map(|group| {
                    let place = |i: usize| 8 - bits as usize * (i + 1);
                    group.iter().enumerate().fold(0u8, |byte, (i, sample)| byte | (*sample as u8) << place(i))
                });
                packed.collect()
            }
        }
    }

    fn compressed(&self, bytes: &[u8]) -> Vec<u8> {
        match self.compression {
            5 => weezl::encode::Encoder::with_tiff_size_switch(BitOrder::Msb, 8).encode(bytes).unwrap(),
            8 => {
                let mut encoder = ZlibEncoder::new(Vec::new(), Level::default());
                encoder.write_all(bytes).unwrap();
                encoder.finish().unwrap()
            }
            // Runs of equal bytes, then one other byte.
            32773 => {
                let mut packed = Vec::new();
                let mut rest = bytes;
                while let Some(&first) = rest.first() {
                    let run = rest.iter().take(128).take_while(|byte| **byte == first).count();
                    packed.extend(if run > 1 { [(1 - run as i16) as u8, first] } else { [0, first] });
                    rest = &rest[run..];
                }
                packed
            }
            _ => bytes.to_vec(),
        }
    }

    fn number(&self, number: u64, size: usize) -> Vec<u8> {
        if self.big_endian {
            number.to_be_bytes()[8 - size..].to_vec()
        } else {
            number.to_le_bytes()[..size].to_vec()
        }
    }

    fn assembled(&self, chunk: [u32; 2], chunks: &[Vec<u8>]) -> Vec<u8> {
        let header = if self.is_big { 16 } else { 8 };
        let mut data = Vec::new();
        let mut places = Vec::new();
        for chunk in chunks {
            places.push((header + data.len()) as u32);
            data.extend(chunk);
        }
        let lengths: Vec<u32> = chunks.iter().map(|chunk| chunk.len() as u32).collect();
        let mut tags = vec![
            (256, 4, vec![SIZE[0]]),
            (257, 4, vec![SIZE[1]]),
            (258, 3, vec![self.bits.into(); self.samples.into()]),
            (259, 3, vec![self.compression.into()]),
            (262, 3, vec![self.photometric.into()]),
            (277, 3, vec![self.samples.into()]),
            (284, 3, vec![if self.planar { 2 } else { 1 }]),
            (317, 3, vec![if self.differences { 2 } else { 1 }]),
        ];
        match self.tiled {
            true => tags.extend([
                (322, 3, vec![chunk[0]]),
                (323, 3, vec![chunk[1]]),
                (324, 4, places),
                (325, 4, lengths),
            ]),
            false => tags.extend([(273, 4, places), (278, 3, vec![chunk[1]]), (279, 4, lengths)]),
        }
        if !self.extra.is_empty() {
            tags.push((338, 3, self.extra.iter().map(|kind| u32::from(*kind)).collect()));
        }
        tags.retain(|(tag, ..)| !self.more.iter().any(|(other, ..)| other == tag));
        tags.extend(self.more.clone());
        tags.sort();
        self.with_directory(header, data, &tags)
    }

    fn with_directory(&self, header: usize, mut data: Vec<u8>, tags: &[(u16, u16, Vec<u32>)]) -> Vec<u8> {
        let offset = if self.is_big { 8 } else { 4 };
        let mut entries = Vec::new();
        for (tag, kind, values) in tags {
            let size = match kind {
                3 => 2,
                4 => 4,
                _ => 1,
            };
            let mut value: Vec<u8> =
                values.iter().flat_map(|value| self.number((*value).into(), size)).collect();
            if value.len() > offset {
                let at = header + data.len();
                data.extend(&value);
                value = self.number(at as u64, offset);
            }
            value.resize(offset, 0);
            entries.extend(self.number((*tag).into(), 2));
            entries.extend(self.number((*kind).into(), 2));
            entries.extend(self.number(values.len() as u64, offset));
            entries.extend(value);
        }
        let mut file = if self.big_endian { b"MM".to_vec() } else { b"II".to_vec() };
        file.extend(self.number(if self.is_big { 43 } else { 42 }, 2));
        if self.is_big {
            file.extend([self.number(8, 2), self.number(0, 2)].concat());
        }
        file.extend(self.number((header + data.len()) as u64, offset));
        file.extend(data);
        file.extend(self.number(tags.len() as u64, if self.is_big { 8 } else { 2 }));
        file.extend(entries);
        file.extend(self.number(0, offset));
        file
    }
}
