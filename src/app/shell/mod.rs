//! The window around the state: applies results, handles keys, draws, and applies requests.

mod crash;
pub mod editor;
mod flat;
pub mod frame_times;
mod input_splitter;
mod look;
pub mod pane_layout;
pub mod textures;

/// The application id in the window system; settings are stored under it.
pub const APP_ID: &str = "quadratura";
