//! A bounded number of cases of every target, the same on every run, and every input that was a finding once.
//!
//! Longer: `cargo dev campaign --seconds 600 --seed 2`.

#![allow(clippy::expect_used, reason = "a test helper fails by panicking")]

use std::path::Path;

use dev::targets::{Target, target, targets};

/// Runs cases of one target; a panic of a promise that is broken names the command that repeats it.
fn cases(name: &str, count: u64) {
    let target: &Target = target(name).expect("a target of this name");
    let seeds = (target.seeds)();
    for number in 0..count {
        let input = target.input(&seeds, 0, number);
        let result = std::panic::catch_unwind(|| (target.check)(&input));
        assert!(
            result.is_ok(),
            "cargo dev case {name} {number} --seed 0 --run"
        );
    }
}

/// Every target stands here once, so that each is a test of its own and the table cannot grow past this list.
macro_rules! targets_and_counts {
    ($($name:ident: $count:expr,)*) => {
        $(#[test]
        fn $name() {
            cases(stringify!($name), $count);
        })*

        #[test]
        fn every_target_is_tested() {
            let tested = [$(stringify!($name)),*];
            let there: Vec<&str> = targets().iter().map(|target| target.name).collect();
            assert_eq!(tested.to_vec(), there);
        }
    };
}

// A few seconds each in a debug build.
targets_and_counts! {
    lexer: 300,
    parser: 1000,
    evaluator: 300,
    library: 300,
    containers: 150,
    chains: 40,
    stacks: 40,
    growth: 10,
    builtins: 60,
    ros2_link: 5000,
    primary: 3000,
    interpreter: 5000,
    query: 10_000,
    dashboard: 10_000,
    debugger: 40,
    rtsi: 10_000,
    opening: 10_000,
    http: 1500,
    foxglove: 500,
    http_inputs: 10_000,
    modbus_server: 10_000,
    modbus_rtu: 10_000,
    script_socket: 5000,
    xmlrpc: 5000,
    recording: 300,
    rerun: 30,
    urscript: 2000,
    toolpath: 1000,
    cell: 1000,
    config: 2000,
    urdf: 300,
    mesh: 300,
    calibration: 2000,
    points: 5000,
    task_names: 3000,
    lsp: 40,
    lsp_edits: 15,
    mcp: 5000,
}

/// `kept/TARGET/NAME`: an input that broke a promise once.
#[test]
fn what_was_found_once_is_not_found_again() {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("kept");
    let mut count = 0;
    for folder in std::fs::read_dir(kept).unwrap().flatten() {
        let name = folder.file_name().to_string_lossy().into_owned();
        let target = target(&name).expect("folders of `kept` are named as targets");
        for file in std::fs::read_dir(folder.path()).unwrap().flatten() {
            eprintln!("{}", file.path().display());
            (target.check)(&std::fs::read(file.path()).unwrap());
            count += 1;
        }
    }
    assert!(count > 0);
}

/// The generators make programs that compile and that run: without this a slip in one of them would go unseen. How many
/// come to their end within the processor time they get is a matter of the machine; those that do not run on.
#[test]
fn generated_programs_compile_and_mostly_run() {
    use dev::language::{TrialOutcome, check_execution};
    let mut run = 0;
    for number in 0..60 {
        let target = target("containers").expect("a target of this name");
        let input = target.input(&[], 3, number);
        let text = String::from_utf8(input).unwrap();
        let outcome = std::panic::catch_unwind(|| check_execution(text.clone()));
        run += usize::from(matches!(
            outcome,
            Ok(TrialOutcome::Done | TrialOutcome::Stopped)
        ));
    }
    assert!(run > 30, "{run} of 60 run");
}

#[test]
fn a_case_is_a_function_of_its_seed_and_number() {
    for target in targets() {
        let seeds = (target.seeds)();
        let [one, again, other] =
            [(5, 7), (5, 7), (5, 8)].map(|(seed, number)| target.input(&seeds, seed, number));
        assert_eq!(one, again, "{}", target.name);
        let more = (9..20).map(|number| target.input(&seeds, 5, number));
        assert!(
            one != other || more.into_iter().any(|input| input != one),
            "{}",
            target.name
        );
    }
}
