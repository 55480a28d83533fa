//! Whether two values are near each other: numbers, and lists of them to any depth.

use elite_lang::Value;

/// Nesting that is followed.
const DEPTH_MAX: usize = 32;

/// # Errors
/// Where they differ, and by how much.
pub(crate) fn near(a: &Value, b: &Value, tolerance: f64) -> Result<(), String> {
    compare(a, b, tolerance, &mut Vec::new())
}

fn compare(a: &Value, b: &Value, tolerance: f64, place: &mut Vec<usize>) -> Result<(), String> {
    let at = |place: &[usize]| match place {
        [] => String::new(),
        place => {
            let indices: Vec<String> = place.iter().map(|i| format!("[{i}]")).collect();
            format!(" at {}", indices.concat())
        }
    };
    if place.len() > DEPTH_MAX {
        return Err("they are nested too deeply".to_owned());
    }
    match (a.as_f64(), b.as_f64()) {
        (Some(x), Some(y)) => {
            let apart = (x - y).abs();
            return match x == y || apart <= tolerance {
                true => Ok(()),
                false => Err(format!("they differ by {apart}{}", at(place))),
            };
        }
        (None, None) => {}
        _ => return Err(format!("one is a number, the other is not{}", at(place))),
    }
    let (Some(items), Some(others)) = (a.as_items(), b.as_items()) else {
        return Err(format!(
            "{} and {} cannot be compared{}; numbers and lists of numbers can",
            a.type_name(),
            b.type_name(),
            at(place)
        ));
    };
    if items.len() != others.len() {
        let (have, want) = (items.len(), others.len());
        return Err(format!(
            "one has {have} items, the other {want}{}",
            at(place)
        ));
    }
    for (index, (item, other)) in items.iter().zip(&others).enumerate() {
        place.push(index);
        compare(item, other, tolerance, place)?;
        place.pop();
    }
    Ok(())
}
