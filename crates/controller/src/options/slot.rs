//! An option as whoever has texts for it sees it: its type does not matter, only what it makes of the texts.

use std::net::IpAddr;
use std::path::PathBuf;
use std::str::FromStr;

use messages::{Text, text};

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
    pub allowed: Text,
}

/// A value that is made of one text.
pub trait OptionValue: Sized {
    /// The value of the text, or what is allowed.
    ///
    /// # Errors
    /// What is allowed, as a sentence without its end.
    fn from_option(text: &str) -> Result<Self, Text>;
}

/// Makes [`OptionValue`]s of types that read themselves, and whose error says what is allowed.
#[macro_export]
macro_rules! option_values {
    ($($value:ty),* $(,)?) => {
        $(impl $crate::options::OptionValue for $value {
            fn from_option(text: &str) -> Result<Self, Text> {
                text.parse()
            }
        })*
    };
}

option_values!(
    ByteSize,
    ClockChoice,
    HomeJoints,
    ModelChoice,
    PayloadChoice,
    Permission,
    PlantChoice,
    RecordTarget,
    RotationLimit,
    StepMillis,
    Tcp
);

fn parsed<T: FromStr>(text: &str, allowed: Text) -> Result<T, Text> {
    text.parse().map_err(|_| allowed)
}

impl OptionValue for PathBuf {
    fn from_option(text: &str) -> Result<Self, Text> {
        Ok(Self::from(text))
    }
}

impl OptionValue for bool {
    fn from_option(text: &str) -> Result<Self, Text> {
        parsed(
            text,
            text!("allowed are true and false", "允许 true 和 false"),
        )
    }
}

impl OptionValue for u64 {
    fn from_option(text: &str) -> Result<Self, Text> {
        parsed(
            text,
            text!("allowed are whole numbers from 0", "允许不小于 0 的整数"),
        )
    }
}

impl OptionValue for u32 {
    fn from_option(text: &str) -> Result<Self, Text> {
        parsed(
            text,
            text!("allowed are whole numbers from 0", "允许不小于 0 的整数"),
        )
    }
}

impl OptionValue for u16 {
    fn from_option(text: &str) -> Result<Self, Text> {
        parsed(
            text,
            text!(
                "allowed are whole numbers from 0 to 65535",
                "允许 0 到 65535 的整数"
            ),
        )
    }
}

impl OptionValue for IpAddr {
    fn from_option(text: &str) -> Result<Self, Text> {
        parsed(text, text!("allowed is an IP address", "允许 IP 地址"))
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
                allowed: text!("one value is needed", "需要一个值"),
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
