//! Drawings of the model's edges over a photo, which quickly show whether the two match.

use std::path::Path;

use glam::{DVec2, DVec3};

use super::faces::CheckedSurface;
use super::seen::VisibleModel;
use super::unexplained::Miss;
use crate::legend_picture::{KeyList, draw_key};
use quadratura_base::error::Result;
use quadratura_base::geometry::Pinhole;
use quadratura_base::scene::{Edges, Model, ObjectId, Photo};
use quadratura_import::photo::read_photo;
use quadratura_io::overlay::{Overlay, write_jpeg};

/// The length of the picture's longer side in pixels.
const LONGEST_SIDE: u32 = 2048;

/// The distance in pixels of the picture between two tests whether an edge is hidden.
const STRIDE: f64 = 6.0;

/// The opacity of hidden edges.
const FAINT: f32 = 0.22;

/// An edge is hidden when a surface is nearer by more than this share of the distance.
const HIDES: f64 = 2e-3;

/// The most objects that the legend lists: those that cover most of the photo.
const LISTED: usize = 8;

/// Draws the edges of the faces that the photo sees, each object in its own colour and hidden parts faint, and over them
/// the sparse points that no face explains, with a legend, and writes the picture.
///
/// # Errors
/// Returns [`quadratura_base::Error::Input`] and [`quadratura_base::Error::Io`] when the photo cannot be read or the picture cannot be
/// written.
pub fn draw(
    model: &Model,
    surface: &CheckedSurface,
    photo: &Photo,
    seen: &VisibleModel,
    unexplained: &[(DVec3, Miss)],
    path: &Path,
) -> Result<()> {
    let pixels = read_photo(&photo.file, photo.camera.width, photo.camera.height)?;
    let mut overlay = Overlay::new(&pixels, LONGEST_SIDE);
    drop(pixels);
    let longest = photo.camera.width.max(photo.camera.height);
    let stride_px = STRIDE * (f64::from(longest) / f64::from(LONGEST_SIDE)).max(1.0);
    // Dots are on top of lines that are drawn later, and the worst ones on top of others.
    for miss in Miss::ALL {
        for (point, _) in unexplained.iter().filter(|(_, it)| *it == miss) {
            let px = photo.camera.image_from_camera(photo.pose.camera_from_world(*point));
            px.into_iter().for_each(|px| overlay.dot(px, dot_color(miss)));
        }
    }
    let edges = Edges::from_model(model);
    for face in seen.faces.iter().map(|seen| seen.face) {
        let color = color_of(model.face(face).object.0);
        for &[a, b] in edges.of_face(face) {
            let ends = [a, b].map(|v| photo.pose.camera_from_world(model.vertices[v as usize]));
            let Some(ends) = within_photo(ends, &photo.camera) else { continue };
            draw_edge(&mut overlay, surface, photo, ends, color, stride_px);
        }
    }
    let mut picture = overlay.into_picture();
    draw_key(&mut picture, &key(model, seen, unexplained));
    write_jpeg(&picture, path)
}

/// Returns the legend: the objects that cover most of the photo, and the kinds of points.
fn key(model: &Model, seen: &VisibleModel, unexplained: &[(DVec3, Miss)]) -> Vec<KeyList> {
    let mut px = vec![0u64; model.objects.len()];
    seen.faces.iter().for_each(|seen| px[model.face(seen.face).object.index()] += u64::from(seen.px));
    let mut objects: Vec<ObjectId> =
        model.objects.iter().enumerate().map(|(at, _)| ObjectId(at as u32)).collect();
    objects.retain(|object| px[object.index()] > 0);
    objects.sort_by_key(|object| (std::cmp::Reverse(px[object.index()]), *object));
    let shown = objects.iter().take(LISTED);
    let shown = shown.map(|object| (model.object(*object).name.clone(), color_of(object.0))).collect();
    let more = match objects.len().saturating_sub(LISTED) {
        0 => String::new(),
        more => format!("; not listed: {more} smaller ones"),
    };
    let mut key = vec![(format!("edges of the model, hidden ones faint{more}"), shown)];
    if !unexplained.is_empty() {
        let count = |miss: Miss| unexplained.iter().filter(|(_, it)| *it == miss).count();
        let kinds = Miss::ALL.into_iter().filter(|miss| count(*miss) > 0);
        let kinds = kinds.map(|miss| (format!("{} {}", count(miss), miss.meaning()), dot_color(miss)));
        key.push(("sparse points that no face explains".into(), kinds.collect()));
    }
    key
}

/// The colour of points that no face explains.
fn dot_color(miss: Miss) -> [u8; 3] {
    match miss {
        Miss::Open => [255, 40, 160],
        Miss::InFront => [255, 220, 40],
        Miss::Hidden => [60, 220, 255],
    }
}

/// Clips an edge (camera frame) to what projects into the photo.
fn within_photo([mut a, mut b]: [DVec3; 2], camera: &Pinhole) -> Option<[DVec3; 2]> {
    let (w, h) = (f64::from(camera.width), f64::from(camera.height));
    // Half spaces through the camera centre; together they exclude everything behind it.
    let sides = [
        DVec3::new(camera.fx, 0.0, camera.cx),
        DVec3::new(-camera.fx, 0.0, w - camera.cx),
        DVec3::new(0.0, camera.fy, camera.cy),
        DVec3::new(0.0, -camera.fy, h - camera.cy),
    ];
    for side in sides {
        let (da, db) = (side.dot(a), side.dot(b));
        if da <= 0.0 && db <= 0.0 {
            return None;
        }
        let meets = a + (b - a) * (da / (da - db));
        if da < 0.0 {
            a = meets;
        } else if db < 0.0 {
            b = meets;
        }
    }
    (a.z > 0.0 && b.z > 0.0).then_some([a, b])
}

