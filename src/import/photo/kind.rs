//! Which format a picture's file is in, by its content; names and endings only help where content says nothing.

use std::path::Path;

use image::ImageFormat;

use quadratura_base::error::Error;

/// The extensions of photos, in lower case.
pub const EXTENSIONS: [&str; 6] = ["jpg", "jpeg", "png", "tif", "tiff", "webp"];

/// The extensions of raw photos, in lower case; the content of most is a TIFF of another kind.
const RAW: [&str; 22] = [
    "dng", "nef", "nrw", "cr2", "cr3", "crw", "arw", "srf", "sr2", "raf", "orf", "rw2", "pef", "srw", "x3f",
    "3fr", "fff", "iiq", "mos", "mrw", "erf", "gpr",
];

/// The extensions of other pictures that are not read, in lower case.
const OTHERS: [&str; 36] = [
    "heic", "heif", "hif", "avif", "jxl", "jp2", "j2k", "jpf", "jpx", "jxr", "wdp", "exr", "hdr", "bmp",
    "dib", "gif", "tga", "psd", "psb", "xcf", "kra", "ora", "dds", "qoi", "ppm", "pgm", "pbm", "pnm", "pfm",
    "ico", "svg", "pdf", "dpx", "cin", "sgi", "jfif",
];

/// The remedy for a picture in a format that is not read.
const CONVERT: &str =
    "convert it to JPEG, PNG, TIFF or WebP of the same size, under the same name (with any ending)";

/// The remedy for a raw photo.
pub const DEVELOP: &str = "develop it to JPEG, PNG, TIFF or WebP of the size that the cameras have, under the same name (with any ending)";

/// What a file is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A picture in a format that is read.
    Photo(ImageFormat),
    /// Something else, with its name, and what to do.
    Other(&'static str, &'static str),
    /// Nothing that is known.
    Unknown,
}

/// The number of bytes at a file's start by which its kind is known.
pub const START: usize = 64;

/// Recognises a file by its start, and by its name where that alone says nothing.
pub fn kind_of(path: &Path, start: &[u8]) -> Kind {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let is_raw = RAW.contains(&ending.as_str());
    match start {
        [b'I', b'I', 42, 0, ..] if start.get(8..10) == Some(b"CR") => {
            Kind::Other("a raw photo (CR2)", DEVELOP)
        }
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] if is_raw => {
            Kind::Other("a raw photo of a camera", DEVELOP)
        }
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => Kind::Photo(ImageFormat::Tiff),
        [0xFF, 0xD8, 0xFF, ..] => Kind::Photo(ImageFormat::Jpeg),
        [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1A, b'\n', ..] => Kind::Photo(ImageFormat::Png),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Kind::Photo(ImageFormat::WebP),
        [_, _, _, _, b'f', b't', b'y', b'p', brands @ ..] => of_brands(brands),
        _ => other(start).unwrap_or(match ending.as_str() {
            // Targa and many raw formats begin with nothing of their own.
            "tga" => Kind::Other("a Targa image (TGA)", CONVERT),
            _ if is_raw => Kind::Other("a raw photo of a camera", DEVELOP),
            _ => Kind::Unknown,
        }),
    }
}

/// Recognises files of the ISO base media format by their brands: the main one, a version, and those that it is compatible
/// with.
fn of_brands(brands: &[u8]) -> Kind {
    let has = |wanted: &[&[u8]]| brands.chunks_exact(4).any(|brand| wanted.contains(&brand));
    let main = &brands[..brands.len().min(4)];
    match () {
        () if main == b"crx " => Kind::Other("a raw photo (CR3)", DEVELOP),
        () if has(&[b"avif", b"avis"]) => Kind::Other("an AVIF image", CONVERT),
        () if has(&[b"heic", b"heix", b"hevc", b"hevx", b"heim", b"heis", b"hevm", b"hevs"]) => {
            Kind::Other("a HEIC image", CONVERT)
        }
        () if has(&[b"mif1", b"mif2", b"msf1", b"miaf"]) => Kind::Other("a HEIF image", CONVERT),
        () => Kind::Other("a video (MP4 or QuickTime)", "give its frames as photos of their own"),
    }
}

