//! The words of an orthophoto: its name, its description, and the title block of its page.

use super::report::OrthoReport;
use super::{OrthoOptions, OrthoPlan, Subject};
use quadratura_io::ortho::page::{PageText, round};
use quadratura_sites::open::Opened;

/// Returns what an orthophoto is of, in words.
pub(super) fn named(subject: &Subject) -> String {
    match subject {
        Subject::On(names) => names.join(", "),
        Subject::Plan(names) if names.is_empty() => "plan".into(),
        Subject::Plan(names) => format!("plan of {}", names.join(", ")),
        Subject::Section([a, b]) => format!("section from {a} to {b}"),
    }
}

/// The longest name of files that is made of names of objects, in characters.
const LONGEST_NAME: usize = 48;

/// Returns a name of files without ending.
pub(super) fn file_name(subject: &Subject) -> String {
    let name = match subject {
        Subject::On(names) => names.join("+"),
        Subject::Plan(names) if names.is_empty() => "plan".into(),
        Subject::Plan(names) => format!("plan-{}", names.join("+")),
        Subject::Section(_) => "section".into(),
    };
    let kept = |c: char| if c.is_alphanumeric() || "._+-".contains(c) { c } else { '_' };
    let name: String = name.chars().map(kept).take(LONGEST_NAME).collect();
    name.trim_matches(['.', '_']).to_owned()
}

/// Returns a length with a unit that suits it.
pub(super) fn length(metres: f64) -> String {
    if metres < 1.0 { format!("{} mm", round(metres * 1000.0)) } else { format!("{} m", round(metres)) }
}

/// Returns the sentence that is written into pictures.
pub(super) fn description(report: &OrthoReport) -> String {
    format!(
        "Orthophoto of {}, 1:{} at {} dpi, {} per pixel; record {:.1} %, reconstruction {:.1} %, not known {:.1} %",
        report.subject,
        round(report.scale),
        round(report.dpi),
        length(report.pixel_m),
        100.0 * report.shares.record(),
        100.0 * report.shares.reconstruction(),
        100.0 * report.shares.nothing,
    )
}

/// Returns the words of the page.
pub(super) fn text(
    opened: &Opened,
    plan: &OrthoPlan,
    options: &OrthoOptions,
    report: &OrthoReport,
) -> PageText {
    let [width, height] = report.size_px.map(|side| f64::from(side) * report.pixel_m);
    let mut rows = vec![
        ("Scale", format!("1:{}", round(report.scale))),
        ("Picture", format!("{width:.2} x {height:.2} m, {} a pixel", length(report.pixel_m))),
    ];
    if let Some(pixel) = report.photo_pixel_m {
        rows.push(("Photos", format!("{:.1} mm a pixel on the surface, in the median", 1000.0 * pixel)));
    }
    let shares = &report.shares;
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let (record, rest) = (percent(shares.record()), percent(shares.reconstruction()));
    rows.push((
        "Sources",
        format!("record {record}, reconstruction {rest}, not known {}", percent(shares.nothing)),
    ));
    rows.push(("Frame", frame_of(opened)));
    if let Some([east, north]) = report.map_corner {
        rows.push(("Corner", format!("E {east:.3}  N {north:.3}, upper left")));
    }
    PageText {
        title: options.title.clone().unwrap_or_else(|| report.subject.clone()),
        rows: rows.into_iter().map(|(what, which)| (what.to_owned(), which)).collect(),
        scale: report.scale,
        pixel_m: report.pixel_m,
        north_deg: north(opened, plan),
    }
}

/// Returns the frame in a few words.
fn frame_of(opened: &Opened) -> String {
    let frame = &opened.project.frame;
    match &frame.crs {
        Some(crs) => format!("EPSG:{}", crs.epsg),
        None => {
            let scale =
                frame.scale.as_ref().map_or(String::new(), |scale| format!("scale from {}", scale.from));
            let level = if frame.up.is_some() { "level, " } else { "" };
            format!("{level}{scale}")
        }
    }
}

/// Returns the direction of north in the picture, clockwise from up, in degrees: of plans of sites whose north is known.
fn north(opened: &Opened, plan: &OrthoPlan) -> Option<f64> {
    opened.project.frame.north.as_ref()?;
    let plane = &plan.subject.plane;
    let north = opened.project.frame.axes().row(1);
    let (right, up) = (north.dot(plane.right), -north.dot(plane.down));
    (right.hypot(up) > 0.99).then(|| right.atan2(up).to_degrees())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_keep_letters_and_say_what_it_is() {
        let of = |name: &str| file_name(&Subject::On(vec![name.into()]));
        assert_eq!(of("church.facade"), "church.facade");
        assert_eq!(of("Façade/west[3]"), "Façade_west_3");
        assert_eq!(file_name(&Subject::Plan(Vec::new())), "plan");
        assert_eq!([length(0.002), length(12.5)], ["2 mm", "12.5 m"]);
    }
}
