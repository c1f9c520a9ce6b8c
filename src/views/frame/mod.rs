//! The frame of a site: level, unit, north, origin and coordinate reference system, from points and faces that a user names.

mod level;
mod named;
mod points;
mod words;

pub use self::level::{Level, up_of};
pub use self::named::{area_vector, faces_named};
pub use self::points::{FORMS, point_named};
pub use self::words::described;

use glam::DVec3;
use serde::Serialize;

use quadratura_base::error::{Error, Result};
use quadratura_base::scene::up;
use quadratura_document::SiteFrame;
use quadratura_document::frame::{FramePart, MapReference, Stated};
use quadratura_sites::open::Opened;

/// A length between two points.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownLength {
    /// The names of the points.
    pub between: [String; 2],
    /// The length in metres.
    pub metres: f64,
}

/// Two points whose direction is known.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownDirection {
    /// The names of the points.
    pub from_to: [String; 2],
    /// The direction from the first to the second, in degrees from north, clockwise seen from above.
    pub azimuth_deg: f64,
}

/// What is to change of a frame; what is `None` stays.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FrameChange {
    /// The parts that are forgotten first.
    pub remove: Vec<FramePart>,
    /// What the up direction is taken from.
    pub level: Option<Level>,
    /// A length that is known.
    pub scale: Option<KnownLength>,
    /// Metres per unit of the model's file, and the unit's name.
    pub unit: Option<(f64, String)>,
    /// A direction that is known.
    pub north: Option<KnownDirection>,
    /// The point that becomes 0, 0, 0.
    pub origin: Option<String>,
    /// The coordinate reference system.
    pub crs: Option<MapReference>,
}

impl FrameChange {
    /// Returns whether nothing is to change.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// The shortest length between two points that says a scale or a direction, as a share of the extent of the model.
const SHORTEST: f64 = 1e-6;

/// Returns the frame of a project after a change.
///
/// # Errors
/// Returns [`Error::Request`] for points and faces that do not exist, two points that are the same, a direction to north that is upright,
/// north without a level, and a coordinate reference system without level, scale and north.
pub fn changed(opened: &Opened, change: &FrameChange) -> Result<SiteFrame> {
    let mut frame = opened.project.frame.clone();
    change.remove.iter().for_each(|part| frame.remove(*part));
    if let Some(level) = &change.level {
        frame.up = Some(level::leveled(opened, level)?);
    }
    if let Some(known) = &change.scale {
        frame.scale = Some(scaled(opened, known)?);
    }
    if let Some((metres, unit)) = &change.unit {
        let value = metres / opened.project.world_from_model.scale;
        frame.scale = Some(Stated { value, from: format!("the model's unit, {unit}") });
    }
    if let Some(known) = &change.north {
        frame.north = Some(oriented(opened, &frame, known)?);
    }
    if let Some(origin) = &change.origin {
        let value = point_named(opened, origin)?.to_array();
        frame.origin = Some(Stated { value, from: origin.clone() });
    }
    if let Some(crs) = &change.crs {
        frame.crs = Some(crs.clone());
    }
    if frame.crs.is_some() {
        check_for_maps(&frame)?;
    }
    Ok(frame)
}

/// Checks that a frame can be placed on a map.
fn check_for_maps(frame: &SiteFrame) -> Result<()> {
    let needed = [FramePart::Level, FramePart::Scale, FramePart::North];
    let missing: Vec<String> =
        needed.into_iter().filter(|part| !frame.has(*part)).map(|part| format!("--{part}")).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let found = "a coordinate reference system needs a frame that is level, in metres and to the north";
    Err(Error::Request(format!("{found}; give {}, too", missing.join(" and "))))
}

/// Returns two points that are apart, and the vector from the first to the second.
fn apart(opened: &Opened, [a, b]: &[String; 2], what: &str) -> Result<DVec3> {
    let (from, to) = (point_named(opened, a)?, point_named(opened, b)?);
    let vertices = &opened.site.model.vertices;
    let extent = vertices.iter().map(|vertex| vertex.distance(from)).fold(0.0, f64::max);
    if from.distance(to) <= SHORTEST * extent {
        return Err(Error::Request(format!(
            "{a} and {b} are the same point, which says no {what}; name two points that are apart"
        )));
    }
    Ok(to - from)
}

fn scaled(opened: &Opened, KnownLength { between, metres }: &KnownLength) -> Result<Stated<f64>> {
    let units = apart(opened, between, "scale")?.length();
    let [a, b] = between;
    Ok(Stated { value: metres / units, from: format!("{metres} m from {a} to {b}") })
}

fn oriented(
    opened: &Opened,
    frame: &SiteFrame,
    KnownDirection { from_to, azimuth_deg }: &KnownDirection,
) -> Result<Stated<[f64; 3]>> {
    let Some(level) = &frame.up else {
        return Err(Error::Request("north is a level direction; give --level, too".into()));
    };
    let up = DVec3::from_array(level.value);
    let along = apart(opened, from_to, "direction")?;
    let [a, b] = from_to;
    let flat = along.reject_from(up);
    if flat.length() < 0.05 * along.length() {
        return Err(Error::Request(format!(
            "{b} is above or below {a}, which says no direction to north; name two points beside each other"
        )));
    }
    // Clockwise from above is the negative sense about up; north is that far back.
    let north = glam::DQuat::from_axis_angle(up.normalize(), azimuth_deg.to_radians()) * flat.normalize();
    let from = format!("{azimuth_deg} degrees from north from {a} to {b}");
    Ok(Stated { value: north.to_array(), from })
}

/// A frame as it is shown.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FrameReport {
    /// The frame as it is kept.
    pub frame: SiteFrame,
    /// The rows of the 4 x 4 matrix from the cameras' world to the frame.
    pub frame_from_world: [[f64; 4]; 4],
    /// The extent of the model in the frame: the least and the largest coordinates.
    pub extent: [[f64; 3]; 2],
    /// The angle between up and the mean up direction of the cameras, in degrees, where up is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub off_cameras_deg: Option<f64>,
}

/// Returns what there is to say about a frame of an opened site.
pub fn report(opened: &Opened, frame: &SiteFrame) -> FrameReport {
    let frame_from_world = frame.frame_from_world();
    let points = opened.site.model.vertices.iter().map(|vertex| frame_from_world.apply(*vertex));
    let (low, high) =
        points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let of_cameras = up(&opened.site.photos);
    let off = |up: &Stated<[f64; 3]>| DVec3::from_array(up.value).angle_between(of_cameras).to_degrees();
    FrameReport {
        frame: frame.clone(),
        frame_from_world: frame_from_world.into(),
        extent: [low.to_array(), high.to_array()],
        off_cameras_deg: frame.up.as_ref().map(off),
    }
}
