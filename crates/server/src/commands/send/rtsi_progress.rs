//! What RTSI tells beside the states of port 30001 while a program runs: its line, and how fast the TCP moves.
//!
//! Only a terminal's last line is made of it. A robot that does not offer it is shown without.

use std::sync::Arc;
use std::time::Duration;

use elite_syntax::SourceFile;
use robot_client::{RobotAddress, RtsiClient, RtsiMessage};
use tokio::sync::watch;
use wire::rtsi::RtsiValue;

/// Rate of the data, Hz: that at which the line is drawn.
const RATE_HZ: f64 = 10.0;
/// Pause between two attempts to connect.
const RETRY: Duration = Duration::from_secs(2);
const WANTED: &[&str] = &["script_control_line", "actual_TCP_speed"];

/// What was told last.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct RtsiProgress {
    /// Line of the program as sent, from 1.
    pub line: Option<u32>,
    /// Speed of the TCP, m/s.
    pub speed: Option<f64>,
}

/// Listens for as long as it is polled; never returns.
pub(super) async fn listen(address: RobotAddress, told: watch::Sender<RtsiProgress>) {
    loop {
        if let Ok(mut rtsi) = RtsiClient::connect(&address, RATE_HZ, WANTED).await {
            while let Ok(arrival) = rtsi.next().await {
                if let RtsiMessage::Data(values) = arrival {
                    // Whoever looks at it lives as long as this.
                    let _ = told.send(of(
                        rtsi.offered().iter().map(|(name, _)| name.as_str()),
                        &values,
                    ));
                }
            }
        }
        let _ = told.send(RtsiProgress::default());
        tokio::time::sleep(RETRY).await;
    }
}

fn of<'a>(names: impl Iterator<Item = &'a str>, values: &[RtsiValue]) -> RtsiProgress {
    let mut told = RtsiProgress::default();
    for (name, value) in names.zip(values) {
        match (name, value) {
            ("script_control_line", RtsiValue::U32(line)) => told.line = Some(*line),
            ("actual_TCP_speed", RtsiValue::Vector6([x, y, z, ..])) => {
                told.speed = Some((x * x + y * y + z * z).sqrt());
            }
            _ => {}
        }
    }
    told
}

/// A node of the pendant's task, as a file names it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct NamedNode {
    pub number: String,
    pub label: String,
}

/// The nodes of the pendant's task that a file names, by the lines they stand in.
#[derive(Clone, Debug, Default)]
pub(super) struct NodeTracker(Vec<(u32, NamedNode)>);

impl NodeTracker {
    /// Of lines such as `$ LINE: (7, "Approach")`. The file has been checked.
    pub(super) fn of(file: &Arc<SourceFile>) -> Self {
        let lines = file.text().lines().zip(1_u32..);
        let nodes = lines.filter_map(|(line, number)| {
            let rest = line.trim_start().strip_prefix('$')?.trim_start();
            let rest = rest.strip_prefix("LINE")?.trim_start().strip_prefix(':')?;
            let (node, label) = rest.trim().strip_prefix('(')?.split_once(',')?;
            let label = label.trim_start();
            let quote = label.chars().next().filter(|c| matches!(c, '"' | '\''))?;
            let label = label[1..].split(quote).next()?;
            let is_number = node.trim().parse::<u32>().is_ok();
            let node = || NamedNode {
                number: node.trim().to_owned(),
                label: label.to_owned(),
            };
            is_number.then(|| (number, node()))
        });
        Self(nodes.collect())
    }

    /// The node that a line belongs to.
    pub(super) fn at(&self, line: u32) -> Option<&NamedNode> {
        let after = self.0.partition_point(|(at, _)| *at <= line);
        let (_, node) = self.0.get(after.checked_sub(1)?)?;
        Some(node)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_belongs_to_the_last_node_before_it() {
        let text = "x = 1\n$ LINE: (3, \"摆动\")\nmovej(a)\n  $ LINE : (12,'Approach' , \"after\")\n\
            $ OTHER: (1, \"x\")\n$ LINE: (x, \"y\")\nmovej(b)\n";
        let nodes = NodeTracker::of(&SourceFile::new("task", text));
        let at = [1, 2, 3, 4, 7, 999].map(|line| {
            let node = nodes.at(line)?;
            Some((node.number.as_str(), node.label.as_str()))
        });
        let (swing, approach) = (Some(("3", "摆动")), Some(("12", "Approach")));
        assert_eq!(at, [None, swing, swing, approach, approach, approach]);
    }

    #[test]
    fn values_have_their_names() {
        let values = [
            RtsiValue::Vector6([0.0, 0.3, -0.4, 9.0, 9.0, 9.0]),
            RtsiValue::U32(7),
        ];
        let names = ["actual_TCP_speed", "script_control_line"];
        let told = of(names.into_iter(), &values);
        assert_eq!((told.line, told.speed), (Some(7), Some(0.5)));
        assert_eq!(of(names.into_iter(), &values[..1]).line, None);
    }
}
