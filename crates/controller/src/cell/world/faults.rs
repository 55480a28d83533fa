//! `[[fault]]`, and the faults that tests and pages ask for by a word.

use messages::{Text, text};
use world::description::*;

use super::keys::{edge, needed};
use crate::cell::check::{InvalidValue, TableCheck};
use crate::cell::point::{IoDirection, IoPointName};
use crate::cell::world_schema::{FaultName, FaultTable};

pub(super) fn fault(number: usize, table: &FaultTable) -> Result<FaultDescription, InvalidValue> {
    let check = TableCheck::numbered("fault", number);
    let when = match (table.at, table.when) {
        (Some(at), None) => Trigger::Time(at),
        (None, Some(point)) => edge(&check, "when", point)?,
        (Some(at), Some(_)) => {
            return Err(check.wrong(
                "at",
                at,
                text!("either at or when is needed", "需要 at 或 when 之一"),
            ));
        }
        (None, None) => {
            return Err(check.missing(
                "at",
                text!("either at or when is needed", "需要 at 或 when 之一"),
            ));
        }
    };
    Ok(FaultDescription {
        when,
        what: fault_kind(&check, table.what, &table.name)?,
        duration: table.duration,
    })
}

/// A fault by its word in the cell file and the name of a thing or an input.
///
/// # Errors
/// A sentence that names the argument, what was given and what is allowed.
pub fn fault_of(what: &str, name: &str) -> Result<FaultKind, Text> {
    let Some(kind) = FaultName::ALL.into_iter().find(|kind| kind.word() == what) else {
        let words: Vec<_> = FaultName::ALL
            .iter()
            .map(|kind| format!("{:?}", kind.word()))
            .collect();
        return Err(text!(
            "what is {what:?}; allowed are {}",
            "what 为 {what:?}；允许 {}",
            words.join(", ")
        ));
    };
    let check = TableCheck::named("fault", what);
    fault_kind(&check, kind, name).map_err(|wrong| {
        text!(
            "{} is {}; {}",
            "{} 为 {}；{}",
            wrong.key,
            wrong.given,
            wrong.allowed
        )
    })
}

/// A fault of a thing or an input that is given by name.
fn fault_kind(check: &TableCheck, what: FaultName, name: &str) -> Result<FaultKind, InvalidValue> {
    if what.is_of_input() {
        let point: IoPointName = name
            .parse()
            .map_err(|reason| check.wrong("name", format_args!("{name:?}"), reason))?;
        let point = needed(check, "name", Some(point), IoDirection::In)?;
        return Ok(match what {
            FaultName::Stuck => FaultKind::Stuck(point),
            _ => FaultKind::Open(point),
        });
    }
    let name = name.to_owned();
    Ok(match what {
        FaultName::Missing => FaultKind::Missing(name),
        FaultName::Turned => FaultKind::Turned(name),
        FaultName::Drop => FaultKind::Drop(name),
        FaultName::Leak => FaultKind::Leak(name),
        FaultName::Blocked => FaultKind::Blocked(name),
        FaultName::Slow | FaultName::Stuck | FaultName::Open => FaultKind::Slow(name),
    })
}
