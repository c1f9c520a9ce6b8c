//! The command `ldi`: layered depth images are built, inspected and rendered.

mod build;
mod info;
mod render;

use super::Outcome;
use super::args::{LdiArgs, LdiCommand};
use crate::error::Result;
use crate::task::Task;

/// Runs `ldi`.
pub fn run(args: &LdiArgs, task: &Task) -> Result<Outcome> {
    match &args.command {
        LdiCommand::Build(args) => build::run(args, task),
        LdiCommand::Info(args) => info::run(args, task),
        LdiCommand::Render(args) => render::run(args, task),
    }
}
