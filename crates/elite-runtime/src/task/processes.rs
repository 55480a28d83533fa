//! Processes for programs that were granted them (`--allow process`), on the task's own tokio runtime.
//!
//! A process has a group of its own. At the end of the task it is killed together with what it has started
//! ([`ProcessTree`]). Futures move the bytes of its pipes through buffers of fixed size; no operation of a script
//! waits, a thread that has to is parked and woken at the next news.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::io;
use std::process::Stdio;
use std::rc::Rc;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use elite_lang::{HostCommand, HostProcess, HostProcesses, ProcessOutput, ProcessStream, ThreadId};
use platform::processes::{self, SignalTarget};
use supervision::{ThreadRole, ThreadSupervisor};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWriteExt};
use tokio::process::{Child, ChildStdin, Command};
use tokio::sync::Notify;
use tokio::task::AbortHandle;

use super::files::Files;
use super::network::IoWaiters;
use super::process_tree::ProcessTree;

/// Most processes of a task that run at once.
const PROCESSES_MAX: usize = 32;
/// Bytes of one pipe that are kept for the program, or for the process.
const PIPE_BYTES: usize = 1 << 18;

/// The processes of one task.
pub(crate) struct Processes {
    files: Rc<Files>,
    outside: Arc<IoWaiters>,
    /// Held until the end of the task: a program may drop a process that goes on.
    all: RefCell<Vec<Rc<ChildProcess>>>,
    family: RefCell<ProcessTree>,
}

impl Processes {
    /// Relative folders count from that of the task; who waits is noted in `outside`.
    pub fn new(files: Rc<Files>, outside: Arc<IoWaiters>) -> Self {
        Self {
            files,
            outside,
            all: RefCell::default(),
            family: RefCell::default(),
        }
    }

    /// The end of the task: what still runs is killed, whoever of the task's processes has started it.
    pub fn kill_all(&self) {
        for process in self.all.take() {
            process.end();
        }
        self.family.borrow_mut().end();
    }
}

impl Drop for Processes {
    /// Kills the processes when the task ends by a panic, too.
    fn drop(&mut self) {
        self.kill_all();
    }
}

impl HostProcesses for Processes {
    fn spawn(&self, command: HostCommand) -> io::Result<Rc<dyn HostProcess>> {
        let mut all = self.all.borrow_mut();
        all.retain(|process| process.exit_status().is_none());
        if all.len() >= PROCESSES_MAX {
            let text = format!("{PROCESSES_MAX} processes run already, more are not allowed");
            return Err(io::Error::other(text));
        }
        let mut family = self.family.borrow_mut();
        family.prepare();
        let process = start(command, &self.files, &self.outside)?;
        family.add(process.number);
        all.push(process.clone());
        Ok(process)
    }

    fn signal(&self, process: i32, signal: i32) -> io::Result<()> {
        processes::send_signal(SignalTarget::Process(process), signal)
    }

    fn signal_group(&self, group: i32, signal: i32) -> io::Result<()> {
        processes::send_signal(SignalTarget::Group(group), signal)
    }

    fn identity(&self) -> [u32; 6] {
        let own = processes::identity();
        let ([user, effective_user], [group, effective_group]) = (own.users, own.groups);
        [
            own.process,
            own.parent,
            user,
            effective_user,
            group,
            effective_group,
        ]
    }
}

