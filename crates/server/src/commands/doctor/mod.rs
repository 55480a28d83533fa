//! `eliteserver doctor`: whether this machine can run the controller as it is set up, and what to do where it cannot.
//!
//! Looks and tries, and changes nothing: the priority is asked for on a thread of its own, ports are opened and closed
//! again, what is written to try the disk is removed. Owns what is looked at and the words; the disk is in `disk`.

mod disk;

use std::fmt::Write as _;
use std::io::ErrorKind;
use std::net::TcpListener;
use std::num::NonZeroUsize;
use std::thread::available_parallelism;
use std::time::Duration;

use messages::{Language, Text, text};
use motion::realtime::{RealtimeOptions, SetupWarning};
use motion::rehearsal::{LatencyTest, run_latency_test};
use platform::machine;
use serde_json::{Value, json};

use crate::cli::FindingFormat;
use crate::command::CommandStatus;
use crate::config::ServeConfig;
use crate::language::{self, columns_of, padded};
use crate::options::PortSetting;

/// The timer is tried for about so long.
const TIMER_TRIED: Duration = Duration::from_secs(2);
/// Waking up later than that, one time in a hundred, is felt on an arm that a client leads cycle by cycle.
const LATE: Duration = Duration::from_micros(500);
/// Clocks that are read without leaving the processor, as Linux names them.
const FAST_CLOCK_SOURCES: [&str; 5] = [
    "tsc",
    "kvm-clock",
    "arch_sys_counter",
    "hyperv_clocksource_tsc_page",
    "riscv_clocksource",
];

/// How good something is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum CheckResult {
    /// The machine needs no change.
    Good,
    /// The controller runs, less well.
    Poor,
    /// The controller does not run so.
    Bad,
}

impl CheckResult {
    const fn name(self) -> Text {
        match self {
            Self::Good => Text::fixed("good", "良好"),
            Self::Poor => Text::fixed("poor", "欠佳"),
            Self::Bad => Text::fixed("bad", "不行"),
        }
    }
}

/// What one look has found.
#[derive(Clone, Debug, PartialEq)]
struct HealthCheck {
    subject: Text,
    grade: CheckResult,
    found: Text,
    /// What to do; empty where nothing is to be done.
    advice: Text,
}

impl HealthCheck {
    fn good(subject: Text, found: Text) -> Self {
        Self {
            subject,
            grade: CheckResult::Good,
            found,
            advice: Text::verbatim(""),
        }
    }

    const fn poor(subject: Text, found: Text, advice: Text) -> Self {
        Self {
            subject,
            grade: CheckResult::Poor,
            found,
            advice,
        }
    }

    const fn bad(subject: Text, found: Text, advice: Text) -> Self {
        Self {
            subject,
            grade: CheckResult::Bad,
            found,
            advice,
        }
    }
}

/// Looks at everything; the report, and the exit status: 0 the controller can run, 1 something keeps it from running.
pub fn doctor(config: &ServeConfig, format: FindingFormat) -> (String, CommandStatus) {
    let mut findings = vec![processors()];
    findings.extend(timing(config));
    findings.extend(clock_source());
    findings.extend(governor());
    findings.extend(ports(config));
    findings.extend(disk::look(&config.robot));
    let worst = findings.iter().map(|f| f.grade).max();
    let report = match format {
        FindingFormat::Human => to_text(&findings, language::chosen()),
        FindingFormat::Json => to_json(&findings),
    };
    (
        report,
        CommandStatus::of_answer(worst != Some(CheckResult::Bad)),
    )
}

fn to_text(findings: &[HealthCheck], language: Language) -> String {
    let subjects = findings.iter().map(|f| f.subject.in_language(language));
    let width = subjects.map(columns_of).max().unwrap_or(0);
    let mut out = String::new();
    for finding in findings {
        // Writing into a text cannot fail.
        let _ = writeln!(
            out,
            "{}  {}  {}",
            padded(finding.grade.name().in_language(language), 4),
            padded(finding.subject.in_language(language), width),
            finding.found.in_language(language),
        );
        if !finding.advice.is_empty() {
            let advice = finding.advice.in_language(language);
            let _ = writeln!(out, "      {:width$}  -> {advice}", "");
        }
    }
    let count = |grade| findings.iter().filter(|f| f.grade == grade).count();
    let sum = match (count(CheckResult::Bad), count(CheckResult::Poor)) {
        (0, 0) => text!("nothing is to be done", "无需处理"),
        (0, poor) => text!(
            "the controller runs; {poor} of it could be better",
            "控制器可以运行；有 {poor} 项可改善"
        ),
        (bad, _) => text!(
            "the controller does not start like this: {bad} to mend",
            "控制器这样无法启动：有 {bad} 项要处理"
        ),
    };
    let _ = writeln!(out, "{}", sum.in_language(language));
    out
}

