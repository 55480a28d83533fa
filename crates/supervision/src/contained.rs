//! Catching panics: in a call, and in each step of a future.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind};
use std::pin::Pin;
use std::task::{Context, Poll};

/// What a panic said, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CaughtPanic {
    /// The words.
    pub message: String,
    /// `file:line`; known only with [`install_panic_hook`].
    pub place: Option<String>,
}

thread_local! {
    /// How many containments the thread is in: inside one the hook stays silent, whoever caught the panic tells.
    static DEPTH: Cell<u32> = const { Cell::new(0) };
    static PLACE: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Panics are remembered with their place; those that nobody here catches are logged, on the way the log goes. Never
/// writes to standard error itself: that could wait for whoever reads it.
pub fn install_panic_hook() {
    std::panic::set_hook(Box::new(|info| {
        let place = info
            .location()
            .map(|at| format!("{}:{}", at.file(), at.line()));
        let told = DEPTH.try_with(Cell::get).is_ok_and(|depth| depth > 0);
        if !told {
            let message = words(info);
            let at = place.as_deref().unwrap_or("an unknown place");
            tracing::error!("a fault of ours: {message} ({at}); please report it");
        }
        let trace = std::backtrace::Backtrace::capture();
        if trace.status() == std::backtrace::BacktraceStatus::Captured {
            tracing::error!("the fault came about so:\n{trace}");
        }
        // A thread that is being taken down has no more place for it.
        let _ = PLACE.try_with(|kept| kept.replace(place));
    }));
}

fn words(info: &PanicHookInfo<'_>) -> String {
    info.payload_as_str()
        .unwrap_or("a panic without words")
        .to_owned()
}

/// Runs `body`; a panic of it becomes an error. What `body` shares with others must be whole at every moment or be
/// given up by the caller.
///
/// # Errors
/// The panic.
pub fn catch<T>(body: impl FnOnce() -> T) -> Result<T, CaughtPanic> {
    let _depth = ContainmentGuard::new();
    catch_unwind(AssertUnwindSafe(body)).map_err(describe)
}

fn describe(payload: Box<dyn Any + Send>) -> CaughtPanic {
    let message = payload
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned())
        .or_else(|| payload.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "a panic without words".to_owned());
    // The payload is anybody's: its destructor may panic, too.
    let _ = catch_unwind(AssertUnwindSafe(move || drop(payload)));
    let place = PLACE.try_with(RefCell::take).ok().flatten();
    CaughtPanic { message, place }
}

struct ContainmentGuard;

impl ContainmentGuard {
    fn new() -> Self {
        DEPTH.with(|depth| depth.set(depth.get() + 1));
        Self
    }
}

impl Drop for ContainmentGuard {
    fn drop(&mut self) {
        DEPTH.with(|depth| depth.set(depth.get() - 1));
    }
}

/// A future whose panic becomes its result. After a panic the inner future is dropped.
pub struct CatchPanic<F> {
    inner: Option<Pin<Box<F>>>,
}

impl<F: Future> CatchPanic<F> {
    /// Contains a future.
    pub fn new(future: F) -> Self {
        Self {
            inner: Some(Box::pin(future)),
        }
    }
}

impl<F: Future> Future for CatchPanic<F> {
    type Output = Result<F::Output, CaughtPanic>;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        let Some(inner) = &mut self.inner else {
            // The future has given its result already, and nobody may poll it again.
            return Poll::Pending;
        };
        let given = match catch(|| inner.as_mut().poll(context)) {
            Ok(Poll::Pending) => return Poll::Pending,
            Ok(Poll::Ready(output)) => Ok(output),
            Err(panicked) => Err(panicked),
        };
        // What the future held goes now, inside a containment of its own.
        let inner = self.inner.take();
        let dropped = catch(move || drop(inner));
        Poll::Ready(given.and_then(|output| dropped.map(|()| output)))
    }
}

impl<F> Drop for CatchPanic<F> {
    fn drop(&mut self) {
        if let Some(inner) = self.inner.take()
            && let Err(panicked) = catch(move || drop(inner))
        {
            tracing::error!(
                "a fault of ours in something that was given up: {}; please report it",
                panicked.message
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::future::ready;

    #[test]
    fn a_future_that_panics_gives_the_panic_and_what_it_held() {
        let held = std::rc::Rc::new(());
        let inside = held.clone();
        let runtime = tokio::runtime::Builder::new_current_thread()
            .build()
            .unwrap();
        let given = runtime.block_on(CatchPanic::new(async move {
            let _inside = inside;
            ready(()).await;
            panic!("halfway");
        }));
        let given: Result<(), CaughtPanic> = given;
        assert_eq!(given.unwrap_err().message, "halfway");
        assert_eq!(std::rc::Rc::strong_count(&held), 1);
        assert_eq!(runtime.block_on(CatchPanic::new(ready(7))), Ok(7));
    }

    #[test]
    fn the_place_of_a_panic_is_known_once_the_hook_is_installed() {
        install_panic_hook();
        let panicked = catch(|| panic!("here")).unwrap_err();
        let place = panicked.place.unwrap();
        assert!(place.starts_with(file!()), "{place}");
        drop(std::panic::take_hook());
    }
}
