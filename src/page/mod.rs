//! Folders that a browser opens, from disk as well as from any static server: what the page of one layered depth image and the page
//! of a whole site have in common. Browsers give pages that are opened from disk no other files to read, so everything but the poster
//! is data within scripts.
//!
//! | module | contents |
//! |---|---|
//! | [`chunk`] | data as a script |
//! | [`html`] | text in HTML, templates |
//! | [`pictures`] | pictures as JPEG and PNG |
//! | [`place`] | where a page goes: never over what the program did not write |
//! | [`viewer`] | the sources of the viewer of sites |
//!
//! It does not know what a page shows.

pub mod chunk;
pub mod html;
pub mod pictures;
pub mod place;
pub mod viewer;
