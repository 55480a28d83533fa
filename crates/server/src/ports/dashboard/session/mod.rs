//! One client of the dashboard, over any duplex stream: a line in, a reply out, in order.
//!
//! What comes together is begun together, as the vendor's controller does: a line is carried out when it comes, not
//! when the one before has been answered, and its reply tells of the moment at which it came. Only the replies keep the
//! order of the lines. What concerns the task (load, play, pause, variables) is done one after the other, because each
//! answer depends on the one before.
//!
//! Some commands take a while, and so does a client that does not read its replies. Reading goes on meanwhile, so that
//! a `stop` or `pause` behind them acts at once; its reply keeps its place.

use std::collections::VecDeque;
use std::io;
use std::time::Duration;

use futures_util::StreamExt as _;
use futures_util::stream::FuturesOrdered;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::sync::Mutex;

use super::codec::{
    DashboardCommand, LINE_BYTES_MAX, encode, greeting, help, mistake, needs_remote_control, parse,
    percent, robot_mode_word, status,
};
use super::{DashboardBackend, DashboardOrder};
use crate::ports::ClientId;
use crate::ports::description::{CONTROLLER_VERSION, TaskStatus};
use crate::ports::lines::{Line, LineFramer};
use io_bus::ControlMode;
use motion_api::RobotMode;

/// What is read at once.
const READ_BYTES: usize = 16 * 1024;

/// Lines that are carried out at the same time, replies that wait to be written included.
const BEGUN_MAX: usize = 16;

/// What may wait of one client, bytes; more lines are answered without being carried out.
const HELD_BYTES_MAX: usize = 6 * 1024 * 1024;

/// With so much waiting the client is beyond help: its connection is closed.
const HELD_BYTES_TOO_MANY: usize = 2 * HELD_BYTES_MAX;

/// What a client sends while there is no room for it is read in pieces with this pause between them.
const FLOOD_PAUSE: Duration = Duration::from_millis(1);

/// What an entry of the queue takes beside its text, bytes, rounded up.
const ENTRY_BYTES: usize = 64;

const PLAY_REFUSED: &str = "Failed to execute: play (an order to stop or to pause came behind it)";
const TOO_MANY_WAIT: &str = "Failed to execute: too many lines wait";

/// Serves one client until it leaves or says so.
///
/// # Errors
/// The connection broke.
pub async fn serve(
    stream: impl AsyncRead + AsyncWrite + Unpin,
    client: ClientId,
    dashboard: &impl DashboardBackend,
) -> io::Result<()> {
    let (reader, mut writer) = tokio::io::split(stream);
    let mut input = LineReader::new(reader);
    let mut waiting = InputQueue::default();
    let desk = Desk {
        client,
        dashboard,
        task: Mutex::default(),
    };
    let mut begun = FuturesOrdered::new();
    let mut replies = Replies::default();
    replies.push(&greeting(), false);
    let mut lines = VecDeque::new();
    loop {
        while begun.len() + replies.waiting.len() < BEGUN_MAX
            && let Some(entry) = waiting.next(begun.is_empty())
        {
            begun.push_back(desk.deal_with(entry));
        }
        if let Some(line) = lines.pop_front() {
            waiting.take_in(line, !begun.is_empty(), &desk).await?;
            continue;
        }
        if begun.is_empty() && replies.waiting.is_empty() && input.has_ended {
            return Ok(());
        }
        tokio::select! {
            biased;
            Some((reply, closes)) = begun.next() => replies.push(&reply, closes),
            written = replies.write(&mut writer), if !replies.waiting.is_empty() => {
                if written? {
                    return writer.shutdown().await;
                }
            }
            received = input.receive(), if !input.has_ended => {
                lines.extend(received?);
                // Others on this thread have a turn, however much waits here.
                match waiting.bytes > HELD_BYTES_MAX {
                    true => tokio::time::sleep(FLOOD_PAUSE).await,
                    false => tokio::task::yield_now().await,
                }
            }
        }
    }
}

