//! Tests with TIFFs of every layout that the tests write themselves.

mod written;

use std::path::PathBuf;

use self::written::{SIZE, Written};
use crate::photo::{check_photo, picture_size, read_photo};
use quadratura_base::error::Result;
use quadratura_base::scene::synthetic::Rng;
use quadratura_base::scene::{PhotoPixels, Samples};

struct TestPhotoFolder(tempfile::TempDir);

impl TestPhotoFolder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn put(&self, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join("photo.tif");
        std::fs::write(&path, bytes).unwrap();
        path
    }

    fn read(&self, bytes: &[u8]) -> Result<PhotoPixels> {
        read_photo(&self.put(bytes), SIZE[0], SIZE[1])
    }

    fn notes(&self, bytes: &[u8]) -> Vec<String> {
        check_photo(&self.put(bytes), SIZE[0], SIZE[1]).unwrap().notes
    }

    fn refused(&self, bytes: &[u8]) -> String {
        let path = self.put(bytes);
        check_photo(&path, SIZE[0], SIZE[1]).and_then(|_| self.read(bytes)).unwrap_err().to_string()
    }
}

/// A value of 16 bits that differs from pixel to pixel and from sample to sample, with runs of equal ones.
fn value(x: u32, y: u32, sample: u16) -> u16 {
    ((x / 3 * 2111 + y * 977) as u16).wrapping_add(sample.wrapping_mul(19_001))
}

/// The same in fewer bits.
fn value_of(bits: u16) -> impl Fn(u32, u32, u16) -> u16 + Copy {
    move |x, y, sample| value(x, y, sample) >> (16 - bits)
}

/// The samples that a photo has, one list a pixel in 16 bits.
fn pixels(photo: &PhotoPixels) -> Vec<Vec<u16>> {
    let wide: Vec<u16> = match &photo.samples {
        Samples::U8(samples) => samples.iter().map(|sample| u16::from(*sample)).collect(),
        Samples::U16(samples) => samples.clone(),
    };
    wide.chunks_exact(photo.channels).map(<[u16]>::to_vec).collect()
}

fn expected(of: impl Fn(u32, u32) -> Vec<u16>) -> Vec<Vec<u16>> {
    (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y))).map(|(x, y)| of(x, y)).collect()
}

#[test]
fn every_layout_of_the_same_picture_gives_the_same_pixels() {
    let folder = TestPhotoFolder::new();
    for case in 0..512u32 {
        let is = |bit: u32| case >> bit & 1 == 1;
        let layout = Written {
            big_endian: is(0),
            is_big: is(1),
            tiled: is(2),
            planar: is(3),
            differences: is(4),
            bits: if is(5) { 16 } else { 8 },
            samples: if is(6) { 4 } else { 3 },
            extra: if is(6) { vec![2] } else { Vec::new() },
            compression: [1, 5, 8, 32773][(case >> 7) as usize],
            ..Written::default()
        };
        let of = value_of(layout.bits);
        let photo = folder.read(&layout.file(of)).unwrap();
        let whole = expected(|x, y| (0..layout.samples).map(|s| of(x, y, s)).collect());
        assert_eq!(pixels(&photo), whole, "{layout:?}");
        assert_eq!(photo.bits(), layout.bits as u8, "{layout:?}");
    }
}

#[test]
fn associated_alpha_is_divided_out_and_straight_alpha_is_not() {
    let folder = TestPhotoFolder::new();
    for case in 0..16u32 {
        let is = |bit: u32| case >> bit & 1 == 1;
        let (grey, bits) = (is(0), if is(1) { 16 } else { 8 });
        let full = (1u32 << bits) - 1;
        let layout = Written {
            planar: is(2),
            tiled: is(3),
            bits,
            samples: if grey { 2 } else { 4 },
            photometric: if grey { 1 } else { 2 },
            extra: vec![1],
            ..Written::default()
        };
        let alpha_at = layout.samples - 1;
        let alpha = |x: u32| if x == 5 { 0 } else { full - x * full / 64 };
        let straight = value_of(bits);
        let stored = |x: u32, y: u32, s: u16| match s == alpha_at {
            true => alpha(x) as u16,
            false => ((u32::from(straight(x, y, s)) * alpha(x) + full / 2) / full) as u16,
        };
        let bytes = layout.file(stored);
        let found = pixels(&folder.read(&bytes).unwrap());
        let truth = expected(|x, y| {
            let colours = (0..3).map(|c| if x == 5 { 0 } else { straight(x, y, if grey { 0 } else { c }) });
            colours.chain([alpha(x) as u16]).collect()
        });
        for (found, truth) in found.iter().zip(&truth) {
            // Half a step of what is stored, over the least opacity of 0.43.
            let near = found.iter().zip(truth).all(|(a, b)| a.abs_diff(*b) <= 2);
            assert!(near && found[3] == truth[3], "{layout:?}: {found:?}, expected {truth:?}");
        }
        let notes = folder.notes(&bytes);
        assert!(notes.len() == 1 && notes[0].contains("associated alpha"), "{notes:?}");
        let straight = Written { extra: vec![2], ..layout }.file(stored);
        let found = pixels(&folder.read(&straight).unwrap());
        let as_stored = expected(|x, y| {
            let colours = (0..3).map(|c| stored(x, y, if grey { 0 } else { c }));
            colours.chain([alpha(x) as u16]).collect()
        });
        assert_eq!(found, as_stored);
        assert!(folder.notes(&straight).is_empty());
    }
}

