//! Conversations as the SDK holds them, over an in-memory stream.

use parking_lot::Mutex;

use kinematics::JointPositions;
use motion_api::{RobotState, SafetyMode};
use proptest::prelude::*;
use tokio::io::{DuplexStream, duplex};
use tokio::task::JoinHandle;

use super::*;
use crate::ports::dashboard::codec::REPLY_BYTES_MAX;
use crate::ports::description::RobotDescription;

/// A robot that does at once what it is told.
struct Fake {
    description: RobotDescription,
    robot: Mutex<Robot>,
    gate: Gate,
}

struct Robot {
    state: RobotState,
    task: TaskStatus,
    control: ControlMode,
    loaded: Option<String>,
    configuration: Option<String>,
    orders: Vec<DashboardOrder>,
}

/// Lines for the log wait for a permit of this, if it is there.
type Gate = Option<std::sync::Arc<tokio::sync::Semaphore>>;

impl Default for Fake {
    fn default() -> Self {
        let mut state = RobotState::at_start(JointPositions::ZERO, 0.004);
        state.robot_mode = RobotMode::PowerOff;
        Self {
            description: RobotDescription::cs66(),
            robot: Mutex::new(Robot {
                state,
                task: TaskStatus::Stopped,
                control: ControlMode::Remote,
                loaded: None,
                configuration: None,
                orders: Vec::new(),
            }),
            gate: None,
        }
    }
}

impl DashboardBackend for Fake {
    fn state(&self) -> RobotState {
        self.robot.lock().state
    }
    fn task_status(&self) -> TaskStatus {
        self.robot.lock().task
    }
    fn description(&self) -> &RobotDescription {
        &self.description
    }
    fn control(&self) -> ControlMode {
        self.robot.lock().control
    }
    fn loaded_task(&self) -> Option<String> {
        self.robot.lock().loaded.clone()
    }
    fn loaded_configuration(&self) -> Option<String> {
        self.robot.lock().configuration.clone()
    }
    async fn order(&self, order: DashboardOrder) {
        if let (DashboardOrder::Log(_), Some(gate)) = (&order, &self.gate) {
            gate.acquire().await.unwrap().forget();
        }
        let mut robot = self.robot.lock();
        match &order {
            DashboardOrder::PowerOn => robot.state.robot_mode = RobotMode::Idle,
            DashboardOrder::PowerOff => robot.state.robot_mode = RobotMode::PowerOff,
            DashboardOrder::ReleaseBrakes => robot.state.robot_mode = RobotMode::Running,
            DashboardOrder::RestartSafetyBoard => robot.state.safety_mode = SafetyMode::Normal,
            DashboardOrder::SetSpeed(fraction) => robot.state.target_speed_fraction = *fraction,
            DashboardOrder::Control(mode) => robot.control = *mode,
            DashboardOrder::Pause => robot.task = TaskStatus::Paused,
            DashboardOrder::Stop => robot.task = TaskStatus::Stopped,
            _ => {}
        }
        robot.orders.push(order);
    }
    async fn load_task(&self, path: &str) -> Result<(), String> {
        if path.contains("..") {
            return Err(format!("{path} leads out of the task folder"));
        }
        self.robot.lock().loaded = Some(path.to_owned());
        Ok(())
    }
    async fn load_configuration(&self, path: &str) -> Result<(), String> {
        self.robot.lock().configuration = Some(path.to_owned());
        Ok(())
    }
    fn plays_loaded_task(&self) -> bool {
        self.robot.lock().task == TaskStatus::Running
    }
    async fn play(&self) -> Result<(), messages::Text> {
        let mut robot = self.robot.lock();
        if robot.loaded.is_none() {
            return Err(messages::text!("no task is loaded", "没有载入任务"));
        }
        robot.task = TaskStatus::Running;
        Ok(())
    }
    async fn variable(&self, name: &str) -> Result<String, String> {
        match name {
            "a" => Ok("[1, 2]".to_owned()),
            _ => Err(format!("variable {name} is undefined")),
        }
    }
    async fn set_variable(&self, _: &str, _: &str) -> Result<(), String> {
        Ok(())
    }
}

struct Rig {
    robot: std::sync::Arc<Fake>,
    client: DuplexStream,
    session: JoinHandle<io::Result<()>>,
}

async fn rig() -> Rig {
    rig_behind(None).await
}

