//! A project that is open elsewhere: the holder of its lock.

use std::path::PathBuf;

/// The interval of checks, in seconds: short enough to seem immediate, long enough to cost nothing.
pub const LOOKS_EVERY_S: f64 = 1.5;

/// A project that is already open elsewhere.
#[derive(Debug, Clone, PartialEq)]
pub struct Held {
    /// The folder of the project.
    pub folder: PathBuf,
    /// The signature in the lock file.
    pub holder: String,
    looked_s: f64,
}

impl Held {
    /// Makes the state of a locked project; `holder` is the signature in the lock file.
    pub fn by(folder: PathBuf, holder: String) -> Self {
        Self { folder, holder, looked_s: 0.0 }
    }

    /// Returns whether the lock is looked at now, which is then remembered.
    pub fn looks(&mut self, now_s: f64) -> bool {
        let looks = now_s - self.looked_s >= LOOKS_EVERY_S;
        if looks {
            self.looked_s = now_s;
        }
        looks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lock_is_looked_at_now_and_then() {
        let mut held = Held::by("site".into(), "somebody".into());
        let times = [0.5, 1.5, 2.0, 2.9, 3.0, 9.0];
        assert_eq!(times.map(|now_s| held.looks(now_s)), [false, true, false, false, true, true]);
    }
}
