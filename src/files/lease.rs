//! Locks between programs on several machines that share a folder: files that name their holder and are renewed while it lives.
//!
//! No lock of the operating system is used, because those of network drives are often missing, or end with the connection. A lease
//! is a file that only one program can create. Its holder counts up a number in it; a lease whose content has not changed for
//! [`LeaseTimes::dead`], by the clock of the one who looks, is taken over. Times that machines write down are only shown: clocks
//! may differ or be set back. A holder on the same machine whose process has ended is replaced at once.
//!
//! Two programs may believe for a moment to hold one lease, where the first was suspended for longer than a minute. Leases
//! therefore save work that would be done twice; what must not be mixed is made current by one rename.

use std::collections::BTreeMap;
use std::fmt;
use std::fs::{self, File, OpenOptions};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{ErrorKind, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use super::atomic::write_atomically;
use super::hash::hash_bytes;
use super::machine;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;

/// How often a lease is renewed, and when it counts as left behind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LeaseTimes {
    /// The time between two renewals.
    pub renewed: Duration,
    /// The time without a renewal after which others take the lease over. Several renewals fit into it, so that a server that
    /// is busy, or shows changes late, kills nobody.
    pub dead: Duration,
}

impl Default for LeaseTimes {
    fn default() -> Self {
        Self { renewed: Duration::from_secs(10), dead: Duration::from_secs(60) }
    }
}

/// Who holds a lease, as its file says.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Holder {
    /// The program and its command.
    pub program: String,
    /// The name of the machine.
    pub host: String,
    /// The process id on that machine.
    pub process: u32,
    /// When it was taken, in seconds since 1970, UTC, by the clock of that machine.
    pub since: u64,
    /// What tells the machine from others of its name, and from itself before it was started anew.
    machine: String,
    /// What tells the process from others with its id.
    started: u64,
    /// What tells this lease from all others.
    nonce: String,
    /// The number of renewals, always of as many digits, so that a renewal changes no other bytes.
    renewed: String,
}

impl Holder {
    /// Returns this process as it would hold a lease from now on.
    pub fn of_this_process() -> Self {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        let random = [(); 2].map(|()| RandomState::new().build_hasher().finish());
        Self {
            program: super::lock::program(),
            host: machine::host().to_owned(),
            process: std::process::id(),
            since,
            machine: machine::identity().to_owned(),
            started: machine::started(std::process::id()).unwrap_or_default(),
            nonce: hash_bytes(format!("{random:?} {} {since}", std::process::id()).as_bytes())[..16]
                .to_owned(),
            renewed: count(0),
        }
    }

    /// Returns whether the holder is known to live: a process of this machine that runs.
    pub fn is_known_to_live(&self) -> bool {
        self.is_of_this_machine() && !self.has_ended()
    }

    /// Returns whether the holder is this very process.
    pub fn is_this_process(&self) -> bool {
        (self.process, &self.host[..]) == (std::process::id(), machine::host())
            && self.machine == machine::identity()
    }

    /// Returns whether two looks found the same holder, without a renewal between them.
    pub fn is_same_moment(&self, other: &Self) -> bool {
        (&self.nonce, &self.renewed) == (&other.nonce, &other.renewed)
    }

    fn is_of_this_machine(&self) -> bool {
        !self.machine.is_empty() && self.machine == machine::identity()
    }

    /// Returns whether the holder was a process of this machine that has ended.
    fn has_ended(&self) -> bool {
        self.is_of_this_machine() && machine::started(self.process) != Some(self.started)
    }

    fn to_line(&self) -> Vec<u8> {
        let mut line = serde_json::to_vec(self).expect("plain data is JSON");
        line.push(b'\n');
        line
    }
}

impl fmt::Display for Holder {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match &self.program[..] {
            "" => write!(f, "another program"),
            program => write!(f, "{program} (process {} on {})", self.process, self.host),
        }
    }
}

fn count(renewed: u64) -> String {
    format!("{renewed:010}")
}

/// The right to something, until it is dropped.
#[derive(Debug)]
pub struct Lease {
    file: PathBuf,
    nonce: String,
    lost: Arc<AtomicBool>,
    renewing: Option<(Sender<()>, JoinHandle<()>)>,
    /// Who had it before and left it behind.
    pub taken_over_from: Option<Holder>,
}

