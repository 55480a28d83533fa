//! An option as whoever has texts for it sees it: its type does not matter, only what it makes of the texts.

use std::net::IpAddr;
use std::path::PathBuf;
use std::str::FromStr;

use super::values::{
    ByteSize, ClockChoice, HomeJoints, ModelChoice, PayloadChoice, Permission, PlantChoice,
    RecordTarget, RotationLimit, StepMillis, Tcp,
};

/// A text that an option does not take.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RefusedValue {
    /// The text.
    pub given: String,
    /// What is allowed, as a sentence without its end.
    pub allowed: String,
}

/// A value that is made of one text.
pub trait OptionValue: Sized {
    /// The value of the text, or what is allowed.
    ///
    /// # Errors
    /// What is allowed, as a sentence without its end.
    fn from_option(text: &str) -> Result<Self, String>;
}

/// Makes [`OptionValue`]s of types that read themselves, and whose error says what is allowed.
#[macro_export]
macro_rules! option_values {
    ($($value:ty),* $(,)?) => {
        $(impl $crate::options::OptionValue for $value {
            fn from_option(text: &str) -> Result<Self, String> {
                text.parse().map_err(|allowed| format!("{allowed}"))
            }
        })*
    };
}

option_values!(
    ByteSize,
    ClockChoice,
    HomeJoints,
    ModelChoice,
    PathBuf,
    PayloadChoice,
    Permission,
    PlantChoice,
    RecordTarget,
    RotationLimit,
    StepMillis,
    Tcp
);

fn parsed<T: FromStr>(text: &str, allowed: &str) -> Result<T, String> {
    text.parse().map_err(|_| allowed.to_owned())
}

impl OptionValue for bool {
    fn from_option(text: &str) -> Result<Self, String> {
        parsed(text, "allowed are true and false")
    }
}

impl OptionValue for u64 {
    fn from_option(text: &str) -> Result<Self, String> {
        parsed(text, "allowed are whole numbers from 0")
    }
}

impl OptionValue for u32 {
    fn from_option(text: &str) -> Result<Self, String> {
        parsed(text, "allowed are whole numbers from 0")
    }
}

impl OptionValue for u16 {
    fn from_option(text: &str) -> Result<Self, String> {
        parsed(text, "allowed are whole numbers from 0 to 65535")
    }
}

impl OptionValue for IpAddr {
    fn from_option(text: &str) -> Result<Self, String> {
        parsed(text, "allowed is an IP address")
    }
}

/// One option, with a value or without.
pub trait OptionSlot {
    /// True for an option that may be given several times: a list is several values then, otherwise the numbers of one.
    fn is_list(&self) -> bool;

    /// True when the option has a value.
    fn is_given(&self) -> bool;

    /// Reads the texts, one for an option that is no list. A value that is there already stays: whoever comes first
    /// counts, and what is wrong is refused all the same.
    ///
    /// # Errors
    /// [`RefusedValue`]: the text that is wrong.
    fn fill(&mut self, texts: &[String]) -> Result<(), RefusedValue>;
}

fn value_of<T: OptionValue>(text: &str) -> Result<T, RefusedValue> {
    T::from_option(text).map_err(|allowed| RefusedValue {
        given: text.to_owned(),
        allowed,
    })
}

impl<T: OptionValue> OptionSlot for Option<T> {
    fn is_list(&self) -> bool {
        false
    }

    fn is_given(&self) -> bool {
        self.is_some()
    }

    fn fill(&mut self, texts: &[String]) -> Result<(), RefusedValue> {
        let [text] = texts else {
            return Err(RefusedValue {
                given: texts.join(","),
                allowed: "one value is needed".to_owned(),
            });
        };
        let value = value_of(text)?;
        self.get_or_insert(value);
        Ok(())
    }
}

/// An option that may be given several times.
impl<T: OptionValue> OptionSlot for Option<Vec<T>> {
    fn is_list(&self) -> bool {
        true
    }

    fn is_given(&self) -> bool {
        self.is_some()
    }

    fn fill(&mut self, texts: &[String]) -> Result<(), RefusedValue> {
        let values: Result<Vec<T>, RefusedValue> =
            texts.iter().map(|text| value_of(text)).collect();
        let values = values?;
        self.get_or_insert(values);
        Ok(())
    }
}
