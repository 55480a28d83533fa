//! The processes that a task has started, and those that these have started: found, and ended with the task.
//!
//! Nothing that descends from the controller is lost: orphans become the controller's own children. A descendant is the
//! task's when it comes from a process the task has started, or stands in the group or session of one, also when that
//! one has gone. Where all children of this process are tasks' (the binary says so at its start), an orphan that has
//! left its group and its session is the task's as well. Owns who belongs to whom; the table of processes is the
//! system's (`platform`).

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use platform::processes::{self, ProcessEntry, ProcessTable, SignalTarget, process_table};

/// Whether this process has no other children than those of tasks.
static ALL_CHILDREN: AtomicBool = AtomicBool::new(false);
/// Children that are no task's all the same.
static OWN_CHILDREN: Mutex<BTreeSet<i32>> = Mutex::new(BTreeSet::new());
/// Rounds of looking and killing at the end of a task, and the pause between them: a second at most.
const ROUNDS_MAX: u32 = 1000;
const PAUSE: Duration = Duration::from_millis(1);
/// Most processes whose numbers are kept before those that nothing refers to are forgotten.
const STARTED_MAX: usize = 256;

/// Tells that this process starts no other processes than those of tasks: every child it comes to have is then ended
/// with the task that runs.
pub fn claim_all_children() {
    ALL_CHILDREN.store(true, Ordering::Relaxed);
}

/// What a task has started.
#[derive(Debug, Default)]
pub(super) struct ProcessTree {
    /// Numbers of the processes that the task itself has started; each is also the number of a group.
    started: BTreeSet<i32>,
}

/// A child of this process that is no task's, as long as this lives: the end of a task leaves it alone.
#[derive(Debug)]
pub struct OwnChild(i32);

impl OwnChild {
    /// The child with this number.
    pub fn new(number: i32) -> Self {
        own_children().insert(number);
        Self(number)
    }
}

impl Drop for OwnChild {
    fn drop(&mut self) {
        own_children().remove(&self.0);
    }
}

fn own_children() -> MutexGuard<'static, BTreeSet<i32>> {
    OWN_CHILDREN.lock().unwrap_or_else(PoisonError::into_inner)
}

impl ProcessTree {
    /// Call before a process is started.
    pub fn prepare(&mut self) {
        if self.started.is_empty() {
            processes::adopt_orphans();
        } else if self.started.len() >= STARTED_MAX {
            let table = process_table();
            let used: BTreeSet<i32> = table
                .iter()
                .flat_map(|(number, entry)| [*number, entry.group, entry.session])
                .collect();
            self.started.retain(|number| used.contains(number));
            reap(&table, &self.started);
        }
    }

    /// The task has started this process, in a group of its own.
    pub fn add(&mut self, number: i32) {
        self.started.insert(number);
    }

    /// Kills everybody, and who is born meanwhile.
    pub fn end(&mut self) {
        if self.started.is_empty() {
            return;
        }
        let own = own_number();
        for _ in 0..ROUNDS_MAX {
            let table = process_table();
            let all = ALL_CHILDREN.load(Ordering::Relaxed);
            let spared = own_children().clone();
            let members = descendants(&table, own, (&self.started, &spared), all);
            for number in &members {
                processes::kill(SignalTarget::Process(*number));
            }
            reap(&table, &self.started);
            if members.is_empty() {
                break;
            }
            std::thread::sleep(PAUSE);
        }
        self.started.clear();
    }
}

/// Living processes that belong to the processes `started` by a task of process `own`. With `all`, every descendant of
/// `own` belongs to them, but for the `spared` children and their descendants.
fn descendants(
    table: &ProcessTable,
    own: i32,
    (started, spared): (&BTreeSet<i32>, &BTreeSet<i32>),
    all: bool,
) -> Vec<i32> {
    let is_member = |number: i32, entry: &ProcessEntry| {
        let mut ancestors = 0;
        let (mut at, mut belongs) = (number, false);
        loop {
            let Some(entry) = table.get(&at) else {
                return false;
            };
            belongs |= [at, entry.group, entry.session]
                .iter()
                .any(|number| started.contains(number));
            ancestors += 1;
            if entry.parent == own {
                break;
            }
            // A number used anew while the table was read could make a ring of it.
            if entry.parent <= 1 || ancestors > table.len() {
                return false;
            }
            at = entry.parent;
        }
        !entry.ended && (belongs || all && !spared.contains(&at))
    };
    let found = table.iter().filter(|(n, entry)| is_member(**n, entry));
    found.map(|(number, _)| *number).collect()
}

/// Asks orphans that have ended how they ended, so that their numbers are free again. Who was started here is asked by
/// whoever started it.
fn reap(table: &ProcessTable, started: &BTreeSet<i32>) {
    if !ALL_CHILDREN.load(Ordering::Relaxed) {
        return;
    }
    let (own, spared) = (own_number(), own_children().clone());
    for (number, entry) in table {
        let is_asked = started.contains(number) || spared.contains(number);
        if entry.parent == own && entry.ended && !is_asked {
            processes::reap(*number);
        }
    }
}

fn own_number() -> i32 {
    i32::try_from(std::process::id()).unwrap_or(i32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(parent: i32, group: i32, session: i32) -> ProcessEntry {
        ProcessEntry {
            parent,
            group,
            session,
            ended: false,
        }
    }

    #[test]
    fn who_descends_from_the_task_belongs_to_it_and_nobody_else() {
        let own = 100;
        let table = ProcessTable::from([
            (1, entry(0, 1, 1)),
            (100, entry(1, 100, 100)),
            // Started by the task, and what it has started.
            (200, entry(100, 200, 100)),
            (201, entry(200, 200, 100)),
            (202, entry(201, 202, 202)),
            // Orphans: of the group of one that has gone, of its session, and one that has left both.
            (301, entry(100, 300, 100)),
            (302, entry(100, 302, 300)),
            (303, entry(100, 303, 303)),
            // Somebody else's child, somebody else's process whose group has the number of one of ours.
            (400, entry(100, 400, 100)),
            (500, entry(1, 300, 500)),
            // Two that name each other.
            (600, entry(601, 600, 600)),
            (601, entry(600, 600, 600)),
        ]);
        let started = BTreeSet::from([200, 300]);
        let nobody = BTreeSet::new();
        assert_eq!(
            descendants(&table, own, (&started, &nobody), false),
            [200, 201, 202, 301, 302]
        );
        assert_eq!(
            descendants(&table, own, (&started, &nobody), true),
            [200, 201, 202, 301, 302, 303, 400]
        );
        let spared = BTreeSet::from([400]);
        assert_eq!(
            descendants(&table, own, (&started, &spared), true),
            [200, 201, 202, 301, 302, 303]
        );
        let mut gone = table;
        gone.get_mut(&301).unwrap().ended = true;
        assert!(!descendants(&gone, own, (&started, &nobody), true).contains(&301));
    }
}
