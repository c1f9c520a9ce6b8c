//! Every format that other modules do not test shows the sample's points where its formula has them; what is wrong is told; and damaged files
//! are survived.

#![cfg(test)]

use super::metashape::export;
use super::others::{fspy, meshroom, nvm, openmvg, opensfm, table, xmp};
use super::{Site, Written, assert_agrees, assert_observations, assert_survives};
use crate::cameras::{CameraOptions, Cameras};

fn usual() -> CameraOptions {
    CameraOptions::default()
}

fn is_noted(read: &Cameras, words: &str) -> bool {
    read.notes.iter().any(|note| note.contains(words))
}

#[test]
fn realityscans_files_beside_the_photos_show_every_point_where_their_formula_has_it() {
    let site = Site::piazza();
    for (model, elements) in [("brown3t2", false), ("brown3t2", true), ("division", false)] {
        let read = assert_agrees(&site, &xmp(&site, model, elements), &usual());
        assert_eq!(
            is_noted(&read, "tangential coefficients t1 and t2"),
            model != "division",
            "{:?}",
            read.notes
        );
        assert!(read.reprojection.is_none());
    }
    let written = xmp(&Site::small(), "brown3", false);
    let unaligned = written.with("Rotation", "Turn").with("Rotation", "Turn").read(&usual()).unwrap();
    assert_eq!(unaligned.photos.len(), 2);
    assert!(is_noted(&unaligned, "1 files beside it have no pose"), "{:?}", unaligned.notes);
    for (from, to, expected) in [
        ("\"brown3\"", "\"kb4\"", "the distortion model \"kb4\""),
        ("xcr:FocalLength35mm", "xcr:Other", "it has no FocalLength35mm"),
        ("xcr:AspectRatio=\"1\"", "xcr:AspectRatio=\"wide\"", "AspectRatio is \"wide\""),
        ("</x:xmpmeta>", "", "it is not whole XML"),
        ("<xcr:Position>", "<xcr:Position>1 ", "Position has more than 3 numbers"),
    ] {
        let read = written.with(from, to).read(&usual()).unwrap();
        let problems: Vec<String> = read.problems.iter().map(ToString::to_string).collect();
        assert_eq!((read.photos.len(), problems.len()), (2, 1), "{problems:?}");
        assert!(problems[0].contains(expected) && problems[0].contains("01_church"), "{problems:?}");
    }
}

#[test]
fn realityscans_table_shows_every_point_where_its_formula_has_it() {
    let site = Site::piazza();
    let written = table(&site);
    assert_agrees(&site, &written, &usual());
    let without_count = written.with("#cameras 9\n", "");
    assert_agrees(&site, &without_count, &usual());
    assert!(
        written
            .with("heading,pitch,roll,f,px", "heading,pitch,roll,g,px")
            .refused()
            .contains("it has no column f")
    );
    for (from, to, expected) in [
        ("01_church.jpg,", "01_church.jpg,7,", "17 fields, expected 16"),
        ("01_church.jpg,", "01_church.jpg,x", "expected a number"),
        ("01_church.jpg", "no such photo.jpg", "there is no such photo"),
    ] {
        let read = written.with(from, to).read(&usual()).unwrap();
        assert_eq!((read.photos.len(), read.problems.len()), (8, 1));
        assert!(read.problems[0].to_string().contains(expected), "{:?}", read.problems);
    }
}

#[test]
fn meshrooms_file_shows_every_point_where_its_formula_has_it() {
    let site = Site::piazza();
    for model in ["radial3", "brown"] {
        let written = meshroom(&site, model);
        let read = assert_agrees(&site, &written, &usual());
        assert_observations(&read, &written);
        assert!(is_noted(&read, "1 of 10 views have no pose"), "{:?}", read.notes);
    }
    let later = meshroom(&site, "radial3");
    let text = String::from_utf8(later.files[0].1.clone()).unwrap();
    let text =
        text.replace("\"type\": \"radial3\"", "\"type\": \"pinhole\", \"distortionType\": \"radialk3\"");
    assert_agrees(&site, &Written::one("sfm.json", text, later.observed.clone()), &usual());
    let small = meshroom(&Site::small(), "radial3");
    for (from, to, expected) in [
        ("\"type\": \"radial3\"", "\"type\": \"3deanamorphic4\"", "the type \"3deanamorphic4\""),
        ("\"sensorWidth\": \"23.5\"", "\"sensorWidth\": \"0\"", "a focal length of inf"),
        ("\"pixelRatio\": \"1\"", "\"pixelRatio\": \"1.5\"", "pixelRatio is 1.5"),
    ] {
        let read = small.with(from, to).read(&usual()).unwrap();
        assert_eq!((read.photos.len(), read.problems.len()), (2, 1));
        assert!(read.problems[0].to_string().contains(expected), "{:?}", read.problems);
    }
    assert!(
        Written::one("cameras.sfm", "{\"version\": [], \"views\": \"viewId\"".into(), Vec::new())
            .refused()
            .contains("cameras.sfm")
    );
}

