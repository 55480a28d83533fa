//! The global variables of a configuration: the file beside the task, and the values in the text of a generated
//! program.
//!
//! Pure. The file is the pendant's (`NAME.configuration.variables`): one element a variable, with its current value.
//! What is written back differs in values alone. A generated program sets the same variables at its beginning, with the
//! values of the moment in which it was generated; [`with_values`] puts the current ones there. Our own reading of
//! files and public programs; the format is not published.

use std::collections::BTreeMap;

use messages::Localized;
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, Writer};
use thiserror::Error;

/// Most variables of one file.
pub const VARIABLES_MAX: usize = 1000;

/// A variable with the text of its value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Variable {
    /// The name under which programs read the variable.
    pub name: String,
    /// A literal, as it is written.
    pub value: String,
}

/// A file that is none.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
pub enum NoVariables {
    /// The text is no XML.
    #[error("it is no XML: {0}")]
    #[zh("不是 XML：{0}")]
    Xml(String),
    /// More than there is room for.
    #[error("it has more than {VARIABLES_MAX} variables")]
    #[zh("变量超过 {VARIABLES_MAX} 个")]
    TooMany,
}

/// The variables in the text of a file, in its order.
///
/// # Errors
/// [`NoVariables`]
pub fn variables(text: &str) -> Result<Vec<Variable>, NoVariables> {
    let mut found: Vec<Variable> = Vec::new();
    each(text, |event| {
        if let Some(variable) = variable_of(event)? {
            if found.len() >= VARIABLES_MAX {
                return Err(NoVariables::TooMany);
            }
            found.push(variable);
        }
        Ok(())
    })?;
    Ok(found)
}

/// The text of a file with other values.
///
/// # Errors
/// [`NoVariables`]
pub fn rewritten(text: &str, values: &BTreeMap<String, String>) -> Result<String, NoVariables> {
    let mut writer = Writer::new(Vec::with_capacity(text.len()));
    each(text, |event| {
        let value = variable_of(event)?.and_then(|variable| values.get(&variable.name));
        let (element, is_empty) = match event {
            Event::Empty(element) => (element, true),
            Event::Start(element) => (element, false),
            other => return writer.write_event(other.borrow()).map_err(xml),
        };
        let Some(value) = value else {
            return writer.write_event(event.borrow()).map_err(xml);
        };
        let mut changed = BytesStart::from_content(
            String::from_utf8_lossy(element.name().as_ref()).into_owned(),
            element.name().as_ref().len(),
        );
        for attribute in element.attributes() {
            let attribute = attribute.map_err(xml)?;
            match attribute.key.as_ref() {
                b"value" => changed.push_attribute(("value", value.as_str())),
                _ => changed.push_attribute(attribute),
            }
        }
        let changed = match is_empty {
            true => Event::Empty(changed),
            false => Event::Start(changed),
        };
        writer.write_event(changed).map_err(xml)
    })?;
    String::from_utf8(writer.into_inner()).map_err(xml)
}

/// The name of the configuration that the XML of a task asks for, and the folder it is in.
pub fn configuration_of(task: &str) -> Option<(String, String)> {
    let mut found = None;
    let looked = each(task, |event| {
        if let Event::Start(element) | Event::Empty(element) = event
            && element.name().as_ref() == b"EliTask"
        {
            let name = attribute(element, b"installationName")?;
            let folder = attribute(element, b"installationDirectory")?;
            found = name.map(|name| (name, folder.unwrap_or_default()));
        }
        Ok(())
    });
    looked.ok()?;
    found.filter(|(name, _)| !name.is_empty())
}

fn xml(error: impl ToString) -> NoVariables {
    NoVariables::Xml(error.to_string())
}

