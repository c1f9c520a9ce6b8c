//! Views of plants, without a project.

use std::f64::consts::TAU;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use glam::{DAffine3, DMat3, DVec3};
use serde::Serialize;

use quadratura_base::error::Result;
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::{Model, Site};
use quadratura_base::task::Task;
use quadratura_foliage::{
    Caster, FlakeOptions, ImageCost, Jump, LayeredOptions, Openness, OutdoorLight, PictureSimilarity, Plant,
    PlantImages, Shades, Shadow, SunShade, View, draw, draw_flakes, draw_layered, draw_shaded, jump,
    similarity,
};
use quadratura_sites::views::{RequestedView, RequestedViews, Size, ViewRequest, ViewSource, views};
use quadratura_view::Picture;

/// The number of views around a plant.
const AROUND: u32 = 8;
/// The side of their pictures in pixels.
const SIDE_PX: u32 = 600;
/// The angle of view in degrees across the shorter side of a picture, which the plant's ball fills.
const FIELD: f64 = 40.0;
/// How far above the horizontal they look from, in degrees.
const ABOVE: f64 = 8.0;

/// Where views of a plant come from.
#[derive(Debug, Clone, PartialEq)]
pub enum PlantViews {
    /// A ring around the plant that shows all of it: eight views, called by their angles in degrees.
    Orbit,
    /// A file or folder of cameras, or a camera path, in the plant's frame and unit.
    At(PathBuf),
}

/// Returns the requested views of a plant.
///
/// # Errors
/// Those of [`views`].
pub fn plant_views(
    plant: &Plant,
    from: &PlantViews,
    size: Size,
    fps: Option<f64>,
    task: &Task,
) -> Result<RequestedViews> {
    match from {
        PlantViews::Orbit => Ok(RequestedViews { list: orbit(plant, size), ..RequestedViews::default() }),
        PlantViews::At(path) => {
            let nobody = Site { photos: Vec::new(), model: Arc::new(Model::default()) };
            views(&nobody, &ViewRequest { source: ViewSource::At(path.clone()), size, fps }, task)
        }
    }
}

/// Returns views around a plant, at equal steps against the clock as seen from above.
fn orbit(plant: &Plant, size: Size) -> Vec<RequestedView> {
    let [width, height] = match size {
        Size::Own => [SIDE_PX; 2],
        Size::Exactly(width, height) => [width, height],
        Size::Scaled(factor) => [(factor * f64::from(SIDE_PX)).round().max(1.0) as u32; 2],
    };
    let half = (0.5 * FIELD).to_radians();
    let focal = 0.5 * f64::from(width.min(height)) / half.tan();
    let (cx, cy) = (0.5 * f64::from(width), 0.5 * f64::from(height));
    let camera = Pinhole { width, height, fx: focal, fy: focal, cx, cy };
    let (up, ball) = (plant.up, plant.whole().bounds.ball);
    let x = (DVec3::X - DVec3::X.dot(up) * up).try_normalize().unwrap_or(DVec3::Y);
    let (rise, level) = ABOVE.to_radians().sin_cos();
    let view = |number: u32| {
        let angle = TAU * f64::from(number) / f64::from(AROUND);
        let outwards = level * (angle.cos() * x + angle.sin() * up.cross(x)) + rise * up;
        let eye = ball.middle + ball.radius / half.sin() * outwards;
        let (forward, right) = (-outwards, (-outwards).cross(up).normalize());
        let rotation = DMat3::from_cols(right, forward.cross(right), forward).transpose();
        let pose = Pose { rotation, translation: -(rotation * eye) };
        RequestedView { name: format!("orbit-{:03}", number * 360 / AROUND), camera, pose, photo: None }
    };
    (0..AROUND).map(view).collect()
}

/// How views of a plant are drawn.
#[derive(Debug, Clone, PartialEq)]
pub enum PlantMethod {
    /// Every polygon of every instance.
    Polygons,
    /// From the images of its sub-objects, in layered pixels.
    Layers(PlantImages, LayeredOptions),
    /// From the images of its sub-objects, texel by texel.
    Texels(PlantImages, FlakeOptions),
}

/// A view beside brute force.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ViewComparison {
    /// The name of the view.
    pub view: String,
    /// How like it is; `None` where the plant is not in view.
    pub similarity: Option<PictureSimilarity>,
    /// The seconds that brute force took for it, over those that the method took.
    pub speedup: f64,
    /// What it changes by since the frame before that brute force does not change by; `None` for views that are no frames, and for the first.
    pub jump: Option<Jump>,
}

/// Draws views of a plant by day.
pub struct PlantDrawing<'a> {
    plant: &'a Plant,
    method: PlantMethod,
    light: OutdoorLight,
    shades: Option<(Shadow, Openness)>,
    /// The triangles that were projected so far, without those of comparisons.
    pub triangles: u64,
    /// What pictures from images cost so far.
    pub layered: ImageCost,
    /// The views that were compared so far; `None` where none shall be.
    pub compared: Option<Vec<ViewComparison>>,
    /// Whether views are the frames of a flight.
    is_flight: bool,
    /// The last frame that was compared: by brute force, and as it was drawn.
    before: Option<[Picture; 2]>,
}