async fn rig_behind(gate: Gate) -> Rig {
    let (client, server) = duplex(256 * 1024);
    let robot = std::sync::Arc::new(Fake {
        gate,
        ..Fake::default()
    });
    let session = tokio::spawn({
        let robot = robot.clone();
        async move { serve(server, ClientId(1), &*robot).await }
    });
    let mut rig = Rig {
        robot,
        client,
        session,
    };
    let greeting = rig.read().await;
    assert!(
        greeting.starts_with("EliRobot dashboard shell, version "),
        "{greeting}"
    );
    rig
}

impl Rig {
    /// One reply: whatever one write brought, which is what the SDK takes for it.
    async fn read(&mut self) -> String {
        let mut buffer = vec![0; 4096];
        let count = self.client.read(&mut buffer).await.unwrap();
        String::from_utf8(buffer[..count].to_vec()).unwrap()
    }

    async fn ask(&mut self, command: &str) -> String {
        self.client
            .write_all(format!("{command}\n").as_bytes())
            .await
            .unwrap();
        self.read().await
    }

    async fn talk(&mut self, conversation: &[(&str, &str)]) {
        for (command, reply) in conversation {
            assert_eq!(self.ask(command).await, format!("{reply}\r\n"), "{command}");
        }
    }
}

#[tokio::test]
async fn the_session_of_the_protocol_page_goes_as_printed() {
    let mut rig = rig().await;
    rig.talk(&[
        ("echo", "Hello ELITE ROBOTS."),
        ("robotMode", "robotMode: POWER_OFF"),
        ("robotControl -on", "Powering on"),
        ("robotMode", "robotMode: IDLE"),
        ("brakeRelease", "Brake Releasing"),
        ("robotMode", "robotMode: RUNNING"),
        ("brakeRelease", "Brake is released."),
        ("task", "Relative path:"),
        ("play", "Failed to execute: play (no task is loaded)"),
        ("task -p test.task", "Loaded task: test.task"),
        ("task", "Relative path:test.task"),
        ("play", "Starting task"),
        ("play", "Failed to execute: play"),
        ("task -s", "Task is running"),
        ("task -r", "Task is running"),
        ("pause", "Pausing task"),
        ("pause", "Failed to execute: pause"),
        ("task -s", "Task is paused"),
        ("task -r", "Task is not running"),
        ("play", "Starting task"),
        ("stop", "Stopping task"),
        ("stop", "Stopping task"),
        ("task -s", "Task is stopped"),
        ("robotControl -off", "Powering off"),
        ("quit", "Disconnected"),
    ])
    .await;
    assert_eq!(rig.read().await, "", "then the connection is closed");
    rig.session.await.unwrap().unwrap();
}

#[tokio::test]
async fn the_getters_answer_what_the_sdk_matches() {
    let mut rig = rig().await;
    rig.talk(&[
        ("safety -m", "Safety mode: NORMAL"),
        ("safety -s", "Safety status: NORMAL"),
        ("safety -r", "Restarting safety board"),
        ("unlockProtectiveStop", "Protective stop unlocking..."),
        ("closeSafetyDialog", "closing safety dialog"),
        ("speed -v 50", "Setting speed: 50"),
        ("speed", "speed: 50"),
        ("version", "2.15.0.0"),
        ("robot -t", "CS66"),
        ("robot -s", "SIM-6206"),
        ("robot -id", "1"),
        (r"log -a a\nb", "Log has been added."),
        ("popup -shello", "Showing popup with text:hello"),
        ("popup -c", "Closing popup"),
        ("task -ss", "Task is saved"),
        ("configuration", "configuration: Relative path:"),
        ("configuration -p default.configuration", "Loading Configuration : default.configuration"),
        ("configuration", "configuration: Relative path:default.configuration"),
        ("configuration -s", "configuration is not modified"),
        ("variable -get a", "[1, 2]"),
        ("variable -get b", "Error: variable b is undefined"),
        ("variable -set a 3", "a, 3"),
        ("clear -a", "clear alarm"),
        ("task -p ../x", "Failed to load the task: ../x leads out of the task folder"),
        ("nonsense", "Command [nonsense] is not found. Please use \"help\"."),
        (
            "status",
            "Target Speed Fraction: 50\r\nRobotMode: POWER_OFF\r\nSafetyMode: NORMAL\r\nRunningStatus: STOP",
        ),
    ])
    .await;
    let orders = rig.robot.robot.lock().orders.clone();
    assert!(orders.contains(&DashboardOrder::Log("a\nb".to_owned())));
    assert!(orders.contains(&DashboardOrder::ShowPopup("hello".to_owned())));
}

