//! What must hold of the first line before memory is taken for what it declares. The same holds of what is written.

use glam::DMat3;

use super::chunk_pixels;
use super::defect::{CheckResult, FileDefect, ensure};
use super::hash::HASH_DIGITS;
use super::header::{
    ALIGNMENT, CHUNK_ROWS, ChunkEntry, FORMAT, LdiCamera, LdiHeader, LevelEntry, STREAMS, SurfaceEntry,
    VERSION,
};
use super::packing::Packing;
use crate::LdiKind;
use crate::layout::{LARGEST_INVERSE_DEPTH, LONGEST_SIDE, MOST_SURFACES};
use crate::levels::half_camera;
use quadratura_base::geometry::{Pinhole, PixelRect};

/// The largest ratio of deflate: 258 bytes can take two bits, so 1032 bytes take a byte.
const LARGEST_DEFLATE_RATIO: u64 = 1032;

/// More bytes than those that lengths, headers and padding add to the packed streams of a chunk.
const PACKED_SLACK: u64 = 1024;

/// The largest number of levels: with 15, one of the longest permitted side has been halved to one pixel.
const MOST_LEVELS: usize = 15;

/// How far the entries of R R^T may be from those of the identity; text with six digits is within.
const ROTATION_TOLERANCE: f64 = 1e-5;

/// The largest logarithm of an exposure over the common one: a ratio of ten million million.
const LARGEST_GAIN: f64 = 30.0;

/// The largest entry of a surface's nu, in 1/world unit. A plane with a larger one has inverse depths beyond
/// [`LARGEST_INVERSE_DEPTH`] at all pixels but those of a line.
const LARGEST_NU: f64 = 1e24;

/// Checks what the first line says.
pub(super) fn check(header: &LdiHeader) -> CheckResult {
    check_format(&header.format, header.version)?;
    ensure(header.streams == STREAMS, || {
        FileDefect::of_line(format!("`streams` is {:?}; expected {STREAMS:?}", header.streams))
    })?;
    check_content(&header.kind, header.gain, &header.camera, &header.surfaces)?;
    check_photo_rect(header.photo_rect.as_ref(), &header.camera)?;
    check_levels(header)
}

/// Checks what is said of a layered depth image whatever file it is in.
pub(super) fn check_content(
    kind: &str,
    gain: [f64; 3],
    camera: &LdiCamera,
    surfaces: &[SurfaceEntry],
) -> CheckResult {
    ensure(LdiKind::ALL.iter().any(|known| known.name() == kind), || {
        let kinds = LdiKind::ALL.map(LdiKind::name).join(", ");
        FileDefect::of_line(format!("`kind` is {kind:?}; expected one of: {kinds}"))
    })?;
    ensure(gain.iter().all(|gain| gain.abs() <= LARGEST_GAIN), || {
        FileDefect::of_line(format!(
            "`gain` is {gain:?}; expected three numbers from -{LARGEST_GAIN} to {LARGEST_GAIN}"
        ))
    })?;
    check_camera(camera)?;
    check_surfaces(surfaces)
}

/// Checks that a file is one of those that this program reads.
pub(super) fn check_format(format: &str, version: u32) -> CheckResult {
    ensure(format == FORMAT, || FileDefect::of_line(format!("`format` is {format:?}; expected {FORMAT:?}")))?;
    ensure(version == VERSION, || {
        FileDefect::of_line(format!(
            "`version` is {version}; expected {VERSION}: a newer version of quadratura may read it"
        ))
    })
}

#[allow(non_snake_case)]
pub(super) fn check_camera(camera: &LdiCamera) -> CheckResult {
    let LdiCamera { K, R, t, width, height } = camera;
    let sides = 1..=LONGEST_SIDE;
    ensure(sides.contains(width) && sides.contains(height), || {
        FileDefect::of_line(format!(
            "the frame has {width} x {height} pixels; expected sides of 1 to {LONGEST_SIDE}"
        ))
    })?;
    let Pinhole { fx, fy, cx, cy, .. } = camera.pinhole();
    let finite = [fx, fy, cx, cy].iter().chain(t).all(|value| value.is_finite());
    let plain = *K == [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]];
    ensure(finite && plain && fx > 0.0 && fy > 0.0, || {
        FileDefect::of_line(format!(
            "`camera` has K = {K:?} and t = {t:?}; expected finite numbers, focal lengths above 0 and no skew"
        ))
    })?;
    let rotation = camera.pose().rotation;
    let apart = (rotation * rotation.transpose() - DMat3::IDENTITY).to_cols_array();
    let orthonormal = apart.iter().all(|entry| entry.abs() <= ROTATION_TOLERANCE);
    ensure(orthonormal && rotation.determinant() > 0.0, || {
        FileDefect::of_line(format!("`camera` has R = {R:?}; expected a rotation matrix"))
    })
}

