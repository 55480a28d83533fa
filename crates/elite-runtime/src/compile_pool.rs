//! Where texts from outside are compiled: on a few threads of their own, so that a long text holds up no port.
//!
//! Owns the queue and its threads. Texts are taken in the order they came; whoever waits for one has no second in the
//! queue, so nobody's texts come before those of others for long. Short texts have a thread that takes no long ones.
//! What is compiled and what is done with the findings is up to the caller.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use messages::Localized;
use supervision::{Fault, ThreadRole, ThreadSupervisor, catch, injection};
use thiserror::Error;
use tokio::sync::oneshot;

/// Most texts that wait; one more is refused.
const WAITING_MAX: usize = 256;
/// Longest text, in bytes, that the thread for short ones takes.
const SHORT_MAX: usize = 64 << 10;

/// The reason for which a text was not compiled.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq, Localized)]
pub enum CompilePoolError {
    /// Too many texts wait.
    #[error("{WAITING_MAX} texts wait to be compiled already")]
    #[zh("已有 {WAITING_MAX} 个文本等待编译")]
    Full,
    /// The compiler ended in a bug, or no thread could be started.
    #[error("the text could not be compiled: the compiler failed")]
    #[zh("文本无法编译：编译器出错")]
    Failed,
}

/// Compiles texts beside the threads that answer ports.
#[derive(Default)]
pub struct CompilePool {
    shared: Arc<CompileQueue>,
    faults: ThreadSupervisor,
}

#[derive(Default)]
struct CompileQueue {
    queue: Mutex<Queue>,
    /// Something waits, or the pool is given up.
    news: Condvar,
}

#[derive(Default)]
struct Queue {
    short: VecDeque<CompileJob>,
    long: VecDeque<CompileJob>,
    threads_started: bool,
    closed: bool,
}

/// Compiles a text and hands the result over.
type CompileJob = Box<dyn FnOnce() + Send>;

/// The texts that a thread of the pool takes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum WorkerKind {
    Short,
    Any,
}

impl CompilePool {
    /// A pool whose threads start with its first text. `faults` hears of bugs of the compiler.
    pub fn new(faults: ThreadSupervisor) -> Self {
        let shared = Arc::default();
        CompilePool { shared, faults }
    }

    /// Runs `compile`, which works on a text of `bytes`, on a thread of the pool. It is left out if nobody waits for it
    /// any more when its turn comes.
    ///
    /// # Errors
    /// [`CompilePoolError`]
    pub async fn run<T: Send + 'static>(
        &self,
        bytes: usize,
        compile: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, CompilePoolError> {
        let (sender, receiver) = oneshot::channel();
        let faults = self.faults.clone();
        let job = Box::new(move || {
            if sender.is_closed() {
                return;
            }
            // A bug costs this text, not the thread; the caller hears that its sender is gone.
            match catch(|| {
                injection::point("compiler");
                compile()
            }) {
                Ok(result) => drop(sender.send(result)),
                Err(panicked) => {
                    faults.tell(&Fault::new(ThreadRole::Service, "compiler", panicked))
                }
            }
        });
        self.add(bytes, job)?;
        receiver.await.map_err(|_| CompilePoolError::Failed)
    }

    fn add(&self, bytes: usize, job: CompileJob) -> Result<(), CompilePoolError> {
        let mut queue = self.shared.queue();
        if queue.short.len() + queue.long.len() >= WAITING_MAX {
            return Err(CompilePoolError::Full);
        }
        if !queue.threads_started {
            for (name, takes) in [
                ("compile-short", WorkerKind::Short),
                ("compile-any", WorkerKind::Any),
            ] {
                self.start_thread(name, takes)?;
            }
            queue.threads_started = true;
        }
        if bytes <= SHORT_MAX {
            queue.short.push_back(job);
        } else {
            queue.long.push_back(job);
        }
        drop(queue);
        self.shared.news.notify_all();
        Ok(())
    }

    fn start_thread(&self, name: &str, takes: WorkerKind) -> Result<(), CompilePoolError> {
        let shared = self.shared.clone();
        let texts = move || {
            while let Some(job) = shared.next(takes) {
                job();
            }
        };
        let started = self
            .faults
            .start(ThreadRole::Service, name.to_owned(), texts);
        started.map(drop).map_err(|_| CompilePoolError::Failed)
    }
}

impl Drop for CompilePool {
    fn drop(&mut self) {
        self.shared.queue().closed = true;
        self.shared.news.notify_all();
    }
}

impl CompileQueue {
    fn queue(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next text; waits for one. `None` when the pool is given up.
    fn next(&self, takes: WorkerKind) -> Option<CompileJob> {
        let mut queue = self.queue();
        loop {
            if queue.closed {
                return None;
            }
            let job = match takes {
                WorkerKind::Short => queue.short.pop_front(),
                // Long ones first: the short ones have a thread of their own.
                WorkerKind::Any => queue.long.pop_front().or_else(|| queue.short.pop_front()),
            };
            if job.is_some() {
                return job;
            }
            queue = self
                .news
                .wait(queue)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;

    fn block_on<T>(future: impl Future<Output = T>) -> T {
        tokio::runtime::Builder::new_current_thread()
            .build()
            .unwrap()
            .block_on(future)
    }

    #[test]
    fn a_short_text_is_compiled_while_a_long_one_is() {
        let pool = CompilePool::new(ThreadSupervisor::default());
        let (release, held) = mpsc::channel::<()>();
        block_on(async {
            let long = pool.run(8 << 20, move || held.recv().is_ok());
            let short = async {
                let result = pool.run(10, || 7).await;
                release.send(()).unwrap();
                result
            };
            assert_eq!(tokio::join!(long, short), (Ok(true), Ok(7)));
        });
    }

    #[test]
    fn a_bug_costs_one_text() {
        let pool = CompilePool::new(ThreadSupervisor::default());
        let bug = block_on(pool.run(10, || -> u8 { panic!("a bug in the compiler") }));
        assert_eq!(bug, Err(CompilePoolError::Failed));
        assert_eq!(block_on(pool.run(10, || 1)), Ok(1));
    }

    #[test]
    fn a_full_queue_refuses_and_forgets_texts_nobody_waits_for() {
        let pool = CompilePool::new(ThreadSupervisor::default());
        let (release, held) = mpsc::channel::<()>();
        let (begun, has_begun) = mpsc::channel();
        block_on(async {
            let mut waiting = Vec::new();
            let first = Box::pin(pool.run(8 << 20, move || {
                begun.send(()).unwrap();
                held.recv().is_ok()
            }));
            let mut first = first;
            assert!(futures_poll(&mut first).is_none());
            has_begun.recv().unwrap();
            let (ran, has_run) = mpsc::channel();
            for _ in 0..WAITING_MAX {
                let ran = ran.clone();
                let mut next = Box::pin(pool.run(8 << 20, move || ran.send(()).is_ok()));
                assert!(futures_poll(&mut next).is_none());
                waiting.push(next);
            }
            drop(ran);
            assert_eq!(pool.run(8 << 20, || ()).await, Err(CompilePoolError::Full));
            drop(waiting);
            release.send(()).unwrap();
            assert_eq!(first.await, Ok(true));
            assert!(has_run.recv().is_err(), "nobody waits for these");
        });
    }

    /// Polls a future once.
    fn futures_poll<F: Future + Unpin>(future: &mut F) -> Option<F::Output> {
        let mut context = std::task::Context::from_waker(std::task::Waker::noop());
        match std::pin::Pin::new(future).poll(&mut context) {
            std::task::Poll::Ready(output) => Some(output),
            std::task::Poll::Pending => None,
        }
    }
}
