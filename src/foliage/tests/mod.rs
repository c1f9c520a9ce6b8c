//! Tests of plants as a whole: graphs, generated plants and brute force.

mod detail;
mod drawn;
mod flakes;
mod graphs;
mod grown;
pub mod layered;
mod parts;
mod popping;
mod shaded;

pub use super::synthetic::{boxed, bushy, draft, plant_of, square};
