//! Where the images of instances are in a view.

use glam::{DAffine3, DMat3, DVec3, Mat3, Vec2, Vec3};

use super::bounds::Bounds;
use super::directions::{Directions, Serving};
use super::images::{ImageCopy, LightCorrection, PlantImages};
use super::lighting::OfSamples;
use super::plant::Plant;
use super::stipple::Stipple;
use super::view::{Projection, normal_map};
use super::walk::Drawn;
use quadratura_base::geometry::PixelRect;

/// An image of an instance in a view.
#[derive(Debug, Clone, Copy)]
pub(super) struct Instance<'a> {
    /// The directions of its images.
    pub directions: Directions,
    /// The images.
    pub copy: &'a ImageCopy,
    /// Box and ball of the sub-object, in its own frame.
    pub bounds: Bounds,
    /// The share of light that leaves let through over what they reflect.
    pub through: Vec3,
    /// The map from the sub-object's frame to the view's.
    pub view_from_object: DAffine3,
    /// A hash of the way to the instance.
    pub path: u64,
    /// The sub-pixels in which it is drawn.
    pub stipple: Stipple,
}

impl<'a> Instance<'a> {
    /// Makes an instance that is drawn by the copy of an index; `None` where its sub-object has no images.
    pub fn of(plant: &Plant, images: &'a PlantImages, drawn: &Drawn, copy: usize) -> Option<Self> {
        let Drawn { object, view_from_object, path, stipple, .. } = *drawn;
        let of = images.objects.get(object)?.as_ref()?;
        Some(Self {
            directions: images.directions,
            copy: &of.copies[copy],
            bounds: plant.objects[object].bounds,
            through: of.through,
            view_from_object,
            path,
            stipple,
        })
    }

    /// Returns the directions whose images serve in a view.
    pub fn serving(&self, projection: &Projection) -> Vec<Serving> {
        self.directions.serving(self.towards_viewer(projection))
    }

    /// Returns what the light of the samples of one of its images depends on.
    pub fn of_samples(&self, place: &ImagePlacement, direction: usize) -> OfSamples {
        let LightCorrection { gain, lengths } = &self.copy.correction;
        OfSamples {
            view_from_normal: place.view_from_normal,
            through: self.through,
            gain: *gain,
            length: lengths[direction],
        }
    }

    /// Returns the direction from the middle of its ball to the viewer, in the sub-object's frame.
    fn towards_viewer(&self, projection: &Projection) -> DVec3 {
        let object_from_view = self.view_from_object.inverse();
        let towards = match projection {
            Projection::Perspective { .. } => object_from_view.translation - self.bounds.ball.middle,
            Projection::Parallel { .. } => object_from_view.transform_vector3(-DVec3::Z),
        };
        // In the very middle of the ball no direction is nearer than another.
        if towards.length_squared() > 0.0 && towards.is_finite() { towards } else { DVec3::Z }
    }
}

/// How an image of an instance comes into a view: what is computed once for all its samples.
pub(super) struct ImagePlacement {
    /// The focal lengths in pixels, or pixels for a unit of a parallel view.
    pub focal: Vec2,
    /// True where parts shrink with distance.
    pub perspective: bool,
    /// The image point of x = y = 0.
    pub centre_px: Vec2,
    /// What the sample at (x, y, z) of the image has in the view: `linear * (x, y, z) + origin`.
    pub linear: Mat3,
    /// The middle of the ball in the view.
    pub origin: Vec3,
    /// The map of normals, times any factor.
    pub view_from_normal: Mat3,
}

impl ImagePlacement {
    /// Places the image from a direction.
    pub fn new(instance: &Instance, projection: &Projection, direction: usize) -> Self {
        let object_from_image = instance.directions.view_from_object(direction).transpose();
        let linear: DMat3 = instance.view_from_object.matrix3 * object_from_image;
        let origin = instance.view_from_object.transform_point3(instance.bounds.ball.middle);
        let (focal, centre) = match projection {
            Projection::Perspective { camera, .. } => ([camera.fx, camera.fy], [camera.cx, camera.cy]),
            Projection::Parallel { scale, centre_px, .. } => ([*scale; 2], centre_px.to_array()),
        };
        let normals = normal_map(&linear);
        // Of any length, so that it does not leave the numbers that f32 has.
        let longest = normals.to_cols_array().iter().fold(0.0f64, |most, value| most.max(value.abs()));
        Self {
            focal: Vec2::from_array(focal.map(|value| value as f32)),
            perspective: projection.is_perspective(),
            centre_px: Vec2::from_array(centre.map(|value| value as f32)),
            linear: linear.as_mat3(),
            origin: origin.as_vec3(),
            view_from_normal: (normals * (1.0 / longest.max(f64::MIN_POSITIVE))).as_mat3(),
        }
    }

    /// Returns the image point of a point of the view's frame.
    #[inline]
    pub fn image(&self, at: Vec3) -> Vec2 {
        let scale = if self.perspective { self.focal / at.z } else { self.focal };
        scale * at.truncate() + self.centre_px
    }

    /// Returns the change of the image point of `at` for a change of the point.
    #[inline]
    pub fn change(&self, at: Vec3, px: Vec2, change: Vec3) -> Vec2 {
        if self.perspective {
            (self.focal * change.truncate() - (px - self.centre_px) * change.z) / at.z
        } else {
            self.focal * change.truncate()
        }
    }

    /// Returns whether a row of an image may meet the pixels.
    pub fn row_meets(&self, y: f32, span: f32, delta: f32, rect: &PixelRect) -> bool {
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        // What a sample covers reaches less than four pixels of the image beyond its centre, leaning included.
        for (x, y, z) in [-span, span]
            .into_iter()
            .flat_map(|x| [-span, span].map(|z| (x, z)))
            .flat_map(|(x, z)| [y - 4.0 * delta, y + 4.0 * delta].map(|y| (x, y, z)))
        {
            let at = self.linear * Vec3::new(x, y, z) + self.origin;
            if self.perspective && at.z <= 0.0 {
                return true;
            }
            let px = self.image(at).y;
            (low, high) = (low.min(px), high.max(px));
        }
        high + 2.0 >= rect.y as f32 && low - 2.0 <= rect.bottom() as f32
    }
}
