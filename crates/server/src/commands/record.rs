//! `eliteserver record`: what a robot somewhere else does, into a recording like our own.
//!
//! Owns the loop between the robot's ports and the recorder: gaps, reconnects, what was left out, and the summary. What
//! the packets mean is `robot-client`'s business, how they are written the recorder's.

use std::process::ExitCode;
use std::time::{Duration, SystemTime};

use kinematics::{CalibrationError, JointPositions};
use motion_api::{BorderSizes, Record, RobotState, border};
use recorder::{LogLevel, RecordError, Recorder, RecorderConfig, RecorderHandle, Rotation, Setup};
use robot_client::calibrate::{self, CalibrateError};
use robot_client::observed::{Beside, WANTED, observe, unknown_state};
use robot_client::{Arrival, Primary, RobotAddress, Rtsi, RtsiError};
use thiserror::Error;
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep, sleep_until};
use wire::primary::{Exception, Level, Message, Numbered, RobotException, Source};
use wire::rtsi::TextLevel;

use crate::cli::RecordArgs;
use crate::logging;
use crate::shutdown::Shutdown;
use crate::start_configuration::ROBOT;

/// Exit status without a recording.
const NO_RECORDING: u8 = 2;
/// Between two attempts to reach a robot that is gone.
const RETRY: Duration = Duration::from_secs(1);
/// A disk that takes nothing for so long is given up.
const PATIENCE: Duration = Duration::from_secs(10);
/// Messages of port 30001 that wait.
const WAITING: usize = 256;

/// Why there is no recording; each is a sentence.
#[derive(Debug, Error)]
enum RecordingError {
    #[error("cannot start: {0}")]
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
    Failed(String),
}

/// Exit status: 0 recorded, 2 no connection or no recording.
pub fn record(args: &RecordArgs) -> ExitCode {
    let recorded = Shutdown::start(0)
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
    match recorded {
        Ok(summary) => {
            logging::say(&summary);
            ExitCode::SUCCESS
        }
        Err(error) => {
            logging::say(&format!("eliteserver: {error}"));
            ExitCode::from(NO_RECORDING)
        }
    }
}

/// What became of the stream.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    cycles: u64,
    missing: u64,
    out_of_order: u64,
    lost: u64,
    reconnects: u64,
}

async fn recorded(args: &RecordArgs, shutdown: &Shutdown) -> Result<String, RecordingError> {
    let host = &args.robot.robot;
    let primary = RobotAddress::new(host, args.robot.primary_port);
    let data = primary.with_port(args.robot.rtsi_port);
    let reading = calibrate::read(&primary, &args.out).await?;
    let model = reading.calibration.open()?;
    let mut rtsi = Rtsi::connect(&data, args.rate, WANTED).await?;
    let offered = rtsi.offered().len();
    let step_time = 1.0 / args.rate;

    // The first values say where the arm is and what its clock shows.
    let mut state = unknown_state(step_time);
    let first = loop {
        if let Arrival::Data(values) = rtsi.next().await? {
            break observe(&mut state, rtsi.offered(), &values);
        }
    };
    let begin = first.timestamp.unwrap_or(0.0);
    let since = SystemTime::now()
        .duration_since(SystemTime::UNIX_EPOCH)
        .unwrap_or_default();
    let sizes = BorderSizes {
        frames: 0,
        ..BorderSizes::default()
    };
    let (mut into, from) = border(sizes, &state);
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
        rotation: Rotation::default(),
        notes_wait: false,
        patience: PATIENCE,
        on_failure: Box::new(|error| tracing::error!("the recording has stopped: {error}")),
    };
    let records = from
        .records
        .ok_or_else(|| RecordingError::Failed(path.clone()))?;
    let (recorder, handle) = Recorder::start(config, records)?;
    shutdown.close_in_any_case(recorder.closer());
    let [major, minor, fix, _] = rtsi.version();
    logging::say(&format!(
        "recording the {} at {primary}, controller {major}.{minor}.{fix}: {offered} of {} variables at {} Hz into {path}",
        reading.calibration.model(),
        WANTED.len(),
        args.rate,
    ));

    let (sender, mut messages) = mpsc::channel(WAITING);
    tokio::pin! { let listening = listened(primary, sender); }
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
    let mut clock = Clock::new(begin, step_time);
    let mut tally = Tally::default();
    take(&mut state, first, &mut clock, &mut tally, &mut into);
    let not_offered = not_offered(&rtsi);
    if !not_offered.is_empty() {
        let text = format!("the controller does not offer {not_offered}");
        handle.log(clock.now, LogLevel::Info, "record", &text);
        logging::say(&text);
    }
    let mut stream = Some(rtsi);
    loop {
        tokio::select! {
            () = shutdown.token().cancelled() => break,
            () = &mut end => break,
            () = &mut listening => {}
            Some(told) = messages.recv() => tell(&handle, clock.now, &told),
            arrival = next(&mut stream, &data, args.rate) => match arrival {
                Ok(Some(Arrival::Data(values))) => {
                    let Some(rtsi) = &stream else { continue };
                    let beside = observe(&mut state, rtsi.offered(), &values);
                    take(&mut state, beside, &mut clock, &mut tally, &mut into);
                }
                Ok(Some(Arrival::Text(level, text))) => {
                    handle.log(clock.now, level_of(level), "RTSI", &text);
                }
                Ok(None) => {
                    tally.reconnects += 1;
                    clock.begin_anew();
                    handle.log(clock.now, LogLevel::Info, "record", "connected again");
                    tracing::info!("connected again");
                }
                Err(error) => {
                    let text = error.to_string();
                    handle.log(clock.now, LogLevel::Warning, "record", &text);
                    tracing::warn!("{text}; trying again");
                    stream = None;
                }
            },
        }
        if recorder.has_failed() {
            return Err(RecordingError::Failed(path));
        }
    }
    recorder.finish()?;
    let Tally {
        cycles,
        missing,
        out_of_order,
        lost,
        reconnects,
    } = tally;
    Ok(format!(
        "{path}: {cycles} cycles, {missing} missing, {out_of_order} out of order left out, {lost} lost here, {reconnects} reconnects"
    ))
}

