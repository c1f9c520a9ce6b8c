//! The content of `scene.json`, field by field.

use glam::{DVec3, DVec4};
use serde::Serialize;

use crate::camera::{HandoverCamera, blender_lens};
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};

/// The version of the format; the script refuses others.
pub const SCENE_VERSION: u32 = 1;

/// A site as Blender's script builds it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scene {
    /// [`SCENE_VERSION`]
    pub version: u32,
    /// The point of the world that is zero in the scene.
    pub origin: [f64; 3],
    /// The mean up direction of the photos.
    pub up: [f64; 3],
    /// The photos.
    pub photos: Vec<ScenePhoto>,
    /// The image layers of all photos.
    pub layers: Vec<SceneLayer>,
    /// The materials, each for all faces that the same image layers texture.
    pub materials: Vec<SceneMaterial>,
    /// The objects.
    pub objects: Vec<SceneObject>,
    /// The billboards that turn towards the camera.
    pub billboards: Vec<SceneBillboard>,
    /// The image layers of what is around the site.
    pub surroundings: Vec<SceneSurroundings>,
    /// The distance between cameras from which they see other surroundings, in world units.
    pub surroundings_scale: f64,
    /// The surroundings where no photo shows them; `None` where nothing is known of them.
    pub dome: Option<SceneDome>,
}

/// A photo with its camera.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScenePhoto {
    /// The name in the project.
    pub name: String,
    /// The undistorted picture.
    pub file: String,
    /// The width and height in pixels.
    pub size: [u32; 2],
    /// The focal length in millimetres on a sensor 36 mm wide.
    pub lens: f64,
    /// The shift in widths of the sensor, to the right and up.
    pub shift: [f64; 2],
    /// The pixel aspect of the scene.
    pub pixel_aspect: [f64; 2],
    /// The transform of a camera that looks along -z with y up.
    pub world_from_camera: [[f64; 4]; 4],
    /// The factors of R, G, B in linear light from the photo's exposure to the common one.
    pub gain: [f64; 3],
}

/// An image layer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneLayer {
    /// The token.
    pub token: String,
    /// The readable name.
    pub name: String,
    /// The photo's place in the list.
    pub photo: usize,
    /// The picture: sRGB and alpha; alpha is the matte where one sees through the surface, else 0 or 1.
    pub file: String,
    /// Whether alpha is a matte.
    pub matte: bool,
    /// The picture of confidence: red is the weight (confidence, ramps towards borders), green how far the texel is known (1 for
    /// photo and paint, less where it was filled).
    pub confidence: String,
    /// The texture matrix: (u q, v q, q) = rows * (x, y, z, 1), u and v in 0..1 of the picture, v down.
    pub uv_from_world: [[f64; 4]; 3],
}

/// The image layers that texture a face.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneMaterial {
    /// The uses of image layers, sorted.
    pub uses: Vec<SceneUse>,
    /// Whether one sees through the surface in places.
    pub see_through: bool,
}

/// The use of an image layer on a face.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneUse {
    /// The image layer's place in the list.
    pub layer: usize,
    /// The factor of its weight on the sides of the face that one sees from the front and from behind.
    pub sides: [f64; 2],
    /// The convex parts of the face that it textures; none for the whole face. Each is where all (a, b, c) have
    /// a u + b v >= c in its picture.
    pub parts: Vec<Vec<[f64; 3]>>,
}

/// An object of the model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneObject {
    /// The name.
    pub name: String,
    /// Whether views show the surroundings in its place.
    pub hidden: bool,
    /// The vertices.
    pub vertices: Vec<[f64; 3]>,
    /// The outlines of the faces, as indices into the vertices; counter-clockwise from the visible side.
    pub faces: Vec<Vec<u32>>,
    /// Each face's index within the object, as in the model file.
    pub indices: Vec<u32>,
    /// Each face's material, as its place in the list.
    pub materials: Vec<usize>,
    /// The photo that shows each face best, as its place in the list; -1 for none.
    pub best: Vec<i64>,
}

/// A billboard that turns about its axis towards the camera.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneBillboard {
    /// The object's name.
    pub name: String,
    /// The lowest point of the axis.
    pub foot: [f64; 3],
    /// The unit direction of the axis, upwards.
    pub axis: [f64; 3],
    /// The size in world units: half the width, and the height.
    pub size: [f64; 2],
    /// The image layers.
    pub uses: Vec<BillboardUse>,
}

/// The use of an image layer on a billboard.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BillboardUse {
    /// The image layer's place in the list.
    pub layer: usize,
    /// The texture matrix: (u q, v q, q) = rows * (x, y, 1), x the distance from the axis to the right and y the height.
    pub uv_from_place: [[f64; 3]; 3],
    /// The photo's camera, or that on the other side of the axis where the picture is mirrored.
    pub seen_from: [f64; 3],
    /// Whether it is the mirror image, for those who come from behind.
    pub mirrored: bool,
}

