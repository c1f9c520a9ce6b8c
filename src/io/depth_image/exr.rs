//! OpenEXR: one channel of a flat image, as 16- or 32-bit float or 32-bit whole numbers, in lines or tiles, compressed or not.

use std::path::Path;

use exr::block::lines::LineRef;
use exr::block::reader::ChunksReader;
use exr::block::{self, UncompressedBlock};
use exr::meta::attribute::{ChannelDescription, SampleType};
use exr::meta::header::Header;
use exr::prelude::{IntegerBounds, f16};

use super::depth_file::{COPY, DepthFile, check_size};
use quadratura_base::error::{Error, Result};
use quadratura_ldi::layout::LONGEST_SIDE;

/// The names of channels of depth, without those of layers before a dot; the first that is there counts.
const NAMES: [&str; 3] = ["z", "v", "depth"];

/// A byte of a compressed file is no more than this many bytes of the image, where the image is larger than [`SLACK`].
/// Deflate has that ratio at most.
const LARGEST_RATIO: u64 = 1032;

/// The image that any file may have, in bytes of all its channels: compressed images of one number are small.
const SLACK: u64 = 64 << 20;

/// The remedy for a file of a kind that is not read.
const REWRITE: &str =
    "save it as a flat image in full resolution, with the compression ZIP, PIZ, RLE or none";

/// A channel of one of the file's parts.
#[derive(Debug, Clone, Copy)]
struct ExrChannel {
    part: usize,
    channel: usize,
}

/// Reads the numbers of a file, rows from the top. Pixels of the picture that the file's data window leaves out have none.
pub(super) fn read(source: &mut DepthFile, size: [u32; 2]) -> Result<Vec<f32>> {
    let (path, length) = (source.path.clone(), source.length);
    let unreadable = |error: exr::error::Error| unreadable(&path, &error);
    let reader = block::read(&mut source.reader, false).map_err(unreadable)?;
    let chosen = chosen(&path, reader.headers())?;
    let header = reader.headers()[chosen.part].clone();
    let display = header.shared_attributes.display_window;
    check_size(&path, [display.size.0 as u64, display.size.1 as u64], size)?;
    check_header(&path, reader.headers(), &header, length)?;
    let wanted = |_: &_, _, index: block::BlockIndex| {
        index.layer == chosen.part && (index.level.0, index.level.1) == (0, 0)
    };
    let mut blocks = reader.filter_chunks(false, wanted).map_err(unreadable)?.sequential_decompressor(false);
    let mut picture = PictureValues::new(&header, display, size);
    while let Some(block) = blocks.decompress_next_block() {
        picture.add(&block.map_err(unreadable)?, chosen, &header).map_err(unreadable)?;
    }
    if picture.filled < picture.expected {
        let found = format!("{} of {} numbers; the file is cut short", picture.filled, picture.expected);
        return Err(Error::input(&path, "", found, COPY));
    }
    Ok(picture.values)
}

/// Returns the error of the package with what helps.
fn unreadable(path: &Path, error: &exr::error::Error) -> Error {
    let remedy = match error {
        exr::error::Error::NotSupported(_) => REWRITE,
        _ => COPY,
    };
    Error::input(path, "", format!("the OpenEXR file cannot be decoded ({error})"), remedy)
}

/// Returns a channel's name without those of layers before it, in lower case.
fn last_name(channel: &ChannelDescription) -> String {
    let name = channel.name.to_string().to_lowercase();
    name.rsplit('.').next().unwrap_or_default().to_owned()
}

/// Returns the channel of depth: the one of a known name, or the only one.
fn chosen(path: &Path, headers: &[Header]) -> Result<ExrChannel> {
    let channels: Vec<(ExrChannel, &ChannelDescription)> = (headers.iter().enumerate())
        .flat_map(|(part, header)| {
            let channels = header.channels.list.iter().enumerate();
            channels.map(move |(channel, description)| (ExrChannel { part, channel }, description))
        })
        .collect();
    if let [(only, _)] = channels[..] {
        return Ok(only);
    }
    for name in NAMES {
        let named: Vec<_> = channels.iter().filter(|(_, channel)| last_name(channel) == name).collect();
        let plain = named.iter().find(|(_, channel)| channel.name.to_string().to_lowercase() == name);
        match (named.as_slice(), plain) {
            (_, Some((chosen, _))) | ([(chosen, _)], None) => return Ok(*chosen),
            ([], None) => {}
            (several, None) => {
                let names: Vec<_> = several.iter().map(|(_, channel)| channel.name.to_string()).collect();
                let found = format!("several channels of depth: {}", names.join(", "));
                return Err(Error::input(
                    path,
                    "header",
                    found,
                    "save the file with the one that belongs to the picture",
                ));
            }
        }
    }
    let names: Vec<_> = channels.iter().take(12).map(|(_, channel)| channel.name.to_string()).collect();
    let found = format!("the channels {}; expected `Z`, `V` or `depth`, or only one", names.join(", "));
    Err(Error::input(path, "header", found, "save the depth as a channel of one of these names"))
}

