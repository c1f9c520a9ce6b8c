//! The builder: one thread that makes what was requested last, and is told to stop what nobody requests any more.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use rayon::ThreadPoolBuilder;

use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;

/// The name of the thread.
const NAME: &str = "ldi builder";

/// Something that was made.
#[derive(Debug)]
pub struct Made<T> {
    /// What was made of the newest request; a draft of it, which comes first; or why it cannot be made.
    pub result: Result<T>,
    /// Whether it is a draft.
    pub is_draft: bool,
}

/// The handle of the builder: it makes a `T` for a request `W`. It ends when this is dropped, without anybody waiting for it.
pub struct Builder<W, T>(Arc<BuilderShared<W, T>>);

/// The thread's side of the builder.
pub struct Workbench<W, T>(Arc<BuilderShared<W, T>>);

struct BuilderShared<W, T> {
    state: Mutex<BuilderState<W, T>>,
    wake: Condvar,
    /// Tells that something was made.
    tell: Box<dyn Fn() + Send + Sync>,
}

struct BuilderState<W, T> {
    /// The newest request that nobody has begun.
    request: Option<W>,
    /// The flag that stops what is being made.
    making: Option<Arc<AtomicBool>>,
    /// What was made for the newest request, oldest first.
    made: Vec<Made<T>>,
    ends: bool,
}

impl<W, T> BuilderShared<W, T> {
    fn state(&self) -> MutexGuard<'_, BuilderState<W, T>> {
        // Nobody panics who holds this lock.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<W: Send + 'static, T: Send + 'static> Builder<W, T> {
    /// Starts the thread, which runs `work`, after it has called `begin`, which gives it a low priority. `tell` is called on
    /// it whenever something was made. All that it divides among threads it does itself: those of the pictures stay free.
    ///
    /// # Errors
    /// [`Error::Request`] when the system cannot start a thread.
    pub fn start(
        begin: fn(),
        tell: impl Fn() + Send + Sync + 'static,
        work: impl FnOnce(&Workbench<W, T>) + Send + 'static,
    ) -> Result<Self> {
        let state = BuilderState { request: None, making: None, made: Vec::new(), ends: false };
        let shared =
            Arc::new(BuilderShared { state: Mutex::new(state), wake: Condvar::new(), tell: Box::new(tell) });
        let one = ThreadPoolBuilder::new().num_threads(1).thread_name(|_| NAME.to_owned());
        let refused = |_| {
            let found = "the system cannot start another thread for layered depth images; close other programs, then \
                         try again";
            Error::Request(found.into())
        };
        let pool = one.start_handler(move |_| begin()).build().map_err(refused)?;
        let bench = Workbench(shared.clone());
        // The pool ends with its thread's work.
        pool.spawn(move || work(&bench));
        Ok(Self(shared))
    }

    /// Requests something, which replaces all earlier requests.
    pub fn request(&self, request: W) {
        let mut state = self.0.state();
        state.stop();
        state.made.clear();
        state.request = Some(request);
        self.0.wake.notify_one();
    }

    /// Takes what was made of the newest request since the last call, oldest first. It never waits for anything that is being
    /// made.
    pub fn take(&self) -> Vec<Made<T>> {
        std::mem::take(&mut self.0.state().made)
    }

    /// Returns whether something is being made, or about to be.
    pub fn is_busy(&self) -> bool {
        let state = self.0.state();
        state.request.is_some() || state.making.is_some()
    }
}

impl<W, T> BuilderState<W, T> {
    fn stop(&mut self) {
        // What was stopped tells nothing any more: its flag is not in the state.
        self.making.take().into_iter().for_each(|flag| flag.store(true, Ordering::Relaxed));
    }
}

impl<W, T> Drop for Builder<W, T> {
    fn drop(&mut self) {
        let mut state = self.0.state();
        state.ends = true;
        state.stop();
        drop(state);
        self.0.wake.notify_one();
    }
}

impl<W, T> Workbench<W, T> {
    /// Waits for a request; returns it with the task that ends with [`Error::Cancelled`] once it is replaced; none when the
    /// builder is gone.
    pub fn next(&self) -> Option<(W, Task)> {
        let waiting = |state: &mut BuilderState<W, T>| state.request.is_none() && !state.ends;
        let state = self.0.wake.wait_while(self.0.state(), waiting);
        let mut state = state.unwrap_or_else(PoisonError::into_inner);
        if state.ends {
            return None;
        }
        let request = state.request.take()?;
        let task = Task::silent();
        state.making = Some(task.stop_flag());
        Some((request, task))
    }

    /// Hands over a draft of what is being made.
    pub fn draft(&self, task: &Task, draft: T) {
        self.hand_over(task, Made { result: Ok(draft), is_draft: true });
    }

    /// Hands over what was made, or why it cannot be made.
    pub fn finish(&self, task: &Task, result: Result<T>) {
        self.hand_over(task, Made { result, is_draft: false });
    }

