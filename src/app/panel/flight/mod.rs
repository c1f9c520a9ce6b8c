//! Bookmarks and the flight: the panel with the timeline, and the dialog for pictures and videos.

pub mod export;
pub mod timeline;