#[test]
fn opensfms_reconstruction_and_tracks_show_every_point_where_their_formula_has_it() {
    let site = Site::piazza();
    let written = opensfm(&site);
    let read = assert_agrees(&site, &written, &usual());
    assert_observations(&read, &written);
    assert!(
        is_noted(&read, "the largest of 2 separate reconstructions is read, with 9 photos"),
        "{:?}",
        read.notes
    );
    let mut alone = opensfm(&site);
    alone.files.pop();
    let read = assert_agrees(&site, &alone, &usual());
    assert!(is_noted(&read, "there is no tracks.csv beside it") && read.reprojection.is_none());
    let panorama = written
        .with("\"projection_type\": \"brown\"", "\"projection_type\": \"spherical\"")
        .read(&usual())
        .unwrap();
    assert!(panorama.problems[0].to_string().contains("panorama"), "{:?}", panorama.problems);
    assert!(
        Written::one("reconstruction.json", "[]".into(), Vec::new())
            .refused()
            .contains("expected a list of reconstructions")
    );
}

#[test]
fn openmvgs_file_shows_every_point_where_its_formula_has_it() {
    let site = Site::piazza();
    for lens in ["disto_k3", "disto_t2", "fisheye"] {
        let written = openmvg(&site, lens);
        let read = assert_agrees(&site, &written, &usual());
        assert_observations(&read, &written);
    }
    let read =
        openmvg(&site, "disto_k3").with("\"id_pose\": 0", "\"id_pose\": 4294967295").read(&usual()).unwrap();
    assert!(read.photos.len() == 8 && is_noted(&read, "1 of 9 views have no pose"), "{:?}", read.notes);
}

#[test]
fn an_nvm_is_read_as_visualsfm_or_colmap_wrote_it() {
    for of_colmap in [false, true] {
        let (site, written) = nvm(&Site::piazza(), of_colmap);
        let read = assert_agrees(&site, &written, &usual());
        assert_observations(&read, &written);
        assert_eq!(is_noted(&read, "measurements are from the corner"), of_colmap, "{:?}", read.notes);
    }
    let (_, written) = nvm(&Site::piazza(), false);
    let text = String::from_utf8(written.files[0].1.clone()).unwrap();
    let cut = Written::one("site.nvm", text[..text.len() / 8].to_owned(), Vec::new()).refused();
    assert!(cut.contains("the file ends before"), "{cut}");
}

#[test]
fn a_project_of_fspy_is_a_photo_without_points() {
    for index in [0, 7] {
        let (site, written) = fspy(&Site::piazza(), index);
        let read = assert_agrees(&site, &written, &usual());
        assert!(
            read.points.is_empty()
                && read.photos[0].is_pinhole()
                && is_noted(&read, "one photo, without sparse points")
        );
    }
    let (_, written) = fspy(&Site::piazza(), 0);
    let name = written.files[0].0.clone();
    let of = |bytes: Vec<u8>| Written { files: vec![(name.clone(), bytes)], observed: Vec::new() }.refused();
    let bytes = &written.files[0].1;
    let state = br#"{"cameraParameters": null}"#;
    let null = [b"fspy", &[1u32, state.len() as u32, 0].map(u32::to_le_bytes).concat()[..], state].concat();
    assert!(of(null).contains("the photo is not calibrated"));
    assert!(of(bytes[..40].to_vec()).contains("it ends after 24 of the"));
    assert!(of(bytes[..10].to_vec()).contains("within its head"));
    let mut newer = bytes.clone();
    newer[4] = 9;
    assert!(of(newer).contains("version 9, expected 1"));
    let mut huge = bytes.clone();
    huge[8..12].fill(0xFF);
    assert!(of(huge).contains("a state of 4294967295 bytes"));
}

