//! Tests of masks: the queue of edits, suggestions, and remedies for masks that cannot be used.

use std::sync::Arc;

use super::bench::{PHOTOS, TestBench};
use crate::state::masking::keeping::MaskWork;
use crate::state::masking::stroke::MaskStroke;
use crate::state::masking::suggested::ShownSuggestion;
use crate::state::masking::tool::MaskTool;
use crate::state::notes::NoteRemedy;
use crate::state::request::{DecideRequest, MaskRequest, SelectRequest};
use crate::state::selection::Selection;
use quadratura_base::geometry::{PixelRect, Spans};
use quadratura_base::scene::{ObjectId, PhotoId};
use quadratura_document::masks::{Mask, MaskOrigin};
use quadratura_io::mask_store::MaskStore;
use quadratura_sites::masks::MaskEdit;
use quadratura_sites::open::UnusableMask;
use quadratura_stacks::masks::suggest::MaskSuggestion;

fn block(x: i32, w: u32) -> Spans {
    Spans::of_pixels(PixelRect { x, y: 0, w, h: 2 }, |_, _| true)
}

/// Masks a block of the first photo.
fn mask(bench: &mut TestBench, name: &str, masked: Spans) {
    let edit = MaskEdit::Add { photo: PHOTOS[0].into(), from: MaskOrigin::Drawn, masked };
    bench.request(MaskRequest::Mask(name.into(), MaskWork::Edits(Arc::new(vec![edit]))));
}

/// Runs frames until all masks are written.
fn keep(bench: &mut TestBench) {
    while !bench.state.masking.is_kept() || !bench.state.running.is_idle() {
        bench.pass(0.1);
        bench.settle();
    }
}

fn masks(bench: &TestBench) -> Vec<Mask> {
    bench.project().masks.of(PHOTOS[0]).to_vec()
}

fn covered(bench: &TestBench) -> u64 {
    bench.state.masking.covered(bench.session(), PhotoId(0)).expect("the photo exists").count()
}

fn suggestion(number: u32, photo: &str, masked: Spans) -> ShownSuggestion {
    let it = MaskSuggestion {
        number,
        photo: photo.into(),
        size: [9, 9],
        rect: masked.bounds(),
        pixels: masked.count(),
        share: 0.1,
        score: 1.0,
        likelihood: 1.0,
        mask: String::new(),
        picture: String::new(),
    };
    ShownSuggestion { it, masked: Arc::new(masked) }
}

fn suggest(bench: &mut TestBench, list: Vec<ShownSuggestion>) {
    (bench.state.masking.suggested.read, bench.state.masking.suggested.pointed) = (true, None);
    bench.state.masking.suggested.put(list);
}

// ---- the queue ----

#[test]
fn a_mask_is_shown_while_it_waits_and_is_a_step_when_it_is_written() {
    let mut bench = TestBench::new();
    mask(&mut bench, "mask by brush", block(0, 4));
    assert_eq!((covered(&bench), bench.undoes(), bench.state.masking.is_kept()), (8, None, false));
    keep(&mut bench);
    assert_eq!((covered(&bench), bench.undoes()), (8, Some("mask by brush")));
    let written = masks(&bench);
    assert!(written.len() == 1 && MaskStore::new(bench.folder()).path(&written[0].file).is_file());
}

#[test]
fn masks_are_written_one_after_the_other_each_as_a_step() {
    let mut bench = TestBench::new();
    mask(&mut bench, "one", block(0, 2));
    mask(&mut bench, "two", block(4, 2));
    assert_eq!(covered(&bench), 8);
    keep(&mut bench);
    assert_eq!((covered(&bench), bench.undoes()), (8, Some("two")));
    bench.request(DecideRequest::Undo);
    assert_eq!((covered(&bench), bench.undoes()), (4, Some("one")));
}

#[test]
fn a_mask_that_changes_nothing_is_no_step() {
    let mut bench = TestBench::new();
    let edit = MaskEdit::Clear { photo: PHOTOS[1].into() };
    bench.request(MaskRequest::Mask("nothing".into(), MaskWork::Edits(Arc::new(vec![edit]))));
    keep(&mut bench);
    assert_eq!(bench.undoes(), None);
}

#[test]
fn a_mask_that_cannot_be_made_is_reported_and_the_next_one_is_written() {
    let mut bench = TestBench::new();
    bench.request(SelectRequest::Only(Selection::Object(ObjectId(0))));
    bench.request(MaskRequest::Object);
    mask(&mut bench, "after it", block(0, 2));
    keep(&mut bench);
    assert!(bench.said().iter().any(|text| text.starts_with("The mask was not saved")), "{:?}", bench.said());
    assert_eq!((covered(&bench), bench.undoes()), (4, Some("after it")));
}

