//! The model as one photo sees it, prepared for a rasteriser: planar items with their triangles in
//! homogeneous clip coordinates and their planes as inverse depth over the image.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use quadratura_base::geometry::clip::clipped_to_box;
use quadratura_base::geometry::{InverseDepth, Pinhole, PixelRect, Pose};
use quadratura_base::scene::{FaceId, Model};

/// The index of an item in [`ProjectedModel::items`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ItemId(pub u32);

/// The unit that the visibility sort orders: a planar face, or one triangle of a face that is not planar.
#[derive(Debug, Clone, PartialEq)]
pub struct Item {
    /// The face that the item belongs to.
    pub face: FaceId,
    /// The index of the triangle within the face when the face is not planar; `None` for a planar face.
    pub triangle: Option<u32>,
    /// The item's plane.
    pub inverse_depth: InverseDepth,
    /// True when the photo sees the item from behind.
    pub back: bool,
    /// Bounding box of the outline, clipped to the photo, in whole pixels.
    pub bounds: PixelRect,
    /// True where one may see through the item in places: what is behind it may be visible all the same.
    pub see_through: bool,
}

/// The reason why a face is absent from the view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Absence {
    /// The face lies in front of the camera but outside the photo.
    Outside,
    /// The face lies behind the camera.
    Behind,
    /// The face's plane passes through the camera.
    EdgeOn,
    /// The face has no area.
    Degenerate,
}

/// The model as one photo sees it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ProjectedModel {
    /// Width of the photo in pixels.
    pub width: u32,
    /// Height of the photo in pixels.
    pub height: u32,
    /// The items in model order: of the items visible at one pixel, the last one owns it.
    pub items: Vec<Item>,
    /// Triangles in item order, with corners in homogeneous clip coordinates (x, y, w): the image position in
    /// pixels is ((x/w + 1) width/2, (1 - y/w) height/2), and w is the depth in world units. Corners behind
    /// the camera have w <= 0; the rasteriser clips them.
    pub corners: Vec<[[f32; 3]; 3]>,
    /// The item index of each triangle; never decreases.
    pub triangle_items: Vec<u32>,
    /// An upper bound of the inverse depth of any fragment in the photo; a power of two.
    pub largest_inverse_depth: f32,
    /// Faces that cannot cover a pixel, in model order, with the reason.
    pub absent: Vec<(FaceId, Absence)>,
}

/// The edge-on limit: a plane is edge-on when its distance from the camera is less than this share of the
/// distance to the polygon. The polygon then covers less than a millionth of a pixel in any photo of fewer
/// than 10^5 pixels a side.
const EDGE_ON: f64 = 1e-12;

impl ProjectedModel {
    /// Returns the memory that it takes, in bytes.
    pub fn bytes(&self) -> u64 {
        let lists = [
            size_of_val(&self.items[..]),
            size_of_val(&self.corners[..]),
            size_of_val(&self.triangle_items[..]),
            size_of_val(&self.absent[..]),
        ];
        lists.iter().sum::<usize>() as u64
    }

    /// Builds the view of `model` (in world coordinates, as the camera sees it: [`Model::facing`]) from a photo's camera. All
    /// computations are in f64
    /// in the camera's frame; only their results are rounded to f32.
    pub fn new(model: &Model, camera: &Pinhole, pose: &Pose) -> Self {
        let points: Vec<DVec3> = model.vertices.par_iter().map(|&p| pose.camera_from_world(p)).collect();
        let seen: Vec<_> = (0..model.faces.len() as u32)
            .into_par_iter()
            .map(|f| items_of_face(model, FaceId(f), &points, camera, pose))
            .collect();
        let mut view = Self { width: camera.width, height: camera.height, ..Self::default() };
        let mut largest = f64::MIN_POSITIVE;
        // Of an impostor only its rectangle can be absent.
        for (face, seen) in model.face_ids().zip(seen).filter(|(face, _)| !model.is_replaced(*face)) {
            match seen {
                Err(absence) => view.absent.push((face, absence)),
                Ok(items) => {
                    let see_through = model.sees_through(face);
                    for (item, triangles, nearest) in items {
                        largest = largest.max(1.0 / nearest);
                        let item = Item { see_through, ..item };
                        view.push(item, &triangles, camera);
                    }
                }
            }
        }
        // The factor 2 allows for a fragment's centre lying a sub-pixel step outside of its outline.
        view.largest_inverse_depth = (2.0 * largest).log2().ceil().clamp(-60.0, 60.0).exp2() as f32;
        view
    }

    /// Returns whether some item is see-through.
    pub fn has_see_through(&self) -> bool {
        self.items.iter().any(|item| item.see_through)
    }

    fn push(&mut self, item: Item, triangles: &[[DVec3; 3]], camera: &Pinhole) {
        let index = self.items.len() as u32;
        self.items.push(item);
        for triangle in triangles {
            self.corners.push(triangle.map(|p| clip_from_camera(p, camera)));
            self.triangle_items.push(index);
        }
    }
}

/// Converts a point in the camera frame to homogeneous clip coordinates (x, y, w), see [`ProjectedModel::corners`].
pub fn clip_from_camera(p: DVec3, camera: &Pinhole) -> [f32; 3] {
    let (width, height) = (f64::from(camera.width), f64::from(camera.height));
    let x = 2.0 * (camera.fx * p.x + camera.cx * p.z) / width - p.z;
    let y = p.z - 2.0 * (camera.fy * p.y + camera.cy * p.z) / height;
    [x as f32, y as f32, p.z as f32]
}

