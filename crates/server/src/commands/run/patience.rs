//! A program that does not come to its end: says what it is at, and stops it when its time is up.

use std::cell::Cell;
use std::time::Duration;

use elite_runtime::ProgramText;
use messages::{Text, text};
use tokio::time::{Instant, sleep};

use crate::controller_host::ControllerHost;
use crate::language;

/// A program that computes for so long without simulated time is told of.
const SILENCE: Duration = Duration::from_secs(5);
/// So is an arm that stands for so long while the program goes on, simulated s.
const REST: f64 = 60.0;
/// The controller is looked at so often; the virtual clock makes a second of simulated time of less than two such
/// pauses.
const PERIOD: Duration = Duration::from_millis(2);
/// A joint that turns more slowly stands, rad/s.
const STANDING: f64 = 1e-4;

/// Watches a run.
pub(super) struct Patience<'h> {
    host: &'h ControllerHost,
    lines: Vec<String>,
    timeout: Option<Duration>,
    /// Time passes only when the program lets it.
    is_virtual: bool,
    is_silence_told: Cell<bool>,
    is_rest_told: Cell<bool>,
}

impl<'h> Patience<'h> {
    pub(super) fn new(
        host: &'h ControllerHost,
        program: &ProgramText,
        timeout: Option<Duration>,
        is_virtual: bool,
    ) -> Self {
        Self {
            host,
            lines: program.text.lines().map(str::to_owned).collect(),
            timeout,
            is_virtual,
            is_silence_told: Cell::new(false),
            is_rest_told: Cell::new(false),
        }
    }

    /// Returns when the program has had its time.
    pub(super) async fn run_out(&self) {
        let robot = self.host.controller().robot();
        let begun = Instant::now();
        let start = robot.state().time;
        let (mut latest, mut since, mut moved) = (start, begun, start);
        loop {
            sleep(PERIOD).await;
            let state = robot.state();
            if state.time > latest {
                (latest, since) = (state.time, Instant::now());
            }
            if state.actual_qd.max_abs() > STANDING {
                moved = state.time;
            }
            if self.is_virtual && since.elapsed() >= SILENCE && !self.is_silence_told.replace(true)
            {
                language::say(&self.silence());
            }
            let is_long = begun.elapsed() >= SILENCE && latest - moved >= REST;
            if self.is_virtual && is_long && !self.is_rest_told.replace(true) {
                language::say(&self.rest(latest - moved));
            }
            let Some(timeout) = self.timeout else {
                continue;
            };
            let simulated = latest - start;
            if simulated >= timeout.as_secs_f64() || since.elapsed() >= timeout {
                language::say(&self.time_is_up(timeout, simulated));
                return;
            }
        }
    }

    /// The line where the program computes.
    fn computing(&self) -> Text {
        self.shown(self.host.controller().supervisor().panel().computing_line())
    }

    /// The line of the main thread in the latest cycle.
    fn waiting(&self) -> Text {
        self.shown(self.host.feed().line())
    }

    /// `, in line 3: while True:`
    fn shown(&self, line: u32) -> Text {
        let text = usize::try_from(line)
            .ok()
            .and_then(|line| self.lines.get(line.checked_sub(1)?));
        let Some(text) = text else {
            return Text::verbatim("");
        };
        let text: String = text.trim().chars().take(80).collect();
        text!(", in line {line}: {text}", "，在第 {line} 行：{text}")
    }

    fn silence(&self) -> Text {
        text!(
            "the program has computed for {} s and no time of the robot has passed{}\n  \
             a loop has to call sync(), sleep() or a motion: otherwise time stands and no input changes; \
             --timeout S ends the program",
            "程序已计算 {} s，没有经过任何机器人时间{}\n  \
             循环必须调用 sync()、sleep() 或运动函数，否则时间不会前进，输入也不会改变；--timeout S 可结束程序",
            SILENCE.as_secs(),
            self.computing()
        )
    }

    fn rest(&self, seconds: f64) -> Text {
        text!(
            "the program goes on, but the arm has not moved for {seconds:.0} s of its time{}\n  \
             it may wait for an input that nobody sets: wire it with --cell, set it in a test (eliteserver test), or \
             end the program with --timeout S",
            "程序在运行，但机械臂已静止 {seconds:.0} s（机器人时间）{}\n  \
             它可能在等待没有人设置的输入：用 --cell 接线，用 eliteserver test 设置输入，或用 --timeout S 结束程序",
            self.waiting()
        )
    }

    fn time_is_up(&self, timeout: Duration, simulated: f64) -> Text {
        let given = timeout.as_secs_f64();
        match simulated < given {
            true => text!(
                "--timeout {given}: the program is stopped, no time of the robot has passed for {given} s{}",
                "--timeout {given}：{given} s 内没有经过机器人时间，程序被停止{}",
                self.computing()
            ),
            false => text!(
                "--timeout {given}: the program is stopped after {simulated:.3} s of the robot's time{}",
                "--timeout {given}：机器人时间 {simulated:.3} s 后程序被停止{}",
                self.waiting()
            ),
        }
    }
}
