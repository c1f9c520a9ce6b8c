//! What PNG, JPEG and WebP say beside their pixels that is not applied, so that it can be told.

use std::io::{BufRead, ErrorKind, Read, Result, Seek, SeekFrom};

use image::ImageFormat;

/// The most segments or chunks of a file that are looked at.
const MOST: usize = 10_000;

/// Returns remarks about parameters that change what a picture shows and are not applied. What is damaged is left to the decoder.
/// The input is at its beginning, and is again afterwards.
///
/// # Errors
/// Those of the system.
pub(super) fn unapplied(format: ImageFormat, input: &mut (impl BufRead + Seek)) -> Result<Vec<String>> {
    let found = match format {
        ImageFormat::Png => of_png(input),
        ImageFormat::Jpeg => of_jpeg(input),
        ImageFormat::WebP => of_webp(input),
        _ => Ok(Vec::new()),
    };
    input.rewind()?;
    match found {
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => Ok(Vec::new()),
        found => found,
    }
}

/// Looks at the chunks of a PNG before its pixels. A later one of `sRGB`, `iCCP` and `cICP` takes precedence over `gAMA`.
fn of_png(input: &mut (impl BufRead + Seek)) -> Result<Vec<String>> {
    /// The gamma of sRGB in hundred thousandths, and the largest deviation that is rounding.
    const SRGB: (u32, u32) = (45_455, 500);
    /// The transfer functions of `cICP` that are those of sRGB, or hardly differ.
    const LIKE_SRGB: [u8; 5] = [1, 6, 13, 14, 15];
    let (mut gamma, mut colours, mut notes) = (None, false, Vec::new());
    input.seek(SeekFrom::Start(8))?;
    for _ in 0..MOST {
        let length = u32::from_be_bytes(bytes(input)?);
        let kind: [u8; 4] = bytes(input)?;
        let mut read = 0;
        match &kind {
            b"IDAT" | b"IEND" => break,
            b"sRGB" | b"iCCP" => colours = true,
            b"gAMA" if length == 4 => {
                gamma = Some(u32::from_be_bytes(bytes(input)?));
                read = 4;
            }
            b"cICP" if length == 4 => {
                let [primaries, transfer, ..] = bytes::<4>(input)?;
                (colours, read) = (true, 4);
                if primaries != 1 || !LIKE_SRGB.contains(&transfer) {
                    notes.push(format!(
                        "its colours are those of cICP (primaries {primaries}, transfer {transfer}), which is not applied: they are \
                         read as sRGB; save it with an ICC profile"
                    ));
                }
            }
            b"acTL" => notes.push("it is animated; its first picture is read".into()),
            _ => {}
        }
        input.seek_relative(i64::from(length) - read + 4)?;
    }
    if let Some(gamma) = gamma.filter(|gamma| !colours && gamma.abs_diff(SRGB.0) > SRGB.1) {
        notes.push(format!(
            "its gamma of {} is not applied: it is read as sRGB; save it as sRGB, or with an ICC profile",
            f64::from(gamma) / 100_000.0
        ));
    }
    Ok(notes)
}

/// Looks for the head of a JPEG's picture, which says how many inks it has.
fn of_jpeg(input: &mut (impl BufRead + Seek)) -> Result<Vec<String>> {
    input.seek(SeekFrom::Start(2))?;
    for _ in 0..MOST {
        input.skip_until(0xFF)?;
        let [kind] = bytes(input)?;
        match kind {
            0x00 | 0x01 | 0xD0..=0xD8 | 0xFF => {}
            0xD9 | 0xDA => break,
            _ => {
                let length = i64::from(u16::from_be_bytes(bytes(input)?));
                // Heads of frames; the three others of this range are tables.
                if matches!(kind, 0xC0..=0xCF) && !matches!(kind, 0xC4 | 0xC8 | 0xCC) {
                    let [.., components] = bytes::<6>(input)?;
                    return Ok(match components {
                        4 => vec![super::CMYK.into()],
                        _ => Vec::new(),
                    });
                }
                input.seek_relative((length - 2).max(0))?;
            }
        }
    }
    Ok(Vec::new())
}

fn of_webp(input: &mut (impl BufRead + Seek)) -> Result<Vec<String>> {
    const ANIMATED: u8 = 2;
    input.seek(SeekFrom::Start(12))?;
    let [v, p, eight, x, _, _, _, _, flags] = bytes(input)?;
    let is_animated = [v, p, eight, x] == *b"VP8X" && flags & ANIMATED != 0;
    Ok(if is_animated { vec!["it is animated; its first picture is read".into()] } else { Vec::new() })
}

fn bytes<const N: usize>(input: &mut impl Read) -> Result<[u8; N]> {
    let mut bytes = [0; N];
    input.read_exact(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    fn of_chunks(chunks: &[(&[u8; 4], &[u8])]) -> Vec<String> {
        let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
        for (kind, content) in chunks {
            file.extend((content.len() as u32).to_be_bytes());
            file.extend([&kind[..], content, &[0; 4]].concat());
        }
        let mut input = Cursor::new(file);
        let found = unapplied(ImageFormat::Png, &mut input).unwrap();
        assert_eq!(input.position(), 0);
        found
    }

    #[test]
    fn another_gamma_is_told_unless_something_better_says_which_colours_these_are() {
        let gamma = |gamma: u32| gamma.to_be_bytes();
        let (linear, usual) = (gamma(100_000), gamma(45_455));
        let end: (&[u8; 4], &[u8]) = (b"IDAT", b"...");
        assert!(of_chunks(&[(b"IHDR", &[0; 13]), (b"gAMA", &linear), end])[0].contains("its gamma of 1 is"));
        assert!(of_chunks(&[(b"gAMA", &usual), end]).is_empty());
        assert!(of_chunks(&[(b"gAMA", &linear), (b"sRGB", &[0]), end]).is_empty());
        assert!(of_chunks(&[end, (b"gAMA", &linear)]).is_empty(), "it comes too late");
        let wide = of_chunks(&[(b"cICP", &[9, 16, 0, 1]), (b"gAMA", &linear), end]);
        assert!(wide.len() == 1 && wide[0].contains("primaries 9, transfer 16"), "{wide:?}");
        assert!(of_chunks(&[(b"cICP", &[1, 13, 0, 1]), end]).is_empty());
        assert!(of_chunks(&[(b"acTL", &[0; 8]), end])[0].contains("animated"));
        assert!(of_chunks(&[(b"gAMA", &linear)])[..].is_empty(), "a file that ends there is the decoder's");
    }

    #[test]
    fn inks_of_a_jpeg_and_pictures_that_move_are_told() {
        let jpeg = |components: u8| {
            let head = [0xFF, 0xC2, 0, 17, 8, 0, 4, 0, 4, components];
            let bytes = [&[0xFF, 0xD8, 0xFF, 0xE1, 0, 4, 0xFF, 0xC0][..], &head, &[0; 12]].concat();
            unapplied(ImageFormat::Jpeg, &mut Cursor::new(bytes)).unwrap()
        };
        assert!(jpeg(4)[0].contains("CMYK") && jpeg(3).is_empty() && jpeg(1).is_empty());
        let webp = |flags: u8| {
            let bytes = [&b"RIFF\0\0\0\0WEBPVP8X\x0a\0\0\0"[..], &[flags], &[0; 9]].concat();
            unapplied(ImageFormat::WebP, &mut Cursor::new(bytes)).unwrap()
        };
        assert!(webp(2)[0].contains("animated") && webp(16).is_empty());
    }
}
