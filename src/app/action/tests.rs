//! Tests of actions without a window, by subject.

pub mod bench;
mod editing;
mod inspect;
pub mod layered;
mod life;
mod lists;
mod opening;
mod round_trip;
mod views;
mod window;
