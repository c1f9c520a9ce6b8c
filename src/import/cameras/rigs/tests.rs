//! Rigs and frames, text and binary, of two cameras that are fixed to each other.

use glam::{DMat3, DQuat};

use super::super::{Cameras, read_cameras};
use super::*;
use quadratura_base::scene::synthetic::Rng;

const CAMERAS: &str = "1 PINHOLE 640 480 500 510 320 240\n2 PINHOLE 640 480 400 410 320 240\n3 PINHOLE 640 480 300 310 320 240\n";

/// The pose of camera 2 in the rig, a quarter turn around y; and those of the rig in two frames, turned around z and x.
const SENSOR: Motion = Motion { half: 0.7, axis: [0.0, 1.0, 0.0], move_by: [-0.5, 0.25, 0.125] };
const FRAMES: [Motion; 2] = [
    Motion { half: 0.3, axis: [0.0, 0.0, 1.0], move_by: [1.0, 2.0, 3.0] },
    Motion { half: -0.2, axis: [1.0, 0.0, 0.0], move_by: [-4.0, 0.5, 6.0] },
];

/// A turn by twice an angle in radians around an axis, then a move.
#[derive(Clone, Copy)]
struct Motion {
    half: f64,
    axis: [f64; 3],
    move_by: [f64; 3],
}

impl Motion {
    fn values(self) -> [f64; 7] {
        let [x, y, z] = self.axis.map(|along| along * self.half.sin());
        let [tx, ty, tz] = self.move_by;
        [self.half.cos(), x, y, z, tx, ty, tz]
    }

    fn text(self) -> String {
        self.values().map(|value| value.to_string()).join(" ")
    }

    /// Moves a point.
    fn apply(self, point: DVec3) -> DVec3 {
        DQuat::from_axis_angle(self.axis.into(), 2.0 * self.half) * point + DVec3::from(self.move_by)
    }
}

/// Photos 11 and 21 of camera 1, 12 and 22 of camera 2, in two frames; 33 of camera 3 is in none.
fn images(pose: impl Fn(u32) -> String) -> String {
    let line = |(id, camera): (u32, u32)| format!("{id} {} {camera} c{camera}/{id}.jpg\n\n", pose(id));
    [(11, 1), (12, 2), (21, 1), (22, 2), (33, 3)].map(line).concat()
}

fn rigs() -> String {
    format!("# rigs\n\n7 4 CAMERA 1 CAMERA 2 1 {} IMU 5 1 {} CAMERA 3 0\n", SENSOR.text(), FRAMES[0].text())
}

fn frames() -> String {
    let [first, second] = FRAMES.map(Motion::text);
    format!(
        "# frames\n1 7 {first} 3 CAMERA 1 11 CAMERA 2 12 IMU 5 99\n2 7 {second} 3 CAMERA 1 21 IMU 5 98 CAMERA 2 22\n"
    )
}

fn read(files: &[(&str, Vec<u8>)]) -> Result<Cameras> {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    read_cameras(folder.path(), &Task::silent())
}

fn text(images: &str, rigs: &str, frames: &str) -> Vec<(&'static str, Vec<u8>)> {
    [("cameras.txt", CAMERAS), ("images.txt", images), ("rigs.txt", rigs), ("frames.txt", frames)]
        .map(|(name, text)| (name, text.as_bytes().to_vec()))
        .to_vec()
}

