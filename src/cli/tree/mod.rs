//! The command `tree`: plants are inspected and rendered.

mod info;
mod render;

use super::Outcome;
use super::args::{TreeArgs, TreeCommand};
use crate::error::Result;
use crate::task::Task;

/// Runs `tree`.
pub fn run(args: &TreeArgs, task: &Task) -> Result<Outcome> {
    match &args.command {
        TreeCommand::Info(args) => info::run(args, task),
        TreeCommand::Render(args) => render::run(args, task),
    }
}
