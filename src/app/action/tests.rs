//! Tests of actions without a window, by subject.

pub mod bench;
mod flat;
mod flight;
mod life;
mod masks;
mod quality;
mod space;
mod views;
mod window;