/// Recognises other kinds by their first bytes.
fn other(start: &[u8]) -> Option<Kind> {
    const IS: &[(&[u8], &str)] = &[
        (b"\x00\x00\x00\x0CJXL \r\n\x87\n", "a JPEG XL image"),
        (b"\xFF\x0A", "a JPEG XL image"),
        (b"\x00\x00\x00\x0CjP  \r\n\x87\n", "a JPEG 2000 image"),
        (b"\xFF\x4F\xFF\x51", "a JPEG 2000 image"),
        (b"II\xBC", "a JPEG XR image"),
        (b"v/1\x01", "an OpenEXR image"),
        (b"#?RADIANCE", "a Radiance HDR image"),
        (b"#?RGBE", "a Radiance HDR image"),
        (b"BM", "a BMP image"),
        (b"GIF8", "a GIF image"),
        (b"8BPS", "a Photoshop document (PSD)"),
        (b"gimp xcf", "a GIMP image (XCF)"),
        (b"PK\x03\x04", "a ZIP archive, such as Krita's and OpenRaster's documents"),
        (b"DDS ", "a DirectDraw surface (DDS)"),
        (b"qoif", "a QOI image"),
        (b"SDPX", "a DPX image"),
        (b"XPDS", "a DPX image"),
        (b"\x80\x2A\x5F\xD7", "a Cineon image"),
        (b"\x01\xDA", "an SGI image"),
        (b"\x00\x00\x01\x00", "an icon (ICO)"),
        (b"SIMPLE  =", "a FITS image"),
        (b"%PDF", "a PDF document"),
        (b"<svg", "an SVG drawing"),
        (b"<?xml", "an XML or SVG document"),
    ];
    const RAWS: &[(&[u8], &str)] = &[
        (b"IIU\x00", "a raw photo (RW2)"),
        (b"IIRO", "a raw photo (ORF)"),
        (b"IIRS", "a raw photo (ORF)"),
        (b"MMOR", "a raw photo (ORF)"),
        (b"FUJIFILMCCD-RAW", "a raw photo (RAF)"),
        (b"FOVb", "a raw photo (X3F)"),
        (b"\x00MRM", "a raw photo (MRW)"),
        (b"II\x1A\x00\x00\x00HEAPCCDR", "a raw photo (CRW)"),
    ];
    let begins = |(signature, _): &&(&[u8], &str)| start.starts_with(signature);
    if let Some((_, name)) = IS.iter().find(begins) {
        return Some(Kind::Other(name, CONVERT));
    }
    if let Some((_, name)) = RAWS.iter().find(begins) {
        return Some(Kind::Other(name, DEVELOP));
    }
    let lower = start.to_ascii_lowercase();
    let text = lower.trim_ascii_start();
    match text {
        [b'p', b'1'..=b'7' | b'f', after, ..] if after.is_ascii_whitespace() => {
            Some(Kind::Other("a portable pixmap (PBM, PGM, PPM, PAM or PFM)", CONVERT))
        }
        _ if text.starts_with(b"<!doctype html") || text.starts_with(b"<html") => {
            Some(Kind::Other("a web page, not a photo", "download the photo itself"))
        }
        _ if text.starts_with(b"version https://git-lfs") => {
            Some(Kind::Other("a pointer of Git LFS, not the photo itself", "fetch it with `git lfs pull`"))
        }
        _ => None,
    }
}

/// Makes the error about a file that is no photo in a format that is read.
pub fn refusal(path: &Path, kind: Kind) -> Error {
    let Kind::Other(name, remedy) = kind else {
        let found = "not a JPEG, PNG, TIFF or WebP image";
        return Error::input(path, "", found, "convert the photo to one of these");
    };
    // What is called a JPEG and is none surprises most.
    let lies = path.extension().is_some_and(|ending| is_one_of(ending, &EXTENSIONS));
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    let although = if lies { format!(", although it is called .{ending}") } else { String::new() };
    Error::input(path, "", format!("this is {name}{although}, which is not read"), remedy)
}

/// Returns a note where a photo's ending names another format than its content.
pub fn lying_ending(path: &Path, format: ImageFormat) -> Option<String> {
    let ending = path.extension()?.to_string_lossy().to_lowercase();
    let named = ImageFormat::from_extension(&ending);
    let is_known =
        named.is_some() || is_one_of(path.extension()?, &RAW) || is_one_of(path.extension()?, &OTHERS);
    let is_true = named == Some(format) || (ending == "jfif" && format == ImageFormat::Jpeg);
    let name = match format {
        ImageFormat::Jpeg => "JPEG",
        ImageFormat::Png => "PNG",
        ImageFormat::Tiff => "TIFF",
        _ => "WebP",
    };
    (is_known && !is_true)
        .then(|| format!("the file is called .{ending}, but is a {name} image; it is read as that"))
}

