//! Tests of every transition of the life cycle, without a window.

use super::*;

const CLEAN: Facts = Facts { is_dirty: false, masks_wait: false, writes: false };
const DIRTY: Facts = Facts { is_dirty: true, ..CLEAN };
const WRITES: Facts = Facts { writes: true, ..CLEAN };
const MASKS: Facts = Facts { is_dirty: true, masks_wait: true, writes: false };

fn asking() -> Phase {
    Phase::Asking { goal: Goal::Close, failed: None }
}

fn saving() -> Phase {
    Phase::Saving { goal: Goal::Close }
}

fn writing(discards: bool) -> Phase {
    Phase::Writing { goal: Goal::Close, discards }
}

fn waiting(discards: bool) -> Phase {
    Phase::Waiting { goal: Goal::Close, discards }
}

fn go(goal: Goal, discards: bool) -> Option<Effect> {
    Some(Effect::Go { goal, discards })
}

fn every_phase() -> Vec<Phase> {
    vec![Phase::Staying, asking(), saving(), writing(false), writing(true), waiting(false), waiting(true)]
}

#[test]
fn a_project_that_is_saved_is_left_at_once_from_any_state() {
    for goal in [Goal::Close, Goal::Open("a".into()), Goal::Create, Goal::Quit] {
        for phase in every_phase() {
            assert_eq!(
                phase.next(LifeEvent::Leave(goal.clone()), CLEAN),
                (Phase::Staying, go(goal.clone(), false))
            );
        }
    }
}

#[test]
fn what_is_not_saved_is_asked_about_before_anything_is_closed() {
    for phase in every_phase() {
        let asked = Phase::Asking { goal: Goal::Quit, failed: None };
        assert_eq!(phase.next(LifeEvent::Leave(Goal::Quit), DIRTY), (asked, None));
    }
}

#[test]
fn what_is_not_saved_is_asked_about_before_what_is_being_written() {
    let facts = Facts { writes: true, ..DIRTY };
    assert_eq!(Phase::Staying.next(LifeEvent::Leave(Goal::Close), facts), (asking(), None));
}

#[test]
fn a_job_that_writes_is_asked_about_where_all_is_saved() {
    assert_eq!(Phase::Staying.next(LifeEvent::Leave(Goal::Close), WRITES), (writing(false), None));
}

#[test]
fn a_new_goal_takes_the_place_of_the_one_before() {
    let (phase, _) = asking().next(LifeEvent::Leave(Goal::Quit), DIRTY);
    let (phase, effect) = phase.next(LifeEvent::Discard, DIRTY);
    assert_eq!((phase, effect), (Phase::Staying, go(Goal::Quit, true)));
}

#[test]
fn saving_begins_at_once_where_no_mask_waits() {
    assert_eq!(asking().next(LifeEvent::Save, DIRTY), (saving(), Some(Effect::Save)));
}

#[test]
fn saving_waits_for_masks_that_are_still_being_written() {
    assert_eq!(asking().next(LifeEvent::Save, MASKS), (saving(), None));
    assert_eq!(saving().next(LifeEvent::Frame, MASKS), (saving(), None));
    assert_eq!(saving().next(LifeEvent::Frame, DIRTY), (saving(), Some(Effect::Save)));
}

#[test]
fn a_project_that_was_saved_is_left() {
    assert_eq!(saving().next(LifeEvent::Saved(Ok(())), CLEAN), (Phase::Staying, go(Goal::Close, false)));
}

#[test]
fn a_project_that_was_saved_while_a_job_writes_is_left_after_that_was_asked() {
    assert_eq!(saving().next(LifeEvent::Saved(Ok(())), WRITES), (writing(false), None));
}

#[test]
fn a_save_that_failed_says_why_and_leaves_nothing() {
    let failed = Phase::Asking { goal: Goal::Close, failed: Some("the disk is full".into()) };
    let (phase, effect) = saving().next(LifeEvent::Saved(Err("the disk is full".into())), DIRTY);
    assert_eq!((phase, effect), (failed.clone(), None));
    assert_eq!(
        failed.clone().next(LifeEvent::Save, DIRTY),
        (saving(), Some(Effect::Save)),
        "it is tried again"
    );
    assert_eq!(failed.clone().next(LifeEvent::Discard, DIRTY), (Phase::Staying, go(Goal::Close, true)));
    assert_eq!(failed.next(LifeEvent::Stay, DIRTY), (Phase::Staying, None));
}

