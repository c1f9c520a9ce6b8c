//! The command `score`: photos are predicted from others and compared with themselves.
//!
//! Pixels are counted in two ways. *Covered* counts only predicted pixels, which tells how good these are. *With
//! holes* counts all pixels, black where nothing was predicted, so that leaving out difficult ones gains nothing.
//! Ignored objects are excluded from both.

mod one;
mod picture;
mod questions;
mod report;

#[cfg(test)]
mod tests;

use std::path::PathBuf;

pub use questions::{Question, held_out, leave_one_out};
pub use report::{MeanMetrics, MeanScore, ObjectScore, ScoreReport, ViewScore};

use self::one::Scorer;
use super::render::Appearance;
use super::unknown_name::no_such;
use super::views::Size;
use crate::document::names::picture_names;
use crate::error::{Error, Remedy, Result};
use crate::io::picture_png::make_folder;
use crate::projection::Renders;
use crate::projection::metrics::ErrorSum;
use crate::scene::Model;
use crate::task::Task;

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
    /// The objects whose pixels are ignored: names, or beginnings of names followed by `*`.
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
            ignored: Vec::new(),
            ignore_background: false,
            pictures: None,
        }
    }
}

/// Predicts photos and compares them. An error in one photo is in [`ScoreReport::failed`] and does not stop the
/// others.
///
/// # Errors
/// Returns [`Error::Request`] for an ignored object that the model does not have, [`Error::Io`] when the folder of
/// the pictures cannot be created, or [`Error::Cancelled`].
pub fn score(
    model: &Model,
    questions: &[Question],
    renders: &mut dyn Renders,
    options: &ScoreOptions,
    task: &Task,
) -> Result<ScoreReport> {
    let scorer = Scorer { ignored: ignored(model, options)?, model, options };
    if let Some(folder) = &options.pictures {
        make_folder(folder)?;
    }
    let mut tallies = vec![ErrorSum::default(); model.objects.len() + 1];
    let mut report = ScoreReport::default();
    let names: Vec<&str> = questions.iter().map(|question| question.photo.name.as_str()).collect();
    for ((done, question), stem) in (0..).zip(questions).zip(picture_names(&names)) {
        task.step(STAGE, done, questions.len() as u64)?;
        match scorer.score(question, &stem, renders, &task.with_subject(&question.photo.name)) {
            Ok((view, of_objects)) => {
                report.views.push(view);
                tallies.iter_mut().zip(of_objects).for_each(|(sum, tally)| *sum += tally);
            }
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => report.failed.push((question.photo.name.clone(), error)),
        }
    }
    task.step(STAGE, questions.len() as u64, questions.len() as u64)?;
    report.mean = MeanScore::from_views(&report.views);
    report.objects = report::objects(model, &tallies);
    Ok(report)
}

/// Returns for each object whether it is ignored, and last whether the background is.
fn ignored(model: &Model, options: &ScoreOptions) -> Result<Vec<bool>> {
    let mut ignored = vec![false; model.objects.len() + 1];
    let mut unknown = Vec::new();
    for pattern in &options.ignored {
        let is_meant = |name: &str| match pattern.strip_suffix('*') {
            Some(beginning) => name.starts_with(beginning),
            None => name == pattern,
        };
        let meant: Vec<usize> =
            (0..model.objects.len()).filter(|&object| is_meant(&model.objects[object].name)).collect();
        if meant.is_empty() {
            let known = model.objects.iter().map(|object| object.name.as_str());
            unknown.push(no_such("object", pattern, known, Some(Remedy::ListObjects)));
        }
        meant.into_iter().for_each(|object| ignored[object] = true);
    }
    ignored[model.objects.len()] = options.ignore_background;
    Error::of_all(unknown).map_or(Ok(ignored), Err)
}
