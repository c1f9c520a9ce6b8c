//! The kinds of widgets that can have the keyboard's focus: a view or a list, which take it with a click, or a control,
//! such as a button or a text field.

use eframe::egui::{Context, Id, Response};

/// The kind of widget that has the keyboard's focus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FocusKind {
    /// No widget.
    Nothing,
    /// A view of the centre.
    View,
    /// A list, in which arrows and Enter have functions of their own.
    List,
    /// Any other widget, which Enter and Space press.
    Control,
}

/// The widgets that were drawn as views and lists.
#[derive(Debug, Clone, Default)]
struct KnownWidgets(Vec<(Id, FocusKind)>);

/// Records that a widget is a view or a list.
pub fn mark(response: &Response, kind: FocusKind) {
    response.ctx.data_mut(|data| {
        let known: &mut KnownWidgets = data.get_temp_mut_or_default(Id::NULL);
        known.0.retain(|(id, _)| *id != response.id);
        known.0.push((response.id, kind));
    });
}

/// Returns the kind of widget that has the focus.
pub fn focused(context: &Context) -> FocusKind {
    let Some(focused) = context.memory(|memory| memory.focused()) else { return FocusKind::Nothing };
    let known: KnownWidgets = context.data(|data| data.get_temp(Id::NULL)).unwrap_or_default();
    known.0.into_iter().find(|(id, _)| *id == focused).map_or(FocusKind::Control, |(_, kind)| kind)
}
