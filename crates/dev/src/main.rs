//! `cargo dev`: commands for those who work on the controller.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::{Parser, Subcommand};
use dev::campaign::{Case, TargetReport, limit_resources, minimize, run_cases, run_target};
use dev::targets::{target, targets};

#[derive(Parser)]
#[command(
    name = "cargo dev",
    about = "Commands for those who work on the controller"
)]
struct DevCli {
    #[command(subcommand)]
    command: DevCommand,
}

#[derive(Subcommand)]
enum DevCommand {
    /// Tries every decoder with hostile inputs, each in a process of its own, and tells what was found
    Campaign {
        /// Only these targets
        targets: Vec<String>,
        /// Seconds for each target
        #[arg(long, default_value_t = 10.0)]
        seconds: f64,
        /// Cases of each target at most
        #[arg(long, default_value_t = u64::MAX)]
        count: u64,
        /// The inputs are a function of this number
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// The first case
        #[arg(long, default_value_t = 0)]
        from: u64,
        /// Folder for the inputs of findings
        #[arg(long, default_value = "target/campaign-findings")]
        keep: PathBuf,
        /// The program that the faults are tried on (fuzz/faults.py), after the targets if all of them run
        #[arg(long, default_value = "target/debug/eliteserver")]
        binary: PathBuf,
        /// Leave the faults out
        #[arg(long)]
        no_faults: bool,
    },
    /// Prints the input of one case, or runs it
    Case {
        target: String,
        number: u64,
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Run it in this process instead of printing it
        #[arg(long)]
        run: bool,
    },
    /// Runs a file as the input of a target
    File { target: String, path: PathBuf },
    /// Makes a finding smaller and prints it
    Shrink {
        /// Of which target
        target: String,
        /// The input
        path: PathBuf,
    },
    /// Prints the input that material of a generator stands for
    Show {
        /// Of which target
        target: String,
        /// The material
        path: PathBuf,
    },
    /// Writes the seeds of a target into a folder, for a fuzzer to begin with
    Seeds {
        /// Of which target
        target: String,
        /// Where to
        folder: PathBuf,
    },
    /// The targets and what they read
    Targets,
    /// Writes the pages of all functions of the robot: docs/reference and docs/zh/reference
    #[cfg(feature = "ports")]
    Reference,
    /// Figures of names and comments: types that are no nouns, shared names, comments that lean on others, long
    /// functions and lines
    #[cfg(feature = "names")]
    Names {
        /// Only these crates
        crates: Vec<String>,
        /// List every finding with its place instead of the table
        #[arg(long)]
        list: bool,
    },
    /// What the campaign starts
    #[command(hide = true)]
    Cases {
        target: String,
        #[arg(long)]
        seed: u64,
        #[arg(long)]
        from: u64,
        #[arg(long)]
        count: u64,
        #[arg(long)]
        seconds: f64,
        #[arg(long)]
        progress: PathBuf,
    },
}

