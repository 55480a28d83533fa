//! How long the arm takes to rest, by what moves it and why it stops, as a table in Markdown.
//!
//! `cargo run -p motion --example stop_table`. Setpoints of an ideal CS66 at 4 ms, stopped a second after the command
//! (in the blend: in the middle of it); times from the cycle in which the stop is taken. *Joints* is the shortest time
//! to rest of joints that brake one by one.
#![allow(
    clippy::expect_used,
    reason = "an example that cannot go on should say where"
)]

use kinematics::{JointSpeeds, RobotModel, RpyPose};
use motion::brake::JointStopMotion;
use motion::modes::encoder::Belt;
use motion::setpoint::Setpoint;
use motion::{
    ControlLoop, CycleConfig, CycleTiming, InputPair, MotionLimits, PlantKind, SafetyInputs,
};
use motion_api::{
    CommandId, CommandKind, Event, MachineCommand, MotionCommand, OffsetAxes, OnlineCommand,
    Origin, OverlayCommand, RingCapacities, RobotState, ScriptEndpoint, SettingCommand,
    motion_channel,
};

const STEP: f64 = 0.004;

/// Names of what moves the arm, and after which time it is stopped, s.
const MODES: [(&str, f64); 11] = [
    ("movej", 1.0),
    ("movej, t = 10", 1.0),
    ("blend of two movej, a = 0.1", 3.36),
    ("movel", 0.6),
    ("movel, t = 10", 1.0),
    ("speedj, a = 0.2", 1.0),
    ("speedl, a = 0.2", 0.8),
    ("servoj", 1.0),
    ("belt", 1.0),
    ("movel on a belt", 1.0),
    ("movel under an offset", 0.6),
];

const STOPS: [(&str, CommandKind); 6] = [
    (
        "safeguard",
        CommandKind::Setting(SettingCommand::SetDigitalInput {
            index: 16,
            level: true,
        }),
    ),
    (
        "protective",
        CommandKind::Machine(MachineCommand::ProtectiveStop),
    ),
    (
        "stop task",
        CommandKind::Machine(MachineCommand::Stop {
            only: CommandId::NONE,
        }),
    ),
    ("power off", CommandKind::Machine(MachineCommand::PowerOff)),
    ("pause", CommandKind::Machine(MachineCommand::Pause)),
    (
        "stopj(8)",
        CommandKind::Online(OnlineCommand::StopJ { acceleration: 8.0 }),
    ),
];

struct Arm {
    cycle: ControlLoop,
    script: ScriptEndpoint,
    limits: MotionLimits,
    next: Option<CommandKind>,
}

impl Arm {
    fn new() -> Self {
        let config = CycleConfig {
            plant: PlantKind::Ideal,
            belts: [
                Some(Belt {
                    encoder: 0,
                    ticks_per_second: 150.0,
                    start_at: 0.0,
                }),
                None,
            ],
            safety_inputs: SafetyInputs {
                safeguard_stop: Some(InputPair {
                    pair: 0,
                    is_active_low: false,
                }),
                ..SafetyInputs::default()
            },
            ..CycleConfig::new(RobotModel::built_in("cs66").expect("a built-in arm"))
        };
        let limits = config.resolve().expect("the limits of the arm");
        let sizes = RingCapacities {
            records: None,
            ..RingCapacities::default()
        };
        let (motion, script) = motion_channel(sizes, &config.first_state());
        let cycle = ControlLoop::new(config, motion).expect("a controller");
        let mut arm = Self {
            cycle,
            script,
            limits,
            next: None,
        };
        arm.tick();
        arm
    }

    fn now(&self) -> RobotState {
        self.script.snapshot.read()
    }

    fn send(&self, kind: impl Into<CommandKind>) {
        self.script
            .commands
            .send(Origin::default(), kind)
            .expect("room");
    }

    fn tick(&mut self) {
        self.cycle.tick(CycleTiming::default());
        while let Some(event) = self.script.events.next_event() {
            if let Event::ReadyForNext { .. } = event
                && let Some(next) = self.next.take()
            {
                self.send(next);
            }
        }
    }

    fn seconds(&mut self, seconds: f64) {
        (0..(seconds / STEP).round() as u32).for_each(|_| self.tick());
    }

