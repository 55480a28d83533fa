//! `replay A --diff B`: where two runs part, and how far they go apart.

use std::collections::BTreeMap;
use std::fmt;

use messages::{Language, Localized, text};
use recorder::{CycleMessage, Difference, Recording, RecordingEntry, Topic, difference_ignoring};

use super::ReplayError;

/// What two recordings have in common and what not.
#[derive(Debug, Default)]
pub(super) struct DiffReport {
    /// Cycles with the same number that were compared.
    compared: u64,
    /// Number of compared cycles that differ.
    different: u64,
    first: Option<Difference>,
    /// Time of the first difference, s.
    time: f64,
    /// For each field the largest difference and the cycle it was in.
    largest: BTreeMap<&'static str, (f64, u64)>,
    /// Fields that differ and are no numbers.
    words: BTreeMap<&'static str, u64>,
    /// Cycles that only one of the two has.
    only: [u64; 2],
    names: [String; 2],
    /// Fields that the version of one of the two did not record.
    missing: Vec<&'static str>,
}

impl DiffReport {
    /// True when every cycle is in both and the same.
    pub(super) fn is_identical(&self) -> bool {
        self.different == 0 && self.only == [0, 0]
    }

    fn take(&mut self, a: &CycleMessage, b: &CycleMessage) {
        self.compared += 1;
        let Some(found) = difference_ignoring(a, b, &self.missing) else {
            return;
        };
        self.different += 1;
        for field in &found.fields {
            match field.magnitude {
                Some(by) => {
                    let largest = self.largest.entry(field.name).or_insert((by, found.cycle));
                    if by > largest.0 {
                        *largest = (by, found.cycle);
                    }
                }
                None => *self.words.entry(field.name).or_default() += 1,
            }
        }
        if self.first.is_none() {
            self.time = a.time;
            self.first = Some(found);
        }
    }
}

/// Compares two recordings cycle by cycle, by the numbers of the cycles.
pub(super) fn compare(a: &Recording, b: &Recording) -> Result<DiffReport, ReplayError> {
    let mut report = DiffReport {
        names: [a.name().to_owned(), b.name().to_owned()],
        missing: [a.missing_fields(), b.missing_fields()].concat(),
        ..DiffReport::default()
    };
    let (mut left, mut right) = (cycles(a)?, cycles(b)?);
    let mut pair = (left.next().transpose()?, right.next().transpose()?);
    loop {
        let (from_left, from_right) = match &pair {
            (None, None) => return Ok(report),
            (Some(_), None) => (true, false),
            (None, Some(_)) => (false, true),
            (Some(a), Some(b)) => (a.cycle <= b.cycle, b.cycle <= a.cycle),
        };
        if let ((Some(a), Some(b)), (true, true)) = (&pair, (from_left, from_right)) {
            report.take(a, b);
        } else if from_left {
            report.only[0] += 1;
        } else {
            report.only[1] += 1;
        }
        if from_left {
            pair.0 = left.next().transpose()?;
        }
        if from_right {
            pair.1 = right.next().transpose()?;
        }
    }
}

fn cycles(
    recording: &Recording,
) -> Result<impl Iterator<Item = Result<Box<CycleMessage>, ReplayError>>, ReplayError> {
    let entries = recording.entries(&[Topic::Cycle])?;
    Ok(entries.filter_map(|entry| match entry {
        Ok((_, RecordingEntry::Cycle(cycle))) => Some(Ok(cycle)),
        Ok(_) => None,
        Err(error) => Some(Err(error.into())),
    }))
}

impl fmt::Display for DiffReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.fmt_in(Language::English, f)
    }
}

impl Localized for DiffReport {
    fn fmt_in(&self, language: Language, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, only) in self.names.iter().zip(self.only) {
            if only > 0 {
                let line = text!(
                    "only in {name}: {only} cycles",
                    "只在 {name} 中：{only} 个周期"
                );
                writeln!(f, "{}", line.in_language(language))?;
            }
        }
        let compared = self.compared;
        let Some(first) = &self.first else {
            let line = text!("identical: {compared} cycles", "相同：{compared} 个周期");
            return f.write_str(line.in_language(language));
        };
        let line = text!(
            "first difference at cycle {} ({:.3} s): {first}",
            "首个差异在周期 {}（{:.3} s）：{first}",
            first.cycle,
            self.time
        );
        writeln!(f, "{}", line.in_language(language))?;
        let line = text!(
            "different: {} of {compared} cycles",
            "不同：{compared} 个周期中的 {} 个",
            self.different
        );
        f.write_str(line.in_language(language))?;
        for (name, (by, cycle)) in &self.largest {
            let line = text!(
                "{name}: up to {by:.3e}, in cycle {cycle}",
                "{name}：最多 {by:.3e}，在周期 {cycle}"
            );
            write!(f, "\n  {}", line.in_language(language))?;
        }
        for (name, times) in &self.words {
            let line = text!(
                "{name}: other in {times} cycles",
                "{name}：{times} 个周期中不同"
            );
            write!(f, "\n  {}", line.in_language(language))?;
        }
        Ok(())
    }
}
