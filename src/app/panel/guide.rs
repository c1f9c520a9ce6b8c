//! The documents of the program in its window, and its name and version.

use eframe::egui::text::{LayoutJob, TextFormat};
use eframe::egui::{ComboBox, Context, Frame, Label, RichText, ScrollArea, TextStyle, Ui, Window};

use super::named;
use crate::state::State;
use crate::state::guide::Guide;
use crate::widget::dialog::escaped;

/// The documents: name and text.
const DOCUMENTS: &[(&str, &str)] = &[
    ("Guide", include_str!("../../../docs/guide.md")),
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

/// Draws a document. Pictures are left out.
fn text_ui(ui: &mut Ui, text: &str) {
    for block in blocks(text) {
        match block {
            Block::Heading(level, text) => {
                ui.add_space(10.0);
                let size = if level == 1 { TextStyle::Heading } else { TextStyle::Body };
                ui.label(RichText::new(text).text_style(size).strong());
            }
            Block::Paragraph(text) => drop(ui.label(formatted(ui, &text, TextStyle::Body))),
            Block::Item(level, mark, text) => {
                ui.horizontal_top(|ui| {
                    ui.add_space(8.0 + 16.0 * level as f32);
                    ui.label(mark);
                    ui.add(Label::new(formatted(ui, &text, TextStyle::Body)).wrap());
                });
            }
            Block::Row(cells) => row_ui(ui, &cells),
            Block::Fixed(text) => {
                Frame::new().inner_margin(6.0).fill(ui.visuals().extreme_bg_color).show(ui, |ui| {
                    ui.monospace(text);
                });
            }
        }
    }
}

/// The share of the width that the first column of a table takes.
const FIRST_COLUMN: f32 = 0.3;

/// Draws a row of a table, all columns after the first one of the same width.
fn row_ui(ui: &mut Ui, cells: &[String]) {
    let gap = ui.spacing().item_spacing.x;
    let room = ui.available_width() - gap * cells.len() as f32;
    let others = cells.len().saturating_sub(1).max(1) as f32;
    ui.horizontal_top(|ui| {
        for (column, cell) in cells.iter().enumerate() {
            let share = if column == 0 { FIRST_COLUMN } else { (1.0 - FIRST_COLUMN) / others };
            ui.scope(|ui| {
                ui.set_width(room * share);
                ui.add(Label::new(formatted(ui, cell, TextStyle::Body)).wrap());
            });
        }
    });
}

/// A part of a document.
#[derive(Debug, PartialEq, Eq)]
enum Block {
    /// A heading with its level, 1 for the title.
    Heading(usize, String),
    Paragraph(String),
    /// An item of a list: its level, its mark, and its text.
    Item(usize, String, String),
    /// The cells of a row of a table.
    Row(Vec<String>),
    /// Lines of a program or a file.
    Fixed(String),
}

/// Splits a document into blocks: it is read line by line, and lines that continue a paragraph or an item are joined.
fn blocks(text: &str) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut fence: Option<Vec<&str>> = None;
    let (mut in_picture, mut is_open) = (false, false);
    // The number of empty lines since the last indented line of a program.
    let mut indented: Option<usize> = None;
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            match fence.take() {
                Some(lines) => blocks.push(Block::Fixed(lines.join("\n"))),
                None => fence = Some(Vec::new()),
            }
            is_open = false;
            continue;
        }
        if let Some(lines) = &mut fence {
            lines.push(line);
            continue;
        }
        if let Some(line) = line.strip_prefix("    ").filter(|line| !is_open && !line.trim().is_empty()) {
            match (blocks.last_mut(), indented) {
                (Some(Block::Fixed(text)), Some(empty)) => {
                    text.push_str(&"\n".repeat(empty + 1));
                    text.push_str(line);
                }
                _ => blocks.push(Block::Fixed(line.to_owned())),
            }
            indented = Some(0);
            continue;
        }
        indented = indented.filter(|_| line.trim().is_empty()).map(|empty| empty + 1);
        in_picture = (in_picture || line.starts_with("![")) && !line.trim().is_empty();
        if in_picture || line.trim().is_empty() {
            is_open = false;
            continue;
        }
        match (starting(line), blocks.last_mut().filter(|_| is_open)) {
            (None, Some(Block::Paragraph(text) | Block::Item(_, _, text))) => {
                text.push(' ');
                text.push_str(line.trim());
            }
            (starting, _) => {
                let block = starting.unwrap_or_else(|| Block::Paragraph(line.trim().to_owned()));
                is_open = matches!(block, Block::Paragraph(_) | Block::Item(..));
                let is_rule =
                    |cells: &[String]| cells.iter().all(|cell| cell.trim_matches(['-', ':']).is_empty());
                match block {
                    Block::Row(cells) if is_rule(&cells) => (),
                    block => blocks.push(block),
                }
            }
        }
    }
    blocks
}

/// Returns the block that a line begins, where it shows by its first characters.
fn starting(line: &str) -> Option<Block> {
    let text = line.trim_start();
    let level = (line.len() - text.len()) / 2;
    if let Some(row) = text.strip_prefix('|') {
        let row = row.trim_end().trim_end_matches('|');
        return Some(Block::Row(row.split('|').map(|cell| cell.trim().to_owned()).collect()));
    }
    let hashes = line.bytes().take_while(|byte| *byte == b'#').count();
    if hashes > 0 {
        return Some(Block::Heading(hashes, plain(line[hashes..].trim())));
    }
    if let Some(item) = text.strip_prefix("- ") {
        return Some(Block::Item(level, "•".into(), item.to_owned()));
    }
    let (number, item) = text.split_once(". ")?;
    let is_number = !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
    is_number.then(|| Block::Item(level, format!("{number}."), item.to_owned()))
}

