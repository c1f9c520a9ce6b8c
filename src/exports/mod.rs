//! A site as other programs and browsers take it: hand-over and baked models, and the page.

pub mod handover;
pub mod page;
mod plugged_in;
