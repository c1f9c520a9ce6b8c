//! Tests of the file of a layered depth image: what is read is what was written, and whatever else a file holds is refused.

use std::fs;
use std::path::{Path, PathBuf};

use glam::{DMat3, DVec3};
use tempfile::TempDir;

use super::hash::short_hash;
use super::*;
use crate::levels::pyramid;
use crate::{DepthPixel, Ldi, LdiKind, LdiReport, LdiSurface, ResolutionLevel, Splat};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};
use quadratura_base::scene::FaceIndex;
use quadratura_base::task::Task;

/// Seeded pseudo-random numbers (SplitMix64).
struct Rng(u64);

impl Rng {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Returns a number below `end`.
    fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }

    /// Returns a number in 0..1.
    fn share(&mut self) -> f64 {
        self.below(1 << 53) as f64 / (1u64 << 53) as f64
    }
}

fn surface(rng: &mut Rng, index: u32) -> LdiSurface {
    let nu = DVec3::new(rng.share() * 1e-3, rng.share() * -1e-3, 0.1 + rng.share() / 3.0);
    let face = (index != 1).then_some(FaceIndex(index));
    LdiSurface { nu, object: format!("house {index} \"é\""), face }
}

/// Returns the depth pixels of a row: about half of the positions are empty, some hold sky, some up to five surfaces.
fn row(rng: &mut Rng, width: u16, y: u32, surfaces: &[LdiSurface]) -> Vec<(u16, DepthPixel)> {
    let mut row = Vec::new();
    for column in 0..width {
        let layers = if y % 5 == 3 { 0 } else { rng.below(12).saturating_sub(6) };
        let mut pixels: Vec<DepthPixel> = (0..layers).map(|_| pixel(rng, column, y, surfaces)).collect();
        pixels.sort_by(|a, b| b.inverse_depth.total_cmp(&a.inverse_depth));
        row.extend(pixels.into_iter().map(|pixel| (column, pixel)));
    }
    row
}

fn pixel(rng: &mut Rng, column: u16, y: u32, surfaces: &[LdiSurface]) -> DepthPixel {
    let surface = rng.below(surfaces.len() as u64 + 1) as u16;
    let plane = surfaces.get(usize::from(surface).wrapping_sub(1)).map(|surface| surface.nu);
    let centre = DVec3::new(f64::from(column) + 0.5, f64::from(y) + 0.5, 1.0);
    let inverse_depth = match rng.below(8) {
        0 => 0.0,
        1 => 1e18,
        2 => f32::from_bits(rng.below(1 << 30) as u32),
        _ => plane.map_or(0.25, |nu| nu.dot(centre) as f32),
    };
    let colour = (rng.next() as u32).to_le_bytes();
    DepthPixel {
        inverse_depth: inverse_depth.clamp(0.0, 1e18),
        colour,
        surface,
        splat: Splat(rng.next() as u8),
    }
}

/// Returns the lower right quarter of a camera's frame.
fn lower_right(camera: &Pinhole) -> PixelRect {
    let (x, y) = (camera.width / 2, camera.height / 2);
    PixelRect { x: x as i32, y: y as i32, w: camera.width - x, h: camera.height - y }
}

