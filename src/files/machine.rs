//! What tells machines and processes apart that write to the same folder.

use std::fs;
use std::process::Command;
use std::sync::LazyLock;

use super::hash::hash_bytes;

/// Returns the name of this machine.
pub fn host() -> &'static str {
    static HOST: LazyLock<String> = LazyLock::new(|| {
        let of_system = fs::read_to_string("/proc/sys/kernel/hostname").ok();
        let asked = || {
            Command::new("hostname")
                .output()
                .ok()
                .map(|out| String::from_utf8_lossy(&out.stdout).into_owned())
        };
        let name = of_system.or_else(asked).unwrap_or_default().trim().to_owned();
        if name.is_empty() { "unknown".into() } else { name }
    });
    &HOST
}

/// Returns what tells this machine from others of its name, from itself before it was started anew, and from containers with
/// process ids of their own; empty where the system does not tell.
pub fn identity() -> &'static str {
    static IDENTITY: LazyLock<String> = LazyLock::new(|| {
        let boot = fs::read_to_string("/proc/sys/kernel/random/boot_id").ok();
        let processes = fs::read_link("/proc/self/ns/pid").ok();
        let all = boot.zip(processes);
        all.map_or_else(String::new, |all| {
            hash_bytes(format!("{all:?} {}", host()).as_bytes())[..16].to_owned()
        })
    });
    &IDENTITY
}

/// Returns when a process of this machine was started, in a unit of the system's own; `None` when there is none with this id, or
/// where the system does not tell.
pub fn started(process: u32) -> Option<u64> {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name of the program, in parentheses, may contain anything. The state follows it; a zombie has ended.
    let mut after = stat.rsplit_once(')')?.1.split_ascii_whitespace();
    let state = after.next()?;
    (!matches!(state, "Z" | "X")).then(|| after.nth(18)?.parse().ok())?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn this_process_runs_and_one_that_has_ended_does_not() {
        assert_eq!(started(std::process::id()), started(std::process::id()));
        assert!(started(std::process::id()).is_some() && !identity().is_empty() && host() != "unknown");
        let mut child = Command::new("true").spawn().unwrap();
        child.wait().unwrap();
        assert_eq!(started(child.id()), None);
    }
}
