//! The window around the state: applies results, handles keys, draws, and applies asks.

mod crash;
pub mod editor;
mod flat;
pub mod frame_times;
pub mod layout;
mod look;
pub mod textures;
mod turns;

/// The application id in the window system; settings are stored under it.
pub const APP_ID: &str = "quadratura";
