//! Lines of port 40011: `req ID STATEMENT` in, `[ID] [success] : [VALUE]` out. Pure.

use core::fmt;

/// Longest line, as on the dashboard, bytes.
pub const LINE_BYTES_MAX: usize = 64 * 1024;

/// One question.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Request {
    /// What the client calls it.
    pub id: u64,
    /// One line of script.
    pub statement: String,
}

/// A reason why there is no value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The request is badly formed.
    Parse,
    /// The request met an exception, or does what a question may not.
    Execute,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Parse => "parse failed",
            Self::Execute => "execute failed",
        })
    }
}

/// Reads a line. A blank between the id and a name may be missing: a program of the vendor's, as it is printed, has
/// none. `None` for what is no question; it is answered under the number -1.
pub fn parse(line: &str) -> Option<Request> {
    let rest = line.trim().strip_prefix("req")?;
    let digits = rest.trim_start();
    if digits.len() == rest.len() {
        return None;
    }
    let end = digits.find(|c: char| !c.is_ascii_digit())?;
    let (id, statement) = digits.split_at(end);
    let begins_a_name = |c: char| c == '_' || c.is_alphabetic();
    if !statement.starts_with(|c: char| c.is_whitespace() || begins_a_name(c)) {
        return None;
    }
    let (id, statement) = (id.parse().ok()?, statement.trim());
    (!statement.is_empty() && id > 0).then(|| Request {
        id,
        statement: statement.to_owned(),
    })
}

/// The answer, with its end of line; `None` is the number of what is no question.
pub fn answer(id: Option<u64>, value: &Result<String, Failure>) -> String {
    let id = id.map_or_else(|| "-1".to_owned(), |id| id.to_string());
    match value {
        Ok(value) => format!(
            "[{id}] [success] : [{}]\n",
            value.replace(char::is_control, " ")
        ),
        Err(failure) => format!("[{id}] [failure] : [{failure}]\n"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn requests_as_clients_send_them_are_read() {
        let request = |id, statement: &str| {
            Some(Request {
                id,
                statement: statement.to_owned(),
            })
        };
        for (line, expected) in [
            (
                "req 1 set_tcp([0,0,0.1,0,0,0])",
                request(1, "set_tcp([0,0,0.1,0,0,0])"),
            ),
            (
                " req 7  get_actual_joint_positions() \r",
                request(7, "get_actual_joint_positions()"),
            ),
            (
                "req 5get_inverse_kin([1,2])",
                request(5, "get_inverse_kin([1,2])"),
            ),
            ("req 5 1/0", request(5, "1/0")),
            ("req 18446744073709551615 x", request(u64::MAX, "x")),
            ("req 18446744073709551616 x", None),
            ("req 0 x", None),
            ("req x get_actual_joint_positions()", None),
            ("req -1 x", None),
            ("req 3", None),
            ("req 3 ", None),
            ("req 3(1)", None),
            ("req3 x", None),
            ("request 3 x", None),
            ("get_actual_joint_positions()", None),
            ("", None),
        ] {
            assert_eq!(parse(line), expected, "{line}");
        }
    }

    #[test]
    fn answers_are_the_bytes_that_clients_look_for() {
        assert_eq!(
            answer(Some(2), &Ok("True".to_owned())),
            "[2] [success] : [True]\n"
        );
        assert_eq!(
            answer(Some(7), &Err(Failure::Execute)),
            "[7] [failure] : [execute failed]\n"
        );
        assert_eq!(
            answer(None, &Err(Failure::Parse)),
            "[-1] [failure] : [parse failed]\n"
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]
        #[test]
        fn an_answer_is_one_line(line in "(req )?[0-9x ]{0,4}.{0,20}", value in "(?s).{0,20}") {
            let id = parse(&line).map(|request| request.id);
            let answer = answer(id, &Ok(value));
            prop_assert_eq!(answer.matches('\n').count(), 1);
            prop_assert!(answer.ends_with("]\n") && !answer.contains('\r'));
        }
    }
}
