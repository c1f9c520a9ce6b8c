//! Pixels on a grid: an image whose pixel format is its type, what lies between its pixels, its half, one colour
//! over another, sums around a cell, and robust statistics. Pure computation; no files, no cameras.
//!
//! Where two uses need different rules, each rule has a name here, and the caller chooses:
//!
//! | subject | rules |
//! |---|---|
//! | [`bilinear`] | border: repeated ([`bilinear::Clamped`]), or left to the caller ([`bilinear::BilinearCorner`]) |
//! | [`halving`] | odd sides: [`halving::OddSide`] drops, shortens or repeats the last column or row |
//! | [`over`] | alpha: premultiplied, straight, or over an opaque ground |
//! | [`robust`] | ties: [`robust::median`] is the mean of the two in the middle, [`robust::upper_median`] the larger |
//! | [`sample`] | rounding: to the nearest; 16 bits to 8 by their full ranges |

pub mod bilinear;
pub mod box_filter;
pub mod halving;
pub mod image;
pub mod over;
pub mod robust;
pub mod sample;
pub mod steps;
pub mod text;

pub use self::image::Image;
pub use self::sample::{Sample, in_8_bits};
