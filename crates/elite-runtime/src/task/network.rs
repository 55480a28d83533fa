//! TCP sockets for programs (`import socket`), on the task's own tokio runtime.
//!
//! No operation waits. A thread that has to is parked by the language; a small future per wait wakes it when the socket
//! is ready. The scheduler asks [`IoWaiters`] who waits for the outside world: meanwhile simulated time keeps wall
//! pace.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::io;
use std::net::{IpAddr, Ipv4Addr, Shutdown, SocketAddr};
use std::rc::{Rc, Weak};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use elite_lang::{HostSocket, Interest, ThreadId};
use io_bus::{PeerStream, names};
use supervision::{CatchPanic, CaughtPanic, ThreadRole, ThreadSupervisor};
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::sync::Notify;
use tokio::task::AbortHandle;

use super::context::TaskContext;
use super::host::NetworkAccess;

/// Most sockets a task may have open.
const SOCKETS_MAX: usize = 32;

/// Threads that wait for the outside world, and those it has woken. Shared with the futures of the waits.
#[derive(Debug, Default)]
pub(crate) struct IoWaiters {
    threads: Mutex<WaiterLists>,
    notify: Notify,
}

#[derive(Debug, Default)]
struct WaiterLists {
    waiting: BTreeSet<ThreadId>,
    woken: Vec<ThreadId>,
}

impl IoWaiters {
    fn threads(&self) -> MutexGuard<'_, WaiterLists> {
        self.threads.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The thread waits for the outside world.
    pub fn wait(&self, thread: ThreadId) {
        self.threads().waiting.insert(thread);
    }

    /// What the thread waits for has come. Others may wake it, too: only the first counts.
    pub fn wake(&self, thread: ThreadId) {
        let mut threads = self.threads();
        if threads.waiting.remove(&thread) {
            threads.woken.push(thread);
            self.notify.notify_one();
        }
    }

    /// Threads woken since the last call.
    pub fn take_woken(&self) -> Vec<ThreadId> {
        std::mem::take(&mut self.threads().woken)
    }

    /// The thread goes on, for whatever reason: it no longer waits.
    pub fn forget(&self, thread: ThreadId) {
        self.threads().waiting.remove(&thread);
    }

    /// Whether any thread waits for the outside world.
    pub fn is_awaited(&self) -> bool {
        !self.threads().waiting.is_empty()
    }

    /// Returns once a thread has been woken.
    pub async fn woken(&self) {
        self.notify.notified().await;
    }
}

/// The sockets of one task.
pub(crate) struct Sockets {
    context: Rc<TaskContext>,
    outside: Arc<IoWaiters>,
    open: RefCell<Vec<Weak<TaskSocket>>>,
}

impl Sockets {
    /// None yet.
    pub fn new(context: Rc<TaskContext>) -> Self {
        Self {
            context,
            outside: Arc::default(),
            open: RefCell::default(),
        }
    }

    /// Who waits for them.
    pub fn outside(&self) -> &Arc<IoWaiters> {
        &self.outside
    }

    /// A new socket.
    pub fn open(self: &Rc<Self>) -> io::Result<Rc<dyn HostSocket>> {
        Ok(self.enter(SocketState::New(TcpSocket::new_v4()?))?)
    }

    /// Whether other machines may reach the program.
    fn check_open_to_others(&self) -> io::Result<()> {
        match self.context.permissions().network {
            NetworkAccess::Everything => Ok(()),
            NetworkAccess::Nothing | NetworkAccess::SimulatedOnly => Err(io::Error::new(
                io::ErrorKind::PermissionDenied,
                "no machine reaches this program: it may use those only that a test plays",
            )),
        }
    }

    fn enter(self: &Rc<Self>, state: SocketState) -> io::Result<Rc<TaskSocket>> {
        let mut open = self.open.borrow_mut();
        open.retain(|socket| socket.upgrade().is_some_and(|socket| !socket.is_closed()));
        if open.len() >= SOCKETS_MAX {
            let text = format!("{SOCKETS_MAX} sockets are open already, more are not allowed");
            return Err(io::Error::other(text));
        }
        let socket = Rc::new(TaskSocket {
            sockets: self.clone(),
            state: RefCell::new(state),
            waits: RefCell::default(),
        });
        open.push(Rc::downgrade(&socket));
        Ok(socket)
    }

