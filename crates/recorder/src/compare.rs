//! Where two recordings of the same run begin to differ.

use std::fmt;

use messages::{Language, Localized, Text, text};

use crate::cycle::{CycleMessage, FieldValue};

/// Fields that say how the machine kept up, not what the robot did.
const HOST_TIMING_FIELDS: [&str; 3] = ["step_duration_us", "wakeup_latency_us", "records_lost"];

/// Fields named in a message; of more, the rest is counted.
const MAX_SHOWN: usize = 5;

/// Two cycles that should be equal and are not.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Number of the cycle, as recorded.
    pub cycle: u64,
    /// The fields that differ.
    pub fields: Vec<FieldDifference>,
}

/// One field of two cycles.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldDifference {
    /// Name of the field.
    pub name: &'static str,
    /// Element of a vector, from 0.
    pub element: Option<usize>,
    /// Value in the first cycle.
    pub first: String,
    /// Value in the second cycle.
    pub second: String,
    /// Size of the difference, where both are numbers.
    pub magnitude: Option<f64>,
}

/// What differs between two cycles, `None` when nothing does. Numbers are compared bit for bit, but for the sign of
/// zero, which the recording does not keep. What the machine took for the cycle does not count.
pub fn difference(first: &CycleMessage, second: &CycleMessage) -> Option<Difference> {
    difference_ignoring(first, second, &[])
}

/// What differs between two cycles outside the fields `except`, for instance those that an earlier version did not
/// record. Otherwise like [`difference`].
pub fn difference_ignoring(
    first: &CycleMessage,
    second: &CycleMessage,
    except: &[&str],
) -> Option<Difference> {
    let mut fields = Vec::new();
    for ((name, a), (_, b)) in first.fields().into_iter().zip(second.fields()) {
        if !HOST_TIMING_FIELDS.contains(&name) && !except.contains(&name) {
            compare(name, a, b, &mut fields);
        }
    }
    (!fields.is_empty()).then_some(Difference {
        cycle: first.cycle,
        fields,
    })
}

fn compare(name: &'static str, a: FieldValue, b: FieldValue, out: &mut Vec<FieldDifference>) {
    let mut different = |element, first: String, second: String, by| {
        out.push(FieldDifference {
            name,
            element,
            first,
            second,
            magnitude: by,
        });
    };
    match (a, b) {
        (FieldValue::Number(a), FieldValue::Number(b)) => {
            if !same(a, b) {
                different(None, a.to_string(), b.to_string(), Some((a - b).abs()));
            }
        }
        (FieldValue::Numbers(a), FieldValue::Numbers(b)) if a.len() == b.len() => {
            for (i, (&a, &b)) in a.iter().zip(b).enumerate() {
                if !same(a, b) {
                    different(Some(i), a.to_string(), b.to_string(), Some((a - b).abs()));
                }
            }
        }
        (FieldValue::Unsigned(a), FieldValue::Unsigned(b)) => {
            if a != b {
                different(None, a.to_string(), b.to_string(), None);
            }
        }
        (FieldValue::Text(a), FieldValue::Text(b)) => {
            if a != b {
                different(None, a.to_owned(), b.to_owned(), None);
            }
        }
        (a, b) => different(None, format!("{a:?}"), format!("{b:?}"), None),
    }
}

fn same(a: f64, b: f64) -> bool {
    a == b || a.to_bits() == b.to_bits()
}

impl Difference {
    /// The first fields that differ, the largest difference of each vector only:
    /// `actual_q[2] 0.5 and 0.6 (by 1.0e-1), mode idle and movej`.
    pub fn text(&self) -> Text {
        let mut shown: Vec<&FieldDifference> = Vec::new();
        for field in &self.fields {
            match shown.last_mut() {
                Some(last) if last.name == field.name => {
                    if field.magnitude > last.magnitude {
                        *last = field;
                    }
                }
                _ => shown.push(field),
            }
        }
        let fields = shown.iter().take(MAX_SHOWN).map(|field| field.text());
        let fields = Text::joined(fields, ", ", "、");
        match shown.len().saturating_sub(MAX_SHOWN) {
            0 => fields,
            more => text!(
                "{fields} and {more} more fields",
                "{fields}，另有 {more} 个字段"
            ),
        }
    }
}

impl FieldDifference {
    fn text(&self) -> Text {
        let Self { first, second, .. } = self;
        let name = match self.element {
            Some(element) => format!("{}[{element}]", self.name),
            None => self.name.to_owned(),
        };
        match self.magnitude {
            Some(by) => text!(
                "{name} {first} and {second} (by {by:.1e})",
                "{name} {first} 与 {second}（差 {by:.1e}）"
            ),
            None => text!("{name} {first} and {second}", "{name} {first} 与 {second}"),
        }
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.text().fmt(f)
    }
}

impl Localized for Difference {
    fn fmt_in(&self, language: Language, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.text().fmt_in(language, f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cycle() -> CycleMessage {
        CycleMessage {
            cycle: 7,
            actual_q: vec![0.5; 6],
            mode: "idle".to_owned(),
            ..CycleMessage::default()
        }
    }

    #[test]
    fn equal_cycles_have_no_difference_whatever_the_machine_took() {
        let mut other = cycle();
        other.step_duration_us = 80.0;
        other.wakeup_latency_us = 12.0;
        other.records_lost = 3;
        other.target_speed_fraction = -0.0;
        assert_eq!(difference(&cycle(), &other), None);
    }

    #[test]
    fn a_difference_says_where_and_by_how_much() {
        let mut other = cycle();
        other.actual_q[2] = 0.25;
        other.actual_q[4] = 0.5 + f64::EPSILON;
        other.mode = "movej".to_owned();
        let found = difference(&cycle(), &other).unwrap();
        assert_eq!((found.cycle, found.fields.len()), (7, 3));
        assert_eq!(
            found.to_string(),
            "actual_q[2] 0.5 and 0.25 (by 2.5e-1), mode idle and movej"
        );
    }

    #[test]
    fn many_differences_are_counted() {
        let mut other = cycle();
        let fields: [&mut f64; 4] = [
            &mut other.time,
            &mut other.speed_scaling,
            &mut other.step_time,
            &mut other.target_speed_fraction,
        ];
        fields.into_iter().for_each(|field| *field = 1.0);
        other.digital_in = 1;
        other.digital_out = 1;
        other.stop_code = 1;
        let text = difference(&cycle(), &other).unwrap().to_string();
        assert!(
            text.starts_with("time 0 and 1 (by 1.0e0), speed_scaling"),
            "{text}"
        );
        assert!(text.ends_with("and 2 more fields"), "{text}");
    }

    #[test]
    fn vectors_of_other_lengths_differ() {
        let mut other = cycle();
        other.actual_q.clear();
        assert!(difference(&cycle(), &other).is_some());
    }
}
