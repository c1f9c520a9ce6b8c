//! The points of one painted layer (`SPECIES-HASH.coat`): a line of JSON, then positions, changes, opacities and kinds of all points,
//! then positions and colours of paint where the plant has nothing; each of the six deflated.

use std::path::Path;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use quadratura_base::error::{Error, Result};
use quadratura_files::deflated::{Fault, deflated, first_line, inflated};
use quadratura_foliage::{BesidePixel, Change, DIRECTION_NAMES, PaintPoint, PaintedSlab};

/// The value of `format`.
const FORMAT: &str = "quadratura-tree-paint";
/// The version that this program writes; it reads no other.
const VERSION: u32 = 1;
/// Steps of a change of colour: the natural logarithm of a ratio times this.
const STEPS: f32 = 4096.0;
/// The most points of a layer.
const MOST: u64 = 1 << 28;
/// What to do about a damaged file.
pub const REMEDY: &str = "restore it from a copy of the project, or import the edited file again, which `quadratura tree import \
                          --history` names";
/// The names of the streams and the bytes of an item of each.
const STREAMS: [(&str, u64); 6] =
    [("positions", 12), ("changes", 6), ("opacities", 1), ("kinds", 1), ("beside", 8), ("colours", 8)];

/// The first line of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct PaintPointsHeader {
    format: String,
    version: u32,
    /// One of [`DIRECTION_NAMES`].
    direction: String,
    slab: usize,
    /// The side of a texel, in the sub-object's unit.
    delta: f64,
    corner: [f64; 2],
    far: f64,
    /// How many points, and how many pixels where the plant has nothing.
    points: u64,
    beside: u64,
    /// Bytes of the arrays as they follow.
    streams: [u64; 6],
}

/// Returns the bytes of a file. Changes are rounded to 1/4096 of a natural logarithm, opacities to 1/255.
pub fn coat_bytes(coat: &PaintedSlab) -> Vec<u8> {
    let of_points = |bytes: &dyn Fn(&PaintPoint, &mut Vec<u8>)| {
        let mut stream = Vec::new();
        coat.points.iter().for_each(|point| bytes(point, &mut stream));
        deflated(&stream)
    };
    let of_beside = |bytes: &dyn Fn(&BesidePixel, &mut Vec<u8>)| {
        let mut stream = Vec::new();
        coat.beside.iter().for_each(|pixel| bytes(pixel, &mut stream));
        deflated(&stream)
    };
    let step = |value: f32| (STEPS * value).round().clamp(f32::from(i16::MIN), f32::from(i16::MAX)) as i16;
    let streams = [
        of_points(&|point, out| point.at.to_array().iter().for_each(|at| out.extend(at.to_le_bytes()))),
        of_points(&|point, out| {
            point.change.colour.to_array().iter().for_each(|value| out.extend(step(*value).to_le_bytes()));
        }),
        of_points(&|point, out| out.push((255.0 * point.change.alpha.clamp(0.0, 1.0)).round() as u8)),
        of_points(&|point, out| out.push(u8::from(point.leaf))),
        of_beside(&|pixel, out| pixel.at.iter().for_each(|at| out.extend(at.to_le_bytes()))),
        of_beside(&|pixel, out| pixel.colour.iter().for_each(|value| out.extend(value.to_le_bytes()))),
    ];
    let header = PaintPointsHeader {
        format: FORMAT.into(),
        version: VERSION,
        direction: DIRECTION_NAMES[coat.direction].into(),
        slab: coat.slab,
        delta: coat.delta,
        corner: coat.corner,
        far: coat.far,
        points: coat.points.len() as u64,
        beside: coat.beside.len() as u64,
        streams: streams.each_ref().map(|stream| stream.len() as u64),
    };
    let mut bytes = serde_json::to_vec(&header).expect("plain data is JSON");
    bytes.push(b'\n');
    streams.iter().for_each(|stream| bytes.extend(stream));
    bytes
}

/// Reads the bytes of a file.
///
/// # Errors
/// [`Error::Input`] for what is no such file.
pub fn parse_coat(file: &Path, bytes: &[u8]) -> Result<PaintedSlab> {
    parsed(bytes).map_err(|(place, found)| Error::input(file, place, found, REMEDY))
}

