//! The window around the state: takes in, hears keys, draws, has done what was asked for.

pub mod crash;
pub mod editor;
pub mod frame_times;
pub mod layout;
mod look;
mod turns;
