//! Steps, gestures, saves and imports, compared with a plain list.

use super::*;
use quadratura_base::geometry::Similarity;
use quadratura_base::scene::synthetic::Rng;
use quadratura_layers::Options;

fn project(margin: u32) -> Project {
    let text = r#"{"version": 1, "photos": "p", "cameras": "c", "model": "m.obj"}"#;
    let project: Project = serde_json::from_str(text).unwrap();
    assert_eq!(project.world_from_model, Similarity::IDENTITY);
    Project { options: Options { margin, ..Options::default() }, ..project }
}

/// Returns the names of all steps, oldest first, and how many of them are not undone.
fn names(history: &History) -> (Vec<&str>, usize) {
    let names = history.steps.iter().map(|step| step.name.as_str()).collect();
    (names, history.steps.len() - history.undone)
}

fn margin(history: &History) -> u32 {
    history.present().options.margin
}

#[test]
fn steps_are_undone_and_done_again_by_name() {
    let mut history = History::new(project(1));
    assert_eq!((history.undo(), history.redo()), (None, None));
    history.edit("merge of 3 layers", project(2), None);
    history.edit("split", project(3), None);
    assert_eq!(history.undoes(), Some("split"));
    assert_eq!(history.undo(), Some(StepResult::Project));
    assert_eq!((history.undoes(), history.redo_name()), (Some("merge of 3 layers"), Some("split")));
    assert_eq!(margin(&history), 2);
    history.undo();
    assert_eq!((margin(&history), history.undoes()), (1, None));
    assert_eq!(names(&history), (vec!["merge of 3 layers", "split"], 0));
    history.redo();
    history.redo();
    assert_eq!((margin(&history), history.redo()), (3, None));
}

#[test]
fn what_is_done_after_an_undo_takes_the_place_of_what_was_undone() {
    let mut history = History::new(project(1));
    history.edit("a", project(2), None);
    history.edit("b", project(3), None);
    history.undo();
    history.edit("c", project(4), None);
    assert_eq!((history.redo(), names(&history)), (None, (vec!["a", "c"], 2)));
}

#[test]
fn a_gesture_is_one_step_and_one_that_ends_where_it_began_is_none() {
    let mut history = History::new(project(1));
    (2..50).for_each(|m| history.edit("margin", project(m), Some(Gesture(1))));
    assert_eq!(names(&history).0.len(), 1);
    history.edit("margin", project(50), Some(Gesture(2)));
    assert_eq!(names(&history).0.len(), 2, "another gesture is another step");
    history.undo();
    history.edit("margin", project(60), Some(Gesture(2)));
    assert_eq!(names(&history).0.len(), 2, "an undo ends a gesture");
    history.undo();
    history.undo();
    assert_eq!(margin(&history), 1);
    [2, 3, 1].into_iter().for_each(|m| history.edit("margin", project(m), Some(Gesture(3))));
    assert!(history.undoes().is_none() && !history.is_dirty());
    history.edit("margin", project(1), None);
    assert!(history.undoes().is_none(), "what changes nothing is no step");
    history.edit("margin", project(7), Some(Gesture(4)));
    history.end_gesture();
    history.edit("margin", project(8), Some(Gesture(4)));
    assert_eq!(names(&history).0.len(), 2);
}

#[test]
fn it_is_known_whether_the_present_is_saved_before_and_after_the_save() {
    let mut history = History::new(project(1));
    assert!(!history.is_dirty());
    history.edit("a", project(2), Some(Gesture(1)));
    assert!(history.is_dirty());
    history.saved();
    assert!(!history.is_dirty());
    history.edit("a", project(3), Some(Gesture(1)));
    assert_eq!(names(&history).0.len(), 2, "what was saved stays a place to go back to");
    history.undo();
    assert!(!history.is_dirty());
    history.undo();
    assert!(history.is_dirty(), "undone past the save");
    history.edit("b", project(4), None);
    assert!(history.is_dirty());
    history.edit("c", project(2), None);
    assert!(!history.is_dirty(), "the same content by another way");
}

