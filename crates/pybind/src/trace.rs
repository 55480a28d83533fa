//! Every cycle of a controller as rows in memory, up to a bound; then the oldest are dropped.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

use elite_runtime::message::Observer;
use motion_api::CycleFrame;

use crate::row::Row;

/// Rows in a block: 0.2 MiB each.
const BLOCK_ROWS: usize = 256;

/// The rows that are kept.
pub(crate) struct CycleBuffer {
    most: usize,
    kept: Mutex<TraceBuffer>,
}

#[derive(Default)]
struct TraceBuffer {
    blocks: VecDeque<Vec<u8>>,
    dropped: u64,
}

impl CycleBuffer {
    /// Keeps the newest `most` cycles, rounded up to a block; 0 keeps none.
    pub(crate) fn new(most: usize) -> Self {
        Self {
            most,
            kept: Mutex::default(),
        }
    }

    /// The rows one after the other, and how many came before them.
    pub(crate) fn bytes(&self) -> (Vec<u8>, u64) {
        let kept = self.kept();
        let mut bytes = Vec::with_capacity(kept.blocks.iter().map(Vec::len).sum());
        kept.blocks
            .iter()
            .for_each(|block| bytes.extend_from_slice(block));
        (bytes, kept.dropped)
    }

    /// The value is whole at every moment, so a poisoned lock is as good as any.
    fn kept(&self) -> MutexGuard<'_, TraceBuffer> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Observer for CycleBuffer {
    fn cycle_ended(&self, frame: &CycleFrame) {
        if self.most == 0 {
            return;
        }
        let mut kept = self.kept();
        let full = BLOCK_ROWS * Row::BYTES;
        if kept.blocks.back().is_none_or(|block| block.len() >= full) {
            let blocks_max = self.most.div_ceil(BLOCK_ROWS);
            let mut block = Vec::new();
            if kept.blocks.len() > blocks_max
                && let Some(oldest) = kept.blocks.pop_front()
            {
                kept.dropped += (oldest.len() / Row::BYTES) as u64;
                block = oldest;
                block.clear();
            }
            block.reserve_exact(full);
            kept.blocks.push_back(block);
        }
        if let Some(block) = kept.blocks.back_mut() {
            Row::from(&frame.state).write(block);
        }
    }
}
