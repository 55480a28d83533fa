//! Tasks of a tokio runtime, started like threads.

use tokio::runtime::Handle as Runtime;
use tokio::task::JoinHandle;

use crate::contained::CatchPanic;
use crate::faults::{FIRST_PAUSE, next_restart_delay};
use crate::{Fault, ThreadRole, ThreadSupervisor};

impl ThreadSupervisor {
    /// Makes a future whose panic is told here and becomes its result. For sets of tasks that others keep.
    pub fn catch_panics<F>(
        &self,
        kind: ThreadRole,
        name: &'static str,
        future: F,
    ) -> impl Future<Output = Result<F::Output, Fault>> + Send + use<F>
    where
        F: Future + Send,
        F::Output: Send,
    {
        let faults = self.clone();
        let contained = CatchPanic::new(future);
        async move {
            contained.await.map_err(|panicked| {
                let fault = Fault::new(kind, name, panicked);
                faults.tell(&fault);
                fault
            })
        }
    }

    /// Starts a task on the current runtime.
    pub fn spawn<F>(
        &self,
        kind: ThreadRole,
        name: &'static str,
        future: F,
    ) -> JoinHandle<Result<F::Output, Fault>>
    where
        F: Future + Send + 'static,
        F::Output: Send + 'static,
    {
        self.spawn_on(&Runtime::current(), kind, name, future)
    }

    /// Starts a task on a runtime.
    pub fn spawn_on<F>(
        &self,
        runtime: &Runtime,
        kind: ThreadRole,
        name: &'static str,
        future: F,
    ) -> JoinHandle<Result<F::Output, Fault>>
    where
        F: Future + Send + 'static,
        F::Output: Send + 'static,
    {
        #[allow(clippy::disallowed_methods, reason = "the one place where tasks start")]
        runtime.spawn(self.catch_panics(kind, name, future))
    }

    /// A service of futures: `begin` is called again, after a growing pause, when what it made has panicked. Ends with
    /// the first future that ends by itself.
    pub async fn run_restarting<F>(&self, name: &'static str, mut begin: impl FnMut() -> F + Send)
    where
        F: Future<Output = ()> + Send,
    {
        let mut pause = FIRST_PAUSE;
        while self
            .catch_panics(ThreadRole::Service, name, begin())
            .await
            .is_err()
        {
            tokio::time::sleep(pause).await;
            pause = next_restart_delay(pause);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(flavor = "current_thread")]
    async fn a_task_that_panics_says_so_to_whoever_waits_and_to_the_watcher() {
        let faults = ThreadSupervisor::default();
        let task = faults.spawn(ThreadRole::Port, "session", async { panic!("here") });
        let fault: Fault = task.await.unwrap().unwrap_err();
        assert_eq!(fault.message, "here");
        assert_eq!(faults.counts()[1], (ThreadRole::Port, 1));
    }

    #[tokio::test(flavor = "current_thread")]
    async fn a_service_is_begun_again_until_it_ends_by_itself() {
        let faults = ThreadSupervisor::default();
        let mut begun = 0;
        faults
            .run_restarting("service", || {
                begun += 1;
                let is_ready = begun == 3;
                async move { assert!(is_ready, "not yet") }
            })
            .await;
        assert_eq!(faults.counts()[2], (ThreadRole::Service, 2));
    }
}
