//! A thread with a runtime of its own for lines that outlive programs.

use std::io;
use std::sync::Arc;

use supervision::{Fault, ThreadRole, ThreadSupervisor};
use tokio::runtime::Handle;
use tokio::sync::Notify;
use tokio::task::JoinHandle;

/// The runtime. Dropping it ends the thread and everything on it.
pub(crate) struct RuntimeThread {
    name: &'static str,
    handle: Handle,
    ending: Arc<Notify>,
    faults: ThreadSupervisor,
}

impl RuntimeThread {
    /// Starts the thread.
    pub(crate) fn start(name: &'static str, faults: ThreadSupervisor) -> io::Result<Self> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()?;
        let handle = runtime.handle().clone();
        let ending = Arc::new(Notify::new());
        let told = ending.clone();
        faults.start(ThreadRole::Service, name, move || {
            runtime.block_on(told.notified());
            runtime.shutdown_background();
        })?;
        Ok(Self {
            name,
            handle,
            ending,
            faults,
        })
    }

    /// Starts something that ends by itself; its panic is its result.
    pub(crate) fn spawn<T: Send + 'static>(
        &self,
        work: impl Future<Output = T> + Send + 'static,
    ) -> JoinHandle<Result<T, Fault>> {
        self.faults
            .spawn_on(&self.handle, ThreadRole::Service, self.name, work)
    }

    /// Starts something that is begun again when it panics.
    pub(crate) fn spawn_restarting<F>(&self, begin: impl FnMut() -> F + Send + 'static)
    where
        F: Future<Output = ()> + Send + 'static,
    {
        let (faults, name) = (self.faults.clone(), self.name);
        drop(self.spawn(async move { faults.run_restarting(name, begin).await }));
    }
}

impl Drop for RuntimeThread {
    fn drop(&mut self) {
        self.ending.notify_one();
    }
}
