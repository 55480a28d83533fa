//! What an RTSI client sends, cut into packets: names, recipes and values of every type.

use server::ports::rtsi::inputs::{InputLatch, InputVariable};
use server::ports::rtsi::outputs::OutputVariable;
use wire::rtsi::{
    RtsiType, RtsiValue, decode_text_message, packet_type, recipe_names, split_packet,
};

const KINDS: [RtsiType; 9] = [
    RtsiType::Bool,
    RtsiType::U8,
    RtsiType::U16,
    RtsiType::U32,
    RtsiType::I32,
    RtsiType::F64,
    RtsiType::Vector3,
    RtsiType::Vector6,
    RtsiType::Vector6I32,
];

pub(super) fn judge(data: &[u8]) {
    let mut rest = data;
    let (mut recipe, mut written) = (Vec::new(), InputLatch::default());
    while let Ok(Some(found)) = split_packet(rest) {
        assert!(found.bytes >= 3 && found.bytes <= rest.len());
        assert_eq!(found.payload.len(), found.bytes - 3);
        match found.letter {
            packet_type::INPUTS => {
                recipe = recipe_names(found.payload)
                    .filter_map(InputVariable::by_name)
                    .collect();
                for input in &recipe {
                    assert_eq!(InputVariable::by_name(&input.name()), Some(*input));
                }
            }
            packet_type::OUTPUTS => {
                for output in recipe_names(found.payload).filter_map(OutputVariable::by_name) {
                    assert!(output.kind().bytes() > 0);
                }
            }
            packet_type::DATA => {
                let mut values = found.payload;
                let package: Vec<(InputVariable, RtsiValue)> = recipe
                    .iter()
                    .filter_map(|input| Some((*input, RtsiValue::read(input.kind(), &mut values)?)))
                    .collect();
                let _ = written.take(&package);
            }
            packet_type::TEXT => {
                if let Some(message) = decode_text_message(found.payload) {
                    // Every byte is in a text, a length or the level; one that is no UTF-8 becomes three.
                    let length = message.text.len() + message.source.len();
                    assert!((found.payload.len() - 3..=3 * found.payload.len()).contains(&length));
                }
            }
            other => {
                let kind = KINDS[usize::from(other) % KINDS.len()];
                let mut bytes = found.payload;
                if let Some(value) = RtsiValue::read(kind, &mut bytes) {
                    let mut again = Vec::new();
                    value.write(&mut again);
                    assert_eq!(again.len(), kind.bytes());
                }
            }
        }
        rest = &rest[found.bytes..];
    }
}