/// A look of a part of a text: plain, or any of these together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Look {
    strong: bool,
    emphasis: bool,
    code: bool,
}

/// Splits a text into parts by its marks of emphasis, code and links. Of a link its text stays.
fn parts(text: &str) -> Vec<(Look, String)> {
    let mut parts: Vec<(Look, String)> = Vec::new();
    let mut add = |look: Look, text: &str| match parts.last_mut().filter(|(last, _)| *last == look) {
        Some((_, before)) => before.push_str(text),
        None => parts.push((look, text.to_owned())),
    };
    let (mut look, mut rest) = (Look::default(), text);
    while let Some(next) = rest.chars().next() {
        let (length, turned) = match next {
            '`' => (1, Look { code: !look.code, ..look }),
            _ if look.code => (0, look),
            '*' if rest.starts_with("**") => (2, Look { strong: !look.strong, ..look }),
            // A star between spaces is a sign of its own.
            '*' if look.emphasis || !rest[1..].starts_with(' ') => {
                (1, Look { emphasis: !look.emphasis, ..look })
            }
            _ => (0, look),
        };
        if length > 0 {
            look = turned;
            rest = &rest[length..];
        } else if let Some((name, after)) = link(rest).filter(|_| !look.code) {
            add(look, &plain(name));
            rest = after;
        } else if let Some((sign, after)) = entity(rest) {
            add(look, sign);
            rest = after;
        } else {
            let (here, after) = rest.split_at(next.len_utf8());
            add(look, here);
            rest = after;
        }
    }
    parts
}

/// Returns the sign that is written as an entity at the beginning of a text, and what follows it.
fn entity(text: &str) -> Option<(&'static str, &str)> {
    let entities = [("&lt;", "<"), ("&gt;", ">"), ("&amp;", "&")];
    entities.iter().find_map(|(name, sign)| Some((*sign, text.strip_prefix(name)?)))
}

/// Returns the text of the link at the beginning of a text, and what follows it.
fn link(text: &str) -> Option<(&str, &str)> {
    let (name, after) = text.strip_prefix('[')?.split_once("](")?;
    let (_, after) = after.split_once(')')?;
    (!name.contains('[')).then_some((name, after))
}

/// Returns a text with its marks as looks.
fn formatted(ui: &Ui, text: &str, style: TextStyle) -> LayoutJob {
    let mut job = LayoutJob::default();
    let (font, code) = (style.resolve(ui.style()), TextStyle::Monospace.resolve(ui.style()));
    let visuals = ui.visuals();
    for (look, text) in parts(text) {
        let plain =
            TextFormat { font_id: font.clone(), color: visuals.text_color(), ..TextFormat::default() };
        let mut format = TextFormat { italics: look.emphasis, ..plain };
        if look.strong {
            format.color = visuals.strong_text_color();
        }
        if look.code {
            (format.font_id, format.background) = (code.clone(), visuals.code_bg_color);
        }
        job.append(&text, 0.0, format);
    }
    job
}

/// Removes the marks of emphasis, code and links.
fn plain(text: &str) -> String {
    parts(text).into_iter().map(|(_, text)| text).collect()
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
    fn a_document_has_headings_paragraphs_lists_and_tables_and_no_pictures() {
        let text = "# One\n\nTwo `x`\nthree.\n\n| a | b |\n|---|---|\n| c | d |\n\n![p\nq](q.jpg)\n\n- four\n  five\n\n```\n- six\n```\n\n    a *b\n\n      c\nd\n";
        let row = |cells: [&str; 2]| Block::Row(cells.map(str::to_owned).to_vec());
        let expected = [
            Block::Heading(1, "One".into()),
            Block::Paragraph("Two `x` three.".into()),
            row(["a", "b"]),
            row(["c", "d"]),
            Block::Item(0, "•".into(), "four five".into()),
            Block::Fixed("- six".into()),
            Block::Fixed("a *b\n\n  c".into()),
            Block::Paragraph("d".into()),
        ];
        assert_eq!(blocks(text), expected);
        let fixed = |text: &str| blocks(text).iter().filter(|block| matches!(block, Block::Fixed(_))).count();
        assert!(
            DOCUMENTS.iter().map(|(_, text)| fixed(text)).sum::<usize>() > 20,
            "examples are no paragraphs"
        );
        assert!(DOCUMENTS.iter().all(|(_, text)| blocks(text).len() > 10));
    }

    #[test]
    fn marks_are_looks_and_of_a_link_its_text_stays() {
        let plain_text = Look::default();
        let (strong, code) = (Look { strong: true, ..plain_text }, Look { code: true, ..plain_text });
        let expected = [
            (plain_text, "a ".to_owned()),
            (strong, "b ".into()),
            (Look { code: true, ..strong }, "f".into()),
            (strong, " g".into()),
            (plain_text, " ".into()),
            (code, "c*".into()),
            (plain_text, ", d [e] <i> 2 * 3".into()),
        ];
        assert_eq!(parts("a **b `f` g** `c*`, [d](x.md#y) [e] &lt;i&gt; 2 * 3"), expected);
        let all = DOCUMENTS.iter().flat_map(|(_, text)| blocks(text));
        let mut texts = all.filter_map(|block| match block {
            Block::Paragraph(text) | Block::Item(_, _, text) => Some(plain(&text)),
            _ => None,
        });
        assert_eq!(texts.find(|text| text.contains("**") || text.contains("](")), None);
    }
}
