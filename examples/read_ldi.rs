//! Reads layered depth images without this project's code, as another program would: `read_ldi FILE [PICTURE]` prints the depth
//! complexity of each image in a file, and writes the first layer of the first one as a PPM file. `docs/formats.md` describes
//! the formats, of single images and of several, which must not be packed here (`packing` is `none`).

use std::error::Error;
use std::fs;

use serde_json::Value;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let bytes = fs::read(arguments.first().ok_or("usage: read_ldi FILE [PICTURE]")?)?;
    let (line, mut rest) = first_line(&bytes)?;
    if line["format"] != "quadratura-ldi-set" {
        return read(&bytes, arguments.get(1));
    }
    // Each image is as in a file of its own, one after the other.
    for (index, image) in line["images"].as_array().ok_or("the images are missing")?.iter().enumerate() {
        let (image, after) =
            rest.split_at_checked(number(&image["bytes"])?).ok_or("the file is cut short")?;
        read(image, arguments.get(1).filter(|_| index == 0))?;
        rest = after;
    }
    Ok(())
}

/// Returns the first line and what is after it.
fn first_line(bytes: &[u8]) -> Result<(Value, &[u8])> {
    let end = bytes.iter().position(|byte| *byte == b'\n').ok_or("there is no first line")?;
    Ok((serde_json::from_slice(&bytes[..end])?, &bytes[end + 1..]))
}

fn number(value: &Value) -> Result<usize> {
    Ok(value.as_u64().ok_or("a number is missing")? as usize)
}

/// Reads a single image.
fn read(bytes: &[u8], picture_file: Option<&String>) -> Result<()> {
    let (line, mut rest) = first_line(bytes)?;
    if line["format"] != "quadratura-ldi" || line["version"] != 1 || line["packing"] != "none" {
        return Err("it is no layered depth image of version 1 that is not packed".into());
    }
    let level = &line["levels"][0];
    let (width, height) = (number(&level["width"])?, number(&level["height"])?);
    let mut picture = Vec::with_capacity(3 * width * height);
    let (mut depth_pixels, mut layered) = (0usize, 0usize);
    for (index, chunk) in level["chunks"].as_array().ok_or("the chunks are missing")?.iter().enumerate() {
        let (size, n) = (number(&chunk["bytes"])?, number(&chunk["depth_pixels"])?);
        let (content, after) = rest.split_at_checked(size).ok_or("the file is cut short")?;
        rest = after;
        let rows = 64.min(height - index * 64);
        // Streams: counts, inverse depths (4 bytes), colours (4), surfaces (2), splats (1), each at a multiple of 8 bytes.
        let counts = content.get(..width * rows).ok_or("a stream is cut short")?;
        let colours_at = (width * rows).next_multiple_of(8) + (4 * n).next_multiple_of(8);
        let colours = content.get(colours_at..colours_at + 4 * n).ok_or("a stream is cut short")?;
        let mut at = 0;
        for count in counts.iter().map(|count| usize::from(*count)) {
            // The nearest depth pixel is the first one; positions without any are black.
            let colour = colours.get(4 * at..4 * at + 3).filter(|_| count > 0).unwrap_or(&[0; 3]);
            picture.extend_from_slice(colour);
            at += count;
            layered += usize::from(count > 0);
        }
        depth_pixels += n;
    }
    let complexity = depth_pixels as f64 / layered.max(1) as f64;
    println!("{width} x {height}, {depth_pixels} depth pixels, depth complexity {complexity:.3}");
    if let Some(path) = picture_file {
        let mut content = format!("P6 {width} {height} 255\n").into_bytes();
        content.extend_from_slice(&picture);
        fs::write(path, content)?;
    }
    Ok(())
}