/// Returns a layered depth image with random content and all the levels that its size gives.
pub(super) fn random(seed: u64, width: u32, height: u32) -> Ldi {
    let mut rng = Rng(seed);
    let surfaces: Vec<LdiSurface> = (0..3).map(|index| surface(&mut rng, index)).collect();
    let camera = Pinhole {
        width,
        height,
        fx: 100.0 + rng.share(),
        fy: 1.0 / 3.0 + 90.0,
        cx: rng.share() * f64::from(width),
        cy: -0.1,
    };
    let rows: Vec<_> = (0..height).map(|y| row(&mut rng, width as u16, y, &surfaces)).collect();
    let pose = Pose {
        rotation: DMat3::from_rotation_y(rng.share()) * DMat3::from_rotation_x(rng.share()),
        translation: DVec3::new(5e6 + rng.share(), -rng.share(), 1e-7),
    };
    let report = LdiReport {
        depth_complexity: 1.0 + rng.share(),
        layers: 5,
        samples: u64::MAX,
        quartiles: [0.1, 0.2, 1.0 / 3.0],
        options: [("layers".to_owned(), "10".to_owned())].into(),
        ..LdiReport::default()
    };
    Ldi {
        kind: LdiKind::ALL[rng.below(4) as usize],
        inputs: "0123abcd-ef".to_owned(),
        camera,
        pose,
        photo_rect: (seed.is_multiple_of(2)).then(|| lower_right(&camera)),
        gain: [0.0, -0.25, rng.share()],
        levels: pyramid(ResolutionLevel::of_rows(camera, rows), &surfaces),
        surfaces,
        sources: vec!["a b.jpg".to_owned(), "nord/0028.jpg".to_owned()],
        report,
    }
}

/// A folder with a file of a layered depth image in it.
struct Written {
    _folder: TempDir,
    file: PathBuf,
    bytes: Vec<u8>,
}

impl Written {
    fn new(ldi: &Ldi, packing: Packing) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("cache/ldi/a.ldi");
        let length = write_ldi(&file, ldi, packing).unwrap();
        let bytes = fs::read(&file).unwrap();
        assert_eq!(length, bytes.len() as u64);
        Self { _folder: folder, file, bytes }
    }

    /// Returns what is read when the file has other content.
    fn read_of(&self, bytes: &[u8]) -> Result<Ldi> {
        fs::write(&self.file, bytes).unwrap();
        read(&self.file)
    }

    /// Returns the message about a file whose first line was changed, with a `line_hash` that fits the change.
    fn message_with(&self, change: impl FnOnce(&mut serde_json::Value)) -> String {
        let end = self.bytes.iter().position(|byte| *byte == b'\n').unwrap();
        let mut line: serde_json::Value = serde_json::from_slice(&self.bytes[..end]).unwrap();
        change(&mut line);
        line.as_object_mut().unwrap().remove("line_hash");
        let mut text = line.to_string().into_bytes();
        text.pop();
        let hash = format!(",\"line_hash\":\"{}\"}}", short_hash(&text));
        text.extend_from_slice(hash.as_bytes());
        text.resize((text.len() + 1).next_multiple_of(8) - 1, b' ');
        text.extend_from_slice(&self.bytes[end..]);
        self.read_of(&text).unwrap_err().to_string()
    }

    /// Returns the message about a file with another byte at `offset` of its first chunk, with hashes that fit the change.
    fn message_with_bytes(&mut self, offset: usize, bytes: &[u8]) -> String {
        let end = self.bytes.iter().position(|byte| *byte == b'\n').unwrap();
        let size = read_ldi_header(&self.file).unwrap().levels[0].chunks[0].bytes as usize;
        let chunk = &mut self.bytes[end + 1..][..size];
        chunk[offset..offset + bytes.len()].copy_from_slice(bytes);
        let hash = short_hash(chunk);
        self.message_with(|line| line["levels"][0]["chunks"][0]["hash"] = hash.into())
    }
}

fn read(file: &Path) -> Result<Ldi> {
    read_ldi(file, &Task::silent())
}

/// Like `==`, with the bits of inverse depths.
pub(super) fn same(a: &Ldi, b: &Ldi) -> bool {
    let bits = |ldi: &Ldi| {
        let depths = ldi.levels.iter().flat_map(|level| &level.inverse_depths);
        depths.map(|depth| depth.to_bits()).collect::<Vec<_>>()
    };
    a == b && bits(a) == bits(b)
}

pub(super) const PACKINGS: [Packing; 2] = [Packing::None, Packing::Deflate];

