//! `eliteserver record`: what a robot somewhere else does, into a recording like our own.
//!
//! Owns the loop between the robot's ports and the recorder: gaps, reconnects, what was left out, and the summary. What
//! the packets mean is `robot-client`'s business, how they are written the recorder's.

mod clock;
mod reports;
mod robot;

use std::time::{Duration, SystemTime};

use kinematics::{CalibrationError, JointPositions};
use messages::{Localized, Text, text};
use motion_api::{MotionEndpoint, Record, RingCapacities, RobotState, motion_channel};
use recorder::{
    CustomTopic, CustomTopicId, LogLevel, RecordError, Recorder, RecorderConfig, RecorderHandle,
    Rotation, Setup,
};
use robot_client::calibrate::{self, CalibrateError};
use robot_client::observed::{
    KNOWN_VARIABLES, PacketExtras, RtsiStateMapper, apply_primary_state, outputs_message,
    outputs_schema, state_message, state_schema, unknown_state,
};
use robot_client::{RobotAddress, RtsiClient, RtsiError, RtsiMessage};
use thiserror::Error;
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep_until};
use wire::primary::Message;
use wire::rtsi::{RtsiType, RtsiValue};

use crate::cli::RecordArgs;
use crate::command::{CommandResult, CommandStatus};
use crate::language;
use crate::shutdown::Shutdown;
use controller::start_configuration::ROBOT;

use clock::Clock;
use reports::{level_of, tell};
use robot::RtsiEvent;

/// Exit status without a recording.
/// A disk that takes nothing for so long is given up.
const PATIENCE: Duration = Duration::from_secs(10);
/// Messages of port 30001 that wait.
const WAITING: usize = 256;
/// Variables of RTSI that have no place in a cycle.
const OUTPUTS: CustomTopicId = CustomTopicId(0);
/// States of port 30001.
const STATES: CustomTopicId = CustomTopicId(1);

