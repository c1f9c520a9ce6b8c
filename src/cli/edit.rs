//! `quadratura edit`: the window.

use serde_json::json;

use super::Outcome;
use super::args::EditArgs;
use crate::app;
use crate::error::Result;

pub fn run(args: &EditArgs) -> Result<Outcome> {
    let frames = app::run(args.project.clone())?;
    Ok(Outcome { text: String::new(), json: json!({ "frames": frames }), problems: Vec::new() })
}
