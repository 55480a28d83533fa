//! What pages and programs may ask for, read from JSON and checked: one table of orders with who may give them.
//!
//! Owns names, ranges and the words of refusal. Carrying an order out, and whether the arm may move at all, is the
//! controller's business: orders go the way of every other port's.

use messages::{Localized, Text, text};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use serde_json::Value;
use thiserror::Error;

use crate::jog::{JogAxis, JogFrame};

/// Longest text of a program, bytes.
pub const PROGRAM_BYTES_MAX: usize = 1 << 20;
/// Longest name of a program, bytes.
pub const NAME_BYTES_MAX: usize = 200;
/// Longest push, s.
const PUSH_SECS_MAX: f64 = 10.0;
/// Farthest place of a part along an axis, m.
const PLACE_MAX: f64 = 100.0;
/// Largest angle of a part's pose, rad.
const ANGLE_MAX: f64 = 100.0;
/// Largest push, N and Nm.
const PUSH_MAX: f64 = 500.0;

/// One message of a page: who it is, what it asks, or that it is still there.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PageRequest {
    /// Comes back with the answer.
    pub id: u64,
    /// What lets the page give orders; once is enough.
    pub token: Option<String>,
    /// Take control, or give it up.
    pub control: Option<bool>,
    /// What is held is still held.
    pub alive: bool,
    /// What is to be done.
    #[serde(deserialize_with = "strict")]
    pub order: Option<PageOrder>,
}

/// An order of a request without a page: the whole of it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct OrderBody(#[serde(deserialize_with = "strict")] pub Option<PageOrder>);

/// An order without anything that it does not know, also where it has no fields at all.
fn strict<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<PageOrder>, D::Error> {
    let Some(value) = Option::<Value>::deserialize(deserializer)? else {
        return Ok(None);
    };
    let fields = value.as_object().map_or(0, serde_json::Map::len);
    let order: PageOrder = serde_json::from_value(value).map_err(D::Error::custom)?;
    match order.is_bare() && fields > 1 {
        true => Err(D::Error::custom("this order takes no fields but `do`")),
        false => Ok(Some(order)),
    }
}

/// What is to be done.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
pub enum PageOrder {
    /// Power to the arm.
    PowerOn,
    /// Power off; the arm brakes first.
    PowerOff,
    /// Release the brakes.
    BrakeRelease,
    /// Leave a protective stop.
    Unlock,
    /// Clear a safety fault.
    RestartSafety,
    /// The emergency stop button.
    EmergencyStop {
        /// Pressed, or released again.
        pressed: bool,
    },
    /// A held program goes on, or the loaded task begins.
    Play,
    /// Hold the program.
    Pause,
    /// End the program; whatever moves comes to rest.
    Stop,
    /// A held program goes on to its next line.
    Step,
    /// Run a text.
    Run {
        /// What it is called.
        name: String,
        /// The program.
        text: String,
        /// Hold it at its first line.
        #[serde(default)]
        step: bool,
    },
    /// Run a file of the task folder.
    RunTask {
        /// Name of the file in that folder.
        name: String,
    },
    /// The speed slider.
    Speed {
        /// 0 to 1.
        fraction: f64,
    },
    /// Answer a popup.
    ClosePopup {
        /// Number of the popup.
        popup: u64,
        /// End the program as well.
        #[serde(default)]
        stop: bool,
    },
    /// Move one joint or one axis of the TCP as long as the page gives signs of life.
    Jog {
        /// Joint or axis that moves.
        axis: JogAxis,
        /// Whose axes those of the TCP are.
        #[serde(default)]
        frame: JogFrame,
        /// Share of the jog speed, -1 to 1.
        speed: f64,
    },
    /// Move to joint positions as long as the page gives signs of life.
    MoveTo {
        /// Target of each joint, rad.
        joints: [f64; 6],
        /// Share of the jog speed, above 0 to 1.
        #[serde(default = "full")]
        speed: f64,
    },
    /// The arm follows the hand as long as the page gives signs of life.
    Freedrive,
    /// End of what is held: jog, move, freedrive.
    Release,
    /// A hand pushes the tool.
    Push {
        /// Force and moment, N and Nm.
        wrench: [f64; 6],
        /// Time that the wrench acts, s.
        duration: f64,
        /// Frame of the wrench.
        #[serde(default)]
        frame: JogFrame,
    },
    /// Set inputs, all or none: names of points to values.
    Inputs {
        /// Values by the names of points, in the form that `/api/inputs` takes.
        values: serde_json::Map<String, serde_json::Value>,
    },
    /// Put a part of the cell somewhere, at rest; while no program runs.
    PlacePart {
        /// Name of the part.
        part: String,
        /// Pose in the base frame: x, y, z, Rx, Ry, Rz, m and rad.
        pose: [f64; 6],
    },
    /// Set outputs by hand, all or none: names of points to values.
    Outputs {
        /// Values by the names of points, in the form that `inputs` takes.
        values: serde_json::Map<String, serde_json::Value>,
    },
}

const fn full() -> f64 {
    1.0
}