#[test]
fn what_is_read_is_what_was_written() {
    // Sides around those of chunks and tiles; the first ones have one level.
    for (seed, width, height) in [(1, 1, 1), (2, 17, 5), (3, 70, 64), (4, 130, 65), (5, 64, 200)] {
        let ldi = random(seed, width, height);
        for packing in PACKINGS {
            let written = Written::new(&ldi, packing);
            assert!(same(&read(&written.file).unwrap(), &ldi), "{width} x {height}, {packing:?}");
        }
    }
}

#[test]
fn a_level_is_read_alone_as_the_whole_image_has_it_from_there_on() {
    for seed in [3, 4] {
        let ldi = random(seed, 130, 65);
        let written = Written::new(&ldi, Packing::None);
        for index in 0..ldi.levels.len() {
            let alone = read_ldi_level(&written.file, index, &Task::silent()).unwrap();
            assert!(alone.levels == ldi.levels[index..], "seed {seed}, level {index}");
            assert_eq!((alone.camera, alone.pose), (ldi.levels[index].camera, ldi.pose));
            // The planes have the same depths at the same places of the photo.
            let at = |nu: DVec3, pixels: f64| nu.dot(DVec3::new(40.0 / pixels, 30.0 / pixels, 1.0));
            for (own, whole) in alone.surfaces.iter().zip(&ldi.surfaces) {
                assert_eq!(at(own.nu, f64::from(1u32 << index)), at(whole.nu, 1.0));
            }
        }
        let coarsest = read_ldi_level(&written.file, 99, &Task::silent()).unwrap();
        assert!(coarsest.levels == ldi.levels[ldi.levels.len() - 1..]);
        // A packed file has the first level alone.
        let packed = Written::new(&ldi, Packing::Deflate);
        assert!(read_ldi_level(&packed.file, 1, &Task::silent()).unwrap().levels == ldi.levels);
        // Damage in another level does not count, and in its own it does.
        let mut bytes = written.bytes.clone();
        let last = bytes.len() - 9;
        bytes[last] ^= 1;
        fs::write(&written.file, &bytes).unwrap();
        assert!(read_ldi_level(&written.file, 1, &Task::silent()).is_ok());
        assert!(read_ldi_level(&written.file, 99, &Task::silent()).is_err());
        fs::write(&written.file, &bytes[..last]).unwrap();
        let error = read_ldi_level(&written.file, 1, &Task::silent()).unwrap_err().to_string();
        assert!(error.contains("cut short"), "{error}");
    }
}

#[test]
fn chunks_and_plain_streams_start_at_multiples_of_eight_bytes() {
    for packing in PACKINGS {
        let written = Written::new(&random(6, 131, 130), packing);
        let header = read_ldi_header(&written.file).unwrap();
        let start = written.bytes.iter().position(|byte| *byte == b'\n').unwrap() + 1;
        assert_eq!(start % 8, 0);
        let levels = if packing == Packing::None { 5 } else { 1 };
        assert_eq!((header.levels.len(), header.levels[0].chunks.len()), (levels, 3));
        assert!(header.levels.iter().flat_map(|level| &level.chunks).all(|chunk| chunk.bytes % 8 == 0));
        assert_eq!(start as u64 + header.report.bytes, written.bytes.len() as u64);
    }
}

#[test]
fn the_same_bytes_are_written_by_one_and_three_threads() {
    let ldi = random(7, 90, 300);
    for packing in PACKINGS {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| Written::new(&ldi, packing).bytes)
        };
        assert_eq!(with(1), with(3));
    }
}

#[test]
fn every_beginning_of_a_file_is_refused_with_the_number_of_whole_rows() {
    let ldi = random(8, 9, 130);
    for packing in PACKINGS {
        let written = Written::new(&ldi, packing);
        let start = written.bytes.iter().position(|byte| *byte == b'\n').unwrap() + 1;
        let first = read_ldi_header(&written.file).unwrap().levels[0].chunks[0].bytes as usize;
        let file = fs::File::options().write(true).open(&written.file).unwrap();
        for length in (0..written.bytes.len()).rev() {
            file.set_len(length as u64).unwrap();
            let error = read(&written.file).unwrap_err();
            let Error::Input { found, remedy, .. } = &error else { panic!("{error}") };
            if length >= start {
                let whole = if length < start + first { "; 0 of 130 rows" } else { "of 130 rows are whole" };
                assert!(found.contains(whole) && remedy.to_string().contains("--partial"), "{error}");
            }
        }
        let mut longer = written.bytes.clone();
        longer.push(0);
        assert!(written.read_of(&longer).is_err());
    }
}

