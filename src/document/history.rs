//! The undo history of the document. It is pure: snapshots are shared, and nothing is read or written.

use std::collections::VecDeque;
use std::ops::RangeBounds;
use std::path::PathBuf;
use std::sync::Arc;

use super::Project;
use super::masks::{Mask, MaskChange, MaskOrigin};
use super::model_change::ModelChange;
use super::paint::ImportedMask;
use super::stroke::Stroke;

/// The most steps that can be undone.
pub const MOST_STEPS: usize = 1000;

/// The authored project over time: one named step per gesture. Undone steps can be redone until another edit is
/// made.
#[derive(Debug, Clone)]
pub struct History {
    /// The steps, oldest first; the last `undone` of them are undone.
    steps: VecDeque<Step>,
    /// The number of steps at the end that are undone.
    undone: usize,
    present: Arc<Project>,
    /// The project as saved; it need not be at any step.
    saved: Arc<Project>,
    /// The gesture that may still extend the last step.
    gesture: Option<Gesture>,
}

/// An id that combines the edits of one drag or one stretch of typing into one step. The editing code chooses it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Gesture(pub u64);

/// A step of the history.
#[derive(Debug, Clone)]
struct Step {
    /// The step's name, such as `merge of 3 layers`.
    name: String,
    change: StepChange,
}

/// The change that a step made.
#[derive(Debug, Clone)]
enum StepChange {
    /// The project changed, from `before` to `after`.
    Project { before: Arc<Project>, after: Arc<Project> },
    /// Paint was imported from these files, and masks with it. The number changes when the files are imported
    /// again.
    Import { number: u32, files: Vec<PathBuf>, masks: Vec<MaskChange> },
    /// A stroke of the brush was painted, as an import with this number, which changes when it is painted again.
    Stroke { number: u32, stroke: Box<Stroke> },
    /// The model's file was written.
    Model(ModelChange),
}

impl StepChange {
    /// Returns the number of the import, or of the stroke.
    fn import(&self) -> Option<u32> {
        match self {
            Self::Project { .. } | Self::Model(_) => None,
            Self::Import { number, .. } | Self::Stroke { number, .. } => Some(*number),
        }
    }
}

/// The result of undoing or redoing a step, and what the caller has to do.
#[derive(Debug, Clone, PartialEq)]
pub enum StepResult {
    /// [`History::present`] is another project; nothing remains to be done.
    Project,
    /// The caller undoes the import with this number and reports it with [`History::import_undone`].
    /// [`crate::paint::PaintBook::take_back`] undoes the last import; where that is another one, or none
    /// is left, the step cannot be undone, and the caller calls [`History::forget_import`].
    TakeBack(u32),
    /// The caller imports these files again, in their present state, and reports the new number with
    /// [`History::import_redone`]. The number given here is that of the undone import.
    ImportAgain(u32, Vec<PathBuf>),
    /// The caller paints this stroke again, and reports the new number with [`History::import_redone`]. The number
    /// given here is that of the undone import.
    PaintAgain(u32, Box<Stroke>),
    /// The caller writes the model's file, if that holds what it held before this change; otherwise it calls
    /// [`History::forget_model_change`].
    WriteModel(ModelChange),
}

impl History {
    /// Starts a history with a project as it is on disk.
    pub fn new(project: Project) -> Self {
        let present = Arc::new(project);
        Self { steps: VecDeque::new(), undone: 0, saved: present.clone(), present, gesture: None }
    }

    /// Returns the present project.
    pub fn present(&self) -> &Arc<Project> {
        &self.present
    }

