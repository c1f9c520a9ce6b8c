//! Cameras of other programs: how a project is made of them, and what is reported.

use std::fs;

use super::site::{Site, stderr_of, stdout_of};

/// The cameras of [`Site::new`] as Metashape's XML, with two chunks; with -1 as `y`, markers are where the photos do not show one point.
fn metashape(y: i32) -> String {
    let camera = |id: usize, label: &str, x: usize| {
        format!(
            "<camera id=\"{id}\" sensor_id=\"0\" label=\"{label}\"><transform>1 0 0 {x} 0 1 0 0 0 0 1 0 0 0 0 1</transform></camera>"
        )
    };
    // Points of the wall at depth 12 and nearer, where both photos show them: a focal length of 160 pixels.
    let marker = |index: i32| {
        let (px, py, depth) = (f64::from(index % 4), f64::from(index / 4 - 1), f64::from(8 + index % 3));
        let places: String = (0..2)
            .map(|id| {
                let (u, v) = (80.0 + 160.0 * (px - f64::from(id)) / depth, 160.0 * py / depth);
                format!(
                    "<location camera_id=\"{id}\" x=\"{u}\" y=\"{}\"/>",
                    60.0 + f64::from(y) * v + f64::from(1 - y) * 5.0 * f64::from(id)
                )
            })
            .collect();
        format!("<marker marker_id=\"{index}\">{places}</marker>")
    };
    let sensors = "<sensors><sensor id=\"0\" type=\"frame\"><calibration type=\"frame\" class=\"adjusted\">\
                   <resolution width=\"160\" height=\"120\"/><f>160</f></calibration></sensor></sensors>";
    let markers: String = (0..12).map(marker).collect();
    let cameras = camera(0, "left", 0)
        + &camera(1, "tür 2", 1)
        + "<camera id=\"2\" sensor_id=\"0\" label=\"blurred\"/>";
    let other = camera(0, "left", 0);
    format!(
        "<?xml version=\"1.0\"?><document version=\"2.0.0\"><chunk label=\"all\">{sensors}<cameras>{cameras}</cameras>\
         <frames><frame id=\"0\"><markers>{markers}</markers></frame></frames></chunk>\
         <chunk label=\"one\">{sensors}<cameras>{other}</cameras></chunk></document>"
    )
}

#[test]
fn a_project_is_made_of_metashapes_cameras_and_says_how_well_they_fit() {
    let site = Site::new();
    fs::write(site.path("cameras.xml"), metashape(1)).unwrap();
    let new = "--photos photos --cameras cameras.xml --model model.obj";
    let made = site.run(&format!("new project {new}")).success();
    let (text, notes) = (stdout_of(&made), stderr_of(&made));
    assert!(
        text.contains("2 of 2") && text.contains("reprojection error  0.00 px (median of 24 observations)"),
        "{text}"
    );
    assert!(notes.contains("1 of 3 cameras are not aligned"), "{notes}");
    assert!(
        notes.contains("the chunk \"all\" is read") && !notes.contains("another image format"),
        "{notes}"
    );
    let one = site.run(&format!("new one {new} --chunk one")).success();
    assert!(stdout_of(&one).contains("1 of 1"));
    assert!(fs::read_to_string(site.path("one/project.json")).unwrap().contains("\"chunk\": \"one\""));
    let none = stderr_of(&site.run(&format!("new none {new} --chunk none")).failure());
    assert!(none.contains("there is no chunk \"none\"; there are \"all\""), "{none}");
}

#[test]
fn cameras_that_do_not_fit_their_own_observations_are_warned_about() {
    let site = Site::new();
    fs::write(site.path("cameras.xml"), metashape(-1)).unwrap();
    let made =
        site.run("new project --photos photos --cameras cameras.xml --model model.obj --json").success();
    let (made, notes) = (super::site::json_of(&made), stderr_of(&made));
    let median = made["reprojection"]["median_px"].as_f64().unwrap();
    assert!(median > 3.0 && notes.contains("median reprojection error"), "{median}: {notes}");
    assert!(!made["reprojection"]["variants"].as_array().unwrap().is_empty());
}
