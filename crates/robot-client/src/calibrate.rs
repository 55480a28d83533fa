//! The arm's own kinematics, from the configuration part of port 30001.

use std::path::Path;
use std::time::Duration;

use kinematics::{
    Calibration, CalibrationError, DhTable, JointPositions, ModelError, Pose, RobotModel, RpyPose,
};
use messages::Localized;
use thiserror::Error;
use tokio::time::timeout;
use wire::primary::Message;
use wire::primary::state::{Configuration, State};

use crate::address::RobotAddress;
use crate::primary::{PrimaryClient, PrimaryError};

/// States come ten times a second, and each has the configuration.
const PATIENCE: Duration = Duration::from_secs(5);

/// Places of every joint that the arm is compared in, rad: with six joints these are 729 places.
const COMPARISON_ANGLES: [f64; 3] = [-1.1, 0.3, 1.7];

/// A reason why there is no calibration, told in a sentence.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum CalibrateError {
    /// The robot does not talk.
    #[error(transparent)]
    Primary(#[from] PrimaryError),
    /// The robot does not say what kind of arm it has.
    #[error("the robot at {address} sends states without the configuration of its arm")]
    #[zh("{address} 处的机器人发送的状态没有机械臂配置")]
    NoConfiguration {
        /// Address of the robot.
        address: RobotAddress,
    },
    /// The arm is none of the models that we know.
    #[error(
        "the robot at {address} is of type {robot_type}, which is none of {}",
        known_types()
    )]
    #[zh("{address} 处的机器人型号为 {robot_type}，不在 {} 之中", known_types())]
    UnknownType {
        /// Address of the robot.
        address: RobotAddress,
        /// The vendor's number.
        robot_type: u32,
    },
    /// A built-in model cannot be had.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// What it sends is no arm of this model.
    #[error("what the robot sends is no arm of its type: {0}")]
    #[zh("机器人发送的数据不是其型号的机械臂：{0}")]
    NoArm(#[from] CalibrationError),
}

fn known_types() -> String {
    let types = RobotModel::names().filter_map(|name| {
        let number = RobotModel::built_in(name).ok()?.type_number()?;
        Some(format!("{number} ({name})"))
    });
    types.collect::<Vec<_>>().join(", ")
}

/// How far an arm is from its sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KinematicDeviation {
    /// Largest distance of the flange from where the nominal arm has it, m.
    pub position: f64,
    /// Mean of these distances, m.
    pub position_mean: f64,
    /// Largest angle between the two, rad.
    pub angle: f64,
}

/// What was read of an arm.
#[derive(Debug)]
pub struct CalibrationReading {
    /// Kinematics of the robot's arm.
    pub calibration: Calibration,
    /// Distance of the arm from the data sheet of its model.
    pub distance: KinematicDeviation,
    /// TCP of the robot's tool in the flange frame, where the robot reports one.
    pub tcp: Option<RpyPose>,
    /// Distance between the TCP that the robot reports and the one that follows from these numbers, m, where the robot
    /// reports one: more than a millimetre means that its kinematics have something that it does not send, such as
    /// offsets of the joints.
    pub tcp_residual: Option<f64>,
    /// The state that all of this was read from, but for the configuration.
    pub state: State,
}

/// Asks the robot; `path` is what errors call the calibration.
///
/// # Errors
/// [`CalibrateError`]
pub async fn read(
    address: &RobotAddress,
    path: &Path,
) -> Result<CalibrationReading, CalibrateError> {
    let mut robot = PrimaryClient::connect(address).await?;
    let configured = timeout(PATIENCE, wait_for_configuration(&mut robot)).await;
    let (state, configuration) = configured.map_err(|_| CalibrateError::NoConfiguration {
        address: address.clone(),
    })??;
    let mut reading = arm_of(&configuration, address, path)?;
    reading.tcp = tool_of(&state);
    reading.tcp_residual = tcp_residual(&state, &reading.calibration.open()?);
    reading.state = state;
    Ok(reading)
}

async fn wait_for_configuration(
    robot: &mut PrimaryClient,
) -> Result<(State, Configuration), PrimaryError> {
    loop {
        if let Message::State(mut state) = robot.next().await?
            && let Some(configuration) = state.configuration.take()
        {
            return Ok((*state, configuration));
        }
    }
}

fn tool_of(state: &State) -> Option<RpyPose> {
    let offset = state.cartesian.as_ref()?.tcp_offset;
    offset
        .iter()
        .all(|value| value.is_finite())
        .then(|| RpyPose::from_array(offset))
}

/// Distance between the reported TCP and that of the arm in the same state, m.
fn tcp_residual(state: &State, arm: &RobotModel) -> Option<f64> {
    let joints = state.joints.as_ref()?;
    let q = JointPositions(joints.0.each_ref().map(|joint| joint.actual_q));
    let reported = Pose::from_rpy(&RpyPose::from_array(state.cartesian.as_ref()?.tcp_pose));
    let counted = arm.flange_pose(&q) * Pose::from_rpy(&tool_of(state)?);
    let distance = (reported.translation - counted.translation).norm();
    distance.is_finite().then_some(distance)
}

