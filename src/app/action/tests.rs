//! Tests of actions without a window, by subject.

pub mod bench;
mod flat;
mod life;
mod masks;
mod quality;
mod views;
mod window;
