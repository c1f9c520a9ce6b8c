//! Tests of defective files of nerfstudio and Bundler: the errors are right, and nothing panics.

#![cfg(test)]

use std::fs;

use glam::{DMat4, DVec3};
use proptest::prelude::*;
use serde_json::{Value, json};

use super::pose::CV_FROM_GL;
use super::tests::mutate;
use super::three_formats::{Taken, bundler, read, scene, transforms, with_photos, written};
use super::*;
use crate::mutations::mutations;
use quadratura_base::geometry::{Lens, Pose};
use quadratura_base::scene::synthetic::Rng;

#[test]
fn lenses_are_taken_where_they_are_understood_and_refused_where_not() {
    let (taken, _) = scene(&mut Rng::new(1));
    let with = |change: &dyn Fn(&mut Value)| {
        let mut text = transforms(&taken[..1], DMat4::IDENTITY, 1.0);
        change(&mut text);
        written("transforms.json", &text.to_string()).1.map(|cameras| cameras.photos[0].lens)
    };
    let set = |key: &'static str, value: Value| {
        with(&|text: &mut Value| text["frames"][0][key] = value.clone()).map_err(|error| error.to_string())
    };
    let k = taken[0].k;
    let fisheye = Lens::Fisheye { k: [k[0], k[1], 0.0, 0.0], p: [0.0; 2], s: [0.0; 2] };
    assert_eq!(set("camera_model", json!("OPENCV_FISHEYE")), Ok(fisheye));
    assert_eq!(set("k3", json!(0.5)), Ok(Lens::Brown { k: [k[0], k[1], 0.5, 0.0, 0.0, 0.0], p: [0.0; 2] }));
    assert_eq!(set("p2", json!(0.5)), Ok(Lens::Brown { k: [k[0], k[1], 0.0, 0.0, 0.0, 0.0], p: [0.0, 0.5] }));
    let old = with(&|text| {
        text.as_object_mut().unwrap().remove("camera_model");
        text["is_fisheye"] = json!(true);
    });
    assert_eq!(old.unwrap(), fisheye);
    for (key, value, expected) in [
        ("k4", json!(0.1), "k4 is 0.1"),
        ("camera_model", json!("EQUIRECTANGULAR"), "panorama"),
        ("camera_model", json!("FISHEYE624"), "known are"),
        ("camera_model", json!(7), "expected a name"),
        ("k5", json!(0.1), "k5 is 0.1, a coefficient that this format does not have"),
        ("k6", json!("0"), "k6 is \"0\", expected a number"),
        ("is_fisheye", json!("true"), "is_fisheye is \"true\", expected true or false"),
    ] {
        let message = set(key, value).unwrap_err();
        assert!(message.contains(expected) && message.contains("frames[0]"), "{message}");
    }
}

