//! Random programs: what a robot is told in a few seconds of work, drawn from a seed.
//!
//! Owns what programs look like; running and judging them is elsewhere. The same seed and arm give the same program.

use core::f64::consts::PI;

use kinematics::{JointPositions, JointSpeeds, Payload, Pose, RobotModel, RpyPose};
use motion::modes::encoder::Belt;
use motion::{CycleConfig, InputPair, LimitOverrides, PlantKind, SafetyInputs};
use motion_api::{CommandKind, MotionCommand, OnlineCommand, OverlayCommand};
use nalgebra::Vector3;

use crate::common::draw::{Draw, fold};
use crate::common::ideal;

/// One program and the robot it runs on.
#[derive(Clone, Debug)]
pub struct Program {
    pub model: &'static str,
    pub step_time: f64,
    pub start: JointPositions,
    pub tcp: RpyPose,
    pub payload_kg: f64,
    pub limits: LimitOverrides,
    pub plant: PlantKind,
    pub conveyor: Option<Conveyor>,
    pub steps: Vec<Step>,
}

/// One statement.
#[derive(Clone, Debug)]
pub enum Step {
    /// A planned motion that is waited for, and what others do while it runs.
    Move(CommandKind, Vec<(usize, Meanwhile)>),
    /// A stream of joint positions, one a cycle: out along `way` and back, `points` of them.
    Servo {
        way: [f64; 6],
        points: usize,
        lookahead: f64,
        gain: f64,
    },
    /// speedj or speedl, waited for.
    Speed(CommandKind),
    /// stopj or stopl, and then until the arm stands.
    Stop(CommandKind),
    /// Statements that take this many cycles.
    Wait(usize),
    /// A new tool, or a new payload, while the arm stands.
    Tell(CommandKind),
    /// Force mode or freedrive, pushed at with these wrenches for so many cycles each.
    Pushed(CommandKind, Vec<([f64; 6], usize)>),
}

/// What people and ports do while a motion runs.
#[derive(Clone, Copy, Debug)]
pub enum Meanwhile {
    /// The speed slider is moved.
    Fraction(f64),
    /// The slider is at zero for so many cycles, then at one.
    Halt(usize),
    /// Pause, and resume after so many cycles.
    Pause(usize),
    /// The motion is ended on its path.
    Stop,
    /// An input asks for a safeguard stop for so many cycles.
    Safeguard(usize),
    /// An input asks for reduced mode for so many cycles, in which the tool gets heavier or lighter.
    Reduced(usize),
    /// A payload of so many kg is told.
    Payload(f64),
}

/// A belt, and how the program follows it: from the first cycle on, before the belt starts.
#[derive(Clone, Copy, Debug)]
pub struct Conveyor {
    pub kind: ConveyorKind,
    /// m/s or rad/s.
    pub speed: f64,
}

/// See [`Conveyor`].
#[derive(Clone, Copy, Debug)]
pub enum ConveyorKind {
    Linear {
        direction: Vector3<f64>,
    },
    Circular {
        center: Vector3<f64>,
        rotate_tool: bool,
    },
}

/// When belts start, s.
pub const BELT_START: f64 = 0.2;
/// How long a program waits until its arm has caught up with a belt, s.
const CATCHING_UP: f64 = 1.2;
const TICKS: f64 = 1000.0;

impl Conveyor {
    pub fn track(&self) -> CommandKind {
        match self.kind {
            ConveyorKind::Linear { direction } => {
                CommandKind::Overlay(OverlayCommand::TrackConveyorLinear {
                    direction: direction.into(),
                    ticks_per_meter: TICKS,
                    encoder: 0,
                })
            }
            ConveyorKind::Circular {
                center,
                rotate_tool,
            } => CommandKind::Overlay(OverlayCommand::TrackConveyorCircular {
                center: RpyPose {
                    xyz: center.into(),
                    rpy: [0.0; 3],
                },
                ticks_per_revolution: TICKS * 2.0 * PI,
                rotate_tool,
                encoder: 0,
            }),
        }
    }
}

impl Program {
    pub fn config(&self) -> CycleConfig {
        let ticks_per_second = self.conveyor.map(|c| c.speed * TICKS);
        let pair = |pair| {
            Some(InputPair {
                pair,
                is_active_low: false,
            })
        };
        CycleConfig {
            step_time: self.step_time,
            home: self.start,
            tcp: self.tcp,
            safety_inputs: SafetyInputs {
                safeguard_stop: pair(0),
                reduced_mode: pair(2),
                ..SafetyInputs::default()
            },
            payload: Payload::new(self.payload_kg, [0.0, 0.0, 0.05], [0.0; 6]).unwrap(),
            limits: self.limits,
            plant: self.plant,
            belts: [
                ticks_per_second.map(|ticks_per_second| Belt {
                    encoder: 0,
                    ticks_per_second,
                    start_at: BELT_START,
                }),
                None,
            ],
            ..ideal(self.model)
        }
    }