/// One JSON object a line.
fn to_json(findings: &[HealthCheck]) -> String {
    let row = |finding: &HealthCheck| -> Value {
        json!({
            "subject": finding.subject,
            "grade": finding.grade.name(),
            "found": finding.found,
            "advice": finding.advice,
        })
    };
    findings.iter().map(|f| format!("{}\n", row(f))).collect()
}

fn processors() -> HealthCheck {
    let count = available_parallelism().map_or(1, NonZeroUsize::get);
    match count {
        1 => HealthCheck::poor(
            text!("processors", "处理器"),
            text!("1 core may be used", "可用 1 个核心"),
            text!(
                "give it two: the control cycle shares the one with every program and every client",
                "请给两个：否则控制周期要与所有程序和客户端共用一个核心"
            ),
        ),
        more => HealthCheck::good(
            text!("processors", "处理器"),
            text!("{more} cores may be used", "可用 {more} 个核心"),
        ),
    }
}

/// Priority, locked memory, and how late the motion thread would wake up.
fn timing(config: &ServeConfig) -> Vec<HealthCheck> {
    let step = Duration::from_secs_f64(config.robot.step.as_secs());
    let cycles = (TIMER_TRIED.as_secs_f64() / step.as_secs_f64()).ceil() as usize;
    match run_latency_test(RealtimeOptions::default(), step, cycles) {
        Ok(rehearsal) => timing_checks(&rehearsal, step),
        Err(error) => vec![HealthCheck::bad(
            text!("threads", "线程"),
            text!(
                "the operating system gives none: {error}",
                "操作系统不提供线程：{error}"
            ),
            text!(
                "raise the limit on processes (ulimit -u, TasksMax= of a unit)",
                "提高进程数上限（ulimit -u，单元的 TasksMax=）"
            ),
        )],
    }
}

fn timing_checks(rehearsal: &LatencyTest, step: Duration) -> Vec<HealthCheck> {
    let mut priority = HealthCheck::good(
        text!("priority", "优先级"),
        text!("real-time priority is given", "有实时优先级"),
    );
    let mut memory = HealthCheck::good(
        text!("memory", "内存"),
        text!("it can be locked", "可以锁定"),
    );
    for warning in &rehearsal.warnings {
        let found = Text::of(warning);
        match warning {
            SetupWarning::Priority { .. } => {
                priority = HealthCheck::poor(
                    text!("priority", "优先级"),
                    found,
                    text!(
                        "allow it: LimitRTPRIO=99 in a systemd unit, 'USER - rtprio 99' in /etc/security/limits.conf, \
                     or --cap-add SYS_NICE of a container",
                        "请允许：systemd 单元中 LimitRTPRIO=99，/etc/security/limits.conf 中 'USER - rtprio 99'，\
                         或容器的 --cap-add SYS_NICE"
                    ),
                );
            }
            SetupWarning::Memory { .. } => {
                memory = HealthCheck::poor(
                    text!("memory", "内存"),
                    found,
                    text!(
                        "allow it: LimitMEMLOCK=infinity in a systemd unit, 'USER - memlock unlimited' in \
                     /etc/security/limits.conf, or --ulimit memlock=-1 of a container",
                        "请允许：systemd 单元中 LimitMEMLOCK=infinity，/etc/security/limits.conf 中 'USER - memlock unlimited'，\
                         或容器的 --ulimit memlock=-1"
                    ),
                );
            }
            other => tracing::debug!("no advice for: {other}"),
        }
    }
    let micros = |time: Duration| time.as_micros();
    let found = text!(
        "woken {} µs late in the median, {} µs in 99 of 100 cycles, {} µs at most, of {} cycles of {} ms",
        "唤醒延迟：中位数 {} µs，百分之九十九的周期不超过 {} µs，最大 {} µs，共 {} 个 {} ms 的周期",
        micros(rehearsal.latency_permille(500)),
        micros(rehearsal.latency_permille(990)),
        micros(rehearsal.max_latency()),
        rehearsal.latencies.len(),
        step.as_secs_f64() * 1e3,
    );
    let advice = text!(
        "keep other load off this machine, set the governor to performance, and for a real cell use a \
        kernel with PREEMPT_RT; a virtual machine is never quite on time",
        "不要在本机上运行其他负载，调频策略设为 performance，真实单元请用带 PREEMPT_RT 的内核；虚拟机总会有些延迟"
    );
    let timer = if rehearsal.max_latency() > step {
        HealthCheck::poor(
            text!("timer", "定时器"),
            text!("{found}: cycles would be missed", "{found}：会错过周期"),
            advice,
        )
    } else if rehearsal.latency_permille(990) > LATE {
        HealthCheck::poor(text!("timer", "定时器"), found, advice)
    } else {
        HealthCheck::good(text!("timer", "定时器"), found)
    };
    vec![priority, memory, timer]
}

