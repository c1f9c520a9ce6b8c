//! What the tags of a TIFF say about its picture, judged before memory is taken.

use std::io::{Read, Seek};

use super::directory::{Directory, TiffDefect};
use crate::photo::CMYK;

/// How the samples of a pixel are colours.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Colours {
    /// One sample, black is 0 or, inverted, white is 0.
    Grey { inverted: bool },
    /// Red, green, blue.
    Rgb,
    /// An index into this list.
    Palette(Vec<[u8; 3]>),
    /// Cyan, magenta, yellow, black.
    Cmyk,
}

impl Colours {
    /// Returns the samples of a pixel that are its colour.
    pub fn samples(&self) -> usize {
        match self {
            Self::Grey { .. } | Self::Palette(_) => 1,
            Self::Rgb => 3,
            Self::Cmyk => 4,
        }
    }
}

/// What the opacity of a pixel is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Alpha {
    /// There is none.
    None,
    /// A sample beside colours that do not depend on it.
    Straight,
    /// A sample that the colours were multiplied with.
    Associated,
}

/// How the bytes of the picture are compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compression {
    None,
    Lzw,
    Deflate,
    PackBits,
    /// JPEG; `true` where its colours are YCbCr.
    Jpeg(bool),
}

/// The picture of a file.
#[derive(Debug)]
pub struct Layout {
    pub width: u32,
    pub height: u32,
    /// Bits of a sample: 1, 2, 4, 8 or 16.
    pub bits: usize,
    /// Samples of a pixel.
    pub samples: usize,
    pub colours: Colours,
    pub alpha: Alpha,
    /// The samples that are used: those of the colour, then alpha's.
    pub used: Vec<usize>,
    /// True where each sample has chunks of its own.
    pub is_planar: bool,
    pub compression: Compression,
    /// True where samples are stored as differences from the pixel before.
    pub differences: bool,
    /// Width and height of a strip or tile.
    pub chunk: [u32; 2],
    pub is_tiled: bool,
    /// Offset and length in bytes of each chunk.
    pub places: Vec<(u64, u64)>,
    /// The tables that the chunks of a JPEG share.
    pub jpeg_tables: Vec<u8>,
    /// Remarks for the user.
    pub notes: Vec<String>,
}

