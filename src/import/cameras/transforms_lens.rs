//! The camera of a frame of `transforms.json`: size, focal lengths, principal point and lens, each of the frame or of
//! the whole file.

use serde_json::{Map, Value};

use super::foreign_text::kind;
use super::raw::RawCamera;
use quadratura_base::geometry::Lens;
use quadratura_files::text::Objection;

/// The fields of a frame, and those of the whole file as their defaults.
#[derive(Clone, Copy)]
pub(super) struct Fields<'a> {
    pub frame: &'a Map<String, Value>,
    pub global: &'a Map<String, Value>,
}

impl<'a> Fields<'a> {
    /// Returns the frame's value, or else the file's.
    fn value(&self, key: &str) -> Option<&'a Value> {
        let there = |fields: &'a Map<String, Value>| fields.get(key).filter(|value| !value.is_null());
        there(self.frame).or_else(|| there(self.global))
    }

    fn number(&self, key: &str) -> Result<Option<f64>, Objection> {
        let number = |value: &Value| {
            let number = value.as_f64().filter(|number| number.is_finite());
            number.ok_or_else(|| {
                (
                    format!("{key} is {}, expected a number", kind(Some(value))),
                    "write a number there, without quotes",
                )
            })
        };
        self.value(key).map(number).transpose()
    }

    /// Returns true when the size is given, so that the photo's file is not needed for it.
    pub fn states_size(&self) -> bool {
        ["w", "h"].iter().all(|key| self.value(key).is_some())
    }

    fn side(&self, key: &str) -> Result<u64, Objection> {
        let number = self.number(key)?.unwrap_or(0.0);
        if !(1.0..=1e9).contains(&number) || number.fract() != 0.0 {
            return Err((
                format!("{key} is {number}, expected a number of pixels"),
                "write the photo's own size",
            ));
        }
        Ok(number as u64)
    }
}

/// Reads the camera of a frame; `of_file` gives the size of the photo's own file.
///
/// # Errors
/// Returns the problem and its remedy.
pub(super) fn camera(
    fields: Fields<'_>,
    of_file: impl FnOnce() -> Result<[u64; 2], Objection>,
) -> Result<RawCamera, Objection> {
    let size = if fields.states_size() { [fields.side("w")?, fields.side("h")?] } else { of_file()? };
    let [width, height] = size.map(|side| side as f64);
    let fx = focal_length(fields, ["fl_x", "camera_angle_x", "x_fov"], width)?;
    let fy = focal_length(fields, ["fl_y", "camera_angle_y", "y_fov"], height)?;
    let Some(fx) = fx.or(fy) else {
        let found = "there is no focal length: neither fl_x nor camera_angle_x";
        return Err((found.into(), "write fl_x, in pixels, in the frame or for the whole file"));
    };
    let centre = [fields.number("cx")?.unwrap_or(0.5 * width), fields.number("cy")?.unwrap_or(0.5 * height)];
    Ok(RawCamera { size, focal: [fx, fy.unwrap_or(fx)], centre, lens: lens(fields)? })
}

/// Reads a focal length in pixels from the first key that is present: in pixels, as an angle of view in radians, or in
/// degrees.
fn focal_length(fields: Fields<'_>, keys: [&str; 3], side: f64) -> Result<Option<f64>, Objection> {
    let of_angle = |angle: f64| 0.5 * side / (0.5 * angle).tan();
    let [pixels, radians, degrees] = keys;
    if let Some(pixels) = fields.number(pixels)? {
        return Ok(Some(pixels));
    }
    let (angle, key, unit, half_turn) = match fields.number(radians)? {
        Some(angle) => (angle, radians, "radians", std::f64::consts::PI),
        None => match fields.number(degrees)? {
            Some(angle) => (angle, degrees, "degrees", 180.0),
            None => return Ok(None),
        },
    };
    if !(angle > 0.0 && angle < half_turn) {
        let found = format!("{key} is {angle} {unit}, expected an angle of view below {half_turn:.4}");
        return Err((found, "write the angle that the photo sees from side to side"));
    }
    Ok(Some(of_angle(angle * std::f64::consts::PI / half_turn)))
}

/// Reads the lens model; parameters are those of OpenCV.
fn lens(fields: Fields<'_>) -> Result<Lens, Objection> {
    let number = |key: &str| Ok(fields.number(key)?.unwrap_or(0.0));
    let k = [number("k1")?, number("k2")?, number("k3")?, number("k4")?];
    let p = [number("p1")?, number("p2")?];
    let fisheye = match fields.value("is_fisheye") {
        None => false,
        Some(Value::Bool(fisheye)) => *fisheye,
        other => {
            let found = format!("is_fisheye is {}, expected true or false", kind(other));
            return Err((found, "write true or false there, without quotes"));
        }
    };
    for key in ["k5", "k6"] {
        // OpenCV's rational model has them; no program writes them here, and leaving them out would bend the photo.
        let value = number(key)?;
        if value != 0.0 {
            let found = format!("{key} is {value}, a coefficient that this format does not have");
            return Err((found, "calibrate with k1 to k3 and p1, p2 at most, or as OPENCV_FISHEYE"));
        }
    }
    let model = match fields.value("camera_model") {
        None if fisheye => "OPENCV_FISHEYE",
        None => "OPENCV",
        Some(Value::String(model)) => model.as_str(),
        other => {
            return Err((
                format!("camera_model is {}, expected a name", kind(other)),
                "write OPENCV or OPENCV_FISHEYE",
            ));
        }
    };
    match model {
        "SIMPLE_PINHOLE" | "PINHOLE" | "SIMPLE_RADIAL" | "RADIAL" | "OPENCV" | "PERSPECTIVE" => {
            // OpenCV divides by 1 + k4 r^2, nerfstudio multiplies by 1 + .. + k4 r^8: no program writes it.
            if k[3] != 0.0 {
                let found = format!("k4 is {} in {model}, which programs understand differently", k[3]);
                return Err((found, "calibrate without k4, or as OPENCV_FISHEYE"));
            }
            Ok(Lens::Brown { k: [k[0], k[1], k[2], 0.0, 0.0, 0.0], p })
        }
        "OPENCV_FISHEYE" | "RADIAL_FISHEYE" | "SIMPLE_RADIAL_FISHEYE" | "FISHEYE" => {
            if p != [0.0; 2] {
                let found = format!("p1 and p2 are {p:?}, which {model} does not have");
                return Err((found, "calibrate without them, or as OPENCV"));
            }
            Ok(Lens::Fisheye { k, p, s: [0.0; 2] })
        }
        "EQUIRECTANGULAR" => Err((
            "a spherical panorama (EQUIRECTANGULAR) is not a pinhole image".into(),
            "cut the panorama into pinhole views first (nerfstudio's ns-process-data can)",
        )),
        _ => {
            let found = format!(
                "the camera model {}; known are OPENCV, OPENCV_FISHEYE, PINHOLE and others of COLMAP's \
                                 with the same k1, k2, p1, p2",
                kind(fields.value("camera_model"))
            );
            Err((found, "calibrate with one of these"))
        }
    }
}
