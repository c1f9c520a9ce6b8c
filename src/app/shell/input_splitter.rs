//! Splits input so that typing and clicking take effect in order.
//!
//! A frame receives all input since the previous one, and looks up the keyboard's focus only once. In slow frames, a
//! field may get the focus by a click or key in the same frame as its first letters, which would be lost; so would
//! letters just before a click elsewhere. Such frames are split in two.

use std::collections::VecDeque;

use eframe::egui::{Context, Event, Plugin, RawInput};

/// Holds back the input of the next frame.
#[derive(Default)]
pub struct InputSplitter {
    held: VecDeque<Event>,
}

impl Plugin for InputSplitter {
    fn debug_name(&self) -> &'static str {
        "input splitter"
    }

    fn input_hook(&mut self, context: &Context, input: &mut RawInput) {
        let mut events: Vec<Event> = self.held.drain(..).collect();
        events.append(&mut input.events);
        self.held = events.split_off(turn(&events)).into();
        input.events = events;
        if !self.held.is_empty() {
            context.request_repaint();
        }
    }
}

/// The kind of an event with respect to focus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Hand {
    /// Text for the focused widget.
    Types,
    /// A click or a command, which may move the focus.
    Moves,
}

fn hand(event: &Event) -> Option<Hand> {
    match event {
        Event::Text(_) | Event::Paste(_) | Event::Ime(_) => Some(Hand::Types),
        Event::PointerButton { .. } => Some(Hand::Moves),
        Event::Key { pressed: true, modifiers, .. } if modifiers.command => Some(Hand::Moves),
        _ => None,
    }
}

fn is_press(event: &Event) -> bool {
    matches!(event, Event::Key { pressed: true, .. })
}

/// Returns the number of events for this frame: up to the change between typing and moving the focus.
fn turn(events: &[Event]) -> usize {
    let mut before = None;
    for (index, event) in events.iter().enumerate() {
        let now = hand(event);
        if now.is_some() && before.is_some() && now != before {
            // The press of a key precedes its text event, and belongs to it.
            let key = &events[index - 1];
            let of_letter = now == Some(Hand::Types) && hand(key).is_none() && is_press(key);
            return if of_letter { index - 1 } else { index };
        }
        before = now.or(before);
    }
    events.len()
}

#[cfg(test)]
mod tests {
    use eframe::egui::{Key, Modifiers, PointerButton, Pos2};

    use super::*;

    fn key(key: Key, modifiers: Modifiers) -> Event {
        Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers }
    }

    fn click(pressed: bool) -> Event {
        let button = PointerButton::Primary;
        Event::PointerButton { pos: Pos2::ZERO, button, pressed, modifiers: Modifiers::NONE }
    }

    fn text(letter: &str) -> Event {
        Event::Text(letter.into())
    }

    #[test]
    fn letters_after_the_keys_that_open_something_are_for_the_next_frame() {
        let events = [key(Key::P, Modifiers::COMMAND), key(Key::B, Modifiers::NONE), text("b"), text("u")];
        assert_eq!(turn(&events), 1);
        assert_eq!(turn(&events[1..]), 3, "they are one turn then");
        assert_eq!(
            turn(&[key(Key::P, Modifiers::COMMAND), text("b")]),
            1,
            "keys without a letter belong to this frame"
        );
    }

    #[test]
    fn letters_come_before_the_click_that_follows_them_and_after_the_one_before_them() {
        assert_eq!(turn(&[text("a"), text("b"), click(true), click(false)]), 2);
        assert_eq!(turn(&[click(true), click(false), text("a")]), 2);
        assert_eq!(turn(&[click(true), click(false), key(Key::Z, Modifiers::COMMAND)]), 3);
    }

    #[test]
    fn what_is_held_back_comes_with_the_next_frame_and_nothing_is_lost() {
        let (mut splitter, context) = (InputSplitter::default(), Context::default());
        let mut input = RawInput { events: vec![text("a"), click(true), text("b")], ..RawInput::default() };
        let mut message = Vec::new();
        for _ in 0..4 {
            splitter.input_hook(&context, &mut input);
            message.push(std::mem::take(&mut input.events).len());
        }
        assert_eq!(message, [1, 1, 1, 0]);
    }
}