/// Checks where the photo lies in the frame.
pub(super) fn check_photo_rect(rect: Option<&PixelRect>, camera: &LdiCamera) -> CheckResult {
    let Some(&PixelRect { x, y, w, h }) = rect else { return Ok(()) };
    let within = |start: i32, side: u32, whole: u32| {
        u32::try_from(start).is_ok_and(|start| side > 0 && start <= whole && side <= whole - start)
    };
    ensure(within(x, w, camera.width) && within(y, h, camera.height), || {
        let (width, height) = (camera.width, camera.height);
        FileDefect::of_line(format!(
            "`photo_rect` is [{x}, {y}, {w}, {h}]; expected sides above 0 within the frame of {width} x {height} pixels"
        ))
    })
}

fn check_surfaces(surfaces: &[SurfaceEntry]) -> CheckResult {
    ensure(surfaces.len() <= MOST_SURFACES, || {
        FileDefect::of_line(format!(
            "there are {} surfaces; expected {MOST_SURFACES} at most",
            surfaces.len()
        ))
    })?;
    let is_possible = |value: &f64| value.abs() <= LARGEST_NU;
    let wrong = surfaces.iter().position(|surface| !surface.nu.iter().all(is_possible));
    wrong.map_or(Ok(()), |index| {
        let nu = surfaces[index].nu;
        Err(FileDefect::of_line(format!(
            "surface {} has nu = {nu:?}; expected numbers up to {LARGEST_NU:e}",
            index + 1
        )))
    })
}

fn check_levels(header: &LdiHeader) -> CheckResult {
    let levels = &header.levels;
    ensure((1..=MOST_LEVELS).contains(&levels.len()), || {
        FileDefect::of_line(format!("there are {} levels; expected 1 to {MOST_LEVELS}", levels.len()))
    })?;
    let mut camera = header.camera.pinhole();
    for (index, level) in levels.iter().enumerate() {
        let place = format!("first line, level {index}");
        ensure((level.width, level.height) == (camera.width, camera.height), || {
            let found = format!("{} x {} pixels", level.width, level.height);
            FileDefect::at(&place, format!("{found}; expected {} x {}", camera.width, camera.height))
        })?;
        check_level(level, header.packing, &place)?;
        camera = half_camera(&camera);
    }
    ensure(header.chunk_bytes() == Some(header.report.bytes), || {
        let bytes = header.report.bytes;
        FileDefect::of_line(format!("`bytes` of the report is {bytes}; the chunks add up to another number"))
    })
}

fn check_level(level: &LevelEntry, packing: Packing, place: &str) -> CheckResult {
    let expected = level.height.div_ceil(CHUNK_ROWS) as usize;
    ensure(level.chunks.len() == expected, || {
        FileDefect::at(place, format!("{} chunks; expected {expected}", level.chunks.len()))
    })?;
    for (index, chunk) in level.chunks.iter().enumerate() {
        let layered = u64::from(level.width) * u64::from(level.rows_of(index));
        check_chunk(chunk, layered, packing)
            .map_err(|found| FileDefect::at(format!("{place}, chunk {index}"), found))?;
    }
    // No sum overflows: each chunk has less than 2^28 depth pixels and 2^33 bytes, and there are at most 256 of them.
    let sum: u64 = level.chunks.iter().map(|chunk| chunk.depth_pixels).sum();
    ensure(sum == level.depth_pixels, || {
        let found = format!("{} depth pixels; its chunks have {sum}", level.depth_pixels);
        FileDefect::at(place, found)
    })?;
    ensure(sum <= u64::from(u32::MAX), || {
        FileDefect::at(
            place,
            format!("{sum} depth pixels; expected less than 2^32: make it of a smaller photo"),
        )
    })
}

/// Checks a chunk with `layered` layered depth pixels; an error says what was found and expected.
fn check_chunk(chunk: &ChunkEntry, layered: u64, packing: Packing) -> Result<(), String> {
    let ChunkEntry { bytes, depth_pixels, near, far, ref hash } = *chunk;
    let most = layered * u64::from(u8::MAX);
    if depth_pixels > most {
        return Err(format!("{depth_pixels} depth pixels; expected {most} at most"));
    }
    let unpacked: u64 = chunk_pixels::stream_sizes(layered, depth_pixels).iter().sum();
    let plain: u64 = chunk_pixels::stream_sizes(layered, depth_pixels)
        .map(|size| size.next_multiple_of(ALIGNMENT as u64))
        .iter()
        .sum();
    if packing == Packing::None && bytes != plain {
        return Err(format!("{bytes} bytes; expected {plain} for {depth_pixels} depth pixels"));
    }
    let possible = unpacked / LARGEST_DEFLATE_RATIO..=2 * unpacked + PACKED_SLACK;
    if bytes % ALIGNMENT as u64 != 0 || !possible.contains(&bytes) {
        return Err(format!("{bytes} bytes; these cannot be {unpacked} bytes that were packed"));
    }
    let range = 0.0..=LARGEST_INVERSE_DEPTH;
    if !(range.contains(&near) && range.contains(&far) && near >= far) {
        return Err(format!("inverse depths from {far} to {near}; expected 0 to {LARGEST_INVERSE_DEPTH:e}"));
    }
    if hash.len() != HASH_DIGITS {
        return Err(format!("the hash {hash:?}; expected {HASH_DIGITS} hexadecimal digits"));
    }
    Ok(())
}
