//! The sequence lock under loom: every interleaving of its atomics, by the file of the crate itself.

#[path = "../src/sequence_lock.rs"]
#[allow(dead_code, reason = "the model needs no part of a value")]
mod sequence_lock;
#[path = "../src/words.rs"]
#[allow(dead_code, reason = "the model needs one kind of value")]
mod words;

/// What `motion_api::atomics` takes from std.
mod atomics {
    pub(crate) use loom::sync::atomic::{AtomicU64, Ordering, fence};
    pub(crate) use loom::thread::yield_now as spin_loop;
}

use loom::sync::Arc;
// Named by `words` as parts of its own crate.
use motion_api::{CommandId, IoConfig, MotionMode, RobotMode, SafetyMode};

use sequence_lock::SequenceLock;

/// Every interleaving of one writer and one reader that loom finds: a reader never sees half of a write.
#[test]
fn a_reader_never_sees_half_a_write() {
    loom::model(|| {
        let cell = Arc::new(SequenceLock::new(&[0_u64; 2]));
        let writer = {
            let cell = cell.clone();
            loom::thread::spawn(move || cell.publish(&[1, 1]))
        };
        let [a, b] = cell.read();
        assert_eq!(a, b);
        writer.join().unwrap();
        assert_eq!(cell.read(), [1, 1]);
    });
}