type VisibleItem = (Item, Vec<[DVec3; 3]>, f64);

/// Builds the items of one face: the face itself, or its triangles when it is not planar. Each item comes
/// with its triangles in the camera frame and the depth of its nearest point within the photo.
fn items_of_face(
    model: &Model,
    face: FaceId,
    points: &[DVec3],
    camera: &Pinhole,
    pose: &Pose,
) -> Result<Vec<VisibleItem>, Absence> {
    let triangles: Vec<(u32, [DVec3; 3])> = (0..)
        .zip(model.face_triangles(face))
        .map(|(i, t)| (i, t.map(|v| points[v as usize])))
        .filter(|(_, t)| normal(t).length_squared() > 0.0)
        .collect();
    if triangles.is_empty() {
        return Err(Absence::Degenerate);
    }
    if model.face(face).planar {
        // The modeller's own plane is used, so that pieces and depths are cut by the same plane.
        let plane = &model.face(face).plane;
        let (normal, point) = (pose.rotation * plane.normal, pose.camera_from_world(plane.point));
        return item_of_triangles(face, None, triangles, normal, point, camera).map(|seen| vec![seen]);
    }
    let items: Vec<_> = triangles
        .into_iter()
        .map(|(i, t)| item_of_triangles(face, Some(i), vec![(i, t)], normal(&t).normalize(), t[0], camera))
        .collect();
    let first_absence = items.iter().find_map(|i| i.as_ref().err().copied());
    let seen: Vec<VisibleItem> = items.into_iter().flatten().collect();
    if seen.is_empty() { Err(first_absence.unwrap_or(Absence::Degenerate)) } else { Ok(seen) }
}

/// Builds the item of some triangles of a plane, whose normal and one point of which are in the camera frame.
fn item_of_triangles(
    face: FaceId,
    triangle: Option<u32>,
    triangles: Vec<(u32, [DVec3; 3])>,
    normal: DVec3,
    point: DVec3,
    camera: &Pinhole,
) -> Result<VisibleItem, Absence> {
    let triangles: Vec<[DVec3; 3]> = triangles.into_iter().map(|(_, t)| t).collect();
    if triangles.iter().flatten().all(|p| p.z <= 0.0) {
        return Err(Absence::Behind);
    }
    let mut extent = OutlineExtent::default();
    let size_px = DVec2::new(f64::from(camera.width), f64::from(camera.height));
    for t in &triangles {
        extent.add(&clipped_to_box(t, camera, DVec2::ZERO, size_px), camera);
    }
    if extent.is_empty() {
        return Err(Absence::Outside);
    }
    let distance = normal.dot(point);
    if distance.abs() <= EDGE_ON * extent.farthest.length() {
        return Err(Absence::EdgeOn);
    }
    let inverse_depth = InverseDepth::of_plane(normal, distance, extent.farthest_px(camera), camera);
    let bounds = extent.bounds(camera);
    // The normal points to the side from which the outline is counter-clockwise; the camera is at the origin.
    let back = distance > 0.0;
    Ok((Item { face, triangle, inverse_depth, back, bounds, see_through: false }, triangles, extent.nearest))
}

fn normal(t: &[DVec3; 3]) -> DVec3 {
    (t[1] - t[0]).cross(t[2] - t[0])
}

/// The extent of a clipped outline in the photo: its bounding box in pixels and its nearest and farthest
/// points.
pub struct OutlineExtent {
    low_px: DVec2,
    high_px: DVec2,
    nearest: f64,
    farthest: DVec3,
}

impl Default for OutlineExtent {
    fn default() -> Self {
        Self {
            low_px: DVec2::INFINITY,
            high_px: DVec2::NEG_INFINITY,
            nearest: f64::INFINITY,
            farthest: DVec3::ZERO,
        }
    }
}

impl OutlineExtent {
    /// Adds a polygon (camera frame) that was clipped to the photo.
    pub fn add(&mut self, clipped: &[DVec3], camera: &Pinhole) {
        for p in clipped {
            let Some(px) = camera.image_from_camera(*p) else { continue };
            self.low_px = self.low_px.min(px);
            self.high_px = self.high_px.max(px);
            self.nearest = self.nearest.min(p.z);
            if p.z > self.farthest.z {
                self.farthest = *p;
            }
        }
    }

    /// Returns true when no part of the outline lies within the photo.
    pub fn is_empty(&self) -> bool {
        self.low_px.x > self.high_px.x
    }

    /// Returns the bounding box in whole pixels, within the photo; it holds one pixel at least.
    pub fn bounds(&self, camera: &Pinhole) -> PixelRect {
        let (w, h) = (camera.width as i32, camera.height as i32);
        let x0 = (self.low_px.x.floor() as i32).clamp(0, w - 1);
        let y0 = (self.low_px.y.floor() as i32).clamp(0, h - 1);
        let x1 = (self.high_px.x.ceil() as i32).clamp(x0 + 1, w);
        let y1 = (self.high_px.y.ceil() as i32).clamp(y0 + 1, h);
        PixelRect::from_edges(x0, y0, x1, y1)
    }

    fn farthest_px(&self, camera: &Pinhole) -> DVec2 {
        camera.image_from_camera(self.farthest).unwrap_or(DVec2::new(camera.cx, camera.cy))
    }
}
