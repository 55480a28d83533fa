//! How fast stop and pause reach a program, and how fast statements go through port 30020.
//!
//! `cargo run --release -p server --example latency [TRIALS]`: the real ports on the loopback, the real clock, the
//! ideal plant, and everything in one process, so that the moment at which a program is unwound or held is seen
//! directly. The time is that from the write of the control line to a client's socket until
//! - stop: the program's `finally` block has run (busy loops and waits), or the arm decelerates (motion);
//! - pause: no thread of the program runs any more, or the arm decelerates (motion).

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a measurement fails by panicking"
)]

use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::Parser;
use elite_runtime::TaskState;
use elite_runtime::message::Message;
use server::backend::{Lifetime, PortBackend, forward_messages};
use server::cli::{Cli, CliCommand};
use server::config::ServeConfig;
use server::controller_host::ControllerHost;
use server::event_broadcast::PrintTarget;
use server::ports::listen::PortMeter;
use server::ports::{interpreter, primary};
use tokio::net::TcpListener;
use tokio::sync::broadcast;
use tokio_util::sync::CancellationToken;

/// Statements of the throughput figure.
const STATEMENTS: usize = 50_000;

/// What a program does when the order comes, as the body of a `try` block.
const SITUATIONS: [(&str, &str); 6] = [
    ("busy loop", "while True:\n      pass"),
    (
        "busy loop beside a busy thread",
        "start_thread(busy)\n    while True:\n      pass",
    ),
    ("sleep", "sleep(1000)"),
    ("sync in a loop", "while True:\n      sync()"),
    ("blocking popup", "popup('wait', blocking=True)"),
    ("interpreter mode", "interpreter_mode()"),
];

struct Bench {
    host: ControllerHost,
    primary: TcpStream,
    interpreter_port: u16,
    messages: broadcast::Receiver<Message>,
    runtime: tokio::runtime::Runtime,
    jitter: u64,
}

fn main() {
    let trials = std::env::args().nth(1).map_or(200, |n| n.parse().unwrap());
    let mut bench = Bench::start();
    println!("| situation | order | p50 ms | p99 ms | max ms |\n|---|---|---|---|---|");
    for (name, body) in SITUATIONS {
        let program = format!(
            "def bench():\n  def busy():\n    while True:\n      pass\n  try:\n    print('ready')\n    {body}\
             \n  finally:\n    print('reached')\nend\n"
        );
        let times = (0..trials).map(|_| bench.stop_reaches(&program)).collect();
        report(name, "stop", times);
        let times = (0..trials).map(|_| bench.pause_reaches(&program)).collect();
        report(name, "pause", times);
    }
    for order in ["stop", "pause"] {
        let times = (0..trials / 2)
            .map(|n| bench.motion_reaches(order, n))
            .collect();
        report("movej at full speed", order, times);
    }
    bench.throughput();
    std::process::exit(0);
}

fn report(situation: &str, order: &str, mut times: Vec<Duration>) {
    times.sort();
    let at = |share: f64| {
        let index = (share * (times.len() - 1) as f64).round() as usize;
        times[index].as_secs_f64() * 1e3
    };
    let (p50, p99, max) = (at(0.5), at(0.99), at(1.0));
    println!("| {situation} | {order} | {p50:.2} | {p99:.2} | {max:.2} |");
}

impl Bench {
    fn start() -> Self {
        let words = "eliteserver serve --plant ideal --record off --clock realtime";
        let CliCommand::Serve(args) = Cli::parse_from(words.split(' ')).into_command() else {
            unreachable!("the words say serve");
        };
        let config = ServeConfig::load(*args).unwrap();
        let host = ControllerHost::start(
            &config.robot,
            None,
            PrintTarget::Log,
            false,
            editor::dap::DebugHub::default(),
        )
        .unwrap();
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(2)
            .enable_all()
            .build()
            .unwrap();
        let hub = primary::StateHub::default();
        let backend = PortBackend::new(&host, &config, hub.clone(), Lifetime::default());
        let backend = Arc::new(backend);
        let token = CancellationToken::new();
        let (first, second) = runtime.block_on(async {
            let first = TcpListener::bind("127.0.0.1:0").await.unwrap();
            let second = TcpListener::bind("127.0.0.1:0").await.unwrap();
            (first, second)
        });
        let primary_port = first.local_addr().unwrap().port();
        let interpreter_port = second.local_addr().unwrap().port();
        let messages = host.announcer().subscribe();
        runtime.spawn(forward_messages(
            host.announcer().subscribe(),
            backend.clone(),
            token.clone(),
        ));
        let meter = PortMeter::new("primary");
        runtime.spawn(primary::serve(
            first,
            backend.clone(),
            hub,
            meter,
            token.clone(),
        ));
        runtime.spawn(interpreter::serve(
            second,
            backend,
            PortMeter::new("interpreter"),
            token,
        ));
        let primary = TcpStream::connect(("127.0.0.1", primary_port)).unwrap();
        primary.set_nodelay(true).unwrap();
        Self {
            host,
            primary,
            interpreter_port,
            messages,
            runtime,
            jitter: 1,
        }
    }

    fn send(&mut self, text: &str) {
        self.primary.write_all(text.as_bytes()).unwrap();
    }

