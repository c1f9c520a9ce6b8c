//! Tests of actions without a window, by subject.

pub mod bench;
mod flat;
mod inspect;
pub mod layered;
mod life;
mod lists;
mod masks;
mod quality;
mod round_trip;
mod views;
mod window;
