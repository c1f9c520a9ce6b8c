//! The face at a position in the 3D view, and the faces of a selection.

use std::collections::BTreeSet;

use glam::DVec3;

use super::picture::NewestPicture;
use super::scene::ShownScene;
pub use super::view_pixel::ViewPixel;
use crate::state::selection::Selection;
use crate::state::session::Session;
use quadratura_base::scene::{FaceId, Model, Object, PhotoId};
use quadratura_document::trees::TreeIndex;
use quadratura_layers::LayerIndex;
use quadratura_projection::{TREE, shown_face};
use quadratura_view::hidden::{Culling, HiddenFaces};

/// The number of parts of a tree's height at which its distance from a ray is looked at.
const PARTS: u32 = 16;

impl ShownScene<'_> {
    /// Returns the face at a position: from the item buffer where the picture shows this view, otherwise by a ray. In the
    /// item buffer, see-through faces are where something of them is there; a ray meets all of them.
    pub fn face_at(&self, pixel: &ViewPixel) -> Option<FaceId> {
        let session = self.session;
        if let Some(number) = self.number_at(pixel) {
            return shown_face(number);
        }
        let (eye, culling) = (pixel.viewpoint.position(), self.space.look.culling());
        session.solid.first_visible(eye, pixel.ray(), culling).map(|hit| hit.face)
    }

    /// Returns the number in the item buffer at a position: 1 + a face's id, 0 where there is none; `None` where the picture
    /// shows another view.
    fn number_at(&self, pixel: &ViewPixel) -> Option<u32> {
        let (view, px) = (&pixel.viewpoint, pixel.at_px);
        let is_this =
            |shown: &&NewestPicture| shown.request.shot.pose == view.pose && !shown.faces.is_empty();
        let shown = self.space.shown.as_ref().filter(is_this)?;
        let camera = &shown.request.shot.camera;
        let place = |px: f64, of: u32, all: u32| ((px / f64::from(all) * f64::from(of)) as u32).min(of - 1);
        let (x, y) =
            (place(px.x, camera.width, pixel.size_px[0]), place(px.y, camera.height, pixel.size_px[1]));
        shown.faces.get(y as usize * camera.width as usize + x as usize).copied()
    }

    /// Returns the tree that is drawn at a position; `None` also where the picture shows another view or trees of before.
    pub fn tree_at(&self, pixel: &ViewPixel) -> Option<TreeIndex> {
        let number = self.number_at(pixel).filter(|number| number & TREE != 0)?;
        let index = TreeIndex(number & !TREE);
        let is_present = self.space.shows_present() && self.session.trees().at(index).is_some();
        is_present.then_some(index)
    }

    /// Returns whether a tree is drawn at a position that is not known to stand there any more.
    pub fn shows_tree_of_before(&self, pixel: &ViewPixel) -> bool {
        self.number_at(pixel).is_some_and(|number| number & TREE != 0) && self.tree_at(pixel).is_none()
    }

    /// Returns the nearest tree that stands at a position and is not in the picture yet; the ball of its crown and stem counts.
    pub fn undrawn_tree_at(&self, pixel: &ViewPixel) -> Option<TreeIndex> {
        let (session, trees) = (self.session, self.session.trees());
        let (eye, ray) = (pixel.viewpoint.position(), pixel.ray().normalize_or_zero());
        let present = self.space.shown.as_ref().filter(|_| self.space.shows_present());
        let drawn: BTreeSet<u32> = present.iter().flat_map(|shown| shown.faces.iter().copied()).collect();
        let up = session.scene_frame.up;
        let depth_at = |index: TreeIndex| {
            let tree = trees.at(index).filter(|tree| !self.trees.hidden.contains(&tree.name))?;
            let radius = session.scene_frame.radius;
            let [height, width] = self.trees.size_of(trees, tree).unwrap_or([0.1 * radius, 0.05 * radius]);
            let foot = DVec3::from_array(tree.at) - eye;
            let near = |part: u32| {
                let point = foot + height * f64::from(part) / f64::from(PARTS) * up;
                (point.cross(ray).length() <= 0.5 * width && point.dot(ray) > 0.0).then(|| point.dot(ray))
            };
            (0..=PARTS).filter_map(near).reduce(f64::min)
        };
        let all = (0..trees.placed.len() as u32).filter(|index| !drawn.contains(&(index | TREE)));
        let met = all.filter_map(|index| Some((depth_at(TreeIndex(index))?, TreeIndex(index))));
        met.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, index)| index)
    }

    /// Returns the point of the solid surfaces under a position in the view, whatever tree or billboard is before it.
    pub fn ground_at(&self, pixel: &ViewPixel) -> Option<DVec3> {
        let session = self.session;
        let (eye, ray, look) = (pixel.viewpoint.position(), pixel.ray(), &self.space.look);
        let flat = |object: &&Object| object.see_through || object.impostor.is_some() || object.billboard;
        let flat =
            session.model().objects.iter().filter(flat).flat_map(|object| object.faces.iter().copied());
        let hidden: HiddenFaces = look.hidden.iter().chain(flat).collect();
        let culling = Culling { hidden: &hidden, ..look.culling() };
        session.solid.first_visible(eye, ray, culling).map(|hit| eye + ray * hit.t)
    }

    /// Returns the point of the model under a position in the view; on a tree, the point as far away as its foot.
    pub fn point_at(&self, pixel: &ViewPixel) -> Option<DVec3> {
        if let Some(index) = self.tree_at(pixel) {
            let (pose, ray) = (pixel.viewpoint.pose, pixel.ray());
            let foot = DVec3::from_array(self.session.trees().at(index)?.at);
            let along = (pose.rotation * ray).z;
            let depth = pose.camera_from_world(foot).z;
            return (depth > 0.0 && along > 0.0).then(|| pixel.viewpoint.position() + ray * (depth / along));
        }
        self.surface_at(pixel).map(|(point, _)| point)
    }

    /// Returns the point of the model under a position in the view, with its face: that of [`Self::face_at`], where the ray
    /// through the position meets it.
    pub fn surface_at(&self, pixel: &ViewPixel) -> Option<(DVec3, FaceId)> {
        let (session, eye) = (self.session, pixel.viewpoint.position());
        let (solid, ray, culling) = (&session.solid, pixel.ray(), self.space.look.culling());
        let on_shown = match self.number_at(pixel) {
            Some(number) => {
                let shown = BTreeSet::from([shown_face(number)?]);
                solid.through(eye, ray, &shown, culling).pop()
            }
            None => None,
        };
        // At an outline, the middle of the picture's pixel shows a face that the ray may miss.
        let hit = on_shown.or_else(|| solid.first_visible(eye, ray, culling))?;
        Some((eye + ray * hit.t, hit.face))
    }
}