#[test]
fn a_file_in_another_convention_is_told_with_the_one_that_it_is_in() {
    let site = Site::piazza();
    let text = |written: &Written| String::from_utf8(written.files[0].1.clone()).unwrap();
    // Rotations by rows, as somebody would write who had not read the definition.
    let mut by_rows = site.clone();
    by_rows.shots.iter_mut().for_each(|shot| shot.rotation = shot.rotation.transpose());
    let (right, wrong) = (text(&meshroom(&site, "radial3")), text(&meshroom(&by_rows, "radial3")));
    let poses = |text: &str| text.find("\"poses\"").unwrap()..text.find("\"structure\"").unwrap();
    let mixed = right.replace(&right[poses(&right)], &wrong[poses(&wrong)]);
    let read = Written::one("cameras.sfm", mixed, Vec::new()).read(&usual()).unwrap();
    let judged = read.reprojection.as_ref().unwrap();
    assert!(judged.median_px > 3.0);
    assert_eq!(judged.better().unwrap().0, "the rotation transposed");
    assert!(
        is_noted(&read, "With the rotation transposed it would be 0.00 px. Nothing is changed"),
        "{:?}",
        read.notes
    );
    // Markers whose positions follow their places.
    let metashape = text(&export(&site, false));
    let upwards: Vec<String> = metashape
        .split("<location camera_id=\"")
        .map(|part| {
            match part.split_once("\" pinned=\"true\"").and_then(|(id, _)| id.parse::<usize>().ok()) {
                None => part.to_owned(),
                Some(id) => {
                    let (before, rest) = part.split_once("y=\"").unwrap();
                    let (y, after) = rest.split_once('"').unwrap();
                    let y = f64::from(site.shots[id].size[1]) - y.parse::<f64>().unwrap();
                    format!("{before}y=\"{y:?}\"{after}")
                }
            }
        })
        .collect();
    let upwards = upwards.join("<location camera_id=\"");
    let read = Written::one("cameras.xml", upwards, Vec::new()).read(&usual()).unwrap();
    assert_eq!(read.reprojection.unwrap().better().unwrap().0, "y of observations upwards");
    // Tangential coefficients in the other order move the photo's borders by pixels.
    let large = text(&export(&site, false))
        .replace("<p1>0.0012</p1><p2>-0.0007</p2>", "<p1>-0.0007</p1><p2>0.0012</p2>");
    let read = Written::one("cameras.xml", large, Vec::new()).read(&usual()).unwrap();
    assert!(read.reprojection.as_ref().unwrap().median_px > 0.3, "{:?}", read.reprojection);
    // The sample itself is right.
    let own = crate::cameras::read_cameras(&super::sample().join("sparse"), &super::Task::silent()).unwrap();
    assert!(own.reprojection.unwrap().median_px < 0.01 && own.notes.is_empty());
}

#[test]
fn damaged_files_of_realityscan_never_panic() {
    let site = Site::small();
    let words = ["xcr:Skew=\"1\"", "<xcr:Rotation>", "</rdf:RDF>", "division", "&lt;", "<!--"];
    assert_survives(&xmp(&site, "brown3t2", false), 0, &words);
    assert_survives(&table(&site), 0, &["#name", ",,,", "nan", ";", "\"", "01_church.jpg,1"]);
}

#[test]
fn damaged_files_of_json_never_panic() {
    let (site, words) =
        (Site::small(), ["[", "]", "{", "null", "\"key\":", "1e400", "NaN", "\"\"", "4294967295", "[[]]"]);
    assert_survives(&meshroom(&site, "brown"), 0, &words);
    assert_survives(&opensfm(&site), 0, &words);
    assert_survives(&openmvg(&site, "disto_t2"), 0, &words);
}

#[test]
fn damaged_tracks_nvm_and_fspy_never_panic() {
    let site = Site::small();
    assert_survives(&opensfm(&site), 1, &["\t", "nan", "01_church.jpg\t0\t0\t1\t1\t0"]);
    assert_survives(
        &nvm(&site, false).1,
        0,
        &["NVM_V3", "FixedK 1 2 3 4", "99999999", "18446744073709551616", "-1"],
    );
    let (_, mut project) = fspy(&site, 0);
    // The sizes are of four bytes that are no text: of a state shorter than 2^16, they are.
    let length = u32::from_le_bytes(project.files[0].1[8..12].try_into().unwrap());
    assert!(length < 1 << 16);
    if length.to_le_bytes().iter().any(|byte| *byte > 127) {
        let padding = (128 - length % 128) as usize;
        let at = project.files[0].1.len() - 3;
        project.files[0].1.splice(at..at, vec![b' '; padding]);
        let whole = (length as usize + padding) as u32;
        project.files[0].1[8..12].copy_from_slice(&whole.to_le_bytes());
    }
    assert_survives(&project, 0, &["null", "[", "}", "1e300", "fspy"]);
}
