//! Names of I/O points in the cell file, as `standard_digital_out[3]`.

use core::fmt;
use core::str::FromStr;

use serde::Deserialize;

/// Groups of points and how many each has; `tool_analog_*` have no index.
const GROUPS: [(&str, u16); 16] = [
    ("standard_digital_in", 16),
    ("standard_digital_out", 16),
    ("configurable_digital_in", 8),
    ("configurable_digital_out", 8),
    ("tool_digital_in", 4),
    ("tool_digital_out", 4),
    ("standard_analog_in", 2),
    ("standard_analog_out", 2),
    ("tool_analog_in", 1),
    ("tool_analog_out", 1),
    ("input_boolean_register", 128),
    ("output_boolean_register", 128),
    ("input_integer_register", 48),
    ("output_integer_register", 48),
    ("input_float_register", 48),
    ("output_float_register", 48),
];

/// One point of the I/O image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub struct PointName {
    group: &'static str,
    index: u16,
}

impl TryFrom<String> for PointName {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl FromStr for PointName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, index) = match text.strip_suffix(']').and_then(|t| t.split_once('[')) {
            Some((name, index)) => (name, Some(index)),
            None => (text, None),
        };
        let Some((group, count)) = GROUPS.iter().find(|(group, _)| *group == name) else {
            let names: Vec<&str> = GROUPS.iter().map(|(group, _)| *group).collect();
            return Err(format!("`{text}` is no point; points are {}", names.join(", ")));
        };
        match (count, index) {
            (1, None) => Ok(Self { group, index: 0 }),
            (1, Some(_)) => Err(format!("`{text}`: there is only one {group}, it takes no index")),
            (count, index) => match index.and_then(|i| i.parse().ok()).filter(|i| i < count) {
                Some(index) => Ok(Self { group, index }),
                None => Err(format!("`{text}` needs an index of 0 to {}, as {group}[0]", count - 1)),
            },
        }
    }
}

impl fmt::Display for PointName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.group.starts_with("tool_analog") {
            f.write_str(self.group)
        } else {
            write!(f, "{}[{}]", self.group, self.index)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::PointName;

    #[test]
    fn names_are_read_and_written_alike() {
        for name in ["standard_digital_out[15]", "tool_analog_in", "input_float_register[47]"] {
            assert_eq!(name.parse::<PointName>().unwrap().to_string(), name);
        }
    }

    #[test]
    fn wrong_names_say_what_is_allowed() {
        for (wrong, word) in [
            ("standard_digital_out[16]", "0 to 15"),
            ("standard_digital_out", "0 to 15"),
            ("tool_analog_in[0]", "no index"),
            ("digital_out[1]", "standard_digital_out"),
        ] {
            let error = wrong.parse::<PointName>().unwrap_err();
            assert!(error.contains(word), "{error}");
        }
    }
}