/// Returns true for the ending of a photo in a format that is read.
pub fn is_photo_ending(ending: &str) -> bool {
    is_one_of(ending.as_ref(), &EXTENSIONS)
}

/// Returns true for the ending of any picture, read or not.
pub fn is_picture_ending(ending: &str) -> bool {
    is_photo_ending(ending) || is_one_of(ending.as_ref(), &RAW) || is_one_of(ending.as_ref(), &OTHERS)
}

fn is_one_of(ending: &std::ffi::OsStr, known: &[&str]) -> bool {
    known.iter().any(|known| ending.eq_ignore_ascii_case(known))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_what_its_content_says_whatever_it_is_called() {
        let named = |path: &str, start: &[u8]| match kind_of(Path::new(path), start) {
            Kind::Photo(format) => format!("{format:?}"),
            Kind::Other(name, _) => name.to_owned(),
            Kind::Unknown => "unknown".to_owned(),
        };
        let photos: [(&[u8], &str); 6] = [
            (b"\xFF\xD8\xFF\xE1", "Jpeg"),
            (b"\x89PNG\r\n\x1A\n\0", "Png"),
            (b"RIFF\x10\0\0\0WEBPVP8 ", "WebP"),
            (b"II+\0\x08\0\0\0", "Tiff"),
            (b"MM\0+\0\x08\0\0", "Tiff"),
            (b"MM\0*\0\0\0\x08", "Tiff"),
        ];
        for (start, name) in photos {
            for path in ["a.HEIC", "a", "a.jpeg.png", "a.txt"] {
                assert_eq!(named(path, start), name, "{path}");
            }
        }
        let others: [(&[u8], &str); 9] = [
            (b"\0\0\0\x18ftypheic\0\0\0\0mif1heic", "a HEIC image"),
            (b"\0\0\0\x1Cftypmif1\0\0\0\0mif1avifmiaf", "an AVIF image"),
            (b"\0\0\0\x18ftypmif1\0\0\0\0mif1miaf", "a HEIF image"),
            (b"\0\0\0\x18ftypcrx \0\0\0\x01crx isom", "a raw photo (CR3)"),
            (b"\0\0\0\x14ftypqt  \0\0\0\0qt  ", "a video (MP4 or QuickTime)"),
            (b"II*\0\x10\0\0\0CR\x02\0", "a raw photo (CR2)"),
            (b"P6\n4 3\n", "a portable pixmap (PBM, PGM, PPM, PAM or PFM)"),
            (b"\n<!DOCTYPE HTML>", "a web page, not a photo"),
            (b"version https://git-lfs.github.com/spec/v1\n", "a pointer of Git LFS, not the photo itself"),
        ];
        for (start, name) in others {
            assert_eq!(named("a.jpg", start), name);
        }
        assert_eq!(named("a.NEF", b"MM\0*\0\0\0\x08"), "a raw photo of a camera");
        assert_eq!(named("a.tga", b"\0\0\x02\0\0\0\0\0"), "a Targa image (TGA)");
        assert_eq!(named("a.jpg", b"\0\0\x02\0\0\0\0\0"), "unknown");
    }

    #[test]
    fn an_ending_that_lies_is_told_and_no_ending_is_no_lie() {
        let note = |path: &str| lying_ending(Path::new(path), ImageFormat::Jpeg);
        assert!(note("a.HEIC").unwrap().contains(".heic, but is a JPEG image"));
        assert!(note("a.jpeg.png").is_some() && note("a.dng").is_some());
        for true_or_none in ["a", "a.JPG", "a.jpeg", "a.jfif", "IMG.2024"] {
            assert_eq!(note(true_or_none), None, "{true_or_none}");
        }
        let said = refusal(Path::new("a.jpg"), kind_of(Path::new("a.jpg"), b"GIF89a")).to_string();
        assert!(
            said.contains("a GIF image, although it is called .jpg, which is not read; convert it"),
            "{said}"
        );
    }
}
