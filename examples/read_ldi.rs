//! Reads layered depth images without this project's code, as another program would: `read_ldi FILE [PICTURE]` prints the depth
//! complexity of each image, and writes the first layer of the last one as a PPM file. `docs/formats.md` describes the formats.
//! Files that are not packed take the first fifty lines; what follows unpacks colours.

use std::{env, error::Error, fs, io::Read};

use flate2::read::ZlibDecoder;
use serde_json::Value;

fn main() -> Result<(), Box<dyn Error>> {
    let picture = picture_of(&fs::read(env::args().nth(1).ok_or("usage: read_ldi FILE [PICTURE]")?)?)?;
    Ok(env::args().nth(2).map_or(Ok(()), |path| fs::write(path, picture))?)
}

/// Reads the images of a file; returns the first layer of the last one as a PPM file.
pub fn picture_of(file: &[u8]) -> Result<Vec<u8>, Box<dyn Error>> {
    let (mut rest, mut picture) = (file, Vec::new());
    while let Some(end) = rest.iter().position(|byte| *byte == b'\n') {
        let line: Value = serde_json::from_slice(&rest[..end])?;
        rest = &rest[end + 1..];
        match line["format"].as_str() {
            // The images of a file of several follow its line, each as in a file of its own.
            Some("quadratura-ldi-set") => {}
            Some("quadratura-ldi") => picture = read(&line, &mut rest)?,
            _ => return Err("this is no layered depth image".into()),
        }
    }
    Ok(picture)
}

/// Reads the image whose first line is given; returns its first layer as a PPM file. `rest` is what follows.
fn read(line: &Value, rest: &mut &[u8]) -> Result<Vec<u8>, Box<dyn Error>> {
    let number = |value: &Value| value.as_u64().map(|n| n as usize).ok_or("a number is missing");
    let [width, height] = [number(&line["levels"][0]["width"])?, number(&line["levels"][0]["height"])?];
    if width == 0 || height == 0 {
        return Err("the image is empty".into());
    }
    let mut picture = format!("P6 {width} {height} 255\n").into_bytes();
    let (mut depth_pixels, mut layered) = (0, 0);
    for (index, level) in line["levels"].as_array().ok_or("levels are missing")?.iter().enumerate() {
        let chunks = level["chunks"].as_array().ok_or("chunks are missing")?;
        for (chunk, top) in chunks.iter().zip((0..).step_by(64)) {
            let mut content = rest.split_off(..number(&chunk["bytes"])?).ok_or("the file is cut short")?;
            if index > 0 {
                continue; // Levels after the first one are coarser.
            }
            let n = number(&chunk["depth_pixels"])?;
            // Streams: counts, inverse depths (4 bytes), colours (4), surfaces (2), splats (1).
            let lengths = [width * height.saturating_sub(top).min(64), 4 * n, 4 * n, 2 * n, n];
            let packed = match line["packing"].as_str() {
                Some("none") => false,
                Some("deflate") => true,
                _ => return Err("the packing is unknown".into()),
            };
            let streams = lengths.map(|length| stream(&mut content, length, packed));
            let [counts, _, colours, surfaces, _] = streams;
            let (counts, mut colours) = (counts?, colours?);
            if packed {
                colours = unpacked(&counts, &colours, &surfaces?, width).ok_or("counts do not add up")?;
            }
            let mut colours = &colours[..];
            for count in counts.iter().map(|count| usize::from(*count)) {
                let of_ray = colours.split_off(..4 * count).ok_or("a stream is cut short")?;
                // The nearest depth pixel is the first one; positions without any are black.
                picture.extend(of_ray.get(..3).unwrap_or(&[0; 3]));
                layered += usize::from(count > 0);
            }
            depth_pixels += n;
        }
    }
    let complexity = depth_pixels as f64 / f64::max(layered as f64, 1.0);
    println!("{width} x {height}, {depth_pixels} depth pixels, depth complexity {complexity:.3}");
    Ok(picture)
}

/// Takes a stream of `length` bytes from a chunk, as it is or inflated. Each ends at a multiple of 8 bytes.
fn stream(content: &mut &[u8], length: usize, packed: bool) -> Result<Vec<u8>, String> {
    let mut take = |bytes: usize| content.split_off(..bytes).ok_or("a stream is cut short");
    if !packed {
        let stream = take(length.next_multiple_of(8))?;
        return Ok(stream[..length].to_vec());
    }
    let stored = take(8)?.try_into().map_or(0, u64::from_le_bytes) as usize;
    let data = take(stored.checked_next_multiple_of(8).ok_or("a length is wrong")?)?;
    let mut stream = Vec::new();
    let inflated = ZlibDecoder::new(data).take(length as u64).read_to_end(&mut stream);
    let read = inflated.map_err(|error| error.to_string())?;
    (read == length).then_some(stream).ok_or_else(|| "a stream is cut short".into())
}

/// Adds the colours of a chunk to those that are expected: that of the same surface in the same column of the row above, the
/// nearest of them, else that of the one before. `None` where the counts are of another number of depth pixels.
fn unpacked(counts: &[u8], colours: &[u8], surfaces: &[u8], width: usize) -> Option<Vec<u8>> {
    let n = surfaces.len() / 2;
    let mut unpacked: Vec<[u8; 4]> = Vec::with_capacity(n);
    let mut known: Vec<u16> = Vec::with_capacity(n);
    let mut above = vec![0..0; width];
    for row in counts.chunks(width) {
        let mut before = None;
        for (above, count) in above.iter_mut().zip(row) {
            let first = unpacked.len();
            for at in first..first + usize::from(*count) {
                let difference = u16::from_be_bytes([*surfaces.get(at)?, *surfaces.get(n + at)?]);
                let surface = difference.wrapping_add(before.map_or(0, |before: usize| known[before]));
                let same = above.clone().find(|other| known[*other] == surface);
                let expected = same.or(before).map_or([0; 4], |other| unpacked[other]);
                let [r, g, b, a] = [0, 1, 2, 3].map(|part| colours[part * n + at]);
                let differences = [r.wrapping_add(g), g, b.wrapping_add(g), a];
                unpacked.push(std::array::from_fn(|c| expected[c].wrapping_add(differences[c])));
                known.push(surface);
                before = Some(at);
            }
            *above = first..unpacked.len();
        }
    }
    (unpacked.len() == n).then(|| unpacked.into_flattened())
}
