//! Errors by cause, with remedies.

#[doc(inline)]
pub use quadratura_base::error::{Error, Message, Remedy, Result};
