//! XML-RPC values and messages as text (xmlrpc.com/spec, with the common extensions `nil` and `i8`). Pure.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use messages::{Localized, Text, text};
use quick_xml::Reader;
use quick_xml::escape::{escape, resolve_predefined_entity};
use quick_xml::events::Event;
use thiserror::Error;

/// Deepest nesting of values taken or given.
pub const DEPTH_MAX: usize = 64;

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub enum RpcValue {
    /// No value.
    Nil,
    /// A truth value.
    Bool(bool),
    /// An integer; `int` where 32 bits hold it, otherwise `i8`.
    Int(i64),
    /// A number.
    Double(f64),
    /// A text.
    Text(String),
    /// Bytes, base64 on the line.
    Bytes(Vec<u8>),
    /// Values in order.
    Array(Vec<RpcValue>),
    /// Values by name, in the order sent.
    Struct(Vec<(String, RpcValue)>),
}

/// The server's own error.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
#[error("fault {code}: {text}")]
#[zh("故障 {code}：{text}")]
pub struct RpcFault {
    /// Number of the fault.
    pub code: i64,
    /// The server's explanation.
    pub text: String,
}

/// An answer that is none.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
#[error("the answer is no XML-RPC: {0}")]
#[zh("应答不是 XML-RPC：{0}")]
pub struct InvalidXmlRpc(Text);

/// The body of a call.
pub fn encode_call(method: &str, arguments: &[RpcValue]) -> String {
    let mut out = String::from("<?xml version=\"1.0\"?><methodCall><methodName>");
    out.push_str(&escape(method));
    out.push_str("</methodName><params>");
    for argument in arguments {
        out.push_str("<param>");
        put(&mut out, argument);
        out.push_str("</param>");
    }
    out.push_str("</params></methodCall>");
    out
}

fn put(out: &mut String, value: &RpcValue) {
    out.push_str("<value>");
    // Writing into a String cannot fail.
    let _ = match value {
        RpcValue::Nil => write!(out, "<nil/>"),
        RpcValue::Bool(level) => write!(out, "<boolean>{}</boolean>", u8::from(*level)),
        RpcValue::Int(n) if i32::try_from(*n).is_ok() => write!(out, "<int>{n}</int>"),
        RpcValue::Int(n) => write!(out, "<i8>{n}</i8>"),
        RpcValue::Double(x) => write!(out, "<double>{x:?}</double>"),
        RpcValue::Text(text) => write!(out, "<string>{}</string>", escape(text.as_str())),
        RpcValue::Bytes(bytes) => write!(out, "<base64>{}</base64>", BASE64.encode(bytes)),
        RpcValue::Array(items) => {
            out.push_str("<array><data>");
            items.iter().for_each(|item| put(out, item));
            write!(out, "</data></array>")
        }
        RpcValue::Struct(members) => {
            out.push_str("<struct>");
            for (name, value) in members {
                let _ = write!(out, "<member><name>{}</name>", escape(name.as_str()));
                put(out, value);
                out.push_str("</member>");
            }
            write!(out, "</struct>")
        }
    };
    out.push_str("</value>");
}

/// The body of an answer with a result, or with the server's fault.
pub fn encode_response(answer: &Result<RpcValue, RpcFault>) -> String {
    let mut out = String::from("<?xml version=\"1.0\"?><methodResponse>");
    match answer {
        Ok(value) => {
            out.push_str("<params><param>");
            put(&mut out, value);
            out.push_str("</param></params>");
        }
        Err(fault) => {
            let members = vec![
                ("faultCode".to_owned(), RpcValue::Int(fault.code)),
                ("faultString".to_owned(), RpcValue::Text(fault.text.clone())),
            ];
            out.push_str("<fault>");
            put(&mut out, &RpcValue::Struct(members));
            out.push_str("</fault>");
        }
    }
    out.push_str("</methodResponse>");
    out
}

/// The method and the arguments of a call.
///
/// # Errors
/// [`InvalidXmlRpc`] says what is wrong.
pub fn decode_call(text: &str) -> Result<(String, Vec<RpcValue>), InvalidXmlRpc> {
    let tree = read_tree(text)?;
    if tree.name != "methodCall" {
        return Err(InvalidXmlRpc(text!("it is a <{}>", "它是 <{}>", tree.name)));
    }
    let Some(method) = tree.child("methodName") else {
        return Err(InvalidXmlRpc(text!(
            "a call without a method",
            "调用没有方法"
        )));
    };
    let parameters = tree.child("params").into_iter();
    let values = parameters
        .flat_map(|params| &params.children)
        .filter_map(|param| param.child("value"))
        .map(value_of);
    let values = values.collect::<Result<_, _>>()?;
    Ok((method.text.trim().to_owned(), values))
}