    /// The end of the task: what programs left open is closed.
    pub fn close_all(&self) {
        let open = std::mem::take(&mut *self.open.borrow_mut());
        for socket in open.iter().filter_map(Weak::upgrade) {
            socket.close();
        }
    }
}

/// One socket of a program.
struct TaskSocket {
    sockets: Rc<Sockets>,
    state: RefCell<SocketState>,
    /// Futures that will wake a thread, one for each.
    waits: RefCell<Vec<(ThreadId, AbortHandle)>>,
}

enum SocketState {
    New(TcpSocket),
    Connecting(Arc<Mutex<PendingIo<TcpStream>>>),
    Connected(Arc<PeerStream>),
    Listening(
        Arc<TcpListener>,
        Arc<Mutex<PendingIo<(TcpStream, SocketAddr)>>>,
    ),
    Closed,
}

/// Something that a future is bringing about.
struct PendingIo<T> {
    result: Option<io::Result<T>>,
    /// The future, while it is at work.
    under_way: Option<AbortHandle>,
    waiters: Vec<ThreadId>,
}

impl<T> Default for PendingIo<T> {
    fn default() -> Self {
        PendingIo {
            result: None,
            under_way: None,
            waiters: Vec::new(),
        }
    }
}

fn lock<T>(pending: &Mutex<PendingIo<T>>) -> MutexGuard<'_, PendingIo<T>> {
    pending.lock().unwrap_or_else(PoisonError::into_inner)
}

fn settle<T>(pending: &Mutex<PendingIo<T>>, result: io::Result<T>, outside: &IoWaiters) {
    let waiters = {
        let mut pending = lock(pending);
        pending.result = Some(result);
        pending.under_way = None;
        std::mem::take(&mut pending.waiters)
    };
    for thread in waiters {
        outside.wake(thread);
    }
}

/// Starts a future of the task's own runtime.
fn start(future: impl Future<Output = ()> + Send + 'static) -> AbortHandle {
    let task = ThreadSupervisor::default().spawn(ThreadRole::Task, "socket", future);
    task.abort_handle()
}

/// A panic is an error of the socket, so that whoever waits goes on.
async fn contained<T>(result: impl Future<Output = io::Result<T>>) -> io::Result<T> {
    let fault = |panicked: CaughtPanic| Err(io::Error::other(panicked.message));
    CatchPanic::new(result).await.unwrap_or_else(fault)
}

/// Ends the future, and says who waited for it.
fn give_up<T>(pending: &Mutex<PendingIo<T>>) -> Vec<ThreadId> {
    let mut pending = lock(pending);
    if let Some(future) = pending.under_way.take() {
        future.abort();
    }
    std::mem::take(&mut pending.waiters)
}

impl TaskSocket {
    fn is_closed(&self) -> bool {
        matches!(*self.state.borrow(), SocketState::Closed)
    }

    fn stream(&self) -> io::Result<Arc<PeerStream>> {
        match &*self.state.borrow() {
            SocketState::Connected(stream) => Ok(stream.clone()),
            SocketState::Closed => Err(io::Error::from_raw_os_error(EBADF)),
            _ => Err(io::Error::from_raw_os_error(ENOTCONN)),
        }
    }
}

/// Linux error numbers of conditions that are found here rather than by the system.
const EBADF: i32 = 9;
const EINVAL: i32 = 22;
const EISCONN: i32 = 106;
const ENOTCONN: i32 = 107;

/// The address of both ends of a connection within this process.
const LOOPBACK_ADDRESS: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 0);

/// The address of a name of this machine.
fn own_address(host: &str, port: u16) -> io::Result<SocketAddr> {
    let ip = match host {
        "" | "0.0.0.0" => IpAddr::V4(Ipv4Addr::UNSPECIFIED),
        "localhost" => IpAddr::V4(Ipv4Addr::LOCALHOST),
        other => other.parse().map_err(|_| {
            let text = format!("'{other}' is not an address of this machine");
            io::Error::new(io::ErrorKind::AddrNotAvailable, text)
        })?,
    };
    Ok(SocketAddr::new(ip, port))
}

