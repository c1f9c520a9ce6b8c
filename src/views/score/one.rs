//! Prediction and comparison of one photo.

use super::mask::{ComparedObjects, objects_in_view};
use super::picture::{self, Panels};
use super::{PredictionTarget, STAGE_COMPARE, STAGE_DRAW, STAGE_READ, ScoreOptions, ViewScore};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Model;
use quadratura_base::task::Task;
use quadratura_io::reference::{Reference, reference};
use quadratura_io::unmasked::read_unmasked;
use quadratura_projection::Renders;
use quadratura_view::metrics::{ErrorSum, ImageMetrics, ImagePair};
use quadratura_view::{DisplayMode, Exposure, Picture, Shot};

/// The inputs that all photos of a score share.
pub(super) struct Scorer<'a> {
    pub model: &'a Model,
    pub options: &'a ScoreOptions,
    /// The objects whose pixels are compared.
    pub compared: ComparedObjects,
}

/// The pixels of one comparison.
pub(super) struct ComparedPixels {
    pub reference: Reference,
    pub picture: Picture,
    /// The predicted colours as RGB, meaningless where nothing was predicted.
    pub predicted: Vec<u8>,
    /// The prediction over black as RGB.
    pub over_black: Vec<u8>,
    /// The object or tree at each pixel, or the number of these where there is none.
    pub objects: Vec<u32>,
    /// Whether each pixel is compared: not ignored, and valid in the photo.
    pub asked: Vec<bool>,
    /// Whether each pixel is compared and predicted.
    pub covered: Vec<bool>,
}

impl Scorer<'_> {
    /// Scores one photo and returns tallies by object, the last one for the background. The picture is `STEM.png`,
    /// if pictures are requested. Returns `None` where the photo shows none of the objects that alone are compared.
    ///
    /// # Errors
    /// Returns the errors of drawing and of reading the photo, or [`Error::Request`] when no pixel is left to
    /// compare.
    pub fn score(
        &self,
        target: &PredictionTarget,
        stem: &str,
        renders: &mut dyn Renders,
        task: &Task,
    ) -> Result<Option<(ViewScore, Vec<ErrorSum>)>> {
        let pixels = self.pixels(target, renders, task)?;
        if !self.options.only.is_empty() && !pixels.asked.contains(&true) {
            task.note(format!("the photo shows nothing of {}", self.options.only.join(", ")));
            return Ok(None);
        }
        task.timed(STAGE_COMPARE, || {
            let mut score = view_score(&target.photo.name, &pixels)?;
            if let Some(folder) = &self.options.pictures {
                score.picture = Some(picture::write(folder, stem, &Panels::from_pixels(&pixels), task)?);
            }
            Ok(Some((score, self.tallies(&pixels))))
        })
    }

    /// Returns the shot that predicts the photo.
    fn shot(&self, target: &PredictionTarget) -> Shot {
        let photo = &target.photo;
        let camera = self.options.size.resize(&photo.camera);
        let mut shot = self.options.look.shot(camera, photo.pose);
        shot.without.extend(&target.without);
        shot.display = DisplayMode::Colour;
        let taken = photo.exposure.and_then(|exposure| exposure.log());
        if let Some(log) = taken.filter(|_| shot.exposure == Exposure::Decided) {
            shot.exposure = Exposure::AsTaken(log);
        }
        shot
    }

    /// Draws the prediction while the photo is read on another thread.
    fn pixels(
        &self,
        target: &PredictionTarget,
        renders: &mut dyn Renders,
        task: &Task,
    ) -> Result<ComparedPixels> {
        let shot = self.shot(target);
        let photo = &target.photo;
        let (width, height) = (shot.camera.width, shot.camera.height);
        let read = || {
            let photo = read_unmasked(photo)?;
            Ok(reference(&photo, width, height))
        };
        let (reference, picture, objects) = std::thread::scope(|scope| {
            let reference = scope.spawn(|| task.timed(STAGE_READ, read));
            let drawn = task.timed(STAGE_DRAW, || {
                let picture = renders.picture(&shot, task)?;
                Ok((
                    picture,
                    objects_in_view(self.model, &shot, renders, self.compared.count() as u32 - 1, task)?,
                ))
            });
            let reference = reference.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            drawn.and_then(|(picture, objects)| Ok((reference?, picture, objects)))
        })?;
        Ok(self.classified(reference, picture, objects))
    }

    /// Determines which pixels are compared.
    fn classified(&self, reference: Reference, picture: Picture, objects: Vec<u32>) -> ComparedPixels {
        let asked: Vec<bool> = objects
            .iter()
            .zip(&reference.valid)
            .map(|(&object, valid)| *valid && self.compared.contains(object))
            .collect();
        let (rgba, _) = picture.rgba.as_chunks::<4>();
        let covered = rgba.iter().zip(&asked).map(|(pixel, asked)| *asked && pixel[3] > 0).collect();
        let predicted = rgba.iter().flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        ComparedPixels {
            over_black: picture.over([0; 3]),
            reference,
            picture,
            predicted,
            objects,
            asked,
            covered,
        }
    }

    /// Sums the errors by object.
    fn tallies(&self, pixels: &ComparedPixels) -> Vec<ErrorSum> {
        let mut tallies = vec![ErrorSum::default(); self.compared.count()];
        let (truth, _) = pixels.reference.rgb.as_chunks::<3>();
        let (predicted, _) = pixels.predicted.as_chunks::<3>();
        for (i, _) in pixels.asked.iter().enumerate().filter(|(_, asked)| **asked) {
            let tally = &mut tallies[pixels.objects[i] as usize];
            if pixels.covered[i] {
                tally.add(truth[i], predicted[i]);
            } else {
                tally.holes += 1;
            }
        }
        tallies
    }
}

/// Computes the score of one photo.
fn view_score(photo: &str, pixels: &ComparedPixels) -> Result<ViewScore> {
    let Picture { width, height, .. } = pixels.picture;
    let compared = |predicted| ImagePair { width, height, truth: &pixels.reference.rgb, predicted };
    let covered = ImageMetrics::new(&compared(&pixels.predicted), &pixels.covered, &pixels.covered);
    let with_holes = ImageMetrics::new(&compared(&pixels.over_black), &pixels.asked, &pixels.covered);
    let with_holes =
        with_holes.ok_or_else(|| Error::Request("no pixels are left to compare: all are ignored".into()))?;
    Ok(ViewScore {
        photo: photo.to_owned(),
        width,
        height,
        coverage: covered.map_or(0, |metrics| metrics.pixels) as f64 / with_holes.pixels as f64,
        covered,
        with_holes,
        picture: None,
    })
}
