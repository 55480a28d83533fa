//! What an RTSI client sends, cut into packets: names, recipes and values of every type.

use server::ports::rtsi::inputs::{Input, Written};
use server::ports::rtsi::outputs::Output;
use wire::rtsi::{Kind, Value, letter, names, packet, text_message};

const KINDS: [Kind; 9] = [
    Kind::Bool,
    Kind::U8,
    Kind::U16,
    Kind::U32,
    Kind::I32,
    Kind::F64,
    Kind::Vector3,
    Kind::Vector6,
    Kind::Vector6I32,
];

pub(super) fn judge(data: &[u8]) {
    let mut rest = data;
    let (mut recipe, mut written) = (Vec::new(), Written::default());
    while let Ok(Some(found)) = packet(rest) {
        assert!(found.bytes >= 3 && found.bytes <= rest.len());
        assert_eq!(found.payload.len(), found.bytes - 3);
        match found.letter {
            letter::INPUTS => {
                recipe = names(found.payload).filter_map(Input::by_name).collect();
                for input in &recipe {
                    assert_eq!(Input::by_name(&input.name()), Some(*input));
                }
            }
            letter::OUTPUTS => {
                for output in names(found.payload).filter_map(Output::by_name) {
                    assert!(output.kind().bytes() > 0);
                }
            }
            letter::DATA => {
                let mut values = found.payload;
                let package: Vec<(Input, Value)> = recipe
                    .iter()
                    .filter_map(|input| Some((*input, Value::read(input.kind(), &mut values)?)))
                    .collect();
                let _ = written.take(&package);
            }
            letter::TEXT => {
                if let Some(message) = text_message(found.payload) {
                    // Every byte is in a text, a length or the level; one that is no UTF-8 becomes three.
                    let length = message.text.len() + message.source.len();
                    assert!((found.payload.len() - 3..=3 * found.payload.len()).contains(&length));
                }
            }
            other => {
                let kind = KINDS[usize::from(other) % KINDS.len()];
                let mut bytes = found.payload;
                if let Some(value) = Value::read(kind, &mut bytes) {
                    let mut again = Vec::new();
                    value.write(&mut again);
                    assert_eq!(again.len(), kind.bytes());
                }
            }
        }
        rest = &rest[found.bytes..];
    }
}
