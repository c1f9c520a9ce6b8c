//! Commands on masks, which mark the pixels of a photo that must not be used.

use eframe::egui::Key;

use super::{Command, Menu, PLAIN, WhyNot, ctrl, plain, with_project};
use crate::state::State;
use crate::state::masking::STEP;
use crate::state::masking::keeping::MaskWork;
use crate::state::masking::queries::has_matte;
use crate::state::masking::tool::MaskTool;
use crate::state::request::{Flag, MaskRequest, WindowRequest};
use crate::state::running::JobKind;
use quadratura_document::stroke::BrushMode;
use quadratura_sites::masks::MaskEdit;

/// The commands in the order of their menus.
pub const COMMANDS: &[&Command] = &[
    &BRUSH,
    &LASSO,
    &UNCOVER,
    &SEE_THROUGH,
    &SOLID,
    &SOLVE,
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

/// Selects the brush.
pub const BRUSH: Command = Command {
    name: "Mask with brush",
    tooltip: "Masks parts of the photo that must not be used, with a round brush; Esc puts the brush away.",
    keys: &[plain(Key::B)],
    on: Some(|state| state.masking.tool == Some(MaskTool::Brush)),
    request: |_| MaskRequest::TakeUp(MaskTool::Brush).into(),
    ..MASK
};

/// Selects the lasso.
pub const LASSO: Command = Command {
    name: "Mask with lasso",
    tooltip: "Masks parts of the photo that must not be used, with a line around them; Esc puts the lasso away.",
    keys: &[plain(Key::L)],
    on: Some(|state| state.masking.tool == Some(MaskTool::Lasso)),
    request: |_| MaskRequest::TakeUp(MaskTool::Lasso).into(),
    ..MASK
};

/// Switches between masking and erasing.
pub const UNCOVER: Command = Command {
    name: "Erase mask",
    tooltip: "Brush and lasso erase masks; hold Ctrl to erase for one stroke.",
    keys: &[plain(Key::I)],
    on: Some(|state| state.masking.uncovers),
    request: |_| MaskRequest::Uncover.into(),
    ..MASK
};

/// The modes of the matte brush.
pub const MATTES: [&Command; 3] = [&SEE_THROUGH, &SOLID, &SOLVE];

/// Selects the matte brush that lets one see through.
pub const SEE_THROUGH: Command = Command {
    name: "Matte: see through",
    tooltip: "A brush that erases the selected see-through layer, or the nearest one: what is behind shows there.",
    starts_group: true,
    ready: with_matte,
    on: Some(|state| state.masking.tool == Some(MaskTool::Matte(BrushMode::SeeThrough))),
    request: |_| MaskRequest::TakeUp(MaskTool::Matte(BrushMode::SeeThrough)).into(),
    ..MASK
};

/// Selects the matte brush that makes solid.
pub const SOLID: Command = Command {
    name: "Matte: solid",
    tooltip: "A brush that makes the selected see-through layer, or the nearest one, solid, in the photo's colours.",
    ready: with_matte,
    on: Some(|state| state.masking.tool == Some(MaskTool::Matte(BrushMode::Solid))),
    request: |_| MaskRequest::TakeUp(MaskTool::Matte(BrushMode::Solid)).into(),
    ..MASK
};

/// Selects the matte brush that marks what is to be solved.
pub const SOLVE: Command = Command {
    name: "Matte: unknown, solve",
    tooltip: "A brush under which the matte is solved from the photo's colours, with the matte around it as known.",
    ready: with_matte,
    on: Some(|state| state.masking.tool == Some(MaskTool::Matte(BrushMode::Solve))),
    request: |_| MaskRequest::TakeUp(MaskTool::Matte(BrushMode::Solve)).into(),
    ..MASK
};

/// Makes the brush larger.
pub const LARGER: Command = Command {
    name: "Larger brush",
    tooltip: "Makes the brush larger by a quarter.",
    keys: &[ctrl(Key::CloseBracket)],
    request: |_| MaskRequest::ResizeBrush(STEP).into(),
    ..MASK
};

/// Makes the brush smaller.
pub const SMALLER: Command = Command {
    name: "Smaller brush",
    tooltip: "Makes the brush smaller by a quarter.",
    keys: &[ctrl(Key::OpenBracket)],
    request: |_| MaskRequest::ResizeBrush(1.0 / STEP).into(),
    ..MASK
};

/// Shows or hides masks.
pub const SHOW: Command = Command {
    name: "Masks",
    tooltip: "Shows masks over the photo.",
    keys: &[plain(Key::M)],
    on: Some(|state| state.masking.shown),
    request: |_| MaskRequest::Show.into(),
    ..MASK
};

/// Finds transient objects in one photo.
pub const LOOK: Command = Command {
    name: "Find transient objects",
    tooltip: "Finds objects that only this photo shows, such as people and cars; you decide what is masked.",
    starts_group: true,
    ready: |state| can_look(state).and(with_photo(state)),
    request: |state| MaskRequest::Look(state.selected_photo_name().into_iter().collect()).into(),
    ..MASK
};

/// Finds transient objects in all photos.
pub const LOOK_EVERYWHERE: Command = Command {
    name: "Find transient objects in all photos",
    tooltip: "Finds objects that only one photo shows, in all photos; you decide what is masked.",
    ready: can_look,
    request: |_| MaskRequest::Look(Vec::new()).into(),
    ..MASK
};

/// Shows or hides suggestions.
pub const SUGGESTIONS: Command = Command {
    name: "Suggestions",
    tooltip: "Outlines suggested masks; a click on an outline masks its area.",
    on: Some(|state| state.masking.suggested.shown),
    request: |_| WindowRequest::Flip(Flag::Suggestions).into(),
    ..MASK
};

/// Accepts all suggestions for the photo.
pub const ACCEPT: Command = Command {
    name: "Mask all suggestions",
    tooltip: "Masks all suggestions in this photo.",
    ready: with_suggestion,
    request: |state| MaskRequest::Accept(state.open_suggestions()).into(),
    ..MASK
};

/// Accepts all suggestions.
pub const ACCEPT_EVERYWHERE: Command = Command {
    name: "Mask all suggestions in all photos",
    tooltip: "Masks all suggestions in all photos.",
    ready: |state| match state.masking.suggested.count() {
        0 => Err(NO_SUGGESTION),
        _ => Ok(()),
    },
    request: |state| MaskRequest::Accept(state.all_suggestions()).into(),
    ..MASK
};

/// Dismisses suggestions.
pub const DISMISS: Command = Command {
    name: "Dismiss suggestions",
    tooltip: "Removes the suggestions in this photo, until the next search.",
    ready: with_suggestion,
    request: |state| MaskRequest::Dismiss(state.open_suggestions()).into(),
    ..MASK
};

/// Masks an object in a photo.
pub const OBJECT: Command = Command {
    name: "Mask object in this photo",
    tooltip: "Masks what the photo shows of the selected object, with a margin.",
    starts_group: true,
    ready: |state| {
        with_photo(state)?;
        state.selected_object().map(|_| ()).ok_or("select an object or a face")
    },
    request: |_| MaskRequest::Object.into(),
    ..MASK
};

/// Removes the mask of the photo.
pub const CLEAR: Command = Command {
    name: "Remove masks",
    tooltip: "Removes all masks of the selected photo.",
    ready: |state| {
        let name = state.selected_photo_name().ok_or(NO_PHOTO)?;
        let session = state.session.as_ref().ok_or("open a project first")?;
        let masked = !session.history.present().masks.of(&name).is_empty();
        if masked { Ok(()) } else { Err("the photo has no mask") }
    },
    request: |state| {
        let photo = state.selected_photo_name().unwrap_or_default();
        let name = format!("removal of masks of {photo}");
        MaskRequest::Mask(name, MaskWork::Edits(vec![MaskEdit::Clear { photo }].into())).into()
    },
    ..MASK
};

const NO_PHOTO: WhyNot = "select a photo first";
const NO_SUGGESTION: WhyNot = "find transient objects first";

fn with_photo(state: &State) -> Result<(), WhyNot> {
    with_project(state)?;
    state.selected_photo().map(|_| ()).ok_or(NO_PHOTO)
}

fn with_matte(state: &State) -> Result<(), WhyNot> {
    with_photo(state)?;
    match state.selected_stack().is_some_and(has_matte) {
        true => Ok(()),
        false => {
            Err("no layer of this photo has a matte: declare objects see-through and fill occluded areas")
        }
    }
}

fn with_suggestion(state: &State) -> Result<(), WhyNot> {
    with_photo(state)?;
    if state.open_suggestions().is_empty() { Err("there are no suggestions in this photo") } else { Ok(()) }
}

fn can_look(state: &State) -> Result<(), WhyNot> {
    let session = state.session.as_ref().ok_or("open a project first")?;
    if state.running.runs(JobKind::Suggest) {
        return Err("the search is already running");
    }
    // Transient objects are found by comparing photos of the same surface.
    if session.opened.site.photos.len() < 3 { Err("at least three photos are needed") } else { Ok(()) }
}
