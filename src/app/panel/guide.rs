//! The documents of the program in its window, and its name and version.

use eframe::egui::{ComboBox, Context, RichText, ScrollArea, Ui, Window};

use super::named;
use crate::app::state::State;
use crate::app::state::guide::Guide;
use crate::app::widget::dialog::escaped;

/// The documents: name and text.
const DOCUMENTS: &[(&str, &str)] = &[
    ("The window", include_str!("../../../docs/window.md")),
    ("Painting", include_str!("../../../docs/editing.md")),
    ("Words", include_str!("../../../docs/glossary.md")),
    ("Files and formats", include_str!("../../../docs/formats.md")),
    ("The method", include_str!("../../../docs/method.md")),
];

/// Draws the documents and *About* while they are open.
pub fn guide_ui(state: &State, guide: &mut Guide, context: &Context) {
    if guide.documents_shown {
        let window = Window::new("Documents").open(&mut guide.documents_shown);
        let window = window.default_size([680.0, 560.0]).vscroll(false);
        let document = &mut guide.document;
        window.show(context, |ui| documents_ui(ui, document));
        guide.documents_shown &= !escaped(context);
    }
    if guide.about_shown {
        let window = Window::new("About Quadratura").open(&mut guide.about_shown).resizable(false);
        window.show(context, |ui| about_ui(state, ui));
        guide.about_shown &= !escaped(context);
    }
}

fn documents_ui(ui: &mut Ui, chosen: &mut usize) {
    let (name, text) = DOCUMENTS[(*chosen).min(DOCUMENTS.len() - 1)];
    let combo = ComboBox::from_id_salt("document").selected_text(name).width(200.0).show_ui(ui, |ui| {
        for (index, (name, _)) in DOCUMENTS.iter().enumerate() {
            ui.selectable_value(chosen, index, *name);
        }
    });
    named(&combo.response, "Document");
    ui.separator();
    ScrollArea::vertical().id_salt(name).auto_shrink(false).show(ui, |ui| text_ui(ui, text));
}

/// Draws a document: headings, paragraphs, and lines of tables and programs as they are. Pictures are left out.
fn text_ui(ui: &mut Ui, text: &str) {
    for block in blocks(text) {
        match block {
            Block::Heading(text) => {
                ui.add_space(8.0);
                ui.label(RichText::new(text).heading());
            }
            Block::Paragraph(text) => drop(ui.label(text)),
            Block::Fixed(text) => drop(ui.monospace(text)),
        }
    }
}

/// A part of a document.
#[derive(Debug, PartialEq, Eq)]
enum Block {
    Heading(String),
    Paragraph(String),
    Fixed(String),
}

/// Splits a document into blocks, at empty lines.
fn blocks(text: &str) -> Vec<Block> {
    let paragraphs = text.split("\n\n").map(|part| part.trim_matches('\n')).filter(|part| !part.is_empty());
    let block = |part: &str| {
        if let Some(heading) = part.strip_prefix('#') {
            return Some(Block::Heading(plain(heading.trim_start_matches('#').trim())));
        }
        if part.starts_with("![") {
            return None;
        }
        let is_fixed = part.starts_with('|') || part.starts_with("    ") || part.starts_with("```");
        if is_fixed {
            return Some(Block::Fixed(part.to_owned()));
        }
        let is_list = part.lines().any(|line| line.starts_with("- ") || line.starts_with("1. "));
        let joined = if is_list { part.to_owned() } else { part.replace('\n', " ") };
        Some(Block::Paragraph(plain(&joined)))
    };
    paragraphs.filter_map(block).collect()
}

/// Removes the marks of emphasis and code.
fn plain(text: &str) -> String {
    text.replace("**", "").replace('`', "")
}

fn about_ui(state: &State, ui: &mut Ui) {
    ui.label(RichText::new(format!("Quadratura {}", env!("CARGO_PKG_VERSION"))).heading());
    ui.label("Image layers by proven visibility, from calibrated photos and a coarse model, to paint on and project back.");
    ui.add_space(4.0);
    ui.label(format!("Graphics device: {}", state.device.as_deref().unwrap_or("none in use")));
    ui.label(format!("Licence: {}", env!("CARGO_PKG_LICENSE")));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_document_has_headings_paragraphs_and_tables_and_no_pictures() {
        let text = "# One\n\nTwo `x`\nthree.\n\n| a |\n|---|\n\n![p](q.jpg)\n";
        let expected = [
            Block::Heading("One".into()),
            Block::Paragraph("Two x three.".into()),
            Block::Fixed("| a |\n|---|".into()),
        ];
        assert_eq!(blocks(text), expected);
        assert!(DOCUMENTS.iter().all(|(_, text)| blocks(text).len() > 10));
    }
}
