//! The commands as they are in the present state.

use super::{Command, WhyNot};
use crate::state::State;
use crate::state::request::Request;

/// The commands in the present state. A panel that offers commands gets this in place of the state, and reads no more of it
/// than they say.
#[derive(Clone, Copy)]
pub struct Commands<'a>(&'a State);

impl<'a> Commands<'a> {
    /// Borrows the state that the commands depend on.
    pub fn of(state: &'a State) -> Self {
        Self(state)
    }

    /// Returns whether a command can be run, or the reason why not.
    pub fn ready(self, command: &Command) -> Result<(), WhyNot> {
        (command.ready)(self.0)
    }

    /// Returns whether the switch of a command is on; false for one that switches nothing.
    pub fn is_on(self, command: &Command) -> bool {
        command.on.is_some_and(|on| on(self.0))
    }

    /// Returns what a command would apply to, for the menu.
    pub fn detail(self, command: &Command) -> Option<String> {
        command.detail.and_then(|detail| detail(self.0))
    }

    /// Returns the request of a command that is ready, and otherwise a note with the reason.
    pub fn requested(self, command: &Command) -> Request {
        command.requested(self.0)
    }
}
