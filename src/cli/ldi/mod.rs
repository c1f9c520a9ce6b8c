//! The command `ldi`: layered depth images are built, inspected, rendered and exported.

mod build;
mod export;
mod info;
mod input;
mod render;
mod several;

use super::Outcome;
use super::args::{LdiArgs, LdiCommand};
use quadratura_base::error::Result;
use quadratura_base::task::Task;

/// Runs `ldi`.
pub fn run(args: &LdiArgs, task: &Task) -> Result<Outcome> {
    match &args.command {
        LdiCommand::Build(args) => build::run(args, task),
        LdiCommand::Info(args) => info::run(args, task),
        LdiCommand::Render(args) => render::run(args, task),
        LdiCommand::Export(args) => export::run(args, task),
    }
}
