//! Whole files: what is read, what is refused, and that nothing makes the readers panic.

use std::path::PathBuf;

use glam::{DMat3, DQuat, DVec3};
use proptest::prelude::*;

use super::raw::Problems;
use super::*;
use crate::mutations::mutations;
use quadratura_base::geometry::{Lens, Pose};

const CAMERAS: &str =
    "# comment\n1 PINHOLE 640 480 500 510 320 240\n2 OPENCV 640 480 500 510 320 240 .1 .2 .3 .4\n";
const IMAGES: &str = "\
# comment
7 1 0 0 0 1 2 3 1 a b/0001.jpg
10.5 20.25 5 1 2 -1 30 40 6

9 0.5 0.5 0.5 0.5 0 0 0 2 0002.jpg

";
const POINTS: &str = "5 1 2 3 255 255 255 0.5 7 0\n6 4 5 6 0 0 0 0.5 7 2\n";

fn folder(files: &[(&str, &[u8])]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    folder
}

fn text(cameras: &str, images: &str, points: &str) -> tempfile::TempDir {
    folder(&[
        ("cameras.txt", cameras.as_bytes()),
        ("images.txt", images.as_bytes()),
        ("points3D.txt", points.as_bytes()),
    ])
}

fn read(folder: &tempfile::TempDir) -> Result<Cameras> {
    read_cameras(folder.path(), &Task::silent())
}