impl HostSocket for TaskSocket {
    fn connect(&self, host: &str, port: u16) -> io::Result<()> {
        let mut state = self.state.borrow_mut();
        let bound = match &*state {
            SocketState::New(socket) => socket.local_addr().is_ok_and(|own| own.port() != 0),
            SocketState::Closed => return Err(io::Error::from_raw_os_error(EBADF)),
            // Asked again after a timeout: the first attempt goes on.
            SocketState::Connecting(..) => return Ok(()),
            _ => return Err(io::Error::from_raw_os_error(EISCONN)),
        };
        if let Some(stream) = self.sockets.context.stand_in(host, port) {
            *state = SocketState::Connected(Arc::new(PeerStream::local(stream?)?));
            return Ok(());
        }
        let SocketState::New(socket) = std::mem::replace(&mut *state, SocketState::Closed) else {
            return Err(io::Error::from_raw_os_error(EBADF));
        };
        let pending = Arc::new(Mutex::new(PendingIo::default()));
        let (slot, outside, host) = (
            pending.clone(),
            self.sockets.outside.clone(),
            host.to_owned(),
        );
        let host = if host.is_empty() {
            "localhost".to_owned()
        } else {
            host
        };
        let task = start(async move {
            let connecting = async {
                if bound {
                    connect_from(socket, &host, port).await
                } else {
                    names::connect(&host, port).await
                }
            };
            settle(&slot, contained(connecting).await, &outside);
        });
        lock(&pending).under_way = Some(task);
        *state = SocketState::Connecting(pending);
        Ok(())
    }

    fn connect_result(&self) -> io::Result<()> {
        let result = match &*self.state.borrow() {
            SocketState::Connecting(pending) => lock(pending).result.take(),
            SocketState::Connected(_) => return Ok(()),
            _ => return Err(io::Error::from_raw_os_error(EBADF)),
        };
        match result {
            None => Err(io::ErrorKind::WouldBlock.into()),
            Some(Ok(stream)) => {
                *self.state.borrow_mut() =
                    SocketState::Connected(Arc::new(PeerStream::Tcp(stream)));
                Ok(())
            }
            Some(Err(error)) => {
                *self.state.borrow_mut() = SocketState::New(TcpSocket::new_v4()?);
                Err(error)
            }
        }
    }

    fn bind(&self, host: &str, port: u16) -> io::Result<()> {
        self.sockets.check_open_to_others()?;
        match &*self.state.borrow() {
            SocketState::New(socket) => {
                socket.set_reuseaddr(true)?;
                socket.bind(own_address(host, port)?)
            }
            SocketState::Closed => Err(io::Error::from_raw_os_error(EBADF)),
            _ => Err(io::Error::from_raw_os_error(EINVAL)),
        }
    }

    fn listen(&self, backlog: u32) -> io::Result<()> {
        self.sockets.check_open_to_others()?;
        let mut state = self.state.borrow_mut();
        match std::mem::replace(&mut *state, SocketState::Closed) {
            SocketState::New(socket) => {
                if !socket.local_addr().is_ok_and(|own| own.port() != 0) {
                    socket.bind(own_address("", 0)?)?;
                }
                let listener = socket.listen(backlog.max(1))?;
                *state = SocketState::Listening(Arc::new(listener), Arc::default());
                Ok(())
            }
            other => {
                let number = if matches!(other, SocketState::Closed) {
                    EBADF
                } else {
                    EINVAL
                };
                *state = other;
                Err(io::Error::from_raw_os_error(number))
            }
        }
    }

    fn accept(&self) -> io::Result<(Rc<dyn HostSocket>, SocketAddr)> {
        let result = match &*self.state.borrow() {
            SocketState::Listening(_, pending) => lock(pending).result.take(),
            SocketState::Closed => return Err(io::Error::from_raw_os_error(EBADF)),
            _ => return Err(io::Error::from_raw_os_error(EINVAL)),
        };
        match result {
            None => Err(io::ErrorKind::WouldBlock.into()),
            Some(result) => {
                let (stream, from) = result?;
                let socket = self
                    .sockets
                    .enter(SocketState::Connected(Arc::new(PeerStream::Tcp(stream))))?;
                Ok((socket, from))
            }
        }
    }

    fn read(&self, buffer: &mut [u8]) -> io::Result<usize> {
        if buffer.is_empty() {
            return Ok(0);
        }
        self.stream()?.try_read(buffer)
    }