#[tokio::test]
async fn without_remote_control_tasks_are_not_touched() {
    let mut rig = rig().await;
    rig.talk(&[
        ("remoteControl -s", "true"),
        ("remoteControl -off", "Remote control is off"),
        ("remoteControl -s", "false"),
        ("robotMode", "robotMode: POWER_OFF"),
    ])
    .await;
    let words = [
        "play",
        "pause",
        "stop",
        "task -p a",
        "configuration -p a",
        "variable -set a 1",
    ];
    for word in words {
        let name = word.split(' ').next().unwrap();
        let reply = rig.ask(word).await;
        assert_eq!(
            reply,
            format!(
                "Command [{name}] is not supported in local control mode. Please close local control mode first.\r\n"
            )
        );
    }
    rig.talk(&[
        ("remoteControl -on", "Remote control is on"),
        ("stop", "Stopping task"),
    ])
    .await;
}

#[tokio::test]
async fn where_remote_control_is_disabled_the_dashboard_does_not_enable_it() {
    let mut rig = rig().await;
    rig.robot.robot.lock().control = ControlMode::Mixed;
    for word in ["play", "remoteControl -on", "remoteControl -off"] {
        let reply = rig.ask(word).await;
        let part = "is not supported while remote control is disabled in the settings";
        assert!(reply.contains(part), "{reply}");
    }
    rig.talk(&[
        ("remoteControl -s", "false"),
        ("robotMode", "robotMode: POWER_OFF"),
    ])
    .await;
}

/// Sends lines behind one that is being carried out for ever; gives the gate that ends it.
async fn behind_a_slow_line(
    task: TaskStatus,
    lines: &str,
) -> (Rig, std::sync::Arc<tokio::sync::Semaphore>) {
    let gate = std::sync::Arc::new(tokio::sync::Semaphore::new(0));
    let mut rig = rig_behind(Some(gate.clone())).await;
    {
        let mut robot = rig.robot.robot.lock();
        robot.task = task;
        robot.loaded = Some("a".to_owned());
    }
    let all = format!("log -a slow\n{lines}");
    rig.client.write_all(all.as_bytes()).await.unwrap();
    for _ in 0..200 {
        tokio::task::yield_now().await;
    }
    (rig, gate)
}

fn orders(rig: &Rig) -> Vec<DashboardOrder> {
    rig.robot.robot.lock().orders.clone()
}

impl Rig {
    async fn replies(&mut self, count: usize) -> Vec<String> {
        let (mut text, mut lines) = (String::new(), 0);
        while lines < count {
            let more = self.read().await;
            lines += more.matches('\n').count();
            text.push_str(&more);
        }
        text.lines().map(str::to_owned).collect()
    }
}

#[tokio::test]
async fn lines_of_one_write_are_begun_together_and_answered_in_order() {
    let lines = "robotControl -on\nspeed -v 50\nrobotMode\n";
    let (mut rig, gate) = behind_a_slow_line(TaskStatus::Stopped, lines).await;
    assert_eq!(
        orders(&rig),
        [DashboardOrder::PowerOn, DashboardOrder::SetSpeed(0.5)]
    );
    gate.add_permits(1);
    assert_eq!(
        rig.replies(4).await,
        [
            "Log has been added.",
            "Powering on",
            "Setting speed: 50",
            "robotMode: IDLE"
        ]
    );
    // What ends the connection waits for the replies before it.
    let gate = std::sync::Arc::new(tokio::sync::Semaphore::new(0));
    let mut rig = rig_behind(Some(gate.clone())).await;
    let lines = b"log -a slow\nquit\necho\n";
    rig.client.write_all(lines).await.unwrap();
    for _ in 0..200 {
        tokio::task::yield_now().await;
    }
    gate.add_permits(1);
    assert_eq!(
        rig.replies(2).await,
        ["Log has been added.", "Disconnected"]
    );
    rig.session.await.unwrap().unwrap();
}

#[tokio::test]
async fn a_stop_behind_slow_lines_acts_at_once_and_is_answered_in_its_turn() {
    let lines = "log -a b\nplay\nspeed\nstop\necho\n";
    let (mut rig, gate) = behind_a_slow_line(TaskStatus::Running, lines).await;
    // At once, and once more behind the `play` before it.
    assert_eq!(orders(&rig), [DashboardOrder::Stop, DashboardOrder::Stop]);
    assert_eq!(rig.robot.task_status(), TaskStatus::Stopped);
    gate.add_permits(2);
    let said = rig.replies(6).await;
    assert_eq!(said[4..], ["Stopping task", "Hello ELITE ROBOTS."]);
    assert_eq!(rig.robot.task_status(), TaskStatus::Stopped);
}