#[test]
fn channels_beside_the_colours_are_told_and_only_what_is_said_to_be_opacity_is_it() {
    let folder = TestPhotoFolder::new();
    let of = value_of(8);
    let told = |samples: u16, extra: &[u16]| {
        let mut found = Vec::new();
        for case in 0..4 {
            let layout = Written {
                samples,
                extra: extra.to_vec(),
                planar: case & 1 == 1,
                // Differences reach over the channels that are left out.
                differences: case & 2 == 2,
                ..Written::default()
            };
            let bytes = layout.file(of);
            let pixel = pixels(&folder.read(&bytes).unwrap())[SIZE[0] as usize + 9].clone();
            found.push((pixel, folder.notes(&bytes).join("; ")));
        }
        assert!(found.iter().all(|it| *it == found[0]), "{found:?}");
        found.remove(0)
    };
    let stored: Vec<u16> = (0..6).map(|s| of(9, 1, s)).collect();
    let (pixel, note) = told(4, &[0]);
    assert_eq!((&pixel[..], note.as_str()), (&stored[..3], "1 channel beside its colours is left out"));
    let (pixel, note) = told(4, &[]);
    assert_eq!(pixel, stored[..4]);
    assert!(note.contains("its last channel is taken for opacity"), "{note}");
    let (pixel, note) = told(6, &[0, 2, 0]);
    assert_eq!(pixel, [stored[0], stored[1], stored[2], stored[4]]);
    assert_eq!(note, "2 channels beside its colours are left out");
    let (pixel, note) = told(5, &[0, 0]);
    assert_eq!((&pixel[..], note.as_str()), (&stored[..3], "2 channels beside its colours are left out"));
}

#[test]
fn grey_of_any_depth_is_spread_over_8_or_16_bits_and_white_may_be_zero() {
    let folder = TestPhotoFolder::new();
    for bits in [1u16, 2, 4, 8, 16] {
        for (white_is_zero, tiled, big_endian) in
            [(false, false, false), (true, false, true), (true, true, false)]
        {
            let photometric = if white_is_zero { 0 } else { 1 };
            let layout = Written { bits, samples: 1, photometric, tiled, big_endian, ..Written::default() };
            let of = value_of(bits);
            let full = if bits == 16 { 65535u32 } else { 255 };
            let spread = full / ((1 << bits) - 1);
            let found = pixels(&folder.read(&layout.file(of)).unwrap());
            let truth = expected(|x, y| {
                let grey = u32::from(of(x, y, 0)) * spread;
                vec![if white_is_zero { full - grey } else { grey } as u16; 3]
            });
            assert_eq!(found, truth, "{layout:?}");
        }
    }
}

#[test]
fn palettes_and_inks_become_rgb() {
    let folder = TestPhotoFolder::new();
    for (bits, scale) in [(4u16, 257u32), (8, 257), (8, 1)] {
        let count = 1u32 << bits;
        let colour = |i: u32| [i * 255 / (count - 1), 255 - i * 255 / (count - 1), i * 7 % 256];
        let map = (0..3).flat_map(|c| (0..count).map(move |i| colour(i)[c] * scale)).collect();
        let more = vec![(320, 3, map)];
        let layout = Written { bits, samples: 1, photometric: 3, more, ..Written::default() };
        let of = value_of(bits);
        let found = pixels(&folder.read(&layout.file(of)).unwrap());
        let truth = expected(|x, y| colour(of(x, y, 0).into()).map(|byte| byte as u16).to_vec());
        assert_eq!(found, truth, "{bits} bits, {scale}");
    }
    for planar in [false, true] {
        let layout = Written { samples: 4, photometric: 5, planar, ..Written::default() };
        let of = value_of(8);
        let bytes = layout.file(of);
        let truth = expected(|x, y| {
            let light = |s: u16| 255.0 - f64::from(of(x, y, s));
            (0..3).map(|s| (light(s) * light(3) / 255.0).round() as u16).collect()
        });
        assert_eq!(pixels(&folder.read(&bytes).unwrap()), truth);
        let notes = folder.notes(&bytes);
        assert!(notes[0].contains("CMYK"), "{notes:?}");
    }
}