/// An image layer of what is around the site.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneSurroundings {
    /// The image layer's place in the list.
    pub layer: usize,
    /// The convex parts, as in [`SceneUse::parts`].
    pub parts: Vec<Vec<[f64; 3]>>,
}

/// A picture of all directions.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneDome {
    /// The equirectangular picture, sRGB, in the common exposure.
    pub file: String,
    /// The unit directions of its middle, of what is to the left of that, and up.
    pub axes: [[f64; 3]; 3],
    /// The distance, in scales of the surroundings, of a photo that has the same weight.
    pub distance: f64,
}

impl ScenePhoto {
    /// Makes a photo of its camera.
    pub fn new(camera: &HandoverCamera, gain: [f64; 3]) -> Self {
        let lens = blender_lens(&camera.camera);
        Self {
            name: camera.name.clone(),
            file: camera.file.clone(),
            size: [camera.camera.width, camera.camera.height],
            lens: lens.lens,
            shift: lens.shift,
            pixel_aspect: lens.pixel_aspect,
            world_from_camera: camera.world_from_gl_camera(),
            gain,
        }
    }
}

/// Returns the texture matrix of a rectangle of a photo: rows ((fx r1 + (cx - x) r3) / w, (fy r2 + (cy - y) r3) / h, r3) of `[R|t]`.
pub fn uv_from_world(camera: &Pinhole, pose: &Pose, rect: PixelRect) -> [[f64; 4]; 3] {
    let rows = pose.rotation.transpose();
    let row = |r: DVec3, t: f64| r.extend(t);
    let [r1, r2, r3] = [
        row(rows.x_axis, pose.translation.x),
        row(rows.y_axis, pose.translation.y),
        row(rows.z_axis, pose.translation.z),
    ];
    let u = (r1 * camera.fx + r3 * (camera.cx - f64::from(rect.x))) / f64::from(rect.w);
    let v = (r2 * camera.fy + r3 * (camera.cy - f64::from(rect.y))) / f64::from(rect.h);
    [u, v, r3].map(|row: DVec4| row.to_array())
}

/// Returns the texture matrix on a billboard's rectangle that faces the photo: the columns of `rows` applied to the direction
/// `across` it, to its `axis`, and to its `foot`.
pub fn uv_from_place(rows: [[f64; 4]; 3], foot: DVec3, axis: DVec3, across: DVec3) -> [[f64; 3]; 3] {
    rows.map(|row| {
        let row = DVec4::from_array(row);
        [row.dot(across.extend(0.0)), row.dot(axis.extend(0.0)), row.dot(foot.extend(1.0))]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DVec2};
    use quadratura_base::scene::impostor::{Facing, Impostor};

    fn camera() -> (Pinhole, Pose) {
        let camera = Pinhole { width: 640, height: 480, fx: 500.0, fy: 510.0, cx: 300.0, cy: 260.0 };
        (camera, Pose { rotation: DMat3::from_rotation_y(0.4), translation: DVec3::new(0.5, -0.2, 2.0) })
    }

    /// u and v by a texture matrix.
    fn uv<const N: usize>(rows: [[f64; N]; 3], point: [f64; N]) -> DVec2 {
        let [u, v, q] = rows.map(|row| row.iter().zip(point).map(|(a, b)| a * b).sum::<f64>());
        DVec2::new(u / q, v / q)
    }

    #[test]
    fn a_texture_matrix_gives_the_place_in_the_rectangle_where_the_photo_shows_the_point() {
        let (camera, pose) = camera();
        let rect = PixelRect { x: -20, y: 40, w: 256, h: 512 };
        let point = DVec3::new(0.3, 0.7, 5.0);
        let px = camera.image_from_camera(pose.camera_from_world(point)).unwrap();
        let expected = (px - DVec2::new(-20.0, 40.0)) / DVec2::new(256.0, 512.0);
        let found = uv(uv_from_world(&camera, &pose, rect), point.extend(1.0).to_array());
        // Rounding of f64 alone.
        assert!(found.distance(expected) < 1e-12, "{found} {expected}");
    }

    #[test]
    fn a_place_on_a_billboard_has_the_texture_of_its_point_on_the_rectangle_that_faces_the_photo() {
        let (camera, pose) = camera();
        let tree = Impostor { foot: DVec3::new(1.0, 0.2, 6.0), axis: DVec3::Y, height: 3.0, half_width: 1.0 };
        let facing = Facing::of_pose(&pose);
        let rows = uv_from_world(&camera, &pose, PixelRect { x: 0, y: 0, w: 512, h: 512 });
        let place = DVec2::new(-0.4, 1.7);
        let on_place = uv_from_place(rows, tree.foot, tree.axis, tree.across(&facing));
        let expected = uv(rows, tree.point(&facing, place).extend(1.0).to_array());
        assert!(uv(on_place, [place.x, place.y, 1.0]).distance(expected) < 1e-12);
    }
}
