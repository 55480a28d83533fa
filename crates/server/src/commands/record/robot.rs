//! The robot's two ports while it is recorded: connected to again when they are gone, and what they do not offer.

use std::time::Duration;

use robot_client::observed::{IN_A_CYCLE, KNOWN_VARIABLES};
use robot_client::{PrimaryClient, RobotAddress, RtsiClient, RtsiError, RtsiMessage};
use tokio::sync::mpsc;
use tokio::time::sleep;
use wire::primary::Message;
use wire::rtsi::RtsiType;

/// Between two attempts to reach a robot that is gone.
const RETRY: Duration = Duration::from_secs(1);

/// Asks for every variable that is known. A controller that does not take so long a list is asked for those that a
/// cycle has a place for.
pub(super) async fn connect(address: &RobotAddress, rate: f64) -> Result<RtsiClient, RtsiError> {
    let every: Vec<&str> = KNOWN_VARIABLES.iter().map(String::as_str).collect();
    match RtsiClient::connect(address, rate, &every).await {
        // Nobody there: nobody would be there again.
        Err(error @ RtsiError::Connect(_)) => Err(error),
        Err(error) => {
            let short = RtsiClient::connect(address, rate, IN_A_CYCLE).await;
            short.map_err(|_| error)
        }
        whole => whole,
    }
}

/// What comes of the connection for data.
#[derive(Debug)]
pub(super) enum RtsiEvent {
    /// Values or a text.
    Arrival(RtsiMessage),
    /// The connection is gone, for this reason.
    Gone(RtsiError),
    /// The connection is there again, with these variables.
    Again(Vec<(String, RtsiType)>),
}

/// Takes what comes from a connection and goes on with a new one when it is gone. Ends when nobody listens.
///
/// Has a channel of its own, so that whatever else happens meanwhile does not interrupt an attempt.
pub(super) async fn follow(
    mut rtsi: RtsiClient,
    address: RobotAddress,
    rate: f64,
    sender: mpsc::Sender<RtsiEvent>,
) {
    loop {
        let why = loop {
            match rtsi.next().await {
                Ok(arrival) => {
                    if sender.send(RtsiEvent::Arrival(arrival)).await.is_err() {
                        return;
                    }
                }
                Err(why) => break why,
            }
        };
        if sender.send(RtsiEvent::Gone(why)).await.is_err() {
            return;
        }
        rtsi = loop {
            sleep(RETRY).await;
            if let Ok(rtsi) = connect(&address, rate).await {
                break rtsi;
            }
        };
        let again = RtsiEvent::Again(rtsi.offered().to_vec());
        if sender.send(again).await.is_err() {
            return;
        }
    }
}

/// Listens to port 30001 for as long as there is somebody who takes it; comes back to a robot that was gone.
pub(super) async fn listen(address: RobotAddress, sender: mpsc::Sender<Message>) {
    loop {
        if let Ok(mut robot) = PrimaryClient::connect(&address).await {
            while let Ok(message) = robot.next().await {
                // States come again; what is reported comes once and has half of the room for itself.
                let is_state = matches!(message, Message::State(_));
                if is_state && sender.capacity() <= sender.max_capacity() / 2 {
                    continue;
                }
                // Of more reports than there is room for, the rest is left out: the robot sends few.
                let _ = sender.try_send(message);
            }
        }
        sleep(RETRY).await;
    }
}

/// Variables that are known and that the controller does not have, in words; registers by their groups.
pub(super) fn not_offered(rtsi: &RtsiClient) -> Option<String> {
    let has = |name: &str| rtsi.offered().iter().any(|(offered, _)| offered == name);
    let missing = KNOWN_VARIABLES
        .iter()
        .map(String::as_str)
        .filter(|name| !has(name));
    in_words(missing)
}

fn in_words<'a>(names: impl Iterator<Item = &'a str>) -> Option<String> {
    let mut words: Vec<(String, &str, usize)> = Vec::new();
    for name in names {
        let group = name.trim_end_matches(|c: char| c.is_ascii_digit());
        let is_register = group.ends_with("_register");
        match words.last_mut() {
            Some((last, _, count)) if is_register && last == group => *count += 1,
            _ => {
                let group = if is_register { group } else { name };
                words.push((group.to_owned(), name, 1));
            }
        }
    }
    let words = words.into_iter().map(|(group, name, count)| match count {
        1 => name.to_owned(),
        _ => format!("{count} × {group}"),
    });
    let words: Vec<String> = words.collect();
    (!words.is_empty()).then(|| words.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_said_in_few_words() {
        assert_eq!(in_words(std::iter::empty()), None);
        let names = [
            "tool_digital0_mode",
            "output_bit_registers0_to_31",
            "output_int_register4",
            "output_int_register5",
            "input_double_register47",
        ];
        assert_eq!(
            in_words(names.into_iter()).unwrap(),
            "tool_digital0_mode, output_bit_registers0_to_31, 2 × output_int_register, input_double_register47"
        );
    }
}