#[test]
fn what_is_discarded_is_discarded_only_when_the_project_is_left() {
    let facts = Facts { writes: true, ..DIRTY };
    assert_eq!(asking().next(LifeEvent::Discard, DIRTY), (Phase::Staying, go(Goal::Close, true)));
    assert_eq!(asking().next(LifeEvent::Discard, facts), (writing(true), None));
    assert_eq!(saving().next(LifeEvent::Discard, DIRTY), (Phase::Staying, go(Goal::Close, true)));
    assert_eq!(saving().next(LifeEvent::Discard, facts), (writing(true), None));
}

#[test]
fn somebody_who_stays_after_all_discards_nothing() {
    assert_eq!(writing(true).next(LifeEvent::Stay, WRITES), (Phase::Staying, None));
    assert_eq!(Phase::Staying.next(LifeEvent::Leave(Goal::Close), CLEAN).1, go(Goal::Close, false));
}

#[test]
fn staying_is_possible_from_every_state() {
    for facts in [CLEAN, DIRTY, WRITES, MASKS] {
        for phase in every_phase() {
            assert_eq!(phase.next(LifeEvent::Stay, facts), (Phase::Staying, None));
        }
    }
}

#[test]
fn what_writes_is_stopped_and_then_the_project_is_left() {
    assert_eq!(writing(false).next(LifeEvent::Stop, WRITES), (waiting(false), Some(Effect::StopWriting)));
    assert_eq!(waiting(false).next(LifeEvent::Frame, WRITES), (waiting(false), None));
    assert_eq!(waiting(false).next(LifeEvent::Frame, CLEAN), (Phase::Staying, go(Goal::Close, false)));
}

#[test]
fn what_writes_is_waited_for_and_can_still_be_stopped() {
    assert_eq!(writing(true).next(LifeEvent::Wait, WRITES), (waiting(true), None));
    assert_eq!(waiting(true).next(LifeEvent::Stop, WRITES), (waiting(true), Some(Effect::StopWriting)));
    assert_eq!(waiting(true).next(LifeEvent::Frame, CLEAN), (Phase::Staying, go(Goal::Close, true)));
}

#[test]
fn a_job_that_ends_by_itself_answers_the_question_about_it() {
    assert_eq!(writing(false).next(LifeEvent::Frame, CLEAN), (Phase::Staying, go(Goal::Close, false)));
    assert_eq!(writing(true).next(LifeEvent::Frame, CLEAN), (Phase::Staying, go(Goal::Close, true)));
    assert_eq!(writing(false).next(LifeEvent::Frame, WRITES), (writing(false), None));
}

#[test]
fn events_that_belong_to_another_question_change_nothing() {
    let saved = || LifeEvent::Saved(Ok(()));
    let none: [(Phase, Vec<LifeEvent>); 5] = [
        (
            Phase::Staying,
            vec![
                LifeEvent::Save,
                LifeEvent::Discard,
                saved(),
                LifeEvent::Stop,
                LifeEvent::Wait,
                LifeEvent::Frame,
            ],
        ),
        (asking(), vec![saved(), LifeEvent::Stop, LifeEvent::Wait, LifeEvent::Frame]),
        (saving(), vec![LifeEvent::Save, LifeEvent::Stop, LifeEvent::Wait]),
        (writing(false), vec![LifeEvent::Save, LifeEvent::Discard, saved()]),
        (waiting(false), vec![LifeEvent::Save, LifeEvent::Discard, saved(), LifeEvent::Wait]),
    ];
    for (phase, events) in none {
        for event in events {
            assert_eq!(phase.clone().next(event.clone(), DIRTY), (phase.clone(), None), "{event:?}");
        }
    }
}