fn parsed(bytes: &[u8]) -> Result<PaintedSlab, Fault> {
    let (header, mut rest): (PaintPointsHeader, &[u8]) = first_line(bytes)?;
    if header.format != FORMAT || header.version != VERSION {
        let found =
            format!("{:?} version {}, expected {FORMAT:?} version {VERSION}", header.format, header.version);
        return Err(("format", found));
    }
    let direction = DIRECTION_NAMES.iter().position(|name| *name == header.direction);
    let direction = direction.ok_or_else(|| {
        ("direction", format!("{:?}, expected one of +x, -x, +y, -y, +z, -z", header.direction))
    })?;
    let numbers = header.corner.iter().chain([&header.far, &header.delta]);
    if !numbers.into_iter().all(|number| number.is_finite()) || header.delta <= 0.0 {
        return Err(("delta", format!("{} at {:?}, expected a length above 0", header.delta, header.corner)));
    }
    if header.points > MOST || header.beside > MOST {
        return Err(("points", format!("{} and {}, expected at most {MOST}", header.points, header.beside)));
    }
    let mut stream = |index: usize| {
        let (place, item) = STREAMS[index];
        let (length, count) = (header.streams[index], if index < 4 { header.points } else { header.beside });
        let cut = || (place, format!("the file ends within its {length} bytes; it was cut short"));
        let (packed, left) =
            usize::try_from(length).ok().and_then(|length| rest.split_at_checked(length)).ok_or_else(cut)?;
        rest = left;
        inflated(packed, item * count).map_err(|found| (place, found))
    };
    let (positions, changes, alphas) = (stream(0)?, stream(1)?, stream(2)?);
    let (kinds, places, colours) = (stream(3)?, stream(4)?, stream(5)?);
    if !rest.is_empty() {
        return Err(("", format!("{} bytes after the last colour, expected none", rest.len())));
    }
    let floats = |bytes: &[u8]| -> Vec<f32> {
        bytes.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect()
    };
    let (positions, places) = (floats(&positions), floats(&places));
    if !positions.iter().chain(&places).all(|at| at.is_finite()) {
        return Err(("positions", "a number that is not finite, expected places".into()));
    }
    let steps: Vec<f32> = changes
        .as_chunks::<2>()
        .0
        .iter()
        .map(|bytes| f32::from(i16::from_le_bytes(*bytes)) / STEPS)
        .collect();
    let colours: Vec<u16> =
        colours.as_chunks::<2>().0.iter().map(|bytes| u16::from_le_bytes(*bytes)).collect();
    let points = positions.as_chunks::<3>().0.iter().zip(steps.as_chunks::<3>().0).zip(&alphas).zip(&kinds);
    let points = points.map(|(((at, colour), alpha), kind)| PaintPoint {
        at: Vec3::from_array(*at),
        change: Change { colour: Vec3::from_array(*colour), alpha: f32::from(*alpha) / 255.0 },
        leaf: *kind != 0,
    });
    let beside = places.as_chunks::<2>().0.iter().zip(colours.as_chunks::<4>().0);
    Ok(PaintedSlab {
        direction,
        slab: header.slab,
        delta: header.delta,
        corner: header.corner,
        far: header.far,
        points: points.collect(),
        beside: beside.map(|(at, colour)| BesidePixel { at: *at, colour: *colour }).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    fn any_coat(rng: &mut Rng) -> PaintedSlab {
        let mut point = || PaintPoint {
            at: Vec3::from_array([0.0; 3].map(|_: f32| rng.between(-9.0, 9.0) as f32)),
            change: Change {
                colour: Vec3::from_array(
                    [0.0; 3].map(|_: f32| (rng.between(-9e3, 9e3).round() / 4096.0) as f32),
                ),
                alpha: rng.between(0.0, 255.0).round() as f32 / 255.0,
            },
            leaf: rng.bits() & 1 == 1,
        };
        let points = (0..40).map(|_| point()).collect();
        let beside = [BesidePixel { at: [0.5, -2.0], colour: [1, 2, 3, 65535] }].into();
        PaintedSlab { direction: 3, slab: 2, delta: 0.25, corner: [-3.0, 4.0], far: 1.5, points, beside }
    }

    #[test]
    fn a_coat_that_is_read_is_the_one_that_was_written() {
        let coat = any_coat(&mut Rng::new(2));
        assert_eq!(parsed(&coat_bytes(&coat)), Ok(coat));
    }

    #[test]
    fn a_file_that_was_cut_short_or_changed_is_refused_with_its_name_or_another_coat_and_never_a_panic() {
        let bytes = coat_bytes(&any_coat(&mut Rng::new(3)));
        for end in 0..bytes.len() {
            let said = parse_coat(Path::new("maple-1.coat"), &bytes[..end]).unwrap_err().to_string();
            assert!(said.contains("maple-1.coat") && said.contains("import the edited file again"), "{said}");
        }
        for at in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[at] ^= 1 << (at % 8);
            if let Ok(coat) = parsed(&changed) {
                assert!(coat.points.iter().all(|point| point.at.is_finite()));
            }
        }
    }
}
