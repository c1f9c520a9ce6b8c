//! Tests of flags, sizes and colours of the window, and of every command from its table.

use super::bench::TestBench;
use crate::command::{all, file};
use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::state::request::{Flag, WindowRequest};
use crate::state::settings::{Colours, Navigation};

// ---- the window ----

#[test]
fn every_flag_is_switched_and_switched_back_by_itself() {
    let mut bench = TestBench::new();
    let flags = [
        (Flag::Settings, (|state| state.dialogs.settings) as fn(&State) -> bool),
        (Flag::Notes, |state| state.settings.notes_shown),
        (Flag::Lists, |state| state.settings.lists_shown),
        (Flag::Side, |state| state.settings.side_shown),
        (Flag::Help, |state| state.dialogs.help),
        (Flag::About, |state| state.dialogs.about),
        (Flag::History, |state| state.dialogs.history),
        (Flag::LayerOptions, |state| state.dialogs.layer_options),
        (Flag::LayerTable, |state| state.settings.layer_list.as_table),
        (Flag::Check, |state| state.checks.shown),
        (Flag::ImageEditor, |state| state.round_trip.dialogs.choosing_editor),
        (Flag::Flight, |state| state.flights.shown),
        (Flag::Legend, |state| state.space.legend_shown),
        (Flag::Wireframe, |state| state.space.wireframe),
        (Flag::Cameras, |state| state.space.cameras),
        (Flag::Backs, |state| state.space.look.without_backs),
        (Flag::Surroundings, |state| state.space.look.without_surroundings),
        (Flag::Agreement, |state| state.space.look.blend.agreement),
        (Flag::WithoutTransients, |state| state.space.look.blend.without_transients),
        (Flag::PhotoOver, |state| state.space.photo_over),
        (Flag::Outlines, |state| state.flat.switches.outlines),
        (Flag::Hatching, |state| state.flat.switches.hatching),
        (Flag::Rectangles, |state| state.flat.switches.rectangles),
        (Flag::Filling, |state| state.flat.switches.filling),
        (Flag::Paint, |state| state.flat.switches.paint),
        (Flag::Even, |state| state.flat.switches.even),
        (Flag::Suggestions, |state| state.masking.suggested.shown),
    ];
    for (flag, is_on) in flags {
        let before: Vec<bool> = flags.iter().map(|(_, is_on)| is_on(&bench.state)).collect();
        bench.request(WindowRequest::Flip(flag));
        let changed = flags.iter().zip(before).filter(|((_, is_on), before)| is_on(&bench.state) != *before);
        assert_eq!(changed.map(|((flag, _), _)| *flag).collect::<Vec<_>>(), [flag]);
        let now = is_on(&bench.state);
        bench.request(WindowRequest::Flip(flag));
        assert_ne!(is_on(&bench.state), now);
    }
}

#[test]
fn the_size_of_text_goes_by_tenths_and_back() {
    let mut bench = TestBench::empty();
    bench.request(WindowRequest::Resize(1.0));
    bench.request(WindowRequest::Resize(1.0));
    assert_eq!(bench.state.settings.scale, 1.2);
    bench.request(WindowRequest::UsualSize);
    assert_eq!(bench.state.settings.scale, 1.0);
}

#[test]
fn the_theme_and_the_layout_are_the_window_s_to_apply() {
    let mut bench = TestBench::empty();
    bench.request(WindowRequest::Theme(Colours::Light));
    bench.state.settings.lists_shown = false;
    bench.request(WindowRequest::ResetLayout);
    assert_eq!(bench.state.settings.colours, Colours::Light);
    assert!(bench.state.settings.lists_shown && bench.state.window.resets);
}

#[test]
fn what_is_hidden_stays_hidden_when_it_is_hidden_again() {
    let mut bench = TestBench::empty();
    bench.request(WindowRequest::Flip(Flag::Help));
    for _ in 0..2 {
        bench.request(WindowRequest::Hide(Flag::Help));
        assert!(!bench.state.dialogs.help);
    }
}

#[test]
fn the_settings_take_what_the_user_sets() {
    let mut bench = TestBench::empty();
    bench.request(WindowRequest::Scale(1.5));
    bench.request(WindowRequest::Navigate(Navigation::Blender));
    bench.request(WindowRequest::ShowHints(false));
    let settings = &bench.state.settings;
    assert_eq!((settings.scale, settings.navigation, settings.hints), (1.5, Navigation::Blender, false));
}

#[test]
fn notes_are_news_until_they_were_seen_and_gone_when_cleared() {
    let mut bench = TestBench::empty();
    bench.request(WindowRequest::Say(Note::new(Weight::Info, "dust")));
    assert_eq!(bench.state.notes.unseen(), (1, Some(Weight::Info)));
    bench.request(WindowRequest::SeeNotes);
    assert_eq!((bench.state.notes.unseen(), bench.said().len()), ((0, None), 1));
    bench.request(WindowRequest::ClearNotes);
    assert!(bench.said().is_empty());
}

#[test]
fn a_command_that_is_not_ready_says_why() {
    let mut bench = TestBench::empty();
    let request = file::SAVE.requested(&bench.state);
    bench.request(request);
    assert_eq!(bench.said(), ["Save: open a project first"]);
}

#[test]
fn every_command_that_is_ready_can_be_asked_for_without_a_window() {
    for command in all() {
        // A test does not open dialogs of the system.
        if command.name == "Open project…" {
            continue;
        }
        let mut bench = TestBench::new();
        let request = command.requested(&bench.state);
        bench.request(request);
        bench.work.jobs.stop_all(&mut bench.state.running);
        bench.settle();
    }
}
