//! Tests of actions without a window, by subject.

pub mod bench;
mod flight;
mod life;
mod space;
mod views;
mod window;
