//! Files of orthophotos: pictures with resolution and place, and pages.
//!
//! | module | contents |
//! |---|---|
//! | [`rows`] | pixels that need not fit into memory |
//! | [`picture`] | TIFF, GeoTIFF and PNG |
//! | [`page`] | a page with scale bar, north arrow and title block |

pub mod page;
pub mod picture;
pub mod rows;