#[test]
fn every_flipped_byte_gives_an_error_or_the_same_image() {
    let ldi = random(9, 6, 9);
    for packing in PACKINGS {
        let written = Written::new(&ldi, packing);
        let mut refused = 0;
        for index in 0..written.bytes.len() {
            for flip in [0x01, 0x20, 0xff] {
                let mut bytes = written.bytes.clone();
                bytes[index] ^= flip;
                match written.read_of(&bytes) {
                    Ok(read) => assert!(same(&read, &ldi), "byte {index} ^ {flip:#x}"),
                    Err(_) => refused += 1,
                }
            }
        }
        // Only spaces before the line feed may be something else, at most seven of them.
        assert!(refused >= 3 * (written.bytes.len() - 7), "{refused} of {}", 3 * written.bytes.len());
    }
}

#[test]
fn rows_that_are_whole_are_read_from_a_file_that_is_cut_short() {
    let ldi = random(10, 40, 150);
    for packing in PACKINGS {
        let written = Written::new(&ldi, packing);
        let header = read_ldi_header(&written.file).unwrap();
        let start = written.bytes.len() - header.report.bytes as usize;
        let chunks: Vec<usize> = header.levels[0].chunks.iter().map(|chunk| chunk.bytes as usize).collect();
        let two = start + chunks[0] + chunks[1];
        for (length, whole) in
            [(start, 0), (two - 1, 64), (two, 128), (two + chunks[2], 150), (written.bytes.len(), 150)]
        {
            fs::write(&written.file, &written.bytes[..length]).unwrap();
            let (read, rows) = read_whole_rows(&written.file, &Task::silent()).unwrap();
            assert_eq!(rows, WholeRows { whole, height: 150 });
            let kept: Vec<_> = (0..150).map(|y| (ldi.levels[0].row(y), y < whole)).collect();
            let rows = kept.iter().map(|(row, kept)| {
                let row = if *kept { row.clone() } else { 0..0 };
                row.map(|index| (ldi.levels[0].columns[index], ldi.levels[0].pixel(index))).collect()
            });
            let first = ResolutionLevel::of_rows(ldi.camera, rows);
            assert!(
                same(&read, &Ldi { levels: pyramid(first, &ldi.surfaces), ..ldi.clone() }),
                "{length} bytes"
            );
        }
    }
}

#[test]
fn a_damaged_chunk_is_left_out_of_what_is_whole() {
    let written = Written::new(&random(11, 20, 150), Packing::None);
    let mut bytes = written.bytes.clone();
    let header = read_ldi_header(&written.file).unwrap();
    let start = bytes.len() - header.report.bytes as usize;
    bytes[start + header.levels[0].chunks[0].bytes as usize] ^= 1;
    let message = written.read_of(&bytes).unwrap_err().to_string();
    assert!(message.contains("level 0, rows 64 to 127: the content has the hash"), "{message}");
    let (read, rows) = read_whole_rows(&written.file, &Task::silent()).unwrap();
    assert_eq!(
        (rows.whole, read.levels[0].row(64).start, read.levels[0].row(127).end > 0),
        (86, read.levels[0].row(63).end, true)
    );
    assert_eq!(read.levels[0].row(127).end, read.levels[0].row(64).start);
}

