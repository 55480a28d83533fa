//! What has no place in a state, as messages in JSON with their schemas: variables of RTSI, states of port 30001.
//!
//! Numbers that are no numbers are null, since JSON has no other word for them.

use serde::ser::{Serialize, SerializeMap, Serializer};
use serde_json::{Map, Value as Json, json};
use wire::primary::state::{
    AdditionalInfo, Cartesian, Configuration, Joints, Masterboard, ModeData, Safety, State, Tool,
    ToolCommunication,
};
use wire::rtsi::{RtsiType, RtsiValue};

use super::RtsiStateMapper;

/// The variables that have no place in a state, by name, in the order of the recipe.
struct OutputsMessage<'a> {
    observer: &'a RtsiStateMapper,
    offered: &'a [(String, RtsiType)],
    values: &'a [RtsiValue],
}

impl Serialize for OutputsMessage<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        let named = self.offered.iter().zip(self.values).enumerate();
        for (index, ((name, _), value)) in named {
            if !self.observer.has_own_message(index) {
                continue;
            }
            match value {
                RtsiValue::Bool(x) => map.serialize_entry(name, x)?,
                RtsiValue::U8(x) => map.serialize_entry(name, x)?,
                RtsiValue::U16(x) => map.serialize_entry(name, x)?,
                RtsiValue::U32(x) => map.serialize_entry(name, x)?,
                RtsiValue::I32(x) => map.serialize_entry(name, x)?,
                RtsiValue::F64(x) => map.serialize_entry(name, x)?,
                RtsiValue::Vector3(x) => map.serialize_entry(name, x)?,
                RtsiValue::Vector6(x) => map.serialize_entry(name, x)?,
                RtsiValue::Vector6I32(x) => map.serialize_entry(name, x)?,
            }
        }
        map.end()
    }
}

/// One packet's variables that have no place in a state.
pub fn outputs_message(
    observer: &RtsiStateMapper,
    offered: &[(String, RtsiType)],
    values: &[RtsiValue],
) -> Vec<u8> {
    let outputs = OutputsMessage {
        observer,
        offered,
        values,
    };
    // Names and numbers always have a form.
    serde_json::to_vec(&outputs).unwrap_or_default()
}

/// The JSON Schema of [`outputs_message`].
pub fn outputs_schema(observer: &RtsiStateMapper, offered: &[(String, RtsiType)]) -> String {
    let named = offered.iter().enumerate();
    let told = named.filter(|(index, _)| observer.has_own_message(*index));
    let properties: Map<String, Json> = told
        .map(|(_, (name, kind))| (name.clone(), schema_of_kind(*kind)))
        .collect();
    json!({
        "title": "elite.RtsiOutputs",
        "description": "Variables of the robot's RTSI that have no place in a cycle, as they came.",
        "type": "object",
        "properties": properties,
    })
    .to_string()
}

fn schema_of_kind(kind: RtsiType) -> Json {
    let list = |of: &str| json!({"type": "array", "items": {"type": of}});
    match kind {
        RtsiType::Bool => json!({"type": "boolean"}),
        RtsiType::U8 | RtsiType::U16 | RtsiType::U32 | RtsiType::I32 => json!({"type": "integer"}),
        RtsiType::F64 => json!({"type": "number"}),
        RtsiType::Vector3 | RtsiType::Vector6 => list("number"),
        RtsiType::Vector6I32 => list("integer"),
    }
}

/// A state of port 30001 with the parts that came.
pub fn state_message(told: &State) -> Vec<u8> {
    // Serializing a state cannot fail: its maps have texts for keys.
    serde_json::to_vec(told).unwrap_or_default()
}

/// The JSON Schema of [`state_message`].
pub fn state_schema() -> String {
    let every_part = State {
        mode: Some(ModeData::default()),
        joints: Some(Joints::default()),
        cartesian: Some(Cartesian::default()),
        configuration: Some(Configuration::default()),
        masterboard: Some(Masterboard::default()),
        additional: Some(AdditionalInfo::default()),
        tool: Some(Tool::default()),
        safety: Some(Safety::default()),
        tool_communication: Some(ToolCommunication::default()),
        unknown: Vec::new(),
    };
    let sample = serde_json::to_value(&every_part).unwrap_or_default();
    let mut schema = schema_of_sample(&sample);
    schema["title"] = json!("elite.RobotState");
    schema["description"] =
        json!("A state message of port 30001: the parts that came, as they came.");
    schema.to_string()
}

fn schema_of_sample(sample: &Json) -> Json {
    match sample {
        Json::Object(fields) => {
            let properties: Map<String, Json> = fields
                .iter()
                .map(|(name, value)| (name.clone(), schema_of_sample(value)))
                .collect();
            json!({"type": "object", "properties": properties})
        }
        Json::Array(items) => {
            let item = items.first().map(schema_of_sample);
            json!({"type": "array", "items": item.unwrap_or_else(|| json!({}))})
        }
        Json::Bool(_) => json!({"type": "boolean"}),
        Json::Number(number) if !number.is_f64() => json!({"type": "integer"}),
        Json::Number(_) => json!({"type": "number"}),
        Json::String(_) => json!({"type": "string"}),
        Json::Null => json!({}),
    }
}
