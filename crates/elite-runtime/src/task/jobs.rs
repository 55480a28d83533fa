//! Waits on the outside world: futures that run beside the script threads on the task's own runtime.
//!
//! A builtin starts a job and suspends its thread until the job is done; other threads go on meanwhile. A job that
//! nobody waits for any more is dropped with what it holds. Under the virtual clock the scheduler lets simulated time
//! pass at wall pace while a job is open. Needs a tokio `LocalSet`.

use std::any::Any;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use supervision::{CatchPanic, CaughtPanic};
use tokio::sync::Notify;
use tokio::task::AbortHandle;

/// Number of a job in its task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct JobId(u64);

/// The jobs of one task. Clones share them.
#[derive(Clone, Default)]
pub(crate) struct JobSet {
    shared: Rc<JobTable>,
}

#[derive(Default)]
struct JobTable {
    jobs: RefCell<Jobs>,
    news: Notify,
    /// A job has panicked; the task ends with it.
    panicked: RefCell<Option<CaughtPanic>>,
}

#[derive(Default)]
struct Jobs {
    last: u64,
    open: BTreeMap<JobId, Job>,
}

struct Job {
    task: Option<AbortHandle>,
    result: Option<Box<dyn Any>>,
}

impl JobSet {
    /// Starts a job.
    pub fn start<T: 'static>(&self, future: impl Future<Output = T> + 'static) -> JobId {
        let mut jobs = self.shared.jobs.borrow_mut();
        jobs.last += 1;
        let id = JobId(jobs.last);
        let shared = Rc::clone(&self.shared);
        #[allow(
            clippy::disallowed_methods,
            reason = "the one place where jobs of a task start; a panic is contained and ends the task"
        )]
        let task = tokio::task::spawn_local(async move {
            let result = CatchPanic::new(future).await;
            match (result, shared.jobs.borrow_mut().open.get_mut(&id)) {
                (Ok(result), Some(job)) => {
                    job.result = Some(Box::new(result));
                    job.task = None;
                }
                (Ok(_), None) => {}
                (Err(panicked), _) => drop(shared.panicked.replace(Some(panicked))),
            }
            shared.news.notify_one();
        });
        let job = Job {
            task: Some(task.abort_handle()),
            result: None,
        };
        jobs.open.insert(id, job);
        id
    }

    /// True once the job has its result, and for a job that does not exist.
    pub fn is_done(&self, id: JobId) -> bool {
        let jobs = self.shared.jobs.borrow();
        jobs.open.get(&id).is_none_or(|job| job.result.is_some())
    }

    /// The result of a job that is done; forgets the job.
    pub fn take<T: 'static>(&self, id: JobId) -> Option<T> {
        let job = self.shared.jobs.borrow_mut().open.remove(&id)?;
        job.result?.downcast().ok().map(|result| *result)
    }

    /// Drops a job that nobody waits for any more.
    pub fn cancel(&self, id: JobId) {
        let job = self.shared.jobs.borrow_mut().open.remove(&id);
        if let Some(task) = job.and_then(|job| job.task) {
            task.abort();
        }
    }

    /// The panic of a job, once.
    pub fn take_panic(&self) -> Option<CaughtPanic> {
        self.shared.panicked.take()
    }

    /// True while a job has no result yet.
    pub fn is_open(&self) -> bool {
        let jobs = self.shared.jobs.borrow();
        jobs.open.values().any(|job| job.result.is_none())
    }

    /// Waits until a job is done that was not done at the last call.
    pub async fn news(&self) {
        self.shared.news.notified().await;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(test: impl Future<Output = ()>) {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .unwrap();
        tokio::task::LocalSet::new().block_on(&runtime, test);
    }

    #[test]
    fn a_job_gives_its_result_once() {
        run(async {
            let outside = JobSet::default();
            let job = outside.start(async { 7 });
            assert!(outside.is_open() && !outside.is_done(job));
            outside.news().await;
            assert!(!outside.is_open() && outside.is_done(job));
            assert_eq!(outside.take::<i32>(job), Some(7));
            assert_eq!(outside.take::<i32>(job), None);
        });
    }

    #[test]
    fn a_job_that_panics_says_so() {
        run(async {
            let outside = JobSet::default();
            outside.start(async { panic!("here") });
            outside.news().await;
            assert_eq!(outside.take_panic().unwrap().message, "here");
            assert!(outside.take_panic().is_none());
        });
    }

    #[test]
    fn a_cancelled_job_drops_what_it_holds() {
        run(async {
            let outside = JobSet::default();
            let held = Rc::new(());
            let inside = held.clone();
            let job = outside.start(async move {
                let _inside = inside;
                std::future::pending::<()>().await;
            });
            tokio::task::yield_now().await;
            outside.cancel(job);
            tokio::task::yield_now().await;
            assert_eq!(Rc::strong_count(&held), 1);
            assert!(!outside.is_open());
        });
    }
}
