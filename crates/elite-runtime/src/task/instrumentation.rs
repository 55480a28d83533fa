//! What a task is given only where programs are tested or debugged: somebody beside it, stand-ins for machines on the
//! network, lines that are counted, a debugger.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use elite_lang::LineCounts;
use io_bus::SimulatedPeers;

use crate::debug::DebuggerHost;
use crate::test_task::TestTaskConfig;

/// Executions by text and line.
pub type LineCountsByText = BTreeMap<String, LineCounts>;

/// All of it; nothing by default.
#[derive(Clone, Default)]
pub struct Instrumentation {
    /// The program is such a one itself.
    pub attendant: Option<TestTaskConfig>,
    /// Consulted before the network is.
    pub stand_ins: Option<Arc<dyn SimulatedPeers>>,
    /// Who debugs the programs.
    pub debug: Option<Arc<dyn DebuggerHost>>,
    /// Where the counts of executed lines are added when a task ends.
    pub line_counts: Option<Arc<Mutex<LineCountsByText>>>,
}

impl Instrumentation {
    /// Adds what a task has counted.
    pub(super) fn add_counts(&self, counted: LineCountsByText) {
        let Some(counts) = &self.line_counts else {
            return;
        };
        let mut counts = counts
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        for (text, lines) in counted {
            let sums = counts.entry(text).or_default();
            for (line, executed) in lines {
                let sum = sums.entry(line).or_insert(0);
                *sum = sum.saturating_add(executed);
            }
        }
    }
}
