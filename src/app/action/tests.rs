//! Tests of actions without a window, by subject.

pub mod bench;
mod inspect;
pub mod layered;
mod life;
mod lists;
mod round_trip;
mod views;
mod window;