fn start(
    command: HostCommand,
    files: &Files,
    outside: &Arc<IoWaiters>,
) -> io::Result<Rc<ChildProcess>> {
    let Some((program, arguments)) = command.words.split_first() else {
        return Err(io::ErrorKind::InvalidInput.into());
    };
    // A path with a folder counts from where the task is, a bare name is looked for along PATH.
    let program = match program.contains('/') {
        true => files.full(program).into_os_string(),
        false => program.into(),
    };
    let mut system = Command::new(program);
    system
        .args(arguments)
        .current_dir(files.start_folder(command.folder.as_deref().unwrap_or(""))?)
        .kill_on_drop(true);
    // The thread that starts it is that of the task. What it has started itself is found at the end of the task, and
    // outlives a `kill -9` of the controller.
    processes::kill_with_parent(system.as_std_mut())?;
    if let Some(environment) = command.environment {
        system.env_clear().envs(environment);
    }
    // Nothing to read is what a controller has for a process that wants input.
    system.stdin(match command.input {
        ProcessStream::Inherit => Stdio::null(),
        other => stdio(other)?,
    });
    match (command.output, command.errors) {
        (ProcessStream::File(file), ProcessStream::WithOutput) => {
            system.stderr(file.try_clone()?).stdout(file);
        }
        (ProcessStream::Pipe, ProcessStream::WithOutput) => {
            let (reader, writer) = io::pipe()?;
            system.stdout(writer.try_clone()?).stderr(writer);
            return finish(system, Some(reader), outside);
        }
        (ProcessStream::Null, ProcessStream::WithOutput) => {
            system.stdout(Stdio::null()).stderr(Stdio::null());
        }
        (output, ProcessStream::WithOutput) => {
            system
                .stdout(stdio(output)?)
                .stderr(processes::clone_stdout()?);
        }
        (output, errors) => {
            system.stdout(stdio(output)?).stderr(stdio(errors)?);
        }
    }
    finish(system, None, outside)
}

fn stdio(stream: ProcessStream) -> io::Result<Stdio> {
    Ok(match stream {
        ProcessStream::Inherit | ProcessStream::WithOutput => Stdio::inherit(),
        ProcessStream::Null => Stdio::null(),
        ProcessStream::Pipe => Stdio::piped(),
        ProcessStream::File(file) => file.into(),
    })
}

/// Starts it and the futures that look after it. `joined` is read as its output if it has one pipe for both.
fn finish(
    mut system: Command,
    joined: Option<io::PipeReader>,
    outside: &Arc<IoWaiters>,
) -> io::Result<Rc<ChildProcess>> {
    let mut child = system.spawn()?;
    // The writing ends that belong to the child must not stay open here.
    drop(system);
    let number = child
        .id()
        .and_then(|id| i32::try_from(id).ok())
        .unwrap_or(-1);
    let shared = Arc::new(ProcessPipes {
        state: Mutex::default(),
        room: Notify::new(),
        input: Notify::new(),
        outside: outside.clone(),
    });
    let mut futures = Vec::new();
    let mut run = |future: std::pin::Pin<Box<dyn Future<Output = ()> + Send>>| {
        let task = ThreadSupervisor::default().spawn(ThreadRole::Task, "process", future);
        futures.push(task.abort_handle());
    };
    {
        let mut state = shared.lock();
        state.pipes[0].open = joined.is_some() || child.stdout.is_some();
        state.pipes[1].open = child.stderr.is_some();
        state.takes_input = child.stdin.is_some();
    }
    if let Some(reader) = joined {
        let reader = processes::async_pipe(reader)?;
        run(Box::pin(drain(reader, shared.clone(), 0)));
    } else if let Some(output) = child.stdout.take() {
        run(Box::pin(drain(output, shared.clone(), 0)));
    }
    if let Some(errors) = child.stderr.take() {
        run(Box::pin(drain(errors, shared.clone(), 1)));
    }
    if let Some(input) = child.stdin.take() {
        run(Box::pin(feed(input, shared.clone())));
    }
    run(Box::pin(reap(child, shared.clone())));
    Ok(Rc::new(ChildProcess {
        number,
        shared,
        futures,
    }))
}

/// What the futures of a process and its program share.
#[derive(Debug)]
struct ProcessPipes {
    state: Mutex<ChildState>,
    /// The program has taken output.
    room: Notify,
    /// The program has given input, or there will be no more.
    input: Notify,
    outside: Arc<IoWaiters>,
}

#[derive(Debug, Default)]
struct ChildState {
    /// Output and errors.
    pipes: [Pipe; 2],
    input: VecDeque<u8>,
    takes_input: bool,
    input_ends: bool,
    ended: Option<i32>,
    news: u64,
    waiters: Vec<ThreadId>,
}

#[derive(Debug, Default)]
struct Pipe {
    data: VecDeque<u8>,
    open: bool,
}

impl ProcessPipes {
    fn lock(&self) -> MutexGuard<'_, ChildState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes the state and wakes who waits for that.
    fn update_and_wake(&self, change: impl FnOnce(&mut ChildState)) {
        let waiters = {
            let mut state = self.lock();
            change(&mut state);
            state.news += 1;
            std::mem::take(&mut state.waiters)
        };
        for thread in waiters {
            self.outside.wake(thread);
        }
    }
}

