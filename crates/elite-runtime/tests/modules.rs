//! Modules that reach into the task: threads, sleeping, sockets.

#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot set itself up should stop"
)]

use crate::common;

use std::io::{Read, Write};
use std::net::TcpListener;

use common::{Standing, run};
use elite_runtime::TaskEnd;

/// What a program prints that has to run to its end.
fn printed(text: &str) -> String {
    let ran = run(&Standing::default(), text);
    assert_eq!(
        (&ran.end, ran.error.as_str()),
        (&TaskEnd::Finished, ""),
        "{}",
        ran.printed
    );
    ran.printed
}

#[test]
fn an_error_in_the_library_is_told_at_the_line_of_the_program() {
    for (text, at) in [
        ("x = 1\nf = open('a.txt')", (2, 5)),
        (
            "import json\ndef read(s):\n    return json.loads(s)\nread('{')",
            (3, 12),
        ),
        (
            "import threading\ndef work():\n    x = 1 / 0\nt = threading.Thread(target=work)\nt.start()\nsleep(1)",
            (3, 9),
        ),
    ] {
        let ran = run(&Standing::default(), text);
        assert!(!ran.error.is_empty(), "{text}");
        assert_eq!(ran.error_at, at, "{text}\n{}", ran.report);
    }
}

#[test]
fn threads_of_the_language_are_scheduled_like_those_of_the_task() {
    let text = "
import threading, time
log = []
def work(name, pause):
    for i in range(3):
        time.sleep(pause)
        log.append((round(time.monotonic(), 3), name, i))
a = threading.Thread(target=work, args=('a', 0.02))
b = threading.Thread(target=work, args=('b', 0.05))
a.start(); b.start()
handle = start_thread(work, ('c', 0.03))
a.join(); b.join(); join_thread(handle)
print([name for _, name, _ in log], log[-1][0] - log[0][0] > 0.1)
";
    let once = printed(text);
    assert_eq!(once, "['a', 'c', 'a', 'b', 'a', 'c', 'c', 'b', 'b'] True\n");
    assert_eq!(printed(text), once);
}

#[test]
fn a_thread_that_is_stopped_lets_go_of_what_it_waits_for() {
    let text = "
import queue, threading, time
q = queue.Queue()
lock = threading.Lock()
def take():
    try:
        q.get()
    finally:
        print('stopped in get')
def hold():
    with lock:
        time.sleep(1000)
t = start_thread(take, ())
h = start_thread(hold, ())
time.sleep(0.1)
stop_thread(t); join_thread(t)
print(lock.locked())
stop_thread(h); join_thread(h)
print(lock.locked(), q.mutex.locked())
q.put(1)
print(q.get())
";
    assert_eq!(printed(text), "stopped in get\nTrue\nFalse False\n1\n");
}

#[test]
fn the_main_program_waits_for_threads_that_are_no_daemons() {
    let text = "
import threading, time
def late(what):
    time.sleep(0.5)
    print(what)
threading.Thread(target=late, args=('worker',)).start()
threading.Thread(target=late, args=('daemon',), daemon=True).start()
print('main')
";
    let output = printed(text);
    assert!(output.starts_with("main\nworker\n"), "{output}");
}

#[test]
fn an_error_in_a_thread_ends_the_task() {
    let text = "
import threading, time
def bad(): raise ValueError('in a thread')
threading.Thread(target=bad).start()
time.sleep(10)
print('not reached')
";
    let ran = run(&Standing::default(), text);
    assert_eq!(
        (ran.end, ran.error.as_str()),
        (TaskEnd::Failed, "ValueError: in a thread")
    );
    assert_eq!(ran.printed, "");
}

#[test]
fn a_client_socket_talks_to_a_peer_while_other_threads_go_on() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let peer = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(200));
        stream.write_all(b"hello\nsecond").unwrap();
        let mut answer = [0; 9];
        stream.read_exact(&mut answer).unwrap();
        answer
    });
    let text = format!(
        "
import socket, threading, time
ticks = []
def tick():
    while True:
        time.sleep(0.01)
        ticks.append(1)
threading.Thread(target=tick, daemon=True).start()
with socket.create_connection(('127.0.0.1', {port}), timeout=5) as s:
    f = s.makefile('r')
    print(repr(f.readline()), len(ticks) >= 3)
    s.sendall(b'answer ok')
    print(repr(f.read()), s.getpeername())
try:
    s.recv(1)
except OSError as e:
    print(e)
"
    );
    let peer_says =
        format!("'hello\\n' True\n'second' ('127.0.0.1', {port})\n[Errno 9] Bad file descriptor\n");
    assert_eq!(printed(&text), peer_says);
    assert_eq!(&peer.join().unwrap(), b"answer ok");
}