#[test]
fn what_is_wrong_with_one_frame_leaves_out_that_one_and_says_where() {
    let (taken, _) = scene(&mut Rng::new(2));
    let matrix = |rows: [[f64; 3]; 3]| {
        let mut all = [[0.0; 4], [0.0; 4], [0.0; 4], [0.0, 0.0, 0.0, 1.0]];
        all.iter_mut().zip(rows).for_each(|(to, row)| to[..3].copy_from_slice(&row));
        json!(all)
    };
    let mirror = matrix([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]]);
    let shear = matrix([[1.0, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    for (key, value, expected) in [
        ("transform_matrix", json!(null), "transform_matrix is null, expected 3 or 4 rows of 4 numbers"),
        ("transform_matrix", json!([[1, 0, 0, 0]]), "has 1 rows"),
        ("transform_matrix", json!([[1, 0, 0, 0], [0, 1, 0], [0, 0, 1, 0]]), "row 1 has 3 items"),
        ("transform_matrix", json!([[1, 0, 0, "x"], [0, 1, 0, 0], [0, 0, 1, 0]]), "row 0 holds \"x\""),
        ("transform_matrix", mirror, "mirrors: its determinant is -1"),
        ("transform_matrix", shear, "shears or stretches"),
        ("transform_matrix", matrix([[0.0; 3]; 3]), "is no rotation: its determinant is 0"),
        ("transform_matrix", json!([[1, 0, 0, 1e16], [0, 1, 0, 0], [0, 0, 1, 0]]), "1e15"),
        (
            "transform_matrix",
            json!([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 1, 1]]),
            "ends with the row",
        ),
        ("file_path", json!(7), "file_path is 7"),
        ("file_path", json!(""), "file_path is \"\""),
        ("w", json!(0), "w is 0"),
        ("w", json!(-64), "w is -64"),
        ("w", json!(64.5), "w is 64.5"),
        ("w", json!("64"), "w is \"64\", expected a number"),
        ("w", json!(70_000), "70000 x 48 pixels"),
        ("fl_x", json!(0), "a focal length of 0 pixels"),
        ("fl_x", json!([1, 2]), "fl_x is a list of 2"),
        ("cx", json!(1e9), "a principal point at 1000000000 pixels"),
    ] {
        let mut text = transforms(&taken, DMat4::IDENTITY, 1.0);
        text["frames"][0][key] = value;
        let read = written("transforms.json", &text.to_string()).1.unwrap();
        let message: Vec<String> = read.problems.iter().map(ToString::to_string).collect();
        assert_eq!((read.photos.len(), message.len()), (2, 1), "{message:?}");
        assert!(
            message[0].contains("transforms.json, frames[0]: ") && message[0].contains(expected),
            "{message:?}"
        );
    }
    let mut twice = transforms(&taken, DMat4::IDENTITY, 1.0);
    twice["frames"][2]["file_path"] = json!("photos/../photos/a.png");
    twice["frames"][1] = json!([]);
    let read = written("transforms.json", &twice.to_string()).1.unwrap();
    let message: Vec<String> = read.problems.iter().map(ToString::to_string).collect();
    assert_eq!((read.listed, read.photos.len()), (3, 1));
    assert!(message[0].contains("frames[1]: a list of 0, expected an object"), "{message:?}");
    assert!(message[1].contains("frames[2]: \"a.png\" appears twice"), "{message:?}");
}

#[test]
fn a_file_that_is_wrong_as_a_whole_is_refused_with_what_to_do() {
    let (taken, _) = scene(&mut Rng::new(3));
    let whole = transforms(&taken, DMat4::IDENTITY, 1.0);
    let text = whole.to_string();
    let changed = |key: &str, value: Value| {
        let mut other = whole.clone();
        other[key] = value;
        other.to_string()
    };
    let mirror = json!([[1, 0, 0, 0], [0, 0, 1, 0], [0, 1, 0, 0]]);
    for (text, expected) in [
        (text[..text.len() - 40].to_owned(), "line 1 column"),
        (text.replace("\"k1\":", "\"k1\":NaN,\"x\":"), "frames[0]: \"a.png\": k1 is NaN, expected a number"),
        (
            changed("frames", json!("none")).replace("\"w\"", "\"file_path\""),
            "frames: \"none\", expected a list",
        ),
        (changed("applied_transform", mirror), "transforms.json: applied_transform mirrors"),
        (changed("applied_transform", json!([])), "has 0 rows"),
        (changed("applied_scale", json!(0)), "expected a positive number"),
        (changed("frames", json!([])), "it lists no photo"),
        (text.replace("\"k1\":", "\"k1\":1e400,\"x\":"), "k1 is 1e400, expected a number"),
        (String::new(), "transforms.json: it is empty, expected a JSON object with a list \"frames\""),
        (" \r\n".to_owned(), "transforms.json: it is empty"),
        ("{}".to_owned(), "frames: missing, expected a list of photos"),
        ("[1, 2]".to_owned(), "a list of 2, expected a JSON object"),
        (format!("// of a drone\n{text}"), "line 1 column 1: expected value near \"// of a drone\""),
        (text[..20].to_owned(), "line 1 column 20: the file ends before its JSON does"),
    ] {
        let message = written("transforms.json", &text).1.unwrap_err().to_string();
        assert!(
            message.contains("transforms.json") && message.contains(expected) && message.contains("; "),
            "{message}"
        );
    }
}

#[test]
fn what_is_wrong_in_a_bundle_is_told_with_its_line() {
    let (taken, points) = scene(&mut Rng::new(6));
    let folder = with_photos(&taken);
    let [out, list] = bundler(&taken, &points, None);
    let read_text = |out: &str, list: &str| {
        fs::write(folder.path().join("bundle.out"), out).unwrap();
        fs::write(folder.path().join("list.txt"), list).unwrap();
        read(folder.path())
    };
    let line = |number: usize, with: &str| {
        let mut lines: Vec<&str> = out.lines().collect();
        lines[number - 1] = with;
        lines.join("\n")
    };
    for (text, expected) in [
        (line(1, "# Bundle file v0.1"), "line 1: \"# Bundle file v0.1\", expected"),
        (line(2, "3 x"), "line 2: \"x\" where the number of points should be"),
        (line(2, "4 5"), "list.txt: 3 photos where"),
        (line(2, "3 99"), "the file ends within point 5 of 99"),
        (out[..out.len() / 2].to_owned(), "the file ends within"),
        (out.lines().take(4).collect::<Vec<_>>().join("\n"), "the file ends within camera 0 of 3"),
        (line(20, "-1"), "should be"),
        (line(1, "Bundle"), "bundle.out, line 1: \"Bundle\", expected \"# Bundle file v0.3\""),
        (String::new(), "bundle.out: it is empty, expected \"# Bundle file v0.3\""),
    ] {
        let message = read_text(&text, &list).unwrap_err().to_string();
        assert!(message.contains(expected) && message.contains("; "), "{message}");
    }
    for (text, photos, expected) in [
        (line(3, "nan 0 0"), 2, "line 3: \"a.png\": camera 0 of 3: \"nan\" where a number should be"),
        (line(3, "-50 0 0"), 2, "line 3: \"a.png\": a focal length of -50 pixels"),
        (line(4, "9 0 0"), 2, "the rotation"),
        (line(7, "1e99 0 0"), 2, "1e15"),
        (line(18, "x 0 0"), 3, "line 18: point 0 of 5: \"x\" where a number should be"),
        (line(20, "1 7 7 0.5 0.5"), 3, "line 20: point 0 of 5: \"7\" where one of 3 cameras should be"),
    ] {
        let read = read_text(&text, &list).unwrap();
        let message: Vec<String> = read.problems.iter().map(ToString::to_string).collect();
        assert_eq!(read.photos.len(), photos, "{message:?}");
        assert!(
            message.len() == 1 && message[0].contains(expected) && message[0].contains("; "),
            "{expected}: {message:?}"
        );
    }
    // Looking along +z: the same file as if it had been written without turning the axes.
    let behind: Vec<DVec3> = points.to_vec();
    let mirrored: Vec<Taken> = taken
        .iter()
        .map(|it| Taken {
            pose: Pose {
                rotation: CV_FROM_GL * it.pose.rotation,
                translation: CV_FROM_GL * it.pose.translation,
            },
            ..*it
        })
        .collect();
    let [out, _] = bundler(&mirrored, &behind, None);
    let message = read_text(&out, &list).unwrap_err().to_string();
    assert!(message.contains("15 of 15 observed points lie behind") && message.contains("-z"), "{message}");

    fs::remove_file(folder.path().join("list.txt")).unwrap();
    let message = read(&folder.path().join("bundle.out")).unwrap_err().to_string();
    assert!(message.contains("there is no list.txt beside it"), "{message}");
}

/// Texts of photos in other encodings than UTF-8.
fn other_encodings(text: &str) -> [Vec<u8>; 3] {
    let utf16 =
        |mark: Option<u16>| mark.into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
    [utf16(Some(0xFEFF)), utf16(None), big]
}

#[test]
fn text_in_another_encoding_is_refused_with_the_encoding_that_is_expected() {
    let (taken, points) = scene(&mut Rng::new(10));
    let folder = with_photos(&taken);
    let texts = transforms(&taken, DMat4::IDENTITY, 1.0).to_string();
    let [out, list] = bundler(&taken, &points, None);
    let refused = |file: &str| {
        let message = read(&folder.path().join(file)).unwrap_err().to_string();
        assert!(message.contains("expected UTF-8") && message.contains("; save it as UTF-8"), "{message}");
        message
    };
    for bytes in other_encodings(&texts) {
        fs::write(folder.path().join("transforms.json"), bytes).unwrap();
        assert!(refused("transforms.json").contains("transforms.json: it is text in UTF-16"));
    }
    let latin: Vec<u8> =
        texts.replace("a.png", "\u{1}.png").bytes().map(|b| if b == 1 { 0xFC } else { b }).collect();
    fs::write(folder.path().join("transforms.json"), [b"\n".as_slice(), &latin].concat()).unwrap();
    assert!(refused("transforms.json").contains("transforms.json, line 2: byte 0xFC"));
    for (first, second) in [(&out, &list), (&list, &out)] {
        for bytes in other_encodings(first) {
            let names = if first == &out { ["bundle.out", "list.txt"] } else { ["list.txt", "bundle.out"] };
            fs::write(folder.path().join(names[0]), bytes).unwrap();
            fs::write(folder.path().join(names[1]), second).unwrap();
            assert!(refused("bundle.out").contains(names[0]));
        }
    }
    for bytes in other_encodings("1 PINHOLE 64 48 60 60 32 24\n") {
        fs::write(folder.path().join("cameras.txt"), bytes).unwrap();
        fs::write(folder.path().join("images.txt"), "1 1 0 0 0 0 0 0 1 a.png\n\n").unwrap();
        assert!(refused("images.txt").contains("cameras.txt: it is text in UTF-16"));
    }
}

#[test]
fn a_file_with_the_usual_name_of_a_format_is_never_passed_over_for_another_reconstruction() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let message = |name: &str| read(&folder.path().join(name)).unwrap_err().to_string();
    // Where it is all that is there, the folder means it, too.
    write("transforms.json", "");
    for path in ["", "transforms.json"] {
        assert!(
            message(path).contains("transforms.json: it is empty, expected a JSON object"),
            "{}",
            message(path)
        );
    }
    assert!(is_camera_file(&folder.path().join("transforms.json")));
    write("cameras.txt", "1 PINHOLE 64 48 60 60 32 24\n");
    fs::remove_file(folder.path().join("transforms.json")).unwrap();
    assert!(
        message("").contains("cameras.txt: cameras.txt and images.txt are not both beside it"),
        "{}",
        message("")
    );
    write("images.txt", "1 1 0 0 0 0 0 0 1 a.png\n\n");
    write("transforms.json", "");
    write("bundle.out", "");
    assert!(message("transforms.json").contains("it is empty"));
    assert!(message("bundle.out").contains("there is no list.txt beside it"));
    assert!(read(folder.path()).unwrap().notes.is_empty());
    // A file of no format is not replaced by what is beside it, which may be older; the message names that.
    for content in ["{}", "", "{\0\"\0"] {
        write("config.json", content);
        let refused = message("config.json");
        assert!(refused.contains("config.json: ") && refused.contains("expected cameras"), "{refused}");
        assert!(refused.ends_with("images.txt beside it"), "{refused}");
    }
}

