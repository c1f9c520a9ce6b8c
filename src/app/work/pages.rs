//! The documents of the program as pages for the browser, in a folder of the user.

use std::fs;
use std::path::{Path, PathBuf};

use pulldown_cmark::html::push_html;
use pulldown_cmark::{CowStr, Event, Options, Parser, Tag, TagEnd};

use crate::state::guide::Document;
use quadratura_base::error::{Error, Result};
use quadratura_files::atomic::write_atomically;

/// The looks of all pages.
const STYLE: &str = "\
:root { color-scheme: light dark; font: 16px/1.5 sans-serif }
body { max-width: 56em; margin: 1em auto; padding: 0 1em }
table { border-collapse: collapse }
th, td { border: 1px solid gray; padding: 0.2em 0.5em; text-align: left; vertical-align: top }
pre { overflow: auto; border: 1px solid gray; padding: 0.5em }
p:empty { display: none }";

/// Returns the file of a document's page in `folder`.
pub fn file_in(folder: &Path, document: Document) -> PathBuf {
    folder.join(format!("{}.html", document.stem))
}

/// Writes the pages of all documents to `folder`, because they link to each other. Files that are up to date stay.
///
/// # Errors
/// [`Error::Io`] when the folder or a file cannot be written.
pub fn write_pages(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
    for document in Document::ALL {
        let (file, page) = (file_in(folder, document), page(document));
        if fs::read(&file).ok().as_deref() != Some(page.as_bytes()) {
            write_atomically(&file, page.as_bytes())?;
        }
    }
    Ok(())
}

/// Returns a document as HTML. Pictures are left out, and links to what is not among the documents are plain text.
fn page(document: Document) -> String {
    let mut events: Vec<Event<'_>> = Vec::new();
    let (mut heading, mut in_picture, mut is_plain) = (0, false, false);
    for event in Parser::new_ext(document.text, Options::ENABLE_TABLES) {
        match event {
            Event::Start(Tag::Image { .. }) => in_picture = true,
            Event::End(TagEnd::Image) => in_picture = false,
            _ if in_picture => (),
            Event::Start(Tag::Link { link_type, dest_url, title, id }) => match target(&dest_url) {
                Some(target) => {
                    let dest_url = CowStr::from(target);
                    events.push(Event::Start(Tag::Link { link_type, dest_url, title, id }));
                }
                None => is_plain = true,
            },
            Event::End(TagEnd::Link) if is_plain => is_plain = false,
            Event::Start(Tag::Heading { .. }) => {
                heading = events.len();
                events.push(event);
            }
            Event::End(TagEnd::Heading(_)) => {
                let words = events[heading..].iter().filter_map(words).collect::<String>();
                if let Event::Start(Tag::Heading { id, .. }) = &mut events[heading] {
                    *id = Some(anchor(&words).into());
                }
                events.push(event);
            }
            event => events.push(event),
        }
    }
    let link = |document: Document| format!("<a href=\"{}.html\">{}</a>", document.stem, document.name);
    let (name, links) = (document.name, Document::ALL.map(link).join(" · "));
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{name} – Quadratura</title>\n\
         <style>\n{STYLE}\n</style>\n<nav>{links}</nav>\n"
    );
    push_html(&mut page, events.into_iter());
    page
}

/// Returns where a link of a document leads from its page; none where there is no such page.
fn target(url: &str) -> Option<String> {
    if url.starts_with('#') || url.starts_with("https://") {
        return Some(url.to_owned());
    }
    let (stem, anchor) = url.split_once(".md")?;
    let is_here = Document::ALL.iter().any(|document| document.stem == stem);
    is_here.then(|| format!("{stem}.html{anchor}"))
}

fn words<'a>(event: &'a Event<'_>) -> Option<&'a str> {
    match event {
        Event::Text(words) | Event::Code(words) => Some(words),
        _ => None,
    }
}

/// Returns the anchor that links give a heading: lower case, blanks as hyphens, other signs dropped.
fn anchor(heading: &str) -> String {
    let kept = heading.to_lowercase().replace(' ', "-");
    kept.chars().filter(|sign| sign.is_alphanumeric() || matches!(sign, '-' | '_')).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &'static str) -> String {
        let page = page(Document { text, ..Document::GUIDE });
        page.split_once("</nav>\n").unwrap().1.to_owned()
    }

    #[test]
    fn links_between_documents_lead_to_their_pages_and_pictures_are_left_out() {
        let text = "# One `two`\n\n![a](b.jpg) [c](window.md#d) [e](quality.md) [f](#g) [h](https://i)\n";
        let expected = "<h1 id=\"one-two\">One <code>two</code></h1>\n<p> <a href=\"window.html#d\">c</a> e \
                        <a href=\"#g\">f</a> <a href=\"https://i\">h</a></p>\n";
        assert_eq!(shown(text), expected);
    }

    #[test]
    fn every_link_of_a_page_leads_to_a_heading() {
        for document in Document::ALL {
            let page = page(document);
            let links: Vec<&str> =
                page.split("href=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
            assert!(links.len() >= Document::ALL.len(), "{} has links", document.name);
            for link in links.into_iter().filter(|link| !link.starts_with("https://")) {
                let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
                let named = |other: &&Document| format!("{}.html", other.stem) == file;
                let other = Document::ALL.iter().find(named).copied().unwrap_or(document);
                let leads = anchor.is_empty() || super::page(other).contains(&format!("id=\"{anchor}\""));
                assert!(leads && (file.is_empty() || other.stem == file.trim_end_matches(".html")), "{link}");
            }
        }
    }

    #[test]
    fn only_pages_that_differ_are_written() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("new");
        write_pages(&folder).unwrap();
        let file = file_in(&folder, Document::GUIDE);
        let before = fs::metadata(&file).unwrap().modified().unwrap();
        fs::write(file_in(&folder, Document::WINDOW), "former").unwrap();
        write_pages(&folder).unwrap();
        assert_eq!(fs::metadata(&file).unwrap().modified().unwrap(), before);
        assert_eq!(fs::read_to_string(file_in(&folder, Document::WINDOW)).unwrap(), page(Document::WINDOW));
    }
}
