//! The frame of a site: what makes the cameras' world level, metric and oriented. COLMAP's world is tilted and has no unit.

use std::fmt;

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

use quadratura_base::geometry::Similarity;

/// What is known of the site's frame. Each part is optional; without any, the frame is the cameras' world.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SiteFrame {
    /// The up direction in the cameras' world, of length 1.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "unit_direction")]
    pub up: Option<Stated<[f64; 3]>>,
    /// Metres per unit of the cameras' world, above 0.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "positive")]
    pub scale: Option<Stated<f64>>,
    /// The direction of north in the cameras' world, of length 1; its level part counts.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "unit_direction")]
    pub north: Option<Stated<[f64; 3]>>,
    /// The point of the cameras' world that is 0, 0, 0 in the frame.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "point")]
    pub origin: Option<Stated<[f64; 3]>>,
    /// The coordinate reference system of maps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub crs: Option<MapReference>,
}

/// A value and what it was taken from, in words.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stated<T> {
    /// The value.
    pub value: T,
    /// What it was taken from.
    pub from: String,
}

/// Where the frame is in a coordinate reference system: its X is east, its Y north, its Z height, in metres.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapReference {
    /// The number of the projected system in EPSG's register.
    pub epsg: u32,
    /// East, north and height of the frame's 0, 0, 0, in metres.
    pub offset: [f64; 3],
}

/// A part of the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum FramePart {
    /// The up direction.
    Level,
    /// The unit.
    Scale,
    /// The direction of north.
    North,
    /// The origin.
    Origin,
    /// The coordinate reference system.
    Crs,
}

impl FramePart {
    /// All parts.
    pub const ALL: [Self; 5] = [Self::Level, Self::Scale, Self::North, Self::Origin, Self::Crs];

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Level => "level",
            Self::Scale => "scale",
            Self::North => "north",
            Self::Origin => "origin",
            Self::Crs => "crs",
        }
    }
}

impl fmt::Display for FramePart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl SiteFrame {
    /// Returns whether nothing is known.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Returns whether a part is known.
    pub fn has(&self, part: FramePart) -> bool {
        match part {
            FramePart::Level => self.up.is_some(),
            FramePart::Scale => self.scale.is_some(),
            FramePart::North => self.north.is_some(),
            FramePart::Origin => self.origin.is_some(),
            FramePart::Crs => self.crs.is_some(),
        }
    }

    /// Forgets a part, and the coordinate reference system, which needs all others.
    pub fn remove(&mut self, part: FramePart) {
        match part {
            FramePart::Level => (self.up, self.north) = (None, None),
            FramePart::Scale => self.scale = None,
            FramePart::North => self.north = None,
            FramePart::Origin => self.origin = None,
            FramePart::Crs => (),
        }
        self.crs = None;
    }

    /// Returns metres per unit of the cameras' world, where the site has a unit.
    pub fn metres_per_unit(&self) -> Option<f64> {
        self.scale.as_ref().map(|scale| scale.value)
    }

    /// Returns the unit of lengths in the frame.
    pub fn unit(&self) -> &'static str {
        if self.scale.is_some() { "m" } else { "units" }
    }

    /// Returns the rows of the frame's axes in the cameras' world: X, to the east where north is known; Y, to the north; Z, up. They are
    /// the world's own where up is not known. Without north, X is nearest to the world's X, else its Y.
    pub fn axes(&self) -> DMat3 {
        let Some(up) = self.up.as_ref().and_then(|up| DVec3::from_array(up.value).try_normalize()) else {
            return DMat3::IDENTITY;
        };
        let level = |direction: DVec3| {
            let level = direction.reject_from_normalized(up);
            (level.length() > LEAST_LEVEL).then(|| level.normalize())
        };
        let north = self.north.as_ref().and_then(|north| level(DVec3::from_array(north.value)));
        let east = north.map(|north| north.cross(up)).or_else(|| level(DVec3::X)).or_else(|| level(DVec3::Y));
        let east = east.unwrap_or_else(|| up.any_orthonormal_vector());
        DMat3::from_cols(east, up.cross(east), up).transpose()
    }

    /// Returns the transform from the cameras' world to the frame.
    pub fn frame_from_world(&self) -> Similarity {
        let (rotation, scale) = (self.axes(), self.metres_per_unit().unwrap_or(1.0));
        let origin = self.origin.as_ref().map_or(DVec3::ZERO, |origin| DVec3::from_array(origin.value));
        Similarity { scale, rotation, translation: rotation * (origin * -scale) }
    }
}