/// A reason why a request is no order, told in a sentence.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
pub enum OrderError {
    /// The text does not have the form of a request.
    #[error("this is no request: {0}")]
    #[zh("这不是请求：{0}")]
    Form(String),
    /// A number is outside its range.
    #[error("{name} is {given}; it must be {allowed}")]
    #[zh("{name} 为 {given}；应为 {allowed}")]
    Range {
        /// Name of the value.
        name: &'static str,
        /// The value as it was given.
        given: String,
        /// What is allowed.
        allowed: Text,
    },
}

impl PageRequest {
    /// Reads a message.
    ///
    /// # Errors
    /// [`OrderError`], in a sentence.
    pub fn read(text: &[u8]) -> Result<Self, OrderError> {
        let request: Self =
            serde_json::from_slice(text).map_err(|error| OrderError::Form(error.to_string()))?;
        if let Some(order) = &request.order {
            order.check()?;
        }
        Ok(request)
    }
}

impl PageOrder {
    /// Stopping and holding need no control; everything else does.
    pub const fn needs_control(&self) -> bool {
        !matches!(self, Self::Stop | Self::Pause | Self::Release)
    }

    /// Has no fields.
    const fn is_bare(&self) -> bool {
        matches!(
            self,
            Self::PowerOn
                | Self::PowerOff
                | Self::BrakeRelease
                | Self::Unlock
                | Self::RestartSafety
                | Self::Play
                | Self::Pause
                | Self::Stop
                | Self::Step
                | Self::Freedrive
                | Self::Release
        )
    }

    /// Goes on only while signs of life come, so it takes a page.
    pub const fn is_held(&self) -> bool {
        matches!(
            self,
            Self::Jog { .. } | Self::MoveTo { .. } | Self::Freedrive
        )
    }

    /// Looks at the numbers.
    ///
    /// # Errors
    /// [`OrderError::Range`] names the first that does not do.
    pub fn check(&self) -> Result<(), OrderError> {
        let range = |name, value: f64, is_good: bool, allowed| match is_good {
            true => Ok(()),
            false => Err(OrderError::Range {
                name,
                given: value.to_string(),
                allowed,
            }),
        };
        let finite = |name, values: &[f64; 6], most: f64, allowed| {
            let bad = values.iter().find(|x| !x.is_finite() || x.abs() > most);
            bad.map_or(Ok(()), |bad| range(name, *bad, false, allowed))
        };
        match self {
            Self::Speed { fraction } => {
                let is_good = (0.0..=1.0).contains(fraction);
                range(
                    "fraction",
                    *fraction,
                    is_good,
                    text!("from 0 to 1", "0 到 1"),
                )
            }
            Self::Jog { speed, .. } => {
                let is_good = (-1.0..=1.0).contains(speed) && *speed != 0.0;
                range(
                    "speed",
                    *speed,
                    is_good,
                    text!("from -1 to 1 and not 0", "-1 到 1 且不为 0"),
                )
            }
            Self::MoveTo { joints, speed } => {
                finite(
                    "joints",
                    joints,
                    1e3,
                    text!("finite angles in rad", "有限的角度（rad）"),
                )?;
                let is_good = *speed > 0.0 && *speed <= 1.0;
                range(
                    "speed",
                    *speed,
                    is_good,
                    text!("above 0 and at most 1", "大于 0 且不超过 1"),
                )
            }
            Self::Push {
                wrench, duration, ..
            } => {
                finite(
                    "wrench",
                    wrench,
                    PUSH_MAX,
                    text!("at most 500 N and Nm", "不超过 500 N 和 Nm"),
                )?;
                let is_good = *duration > 0.0 && *duration <= PUSH_SECS_MAX;
                range(
                    "duration",
                    *duration,
                    is_good,
                    text!("above 0 and at most 10 s", "大于 0 且不超过 10 s"),
                )
            }
            Self::Run { name, text, .. } => {
                let bytes = text.len();
                let allowed = text!("at most 1048576 bytes long", "不超过 1048576 字节");
                range("text", bytes as f64, bytes <= PROGRAM_BYTES_MAX, allowed)?;
                check_name("name", name)
            }
            Self::RunTask { name } => check_name("name", name),
            Self::PlacePart { part, pose } => {
                check_name("part", part)?;
                let (place, angles) = pose.split_at(3);
                let most = |name, values: &[f64], most: f64, allowed| {
                    let bad = values.iter().find(|x| !x.is_finite() || x.abs() > most);
                    bad.map_or(Ok(()), |bad| range(name, *bad, false, allowed))
                };
                most(
                    "pose",
                    place,
                    PLACE_MAX,
                    text!("at most 100 m from the base", "距基座不超过 100 m"),
                )?;
                most(
                    "pose",
                    angles,
                    ANGLE_MAX,
                    text!("angles of at most 100 rad", "不超过 100 rad 的角度"),
                )
            }
            _ => Ok(()),
        }
    }
}