    fn line(&self, duration: f64) -> CommandKind {
        let mut target = self.now().target_tcp_pose;
        target.xyz[1] += 0.25;
        CommandKind::Motion(MotionCommand::MoveL {
            target,
            acceleration: 1.2,
            speed: 0.25,
            duration,
            radius: 0.0,
        })
    }

    fn joints(
        &self,
        joint: usize,
        by: f64,
        (acceleration, duration, radius): (f64, f64, f64),
    ) -> CommandKind {
        let mut target = self.now().target_q;
        target[0] += 0.6;
        target[joint] += by;
        CommandKind::Motion(MotionCommand::MoveJ {
            target,
            acceleration,
            speed: 1.05,
            duration,
            radius,
        })
    }

    fn begin(&mut self, mode: &str) {
        match mode {
            "movej" => self.send(self.joints(0, 0.6, (1.4, 0.0, 0.0))),
            "movej, t = 10" => self.send(self.joints(0, 1.4, (1.4, 10.0, 0.0))),
            "blend of two movej, a = 0.1" => {
                self.next = Some(self.joints(2, 0.8, (0.1, 0.0, 0.0)));
                self.send(self.joints(0, 0.0, (0.1, 0.0, 0.1)));
            }
            "movel" => self.send(self.line(0.0)),
            "movel, t = 10" => self.send(self.line(10.0)),
            "speedj, a = 0.2" => self.send(OnlineCommand::SpeedJ {
                speeds: JointSpeeds([0.7, 0.0, 0.0, 0.0, 0.3, 0.0]),
                acceleration: 0.2,
                duration: None,
            }),
            "speedl, a = 0.2" => self.send(OnlineCommand::SpeedL {
                speed: [0.0, 0.2, 0.0, 0.0, 0.0, 0.0],
                acceleration: 0.2,
                rotation_acceleration: 1.0,
                duration: None,
            }),
            "servoj" => {
                let mut target = self.now().target_q;
                target[0] += 0.6;
                self.send(OnlineCommand::ServoJ {
                    target,
                    duration: 5.0,
                    lookahead: 0.1,
                    gain: 300.0,
                });
            }
            "belt" | "movel on a belt" => {
                self.send(OverlayCommand::TrackConveyorLinear {
                    direction: [0.0, 1.0, 0.0],
                    ticks_per_meter: 1000.0,
                    encoder: 0,
                });
                self.seconds(0.4);
                if mode != "belt" {
                    let mut target = self.now().path_pose;
                    target.xyz[2] -= 0.15;
                    self.send(MotionCommand::MoveL {
                        target,
                        acceleration: 1.2,
                        speed: 0.1,
                        duration: 0.0,
                        radius: 0.0,
                    });
                }
            }
            _ => {
                self.send(OverlayCommand::PathOffsetEnable);
                self.send(OverlayCommand::PathOffsetSet {
                    offset: RpyPose::from_array([0.0, 0.0, 0.03, 0.0, 0.0, 0.0]),
                    axes: OffsetAxes::Base,
                });
                self.send(self.line(0.0));
            }
        }
    }

    /// Time until the joints stand, s.
    fn time_to_rest(&mut self) -> f64 {
        self.next = None;
        for cycle in 0..500 {
            self.tick();
            let state = self.now();
            if state.target_qd == JointSpeeds::ZERO && state.target_qdd.0 == [0.0; 6] {
                return f64::from(cycle) * STEP;
            }
        }
        f64::INFINITY
    }
}

fn main() {
    print!("| moved by | joints |");
    STOPS.iter().for_each(|(name, _)| print!(" {name} |"));
    print!("\n|---|---|");
    STOPS.iter().for_each(|_| print!("---|"));
    println!();
    for (mode, after) in MODES {
        let stopped = |kind: Option<CommandKind>| {
            let mut arm = Arm::new();
            arm.begin(mode);
            arm.seconds(after);
            let Some(kind) = kind else {
                let RobotState {
                    target_q,
                    target_qd,
                    target_qdd,
                    ..
                } = arm.now();
                let (q, qd, qdd) = (target_q, target_qd, target_qdd);
                return JointStopMotion::new(&Setpoint { q, qd, qdd }, &arm.limits).longest();
            };
            arm.send(kind);
            arm.time_to_rest()
        };
        print!("| {mode} | {:.3} |", stopped(None));
        for (_, kind) in STOPS {
            let time = stopped(Some(kind));
            if time.is_finite() {
                print!(" {time:.3} |");
            } else {
                print!(" rides on |");
            }
        }
        println!();
    }
}
