//! Strokes of the brush in the 3D view: each becomes paint in the background, one after the other.

use std::sync::Arc;

use crate::state::State;
use crate::state::running::JobKind;
use crate::state::space::brush::DrawnStroke;
use crate::work::Work;
use quadratura_document::stroke::Stroke;
use quadratura_editing::stroke::{StrokeOptions, apply};

/// Starts the first stroke that waits, unless paint is being changed.
pub fn paint_strokes(state: &mut State, work: &mut Work) {
    if state.running.runs(JobKind::Import) || state.session.is_none() {
        return;
    }
    if state.space.brush.is_painting {
        // Its job has ended without a result, by a fault that a message reports.
        let first = state.space.brush.waiting.front().cloned();
        first.into_iter().for_each(|first| drop(state.space.brush.take_ended(&first)));
    }
    let Some(drawn) = state.space.brush.waiting.front().cloned() else { return };
    state.space.brush.is_painting = true;
    paint(state, work, drawn, None);
}

/// Redoes a stroke that was undone.
pub fn paint_again(state: &mut State, work: &mut Work, number: u32, stroke: &Stroke) {
    let drawn = DrawnStroke { viewpoint: state.space.viewpoint, stroke: stroke.clone() };
    paint(state, work, Arc::new(drawn), Some(number));
}

/// Undoes the last stroke, where it has not become paint yet; returns whether there was one.
pub fn undo_stroke(state: &mut State, work: &mut Work) -> bool {
    let brush = &mut state.space.brush;
    if brush.give_up() {
        return true;
    }
    let waits = brush.waiting.len() > usize::from(brush.is_painting);
    if waits {
        brush.waiting.pop_back();
    } else if brush.is_painting {
        // It is stopped, and not seen any more. It may be on disk already: then it is undone as soon as it is a step of the
        // history.
        brush.is_undone = true;
        work.jobs.stop_kind(&mut state.running, JobKind::Import);
        // Asked for once more, the steps before it are undone as well.
        let done = state.session.as_ref().map(|session| session.history.names().1);
        state.dialogs.history_target =
            state.dialogs.history_target.map(|target| target.saturating_sub(1)).or(done);
    }
    waits || state.space.brush.is_painting
}

fn paint(state: &mut State, work: &mut Work, drawn: Arc<DrawnStroke>, again: Option<u32>) {
    let Some(session) = &state.session else { return };
    let (folder, opened, lock) = (session.folder.clone(), session.opened.clone(), session.lock.clone());
    let (turn, look) = (work.live.paint.clone(), state.space.look.clone());
    work.jobs.start(&mut state.running, JobKind::Import, "Painting a stroke", move |task| {
        let _turn = turn.take();
        let options = StrokeOptions { without_stack_notes: true, ..StrokeOptions::default() };
        let done = apply(&folder, &opened.project, &opened.site, &drawn.stroke, &look, options, task);
        drop(lock);
        Ok(Box::new(move |state| state.stroke_came(&folder, &drawn, done, again)))
    });
}