/// The same as the text above, as COLMAP writes it in binary.
fn binary() -> [(&'static str, Vec<u8>); 3] {
    let mut cameras = 2u64.to_le_bytes().to_vec();
    for (id, model, parameters) in [
        (1u32, 1i32, &[500.0, 510.0, 320.0, 240.0][..]),
        (2, 4, &[500.0, 510.0, 320.0, 240.0, 0.1, 0.2, 0.3, 0.4]),
    ] {
        cameras.extend(id.to_le_bytes());
        cameras.extend(model.to_le_bytes());
        cameras.extend([640u64.to_le_bytes(), 480u64.to_le_bytes()].concat());
        cameras.extend(doubles(parameters));
    }
    let mut images = 2u64.to_le_bytes().to_vec();
    images.extend(image(7, &[1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0], 1, "a b/0001.jpg"));
    images.extend(3u64.to_le_bytes());
    for (x, y, point) in [(10.5, 20.25, 5), (1.0, 2.0, u64::MAX), (30.0, 40.0, 6)] {
        images.extend(doubles(&[x, y]));
        images.extend(point.to_le_bytes());
    }
    images.extend(image(9, &[0.5, 0.5, 0.5, 0.5, 0.0, 0.0, 0.0], 2, "0002.jpg"));
    images.extend(0u64.to_le_bytes());
    let mut points = 2u64.to_le_bytes().to_vec();
    for (id, position, keypoint) in [(5u64, [1.0, 2.0, 3.0], 0u32), (6, [4.0, 5.0, 6.0], 2)] {
        points.extend(id.to_le_bytes());
        points.extend(doubles(&position));
        points.extend([9, 9, 9]);
        points.extend(doubles(&[0.5]));
        points.extend(1u64.to_le_bytes());
        points.extend([7u32.to_le_bytes(), keypoint.to_le_bytes()].concat());
    }
    [("cameras.bin", cameras), ("images.bin", images), ("points3D.bin", points)]
}

fn doubles(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn image(id: u32, pose: &[f64], camera: u32, name: &str) -> Vec<u8> {
    [&id.to_le_bytes()[..], &doubles(pose), &camera.to_le_bytes(), name.as_bytes(), &[0]].concat()
}

fn binary_folder() -> tempfile::TempDir {
    let files = binary();
    folder(&files.each_ref().map(|(name, bytes)| (*name, bytes.as_slice())))
}

#[test]
fn a_keypoint_that_is_no_number_is_left_out_and_told() {
    let images = IMAGES.replace("10.5 20.25 5", "nan 20.25 5");
    let read = read(&text(CAMERAS, &images, POINTS)).unwrap();
    assert_eq!(read.points.iter().map(|point| point.observations.len()).collect::<Vec<_>>(), [0, 1]);
    assert!(read.notes[0].contains("1 keypoints are left out"), "{:?}", read.notes);
}

#[test]
fn a_text_model_is_read_with_sub_folders_spaces_and_points() {
    let cameras = read(&text(CAMERAS, IMAGES, POINTS)).unwrap();
    assert!(cameras.problems.is_empty(), "{:?}", cameras.problems);
    let [first, second] = cameras.photos.as_slice() else { panic!("{cameras:?}") };
    assert_eq!((first.name.as_str(), first.place.as_str()), ("a b/0001.jpg", "line 2"));
    assert_eq!((first.camera.fx, first.camera.fy, first.camera.height), (500.0, 510.0, 480));
    assert_eq!(first.pose, Pose { rotation: DMat3::IDENTITY, translation: DVec3::new(1.0, 2.0, 3.0) });
    assert_eq!(second.lens, Lens::Brown { k: [0.1, 0.2, 0.0, 0.0, 0.0, 0.0], p: [0.3, 0.4] });
    // Half, half, half, half: x becomes y, y becomes z, z becomes x.
    assert!((second.pose.rotation * DVec3::X - DVec3::Y).length() < 1e-15);
    assert_eq!(cameras.points[1].position, DVec3::new(4.0, 5.0, 6.0));
    assert_eq!(cameras.points[1].observations, [(0, glam::DVec2::new(30.0, 40.0))]);
}

#[test]
fn binary_and_text_say_the_same_and_binary_wins() {
    let from_text = read(&text(CAMERAS, IMAGES, POINTS)).unwrap();
    let both = binary_folder();
    std::fs::write(both.path().join("cameras.txt"), "nonsense").unwrap();
    std::fs::write(both.path().join("images.txt"), "nonsense").unwrap();
    let from_binary = read(&both).unwrap();
    assert_eq!(from_binary.points, from_text.points);
    for (b, t) in from_binary.photos.iter().zip(&from_text.photos) {
        assert_eq!((&b.name, b.camera, b.lens, b.pose), (&t.name, t.camera, t.lens, t.pose));
    }
    assert!(from_binary.notes[0].contains("instead of images.txt"), "{:?}", from_binary.notes);
    assert!(read_cameras(&both.path().join("images.txt"), &Task::silent()).is_err());
}

#[test]
fn the_model_is_found_from_a_folder_above_and_from_one_of_its_files() {
    let project = tempfile::tempdir().unwrap();
    for number in ["0", "1"] {
        let model = project.path().join("sparse").join(number);
        std::fs::create_dir_all(&model).unwrap();
        std::fs::write(model.join("cameras.txt"), CAMERAS).unwrap();
        std::fs::write(model.join("images.txt"), IMAGES).unwrap();
    }
    for below in ["", "sparse", "sparse/0", "sparse/0/cameras.txt", "sparse/0/images.txt"] {
        let cameras = read_cameras(&project.path().join(below), &Task::silent()).unwrap();
        assert_eq!((cameras.photos.len(), cameras.points.len()), (2, 0), "{below}");
    }
    let missing = read_cameras(&project.path().join("sparse/7"), &Task::silent()).unwrap_err().to_string();
    let there = project.path().join("sparse").display().to_string();
    assert!(missing.ends_with(&format!("there are cameras in {there}")), "{missing}");
    let cameras = read_cameras(project.path(), &Task::silent()).unwrap();
    assert!(cameras.notes[0].contains("2 separate reconstructions"), "{:?}", cameras.notes);
}

#[test]
fn a_path_without_cameras_is_told_what_to_point_at() {
    let empty = tempfile::tempdir().unwrap();
    for path in [empty.path().to_path_buf(), empty.path().join("none"), PathBuf::from("")] {
        let error = read_cameras(&path, &Task::silent()).unwrap_err().to_string();
        assert!(error.contains("; give COLMAP's cameras") || error.contains("check the path"), "{error}");
    }
}

#[test]
fn one_bad_photo_does_not_stop_the_others() {
    let bad = [
        ("7 1 0 0 0 0 0 0 1 b.jpg", "number 7"),
        ("8 1 0 0 0 0 0 0 1 ok.jpg", "appears twice"),
        ("8 1 0 0 0 0 0 0 4 b.jpg", "camera 4, which is not in the cameras file"),
        ("8 1 0 0 0 0 0 0 3 b.jpg", "camera 3, which cannot be used"),
        ("8 0 0 0 0 0 0 0 1 b.jpg", "not a valid quaternion"),
        ("8 nan 0 0 0 0 0 0 1 b.jpg", "not a valid quaternion"),
        ("8 1 0 0 0 inf 0 0 1 b.jpg", "position"),
        ("8 1 0 0 0 0 0 0 1 ../b.jpg", "leaves the photo folder"),
        ("8 1 0 0 0 0 0 0 1", "without a name"),
        ("8 1 0 0 0 0 0", "ends before TZ"),
        ("8 1 0 x 0 0 0 0 1 b.jpg", "\"x\" where QY should be"),
    ];
    let cameras = format!("{CAMERAS}3 PINHOLE 0 480 500 500 320 240\n");
    for (line, finding) in bad {
        let images = format!("7 2 0 0 0 1 2 3 1 ok.jpg\n\n{line}\n\n12 1 0 0 0 1 2 3 1 last.jpg\n\n");
        let read = read(&text(&cameras, &images, "")).unwrap();
        let names: Vec<_> = read.photos.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["ok.jpg", "last.jpg"], "{line}");
        let problem = read.problems.last().unwrap().to_string();
        assert!(problem.contains(finding) && problem.contains("images.txt, line 3"), "{problem}");
    }
}

#[test]
fn a_bad_camera_is_named_with_its_line_and_a_remedy() {
    let bad = [
        ("3 PINHOLE 640 480 500 510 320", "3 parameters where PINHOLE has 4 (fx, fy, cx, cy)"),
        ("3 PINHOLE 640 480 500 510 320 nan", "NaN"),
        ("3 PINHOLE 640 480 0 510 320 240", "focal length of 0"),
        ("3 PINHOLE 640 480 -500 510 320 240", "focal length of -500"),
        ("3 PINHOLE 640 99999 500 510 320 240", "640 x 99999 pixels"),
        ("3 PINHOLE 65535 65535 500 510 320 240", "65535 x 65535 pixels"),
        ("3 PINHOLE 640 480 500 510 1e9 240", "principal point"),
        ("3 pinhole 640 480 500 510 320 240", "camera model \"pinhole\""),
        ("3 EUCM 640 480 500 510 320 240 2 1", "alpha 2"),
        ("3 EQUIRECTANGULAR 640 480 640 480", "panorama"),
        ("1 PINHOLE 640 480 1 1 1 1", "appears twice"),
        ("x PINHOLE 640 480 1 1 1 1", "\"x\" where CAMERA_ID should be"),
        ("3 PINHOLE 640", "ends before HEIGHT"),
    ];
    for (line, finding) in bad {
        let read = read(&text(&format!("{CAMERAS}{line}\n"), IMAGES, "")).unwrap();
        assert_eq!((read.photos.len(), read.problems.len()), (2, 1), "{line}");
        let problem = read.problems[0].to_string();
        assert!(problem.contains(finding) && problem.contains("cameras.txt, line 4"), "{problem}");
    }
}

#[test]
fn photos_without_their_second_line_are_read_all_the_same() {
    let images = "7 1 0 0 0 1 2 3 1 a.jpg\n8 1 0 0 0 1 2 3 1 b.jpg\n9 1 0 0 0 1 2 3 1 c.jpg";
    let read = read(&text(CAMERAS, images, "")).unwrap();
    assert_eq!(read.photos.len(), 3);
    assert!(read.notes[0].contains("2 photos lack"), "{:?}", read.notes);
}

#[test]
fn quaternions_are_normalised() {
    let images = "7 0 0 0 2.5 0 0 0 1 a.jpg\n\n";
    let read = read(&text(CAMERAS, images, "")).unwrap();
    let half_turn = DMat3::from_quat(DQuat::from_xyzw(0.0, 0.0, 1.0, 0.0));
    assert_eq!(read.photos[0].pose.rotation, half_turn);
}

#[test]
fn a_camera_or_point_beyond_any_map_is_refused() {
    let images = "7 1 0 0 0 1e300 0 0 1 a.jpg\n\n8 1 0 0 0 5e6 0 0 1 b.jpg\n\n";
    let read = read(&text(CAMERAS, images, "5 0 1e308 0 0 0 0 0\n")).unwrap();
    assert_eq!((read.photos.len(), read.points.len()), (1, 0));
    assert!(read.problems.iter().all(|problem| problem.to_string().contains("1e15")), "{:?}", read.problems);
}

#[test]
fn a_model_without_usable_photos_is_an_error() {
    let error = read(&text(CAMERAS, "# nothing\n", "")).unwrap_err().to_string();
    assert!(error.contains("lists no photo"), "{error}");
    let error = read(&text(CAMERAS, "7 1 0 0 0 0 0 0 1 /etc/passwd\n\n", "")).unwrap_err().to_string();
    assert!(error.contains("absolute"), "{error}");
}

#[test]
fn a_binary_file_that_ends_early_is_named_with_the_byte() {
    for (cut, (name, bytes)) in binary().into_iter().enumerate() {
        let cut_folder = binary_folder();
        std::fs::write(cut_folder.path().join(name), &bytes[..bytes.len() - 3]).unwrap();
        let error = read(&cut_folder).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains("byte"), "{cut}: {error}");
    }
}

