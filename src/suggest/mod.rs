//! A first coarse model of a site, from calibrated photos and the sparse points of structure from motion.
//!
//! Planes are fitted to the points, each pixel of each photo is given the plane that it shows, and the photos vote where on its
//! plane a face is (piecewise planar stereo, Sinha, Steedly and Szeliski 2009). Faces that do not help to predict photos that
//! are left out are dropped. This package knows photos, cameras and points, and neither files nor devices.
//!
//! | modules | contents |
//! |---|---|
//! | [`chart`], [`view`] | a raster on a plane; a photo at the working size |
//! | [`points`], [`scan`] | the points that say something, in normalised coordinates; which photos are compared |
//! | [`planes`] | planes of points |
//! | [`up`], [`support`] | which way is up; how far points and rays support the places of a plane |
//! | `ground` | the ground, by comparing photos |
//! | [`compare`], [`sgm`] | the agreement of photos; one label per pixel |
//! | [`sky`] | where photos show the sky |
//! | [`label`] | what each pixel shows |
//! | [`sweep`] | walls without points |
//! | [`votes`], [`outline`], [`face`] | where on its plane a face is, its outline, the face |
//! | [`snap`] | edges that lie along other planes, plumb, level |
//! | [`edit`] | faces whose edges are dragged |
//! | [`rays`], [`predict`] | lines of sight that faces block; photos predicted with and without a face |
//! | [`suggest`] | the steps in order |
//!
//! A module uses only modules of its own row and of rows above it in this table.

pub mod chart;
pub mod compare;
pub mod edit;
pub mod face;
mod ground;
pub mod label;
pub mod outline;
pub mod planes;
pub mod points;
pub mod predict;
pub mod rays;
pub mod scan;
pub mod sgm;
pub mod sky;
pub mod snap;
pub mod suggest;
pub mod support;
pub mod sweep;
pub mod up;
pub mod view;
pub mod votes;

#[cfg(test)]
mod tests;

pub use points::SourcePoint;
pub use scan::points_of_mesh;
pub use suggest::{Input, Reason, SuggestedFace, SuggestedObject, Suggestion, suggest};
pub use view::{FINE_PX, SourcePhoto};
