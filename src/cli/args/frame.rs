//! Arguments of `frame`.

use std::path::PathBuf;

use clap::Args;

use super::number::degrees;
use super::one_of;
use quadratura_document::frame::{FramePart, MapReference};
use quadratura_views::frame::{FORMS, FrameChange, KnownDirection, KnownLength, Level};

#[derive(Debug, Args)]
#[command(after_help = format!(
    "A and B are points: {FORMS}.\n\nWithout options the frame is shown. It is kept in project.json; exports, measurements and orthophotos use it."
))]
pub struct FrameArgs {
    /// The project folder
    pub project: PathBuf,
    /// Make the site level: by the model's upright edges (`verticals`, the default), by the `cameras`, or by level and upright faces,
    /// as OBJECT or 'OBJECT[3, 5-8]'
    #[arg(long, value_name = "verticals|cameras|FACES", num_args = 0..)]
    pub level: Option<Vec<String>>,
    /// The length from point A to point B, such as 12.34, 12.34m, 850mm or 40ft
    #[arg(long, num_args = 3, value_names = ["A", "B", "LENGTH"], allow_hyphen_values = true, conflicts_with = "unit")]
    pub scale: Option<Vec<String>>,
    /// The unit in which the model was drawn
    #[arg(long, value_parser = one_of(UNITS))]
    pub unit: Option<f64>,
    /// The direction from point A to point B is north
    #[arg(long, num_args = 2, value_names = ["A", "B"], allow_hyphen_values = true)]
    pub north: Option<Vec<String>>,
    /// The direction from A to B of --north is so far from north, in degrees, clockwise seen from above
    #[arg(long, value_name = "DEGREES", value_parser = degrees, requires = "north")]
    pub azimuth: Option<f64>,
    /// The point that is 0, 0, 0
    #[arg(long, value_name = "A", allow_hyphen_values = true)]
    pub origin: Option<String>,
    /// The projected coordinate reference system of the map, such as EPSG:25832
    #[arg(long, value_name = "EPSG:N", value_parser = epsg, requires = "offset")]
    pub crs: Option<u32>,
    /// East, north and height of 0, 0, 0 in that system, in metres
    #[arg(long, num_args = 3, value_names = ["E", "N", "H"], allow_hyphen_values = true, requires = "crs")]
    pub offset: Option<Vec<f64>>,
    /// Forget these parts of the frame first
    #[arg(long, value_name = "PART", num_args = 1.., value_parser = one_of(PARTS))]
    pub remove: Vec<FramePart>,
    /// Forget the whole frame first
    #[arg(long)]
    pub reset: bool,
}

/// Units of models, in metres.
const UNITS: &[(&str, f64, &str)] = &[
    ("m", 1.0, "Metres"),
    ("cm", 0.01, "Centimetres"),
    ("mm", 0.001, "Millimetres"),
    ("ft", FOOT_M, "Feet"),
    ("in", INCH_M, "Inches"),
];
const FOOT_M: f64 = 0.3048;
const INCH_M: f64 = 0.0254;

const PARTS: &[(&str, FramePart, &str)] = &[
    ("level", FramePart::Level, "The up direction, and north with it"),
    ("scale", FramePart::Scale, "The unit"),
    ("north", FramePart::North, "The direction of north"),
    ("origin", FramePart::Origin, "The origin"),
    ("crs", FramePart::Crs, "The coordinate reference system"),
];

impl FrameArgs {
    /// Returns what is to change.
    ///
    /// # Errors
    /// A sentence about a length or an angle that is none.
    pub fn change(&self) -> Result<FrameChange, String> {
        let scale = self.scale.as_deref().map(known_length).transpose()?;
        let north = self
            .north
            .as_deref()
            .map(|points| known_direction(points, self.azimuth.unwrap_or(0.0)))
            .transpose()?;
        let offset = self.offset.as_deref().and_then(|offset| <[f64; 3]>::try_from(offset).ok());
        if offset.is_some_and(|offset| offset.iter().any(|x| !x.is_finite())) {
            return Err("--offset takes three finite numbers: east, north and height".into());
        }
        let unit_name = |metres: f64| {
            let name = UNITS.iter().find(|(_, unit, _)| *unit == metres).map_or("m", |(name, ..)| name);
            (metres, name.to_owned())
        };
        Ok(FrameChange {
            remove: if self.reset { FramePart::ALL.to_vec() } else { self.remove.clone() },
            level: self.level.as_deref().map(level),
            scale,
            unit: self.unit.map(unit_name),
            north,
            origin: self.origin.clone(),
            crs: self.crs.zip(offset).map(|(epsg, offset)| MapReference { epsg, offset }),
        })
    }
}

fn level(words: &[String]) -> Level {
    match words {
        [] => Level::Verticals,
        [word] if word == "verticals" => Level::Verticals,
        [word] if word == "cameras" => Level::Cameras,
        faces => Level::Faces(faces.to_vec()),
    }
}

fn known_length(values: &[String]) -> Result<KnownLength, String> {
    let [a, b, length] = values else { return Err("--scale takes A, B and a length".into()) };
    let metres = metres(length).map_err(|why| format!("--scale: {why}"))?;
    Ok(KnownLength { between: [a.clone(), b.clone()], metres })
}

fn known_direction(points: &[String], azimuth_deg: f64) -> Result<KnownDirection, String> {
    let [a, b] = points else { return Err("--north takes A and B".into()) };
    Ok(KnownDirection { from_to: [a.clone(), b.clone()], azimuth_deg })
}

/// Parses a length above 0, with a unit or in metres.
pub fn metres(text: &str) -> Result<f64, String> {
    let number = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = &text[number.len()..];
    // An exponent without digits is a part of the unit's word.
    let factor = match unit {
        "" => Some(1.0),
        unit => UNITS.iter().find(|(name, ..)| *name == unit).map(|(_, metres, _)| *metres),
    };
    let length = number.trim().parse::<f64>().ok().zip(factor).map(|(number, factor)| number * factor);
    length.filter(|length| length.is_finite() && *length > 0.0).ok_or_else(|| {
        format!("{text:?} is no length above 0; write 12.34 for metres, or 12.34m, 85cm, 850mm, 40ft or 6in")
    })
}

fn epsg(text: &str) -> Result<u32, String> {
    let number = text.strip_prefix("EPSG:").or_else(|| text.strip_prefix("epsg:")).unwrap_or(text);
    number.parse().ok().filter(|number| (1024..=32766).contains(number)).ok_or_else(|| {
        "expected the number of a projected system in EPSG's register, such as EPSG:25832; numbers are 1024 to 32766".into()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_units_and_systems_have_numbers() {
        assert_eq!([metres("12.5"), metres("850mm"), metres("10ft")], [Ok(12.5), Ok(0.85), Ok(3.048)]);
        assert!(metres("0").is_err() && metres("3 furlongs").is_err() && metres("mm").is_err());
        assert_eq!(epsg("EPSG:25832"), Ok(25832));
        assert!(epsg("4").is_err() && epsg("UTM").is_err());
    }
}
