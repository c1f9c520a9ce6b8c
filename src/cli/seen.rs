//! The command `paint`: where paint is seen.

use serde_json::json;

use super::Outcome;
use super::args::PaintArgs;
use super::lock::read_with_lock_if;
use super::painted::PaintReport;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Site;
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_document::paint::PaintBook;
use quadratura_io::paint_store::PaintStore;
use quadratura_io::project::change_project;
use quadratura_io::stack_store::StackStore;
use quadratura_sites::named::index_of_photo;
use quadratura_sites::open::open_site;
use quadratura_stacks::decide::faces_named;
use quadratura_stacks::fill::seen::{
    EditedPaint, Seen, SeenEdit, SeenReport, edited, exceptions_in_words, propagation_in_words,
};

/// Runs `paint`: changes where paint is seen as the arguments ask, and lists the paint with that.
pub fn run(args: &PaintArgs, task: &Task) -> Result<Outcome> {
    let (_lock, project) = read_with_lock_if(args.changes(), &args.project, task)?;
    let mut opened = open_site(&args.project, project, task)?;
    let book = PaintStore::new(&args.project).read()?;
    let before = opened.project.fill.clone();
    for edit in edits(args, &opened.site, &book)? {
        opened.project.fill = edited(&opened.project.fill, &edit, &opened.site.model);
    }
    let changed = opened.project.fill != before;
    if changed {
        let fill = &opened.project.fill;
        change_project(&args.project, |project| Ok(Project { fill: fill.clone(), ..project? }))?;
    }
    outcome(args, &opened.project, &opened.site, &book, changed)
}

impl PaintArgs {
    /// Returns true when something is to be changed.
    fn changes(&self) -> bool {
        self.seen().is_some() || !self.protect.is_empty() || !self.unprotect.is_empty()
    }

    fn seen(&self) -> Option<Seen> {
        match (self.everywhere, self.only_here) {
            (true, _) => Some(Seen::Everywhere),
            (_, true) => Some(Seen::OnlyHere),
            _ => None,
        }
    }
}

/// Returns the edits that the arguments ask for; all names that do not exist are one error.
fn edits(args: &PaintArgs, site: &Site, book: &PaintBook) -> Result<Vec<SeenEdit>> {
    let mut edits: Vec<Result<SeenEdit>> = Vec::new();
    let photo = |name: &String| {
        let id = index_of_photo(site, name)?;
        Ok(site.photo(id).name.clone())
    };
    if let Some(seen) = args.seen() {
        let edit = |paint| SeenEdit { paint, seen };
        let photos = args.photos.iter().map(|name| Ok(edit(EditedPaint::OfPhoto(photo(name)?))));
        edits.extend(photos);
        for typed in &args.surfaces {
            match faces_named(&site.model, None, typed) {
                Ok(faces) => edits.extend(faces.into_iter().map(|faces| Ok(edit(EditedPaint::On(faces))))),
                Err(error) => edits.push(Err(error)),
            }
        }
        let imports =
            args.imports.iter().map(|number| Ok(edit(EditedPaint::OfImport(import(*number, book)?))));
        edits.extend(imports);
        if edits.is_empty() {
            edits.push(Ok(edit(EditedPaint::All)));
        }
    }
    let lists = [(&args.protect, Seen::OnlyHere), (&args.unprotect, Seen::Everywhere)];
    for (names, seen) in lists {
        edits.extend(names.iter().map(|name| Ok(SeenEdit { paint: EditedPaint::To(photo(name)?), seen })));
    }
    let (edits, errors): (Vec<_>, Vec<_>) = edits.into_iter().partition(Result::is_ok);
    match Error::of_all(errors.into_iter().filter_map(Result::err).collect()) {
        Some(error) => Err(error),
        None => edits.into_iter().collect(),
    }
}

/// Returns the number of an import, if there is paint of it.
fn import(number: u32, book: &PaintBook) -> Result<u32> {
    let mut known: Vec<u32> = book.entries.iter().map(|entry| entry.import).collect();
    known.sort_unstable();
    known.dedup();
    if known.contains(&number) {
        return Ok(number);
    }
    let known: Vec<String> = known.iter().map(u32::to_string).collect();
    let there = if known.is_empty() { "no import".into() } else { format!("imports {}", known.join(", ")) };
    Err(Error::Request(format!("there is no paint of import {number}; the project has paint of {there}")))
}

fn outcome(
    args: &PaintArgs,
    project: &Project,
    site: &Site,
    book: &PaintBook,
    changed: bool,
) -> Result<Outcome> {
    let fill = &project.fill;
    let painted = PaintReport::new(site, &StackStore::new(&args.project))?;
    let seen = SeenReport::new(fill, site, book);
    let mut text = format!("{}\n", propagation_in_words(fill));
    exceptions_in_words(fill).iter().for_each(|line| text.push_str(&format!("  {line}\n")));
    seen.gone.iter().for_each(|line| text.push_str(&format!("  without effect: {line}\n")));
    text.push_str(&painted.text());
    if changed {
        text.push_str(&format!("\nrun `quadratura fill {}` to update the photos\n", args.project.display()));
    }
    let json = json!({ "changed": changed, "seen": seen, "paint": painted.to_json() });
    Ok(Outcome { text, json, problems: painted.problems() })
}
