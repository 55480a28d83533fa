//! Random programs on all six arms, every cycle judged: no limit exceeded, no way left, every end exact.
//!
//! A few programs an arm run here; `ELITE_PROGRAMS=500` runs that many, from seed `ELITE_FIRST` on where that is set,
//! `ELITE_PROGRAM=SEED` a single one and prints it.
//! With `ELITE_DURATIONS=FILE` the durations of movej from rest to rest are appended to a table, which
//! `tests/peers/movej_oracle.py` compares with an independent planner.
#![allow(missing_docs, reason = "a test of its own")]
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot go on should say where"
)]

#[path = "../common/mod.rs"]
mod common;
mod everything;
mod generate;
mod judge;
mod run;
mod way;

use std::fmt::Write as _;
use std::io::Write as _;

use generate::Program;
use judge::Tally;

/// Programs an arm when nothing else is said.
const PROGRAMS: u64 = 12;
/// Faulty programs that are told of.
const MOST_TOLD: usize = 8;

fn number(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

/// Runs the programs of one arm and fails with the seeds of those that were not right.
fn every_program_is_right(model: &'static str) {
    let seeds = match number("ELITE_PROGRAM") {
        Some(seed) => seed..seed + 1,
        None => {
            let first = number("ELITE_FIRST").unwrap_or(0);
            first..first + number("ELITE_PROGRAMS").unwrap_or(PROGRAMS)
        }
    };
    let count = seeds.end - seeds.start;
    let mut all = Tally::default();
    let (mut wrong, mut told) = (Vec::new(), String::new());
    for seed in seeds {
        let program = Program::draw(model, seed);
        if count == 1 {
            println!("{program:#?}");
        }
        let run = run::run(&program);
        let verdict = judge::judge(&program, &run);
        if !verdict.faults.is_empty() {
            if wrong.len() < MOST_TOLD {
                let faults = verdict.faults.join("\n  ");
                let belt = program.conveyor.map_or("", |_| " on a belt");
                writeln!(told, "{model}, seed {seed}{belt}:\n  {faults}").unwrap();
            }
            wrong.push(seed);
        }
        save_durations(&program, &run.bench.limits, &verdict.tally);
        all.add(verdict.tally);
    }
    let durations = all.rest_to_rest.len();
    println!(
        "{model}: {count} programs, {} cycles, {} motions ({} refused, {} cut short), {} joined ({} not blended), \
         {} on belts ({} programs carried away); largest \
         deviation from the path {:.1e}, at the end {:.1e}, on a belt {:.1e} m; {durations} movej from rest to rest",
        all.cycles,
        all.motions,
        all.refused,
        all.cut_short,
        all.joined,
        all.not_joined,
        all.on_belts,
        all.carried_away,
        all.path_max,
        all.end_max,
        all.belt_max,
    );
    assert!(
        wrong.is_empty(),
        "{} of {count} programs are not right: {wrong:?}\n{told}",
        wrong.len()
    );
    // The judge had something to see.
    if count >= PROGRAMS {
        assert!(all.motions as u64 > 3 * count && 3 * all.refused < all.motions);
        assert!(20 * all.cut_short <= all.motions);
        // These motions are sent when the zone is entered, whatever was due before: where it is short for the speed
        // that is too late.
        assert!(all.joined as u64 > count / 2 && all.not_joined < all.joined);
        assert!(3 * all.carried_away <= all.on_belts);
    }
}

/// One line a motion: arm, step, way of six joints, speed and acceleration asked, the joints' limits, time taken.
fn save_durations(program: &Program, limits: &motion::MotionLimits, tally: &Tally) {
    let Some(path) = std::env::var_os("ELITE_DURATIONS") else {
        return;
    };
    let mut text = String::new();
    for motion in &tally.rest_to_rest {
        write!(text, "{},{}", program.model, program.step_time).unwrap();
        let numbers = motion
            .way
            .iter()
            .chain([&motion.speed, &motion.acceleration]);
        let numbers = numbers
            .chain(&limits.speed.0)
            .chain(&limits.acceleration.0)
            .chain(&limits.jerk.0);
        for number in numbers.chain([&motion.taken]) {
            write!(text, ",{number:e}").unwrap();
        }
        text.push('\n');
    }
    let mut options = std::fs::OpenOptions::new();
    let mut file = options.append(true).create(true).open(path).unwrap();
    file.write_all(text.as_bytes()).unwrap();
}

#[test]
fn random_programs_are_right_on_cs63() {
    every_program_is_right("cs63");
}

#[test]
fn random_programs_are_right_on_cs66() {
    every_program_is_right("cs66");
}

#[test]
fn random_programs_are_right_on_cs612() {
    every_program_is_right("cs612");
}

#[test]
fn random_programs_are_right_on_cs616() {
    every_program_is_right("cs616");
}

#[test]
fn random_programs_are_right_on_cs620() {
    every_program_is_right("cs620");
}

#[test]
fn random_programs_are_right_on_cs625() {
    every_program_is_right("cs625");
}

/// Light curtains instead of pauses, reduced mode instead of the slider: the same judge.
#[test]
fn random_programs_are_right_among_people() {
    let count = number("ELITE_PROGRAMS").unwrap_or(PROGRAMS / 3);
    let first = number("ELITE_FIRST").unwrap_or(0);
    let mut wrong = String::new();
    for model in ["cs63", "cs66", "cs612", "cs625"] {
        for seed in first..first + count {
            let program = Program::draw(model, seed).with_safety_inputs();
            let verdict = judge::judge(&program, &run::run(&program));
            if !verdict.faults.is_empty() {
                writeln!(wrong, "{model} {seed}: {}", verdict.faults.join("; ")).unwrap();
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Chains, force mode, hands, tools and payloads: the same judge.
#[test]
fn random_programs_of_everything_are_right() {
    let count = number("ELITE_PROGRAMS").unwrap_or(PROGRAMS / 2);
    let first = number("ELITE_FIRST").unwrap_or(0);
    let (mut all, mut wrong) = (Tally::default(), String::new());
    for model in ["cs63", "cs66", "cs612", "cs616", "cs620", "cs625"] {
        for seed in first..first + count {
            let program = Program::draw_of_everything(model, seed);
            let verdict = judge::judge(&program, &run::run(&program));
            if !verdict.faults.is_empty() {
                writeln!(wrong, "{model} {seed}: {}", verdict.faults.join("; ")).unwrap();
            }
            all.add(verdict.tally);
        }
    }
    println!(
        "{} motions, {} refused, {} joined, {} not blended; {:.1e} off the path, {:.1e} at the end",
        all.motions, all.refused, all.joined, all.not_joined, all.path_max, all.end_max
    );
    assert!(wrong.is_empty(), "{wrong}");
    assert!(3 * all.refused < all.motions && all.joined > all.motions / 3);
}

/// A belt that took a joint to its full speed while it still accelerated; blends on which the TCP was faster between
/// the places looked at than at any of them; a motion on a turntable that took too long, so that a stop ended tracking
/// with it; a slow clock that was to go fast again before a slower motion; lines that were planned past a singular
/// position into another branch of solutions. Among people: joints that braked each for itself led the TCP on a belt
/// faster than it may go in reduced mode; an arm that slowed down for reduced mode used no more acceleration than is
/// left at full speed; one that counted as slow while its braking joints would lead the TCP on, one that braked later
/// than planned. Of everything: one that braked for a slider that was lowered while its mean still sped up; lines whose
/// bend is largest between two places that were looked at; a hand that leads the arm along axes of a tool that it
/// turns.
#[test]
fn programs_that_were_wrong_once_are_right() {
    let among_people = [("cs612", 4), ("cs625", 40), ("cs625", 1022), ("cs63", 1073)];
    let programs = among_people.map(|(model, seed)| {
        let program = Program::draw(model, seed).with_safety_inputs();
        (model, seed, program)
    });
    let alone = [
        ("cs63", 107),
        ("cs63", 113),
        ("cs66", 451),
        ("cs625", 5100),
        ("cs616", 360),
        ("cs625", 411),
        ("cs63", 441),
        ("cs612", 257),
    ];
    let alone = alone.map(|(model, seed)| (model, seed, Program::draw(model, seed)));
    let everything = [
        ("cs620", 2084),
        ("cs625", 185),
        ("cs620", 283),
        ("cs63", 713),
        ("cs63", 720),
    ];
    let everything =
        everything.map(|(model, seed)| (model, seed, Program::draw_of_everything(model, seed)));
    for (model, seed, program) in programs.into_iter().chain(alone).chain(everything) {
        let verdict = judge::judge(&program, &run::run(&program));
        assert!(
            verdict.faults.is_empty(),
            "{model} {seed}: {:?}",
            verdict.faults
        );
    }
}
