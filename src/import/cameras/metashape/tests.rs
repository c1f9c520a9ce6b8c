//! Files of Metashape: what is read, what is left out and told, and what is refused.

use std::fs;

use super::super::invented::metashape::{export, project, zipped};
use super::super::invented::{Site, Written, assert_agrees, assert_observations, assert_survives, sample};
use super::super::{CameraOptions, Cameras, read_cameras, read_cameras_as};
use crate::photo::{Match, PhotoFolder};
use quadratura_base::task::Task;

fn usual() -> CameraOptions {
    CameraOptions::default()
}

fn chunk(name: &str) -> CameraOptions {
    CameraOptions { chunk: Some(name.into()), ..usual() }
}

fn told(read: &Cameras, words: &str) -> bool {
    read.notes.iter().any(|note| note.contains(words))
}

#[test]
fn the_piazza_of_metashape_shows_every_point_where_its_formula_has_it() {
    let site = Site::piazza();
    let written = export(&site, false);
    let read = assert_agrees(&site, &written, &usual());
    assert_observations(&read, &written);
    assert!(told(&read, "1 of 10 cameras are not aligned"), "{:?}", read.notes);
    assert_eq!(read.photos[0].name, "01_church.jpg");
}

#[test]
fn a_project_is_read_from_its_psx_and_from_its_folder_with_paths_of_another_machine() {
    let site = Site::piazza();
    let written = project(&site);
    let read = assert_agrees(&site, &written, &usual());
    assert_observations(&read, &written);
    assert_eq!(read.photos[7].name, "08_portrait.jpg");
    let folder = written.folder();
    let of_folder = read_cameras(&folder.path().join("site.files"), &Task::silent()).unwrap();
    let of_parent = read_cameras(folder.path(), &Task::silent()).unwrap();
    assert!(of_folder.photos == read.photos && of_parent.photos == read.photos);
    let files = super::super::camera_files(&folder.path().join("site.psx"));
    assert_eq!(files.len(), 4, "a change of any of them is noticed: {files:?}");
    fs::rename(folder.path().join("site.files"), folder.path().join("other.files")).unwrap();
    let refused = read_cameras(&folder.path().join("site.psx"), &Task::silent()).unwrap_err().to_string();
    assert!(refused.contains("site.files/project.zip is not beside it"), "{refused}");
}

#[test]
fn a_rolling_shutter_is_told_and_taken_out_on_request() {
    let site = Site::piazza();
    let written = export(&site, true);
    let still = written.read(&usual()).unwrap();
    assert!(
        told(&still, "the cameras of 9 of the photos moved while a rolling shutter took them")
            && told(&still, "--rolling-shutter")
    );
    assert!(still.reprojection.as_ref().unwrap().median_px > 1.0, "{:?}", still.reprojection);
    let options = CameraOptions { rolling_shutter: true, ..usual() };
    let read = assert_agrees(&site, &written, &options);
    assert_observations(&read, &written);
    assert!(told(&read, "are resampled by row") && !read.photos[0].is_pinhole());
    let depth = read.photos[0].shutter.unwrap().depth;
    assert!((5.0..60.0).contains(&depth), "{depth}");
    let damaged = written.with("<rolling_shutter><rotation>", "<rolling_shutter><rotation>x ");
    assert!(told(&damaged.read(&usual()).unwrap(), "cannot be read for 1 of the cameras"));
}