    /// The same program among people who step into light curtains instead of pausing it.
    pub fn with_safety_inputs(mut self) -> Self {
        for step in &mut self.steps {
            let Step::Move(_, meanwhile) = step else {
                continue;
            };
            for (_, what) in meanwhile {
                *what = match *what {
                    Meanwhile::Pause(cycles) => Meanwhile::Safeguard(cycles),
                    Meanwhile::Fraction(fraction) => {
                        Meanwhile::Reduced((200.0 * fraction) as usize)
                    }
                    other => other,
                };
            }
        }
        self
    }

    /// The program of a seed.
    pub fn draw(model: &'static str, seed: u64) -> Self {
        let mut draw = Draw::new(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ fold(model));
        let arm = RobotModel::built_in(model).unwrap();
        let middle = JointPositions(std::array::from_fn(|joint| {
            let usual = [0.0, -1.5, 1.7, -1.7, -1.5, 0.0][joint];
            usual + draw.between(-0.5, 0.5)
        }));
        let tcp = if draw.chance(0.5) {
            RpyPose::default()
        } else {
            tool(&mut draw)
        };
        let step_time = *draw.pick(&[0.001, 0.002, 0.004, 0.004, 0.004, 0.008]);
        let conveyor = draw.chance(0.15).then(|| Conveyor::draw(&mut draw));
        let rated = arm.rated_payload_kg().unwrap();
        // What belts add to planned motions is not foreseen by limits of points: the arm stops there.
        let slow_points = conveyor.is_none() && draw.chance(0.2);
        let mut writer = Writer {
            tcp: Pose::from_rpy(&tcp),
            arm,
            middle,
            at: middle,
            draw,
            steps: Vec::new(),
        };
        if conveyor.is_some() {
            writer.on_a_belt((CATCHING_UP / step_time) as usize);
        } else {
            // With limited points the online modes stay out: what they are asked here is mostly beyond such limits.
            writer.at_will(!slow_points);
        }
        let mut draw = writer.draw;
        Self {
            model,
            step_time,
            start: middle,
            tcp,
            payload_kg: if draw.chance(0.3) { rated } else { 0.0 },
            limits: LimitOverrides {
                tcp_speed: slow_points.then(|| draw.between(0.1, 0.6)),
                elbow_speed: slow_points.then(|| draw.between(0.1, 0.6)),
                // Has tests of its own; here joints go anywhere.
                self_collision: Some(false),
                ..LimitOverrides::default()
            },
            plant: if draw.chance(0.05) {
                PlantKind::Rigid
            } else {
                PlantKind::Ideal
            },
            conveyor,
            steps: writer.steps,
        }
    }
}

/// A TCP, from the flange.
pub fn tool(draw: &mut Draw) -> RpyPose {
    RpyPose::from_array([
        draw.between(-0.1, 0.1),
        draw.between(-0.1, 0.1),
        draw.between(0.0, 0.2),
        draw.between(-1.0, 1.0),
        draw.between(-1.0, 1.0),
        draw.between(-1.0, 1.0),
    ])
}

impl Conveyor {
    fn draw(draw: &mut Draw) -> Self {
        if draw.chance(0.6) {
            let direction = Vector3::from_fn(|_, _| draw.between(-1.0, 1.0));
            Self {
                kind: ConveyorKind::Linear { direction },
                speed: draw.between(0.005, 0.06),
            }
        } else {
            let center = Vector3::new(
                draw.between(-0.8, -0.4),
                draw.between(-0.3, 0.3),
                draw.between(-0.2, 0.2),
            );
            Self {
                kind: ConveyorKind::Circular {
                    center,
                    rotate_tool: draw.chance(0.5),
                },
                speed: draw.between(0.01, 0.08),
            }
        }
    }
}

/// Writes the statements, knowing where the arm would be.
pub struct Writer {
    pub arm: RobotModel,
    pub tcp: Pose,
    pub middle: JointPositions,
    pub at: JointPositions,
    pub draw: Draw,
    pub steps: Vec<Step>,
}

impl Writer {
    /// Motions of every kind.
    fn at_will(&mut self, with_online_modes: bool) {
        for _ in 0..self.draw.whole(3, 8) {
            if with_online_modes && self.draw.chance(0.2) {
                self.online();
            } else {
                let kind = self.draw.whole(0, 2);
                self.planned(kind, 0.6);
            }
        }
    }

    /// Lines and arcs while a belt is followed.
    fn on_a_belt(&mut self, catching_up: usize) {
        self.steps.push(Step::Wait(catching_up));
        for _ in 0..self.draw.whole(1, 3) {
            let kind = self.draw.whole(1, 2);
            self.planned(kind, 0.15);
        }
        // What comes after a stop on a belt begins where no command says.
        for step in &mut self.steps {
            if let Step::Move(_, meanwhile) = step {
                meanwhile.retain(|(_, what)| !matches!(what, Meanwhile::Stop));
            }
        }
    }