/// The least length of the level part of a unit direction that still says a direction: half a degree.
const LEAST_LEVEL: f64 = 0.01;

/// Half a step of a direction's length in files that were written by hand.
const ROUNDING: f64 = 1e-3;

fn finite(value: &[f64; 3]) -> bool {
    value.iter().all(|x| x.is_finite())
}

fn stated<'de, D: serde::Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
    is_good: impl Fn(&T) -> bool,
    expected: &str,
) -> Result<Option<Stated<T>>, D::Error> {
    let stated = Option::<Stated<T>>::deserialize(deserializer)?;
    match stated.as_ref().is_none_or(|stated| is_good(&stated.value)) {
        true => Ok(stated),
        false => Err(serde::de::Error::custom(format!("the value is not {expected}"))),
    }
}

fn unit_direction<'de, D: serde::Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<Stated<[f64; 3]>>, D::Error> {
    let is_good = |value: &[f64; 3]| (DVec3::from_array(*value).length() - 1.0).abs() < ROUNDING;
    stated(deserializer, is_good, "a direction of length 1")
}

fn positive<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Option<Stated<f64>>, D::Error> {
    stated(deserializer, |value: &f64| value.is_finite() && *value > 0.0, "a number above 0")
}

fn point<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Option<Stated<[f64; 3]>>, D::Error> {
    stated(deserializer, finite, "three finite numbers")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of<T>(value: T) -> Option<Stated<T>> {
        Some(Stated { value, from: "a test".into() })
    }

    #[test]
    fn a_frame_of_nothing_is_the_cameras_world() {
        assert_eq!(SiteFrame::default().frame_from_world(), Similarity::IDENTITY);
        assert!(SiteFrame::default().is_empty());
    }

    #[test]
    fn a_tilted_world_becomes_level_metric_and_oriented() {
        // Up is the world's -Y, north its Z, as in many results of COLMAP; a unit is half a metre.
        let frame = SiteFrame {
            up: of([0.0, -1.0, 0.0]),
            scale: of(0.5),
            north: of([0.0, 0.6, 0.8]),
            origin: of([10.0, 20.0, 30.0]),
            crs: None,
        };
        let similarity = frame.frame_from_world();
        let at = |x, y, z| similarity.apply(DVec3::new(x, y, z));
        assert!((at(10.0, 20.0, 30.0)).length() < 1e-12);
        assert!((at(10.0, 18.0, 30.0) - DVec3::Z).length() < 1e-12, "two units up are a metre up");
        assert!((at(10.0, 20.0, 32.0) - DVec3::Y).length() < 1e-12, "the level part of north counts");
        assert!((at(12.0, 20.0, 30.0) - DVec3::X).length() < 1e-12);
        assert!((similarity.rotation.determinant() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_removed_takes_with_it_what_needs_it() {
        let mut frame = SiteFrame {
            up: of([0.0, 0.0, 1.0]),
            north: of([0.0, 1.0, 0.0]),
            crs: Some(MapReference { epsg: 25832, offset: [0.0; 3] }),
            ..SiteFrame::default()
        };
        frame.remove(FramePart::Level);
        assert!(frame.is_empty(), "{frame:?}");
    }

    #[test]
    fn values_that_say_nothing_are_refused_when_they_are_read() {
        for (text, word) in [
            (r#"{"up": {"value": [0, 0, 0], "from": "x"}}"#, "length 1"),
            (r#"{"scale": {"value": 0, "from": "x"}}"#, "above 0"),
            (r#"{"scale": {"value": 1}}"#, "from"),
            (r#"{"uq": 1}"#, "uq"),
        ] {
            let error = serde_json::from_str::<SiteFrame>(text).unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
        }
        let frame: SiteFrame = serde_json::from_str(r#"{"scale": {"value": 2, "from": "x"}}"#).unwrap();
        assert_eq!(frame.metres_per_unit(), Some(2.0));
    }
}
