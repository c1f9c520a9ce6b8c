//! Progress reports and cancellation of long computations.
//!
//! Every long computation takes a [`Task`]. It reports steps and notes to the task's observer, and ends with
//! [`Error::Cancelled`](crate::Error::Cancelled) soon after the flag was set.
//!
//! ```
//! use std::sync::atomic::Ordering;
//!
//! use quadratura::project::open;
//! use quadratura::Error;
//! use quadratura::task::{Event, Task};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let temporary = tempfile::tempdir()?;
//! # let (project, _) = quadratura::testing::tiny_project(temporary.path())?;
//! let task = Task::new(|event| match event {
//!     Event::Step { stage, subject, done, total } => println!("{stage} {subject}: {done} of {total}"),
//!     Event::Note { subject, text } => println!("{subject}: {text}"),
//!     Event::Detail { subject, text } => eprintln!("{subject}: {text}"),
//!     Event::Timing { stage, spent, .. } => println!("{stage} took {spent:?}"),
//! });
//! open(&project, &task)?;
//!
//! // A button or a signal handler keeps the flag.
//! let flag = task.stop_flag();
//! flag.store(true, Ordering::Relaxed);
//! assert!(matches!(open(&project, &task), Err(Error::Cancelled)));
//! # Ok(())
//! # }
//! ```

#[doc(inline)]
pub use quadratura_base::task::{Event, Task};