/// Moves what a process writes into the buffer, as long as there is room.
async fn drain(mut pipe: impl AsyncRead + Unpin, shared: Arc<ProcessPipes>, which: usize) {
    let mut buffer = vec![0; 1 << 16];
    loop {
        let room = PIPE_BYTES.saturating_sub(shared.lock().pipes[which].data.len());
        if room == 0 {
            shared.room.notified().await;
            continue;
        }
        let most = room.min(buffer.len());
        match pipe.read(&mut buffer[..most]).await {
            Ok(0) | Err(_) => {
                return shared.update_and_wake(|state| state.pipes[which].open = false);
            }
            Ok(count) => {
                shared.update_and_wake(|state| state.pipes[which].data.extend(&buffer[..count]))
            }
        }
    }
}

/// Moves what the program has written to the process.
async fn feed(mut pipe: ChildStdin, shared: Arc<ProcessPipes>) {
    loop {
        let (piece, ends) = {
            let mut state = shared.lock();
            let count = state.input.len().min(1 << 16);
            let piece: Vec<u8> = state.input.drain(..count).collect();
            (piece, state.input_ends)
        };
        if piece.is_empty() {
            if ends {
                return;
            }
            shared.input.notified().await;
        } else if pipe.write_all(&piece).await.is_err() {
            return shared.update_and_wake(|state| state.takes_input = false);
        } else {
            shared.update_and_wake(|_| {});
        }
    }
}

async fn reap(mut child: Child, shared: Arc<ProcessPipes>) {
    let code = child.wait().await.map_or(-1, processes::exit_code);
    shared.update_and_wake(|state| state.ended = Some(code));
}

/// One process of a task.
#[derive(Debug)]
struct ChildProcess {
    number: i32,
    shared: Arc<ProcessPipes>,
    futures: Vec<AbortHandle>,
}

impl ChildProcess {
    /// Kills the process and its group; the futures end with what they hold.
    fn end(&self) {
        if self.exit_status().is_none() {
            processes::kill(SignalTarget::Group(self.number));
        }
        for future in &self.futures {
            future.abort();
        }
    }
}

impl HostProcess for ChildProcess {
    fn number(&self) -> i32 {
        self.number
    }

    fn exit_status(&self) -> Option<i32> {
        self.shared.lock().ended
    }

    fn signal(&self, signal: i32) -> io::Result<()> {
        match self.exit_status() {
            Some(_) => Ok(()),
            None => processes::send_signal(SignalTarget::Process(self.number), signal),
        }
    }

    fn read(&self, stream: ProcessOutput, most: usize) -> io::Result<Vec<u8>> {
        let mut state = self.shared.lock();
        let pipe = match stream {
            ProcessOutput::Output => &mut state.pipes[0],
            ProcessOutput::Errors => &mut state.pipes[1],
        };
        if pipe.data.is_empty() && pipe.open {
            return Err(io::ErrorKind::WouldBlock.into());
        }
        let count = pipe.data.len().min(most);
        let data = pipe.data.drain(..count).collect();
        // Both readers look again.
        self.shared.room.notify_waiters();
        self.shared.room.notify_one();
        Ok(data)
    }

    fn write(&self, data: &[u8]) -> io::Result<usize> {
        let mut state = self.shared.lock();
        if !state.takes_input || state.input_ends {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        let room = PIPE_BYTES.saturating_sub(state.input.len());
        if room == 0 {
            return Err(io::ErrorKind::WouldBlock.into());
        }
        let count = data.len().min(room);
        state.input.extend(&data[..count]);
        self.shared.input.notify_one();
        Ok(count)
    }

    fn close_input(&self) {
        self.shared.lock().input_ends = true;
        self.shared.input.notify_one();
    }

    fn news(&self) -> u64 {
        self.shared.lock().news
    }

    fn watch(&self, thread: ThreadId) {
        self.shared.outside.wait(thread);
        let mut state = self.shared.lock();
        if !state.waiters.contains(&thread) {
            state.waiters.push(thread);
        }
    }
}