/// Returns the bounding sphere of a selection, in world space; none for photos and for nothing.
pub fn ball_of(selection: Selection, session: &Session) -> Option<(DVec3, f64)> {
    let model = session.model();
    let faces = faces_of(selection, session);
    let points: Vec<DVec3> = faces.into_iter().flat_map(|face| model.ring_points(face)).collect();
    if points.is_empty() {
        return None;
    }
    let (low, high) =
        points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
    let center = (low + high) / 2.0;
    let radius = points.iter().map(|point| point.distance(center)).fold(0.0, f64::max);
    Some((center, radius.max(session.scene_frame.radius * 1e-3)))
}

/// Returns the selected faces.
pub fn faces_of(selection: Selection, session: &Session) -> Vec<FaceId> {
    let model: &Model = session.model();
    match selection {
        Selection::Object(object) => model.object(object).faces.clone(),
        Selection::Face(face) => vec![face],
        Selection::Layer { photo, layer } => faces_of_layer(photo, layer, session).unwrap_or_default(),
        Selection::Photo(_) | Selection::Nothing | Selection::Tree(_) | Selection::Trees => Vec::new(),
    }
}

fn faces_of_layer(photo: PhotoId, layer: LayerIndex, session: &Session) -> Option<Vec<FaceId>> {
    let stack = session.stack_of(photo)?;
    let elements: Vec<_> = stack.visibility_layers.iter().flatten().collect();
    let model = session.model();
    let mut found = Vec::new();
    for element in &stack.image_layers.get(layer.index())?.elements {
        let element = elements.get(element.index())?;
        let object = model.objects.iter().find(|object| object.name == element.object)?;
        let pieces = element.pieces.iter().map(|(face, _)| *face);
        found.extend(element.faces.iter().copied().chain(pieces).filter_map(|index| object.face(index)));
    }
    found.sort_unstable();
    found.dedup();
    Some(found)
}
