//! The calibration file: reading, strictly, and writing, so that the same bits come back.

use std::fmt::Write as _;
use std::path::Path;

use messages::{Text, text};

use super::{Calibration, CalibrationError, CalibrationPart, TABLE};
use crate::dh::DhTable;
use crate::joint::DOF;

/// A calibration file larger than this is refused, bytes.
const SIZE_MAX: usize = 1 << 20;

impl Calibration {
    /// From numbers, for a model as `--model` takes it; what errors call it is `path`.
    ///
    /// # Errors
    /// [`CalibrationError::Value`] for a number that is not finite.
    pub fn new(
        model: &str,
        modified_dh: DhTable,
        theta: [f64; DOF],
        path: &Path,
    ) -> Result<Self, CalibrationError> {
        let rows = [
            ("a", &modified_dh.a),
            ("d", &modified_dh.d),
            ("alpha", &modified_dh.alpha),
            ("theta", &theta),
        ];
        for (key, values) in rows {
            if let Some(element) = values.iter().position(|value| !value.is_finite()) {
                return Err(CalibrationError::Value {
                    path: path.to_owned(),
                    place: CalibrationPart::Table,
                    key: format!("{key}[{element}]"),
                    given: values[element].to_string(),
                    allowed: text!("finite numbers are needed", "需要有限的数"),
                });
            }
        }
        Ok(Self {
            model: model.to_owned(),
            modified_dh,
            theta,
            path: path.to_owned(),
        })
    }

    /// Reads and checks a file.
    ///
    /// # Errors
    /// [`CalibrationError`] names the file, the table, the key and what is allowed.
    pub fn load(path: &Path) -> Result<Self, CalibrationError> {
        let text = crate::text_file::read_text_file(path).map_err(|source| {
            CalibrationError::Unreadable {
                path: path.to_owned(),
                source,
            }
        })?;
        Self::from_text(&text, path)
    }

    /// Checks the text of a file; `path` is what errors call it.
    ///
    /// # Errors
    /// The errors of [`Self::load`].
    pub fn from_text(text: &str, path: &Path) -> Result<Self, CalibrationError> {
        let syntax = |line: usize, message: Text| CalibrationError::Syntax {
            path: path.to_owned(),
            line,
            message,
        };
        if text.len() > SIZE_MAX {
            let message = text!(
                "{} bytes, {SIZE_MAX} are allowed",
                "{} 字节，允许 {SIZE_MAX} 字节",
                text.len()
            );
            return Err(syntax(1, message));
        }
        let whole: toml::Table = text.parse().map_err(|error: toml::de::Error| {
            let upto = error.span().map_or(0, |span| span.start);
            let line = 1 + text.bytes().take(upto).filter(|b| *b == b'\n').count();
            syntax(line, Text::of_library(&error.message().replace('\n', ", ")))
        })?;
        let reader = ErrorContext { path };
        reader.known(
            &whole,
            CalibrationPart::File,
            &["model", TABLE],
            text!("model and [modified_dh]", "model 和 [modified_dh]"),
        )?;
        let model = match whole.get("model") {
            Some(toml::Value::String(model)) if !model.trim().is_empty() => model.as_str(),
            Some(other) => {
                return Err(reader.value(
                    CalibrationPart::File,
                    "model",
                    other,
                    text!("a name as \"cs66\" is needed", "需要如 \"cs66\" 的名称"),
                ));
            }
            None => {
                return Err(reader.missing(
                    CalibrationPart::File,
                    "model",
                    text!(
                        "it says which arm was measured, as model = \"cs66\"",
                        "它说明测量的是哪种机械臂，如 model = \"cs66\""
                    ),
                ));
            }
        };
        let table = match whole.get(TABLE) {
            Some(toml::Value::Table(table)) => table,
            Some(other) => {
                let allowed = text!(
                    "a table with a, d, alpha and optionally theta is needed",
                    "需要含有 a、d、alpha 和可选 theta 的表"
                );
                return Err(reader.value(CalibrationPart::File, TABLE, other, allowed));
            }
            None => {
                return Err(reader.missing(
                    CalibrationPart::File,
                    TABLE,
                    text!(
                        "the table with a, d, alpha and optionally theta is needed",
                        "需要含有 a、d、alpha 和可选 theta 的表"
                    ),
                ));
            }
        };
        let keys = ["a", "d", "alpha", "theta"];
        reader.known(
            table,
            CalibrationPart::Table,
            &keys,
            text!(
                "a, d, alpha and optionally theta",
                "a、d、alpha 和可选的 theta"
            ),
        )?;
        let modified_dh = DhTable {
            a: reader.six(table, "a", &text!("six lengths in m", "六个长度（m）"))?,
            d: reader.six(table, "d", &text!("six lengths in m", "六个长度（m）"))?,
            alpha: reader.six(
                table,
                "alpha",
                &text!("six angles in rad", "六个角度（rad）"),
            )?,
        };
        let theta = match table.contains_key("theta") {
            true => reader.six(
                table,
                "theta",
                &text!("six angles in rad", "六个角度（rad）"),
            )?,
            false => [0.0; DOF],
        };
        Self::new(model, modified_dh, theta, path)
    }