#[test]
fn a_hostile_count_is_refused_before_anything_is_allocated() {
    for name in ["cameras.bin", "images.bin", "points3D.bin"] {
        let hostile = binary_folder();
        std::fs::write(hostile.path().join(name), [0xFF; 64]).unwrap();
        let error = read(&hostile).unwrap_err().to_string();
        assert!(error.contains("18446744073709551615 records announced"), "{error}");
    }
}

#[test]
fn a_line_without_end_does_not_fill_the_memory() {
    let folder = text(CAMERAS, IMAGES, "");
    let endless = std::fs::File::create(folder.path().join("points3D.txt")).unwrap();
    endless.set_len(1 << 32).unwrap();
    let error = read(&folder).unwrap_err().to_string();
    assert!(error.contains("line of more than 64 megabytes"), "{error}");
}

#[test]
fn a_thousand_problems_are_not_a_thousand_messages() {
    let points: String = (0..1000).map(|_| "5 1 2 3\n").collect();
    let read = read(&text(CAMERAS, IMAGES, &points)).unwrap();
    assert_eq!(read.problems.len(), Problems::MOST + 1);
    assert!(read.problems.last().unwrap().to_string().contains("799 more"));
}

#[test]
fn the_castle_is_read_whole() {
    let Some(folder) = crate::left_out::castle() else { return };
    let castle = read_cameras(&folder.join("sparse"), &Task::silent()).unwrap();
    assert_eq!((castle.photos.len(), castle.points.len(), castle.problems.len()), (19, 16780, 0));
    assert_eq!(castle.points.iter().map(|p| p.observations.len()).sum::<usize>(), 50738);
    let mut squares = 0.0;
    for point in &castle.points {
        for &(photo, at) in &point.observations {
            let photo = &castle.photos[photo as usize];
            let seen = photo.camera.image_from_camera(photo.pose.camera_from_world(point.position)).unwrap();
            squares += seen.distance_squared(at);
        }
    }
    let rms = (squares / 50738.0f64).sqrt();
    assert!((rms - 0.65).abs() < 0.01, "the data set's description says 0.65, this is {rms}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(mutations(300)))]

    #[test]
    fn mutated_binary_files_never_panic(
        which in 0usize..3,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut files = binary();
        mutate(&mut files[which].1, &changes, cut);
        let _ = read(&folder(&files.each_ref().map(|(name, bytes)| (*name, bytes.as_slice()))));
    }

    #[test]
    fn mutated_text_files_never_panic(
        which in 0usize..3,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut files = [CAMERAS, IMAGES, POINTS].map(|text| text.as_bytes().to_vec());
        mutate(&mut files[which], &changes, cut);
        let names = ["cameras.txt", "images.txt", "points3D.txt"];
        let _ = read(&folder(&[0, 1, 2].map(|i| (names[i], files[i].as_slice()))));
    }
}

pub(super) fn mutate(
    bytes: &mut Vec<u8>,
    changes: &[(prop::sample::Index, u8)],
    cut: Option<prop::sample::Index>,
) {
    for (at, value) in changes {
        let at = at.index(bytes.len());
        bytes[at] = *value;
    }
    if let Some(cut) = cut {
        bytes.truncate(cut.index(bytes.len()));
    }
}
