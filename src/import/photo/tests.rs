//! Tests that every format and depth is read unchanged, and that unsuitable files are refused.

use std::path::PathBuf;

use image::codecs::jpeg::JpegEncoder;
use image::{DynamicImage, ImageBuffer, ImageEncoder};
use proptest::prelude::*;

use super::*;

const SIZE: (u32, u32) = (6, 4);

/// Returns a picture of every supported kind.
fn kinds() -> Vec<DynamicImage> {
    let (w, h) = SIZE;
    let at = |x: u32, y: u32| (x * 40 + y * 7) as u16 * 257;
    vec![
        DynamicImage::ImageLuma8(ImageBuffer::from_fn(w, h, |x, y| image::Luma([at(x, y) as u8]))),
        DynamicImage::ImageLuma16(ImageBuffer::from_fn(w, h, |x, y| image::Luma([at(x, y)]))),
        DynamicImage::ImageLumaA8(ImageBuffer::from_fn(w, h, |x, y| image::LumaA([x as u8, at(x, y) as u8]))),
        DynamicImage::ImageRgb8(ImageBuffer::from_fn(w, h, |x, y| image::Rgb([x as u8, 9, y as u8]))),
        DynamicImage::ImageRgb16(ImageBuffer::from_fn(w, h, |x, y| image::Rgb([at(x, y), 300, 7]))),
        DynamicImage::ImageRgba8(ImageBuffer::from_fn(w, h, |x, y| image::Rgba([x as u8, 1, 2, y as u8]))),
        DynamicImage::ImageRgba16(ImageBuffer::from_fn(w, h, |x, y| image::Rgba([at(x, y), 1, 2, 999]))),
    ]
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn put(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

fn encoded(image: &DynamicImage, format: ImageFormat) -> image::ImageResult<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format)?;
    Ok(bytes.into_inner())
}

fn jpeg() -> Vec<u8> {
    encoded(&kinds()[3], ImageFormat::Jpeg).unwrap()
}

/// Returns a JPEG with an EXIF block that holds only the orientation.
fn jpeg_turned(orientation: u8) -> Vec<u8> {
    let mut block = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0".to_vec();
    block.extend([orientation, 0, 0, 0, 0, 0, 0, 0]);
    jpeg_with(&block)
}

/// Returns a JPEG with an EXIF block.
fn jpeg_with(block: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0xFF, 0xD8, 0xFF, 0xE1];
    bytes.extend((block.len() as u16 + 8).to_be_bytes());
    bytes.extend(b"Exif\0\0");
    bytes.extend(block);
    bytes.extend(&jpeg()[2..]);
    bytes
}

fn expected(image: &DynamicImage) -> Samples {
    let alpha = image.color().has_alpha();
    let deep = image.color().bytes_per_pixel() / image.color().channel_count() == 2;
    match (deep, alpha) {
        (false, false) => Samples::U8(image.to_rgb8().into_raw()),
        (false, true) => Samples::U8(image.to_rgba8().into_raw()),
        (true, false) => Samples::U16(image.to_rgb16().into_raw()),
        (true, true) => Samples::U16(image.to_rgba16().into_raw()),
    }
}

#[test]
fn every_kind_of_every_lossless_format_comes_back_bit_for_bit() {
    let folder = Folder::new();
    let mut pngs = 0;
    for format in [ImageFormat::Png, ImageFormat::Tiff, ImageFormat::WebP] {
        for image in kinds() {
            // An encoder converts or refuses what its format cannot hold; PNG holds every kind.
            let Ok(bytes) = encoded(&image, format) else { continue };
            let stored = image::load_from_memory(&bytes).unwrap();
            pngs += usize::from(format == ImageFormat::Png && stored == image);
            let pixels = read_photo(&folder.put("photo", &bytes), SIZE.0, SIZE.1).unwrap();
            assert_eq!(pixels.samples, expected(&stored), "{format:?} {:?}", image.color());
            assert_eq!(pixels.channels, if stored.color().has_alpha() { 4 } else { 3 });
        }
    }
    assert_eq!(pngs, kinds().len());
}

