//! The `<elite_robot>` element of a URDF: what URDF has no word for.
//!
//! Owns its attributes and children. Also the first to walk the text, so it refuses files that are too deep or not XML
//! before a recursive parser sees them. `robots/README.md` describes the element for people.

use super::ModelError;
use messages::{Text, text};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// Nesting deeper than this is no robot description.
const DEPTH_MAX: usize = 32;

/// What the element says; everything is optional.
#[derive(Debug, Default)]
pub(super) struct Extension {
    pub(super) type_number: Option<u32>,
    pub(super) rated_payload_kg: Option<f64>,
    /// Joint name and its acceleration limit, rad/s².
    pub(super) joint_accelerations: Vec<(String, f64)>,
    /// Names of two links that cannot touch.
    pub(super) never_collide: Vec<(String, String)>,
}

impl Extension {
    /// Reads the element from a URDF; one that is not there is the same as an empty one.
    pub(super) fn read(urdf: &str) -> Result<Self, ModelError> {
        let mut extension = Self::default();
        let mut reader = Reader::from_str(urdf);
        let mut depth = 0;
        let mut inside = None;
        loop {
            let event = reader.read_event().map_err(|error| ModelError::NotXml {
                offset: reader.error_position(),
                reason: Text::of_library(&error),
            })?;
            let (element, opens) = match event {
                Event::Start(element) => (element, true),
                Event::Empty(element) => (element, false),
                Event::End(_) => {
                    depth = usize::saturating_sub(depth, 1);
                    if inside == Some(depth) {
                        inside = None;
                    }
                    continue;
                }
                Event::Eof if depth > 0 => {
                    return Err(ModelError::NotXml {
                        offset: reader.buffer_position(),
                        reason: text!("the file ends inside an element", "文件在元素中间结束"),
                    });
                }
                Event::Eof => return Ok(extension),
                _ => continue,
            };
            if inside.is_some() {
                extension.read_child(&element)?;
            } else if depth == 1 && element.name().as_ref() == b"elite_robot" {
                extension.read_attributes(&element)?;
                if opens {
                    inside = Some(depth);
                }
            }
            if opens {
                depth += 1;
                if depth > DEPTH_MAX {
                    return Err(ModelError::TooDeep { max: DEPTH_MAX });
                }
            }
        }
    }

    fn read_attributes(&mut self, element: &BytesStart<'_>) -> Result<(), ModelError> {
        if let Some(text) = attribute(element, "type")? {
            self.type_number = Some(parse(element, "type", &text)?);
        }
        if let Some(text) = attribute(element, "rated_payload")? {
            self.rated_payload_kg = Some(positive(element, "rated_payload", &text)?);
        }
        Ok(())
    }

    fn read_child(&mut self, element: &BytesStart<'_>) -> Result<(), ModelError> {
        match element.name().as_ref() {
            b"joint_acceleration" => {
                let joint = required(element, "joint")?;
                let limit = positive(element, "limit", &required(element, "limit")?)?;
                self.joint_accelerations.push((joint, limit));
            }
            b"never_collide" => {
                let pair = (required(element, "link1")?, required(element, "link2")?);
                self.never_collide.push(pair);
            }
            _ => {
                return Err(ModelError::Extension {
                    element: name(element),
                    reason: text!(
                        "is not known inside <elite_robot>; known are <joint_acceleration> and <never_collide>",
                        "在 <elite_robot> 中没有定义；可用的是 <joint_acceleration> 和 <never_collide>"
                    ),
                });
            }
        }
        Ok(())
    }
}

fn name(element: &BytesStart<'_>) -> String {
    String::from_utf8_lossy(element.name().as_ref()).into_owned()
}

fn error(element: &BytesStart<'_>, reason: Text) -> ModelError {
    ModelError::Extension {
        element: name(element),
        reason,
    }
}

fn attribute(element: &BytesStart<'_>, key: &str) -> Result<Option<String>, ModelError> {
    let found = element.try_get_attribute(key).map_err(|e| {
        error(
            element,
            text!("has malformed attributes: {e}", "的属性格式错误：{e}"),
        )
    })?;
    found
        .map(|a| {
            a.unescape_value()
                .map(|value| value.trim().to_owned())
                .map_err(|e| {
                    error(
                        element,
                        text!(
                            "has an unreadable attribute `{key}`: {e}",
                            "的属性 `{key}` 无法读取：{e}"
                        ),
                    )
                })
        })
        .transpose()
}

fn required(element: &BytesStart<'_>, key: &str) -> Result<String, ModelError> {
    attribute(element, key)?.ok_or_else(|| {
        error(
            element,
            text!("needs the attribute `{key}`", "需要属性 `{key}`"),
        )
    })
}

fn parse<T: core::str::FromStr>(
    element: &BytesStart<'_>,
    key: &str,
    text: &str,
) -> Result<T, ModelError> {
    text.parse().map_err(|_| {
        error(
            element,
            text!(
                "has `{key}=\"{text}\"`, which is not a number",
                "有 `{key}=\"{text}\"`，它不是数"
            ),
        )
    })
}

fn positive(element: &BytesStart<'_>, key: &str, text: &str) -> Result<f64, ModelError> {
    let value: f64 = parse(element, key, text)?;
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(error(
            element,
            text!(
                "has `{key}=\"{text}\"`, it must be a positive number",
                "有 `{key}=\"{text}\"`，必须是正数"
            ),
        ))
    }
}
