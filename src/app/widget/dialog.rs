//! Modal dialogs, which dim the window. While one is open, keys belong to it: Escape closes it, Enter presses its main
//! button, and only commands that do no harm there keep their keys.

use eframe::egui::{
    Align, Align2, Area, Context, Event, Id, Key, Layout, Modal, Modifiers, Popup, Response, ScrollArea, Ui,
    Vec2, vec2,
};

/// A dialog to be drawn.
pub struct Dialog {
    id: Id,
    width: f32,
    area: Area,
}

/// The keyboard input of the dialog in this frame.
pub struct Keys {
    /// Whether the dialog has just come to the front.
    opens: bool,
    /// Whether Enter was pressed and the focused widget does not use it.
    enter: bool,
}

/// The result of drawing a dialog.
pub struct Answer<T> {
    /// The value returned by its contents.
    pub inner: T,
    /// Whether Escape was pressed and the dialog is in front.
    pub escaped: bool,
    /// Whether the pointer was pressed outside of the dialog.
    beside: bool,
}

impl Dialog {
    /// Makes a dialog in the centre of the window, `width` points wide. `name` is its unique id.
    pub fn new(name: &'static str, width: f32) -> Self {
        let id = Id::unique(name);
        Self { id, width, area: Modal::default_area(id) }
    }

    /// Places the dialog elsewhere.
    pub fn at(self, place: Align2, offset: impl Into<Vec2>) -> Self {
        Self { area: self.area.anchor(place, offset), ..self }
    }

    /// Draws the dialog in front of those opened before.
    pub fn show<T>(self, context: &Context, contents: impl FnOnce(&mut Ui, &mut Keys) -> T) -> Answer<T> {
        let layer = self.area.layer();
        let is_in_front = context.memory(|memory| memory.top_modal_layer() == Some(layer));
        let opens = comes_to_the_front(context, self.id, is_in_front);
        if opens {
            // This press of Enter opened the dialog.
            context.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Enter));
        }
        let mut keys = Keys { opens, enter: is_in_front && enter_is_free(context) };
        let width = self.width.min(context.content_rect().width() - SIDES);
        let modal = Modal::new(self.id).area(self.area).show(context, |ui| {
            ui.set_width(width);
            contents(ui, &mut keys)
        });
        let may_escape = modal.is_top_modal && !modal.any_popup_open;
        let escaped =
            may_escape && context.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape));
        let beside = modal.backdrop_response.clicked() || modal.response.should_close();
        Answer { inner: modal.inner, escaped, beside }
    }
}

/// Draws the button that closes a dialog without a question, at its right.
pub fn at_the_right<T>(ui: &mut Ui, button: impl FnOnce(&mut Ui) -> T) -> T {
    let size = vec2(ui.available_width(), ui.spacing().interact_size.y);
    ui.allocate_ui_with_layout(size, Layout::right_to_left(Align::Center), button).inner
}

impl<T> Answer<T> {
    /// Returns whether the dialog was cancelled: by Escape, or by a click outside. Dialogs with typed text do not use
    /// it, because an accidental click must not discard the text.
    pub fn is_left(&self) -> bool {
        self.escaped || self.beside
    }
}

impl Keys {
    /// Returns whether the main button was pressed: by the pointer, or by Enter.
    pub fn press(&mut self, main: &Response) -> bool {
        main.clicked() || (main.enabled() && std::mem::take(&mut self.enter))
    }

    /// Returns whether a main button was pressed that has the focus when the dialog opens; only for harmless ones.
    pub fn press_first(&mut self, main: &Response) -> bool {
        self.begin_at(main);
        self.press(main)
    }

    /// Consumes Enter, which was for something else.
    pub fn take_enter(&mut self) {
        self.enter = false;
    }

    /// Gives a widget the focus when the dialog opens.
    pub fn begin_at(&self, widget: &Response) {
        if self.opens {
            widget.request_focus();
        }
    }
}

/// The width of a dialog's margins and of the window's edge beside it, in points.
const SIDES: f32 = 24.0;
/// The height of title, buttons and margins of a dialog, in points.
const FRAME: f32 = 150.0;

