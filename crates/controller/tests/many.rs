//! Many controllers in one process: each is alone in its world, and nothing of it is left when it has ended.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "test helpers fail by panicking"
)]

use std::path::Path;

use crate::common;

use common::{program, started};
use controller::options::RecordTarget;
use controller::{ControllerConfig, PreparedController, StartOptions};
use elite_runtime::TaskEnd;
use recorder::{CycleMessage, Recording, difference};

/// Moves, threads, random numbers and an output.
const PROGRAM: &str = "
import random
def beside():
    for i in range(20):
        set_standard_digital_out(i % 8, i % 2 == 0)
        sleep(0.03)
t = start_thread(beside)
q = get_actual_joint_positions()
for i in range(3):
    q[i] += random.uniform(-0.3, 0.3)
    movej(q, a=3, v=1.5)
print('moved', random.random())
";

/// What a controller printed, and its recording's cycles.
fn run(folder: &Path, name: &str, seed: u64) -> (String, Vec<CycleMessage>) {
    let path = folder.join(format!("{name}.mcap"));
    let config = ControllerConfig {
        seed,
        record: RecordTarget::File(path.clone()),
        ..ControllerConfig::default()
    };
    let (controller, prints) = started(&config);
    let program = program(PROGRAM);
    let end = controller.run_to_end(program, "a test", std::future::pending());
    assert_eq!(end.unwrap(), Some(TaskEnd::Finished));
    assert!(controller.shut_down());
    let printed = prints.0.lock().clone();
    let recording = Recording::open(&path).unwrap();
    let cycles = recording.cycles().unwrap().map(Result::unwrap).collect();
    (printed, cycles)
}

/// Names of the threads of this process.
fn threads() -> Vec<String> {
    let tasks = std::fs::read_dir("/proc/self/task").unwrap();
    let names = tasks
        .flatten()
        .flat_map(|task| std::fs::read_to_string(task.path().join("comm")));
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}

#[test]
fn controllers_in_threads_are_each_the_same_run_and_leave_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let before = threads();
    let (said, alone) = run(folder.path(), "alone", 7);
    assert!(said.starts_with("moved 0."), "{said}");
    std::thread::scope(|scope| {
        let runs = (0..6_u64).map(|number| {
            let (folder, said, alone) = (folder.path(), &said, &alone);
            scope.spawn(move || {
                // Every other one has a seed of its own: it is another run, and changes nothing for the rest.
                let seed = if number % 2 == 0 { 7 } else { number };
                let (printed, cycles) = run(folder, &format!("beside-{number}"), seed);
                let mut pairs = alone.iter().zip(&cycles);
                let differ = pairs.find_map(|(one, other)| difference(one, other));
                if seed == 7 {
                    assert_eq!((&printed, cycles.len()), (said, alone.len()));
                    assert!(differ.is_none(), "{differ:?}");
                } else {
                    assert_ne!(&printed, said);
                    assert!(differ.is_some());
                }
            })
        });
        // The end of a scope does not wait until its threads are gone; joining does.
        for run in runs.collect::<Vec<_>>() {
            run.join().unwrap();
        }
    });
    assert_eq!(threads(), before);
}

#[test]
fn a_controller_runs_one_program_after_the_other_and_its_state_goes_on() {
    let (controller, prints) = started(&ControllerConfig::default());
    for text in [
        "movej([0.2, -1.5, 1.5, -1.5, -1.5, 0], a=3, v=1.5)",
        "print(round(get_actual_joint_positions()[0], 3))",
        "raise ValueError('no')",
    ] {
        let program = program(text);
        let end = controller.run_to_end(program, "a test", std::future::pending());
        let wanted = if text.starts_with("raise") {
            TaskEnd::Failed
        } else {
            TaskEnd::Finished
        };
        assert_eq!(end.unwrap(), Some(wanted), "{text}");
    }
    assert_eq!(*prints.0.lock(), "0.2\n");
    assert!(controller.shut_down());
}

#[test]
fn what_does_not_fit_is_an_error_before_anything_starts() {
    let before = threads();
    let config = ControllerConfig {
        cell: Some("no such file.toml".into()),
        ..ControllerConfig::default()
    };
    let error = PreparedController::new(&config, StartOptions::for_single_run())
        .err()
        .unwrap();
    assert!(
        error
            .to_string()
            .starts_with("cannot read the cell file no such file.toml"),
        "{error}"
    );
    assert_eq!(threads(), before);
}
