//! Masks that the program makes: of an object that photos show where the model has it, and of what moved between photos.

pub mod object;
pub mod suggest;
