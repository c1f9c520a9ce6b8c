//! Tests of the file of several layered depth images.

#![cfg(test)]

use std::fs;
use std::path::PathBuf;

use glam::{DMat3, DVec3};
use tempfile::TempDir;

use super::tests::{PACKINGS, random, same};
use super::*;
use crate::cube::cube_cameras;
use crate::levels::pyramid;
use crate::{Arrangement, Ldi, LdiSet, ResolutionLevel};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;

/// Returns six faces with random content.
fn faces(side: u32) -> Vec<Ldi> {
    let cameras = cube_cameras(DVec3::new(5e6, -3.0, 0.1), &DMat3::IDENTITY, side).into_iter().enumerate();
    let face = |(index, (camera, pose))| {
        let ldi = random(20 + index as u64, side, side);
        let rows = (0..side).map(|y| {
            let level = &ldi.levels[0];
            level.row(y).map(|index| (level.columns[index], level.pixel(index))).collect()
        });
        let levels = pyramid(ResolutionLevel::of_rows(camera, rows), &ldi.surfaces);
        Ldi { camera, pose, gain: [0.25; 3], levels, ..ldi }
    };
    cameras.map(face).collect()
}

/// Returns images of several sizes.
fn any() -> Vec<Ldi> {
    [(1, 9, 5), (2, 3, 70), (3, 20, 20)].map(|(seed, width, height)| random(seed, width, height)).into()
}

struct WrittenSet {
    _folder: TempDir,
    file: PathBuf,
    bytes: Vec<u8>,
}

impl WrittenSet {
    fn new(arrangement: Arrangement, images: &[Ldi], packing: Packing) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("new/a.ldi");
        let mut packed = PackedSet::new(arrangement, packing);
        for image in images {
            packed.add(&file, image).unwrap();
        }
        let length = packed.write(&file).unwrap();
        let bytes = fs::read(&file).unwrap();
        assert_eq!(length, bytes.len() as u64);
        Self { _folder: folder, file, bytes }
    }

    fn read_of(&self, bytes: &[u8]) -> Result<LdiSet> {
        fs::write(&self.file, bytes).unwrap();
        read_ldi_set(&self.file, &Task::silent())
    }

    /// Returns the message about a file with another first line, whose hash fits.
    fn message_with(&self, header: &serde_json::Value) -> String {
        let end = self.bytes.iter().position(|byte| *byte == b'\n').unwrap();
        let mut bytes = line::to_line(header).unwrap();
        bytes.extend_from_slice(&self.bytes[end + 1..]);
        self.read_of(&bytes).map(drop).unwrap_err().to_string()
    }
}

fn all_same(a: &[Ldi], b: &[Ldi]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b))
}

#[test]
fn cubes_and_sets_are_read_as_they_were_written() {
    for packing in PACKINGS {
        for (arrangement, images) in [(Arrangement::Cube, faces(20)), (Arrangement::Set, any())] {
            let written = WrittenSet::new(arrangement, &images, packing);
            let read = read_ldi_set(&written.file, &Task::silent()).unwrap();
            assert!(read.arrangement == arrangement && all_same(&read.images, &images));
        }
    }
}

#[test]
fn each_image_is_in_the_file_as_in_a_file_of_its_own() {
    let images = any();
    for packing in PACKINGS {
        let written = WrittenSet::new(Arrangement::Set, &images, packing);
        let mut at = written.bytes.iter().position(|byte| *byte == b'\n').unwrap() + 1;
        for image in &images {
            assert_eq!(at % 8, 0);
            let file = written.file.with_file_name("one.ldi");
            write_ldi(&file, image, packing).unwrap();
            let alone = fs::read(file).unwrap();
            assert!(written.bytes[at..].starts_with(&alone));
            at += alone.len();
        }
        assert_eq!(at, written.bytes.len());
    }
}

#[test]
fn a_file_of_one_image_is_one_alone_and_readers_of_one_refuse_several_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let (file, image) = (folder.path().join("one.ldi"), random(4, 20, 9));
    write_ldi(&file, &image, Packing::Deflate).unwrap();
    let read = read_ldi_set(&file, &Task::silent()).unwrap();
    assert!(read.arrangement == Arrangement::Single && all_same(&read.images, &[image]));
    let several = WrittenSet::new(Arrangement::Set, &any(), Packing::None);
    for refused in [
        read_ldi(&several.file, &Task::silent()).map(drop),
        read_ldi_header(&several.file).map(drop),
        read_whole_rows(&several.file, &Task::silent()).map(drop),
    ] {
        let message = refused.unwrap_err().to_string();
        assert!(
            message.contains("several layered depth images") && message.contains("ldi render"),
            "{message}"
        );
    }
    assert!(!has_whole_length(&several.file));
}

#[test]
fn every_beginning_of_a_file_of_several_is_refused() {
    for packing in PACKINGS {
        let written = WrittenSet::new(Arrangement::Set, &any(), packing);
        let file = fs::File::options().write(true).open(&written.file).unwrap();
        for length in (0..written.bytes.len()).rev() {
            file.set_len(length as u64).unwrap();
            let error = read_ldi_set(&written.file, &Task::silent()).unwrap_err();
            assert!(matches!(error, Error::Input { .. }), "{error}");
        }
        let mut longer = written.bytes.clone();
        longer.push(0);
        assert!(written.read_of(&longer).is_err());
    }
}