/// What is known of a lease's file.
#[derive(Debug)]
enum LeaseFile {
    Free,
    Held(Holder),
    /// The content, which nobody renews, and who wrote it.
    Dead(Vec<u8>, Holder),
}

impl Lease {
    /// Takes the lease `file`, whose folder exists, or returns who holds it.
    ///
    /// # Errors
    /// An error of the system other than that the file exists.
    pub fn try_take(file: &Path) -> std::io::Result<std::result::Result<Self, Holder>> {
        Self::try_take_with(file, LeaseTimes::default())
    }

    /// [`Self::try_take`] with other times.
    ///
    /// # Errors
    /// As [`Self::try_take`].
    pub fn try_take_with(
        file: &Path,
        times: LeaseTimes,
    ) -> std::io::Result<std::result::Result<Self, Holder>> {
        let own = Holder::of_this_process();
        match OpenOptions::new().write(true).create_new(true).open(file) {
            Ok(mut new) => {
                let written = new.write_all(&own.to_line());
                drop(new);
                if let Err(error) = written {
                    // On a full disk: nobody is to wait for it.
                    let _ = fs::remove_file(file);
                    return Err(error);
                }
                return Ok(Ok(Self::renewed(file, own.nonce, times, None)));
            }
            Err(error) if error.kind() == ErrorKind::AlreadyExists => (),
            Err(error) => return Err(error),
        }
        match found(file, times) {
            // It was given back just now: whoever asks again gets it.
            LeaseFile::Free => Ok(Err(Holder::default())),
            LeaseFile::Held(holder) => Ok(Err(holder)),
            LeaseFile::Dead(content, holder) => match take_over(file, &content, &own, times)? {
                true => Ok(Ok(Self::renewed(file, own.nonce, times, Some(holder)))),
                false => Ok(Err(holder)),
            },
        }
    }

    /// Takes the lease `file` in a folder that is created where it is missing; waits while another program holds it. `waits` says
    /// once what this waits for, and `takes_over` whose lease was left behind.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Cancelled`].
    pub fn wait(
        file: &Path,
        task: &Task,
        waits: impl Fn(&Holder) -> String,
        takes_over: impl Fn(&Holder) -> String,
    ) -> Result<Self> {
        let folder = file.parent().unwrap_or(Path::new("."));
        fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
        let mut noted = false;
        let mut pause = FIRST_PAUSE;
        loop {
            task.check_cancelled()?;
            match Self::try_take(file).map_err(Error::io(file, "take the lock"))? {
                Ok(lease) => {
                    lease.taken_over_from.iter().for_each(|holder| task.note(takes_over(holder)));
                    return Ok(lease);
                }
                Err(holder) => {
                    // A moment's wait is none.
                    if pause == LONGEST_PAUSE && !std::mem::replace(&mut noted, true) {
                        task.note(waits(&holder));
                    }
                }
            }
            std::thread::sleep(pause);
            pause = (2 * pause).min(LONGEST_PAUSE);
        }
    }

    /// Returns who holds the lease `file`; `None` when nobody does, or who did has left it behind.
    pub fn holder(file: &Path) -> Option<Holder> {
        match found(file, LeaseTimes::default()) {
            LeaseFile::Held(holder) => Some(holder),
            LeaseFile::Free | LeaseFile::Dead(..) => None,
        }
    }

    /// Returns whether this is still the holder. After a machine was suspended, another one may be.
    pub fn is_held(&self) -> bool {
        !self.lost.load(Ordering::Relaxed) && is_own(&read(&self.file).unwrap_or_default(), &self.nonce)
    }

    fn renewed(file: &Path, nonce: String, times: LeaseTimes, taken_over_from: Option<Holder>) -> Self {
        let lost = Arc::new(AtomicBool::new(false));
        let (stop, stopped) = channel::<()>();
        let renew = {
            let (file, nonce, lost) = (file.to_path_buf(), nonce.clone(), lost.clone());
            move || {
                let mut renewals = 0;
                while stopped.recv_timeout(times.renewed) == Err(RecvTimeoutError::Timeout) {
                    renewals += 1;
                    match renew(&file, &nonce, renewals) {
                        Ok(true) => (),
                        Ok(false) => return lost.store(true, Ordering::Relaxed),
                        Err(error) if error.kind() == ErrorKind::NotFound => {
                            return lost.store(true, Ordering::Relaxed);
                        }
                        // The server may be away for a while.
                        Err(_) => (),
                    }
                }
            }
        };
        let thread = std::thread::Builder::new().name("lease".into()).spawn(renew).ok();
        let renewing = thread.map(|thread| (stop, thread));
        Self { file: file.to_path_buf(), nonce, lost, renewing, taken_over_from }
    }
}

