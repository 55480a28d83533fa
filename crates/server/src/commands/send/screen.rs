//! What a person sees of a program that runs elsewhere: a line that changes on a terminal, plain lines in a pipe.

use std::io::Write;
use std::time::Duration;

use messages::Text;
use wire::primary::State;

use super::rtsi_progress::RtsiProgress;
use crate::language::{self, is_wide, pick, shown};
use crate::logging;
use crate::ports::escape::EscapedLines;

/// What every terminal has.
const COLUMNS: usize = 80;
/// The changing line is drawn so often at most.
const REDRAW: Duration = Duration::from_millis(100);

/// Standard error, with a line at its end that changes if it is a terminal.
pub(super) struct ProgressLine {
    is_terminal: bool,
    drawn: Option<Duration>,
    last: Option<(Duration, [f64; 3])>,
}

impl ProgressLine {
    /// Of a terminal, or of a pipe that gets no changing line.
    pub(super) const fn new(is_terminal: bool) -> Self {
        Self {
            is_terminal,
            drawn: None,
            last: None,
        }
    }

    /// A line that stays.
    pub(super) fn line(&mut self, text: &str) {
        self.wipe();
        logging::say(text);
        if self.is_terminal {
            // Before the changing line is drawn again.
            logging::flush_within(REDRAW);
        }
    }

    /// A text that stays, in the language of this process.
    pub(super) fn text(&mut self, text: &Text) {
        self.line(text.in_language(language::chosen()));
    }

    /// A line that the program printed: on standard output, as `run` has it.
    pub(super) fn output(&mut self, text: &str) {
        self.wipe();
        let mut out = std::io::stdout().lock();
        // Whoever reads may have seen enough.
        let _ = writeln!(out, "{}", EscapedLines(text)).and_then(|()| out.flush());
    }

    /// How the robot is, so long after the program was sent. `place` is where the program is.
    pub(super) fn state(
        &mut self,
        state: &State,
        told: RtsiProgress,
        place: &Text,
        moment: Duration,
    ) {
        let between = self.tcp_speed(state, moment);
        let speed = told.speed.or(between);
        let Some(mode) = &state.mode else { return };
        let is_due = self.drawn.is_none_or(|drawn| moment >= drawn + REDRAW);
        if !self.is_terminal || !is_due {
            return;
        }
        let doing = match (mode.is_task_running, mode.is_task_paused) {
            (true, true) => pick("paused", "已暂停"),
            (true, false) => pick("running", "运行中"),
            (false, _) => pick("standing", "静止"),
        };
        let stopped = match (mode.is_protective_stopped, mode.is_emergency_stopped) {
            (_, true) => pick(", EMERGENCY STOP", "，紧急停止"),
            (true, _) => pick(", protective stop", "，保护性停止"),
            _ => "",
        };
        let speed = speed.map_or_else(String::new, |speed| format!(", TCP {speed:.3} m/s"));
        let seconds = moment.as_secs_f64();
        let line = format!("{doing}{stopped}, {seconds:.1} s{speed}{}", shown(place));
        // A line that wraps is not wiped.
        let mut columns = 0;
        let drawn: String = line
            .chars()
            .take_while(|letter| {
                columns += 1 + usize::from(is_wide(*letter));
                columns < COLUMNS
            })
            .collect();
        let mut error = std::io::stderr().lock();
        // Whoever closed the terminal does not read it.
        let _ = write!(error, "\r\x1b[K{drawn}").and_then(|()| error.flush());
        self.drawn = Some(moment);
    }

    /// The speed between two states, m/s; states have positions only.
    fn tcp_speed(&mut self, state: &State, moment: Duration) -> Option<f64> {
        let pose = state.cartesian.as_ref()?.tcp_pose;
        let position = [pose[0], pose[1], pose[2]];
        let last = self.last.replace((moment, position));
        let (before, from) = last?;
        let time = moment.saturating_sub(before).as_secs_f64();
        let way = (0..3)
            .map(|i| (position[i] - from[i]).powi(2))
            .sum::<f64>()
            .sqrt();
        (time > 0.01).then(|| way / time)
    }

    /// Nothing changes any more.
    pub(super) fn end(&mut self) {
        self.wipe();
    }

    fn wipe(&mut self) {
        if self.drawn.take().is_some() {
            let mut error = std::io::stderr().lock();
            // A terminal that cannot be written to loses the line, no more.
            let _ = write!(error, "\r\x1b[K").and_then(|()| error.flush());
        }
    }
}
