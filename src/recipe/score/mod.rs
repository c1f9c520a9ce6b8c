//! `score`: photos that take no part are predicted from the others, and compared with what they show.
//!
//! Pixels are counted in two ways. *Covered*: those that were predicted, so this says how good the
//! pixels are that are there. *With holes*: all of them, black where nothing was predicted, so nothing
//! is gained by leaving out what is difficult. Ignored objects are left out of both.

mod one;
mod picture;
mod questions;
mod report;

#[cfg(test)]
mod tests;

use std::path::PathBuf;

pub use questions::{Question, held_out, leave_one_out};
pub use report::{MeanLikeness, MeanScore, ObjectScore, ScoreReport, ViewScore};

use self::one::Scorer;
use super::render::Look;
use super::views::Size;
use crate::document::names::picture_names;
use crate::error::{Error, Result};
use crate::io::picture_png::make_folder;
use crate::projection::Renders;
use crate::projection::likeness::Tally;
use crate::scene::Model;
use crate::task::Task;

/// The stages that are reported: of each photo, and of all.
pub const STAGE_DRAW: &str = "predict";
/// See [`STAGE_DRAW`].
pub const STAGE_READ: &str = "read and reduce photo";
/// See [`STAGE_DRAW`].
pub const STAGE_COMPARE: &str = "compare";
/// See [`STAGE_DRAW`].
pub const STAGE: &str = "score";

/// What `score` is asked to do.
#[derive(Debug, Clone, PartialEq)]
pub struct ScoreOptions {
    /// How photos are predicted; what is shown is the colour, and the question's photo takes no part.
    pub look: Look,
    /// The size at which they are compared.
    pub size: Size,
    /// Objects whose pixels are left out: names, or beginnings of names with `*` behind.
    pub ignored: Vec<String>,
    /// Leave out also pixels that show no surface of the model.
    pub ignore_background: bool,
    /// Where pictures of the differences go, if anywhere.
    pub pictures: Option<PathBuf>,
}

/// Predicts and compares. A fault in one photo is in [`ScoreReport::failed`], the others go on.
///
/// # Errors
/// [`Error::Request`] for an ignored object that the model does not have; [`Error::Io`] when the folder
/// of the pictures cannot be made; [`Error::Cancelled`].
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
    let mut tallies = vec![Tally::default(); model.objects.len() + 1];
    let mut report = ScoreReport::default();
    let names: Vec<&str> = questions.iter().map(|question| question.photo.name.as_str()).collect();
    for ((done, question), stem) in (0..).zip(questions).zip(picture_names(&names)) {
        task.step(STAGE, done, questions.len() as u64)?;
        match scorer.score(question, &stem, renders, &task.of(&question.photo.name)) {
            Ok((view, of_objects)) => {
                report.views.push(view);
                tallies.iter_mut().zip(of_objects).for_each(|(sum, tally)| *sum += tally);
            }
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => report.failed.push((question.photo.name.clone(), error)),
        }
    }
    task.step(STAGE, questions.len() as u64, questions.len() as u64)?;
    report.mean = MeanScore::of(&report.views);
    report.objects = report::objects(model, &tallies);
    Ok(report)
}

/// For each object whether it is left out, and last whether the background is.
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
            unknown.push(Error::Request(format!("the model has no object {pattern:?} to ignore")));
        }
        meant.into_iter().for_each(|object| ignored[object] = true);
    }
    ignored[model.objects.len()] = options.ignore_background;
    Error::of_all(unknown).map_or(Ok(ignored), Err)
}
