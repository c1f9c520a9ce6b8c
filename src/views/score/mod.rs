//! The command `score`: photos are predicted from others and compared with themselves.
//!
//! Pixels are counted in two ways. *Covered* counts only predicted pixels, which tells how good these are. *With
//! holes* counts all pixels, black where nothing was predicted, so that leaving out difficult ones gains nothing.
//! Ignored objects are excluded from both.

mod mask;
mod one;
mod picture;
mod report;
mod targets;

#[cfg(test)]
mod tests;

use std::path::PathBuf;

pub use report::{MeanMetrics, MeanScore, ObjectScore, ScoreReport, ViewScore};
pub use targets::{PredictionTarget, held_out, leave_one_out};

use self::mask::ComparedObjects;
use self::one::Scorer;
use crate::render::Appearance;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Model;
use quadratura_base::task::Task;
use quadratura_document::names::picture_names;
use quadratura_io::picture_png::make_folder;
use quadratura_projection::Renders;
use quadratura_sites::views::Size;
use quadratura_view::metrics::ErrorSum;

/// The stage that is reported for predicting one photo.
pub const STAGE_DRAW: &str = "predict";
/// The stage that is reported for reading and reducing one photo.
pub const STAGE_READ: &str = "read and reduce photo";
/// The stage that is reported for comparing one photo.
pub const STAGE_COMPARE: &str = "compare";
/// The stage that is reported for all photos together.
pub const STAGE: &str = "score";

/// Options of [`score`].
#[derive(Debug, Clone, PartialEq)]
pub struct ScoreOptions {
    /// The appearance of predictions. Colours are displayed in any case, and the predicted photo is never used.
    pub look: Appearance,
    /// The size at which photos are compared.
    pub size: Size,
    /// The objects whose pixels alone are compared: names, or patterns in which `*` stands for any characters; all pixels
    /// where there are none.
    pub only: Vec<String>,
    /// The names of the trees of the site, by number; they count as objects.
    pub trees: Vec<String>,
    /// The objects whose pixels are ignored, as in `only`, and taken from these.
    pub ignored: Vec<String>,
    /// Whether pixels without a surface of the model are ignored, too.
    pub ignore_background: bool,
    /// The folder for pictures of the differences; `None` for no pictures.
    pub pictures: Option<PathBuf>,
}

/// All pixels of the photos in their own size, without pictures.
impl Default for ScoreOptions {
    fn default() -> Self {
        Self {
            look: Appearance::default(),
            size: Size::Own,
            only: Vec::new(),
            trees: Vec::new(),
            ignored: Vec::new(),
            ignore_background: false,
            pictures: None,
        }
    }
}

/// Predicts photos and compares them. An error in one photo is in [`ScoreReport::failed`] and does not stop the
/// others. A photo that shows none of the objects that alone are compared is noted and left out.
///
/// # Errors
/// Returns [`Error::Request`] for an object that the model does not have, or that no photo shows, [`Error::Io`] when the folder of
/// the pictures cannot be created, or [`Error::Cancelled`].
pub fn score(
    model: &Model,
    targets: &[PredictionTarget],
    renders: &mut dyn Renders,
    options: &ScoreOptions,
    task: &Task,
) -> Result<ScoreReport> {
    let scorer = Scorer { compared: ComparedObjects::new(model, options)?, model, options };
    if let Some(folder) = &options.pictures {
        make_folder(folder)?;
    }
    let mut tallies = vec![ErrorSum::default(); scorer.compared.count()];
    let mut report = ScoreReport::default();
    let mut unconcerned = 0;
    let names: Vec<&str> = targets.iter().map(|target| target.photo.name.as_str()).collect();
    for ((done, target), stem) in (0..).zip(targets).zip(picture_names(&names)) {
        task.step(STAGE, done, targets.len() as u64)?;
        match scorer.score(target, &stem, renders, &task.with_subject(&target.photo.name)) {
            Ok(Some((view, of_objects))) => {
                report.views.push(view);
                tallies.iter_mut().zip(of_objects).for_each(|(sum, tally)| *sum += tally);
            }
            Ok(None) => unconcerned += 1,
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => report.failed.push((target.photo.name.clone(), error)),
        }
    }
    task.step(STAGE, targets.len() as u64, targets.len() as u64)?;
    if unconcerned > 0 && unconcerned == targets.len() {
        return Err(Error::Request(format!("no photo shows {}", options.only.join(", "))));
    }
    report.mean = MeanScore::from_views(&report.views);
    report.objects = report::objects(scorer.compared.names(), &tallies);
    Ok(report)
}
