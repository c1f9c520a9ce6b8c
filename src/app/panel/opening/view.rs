//! What the dialogs for opening projects depend on.

use crate::command::Commands;
use crate::state::State;
use crate::state::opening::Opening;
use crate::state::running::Running;

/// What the dialogs for opening and creating projects depend on.
pub struct OpeningView<'a> {
    /// The commands that the panel offers.
    pub commands: Commands<'a>,
    /// The dialogs for opening projects.
    pub opening: &'a Opening,
    /// The running jobs.
    pub running: &'a Running,
}

impl<'a> OpeningView<'a> {
    /// Borrows what the panel shows.
    pub fn new(state: &'a State) -> Self {
        Self { commands: Commands::of(state), opening: &state.opening, running: &state.running }
    }
}