/// Replies on their way to the client.
#[derive(Default)]
struct Replies {
    /// Each with whether the connection ends behind it.
    waiting: VecDeque<(Vec<u8>, bool)>,
    /// Bytes of the first reply that are written.
    written: usize,
}

impl Replies {
    fn push(&mut self, reply: &str, closes: bool) {
        self.waiting.push_back((encode(reply), closes));
    }

    /// Writes some of the first reply, all of it in one write where the client takes it; true when the connection ends
    /// with it. Nothing is lost when this is dropped before it returns.
    async fn write(&mut self, writer: &mut (impl AsyncWrite + Unpin)) -> io::Result<bool> {
        let Some((reply, closes)) = self.waiting.front() else {
            return Ok(false);
        };
        let count = writer.write(&reply[self.written..]).await?;
        if count == 0 {
            return Err(io::ErrorKind::WriteZero.into());
        }
        self.written += count;
        if self.written < reply.len() {
            return Ok(false);
        }
        let closes = *closes;
        self.waiting.pop_front();
        self.written = 0;
        Ok(closes)
    }
}

/// What comes from the client.
struct LineReader<R> {
    reader: R,
    framer: LineFramer,
    buffer: Vec<u8>,
    /// The client sends no more.
    has_ended: bool,
}

impl<R: AsyncRead + Unpin> LineReader<R> {
    fn new(reader: R) -> Self {
        Self {
            reader,
            framer: LineFramer::new(LINE_BYTES_MAX),
            buffer: vec![0; READ_BYTES],
            has_ended: false,
        }
    }

    /// The lines that came next, none at the end. Nothing is lost when this is dropped before it returns.
    async fn receive(&mut self) -> io::Result<Vec<Line>> {
        let mut lines = Vec::new();
        let count = self.reader.read(&mut self.buffer).await?;
        self.framer.push(&self.buffer[..count], &mut lines);
        self.has_ended = count == 0;
        Ok(lines)
    }
}

/// A line whose turn has not come.
#[derive(Debug)]
enum QueuedLine {
    /// A line to carry out and answer.
    Line(Line),
    /// To be answered, so many times: it was carried out when it came, or is not at all. In its turn the order is given
    /// once more, for what has begun meanwhile.
    Answered {
        reply: String,
        times: usize,
        again: Option<DashboardOrder>,
    },
}

impl QueuedLine {
    fn not_carried_out(reply: &str) -> Self {
        Self::Answered {
            reply: reply.to_owned(),
            times: 1,
            again: None,
        }
    }

    fn bytes(&self) -> usize {
        let text = match self {
            Self::Line(Line::Text(text)) => text.capacity(),
            Self::Line(Line::TooLong) => 0,
            Self::Answered { reply, .. } => reply.capacity(),
        };
        ENTRY_BYTES + text
    }

    fn command(&self) -> Option<DashboardCommand> {
        match self {
            Self::Line(Line::Text(text)) => parse(text).ok(),
            Self::Line(Line::TooLong) | Self::Answered { .. } => None,
        }
    }

    fn is_play(&self) -> bool {
        self.command() == Some(DashboardCommand::Play)
    }

    /// What ends the connection or the controller must not take the replies of others with it.
    fn comes_last(&self) -> bool {
        matches!(
            self.command(),
            Some(DashboardCommand::Quit | DashboardCommand::Reboot | DashboardCommand::Shutdown)
        )
    }
}

/// What was received and not begun yet, in order.
#[derive(Default)]
struct InputQueue {
    entries: VecDeque<QueuedLine>,
    bytes: usize,
    plays: usize,
}