    /// Records an edit as a step. Consecutive edits of one gesture make one step with the first edit's name; a
    /// gesture that ends where it began leaves no step, nor does an edit without effect.
    pub fn edit(&mut self, name: impl Into<String>, project: Project, gesture: Option<Gesture>) {
        let continues = gesture.is_some() && self.gesture == gesture && self.undone == 0;
        if *self.present == project {
            return;
        }
        let after = Arc::new(project);
        let open = if continues { self.steps.back_mut() } else { None };
        if let Some(Step { change: StepChange::Project { before, after: end }, .. }) = open {
            let nothing = **before == *after;
            *end = after.clone();
            // The same snapshot, so that it is recognised as the saved one.
            self.present = if nothing { before.clone() } else { after };
            if nothing {
                self.steps.pop_back();
                self.gesture = None;
            }
            return;
        }
        let before = std::mem::replace(&mut self.present, after.clone());
        self.push(Step { name: name.into(), change: StepChange::Project { before, after } });
        self.gesture = gesture;
    }

    /// Ends a gesture: the next edit is a step of its own.
    pub fn end_gesture(&mut self) {
        self.gesture = None;
    }

    /// Records an import as a step. The import is on disk already; in the project only the masks that came with it
    /// have changed, on disk as well.
    pub fn imported(
        &mut self,
        name: impl Into<String>,
        number: u32,
        files: Vec<PathBuf>,
        masks: Vec<MaskChange>,
    ) {
        self.set_masks(masks.iter().map(|mask| (&mask.photo, &mask.from, &mask.after)));
        self.push(Step { name: name.into(), change: StepChange::Import { number, files, masks } });
        self.gesture = None;
    }

    /// Records a stroke of the brush as a step. Its paint is on disk already.
    pub fn stroked(&mut self, name: impl Into<String>, number: u32, stroke: Stroke) {
        let stroke = Box::new(stroke);
        self.push(Step { name: name.into(), change: StepChange::Stroke { number, stroke } });
        self.gesture = None;
    }

    /// Records a change of the model's file as a step. It is on disk already.
    pub fn model_written(&mut self, name: impl Into<String>, change: ModelChange) {
        self.push(Step { name: name.into(), change: StepChange::Model(change) });
        self.gesture = None;
    }

    /// Removes the step of a change of the model's file that could not be undone or redone, as [`StepResult::WriteModel`] gave it.
    pub fn forget_model_change(&mut self, change: &ModelChange) {
        let is_it = |step: &Step| match &step.change {
            StepChange::Model(own) => own == change || own.reversed() == *change,
            _ => false,
        };
        let Some(index) = self.steps.iter().rposition(is_it) else { return };
        self.undone -= usize::from(index >= self.steps.len() - self.undone);
        self.steps.remove(index);
    }

    /// Replaces the number of an import that was redone, and the masks that came with it.
    pub fn import_redone(&mut self, old: u32, new: u32, came: Vec<MaskChange>) {
        self.set_masks(came.iter().map(|mask| (&mask.photo, &mask.from, &mask.after)));
        let Some(index) = self.index_of_import(old) else { return };
        // Later steps were made with the masks that came with the first import.
        let after = came.iter().map(|mask| (&mask.photo, &mask.from, &mask.after));
        self.rewrite(index.., |project| renumbered(&with_masks(project, after.clone()), old, new));
        match &mut self.steps[index].change {
            StepChange::Import { number, masks, .. } => (*number, *masks) = (new, came),
            StepChange::Stroke { number, .. } => *number = new,
            StepChange::Project { .. } | StepChange::Model(_) => (),
        }
    }

    /// Records that the paint of an import stays in its photo, as the project on disk says already.
    pub fn stays_in_photo(&mut self, import: u32) {
        (self.present, self.saved) = (seen_here(&self.present, import), seen_here(&self.saved, import));
        if let Some(index) = self.index_of_import(import) {
            self.rewrite(index.., |project| seen_here(project, import));
        }
    }

    /// Returns the index of the step of an import.
    fn index_of_import(&self, import: u32) -> Option<usize> {
        let is_it = |step: &Step| step.change.import() == Some(import);
        self.steps.iter().position(is_it)
    }