#[test]
fn a_file_of_no_format_is_described_with_what_is_accepted() {
    let folder = tempfile::tempdir().unwrap();
    for (bytes, expected) in [
        (b"".as_slice(), "it is empty"),
        (b"\n \n", "it has only empty lines"),
        (b"\n\nhello \xC3\xBC\n", "it begins with the line \"hello \u{fc}\""),
        (b"\x89PNG\r\n\x1A\n\0\0", "it is a binary file of another kind"),
        (b"a\0b\0", "it is text in UTF-16 or a binary file"),
    ] {
        let file = folder.path().join("notes.json");
        fs::write(&file, bytes).unwrap();
        let message = read(&file).unwrap_err().to_string();
        assert!(message.contains(&format!("notes.json: {expected}")), "{message}");
        assert!(message.contains(", expected cameras; give COLMAP's cameras"), "{message}");
    }
    let message = read(folder.path().join("none").as_path()).unwrap_err().to_string();
    assert!(message.contains("does not exist; check the path; give COLMAP's"), "{message}");
    assert!(extensions().iter().all(|ending| accepted().contains(ending)), "{:?}", extensions());
}

#[test]
fn an_angle_of_view_that_is_none_is_named_by_its_key_and_unit() {
    let (taken, _) = scene(&mut Rng::new(11));
    let mut text = transforms(&taken[..1], DMat4::IDENTITY, 1.0);
    for field in ["fl_x", "fl_y"] {
        text["frames"][0].as_object_mut().unwrap().remove(field);
        text.as_object_mut().unwrap().remove(field);
    }
    for (key, value, expected) in [
        ("camera_angle_x", 56.0, "camera_angle_x is 56 radians, expected an angle of view below 3.1416"),
        ("x_fov", 400.0, "x_fov is 400 degrees, expected an angle of view below 180"),
        ("x_fov", -1.0, "x_fov is -1 degrees"),
    ] {
        let mut other = text.clone();
        other[key] = json!(value);
        let message = written("transforms.json", &other.to_string()).1.unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
    text["x_fov"] = json!(90.0);
    let read = written("transforms.json", &text.to_string()).1.unwrap();
    // Half of the width over the tangent of 45 degrees.
    assert!((read.photos[0].camera.fx - 0.5 * f64::from(taken[0].size[0])).abs() < 1e-12);
}

#[test]
fn a_photo_that_is_listed_twice_is_said_to_be_and_the_first_is_used() {
    let (taken, points) = scene(&mut Rng::new(12));
    let folder = with_photos(&taken);
    let [out, list] = bundler(&taken, &points, None);
    fs::write(folder.path().join("bundle.out"), out).unwrap();
    fs::write(folder.path().join("list.txt"), list.replace("nord/b.png", "a.png")).unwrap();
    let photos = folder.path().join("photos");
    let read = read_cameras_of(&photos, &folder.path().join("bundle.out"), &Task::silent()).unwrap();
    let message: Vec<String> = read.problems.iter().map(ToString::to_string).collect();
    assert_eq!((read.listed, read.photos.len()), (3, 2), "{message:?}");
    assert!(
        message.len() == 1 && message[0].contains("line 8: \"a.png\" appears twice; keep one"),
        "{message:?}"
    );
}

#[test]
fn cameras_that_are_not_there_and_lines_that_are_none_are_named_where_they_are_missing() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let message = || read(folder.path()).unwrap_err().to_string();
    write("images.txt", "1 1 0 0 0 0 0 0 1 a.png\n\n");
    write("cameras.txt", "# none\n");
    assert!(message().contains("cameras.txt: it lists no camera; use the cameras file"), "{}", message());
    write("cameras.txt", "1 PINHOLE 64 48 60 60 32 24\n");
    write("images.txt", &"garbage\n".repeat(9));
    assert!(message().contains("images.txt, line 1: \"garbage\" where IMAGE_ID should be"), "{}", message());
    // Points are no photos.
    write("images.txt", "1 1 0 0 0 0 0 0 1 a.png\n\n2 1 0 0 0 0 0 0 7 b.png\n\n");
    write("points3D.txt", &"x y z\n".repeat(9));
    let read = read(folder.path()).unwrap();
    assert_eq!((read.listed, read.photos.len(), read.problems.len()), (2, 1, 10));
}

