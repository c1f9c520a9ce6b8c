//! The command `tree`: plants are inspected and rendered; trees are placed in a project, masked in its photos,
//! and painted.

mod bake;
mod edit;
mod info;
mod light;
mod list;
mod mask;
mod paint;
mod render;

pub use self::list::note_doubts;
use super::Outcome;
use super::args::{TreeArgs, TreeCommand};
use quadratura_base::error::Result;
use quadratura_base::task::Task;

/// Runs `tree`.
pub fn run(args: &TreeArgs, task: &Task) -> Result<Outcome> {
    match &args.command {
        TreeCommand::Info(args) => info::run(args, task),
        TreeCommand::Render(args) => render::run(args, task),
        TreeCommand::List(args) => list::run(args, task),
        TreeCommand::Species(args) => edit::species(args, task),
        TreeCommand::Place(args) => edit::place(args, task),
        TreeCommand::Move(args) => edit::move_trees(args, task),
        TreeCommand::Remove(args) => edit::remove(args, task),
        TreeCommand::Light(args) => light::run(args, task),
        TreeCommand::Bake(args) => bake::run(args, task),
        TreeCommand::Mask(args) => mask::run(args, task),
        TreeCommand::Export(args) => paint::export(args, task),
        TreeCommand::Import(args) => paint::import(args, task),
    }
}