#[test]
fn every_flipped_byte_gives_an_error_or_the_same_images() {
    let images = [random(9, 6, 9), random(10, 5, 3)];
    for packing in PACKINGS {
        let written = WrittenSet::new(Arrangement::Set, &images, packing);
        let mut refused = 0;
        for index in 0..written.bytes.len() {
            for flip in [0x01, 0x20, 0xff] {
                let mut bytes = written.bytes.clone();
                bytes[index] ^= flip;
                match written.read_of(&bytes) {
                    Ok(read) => assert!(all_same(&read.images, &images), "byte {index} ^ {flip:#x}"),
                    Err(_) => refused += 1,
                }
            }
        }
        // Only spaces before line feeds may be something else, at most seven in each of three lines.
        assert!(refused >= 3 * (written.bytes.len() - 21), "{refused} of {}", 3 * written.bytes.len());
    }
}

#[test]
fn what_is_left_of_a_file_that_is_cut_short_is_read_image_by_image() {
    let images = any();
    let written = WrittenSet::new(Arrangement::Set, &images, Packing::None);
    let opened = LdiFile::open(&written.file).unwrap();
    assert_eq!(opened.count(), 3);
    let last = write::PackedImage::of(&images[2], Packing::None).unwrap().bytes() as usize;
    fs::write(&written.file, &written.bytes[..written.bytes.len() - last - 8]).unwrap();
    let opened = LdiFile::open(&written.file).unwrap();
    opened.check().unwrap_err();
    assert!(same(&opened.read(0, &Task::silent()).unwrap(), &images[0]));
    let (left, rows) = opened.read_whole_rows(1, &Task::silent()).unwrap();
    assert!(rows.whole == rows.height && left.levels[0] == images[1].levels[0], "a coarse level is cut");
    let message = opened.read(1, &Task::silent()).unwrap_err().to_string();
    assert!(message.contains("image 1") && message.contains("cut short"), "{message}");
    let message = opened.read_whole_rows(2, &Task::silent()).unwrap_err().to_string();
    assert!(message.contains("image 2, first line"), "{message}");
}

#[test]
fn a_first_line_that_cannot_be_true_is_refused() {
    let written = WrittenSet::new(Arrangement::Set, &any(), Packing::Deflate);
    let end = written.bytes.iter().position(|byte| *byte == b'\n').unwrap();
    let mut header: serde_json::Value = serde_json::from_slice(&written.bytes[..end]).unwrap();
    header.as_object_mut().unwrap().remove("line_hash");
    let says = |change: &dyn Fn(&mut serde_json::Value), what: &str| {
        let mut header = header.clone();
        change(&mut header);
        let message = written.message_with(&header);
        assert!(message.contains(what), "{message}");
    };
    says(&|line| line["version"] = 2.into(), "`version` is 2; expected 1");
    says(&|line| line["arrangement"] = "ring".into(), "expected one of: cube, set");
    says(&|line| line["arrangement"] = "cube".into(), "3 images of a cube; expected 6");
    says(&|line| line["images"] = serde_json::json!([]), "no image in the set");
    says(&|line| line["images"][1]["bytes"] = 0.into(), "image 1: 0 bytes; expected a multiple of 8");
    says(&|line| line["images"][1]["bytes"] = (1u64 << 63).into(), "more bytes than any file");
    says(&|line| line["images"][2]["bytes"] = 8.into(), "expected");
    says(&|line| line["images"][0]["bytes"] = 8.into(), "expected");
    says(&|line| line["images"][2]["bytes"] = (1u64 << 40).into(), "the file is cut short");
    says(&|line| drop(line["images"].as_array_mut().unwrap().pop()), "bytes; expected");
}

#[test]
fn six_images_that_make_no_cube_are_neither_written_nor_read() {
    let mut images = faces(4);
    images.swap(0, 1);
    let written = WrittenSet::new(Arrangement::Cube, &images, Packing::Deflate);
    assert!(read_ldi_set(&written.file, &Task::silent()).is_ok(), "their order in the file is free");
    images[3] = images[2].clone();
    let file = written.file.with_file_name("none.ldi");
    let packed = |arrangement, images: &[Ldi]| {
        let mut packed = PackedSet::new(arrangement, Packing::None);
        for image in images {
            packed.add(&file, image).unwrap();
        }
        packed
    };
    let message = packed(Arrangement::Cube, &images).write(&file).unwrap_err().to_string();
    assert!(message.contains("faces 2 and 3") && !file.exists(), "{message}");
    // As a set they are written, and no cube is made of it by name alone.
    let set = WrittenSet::new(Arrangement::Set, &images, Packing::None);
    let end = set.bytes.iter().position(|byte| *byte == b'\n').unwrap();
    let mut header: serde_json::Value = serde_json::from_slice(&set.bytes[..end]).unwrap();
    header.as_object_mut().unwrap().remove("line_hash");
    header["arrangement"] = "cube".into();
    let message = set.message_with(&header);
    assert!(message.contains("the images make no cube"), "{message}");
    assert!(packed(Arrangement::Cube, &images[..5]).write(&file).is_err());
    assert!(packed(Arrangement::Set, &[]).write(&file).is_err());
}
