//! Tests of actions without a window, by subject.

pub mod bench;
mod editing;
mod life;
mod opening;
mod views;
mod window;