#[test]
fn masks_that_were_read_are_not_read_again() {
    let mut bench = TestBench::new();
    mask(&mut bench, "one", block(0, 2));
    keep(&mut bench);
    bench.request(MaskRequest::WantMasks(PhotoId(0)));
    assert!(bench.state.running.is_idle());
    bench.state.masking.cache = Default::default();
    assert_eq!(covered(&bench), 0);
    bench.request(MaskRequest::WantMasks(PhotoId(0)));
    bench.settle();
    assert_eq!(covered(&bench), 4);
}

#[test]
fn a_mask_whose_file_is_gone_counts_as_empty_and_is_reported_with_remedies_once() {
    let mut bench = TestBench::new();
    mask(&mut bench, "one", block(0, 2));
    keep(&mut bench);
    let lost = masks(&bench).remove(0);
    std::fs::remove_file(MaskStore::new(bench.folder()).path(&lost.file)).unwrap();
    bench.state.masking.cache = Default::default();
    for _ in 0..3 {
        bench.request(MaskRequest::WantMasks(PhotoId(0)));
        bench.settle();
    }
    assert_eq!((covered(&bench), bench.state.notes.list().len()), (0, 1), "{:?}", bench.said());
    let note = bench.state.notes.list()[0].clone();
    let away = note.remedies.iter().find_map(|(_, remedy)| match remedy {
        NoteRemedy::SetMask(change) if change.after.is_none() => Some(change.clone()),
        _ => None,
    });
    let away = away.expect("the mask can be taken away");
    let remedy = NoteRemedy::SetMask(away.clone());
    assert!(remedy.applies(Some(bench.session())));
    bench.request(MaskRequest::Set((*away).clone()));
    assert!(masks(&bench).is_empty() && !remedy.applies(Some(bench.session())));
    bench.request(DecideRequest::Undo);
    assert_eq!(masks(&bench), [lost]);
}

#[test]
fn a_mask_of_an_older_version_is_offered_in_place_of_a_lost_one() {
    let mut bench = TestBench::new();
    mask(&mut bench, "one", block(0, 2));
    keep(&mut bench);
    mask(&mut bench, "two", block(4, 2));
    keep(&mut bench);
    let lost = masks(&bench).remove(0);
    std::fs::remove_file(MaskStore::new(bench.folder()).path(&lost.file)).unwrap();
    let photo = bench.session().opened.site.photos[0].clone();
    let unusable = UnusableMask { photo, mask: lost, problem: "it is gone".into() };
    bench.request(MaskRequest::Report(vec![unusable], "cannot be built"));
    bench.settle();
    let note = &bench.state.notes.list()[0];
    assert_eq!(note.remedies.len(), 3, "away, the older one, a file: {}", note.text);
}

// ---- tools ----

#[test]
fn a_tool_is_put_away_and_its_stroke_given_up() {
    let mut bench = TestBench::new();
    bench.request(MaskRequest::TakeUp(MaskTool::Brush));
    bench.state.masking.stroke = Some(MaskStroke::new(PhotoId(0), MaskTool::Brush, false, 3.0));
    bench.request(MaskRequest::GiveUpStroke);
    assert!(!bench.state.masking.is_drawing() && bench.state.masking.tool == Some(MaskTool::Brush));
    bench.request(MaskRequest::PutAway);
    assert_eq!(bench.state.masking.tool, None);
}

#[test]
fn the_brush_is_resized_for_the_selected_photo() {
    let mut bench = TestBench::new();
    let size = bench.state.selected_photo_size().unwrap();
    let before = bench.state.masking.radius_px(size);
    bench.request(MaskRequest::ResizeBrush(2.0));
    assert_eq!(bench.state.masking.radius_px(size), 2.0 * before);
}

// ---- suggestions ----

#[test]
fn a_suggestion_that_is_accepted_is_a_mask_and_open_no_longer() {
    let mut bench = TestBench::new();
    let list = vec![suggestion(1, PHOTOS[0], block(0, 2)), suggestion(2, PHOTOS[1], block(0, 2))];
    suggest(&mut bench, list);
    assert_eq!(bench.state.masking.suggestions_of(bench.session(), PhotoId(0)).len(), 1);
    bench.request(MaskRequest::Accept(vec![1]));
    assert!(
        bench.state.masking.suggestions_of(bench.session(), PhotoId(0)).is_empty()
            && bench.state.open_suggestions().is_empty()
    );
    keep(&mut bench);
    assert_eq!(bench.undoes(), Some(format!("mask of {} by suggestion 1", PHOTOS[0]).as_str()));
    bench.request(DecideRequest::Undo);
    assert_eq!(bench.state.masking.suggestions_of(bench.session(), PhotoId(0)).len(), 1, "it returns");
    assert_eq!(bench.state.all_suggestions(), [1, 2]);
}

