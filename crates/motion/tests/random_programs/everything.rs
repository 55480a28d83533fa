//! Programs beyond planned motions one by one: chains of short moves, process moves, force mode, hands on the arm,
//! tools and payloads that change.
//!
//! Owns what such programs look like; arm, plant and limits are those of [`Program::draw`] of the same seed.

use core::f64::consts::PI;

use kinematics::{Payload, Pose, RpyPose};
use motion_api::{
    CommandKind, FreedriveFrame, MotionCommand, OnlineCommand, OverlayCommand, SensingCommand,
    SettingCommand,
};
use nalgebra::Vector3;

use crate::generate::{Meanwhile, Program, Step, Writer, tool};

/// Told to the cycle so that pushes through the port count.
const PUSHES_COUNT: CommandKind = CommandKind::Sensing(SensingCommand::FtRtsiInput {
    enabled: true,
    mass: 0.0,
    measuring_offset: [0.0; 3],
    cog: [0.0; 3],
});

impl Program {
    /// The program of a seed, without limits of points: how fast those go that are pushed at is up to who pushes.
    pub fn draw_of_everything(model: &'static str, seed: u64) -> Self {
        let base = Self::draw(model, seed);
        let arm = kinematics::RobotModel::built_in(model).unwrap();
        let mut limits = base.limits;
        (limits.tcp_speed, limits.elbow_speed) = (None, None);
        let mut writer = Writer {
            tcp: Pose::from_rpy(&base.tcp),
            arm,
            middle: base.start,
            at: base.start,
            draw: crate::common::draw::Draw::new(seed ^ 0x00c0_ffee),
            steps: vec![
                Step::Tell(PUSHES_COUNT),
                Step::Tell(CommandKind::Sensing(SensingCommand::SetCollisionDetection(
                    false,
                ))),
            ],
        };
        for _ in 0..writer.draw.whole(2, 5) {
            match writer.draw.whole(0, 6) {
                0 | 1 => writer.chain(),
                2 => writer.force(base.step_time),
                3 => writer.hand(base.step_time),
                4 => writer.new_tool(),
                5 => writer.new_payload(),
                _ => writer.online(),
            }
        }
        writer.planned(0, 0.6);
        Self {
            conveyor: None,
            limits,
            steps: writer.steps,
            ..base
        }
    }
}

impl Writer {
    /// Many short lines, process moves or joint moves, each a little further on, with blends smaller and larger than
    /// they are long; the last one stops.
    fn chain(&mut self) {
        let (count, kind) = (self.draw.whole(4, 14), self.draw.whole(0, 2));
        let length = self.draw.spread(0.002, 0.06);
        let mut heading = Vector3::from_fn(|_, _| self.draw.between(-1.0, 1.0)).normalize();
        let speed = self.draw.spread(0.02, 0.8);
        let acceleration = self.draw.spread(0.3, 5.0);
        let mut pose = self.arm.tcp_pose(&self.at, &self.tcp);
        for number in 1..=count {
            let bend = Vector3::from_fn(|_, _| self.draw.between(-0.4, 0.4));
            heading = (heading + bend).normalize();
            pose.translation += heading * length;
            let Some(to) = self.arm.inverse_nearest(&pose, &self.tcp, &self.at) else {
                break;
            };
            let radius = match number == count {
                true => 0.0,
                false => length * self.draw.between(0.0, 0.7),
            };
            let motion = match kind {
                0 => CommandKind::Motion(MotionCommand::MoveP {
                    target: pose.to_rpy(),
                    acceleration,
                    speed,
                    radius,
                }),
                1 => CommandKind::Motion(MotionCommand::MoveL {
                    target: pose.to_rpy(),
                    acceleration,
                    speed,
                    duration: 0.0,
                    radius,
                }),
                _ => CommandKind::Motion(MotionCommand::MoveJ {
                    target: to,
                    acceleration: 4.0 * acceleration,
                    speed: 3.0 * speed,
                    duration: 0.0,
                    radius,
                }),
            };
            self.at = to;
            let meanwhile = match self.draw.whole(0, 19) {
                0 => vec![(
                    self.draw.whole(0, 20),
                    Meanwhile::Fraction(self.draw.between(0.05, 1.0)),
                )],
                1 => vec![(
                    self.draw.whole(0, 20),
                    Meanwhile::Pause(self.draw.whole(1, 60)),
                )],
                2 => vec![(self.draw.whole(0, 20), self.payload())],
                _ => Vec::new(),
            };
            self.steps.push(Step::Move(motion, meanwhile));
        }
        // Also where the last one could not be reached and the one before was to be left in its zone.
        self.back();
    }

