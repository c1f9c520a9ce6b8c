//! What is known of a site's frame, in words.

use quadratura_document::SiteFrame;
use quadratura_document::frame::FramePart;

/// Returns what is known of a part, in words.
pub fn described(frame: &SiteFrame, part: FramePart) -> Option<String> {
    let vector = |v: [f64; 3]| v.map(|x| format!("{:.6}", x + 0.0)).join(",");
    match part {
        FramePart::Level => frame
            .up
            .as_ref()
            .map(|up| format!("up is {} in the cameras' world, from {}", vector(up.value), up.from)),
        FramePart::Scale => frame.scale.as_ref().map(|scale| {
            format!("{} m per unit of the cameras' world, from {}", nine(scale.value), scale.from)
        }),
        FramePart::North => {
            frame.north.as_ref().map(|north| format!("{}, from {}", vector(north.value), north.from))
        }
        FramePart::Origin => {
            frame.origin.as_ref().map(|origin| format!("{}, from {}", vector(origin.value), origin.from))
        }
        FramePart::Crs => frame.crs.as_ref().map(|crs| {
            let [e, n, h] = crs.offset;
            format!("EPSG:{}, 0,0,0 is E {e} N {n} H {h}", crs.epsg)
        }),
    }
}

/// Rounds a number to nine decimals, which are shown without trailing zeros.
fn nine(number: f64) -> f64 {
    (number * 1e9).round() / 1e9
}