/// In any sequence of events, a project with unsaved changes is left only after they were saved or discarded.
#[test]
fn no_sequence_of_events_leaves_unsaved_work_unasked() {
    let events = || {
        [
            LifeEvent::Leave(Goal::Quit),
            LifeEvent::Save,
            LifeEvent::Discard,
            LifeEvent::Stay,
            LifeEvent::Stop,
            LifeEvent::Wait,
            LifeEvent::Frame,
        ]
    };
    let mut sequences: Vec<(Phase, bool)> = vec![(Phase::Staying, false)];
    for _ in 0..6 {
        let mut longer = Vec::new();
        for (phase, was_discarded) in sequences {
            for event in events() {
                for facts in [DIRTY, MASKS, Facts { writes: true, ..DIRTY }] {
                    let discards = event == LifeEvent::Discard
                        && matches!(phase, Phase::Asking { .. } | Phase::Saving { .. });
                    let stays = matches!(event, LifeEvent::Stay | LifeEvent::Leave(_));
                    let discarded = discards || (was_discarded && !stays);
                    let (next, effect) = phase.clone().next(event.clone(), facts);
                    if let Some(Effect::Go { discards, .. }) = effect {
                        assert!(discards && discarded, "{phase:?} {event:?}");
                    }
                    let is_new = (next, discarded);
                    if !longer.contains(&is_new) {
                        longer.push(is_new);
                    }
                }
            }
        }
        sequences = longer;
    }
}

#[test]
fn a_project_that_is_closed_is_asked_about_no_more_but_the_program_still_ends() {
    let mut life = Life { phase: asking(), ..Life::default() };
    assert!(life.is_asking() && !life.asks_about_writing());
    life.phase = writing(false);
    assert!(life.asks_about_writing() && !life.is_asking());
    life.quit();
    life.closed();
    assert_eq!((life.phase.clone(), life.quits()), (Phase::Staying, true));
    assert!(!life.is_asking() && !life.asks_about_writing());
}

#[test]
fn what_is_decided_is_kept_at_once() {
    let mut autosave = Autosave::default();
    assert!(!autosave.begins(0.0) && !autosave.is_due());
    autosave.edited(false, 1.0);
    assert!(autosave.is_due() && autosave.begins(1.0));
    assert!(!autosave.is_due() && !autosave.begins(1.0), "once");
}

#[test]
fn a_gesture_is_kept_when_it_rests() {
    let mut autosave = Autosave::default();
    (0..30).for_each(|step| autosave.edited(true, 1.0 + 0.05 * f64::from(step)));
    assert!(!autosave.begins(2.5));
    assert!(autosave.begins(2.5 + KEPT_AFTER_S));
}

#[test]
fn a_gesture_that_never_rests_is_kept_two_seconds_after_its_first_edit() {
    let mut autosave = Autosave::default();
    (0..40).for_each(|step| autosave.edited(true, 1.0 + 0.05 * f64::from(step)));
    assert!(!autosave.begins(2.95));
    autosave.edited(true, 3.0);
    assert!(autosave.begins(3.0));
}

#[test]
fn the_end_of_a_gesture_is_kept_at_once() {
    let mut autosave = Autosave::default();
    autosave.edited(true, 1.0);
    assert!(!autosave.begins(1.0));
    autosave.gesture_ended();
    assert!(autosave.begins(1.0));
}

#[test]
fn what_could_not_be_kept_is_tried_again_after_a_rest() {
    let mut autosave = Autosave::default();
    autosave.edited(false, 1.0);
    assert!(autosave.begins(1.0));
    autosave.failed(2.0);
    assert!(autosave.is_due() && !autosave.begins(2.0) && !autosave.begins(6.9));
    assert!(autosave.begins(7.0));
}

#[test]
fn the_autosave_is_told_of_every_edit_once() {
    let mut autosave = Autosave::default();
    assert!(!autosave.take_news());
    autosave.edited(true, 1.0);
    assert!(autosave.take_news() && !autosave.take_news());
    autosave.edited(true, 1.1);
    assert!(autosave.take_news());
}
