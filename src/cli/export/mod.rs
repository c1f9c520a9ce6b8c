//! The command `export`.

mod handover;
mod layered;
mod page;

use super::Outcome;
use super::args::{ExportArgs, ExportTarget};
use super::lock::lock_and_read;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_files::writable::check_folder;
use quadratura_sites::open::open_site;

/// Runs `export`.
pub fn run(args: &ExportArgs, task: &Task) -> Result<Outcome> {
    handover::check(args)?;
    // What cannot be written is reported before the work, not after it.
    check_folder(&args.out)?;
    let (_lock, project) = lock_and_read(&args.project, task)?;
    let opened = open_site(&args.project, project, task)?;
    match args.format {
        ExportTarget::Layered(format) => layered::run(args, format, &opened, task),
        ExportTarget::Handover(format) => handover::run(args, format, &opened, task),
        ExportTarget::Page => page::run(args, &opened, task),
    }
}
