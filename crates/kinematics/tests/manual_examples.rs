//! The examples of the manual's sections 3.2 (mathematics), 4.8 (wrench_trans) and those around them that need a model.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot read its input fails"
)]

use crate::common;

use common::{assert_close, get, vectors};
use kinematics::script_math as m;
use kinematics::{JointPositions, Pose, RobotModel, RpyPose, Wrench};
use serde_json::{Value, json};

/// The arguments of a call in a script, without their names: `f(a, b=c)` gives the name and `[a, c]`.
fn parse(code: &str) -> (String, Vec<Value>) {
    let (name, rest) = code.split_once('(').unwrap();
    let mut text = rest.strip_suffix(')').unwrap().to_owned();
    for keyword in ["qnear=", "tcp="] {
        text = text.replace(keyword, "");
    }
    let text = text
        .replace("True", "true")
        .replace("4<5", "true")
        .replace("9==10", "false")
        .replace("9%3==0", "true");
    (
        name.to_owned(),
        serde_json::from_str(&format!("[{text}]")).unwrap(),
    )
}

struct Call {
    arguments: Vec<Value>,
    model: Option<RobotModel>,
}

impl Call {
    fn number(&self, index: usize) -> f64 {
        self.arguments[index].as_f64().unwrap()
    }

    fn list(&self, index: usize) -> Vec<f64> {
        match &self.arguments[index] {
            Value::Number(n) => vec![n.as_f64().unwrap()],
            list => serde_json::from_value(list.clone()).unwrap(),
        }
    }

    fn six(&self, index: usize) -> [f64; 6] {
        self.list(index).try_into().unwrap()
    }

    fn rpy(&self, index: usize) -> RpyPose {
        RpyPose::from_array(self.six(index))
    }

    fn pose(&self, index: usize) -> Pose {
        Pose::from_rpy(&self.rpy(index))
    }

    fn model(&self) -> &RobotModel {
        self.model.as_ref().unwrap()
    }

    /// What the library answers, in the JSON of the example.
    fn answer(&self, name: &str) -> Value {
        let fallible = |result: Result<f64, m::DomainError>| match result {
            Ok(x) => json!(x),
            Err(e) => json!(format!("exception: {e}")),
        };
        match name {
            "bit_list_to_integer" => {
                let bits: Vec<bool> = serde_json::from_value(self.arguments[0].clone()).unwrap();
                json!(m::bit_list_to_integer(&bits))
            }
            "integer_to_bit_list" => {
                json!(m::integer_to_bit_list(self.arguments[0].as_i64().unwrap()))
            }
            "acos" => fallible(m::acos(self.number(0))),
            "asin" => fallible(m::asin(self.number(0))),
            "atan2" => json!(m::atan2(self.number(0), self.number(1))),
            "d2r" => json!(m::d2r(self.number(0))),
            "r2d" => json!(m::r2d(self.number(0))),
            "log" => fallible(m::log(self.number(0), self.number(1))),
            "sqrt" => fallible(m::sqrt(self.number(0))),
            "norm" => json!(m::norm(&self.list(0))),
            "normalize" => {
                let mut v = self.list(0);
                match m::normalize(&mut v) {
                    Ok(()) => json!(v),
                    Err(e) => json!(format!("exception: {e}")),
                }
            }
            "point_dist" => json!(m::point_dist(&self.rpy(0), &self.rpy(1))),
            "pose_add" => json!(m::pose_add(&self.rpy(0), &self.rpy(1)).to_array()),
            "pose_dist" => json!(m::pose_dist(&self.rpy(0), &self.rpy(1))),
            "pose_inv" => json!(m::pose_inv(&self.rpy(0)).to_array()),
            "pose_sub" => json!(m::pose_sub(&self.rpy(0), &self.rpy(1)).to_array()),
            "pose_trans" => json!(m::pose_trans(&self.rpy(0), &self.rpy(1)).to_array()),
            "rotvec2rpy" => json!(m::rotvec2rpy(self.list(0).try_into().unwrap())),
            "rpy2rotvec" => json!(m::rpy2rotvec(self.list(0).try_into().unwrap())),
            "interpolate_pose" => {
                json!(m::interpolate_pose(&self.rpy(0), &self.rpy(1), self.number(2)).to_array())
            }
            "wrench_trans" => {
                json!(m::wrench_trans(&self.rpy(0), &Wrench::from_array(self.six(1))).to_array())
            }
            "get_forward_kin" => {
                let q = JointPositions(self.six(0));
                json!(self.model().tcp_pose(&q, &self.pose(1)).to_rpy().to_array())
            }
            "get_all_inverse_kin" => {
                let found = self.model().inverse_all(&self.pose(0), &self.pose(1));
                json!(found.iter().map(|q| q.0).collect::<Vec<_>>())
            }
            "get_inverse_kin" => {
                let near = JointPositions(self.six(1));
                let found = self
                    .model()
                    .inverse_nearest(&self.pose(0), &self.pose(2), &near);
                json!(found.unwrap().0)
            }
            "get_inverse_kin_has_solution" => {
                json!(
                    !self
                        .model()
                        .inverse_all(&self.pose(0), &self.pose(1))
                        .is_empty()
                )
            }
            other => panic!("no function {other}"),
        }
    }
}