/// A reason why there is no recording, told in a sentence.
#[derive(Debug, Error, Localized)]
enum RecordingError {
    #[error("cannot start: {0}")]
    #[zh("无法启动：{0}")]
    Start(#[from] std::io::Error),
    #[error(transparent)]
    Arm(#[from] CalibrateError),
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    #[error(transparent)]
    Rtsi(#[from] RtsiError),
    #[error(transparent)]
    Record(#[from] RecordError),
    #[error("the recording {0} has failed")]
    #[zh("记录 {0} 失败")]
    Failed(String),
}

/// Exit status: 0 recorded, 2 no connection or no recording.
pub fn record(args: &RecordArgs) -> CommandResult {
    let recorded = Shutdown::start(CommandStatus::Success)
        .map_err(RecordingError::from)
        .and_then(|shutdown| {
            let runtime = tokio::runtime::Builder::new_current_thread()
                .enable_all()
                .build()?;
            let recorded = runtime.block_on(recorded(args, &shutdown));
            // A look-up or a connection that hangs is left behind.
            runtime.shutdown_background();
            recorded
        });
    language::say(&recorded?);
    Ok(CommandStatus::Success)
}

/// What became of the stream.
#[derive(Clone, Copy, Debug, Default)]
struct StreamStats {
    cycles: u64,
    missing: u64,
    out_of_order: u64,
    lost: u64,
    reconnects: u64,
}

async fn recorded(args: &RecordArgs, shutdown: &Shutdown) -> Result<Text, RecordingError> {
    let host = &args.robot.robot;
    let primary = RobotAddress::new(host, args.robot.primary_port);
    let data = primary.with_port(args.robot.rtsi_port);
    let reading = calibrate::read(&primary, &args.out).await?;
    let model = reading.calibration.open()?;
    let mut rtsi = robot::connect(&data, args.rate).await?;
    let mut observer = RtsiStateMapper::for_recipe(rtsi.offered());
    let step_time = 1.0 / args.rate;

    // The first values say where the arm is and what its clock shows.
    let mut state = unknown_state(step_time);
    apply_primary_state(&mut state, &reading.state);
    let (first, values) = loop {
        if let RtsiMessage::Data(values) = rtsi.next().await? {
            break (observer.apply_packet(&mut state, &values), values);
        }
    };
    let since = SystemTime::now()
        .duration_since(SystemTime::UNIX_EPOCH)
        .unwrap_or_default();
    let sizes = RingCapacities {
        frames: 0,
        ..RingCapacities::default()
    };
    let (into, from) = motion_channel(sizes, &state);
    let setup = Setup {
        model: reading.calibration.model().to_owned(),
        calibration: Some(reading.calibration.to_toml()),
        home: known_joints(&state),
        tcp: reading.tcp.unwrap_or_default(),
        payload: state.payload,
        step_time,
        plant: ROBOT.to_owned(),
        clock: ROBOT.to_owned(),
        epoch_ns: u64::try_from(since.as_nanos()).unwrap_or(u64::MAX),
        ..Setup::default()
    };
    let path = args.out.display().to_string();
    let config = RecorderConfig {
        path: args.out.clone(),
        setup,
        model,
        obstacles: Vec::new(),
        extra: extra_topics(&observer, &rtsi),
        rotation: Rotation::default(),
        notes_wait: false,
        patience: PATIENCE,
        on_failure: Box::new(|error| {
            let text = text!("the recording has stopped: {error}", "记录已停止：{error}");
            tracing::error!("{}", language::shown(&text));
        }),
    };
    let records = from
        .records
        .ok_or_else(|| RecordingError::Failed(path.clone()))?;
    let (recorder, handle) = Recorder::start(config, records)?;
    shutdown.set_recording_closer(recorder.closer());
    let [major, minor, fix, _] = rtsi.version();
    let offered = rtsi.offered().len();
    language::say(&text!(
        "recording the {} at {primary}, controller {major}.{minor}.{fix}: {offered} of {} variables at {} Hz into \
         {path}",
        "正在记录 {primary} 处的 {}，控制器 {major}.{minor}.{fix}：{} 个变量中的 {offered} 个，{} Hz，写入 {path}",
        reading.calibration.model(),
        KNOWN_VARIABLES.len(),
        args.rate,
    ));

    let clock = Clock::new(first.timestamp.unwrap_or(0.0), step_time);
    let mut recording = RecordingSession {
        state,
        offered: rtsi.offered().to_vec(),
        observer,
        clock,
        tally: StreamStats::default(),
        into,
        handle,
    };
    recording.take(first, &values);
    if let Some(missing) = robot::not_offered(&rtsi) {
        let text = text!(
            "the controller does not offer {missing}",
            "控制器不提供 {missing}"
        );
        recording.log(LogLevel::Info, "record", text.english());
        language::say(&text);
    }

    let (sender, mut messages) = mpsc::channel(WAITING);
    tokio::pin! { let listening = robot::listen(primary, sender); }
    let (sender, mut news) = mpsc::channel(WAITING);
    tokio::pin! { let following = robot::follow(rtsi, data, args.rate, sender); }
    let until = args
        .duration
        .map(|seconds| Instant::now() + Duration::from_secs_f64(seconds));
    let end = async {
        match until {
            Some(until) => sleep_until(until).await,
            None => std::future::pending().await,
        }
    };
    tokio::pin!(end);
    loop {
        tokio::select! {
            () = shutdown.token().cancelled() => break,
            () = &mut end => break,
            // Both go on for as long as their receivers are here.
            () = &mut listening => {}
            () = &mut following => {}
            Some(told) = messages.recv() => recording.hear(&told),
            Some(news) = news.recv() => recording.follow(news),
        }
        if recorder.has_failed() {
            return Err(RecordingError::Failed(path));
        }
    }
    let left_out = recording.handle.notes_dropped();
    recorder.finish()?;
    let StreamStats {
        cycles,
        missing,
        out_of_order,
        lost,
        reconnects,
    } = recording.tally;
    let left_out = match left_out {
        0 => Text::verbatim(""),
        count => text!(", {count} messages left out", "，略去 {count} 条消息"),
    };
    Ok(text!(
        "{path}: {cycles} cycles, {missing} missing, {out_of_order} out of order left out, {lost} lost here, \
         {reconnects} reconnects{left_out}",
        "{path}：{cycles} 个周期，缺失 {missing} 个，乱序略去 {out_of_order} 个，本机丢失 {lost} 个，重新连接 {reconnects} 次{left_out}"
    ))
}

/// The topics beside those of every recording, in the order of [`OUTPUTS`] and [`STATES`].
fn extra_topics(observer: &RtsiStateMapper, rtsi: &RtsiClient) -> Vec<CustomTopic> {
    let topic = |name: &str, schema_name: &str, schema: String| CustomTopic {
        name: name.to_owned(),
        schema_name: schema_name.to_owned(),
        schema,
    };
    let outputs = outputs_schema(observer, rtsi.offered());
    vec![
        topic("/rtsi", "elite.RtsiOutputs", outputs),
        topic("/robot_state", "elite.RobotState", state_schema()),
    ]
}

/// What is known of the robot, on its way into the file.
struct RecordingSession {
    state: RobotState,
    /// The variables of the connection.
    offered: Vec<(String, RtsiType)>,
    observer: RtsiStateMapper,
    clock: Clock,
    tally: StreamStats,
    into: MotionEndpoint,
    handle: RecorderHandle,
}

impl RecordingSession {
    fn follow(&mut self, news: RtsiEvent) {
        match news {
            RtsiEvent::Arrival(RtsiMessage::Data(values)) => {
                let beside = self.observer.apply_packet(&mut self.state, &values);
                self.take(beside, &values);
            }
            RtsiEvent::Arrival(RtsiMessage::Text(level, text)) => {
                self.log(level_of(level), "RTSI", &text)
            }
            RtsiEvent::Gone(why) => {
                self.log(LogLevel::Warning, "record", &why.to_string());
                let text = text!("{why}; trying again", "{why}；正在重试");
                tracing::warn!("{}", language::shown(&text));
            }
            RtsiEvent::Again(offered) => {
                // Perhaps another controller, with other variables.
                self.observer = RtsiStateMapper::for_recipe(&offered);
                self.offered = offered;
                self.tally.reconnects += 1;
                self.clock.begin_anew();
                let text = text!("connected again", "已重新连接");
                self.log(LogLevel::Info, "record", text.english());
                tracing::info!("{}", language::shown(&text));
            }
        }
    }

    /// A packet of RTSI has been taken over into the state.
    fn take(&mut self, beside: PacketExtras, values: &[RtsiValue]) {
        let here = self.clock.begin + self.clock.now;
        let Some(missing) = self.clock.cycle_at(beside.timestamp.unwrap_or(here)) else {
            self.tally.out_of_order += 1;
            return;
        };
        let (cycle, time) = (self.clock.cycle, self.clock.now);
        (self.state.cycle, self.state.time) = (cycle, time);
        self.tally.missing += missing;
        self.tally.cycles += 1;
        let message = outputs_message(&self.observer, &self.offered, values);
        self.handle.extra(time, OUTPUTS, message);
        if let Some(images) = beside.registers {
            self.put(Record::Registers { cycle, images });
        }
        self.put(Record::Cycle(self.state));
    }

    fn put(&mut self, record: Record) {
        let ring = self.into.records.as_mut();
        if ring.is_none_or(|ring| ring.push(record).is_err()) {
            self.tally.lost += 1;
            self.state.records_lost += 1;
        }
    }

    /// Port 30001 says something.
    fn hear(&mut self, told: &Message) {
        match told {
            Message::Exception(exception) => tell(&self.handle, self.clock.now, exception),
            Message::State(told) => {
                apply_primary_state(&mut self.state, told);
                let message = state_message(told);
                self.handle.extra(self.clock.now, STATES, message);
            }
            Message::Unknown(_) => {}
        }
    }

    fn log(&self, level: LogLevel, source: &str, text: &str) {
        let text = Text::verbatim(text.to_owned());
        self.handle.log(self.clock.now, level, source, &text);
    }
}

/// Where a fresh controller would begin; the defaults for joints that are not known.
fn known_joints(state: &RobotState) -> JointPositions {
    let home = Setup::default().home;
    JointPositions(core::array::from_fn(|joint| match state.actual_q[joint] {
        q if q.is_finite() => q,
        _ => home[joint],
    }))
}
