//! How many values a JSON text has, counted without building one: two bytes of text can become a hundred of memory.

use std::fmt;

use messages::{Text, text};
use serde::de::{DeserializeSeed, IgnoredAny};
use serde::de::{Deserializer as _, Error, MapAccess, SeqAccess, Visitor};

/// Refuses a text that is not JSON, or has more than `most` values, containers included.
pub(crate) fn check_value_count(most: usize, text: &[u8]) -> Result<(), Text> {
    let mut left = Some(most);
    let mut json = serde_json::Deserializer::from_slice(text);
    json.deserialize_any(ValueCounter(&mut left))
        .and_then(|()| json.end())
        .map_err(|error| match left {
            Some(_) => Text::of_library(&error),
            None => text!(
                "it has too many values at line {} column {}",
                "值太多（第 {} 行第 {} 列）",
                error.line(),
                error.column()
            ),
        })
}

/// Counts down; nothing is left of a number where there are more.
struct ValueCounter<'a>(&'a mut Option<usize>);

impl ValueCounter<'_> {
    fn one<E: Error>(&mut self) -> Result<(), E> {
        *self.0 = self.0.and_then(|left| left.checked_sub(1));
        match self.0 {
            Some(_) => Ok(()),
            None => Err(E::custom("it has too many values")),
        }
    }
}

impl<'de> DeserializeSeed<'de> for ValueCounter<'_> {
    type Value = ();

    fn deserialize<D: serde::Deserializer<'de>>(self, value: D) -> Result<(), D::Error> {
        value.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for ValueCounter<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_bool<E: Error>(mut self, _: bool) -> Result<(), E> {
        self.one()
    }

    fn visit_i64<E: Error>(mut self, _: i64) -> Result<(), E> {
        self.one()
    }

    fn visit_u64<E: Error>(mut self, _: u64) -> Result<(), E> {
        self.one()
    }

    fn visit_f64<E: Error>(mut self, _: f64) -> Result<(), E> {
        self.one()
    }

    fn visit_str<E: Error>(mut self, _: &str) -> Result<(), E> {
        self.one()
    }

    fn visit_unit<E: Error>(mut self) -> Result<(), E> {
        self.one()
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut items: A) -> Result<(), A::Error> {
        self.one()?;
        while items.next_element_seed(ValueCounter(self.0))?.is_some() {}
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut fields: A) -> Result<(), A::Error> {
        self.one()?;
        while fields.next_key::<IgnoredAny>()?.is_some() {
            fields.next_value_seed(ValueCounter(self.0))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_counted_and_what_is_no_json_is_refused() {
        for (text, values) in [
            ("1", 1),
            ("[]", 1),
            ("[true, null, -1, 1.5, \"x\"]", 6),
            ("{\"a\": {\"b\": [[], []]}, \"c\": 1}", 6),
        ] {
            assert_eq!(check_value_count(values, text.as_bytes()), Ok(()), "{text}");
            let error = check_value_count(values - 1, text.as_bytes()).unwrap_err();
            assert!(
                error.english().contains("too many values"),
                "{text}: {error}"
            );
        }
        let deep = "[".repeat(100_000);
        for wrong in ["", "[1", "{}{}", "\u{1}", &deep] {
            assert!(check_value_count(1_000_000, wrong.as_bytes()).is_err());
        }
        assert!(check_value_count(10, b"\"\xff\"").is_err());
    }
}
