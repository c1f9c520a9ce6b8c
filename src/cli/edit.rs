//! `quadratura edit`: the window.

use serde_json::json;

use super::Outcome;
use super::args::EditArgs;
use crate::app;
use crate::error::Result;

pub fn run(args: &EditArgs) -> Result<Outcome> {
    app::run(args.project.clone())?;
    Ok(Outcome { text: String::new(), json: json!({}), problems: Vec::new() })
}
