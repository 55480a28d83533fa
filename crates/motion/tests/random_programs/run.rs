//! Runs a program as its own thread would: one statement after the other, waiting for motions to end.

use kinematics::{JointPositions, RpyPose};
use motion_api::{
    CommandId, CommandKind, MachineCommand, OnlineCommand, Outcome, OverlayCommand, SensingCommand,
    SettingCommand,
};

use crate::common::Bench;
use crate::generate::{Meanwhile, Program, Step};

/// What happened.
pub struct Run {
    pub bench: Bench,
    pub phases: Vec<Phase>,
    /// Motions that were ended because they took too long.
    pub cut_short: usize,
    /// First and last cycle of each pause.
    pub pauses: Vec<(u64, u64)>,
}

/// The cycles from one statement that moves the arm to the next.
pub struct Phase {
    /// The last cycle before it.
    pub from: u64,
    pub what: What,
}

/// What a phase belongs to.
pub enum What {
    Move(Box<Sent>),
    /// An online mode; ends with a stop.
    Online,
    /// A new tool.
    Tool(RpyPose),
}

/// A planned motion.
pub struct Sent {
    pub id: CommandId,
    pub kind: CommandKind,
    /// Where the arm stood when it was sent; `None` in the zone of the motion before.
    pub stood: Option<JointPositions>,
    pub outcome: Outcome,
    /// In which cycle it ended.
    pub ended: u64,
    /// The last cycle before it was ended for taking too long.
    pub cut_short_after: Option<u64>,
    /// Slider, pause or stop came in between.
    pub is_disturbed: bool,
}

/// A motion that takes longer is ended by a stop, s: it crawls past a singular position, or with the slider low.
const PATIENCE_S: f64 = 40.0;
/// Cycles in which an arm that was stopped comes to rest.
const RESTING: usize = 20_000;

pub fn run(program: &Program) -> Run {
    let mut bench = Bench::new(program.config());
    bench.model = program.model;
    let mut run = Run {
        bench,
        phases: Vec::new(),
        cut_short: 0,
        pauses: Vec::new(),
    };
    if let Some(conveyor) = &program.conveyor {
        run.bench.do_it(conveyor.track());
    }
    for step in &program.steps {
        run.step(step);
        // A stop ends tracking too: what comes after one on a belt begins where no command says.
        let is_off_the_belt = program.conveyor.is_some() && run.cut_short > 0;
        if !run.bench.stops.is_empty() || is_off_the_belt {
            break;
        }
    }
    run.until_standing();
    if program.conveyor.is_some() {
        run.bench.do_it(OverlayCommand::StopConveyorTracking);
    }
    run
}

impl Run {
    fn step(&mut self, step: &Step) {
        match step {
            Step::Move(kind, meanwhile) => self.planned(*kind, meanwhile),
            Step::Servo {
                way,
                points,
                lookahead,
                gain,
            } => {
                self.online();
                let from = self.bench.now().target_q;
                for point in 1..=*points {
                    let share = point as f64 / *points as f64;
                    let out = (1.0 - (share * core::f64::consts::TAU).cos()) / 2.0;
                    let kind = CommandKind::Online(OnlineCommand::ServoJ {
                        target: JointPositions(std::array::from_fn(|j| from[j] + way[j] * out)),
                        duration: self.bench.cycle.step_time(),
                        lookahead: *lookahead,
                        gain: *gain,
                    });
                    self.bench.do_it(kind);
                }
            }
            Step::Speed(kind) => {
                self.online();
                self.bench.do_it(*kind);
            }
            Step::Stop(kind) => {
                self.bench.do_it(*kind);
                self.until_standing();
            }
            Step::Wait(cycles) => self.bench.run(*cycles),
            Step::Tell(kind) => {
                self.until_standing();
                if let CommandKind::Setting(SettingCommand::SetTcp(tcp)) = kind {
                    self.phase(What::Tool(*tcp));
                }
                self.bench.do_it(*kind);
            }
            Step::Pushed(begin, pushes) => {
                self.until_standing();
                self.online();
                self.bench.do_it(*begin);
                for (wrench, cycles) in pushes {
                    self.bench.send(SensingCommand::SetExternalWrench(*wrench));
                    self.bench.run(*cycles);
                }
                self.bench.send(SensingCommand::SetExternalWrench([0.0; 6]));
                self.bench.do_it(match begin {
                    CommandKind::Overlay(OverlayCommand::ForceMode { .. }) => {
                        CommandKind::Overlay(OverlayCommand::EndForceMode)
                    }
                    _ => CommandKind::Online(OnlineCommand::EndFreedrive),
                });
                self.until_standing();
            }
        }
    }

