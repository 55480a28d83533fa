//! The world of parts around a controller: what a held part does to the arm, orders between two cycles, conditions over
//! parts.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "test helpers fail by panicking"
)]

use std::io::Write as _;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use controller::cell_world::WorldOrder;
use controller::cell_world::topic::WorldMessage;
use controller::condition::{Condition, ProgramPosition};
use controller::options::PlantChoice;
use controller::{ControllerConfig, NullObserver, SteppedController, WallTimeout};
use elite_runtime::ProgramText;
use kinematics::{Pose, RobotModel};
use motion_api::{RobotState, Seconds};
use recorder::CycleMessage;

/// A box on a table below the flange, and a cup.
const CELL: &str = r#"
[world]
floor = -0.5

[[obstacle]]
name = "table"
shape = "box"
size = [0.6, 0.6, 0.05]
pose = [-0.45, 0.0, 0.125, 0, 0, 0]

[[part]]
name = "box"
shape = "box"
size = [0.06, 0.08, 0.05]
mass = 0.4
pose = [-0.45, -0.2, 0.175, 0, 0, 0]

[[part]]
name = "spare"
shape = "sphere"
size = 0.02
density = 1000
pose = [-0.45, 0.2, 0.1701, 0, 0, 0]

[[gripper]]
name = "cup"
kind = "vacuum"
cups = [[0, 0, 0.1]]
radius = 0.02
on = "standard_digital_out[0]"
switch = "standard_digital_in[0]"
gauge = "standard_analog_in[0]"

[[detector]]
name = "eye"
kind = "presence"
pose = [-0.45, -0.2, 0.175, 0, 0, 0]
size = [0.02, 0.02, 0.02]
to = "standard_digital_in[1]"
"#;

/// Takes the box up, and stands.
const TAKE: &str = "
set_tcp([0, 0, 0.1, 0, 0, 0])
down = [3.141592653589793, 0, 0]
movel([-0.45, -0.2, 0.25] + down, a=1, v=0.5)
movel([-0.45, -0.2, 0.2] + down, a=0.5, v=0.1)
set_standard_digital_out(0, True)
sleep(0.5)
";
const LIFT: &str = "
movel([-0.45, -0.1, 0.4] + down, a=1, v=0.5)
sleep(2)
";

struct Cell(SteppedController);

fn open(cell: &str, plant: PlantChoice) -> Cell {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(cell.as_bytes()).unwrap();
    let config = ControllerConfig {
        cell: Some(file.path().to_owned()),
        plant,
        ..ControllerConfig::default()
    };
    // The file is read at the start, and not needed any more.
    Cell(SteppedController::open(&config, Arc::new(NullObserver)).unwrap())
}

