//! Commands on masks: what of a photo must not be used.

use eframe::egui::Key;

use super::{Command, Menu, PLAIN, WhyNot, ctrl, plain, with_project};
use crate::app::editor::Editor;
use crate::app::jobs::Kind;
use crate::app::layout::Pane;
use crate::app::masking::keeping::Work;
use crate::app::masking::{STEP, Tool};
use crate::recipe::masks::MaskEdit;

/// In the order of their menus.
pub const COMMANDS: &[&Command] = &[
    &BRUSH,
    &LASSO,
    &UNCOVER,
    &LARGER,
    &SMALLER,
    &SHOW,
    &LOOK,
    &LOOK_EVERYWHERE,
    &SUGGESTIONS,
    &ACCEPT,
    &ACCEPT_EVERYWHERE,
    &DISMISS,
    &OBJECT,
    &CLEAR,
];

const MASK: Command = Command { menu: Menu::Mask, ready: with_photo, ..PLAIN };

/// The brush.
pub const BRUSH: Command = Command {
    name: "Mask by brush",
    tooltip: "Marks what of the photo must not be used, by a round brush; Esc puts it away.",
    keys: &[plain(Key::B)],
    on: Some(|editor| editor.masking.tool == Some(Tool::Brush)),
    run: |editor, _| editor.take_up(Tool::Brush),
    ..MASK
};

/// The lasso.
pub const LASSO: Command = Command {
    name: "Mask by lasso",
    tooltip: "Marks what of the photo must not be used, by a line around it; Esc puts it away.",
    keys: &[plain(Key::L)],
    on: Some(|editor| editor.masking.tool == Some(Tool::Lasso)),
    run: |editor, _| editor.take_up(Tool::Lasso),
    ..MASK
};

/// The other way round.
pub const UNCOVER: Command = Command {
    name: "Uncover instead of mask",
    tooltip: "Brush and lasso take masks away; hold Ctrl to do that for one stroke.",
    keys: &[plain(Key::I)],
    on: Some(|editor| editor.masking.uncovers),
    run: |editor, _| editor.masking.uncovers = editor.switched_in_photo(editor.masking.uncovers),
    ..MASK
};

/// A larger brush.
pub const LARGER: Command = Command {
    name: "Larger brush",
    tooltip: "Makes the brush larger by a quarter.",
    keys: &[ctrl(Key::CloseBracket)],
    run: |editor, _| editor.resize_brush(STEP),
    ..MASK
};

/// A smaller brush.
pub const SMALLER: Command = Command {
    name: "Smaller brush",
    tooltip: "Makes the brush smaller by a quarter.",
    keys: &[ctrl(Key::OpenBracket)],
    run: |editor, _| editor.resize_brush(1.0 / STEP),
    ..MASK
};

/// Whether masks are drawn.
pub const SHOW: Command = Command {
    name: "Masks",
    tooltip: "Draws over the photo what of it is masked.",
    keys: &[plain(Key::M)],
    on: Some(|editor| editor.masking.shown),
    run: |editor, _| editor.masking.shown = editor.switched_in_photo(editor.masking.shown),
    ..MASK
};

/// Strangers in one photo.
pub const LOOK: Command = Command {
    name: "Look for people and cars",
    tooltip: "Looks in this photo for what no other photo shows, such as people and cars; you decide what is masked.",
    starts_group: true,
    ready: |editor| can_look(editor).and(with_photo(editor)),
    run: |editor, _| {
        let photo = editor.selected_photo_name();
        editor.look_for_strangers(photo.into_iter().collect());
    },
    ..MASK
};

/// Strangers in all photos.
pub const LOOK_EVERYWHERE: Command = Command {
    name: "Look for people and cars in all photos",
    tooltip: "Looks in every photo for what no other photo shows; you decide what is masked.",
    ready: can_look,
    run: |editor, _| editor.look_for_strangers(Vec::new()),
    ..MASK
};

/// Whether suggestions are drawn.
pub const SUGGESTIONS: Command = Command {
    name: "Suggestions",
    tooltip: "Draws outlines around what was found that might be masked; a click on one masks it.",
    on: Some(|editor| editor.masking.suggested.shown),
    run: |editor, _| editor.masking.suggested.shown ^= true,
    ..MASK
};

/// All suggestions for the photo.
pub const ACCEPT: Command = Command {
    name: "Mask all suggestions",
    tooltip: "Masks everything that is suggested in this photo.",
    ready: with_suggestion,
    run: |editor, _| {
        let numbers = editor.open_suggestions();
        editor.accept_suggestions(&numbers);
    },
    ..MASK
};

/// All suggestions.
pub const ACCEPT_EVERYWHERE: Command = Command {
    name: "Mask all suggestions in all photos",
    tooltip: "Masks everything that is suggested in any photo.",
    ready: |editor| match editor.masking.suggested.count() {
        0 => Err(NO_SUGGESTION),
        _ => Ok(()),
    },
    run: |editor, _| {
        let numbers = editor.all_suggestions();
        editor.accept_suggestions(&numbers);
    },
    ..MASK
};

