//! Changes of state that follow from strokes of the brush in the 3D view.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::state::numbers::{counted, grouped};
use crate::state::request::{Request, RoundTripRequest};
use crate::state::running::JobKind;
use crate::state::space::brush::{DrawnStroke, UnseenStroke};
use quadratura_base::error::{Error, Result};
use quadratura_document::stroke::{BrushMode, Stroke};
use quadratura_editing::stroke::StrokeReport;
use quadratura_editing::stroke::coverage::StrokeCoverage;

/// The share of a stroke's pixels that may stay unpainted without a message: along its rim the texels of a photo never
/// fit those of the view.
const RIM: f64 = 0.1;

impl State {
    /// Handles a stroke that has become paint: records it as a step, reports what was left out, and updates all views.
    /// `again` is the number of the import that was undone before.
    pub fn stroke_came(
        &mut self,
        folder: &Path,
        drawn: &Arc<DrawnStroke>,
        done: Result<StrokeReport>,
        again: Option<u32>,
    ) -> Vec<Request> {
        let was_undone = self.space.brush.is_undone;
        let ended = self.space.brush.take_ended(drawn);
        if self.session.as_ref().is_none_or(|session| session.folder != folder) {
            return Vec::new();
        }
        let report = match done {
            Ok(report) => report,
            Err(Error::Cancelled) if was_undone => return Vec::new(),
            Err(error) => {
                self.notify(Note::new(Weight::Problem, format!("The stroke was not painted: {error}")));
                return Vec::new();
            }
        };
        let notes = what_was_left_out(&report, drawn.stroke.brush.mode);
        self.space.brush.remark = notes.first().cloned();
        notes.into_iter().for_each(|text| self.notify(Note::new(Weight::Warning, text)));
        let Some(number) = report.number else { return Vec::new() };
        self.remember_stroke(number, again, drawn.stroke.clone(), name_of(&drawn.stroke, &report));
        if report.only_here {
            self.remember_only_here(number);
        }
        // The picture on the screen does not contain it yet.
        let gets_picture =
            !was_undone && (self.space.device.is_some() || self.running.runs(JobKind::Preview));
        if let Some(drawn) = ended.filter(|_| gets_picture) {
            let revision = self.space.next_revision();
            self.space.brush.unseen.push(UnseenStroke { drawn, number, revision });
        }
        let photos = report.layers.iter().map(|layer| layer.photo.clone()).collect();
        vec![RoundTripRequest::PaintChanged(photos, report.book.clone()).into()]
    }
}

/// Returns the name of a stroke as a step of the history: `brush stroke: colour on facade, 3 photos`.
fn name_of(stroke: &Stroke, report: &StrokeReport) -> String {
    let photos: BTreeSet<&str> = report.layers.iter().map(|layer| layer.photo.as_str()).collect();
    let on = match report.objects.split_first() {
        Some((first, [])) => format!(" on {first}"),
        Some((first, others)) => format!(" on {first} and {} more", others.len()),
        None => String::new(),
    };
    format!("brush stroke: {}{on}, {}", stroke.brush.mode.word(), counted(photos.len() as u64, "photo"))
}

/// Returns messages about the parts of a stroke that are not paint, with the reason and what to do.
fn what_was_left_out(report: &StrokeReport, mode: BrushMode) -> Vec<String> {
    let mut texts: Vec<String> = left_out(&report.coverage).into_iter().collect();
    if report.without_source > 0 {
        texts.push(format!(
            "The view shows nothing at the source of {} pixels; they were not painted",
            grouped(report.without_source)
        ));
    }
    if report.number.is_none() && texts.is_empty() {
        texts.push(match mode {
            BrushMode::Erase => {
                "There is no paint of brush strokes under the eraser; paint of the image editor stays".into()
            }
            _ => "The stroke changed nothing: the layers show these colours already".into(),
        });
    }
    texts
}

fn left_out(coverage: &StrokeCoverage) -> Option<String> {
    let StrokeCoverage { pixels, painted, coarse, hidden, outside } = *coverage;
    let lost = pixels - painted;
    if lost == 0 || (hidden + outside == 0 && (lost as f64) < RIM * pixels as f64) {
        return None;
    }
    let reason = |count: u64, reason: &str| (count > 0).then(|| format!("{} {reason}", grouped(count)));
    let reasons = [
        reason(
            coarse,
            "because no photo shows the surface finely enough for this stroke: use a larger brush",
        ),
        reason(
            hidden,
            "because no photo shows this side of the surface: others hide it, or it is turned away",
        ),
        reason(outside, "because the surface is outside all photos"),
    ];
    let reasons: Vec<String> = reasons.into_iter().flatten().collect();
    // 100 % only where nothing was painted.
    let percent = (100 * lost / pixels).max(1);
    let only = if hidden + outside > 0 { " Paint needs a photo that shows the surface." } else { "" };
    let (lost, pixels, reasons) = (grouped(lost), grouped(pixels), reasons.join("; "));
    Some(format!("{lost} of the stroke’s {pixels} pixels ({percent} %) were not painted: {reasons}.{only}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_editing::stroke::StrokedLayer;

    fn coverage(painted: u64, coarse: u64, hidden: u64, outside: u64) -> StrokeCoverage {
        StrokeCoverage { pixels: painted + coarse + hidden + outside, painted, coarse, hidden, outside }
    }

    #[test]
    fn a_message_says_how_much_of_a_stroke_is_no_paint_and_why() {
        assert_eq!(left_out(&coverage(95, 5, 0, 0)), None, "the rim");
        let text = left_out(&coverage(91, 11_909, 0, 0)).unwrap();
        let (lost, all) = (grouped(11_909), grouped(12_000));
        let begins = format!("{lost} of the stroke’s {all} pixels (99 %) were not painted: {lost} because");
        assert!(text.starts_with(&begins), "{text}");
        assert!(text.contains("larger brush") && !text.contains("hide"), "{text}");
        let text = left_out(&coverage(900, 0, 60, 40)).unwrap();
        assert!(text.contains("(10 %)") && text.contains("60 because no photo shows this side"), "{text}");
        assert!(text.contains("40 because the surface is outside all photos"), "{text}");
    }

    #[test]
    fn a_stroke_that_changes_nothing_says_so() {
        let report = StrokeReport { coverage: coverage(10, 0, 0, 0), ..StrokeReport::default() };
        assert!(what_was_left_out(&report, BrushMode::Colour)[0].contains("changed nothing"));
        assert!(what_was_left_out(&report, BrushMode::Erase)[0].contains("no paint of brush strokes"));
    }

    #[test]
    fn a_step_of_the_history_says_what_the_stroke_is() {
        let layer = |photo: &str| StrokedLayer { photo: photo.into(), layer: "a".into(), changed: 1 };
        let mut report = StrokeReport {
            layers: vec![layer("a.jpg"), layer("b.jpg"), layer("a.jpg")],
            objects: vec!["facade".into()],
            ..StrokeReport::default()
        };
        let stroke = crate::state::space::brush::tests::a_stroke();
        assert_eq!(name_of(&stroke, &report), "brush stroke: colour on facade, 2 photos");
        report.objects.push("door".into());
        assert_eq!(name_of(&stroke, &report), "brush stroke: colour on facade and 1 more, 2 photos");
    }
}
