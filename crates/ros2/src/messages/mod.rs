//! The messages of ROS 2 that the controller speaks, with the text of their definitions.
//!
//! Fields, their order and their types are those of ROS 2 Jazzy and of the vendor's driver 1.0.3: what serde makes of
//! a type as CDR is what a ROS node reads. A definition is made from the struct, so the two cannot differ.

mod control;
mod elite;
mod parameters;
mod standard;

pub use control::*;
pub use elite::*;
pub use parameters::*;
pub use standard::*;

/// Definitions that a message needs: names as `package/Name` with their text, each once, in the order of their first
/// use.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Definitions(Vec<(&'static str, String)>);

impl Definitions {
    /// The text as bags keep it (`ros2msg`): the first definition, then those that it needs, with lines between.
    pub fn joined(&self) -> String {
        let mut text = String::new();
        for (position, (name, definition)) in self.0.iter().enumerate() {
            if position > 0 {
                text.push_str(&"=".repeat(80));
                text.push_str("\nMSG: ");
                text.push_str(name);
                text.push('\n');
            }
            text.push_str(definition);
        }
        text
    }

    fn add(&mut self, name: &'static str, text: impl FnOnce() -> String) -> bool {
        if self.0.iter().any(|(known, _)| *known == name) {
            return false;
        }
        self.0.push((name, text()));
        true
    }
}

/// What a field of a message can be.
pub trait FieldType {
    /// Adds the definitions that the type needs.
    fn define(definitions: &mut Definitions);
}

macro_rules! primitives {
    ($($name:ty),+) => { $(impl FieldType for $name { fn define(_: &mut Definitions) {} })+ };
}
primitives!(bool, u8, i8, u16, i32, u32, i64, u64, f64, String);

impl<T: FieldType> FieldType for Vec<T> {
    fn define(definitions: &mut Definitions) {
        T::define(definitions);
    }
}

impl<T: FieldType, const N: usize> FieldType for [T; N] {
    fn define(definitions: &mut Definitions) {
        T::define(definitions);
    }
}

/// A message of a topic.
pub trait Message: FieldType + serde::Serialize + serde::de::DeserializeOwned {
    /// The package, as `sensor_msgs`.
    const PACKAGE: &'static str;
    /// The name in its package, as `JointState`.
    const NAME: &'static str;

    /// The name as bags have it: `sensor_msgs/msg/JointState`.
    fn type_name() -> String {
        format!("{}/msg/{}", Self::PACKAGE, Self::NAME)
    }

    /// The definition with all that it needs.
    fn definition() -> String {
        let mut definitions = Definitions::default();
        Self::define(&mut definitions);
        definitions.joined()
    }

    /// The message as bags and networks carry it: CDR, little endian, with its header of four bytes.
    ///
    /// # Errors
    /// The encoder's; none of the messages here has what CDR cannot say.
    fn to_cdr(&self) -> Result<Vec<u8>, cdr_encoding::Error> {
        let mut bytes = vec![0, 1, 0, 0];
        bytes.extend(cdr_encoding::to_vec::<Self, byteorder::LittleEndian>(self)?);
        Ok(bytes)
    }

    /// The message that `bytes` hold, either byte order.
    ///
    /// # Errors
    /// The bytes are not one.
    fn from_cdr(bytes: &[u8]) -> Result<Self, cdr_encoding::Error> {
        let (head, body) = bytes.split_at_checked(4).ok_or(cdr_encoding::Error::Eof)?;
        match head {
            [0, 0, _, _] => cdr_encoding::from_bytes::<Self, byteorder::BigEndian>(body),
            [0, 1, _, _] => cdr_encoding::from_bytes::<Self, byteorder::LittleEndian>(body),
            _ => Err(cdr_encoding::Error::Message(
                "neither big nor little endian CDR".to_owned(),
            )),
        }
        .map(|(message, _)| message)
    }
}

/// Makes messages: the struct, its name in ROS, and its definition.
macro_rules! messages {
    ($(
        $(#[$doc:meta])*
        $name:ident = $package:literal / $ros:literal { $($field:ident: $type:ty = $text:literal,)* }
    )+) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
            pub struct $name {
                $(
                    #[doc = concat!("`", $text, "`")]
                    pub $field: $type,
                )*
            }

            impl $crate::messages::FieldType for $name {
                fn define(definitions: &mut $crate::messages::Definitions) {
                    let own = || {
                        let mut text = String::new();
                        $(text.push_str(concat!($text, "\n"));)*
                        text
                    };
                    if definitions.add(concat!($package, "/", $ros), own) {
                        $(<$type as $crate::messages::FieldType>::define(definitions);)*
                    }
                }
            }

            impl $crate::messages::Message for $name {
                const PACKAGE: &'static str = $package;
                const NAME: &'static str = $ros;
            }

            #[cfg(feature = "node")]
            impl ros2_client::Message for $name {}
        )+
    };
}
pub(crate) use messages;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_definition_has_all_it_needs_once_and_itself_first() {
        let text = JointTrajectory::definition();
        assert!(text.starts_with("std_msgs/Header header\nstring[] joint_names\n"));
        for name in [
            "std_msgs/Header",
            "builtin_interfaces/Time",
            "trajectory_msgs/JointTrajectoryPoint",
            "builtin_interfaces/Duration",
        ] {
            assert_eq!(text.matches(&format!("MSG: {name}\n")).count(), 1, "{text}");
        }
    }

    #[test]
    fn a_message_survives_cdr_in_both_byte_orders() {
        let message = JointState {
            header: Header {
                stamp: Time {
                    sec: 3,
                    nanosec: 4_000_000,
                },
                frame_id: "base".to_owned(),
            },
            name: vec!["a".to_owned(), "bcd".to_owned()],
            position: vec![1.0, -2.0],
            velocity: vec![],
            effort: vec![0.5],
        };
        let bytes = message.to_cdr().unwrap();
        assert_eq!(JointState::from_cdr(&bytes).unwrap(), message);
        let mut big = vec![0, 0, 0, 0];
        let body = cdr_encoding::to_vec::<_, byteorder::BigEndian>(&message).unwrap();
        big.extend(body);
        assert_eq!(JointState::from_cdr(&big).unwrap(), message);
        for wrong in [&bytes[..3], &bytes[..20], &[9, 9, 0, 0][..]] {
            assert!(JointState::from_cdr(wrong).is_err());
        }
    }
}
