//! Paint is assigned to its surface again, or reported as lost.

use glam::{DMat3, DVec3};

use super::home::{Home, PaintMapping, home};
use super::parts::{LayerParts, PartSource, camera_of};
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::FaceIndex;
use quadratura_document::Element;
use quadratura_document::paint::{PaintEntry, PaintPatch, PaintedView};
use quadratura_document::stack::{StackCamera, StackPhoto, StackSurface};

const NOTHING: PixelRect = PixelRect::EMPTY;

/// A square of 4 x 4 at `x` to the right and `z` away that faces the camera.
fn square(object: &str, face: u32, x: f64, z: f64) -> StackSurface {
    let corner = |dx: f64, dy: f64| [x + dx, dy, z];
    let outline = vec![corner(0.0, 0.0), corner(0.0, 4.0), corner(4.0, 4.0), corner(4.0, 0.0)];
    StackSurface { object: object.into(), face: FaceIndex(face), triangle: None, outline }
}

fn painted_on(surface: &StackSurface) -> PaintEntry {
    PaintEntry {
        photo: "a".into(),
        object: surface.object.clone(),
        face: Some(surface.face),
        triangle: None,
        beyond: false,
        layer: "t".into(),
        document: "k".into(),
        import: 1,
        view: "v".into(),
        outline: surface.outline.clone(),
        file: String::new(),
        rect: PixelRect::of_size(4, 4),
        pixels: 16,
    }
}

/// A camera at `x` in which one world unit at the depth of ten is one pixel.
fn view(x: f64) -> PaintedView {
    PaintedView {
        photo: StackPhoto { name: "a".into(), width: 20, height: 8 },
        camera: StackCamera {
            K: [[10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 1.0]],
            R: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            t: [-x, 0.0, 0.0],
        },
    }
}

/// Finds the parts to which paint of `entry` belongs in a stack of `surfaces`.
fn home_among(entry: &PaintEntry, surfaces: &[StackSurface]) -> Home {
    let view = view(0.0);
    let scenery = PartSource { photo: &view.photo, camera: &view.camera, surfaces, pieces: &[] };
    let element = |s: &StackSurface| Element {
        object: s.object.clone(),
        faces: vec![s.face],
        pieces: vec![],
        back: vec![],
        ..Element::default()
    };
    let elements: Vec<Element> = surfaces.iter().map(element).collect();
    let with_tiles: Vec<_> = elements.iter().map(|e| (e, None)).collect();
    let parts: LayerParts = scenery.parts(&with_tiles, NOTHING);
    home(entry, &parts.list.iter().collect::<Vec<_>>())
}

#[test]
fn a_surface_is_known_by_its_name_and_its_outline() {
    let (wall, window) = (square("wall", 0, 0.0, 10.0), square("window", 0, 1.0, 10.0));
    let entry = painted_on(&window);
    assert_eq!(home_among(&entry, &[wall, window]), Home::Same(vec![1]));
}

/// Paint on the surroundings.
fn painted_on_the_sky() -> PaintEntry {
    let surface = square("[surroundings]", 0, 0.0, 10.0);
    PaintEntry { face: None, outline: vec![], ..painted_on(&surface) }
}

#[test]
fn paint_on_the_surroundings_is_at_home_there_and_nowhere_else() {
    let (view, entry) = (view(0.0), painted_on_the_sky());
    let scenery = PartSource { photo: &view.photo, camera: &view.camera, surfaces: &[], pieces: &[] };
    let sky = Element::surroundings();
    let parts: LayerParts = scenery.parts(&[(&sky, None)], PixelRect::of_size(4, 4));
    assert_eq!(home(&entry, &parts.list.iter().collect::<Vec<_>>()), Home::Same(vec![0]));
    assert!(parts.at(19, 7).next().is_some(), "they cover every pixel of the photo");
    assert_eq!(home_among(&entry, &[square("wall", 0, 0.0, 10.0)]), Home::Lost);
    let wall = painted_on(&square("wall", 0, 0.0, 10.0));
    assert_eq!(home(&wall, &parts.list.iter().collect::<Vec<_>>()), Home::Lost);
}

#[test]
fn paint_on_the_surroundings_keeps_its_direction_whatever_the_camera() {
    let entry = painted_on_the_sky();
    let blue = [0, 0, u16::MAX, u16::MAX];
    let patch = PaintPatch::of_pixels(&[(2, 1, blue)]);
    let between = |old: &PaintedView, now: &PaintedView| {
        let (camera, pose) = camera_of(&now.photo, &now.camera);
        PaintMapping::between(&entry, old, camera, pose)
    };
    // It is infinitely far away, so a step aside changes nothing.
    assert!(between(&view(0.0), &view(3.0)).is_none());
    // Half as wide: the direction of pixel (2, 1) is at twice the distance from the principal point.
    let mut longer = view(5.0);
    longer.camera.K[0][0] = 20.0;
    longer.camera.K[1][1] = 20.0;
    let moved = between(&view(0.0), &longer).expect("the camera has changed");
    let found = moved.applied(&patch, PixelRect::of_size(20, 8));
    let at: Vec<_> = found.iter().collect();
    assert_eq!(at, [(4, 2, blue), (5, 2, blue), (4, 3, blue), (5, 3, blue)]);
}