    fn hand_over(&self, task: &Task, made: Made<T>) {
        let mut state = self.0.state();
        let flag = task.stop_flag();
        if !state.making.as_ref().is_some_and(|making| Arc::ptr_eq(making, &flag)) {
            return;
        }
        if !made.is_draft {
            state.making = None;
        }
        state.made.push(made);
        drop(state);
        (self.0.tell)();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Receiver, Sender, channel};

    use super::*;

    /// A builder that makes ten times the number that is requested, when it is let.
    struct Slow {
        builder: Builder<u32, u32>,
        /// The numbers that were begun.
        begun: Receiver<u32>,
        /// Lets it finish one, unless that is stopped.
        go: Sender<()>,
        /// Called when something was made.
        told: Receiver<()>,
        /// Those that were stopped.
        stopped: Receiver<u32>,
    }

    fn slow() -> Slow {
        let ((begins, begun), (go, may)) = (channel(), channel());
        let ((tells, told), (stops, stopped)) = (channel(), channel());
        let tell = move || {
            let _ = tells.send(());
        };
        let work = move |bench: &Workbench<u32, u32>| {
            while let Some((request, task)) = bench.next() {
                let _ = begins.send(request);
                bench.draft(&task, request);
                let made = loop {
                    match (task.check_cancelled(), may.try_recv()) {
                        (Err(error), _) => break Err(error),
                        (Ok(()), Ok(())) => break Ok(10 * request),
                        (Ok(()), Err(_)) => std::thread::yield_now(),
                    }
                };
                if made.is_err() {
                    let _ = stops.send(request);
                }
                bench.finish(&task, made);
            }
        };
        Slow { builder: Builder::start(|| (), tell, work).unwrap(), begun, go, told, stopped }
    }

    fn taken(builder: &Builder<u32, u32>) -> Vec<(u32, bool)> {
        builder.take().into_iter().map(|made| (made.result.unwrap(), made.is_draft)).collect()
    }

    #[test]
    fn the_newest_request_is_made_and_the_one_that_it_replaces_is_stopped() {
        let slow = slow();
        slow.builder.request(1);
        assert_eq!(slow.begun.recv(), Ok(1));
        // The second is never begun, because the third one replaces it before.
        slow.builder.request(3);
        assert_eq!((slow.stopped.recv(), slow.begun.recv()), (Ok(1), Ok(3)));
        slow.go.send(()).unwrap();
        while slow.builder.is_busy() {
            slow.told.recv().unwrap();
        }
        assert_eq!(taken(&slow.builder), [(3, true), (30, false)], "nothing of the first request is left");
        assert!(slow.begun.try_recv().is_err());
    }

    #[test]
    fn requests_that_were_replaced_before_they_were_begun_are_never_made() {
        let slow = slow();
        slow.builder.request(1);
        assert_eq!(slow.begun.recv(), Ok(1));
        {
            // The thread cannot take a request meanwhile.
            let mut state = slow.builder.0.state();
            state.stop();
            (state.request, state.made) = (Some(2), Vec::new());
        }
        slow.builder.request(4);
        let next = slow.begun.recv().unwrap();
        // It may have begun the second between the two, but then it was stopped.
        let last = if next == 2 { slow.begun.recv().unwrap() } else { next };
        assert_eq!(last, 4);
        slow.go.send(()).unwrap();
        while slow.builder.is_busy() {
            slow.told.recv().unwrap();
        }
        assert!(taken(&slow.builder).iter().all(|made| [4, 40].contains(&made.0)));
    }

    #[test]
    fn taking_does_not_wait_for_what_is_being_made() {
        let slow = slow();
        assert!(slow.builder.take().is_empty() && !slow.builder.is_busy());
        slow.builder.request(5);
        slow.told.recv().unwrap();
        // It would be made for ever.
        assert_eq!(taken(&slow.builder), [(5, true)]);
        for _ in 0..100 {
            assert!(slow.builder.take().is_empty() && slow.builder.is_busy());
        }
    }

    #[test]
    fn a_builder_that_is_dropped_stops_what_it_makes_and_its_thread_ends() {
        let slow = slow();
        slow.builder.request(7);
        assert_eq!(slow.begun.recv(), Ok(7));
        drop(slow.builder);
        assert_eq!(slow.stopped.recv(), Ok(7));
        assert!(slow.begun.recv().is_err(), "the thread has let go of its channels");
    }

    #[test]
    fn its_thread_has_its_name_and_does_all_of_the_work_itself() {
        use rayon::prelude::*;
        let (send, receive) = channel();
        let work = move |_: &Workbench<u32, u32>| {
            let name = || std::thread::current().name().map(str::to_owned);
            let names: Vec<_> = (0..64).into_par_iter().map(|_| name()).collect();
            let _ = send.send(names);
        };
        let _builder = Builder::start(|| (), || (), work).unwrap();
        assert_eq!(receive.recv().unwrap(), vec![Some(NAME.to_owned()); 64]);
    }
}
