//! How long it takes until a motion command is planned, and whether long chains of blends stream without a stop.
//!
//! `cargo bench -p motion --bench planning`; times are the thread's own, so that they hold on a busy machine too. The
//! ideal plant costs next to nothing, so the time of the cycles from taking a command to the first setpoint of its
//! motion is that of planning.
#![allow(
    clippy::expect_used,
    reason = "a bench that cannot go on should say where"
)]

use kinematics::{JointPositions, Pose, RobotModel, RpyPose};
use motion::{ControlLoop, CycleConfig, CycleTiming, PlantKind};
use motion_api::{
    CommandKind, Event, MotionCommand, Origin, Outcome, RingCapacities, ScriptEndpoint,
    motion_channel,
};

/// Commands of each kind on each arm.
const COMMANDS: usize = 300;
/// Legs of the chain.
const LEGS: usize = 100;
const MODELS: [&str; 6] = ["cs63", "cs66", "cs612", "cs616", "cs620", "cs625"];

fn main() {
    for kind in [Kind::MoveJ, Kind::MoveL, Kind::MoveC] {
        let mut times = Vec::new();
        let mut cycles = 0;
        let mut done = 0;
        for model in MODELS {
            let mut desk = Desk::new(model);
            for number in 0..COMMANDS {
                let Some((planned, waited)) = desk.one(kind, number) else {
                    continue;
                };
                times.push(planned);
                cycles = cycles.max(waited);
                done += 1;
            }
        }
        let at = percentiles(&mut times);
        println!(
            "{kind:?} planned, {done} of {}: p50 {:.0} us, p99 {:.0} us, largest {:.0} us, in {cycles} cycles at most",
            MODELS.len() * COMMANDS,
            at(500),
            at(990),
            at(1000)
        );
    }
    chain();
}

/// Time that this thread has had a processor, us: others who share the machine do not count.
fn cpu_time_us() -> f64 {
    let clock = nix::time::ClockId::CLOCK_THREAD_CPUTIME_ID;
    let now = clock.now().expect("every thread has this clock");
    now.tv_sec() as f64 * 1e6 + now.tv_nsec() as f64 * 1e-3
}

/// Places in a sorted list, in thousandths.
fn percentiles(times: &mut [f64]) -> impl Fn(usize) -> f64 + '_ {
    times.sort_by(f64::total_cmp);
    |share| times[(times.len() * share / 1000).min(times.len() - 1)]
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    MoveJ,
    MoveL,
    MoveC,
}

/// An arm, and numbers drawn from a seed.
struct Desk {
    model: RobotModel,
    cycle: ControlLoop,
    script: ScriptEndpoint,
    drawn: u64,
}

impl Desk {
    fn new(name: &str) -> Self {
        let config = CycleConfig {
            plant: PlantKind::Ideal,
            ..CycleConfig::new(RobotModel::built_in(name).expect("a built-in arm"))
        };
        let sizes = RingCapacities {
            records: None,
            ..RingCapacities::default()
        };
        let (motion, script) = motion_channel(sizes, &config.first_state());
        Self {
            model: config.model.clone(),
            cycle: ControlLoop::new(config, motion).expect("a controller"),
            script,
            drawn: 1,
        }
    }

    /// Between -1 and 1 (splitmix64).
    fn draw(&mut self) -> f64 {
        self.drawn = self.drawn.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.drawn ^ (self.drawn >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn place(&mut self) -> JointPositions {
        let usual = [0.0, -1.5, 1.7, -1.7, -1.5, 0.0];
        JointPositions(std::array::from_fn(|joint| {
            usual[joint] + 0.6 * self.draw()
        }))
    }

    fn pose(&mut self) -> RpyPose {
        let q = self.place();
        self.model.tcp_pose(&q, &Pose::IDENTITY).to_rpy()
    }

    /// Planning of one command, us, and the cycles it took; `None` for one that is refused.
    fn one(&mut self, kind: Kind, number: usize) -> Option<(f64, usize)> {
        let kind = match kind {
            Kind::MoveJ => CommandKind::Motion(MotionCommand::MoveJ {
                target: self.place(),
                acceleration: 1.4,
                speed: 3.0,
                duration: 0.0,
                radius: 0.0,
            }),
            Kind::MoveL => line(self.pose(), 0.5, 0.0),
            Kind::MoveC => CommandKind::Motion(MotionCommand::MoveC {
                via: self.pose(),
                target: self.pose(),
                acceleration: 1.2,
                speed: 0.5,
                radius: 0.0,
                fixed: number.is_multiple_of(2),
            }),
        };
        self.script
            .commands
            .send(Origin::default(), kind)
            .expect("room");
        let before = self.script.snapshot.read().target_q;
        let (mut planned, mut waited) = (0.0, 0);
        let mut is_planned = false;
        // A motion that crawls past a singular position is not waited for.
        for cycle in 0..5000 {
            let begin = cpu_time_us();
            self.cycle.tick(CycleTiming::default());
            let took = cpu_time_us() - begin;
            if !is_planned {
                planned += took;
                waited = cycle + 1;
                is_planned = self.script.snapshot.read().target_q != before;
            }
            while let Some(event) = self.script.events.next_event() {
                if let Event::Ended { outcome, .. } = event {
                    return (outcome == Outcome::Done && is_planned).then_some((planned, waited));
                }
            }
        }
        self.cycle.stop_moving();
        while !self.cycle.is_standing() {
            self.cycle.tick(CycleTiming::default());
        }
        while self.script.events.next_event().is_some() {}
        Some((planned, waited))
    }
}

fn line(target: RpyPose, speed: f64, radius: f64) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveL {
        target,
        acceleration: 1.2,
        speed,
        duration: 0.0,
        radius,
    })
}

/// A polygon of [`LEGS`] legs of 26 mm with blends of 8 mm: does the arm ever stop, and what do the cycles cost?
fn chain() {
    let mut desk = Desk::new("cs66");
    let home = desk.script.snapshot.read().target_tcp_pose;
    let mut times = Vec::new();
    let (mut slowest, mut warnings) = (f64::INFINITY, 0);
    for leg in 1..=LEGS {
        let angle = leg as f64 * core::f64::consts::TAU / 24.0;
        let mut target = home;
        target.xyz[0] += 0.1 * (angle.cos() - 1.0);
        target.xyz[1] += 0.1 * angle.sin();
        let radius = if leg < LEGS { 0.008 } else { 0.0 };
        let kind = line(target, 0.25, radius);
        desk.script
            .commands
            .send(Origin::default(), kind)
            .expect("room");
        let mut has_ended = false;
        while !has_ended {
            let begin = cpu_time_us();
            desk.cycle.tick(CycleTiming::default());
            times.push(cpu_time_us() - begin);
            if leg > 1 && leg < LEGS {
                let v = desk.script.snapshot.read().target_tcp_speed;
                let speed = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
                slowest = slowest.min(speed);
            }
            while let Some(event) = desk.script.events.next_event() {
                match event {
                    Event::Ended { .. } => has_ended = true,
                    Event::Warned { .. } => warnings += 1,
                    Event::Stopped { .. } | Event::ReadyForNext { .. } | Event::Due { .. } => {}
                }
            }
        }
    }
    let cycles = times.len();
    let at = percentiles(&mut times);
    println!(
        "chain of {LEGS} lines at 0.25 m/s: {cycles} cycles, slowest {slowest:.3} m/s, {warnings} warnings; \
         cycle p50 {:.1} us, p99 {:.1} us, largest {:.1} us",
        at(500),
        at(990),
        at(1000)
    );
}
