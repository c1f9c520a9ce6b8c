//! Pix4D's, MVE's and Polycam's files: written by their definitions, read, and damaged.

#![cfg(test)]

use std::fmt::Write as _;

use glam::{DMat3, DVec3};
use serde_json::json;

use super::others::{K, P, brown, pinhole, plane};
use super::{Shot, Site, Written, assert_agrees, assert_survives};
use crate::cameras::{CameraOptions, Cameras};

fn usual() -> CameraOptions {
    CameraOptions::default()
}

fn is_noted(read: &Cameras, words: &str) -> bool {
    read.notes.iter().any(|note| note.contains(words))
}

/// Returns the only problem, of a file of which all other photos are read.
#[track_caller]
fn only_problem(written: &Written, photos: usize) -> String {
    let read = written.read(&usual()).unwrap();
    let problems: Vec<String> = read.problems.iter().map(ToString::to_string).collect();
    assert_eq!((read.photos.len(), problems.len()), (photos - 1, 1), "{problems:?}");
    problems[0].clone()
}

/// Pix4D's list of calibrated cameras, with the offset beside it.
fn pix4d(site: &Site) -> Written {
    let mut text = String::from(
        "fileName imageWidth imageHeight \ncamera matrix K [3x3]\nradial distortion [3x1]\ntangential distortion [2x1]\n\
         camera position t [3x1]\ncamera rotation R [3x3]\ncamera model m = K [R|-Rt] X\n\n",
    );
    for shot in &site.shots {
        let ([w, h], f, [cx, cy], c, r) = (shot.size, shot.f, shot.centre_px, shot.centre, shot.rows());
        writeln!(text, "{} {w} {h}\n{f:?} 0 {cx:?}\n0 {f:?} {cy:?}\n0 0 1", shot.name).unwrap();
        writeln!(text, "{:?} {:?} {:?}\n{:?} {:?}", K[0], K[1], K[2], P[0], P[1]).unwrap();
        writeln!(text, "{:?} {:?} {:?}", c.x, c.y, c.z).unwrap();
        r.chunks(3).for_each(|row| writeln!(text, "{:?} {:?} {:?}", row[0], row[1], row[2]).unwrap());
    }
    let files = vec![
        ("site_calibrated_camera_parameters.txt".to_owned(), text.into_bytes()),
        ("site_offset.xyz".to_owned(), b"412345.000 5654321.000 101.000\n".to_vec()),
    ];
    Written { files, observed: brown(site, K, P) }
}

/// MVE's views.
fn mve(site: &Site) -> Written {
    let file = |(index, shot): (usize, &Shot)| {
        let [w, h] = shot.size.map(f64::from);
        let (rows, t) = (shot.rows().map(|value| format!("{value:?}")), -(shot.rotation * shot.centre));
        let name = shot.name.trim_end_matches(".jpg");
        let text = format!(
            "# MVE view meta data is stored in INI-file syntax.\n\n[camera]\nfocal_length = {:?}\npixel_aspect = 1\n\
             principal_point = {:?} {:?}\nradial_distortion = {:?} {:?}\nrotation = {}\ntranslation = {:?} {:?} {:?}\n\n\
             [view]\nid = {index}\nname = {name}\n",
            shot.f / shot.longer_side(),
            shot.centre_px[0] / w,
            shot.centre_px[1] / h,
            K[0],
            K[1],
            rows.join(" "),
            t.x,
            t.y,
            t.z
        );
        (format!("views/view_{index:04}.mve/meta.ini"), text.into_bytes())
    };
    let files = site.shots.iter().enumerate().map(file).collect();
    Written { files, observed: brown(site, [K[0], K[1], 0.0], [0.0; 2]) }
}