#[test]
fn the_largest_chunk_is_read_and_another_one_by_its_name() {
    let site = Site::small();
    let second = "<chunk label=\"Chunk 2\"><cameras><camera id=\"0\" sensor_id=\"0\" label=\"x\"><transform>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\
                  </transform></camera></cameras><sensors><sensor id=\"0\"><calibration><resolution width=\"64\" height=\"48\"/><f>50</f>\
                  </calibration></sensor></sensors></chunk><chunk label=\"empty\"/>";
    let written = export(&site, false).with("</document>", &format!("{second}</document>"));
    let read = written.read(&usual()).unwrap();
    assert_eq!(read.photos.len(), 3);
    assert!(told(
        &read,
        "the chunk \"Chunk 1\" is read, of \"Chunk 1\" (3 of 4 cameras are aligned), \"Chunk 2\" (1 of 1"
    ));
    let other = written.read(&chunk("Chunk 2")).unwrap();
    assert_eq!(
        (other.photos.len(), other.photos[0].name.as_str(), other.photos[0].camera.cx),
        (1, "x", 32.0)
    );
    for (name, expected) in
        [("chunk 2", "there is no chunk \"chunk 2\""), ("empty", "the chunk \"empty\" is empty")]
    {
        let refused = written.read(&chunk(name)).unwrap_err().to_string();
        assert!(refused.contains(expected), "{refused}");
    }
    let colmap =
        read_cameras_as(&sample().join("photos"), &sample().join("sparse"), &chunk("x"), &Task::silent());
    assert!(colmap.unwrap_err().to_string().contains("only files of Metashape have chunks"));
}

#[test]
fn what_is_not_to_be_used_is_left_out_and_told() {
    let written = export(&Site::small(), false);
    for (from, to, photos, expected) in [
        ("<camera id=\"1\"", "<camera enabled=\"false\" id=\"1\"", 2, "1 of 4 cameras are disabled"),
        ("<sensor id=\"1\"", "<sensor master_id=\"0\" id=\"1\"", 2, "1 of 4 cameras belong to a rig"),
        ("id=\"1\" sensor_id=\"1\"", "id=\"1\" master_id=\"0\" sensor_id=\"1\"", 2, "belong to a rig"),
        ("component_id=\"0\" label=\"02", "component_id=\"5\" label=\"02", 3, "of 2 components"),
        (
            "<transform><rotation locked=\"true\">",
            "<reference>GEOGCS[\"WGS 84\"]</reference><transform><rotation>",
            3,
            "geocentric",
        ),
    ] {
        let read = written.with(from, to).read(&usual()).unwrap();
        assert_eq!(read.photos.len(), photos, "{expected}: {:?}", read.problems);
        assert!(told(&read, expected), "{:?}", read.notes);
    }
}

#[test]
fn what_is_wrong_with_one_camera_or_sensor_leaves_it_out_with_the_reason() {
    let written = export(&Site::small(), false);
    let f = written.with("<f>1</f>", "<x/>");
    for (from, to, expected) in [
        ("<f>1330.0</f>", "<f>nan</f>", "sensor \"a camera\": f is \"nan\", expected a number"),
        ("<f>1330.0</f>", "", "a focal length of 1.75 pixels"),
        ("<f>1330.0</f>", "<f>-1330</f>", "a focal length of -1328.25"),
        ("<f>1330.0</f>", "<f>1330</f><p3>0.1</p3>", "p3 is 0.1"),
        (
            "class=\"adjusted\"><resolution width=\"2160\"",
            "class=\"adjusted\"><resolution width=\"wide\"",
            "the width of its resolution is \"wide\"",
        ),
        (
            "type=\"frame\" class=\"adjusted\"",
            "type=\"spherical\" class=\"adjusted\"",
            "a spherical panorama",
        ),
        (
            "type=\"frame\" class=\"adjusted\"",
            "type=\"rpc\" class=\"adjusted\"",
            "the camera model is \"rpc\"",
        ),
        (
            "sensor_id=\"0\" component_id",
            "sensor_id=\"70\" component_id",
            "its sensor \"70\" is not in the chunk",
        ),
        ("label=\"01_church.jpg\"", "label=\"\"", "a photo without a name"),
        ("label=\"01_church.jpg\"", "label=\"02_from_southwest.jpg\"", "appears twice"),
        (
            "label=\"01_church.jpg\"><transform>",
            "label=\"01_church.jpg\"><transform>1 ",
            "has more than 16 numbers",
        ),
        (
            "label=\"01_church.jpg\"><transform>",
            "label=\"01_church.jpg\"><transform>x ",
            "is \"x\", expected a number",
        ),
    ] {
        let read = f.with(from, to).read(&usual()).unwrap();
        let problems: Vec<String> = read.problems.iter().map(ToString::to_string).collect();
        assert_eq!((read.photos.len(), problems.len()), (2, 1), "{expected}: {problems:?}");
        assert!(
            problems[0].contains(expected) && problems[0].contains("cameras.xml, camera "),
            "{problems:?}"
        );
    }
}