impl InputQueue {
    /// Adds what came. Behind others, waiting or (`is_busy`) begun, `stop` and `pause` act now.
    async fn take_in(
        &mut self,
        line: Line,
        is_busy: bool,
        desk: &Desk<'_, impl DashboardBackend>,
    ) -> io::Result<()> {
        let order = match &line {
            Line::Text(text) if is_busy || !self.entries.is_empty() => {
                urgent_order(text, desk.dashboard)
            }
            Line::Text(_) | Line::TooLong => None,
        };
        let entry = match (order, line) {
            (Some(order), Line::Text(text)) => {
                self.refuse_plays();
                let (reply, _) = answer(&text, desk.client, desk.dashboard).await;
                QueuedLine::Answered {
                    reply,
                    times: 1,
                    again: Some(order),
                }
            }
            _ if self.bytes > HELD_BYTES_MAX => QueuedLine::not_carried_out(TOO_MANY_WAIT),
            (_, line) => QueuedLine::Line(line),
        };
        self.push(entry);
        if self.bytes > HELD_BYTES_TOO_MANY {
            return Err(io::Error::other("more lines wait than there is room for"));
        }
        Ok(())
    }

    /// What would begin or go on only to be stopped or held does not.
    fn refuse_plays(&mut self) {
        if core::mem::take(&mut self.plays) > 0 {
            for entry in self.entries.iter_mut().filter(|entry| entry.is_play()) {
                *entry = QueuedLine::not_carried_out(PLAY_REFUSED);
            }
            self.bytes = self.entries.iter().map(QueuedLine::bytes).sum();
        }
    }

    fn push(&mut self, entry: QueuedLine) {
        if let QueuedLine::Answered { reply, again, .. } = &entry
            && let Some(QueuedLine::Answered {
                reply: before,
                again: order_before,
                times,
            }) = self.entries.back_mut()
            && before == reply
            && order_before == again
        {
            *times += 1;
            return;
        }
        self.bytes += entry.bytes();
        self.plays += usize::from(entry.is_play());
        self.entries.push_back(entry);
    }

    /// The next to begin. While others are being carried out, what must come last is not it.
    fn next(&mut self, is_alone: bool) -> Option<QueuedLine> {
        if !is_alone && self.entries.front()?.comes_last() {
            return None;
        }
        if let Some(QueuedLine::Answered {
            reply,
            times,
            again,
        }) = self.entries.front_mut()
            && *times > 1
        {
            *times -= 1;
            return Some(QueuedLine::Answered {
                reply: reply.clone(),
                times: 1,
                again: again.clone(),
            });
        }
        let entry = self.entries.pop_front()?;
        self.bytes -= entry.bytes();
        self.plays -= usize::from(entry.is_play());
        Some(entry)
    }
}

/// The order that a line is if it makes a running task stand still and may do so now. A `pause` of a task that a `play`
/// is yet to start has its turn after that.
fn urgent_order(line: &str, dashboard: &impl DashboardBackend) -> Option<DashboardOrder> {
    let order = match parse(line) {
        Ok(DashboardCommand::Stop) => DashboardOrder::Stop,
        Ok(DashboardCommand::Pause) if dashboard.task_status() == TaskStatus::Running => {
            DashboardOrder::Pause
        }
        _ => return None,
    };
    (dashboard.control() == ControlMode::Remote).then_some(order)
}

/// Carries out the lines of one client.
struct Desk<'a, D> {
    client: ClientId,
    dashboard: &'a D,
    /// Held while something concerns the task; whoever waits has its turn in the order of the lines.
    task: Mutex<()>,
}

impl<D: DashboardBackend> Desk<'_, D> {
    /// The reply to an entry, and whether the connection ends with it.
    async fn deal_with(&self, entry: QueuedLine) -> (String, bool) {
        match entry {
            QueuedLine::Line(Line::Text(text)) => {
                let _turn = match parse(&text) {
                    Ok(command) if command.concerns_the_task() => Some(self.task.lock().await),
                    _ => None,
                };
                answer(&text, self.client, self.dashboard).await
            }
            QueuedLine::Line(Line::TooLong) => {
                let kib = LINE_BYTES_MAX / 1024;
                (format!("The line is longer than {kib} KiB."), false)
            }
            QueuedLine::Answered { reply, again, .. } => {
                if let Some(order) = again {
                    // Behind a `play` that has begun, so that its program is met as well.
                    let _turn = self.task.lock().await;
                    self.dashboard.order(order).await;
                }
                (reply, false)
            }
        }
    }
}