/// The result in the body of an answer, or the server's fault.
///
/// # Errors
/// [`InvalidXmlRpc`] says what is wrong.
pub fn decode_response(text: &str) -> Result<Result<RpcValue, RpcFault>, InvalidXmlRpc> {
    let mut tree = read_tree(text)?;
    let wrong = InvalidXmlRpc;
    if tree.name != "methodResponse" {
        return Err(InvalidXmlRpc(text!("it is a <{}>", "它是 <{}>", tree.name)));
    }
    let child = tree
        .children
        .pop()
        .ok_or_else(|| wrong(text!("it is empty", "是空的")))?;
    match child.name.as_str() {
        "params" => {
            let value = child.child("param").and_then(|param| param.child("value"));
            // An answer without a value: the method returns nothing.
            Ok(Ok(value.map_or(Ok(RpcValue::Nil), value_of)?))
        }
        "fault" => {
            let value = child
                .child("value")
                .ok_or_else(|| wrong(text!("a fault without a value", "故障没有值")))?;
            let RpcValue::Struct(members) = value_of(value)? else {
                return Err(wrong(text!("a fault that is no struct", "故障不是结构")));
            };
            let member = |wanted: &str| members.iter().find(|(name, _)| name == wanted);
            let code = match member("faultCode") {
                Some((_, RpcValue::Int(code))) => *code,
                _ => 0,
            };
            let text = match member("faultString") {
                Some((_, RpcValue::Text(text))) => text.clone(),
                _ => String::new(),
            };
            Ok(Err(RpcFault { code, text }))
        }
        other => Err(InvalidXmlRpc(text!(
            "<{other}> in the place of <params>",
            "<params> 的位置上是 <{other}>"
        ))),
    }
}

/// An element with its text and its children.
#[derive(Default)]
struct Element {
    name: String,
    text: String,
    children: Vec<Element>,
}

impl Element {
    fn child(&self, name: &str) -> Option<&Element> {
        self.children.iter().find(|child| child.name == name)
    }
}

fn read_tree(text: &str) -> Result<Element, InvalidXmlRpc> {
    let broken = |error: &dyn std::fmt::Display| InvalidXmlRpc(Text::of_library(&error));
    let mut reader = Reader::from_str(text);
    // Elements from the outermost to the one that is open.
    let mut open: Vec<Element> = vec![Element::default()];
    loop {
        let event = reader.read_event().map_err(|error| broken(&error))?;
        let named = |name: &[u8]| Element {
            name: String::from_utf8_lossy(name).into_owned(),
            ..Element::default()
        };
        // A value is at most five elements deep in another.
        if open.len() > 5 * DEPTH_MAX {
            return Err(InvalidXmlRpc(text!(
                "values are nested deeper than {DEPTH_MAX}",
                "值的嵌套超过 {DEPTH_MAX} 层"
            )));
        }
        let closed = match event {
            Event::Start(start) => {
                open.push(named(start.local_name().as_ref()));
                None
            }
            Event::Empty(empty) => Some(named(empty.local_name().as_ref())),
            // The reader has made sure that it closes the element that is open.
            Event::End(_) if open.len() > 1 => open.pop(),
            Event::Text(part) => {
                let part = part.xml10_content().map_err(|error| broken(&error))?;
                append(&mut open, &part);
                None
            }
            Event::CData(part) => {
                let part = part.xml10_content().map_err(|error| broken(&error))?;
                append(&mut open, &part);
                None
            }
            Event::GeneralRef(reference) => {
                let name = reference.decode().map_err(|error| broken(&error))?;
                let character = reference
                    .resolve_char_ref()
                    .map_err(|error| broken(&error))?;
                match (character, resolve_predefined_entity(&name)) {
                    (Some(character), _) => append(&mut open, character.encode_utf8(&mut [0; 4])),
                    (None, Some(known)) => append(&mut open, known),
                    (None, None) => {
                        return Err(InvalidXmlRpc(text!(
                            "unknown entity &{name};",
                            "未知的实体 &{name};"
                        )));
                    }
                }
                None
            }
            Event::Eof => break,
            _ => None,
        };
        if let (Some(closed), Some(parent)) = (closed, open.last_mut()) {
            parent.children.push(closed);
        }
    }
    match open.as_mut_slice() {
        [root] => root
            .children
            .pop()
            .ok_or_else(|| InvalidXmlRpc(text!("there is no element", "没有元素"))),
        _ => Err(InvalidXmlRpc(text!("it ends in the middle", "在中间结束"))),
    }
}

fn append(open: &mut [Element], text: &str) {
    if let Some(element) = open.last_mut() {
        element.text.push_str(text);
    }
}

