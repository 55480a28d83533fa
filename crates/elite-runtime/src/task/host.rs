//! What the language asks of its surroundings: output, clock and random numbers, all of them the task's.

use std::cell::{Cell, RefCell};
use std::ffi::OsString;
use std::io;
use std::rc::Rc;

use elite_lang::{
    Capability, CleanupLimit, Host, HostFiles, HostProcesses, HostSocket, ScriptThread, ThreadId,
};
use kinematics::random::RandomSequence;
use messages::{Text, text};
use motion_api::ThreadNumber;

use super::context::TaskContext;
use super::files::Files;
use super::network::Sockets;
use super::processes::Processes;
use super::sandbox::SandboxRoots;
use crate::external::ExternalInputKind;
use crate::message::{CutShort, Message};

/// What programs may reach beyond the robot (`--allow`).
#[derive(Clone, Debug)]
pub struct Permissions {
    /// Files and folders.
    pub files: FileAccess,
    /// Starting processes, and signals.
    pub processes: bool,
    /// Environment variables.
    pub environment: bool,
    /// The network.
    pub network: NetworkAccess,
}

/// The machines that programs may reach.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NetworkAccess {
    /// No machine.
    Nothing,
    /// Machines that somebody in this process stands in for; no other, in either direction.
    SimulatedOnly,
    /// Every machine, and every machine may reach programs.
    Everything,
}

/// The files that programs may reach.
#[derive(Clone, Debug)]
pub enum FileAccess {
    /// No file.
    Nothing,
    /// Files beneath some folders.
    Sandboxed(SandboxRoots),
    /// Every file that the controller itself may reach.
    Everything,
}

impl Default for Permissions {
    /// The network only.
    fn default() -> Self {
        Self {
            files: FileAccess::Nothing,
            processes: false,
            environment: false,
            network: NetworkAccess::Everything,
        }
    }
}

/// The surroundings of one task.
pub(crate) struct TaskHost {
    context: Rc<TaskContext>,
    random: Cell<RandomSequence>,
    permissions: Permissions,
    sockets: Rc<Sockets>,
    files: Rc<Files>,
    processes: Processes,
    woken: RefCell<Vec<ThreadId>>,
    started: RefCell<Vec<(ThreadNumber, ScriptThread)>>,
}

impl TaskHost {
    /// Random numbers follow from `seed`.
    pub fn new(context: Rc<TaskContext>, seed: u64, permissions: Permissions) -> Self {
        let within = match &permissions.files {
            FileAccess::Sandboxed(folders) => Some(folders.clone()),
            FileAccess::Nothing | FileAccess::Everything => None,
        };
        let sockets = Rc::new(Sockets::new(context.clone()));
        let files = Rc::new(Files::new(within, context.task_folder().root()));
        Self {
            context,
            random: Cell::new(RandomSequence::new(seed)),
            permissions,
            processes: Processes::new(files.clone(), sockets.outside().clone()),
            sockets,
            files,
            woken: RefCell::default(),
            started: RefCell::default(),
        }
    }

    /// Threads that the program has started through the language since the last call, with their numbers.
    pub fn take_started(&self) -> Vec<(ThreadNumber, ScriptThread)> {
        self.started.take()
    }

    /// Threads that became ready since the last call, in the order in which they did.
    pub fn take_woken(&self) -> Vec<ThreadId> {
        self.woken.take()
    }

    /// Threads that waited for the outside world and became ready since the last call, in the order in which they did.
    pub fn take_woken_outside(&self) -> Vec<ThreadId> {
        self.sockets.outside().take_woken()
    }

    /// The end of the task: sockets are closed, processes killed.
    pub fn close(&self) {
        self.sockets.close_all();
        self.processes.kill_all();
    }

    /// The program looks at something that is not noted.
    fn note_unrecorded(&self, what: &Text) {
        if self.context.witness().is_some() && self.context.is_first_warning(what.english()) {
            self.context.note(ExternalInputKind::Unrecorded(text!(
                "it used {what}",
                "它使用了{what}"
            )));
        }
    }

    /// The sockets of the task.
    pub fn sockets(&self) -> &Sockets {
        &self.sockets
    }
}

impl Host for TaskHost {
    fn print(&self, _thread: ThreadId, text: &str) {
        let origin = self.context.origin(0);
        let text = text.to_owned();
        self.context
            .observer()
            .message(&Message::Print { origin, text });
    }

    fn unwinding_goes_on(&self) -> bool {
        self.context.may_clean_up()
    }

    fn unwinding_is_cut(&self, _thread: ThreadId, line: u32, cut: CleanupLimit) {
        let cut = match cut {
            CleanupLimit::Time => CutShort::Time,
            CleanupLimit::Wait if self.context.has_called_enough() => CutShort::Calls,
            CleanupLimit::Wait => CutShort::Wait,
        };
        let message = Message::clean_up_is_cut(self.context.origin(line), cut);
        self.context.observer().message(&message);
    }

    fn start(&self, thread: ScriptThread) -> Result<(), String> {
        let number = self
            .context
            .take_number()
            .map_err(|refused| refused.to_string())?;
        self.started.borrow_mut().push((number, thread));
        Ok(())
    }

    fn may_wait(&self) -> Result<(), String> {
        if self.context.is_secondary() {
            return Err("a secondary program may not wait".to_owned());
        }
        Ok(())
    }

    fn wake(&self, thread: ThreadId) {
        self.woken.borrow_mut().push(thread);
    }

    fn permits(&self, access: Capability) -> bool {
        match access {
            Capability::Files => !matches!(self.permissions.files, FileAccess::Nothing),
            Capability::Processes => self.permissions.processes,
            Capability::Environment => self.permissions.environment,
            Capability::Network => self.permissions.network != NetworkAccess::Nothing,
        }
    }

    fn environment(&self) -> Vec<(String, String)> {
        self.note_unrecorded(&text!("environment variables", "环境变量"));
        let entries = std::env::vars_os();
        let text = |(name, value): (OsString, OsString)| {
            Some((name.into_string().ok()?, value.into_string().ok()?))
        };
        entries.filter_map(text).collect()
    }

    fn files(&self) -> Option<&dyn HostFiles> {
        self.note_unrecorded(&text!("files", "文件"));
        Some(&*self.files)
    }

    fn processes(&self) -> Option<&dyn HostProcesses> {
        self.note_unrecorded(&text!("other processes", "其他进程"));
        Some(&self.processes)
    }

    fn open_socket(&self) -> io::Result<Rc<dyn HostSocket>> {
        self.note_unrecorded(&text!(
            "sockets of the module socket",
            "socket 模块的套接字"
        ));
        self.sockets.open()
    }

    fn unix_time(&self) -> f64 {
        self.context.unix_time()
    }

    fn monotonic(&self) -> f64 {
        self.context.robot().moment().time
    }

    fn random_u64(&self) -> u64 {
        let mut random = self.random.get();
        let bits = random.bits();
        self.random.set(random);
        bits
    }
}