/// Why a file is not read: what was found, and what to do.
pub type Refusal = (TiffDefect, &'static str);

pub const DAMAGED: &str = "copy the file again, or save it again in an image editor";
const AS_RGB: &str = "save the photo as RGB or grey with 8 or 16 bits per channel";
const PLAIN: &str =
    "save the photo again as a TIFF without compression, or with LZW or ZIP (Deflate), or as PNG";

impl Layout {
    /// Reads the tags that say how the picture is stored.
    ///
    /// # Errors
    /// The file is damaged, or of a kind that is not read.
    pub fn read<R: Read + Seek>(file: &mut Directory<R>) -> Result<Self, Refusal> {
        let damaged = |defect: TiffDefect| (defect, DAMAGED);
        let number = |file: &mut Directory<R>, tag: u16, usual: u64| {
            file.number(tag).map(|number| number.unwrap_or(usual)).map_err(damaged)
        };
        // DNGVersion.
        if file.has(50706) {
            return Err(("a raw photo (DNG), which is not read".into(), super::super::kind::DEVELOP));
        }
        let size = [number(file, 256, 0)?, number(file, 257, 0)?];
        let [Ok(width), Ok(height)] = size.map(u32::try_from) else {
            return Err(damaged(format!("a picture of {} x {} pixels", size[0], size[1])));
        };
        if width == 0 || height == 0 {
            return Err(damaged("no width or no height".into()));
        }
        let samples = number(file, 277, 1)? as usize;
        let depths = file.numbers(258).map_err(damaged)?;
        let bits = depths.first().copied().unwrap_or(1) as usize;
        if depths.iter().any(|other| *other as usize != bits) {
            return Err((format!("channels of different depths ({depths:?} bits)"), AS_RGB));
        }
        let kinds = file.numbers(339).map_err(damaged)?;
        if let Some(kind) = kinds.iter().find(|kind| ![1, 4].contains(*kind)) {
            let kind = match kind {
                2 => "signed whole numbers",
                3 => "floating-point numbers",
                _ => "numbers of an unknown kind",
            };
            return Err((format!("samples that are {kind} of {bits} bits"), AS_RGB));
        }
        let photometric = number(file, 262, u64::MAX)?;
        let compression = compression(number(file, 259, 1)?, photometric)?;
        let colours = colours(file, photometric, compression, bits)?;
        let (alpha, used, mut notes) =
            alpha(&file.numbers(338).map_err(damaged)?, samples, colours.samples(), photometric)?;
        if colours == Colours::Cmyk {
            notes.push(CMYK.into());
        }
        let is_planar = samples > 1 && number(file, 284, 1)? == 2;
        let differences = match number(file, 317, 1)? {
            1 => false,
            2 if bits >= 8 => true,
            other => return Err((format!("predictor {other} with {bits} bits, which is not read"), PLAIN)),
        };
        if number(file, 266, 1)? == 2 && bits < 8 {
            return Err(("bits in reversed order, which are not read".into(), PLAIN));
        }
        if let Compression::Jpeg(_) = compression
            && (bits != 8 || is_planar || !matches!(samples, 1 | 3))
        {
            let found = format!("JPEG compression of {samples} channels with {bits} bits, which is not read");
            return Err((found, PLAIN));
        }
        let is_tiled = file.has(324);
        let chunk = match is_tiled {
            true => [number(file, 322, 0)?, number(file, 323, 0)?],
            false => [width.into(), number(file, 278, height.into())?.min(height.into())],
        };
        let [Ok(across), Ok(down)] = chunk.map(u32::try_from) else {
            return Err(damaged("tiles of more than 4,294,967,295 pixels a side".into()));
        };
        if across == 0 || down == 0 {
            return Err(damaged("strips or tiles without pixels".into()));
        }
        let (offsets, lengths) = if is_tiled { (324, 325) } else { (273, 279) };
        let offsets = file.numbers(offsets).map_err(damaged)?;
        let lengths = file.numbers(lengths).map_err(damaged)?;
        let planes = if is_planar { samples as u64 } else { 1 };
        let expected = u64::from(width.div_ceil(across)) * u64::from(height.div_ceil(down)) * planes;
        if (offsets.len() as u64, lengths.len() as u64) != (expected, expected) {
            let found = format!(
                "{} places and {} lengths of {expected} strips or tiles",
                offsets.len(),
                lengths.len()
            );
            return Err(damaged(found));
        }
        let jpeg_tables = file.bytes(347).map_err(damaged)?.unwrap_or_default();
        match file.pages() {
            1 => {}
            pages => notes.push(format!("it has {pages} pages or more, of which the first is read")),
        }
        Ok(Self {
            width,
            height,
            bits,
            samples,
            colours,
            alpha,
            used,
            is_planar,
            compression,
            differences,
            chunk: [across, down],
            is_tiled,
            places: offsets.into_iter().zip(lengths).collect(),
            jpeg_tables,
            notes,
        })
    }

    /// Returns the samples that a pixel has within a chunk.
    pub fn samples_in_chunk(&self) -> usize {
        if self.is_planar { 1 } else { self.samples }
    }

    /// Returns the bytes of a row of a chunk; `None` where they are too many to count.
    pub fn row_bytes(&self) -> Option<usize> {
        let bits = (self.chunk[0] as usize).checked_mul(self.samples_in_chunk())?.checked_mul(self.bits)?;
        Some(bits.div_ceil(8))
    }
}

fn compression(number: u64, photometric: u64) -> Result<Compression, Refusal> {
    let name = match number {
        1 => return Ok(Compression::None),
        5 => return Ok(Compression::Lzw),
        // YCbCr.
        7 => return Ok(Compression::Jpeg(photometric == 6)),
        8 | 32946 => return Ok(Compression::Deflate),
        32773 => return Ok(Compression::PackBits),
        2..=4 => "CCITT (fax)",
        6 => "JPEG of the old kind",
        33003 | 33004 | 33005 | 34712 => "JPEG 2000",
        34887 => "LERC",
        34925 => "LZMA",
        34892 => "lossy JPEG of DNG",
        34926 | 50000 => "ZSTD",
        34927 | 50001 => "WebP",
        34933 => "PNG",
        22610 | 34934 => "JPEG XR",
        50002 | 52546 => "JPEG XL",
        _ => "an unknown kind",
    };
    Err((format!("a TIFF whose compression ({name}, {number}) is not read"), PLAIN))
}

fn colours<R: Read + Seek>(
    file: &mut Directory<R>,
    photometric: u64,
    compression: Compression,
    bits: usize,
) -> Result<Colours, Refusal> {
    let (colours, depths): (Colours, &[usize]) = match photometric {
        0 | 1 => (Colours::Grey { inverted: photometric == 0 }, &[1, 2, 4, 8, 16]),
        2 => (Colours::Rgb, &[8, 16]),
        3 => {
            let map = file.numbers(320).map_err(|defect| (defect, DAMAGED))?;
            (Colours::Palette(palette(&map, bits)?), &[1, 2, 4, 8])
        }
        5 => (Colours::Cmyk, &[8, 16]),
        6 if matches!(compression, Compression::Jpeg(_)) => (Colours::Rgb, &[8]),
        other => {
            let name = match other {
                4 => "a mask of transparency",
                6 => "YCbCr colours without JPEG compression",
                8..=10 => "Lab colours",
                32803 | 34892 => "raw data of a camera's sensor",
                32844 | 32845 => "LogLuv colours",
                u64::MAX => "colours of which it does not say what they are",
                _ => "colours of an unknown kind",
            };
            return Err((format!("a TIFF with {name}, which is not read"), AS_RGB));
        }
    };
    if depths.contains(&bits) {
        return Ok(colours);
    }
    Err((format!("samples of {bits} bits, which are not read"), AS_RGB))
}

/// Returns the colours of a palette in 8 bits. Some programs wrote 8 bits into the 16 of the format.
fn palette(map: &[u64], bits: usize) -> Result<Vec<[u8; 3]>, Refusal> {
    let count = if bits <= 8 { 1 << bits } else { 0 };
    if count == 0 || map.len() != 3 * count {
        return Err((format!("a palette of {} numbers for {bits} bits", map.len()), DAMAGED));
    }
    let shift = if map.iter().all(|value| *value < 256) { 0 } else { 8 };
    Ok((0..count).map(|i| [0, 1, 2].map(|c| (map[c * count + i] >> shift) as u8)).collect())
}

/// Judges the samples beside the colour: which is opacity, and what is left out. Returns the samples that are used, and notes.
fn alpha(
    extra: &[u64],
    samples: usize,
    colour: usize,
    photometric: u64,
) -> Result<(Alpha, Vec<usize>, Vec<String>), Refusal> {
    let beside = samples.checked_sub(colour);
    let beside =
        beside.ok_or_else(|| (format!("{samples} channels where colours need {colour}"), DAMAGED))?;
    let (mut used, mut notes): (Vec<usize>, _) = ((0..colour).collect(), Vec::new());
    let stated = |kind: u64| extra.iter().take(beside).position(|extra| *extra == kind);
    let (alpha, at) = match (stated(2), stated(1)) {
        // Of several, the first that is said to be opacity.
        (Some(straight), associated) if associated.is_none_or(|it| it > straight) => {
            (Alpha::Straight, Some(straight))
        }
        (_, Some(associated)) => (Alpha::Associated, Some(associated)),
        (_, None) if beside == 1 && extra.is_empty() => {
            notes.push(
                "its last channel is taken for opacity, although the file does not say what it is".into(),
            );
            (Alpha::Straight, Some(0))
        }
        _ => (Alpha::None, None),
    };
    used.extend(at.map(|at| colour + at));
    match beside - usize::from(at.is_some()) {
        0 => {}
        1 => notes.push("1 channel beside its colours is left out".into()),
        more => notes.push(format!("{more} channels beside its colours are left out")),
    }
    if alpha == Alpha::Associated {
        // What black is multiplied with is only clear where black is 0.
        if !matches!(photometric, 1 | 2) {
            let found =
                "colours that are multiplied with opacity and are neither RGB nor grey with black as 0";
            return Err((found.into(), AS_RGB));
        }
        notes.push(
            "its colours are stored multiplied with opacity (associated alpha); they are divided by it"
                .into(),
        );
    }
    Ok((alpha, used, notes))
}