fn each(
    text: &str,
    mut see: impl FnMut(&Event<'_>) -> Result<(), NoVariables>,
) -> Result<(), NoVariables> {
    let mut reader = Reader::from_str(text);
    loop {
        match reader.read_event().map_err(xml)? {
            Event::Eof => return Ok(()),
            event => see(&event)?,
        }
    }
}

fn variable_of(event: &Event<'_>) -> Result<Option<Variable>, NoVariables> {
    let (Event::Start(element) | Event::Empty(element)) = event else {
        return Ok(None);
    };
    if element.name().as_ref() != b"Variable" {
        return Ok(None);
    }
    let (name, value) = (attribute(element, b"name")?, attribute(element, b"value")?);
    Ok(name
        .zip(value)
        .map(|(name, value)| Variable { name, value }))
}

fn attribute(element: &BytesStart<'_>, key: &[u8]) -> Result<Option<String>, NoVariables> {
    for attribute in element.attributes() {
        let attribute = attribute.map_err(xml)?;
        if attribute.key.as_ref() == key {
            return attribute
                .unescape_value()
                .map(|value| Some(value.into_owned()))
                .map_err(xml);
        }
    }
    Ok(None)
}

/// The variables that a generated program sets at its beginning: each a line `global NAME` and the line `NAME = VALUE`
/// behind it, before the first node.
pub fn in_program(text: &str) -> Vec<Variable> {
    let mut found: Vec<Variable> = Vec::new();
    for (name, value, _) in beginning(text) {
        if found.len() < VARIABLES_MAX && !found.iter().any(|known| known.name == name) {
            found.push(Variable {
                name: name.to_owned(),
                value: value.to_owned(),
            });
        }
    }
    found
}

/// The text with current values where it first sets these variables. What sets them again, as the start values of a
/// task do, stays, and so does the number of every line.
pub fn with_values(text: &str, values: &BTreeMap<String, String>) -> String {
    let mut changed = text.to_owned();
    let mut set: Vec<&str> = Vec::new();
    let mut places = Vec::new();
    for (name, old, at) in beginning(text) {
        if let Some(value) = values.get(name)
            && !set.contains(&name)
        {
            set.push(name);
            places.push((at, old.len(), value));
        }
    }
    for (at, length, value) in places.into_iter().rev() {
        changed.replace_range(at..at + length, value);
    }
    changed
}

/// Name, value and the place of the value in the text.
fn beginning(text: &str) -> impl Iterator<Item = (&str, &str, usize)> {
    let mut lines = Vec::new();
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        if line.trim_start().starts_with('$') {
            break;
        }
        lines.push((line.trim_end_matches(['\n', '\r']), at));
        at += line.len();
    }
    let pairs: Vec<_> = lines
        .windows(2)
        .filter_map(|pair| {
            let [(declared, _), (set, at)] = pair else {
                return None;
            };
            let name = declared.trim().strip_prefix("global ")?.trim();
            let rest = set.trim_start().strip_prefix(name)?.trim_start();
            let value = rest.strip_prefix('=')?;
            if value.starts_with('=') {
                return None;
            }
            let value = value.trim_start();
            let at = at + (set.len() - value.len());
            let value = value.trim_end();
            Some((name, value, at))
        })
        .collect();
    pairs.into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const FILE: &str = "<VariablesManager>\n    <Variable name=\"width\" value=\"594.59998\" remarks=\"mm, \
                        &lt;from&gt; the line\" favorite=\"false\"/>\n    \
                        <Variable name=\"home_q\" value=\"[0, -1.5708]\" remarks=\"\" favorite=\"true\"/>\n    \
                        <Variable name=\"word\" value=\"&quot;a &amp; b&quot;\" remarks=\"\" favorite=\"true\"/>\n\
                        </VariablesManager>\n";

    fn values(pairs: &[(&str, &str)]) -> BTreeMap<String, String> {
        pairs
            .iter()
            .map(|(name, value)| ((*name).to_owned(), (*value).to_owned()))
            .collect()
    }

    #[test]
    fn a_file_is_read_and_written_back_with_other_values_only() {
        let read = variables(FILE).unwrap();
        let pairs: Vec<_> = read.iter().map(|v| (&*v.name, &*v.value)).collect();
        assert_eq!(
            pairs,
            [
                ("width", "594.59998"),
                ("home_q", "[0, -1.5708]"),
                ("word", "\"a & b\"")
            ]
        );
        assert_eq!(rewritten(FILE, &BTreeMap::new()).unwrap(), FILE);
        let changed = rewritten(FILE, &values(&[("width", "7"), ("word", "\"<\"")])).unwrap();
        let expected = FILE
            .replace("594.59998", "7")
            .replace("&quot;a &amp; b&quot;", "&quot;&lt;&quot;");
        assert_eq!(changed, expected);
    }

    #[test]
    fn the_task_names_its_configuration() {
        let task = "<EliTask name=\"cell\" installationName=\"line 2\" \
                    installationDirectory=\"Dusan\"><MainTask/></EliTask>";
        let named = Some(("line 2".to_owned(), "Dusan".to_owned()));
        assert_eq!(configuration_of(task), named);
        assert_eq!(configuration_of("<EliTask name=\"cell\"/>"), None);
        assert_eq!(configuration_of("no XML <"), None);
    }

    #[test]
    fn the_current_values_replace_those_of_the_preamble() {
        let text = "def cell():\r\n  # mm\n  global width\n  width = 100\n  global q\n  q = [1, 2]  \n  global other\
                    \n  y = 1\n  global width\n  width = 3\n  $ 1 \"Main\"\n  global q\n  q = 5\nend\n";
        let found = in_program(text);
        assert_eq!(found.len(), 2);
        assert_eq!(found[1].value, "[1, 2]");
        let changed = with_values(text, &values(&[("width", "55"), ("q", "0"), ("y", "9")]));
        let expected =
            text.replacen("width = 100", "width = 55", 1)
                .replacen("q = [1, 2]", "q = 0", 1);
        assert_eq!(changed, expected);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn any_text_is_read_or_refused(text in "(<Variable |name=|value=|\"|/>|<|>|&|a|global b\n|b = 1\n|\n\
            | ){0,30}") {
            if let Ok(found) = variables(&text) {
                let values = found.iter().map(|v| (v.name.clone(), "1".to_owned())).collect();
                if let Ok(changed) = rewritten(&text, &values) {
                    prop_assert_eq!(variables(&changed).unwrap().len(), found.len());
                }
            }
            let set = with_values(&text, &values(&[("b", "22")]));
            prop_assert_eq!(set.lines().count(), text.lines().count());
        }
    }
}
