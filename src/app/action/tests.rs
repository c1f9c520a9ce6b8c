//! Tests of actions without a window, by subject.

pub mod bench;
mod life;
mod views;
mod window;