/// The reply to a line, and whether the connection ends with it.
pub(crate) async fn answer(
    line: &str,
    client: ClientId,
    dashboard: &impl DashboardBackend,
) -> (String, bool) {
    let command = match parse(line) {
        Ok(command) => command,
        Err(found) => return (mistake(line, &found), false),
    };
    if let Some(word) = command.word_needing_remote_control()
        && dashboard.control() != ControlMode::Remote
    {
        return (needs_remote_control(word, dashboard.control()), false);
    }
    tracing::debug!(%client, ?command, "dashboard");
    let closes = matches!(
        command,
        DashboardCommand::Quit | DashboardCommand::Reboot | DashboardCommand::Shutdown
    );
    let reply = match question(&command, dashboard) {
        Some(reply) => reply,
        None => carry_out(command, dashboard).await,
    };
    (reply, closes)
}

/// The reply to a command that changes nothing.
fn question(command: &DashboardCommand, dashboard: &impl DashboardBackend) -> Option<String> {
    let state = || dashboard.state();
    let task = || dashboard.task_status();
    Some(match command {
        DashboardCommand::Echo => "Hello ELITE ROBOTS.".to_owned(),
        DashboardCommand::SafetyMode => format!("Safety mode: {}", state().safety_mode.name()),
        DashboardCommand::SafetyStatus => format!("Safety status: {}", state().safety_mode.name()),
        DashboardCommand::RobotMode => {
            format!("robotMode: {}", robot_mode_word(state().robot_mode))
        }
        DashboardCommand::Status => {
            let state = state();
            status(
                state.robot_mode,
                state.safety_mode,
                task(),
                state.target_speed_fraction,
            )
        }
        DashboardCommand::Speed => format!("speed: {}", percent(state().target_speed_fraction)),
        DashboardCommand::Version => CONTROLLER_VERSION.map(|part| part.to_string()).join("."),
        DashboardCommand::RobotType => dashboard.description().name.clone(),
        // A simulated arm has no plate to read these from.
        DashboardCommand::SerialNumber => format!("SIM-{}", dashboard.description().robot_type),
        DashboardCommand::RobotId => "1".to_owned(),
        DashboardCommand::TaskPath => format!(
            "Relative path:{}",
            dashboard.loaded_task().unwrap_or_default()
        ),
        DashboardCommand::TaskStatus => format!("Task is {}", task().name()),
        DashboardCommand::TaskIsRunning => match task() {
            TaskStatus::Running => "Task is running".to_owned(),
            TaskStatus::Stopped | TaskStatus::Paused => "Task is not running".to_owned(),
        },
        // Tasks are files: what is loaded is what is on disk.
        DashboardCommand::TaskIsSaved => "Task is saved".to_owned(),
        DashboardCommand::ConfigurationPath => format!(
            "configuration: Relative path:{}",
            dashboard.loaded_configuration().unwrap_or_default()
        ),
        DashboardCommand::ConfigurationIsModified => "configuration is not modified".to_owned(),
        DashboardCommand::RemoteControl => (dashboard.control() == ControlMode::Remote).to_string(),
        DashboardCommand::Help(names) => help(names),
        DashboardCommand::Quit => "Disconnected".to_owned(),
        _ => return None,
    })
}

