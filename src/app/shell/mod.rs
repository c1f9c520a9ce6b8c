//! The window around the state: applies results, handles keys, draws, and applies asks.

pub mod crash;
pub mod editor;
mod flat;
pub mod frame_times;
pub mod layout;
mod look;
pub mod textures;
mod turns;
