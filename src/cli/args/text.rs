//! Arguments of `text`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use quadratura_views::frame::FORMS;

#[derive(Debug, Args)]
pub struct TextArgs {
    #[command(subcommand)]
    pub command: TextCommand,
}

#[derive(Debug, Subcommand)]
pub enum TextCommand {
    /// Add a text at a place, or all texts of a file
    Add(TextAddArgs),
    /// List the texts, and what the page says beside them
    List {
        /// The project folder
        project: PathBuf,
    },
    /// Remove texts
    Remove(TextRemoveArgs),
    /// Set the title of the page, who is named below it, and the licence of the photos
    About(TextAboutArgs),
}

#[derive(Debug, Args)]
#[command(after_help = format!("POINT is {FORMS}."))]
pub struct TextAddArgs {
    /// The project folder
    pub project: PathBuf,
    /// A JSON file with a list of texts, each with `title`, `text` and `at`, and with `link`, `view` and `language` where wanted
    #[arg(value_name = "FILE", required_unless_present = "title", conflicts_with_all = ["title", "text", "at"])]
    pub file: Option<PathBuf>,
    /// The title, by which visitors choose it
    #[arg(long, value_name = "TEXT", requires_all = ["text", "at"])]
    pub title: Option<String>,
    /// The text, plain; line feeds are kept
    #[arg(long, value_name = "TEXT", requires = "title")]
    pub text: Option<String>,
    /// The place
    #[arg(long, value_name = "POINT", requires = "title", allow_hyphen_values = true)]
    pub at: Option<String>,
    /// Where more is to be read: an address with http, https or mailto, or one relative to the page
    #[arg(long, value_name = "URL", requires = "title")]
    pub link: Option<String>,
    /// The bookmark from which one looks at the place
    #[arg(long, value_name = "NAME", requires = "title")]
    pub view: Option<String>,
    /// The language of the text, such as fr or pt-BR
    #[arg(long, value_name = "TAG", requires = "title")]
    pub language: Option<String>,
    /// Replace the text that has this title
    #[arg(long)]
    pub replace: bool,
}

#[derive(Debug, Args)]
pub struct TextRemoveArgs {
    /// The project folder
    pub project: PathBuf,
    /// The texts, by number as listed or by title
    #[arg(required = true, value_name = "NUMBER|TITLE")]
    pub texts: Vec<String>,
}

#[derive(Debug, Args)]
pub struct TextAboutArgs {
    /// The project folder
    pub project: PathBuf,
    /// The title of the page; an empty one forgets it
    #[arg(long, value_name = "TEXT")]
    pub title: Option<String>,
    /// Who is to be named below the page, in place of those before; may be given several times, and an empty one forgets all
    #[arg(long, value_name = "TEXT")]
    pub credit: Vec<String>,
    /// The licence of the photos: an SPDX name such as CC-BY-4.0, or the address of a text; an empty one forgets it
    #[arg(long, value_name = "NAME|URL")]
    pub licence: Option<String>,
}