const FIRST_PAUSE: Duration = Duration::from_millis(20);
const LONGEST_PAUSE: Duration = Duration::from_millis(640);

impl Drop for Lease {
    fn drop(&mut self) {
        if let Some((stop, thread)) = self.renewing.take() {
            drop(stop);
            // It cannot panic, and if it did, there would be nothing to renew.
            let _ = thread.join();
        }
        if self.is_held() {
            let _ = fs::remove_file(&self.file);
        }
    }
}

/// Counts up the number in the lease's file; false where it is another's now.
fn renew(file: &Path, nonce: &str, renewals: u64) -> std::io::Result<bool> {
    // Through one handle: where the file is replaced meanwhile, this writes to the one that was replaced.
    let mut open = OpenOptions::new().read(true).write(true).open(file)?;
    let mut content = Vec::new();
    open.read_to_end(&mut content)?;
    let Some(mut holder) = parsed(&content).filter(|holder| holder.nonce == nonce) else { return Ok(false) };
    holder.renewed = count(renewals);
    open.rewind()?;
    open.write_all(&holder.to_line())?;
    Ok(true)
}

/// Replaces a lease that was left behind with `content`; false where another program does, or its holder lives after all.
fn take_over(file: &Path, content: &[u8], own: &Holder, times: LeaseTimes) -> std::io::Result<bool> {
    // Of several that want this very lease, one creates the file with its name.
    let claim = beside(file, &format!(".{}", &hash_bytes(content)[..12]));
    match OpenOptions::new().write(true).create_new(true).open(&claim) {
        Ok(mut new) => new.write_all(&own.to_line())?,
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            if let LeaseFile::Dead(..) = found(&claim, times) {
                let _ = fs::remove_file(&claim);
            }
            return Ok(false);
        }
        Err(error) => return Err(error),
    }
    let is_left = read(file).is_ok_and(|now| now == content);
    let taken = is_left.then(|| write_atomically(file, &own.to_line()).is_ok());
    let _ = fs::remove_file(&claim);
    Ok(taken.unwrap_or(false))
}

fn beside(file: &Path, end: &str) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(end);
    name.into()
}

/// What this program saw of leases, and when it saw it first.
static SEEN: Mutex<BTreeMap<PathBuf, (Vec<u8>, Instant)>> = Mutex::new(BTreeMap::new());

fn found(file: &Path, times: LeaseTimes) -> LeaseFile {
    // The entries are independent of each other, so they are valid after a panic elsewhere.
    let mut seen = SEEN.lock().unwrap_or_else(PoisonError::into_inner);
    let Ok(content) = read(file) else {
        seen.remove(file);
        return LeaseFile::Free;
    };
    let holder = parsed(&content);
    // A file that names nobody is being written, or was left behind while it was. Others are none of this program's.
    let is_foreign = holder.is_none() && !content.is_empty();
    let holder = holder.unwrap_or_default();
    if is_foreign || holder.has_ended() {
        return LeaseFile::Dead(content, holder);
    }
    match seen.get(file) {
        Some((before, since)) if *before == content => match since.elapsed() >= times.dead {
            true if !holder.is_known_to_live() => LeaseFile::Dead(content, holder),
            _ => LeaseFile::Held(holder),
        },
        _ => {
            seen.insert(file.to_path_buf(), (content, Instant::now()));
            LeaseFile::Held(holder)
        }
    }
}

/// Returns a file's content. It is opened each time, because network drives ask the server then.
fn read(file: &Path) -> std::io::Result<Vec<u8>> {
    let mut content = Vec::new();
    File::open(file)?.take(LONGEST).read_to_end(&mut content)?;
    Ok(content)
}

/// More than any lease has, in bytes.
const LONGEST: u64 = 4096;

fn parsed(content: &[u8]) -> Option<Holder> {
    serde_json::from_slice(content).ok()
}

