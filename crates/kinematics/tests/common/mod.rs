//! Reading of the shared vectors in `tests/vectors/`, and comparisons.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]
#![allow(dead_code, reason = "every test binary uses its own part")]

pub mod random;

use kinematics::{JointPositions, RobotModel};
use serde::de::DeserializeOwned;
use serde_json::Value;

pub fn vectors(name: &str) -> Value {
    let path = format!("{}/../../tests/vectors/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{path}: {e}"))
}

pub fn get<T: DeserializeOwned>(value: &Value, key: &str) -> T {
    serde_json::from_value(value[key].clone()).unwrap_or_else(|e| panic!("{key}: {e}"))
}

pub fn cases<'a>(value: &'a Value, key: &str) -> &'a Vec<Value> {
    let list = value[key]
        .as_array()
        .unwrap_or_else(|| panic!("{key} is not a list"));
    assert!(!list.is_empty(), "{key} is empty: the test would not test");
    list
}

/// Every arm with its part of the reference values.
pub fn arms() -> Vec<(RobotModel, Value)> {
    let truth = vectors("truth.json");
    let arms: Vec<_> = RobotModel::names()
        .map(|name| {
            let values = truth["models"][name].clone();
            assert!(values.is_object(), "no reference values for {name}");
            (RobotModel::built_in(name).unwrap(), values)
        })
        .collect();
    assert_eq!(arms.len(), 6);
    arms
}

pub fn q(value: &Value) -> JointPositions {
    JointPositions(get(value, "q"))
}

#[track_caller]
pub fn assert_close(what: &str, is: &[f64], should: &[f64], tolerance: f64) {
    assert_eq!(is.len(), should.len(), "{what}: lengths");
    for (i, (a, b)) in is.iter().zip(should).enumerate() {
        assert!(
            (a - b).abs() <= tolerance,
            "{what}[{i}]: {a} instead of {b}, tolerance {tolerance}"
        );
    }
}
