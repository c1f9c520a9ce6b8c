//! Pages: what is written, and over what not.

use glam::DVec3;

use super::{Page, PagePlace, VIEWER, description, place_of_page, write_page};
use crate::lean::{DIRECTIONS, SafeRegion, Window};
use crate::segments::{Atlas, Segments, TexturedPart, Vertex};
use quadratura_base::geometry::{Pinhole, PixelRect};
use quadratura_page::viewer::assert_small;
use quadratura_view::Picture;

const CAMERA: Pinhole = Pinhole { width: 16, height: 8, fx: 10.0, fy: 10.0, cx: 8.0, cy: 4.0 };

fn one_square() -> Segments {
    let vertices = [[0, 0], [8, 0], [8, 8]].map(|[x, y]| Vertex { x, y, inverse_depth: 0.5 }).to_vec();
    let part = TexturedPart {
        segment: 0,
        atlas: 0,
        origin: [-2, -2],
        at: [0, 0],
        size: [16, 16],
        vertices,
        triangles: vec![[0, 1, 2]],
    };
    let atlas = Atlas {
        first: true,
        opaque: true,
        width: 16,
        height: 16,
        rgb: vec![90; 768],
        opacity: vec![255; 256],
    };
    Segments { count: 1, parts: vec![part], atlases: vec![atlas], reach: 0.3, parallax: 0.5 }
}

const WINDOW: Window =
    Window { pivot: 2.0, zoom: 1.0, seen: PixelRect { x: 0, y: 0, w: CAMERA.width, h: CAMERA.height } };
const SAFE: SafeRegion = SafeRegion { across: [0.1; DIRECTIONS], along: [0.1; 2] };

fn square<'a>(segments: &'a Segments, caption: &'a str, poster: &'a Picture) -> Page<'a> {
    Page { camera: &CAMERA, segments, window: &WINDOW, safe: &SAFE, poster, caption, quality: 90 }
}

fn poster() -> Picture {
    Picture { width: 16, height: 8, rgba: vec![200; 512] }
}

fn write(place: &PagePlace, caption: &str) -> Vec<String> {
    let page = write_page(place, &square(&one_square(), caption, &poster()));
    page.unwrap().into_iter().map(|file| file.name).collect()
}

#[test]
fn a_page_has_its_files_and_a_caption_that_is_no_markup() {
    let folder = tempfile::tempdir().unwrap();
    let place = place_of_page(&folder.path().join("page"));
    let files = write(&place, "<b> {{width}} & \"x\"");
    for file in
        ["index.html", "viewer.css", "poster.jpg", "code/shaders.js", "code/start.js", "data/photo.js"]
    {
        assert!(files.iter().any(|name| name == file), "{file} is missing: {files:?}");
    }
    let index = std::fs::read_to_string(place.folder.join("index.html")).unwrap();
    assert!(index.contains("<title>&lt;b&gt; {{width}} &amp; &quot;x&quot;</title>"), "{index}");
    assert!(!index.contains("<b>") && index.contains("lang=\"en\"") && index.contains("<noscript>"));
    let data = std::fs::read_to_string(place.folder.join("data/photo.js")).unwrap();
    assert!(data.starts_with("quadratura.chunk(\"photo\", "), "{data}");
}

#[test]
fn a_page_says_where_the_camera_is_and_how_many_pieces_its_meshes_have() {
    let photo = description(&square(&one_square(), "a square", &poster()));
    assert_eq!((photo["pieces"].as_u64(), photo["camera"]["fx"].as_f64()), (Some(1), Some(10.0)));
    assert_eq!(photo["atlases"][0]["width"].as_u64(), Some(16));
}

#[test]
fn sources_are_short_enough_to_be_read_and_small_enough_to_be_sent() {
    assert_small(&VIEWER);
}

#[test]
fn nothing_of_others_is_overwritten_and_an_unchanged_page_is_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("page");
    std::fs::create_dir(&out).unwrap();
    assert_eq!(place_of_page(&out).folder, out, "an empty folder is free");
    write(&place_of_page(&out), "first");
    let again = place_of_page(&out);
    assert_eq!((&again.folder, again.spared.len()), (&out, 0));
    write(&again, "second");
    assert!(std::fs::read_to_string(out.join("index.html")).unwrap().contains("second"));
    // One file more, or one that was changed, makes it somebody's work.
    std::fs::write(out.join("notes.txt"), "mine").unwrap();
    let beside = place_of_page(&out);
    assert_eq!((beside.folder, beside.spared), (folder.path().join("page-2"), vec![out.clone()]));
    std::fs::remove_file(out.join("notes.txt")).unwrap();
    std::fs::write(out.join("viewer.css"), "body { color: red }").unwrap();
    assert_eq!(place_of_page(&out).folder, folder.path().join("page-2"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing unfinished is left");
}

#[test]
fn points_at_the_pivot_keep_their_place_when_the_viewpoint_moves_aside() {
    let window = Window { pivot: 2.0, zoom: 1.5, seen: CAMERA.rect() };
    let ldi = crate::Ldi {
        kind: crate::LdiKind::Depth,
        inputs: String::new(),
        camera: CAMERA,
        pose: quadratura_base::geometry::Pose {
            rotation: glam::DMat3::IDENTITY,
            translation: DVec3::new(3.0, 1.0, 2.0),
        },
        photo_rect: None,
        gain: [0.0; 3],
        surfaces: Vec::new(),
        sources: Vec::new(),
        levels: Vec::new(),
        report: crate::LdiReport::default(),
    };
    let position = |offset: DVec3| {
        let shot = window.shot(&ldi, offset, [32, 16]);
        let point = ldi.pose.world_from_camera(DVec3::new(0.4, -0.2, 2.0));
        shot.camera.image_from_camera(shot.pose.camera_from_world(point)).unwrap()
    };
    assert!((position(DVec3::ZERO) - position(DVec3::new(0.3, -0.2, 0.0))).length() < 1e-9);
    // (0.4, -0.2) / 2 at a focal length of 10 px, magnified 1.5 times and twice as large, from the middle.
    assert!((position(DVec3::ZERO) - glam::DVec2::new(16.0 + 6.0, 8.0 - 3.0)).length() < 1e-9);
}