    /// The text of a file that reads back to the same numbers, bit for bit.
    pub fn to_toml(&self) -> String {
        let model = toml::Value::String(self.model.clone());
        let mut text = format!("model = {model}\n\n[{TABLE}]\n");
        let rows = [
            ("a", &self.modified_dh.a),
            ("d", &self.modified_dh.d),
            ("alpha", &self.modified_dh.alpha),
            ("theta", &self.theta),
        ];
        for (key, values) in rows {
            // `{:?}` writes the shortest form with a point or an exponent, which TOML needs of a float. Writing to a
            // String cannot fail.
            let _ = writeln!(text, "{key} = {values:?}");
        }
        text
    }
}

/// Makes errors of a file.
struct ErrorContext<'a> {
    path: &'a Path,
}

impl ErrorContext<'_> {
    fn known(
        &self,
        table: &toml::Table,
        place: CalibrationPart,
        keys: &[&str],
        allowed: Text,
    ) -> Result<(), CalibrationError> {
        match table.keys().find(|key| !keys.contains(&key.as_str())) {
            Some(key) => Err(CalibrationError::UnknownKey {
                path: self.path.to_owned(),
                place,
                key: key.clone(),
                allowed,
            }),
            None => Ok(()),
        }
    }

    fn value(
        &self,
        place: CalibrationPart,
        key: impl Into<String>,
        given: &toml::Value,
        allowed: Text,
    ) -> CalibrationError {
        CalibrationError::Value {
            path: self.path.to_owned(),
            place,
            key: key.into(),
            given: given.to_string().replace('\n', " "),
            allowed,
        }
    }

    fn missing(
        &self,
        place: CalibrationPart,
        key: &'static str,
        allowed: Text,
    ) -> CalibrationError {
        CalibrationError::Missing {
            path: self.path.to_owned(),
            place,
            key,
            allowed,
        }
    }

    fn six(
        &self,
        table: &toml::Table,
        key: &'static str,
        what: &Text,
    ) -> Result<[f64; DOF], CalibrationError> {
        let Some(given) = table.get(key) else {
            return Err(self.missing(
                CalibrationPart::Table,
                key,
                text!("{what} are needed", "需要{what}"),
            ));
        };
        let toml::Value::Array(items) = given else {
            return Err(self.value(
                CalibrationPart::Table,
                key,
                given,
                text!("a list of {what} is needed", "需要{what}的列表"),
            ));
        };
        if items.len() != DOF {
            let allowed = text!(
                "{what} are needed, these are {}",
                "需要{what}，这里有 {} 个",
                items.len()
            );
            return Err(self.value(CalibrationPart::Table, key, given, allowed));
        }
        let mut numbers = [0.0; DOF];
        for (element, (number, item)) in numbers.iter_mut().zip(items).enumerate() {
            *number = match item {
                toml::Value::Float(number) => *number,
                #[expect(clippy::cast_precision_loss, reason = "a whole number of metres")]
                toml::Value::Integer(number) => *number as f64,
                other => {
                    let key = format!("{key}[{element}]");
                    return Err(self.value(
                        CalibrationPart::Table,
                        key,
                        other,
                        text!("a number is needed", "需要一个数"),
                    ));
                }
            };
        }
        Ok(numbers)
    }
}
