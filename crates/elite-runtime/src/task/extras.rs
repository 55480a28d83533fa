//! What a task is given only where programs are tested or debugged: somebody beside it, stand-ins for machines on the network,
//! lines that are counted, a debugger.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use elite_lang::LineCounts;
use io_bus::StandIns;

use crate::attendant::Attendant;
use crate::debug::DebugLink;

/// Executions by text and line.
pub type LineCountsOfTexts = BTreeMap<String, LineCounts>;

/// All of it; nothing by default.
#[derive(Clone, Default)]
pub struct Extras {
    /// The program is such a one itself.
    pub attendant: Option<Attendant>,
    /// Consulted before the network is.
    pub stand_ins: Option<Arc<dyn StandIns>>,
    /// Who debugs the programs.
    pub debug: Option<Arc<dyn DebugLink>>,
    /// Where the counts of executed lines are added when a task ends.
    pub line_counts: Option<Arc<Mutex<LineCountsOfTexts>>>,
}

impl Extras {
    /// Adds what a task has counted.
    pub(super) fn add_counts(&self, counted: LineCountsOfTexts) {
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