/// No suggestion.
pub const DISMISS: Command = Command {
    name: "Dismiss suggestions",
    tooltip: "Forgets what is suggested in this photo, until one looks again.",
    ready: with_suggestion,
    run: |editor, _| {
        let numbers = editor.open_suggestions();
        editor.dismiss_suggestions(&numbers);
    },
    ..MASK
};

/// An object in a photo.
pub const OBJECT: Command = Command {
    name: "Mask object in this photo",
    tooltip: "Marks what the photo shows of the selected object, with a margin, as not to be used.",
    starts_group: true,
    ready: |editor| {
        with_photo(editor)?;
        editor.selected_object().map(|_| ()).ok_or("select an object or a face")
    },
    run: |editor, _| editor.mask_object(),
    ..MASK
};

/// No mask.
pub const CLEAR: Command = Command {
    name: "Remove masks",
    tooltip: "Takes all masks of the selected photo away.",
    ready: |editor| {
        let name = editor.selected_photo_name().ok_or(NO_PHOTO)?;
        let session = editor.session.as_ref().ok_or("open a project first")?;
        let masked = !session.history.present().masks.of(&name).is_empty();
        if masked { Ok(()) } else { Err("the photo has no mask") }
    },
    run: |editor, _| {
        if let Some(photo) = editor.selected_photo_name() {
            let name = format!("removal of masks of {photo}");
            editor.mask(name, Work::Edits(vec![MaskEdit::Clear { photo }].into()));
        }
    },
    ..MASK
};

const NO_PHOTO: WhyNot = "select a photo first";
const NO_SUGGESTION: WhyNot = "look for people and cars first";

fn with_photo(editor: &Editor) -> Result<(), WhyNot> {
    with_project(editor)?;
    editor.selected_photo().map(|_| ()).ok_or(NO_PHOTO)
}

fn with_suggestion(editor: &Editor) -> Result<(), WhyNot> {
    with_photo(editor)?;
    if editor.open_suggestions().is_empty() { Err("nothing is suggested in this photo") } else { Ok(()) }
}

fn can_look(editor: &Editor) -> Result<(), WhyNot> {
    let session = editor.session.as_ref().ok_or("open a project first")?;
    if editor.jobs.runs(Kind::Suggest) {
        return Err("it is being looked for");
    }
    // What is asked is where photos show the same surface.
    if session.opened.site.photos.len() < 3 { Err("it takes three photos at least") } else { Ok(()) }
}

impl Editor {
    /// Takes a tool up in the photo's view, or puts it away where that is seen.
    fn take_up(&mut self, tool: Tool) {
        let is_on = self.masking.tool == Some(tool);
        if self.switched_in_photo(is_on) != is_on {
            self.masking.toggle(tool);
        }
    }

    /// A switch of the photo's view after it was pressed: the other way round where that view is seen. Where it is not
    /// it comes to the front, and the switch is on: nothing changes that nobody sees.
    fn switched_in_photo(&mut self, is_on: bool) -> bool {
        let is_seen = self.layout.is_shown(Pane::Photo);
        self.layout.show(Pane::Photo);
        !is_seen || !is_on
    }

    fn resize_brush(&mut self, factor: f64) {
        if let Some(size) = self.selected_photo_size() {
            self.masking.resize(factor, size);
        }
    }

    fn mask_object(&mut self) {
        let (Some(photo), Some(object)) = (self.selected_photo_name(), self.selected_object()) else {
            return;
        };
        let margin_px = self.masking.margin_px;
        self.mask(format!("mask of {object} in {photo}"), Work::Object { photo, object, margin_px });
    }
}

#[cfg(test)]
mod tests {
    use eframe::egui::Context;

    use super::*;

    #[test]
    fn a_switch_of_the_photo_shows_the_photo_before_it_switches_anything_off() {
        let mut editor = Editor::new(&Context::default(), None, None);
        for (command, is_on) in [
            (&BRUSH, false),
            (&BRUSH, true),
            (&LASSO, false),
            (&UNCOVER, false),
            (&UNCOVER, true),
            (&SHOW, true),
        ] {
            let on = command.on.expect("it switches");
            editor.layout.show(Pane::Photo);
            while on(&editor) != is_on {
                (command.run)(&mut editor, &Context::default());
            }
            editor.layout.show(Pane::Space);
            (command.run)(&mut editor, &Context::default());
            assert!(on(&editor) && editor.layout.is_shown(Pane::Photo), "{} from the 3D view", command.name);
            (command.run)(&mut editor, &Context::default());
            assert!(!on(&editor), "{} in the photo's view", command.name);
        }
    }
}
