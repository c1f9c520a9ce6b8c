//! Reads what other programs made of a site: cameras, models and photos. It knows their formats, and not what a project makes of
//! them.

pub mod cameras;
pub mod meshes;
pub mod models;
pub mod photo;

#[cfg(test)]
#[path = "../../tests/common/left_out.rs"]
mod left_out;
#[cfg(test)]
#[path = "../../tests/common/mutations.rs"]
mod mutations;