/// Variables that a recording would hold and the controller does not have.
fn not_offered(rtsi: &Rtsi) -> String {
    let has = |wanted: &str| rtsi.offered().iter().any(|(name, _)| *name == wanted);
    let missing = WANTED.iter().copied().filter(|name| !has(name));
    missing.collect::<Vec<_>>().join(", ")
}

/// The next arrival; without a stream, a new one: `None`. Never returns while there is none.
async fn next(
    stream: &mut Option<Rtsi>,
    address: &RobotAddress,
    rate: f64,
) -> Result<Option<Arrival>, RtsiError> {
    if let Some(rtsi) = stream {
        return rtsi.next().await.map(Some);
    }
    loop {
        sleep(RETRY).await;
        if let Ok(rtsi) = Rtsi::connect(address, rate, WANTED).await {
            *stream = Some(rtsi);
            return Ok(None);
        }
    }
}

/// Times of the robot's clock as times that only grow, counted from the first.
struct Clock {
    begin: f64,
    step_time: f64,
    now: f64,
    cycle: u64,
    /// When the last cycle came, to go on from if the robot's clock begins anew.
    came: Instant,
    is_anew: bool,
}

impl Clock {
    fn new(begin: f64, step_time: f64) -> Self {
        Self {
            begin,
            step_time,
            now: 0.0,
            cycle: 0,
            came: Instant::now(),
            is_anew: false,
        }
    }

    /// The connection was gone: the controller may have been, too.
    fn begin_anew(&mut self) {
        self.is_anew = true;
    }

    /// Time and number of the cycle with this time stamp, and how many are missing before it; `None` if it is not after
    /// the last.
    fn cycle_at(&mut self, timestamp: f64) -> Option<u64> {
        if !timestamp.is_finite() {
            return None;
        }
        let gone = self.came.elapsed().as_secs_f64();
        if self.is_anew && (timestamp - self.begin - self.now - gone).abs() > 1.0 {
            // Another clock: the time that has passed here stands for it.
            self.begin = timestamp - self.now - gone;
        }
        self.is_anew = false;
        let now = timestamp - self.begin + self.step_time;
        let steps = ((now - self.now) / self.step_time).round();
        if steps < 1.0 {
            return None;
        }
        self.came = Instant::now();
        self.now = now;
        self.cycle += steps as u64;
        Some(steps as u64 - 1)
    }
}

fn take(
    state: &mut RobotState,
    beside: Beside,
    clock: &mut Clock,
    tally: &mut Tally,
    into: &mut motion_api::MotionEnd,
) {
    let timestamp = beside.timestamp.unwrap_or(clock.begin + clock.now);
    let Some(missing) = clock.cycle_at(timestamp) else {
        tally.out_of_order += 1;
        return;
    };
    (state.cycle, state.time) = (clock.cycle, clock.now);
    tally.missing += missing;
    tally.cycles += 1;
    let ring = into.records.as_mut();
    if ring.is_none_or(|ring| ring.push(Record::Cycle(*state)).is_err()) {
        tally.lost += 1;
        state.records_lost += 1;
    }
}

/// Listens to port 30001 for as long as there is somebody who takes it; comes back to a robot that was gone.
async fn listened(address: RobotAddress, sender: mpsc::Sender<RobotException>) {
    loop {
        if let Ok(mut robot) = Primary::connect(&address).await {
            while let Ok(message) = robot.next().await {
                if let Message::Exception(exception) = message {
                    // Of more than there is room for, the rest is left out: the robot sends few.
                    let _ = sender.try_send(exception);
                }
            }
        }
        sleep(RETRY).await;
    }
}

fn tell(handle: &RecorderHandle, time: f64, told: &RobotException) {
    let (level, text) = match &told.exception {
        Exception::Script { line, column, text } => {
            // What happened stands in the last line of a report; whoever reads one line reads that.
            let what = text.lines().rfind(|line| !line.trim().is_empty());
            let report = match text.lines().count() {
                0 | 1 => String::new(),
                _ => format!("\n{text}"),
            };
            let what = what.unwrap_or_default();
            let text = format!("line {line}, column {column}: {what}{report}");
            (LogLevel::Error, text)
        }
        Exception::Robot {
            code,
            sub_code,
            level,
            data,
        } => {
            let level = match level {
                Level::Info => LogLevel::Info,
                Level::Warning => LogLevel::Warning,
                Level::Error | Level::Fatal => LogLevel::Error,
            };
            let (code, sub_code) = (*code, *sub_code);
            let numbered = Numbered {
                code,
                sub_code,
                data,
            };
            (level, numbered.to_string())
        }
    };
    handle.log(time, level, Source::name(told.source), &text);
}

fn level_of(level: TextLevel) -> LogLevel {
    match level {
        TextLevel::Exception | TextLevel::Error => LogLevel::Error,
        TextLevel::Warning => LogLevel::Warning,
        TextLevel::Info => LogLevel::Info,
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