/// The arm that a configuration describes.
fn arm_of(
    configuration: &Configuration,
    address: &RobotAddress,
    path: &Path,
) -> Result<CalibrationReading, CalibrateError> {
    let mut found = None;
    for name in RobotModel::names() {
        let model = RobotModel::built_in(name)?;
        if model.type_number() == Some(configuration.robot_type) {
            found = Some((name, model));
        }
    }
    let Some((name, nominal)) = found else {
        return Err(CalibrateError::UnknownType {
            address: address.clone(),
            robot_type: configuration.robot_type,
        });
    };
    let table = DhTable {
        a: configuration.dh_a,
        d: configuration.dh_d,
        alpha: configuration.dh_alpha,
    };
    // The vendor's own programs read nothing of the numbers behind alpha; whether they are offsets of the joints is not
    // established. What they would do is found in `tcp_residual`.
    let calibration = Calibration::new(name, table, [0.0; 6], path)?;
    let measured = nominal.clone().calibrated(&calibration)?;
    let distance = distance(&nominal, &measured);
    Ok(CalibrationReading {
        calibration,
        distance,
        tcp: None,
        tcp_residual: None,
        state: State::default(),
    })
}

fn distance(nominal: &RobotModel, measured: &RobotModel) -> KinematicDeviation {
    let mut found = KinematicDeviation::default();
    let places = COMPARISON_ANGLES.len().pow(6);
    for place in 0..places {
        let mut rest = place;
        let q = core::array::from_fn(|_| {
            let joint = COMPARISON_ANGLES[rest % COMPARISON_ANGLES.len()];
            rest /= COMPARISON_ANGLES.len();
            joint
        });
        let q = JointPositions::from(q);
        let (own, other) = (nominal.flange_pose(&q), measured.flange_pose(&q));
        let position = (own.translation - other.translation).norm();
        let angle = own.rotation.rotation_to(&other.rotation).angle();
        found.position = found.position.max(position);
        found.position_mean += position / places as f64;
        found.angle = found.angle.max(angle);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(table: DhTable, robot_type: u32) -> Result<CalibrationReading, CalibrateError> {
        let configuration = Configuration {
            dh_a: table.a,
            dh_d: table.d,
            dh_alpha: table.alpha,
            robot_type,
            ..Configuration::default()
        };
        let address = RobotAddress::new("robot", 30001);
        arm_of(&configuration, &address, Path::new("arm.toml"))
    }

    fn nominal(name: &str) -> (DhTable, u32) {
        let model = RobotModel::built_in(name).expect("a built-in model");
        let table = model.modified_dh().expect("an arm of the CS shape");
        (table, model.type_number().expect("a number"))
    }

    #[test]
    fn every_arm_as_on_its_sheet_is_itself() {
        for name in RobotModel::names() {
            let (table, robot_type) = nominal(name);
            let reading = of(table, robot_type).expect("an arm");
            assert_eq!(reading.calibration.model(), name);
            assert!(reading.distance.position < 1e-9 && reading.distance.angle < 1e-7);
        }
    }

    #[test]
    fn a_longer_flange_is_as_far_away_as_it_is_longer() {
        let (mut table, robot_type) = nominal("cs66");
        table.d[5] += 0.003;
        let distance = of(table, robot_type).expect("an arm").distance;
        assert!((distance.position - 0.003).abs() < 1e-12);
        assert!((distance.position_mean - 0.003).abs() < 1e-12);
        assert!(distance.angle < 1e-7);
    }

    #[test]
    fn what_the_numbers_do_not_explain_is_as_far_as_the_tcp_is_elsewhere() {
        let arm = RobotModel::built_in("cs66").expect("a built-in model");
        let q = JointPositions([0.3, -1.2, 1.4, -1.6, -1.5, 0.2]);
        let tool = RpyPose::from_array([0.01, -0.02, 0.1, 0.0, 0.5, 0.0]);
        let tcp = arm.flange_pose(&q) * Pose::from_rpy(&tool);
        let mut pose = tcp.to_rpy().to_array();
        let state = |tcp_pose: [f64; 6]| State {
            joints: Some(wire::primary::state::Joints(core::array::from_fn(|i| {
                wire::primary::state::Joint {
                    actual_q: q.0[i],
                    ..Default::default()
                }
            }))),
            cartesian: Some(wire::primary::state::Cartesian {
                tcp_pose,
                tcp_offset: tool.to_array(),
            }),
            ..State::default()
        };
        let found = |pose| tcp_residual(&state(pose), &arm);
        assert!(found(pose).expect("known") < 1e-9);
        pose[2] += 0.004;
        assert!((found(pose).expect("known") - 0.004).abs() < 1e-9);
        pose[2] = f64::NAN;
        assert_eq!(found(pose), None);
        assert_eq!(tcp_residual(&State::default(), &arm), None);
    }

    #[test]
    fn values_that_are_no_arm_are_refused_with_a_sentence() {
        let (table, robot_type) = nominal("cs66");
        let mut broken = table;
        broken.d[0] = f64::NAN;
        let said = |result: Result<CalibrationReading, CalibrateError>| {
            result.expect_err("refused").to_string()
        };
        assert!(said(of(broken, robot_type)).contains("d[0] = NaN"));
        let mut far = table;
        far.a[2] = -1.0;
        assert!(said(of(far, robot_type)).contains("a[2]"));
        let zeros = DhTable {
            a: [0.0; 6],
            d: [0.0; 6],
            alpha: [0.0; 6],
        };
        assert!(said(of(zeros, robot_type)).starts_with("what the robot sends is no arm"));
        let unknown = said(of(table, 7));
        assert!(
            unknown.contains("type 7") && unknown.contains("6206 (cs66)"),
            "{unknown}"
        );
    }
}