#[test]
fn a_jpeg_is_read_as_its_decoder_gives_it() {
    let folder = Folder::new();
    let pixels = read_photo(&folder.put("a.jpg", &jpeg()), SIZE.0, SIZE.1).unwrap();
    let decoded = image::load_from_memory(&jpeg()).unwrap();
    assert_eq!(pixels.samples, Samples::U8(decoded.to_rgb8().into_raw()));
    assert_eq!((pixels.channels, pixels.bits()), (3, 8));
}

#[test]
fn orientation_is_applied_only_where_the_camera_demands_it() {
    let folder = Folder::new();
    let path = folder.put("a.jpg", &jpeg_turned(6));
    let stored = read_photo(&path, SIZE.0, SIZE.1).unwrap();
    assert_eq!(stored, read_photo(&folder.put("b.jpg", &jpeg()), SIZE.0, SIZE.1).unwrap());
    let notes = check_photo(&path, SIZE.0, SIZE.1).unwrap().notes;
    assert!(notes[0].contains("orientation 6 is not applied"), "{notes:?}");

    let turned = read_photo(&path, SIZE.1, SIZE.0).unwrap();
    assert_eq!(turned.rgba16(0, 0), stored.rgba16(0, SIZE.1 - 1));
    assert_eq!(turned.rgba16(SIZE.1 - 1, 0), stored.rgba16(0, 0));
    let notes = check_photo(&path, SIZE.1, SIZE.0).unwrap().notes;
    assert!(notes[0].contains("orientation 6 is applied"), "{notes:?}");
}

#[test]
fn the_exposure_that_a_camera_wrote_down_is_found_in_the_header() {
    let folder = Folder::new();
    // A sixtieth of a second, f/4, ISO 400.
    let fields = [(0x829a, 1, Some(60)), (0x829d, 4, Some(1)), (0x8827, 400, None)];
    let path = folder.put("a.jpg", &jpeg_with(&super::exif::tests::block(&fields)));
    let found = check_photo(&path, SIZE.0, SIZE.1).unwrap();
    let exposure = found.exposure.unwrap();
    assert!((exposure.seconds * 60.0 - 1.0).abs() < 1e-12 && exposure.iso == 400.0, "{exposure:?}");
    assert_eq!(super::read_exposure(&path), found.exposure);
    let plain = folder.put("b.jpg", &jpeg());
    assert_eq!(check_photo(&plain, SIZE.0, SIZE.1).unwrap().exposure, None);
}

#[test]
fn a_photo_of_another_size_is_refused_with_both_sizes() {
    let folder = Folder::new();
    let path = folder.put("a.jpg", &jpeg());
    let error = check_photo(&path, 12, 8).unwrap_err().to_string();
    assert!(error.contains("6 x 4 pixels where the camera has 12 x 8"), "{error}");
    let error = read_photo(&path, SIZE.1, SIZE.0).unwrap_err().to_string();
    assert!(error.contains("turn the photo by 90 degrees"), "{error}");
}

#[test]
fn files_that_are_no_photos_are_refused() {
    let folder = Folder::new();
    for bytes in [&b""[..], b"GIF89a", b"\xFF\xD8\xFF\xE0", &jpeg()[..20]] {
        let path = folder.put("a.jpg", bytes);
        assert!(matches!(check_photo(&path, 6, 4), Err(Error::Input { .. })));
        assert!(matches!(read_photo(&path, 6, 4), Err(Error::Input { .. })));
    }
    assert!(matches!(check_photo(folder.0.path(), 6, 4), Err(Error::Input { .. })));
    assert!(matches!(check_photo(&folder.0.path().join("none"), 6, 4), Err(Error::Io { .. })));
}