/// Polycam's keyframes.
fn polycam(site: &Site) -> Written {
    let file = |shot: &Shot| {
        let gl = shot.rotation.transpose() * DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0));
        let mut frame = json!({
            "fx": shot.f, "fy": shot.f, "cx": shot.centre_px[0], "cy": shot.centre_px[1],
            "width": shot.size[0], "height": shot.size[1], "blur_score": 88.5, "timestamp": 262195552056u64,
        });
        for row in 0..3 {
            for column in 0..3 {
                frame[format!("t_{row}{column}")] = json!(gl.col(column)[row]);
            }
            frame[format!("t_{row}3")] = json!(shot.centre[row]);
        }
        let name = shot.name.replace(".jpg", ".json");
        (format!("keyframes/corrected_cameras/{name}"), format!("{frame:#}").into_bytes())
    };
    let observed = site.observed(|shot, point| pinhole(shot, plane(shot, point)));
    Written { files: site.shots.iter().map(file).collect(), observed }
}

#[test]
fn pix4ds_list_shows_every_point_where_its_formula_has_it() {
    let site = Site::piazza();
    let written = pix4d(&site);
    let read = assert_agrees(&site, &written, &usual());
    assert!(is_noted(&read, "less 412345, 5654321, 101"), "{:?}", read.notes);
    let plain = written.with("camera model m = K [R|-Rt] X\n\n", "camera model m = K [R|-Rt] X\n");
    assert_agrees(&site, &plain, &usual());
    for (from, to, expected) in [
        ("0 0 1\n", "0 1 1\n", "K is no matrix of intrinsics"),
        (" 0 1080", " 0.5 1080", "K has a skew of 0.5"),
        ("-0.06 0.015", "-0.06 x", "the radial distortion is \"x\""),
    ] {
        let said = only_problem(&written.with(from, to), 9);
        assert!(said.contains(expected) && said.contains("01_church"), "{said}");
    }
    let text = String::from_utf8(written.files[0].1.clone()).unwrap();
    let cut = |lines: usize| {
        let text = text.lines().take(lines).collect::<Vec<_>>().join("\n");
        Written::one("site_calibrated_camera_parameters.txt", text, Vec::new()).refused()
    };
    assert!(cut(12).contains("the file ends after 3 of the 9 lines of \"01_church.jpg\""), "{}", cut(12));
    assert!(cut(7).contains("it has no photo"), "{}", cut(7));
}

#[test]
fn mves_views_show_every_point_where_their_formula_has_it() {
    let site = Site::piazza();
    let written = mve(&site);
    assert_agrees(&site, &written, &usual());
    let without = written.with("focal_length = ", "focal_length = 0 ; ");
    // A line of two numbers is no focal length.
    assert!(only_problem(&without, 9).contains("focal_length is"), "{}", only_problem(&without, 9));
    let text = String::from_utf8(written.files[0].1.clone()).unwrap();
    let line = text.lines().find(|line| line.starts_with("focal_length")).unwrap();
    let unposed = written.with(line, "focal_length = 0").read(&usual()).unwrap();
    assert!(unposed.photos.len() == 8 && is_noted(&unposed, "1 views have no pose"), "{:?}", unposed.notes);
    assert!(only_problem(&written.with("rotation = ", "turn = "), 9).contains("it has no rotation"));
}

#[test]
fn polycams_keyframes_show_every_point_where_their_formula_has_it() {
    let site = Site::piazza();
    let written = polycam(&site);
    assert_agrees(&site, &written, &usual());
    for (from, to, expected) in [
        ("\"width\": 2160", "\"width\": \"wide\"", "width is"),
        ("\"t_13\"", "\"t_14\"", "t_13 is missing"),
        ("\"fx\"", "\"fz\"", "fx is missing"),
    ] {
        let said = only_problem(&written.with(from, to), 9);
        assert!(said.contains(expected) && said.contains("01_church"), "{said}");
    }
}

#[test]
fn damaged_files_of_pix4d_mve_and_polycam_never_panic() {
    let site = Site::small();
    assert_survives(
        &pix4d(&site),
        0,
        &["0 0 1", "nan", "1e400", "a.jpg 1 1", "camera model m = K [R|-Rt] X", "-1"],
    );
    assert_survives(&pix4d(&site), 1, &["nan", "1e400", "-", "\u{0}"]);
    assert_survives(&mve(&site), 0, &["[camera]", "[", "=", "focal_length = 1e300", "nan", "name = ../../x"]);
    assert_survives(&polycam(&site), 0, &["[", "}", "null", "\"t_00\":", "1e400", "NaN"]);
}
