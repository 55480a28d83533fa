//! What is wrong with the description of a cell, or with an order to the world.
use messages::{Localized, Text};

/// A refusal of a description: the table, the entry, the key, what was given and what is allowed.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Localized)]
#[non_exhaustive]
pub enum WorldError {
    /// A value outside its range.
    #[error("[[{table}]] \"{name}\": {key} is {given}, allowed: {allowed}")]
    #[zh("[[{table}]] \"{name}\"：{key} 为 {given}，允许：{allowed}")]
    OutOfRange {
        /// Table of the cell file.
        table: &'static str,
        /// Name of the entry.
        name: String,
        /// Key.
        key: &'static str,
        /// The value.
        given: Text,
        /// What is allowed.
        allowed: Text,
    },
    /// A name that nothing has.
    #[error("[[{table}]] \"{name}\": {key} names \"{given}\", allowed: the name of {allowed}")]
    #[zh("[[{table}]] \"{name}\"：{key} 指向 \"{given}\"，允许{allowed}的名称")]
    UnknownName {
        /// Table of the cell file.
        table: &'static str,
        /// Name of the entry.
        name: String,
        /// Key.
        key: &'static str,
        /// The name that was given.
        given: String,
        /// What it should be the name of.
        allowed: Text,
    },
    /// A name that two things have.
    #[error(
        "[[{table}]]: name is \"{name}\", allowed: names that nothing else has ([[{other}]] has it)"
    )]
    #[zh("[[{table}]]：名称为 \"{name}\"，不允许重名（[[{other}]] 已用此名称）")]
    DuplicateName {
        /// Table of the second.
        table: &'static str,
        /// The name.
        name: String,
        /// Table of the first.
        other: &'static str,
    },
    /// More entries than the world can hold.
    #[error("[[{table}]]: {given} entries, allowed: up to {allowed}")]
    #[zh("[[{table}]]：有 {given} 项，最多允许 {allowed} 项")]
    TooMany {
        /// Table of the cell file.
        table: &'static str,
        /// How many were given.
        given: usize,
        /// How many may be.
        allowed: usize,
    },
    /// An input that two things drive.
    #[error(
        "[[{table}]] \"{name}\": {key} is {given}, allowed: an input that nothing else drives (\"{other}\" drives it)"
    )]
    #[zh(
        "[[{table}]] \"{name}\"：{key} 为 {given}，应为没有其他驱动的输入（\"{other}\" 在驱动它）"
    )]
    DrivenTwice {
        /// Table of the second.
        table: &'static str,
        /// Name of the second.
        name: String,
        /// Key of the second.
        key: &'static str,
        /// The point.
        given: String,
        /// Name of the first.
        other: String,
    },
    /// Two parts that are in the same place at the start.
    #[error(
        "[[part]] \"{a}\": pose overlaps \"{b}\" by {depth_m:.4} m, allowed: poses in which parts do not overlap"
    )]
    #[zh("[[part]] \"{a}\"：位姿与 \"{b}\" 重叠 {depth_m:.4} m，只允许工件不重叠的位姿")]
    Overlap {
        /// Name of the first part.
        a: String,
        /// Name of the second part.
        b: String,
        /// Depth, m.
        depth_m: f64,
    },
    /// The engine refused a joint between an actuator and its frame.
    #[error("[[actuator]] \"{name}\": the physics engine refused its joint")]
    #[zh("[[actuator]] \"{name}\"：物理引擎拒绝了它的关节")]
    Joint {
        /// Name of the actuator.
        name: String,
    },
}

/// A refusal of an order to a running world.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Localized)]
#[non_exhaustive]
pub enum OrderError {
    /// A name that nothing has.
    #[error("there is no {what} \"{name}\"")]
    #[zh("没有 {what} \"{name}\"")]
    UnknownName {
        /// What was looked for.
        what: Text,
        /// The name.
        name: String,
    },
    /// An argument outside its range.
    #[error("{argument} is {given}, allowed: {allowed}")]
    #[zh("{argument} 为 {given}，允许：{allowed}")]
    OutOfRange {
        /// Name of the argument.
        argument: &'static str,
        /// What was given.
        given: Text,
        /// What is allowed.
        allowed: Text,
    },
    /// There are as many parts as the world can hold.
    #[error("there are {given} parts, allowed: up to {allowed}")]
    #[zh("有 {given} 个工件，最多允许 {allowed} 个")]
    TooManyParts {
        /// How many there would be.
        given: usize,
        /// How many may be.
        allowed: usize,
    },
}
