//! Where debuggers attach to a controller that serves: one drives, others look on, and programs run on without them.
//!
//! Owns who is there, what the driver wants the programs to be held for, and which program is held. A program that
//! begins while somebody is there is watched; one that begins while nobody is costs what it always did, unless all are
//! to be watched. Nothing here waits: a client that does not take what it is told is let go.

use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use elite_runtime::debug::{DebuggedTask, DebuggerHost, TaskDebugger};
use messages::{Text, text};
use motion_api::ProgramId;
use parking_lot::{Condvar, Mutex, MutexGuard};
use serde_json::{Value as Json, json};

use super::breakpoints::Breakpoints;
use super::probe::Probe;
use super::run_channel::{
    Purpose, ResumeMode, RunChannel, RunCommand, RunEvent, SessionEvent, SuspendReason,
};
use super::run_position::Position;

/// Most clients at once.
const CLIENTS_MAX: usize = 8;
/// A program that begins waits so long for its driver to say where it is to be held.
const READY_WITHIN: Duration = Duration::from_secs(1);
/// Orders that may wait for the program.
const ORDERS_MAX: usize = 256;

/// The debuggers of one controller: clients that are there, what the driver wants programs to be held for, and the
/// program that is held.
#[derive(Default)]
pub struct DebugHub {
    state: Mutex<HubState>,
    /// A driver is ready for the program that begins.
    readied: Condvar,
    changes: AtomicU64,
    /// Programs are watched whether somebody is there or not.
    watches_every_program: bool,
}

#[derive(Default)]
struct HubState {
    clients: BTreeMap<u32, Client>,
    last_client: u32,
    generation: u64,
    /// Of the latest program for which the driver has said where it is to be held.
    ready: u64,
    breakpoints: Arc<Breakpoints>,
    current: Option<CurrentProgram>,
}

struct Client {
    notes: SyncSender<SessionEvent>,
    drives: bool,
}

struct CurrentProgram {
    program: ProgramId,
    name: Arc<str>,
    text: Arc<str>,
    watched: Option<ProgramLink>,
    held: Option<SuspendedProgram>,
}

/// The two ends towards a program that is watched.
#[derive(Clone)]
pub(crate) struct ProgramLink {
    pub link: Arc<RunChannel>,
    pub orders: SyncSender<RunCommand>,
}

/// Place where a program is held.
#[derive(Clone, Debug)]
pub(crate) struct SuspendedProgram {
    pub thread: u32,
    pub threads: Vec<u32>,
    pub why: SuspendReason,
    pub position: Position,
    line: u32,
    column: u32,
}

/// A program that runs, for a client.
#[derive(Clone)]
pub(crate) struct ProgramStarted {
    pub generation: u64,
    pub name: Arc<str>,
    pub text: Arc<str>,
    pub watched: Option<ProgramLink>,
    pub held: Option<SuspendedProgram>,
}

/// The hub as programs find it.
#[derive(Clone)]
pub struct HubDebugger(pub Arc<DebugHub>);

impl DebugHub {
    /// One whose programs are all watched from their start: a client may attach to one that has begun.
    pub fn of_every_program() -> Self {
        Self {
            watches_every_program: true,
            ..Self::default()
        }
    }

    /// Counts what is shown of it ([`shown`](Self::shown)).
    pub fn changes(&self) -> u64 {
        self.changes.load(Ordering::Acquire)
    }

    /// What a page shows: who debugs, where the program is held, breakpoints.
    pub fn shown(&self) -> Json {
        let state = self.state.lock();
        let drives = state.clients.values().any(|client| client.drives);
        let current = state.current.as_ref();
        let held = current.and_then(|current| current.held.as_ref());
        let mut places: Vec<_> = state.breakpoints.places.iter().collect();
        places.sort_by_key(|(place, _)| **place);
        let breakpoints: Vec<Json> = places
            .into_iter()
            .flat_map(|((line, column), all)| {
                all.iter().map(move |at| {
                    json!({
                        "line": line,
                        "column": column,
                        "condition": at.condition,
                        "hits": at.hits.map(|hits| hits.to_string()),
                        "message": at.message,
                    })
                })
            })
            .collect();
        json!({
            "driver": drives,
            "watchers": state.clients.len() - usize::from(drives),
            "watched": current.is_some_and(|current| current.watched.is_some()),
            "program": current.map(|current| &*current.name),
            "held": held.map(|held| json!({
                "reason": held.why.reason,
                "thread": held.thread,
                "line": held.line,
                "column": held.column,
            })),
            "breakpoints": breakpoints,
        })
    }

