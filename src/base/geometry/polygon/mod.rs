//! Polygons of planar faces: their plane, their triangles, and cutting them by a plane.
//!
//! An outline is one closed ring of points, counter-clockwise seen from the visible side. Holes are bridged: the
//! ring walks from the outer outline to the hole and back along the same edge, so it is only *weakly* simple. All
//! functions here take and return such rings.
//!
//! Cutting and bridging never intersect outlines with each other. The ring is triangulated once
//! ([`triangulate`](fn@triangulate)), the triangles are cut one by one, and the pieces that share edges are walked
//! around ([`outlines`]). Each step asks about one triangle, or about which triangles are neighbours, so doubled
//! edges and touching corners need no special case.

mod crossing;
mod flat;
mod join;
mod outline;
mod plane_fit;
mod split;
mod triangulate;

pub use flat::PlaneFrame;
pub use join::{join_all, join_coplanar};
pub use outline::outlines;
pub use plane_fit::{PLANARITY, extent, fit_plane, is_planar, largest_distance, newell_normal};
pub use split::{bridge_holes, split_by_plane};
pub use triangulate::{OutlineFlaw, Triangulation, triangulate};

#[cfg(test)]
mod tests;
