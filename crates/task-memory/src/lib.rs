//! Memory of one task: a counting allocator, its free lists, the memory alarm, and the fuel that the alarm withholds.
//!
//! Linking this crate installs the global allocator, so no interpreter runs unlimited. A task runs on one thread of the
//! system, and counts what its thread has come to hold since its interpreter was made: numbers, small objects, tables,
//! compiled text, whatever a library allocates on its behalf.
//!
//! ```
//! let before = task_memory::live_bytes();
//! let buffer: Vec<u8> = Vec::with_capacity(1000);
//! assert_eq!(task_memory::live_bytes() - before, 1024);
//! drop(buffer);
//! assert_eq!(task_memory::live_bytes(), before);
//!
//! // Beyond the alarm no safepoint can be passed until the memory has been compared with the limit.
//! task_memory::set_fuel(10);
//! task_memory::set_alarm(task_memory::live_bytes() + 4096);
//! let too_much = vec![0_u8; 8192];
//! assert!(!task_memory::consume_fuel());
//! drop(too_much);
//! assert!(task_memory::take_alarm() && task_memory::consume_fuel());
//! ```

mod account;
mod allocator;
mod free_lists;
mod fuel;

pub use account::{
    add_external, allocated_bytes, clone_uncounted, live_bytes, remove_external, set_alarm,
    take_alarm, uncounted,
};
pub use allocator::{CountingAllocator, clear_free_lists, set_unmap_deferred, unmap_deferred};
pub use fuel::{consume_fuel, fuel, set_fuel};
