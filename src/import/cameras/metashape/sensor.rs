//! Sensors of a chunk and their calibrations.
//!
//! A calibration has the focal length f in pixels, the principal point from the middle of the photo, and the lens: a point x, y of
//! the plane z = 1 is moved to
//!
//! ```text
//! x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6 + k4 r^8) + p1 (r^2 + 2 x^2) + 2 p2 x y
//! y' = y (1 + k1 r^2 + k2 r^4 + k3 r^6 + k4 r^8) + p2 (r^2 + 2 y^2) + 2 p1 x y
//! u = W / 2 + cx + x' f + x' b1 + y' b2,   v = H / 2 + cy + y' f
//! ```
//!
//! so that p1 and p2 are OpenCV's p2 and p1. For a fisheye, the point has the angle to the axis as its radius before.

use roxmltree::Node;

use super::super::foreign_text::{child, children, number};
use super::super::photo_name::short;
use super::super::raw::RawCamera;
use quadratura_base::geometry::Lens;
use quadratura_files::text::Objection;

/// A sensor as photos use it.
#[derive(Debug, Clone)]
pub(super) enum Sensor {
    /// It has a camera, or the reason why it has none.
    Camera(Result<RawCamera, Objection>),
    /// Its place is given by that of another sensor.
    OfRig,
}

const AGAIN: &str = "align the photos again, and export the cameras again";

/// Reads a sensor.
pub(super) fn sensor(node: Node<'_, '_>) -> Sensor {
    let id = node.attribute("id").unwrap_or_default();
    match node.attribute("master_id") {
        Some(master) if master != id => Sensor::OfRig,
        _ => Sensor::Camera(camera(node).map_err(|(found, remedy)| {
            (format!("sensor {}: {found}", short(node.attribute("label").unwrap_or(id))), remedy)
        })),
    }
}

fn camera(sensor: Node<'_, '_>) -> Result<RawCamera, Objection> {
    let of_class = |class: &str| {
        children(sensor, "calibration").find(|calibration| calibration.attribute("class") == Some(class))
    };
    let calibration = of_class("adjusted")
        .or_else(|| of_class("initial"))
        .or_else(|| child(sensor, "calibration"))
        .ok_or_else(|| ("it has no calibration".to_owned(), AGAIN))?;
    let size = size(child(calibration, "resolution").or_else(|| child(sensor, "resolution")))?;
    let value = |name: &str| {
        child(calibration, name).map_or(Ok(0.0), |node| number(node.text().unwrap_or_default(), name))
    };
    let f = value("f")?;
    let [cx, cy] = [value("cx")?, value("cy")?];
    let k = [value("k1")?, value("k2")?, value("k3")?, value("k4")?];
    let p = [value("p2")?, value("p1")?];
    let [b1, b2] = [value("b1")?, value("b2")?];
    for name in ["p3", "p4"] {
        let value = value(name)?;
        if value != 0.0 {
            let found = format!("{name} is {value}, and only p1 and p2 are supported");
            return Err((found, "calibrate without p3 and p4"));
        }
    }
    let fx = f + b1;
    let kind = calibration.attribute("type").or(sensor.attribute("type")).unwrap_or("frame");
    let lens = match kind {
        "frame" if k[3] == 0.0 && b2 == 0.0 => Lens::Brown { k: [k[0], k[1], k[2], 0.0, 0.0, 0.0], p },
        // f is judged later; without one there is no skew either.
        "frame" => Lens::Skewed { k, p, skew: if fx == 0.0 { 0.0 } else { b2 / fx } },
        "fisheye" | "equidistant_fisheye" if b2 == 0.0 => Lens::Fisheye { k, p, s: [0.0; 2] },
        "fisheye" | "equidistant_fisheye" => {
            return Err((
                format!("b2 is {b2}, expected 0 for a fisheye lens"),
                "calibrate fisheyes without b2",
            ));
        }
        "spherical" | "cylindrical" => {
            let found = format!("a {kind} panorama is not a pinhole image");
            return Err((found, "cut the panorama into pinhole views first"));
        }
        other => {
            let found = format!("the camera model is {}, expected frame or fisheye", short(other));
            return Err((found, "calibrate with one of these"));
        }
    };
    let centre = [0.5 * size[0] as f64 + cx, 0.5 * size[1] as f64 + cy];
    Ok(RawCamera { size, focal: [fx, f], centre, lens })
}

fn size(resolution: Option<Node<'_, '_>>) -> Result<[u64; 2], Objection> {
    let side = |name: &str| {
        let text = resolution.and_then(|node| node.attribute(name)).unwrap_or("missing");
        let side = text.parse::<u64>();
        side.map_err(|_| (format!("the {name} of its resolution is {}", short(text)), AGAIN))
    };
    Ok([side("width")?, side("height")?])
}