/// Checks what is needed before memory is taken.
fn check_header(path: &Path, headers: &[Header], header: &Header, length: u64) -> Result<()> {
    if header.deep {
        let found = "a deep image, with several depths a pixel; expected a flat one";
        return Err(Error::input(path, "header", found, "save it as a flat image"));
    }
    // Decoders of other compressions take as much memory as a chunk asks for.
    use exr::compression::Compression::{B44, B44A, PIZ, PXR24, RLE, Uncompressed, ZIP1, ZIP16};
    if !matches!(header.compression, Uncompressed | RLE | ZIP1 | ZIP16 | PIZ | PXR24 | B44 | B44A) {
        let found = format!("{}; expected none, or RLE, ZIP, PIZ, PXR24 or B44", header.compression);
        return Err(Error::input(path, "header", found, REWRITE));
    }
    if header.channels.list.iter().any(|channel| (channel.sampling.0, channel.sampling.1) != (1, 1)) {
        let found = "channels of several resolutions; expected a number for each pixel";
        return Err(Error::input(path, "header", found, "save it without reduced channels"));
    }
    let (width, height) = (header.layer_size.0 as u64, header.layer_size.1 as u64);
    let most = u64::from(LONGEST_SIDE);
    if width > most || height > most {
        let found = format!("a data window of {width} x {height} pixels; expected sides of at most {most}");
        return Err(Error::input(path, "header", found, "save it without what is outside of the picture"));
    }
    let bytes = width * height * header.channels.bytes_per_pixel as u64;
    let chunks = headers.iter().fold(0u64, |sum, header| sum.saturating_add(header.chunk_count as u64));
    if chunks.saturating_mul(8) > length || bytes > SLACK + LARGEST_RATIO * length {
        let found = format!("{length} bytes; {bytes} bytes of pixels in {chunks} blocks cannot be in them");
        return Err(Error::input(path, "", format!("the file is cut short: {found}"), COPY));
    }
    Ok(())
}

/// The numbers of a picture while blocks of the data window are put into it.
struct PictureValues {
    values: Vec<f32>,
    size: [i64; 2],
    /// Where the data window begins in the picture.
    start: [i64; 2],
    /// The pixels of the data window, and how many of them were read.
    expected: u64,
    filled: u64,
}

impl PictureValues {
    fn new(header: &Header, display: IntegerBounds, size: [u32; 2]) -> Self {
        let position = header.own_attributes.layer_position;
        let start = [(position.0, display.position.0), (position.1, display.position.1)];
        Self {
            values: vec![f32::NAN; size[0] as usize * size[1] as usize],
            size: size.map(i64::from),
            start: start.map(|(data, display)| i64::from(data) - i64::from(display)),
            expected: header.layer_size.0 as u64 * header.layer_size.1 as u64,
            filled: 0,
        }
    }

    /// Puts the lines of the chosen channel into the picture.
    fn add(
        &mut self,
        block: &UncompressedBlock,
        chosen: ExrChannel,
        header: &Header,
    ) -> exr::error::UnitResult {
        let lines = block.lines(&header.channels).filter(|line| line.location.channel == chosen.channel);
        for line in lines {
            let numbers = numbers(line, header.channels.list[chosen.channel].sample_type)?;
            self.filled += numbers.len() as u64;
            let y = line.location.position.1 as i64 + self.start[1];
            if !(0..self.size[1]).contains(&y) {
                continue;
            }
            let first = line.location.position.0 as i64 + self.start[0];
            for (x, number) in (first..).zip(numbers) {
                if (0..self.size[0]).contains(&x) {
                    self.values[(y * self.size[0] + x) as usize] = number;
                }
            }
        }
        Ok(())
    }
}

/// Returns the numbers of a line.
fn numbers(line: LineRef<'_>, kind: SampleType) -> exr::error::Result<Vec<f32>> {
    match kind {
        SampleType::F16 => line.read_samples::<f16>().map(|sample| Ok(sample?.to_f32())).collect(),
        SampleType::F32 => line.read_samples::<f32>().collect(),
        SampleType::U32 => line.read_samples::<u32>().map(|sample| Ok(sample? as f32)).collect(),
    }
}
