//! Faults on demand, for tests of the whole program; nothing at all without the feature `fault-injection`.
//!
//! The environment variable [`VARIABLE`] names a file. Each line of it is an order, `POINT panic`, `POINT overflow`,
//! `POINT stall` or `POINT hang`: the next thread that passes [`point`] with that name panics once, or overflows its
//! stack, or sleeps for 1.5 s, or every one that passes stops there for ever. The file is read at [`begin`] and then
//! watched; orders that were taken are gone from it.

/// Names the file of orders.
pub const VARIABLE: &str = "ELITESERVER_FAULTS";

#[cfg(not(feature = "fault-injection"))]
mod on_demand {
    /// Watches for orders.
    pub const fn begin() {}

    /// A place where a fault can be raised.
    #[inline(always)]
    pub const fn point(_name: &str) {}
}

#[cfg(feature = "fault-injection")]
mod on_demand {
    use std::fs;
    use std::path::{Path, PathBuf};
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::time::Duration;

    use parking_lot::{Mutex, MutexGuard};

    use crate::{ThreadRole, ThreadSupervisor};

    /// Time between two looks at the file.
    const LOOK: Duration = Duration::from_millis(2);

    #[derive(Clone, Copy, PartialEq)]
    enum Action {
        Panic,
        Overflow,
        Stall,
        Hang,
    }

    /// How long a thread sleeps that stalls.
    const STALL: Duration = Duration::from_millis(1500);

    /// Recursion that asks nobody whether there is room.
    fn fall(level: u64) -> u64 {
        let frame = std::hint::black_box([level; 20]);
        match level {
            u64::MAX => 0,
            _ => fall(level + 1) + frame[level as usize % 20],
        }
    }

    /// The way of a point when nothing is ordered, which the control cycle takes, too.
    static IS_ARMED: AtomicBool = AtomicBool::new(false);
    static ARMED: Mutex<Vec<(String, Action)>> = Mutex::new(Vec::new());

    fn armed() -> MutexGuard<'static, Vec<(String, Action)>> {
        ARMED.lock()
    }

    /// Watches for orders.
    pub fn begin() {
        let Some(path) = std::env::var_os(super::VARIABLE).map(PathBuf::from) else {
            return;
        };
        take_orders(&path);
        let started =
            ThreadSupervisor::default().start(ThreadRole::Service, "fault-injection", move || {
                loop {
                    std::thread::sleep(LOOK);
                    take_orders(&path);
                }
            });
        if let Err(error) = started {
            tracing::error!("no faults on demand: {error}");
        }
    }

    fn take_orders(path: &Path) {
        let Ok(text) = fs::read_to_string(path) else {
            return;
        };
        // An order is whole once its line has ended.
        if !text.ends_with('\n') || fs::remove_file(path).is_err() {
            return;
        }
        text.lines().for_each(order);
    }

    /// Takes one order, for tests in the same process.
    pub fn order(line: &str) {
        let action = match line.split_once(' ') {
            Some((name, "panic")) => (name.to_owned(), Action::Panic),
            Some((name, "overflow")) => (name.to_owned(), Action::Overflow),
            Some((name, "stall")) => (name.to_owned(), Action::Stall),
            Some((name, "hang")) => (name.to_owned(), Action::Hang),
            _ => {
                tracing::error!("no order for a fault: {line}");
                return;
            }
        };
        armed().push(action);
        IS_ARMED.store(true, Ordering::Release);
    }

    /// A place where a fault can be raised.
    pub fn point(name: &str) {
        if !IS_ARMED.load(Ordering::Acquire) {
            return;
        }
        let mut orders = armed();
        let Some(place) = orders.iter().position(|(wanted, _)| wanted == name) else {
            return;
        };
        let action = orders[place].1;
        if action != Action::Hang {
            orders.remove(place);
        }
        drop(orders);
        match action {
            Action::Panic => panic!("a fault on demand in {name}"),
            Action::Overflow => {
                std::hint::black_box(fall(0));
            }
            Action::Stall => std::thread::sleep(STALL),
            Action::Hang => loop {
                std::thread::sleep(Duration::from_secs(3600));
            },
        }
    }
}

#[cfg(feature = "fault-injection")]
pub use on_demand::order;
pub use on_demand::{begin, point};