#[test]
fn what_is_not_read_is_refused_by_name_before_anything_is_decoded() {
    let folder = TestPhotoFolder::new();
    let with = |more: &[(u16, u16, Vec<u32>)]| Written { more: more.to_vec(), ..Written::default() };
    let one = |tag: u16, value: u32| with(&[(tag, 3, vec![value])]);
    let deep = |bits: u16| Written { bits, ..Written::default() };
    let cases = [
        (with(&[(339, 3, vec![3; 3]), (258, 3, vec![32; 3])]), "floating-point numbers of 32 bits"),
        (with(&[(339, 3, vec![2; 3])]), "signed whole numbers of 8 bits"),
        (with(&[(258, 3, vec![32; 3])]), "samples of 32 bits"),
        (with(&[(258, 3, vec![5, 6, 5])]), "channels of different depths"),
        (one(262, 6), "YCbCr colours without JPEG"),
        (one(262, 8), "Lab colours"),
        (one(262, 32803), "raw data of a camera's sensor"),
        (one(259, 50000), "compression (ZSTD, 50000)"),
        (one(259, 4), "compression (CCITT (fax), 4)"),
        (one(259, 6), "JPEG of the old kind"),
        (one(317, 3), "predictor 3"),
        (with(&[(50706, 1, vec![1, 4, 0, 0])]), "a raw photo (DNG)"),
        (one(277, 2), "2 channels where colours need 3"),
        (
            with(&[(322, 4, vec![60_000]), (323, 4, vec![60_000]), (324, 4, vec![8]), (325, 4, vec![9])]),
            "tiles of 60000",
        ),
        (with(&[(273, 4, vec![8])]), "1 places and 3 lengths of 3 strips"),
        (with(&[(273, 4, vec![8, 9, u32::MAX])]), "cut short"),
        (with(&[(279, 4, vec![5, 5, 5])]), "strip 0: it ends before its pixels do"),
        (
            Written { photometric: 0, samples: 2, extra: vec![1], ..Written::default() },
            "multiplied with opacity",
        ),
        (deep(8), "37 x 21 pixels where"),
    ];
    for (layout, expected) in cases {
        let bytes = layout.file(value_of(8));
        let said = match expected.starts_with("37") {
            false => folder.refused(&bytes),
            true => check_photo(&folder.put(&bytes), 38, 21).unwrap_err().to_string(),
        };
        assert!(said.contains(expected), "{said}, expected {expected}");
    }
    assert_eq!(picture_size(&folder.put(&deep(8).file(value_of(8)))).unwrap(), SIZE);
}

#[test]
fn orientation_and_profile_are_those_of_the_tags_in_both_sizes_of_offsets() {
    let folder = TestPhotoFolder::new();
    let mut profile = vec![0u32; 128];
    profile[16..20].copy_from_slice(&b"RGB ".map(u32::from));
    for is_big in [false, true] {
        let more = vec![(274, 3, vec![6]), (34675, 7, profile.clone())];
        let bytes = Written { is_big, more, ..Written::default() }.file(value_of(8));
        let path = folder.put(&bytes);
        let turned = read_photo(&path, SIZE[1], SIZE[0]).unwrap();
        let stored = read_photo(&path, SIZE[0], SIZE[1]).unwrap();
        assert_eq!(turned.rgba16(0, 0), stored.rgba16(0, SIZE[1] - 1));
        assert_eq!(stored.icc.map(|icc| icc.len()), Some(128));
    }
}

/// `QUADRATURA_MUTATIONS=10000 cargo test --release -p quadratura-import --lib mutated_tiffs` reads as many.
#[test]
fn mutated_tiffs_give_a_photo_or_an_error_and_never_a_fault() {
    let count = std::env::var("QUADRATURA_MUTATIONS").ok().and_then(|count| count.parse().ok());
    let count: u32 = count.unwrap_or(600);
    let folder = TestPhotoFolder::new();
    let mut rng = Rng::new(41);
    let mut read = 0;
    for case in 0..count {
        let is = |rng: &mut Rng| rng.chance(0.5);
        let grey = is(&mut rng);
        let layout = Written {
            big_endian: is(&mut rng),
            is_big: is(&mut rng),
            tiled: is(&mut rng),
            planar: is(&mut rng),
            differences: is(&mut rng),
            compression: [1, 5, 8, 32773][rng.whole(0, 3) as usize],
            bits: if is(&mut rng) { 16 } else { 8 },
            samples: if grey { 2 } else { 4 },
            photometric: if grey { 1 } else { 2 },
            extra: vec![rng.whole(0, 2) as u16],
            ..Written::default()
        };
        let mut bytes = layout.file(value_of(layout.bits));
        for _ in 0..rng.whole(1, 4) {
            // Tags are at the end, the header at the start.
            let last = bytes.len() as u32 - 1;
            let from = if is(&mut rng) { last.saturating_sub(300) } else { 0 };
            let at = rng.whole(from, last) as usize;
            match rng.whole(0, 3) {
                0 => bytes[at] ^= 1 << rng.whole(0, 7),
                1 => bytes[at] = rng.bits() as u8,
                2 => bytes[at..].iter_mut().take(rng.whole(1, 8) as usize).for_each(|byte| *byte = 255),
                _ if rng.chance(0.3) => bytes.truncate(at.max(1)),
                _ => bytes[at] = 0,
            }
        }
        match folder.read(&bytes) {
            Ok(_) => read += 1,
            Err(error) => {
                let said = error.to_string();
                assert!(
                    said.contains("photo.tif") && !said.contains("its decoder failed"),
                    "case {case}: {said}"
                );
            }
        }
    }
    assert!(
        (count / 20..count / 20 * 19).contains(&read),
        "some are photos and some are not: {read} of {count}"
    );
}