#[test]
fn imports_are_steps_that_say_what_is_to_be_done() {
    let mut history = History::new(project(1));
    history.edit("a", project(2), None);
    let files = vec![PathBuf::from("wall.psd")];
    history.imported("import of wall.psd", 7, files.clone(), vec![]);
    assert!(history.is_dirty() && history.undoes() == Some("import of wall.psd"));
    assert_eq!(history.undo(), Some(StepResult::TakeBack(7)));
    assert_eq!(margin(&history), 2);
    assert_eq!(history.undo(), Some(StepResult::Project));
    assert_eq!(
        (history.redo(), history.redo()),
        (Some(StepResult::Project), Some(StepResult::ImportAgain(7, files)))
    );
    history.import_redone(7, 9, vec![]);
    assert_eq!(history.undo(), Some(StepResult::TakeBack(9)));
    history.forget_import(9);
    assert_eq!((history.redo(), history.undoes()), (None, Some("a")));
}

/// Returns the file of the only mask, if any.
fn mask_of(history: &History) -> Option<&str> {
    history.present().masks.of("a.jpg").first().map(|mask| mask.file.as_str())
}

#[test]
fn an_import_with_a_mask_is_one_step_and_the_mask_comes_and_goes_with_it() {
    let from = MaskOrigin::Layer("9@a.psd".into());
    let photo = "a.jpg".to_owned();
    let came = |file: &str| {
        let after = Some(Mask { from: from.clone(), file: file.into(), pixels: 3 });
        vec![MaskChange { photo: photo.clone(), from: from.clone(), before: None, after }]
    };
    let went = [ImportedMask { photo: photo.clone(), from: from.clone(), before: None }];
    let mut history = History::new(project(1));
    history.imported("import 1", 1, vec![], came("first"));
    assert_eq!((mask_of(&history), history.is_dirty()), (Some("first"), false), "it is on disk");
    history.edit("b", Project { masks: history.present().masks.clone(), ..project(2) }, None);
    history.undo();
    assert_eq!(history.undo(), Some(StepResult::TakeBack(1)));
    history.import_undone(1, &went);
    assert_eq!((mask_of(&history), history.is_dirty(), history.undoes()), (None, false, None));
    assert_eq!(history.redo(), Some(StepResult::ImportAgain(1, vec![])));
    history.import_redone(1, 2, came("first"));
    assert_eq!(
        (mask_of(&history), history.redo_name(), history.is_dirty()),
        (Some("first"), Some("b"), false)
    );
    history.redo();
    assert_eq!((mask_of(&history), margin(&history)), (Some("first"), 2));

    // Undone when it is no longer the last step: no step restores its mask.
    history.forget_import(2);
    history.import_undone(2, &went);
    assert_eq!(mask_of(&history), None);
    assert_eq!(history.undo(), Some(StepResult::Project));
    assert_eq!((mask_of(&history), history.is_dirty(), history.undoes()), (None, false, None));
    history.redo();
    assert_eq!((mask_of(&history), margin(&history)), (None, 2));
}

#[test]
fn what_came_another_time_is_in_the_steps_after_the_import_and_a_forgotten_one_stays_made() {
    let from = MaskOrigin::Layer("9@a.psd".into());
    let photo = "a.jpg".to_owned();
    let came = |file: &str| {
        let after = Some(Mask { from: from.clone(), file: file.into(), pixels: 3 });
        vec![MaskChange { photo: photo.clone(), from: from.clone(), before: None, after }]
    };
    let mut history = History::new(project(0));
    history.edit("a", project(1), None);
    history.imported("import 1", 1, vec![], came("first"));
    history.edit("b", Project { masks: history.present().masks.clone(), ..project(2) }, None);
    history.undo();
    history.undo();
    history.import_undone(1, &[ImportedMask { photo: photo.clone(), from: from.clone(), before: None }]);
    history.redo();
    // The file was saved again since.
    history.import_redone(1, 2, came("second"));
    history.redo();
    assert_eq!((mask_of(&history), margin(&history)), (Some("second"), 2), "not the one that came first");
    history.forget_import(2);
    history.undo();
    history.undo();
    assert_eq!((mask_of(&history), margin(&history)), (Some("second"), 0), "it is still made");
}