fn value_of(value: &Element) -> Result<RpcValue, InvalidXmlRpc> {
    let Some(inner) = value.children.first() else {
        // Without a type it is a text.
        return Ok(RpcValue::Text(value.text.clone()));
    };
    let (name, text) = (inner.name.as_str(), inner.text.as_str());
    let wrong = || InvalidXmlRpc(text!("<{name}> with {text:?}", "<{name}> 中是 {text:?}"));
    Ok(match name {
        "nil" => RpcValue::Nil,
        "boolean" => match text.trim() {
            "1" | "true" => RpcValue::Bool(true),
            "0" | "false" => RpcValue::Bool(false),
            _ => return Err(wrong()),
        },
        "int" | "i1" | "i2" | "i4" | "i8" => {
            RpcValue::Int(text.trim().parse().map_err(|_| wrong())?)
        }
        "double" | "float" => RpcValue::Double(text.trim().parse().map_err(|_| wrong())?),
        // A time of day comes as its text; scripts have no type for it.
        "string" | "dateTime.iso8601" => RpcValue::Text(inner.text.clone()),
        "base64" => RpcValue::Bytes(from_base64(text).ok_or_else(wrong)?),
        "array" => {
            let items = inner.child("data").map_or(&[][..], |data| &data.children);
            RpcValue::Array(items.iter().map(value_of).collect::<Result<_, _>>()?)
        }
        "struct" => {
            let member = |member: &Element| {
                let name = member.child("name").map(|name| name.text.clone());
                let value = member.child("value").map(value_of).transpose()?;
                name.zip(value).ok_or_else(|| {
                    InvalidXmlRpc(text!("a member without name or value", "成员没有名称或值"))
                })
            };
            RpcValue::Struct(
                inner
                    .children
                    .iter()
                    .map(member)
                    .collect::<Result<_, _>>()?,
            )
        }
        _ => {
            return Err(InvalidXmlRpc(text!(
                "unknown type <{name}>",
                "未知的类型 <{name}>"
            )));
        }
    })
}

/// Line ends, missing padding and left-over bits are no errors: encoders differ in them.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_allow_trailing_bits(true)
        .with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

fn from_base64(text: &str) -> Option<Vec<u8>> {
    let digits: Vec<u8> = text
        .bytes()
        .filter(|byte| !byte.is_ascii_whitespace() && *byte != b'=')
        .collect();
    BASE64.decode(digits).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn values() -> impl Strategy<Value = RpcValue> {
        let leaf = prop_oneof![
            Just(RpcValue::Nil),
            any::<bool>().prop_map(RpcValue::Bool),
            any::<i64>().prop_map(RpcValue::Int),
            proptest::num::f64::NORMAL.prop_map(RpcValue::Double),
            "[ -~äß€]{0,20}".prop_map(RpcValue::Text),
            proptest::collection::vec(any::<u8>(), 0..20).prop_map(RpcValue::Bytes),
        ];
        leaf.prop_recursive(4, 32, 5, |inner| {
            prop_oneof![
                proptest::collection::vec(inner.clone(), 0..5).prop_map(RpcValue::Array),
                proptest::collection::vec(("[a-z<&]{1,5}", inner), 0..5).prop_map(RpcValue::Struct),
            ]
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn every_value_comes_back(value in values()) {
            let call = encode_call("m", std::slice::from_ref(&value));
            let (_, params) = call.split_once("<params>").unwrap();
            let answer = format!("<methodResponse><params>{}", params.replace("methodCall", "methodResponse"));
            prop_assert_eq!(decode_response(&answer), Ok(Ok(value)));
        }

        #[test]
        fn any_text_is_an_answer_or_an_error(text in "[<>/a-z&;#0-9 ]{0,80}") {
            let _ = decode_response(&text);
            let _ = decode_response(&format!("<methodResponse><params><param><value>{text}</value></param></params>\
                </methodResponse>"));
        }
    }

    #[test]
    fn faults_and_bare_texts_are_understood() {
        let fault = "<?xml version='1.0'?>\n<methodResponse>\n<fault>\n<value><struct>\n<member>\n\
            <name>faultCode</name>\n<value><int>4</int></value>\n</member>\n<member>\n<name>faultString</name>\n\
            <value><string>too many &lt;x&gt;</string></value>\n</member>\n</struct></value>\n</fault>\n\
            </methodResponse>\n";
        let wanted = RpcFault {
            code: 4,
            text: "too many <x>".to_owned(),
        };
        assert_eq!(decode_response(fault), Ok(Err(wanted)));
        let bare = "<methodResponse><params><param><value>a &#228;</value></param></params></methodResponse>";
        assert_eq!(
            decode_response(bare),
            Ok(Ok(RpcValue::Text("a ä".to_owned())))
        );
        let deep = "<value><array><data>".repeat(1000);
        assert!(decode_response(&format!("<methodResponse>{deep}")).is_err());
        assert_eq!(
            decode_response("<html></html>").unwrap_err().to_string(),
            "the answer is no XML-RPC: it is a <html>"
        );
    }
}