    fn wait_for_print(&mut self, wanted: &str) {
        let messages = &mut self.messages;
        self.runtime.block_on(async {
            loop {
                match messages.recv().await.unwrap() {
                    Message::Print { text, .. } if text.trim() == wanted => return,
                    Message::ScriptError { report, .. } => panic!("{report}"),
                    _ => {}
                }
            }
        });
    }

    fn wait_until_stopped(&mut self) {
        let supervisor = self.host.controller().supervisor();
        self.runtime.block_on(supervisor.ended());
    }

    /// Some time later, so that orders come at any moment of a cycle.
    fn later(&mut self) {
        self.jitter = self
            .jitter
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        std::thread::sleep(Duration::from_micros(2000 + (self.jitter >> 33) % 8000));
    }

    fn begin(&mut self, program: &str) {
        self.wait_until_stopped();
        self.send(program);
        self.wait_for_print("ready");
        self.later();
    }

    fn stop_reaches(&mut self, program: &str) -> Duration {
        self.begin(program);
        let started = Instant::now();
        self.send("stop task\n");
        self.wait_for_print("reached");
        let time = started.elapsed();
        self.wait_until_stopped();
        time
    }

    fn pause_reaches(&mut self, program: &str) -> Duration {
        self.begin(program);
        let mut status = self.host.controller().supervisor().watch();
        let started = Instant::now();
        self.send("pause task\n");
        self.runtime
            .block_on(status.wait_for(|s| s.state == TaskState::Paused))
            .unwrap();
        let time = started.elapsed();
        self.send("stop task\n");
        self.wait_for_print("reached");
        self.wait_until_stopped();
        time
    }

    /// Until the commanded speed falls.
    fn motion_reaches(&mut self, order: &str, n: usize) -> Duration {
        const SPEED: f64 = 0.1;
        let target = if n.is_multiple_of(2) { 0.3 } else { -0.3 };
        let program = format!(
            "def bench():\n  print('ready')\n  movej([{target},-1.5708,1.5708,-1.5708,-1.5708,0],a=1,v={SPEED})\nend\n"
        );
        self.begin(&program);
        while self.speed() < 0.9999 * SPEED {
            std::thread::sleep(Duration::from_micros(200));
        }
        self.later();
        let started = Instant::now();
        self.send(&format!("{order} task\n"));
        while self.speed() > 0.9999 * SPEED {
            assert!(
                started.elapsed() < Duration::from_secs(2),
                "{order} does not reach the arm"
            );
            std::thread::sleep(Duration::from_micros(50));
        }
        let time = started.elapsed();
        self.send("stop task\n");
        self.wait_until_stopped();
        time
    }

    fn speed(&self) -> f64 {
        self.host.controller().robot().state().target_qd.max_abs()
    }

    /// Statements a second, from the first byte sent to the last acknowledgement and to the last execution; and the
    /// memory that a full queue takes.
    fn throughput(&mut self) {
        let mut client = TcpStream::connect(("127.0.0.1", self.interpreter_port)).unwrap();
        let mut replies = BufReader::new(client.try_clone().unwrap());
        self.send("def bench():\n  n = 0\n  print('ready')\n  interpreter_mode()\n  print('executed ' + str(n))\n\
            end\n");
        self.wait_for_print("ready");
        while !self
            .host
            .controller()
            .supervisor()
            .interpreter()
            .is_active()
        {
            std::thread::sleep(Duration::from_millis(1));
        }
        let text = "n = n + 1\n".repeat(STATEMENTS) + "end_interpreter()\n";
        let started = Instant::now();
        let sending = std::thread::spawn(move || {
            client.write_all(text.as_bytes()).unwrap();
            client
        });
        let (mut line, mut full) = (String::new(), 0);
        let mut acked = 0;
        while acked + full < STATEMENTS + 1 {
            line.clear();
            replies.read_line(&mut line).unwrap();
            if line.starts_with("ack: ") {
                acked += 1;
            } else {
                full += 1;
            }
        }
        let all_acked = started.elapsed();
        self.wait_until_stopped();
        let executed = started.elapsed();
        let mut client = sending.join().unwrap();
        let rate = |time: Duration| acked as f64 / time.as_secs_f64();
        println!(
            "\n{acked} statements: {:.0} acknowledged a second, {:.0} executed a second; {full} found the queue full",
            rate(all_acked),
            rate(executed)
        );

        self.send("def bench():\n  print('ready')\n  sleep(1000)\nend\n");
        self.wait_for_print("ready");
        let before = resident_bytes();
        client
            .write_all(
                "movel([0.3, 0.2, 0.1, 0.0, 3.14, 0.0], a=1.2, v=0.25)\n"
                    .repeat(8500)
                    .as_bytes(),
            )
            .unwrap();
        for _ in 0..8500 {
            line.clear();
            replies.read_line(&mut line).unwrap();
            assert!(line.starts_with("ack: "), "{line}");
        }
        let mib = (resident_bytes() - before) as f64 / (1 << 20) as f64;
        println!("8500 movel statements queued: {mib:.1} MiB");
    }
}

/// Memory of this process, from the kernel.
fn resident_bytes() -> i64 {
    let statm = std::fs::read_to_string("/proc/self/statm").unwrap();
    let pages: i64 = statm.split(' ').nth(1).unwrap().parse().unwrap();
    pages * 4096
}