    /// A motion to some place not farther than `spread` rad from the middle.
    pub fn planned(&mut self, kind: usize, spread: f64) {
        let to = self.place(spread);
        let pose = self.arm.tcp_pose(&to, &self.tcp);
        let radius = if self.draw.chance(0.6) {
            self.draw.between(0.0, 0.08)
        } else {
            0.0
        };
        let duration = if self.draw.chance(0.1) {
            self.draw.between(0.05, 3.0)
        } else {
            0.0
        };
        let motion = match kind {
            0 => CommandKind::Motion(MotionCommand::MoveJ {
                target: to,
                acceleration: self.draw.spread(0.3, 20.0),
                speed: self.draw.spread(0.1, 6.0),
                duration,
                radius,
            }),
            1 => CommandKind::Motion(MotionCommand::MoveL {
                target: pose.to_rpy(),
                acceleration: self.draw.spread(0.2, 6.0),
                speed: self.draw.spread(0.05, 1.5),
                duration,
                radius,
            }),
            _ => CommandKind::Motion(MotionCommand::MoveC {
                via: self.via(&pose),
                target: pose.to_rpy(),
                acceleration: self.draw.spread(0.2, 6.0),
                speed: self.draw.spread(0.05, 1.0),
                radius,
                fixed: self.draw.chance(0.4),
            }),
        };
        self.at = to;
        let meanwhile = self.meanwhile();
        self.steps.push(Step::Move(motion, meanwhile));
        if self.draw.chance(0.3) {
            self.steps.push(Step::Wait(self.draw.whole(0, 60)));
        }
    }

    fn meanwhile(&mut self) -> Vec<(usize, Meanwhile)> {
        let count = if self.draw.chance(0.25) {
            self.draw.whole(1, 3)
        } else {
            0
        };
        (0..count)
            .map(|_| {
                let what = match self.draw.whole(0, 9) {
                    0..=4 => Meanwhile::Fraction(self.draw.between(0.05, 1.0)),
                    5..=6 => Meanwhile::Halt(self.draw.whole(1, 80)),
                    7..=8 => Meanwhile::Pause(self.draw.whole(1, 80)),
                    _ => Meanwhile::Stop,
                };
                (self.draw.whole(0, 120), what)
            })
            .collect()
    }

    /// Streams and speeds, a stop, and back to where planned motions are at home.
    pub fn online(&mut self) {
        for _ in 0..self.draw.whole(1, 3) {
            let duration = Some(self.draw.between(0.004, 0.5));
            let step = match self.draw.whole(0, 2) {
                0 => Step::Servo {
                    way: std::array::from_fn(|_| self.draw.between(-0.3, 0.3)),
                    points: self.draw.whole(20, 200),
                    lookahead: self.draw.between(0.03, 0.2),
                    gain: self.draw.between(100.0, 2000.0),
                },
                1 => Step::Speed(CommandKind::Online(OnlineCommand::SpeedJ {
                    speeds: JointSpeeds(std::array::from_fn(|_| self.draw.between(-1.0, 1.0))),
                    acceleration: self.draw.spread(0.3, 30.0),
                    duration,
                })),
                _ => Step::Speed(CommandKind::Online(OnlineCommand::SpeedL {
                    speed: std::array::from_fn(|_| self.draw.between(-0.4, 0.4)),
                    acceleration: self.draw.spread(0.3, 10.0),
                    rotation_acceleration: self.draw.spread(0.3, 10.0),
                    duration,
                })),
            };
            self.steps.push(step);
        }
        let acceleration = self.draw.spread(0.3, 20.0);
        self.steps.push(Step::Stop(if self.draw.chance(0.5) {
            CommandKind::Online(OnlineCommand::StopJ { acceleration })
        } else {
            CommandKind::Online(OnlineCommand::StopL { acceleration })
        }));
        self.back();
    }

    /// To where planned motions are at home.
    pub fn back(&mut self) {
        self.steps.push(Step::Move(
            CommandKind::Motion(MotionCommand::MoveJ {
                target: self.at,
                acceleration: self.draw.spread(0.3, 20.0),
                speed: self.draw.spread(0.3, 6.0),
                duration: 0.0,
                radius: 0.0,
            }),
            Vec::new(),
        ));
    }

    fn place(&mut self, spread: f64) -> JointPositions {
        let at = self.middle;
        JointPositions(std::array::from_fn(|joint| {
            at[joint] + self.draw.between(-spread, spread)
        }))
    }

    /// A point beside the middle of the way to `end`.
    fn via(&mut self, end: &Pose) -> RpyPose {
        let start = self.arm.tcp_pose(&self.at, &self.tcp).translation;
        let chord = end.translation - start;
        let side = Vector3::from_fn(|_, _| self.draw.between(-1.0, 1.0)).cross(&chord);
        let height = chord.norm() * self.draw.between(0.05, 0.6) / side.norm();
        RpyPose {
            xyz: (start + chord * self.draw.between(0.3, 0.7) + side * height).into(),
            rpy: [0.0; 3],
        }
    }
}