#[test]
fn a_chunk_without_aligned_cameras_and_a_damaged_file_are_refused_as_a_whole() {
    let written = export(&Site::small(), false);
    let text = String::from_utf8(written.files[0].1.clone()).unwrap();
    let file = |text: &str| Written::one("cameras.xml", text.to_owned(), Vec::new());
    let unaligned = text.replace("transform>", "other>");
    assert!(file(&unaligned).refused().contains("none of the 4 cameras of the chunk \"Chunk 1\" is aligned"));
    let short = file(&text[..text.len() - 30]).refused();
    assert!(short.contains("it is not whole XML") && short.contains("line "), "{short}");
    let mirror = text.replace("<scale locked=\"true\">2.5", "<scale locked=\"true\">-2.5");
    assert!(file(&mirror).refused().contains("its transform mirrors"));
    let bomb = text.replacen("?>\n", "?>\n<!DOCTYPE a [<!ENTITY b \"c\">]>\n", 1);
    assert!(file(&bomb).refused().contains("it is not whole XML"));
    let deep = format!("<document><chunk>{}", "<a>".repeat(1_000_000));
    assert!(file(&deep).refused().contains("it is not whole XML"));
    let other = file("<document><note>no cameras</note></document>").refused();
    assert!(other.contains("Metashape's .xml"), "{other}");
}

#[test]
fn damaged_archives_of_a_project_are_refused_by_name() {
    let written = project(&Site::small());
    for (which, name) in [(1, "project.zip"), (2, "chunk.zip"), (3, "frame.zip")] {
        for bytes in [b"no archive".to_vec(), zipped("<a"), zipped(" ")] {
            let mut files = written.files.clone();
            files[which].1 = bytes;
            let refused = Written { files, observed: Vec::new() }.refused();
            assert!(refused.contains(name) && refused.contains("; "), "{refused}");
        }
        let mut leading_away = written.files.clone();
        let away = "<document><chunks><chunk path=\"../../other.zip\"/></chunks></document>";
        leading_away[1].1 = zipped(away);
        assert!(
            Written { files: leading_away, observed: Vec::new() }.refused().contains("no chunk with cameras")
        );
    }
}

#[test]
fn focal_lengths_in_millimetres_are_told() {
    let read = export(&Site::small(), false).with("<f>1330.0</f>", "<f>24</f>").read(&usual()).unwrap();
    assert!(
        told(&read, "1 photos have a very wide angle of view, such as 01_church.jpg with 177 degrees"),
        "{:?}",
        read.notes
    );
}

#[test]
fn a_label_without_ending_finds_its_photo_without_a_remark() {
    let folder = PhotoFolder::scan(&sample().join("photos"), &Task::silent()).unwrap();
    let found = folder.find(&["01_church", "08_PORTRAIT", "02_from_southwest.png"]);
    assert!(matches!(found[0], Match::File(_, "")), "{found:?}");
    assert!(matches!(found[1], Match::File(_, "in another letter case")), "{found:?}");
    assert!(matches!(found[2], Match::File(_, "in another image format")), "{found:?}");
}

#[test]
fn damaged_files_never_panic() {
    let words = [
        "<camera ",
        "</chunk>",
        "<transform>",
        "master_id=\"0\"",
        "enabled=\"0\"",
        "<markers>",
        "&amp;",
        "]]>",
        "<!--",
    ];
    assert_survives(&export(&Site::small(), true), 0, &words);
}
