//! Whether two values are near each other: numbers, and lists of them to any depth.

use elite_lang::Value;
use messages::{Text, text};

/// Nesting that is followed.
const DEPTH_MAX: usize = 32;

/// # Errors
/// Where they differ, and by how much.
pub(crate) fn near(a: &Value, b: &Value, tolerance: f64) -> Result<(), Text> {
    compare(a, b, tolerance, &mut Vec::new())
}

fn compare(a: &Value, b: &Value, tolerance: f64, place: &mut Vec<usize>) -> Result<(), Text> {
    if place.len() > DEPTH_MAX {
        return Err(text!("they are nested too deeply", "嵌套过深"));
    }
    match (a.as_f64(), b.as_f64()) {
        (Some(x), Some(y)) => {
            let apart = (x - y).abs();
            if x == y || apart <= tolerance {
                return Ok(());
            }
            return Err(match indices(place) {
                None => text!("they differ by {apart}", "相差 {apart}"),
                Some(at) => text!("they differ by {apart} at {at}", "位置 {at} 处相差 {apart}"),
            });
        }
        (None, None) => {}
        _ => {
            return Err(match indices(place) {
                None => text!("one is a number, the other is not", "一个是数，另一个不是"),
                Some(at) => text!(
                    "one is a number, the other is not at {at}",
                    "位置 {at}：一个是数，另一个不是"
                ),
            });
        }
    }
    let (Some(items), Some(others)) = (a.as_items(), b.as_items()) else {
        let (one, other) = (a.type_name(), b.type_name());
        return Err(match indices(place) {
            None => text!(
                "{one} and {other} cannot be compared; numbers and lists of numbers can",
                "{one} 与 {other} 不能比较；数和数的列表可以"
            ),
            Some(at) => text!(
                "{one} and {other} cannot be compared at {at}; numbers and lists of numbers can",
                "位置 {at}：{one} 与 {other} 不能比较；数和数的列表可以"
            ),
        });
    };
    if items.len() != others.len() {
        let (have, want) = (items.len(), others.len());
        return Err(match indices(place) {
            None => text!(
                "one has {have} items, the other {want}",
                "一个有 {have} 项，另一个有 {want} 项"
            ),
            Some(at) => text!(
                "one has {have} items, the other {want} at {at}",
                "位置 {at}：一个有 {have} 项，另一个有 {want} 项"
            ),
        });
    }
    for (index, (item, other)) in items.iter().zip(&others).enumerate() {
        place.push(index);
        compare(item, other, tolerance, place)?;
        place.pop();
    }
    Ok(())
}

/// `[0][2]`; none for the whole.
fn indices(place: &[usize]) -> Option<String> {
    let indices: Vec<String> = place.iter().map(|i| format!("[{i}]")).collect();
    (!place.is_empty()).then(|| indices.concat())
}