    fn online(&mut self) {
        self.phase(What::Online);
    }

    fn phase(&mut self, what: What) {
        let from = self.bench.now().cycle;
        self.phases.push(Phase { from, what });
    }

    fn planned(&mut self, kind: CommandKind, meanwhile: &[(usize, Meanwhile)]) {
        let from = self.bench.now().cycle;
        let stands = self.bench.cycle.is_standing();
        let stood = stands.then(|| self.bench.now().target_q);
        let id = self.bench.send(kind);
        let mut is_disturbed = false;
        for (cycles, what) in meanwhile {
            for _ in 0..*cycles {
                if self.bench.outcome(id).is_none() {
                    self.bench.tick();
                }
            }
            if self.bench.outcome(id).is_none() {
                is_disturbed = true;
                self.disturb(*what);
            }
        }
        let (outcome, ended, cut_short_after) = self.end_of(id);
        let is_moved_on = matches!(outcome, Outcome::Done);
        self.phases.push(Phase {
            from,
            what: What::Move(Box::new(Sent {
                id,
                kind,
                stood,
                outcome,
                ended,
                cut_short_after,
                is_disturbed,
            })),
        });
        if is_disturbed {
            self.bench.do_it(SettingCommand::SetSpeedFraction(1.0));
        }
        if !is_moved_on {
            self.until_standing();
        }
    }

    fn end_of(&mut self, id: CommandId) -> (Outcome, u64, Option<u64>) {
        let latest = self.bench.now().time + PATIENCE_S;
        let mut cut_short_after = None;
        loop {
            if let Some((_, outcome, cycle)) = self.bench.ended.iter().find(|e| e.0 == id) {
                return (*outcome, *cycle, cut_short_after);
            }
            if self.bench.now().time > latest {
                self.cut_short += 1;
                cut_short_after = Some(self.bench.now().cycle);
                let only = CommandId::NONE;
                self.bench.do_it(MachineCommand::Stop { only });
            } else {
                self.bench.tick();
            }
        }
    }

    fn disturb(&mut self, what: Meanwhile) {
        match what {
            Meanwhile::Fraction(fraction) => {
                self.bench.send(SettingCommand::SetSpeedFraction(fraction));
            }
            Meanwhile::Halt(cycles) => {
                self.bench.send(SettingCommand::SetSpeedFraction(0.0));
                self.bench.run(cycles);
                self.bench.send(SettingCommand::SetSpeedFraction(1.0));
            }
            Meanwhile::Pause(cycles) => {
                let from = self.bench.now().cycle;
                self.bench.send(MachineCommand::Pause);
                self.bench.run(cycles);
                self.pauses.push((from, self.bench.now().cycle));
                self.bench.send(MachineCommand::Resume);
            }
            Meanwhile::Safeguard(cycles) => {
                let from = self.bench.now().cycle;
                self.input(16, true);
                self.bench.run(cycles);
                self.pauses.push((from, self.bench.now().cycle));
                self.input(16, false);
            }
            Meanwhile::Reduced(cycles) => {
                self.input(20, true);
                self.bench.run(cycles / 2);
                let payload = self.bench.now().payload;
                let mass = 0.5 * payload.mass;
                let lighter = kinematics::Payload { mass, ..payload };
                self.bench.send(SettingCommand::SetPayload(lighter));
                self.bench.run(cycles / 2);
                self.input(20, false);
            }
            Meanwhile::Payload(mass) => {
                let payload = kinematics::Payload {
                    mass,
                    ..self.bench.now().payload
                };
                self.bench.send(SettingCommand::SetPayload(payload));
            }
            Meanwhile::Stop => {
                self.bench.do_it(MachineCommand::Stop {
                    only: CommandId::NONE,
                });
            }
        }
    }

    fn input(&mut self, index: u8, level: bool) {
        self.bench
            .send(SettingCommand::SetDigitalInput { index, level });
    }

    fn until_standing(&mut self) {
        for _ in 0..RESTING {
            if self.bench.cycle.is_standing() {
                return;
            }
            self.bench.tick();
        }
        panic!("the arm does not come to rest: {:?}", self.bench.now());
    }
}
