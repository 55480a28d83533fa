//! The numbers of the server in Prometheus' text format. Pure.

use core::fmt::{Display, Write};

use motion_api::RobotState;

use crate::ports::description::TaskStatus;
use crate::ports::listen::PortMeter;

/// The media type of the format.
pub const CONTENT_TYPE: &str = "text/plain; version=0.0.4; charset=utf-8";

/// What is measured.
#[derive(Clone, Copy, Debug)]
pub struct Measurements<'a> {
    /// The latest snapshot.
    pub state: &'a RobotState,
    /// What the main task is doing.
    pub task: TaskStatus,
    /// Cycles that took longer than a cycle lasts.
    pub overruns: u64,
    /// Cycles that were left out.
    pub missed_cycles: u64,
    /// Ports and their clients.
    pub ports: &'a [PortMeter],
}

/// The page.
pub fn render(m: &Measurements<'_>) -> String {
    let mut page = Page::default();
    page.counter("cycles_total", "Control cycles since start.", m.state.cycle);
    page.counter(
        "cycle_overruns_total",
        "Cycles that took longer than a cycle lasts.",
        m.overruns,
    );
    page.counter(
        "cycles_missed_total",
        "Cycles left out because the motion thread woke up too late.",
        m.missed_cycles,
    );
    page.counter(
        "records_lost_total",
        "Records that the recording could not take.",
        m.state.records_lost,
    );
    page.gauge(
        "cycle_period_seconds",
        "Length of a control cycle.",
        m.state.step_time,
    );
    page.gauge(
        "cycle_duration_seconds",
        "Time the last cycle took; 0 under the virtual clock.",
        m.state.step_duration_us / 1e6,
    );
    page.gauge(
        "cycle_wakeup_latency_seconds",
        "How late the last cycle began; 0 under the virtual clock.",
        m.state.wakeup_latency_us / 1e6,
    );
    page.gauge("time_seconds", "Simulated time since start.", m.state.time);
    page.gauge(
        "robot_mode",
        "Robot mode by number: 3 power off, 5 idle, 7 running.",
        m.state.robot_mode.number(),
    );
    page.gauge(
        "safety_mode",
        "Safety mode by number: 1 normal, 2 reduced, 3 protective stop.",
        m.state.safety_mode.number(),
    );
    page.gauge(
        "speed_scaling",
        "Speed scaling in effect, 0 to 1.",
        m.state.speed_scaling,
    );
    page.head("task_state", "1 for what the main task is doing.", "gauge");
    for state in [TaskStatus::Stopped, TaskStatus::Running, TaskStatus::Paused] {
        page.labelled(
            "task_state",
            "state",
            state.name(),
            u8::from(state == m.task),
        );
    }
    page.head("clients", "Clients connected now.", "gauge");
    for port in m.ports {
        page.labelled("clients", "port", port.name(), port.clients());
    }
    page.0
}

#[derive(Default)]
struct Page(String);

impl Page {
    fn counter(&mut self, name: &str, help: &str, value: u64) {
        self.head(name, help, "counter");
        self.line(format_args!("elite_{name} {value}"));
    }

    fn gauge(&mut self, name: &str, help: &str, value: impl Display) {
        self.head(name, help, "gauge");
        self.line(format_args!("elite_{name} {value}"));
    }

    fn head(&mut self, name: &str, help: &str, kind: &str) {
        self.line(format_args!("# HELP elite_{name} {help}"));
        self.line(format_args!("# TYPE elite_{name} {kind}"));
    }

    fn labelled(&mut self, name: &str, label: &str, value: &str, number: impl Display) {
        self.line(format_args!("elite_{name}{{{label}=\"{value}\"}} {number}"));
    }

    fn line(&mut self, line: core::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.0, "{line}");
    }
}
