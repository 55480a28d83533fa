//! A controller whose owner passes time: outcomes in their words, time-outs on the cycle, and steps that meet the
//! program where it stands.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "test helpers fail by panicking"
)]

use std::convert::Infallible;
use std::sync::Arc;
use std::time::{Duration, Instant};

use controller::{
    ControllerConfig, NullObserver, ProgramOutcome, ProgramResult, SteppedController, SteppedError,
    WallTimeout,
};
use elite_runtime::ProgramText;
use motion_api::{CommandKind, MachineCommand, Origin, Seconds};

fn opened() -> SteppedController {
    SteppedController::open(&ControllerConfig::default(), Arc::new(NullObserver)).unwrap()
}

fn text(text: &str) -> ProgramText {
    ProgramText {
        name: "stepped.script".to_owned(),
        text: text.to_owned(),
    }
}

fn seconds(secs: f64) -> Seconds {
    Seconds::new(secs).unwrap()
}

/// Calls with a patience of `wall`.
fn patiently<T>(wall: Duration, call: impl FnOnce(&mut WallTimeout<'_>) -> T) -> T {
    call(&mut WallTimeout {
        wall,
        keep_going: &mut || true,
    })
}

const LONG: Duration = Duration::from_secs(30);

fn run(controller: &SteppedController, program: &str, secs: f64) -> ProgramResult {
    patiently(LONG, |patience| {
        controller.run_program(text(program), seconds(secs), patience)
    })
    .unwrap()
}

#[test]
fn programs_end_in_their_words() {
    let controller = opened();
    for (program, outcome, error, line, prints) in [
        (
            "print('a')\nprint('b')",
            ProgramOutcome::Ended,
            None,
            None,
            &["a", "b"][..],
        ),
        (
            "print(1)\nx = 1 / 0",
            ProgramOutcome::Failed,
            Some("ZeroDivisionError: division by zero"),
            Some(2),
            &["1"],
        ),
        (
            "if x\n",
            ProgramOutcome::Failed,
            Some("SyntaxError"),
            Some(1),
            &[],
        ),
        (
            "sleep(1)\nwhile True:\n    sleep(0.1)\nend\n",
            ProgramOutcome::Timeout,
            Some("had not ended after 2 s"),
            Some(3),
            &[],
        ),
    ] {
        let result = run(&controller, program, 2.0);
        assert_eq!(result.outcome, outcome, "{program}: {result:?}");
        assert_eq!(result.line, line, "{program}: {result:?}");
        assert_eq!(result.prints, prints, "{program}");
        match error {
            None => assert_eq!(result.error, None, "{program}"),
            Some(error) => {
                let said = result.error.unwrap();
                assert!(said.english().contains(error), "{program}: {said}");
            }
        }
    }
    assert!(controller.shut_down().unwrap());
}

#[test]
fn a_program_that_computes_without_end_times_out_and_the_next_one_runs() {
    let controller = opened();
    let program = text("x = 0\nwhile True:\n    x += 1\nend\n");
    let begin = Instant::now();
    let result = patiently(Duration::from_millis(200), |patience| {
        controller.run_program(program.clone(), seconds(60.0), patience)
    })
    .unwrap();
    assert!(begin.elapsed() < Duration::from_secs(5));
    assert_eq!(result.outcome, ProgramOutcome::Timeout);
    assert!(
        result
            .error
            .unwrap()
            .english()
            .contains("no simulated time passed")
    );
    let error = patiently(Duration::from_millis(100), |patience| {
        controller.start(program, patience)
    })
    .unwrap_err();
    assert!(matches!(error, SteppedError::Stuck { .. }), "{error}");
    assert_eq!(run(&controller, "print(1)", 1.0).prints, ["1"]);
    controller.shut_down().unwrap();
}

#[test]
fn steps_are_cycles_and_the_program_stands_between_them() {
    let controller = opened();
    let program = "for i in range(5):\n    print(i)\n    sync()\nend\nsleep(1)\n";
    patiently(LONG, |patience| {
        controller.start(text(program), patience).unwrap();
        assert_eq!(controller.collector().prints(), ["0"]);
        assert_eq!(controller.state().cycle, 0);
        for cycle in 1..=3 {
            assert!(controller.advance(1, patience).unwrap());
            assert_eq!(controller.state().cycle, cycle);
            assert_eq!(controller.collector().prints().len(), cycle as usize + 1);
        }
        let error = controller.start(text("pass"), patience).unwrap_err();
        assert!(matches!(error, SteppedError::Running), "{error}");
        // The program ends on the way, the cycles go on.
        assert!(controller.advance(1000, patience).unwrap());
        assert_eq!(controller.state().cycle, 1003);
        assert!(!controller.is_running());
        let result = controller.result().unwrap();
        assert_eq!(result.outcome, ProgramOutcome::Ended);
        assert!((1.0..1.1).contains(&result.time), "{result:?}");
        // Without a program time passes all the same.
        assert!(controller.advance(7, patience).unwrap());
        assert_eq!(controller.state().cycle, 1010);
    });
    controller.shut_down().unwrap();
}

#[test]
fn a_stepped_run_is_the_same_as_one_at_once() {
    let program =
        "movej([0.3, -1.2, 1.4, -1.5, -1.5, 0], a=3, v=1.5)\nprint(get_actual_joint_positions())\n";
    let (at_once, stepped) = (opened(), opened());
    let result = run(&at_once, program, 10.0);
    patiently(LONG, |patience| {
        stepped.start(text(program), patience).unwrap();
        let mut steps = (1..).cycle();
        while stepped.is_running() {
            stepped
                .advance(steps.next().unwrap() % 7, patience)
                .unwrap();
        }
    });
    assert_eq!(stepped.result(), Some(result));
    let peaks = stepped.collector().peaks();
    assert!(
        (0.5..=1.5 + 1e-3).contains(&peaks.by_name("joint_speed").unwrap()),
        "{peaks:?}"
    );
}

#[test]
fn waiting_for_a_state_ends_on_its_cycle() {
    let controller = opened();
    patiently(LONG, |patience| {
        let program = text("movej([0.5, -1.5708, 1.5708, -1.5708, -1.5708, 0])");
        controller.start(program, patience).unwrap();
        let mut looks = 0;
        let there = controller.advance_until::<SteppedError>(
            |state| {
                looks += 1;
                Ok(state.actual_q.0[0] > 0.25)
            },
            seconds(10.0),
            patience,
        );
        assert!(there.unwrap());
        assert_eq!(looks, controller.state().cycle + 1);
        let never = controller.advance_until::<SteppedError>(|_| Ok(false), seconds(0.1), patience);
        assert!(!never.unwrap());
        let stopped = controller.stop().unwrap().unwrap();
        assert_eq!(stopped.outcome, ProgramOutcome::Stopped);
        assert!(controller.state().actual_qd.max_abs() < 1e-3);
        assert!(controller.state().actual_q.0[0] < 0.5);
    });
    controller.shut_down().unwrap();
}

#[test]
fn stops_of_the_arm_are_outcomes() {
    for (pressed, outcome) in [
        (true, ProgramOutcome::EmergencyStop),
        (false, ProgramOutcome::Ended),
    ] {
        let controller = opened();
        patiently(LONG, |patience| {
            let program = "movej([1, -1.5708, 1.5708, -1.5708, -1.5708, 0])";
            controller.start(text(program), patience).unwrap();
            controller.advance(100, patience).unwrap();
            let kind = CommandKind::Machine(MachineCommand::EmergencyStop { pressed });
            let robot = controller.controller().robot();
            robot.send(Origin::default(), kind).unwrap();
            let result = controller.run_to_end(seconds(20.0), patience).unwrap();
            assert_eq!(result.outcome, outcome, "{result:?}");
        });
        controller.shut_down().unwrap();
    }
}

#[test]
fn another_thread_and_the_owner_can_end_a_run() {
    let controller = opened();
    let forever = "while True:\n    sleep(0.01)\nend\n";
    let result = std::thread::scope(|scope| {
        scope.spawn(|| {
            while !controller.is_running() || controller.state().cycle < 50 {
                std::thread::sleep(Duration::from_millis(1));
            }
            controller.request_stop();
        });
        run(&controller, forever, 1e7)
    });
    assert_eq!(
        (result.outcome, result.error),
        (ProgramOutcome::Stopped, None)
    );
    let begin = Instant::now();
    let mut patience = WallTimeout {
        wall: LONG,
        keep_going: &mut || begin.elapsed() < Duration::from_millis(50),
    };
    let result = controller.run_program(text(forever), seconds(1e7), &mut patience);
    assert_eq!(result.unwrap().outcome, ProgramOutcome::Stopped);
    // A condition is asked cycle by cycle, its owner all the same.
    let begin = Instant::now();
    let mut patience = WallTimeout {
        wall: LONG,
        keep_going: &mut || begin.elapsed() < Duration::from_millis(50),
    };
    let never =
        controller.advance_until::<SteppedError>(|_| Ok(false), seconds(1e7), &mut patience);
    assert!(!never.unwrap() && begin.elapsed() < Duration::from_secs(10));
    assert_eq!(run(&controller, "pass", 1.0).outcome, ProgramOutcome::Ended);
    controller.shut_down().unwrap();
}

/// `advance_until` takes the errors of its question.
#[derive(Debug)]
struct Asked;

impl From<SteppedError> for Asked {
    fn from(_: SteppedError) -> Self {
        Self
    }
}

impl From<Infallible> for Asked {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}

#[test]
fn a_question_that_fails_leaves_the_program_where_it_stands() {
    let controller = opened();
    patiently(LONG, |patience| {
        controller
            .start(text("sleep(1)\nprint('on')"), patience)
            .unwrap();
        let asked = controller.advance_until(
            |state| {
                if state.cycle < 10 {
                    Ok(false)
                } else {
                    Err(Asked)
                }
            },
            seconds(1.0),
            patience,
        );
        assert!(asked.is_err());
        assert_eq!(controller.state().cycle, 10);
        let result = controller.run_to_end(seconds(5.0), patience).unwrap();
        assert_eq!(result.prints, ["on"]);
    });
    controller.shut_down().unwrap();
}