#[test]
fn a_first_line_that_cannot_be_true_is_refused_before_memory_is_taken() {
    let plain = Written::new(&random(12, 20, 70), Packing::None);
    let deflated = Written::new(&random(12, 20, 70), Packing::Deflate);
    for written in [&plain, &deflated] {
        let says = |change: &dyn Fn(&mut serde_json::Value), what: &str| {
            let message = written.message_with(change);
            assert!(message.contains(what), "{message}");
        };
        says(&|line| line["version"] = 2.into(), "`version` is 2; expected 1");
        says(&|line| line["format"] = "else".into(), "`format` is \"else\"");
        says(&|line| line["kind"] = "cube".into(), "expected one of: stack, photos, site, depth");
        says(&|line| line["streams"][0] = "colours".into(), "`streams`");
        says(&|line| line["camera"]["width"] = 16385.into(), "16384");
        says(&|line| line["camera"]["height"] = 0.into(), "16384");
        says(&|line| line["camera"]["K"][0][0] = 0.into(), "focal lengths");
        says(&|line| line["camera"]["K"][0][1] = 1.into(), "no skew");
        says(&|line| line["camera"]["R"][0][0] = 3.into(), "rotation");
        says(&|line| line["photo_rect"] = serde_json::json!([0, 0, 0, 0]), "sides above 0");
        says(
            &|line| line["photo_rect"] = serde_json::json!([-5, 0, 99999, 99999]),
            "within the frame of 20 x 70",
        );
        says(&|line| line["levels"][0]["width"] = 21.into(), "level 0: 21 x 70 pixels; expected 20 x 70");
        says(&|line| line["levels"] = serde_json::json!([]), "0 levels");
        says(&|line| line["levels"][0]["depth_pixels"] = 1.into(), "its chunks have");
        says(&|line| line["levels"][0]["chunks"][0]["depth_pixels"] = 326_401.into(), "326400 at most");
        says(
            &|line| line["levels"][0]["chunks"][0]["bytes"] = (1u64 << 60).into(),
            "1152921504606846976 bytes;",
        );
        says(&|line| line["levels"][0]["chunks"][0]["bytes"] = 0.into(), "0 bytes;");
        says(&|line| line["levels"][0]["chunks"][0]["near"] = 2e18.into(), "inverse depths from");
        says(&|line| line["levels"][0]["chunks"][0]["near"] = 9e17.into(), "inverse depths from");
        says(
            &|line| line["levels"][0]["chunks"][0]["hash"] = "0123456789abcdef".into(),
            "expected 0123456789abcdef",
        );
        says(&|line| line["levels"][0]["chunks"] = serde_json::json!([]), "0 chunks; expected 2");
        says(&|line| line["report"]["bytes"] = 8.into(), "`bytes` of the report is 8");
        says(&|line| line["surfaces"] = serde_json::json!([]), "expected 0 to 0");
    }
    let most = |line: &mut serde_json::Value| line["levels"][0]["chunks"][0]["depth_pixels"] = 326_400.into();
    let message = plain.message_with(most);
    assert!(message.contains("expected 3591680 for 326400 depth pixels"), "{message}");
    let message = deflated.message_with(most);
    assert!(message.contains("its chunks have"), "{message}");
    let message = plain.message_with(|line| line["packing"] = "deflate".into());
    assert!(message.contains("stream"), "{message}");
    let message = plain.read_of(&vec![b'['; line::LONGEST_LINE + 1]).unwrap_err().to_string();
    assert!(message.contains("more than 16777216 bytes"), "{message}");
}

/// Returns a layered depth image of one row: two depth pixels in the first column, one of them in the second.
fn three() -> Ldi {
    let pixel = |inverse_depth, surface| DepthPixel {
        inverse_depth,
        colour: [9, 8, 7, 255],
        surface,
        splat: Splat(3),
    };
    let ldi = random(13, 2, 1);
    let rows = [vec![(0, pixel(3.0, 1)), (0, pixel(2.0, 0)), (1, pixel(1.0, 3))]];
    Ldi { levels: vec![ResolutionLevel::of_rows(ldi.camera, rows)], ..ldi }
}

