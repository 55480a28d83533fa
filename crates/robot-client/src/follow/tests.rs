use wire::primary::ErrorData;
use wire::primary::state::ModeData;

use super::*;

fn state(is_task_running: bool, is_task_paused: bool) -> Message {
    Message::State(Box::new(State {
        mode: Some(ModeData {
            is_task_running,
            is_task_paused,
            ..ModeData::default()
        }),
        ..State::default()
    }))
}

fn script_error(text: &str) -> Message {
    Message::Exception(RobotException {
        timestamp: 0,
        source: 104,
        exception: Exception::Script {
            line: 3,
            column: 1,
            text: text.to_owned(),
        },
    })
}

/// The news of messages at tenths of a second.
fn told(messages: &[(u64, Message)]) -> Vec<ProgramEvent> {
    let mut follower = ProgramMonitor::new();
    let news = messages.iter().flat_map(|(tenths, message)| {
        follower.handle_message(message, Duration::from_millis(100 * tenths))
    });
    let told: Vec<ProgramEvent> = news.collect();
    let ends = told
        .iter()
        .filter(|news| matches!(news, ProgramEvent::Finished(_)));
    assert!(ends.count() <= 1);
    told
}

#[test]
fn a_program_begins_pauses_goes_on_and_ends() {
    let (runs, held, idle) = (state(true, false), state(true, true), state(false, false));
    let messages = [
        (0, idle.clone()),
        (1, runs.clone()),
        (2, runs.clone()),
        (3, held),
        (4, runs),
        (5, idle.clone()),
        (6, idle.clone()),
        (8, idle.clone()),
        (9, idle),
    ];
    let wanted = [
        ProgramEvent::Began,
        ProgramEvent::Paused,
        ProgramEvent::Resumed,
        ProgramEvent::Finished(MonitorOutcome::Completed),
    ];
    assert_eq!(told(&messages), wanted);
}

#[test]
fn a_program_that_is_never_seen_running_has_ended_once_nobody_can_complain() {
    let idle = state(false, false);
    let messages: Vec<_> = (0..12).map(|tenths| (tenths, idle.clone())).collect();
    assert_eq!(
        told(&messages),
        [ProgramEvent::Finished(MonitorOutcome::Completed)]
    );
    assert_eq!(told(&messages[..9]), []);
}

#[test]
fn errors_before_and_shortly_after_the_end_make_it_a_failure() {
    let (runs, idle) = (state(true, false), state(false, false));
    let error = script_error("NameError: name 'x' is not defined");
    let late = [
        (1, runs.clone()),
        (2, idle.clone()),
        (3, error.clone()),
        (5, idle.clone()),
    ];
    assert_eq!(
        told(&late).last(),
        Some(&ProgramEvent::Finished(MonitorOutcome::Failed))
    );
    let at_once = [
        (0, idle.clone()),
        (1, error),
        (2, idle.clone()),
        (5, idle.clone()),
    ];
    assert_eq!(
        told(&at_once).last(),
        Some(&ProgramEvent::Finished(MonitorOutcome::Failed))
    );
    // What is wrong in a secondary program is not the program's failure.
    let secondary = script_error("[SEC] Exception: NameError");
    let beside = [(1, runs), (2, secondary), (3, idle.clone()), (6, idle)];
    assert_eq!(
        told(&beside).last(),
        Some(&ProgramEvent::Finished(MonitorOutcome::Completed))
    );
}

#[test]
fn a_program_that_takes_the_place_of_another_is_followed_to_its_own_end() {
    let (runs, idle) = (state(true, false), state(false, false));
    // Between the two the controller may be seen without a program for a moment.
    let messages = [
        (0, runs.clone()),
        (1, idle.clone()),
        (2, runs.clone()),
        (3, runs),
        (4, idle.clone()),
        (7, idle),
    ];
    assert_eq!(
        told(&messages),
        [
            ProgramEvent::Began,
            ProgramEvent::Finished(MonitorOutcome::Completed)
        ]
    );
}

#[test]
fn alarms_fail_and_warnings_do_not() {
    let alarm = |level| {
        Message::Exception(RobotException {
            timestamp: 0,
            source: 99,
            exception: Exception::Robot {
                code: 100,
                sub_code: 12,
                level,
                data: ErrorData::Text("protective stop".to_owned()),
            },
        })
    };
    let (runs, idle) = (state(true, false), state(false, false));
    for (level, outcome) in [
        (ExceptionLevel::Error, MonitorOutcome::Failed),
        (ExceptionLevel::Fatal, MonitorOutcome::Failed),
        (ExceptionLevel::Warning, MonitorOutcome::Completed),
        (ExceptionLevel::Info, MonitorOutcome::Completed),
    ] {
        let messages = [
            (1, runs.clone()),
            (2, alarm(level)),
            (3, idle.clone()),
            (6, idle.clone()),
        ];
        assert_eq!(
            told(&messages).last(),
            Some(&ProgramEvent::Finished(outcome))
        );
    }
}
