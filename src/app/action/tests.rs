//! Tests of actions without a window, by subject.

pub mod bench;
mod editing;
mod flat;
mod flight;
mod inspect;
pub mod layered;
mod life;
mod lists;
mod masks;
mod opening;
mod quality;
mod round_trip;
mod space;
mod trees;
mod updating;
mod views;
mod window;
