//! How threads wake the window.

use std::sync::Arc;

/// Wakes the window from any thread; one that nobody gave does nothing.
#[derive(Clone, Default)]
pub struct Waker(Option<Arc<dyn Fn() + Send + Sync>>);

impl Waker {
    /// One that does this.
    pub fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self(Some(Arc::new(wake)))
    }

    /// The window looks soon at what has come.
    pub fn wake(&self) {
        if let Some(wake) = &self.0 {
            wake();
        }
    }
}
