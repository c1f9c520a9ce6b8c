//! Texts as other programs write them: ends of lines, comments, names, and what stands for no number.

#![cfg(test)]

use std::fs;

use glam::DMat4;
use serde_json::json;

use super::three_formats::{bundler, read, scene, transforms, with_photos, written};
use super::*;
use quadratura_base::scene::synthetic::Rng;

fn names(cameras: &Cameras) -> Vec<&str> {
    cameras.photos.iter().map(|photo| photo.name.as_str()).collect()
}

#[test]
fn names_in_colmaps_text_hold_whatever_their_line_does_whatever_ends_it() {
    let cameras = "\u{feff}# of a museum\n1 PINHOLE 64 48 60 60 32 24 # the front one\n\t2 SIMPLE_PINHOLE 64 48 60 32 24\x0c\n";
    let images = "# made by C:\\tools\\\n1 1 0 0 0 0 0 0 1 #1 gate # old.jpg \t\n\n2 1 0 0 0 0 0 0 2 nord\\b  c.jpg\n\n\
                  3 1 0 0 0 0 0 0 1 \u{3000}d.jpg\n\n4 1 0 0 0 nan 0 0 1 e.jpg\n\n5 1 0 0 0 0 0 -1.#IND 1 f.jpg\n\n";
    for end in ["\n", "\r\n", "\r", "\r\r\n"] {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in [("cameras.txt", cameras), ("images.txt", images)] {
            fs::write(folder.path().join(name), text.replace('\n', end)).unwrap();
        }
        let read = read(folder.path()).unwrap();
        assert_eq!(names(&read), ["#1 gate # old.jpg", "nord/b  c.jpg", "\u{3000}d.jpg"], "{end:?}");
        assert!(
            read.notes[0].ends_with("images.txt: \\ in the names of 1 photos is read as /"),
            "{:?}",
            read.notes
        );
        let told: Vec<String> = read.problems.iter().map(ToString::to_string).collect();
        assert!(
            told[0].contains("\"e.jpg\": the position") && told[1].contains("\"-1.#IND\" where TZ should be"),
            "{told:?}"
        );
    }
}

#[test]
fn a_frame_that_uses_no_number_is_left_out_by_name_and_one_that_nothing_uses_does_not_matter() {
    let (taken, _) = scene(&mut Rng::new(21));
    let mut whole = transforms(&taken, DMat4::IDENTITY, 1.0);
    whole["frames"][1]["transform_matrix"][2][3] = json!("AT");
    whole["aabb_scale"] = json!("SCALE");
    whole["frames"][0]["sharpness"] = json!("SHARP");
    for (word, at) in [("NaN", "\"AT\""), ("-Infinity", "\"AT\""), ("nan", "\"AT\""), ("-nan(ind)", "\"AT\"")]
    {
        let text =
            whole.to_string().replace(at, word).replace("\"SCALE\"", "Infinity").replace("\"SHARP\"", "NaN");
        let read = written("transforms.json", &text).1.unwrap();
        assert_eq!(names(&read), ["a.png", "nord/c d.png"]);
        let told = read.problems[0].to_string();
        assert!(
            told.contains(&format!(
                "frames[1]: \"nord/b.png\": transform_matrix row 2 holds {word}, expected"
            )),
            "{told}"
        );
        let path = whole.to_string().replace("\"./photos/nord/b.png\"", word).replace("\"AT\"", "0");
        let read =
            written("transforms.json", &path.replace("\"SCALE\"", "1").replace("\"SHARP\"", "1")).1.unwrap();
        assert!(read.problems[0].to_string().contains(&format!("frames[1]: file_path is {word}")));
    }
}

#[test]
fn a_bundle_is_read_with_the_lists_of_other_programs() {
    let (taken, points) = scene(&mut Rng::new(22));
    let [out, list] = bundler(&taken, &points, None);
    let plain: String = list.lines().map(|line| format!("{}\r", line.split(" 0 ").next().unwrap())).collect();
    for (bundle, named, text) in [
        ("bundle.out", "imagelist.lst", plain.replace('/', "\\")),
        ("tour.bundle.out", "tour.list.txt", plain.clone()),
        ("tour.out", "all photos.txt", plain.replace("photos/", "PHOTOS/").replace(".png", ".PNG")),
    ] {
        let folder = with_photos(&taken);
        fs::write(folder.path().join(bundle), &out).unwrap();
        fs::write(folder.path().join(named), text).unwrap();
        for path in [folder.path().to_path_buf(), folder.path().join(bundle)] {
            let read = read(&path).unwrap();
            assert!(read.photos.len() == 3 && read.problems.is_empty(), "{named}: {:?}", read.problems);
        }
    }
}
