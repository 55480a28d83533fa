//! The numbers of the server in Prometheus' text format. Pure.

use core::fmt::{Display, Write};

use motion::histogram::{BUCKETS_US, HistogramSnapshot};
use motion_api::RobotState;
use recorder::RecorderMetrics;
use supervision::ThreadRole;

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
    /// What the controller counts.
    pub figures: &'a Figures,
    /// Ports and their clients.
    pub ports: &'a [PortMeter],
}

/// What the controller counts, since start.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Figures {
    /// Cycles that ended later than the next one was due.
    pub overruns: u64,
    /// Cycles that were left out because the motion thread woke up too late.
    pub missed_cycles: u64,
    /// Durations of cycles.
    pub cycle_durations: HistogramSnapshot,
    /// How late cycles began.
    pub wakeup_latencies: HistogramSnapshot,
    /// Commands that wait for the motion thread.
    pub commands_waiting: usize,
    /// Statements of interpreter mode that wait.
    pub statements_waiting: usize,
    /// The recording, if there is one.
    pub recording: Option<RecordingFigures>,
    /// Errors by kind.
    pub errors: [(&'static str, u64); 5],
    /// Faults of ours that were contained, by the kind of their thread.
    pub faults: [u64; ThreadRole::ALL.len()],
    /// Log lines that nobody will read.
    pub log_lines_lost: u64,
}

/// What the recording counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RecordingFigures {
    /// Bytes written, all parts together.
    pub bytes: u64,
    /// Records that wait for the recorder.
    pub records_waiting: u64,
    /// Messages of programs that it could not take.
    pub notes_dropped: u64,
    /// Bytes of such messages that wait.
    pub note_bytes_waiting: u64,
    /// Texts that were too long for it.
    pub texts_cut: u64,
    /// The recording has stopped because its file cannot be written.
    pub has_failed: bool,
}

impl RecordingFigures {
    /// The figures now.
    pub fn of(meter: &RecorderMetrics) -> Self {
        Self {
            bytes: meter.bytes(),
            records_waiting: meter.records_waiting(),
            notes_dropped: meter.notes_dropped(),
            note_bytes_waiting: meter.bytes_waiting(),
            texts_cut: meter.texts_cut(),
            has_failed: meter.has_failed(),
        }
    }
}

/// The page.
pub fn render(m: &Measurements<'_>) -> String {
    let mut page = MetricsText::default();
    page.counter("cycles_total", "Control cycles since start.", m.state.cycle);
    page.counter(
        "cycle_overruns_total",
        "Cycles that ended later than the next one was due, because they took long or began late.",
        m.figures.overruns,
    );
    page.counter(
        "cycles_missed_total",
        "Cycles left out because the motion thread woke up too late.",
        m.figures.missed_cycles,
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
    page.histogram(
        "cycle_duration_seconds",
        "Time that cycles took; empty under the virtual clock.",
        &m.figures.cycle_durations,
    );
    page.histogram(
        "cycle_wakeup_latency_seconds",
        "How late cycles began; empty under the virtual clock.",
        &m.figures.wakeup_latencies,
    );
    page.head("queue_depth", "What waits, by queue.", "gauge");
    let records = m.figures.recording.map_or(0, |r| r.records_waiting);
    page.labelled(
        "queue_depth",
        "queue",
        "commands",
        m.figures.commands_waiting,
    );
    page.labelled("queue_depth", "queue", "records", records);
    page.labelled(
        "queue_depth",
        "queue",
        "interpreter",
        m.figures.statements_waiting,
    );
    page.head("errors_total", "Errors by kind.", "counter");
    for (kind, count) in m.figures.errors {
        page.labelled("errors_total", "kind", kind, count);
    }
    page.head(
        "faults_total",
        "Faults of ours that were contained, by kind of thread.",
        "counter",
    );
    for (kind, count) in ThreadRole::ALL.iter().zip(m.figures.faults) {
        page.labelled("faults_total", "kind", kind.name(), count);
    }
    page.counter(
        "log_lines_lost_total",
        "Log lines lost because standard error was closed or not read.",
        m.figures.log_lines_lost,
    );
    if let Some(recording) = &m.figures.recording {
        page.gauge(
            "recording_active",
            "1 while the recording is written, 0 after its file could not be.",
            u8::from(!recording.has_failed),
        );
        page.counter(
            "recording_bytes_total",
            "Bytes of the recording, all parts together.",
            recording.bytes,
        );
        page.counter(
            "recording_notes_dropped_total",
            "Messages of programs that the recording could not take.",
            recording.notes_dropped,
        );
        page.counter(
            "recording_texts_cut_total",
            "Texts of programs that were too long and were cut in the recording.",
            recording.texts_cut,
        );
        page.gauge(
            "recording_bytes_waiting",
            "Bytes of messages of programs that wait for the recording.",
            recording.note_bytes_waiting,
        );
    }
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
struct MetricsText(String);

impl MetricsText {
    fn counter(&mut self, name: &str, help: &str, value: u64) {
        self.head(name, help, "counter");
        self.line(format_args!("elite_{name} {value}"));
    }

    fn gauge(&mut self, name: &str, help: &str, value: impl Display) {
        self.head(name, help, "gauge");
        self.line(format_args!("elite_{name} {value}"));
    }

    fn histogram(&mut self, name: &str, help: &str, histogram: &HistogramSnapshot) {
        self.head(name, help, "histogram");
        let mut count = 0;
        for (end_us, in_bucket) in BUCKETS_US.iter().zip(histogram.counts) {
            count += in_bucket;
            let end = *end_us as f64 / 1e6;
            self.line(format_args!("elite_{name}_bucket{{le=\"{end}\"}} {count}"));
        }
        count += histogram.counts[BUCKETS_US.len()];
        let sum = histogram.sum_ns as f64 / 1e9;
        self.line(format_args!("elite_{name}_bucket{{le=\"+Inf\"}} {count}"));
        self.line(format_args!("elite_{name}_sum {sum}"));
        self.line(format_args!("elite_{name}_count {count}"));
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