/// Does what the command says and gives its reply.
async fn carry_out(command: DashboardCommand, dashboard: &impl DashboardBackend) -> String {
    let (order, reply) = match command {
        DashboardCommand::Power(true) => (DashboardOrder::PowerOn, "Powering on".to_owned()),
        DashboardCommand::Power(false) => (DashboardOrder::PowerOff, "Powering off".to_owned()),
        DashboardCommand::BrakeRelease if dashboard.state().robot_mode == RobotMode::Running => {
            return "Brake is released.".to_owned();
        }
        DashboardCommand::BrakeRelease => {
            (DashboardOrder::ReleaseBrakes, "Brake Releasing".to_owned())
        }
        DashboardCommand::CloseSafetyDialog => (
            DashboardOrder::CloseSafetyDialog,
            "closing safety dialog".to_owned(),
        ),
        DashboardCommand::UnlockProtectiveStop => (
            DashboardOrder::UnlockProtectiveStop,
            "Protective stop unlocking...".to_owned(),
        ),
        DashboardCommand::RestartSafetyBoard => (
            DashboardOrder::RestartSafetyBoard,
            "Restarting safety board".to_owned(),
        ),
        DashboardCommand::ClearAlarms => (
            DashboardOrder::UnlockProtectiveStop,
            "clear alarm".to_owned(),
        ),
        DashboardCommand::SetSpeed(percent) => (
            DashboardOrder::SetSpeed(f64::from(percent) / 100.0),
            format!("Setting speed: {percent}"),
        ),
        DashboardCommand::Log(text) => {
            (DashboardOrder::Log(text), "Log has been added.".to_owned())
        }
        DashboardCommand::ShowPopup(text) => {
            let reply = format!("Showing popup with text:{text}");
            (DashboardOrder::ShowPopup(text), reply)
        }
        DashboardCommand::ClosePopup => (DashboardOrder::ClosePopup, "Closing popup".to_owned()),
        // The setting is the pendant's; the dashboard only switches where it is enabled.
        DashboardCommand::SetRemoteControl(_) if dashboard.control() == ControlMode::Mixed => {
            return needs_remote_control("remoteControl", ControlMode::Mixed);
        }
        DashboardCommand::SetRemoteControl(on) => {
            let (mode, word) = match on {
                true => (ControlMode::Remote, "on"),
                false => (ControlMode::Local, "off"),
            };
            (
                DashboardOrder::Control(mode),
                format!("Remote control is {word}"),
            )
        }
        // The SDK wants this also when nothing runs.
        DashboardCommand::Stop => (DashboardOrder::Stop, "Stopping task".to_owned()),
        DashboardCommand::Pause if dashboard.task_status() != TaskStatus::Running => {
            return "Failed to execute: pause".to_owned();
        }
        DashboardCommand::Pause => (DashboardOrder::Pause, "Pausing task".to_owned()),
        DashboardCommand::Reboot => (DashboardOrder::Reboot, "Rebooting".to_owned()),
        DashboardCommand::Shutdown => (DashboardOrder::Shutdown, "Shutting down".to_owned()),
        other => return attempt(other, dashboard).await,
    };
    dashboard.order(order).await;
    reply
}

/// Does what may fail.
async fn attempt(command: DashboardCommand, dashboard: &impl DashboardBackend) -> String {
    match command {
        DashboardCommand::Play => {
            if dashboard.plays_loaded_task() {
                return "Failed to execute: play".to_owned();
            }
            match dashboard.play().await {
                Ok(()) => "Starting task".to_owned(),
                Err(reason) => format!("Failed to execute: play ({reason})"),
            }
        }
        DashboardCommand::LoadTask(path) => match dashboard.load_task(&path).await {
            Ok(()) => format!("Loaded task: {path}"),
            Err(reason) => format!("Failed to load the task: {reason}"),
        },
        DashboardCommand::LoadConfiguration(path) => {
            match dashboard.load_configuration(&path).await {
                Ok(()) => format!("Loading Configuration : {path}"),
                Err(reason) => format!("Failed to load the configuration: {reason}"),
            }
        }
        DashboardCommand::GetVariable(name) => match dashboard.variable(&name).await {
            Ok(value) => value,
            Err(reason) => format!("Error: {reason}"),
        },
        DashboardCommand::SetVariable(name, value) => {
            match dashboard.set_variable(&name, &value).await {
                Ok(()) => format!("{name}, {value}"),
                Err(reason) => format!("Error: {reason}"),
            }
        }
        // Every other command was answered above.
        other => format!("Failed to execute: {other:?}"),
    }
}

#[cfg(test)]
mod tests;