/// Draws an edge in short pieces, hidden ones faint.
fn draw_edge(
    overlay: &mut Overlay,
    surface: &CheckedSurface,
    photo: &Photo,
    [a, b]: [DVec3; 2],
    color: [u8; 3],
    stride_px: f64,
) {
    let project = |p: DVec3| photo.camera.image_from_camera(p).unwrap_or(DVec2::NAN);
    let (a_px, b_px) = (project(a), project(b));
    let pieces = (a_px.distance(b_px) / stride_px).ceil().max(1.0);
    if !pieces.is_finite() {
        return;
    }
    let eye = photo.pose.center_in_world();
    // The steps are equal in the image; positions in space are interpolated by inverse depth.
    let at = |share: f64| {
        let weight_b = share / b.z;
        let weight_a = (1.0 - share) / a.z;
        (a * weight_a + b * weight_b) / (weight_a + weight_b)
    };
    let hidden = |share: f64| {
        let ray = photo.pose.world_from_camera(at(share)) - eye;
        surface.tree.first_hit(eye, ray, 1.0 - HIDES).is_some()
    };
    let mut start = 0.0;
    let mut was_hidden = hidden(0.5 / pieces);
    for piece in 1..=pieces as u64 {
        let here = piece as f64 / pieces;
        let is_last = piece == pieces as u64;
        let is_hidden = if is_last { !was_hidden } else { hidden(here + 0.5 / pieces) };
        if is_hidden != was_hidden {
            let strength = if was_hidden { FAINT } else { 1.0 };
            overlay.line(a_px.lerp(b_px, start), a_px.lerp(b_px, here), color, strength);
            (start, was_hidden) = (here, is_hidden);
        }
    }
}

/// Returns a bright colour. Neighbouring objects differ strongly, because the hue advances by the golden angle.
fn color_of(object: u32) -> [u8; 3] {
    let hue = (f64::from(object) * 0.618_033_988_75).fract() * 6.0;
    let channel = |shift: f64| {
        let distance = ((hue + shift) % 6.0 - 3.0).abs() - 1.0;
        (80.0 + 175.0 * distance.clamp(0.0, 1.0)).round() as u8
    };
    [channel(0.0), channel(4.0), channel(2.0)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::seen::VisibleFace;
    use quadratura_base::scene::FaceId;
    use quadratura_base::scene::synthetic::{Modeller, centred};

    #[test]
    fn an_edge_through_the_camera_plane_is_cut_at_the_photos_border() {
        let camera = centred(100, 100, 50.0);
        let [a, b] = within_photo([DVec3::new(0.0, 0.5, -3.0), DVec3::new(0.0, 0.5, 10.0)], &camera).unwrap();
        let px = |p| camera.image_from_camera(p).unwrap();
        assert!((px(a) - DVec2::new(50.0, 100.0)).length() < 1e-9);
        assert!((px(b) - DVec2::new(50.0, 52.5)).length() < 1e-9);
        assert!(within_photo([DVec3::new(0.0, 0.0, -1.0), DVec3::new(0.0, 0.0, -2.0)], &camera).is_none());
        assert!(within_photo([DVec3::new(9.0, 0.0, 1.0), DVec3::new(9.0, 5.0, 2.0)], &camera).is_none());
    }

    #[test]
    fn the_legend_lists_the_largest_objects_and_the_kinds_of_points_that_there_are() {
        let mut m = Modeller::new();
        for object in 0..10 {
            m.object(format!("object {object}")).screen(10.0, [0.0, 0.0, 1.0, 1.0]);
        }
        let model = m.finish();
        let seen = |(face, px): (FaceId, u32)| VisibleFace { face, back: false, px };
        // The last object is not seen, the one before it has most pixels.
        let faces = model.face_ids().take(9).zip(1..).map(seen).collect();
        let seen = VisibleModel { in_front: 1.0, inside: 1.0, covered: 1.0, faces };
        let points = [(DVec3::ZERO, Miss::Open), (DVec3::ONE, Miss::Open), (DVec3::X, Miss::Hidden)];
        let lists = key(&model, &seen, &points);
        assert_eq!(lists[0].0, "edges of the model, hidden ones faint; not listed: 1 smaller ones");
        assert_eq!((lists[0].1.len(), &lists[0].1[0]), (8, &("object 8".to_owned(), color_of(8))));
        let points: Vec<&str> = lists[1].1.iter().map(|(text, _)| text.as_str()).collect();
        assert_eq!(
            points,
            ["2 with no face behind them: shown infinitely far away", "1 behind a face, which hides them"]
        );
        assert_eq!(key(&model, &seen, &[]).len(), 1);
    }

    #[test]
    fn neighbouring_objects_get_different_bright_colours() {
        for object in 0..50 {
            let (a, b) = (color_of(object), color_of(object + 1));
            assert!(a.iter().zip(&b).map(|(a, b)| a.abs_diff(*b)).max().unwrap() > 100, "{a:?} {b:?}");
            assert!(a.iter().max().unwrap() > &200);
        }
    }
}
