//! The command `text`.

use std::path::Path;

use serde_json::json;

use super::Outcome;
use super::args::{TextAboutArgs, TextAddArgs, TextArgs, TextCommand, TextRemoveArgs};
use super::lock::{lock_and_read, read_with_lock_if};
use super::table::{Table, counted};
use super::words::command_for_project;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_document::{PageDecisions, PlaceText, Project};
use quadratura_files::json::read_json;
use quadratura_io::project::write_project;
use quadratura_sites::open::open_site;
use quadratura_views::frame::point_named;

/// The most bytes of a file of texts.
const LARGEST: u64 = 1 << 22;
const REMEDY: &str = "docs/page.md says what the file holds";
/// The number of characters of a text that are listed.
const LISTED: usize = 60;

/// Runs `text`.
pub fn run(args: &TextArgs, task: &Task) -> Result<Outcome> {
    match &args.command {
        TextCommand::Add(args) => add(args, task),
        TextCommand::List { project } => {
            let (_, read) = read_with_lock_if(false, project, task)?;
            Ok(outcome(&read))
        }
        TextCommand::Remove(args) => remove(args, task),
        TextCommand::About(args) => about(args, task),
    }
}

/// Runs `text add`.
fn add(args: &TextAddArgs, task: &Task) -> Result<Outcome> {
    let (_lock, project) = lock_and_read(&args.project, task)?;
    let (added, mut project) = match &args.file {
        Some(file) => (of_file(file)?, project),
        None => {
            let opened = open_site(&args.project, project, task)?;
            let place = point_named(&opened, args.at.as_deref().unwrap_or_default())?;
            (vec![typed(args, place.to_array())], opened.project)
        }
    };
    for text in added {
        check_view(&project, &text)?;
        match project.texts.iter().position(|other| other.title == text.title) {
            Some(at) if args.replace => project.texts[at] = text,
            Some(at) => {
                return Err(Error::Request(format!(
                    "text {} already has the title {:?}; give it another one, or --replace",
                    at + 1,
                    text.title
                )));
            }
            None => project.texts.push(text),
        }
    }
    write_project(&args.project, &project)?;
    Ok(outcome(&project))
}

/// Returns the text that the arguments describe.
fn typed(args: &TextAddArgs, at: [f64; 3]) -> PlaceText {
    PlaceText {
        title: args.title.clone().unwrap_or_default(),
        text: args.text.clone().unwrap_or_default(),
        at,
        link: args.link.clone(),
        view: args.view.clone(),
        language: args.language.clone(),
    }
}

/// Reads texts, and checks each.
fn of_file(file: &Path) -> Result<Vec<PlaceText>> {
    let texts: Vec<PlaceText> = read_json(file, LARGEST, REMEDY)?;
    match texts.iter().enumerate().find_map(|(at, text)| Some((at, text.problem()?))) {
        Some((at, problem)) => Err(Error::input(file, format!("text {}", at + 1), problem, REMEDY)),
        None => Ok(texts),
    }
}

/// Checks a text, and that its bookmark exists.
fn check_view(project: &Project, text: &PlaceText) -> Result<()> {
    if let Some(problem) = text.problem() {
        return Err(Error::Request(problem));
    }
    let Some(view) = &text.view else { return Ok(()) };
    if project.views.iter().any(|bookmark| bookmark.name == *view) {
        return Ok(());
    }
    let names: Vec<String> = project.views.iter().map(|bookmark| format!("{:?}", bookmark.name)).collect();
    let known = if names.is_empty() { "none; the window stores them".to_owned() } else { names.join(", ") };
    Err(Error::Request(format!("the project has no bookmark {view:?}; it has {known}")))
}

/// Runs `text remove`.
fn remove(args: &TextRemoveArgs, task: &Task) -> Result<Outcome> {
    let (_lock, mut project) = lock_and_read(&args.project, task)?;
    let named = |name: &String| {
        let by_title = project.texts.iter().position(|text| text.title == *name);
        let by_number = || name.parse::<usize>().ok()?.checked_sub(1).filter(|at| *at < project.texts.len());
        by_title.or_else(by_number).ok_or_else(|| {
            let list = command_for_project("text list");
            Error::Request(format!("there is no text {name:?}; {list} lists those that there are"))
        })
    };
    let mut removed = args.texts.iter().map(named).collect::<Result<Vec<usize>>>()?;
    removed.sort_unstable();
    removed.dedup();
    removed.into_iter().rev().for_each(|at| drop(project.texts.remove(at)));
    write_project(&args.project, &project)?;
    Ok(outcome(&project))
}

/// Runs `text about`.
fn about(args: &TextAboutArgs, task: &Task) -> Result<Outcome> {
    let changes = args.title.is_some() || args.licence.is_some() || !args.credit.is_empty();
    let (_lock, mut project) = read_with_lock_if(changes, &args.project, task)?;
    let said = |text: &String| (!text.is_empty()).then(|| text.clone());
    let page = &mut project.page;
    if let Some(title) = &args.title {
        page.title = said(title);
    }
    if let Some(licence) = &args.licence {
        page.licence = said(licence);
    }
    if !args.credit.is_empty() {
        page.credits = args.credit.iter().filter_map(said).collect();
    }
    if changes {
        write_project(&args.project, &project)?;
    }
    Ok(outcome(&project))
}

/// Returns the texts, and what the page says beside them.
fn outcome(project: &Project) -> Outcome {
    let text = format!("{}{}", listed(&project.texts), about_text(&project.page));
    let json = json!({ "texts": project.texts, "page": project.page });
    Outcome { text, json, problems: Vec::new() }
}

fn listed(texts: &[PlaceText]) -> String {
    if texts.is_empty() {
        let add = command_for_project("text add --title TITLE --text TEXT --at PHOTO:X,Y");
        return format!("no texts yet; {add} adds one\n");
    }
    let mut table = Table::new(&["", "title", "at", "seen from", "text"]);
    for (number, text) in (1..).zip(texts) {
        let line = text.text.replace('\n', " ");
        let more = if line.chars().count() > LISTED { "..." } else { "" };
        table.row([
            format!("{number}"),
            text.title.clone(),
            text.at.map(|value| format!("{value:.3}")).join(","),
            text.view.clone().unwrap_or_else(|| "-".to_owned()),
            line.chars().take(LISTED).chain(more.chars()).collect(),
        ]);
    }
    format!("{}{}\n", table.render().trim_start(), counted(texts.len(), "text"))
}

fn about_text(page: &PageDecisions) -> String {
    let line =
        |what: &str, said: Option<&str>| said.map(|said| format!("{what}: {said}\n")).unwrap_or_default();
    let credits: String = page.credits.iter().map(|credit| line("credit", Some(credit))).collect();
    let (title, licence) = (line("title", page.title.as_deref()), line("licence", page.licence.as_deref()));
    format!("{title}{credits}{licence}")
}
