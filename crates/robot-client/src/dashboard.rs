//! Questions to the dashboard, port 29999, that other commands need answered.

use std::time::Duration;

use tokio::io::{AsyncBufReadExt, AsyncReadExt, AsyncWriteExt, BufReader};
use tokio::time::timeout;

use crate::address::RobotAddress;

/// Who asks waits no longer than this: without an answer it goes on.
const PATIENCE: Duration = Duration::from_millis(800);
/// Longest line that is read.
const LINE_BYTES_MAX: u64 = 4096;

/// Whether the robot takes orders from outside: `Some(false)` in local mode, `None` if nobody says so.
pub async fn is_remote(address: &RobotAddress) -> Option<bool> {
    let answer = answers(address, &["remoteControl -s"]).await?;
    match answer.first()?.to_ascii_lowercase().as_str() {
        "true" => Some(true),
        "false" => Some(false),
        _ => None,
    }
}

/// Whether it is a simulated controller of ours, which says so in the place of its serial number.
pub async fn is_simulated(address: &RobotAddress) -> bool {
    let answers = answers(address, &["robot -s"]).await;
    answers.is_some_and(|answers| answers.iter().any(|answer| answer.starts_with("SIM-")))
}

/// The values of global variables of the program that runs, as it would print them; `None` for one that the robot does
/// not know, or if nobody says so.
pub async fn variables(address: &RobotAddress, names: &[String]) -> Vec<Option<String>> {
    let questions = names.iter().map(|name| format!("variable -get {name}"));
    let questions: Vec<String> = questions.collect();
    let questions: Vec<&str> = questions.iter().map(String::as_str).collect();
    let answers = answers(address, &questions).await.unwrap_or_default();
    let mut values: Vec<_> = answers.iter().map(|answer| value_of(answer)).collect();
    values.resize(names.len(), None);
    values
}

/// The value in an answer; other controllers put the name before it.
fn value_of(answer: &str) -> Option<String> {
    let is_unknown = ["Error", "undefined", "Can not find"]
        .iter()
        .any(|word| answer.contains(word));
    (!is_unknown && !answer.is_empty()).then(|| answer.to_owned())
}

/// One line for every question; `None` if the dashboard does not answer all of them in time.
async fn answers(address: &RobotAddress, questions: &[&str]) -> Option<Vec<String>> {
    let asking = timeout(PATIENCE, ask(address, questions));
    asking.await.ok().flatten()
}

async fn ask(address: &RobotAddress, questions: &[&str]) -> Option<Vec<String>> {
    let stream = address.connect().await.ok()?;
    let limit = LINE_BYTES_MAX * (questions.len() as u64 + 1);
    let mut lines = BufReader::new(stream).take(limit);
    let mut line = String::new();
    // The server greets first, in one line or in several, which arrive together.
    lines.read_line(&mut line).await.ok()?;
    let greeting = lines.get_ref().buffer().len();
    lines.consume(greeting);
    let mut answers = Vec::with_capacity(questions.len());
    for question in questions {
        let stream = lines.get_mut().get_mut();
        stream
            .write_all(format!("{question}\n").as_bytes())
            .await
            .ok()?;
        line.clear();
        lines.read_line(&mut line).await.ok()?;
        answers.push(line.trim().to_owned());
    }
    Some(answers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_what_is_no_complaint() {
        assert_eq!(value_of("[1, 2]"), Some("[1, 2]".to_owned()));
        assert_eq!(value_of("speed, 0.25"), Some("speed, 0.25".to_owned()));
        for answer in ["", "Error: variable b is undefined", "Can not find b"] {
            assert_eq!(value_of(answer), None);
        }
    }
}