#[test]
fn an_import_undone_on_disk_leaves_no_decision_to_the_next_one_with_its_number() {
    let mut only_here = project(1);
    only_here.fill.only_here.imports.insert(4);
    let mut history = History::new(project(0));
    history.edit("only here", only_here.clone(), None);
    history.saved();
    history.edit("more", Project { options: project(2).options, ..only_here }, None);
    history.import_undone(4, &[]);
    let stays = |history: &History| !history.present().fill.only_here.is_empty();
    assert!(!stays(&history));
    history.undo();
    assert!(!stays(&history) && !history.is_dirty(), "it is saved so on disk, too");
}

#[test]
fn a_thousand_steps_can_be_undone_and_no_more() {
    let mut history = History::new(project(0));
    (1..=1200).for_each(|m| history.edit(m.to_string(), project(m), None));
    let mut undone = 0;
    while history.undo().is_some() {
        undone += 1;
    }
    assert_eq!((undone, margin(&history)), (MOST_STEPS, 200));
    while history.redo().is_some() {}
    assert_eq!(margin(&history), 1200);
}

/// Compares the history with a list of states and an index.
#[test]
fn any_mixture_of_edits_undo_redo_and_saves_is_that_of_a_plain_list() {
    let mut rng = Rng::new(31);
    for _ in 0..50 {
        let mut history = History::new(project(0));
        let mut list = vec![0];
        let mut at = 0;
        let mut saved = 0;
        for number in 1..200 {
            match rng.whole(0, 9) {
                0..=3 => {
                    history.edit("edit", project(number), None);
                    list.truncate(at + 1);
                    list.push(number);
                    at += 1;
                }
                4..=6 => {
                    assert_eq!(history.undo().is_some(), at > 0);
                    at = at.saturating_sub(1);
                }
                7..=8 => {
                    assert_eq!(history.redo().is_some(), at + 1 < list.len());
                    at = (at + 1).min(list.len() - 1);
                }
                _ => {
                    history.saved();
                    saved = list[at];
                }
            }
            assert_eq!(margin(&history), list[at]);
            assert_eq!(history.is_dirty(), list[at] != saved);
        }
    }
}

#[test]
fn paint_that_stayed_in_its_photo_stays_there_when_its_import_is_done_again() {
    let mut history = History::new(project(1));
    history.imported("import 1", 1, Vec::new(), Vec::new());
    let mut only_here = Project::clone(history.present());
    only_here.fill.only_here.imports.insert(1);
    history.edit("only in this photo", only_here, None);
    history.saved();
    assert_eq!(history.undo(), Some(StepResult::Project));
    assert_eq!(history.undo(), Some(StepResult::TakeBack(1)));
    history.import_undone(1, &[]);
    assert!(history.on_disk().fill.only_here.imports.is_empty(), "the undoing has changed the file");
    assert!(matches!(history.redo(), Some(StepResult::ImportAgain(1, _))));
    history.import_redone(1, 4, Vec::new());
    assert_eq!(history.redo(), Some(StepResult::Project));
    assert!(history.present().fill.only_here.imports.iter().eq([&4]), "the import has another number now");
    assert!(history.is_dirty(), "it has to be saved again");
}

#[test]
fn a_stroke_that_stays_in_its_photo_stays_there_when_it_is_saved_undone_and_done_again() {
    let mut history = History::new(project(1));
    history.imported("matte stroke", 1, Vec::new(), Vec::new());
    history.stays_in_photo(1);
    let stays = |project: &Project| project.fill.only_here.imports.clone();
    assert!(!history.is_dirty() && stays(history.on_disk()).contains(&1), "the stroke has written it");
    history.edit("more", Project { options: project(2).options, ..Project::clone(history.present()) }, None);
    assert!(stays(history.present()).contains(&1));
    assert_eq!(history.undo(), Some(StepResult::Project));
    assert_eq!(history.undo(), Some(StepResult::TakeBack(1)));
    history.import_undone(1, &[]);
    assert!(stays(history.present()).is_empty() && !history.is_dirty());
    assert!(matches!(history.redo(), Some(StepResult::ImportAgain(1, _))));
    history.import_redone(1, 4, Vec::new());
    history.stays_in_photo(4);
    assert!(!history.is_dirty());
    assert_eq!(history.redo(), Some(StepResult::Project));
    assert!(stays(history.present()).iter().eq([&4]), "the later step says so, too");
}
