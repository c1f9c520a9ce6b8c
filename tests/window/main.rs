//! The editor's window without a display, driven by the names of its widgets: its panels, and whole sessions.
//!
//! One program holds all of these tests, because each program of tests links the whole library anew.

#[path = "../common/mod.rs"]
#[allow(dead_code)]
mod common;
mod editor;
mod harness;
mod keeping;
mod keyboard;
mod lists;
mod looks;
mod masks;
mod measuring;
#[path = "../round_trip/paper.rs"]
#[allow(dead_code)]
mod paper;
mod projects;
mod publishing;
mod room;
mod session;
mod space;
mod stops;
mod suggesting;
mod up_to_date;