fn check_name(what: &'static str, name: &str) -> Result<(), OrderError> {
    let is_good = !name.trim().is_empty()
        && name.len() <= NAME_BYTES_MAX
        && !name.chars().any(char::is_control);
    match is_good {
        true => Ok(()),
        false => Err(OrderError::Range {
            name: what,
            given: format!("{:?}", name.chars().take(40).collect::<String>()),
            allowed: text!(
                "a name of at most 200 bytes without control characters",
                "不超过 200 字节、不含控制字符的名称"
            ),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn order(text: &str) -> Result<PageOrder, String> {
        let request = format!(r#"{{"id": 1, "order": {text}}}"#);
        let read = PageRequest::read(request.as_bytes()).map_err(|error| error.to_string())?;
        Ok(read.order.unwrap())
    }

    #[test]
    fn orders_are_read() {
        for (text, expected) in [
            (r#"{"do": "power_on"}"#, PageOrder::PowerOn),
            (
                r#"{"do": "speed", "fraction": 0.5}"#,
                PageOrder::Speed { fraction: 0.5 },
            ),
            (
                r#"{"do": "jog", "axis": "j3", "speed": -0.5}"#,
                PageOrder::Jog {
                    axis: JogAxis::J3,
                    frame: JogFrame::Base,
                    speed: -0.5,
                },
            ),
            (
                r#"{"do": "jog", "axis": "rz", "frame": "tool", "speed": 1}"#,
                PageOrder::Jog {
                    axis: JogAxis::Rz,
                    frame: JogFrame::Tool,
                    speed: 1.0,
                },
            ),
            (
                r#"{"do": "move_to", "joints": [0, 1, 2, 3, 4, 5]}"#,
                PageOrder::MoveTo {
                    joints: [0.0, 1.0, 2.0, 3.0, 4.0, 5.0],
                    speed: 1.0,
                },
            ),
        ] {
            assert_eq!(order(text), Ok(expected), "{text}");
        }
    }

    #[test]
    fn a_part_is_placed_under_control() {
        let read = order(r#"{"do": "place_part", "part": "box[3]", "pose": [1, 2, 3, 0, 0, 1.5]}"#);
        let placed = PageOrder::PlacePart {
            part: "box[3]".to_owned(),
            pose: [1.0, 2.0, 3.0, 0.0, 0.0, 1.5],
        };
        assert_eq!(read, Ok(placed.clone()));
        assert!(placed.needs_control() && !placed.is_held());
    }

    #[test]
    fn outputs_take_control_and_are_not_held() {
        let read = order(r#"{"do": "outputs", "values": {"standard_digital_out[1]": true}}"#);
        let read = read.unwrap();
        assert!(matches!(&read, PageOrder::Outputs { values } if values.len() == 1));
        assert!(read.needs_control() && !read.is_held());
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (text, part) in [
            (r#"{"do": "dance"}"#, "unknown variant `dance`"),
            (r#"{"do": "speed"}"#, "missing field `fraction`"),
            (
                r#"{"do": "speed", "fraction": 2}"#,
                "fraction is 2; it must be from 0 to 1",
            ),
            (
                r#"{"do": "jog", "axis": "j7", "speed": 1}"#,
                "unknown variant `j7`",
            ),
            (r#"{"do": "jog", "axis": "j1", "speed": 0}"#, "speed is 0"),
            (r#"{"do": "move_to", "joints": [1, 2]}"#, "length 2"),
            (
                r#"{"do": "move_to", "joints": [1, 2, 3, 4, 5, 1e9]}"#,
                "joints is 1000000000",
            ),
            (
                r#"{"do": "push", "wrench": [1,0,0,0,0,0], "duration": 100}"#,
                "duration is 100",
            ),
            (r#"{"do": "run", "name": "", "text": ""}"#, "name is \"\""),
            (r#"{"do": "run_task", "name": "a\nb"}"#, "name is"),
            (r#"{"do": "power_on", "now": true}"#, "takes no fields"),
            (
                r#"{"do": "place_part", "part": "box", "pose": [0, 0, 200, 0, 0, 0]}"#,
                "pose is 200; it must be at most 100 m from the base",
            ),
            (
                r#"{"do": "place_part", "part": "box", "pose": [0, 0, 0, 0, -101, 0]}"#,
                "pose is -101; it must be angles",
            ),
            (
                r#"{"do": "place_part", "part": " ", "pose": [0, 0, 0, 0, 0, 0]}"#,
                "part is \" \"",
            ),
            (
                r#"{"do": "place_part", "part": "box"}"#,
                "missing field `pose`",
            ),
        ] {
            let error = order(text).unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
    }

    #[test]
    fn to_stop_takes_no_control() {
        let free = [PageOrder::Stop, PageOrder::Pause, PageOrder::Release];
        assert!(free.iter().all(|order| !order.needs_control()));
        assert!(PageOrder::Unlock.needs_control() && PageOrder::Freedrive.is_held());
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn any_message_is_read_or_refused(
            bytes in proptest::collection::vec(any::<u8>(), 0..200),
            text in r#"[{}\[\]":,a-z0-9_ .-]{0,80}"#,
        ) {
            let _ = PageRequest::read(&bytes);
            let _ = PageRequest::read(text.as_bytes());
        }
    }
}