/// Linux tells which clock it reads; others do not.
fn clock_source() -> Option<HealthCheck> {
    let name = machine::clock_source()?;
    Some(match FAST_CLOCK_SOURCES.contains(&&*name) {
        true => HealthCheck::good(
            text!("clock", "时钟"),
            text!("{name}, read in nanoseconds", "{name}，读取只需几纳秒"),
        ),
        false => HealthCheck::poor(
            text!("clock", "时钟"),
            text!(
                "{name}, which takes a microsecond and more to read",
                "{name}，读取需一微秒以上"
            ),
            text!(
                "boot with clocksource=tsc tsc=reliable where the processor has an invariant counter",
                "处理器有恒定计数器时，以 clocksource=tsc tsc=reliable 启动系统"
            ),
        ),
    })
}

/// Checks the governor of the processors' frequency, where there is one.
fn governor() -> Option<HealthCheck> {
    let governors = machine::cpu_governors();
    if governors.is_empty() {
        return None;
    }
    Some(match governors.iter().all(|name| name == "performance") {
        true => HealthCheck::good(text!("governor", "调频策略"), Text::verbatim("performance")),
        false => HealthCheck::poor(
            text!("governor", "调频策略"),
            Text::verbatim(governors.join(", ")),
            text!(
                "cpupower frequency-set -g performance: a core that has slowed down wakes up late",
                "cpupower frequency-set -g performance：降频的核心唤醒较晚"
            ),
        ),
    })
}

