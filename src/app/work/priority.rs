//! The priority of threads that must not slow the window down.

/// How much nicer such a thread is than others (`nice`).
#[cfg(target_os = "linux")]
const NICER: i32 = 10;

/// Lowers the priority of the calling thread. Where the system does not give priorities to single threads, it stays as it is:
/// that is no fault.
pub fn lower_own_priority() {
    #[cfg(target_os = "linux")]
    // On Linux this concerns the calling thread alone.
    let _ = rustix::process::nice(NICER);
}

#[cfg(test)]
mod tests {
    #[cfg(target_os = "linux")]
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn the_priority_of_one_thread_is_lowered_and_that_of_the_others_stays() {
        let nice = || rustix::process::nice(0).unwrap();
        let before = nice();
        let lowered = std::thread::spawn(move || {
            lower_own_priority();
            rustix::process::nice(0).unwrap()
        });
        assert_eq!(lowered.join().unwrap(), (before + NICER).min(19));
        assert_eq!(nice(), before);
    }
}