#[test]
fn an_object_that_was_renamed_and_a_face_with_another_number_are_found_by_the_outline() {
    let (wall, window) = (square("wall", 0, 0.0, 10.0), square("window", 0, 1.0, 10.0));
    let entry = painted_on(&window);
    let mut shifted = StackSurface { object: "fenster".into(), face: FaceIndex(7), ..window.clone() };
    shifted.outline.rotate_left(1);
    assert_eq!(home_among(&entry, &[wall.clone(), shifted]), Home::Same(vec![1]));
    let other = square("window", 0, 1.0, 30.0);
    let renumbered = StackSurface { face: FaceIndex(1), ..window };
    assert_eq!(home_among(&entry, &[wall, other, renumbered]), Home::Same(vec![2]), "not by its name alone");
}

#[test]
fn the_parts_that_a_wall_was_split_into_share_its_paint() {
    let entry = painted_on(&square("wall", 0, 0.0, 10.0));
    let halves = [square("wall", 0, -2.0, 10.0), square("wall", 1, 2.0, 10.0), square("wall", 2, 0.0, 20.0)];
    assert_eq!(home_among(&entry, &halves), Home::Spread(vec![0, 1]));
}

#[test]
fn paint_of_a_surface_that_is_gone_is_lost_and_not_given_to_another_object() {
    let entry = painted_on(&square("wall", 0, 0.0, 10.0));
    assert_eq!(home_among(&entry, &[square("tree", 0, 1.0, 10.0)]), Home::Lost);
    assert_eq!(home_among(&entry, &[]), Home::Lost);
}

fn moved(entry: &PaintEntry, patch: &PaintPatch, to: &PaintedView) -> Option<PaintPatch> {
    let (camera, pose) = camera_of(&to.photo, &to.camera);
    let photo = PixelRect::of_size(20, 8);
    PaintMapping::between(entry, &view(0.0), camera, pose)
        .map(|reprojection| reprojection.applied(patch, photo))
}

#[test]
fn under_the_same_camera_paint_stays_at_its_pixels() {
    let entry = painted_on(&square("wall", 0, 0.0, 10.0));
    let patch = PaintPatch::of_pixels(&[(1, 1, [257; 4])]);
    assert_eq!(moved(&entry, &patch, &view(0.0)), None);
    assert_eq!(moved(&entry, &patch, &view(1e-5)), None, "a thousandth of a pixel is none");
}

#[test]
fn a_camera_that_moved_sees_the_paint_at_the_same_place_of_the_wall() {
    let entry = painted_on(&square("wall", 0, 0.0, 10.0));
    let patch =
        PaintPatch::of_pixels(&[(1, 1, [257, 0, 0, 65535]), (3, 2, [0; 4]), (2, 1, [514, 0, 0, 65535])]);
    // The camera moves three units to the left, so the whole wall moves three pixels to the right.
    let found = moved(&entry, &patch, &view(-3.0)).expect("the camera is another one").picked(|_, _, _| true);
    let expected =
        PaintPatch::of_pixels(&[(4, 1, [257, 0, 0, 65535]), (6, 2, [0; 4]), (5, 1, [514, 0, 0, 65535])]);
    assert_eq!(found, expected);
}

#[test]
fn a_photo_of_twice_the_size_shows_paint_of_twice_the_size() {
    let entry = painted_on(&square("wall", 0, 0.0, 10.0));
    let patch = PaintPatch::of_pixels(&[(1, 1, [257, 0, 0, 65535]), (2, 1, [257, 0, 0, 65535])]);
    let mut double = view(0.0);
    (double.photo.width, double.photo.height) = (40, 16);
    double.camera.K = [[20.0, 0.0, 0.0], [0.0, 20.0, 0.0], [0.0, 0.0, 1.0]];
    let (camera, pose) = camera_of(&double.photo, &double.camera);
    let reprojection =
        PaintMapping::between(&entry, &view(0.0), camera, pose).expect("the camera is another one");
    let found = reprojection.applied(&patch, PixelRect::of_size(40, 16)).picked(|_, _, _| true);
    assert_eq!((found.rect(), found.count()), (PixelRect { x: 2, y: 2, w: 4, h: 2 }, 8));
}

#[test]
fn the_camera_of_a_stack_is_the_one_it_was_written_of() {
    let turned = DMat3::from_rotation_y(0.3) * DMat3::from_rotation_x(-0.8);
    let pose = quadratura_base::geometry::Pose { rotation: turned, translation: DVec3::new(1.0, 2.0, 3.0) };
    let camera = StackCamera { R: pose.rotation_rows(), t: pose.translation.to_array(), ..view(0.0).camera };
    assert_eq!(camera_of(&view(0.0).photo, &camera).1, pose);
}