/// What COLMAP writes in binary: numbers of 32 bits, counts of files and data of 64.
fn binary() -> Vec<(&'static str, Vec<u8>)> {
    let number = |number: u32| number.to_le_bytes().to_vec();
    let long = |number: u64| number.to_le_bytes().to_vec();
    let doubles = |values: &[f64]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let camera = |id: u32, f: f64| {
        [number(id), number(1), long(640), long(480), doubles(&[f, f + 10.0, 320.0, 240.0])].concat()
    };
    let image = |id: u32, camera: u32| {
        let pose = doubles(&[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        [number(id), pose, number(camera), format!("c{camera}/{id}.jpg\0").into_bytes(), long(0)].concat()
    };
    let frame = |id: u32, motion: Motion, photos: [u64; 2]| {
        let data = |kind: u32, sensor: u32, data: u64| [number(kind), number(sensor), long(data)].concat();
        let head = [number(id), number(7), doubles(&motion.values()), number(3)].concat();
        [head, data(0, 1, photos[0]), data(1, 5, 99), data(0, 2, photos[1])].concat()
    };
    let with_pose = |kind: u32, id: u32, motion: Motion| {
        [number(kind), number(id), vec![1], doubles(&motion.values())].concat()
    };
    let rig = [number(7), number(4), number(0), number(1)].concat();
    let rig =
        [rig, with_pose(0, 2, SENSOR), with_pose(1, 5, FRAMES[0]), number(0), number(3), vec![0]].concat();
    let list = |count: u64, items: Vec<Vec<u8>>| [long(count), items.concat()].concat();
    vec![
        ("cameras.bin", list(3, vec![camera(1, 500.0), camera(2, 400.0), camera(3, 300.0)])),
        ("images.bin", list(5, vec![image(11, 1), image(12, 2), image(21, 1), image(22, 2), image(33, 3)])),
        ("rigs.bin", list(1, vec![rig])),
        ("frames.bin", list(2, vec![frame(1, FRAMES[0], [11, 12]), frame(2, FRAMES[1], [21, 22])])),
    ]
}

/// The largest distance of where photos have points from where sensors and frames bring them.
fn error(cameras: &Cameras) -> f64 {
    let points = [DVec3::ZERO, DVec3::X, DVec3::new(-3.0, 7.0, 11.0)];
    let mut largest = 0.0f64;
    for photo in &cameras.photos {
        for point in points {
            let truth = match photo.name.as_str() {
                "c1/11.jpg" => FRAMES[0].apply(point),
                "c2/12.jpg" => SENSOR.apply(FRAMES[0].apply(point)),
                "c1/21.jpg" => FRAMES[1].apply(point),
                "c2/22.jpg" => SENSOR.apply(FRAMES[1].apply(point)),
                _ => continue,
            };
            largest = largest.max((photo.pose.rotation * point + photo.pose.translation).distance(truth));
        }
    }
    largest
}

const STALE: &str = "1 0 0 0 0 0 0";

#[test]
fn poses_come_from_rigs_and_frames_in_text_and_binary() {
    for files in [text(&images(|_| STALE.into()), &rigs(), &frames()), binary()] {
        let cameras = read(&files).unwrap();
        assert_eq!(cameras.photos.len(), 5);
        // Sums of products of numbers below 12.
        assert!(error(&cameras) < 1e-13, "{}", error(&cameras));
        assert_eq!(cameras.photos[4].pose.rotation, DMat3::IDENTITY, "it is in no frame");
        let [another, without] = &cameras.notes[..] else { panic!("{:?}", cameras.notes) };
        assert!(another.contains("4 of 4 photos have another pose in images."), "{another}");
        // The largest turn of all is 2 * 0.7 and 2 * 0.3 radians around different axes.
        assert!(another.contains("c2/12.jpg") && another.contains(" degrees and "), "{another}");
        assert!(without.contains("for 1 of the photos") && without.contains("c3/33.jpg"), "{without}");
        assert!(cameras.problems.is_empty(), "{:?}", cameras.problems);
    }
}

#[test]
fn poses_that_are_the_same_in_images_need_no_note_and_one_that_is_not_is_told_by_how_much() {
    let written = |id: u32, by: f64| {
        let frame = FRAMES[usize::from(id > 20)];
        let (rotation, translation) =
            (DMat3::from_quat(DQuat::from_axis_angle(frame.axis.into(), 2.0 * frame.half)), frame.move_by);
        let sensor = DMat3::from_quat(DQuat::from_axis_angle(SENSOR.axis.into(), 2.0 * SENSOR.half));
        let (rotation, translation) = match id % 10 {
            2 => (sensor * rotation, sensor * DVec3::from(translation) + DVec3::from(SENSOR.move_by)),
            _ => (rotation, DVec3::from(translation)),
        };
        let turn = DMat3::from_axis_angle(DVec3::X, by.to_radians());
        let (quaternion, translation) = (DQuat::from_mat3(&(turn * rotation)), turn * translation);
        let [x, y, z, w] = quaternion.to_array();
        [w, x, y, z, translation.x, translation.y, translation.z].map(|value| format!("{value:.9}")).join(" ")
    };
    let in_frames = frames().replace("3 CAMERA 1 11", "4 CAMERA 3 33 CAMERA 1 11");
    let rigs = rigs().replace("CAMERA 3 0", "CAMERA 3 1 1 0 0 0 0 0 0");
    let third = |id: u32, by: f64| if id == 33 { written(11, by) } else { written(id, by) };
    let same = read(&text(&images(|id| third(id, 0.0)), &rigs, &in_frames)).unwrap();
    assert!(same.notes.is_empty(), "{:?}", same.notes);
    let moved =
        read(&text(&images(|id| third(id, if id == 21 { 0.5 } else { 0.0 })), &rigs, &in_frames)).unwrap();
    let [note] = &moved.notes[..] else { panic!("{:?}", moved.notes) };
    // A turn about the camera's own centre leaves the centre where it is.
    let told =
        ["frames.txt: 1 of 5 photos has", "images.txt (", "c1/21.jpg", " by 0.500 degrees and 0.0000 units)"];
    assert!(told.iter().all(|words| note.contains(words)), "{note}");
}

#[test]
fn a_half_is_told_and_not_used_and_what_is_wrong_in_a_line_leaves_its_frame_to_images() {
    let given = images(|_| STALE.into());
    for (missing, there) in [("rigs.txt", "frames.txt"), ("frames.txt", "rigs.txt")] {
        let mut files = text(&given, &rigs(), &frames());
        files.retain(|(name, _)| *name != missing);
        let cameras = read(&files).unwrap();
        let [note] = &cameras.notes[..] else { panic!("{:?}", cameras.notes) };
        assert!(note.contains(&format!("{there}: not used without {missing}")), "{note}");
        assert!(cameras.photos.iter().all(|photo| photo.pose.rotation == DMat3::IDENTITY));
    }
    let first = FRAMES[0].text();
    let lines = [
        (frames().replacen("1 7 ", "1 8 ", 1), "a frame of rig 8, which is not in the rigs file"),
        (frames().replacen("99", "", 1), "the line ends before DATA_ID"),
        (frames().replacen("99", "99 5", 1), "after the 3 announced"),
        (frames().replacen(&format!("{first} 3"), &format!("{first} x"), 1), "where NUM_DATA_IDS should be"),
        (frames().replacen(&first, "0 0 0 0 1 2 3", 1), "not a valid quaternion"),
        (frames().replacen("3 CAMERA 1 11 CAMERA 2", "3 CAMERA 1 11 2 2", 1), "where SENSOR_TYPE should be"),
    ];
    for (frames, expected) in lines {
        let cameras = read(&text(&given, &rigs(), &frames)).unwrap();
        let said = cameras.problems.iter().map(ToString::to_string).collect::<Vec<_>>();
        assert!(said.len() == 1 && said[0].contains(expected) && said[0].contains("line 2"), "{said:?}");
        assert!(cameras.notes.iter().any(|note| note.contains("for 3 of the photos")), "{:?}", cameras.notes);
        assert!(error(&cameras) > 1.0, "frame 1 is not used");
    }
    let twice = frames().replacen("CAMERA 1 21", "CAMERA 1 11", 1);
    let cameras = read(&text(&given, &rigs(), &twice)).unwrap();
    assert!(cameras.problems[0].to_string().contains("photo 11 is in two frames"), "{:?}", cameras.problems);
    let other_camera = frames().replacen("CAMERA 1 11", "CAMERA 3 11", 1);
    let cameras = read(&text(&given, &rigs(), &other_camera)).unwrap();
    assert!(cameras.notes.iter().any(|note| note.contains("c1/11.jpg")), "{:?}", cameras.notes);
}

#[test]
fn a_binary_file_that_is_cut_is_refused_with_the_place() {
    for which in [2, 3] {
        let mut files = binary();
        files[which].1.pop();
        let said = read(&files).unwrap_err().to_string();
        assert!(said.contains(files[which].0) && said.contains("copy the file again"), "{said}");
    }
}

/// `QUADRATURA_MUTATIONS=10000 cargo test --release -p quadratura-import --lib mutated_rigs` reads as many.
#[test]
fn mutated_rigs_and_frames_are_read_or_refused_and_never_a_fault() {
    let count = std::env::var("QUADRATURA_MUTATIONS").ok().and_then(|count| count.parse().ok());
    let mut rng = Rng::new(12);
    let mut read_ones = 0;
    let count: u32 = count.unwrap_or(400);
    for case in 0..count {
        let mut files =
            if rng.chance(0.5) { binary() } else { text(&images(|_| STALE.into()), &rigs(), &frames()) };
        let which = rng.whole(2, 3) as usize;
        let bytes = &mut files[which].1;
        for _ in 0..rng.whole(1, 4) {
            let at = rng.whole(0, bytes.len() as u32 - 1) as usize;
            match rng.whole(0, 4) {
                0 => bytes[at] = rng.bits() as u8,
                1 => bytes[at] = b"0123456789.-e CAMERA#\n"[rng.whole(0, 21) as usize],
                2 => bytes[at..].iter_mut().take(8).for_each(|byte| *byte = 255),
                3 if rng.chance(0.3) => bytes.truncate(at.max(1)),
                _ => drop(bytes.splice(at..at, *b" 4294967295 ")),
            }
        }
        match read(&files) {
            Ok(_) => read_ones += 1,
            Err(error) => {
                let said = error.to_string();
                assert!(
                    said.contains(files[which].0) && !said.contains("decoder failed"),
                    "case {case}: {said}"
                );
            }
        }
    }
    assert!((count / 20..=count / 20 * 19).contains(&read_ones), "{read_ones} of {count}");
}