impl<'a> PlantDrawing<'a> {
    /// Prepares the drawing of a plant, without shadows. `towards_sun` is in the plant's frame, of any finite length but 0; without it the
    /// sun is that of [`OutdoorLight::day`].
    pub fn new(plant: &'a Plant, method: PlantMethod, towards_sun: Option<DVec3>, compares: bool) -> Self {
        let day = OutdoorLight::day(plant.up);
        Self {
            plant,
            method,
            light: OutdoorLight { towards_sun: towards_sun.map_or(day.towards_sun, DVec3::normalize), ..day },
            shades: None,
            triangles: 0,
            layered: ImageCost::default(),
            compared: compares.then(Vec::new),
            is_flight: false,
            before: None,
        }
    }

    /// Returns the direction to the sun, of length 1, in the plant's frame.
    pub fn towards_sun(&self) -> DVec3 {
        self.light.towards_sun
    }

    /// Takes views as the frames of a flight, so that comparisons tell of jumps, too.
    pub fn with_frames(mut self) -> Self {
        self.is_flight = true;
        self
    }

    /// Prepares the same with the plant's shadows on itself: the sun's, and what its crown keeps from sky and ground. Pictures from
    /// images have none.
    ///
    /// # Errors
    /// Those of [`Self::picture`].
    pub fn with_shadows(mut self, task: &Task) -> Result<Self> {
        // A plant of nothing is refused when it is drawn.
        if self.plant.whole().counts.triangles > 0 {
            let quiet = Task::silent().with_stop_flag(task.stop_flag());
            let itself = Caster { plant: self.plant, frame_from_plant: DAffine3::IDENTITY };
            let ball = &self.plant.whole().bounds.ball;
            let shadow = Shadow::cast(&[itself], ball, self.light.towards_sun, &quiet)?;
            self.shades = Some((shadow, Openness::bake(self.plant, &quiet)?));
        }
        Ok(self)
    }

    /// Draws a view.
    ///
    /// # Errors
    /// Those of [`draw_shaded`].
    pub fn picture(&mut self, requested: &RequestedView, task: &Task) -> Result<Picture> {
        let view = View::perspective(requested.camera, &requested.pose, &self.plant.whole().bounds.ball);
        let began = Instant::now();
        let picture = match &self.method {
            PlantMethod::Polygons => {
                let shades = self.shades.as_ref().map(|(shadow, openness)| Shades {
                    sun: SunShade::Shadow { shadow, frame_from_plant: DAffine3::IDENTITY },
                    openness,
                });
                let drawing = draw_shaded(self.plant, &view, &self.light, shades.as_ref(), task)?;
                self.triangles += drawing.triangles;
                drawing.picture
            }
            PlantMethod::Layers(images, options) => {
                let drawn = draw_layered(self.plant, images, &view, &self.light, options, task)?;
                self.counted(drawn)
            }
            PlantMethod::Texels(images, options) => {
                let drawn = draw_flakes(self.plant, images, &view, &self.light, options, task)?;
                self.counted(drawn)
            }
        };
        let seconds = began.elapsed().as_secs_f64();
        if let Some(compared) = &mut self.compared {
            let began = Instant::now();
            let truth = task.timed("brute force", || draw(self.plant, &view, &self.light, task))?.picture;
            let speedup = began.elapsed().as_secs_f64() / seconds.max(f64::MIN_POSITIVE);
            let similarity = similarity(&truth, &picture);
            let frame = [truth, picture.clone()];
            let before = self
                .before
                .as_ref()
                .filter(|of| of[0].width == picture.width && of[0].height == picture.height);
            let jump = before.and_then(|of| jump([&of[0], &frame[0]], [&of[1], &frame[1]]));
            compared.push(ViewComparison { view: requested.name.clone(), similarity, speedup, jump });
            self.before = self.is_flight.then_some(frame);
        }
        Ok(picture)
    }

    /// Adds up what a picture from images cost.
    fn counted(&mut self, (picture, cost): (Picture, ImageCost)) -> Picture {
        self.layered += cost;
        self.triangles += cost.triangles;
        picture
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use quadratura_foliage::files::read_plant;

    #[test]
    fn views_around_a_plant_show_all_of_it_upright_in_any_shape_of_picture() {
        let plant = read_plant(Path::new("maple"), None, &Task::silent()).unwrap();
        for size in [Size::Own, Size::Exactly(120, 40), Size::Exactly(40, 120), Size::Scaled(0.1)] {
            let views = plant_views(&plant, &PlantViews::Orbit, size, None, &Task::silent()).unwrap().list;
            assert_eq!((views.len(), views[1].name.as_str()), (8, "orbit-045"));
            let space = plant.whole().bounds.space;
            for view in views {
                let camera = view.camera;
                for z in [space.low.z, space.high.z] {
                    let point = DVec3::new(0.0, 0.0, z);
                    let px = camera.image_from_camera(view.pose.camera_from_world(point)).unwrap();
                    assert!(px.x > 0.0 && px.x < f64::from(camera.width), "{size:?}: {px}");
                    assert!(px.y > 0.0 && px.y < f64::from(camera.height), "{size:?}: {px}");
                }
                assert!((view.pose.rotation * plant.up).y < -0.9, "up is up in the picture");
            }
        }
    }
}