#[test]
fn content_that_breaks_the_layout_is_refused_although_its_hash_fits() {
    // The streams: 2 counts at 0, 3 inverse depths at 8, 3 colours at 24, 3 surfaces at 40, 3 splats at 48.
    let cases: [(usize, Vec<u8>, &str); 7] = [
        (0, vec![2, 2], "counts of 4 depth pixels; expected 3"),
        (8, f32::NAN.to_le_bytes().to_vec(), "column 0, row 0: the inverse depth NaN"),
        (8, f32::INFINITY.to_le_bytes().to_vec(), "the inverse depth inf"),
        (16, (-1f32).to_le_bytes().to_vec(), "column 1, row 0: the inverse depth -1"),
        (12, 3.5f32.to_le_bytes().to_vec(), "column 0, row 0: a depth pixel is behind a farther one"),
        (8, 4f32.to_le_bytes().to_vec(), "inverse depths from 1 to 4; expected 1 to 3"),
        (42, vec![4, 0], "column 0, row 0: surface 4; expected 0 to 3"),
    ];
    for (offset, bytes, what) in cases {
        let mut written = Written::new(&three(), Packing::None);
        assert_eq!(written.bytes.len() % 8, 0);
        let message = written.message_with_bytes(offset, &bytes);
        assert!(message.contains(what), "{message}");
    }
}

#[test]
fn packed_streams_that_are_too_long_or_none_are_refused() {
    // The first stream: its length, then zlib.
    for (offset, bytes) in [(0, [0xff; 8]), (0, [0; 8]), (8, [0xff; 8]), (8, [0; 8])] {
        let mut written = Written::new(&three(), Packing::Deflate);
        let message = written.message_with_bytes(offset, &bytes);
        assert!(message.contains("level 0, rows 0 to 0: a stream"), "{message}");
    }
}

#[test]
fn what_the_file_cannot_hold_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.ldi");
    let refused = |ldi: Ldi, what: &str| {
        let error = write_ldi(&file, &ldi, Packing::Deflate).unwrap_err();
        assert!(matches!(&error, Error::Request(text) if text.contains(what)), "{error}");
        assert!(!file.exists());
    };
    let ldi = three();
    let deep = (0..256).map(|_| (1, ldi.levels[0].pixel(0))).collect();
    refused(
        Ldi { levels: vec![ResolutionLevel::of_rows(ldi.camera, [deep])], ..three() },
        "more depth pixels than 255",
    );
    let mut negative = three();
    negative.levels[0].inverse_depths[2] = -1.0;
    refused(negative, "column 1, row 0: the inverse depth -1");
    let mut ragged = three();
    ragged.levels[0].colours.pop();
    refused(ragged, "level 0: it was not written: its arrays do not fit together");
    refused(Ldi { gain: [f64::NAN; 3], ..three() }, "`gain`");
    refused(Ldi { gain: [0.0, 31.0, 0.0], ..three() }, "`gain`");
    let mut steep = three();
    steep.surfaces.push(LdiSurface { nu: DVec3::new(0.0, 1e300, 0.0), object: "roof".into(), face: None });
    refused(steep, "expected numbers up to 1e24");
    refused(Ldi { levels: Vec::new(), ..three() }, "0 levels");
    let other = Pinhole { fx: 1.0, ..ldi.camera };
    refused(Ldi { camera: other, ..three() }, "not the one of half the resolution");
}

#[test]
fn a_file_that_is_missing_is_an_error_of_the_system() {
    let error = read(Path::new("missing.ldi")).unwrap_err();
    assert!(matches!(error, Error::Io { .. }), "{error}");
}

#[test]
fn reading_stops_on_request() {
    let written = Written::new(&three(), Packing::None);
    let task = Task::silent();
    task.stop_flag().store(true, std::sync::atomic::Ordering::Relaxed);
    assert!(matches!(read_ldi(&written.file, &task), Err(Error::Cancelled)));
}