#[test]
fn a_server_socket_accepts_and_serves_within_one_task() {
    let text = "
import socket, threading, struct
server = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
server.bind(('127.0.0.1', 0))
server.listen(5)
port = server.getsockname()[1]
def serve():
    for _ in range(2):
        conn, address = server.accept()
        with conn:
            while True:
                data = conn.recv(4)
                if not data: break
                conn.sendall(struct.pack('>i', struct.unpack('>i', data)[0] * 2))
t = threading.Thread(target=serve); t.start()
for n in (21, -5):
    c = socket.socket()
    c.connect(('localhost', port))
    c.send(struct.pack('>i', n))
    print(struct.unpack('>i', c.recv(4)))
    c.shutdown(socket.SHUT_WR)
    print(c.recv(10))
    c.close()
t.join()
server.close()
big = socket.create_server(('127.0.0.1', 0))
received = []
def swallow():
    conn, _ = big.accept()
    while True:
        data = conn.recv(65536)
        if not data: break
        received.append(len(data))
t = threading.Thread(target=swallow); t.start()
with socket.create_connection(big.getsockname()) as c:
    c.sendall(b'x' * 3_000_000)
t.join()
print(sum(received))
";
    assert_eq!(printed(text), "(42,)\nb''\n(-10,)\nb''\n3000000\n");
}

#[test]
fn sockets_time_out_refuse_and_end_with_errors_of_python() {
    let text = "
import socket, time, threading
server = socket.create_server(('127.0.0.1', 0))
c = socket.create_connection(server.getsockname(), timeout=0.05)
begin = time.monotonic()
try: c.recv(1)
except socket.timeout as e: print(repr(e), 0.04 < time.monotonic() - begin < 1)
c.setblocking(False)
try: c.recv(1)
except BlockingIOError as e: print(e.errno)
print(c.gettimeout(), c.getblocking())
port = server.getsockname()[1]
server.settimeout(0.02)
server.accept()[0].close()
try: server.accept()
except TimeoutError as e: print(e)
c.settimeout(1)
print(c.recv(5))
server.close()
try: socket.create_connection(('127.0.0.1', port), timeout=1)
except ConnectionRefusedError as e: print(e)
print(socket.socket().connect_ex(('127.0.0.1', port)))
for bad in (lambda: socket.socket().recv(1), lambda: socket.socket().connect(5), lambda: socket.socket().connect(('x', \
1 << 20)), lambda: c.settimeout(-1), lambda: c.send('text')):
    try: bad()
    except Exception as e: print(type(e).__name__, e)
server = socket.create_server(('127.0.0.1', 0))
def close_later():
    time.sleep(0.05)
    server.close()
threading.Thread(target=close_later).start()
try: server.accept()
except OSError as e: print(e)
many = []
try:
    while True: many.append(socket.socket())
except OSError as e: print(e)
";
    let expected = "TimeoutError('timed out') True\n11\n0.0 False\ntimed out\nb''\n\
                    [Errno 111] Connection refused\n111\n\
        OSError [Errno 107] Transport endpoint is not connected\n\
        TypeError connect(): AF_INET address must be tuple, not int\n\
        OverflowError connect(): port must be 0-65535.\nValueError Timeout value out of range\n\
        TypeError a bytes-like object is required, not 'str'\n[Errno 9] Bad file descriptor\n\
        32 sockets are open already, more are not allowed\n";
    assert_eq!(printed(text), expected);
}

#[test]
fn a_secondary_program_may_neither_sleep_nor_wait() {
    let ran = run(
        &Standing::default(),
        "sec s():\n    import time\n    time.sleep(1)\nend\n",
    );
    let text = "[SEC] Exception: RuntimeError: a secondary program may not wait";
    assert!(ran.log.iter().any(|line| line == text), "{:?}", ran.log);
}