/// All numbers of a JSON value in order.
fn flat(value: &Value, into: &mut Vec<f64>) {
    match value {
        Value::Array(list) => list.iter().for_each(|v| flat(v, into)),
        Value::Bool(b) => into.push(f64::from(u8::from(*b))),
        other => into.push(
            other
                .as_f64()
                .unwrap_or_else(|| panic!("{other} is not a number")),
        ),
    }
}

#[test]
fn every_example_of_the_manual_comes_out() {
    // Functions of the language itself, tested where the language is.
    let elsewhere = [
        "get_list_length",
        "length",
        "atan",
        "cos",
        "sin",
        "tan",
        "ceil",
        "floor",
        "pow",
        "random",
    ];
    let mut tested = 0;
    for example in vectors("manual_examples.json").as_array().unwrap() {
        let section: String = get(example, "section");
        if !["3.1.1", "3.1.2", "4.8"].contains(&section.as_str()) && !section.starts_with("3.2.") {
            continue;
        }
        let code = example["code"].as_str().unwrap();
        let (name, arguments) = parse(code);
        if elsewhere.contains(&name.as_str()) {
            continue;
        }
        let model = example["model"]
            .as_str()
            .map(|n| RobotModel::built_in(n).unwrap());
        let answer = Call { arguments, model }.answer(&name);
        if example["match"] == "error" {
            assert!(
                answer
                    .as_str()
                    .is_some_and(|s| s.contains("invalid parameter")),
                "{code}: {answer}"
            );
        } else {
            let (mut is, mut should) = (Vec::new(), Vec::new());
            flat(&answer, &mut is);
            flat(&example["expect"], &mut should);
            let tolerance: f64 = get(example, "tolerance");
            // Sums may be taken in another order than in the reference.
            assert_close(code, &is, &should, tolerance.max(1e-15));
        }
        tested += 1;
    }
    assert!(tested >= 70, "only {tested} examples were tested");
}

#[test]
fn arguments_without_a_value_are_refused_by_name() {
    assert_eq!(
        m::acos(1.5).unwrap_err().to_string(),
        "acos(): f must be between -1 and 1, got 1.5"
    );
    assert_eq!(
        m::log(1.0, 2.0).unwrap_err().to_string(),
        "log(): b must be positive and not 1, got 1"
    );
    for bad in [
        m::asin(f64::NAN),
        m::sqrt(-1.0),
        m::log(2.0, 0.0),
        m::log(-2.0, 3.0),
    ] {
        bad.unwrap_err();
    }
}

#[test]
fn thirty_two_bits_are_a_signed_number() {
    for x in [0, 1, -1, 11, i64::from(i32::MIN), i64::from(i32::MAX)] {
        assert_eq!(m::bit_list_to_integer(&m::integer_to_bit_list(x)), x);
    }
    let mut long = vec![true; 31];
    assert_eq!(m::bit_list_to_integer(&long), i64::from(i32::MAX));
    long.push(true);
    assert_eq!(m::bit_list_to_integer(&long), -1);
    long.extend([true, false]);
    assert_eq!(m::bit_list_to_integer(&long), -1);
    assert_eq!(m::bit_list_to_integer(&[]), 0);
}

#[test]
fn very_long_and_very_short_vectors_keep_their_direction() {
    for size in [1e-200, 1e200] {
        let mut v = [3.0 * size, 4.0 * size];
        assert_close("length", &[m::norm(&v) / size], &[5.0], 1e-15);
        m::normalize(&mut v).unwrap();
        assert_close("direction", &v, &[0.6, 0.8], 1e-15);
    }
}
