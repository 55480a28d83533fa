//! `time`: the host's clocks, sleeping, and calendar dates. The controller has no time zone: local time is UTC.

use super::define::ModuleBuilder;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::value::{R, Value};

/// Seconds of a day.
const DAY: i64 = 86_400;
const DAYS: [&str; 7] = [
    "Monday",
    "Tuesday",
    "Wednesday",
    "Thursday",
    "Friday",
    "Saturday",
    "Sunday",
];
const MONTHS: [&str; 12] = [
    "January",
    "February",
    "March",
    "April",
    "May",
    "June",
    "July",
    "August",
    "September",
    "October",
    "November",
    "December",
];

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    module.functions(&[
        ("time", "", |ev, _| {
            Ok(Value::Float(ev.core.host.unix_time()))
        }),
        ("time_ns", "", |ev, _| {
            Ok(nanoseconds(ev.core.host.unix_time()))
        }),
        ("monotonic", "", |ev, _| {
            Ok(Value::Float(ev.core.host.monotonic()))
        }),
        ("monotonic_ns", "", |ev, _| {
            Ok(nanoseconds(ev.core.host.monotonic()))
        }),
        ("perf_counter", "", |ev, _| {
            Ok(Value::Float(ev.core.host.monotonic()))
        }),
        ("perf_counter_ns", "", |ev, _| {
            Ok(nanoseconds(ev.core.host.monotonic()))
        }),
        ("process_time", "", |ev, _| {
            Ok(Value::Float(ev.core.host.monotonic()))
        }),
        ("thread_time", "", |ev, _| {
            Ok(Value::Float(ev.core.host.monotonic()))
        }),
        ("sleep", "secs /", |ev, args| {
            let seconds = ev.to_f64(&args[0])?;
            super::thread::sleep(ev, seconds)
        }),
        ("_fields", "secs /", |ev, args| {
            let seconds = ev.to_f64(&args[0])?;
            fields(ev, seconds)
        }),
        ("_format", "format fields /", format),
        ("_unix", "fields /", |ev, args| {
            let fields = numbers(ev, &args[0])?;
            Ok(Value::Int(unix(&fields)))
        }),
    ]);
    module.value("timezone", Value::Int(0));
    module.value("altzone", Value::Int(0));
    module.value("daylight", Value::Int(0));
    module.value(
        "tzname",
        Value::tuple(vec![Value::str("UTC"), Value::str("UTC")]),
    );
    Ok(())
}

fn nanoseconds(seconds: f64) -> Value {
    // Within 64 bits until the year 2262; the cast saturates there.
    Value::Int((seconds * 1e9).round() as i64)
}

/// Days since 1970-01-01 of a date of the Gregorian calendar (Howard Hinnant, "chrono-compatible low-level date
/// algorithms").
fn days_from_civil(year: i64, month: i64, day: i64) -> i64 {
    let year = if month <= 2 { year - 1 } else { year };
    let era = year.div_euclid(400);
    let year_of_era = year.rem_euclid(400);
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    era * 146_097 + year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year - 719_468
}

