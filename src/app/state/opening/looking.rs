//! The paths of a dialog, which are checked on disk while the user types: when the next check is due, and the last one.

use quadratura_sites::discover::{DiscoveryReport, SiteParts};

/// The time without typing after which a path is checked, in seconds.
const TYPED_S: f64 = 0.35;
/// Files change while a dialog is open, for example when a model is exported again: paths are checked at this interval,
/// in seconds,
const AGAIN_S: f64 = 2.0;
/// and where a check is slow, as on a network drive, it takes no more than this share of the time.
const SHARE: f64 = 0.05;

/// The paths of a dialog, and the last check of them.
#[derive(Default)]
pub struct Looking {
    wanted: SiteParts,
    since_s: f64,
    /// The paths that were checked last, or are being checked.
    asked: Option<SiteParts>,
    asked_s: f64,
    /// The duration of the last check, in seconds.
    took_s: f64,
    /// The result of the last check, maybe of other paths than the current ones.
    pub look: Option<DiscoveryReport>,
}

impl Looking {
    /// Sets the current paths.
    pub fn want(&mut self, parts: SiteParts, now_s: f64) {
        if self.wanted != parts {
            (self.wanted, self.since_s) = (parts, now_s);
        }
    }

    /// Returns the result for the current paths, once it is known.
    pub fn now(&self) -> Option<&DiscoveryReport> {
        self.look.as_ref().filter(|look| look.parts() == self.wanted)
    }

    /// Returns the time until the next check is due, in seconds; none where none is. `is_shown`: a dialog is open;
    /// `is_busy`: a check runs. A check is only repeated once its result was seen.
    pub fn rest_s(&self, is_shown: bool, is_busy: bool, now_s: f64) -> Option<f64> {
        let is_new = self.asked.as_ref().unwrap_or(&SiteParts::default()) != &self.wanted;
        if !is_new && (!is_shown || self.asked.is_none() || is_busy) {
            return None;
        }
        let due_s =
            if is_new { self.since_s + TYPED_S } else { self.asked_s + AGAIN_S.max(self.took_s / SHARE) };
        Some(due_s - now_s)
    }

    /// Records that a check begins; returns its paths.
    pub fn begin(&mut self, now_s: f64) -> SiteParts {
        (self.asked, self.asked_s) = (Some(self.wanted.clone()), now_s);
        self.wanted.clone()
    }

    /// Takes the result of a check. A later check may have been started, and may even have finished first.
    pub fn found(&mut self, look: DiscoveryReport, took_s: f64) {
        if self.asked.as_ref() == Some(&look.parts()) {
            (self.look, self.took_s) = (Some(look), took_s);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts(model: &str) -> SiteParts {
        SiteParts { photos: "p".into(), cameras: "c".into(), model: model.into() }
    }

    /// Returns whether the next check is due in this time, in seconds.
    fn is_due_in(looking: &Looking, is_busy: bool, now_s: f64, rest_s: f64) -> bool {
        looking.rest_s(true, is_busy, now_s).is_some_and(|rest| (rest - rest_s).abs() < 1e-9)
    }

    #[test]
    fn a_path_is_checked_once_nothing_was_typed_for_a_moment() {
        let mut looking = Looking::default();
        assert_eq!(looking.rest_s(true, false, 9.0), None, "nothing is typed");
        looking.want(parts("a"), 10.0);
        assert!(is_due_in(&looking, false, 10.0, TYPED_S));
        looking.want(parts("ab"), 10.2);
        looking.want(parts("ab"), 10.3);
        assert!(is_due_in(&looking, false, 10.2, TYPED_S), "typing goes on");
        assert!(looking.rest_s(true, false, 10.6).is_some_and(|rest| rest <= 0.0));
    }

    #[test]
    fn a_check_is_repeated_while_a_dialog_is_open_and_none_runs() {
        let mut looking = Looking::default();
        looking.want(parts("a"), 0.0);
        assert_eq!(looking.begin(1.0), parts("a"));
        assert_eq!(looking.rest_s(true, true, 1.0), None, "it runs");
        assert_eq!(looking.rest_s(false, false, 1.0), None, "it is hidden");
        assert!(is_due_in(&looking, false, 1.0, AGAIN_S));
        looking.want(parts("b"), 1.5);
        assert!(is_due_in(&looking, true, 1.5, TYPED_S), "other paths do not wait for it");
    }

    #[test]
    fn a_slow_check_takes_a_small_share_of_the_time() {
        let mut looking = Looking::default();
        looking.want(SiteParts::default(), 0.0);
        looking.begin(0.0);
        let look = quadratura_sites::discover::look_at(
            &SiteParts::default(),
            None,
            &quadratura_base::task::Task::silent(),
        );
        looking.found(look.unwrap(), 1.0);
        assert!(looking.now().is_some());
        assert!(is_due_in(&looking, false, 0.0, 1.0 / SHARE));
    }

    #[test]
    fn the_result_for_earlier_paths_is_not_that_of_the_current_ones() {
        let look = quadratura_sites::discover::look_at(
            &SiteParts::default(),
            None,
            &quadratura_base::task::Task::silent(),
        );
        let mut looking = Looking::default();
        looking.want(parts("a"), 0.0);
        looking.begin(0.0);
        looking.found(look.unwrap(), 0.0);
        assert!(looking.look.is_none() && looking.now().is_none());
    }
}