    /// Records that an import was undone, and that the masks it had replaced are on disk again. Where the import is
    /// not a step that can be redone, its masks are removed from all steps.
    pub fn import_undone(&mut self, import: u32, masks: &[ImportedMask]) {
        let put_back = masks.iter().map(|mask| (&mask.photo, &mask.from, &mask.before));
        self.set_masks(put_back.clone());
        // On disk its paint does not stay in its photo any more. A step that said so says it again when it is redone.
        (self.present, self.saved) = (seen_again(&self.present, import), seen_again(&self.saved, import));
        if self.index_of_import(import).is_some() {
            return;
        }
        if !masks.is_empty() {
            self.rewrite(.., |project| with_masks(project, put_back.clone()));
        }
        // A later import may get the number.
        self.rewrite(.., |project| seen_again(project, import));
    }

    /// Sets masks in the present project and in the saved one.
    fn set_masks<'a>(&mut self, masks: impl ExactSizeIterator<Item = NewMask<'a>> + Clone) {
        if masks.len() > 0 {
            self.present = with_masks(&self.present, masks.clone());
            self.saved = with_masks(&self.saved, masks);
            self.gesture = None;
        }
    }

    /// Replaces the projects before and after some steps.
    fn rewrite(&mut self, steps: impl RangeBounds<usize>, change: impl Fn(&Arc<Project>) -> Arc<Project>) {
        // Consecutive steps share the project between them, and still do afterwards.
        let mut last: Option<(Arc<Project>, Arc<Project>)> = None;
        let mut changed = |project: &mut Arc<Project>| {
            let known =
                last.as_ref().filter(|(old, _)| Arc::ptr_eq(old, project)).map(|(_, new)| new.clone());
            let new = known.unwrap_or_else(|| change(project));
            let old = std::mem::replace(project, new.clone());
            last = Some((old, new));
        };
        for step in self.steps.range_mut(steps) {
            if let StepChange::Project { before, after } = &mut step.change {
                changed(before);
                changed(after);
            }
        }
    }

    /// Removes an import from the history, because it can no longer be undone or redone. An import that is not
    /// undone remains in effect: earlier steps get its masks.
    pub fn forget_import(&mut self, number: u32) {
        let made = self.index_of_import(number).filter(|index| *index < self.steps.len() - self.undone);
        if let Some((index, StepChange::Import { masks, .. })) =
            made.map(|index| (index, self.steps[index].change.clone()))
        {
            let after = masks.iter().map(|mask| (&mask.photo, &mask.from, &mask.after));
            self.rewrite(..index, |project| with_masks(project, after.clone()));
        }
        let is_it = |step: &Step| step.change.import() == Some(number);
        let past = self.steps.len() - self.undone;
        let after = self.steps.iter().skip(past).filter(|step| is_it(step)).count();
        self.steps.retain(|step| !is_it(step));
        self.undone -= after;
    }

    /// Appends a step and drops the undone ones.
    fn push(&mut self, step: Step) {
        self.steps.truncate(self.steps.len() - self.undone);
        self.undone = 0;
        self.steps.push_back(step);
        if self.steps.len() > MOST_STEPS {
            self.steps.pop_front();
        }
    }

    /// Returns the name of the step that [`Self::undo`] would undo.
    pub fn undoes(&self) -> Option<&str> {
        let index = self.steps.len().checked_sub(self.undone + 1)?;
        Some(&self.steps[index].name)
    }

    /// Returns the number of the import, or of the stroke, that [`Self::undo`] would undo.
    pub fn undoes_import(&self) -> Option<u32> {
        let index = self.steps.len().checked_sub(self.undone + 1)?;
        self.steps[index].change.import()
    }

    /// Returns the name of the step that [`Self::redo`] would redo.
    pub fn redo_name(&self) -> Option<&str> {
        Some(&self.steps.get(self.steps.len() - self.undone)?.name)
    }

    /// Returns the names of all steps, oldest first, and the number of them that are done.
    pub fn names(&self) -> (impl ExactSizeIterator<Item = &str>, usize) {
        (self.steps.iter().map(|step| step.name.as_str()), self.steps.len() - self.undone)
    }

    /// Undoes the last step; `None` when there is none.
    pub fn undo(&mut self) -> Option<StepResult> {
        let index = self.steps.len().checked_sub(self.undone + 1)?;
        self.undone += 1;
        self.gesture = None;
        Some(match &self.steps[index].change {
            StepChange::Project { before, .. } => {
                self.present = before.clone();
                StepResult::Project
            }
            StepChange::Import { number, .. } | StepChange::Stroke { number, .. } => {
                StepResult::TakeBack(*number)
            }
            StepChange::Model(change) => StepResult::WriteModel(change.reversed()),
        })
    }

    /// Redoes the step that was undone last; `None` when there is none.
    pub fn redo(&mut self) -> Option<StepResult> {
        let index = self.steps.len() - self.undone;
        let step = self.steps.get(index)?;
        self.undone -= 1;
        self.gesture = None;
        Some(match &step.change {
            StepChange::Project { after, .. } => {
                self.present = after.clone();
                StepResult::Project
            }
            StepChange::Import { number, files, .. } => StepResult::ImportAgain(*number, files.clone()),
            StepChange::Stroke { number, stroke } => StepResult::PaintAgain(*number, stroke.clone()),
            StepChange::Model(change) => StepResult::WriteModel(change.clone()),
        })
    }

    /// Returns the project as it was last known to be on disk.
    pub fn on_disk(&self) -> &Project {
        &self.saved
    }

    /// Records that the present project is on disk.
    pub fn saved(&mut self) {
        self.saved = self.present.clone();
        // A new gesture, so that the saved state can be reached by undoing.
        self.gesture = None;
    }

    /// Returns true when the present project differs from the saved one. Steps that lead back to the saved state
    /// make the project clean again.
    pub fn is_dirty(&self) -> bool {
        !Arc::ptr_eq(&self.present, &self.saved) && self.present != self.saved
    }
}