impl Cell {
    fn patiently<T>(&self, call: impl FnOnce(&SteppedController, &mut WallTimeout<'_>) -> T) -> T {
        let mut patience = WallTimeout {
            wall: Duration::from_secs(60),
            keep_going: &mut || true,
        };
        call(&self.0, &mut patience)
    }

    fn run(&self, program: &str) -> RobotState {
        let text = ProgramText {
            name: "cell.script".to_owned(),
            text: program.to_owned(),
        };
        let result = self
            .patiently(|controller, patience| {
                controller.run_program(text, Seconds::new(60.0).unwrap(), patience)
            })
            .unwrap();
        assert_eq!(result.error, None);
        self.0.state()
    }

    fn advance(&self, cycles: u64) {
        self.patiently(|controller, patience| controller.advance(cycles, patience))
            .unwrap();
    }

    fn pose(&self, part: &str) -> Pose {
        let world = self.0.controller().world().unwrap().lock();
        world.part(part).unwrap().unwrap().pose
    }

    fn holds(&self, text: &str) -> bool {
        let condition = Condition::new("condition", text).unwrap();
        condition.set_world(Some(self.0.controller().world().unwrap().facts()));
        let cycle = CycleMessage::from(&self.0.state());
        condition
            .holds(&cycle, &ProgramPosition::default())
            .unwrap()
    }
}

#[test]
fn a_held_part_acts_as_the_payload_that_it_is() {
    for (plant, tolerance) in [(PlantChoice::Ideal, 1e-9), (PlantChoice::Rigid, 1e-6)] {
        let held = open(CELL, plant);
        held.run(&format!("{TAKE}{LIFT}"));
        assert!(held.holds("held('box')"));
        let standing = held.0.state();
        let flange = RobotModel::built_in("cs66")
            .unwrap()
            .forward(&standing.actual_q)
            .base_from_flange;
        let flange_from_part = flange.inverse() * held.pose("box");
        let [x, y, z]: [f64; 3] = flange_from_part.translation.into();
        let body = held
            .0
            .controller()
            .world()
            .unwrap()
            .lock()
            .part_mass(0)
            .unwrap()
            .expressed_in(&flange_from_part);
        let i = body.inertia;
        let cell = format!(
            "[payload]\nmass = 0.4\ncog = [{x}, {y}, {z}]\ninertia = [{}, {}, {}, {}, {}, {}]\n",
            i.m11, i.m22, i.m33, i.m12, i.m13, i.m23
        );
        let configured = open(&cell, plant);
        configured.run(&format!("{TAKE}{LIFT}"));
        // At rest, and in the course of a motion that both do from there.
        let mut pairs = vec![(standing, configured.0.state())];
        let swing = "q = get_actual_joint_positions()\nq[0] = q[0] + 0.6\nq[2] = q[2] - 0.2\nmovej(q, a=3, v=2)\n\
                     sleep(2)";
        pairs.push((held.run(swing), configured.run(swing)));
        for (held, configured) in pairs {
            let force = held.tcp_force[..3]
                .iter()
                .map(|x| x * x)
                .sum::<f64>()
                .sqrt();
            assert!((force - 0.4 * 9.81).abs() < 0.05, "{:?}", held.tcp_force);
            for (a, b) in [
                (held.tcp_force, configured.tcp_force),
                (held.actual_torque.0, configured.actual_torque.0),
                (held.actual_q.0, configured.actual_q.0),
            ] {
                let size = b.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                for (a, b) in a.iter().zip(&b) {
                    assert!((a - b).abs() <= tolerance * size, "{plant:?}: {a} and {b}");
                }
            }
        }
        let (a, b) = (held.0.collector().peaks(), configured.0.collector().peaks());
        for (a, b) in a.joint_torque.iter().zip(&b.joint_torque) {
            assert!(
                (a - b).abs() <= 1e3 * tolerance * b.abs().max(1.0),
                "{plant:?}: {a} and {b}"
            );
        }
    }
}

#[test]
fn what_supports_a_part_bears_it_until_it_is_lifted() {
    let cell = open(CELL, PlantChoice::Rigid);
    let standing = cell.run(TAKE);
    assert!(cell.holds("held('box')"));
    let force = standing.tcp_force[..3]
        .iter()
        .map(|x| x * x)
        .sum::<f64>()
        .sqrt();
    assert!(force < 2.0, "{force}");
    assert_eq!(standing.digital_in & 3, 3, "switch and eye");
    assert!(
        (standing.analog_in[0] - 10.0).abs() < 0.2,
        "{:?}",
        standing.analog_in
    );
    let lifted =
        cell.run("movel(pose_add(get_actual_tcp_pose(), [0, 0, 0.1, 0, 0, 0]), a=1, v=0.2)");
    assert!(
        (lifted.tcp_force[2] - 3.92).abs() < 0.1,
        "{:?}",
        lifted.tcp_force
    );
    assert_eq!(lifted.digital_in & 3, 1);
    // A payload that the controller knows does not show.
    let known = cell.run("set_payload(0.4, [0, 0, 0.125])\nsleep(0.5)");
    assert!(known.tcp_force[2].abs() < 0.1, "{:?}", known.tcp_force);
}

#[test]
fn a_held_part_is_pressed_on_a_plate_and_set_down() {
    let soft = CELL.replace(
        "name = \"table\"",
        "name = \"table\"\nstiffness = 2e4\ndamping = 100",
    );
    let cell = open(&soft, PlantChoice::Rigid);
    cell.run(&format!("{TAKE}{LIFT}"));
    // Pressed on the table by force mode, then let go of.
    cell.run(
        "set_payload(0.4, [0, 0, 0.125])
sleep(0.5)
movel([-0.45, -0.1, 0.205] + [3.141592653589793, 0, 0], a=1, v=0.2)
zero_ftsensor()
force_mode([0, 0, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0], [0, 0, -20, 0, 0, 0], 0, [0.05, 0.05, 0.02, 0.1, 0.1, 0.1])
sleep(3)
print(get_tcp_force(True)[2])",
    );
    let prints = cell.0.result().unwrap().prints;
    let force: f64 = prints[0].parse().unwrap();
    assert!((force.abs() - 20.0).abs() < 0.01, "{force}");
    cell.run(
        "movel(pose_add(get_actual_tcp_pose(), [0, 0, 0.002, 0, 0, 0]), a=0.5, v=0.05)
set_standard_digital_out(0, False)
sleep(0.5)",
    );
    assert!(!cell.holds("held('box')"));
    assert!((cell.pose("box").translation.z - 0.175).abs() < 1e-3);
    assert!(cell.holds("part('box').speed < 0.001 and not fallen('*')"));
}

#[test]
fn orders_between_two_cycles_are_there_in_the_next() {
    let cell = open(CELL, PlantChoice::Ideal);
    let world = cell.0.controller().world().unwrap().clone();
    let place = |pose| WorldOrder::Place {
        name: "spare".to_owned(),
        pose,
    };
    world
        .order(place([-0.45, 0.1, 0.3, 0.0, 0.0, 0.0]))
        .unwrap();
    cell.advance(1);
    assert!((cell.pose("spare").translation.z - 0.3).abs() < 1e-3);
    let add = WorldOrder::Add {
        template: "box".to_owned(),
        pose: [-0.45, 0.2, 0.3, 0.0, 0.0, 0.0],
    };
    assert_eq!(world.order(add).unwrap().as_deref(), Some("box#1"));
    cell.advance(400);
    // The spare ball lies on the table, or below it where it rolled off; the box stands.
    assert!((cell.pose("box#1").translation.z - 0.175).abs() < 1e-3);
    let remove = WorldOrder::Remove {
        name: "box#1".to_owned(),
    };
    world.order(remove).unwrap();
    cell.advance(1);
    assert!(cell.holds("not part('box#1').present"));
    let unknown = WorldOrder::Remove {
        name: "bax".to_owned(),
    };
    let error = world.order(unknown).unwrap_err().to_string();
    assert!(error.contains("bax"), "{error}");
    let open_circuit = WorldOrder::Fault {
        what: "open".to_owned(),
        name: "standard_digital_in[1]".to_owned(),
        duration: Some(0.1),
    };
    world.order(open_circuit).unwrap();
    cell.advance(5);
    assert_eq!(cell.0.state().digital_in & 2, 0);
    cell.advance(50);
    assert_eq!(cell.0.state().digital_in & 2, 2);
}

/// What a follower who comes after `unfollowed` cycles is told from then on, the state at that time apart.
fn news_after(unfollowed: u64) -> Vec<WorldMessage> {
    let cell = open(CELL, PlantChoice::Ideal);
    let world = cell.0.controller().world().unwrap().clone();
    let news = Arc::new(Mutex::new(Vec::new()));
    let follow = || {
        let news = news.clone();
        world.follow(Box::new(move |message| {
            news.lock().unwrap().push(message.clone());
        }));
    };
    let pose = [-0.45, 0.1, 0.3, 0.0, 0.0, 0.0];
    let (template, name) = ("box".to_owned(), "spare".to_owned());
    if unfollowed == 0 {
        follow();
    }
    world.order(WorldOrder::Remove { name }).unwrap();
    cell.advance(100);
    if unfollowed == 100 {
        follow();
    }
    world.order(WorldOrder::Add { template, pose }).unwrap();
    cell.advance(150);
    let mut news = core::mem::take(&mut *news.lock().unwrap());
    news.retain(|message| message.cycle > 100);
    news
}

#[test]
fn who_follows_late_is_told_the_same_as_who_has_followed_all_the_time() {
    let always = news_after(0);
    assert!(always.iter().any(|message| !message.parts.is_empty()));
    assert!(always.iter().all(|message| message.removed.is_empty()));
    assert_eq!(news_after(100), always);
}