    fn write(&self, data: &[u8]) -> io::Result<usize> {
        if data.is_empty() {
            return Ok(0);
        }
        self.stream()?.try_write(data)
    }

    fn shutdown(&self, how: Shutdown) -> io::Result<()> {
        let stream = self.stream()?;
        stream.socket().shutdown(how)
    }

    fn close(&self) {
        let state = self.state.replace(SocketState::Closed);
        // Whoever waits finds it closed.
        let waiters = match &state {
            SocketState::Connecting(pending) => give_up(pending),
            SocketState::Listening(_, pending) => give_up(pending),
            SocketState::New(_) | SocketState::Connected(_) | SocketState::Closed => Vec::new(),
        };
        for thread in waiters {
            self.sockets.outside.wake(thread);
        }
        for (thread, wait) in self.waits.take() {
            wait.abort();
            self.sockets.outside.wake(thread);
        }
    }

    fn set_nodelay(&self, on: bool) -> io::Result<()> {
        match &*self.state.borrow() {
            SocketState::Connected(stream) => match &**stream {
                PeerStream::Tcp(stream) => stream.set_nodelay(on),
                PeerStream::Local(_) => Ok(()),
            },
            SocketState::New(socket) => socket.set_nodelay(on),
            SocketState::Connecting(..) | SocketState::Listening(..) => Ok(()),
            SocketState::Closed => Err(io::Error::from_raw_os_error(EBADF)),
        }
    }

    fn local_address(&self) -> io::Result<SocketAddr> {
        match &*self.state.borrow() {
            SocketState::New(socket) => socket.local_addr(),
            SocketState::Connected(stream) => match &**stream {
                PeerStream::Tcp(stream) => stream.local_addr(),
                PeerStream::Local(_) => Ok(LOOPBACK_ADDRESS),
            },
            SocketState::Listening(listener, _) => listener.local_addr(),
            SocketState::Connecting(..) => Err(io::Error::from_raw_os_error(ENOTCONN)),
            SocketState::Closed => Err(io::Error::from_raw_os_error(EBADF)),
        }
    }

    fn peer_address(&self) -> io::Result<SocketAddr> {
        match &*self.stream()? {
            PeerStream::Tcp(stream) => stream.peer_addr(),
            PeerStream::Local(_) => Ok(LOOPBACK_ADDRESS),
        }
    }

    fn watch(&self, thread: ThreadId, interest: Interest) {
        let outside = self.sockets.outside.clone();
        outside.wait(thread);
        let mut waits = self.waits.borrow_mut();
        waits.retain(|(other, wait)| {
            if *other == thread {
                wait.abort();
            }
            *other != thread && !wait.is_finished()
        });
        let wait = match &*self.state.borrow() {
            SocketState::Connected(stream) => {
                let stream = stream.clone();
                start(async move {
                    // An error shows in the operation that follows.
                    let _ = match interest {
                        Interest::Write => stream.writable().await,
                        Interest::Read | Interest::Connect => stream.readable().await,
                    };
                    outside.wake(thread);
                })
            }
            SocketState::Connecting(pending) => {
                let mut pending = lock(pending);
                if pending.result.is_none() {
                    pending.waiters.push(thread);
                    return;
                }
                start(async move { outside.wake(thread) })
            }
            SocketState::Listening(listener, pending) => {
                let (listener, slot) = (listener.clone(), pending.clone());
                let mut pending = lock(pending);
                pending.waiters.push(thread);
                if pending.under_way.is_none() {
                    let accepting = start(async move {
                        settle(&slot, contained(listener.accept()).await, &outside);
                    });
                    pending.under_way = Some(accepting);
                }
                return;
            }
            SocketState::New(_) | SocketState::Closed => start(async move { outside.wake(thread) }),
        };
        waits.push((thread, wait));
    }
}

impl Drop for TaskSocket {
    fn drop(&mut self) {
        self.close();
    }
}

/// Connects a socket that has an address of its own.
async fn connect_from(socket: TcpSocket, host: &str, port: u16) -> io::Result<TcpStream> {
    let addresses = names::resolve(host, port).await?;
    match addresses.into_iter().find(SocketAddr::is_ipv4) {
        Some(address) => socket.connect(address).await,
        None => Err(io::Error::new(
            io::ErrorKind::NotFound,
            format!("'{host}' has no IPv4 address"),
        )),
    }
}