fn is_own(content: &[u8], nonce: &str) -> bool {
    parsed(content).is_some_and(|holder| holder.nonce == nonce)
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUICK: LeaseTimes =
        LeaseTimes { renewed: Duration::from_millis(20), dead: Duration::from_millis(400) };

    /// A lease as a program on another machine writes it, whose clock is ten minutes ahead.
    fn of_another_machine(renewed: u64) -> Vec<u8> {
        let own = Holder::of_this_process();
        let (host, machine, nonce) = ("farm-2".to_owned(), "another".to_owned(), "5eed".to_owned());
        Holder { host, machine, nonce, since: own.since + 600, renewed: count(renewed), ..own }.to_line()
    }

    fn file() -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.lock");
        (folder, file)
    }

    fn names(folder: &Path) -> usize {
        fs::read_dir(folder).unwrap().count()
    }

    #[test]
    fn one_has_it_until_it_is_dropped() {
        let (folder, file) = file();
        let first = Lease::try_take(&file).unwrap().unwrap();
        let holder = Lease::try_take(&file).unwrap().unwrap_err();
        assert!(holder.is_known_to_live() && holder.to_string().contains(machine::host()), "{holder}");
        assert!(first.is_held());
        drop(first);
        assert_eq!((Lease::holder(&file), names(folder.path())), (None, 0));
    }

    #[test]
    fn one_that_another_machine_renews_stays_its_own_whatever_its_clock_says() {
        let (_folder, file) = file();
        let started = Instant::now();
        let mut renewals = 0;
        while started.elapsed() < 2 * QUICK.dead {
            fs::write(&file, of_another_machine(renewals)).unwrap();
            renewals += 1;
            let holder = Lease::try_take_with(&file, QUICK).unwrap().unwrap_err();
            assert_eq!(holder.host, "farm-2");
            std::thread::sleep(QUICK.renewed);
        }
    }

    #[test]
    fn one_that_was_left_behind_is_taken_over_by_one_of_several_and_its_holder_notices() {
        let (folder, file) = file();
        fs::write(&file, of_another_machine(7)).unwrap();
        let started = Instant::now();
        let take = || loop {
            match Lease::try_take_with(&file, QUICK).unwrap() {
                Ok(lease) => return Some((lease, started.elapsed())),
                Err(holder) if holder.host != "farm-2" && !holder.host.is_empty() => return None,
                Err(_) => std::thread::sleep(Duration::from_millis(3)),
            }
        };
        let taken: Vec<_> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..4).map(|_| scope.spawn(take)).collect();
            threads.into_iter().filter_map(|thread| thread.join().unwrap()).collect()
        });
        let [(lease, after)] = &taken[..] else { panic!("{} have it", taken.len()) };
        assert!(*after >= QUICK.dead && lease.is_held());
        assert_eq!(lease.taken_over_from.as_ref().unwrap().host, "farm-2");
        assert_eq!(names(folder.path()), 1, "no claim is left");
        assert!(!renew(&file, "5eed", 8).unwrap(), "the holder before renews nothing of another's");
        // And if this one is the one that slept:
        fs::write(&file, of_another_machine(0)).unwrap();
        assert!(!lease.is_held());
        drop(taken);
        assert!(file.exists(), "another's lease stays");
    }

    #[test]
    fn a_holder_of_this_machine_that_has_ended_is_replaced_at_once() {
        let (_folder, file) = file();
        let own = Holder::of_this_process();
        fs::write(&file, Holder { started: own.started + 1, ..own }.to_line()).unwrap();
        match machine::started(std::process::id()) {
            Some(_) => assert!(Lease::try_take(&file).unwrap().unwrap().taken_over_from.is_some()),
            // Where the system does not tell, it is waited for as for another machine.
            None => assert!(Lease::try_take(&file).unwrap().is_err()),
        }
    }

    #[test]
    fn renewals_change_the_number_alone_and_an_unfinished_lease_is_waited_for() {
        let (_folder, file) = file();
        let lease = Lease::try_take_with(&file, QUICK).unwrap().unwrap();
        let before = read(&file).unwrap();
        let started = Instant::now();
        while read(&file).unwrap() == before {
            assert!(started.elapsed() < Duration::from_secs(60), "nobody renews it");
            std::thread::sleep(Duration::from_millis(5));
        }
        let after = read(&file).unwrap();
        assert_eq!((before.len(), lease.is_held()), (after.len(), true));
        drop(lease);
        fs::write(&file, "").unwrap();
        assert!(Lease::try_take_with(&file, QUICK).unwrap().is_err());
        std::thread::sleep(QUICK.dead);
        assert!(Lease::try_take_with(&file, QUICK).unwrap().is_ok());
    }
}
