//! Strokes of the brush in the 3D view: each becomes paint in the background, one after the other.

use std::sync::Arc;

use crate::app::state::State;
use crate::app::state::running::JobKind;
use crate::app::state::space::brush::DrawnStroke;
use crate::app::work::Work;
use crate::document::stroke::Stroke;
use crate::recipe::stroke::{StrokeOptions, apply};

/// Starts the first stroke that waits, unless paint is being changed.
pub fn paint_strokes(state: &mut State, work: &mut Work) {
    if state.space.brush.is_painting || state.running.runs(JobKind::Import) {
        return;
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

fn paint(state: &mut State, work: &mut Work, drawn: Arc<DrawnStroke>, again: Option<u32>) {
    let Some(session) = &state.session else { return };
    let (folder, opened, lock) = (session.folder.clone(), session.opened.clone(), session.lock.clone());
    let (turn, look) = (work.live.paint.clone(), state.space.look.clone());
    work.jobs.start(&mut state.running, JobKind::Import, "Painting a stroke", move |task| {
        let _turn = turn.take();
        let done = apply(&folder, &opened, &drawn.stroke, &look, StrokeOptions::default(), task);
        drop(lock);
        Ok(Box::new(move |state| state.stroke_came(&folder, &drawn, done, again)))
    });
}