    fn bump_changes(&self) {
        self.changes.fetch_add(1, Ordering::AcqRel);
    }

    /// A client attaches; its number, and the program that runs.
    pub(crate) fn join(
        &self,
        notes: SyncSender<SessionEvent>,
        drives: bool,
    ) -> Result<(u32, Option<ProgramStarted>), Text> {
        let mut state = self.state.lock();
        if state.clients.len() >= CLIENTS_MAX {
            return Err(text!(
                "{CLIENTS_MAX} debuggers are attached already, more are not allowed",
                "已连接 {CLIENTS_MAX} 个调试器，不能再多"
            ));
        }
        if drives && state.clients.values().any(|client| client.drives) {
            return Err(text!(
                "another debugger drives already; with \"drive\": false this one looks on",
                "已有另一个调试器在控制；以 \"drive\": false 连接可旁观"
            ));
        }
        state.last_client += 1;
        let number = state.last_client;
        state.clients.insert(number, Client { notes, drives });
        if let Some(watched) = state.watched() {
            watched.link.is_over.store(false, Ordering::Release);
            if drives {
                watched.link.is_driven.store(true, Ordering::Release);
            }
        }
        let begun = state.begun();
        drop(state);
        self.bump_changes();
        Ok((number, begun))
    }

    /// A client leaves; where it has driven nothing is held any more.
    pub(crate) fn leave(&self, number: u32) {
        let mut state = self.state.lock();
        let Some(client) = state.clients.remove(&number) else {
            return;
        };
        let is_last = state.clients.is_empty();
        if client.drives {
            state.breakpoints = Arc::default();
            if let Some(current) = &mut state.current {
                current.held = None;
            }
        }
        if let Some(watched) = state.watched() {
            let link = &watched.link;
            if client.drives {
                *link.breakpoints.lock() = Arc::default();
                link.changes.fetch_add(1, Ordering::AcqRel);
                link.is_driven.store(false, Ordering::Release);
                let note = SessionEvent::Run(state.generation, Box::new(RunEvent::Continued));
                state.notify_others(number, &note);
            }
            if is_last {
                link.is_over.store(true, Ordering::Release);
            }
        }
        drop(state);
        self.bump_changes();
    }

    /// What the driver wants programs to be held for.
    pub(crate) fn set_breakpoints(&self, breakpoints: Arc<Breakpoints>) {
        let mut state = self.state.lock();
        state.breakpoints = breakpoints.clone();
        if let Some(watched) = state.watched() {
            *watched.link.breakpoints.lock() = breakpoints;
            watched.link.changes.fetch_add(1, Ordering::AcqRel);
        }
        drop(state);
        self.bump_changes();
    }

    /// The driver has said where the program of this number is to be held.
    pub(crate) fn mark_ready(&self, generation: u64) {
        self.state.lock().ready = generation;
        self.readied.notify_all();
    }

    /// The driver lets a held program go on.
    pub(crate) fn go(&self, number: u32, go: ResumeMode) -> Result<(), Text> {
        let mut state = self.state.lock();
        let watched = state
            .watched()
            .ok_or(text!("no program is held", "没有停住的程序"))?;
        let current = state
            .current
            .as_mut()
            .filter(|current| current.held.is_some());
        let current = current.ok_or(text!("the program is running", "程序正在运行"))?;
        watched
            .orders
            .try_send(RunCommand::Go(go))
            .map_err(|_| text!("the program takes no orders just now", "程序此刻不接受命令"))?;
        current.held = None;
        let note = SessionEvent::Run(state.generation, Box::new(RunEvent::Continued));
        state.notify_others(number, &note);
        drop(state);
        self.bump_changes();
        Ok(())
    }

    /// Passes on what a program tells.
    fn forward_event(&self, note: &SessionEvent) {
        let mut state = self.state.lock();
        let SessionEvent::Run(generation, event) = note else {
            return;
        };
        if *generation != state.generation {
            return;
        }
        match &**event {
            RunEvent::Answer { request, .. } => {
                let number = u32::try_from(request.0 >> 32).unwrap_or(0);
                state.tell_one(number, note);
                return;
            }
            RunEvent::Stopped {
                thread,
                threads,
                why,
                position,
                ..
            } => {
                if let Some(current) = &mut state.current {
                    let place = current.watched.as_ref().map(|watched| {
                        let link = &watched.link;
                        let line = link.line.load(Ordering::Relaxed);
                        (line, link.column.load(Ordering::Relaxed))
                    });
                    let (line, column) = place.unwrap_or_default();
                    current.held = Some(SuspendedProgram {
                        thread: *thread,
                        threads: threads.clone(),
                        why: why.clone(),
                        position: *position,
                        line,
                        column,
                    });
                }
            }
            _ => {}
        }
        state.notify_others(0, note);
        drop(state);
        self.bump_changes();
    }
}