/// Draws contents that may be higher than the window: they scroll, so that title and buttons stay visible.
pub fn scrolled<T>(ui: &mut Ui, contents: impl FnOnce(&mut Ui) -> T) -> T {
    let highest = (ui.ctx().content_rect().height() - FRAME).max(FRAME);
    let area = ScrollArea::vertical().id_salt("contents").max_height(highest).auto_shrink([false, true]);
    area.show(ui, contents).inner
}

/// Returns whether a dialog was open in the previous frame, for widgets that read keys themselves.
pub fn is_open(context: &Context) -> bool {
    context.memory(|memory| memory.top_modal_layer().is_some())
}

/// Returns whether Escape was pressed and neither a dialog nor a text field uses it: for non-modal windows such as the
/// check and the list of keys.
pub fn escaped(context: &Context) -> bool {
    let waits = context.text_edit_focused() || is_open(context);
    !waits && context.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape))
}

/// Returns whether the dialog was not in front in the previous pass. The first pass of a dialog counts, and so does the
/// first one in which the dialog is known to be in front: before that, a dialog behind another one gets no focus.
fn comes_to_the_front(context: &Context, id: Id, is_in_front: bool) -> bool {
    let now = context.cumulative_pass_nr();
    let before = context.data(|data| data.get_temp::<u64>(id));
    if is_in_front {
        context.data_mut(|data| data.insert_temp(id, now));
    }
    before.is_none_or(|before| before + 1 < now)
}

/// Returns whether Enter was pressed, not repeated, while no button, list or slider has the focus. Enter in a text
/// field belongs to the dialog; no dialog has a text field of several lines.
fn enter_is_free(context: &Context) -> bool {
    let taken = context.memory(|memory| memory.focused()).is_some() && !context.text_edit_focused();
    let is_enter = |event: &Event| {
        let Event::Key { key: Key::Enter, pressed: true, repeat: false, modifiers, .. } = event else {
            return false;
        };
        modifiers.is_none()
    };
    !taken && !Popup::is_any_open(context) && context.input(|input| input.events.iter().any(is_enter))
}

#[cfg(test)]
mod tests {
    use eframe::egui::{Button, RawInput, TextEdit};

    use super::*;

    /// Makes the input of pressing or releasing a key.
    fn turn(key: Key, pressed: bool) -> RawInput {
        let event =
            Event::Key { key, physical_key: None, pressed, repeat: false, modifiers: Modifiers::NONE };
        RawInput { events: vec![event], ..RawInput::default() }
    }

    fn press(key: Key) -> RawInput {
        turn(key, true)
    }

    /// Draws a dialog with a text field and two buttons; returns whether the main one, the other one, and Escape were
    /// pressed.
    fn frame(context: &Context, input: RawInput, line: bool) -> (bool, bool, bool) {
        let mut pressed = (false, false, false);
        let _ = context.run_ui(input, |ui| {
            let mut text = String::new();
            let answer = Dialog::new("of a test", 200.0).show(ui.ctx(), |ui, keys| {
                let field = ui.add(TextEdit::singleline(&mut text));
                let main = ui.add(Button::new("Main"));
                let other = ui.add(Button::new("Other"));
                keys.begin_at(if line { &field } else { &other });
                (keys.press(&main), other.clicked())
            });
            let (main, other) = answer.inner;
            pressed = (pressed.0 | main, pressed.1 | other, pressed.2 | answer.escaped);
        });
        pressed
    }

    #[test]
    fn enter_in_a_line_presses_the_main_button_and_on_another_button_that_one() {
        for (line, expected) in [(true, (true, false, false)), (false, (false, true, false))] {
            let context = Context::default();
            assert_eq!(frame(&context, press(Key::Enter), line), (false, false, false), "not when it opens");
            for input in [turn(Key::Enter, false), RawInput::default()] {
                assert_eq!(frame(&context, input, line), (false, false, false));
            }
            assert_eq!(frame(&context, press(Key::Enter), line), expected, "in a line: {line}");
            assert_eq!(frame(&context, press(Key::Escape), line), (false, false, true));
        }
    }
}