#[tokio::test]
async fn a_play_that_has_not_begun_does_not_begin_when_a_stop_is_behind_it() {
    let lines = format!("{}play\nstop\n", "echo\n".repeat(BEGUN_MAX));
    let (mut rig, gate) = behind_a_slow_line(TaskStatus::Running, &lines).await;
    assert_eq!(orders(&rig), [DashboardOrder::Stop]);
    gate.add_permits(1);
    let said = rig.replies(BEGUN_MAX + 3).await;
    let [.., play, stop] = &said[..] else {
        panic!("{said:?}")
    };
    assert!(play.starts_with("Failed to execute: play ("), "{said:?}");
    assert_eq!(stop, "Stopping task");
}

#[tokio::test]
async fn a_pause_behind_slow_lines_acts_at_once_on_what_runs() {
    let (mut rig, gate) = behind_a_slow_line(TaskStatus::Running, "pause\nplay\n").await;
    assert_eq!(orders(&rig), [DashboardOrder::Pause, DashboardOrder::Pause]);
    gate.add_permits(1);
    let said = rig.replies(3).await;
    assert_eq!(said[1..], ["Pausing task", "Starting task"]);
    assert_eq!(rig.robot.task_status(), TaskStatus::Running);
}

#[tokio::test]
async fn play_and_stop_or_pause_in_one_packet_have_their_turns() {
    for (order, reply, after) in [
        ("stop", "Stopping task", TaskStatus::Stopped),
        ("pause", "Pausing task", TaskStatus::Paused),
    ] {
        let mut rig = rig().await;
        rig.robot.robot.lock().loaded = Some("a".to_owned());
        let lines = format!("play\n{order}\n");
        rig.client.write_all(lines.as_bytes()).await.unwrap();
        assert_eq!(rig.replies(2).await, ["Starting task", reply]);
        assert_eq!(rig.robot.task_status(), after);
    }
}

#[tokio::test]
async fn a_stop_acts_behind_more_lines_than_there_is_room_for() {
    let many = 100_000;
    let lines = "speed -v 50\n".repeat(many);
    let (mut rig, gate) = behind_a_slow_line(TaskStatus::Running, "").await;
    rig.client.write_all(lines.as_bytes()).await.unwrap();
    rig.client.write_all(b"stop\nstop\n").await.unwrap();
    while !orders(&rig).contains(&DashboardOrder::Stop) {
        tokio::task::yield_now().await;
    }
    gate.add_permits(1);
    let said = rig.replies(many + 3).await;
    assert_eq!(said[many], super::TOO_MANY_WAIT);
    assert_eq!(said[many + 1..], ["Stopping task"; 2]);
}

#[tokio::test]
async fn a_stop_acts_while_the_client_reads_no_replies() {
    let mut rig = rig().await;
    rig.robot.robot.lock().task = TaskStatus::Running;
    let lines = "version\n".repeat(100_000);
    rig.client.write_all(lines.as_bytes()).await.unwrap();
    rig.client.write_all(b"stop\n").await.unwrap();
    while orders(&rig).is_empty() {
        tokio::task::yield_now().await;
    }
    assert_eq!(orders(&rig), [DashboardOrder::Stop]);
}

#[tokio::test]
async fn a_long_line_is_answered_and_the_connection_lives_on() {
    let mut rig = rig().await;
    rig.talk(&[
        (&"x".repeat(70_000), "The line is longer than 64 KiB."),
        ("echo", "Hello ELITE ROBOTS."),
    ])
    .await;
    let reply = rig.ask(&format!("popup -s{}", "x".repeat(2000))).await;
    assert_eq!(reply.len(), REPLY_BYTES_MAX);
}

#[tokio::test]
async fn shutdown_ends_the_connection() {
    let mut rig = rig().await;
    rig.talk(&[("shutdown", "Shutting down"), ("", "")][..1])
        .await;
    assert_eq!(rig.read().await, "");
    assert_eq!(rig.robot.robot.lock().orders, [DashboardOrder::Shutdown]);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]
    #[test]
    fn any_bytes_leave_the_session_alive(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        runtime.block_on(async {
            let mut rig = rig().await;
            rig.client.write_all(b"echo\n").await.unwrap();
            rig.client.write_all(&bytes).await.unwrap();
            rig.client.write_all(b"\nversion\n").await.unwrap();
            let mut all = String::new();
            while !all.ends_with("2.15.0.0\r\n") {
                let reply = rig.read().await;
                assert!(!reply.is_empty());
                all.push_str(&reply);
            }
        });
    }
}