/// Whether the ports of the services can be opened.
fn ports(config: &ServeConfig) -> Vec<HealthCheck> {
    let (mut free, mut findings) = (Vec::new(), Vec::new());
    for (_, option, setting) in config.ports.list() {
        let (mut port, otherwise) = match setting {
            PortSetting::Number(port) => (port, None),
            PortSetting::Either(port, otherwise) => (port, Some(otherwise)),
            PortSetting::Any | PortSetting::Off => continue,
        };
        let mut opened = TcpListener::bind((config.bind, port));
        if let (Err(error), Some(otherwise)) = (&opened, otherwise)
            && error.kind() == ErrorKind::PermissionDenied
        {
            port = otherwise;
            opened = TcpListener::bind((config.bind, port));
        }
        let Err(error) = opened else {
            free.push(port.to_string());
            continue;
        };
        let (found, advice) = match error.kind() {
            ErrorKind::AddrInUse => (
                text!(
                    "{port} on {} is taken by another program",
                    "{} 上的端口 {port} 已被其他程序占用",
                    config.bind
                ),
                text!(
                    "end it ('ss -ltnp sport = :{port}' names it), or choose another with {option}",
                    "结束该程序（'ss -ltnp sport = :{port}' 可查），或用 {option} 选择其他端口"
                ),
            ),
            ErrorKind::PermissionDenied => (
                text!(
                    "{port} may not be opened by this user",
                    "此用户不能打开端口 {port}"
                ),
                text!(
                    "choose one from 1024 on with {option}, or allow it: AmbientCapabilities=CAP_NET_BIND_SERVICE",
                    "用 {option} 选择 1024 以上的端口，或允许：AmbientCapabilities=CAP_NET_BIND_SERVICE"
                ),
            ),
            _ => (
                text!(
                    "{port} on {} cannot be opened: {error}",
                    "无法打开 {} 上的端口 {port}：{error}",
                    config.bind
                ),
                text!(
                    "is the address of --bind one of this machine's?",
                    "--bind 的地址是本机的吗？"
                ),
            ),
        };
        findings.push(HealthCheck::bad(text!("ports", "端口"), found, advice));
    }
    if !free.is_empty() {
        let found = text!(
            "{} on {} are free",
            "{1} 上的 {0} 空闲",
            free.join(", "),
            config.bind
        );
        findings.push(HealthCheck::good(text!("ports", "端口"), found));
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rehearsal(latencies: &[u64], warnings: Vec<SetupWarning>) -> LatencyTest {
        LatencyTest {
            warnings,
            latencies: latencies
                .iter()
                .copied()
                .map(Duration::from_micros)
                .collect(),
        }
    }

    #[test]
    fn late_timers_and_refused_priorities_come_with_advice() {
        let step = Duration::from_millis(4);
        let grades = |found: &[HealthCheck]| found.iter().map(|f| f.grade).collect::<Vec<_>>();
        let good = timing_checks(&rehearsal(&[10; 500], Vec::new()), step);
        assert_eq!(grades(&good), [CheckResult::Good; 3]);
        assert!(good.iter().all(|f| f.advice.is_empty()));

        let mut latencies = vec![10; 500];
        latencies[490..].fill(900);
        let refused = vec![
            SetupWarning::Priority {
                priority: 80,
                reason: Text::verbatim("not permitted"),
            },
            SetupWarning::Memory {
                reason: Text::verbatim("too little"),
            },
        ];
        let poor = timing_checks(&rehearsal(&latencies, refused), step);
        assert_eq!(grades(&poor), [CheckResult::Poor; 3]);
        assert!(
            poor[0].found.english().contains("not permitted")
                && poor[0].advice.english().contains("LimitRTPRIO")
        );
        assert!(poor[1].advice.english().contains("LimitMEMLOCK"));
        assert!(poor[2].found.english().contains("900 µs in 99 of 100"));

        latencies[499] = 5000;
        let missed = timing_checks(&rehearsal(&latencies, Vec::new()), step);
        assert!(
            missed[2]
                .found
                .english()
                .ends_with("cycles would be missed")
        );
    }

    #[test]
    fn reports_are_in_chinese_and_stand_below_each_other() {
        let step = Duration::from_millis(4);
        let mut findings = timing_checks(
            &rehearsal(
                &[900; 500],
                vec![SetupWarning::Memory {
                    reason: Text::of(&std::io::Error::from_raw_os_error(1)),
                }],
            ),
            step,
        );
        findings.push(HealthCheck::good(
            text!("recording", "记录"),
            text!("off", "关闭"),
        ));
        let text = to_text(&findings, Language::Chinese);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(
            lines,
            [
                "良好  优先级  有实时优先级",
                "欠佳  内存    无法锁定内存（不允许的操作（系统错误 1））；内存不足时周期可能延迟",
                "              -> 请允许：systemd 单元中 LimitMEMLOCK=infinity，/etc/security/limits.conf 中 'USER - memlock \
                 unlimited'，或容器的 --ulimit memlock=-1",
                "欠佳  定时器  唤醒延迟：中位数 900 µs，百分之九十九的周期不超过 900 µs，最大 900 µs，共 500 个 4 ms 的周期",
                "              -> 不要在本机上运行其他负载，调频策略设为 performance，真实单元请用带 PREEMPT_RT \
                 的内核；虚拟机总会有些延迟",
                "良好  记录    关闭",
                "控制器可以运行；有 2 项可改善",
            ]
        );
    }

    #[test]
    fn reports_have_a_line_for_each_and_the_worst_is_summed_up() {
        let findings = [
            HealthCheck::good(text!("timer", "定时器"), text!("on time", "准时")),
            HealthCheck::bad(
                text!("ports", "端口"),
                text!("30001 is taken", "30001 被占用"),
                text!("end it", "请结束它"),
            ),
        ];
        assert_eq!(
            to_text(&findings, Language::English),
            "good  timer  on time\nbad   ports  30001 is taken\n             -> end it\n\
             the controller does not start like this: 1 to mend\n"
        );
        let lines = to_json(&findings);
        let row: Value = serde_json::from_str(lines.lines().nth(1).unwrap()).unwrap();
        assert_eq!(
            (&row["grade"], &row["advice"]),
            (&json!("bad"), &json!("end it"))
        );
    }
}