    /// Force mode in the air, against pushes.
    fn force(&mut self, step: f64) {
        let selection = std::array::from_fn(|_| self.draw.chance(0.5));
        let begin = CommandKind::Overlay(OverlayCommand::ForceMode {
            frame: RpyPose::from_array(std::array::from_fn(|k| {
                if k < 3 {
                    0.0
                } else {
                    self.draw.between(-PI, PI)
                }
            })),
            selection,
            wrench: self.wrench(15.0, 1.0),
            mode: *self.draw.pick(&[0, 3]),
            speed_limits: std::array::from_fn(|_| self.draw.between(0.02, 0.2)),
        });
        self.pushed(begin, step);
    }

    /// A hand leads the arm.
    fn hand(&mut self, step: f64) {
        let begin = CommandKind::Online(OnlineCommand::Freedrive {
            free_axes: std::array::from_fn(|_| self.draw.chance(0.7)),
            frame: *self
                .draw
                .pick(&[FreedriveFrame::Base, FreedriveFrame::Tool]),
        });
        self.pushed(begin, step);
    }

    fn pushed(&mut self, begin: CommandKind, step: f64) {
        let pushes = (0..self.draw.whole(1, 4))
            .map(|_| {
                let seconds = self.draw.between(0.02, 0.5);
                (self.wrench(40.0, 3.0), (seconds / step) as usize)
            })
            .collect();
        self.steps.push(Step::Pushed(begin, pushes));
        self.back();
    }

    fn wrench(&mut self, force: f64, torque: f64) -> [f64; 6] {
        std::array::from_fn(|k| {
            let most = if k < 3 { force } else { torque };
            self.draw.between(-most, most)
        })
    }

    fn new_tool(&mut self) {
        let tcp = tool(&mut self.draw);
        self.tcp = Pose::from_rpy(&tcp);
        // It counts for what comes after the arm stands.
        self.back();
        self.steps
            .push(Step::Tell(CommandKind::Setting(SettingCommand::SetTcp(
                tcp,
            ))));
        let kind = self.draw.whole(0, 2);
        self.planned(kind, 0.4);
    }

    fn new_payload(&mut self) {
        let Meanwhile::Payload(mass) = self.payload() else {
            return;
        };
        let payload = Payload::new(mass, [0.0, 0.0, 0.05], [0.0; 6]).unwrap();
        self.steps.push(Step::Tell(CommandKind::Setting(
            SettingCommand::SetPayload(payload),
        )));
        let kind = self.draw.whole(0, 2);
        self.planned(kind, 0.4);
    }

    fn payload(&mut self) -> Meanwhile {
        let rated = self.arm.rated_payload_kg().unwrap_or_default();
        Meanwhile::Payload(self.draw.between(0.0, rated))
    }
}

/// So that a judge that sees nothing is noticed: programs of all kinds of statements.
#[test]
fn programs_of_everything_have_everything() {
    let steps: Vec<Step> = (0..40)
        .flat_map(|seed| Program::draw_of_everything("cs66", seed).steps)
        .collect();
    let has = |wanted: &dyn Fn(&Step) -> bool| steps.iter().any(wanted);
    assert!(has(&|step| matches!(
        step,
        Step::Move(CommandKind::Motion(MotionCommand::MoveP { .. }), _)
    )));
    assert!(has(&|step| matches!(
        step,
        Step::Pushed(CommandKind::Overlay(OverlayCommand::ForceMode { .. }), _)
    )));
    assert!(has(&|step| matches!(
        step,
        Step::Pushed(CommandKind::Online(OnlineCommand::Freedrive { .. }), _)
    )));
    assert!(has(&|step| matches!(
        step,
        Step::Tell(CommandKind::Setting(SettingCommand::SetTcp(_)))
    )));
    assert!(has(&|step| matches!(
        step,
        Step::Tell(CommandKind::Setting(SettingCommand::SetPayload(_)))
    )));
    assert!(has(&|step| matches!(step, Step::Servo { .. })));
}
