//! The processes that a task has started, and those that these have started: found, and ended with the task.
//!
//! Nothing that descends from the controller is lost: orphans become the controller's own children. A descendant is the
//! task's when it comes from a process the task has started, or stands in the group or session of one, also when that one
//! has gone. Where all children of this process are tasks' (the binary says so at its start), an orphan that has left its
//! group and its session is the task's as well. Knows the system's table of processes, nothing of pipes and scripts.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use nix::sys::prctl::set_child_subreaper;
use nix::sys::signal::{Signal, kill};
use nix::sys::wait::{WaitPidFlag, waitpid};
use nix::unistd::{Pid, getpid};

/// Whether this process has no other children than those of tasks.
static ALL_CHILDREN: AtomicBool = AtomicBool::new(false);
/// Rounds of looking and killing at the end of a task, and the pause between them: a second at most.
const ROUNDS_MAX: u32 = 1000;
const PAUSE: Duration = Duration::from_millis(1);
/// Most processes whose numbers are kept before those that nothing refers to are forgotten.
const STARTED_MAX: usize = 256;

/// Tells that this process starts no other processes than those of tasks: every child it comes to have is then ended
/// with the task that runs.
pub fn all_children_are_tasks() {
    ALL_CHILDREN.store(true, Ordering::Relaxed);
}

/// What a task has started.
#[derive(Debug, Default)]
pub(super) struct Family {
    /// Numbers of the processes that the task itself has started; each is also the number of a group.
    started: BTreeSet<i32>,
}

/// One line of the system's table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Entry {
    parent: i32,
    group: i32,
    session: i32,
    /// It has ended, and its parent has not asked how.
    ended: bool,
}

type Table = BTreeMap<i32, Entry>;

impl Family {
    /// Call before a process is started.
    pub fn prepare(&mut self) {
        if self.started.is_empty() {
            // Without it (an old kernel) orphans are found by their group or session as long as they keep one.
            let _ = set_child_subreaper(true);
        } else if self.started.len() >= STARTED_MAX {
            let table = table();
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
        let own = getpid().as_raw();
        for _ in 0..ROUNDS_MAX {
            let table = table();
            let all = ALL_CHILDREN.load(Ordering::Relaxed);
            let members = members(&table, own, &self.started, all);
            for number in &members {
                // It may have ended meanwhile, which is as good.
                let _ = kill(Pid::from_raw(*number), Signal::SIGKILL);
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

/// Those who live and belong to the processes `started` by a task of process `own`; with `all`, every descendant does.
fn members(table: &Table, own: i32, started: &BTreeSet<i32>, all: bool) -> Vec<i32> {
    let is_member = |number: i32, entry: &Entry| {
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
        !entry.ended && (belongs || all)
    };
    let found = table.iter().filter(|(n, entry)| is_member(**n, entry));
    found.map(|(number, _)| *number).collect()
}

/// Asks orphans that have ended how they ended, so that their numbers are free again. Who was started here is asked by
/// whoever started it.
fn reap(table: &Table, started: &BTreeSet<i32>) {
    if !ALL_CHILDREN.load(Ordering::Relaxed) {
        return;
    }
    let own = getpid().as_raw();
    for (number, entry) in table {
        if entry.parent == own && entry.ended && !started.contains(number) {
            let _ = waitpid(Pid::from_raw(*number), Some(WaitPidFlag::WNOHANG));
        }
    }
}

/// The part of the system's table that descends from this process; those that end while it is read may be missing.
fn table() -> Table {
    let mut found = Table::new();
    let mut open = vec![getpid().as_raw()];
    while let Some(number) = open.pop() {
        let Some(children) = children(number) else {
            // It has just ended, or this system does not tell children: then everybody is looked at.
            match number == getpid().as_raw() {
                true => return whole_table(),
                false => continue,
            }
        };
        for child in children {
            if let Some(entry) = entry(child)
                && found.insert(child, entry).is_none()
            {
                open.push(child);
            }
        }
    }
    found
}

/// The children of all threads of a process.
fn children(number: i32) -> Option<Vec<i32>> {
    let mut found = Vec::new();
    for thread in std::fs::read_dir(format!("/proc/{number}/task")).ok()? {
        let text = std::fs::read_to_string(thread.ok()?.path().join("children"));
        match text {
            Ok(text) => found.extend(
                text.split_ascii_whitespace()
                    .filter_map(|n| n.parse::<i32>().ok()),
            ),
            // A thread that has just ended has left its children to another one.
            Err(_) if std::path::Path::new("/proc/thread-self/children").exists() => {}
            Err(_) => return None,
        }
    }
    Some(found)
}

fn whole_table() -> Table {
    let Ok(folder) = std::fs::read_dir("/proc") else {
        return Table::new();
    };
    folder
        .flatten()
        .filter_map(|found| {
            let number = found.file_name().to_str()?.parse().ok()?;
            Some((number, entry(number)?))
        })
        .collect()
}

fn entry(number: i32) -> Option<Entry> {
    // As bytes: a process may have any name.
    parse(&std::fs::read(format!("/proc/{number}/stat")).ok()?)
}

/// `4711 (any ) name) S PARENT GROUP SESSION …` (proc_pid_stat(5)).
fn parse(stat: &[u8]) -> Option<Entry> {
    let behind_the_name = stat.iter().rposition(|c| *c == b')')? + 1;
    let rest = std::str::from_utf8(&stat[behind_the_name..]).ok()?;
    let mut words = rest.split_ascii_whitespace();
    let state = words.next()?;
    let mut number = || words.next()?.parse().ok();
    Some(Entry {
        parent: number()?,
        group: number()?,
        session: number()?,
        ended: matches!(state, "Z" | "X"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(parent: i32, group: i32, session: i32) -> Entry {
        Entry {
            parent,
            group,
            session,
            ended: false,
        }
    }

    #[test]
    fn the_line_of_a_process_is_read_whatever_its_name() {
        let stat = b"4711 (a) S 1 \xff) R 10 20 30 0 -1";
        assert_eq!(parse(stat), Some(entry(10, 20, 30)));
        let ended = parse(b"1 (x) Z 2 3 4 5");
        assert_eq!(ended.map(|entry| entry.ended), Some(true));
        for wrong in [&b""[..], b"4711", b"1 (x) S", b"1 (x) S a b c"] {
            assert_eq!(parse(wrong), None);
        }
    }

    #[test]
    fn who_descends_from_the_task_belongs_to_it_and_nobody_else() {
        let own = 100;
        let table = Table::from([
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
        assert_eq!(
            members(&table, own, &started, false),
            [200, 201, 202, 301, 302]
        );
        assert_eq!(
            members(&table, own, &started, true),
            [200, 201, 202, 301, 302, 303, 400]
        );
        let mut gone = table;
        gone.get_mut(&301).unwrap().ended = true;
        assert!(!members(&gone, own, &started, true).contains(&301));
    }
}