#[test]
fn a_jpeg_that_is_cut_is_refused_by_its_header_already_and_one_with_more_behind_it_is_read() {
    let folder = Folder::new();
    let bytes = jpeg();
    for cut in [bytes.len() - 1, bytes.len() - 4] {
        let path = folder.put("a.jpg", &bytes[..cut]);
        for error in [check_photo(&path, 6, 4).unwrap_err(), read_photo(&path, 6, 4).unwrap_err()] {
            assert!(error.to_string().contains("cut short"), "{error}");
        }
    }
    let path = folder.put("a.jpg", &[&bytes[..], b"more"].concat());
    check_photo(&path, 6, 4).unwrap();
    read_photo(&path, 6, 4).unwrap();
}

#[test]
fn a_png_that_is_cut_is_refused_by_its_header_already_and_one_with_more_behind_it_is_read() {
    let folder = Folder::new();
    let bytes = encoded(&kinds()[4], ImageFormat::Png).unwrap();
    for cut in [8, 20, bytes.len() - 20, bytes.len() - 13, bytes.len() - 5] {
        let path = folder.put("a.png", &bytes[..cut]);
        for error in [check_photo(&path, 6, 4).unwrap_err(), read_photo(&path, 6, 4).unwrap_err()] {
            assert!(error.to_string().contains("the PNG is cut short"), "{cut}: {error}");
        }
    }
    let path = folder.put("a.png", &[&bytes[..], b"more"].concat());
    check_photo(&path, 6, 4).unwrap();
    read_photo(&path, 6, 4).unwrap();
}

#[test]
fn a_png_that_claims_to_be_huge_is_refused_by_its_header() {
    let folder = Folder::new();
    let mut bytes = encoded(&kinds()[3], ImageFormat::Png).unwrap();
    bytes[16..24].copy_from_slice(&[0, 0, 0xFF, 0xFF, 0, 0, 0xFF, 0xFF]);
    let error = read_photo(&folder.put("a.png", &bytes), 6, 4).unwrap_err().to_string();
    assert!(error.contains("65535") || error.contains("cannot be decoded"), "{error}");
}

#[test]
fn a_file_far_larger_than_the_photo_is_refused() {
    let folder = Folder::new();
    let path = folder.put("a.jpg", &jpeg());
    std::fs::File::options().write(true).open(&path).unwrap().set_len(1 << 30).unwrap();
    let error = read_photo(&path, 6, 4).unwrap_err().to_string();
    assert!(error.contains("1024 megabytes"), "{error}");
}

#[test]
fn the_profile_is_kept_for_rgb_and_dropped_for_grey() {
    let folder = Folder::new();
    let mut profile = vec![0; 128];
    profile[16..20].copy_from_slice(b"RGB ");
    for (kind, kept) in [(3, true), (0, false)] {
        let image = &kinds()[kind];
        profile[16..20].copy_from_slice(if kept { b"RGB " } else { b"GRAY" });
        let mut bytes = Vec::new();
        let mut encoder = JpegEncoder::new(&mut bytes);
        encoder.set_icc_profile(profile.clone()).unwrap();
        encoder.encode_image(image).unwrap();
        let path = folder.put("a.jpg", &bytes);
        assert_eq!(read_photo(&path, 6, 4).unwrap().icc.is_some(), kept);
        assert_eq!(check_photo(&path, 6, 4).unwrap().notes.is_empty(), kept);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn damaged_photos_never_panic(
        format in 0usize..4,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let format = [ImageFormat::Jpeg, ImageFormat::Png, ImageFormat::Tiff, ImageFormat::WebP][format];
        let mut bytes = encoded(&kinds()[3], format).unwrap();
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        let folder = Folder::new();
        let path = folder.put("photo", &bytes);
        let _ = (check_photo(&path, SIZE.0, SIZE.1), read_photo(&path, SIZE.0, SIZE.1));
    }
}