impl HubState {
    fn watched(&self) -> Option<ProgramLink> {
        self.current.as_ref()?.watched.clone()
    }

    fn begun(&self) -> Option<ProgramStarted> {
        let current = self.current.as_ref()?;
        Some(ProgramStarted {
            generation: self.generation,
            name: current.name.clone(),
            text: current.text.clone(),
            watched: current.watched.clone(),
            held: current.held.clone(),
        })
    }

    /// Tells everybody but one.
    fn notify_others(&mut self, but: u32, note: &SessionEvent) {
        let others: Vec<u32> = self.clients.keys().copied().filter(|n| *n != but).collect();
        for number in others {
            self.tell_one(number, note);
        }
    }

    fn tell_one(&mut self, number: u32, note: &SessionEvent) {
        let Some(client) = self.clients.get(&number) else {
            return;
        };
        match client.notes.try_send(note.clone()) {
            Ok(()) => {}
            // A client that does not take its events loses them; its session ends when it goes.
            Err(TrySendError::Full(_)) => {
                tracing::warn!("a debugger is too slow and misses events")
            }
            Err(TrySendError::Disconnected(_)) => {}
        }
    }
}

impl DebuggerHost for HubDebugger {
    fn begins(&self, program: ProgramId, name: &str, text: &str) {
        let mut state = self.0.state.lock();
        state.current = Some(CurrentProgram {
            program,
            name: name.into(),
            text: text.into(),
            watched: None,
            held: None,
        });
        drop(state);
        self.0.bump_changes();
    }

    fn attach(&self, task: DebuggedTask) -> Option<Rc<dyn TaskDebugger>> {
        let hub = self.0.clone();
        let mut state: MutexGuard<'_, HubState> = self.0.state.lock();
        let nobody = state.clients.is_empty();
        if nobody && !self.0.watches_every_program {
            return None;
        }
        state.generation += 1;
        let (orders, receiver) = sync_channel(ORDERS_MAX);
        let link = Arc::new(RunChannel {
            generation: state.generation,
            program: Some(task.program()),
            is_attached: true,
            is_driven: AtomicBool::new(state.clients.values().any(|client| client.drives)),
            purpose: Purpose::Run {
                stop_on_entry: false,
            },
            interventions: Vec::new(),
            stop_at_end: false,
            breakpoints: state.breakpoints.clone().into(),
            changes: AtomicU64::new(0),
            pause: AtomicBool::new(false),
            is_over: AtomicBool::new(nobody),
            is_stopping: AtomicBool::new(false),
            is_muted: AtomicBool::new(false),
            said: AtomicU64::new(0),
            seen: AtomicU64::new(0),
            line: AtomicU32::new(0),
            column: AtomicU32::new(0),
            world: OnceLock::new(),
            events: Box::new(move |note| {
                hub.forward_event(&note);
                true
            }),
            orders: Some(receiver).into(),
        });
        if let Some(current) = &mut state.current {
            current.watched = Some(ProgramLink {
                link: link.clone(),
                orders,
            });
        }
        let begun = state.begun();
        state.notify_others(0, &SessionEvent::Begun(begun.map(Box::new)));
        // Breakpoints have their places before the first statement; a driver that is slow misses some.
        let waits = |state: &mut HubState| {
            let has_driver = state.clients.values().any(|client| client.drives);
            has_driver && state.ready < state.generation
        };
        self.0
            .readied
            .wait_while_for(&mut state, waits, READY_WITHIN);
        drop(state);
        self.0.bump_changes();
        Some(Rc::new(Probe::new(link, task)))
    }

    fn ended(&self, program: ProgramId) {
        let mut state = self.0.state.lock();
        if state
            .current
            .as_ref()
            .is_none_or(|current| current.program != program)
        {
            return;
        }
        state.current = None;
        state.notify_others(0, &SessionEvent::Begun(None));
        drop(state);
        self.0.bump_changes();
    }
}
