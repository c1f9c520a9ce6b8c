//! Reads layered depth images in fifty lines and without this project's code, as another program would: `read_ldi FILE [PICTURE]`
//! prints the depth complexity of each image, and writes the first layer of the last one as a PPM file. `docs/formats.md`
//! describes the formats; files must not be packed here (`packing` is `none`).

use std::{env, error::Error, fs};

use serde_json::Value;

fn main() -> Result<(), Box<dyn Error>> {
    let file = fs::read(env::args().nth(1).ok_or("usage: read_ldi FILE [PICTURE]")?)?;
    let (mut rest, mut picture) = (&file[..], Vec::new());
    while let Some(end) = rest.iter().position(|byte| *byte == b'\n') {
        let line: Value = serde_json::from_slice(&rest[..end])?;
        rest = &rest[end + 1..];
        match line["format"].as_str() {
            // The images of a file of several follow its line, each as in a file of its own.
            Some("quadratura-ldi-set") => {}
            Some("quadratura-ldi") if line["packing"] == "none" => picture = read(&line, &mut rest)?,
            _ => return Err("this is no layered depth image, or it is packed".into()),
        }
    }
    Ok(env::args().nth(2).map_or(Ok(()), |path| fs::write(path, picture))?)
}

/// Reads the image whose first line is given; returns its first layer as a PPM file. `rest` is what follows.
fn read(line: &Value, rest: &mut &[u8]) -> Result<Vec<u8>, Box<dyn Error>> {
    let number = |value: &Value| value.as_u64().map(|n| n as usize).ok_or("a number is missing");
    let [width, height] = [number(&line["levels"][0]["width"])?, number(&line["levels"][0]["height"])?];
    let mut picture = format!("P6 {width} {height} 255\n").into_bytes();
    let (mut depth_pixels, mut layered) = (0, 0);
    for (index, level) in line["levels"].as_array().ok_or("levels are missing")?.iter().enumerate() {
        for (chunk, top) in
            level["chunks"].as_array().ok_or("chunks are missing")?.iter().zip((0..).step_by(64))
        {
            let content = rest.split_off(..number(&chunk["bytes"])?).ok_or("the file is cut short")?;
            if index > 0 {
                continue; // Levels after the first one are coarser.
            }
            // Streams: counts, inverse depths (4 bytes), colours (4), surfaces (2), splats (1), at multiples of 8 bytes.
            let (n, positions) =
                (number(&chunk["depth_pixels"])?, width * height.saturating_sub(top).min(64));
            let counts = content.get(..positions).ok_or("a stream is cut short")?;
            let colours = content.get(positions.next_multiple_of(8) + (4 * n).next_multiple_of(8)..);
            let mut colours = colours.ok_or("a stream is cut short")?;
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