fn main() -> ExitCode {
    match obey(DevCli::parse().command) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn obey(order: DevCommand) -> Result<ExitCode, Box<dyn std::error::Error>> {
    match order {
        #[cfg(feature = "ports")]
        DevCommand::Reference => {
            let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
            for made in dev::reference::make(&root)? {
                let path = root.join(made.path);
                if let Some(folder) = path.parent() {
                    std::fs::create_dir_all(folder)?;
                }
                std::fs::write(path, made.text)?;
            }
            Ok(ExitCode::SUCCESS)
        }
        #[cfg(feature = "names")]
        DevCommand::Names { crates, list } => {
            std::io::stdout().write_all(name_figures(&crates, list)?.as_bytes())?;
            Ok(ExitCode::SUCCESS)
        }
        DevCommand::Campaign {
            targets: names,
            seconds,
            count,
            seed,
            from,
            keep,
            binary,
            no_faults,
        } => {
            let with_faults = names.is_empty() && !no_faults;
            let time = Duration::from_secs_f64(seconds);
            let is_clean = campaign(names, seed, from, count, time, &keep)?;
            let is_clean = is_clean & (!with_faults || faults(&binary, seed)?);
            Ok(if is_clean {
                ExitCode::SUCCESS
            } else {
                ExitCode::FAILURE
            })
        }
        DevCommand::Case {
            target: name,
            number,
            seed,
            run,
        } => {
            let target = known(&name)?;
            let input = target.input(&(target.seeds)(), seed, number);
            if run {
                limit_resources();
                (target.check)(&input);
            } else {
                std::io::stdout().write_all(&input)?;
            }
            Ok(ExitCode::SUCCESS)
        }
        DevCommand::File { target: name, path } => {
            limit_resources();
            (known(&name)?.check)(&std::fs::read(path)?);
            Ok(ExitCode::SUCCESS)
        }
        DevCommand::Shrink { target: name, path } => {
            known(&name)?;
            let (input, answer) = minimize(&name, &std::fs::read(path)?)?;
            eprintln!("{answer}");
            std::io::stdout().write_all(&input)?;
            Ok(ExitCode::SUCCESS)
        }
        DevCommand::Show { target: name, path } => {
            let input = (known(&name)?.render_input)(&std::fs::read(path)?);
            std::io::stdout().write_all(&input)?;
            Ok(ExitCode::SUCCESS)
        }
        DevCommand::Seeds {
            target: name,
            folder,
        } => {
            std::fs::create_dir_all(&folder)?;
            for (number, seed) in (known(&name)?.seeds)().into_iter().enumerate() {
                std::fs::write(folder.join(format!("seed-{number}")), seed)?;
            }
            Ok(ExitCode::SUCCESS)
        }
        DevCommand::Targets => {
            for target in targets() {
                writeln!(std::io::stdout(), "{:14} {}", target.name, target.about)?;
            }
            Ok(ExitCode::SUCCESS)
        }
        DevCommand::Cases {
            target: name,
            seed,
            from,
            count,
            seconds,
            progress,
        } => {
            run_cases(&Case {
                target: known(&name)?,
                seed,
                from,
                count,
                time: Duration::from_secs_f64(seconds),
                progress: &progress,
            })?;
            Ok(ExitCode::SUCCESS)
        }
    }
}

/// Runs the targets of these names, or all of them, prints the table, and keeps the inputs of findings in `folder`;
/// whether there were none.
fn campaign(
    names: Vec<String>,
    seed: u64,
    from: u64,
    count: u64,
    time: Duration,
    folder: &Path,
) -> Result<bool, Box<dyn std::error::Error>> {
    let names = if names.is_empty() {
        targets()
            .iter()
            .map(|target| target.name.to_owned())
            .collect()
    } else {
        names
    };
    for name in &names {
        known(name)?;
    }
    let mut reports = Vec::new();
    for name in names {
        let report = run_target(&name, seed, from, count, time)?;
        eprintln!(
            "{name}: {} cases, {} kinds of findings",
            report.cases,
            report.found.len()
        );
        save_findings(&report, seed, folder)?;
        reports.push(report);
    }
    std::io::stdout().write_all(table(&reports, seed).as_bytes())?;
    Ok(reports.iter().all(|report| report.found.is_empty()))
}

/// The table of `cargo dev names`, or the list of what it counts.
#[cfg(feature = "names")]
fn name_figures(only: &[String], is_list: bool) -> Result<String, dev::names::NamesError> {
    use dev::names::{Findings, Inventory, scan_workspace, table};

    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut all = Inventory::default();
    for inventory in scan_workspace(&root, only)?.values_mut() {
        all.append(inventory);
    }
    Ok(if is_list {
        Findings::of(&all).list(&root)
    } else {
        table(&scan_workspace(&root, only)?, &all)
    })
}

fn known(name: &str) -> Result<&'static dev::targets::Target, String> {
    target(name)
        .ok_or_else(|| format!("there is no target {name:?}; `cargo dev targets` lists them"))
}

/// Tries faults around the controller; whether every promise held.
fn faults(binary: &Path, seed: u64) -> Result<bool, Box<dyn std::error::Error>> {
    if !binary.exists() {
        return Err(format!("there is no {}; `cargo build` makes it", binary.display()).into());
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/faults.py");
    let mut command = std::process::Command::new("python3");
    command
        .arg(script)
        .arg(binary)
        .args(["--seed", &seed.to_string()]);
    Ok(command.status()?.success())
}

/// Writes the first input of each kind of finding to the folder.
fn save_findings(
    report: &TargetReport,
    seed: u64,
    folder: &Path,
) -> Result<(), Box<dyn std::error::Error>> {
    let target = known(&report.name)?;
    let seeds = (target.seeds)();
    for found in report.found.values() {
        std::fs::create_dir_all(folder)?;
        let file = folder.join(format!("{}-{seed}-{}", report.name, found.number));
        std::fs::write(file, target.input(&seeds, seed, found.number))?;
    }
    Ok(())
}

/// One line a target, and one for each kind of finding with the command that repeats it.
fn table(reports: &[TargetReport], seed: u64) -> String {
    let mut out = format!(
        "{:14} {:>12} {:>10} {:>9}\n",
        "target", "cases", "a second", "findings"
    );
    for report in reports {
        let rate = report.cases as f64 / report.time.as_secs_f64().max(1e-3);
        out += &format!(
            "{:14} {:>12} {:>10.0} {:>9}\n",
            report.name,
            report.cases,
            rate,
            report.found.len()
        );
        for (what, found) in &report.found {
            out += &format!("    {} times: {what}\n", found.times);
            out += &format!(
                "        cargo dev case {} {} --seed {seed}\n",
                report.name, found.number
            );
        }
    }
    out
}