#[test]
fn a_number_that_no_suggestion_has_masks_nothing() {
    let mut bench = TestBench::new();
    suggest(&mut bench, vec![suggestion(1, PHOTOS[0], block(0, 2))]);
    bench.request(MaskRequest::Accept(vec![7]));
    keep(&mut bench);
    assert_eq!(bench.undoes(), None);
}

#[test]
fn the_smallest_suggestion_under_the_pointer_is_meant_and_none_while_they_are_hidden() {
    let mut bench = TestBench::new();
    let list = vec![suggestion(1, PHOTOS[0], block(0, 9)), suggestion(2, PHOTOS[0], block(2, 2))];
    suggest(&mut bench, list);
    let at = |bench: &TestBench, x| bench.state.masking.suggestion_at(bench.session(), PhotoId(0), (x, 0));
    assert_eq!([at(&bench, 3), at(&bench, 7), at(&bench, 20)], [Some(2), Some(1), None]);
    bench.state.masking.suggested.shown = false;
    assert_eq!(at(&bench, 3), None);
}

#[test]
fn a_suggestion_that_is_pointed_at_is_forgotten_with_its_list() {
    let mut bench = TestBench::new();
    suggest(&mut bench, vec![suggestion(1, PHOTOS[0], block(0, 2))]);
    bench.request(MaskRequest::PointAt(Some(1)));
    assert_eq!(bench.state.masking.suggested.pointed, Some(1));
    bench.request(MaskRequest::Dismiss(vec![1]));
    assert_eq!((bench.state.masking.suggested.pointed, bench.state.masking.suggested.count()), (None, 0));
}

#[test]
fn what_is_hardly_an_object_is_offered_only_on_request() {
    let mut bench = TestBench::new();
    let mut haze = suggestion(2, PHOTOS[0], block(4, 2));
    haze.it.likelihood = 0.2;
    suggest(&mut bench, vec![suggestion(1, PHOTOS[0], block(0, 2)), haze]);
    let offered = |bench: &TestBench| {
        (bench.state.all_suggestions(), bench.state.masking.unlikely_in(bench.session(), PhotoId(0)))
    };
    assert_eq!(offered(&bench), (vec![1], 1));
    bench.request(MaskRequest::OfferUnlikely(true));
    assert_eq!(offered(&bench), (vec![1, 2], 1));
    bench.request(MaskRequest::Dismiss(vec![1]));
    assert_eq!(offered(&bench), (vec![2], 1));
    bench.request(MaskRequest::OfferUnlikely(false));
    assert_eq!(offered(&bench), (vec![], 1), "it is kept");
    bench.request(MaskRequest::OfferUnlikely(true));
    assert_eq!(offered(&bench), (vec![2], 1));
}

#[test]
fn suggestions_of_earlier_runs_are_read_once() {
    let mut bench = TestBench::new();
    bench.request(MaskRequest::WantSuggestions);
    bench.settle();
    bench.request(MaskRequest::WantSuggestions);
    assert!(bench.state.running.is_idle() && bench.said().is_empty());
}

#[test]
fn the_outcome_of_a_search_is_told_until_it_was_seen() {
    use crate::state::masking::suggested::TransientSearch;

    let mut bench = TestBench::new();
    assert_eq!(bench.state.masking.outcome_in(bench.session(), PhotoId(0)), None);
    suggest(&mut bench, vec![suggestion(1, PHOTOS[0], block(0, 2))]);
    bench.state.masking.suggested.outcome = Some(TransientSearch { without: vec![PHOTOS[1].into()] });
    let reported = |bench: &TestBench| {
        [0, 1, 2].map(|photo| bench.state.masking.outcome_in(bench.session(), PhotoId(photo)).is_some())
    };
    assert_eq!(reported(&bench), [true, true, false]);
    bench.request(MaskRequest::Accept(vec![1]));
    assert_eq!(reported(&bench), [false, true, false], "all of it is masked");
    bench.request(MaskRequest::ForgetOutcome);
    assert_eq!(reported(&bench), [false; 3]);
}