/// The inverse of `days_from_civil`: year, month, day.
fn civil_from_days(days: i64) -> (i64, i64, i64) {
    let days = days + 719_468;
    let era = days.div_euclid(146_097);
    let day_of_era = days.rem_euclid(146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted = (5 * day_of_year + 2) / 153;
    let month = if shifted < 10 {
        shifted + 3
    } else {
        shifted - 9
    };
    let year = year_of_era + era * 400 + i64::from(month <= 2);
    (year, month, day_of_year - (153 * shifted + 2) / 5 + 1)
}

/// The nine fields of `time.struct_time` for a number of seconds since 1970.
fn fields(ev: &Evaluator<'_>, seconds: f64) -> R {
    if !(-6.2e10..2.5e11).contains(&seconds) {
        let text = "timestamp out of range for platform time_t";
        return Err(ev.raise(ExceptionKind::OverflowError, text));
    }
    let seconds = seconds.floor() as i64;
    let (days, rest) = (seconds.div_euclid(DAY), seconds.rem_euclid(DAY));
    let (year, month, day) = civil_from_days(days);
    let day_of_year = days - days_from_civil(year, 1, 1) + 1;
    let weekday = (days + 3).rem_euclid(7);
    let fields = [
        year,
        month,
        day,
        rest / 3600,
        rest / 60 % 60,
        rest % 60,
        weekday,
        day_of_year,
        0,
    ];
    Ok(Value::tuple(
        fields.iter().map(|field| Value::Int(*field)).collect(),
    ))
}

fn numbers(ev: &Evaluator<'_>, value: &Value) -> R<Vec<i64>> {
    let items = ev.collect(value)?;
    if items.len() < 9 {
        return Err(ev.type_error("Tuple or struct_time argument required"));
    }
    let numbers: Vec<i64> = items.iter().map(|item| ev.index(item)).collect::<R<_>>()?;
    if numbers.iter().any(|number| number.abs() > 1_000_000_000) {
        return Err(ev.raise(ExceptionKind::OverflowError, "mktime argument out of range"));
    }
    Ok(numbers)
}

/// Seconds since 1970 of fields, which may lie outside their usual ranges.
fn unix(f: &[i64]) -> i64 {
    let (year, month) = (
        f[0] + (f[1] - 1).div_euclid(12),
        (f[1] - 1).rem_euclid(12) + 1,
    );
    let days = days_from_civil(year, month, 1) + f[2] - 1;
    days * DAY + f[3] * 3600 + f[4] * 60 + f[5]
}

/// `strftime` in the C locale. A tenth field holds microseconds, for `datetime`.
fn format(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let Value::Str(format) = ev.unwrap_builtin(&args[0]) else {
        let name = ev.core.types.name_of(&args[0]);
        return Err(ev.type_error(format!("strftime() argument 1 must be str, not {name}")));
    };
    let f = numbers(ev, &args[1])?;
    if !(1..=12).contains(&f[1]) {
        return Err(ev.value_error("month out of range"));
    }
    if !(1..=31).contains(&f[2]) {
        return Err(ev.value_error("day of month out of range"));
    }
    let mut out = String::new();
    let mut chars = format.as_str().chars();
    while let Some(c) = chars.next() {
        if c != '%' {
            out.push(c);
            continue;
        }
        match chars.next() {
            Some(code) => push_directive(&mut out, code, &f),
            None => out.push('%'),
        }
        ev.check_allocation(out.len())?;
    }
    Ok(Value::str(out))
}

fn push_directive(out: &mut String, code: char, f: &[i64]) {
    let (weekday, month) = (
        f[6].rem_euclid(7) as usize,
        (f[1] - 1).rem_euclid(12) as usize,
    );
    let hour12 = match f[3].rem_euclid(12) {
        0 => 12,
        hour => hour,
    };
    let sunday_first = (f[6] + 1).rem_euclid(7);
    let text = match code {
        'Y' => f[0].to_string(),
        'y' => format!("{:02}", f[0].rem_euclid(100)),
        'C' => format!("{:02}", f[0].div_euclid(100)),
        'm' => format!("{:02}", f[1]),
        'd' => format!("{:02}", f[2]),
        'e' => format!("{:2}", f[2]),
        'H' => format!("{:02}", f[3]),
        'I' => format!("{hour12:02}"),
        'M' => format!("{:02}", f[4]),
        'S' => format!("{:02}", f[5]),
        'f' => format!("{:06}", f.get(9).copied().unwrap_or(0)),
        'p' => if f[3] < 12 { "AM" } else { "PM" }.to_owned(),
        'j' => format!("{:03}", f[7]),
        'A' => DAYS[weekday].to_owned(),
        'a' => DAYS[weekday][..3].to_owned(),
        'B' => MONTHS[month].to_owned(),
        'b' | 'h' => MONTHS[month][..3].to_owned(),
        'w' => sunday_first.to_string(),
        'u' => (f[6].rem_euclid(7) + 1).to_string(),
        'U' => format!("{:02}", (f[7] + 6 - sunday_first) / 7),
        'W' => format!("{:02}", (f[7] + 6 - f[6].rem_euclid(7)) / 7),
        'G' | 'V' => {
            let (year, week) = iso_week(f);
            if code == 'G' {
                year.to_string()
            } else {
                format!("{week:02}")
            }
        }
        's' => unix(f).to_string(),
        'z' => "+0000".to_owned(),
        'Z' => "UTC".to_owned(),
        'n' => "\n".to_owned(),
        't' => "\t".to_owned(),
        '%' => "%".to_owned(),
        'c' | 'x' | 'X' | 'D' | 'F' | 'T' | 'R' | 'r' => {
            let pattern = match code {
                'c' => "%a %b %e %H:%M:%S %Y",
                'F' => "%Y-%m-%d",
                'R' => "%H:%M",
                'r' => "%I:%M:%S %p",
                'X' | 'T' => "%H:%M:%S",
                _ => "%m/%d/%y",
            };
            let mut codes = pattern.chars();
            while let Some(c) = codes.next() {
                match (c, codes.clone().next()) {
                    ('%', Some(code)) => {
                        codes.next();
                        push_directive(out, code, f);
                    }
                    _ => out.push(c),
                }
            }
            return;
        }
        other => format!("%{other}"),
    };
    out.push_str(&text);
}

/// Year and week by ISO 8601: the week belongs to the year of its Thursday.
fn iso_week(f: &[i64]) -> (i64, i64) {
    let thursday = days_from_civil(f[0], 1, 1) + f[7] - 1 - f[6].rem_euclid(7) + 3;
    let (year, _, _) = civil_from_days(thursday);
    (year, (thursday - days_from_civil(year, 1, 1)) / 7 + 1)
}
