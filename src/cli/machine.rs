//! What the machine has, and what we took of it.

use sysinfo::System;

/// What a machine that does not tell is taken to have.
const UNKNOWN_MACHINE: u64 = 8 << 30;

/// A quarter of the memory that this process may have, in bytes.
pub fn default_memory() -> u64 {
    let Ok(mut system) = System::new() else { return UNKNOWN_MACHINE / 4 };
    system.refresh_memory();
    // A container may be given less than the machine has.
    let limit = system.cgroup_limits().map_or(u64::MAX, |limits| limits.total_memory);
    system.total_memory().min(limit) / 4
}

/// The most memory this process ever held, in bytes; `None` where the system does not tell.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kibibytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_machine_has_memory_and_we_took_some() {
        assert!(default_memory() > 1 << 20);
        if cfg!(target_os = "linux") {
            assert!(peak_memory().unwrap() > 1 << 20);
        }
    }
}