#[test]
fn a_bundle_without_its_photos_says_which_are_missing() {
    let (taken, points) = scene(&mut Rng::new(7));
    let [out, list] = bundler(&taken, &points, None);
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("any name.out"), out).unwrap();
    fs::write(folder.path().join("list.txt"), list).unwrap();
    let names = read_names(folder.path(), &Task::silent()).unwrap();
    assert_eq!((names.names.len(), names.points, names.problems.len()), (3, 5, 0));
    let message = read(folder.path()).unwrap_err().to_string();
    assert!(
        message.contains("line 3: \"a.png\"") && message.contains("does not state the photo's size"),
        "{message}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(mutations(300)))]

    #[test]
    fn mutated_transforms_never_panic(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let (taken, _) = scene(&mut Rng::new(8));
        let mut text = transforms(&taken, DMat4::IDENTITY, 1.0).to_string().into_bytes();
        mutate(&mut text, &changes, cut);
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("transforms.json"), text).unwrap();
        let _ = read(folder.path());
        let _ = read_names(&folder.path().join("transforms.json"), &Task::silent());
    }

    #[test]
    fn mutated_bundles_never_panic(
        which in 0usize..2,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let (taken, points) = scene(&mut Rng::new(9));
        let mut files = bundler(&taken, &points, None).map(String::into_bytes);
        mutate(&mut files[which], &changes, cut);
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("bundle.out"), &files[0]).unwrap();
        fs::write(folder.path().join("list.txt"), &files[1]).unwrap();
        let _ = read(folder.path());
        let _ = read_names(&folder.path().join("bundle.out"), &Task::silent());
    }
}