/// A photo, the origin of a mask, and the mask, or `None` where it is removed.
type NewMask<'a> = (&'a String, &'a MaskOrigin, &'a Option<Mask>);

/// Returns a project in which the paint of an import stays in its photo.
fn seen_here(project: &Arc<Project>, import: u32) -> Arc<Project> {
    if project.fill.only_here.imports.contains(&import) {
        return project.clone();
    }
    let mut changed = Project::clone(project);
    changed.fill.only_here.imports.insert(import);
    Arc::new(changed)
}

/// Returns a project in which the paint of an import does not stay in its photo.
fn seen_again(project: &Arc<Project>, import: u32) -> Arc<Project> {
    if !project.fill.only_here.imports.contains(&import) {
        return project.clone();
    }
    let mut changed = Project::clone(project);
    changed.fill.only_here.imports.remove(&import);
    Arc::new(changed)
}

/// Returns a project in which what was said of import `old` is said of `new`.
fn renumbered(project: &Arc<Project>, old: u32, new: u32) -> Arc<Project> {
    if old == new || !project.fill.only_here.imports.contains(&old) {
        return project.clone();
    }
    let mut changed = Project::clone(project);
    changed.fill.only_here.imports.remove(&old);
    changed.fill.only_here.imports.insert(new);
    Arc::new(changed)
}

/// Returns the project with these masks, or the same snapshot where it has them already.
fn with_masks<'a>(project: &Arc<Project>, masks: impl Iterator<Item = NewMask<'a>>) -> Arc<Project> {
    let mut changed = project.masks.clone();
    masks.for_each(|(photo, from, mask)| changed.set(photo, from, mask.clone()));
    match changed == project.masks {
        true => project.clone(),
        false => Arc::new(Project { masks: changed, ..Project::clone(project) }),
    }
}

#[cfg(test)]
mod tests;
