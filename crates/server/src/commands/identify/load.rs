//! Payload, friction and the bias of the force sensor: linear least squares over samples.

use kinematics::identification::{
    BODY_PARAMETERS, BodyMotion, FitError, LeastSquares, Solution, body_regressor,
};
use kinematics::{DOF, JointAccelerations, JointSpeeds, Payload, Pose};
use messages::{Text, text};
use nalgebra::{DMatrix, Matrix3, SMatrix, Vector3};

use super::IdentifyError;
use super::answer::{Answer, FrictionAnswer, PayloadAnswer, SensorAnswer};
use super::samples::{RestInterval, Sample, Samples};

/// Names of the parameters of a body.
const BODY_NAMES: [Text; BODY_PARAMETERS] = [
    text!("the mass", "质量"),
    text!("the centre of gravity in x", "x 方向的重心"),
    text!("the centre of gravity in y", "y 方向的重心"),
    text!("the centre of gravity in z", "z 方向的重心"),
    Text::fixed("Ixx", "Ixx"),
    Text::fixed("Iyy", "Iyy"),
    Text::fixed("Izz", "Izz"),
    Text::fixed("Ixy", "Ixy"),
    Text::fixed("Ixz", "Ixz"),
    Text::fixed("Iyz", "Iyz"),
];
/// An inertia is told where its standard deviation is below this share of the largest moment, and this much, kg m².
const INERTIA_SHARE: f64 = 0.2;
const INERTIA_SIGMA_MAX: f64 = 2e-3;
/// The inertia is found with the rest where the centre of gravity is told better than this then, m.
const COG_SIGMA_FULL_M: f64 = 2e-3;
/// A centre of gravity that is told worse is not told, m.
const COG_SIGMA_MAX_M: f64 = 0.02;
/// Joints that turn slower tell nothing about friction, rad/s.
const SLIDING_RAD_S: f64 = 0.02;
/// Errors of the model that are further apart do not hang together, s.
const STRETCH_S: f64 = 0.4;
/// Each joint has to turn this far for its friction, rad.
const TURN_MIN_RAD: f64 = 0.2;

fn motion(samples: &Samples, sample: &Sample) -> BodyMotion {
    BodyMotion::of_flange(
        samples.model.chain(),
        &sample.q,
        &sample.qd,
        &sample.qdd,
        sample.gravity,
    )
}

/// Rows of force and moment about the flange, in flange axes, as functions of the body; in the TCP frame, as the sensor
/// reads it: what the body does to the flange.
fn sensor_rows(motion: &BodyMotion, flange_from_tcp: &Pose) -> SMatrix<f64, 6, BODY_PARAMETERS> {
    let mut rows = -body_regressor(motion);
    for mut column in rows.column_iter_mut() {
        let force = Vector3::new(column[0], column[1], column[2]);
        let moment = Vector3::new(column[3], column[4], column[5]);
        let at_tcp = moment - flange_from_tcp.translation.cross(&force);
        let (force, moment) = (
            flange_from_tcp.rotate_back(force),
            flange_from_tcp.rotate_back(at_tcp),
        );
        for axis in 0..3 {
            column[axis] = force[axis];
            column[3 + axis] = moment[axis];
        }
    }
    rows
}

/// How much more moments count than forces, as long as their noise is not known, 1/m.
const FORCE_TO_MOMENT: f64 = 20.0;

/// The payload from the force reading.
pub fn payload_from_forces(samples: &Samples) -> Result<Answer, IdentifyError> {
    if samples
        .samples
        .iter()
        .all(|sample| sample.wrench[0].is_nan())
    {
        return Err(IdentifyError::CannotTell(text!(
            "the recordings hold no force reading (raw_wrench): use --from-torques",
            "记录中没有力读数（raw_wrench）：请用 --from-torques"
        )));
    }
    // Noise of forces and moments differs: the second fit knows how far the first one leaves each.
    let first = force_fit(samples, 4, FORCE_TO_MOMENT);
    let weight = first.map_or(FORCE_TO_MOMENT, |first| moment_weight(samples, &first));
    payload_of(
        force_fit(samples, BODY_PARAMETERS, weight),
        force_fit(samples, 4, weight),
        samples.samples.len(),
    )
}

/// Samples whose force is known, with their numbers and the rows of their readings.
fn force_rows(
    samples: &Samples,
) -> impl Iterator<Item = (usize, &Sample, SMatrix<f64, 6, BODY_PARAMETERS>)> {
    let known = |(_, sample): &(usize, &Sample)| sample.wrench.iter().all(|x| x.is_finite());
    let numbered = samples.samples.iter().enumerate().filter(known);
    numbered.map(|(index, sample)| {
        let rows = sensor_rows(&motion(samples, sample), &sample.flange_from_tcp);
        (index, sample, rows)
    })
}

/// What one standard deviation of the time between posture and reading, the same in the whole recording, adds to a
/// reading, given those before and after it: anything within half a cycle is alike likely.
fn skew(before: f64, after: f64) -> f64 {
    let change = (after - before) / 2.0 / 12_f64.sqrt();
    if change.is_finite() { change } else { 0.0 }
}

/// Ends a stretch of the sums whenever enough time has gone; a recording that begins anew ends one, too.
fn end_stretches(sums: &mut LeastSquares, end: &mut f64, time: f64) {
    if time >= *end || time < *end - STRETCH_S {
        if end.is_finite() {
            sums.end_stretch();
        }
        *end = time + STRETCH_S;
    }
}

/// Fits the first `unknowns` parameters of the body; moments count `weight` times.
fn force_fit(samples: &Samples, unknowns: usize, weight: f64) -> Result<Solution, FitError> {
    let mut sums = LeastSquares::new(unknowns);
    let mut stretch_end = f64::NEG_INFINITY;
    for (index, sample, rows) in force_rows(samples) {
        end_stretches(&mut sums, &mut stretch_end, sample.time);
        let around = samples.neighbours(index);
        for axis in 0..6 {
            let factor = if axis < 3 { 1.0 } else { weight };
            let row = rows.row(axis);
            let row: Vec<f64> = row.iter().take(unknowns).map(|x| x * factor).collect();
            let shared = around.map_or(0.0, |(before, after)| {
                skew(before.wrench[axis], after.wrench[axis])
            });
            sums.add_with_shared(&row, sample.wrench[axis] * factor, shared * factor);
        }
    }
    sums.solve()
}

/// What a fit leaves of forces, divided by what it leaves of moments.
fn moment_weight(samples: &Samples, fit: &Solution) -> f64 {
    let mut squares = [0.0; 2];
    for (_, sample, rows) in force_rows(samples) {
        for axis in 0..6 {
            let row = rows.row(axis);
            let model: f64 = row.iter().zip(&fit.values).map(|(a, b)| a * b).sum();
            squares[axis / 3] += (sample.wrench[axis] - model).powi(2);
        }
    }
    match squares[1] > 1e-18 && squares[0] > 1e-18 {
        true => (squares[0] / squares[1]).sqrt(),
        false => FORCE_TO_MOMENT,
    }
}

/// The payload from the torques of the joints; friction is found with it, so that it does not count as weight.
pub fn payload_from_torques(samples: &Samples) -> Result<Answer, IdentifyError> {
    need_torques(samples)?;
    payload_of(
        joint_torque_fit(samples, BODY_PARAMETERS),
        joint_torque_fit(samples, 4),
        samples.samples.len(),
    )
}

/// Torques of the joints as functions of a body on the flange, in its frame.
fn payload_torques(samples: &Samples, sample: &Sample) -> SMatrix<f64, DOF, BODY_PARAMETERS> {
    let frames = samples.model.forward(&sample.q);
    let jacobian = frames.jacobian(frames.base_from_flange.translation);
    let mut wrenches = body_regressor(&motion(samples, sample));
    for mut column in wrenches.column_iter_mut() {
        let force = frames
            .base_from_flange
            .rotate(Vector3::new(column[0], column[1], column[2]));
        let moment = frames
            .base_from_flange
            .rotate(Vector3::new(column[3], column[4], column[5]));
        for axis in 0..3 {
            column[axis] = force[axis];
            column[3 + axis] = moment[axis];
        }
    }
    jacobian.transpose() * wrenches
}

fn need_torques(samples: &Samples) -> Result<(), IdentifyError> {
    match samples
        .samples
        .iter()
        .any(|sample| !sample.torque[0].is_nan())
    {
        true => Ok(()),
        false => Err(IdentifyError::CannotTell(text!(
            "the recordings hold no torques of the joints (actual_torque)",
            "记录中没有关节力矩（actual_torque）"
        ))),
    }
}

/// The fit with inertia if it tells the centre of gravity well, else the one without: inertia that is left out would
/// count as weight where the motion is fast, inertia that is not seen where it is slow would make the rest vague.
fn payload_of(
    with_inertia: Result<Solution, FitError>,
    without: Result<Solution, FitError>,
    samples: usize,
) -> Result<Answer, IdentifyError> {
    let is_sharp = |solution: &Solution| {
        let mass = solution.values[0];
        let cog = solution.sigmas[1..4].iter().fold(0.0_f64, |a, b| a.max(*b));
        mass > 0.0 && cog < COG_SIGMA_FULL_M * mass
    };
    let (solution, has_inertia) = match with_inertia.ok().filter(is_sharp) {
        Some(solution) => {
            let inertia = inertia_of(&solution.values);
            let largest = inertia[..3].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            let sigma = solution.sigmas[4..BODY_PARAMETERS]
                .iter()
                .fold(0.0_f64, |a, b| a.max(*b));
            let is_told = sigma < INERTIA_SIGMA_MAX.min(INERTIA_SHARE * largest.max(5e-3));
            (solution, is_told)
        }
        None => {
            let solution = without.map_err(|error| IdentifyError::of_fit(&error, &BODY_NAMES))?;
            (solution, false)
        }
    };
    let mass = solution.values[0];
    if mass <= 3.0 * solution.sigmas[0] || mass < 1e-3 {
        return Err(IdentifyError::CannotTell(text!(
            "the payload is too light to tell where it is: {mass:.4} kg, ± {:.4} kg",
            "负载太轻，无法判断其位置：{mass:.4} kg，± {:.4} kg",
            solution.sigmas[0]
        )));
    }
    let cog: [f64; 3] = core::array::from_fn(|axis| solution.values[1 + axis] / mass);
    // Of a quotient: d(mc/m) = (d(mc) - c dm) / m.
    let covariance: &DMatrix<f64> = &solution.covariance;
    let sigma_cog: [f64; 3] = core::array::from_fn(|axis| {
        let c = cog[axis];
        let variance = covariance[(1 + axis, 1 + axis)] - 2.0 * c * covariance[(0, 1 + axis)]
            + c * c * covariance[(0, 0)];
        variance.max(0.0).sqrt() / mass
    });
    if sigma_cog.iter().any(|sigma| *sigma > COG_SIGMA_MAX_M) {
        return Err(IdentifyError::CannotTell(text!(
            "the motion does not tell the centre of gravity (mass {mass:.3} kg): turn the flange about two axes",
            "此运动无法判断重心（质量 {mass:.3} kg）：请绕两个轴转动法兰"
        )));
    }
    Ok(Answer::Payload(PayloadAnswer {
        mass,
        cog,
        inertia: has_inertia.then(|| inertia_of(&solution.values)),
        sigma_mass: solution.sigmas[0],
        sigma_cog,
        residual_rms: solution.residual_rms,
        samples,
    }))
}

/// Inertia about the centre of gravity.
fn inertia_of(values: &[f64]) -> [f64; 6] {
    let mass = values[0];
    let c = Vector3::new(values[1], values[2], values[3]) / mass;
    let about_origin = Matrix3::new(
        values[4], values[7], values[8], values[7], values[5], values[9], values[8], values[9],
        values[6],
    );
    let moved = (Matrix3::identity() * c.norm_squared() - c * c.transpose()) * mass;
    let i = about_origin - moved;
    [i.m11, i.m22, i.m33, i.m12, i.m13, i.m23]
}

/// Friction of each joint.
pub fn friction(samples: &Samples) -> Result<Answer, IdentifyError> {
    need_torques(samples)?;
    let still: Vec<Text> = (0..DOF)
        .filter(|joint| {
            let range = samples.samples.iter().map(|sample| sample.q[*joint]);
            let (low, high) = range.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(x), high.max(x))
            });
            high - low < TURN_MIN_RAD
        })
        .map(|joint| text!("joint {joint}", "关节 {joint}"))
        .collect();
    if !still.is_empty() {
        return Err(IdentifyError::CannotTell(text!(
            "{} did not turn far enough (0.2 rad) to tell its friction",
            "{}转动不足（0.2 rad），无法判断摩擦",
            Text::joined(still, ", ", "、")
        )));
    }
    // With a body on the flange: what hangs there is not known.
    let solution = joint_torque_fit(samples, BODY_PARAMETERS)
        .or_else(|_| joint_torque_fit(samples, 4))
        .or_else(|_| joint_torque_fit(samples, 0))
        .map_err(|error| {
            let names: Vec<Text> = (0..2 * DOF)
                .map(|index| match index < DOF {
                    true => text!("the dry friction of joint {index}", "关节 {index} 的干摩擦"),
                    false => text!(
                        "the viscous friction of joint {}",
                        "关节 {} 的粘性摩擦",
                        index - DOF
                    ),
                })
                .collect();
            IdentifyError::of_fit(&error, &names)
        })?;
    let body = solution.values.len() - 2 * DOF;
    let part = |values: &[f64], begin: usize| core::array::from_fn(|joint| values[begin + joint]);
    Ok(Answer::Friction(FrictionAnswer {
        coulomb: part(&solution.values, body),
        viscous: part(&solution.values, body + DOF),
        sigma_coulomb: part(&solution.sigmas, body),
        sigma_viscous: part(&solution.sigmas, body + DOF),
        residual_rms: solution.residual_rms,
        samples: samples.samples.len(),
    }))
}

/// Torques of sliding joints, less those of the links, as functions of a body on the flange (its first `body`
/// parameters) and of the friction of each joint.
fn joint_torque_fit(samples: &Samples, body: usize) -> Result<Solution, FitError> {
    let mut sums = LeastSquares::new(body + 2 * DOF);
    let mut stretch_end = f64::NEG_INFINITY;
    for (index, sample) in samples.samples.iter().enumerate() {
        end_stretches(&mut sums, &mut stretch_end, sample.time);
        let around = samples.neighbours(index);
        let model = torques_of_links(samples, sample);
        let rows = payload_torques(samples, sample);
        for joint in 0..DOF {
            let speed = sample.qd[joint];
            // Dry friction of a joint at rest may be anything.
            if speed.abs() < SLIDING_RAD_S || sample.torque[joint].is_nan() {
                continue;
            }
            let mut row = vec![0.0; body + 2 * DOF];
            for (column, value) in row.iter_mut().take(body).enumerate() {
                *value = rows[(joint, column)];
            }
            row[body + joint] = speed.signum();
            row[body + DOF + joint] = speed;
            // Where the joint turns round, dry friction changes, and not with time.
            let slides = |other: &Sample| {
                other.qd[joint].abs() >= SLIDING_RAD_S && other.qd[joint].signum() == speed.signum()
            };
            let shared = around
                .filter(|(before, after)| slides(before) && slides(after))
                .map_or(0.0, |(before, after)| {
                    skew(before.torque[joint], after.torque[joint])
                });
            sums.add_with_shared(&row, sample.torque[joint] - model[joint], shared);
        }
    }
    sums.solve()
}

/// Torques of the arm without anything on its flange.
fn torques_of_links(samples: &Samples, sample: &Sample) -> [f64; DOF] {
    let bare = samples.model.dynamics(&Payload::NONE, sample.gravity);
    bare.inverse_dynamics(&sample.q, &sample.qd, &sample.qdd).0
}

/// Bias of the force sensor, and what hangs below it, from rests.
pub fn sensor(samples: &Samples, at: &[f64]) -> Result<Answer, IdentifyError> {
    let rests: Vec<RestInterval> = samples
        .chosen_rests(at)?
        .into_iter()
        .filter(|rest| rest.wrench.iter().all(|x| x.is_finite()))
        .collect();
    if rests.len() < 3 {
        return Err(IdentifyError::CannotTell(text!(
            "{} rests with a force reading: three or more with other orientations are needed",
            "带力读数的静止段有 {} 个：需要三个以上不同的姿态",
            rests.len()
        )));
    }
    let mut sums = LeastSquares::new(10);
    let mut count = 0;
    for rest in &rests {
        let motion = BodyMotion::of_flange(
            samples.model.chain(),
            &rest.q,
            &JointSpeeds([0.0; DOF]),
            &JointAccelerations([0.0; DOF]),
            rest.gravity,
        );
        let rows = sensor_rows(&motion, &rest.flange_from_tcp);
        let weight = (rest.count as f64).sqrt();
        count += rest.count;
        for axis in 0..6 {
            let factor = weight * if axis < 3 { 1.0 } else { FORCE_TO_MOMENT };
            let mut row = [0.0; 10];
            row[axis] = factor;
            for column in 0..4 {
                row[6 + column] = rows[(axis, column)] * factor;
            }
            sums.add(&row, rest.wrench[axis] * factor);
        }
    }
    let names = [
        text!("the bias of the force in x", "x 方向力的零偏"),
        text!("the bias of the force in y", "y 方向力的零偏"),
        text!("the bias of the force in z", "z 方向力的零偏"),
        text!("the bias of the moment about x", "绕 x 轴力矩的零偏"),
        text!("the bias of the moment about y", "绕 y 轴力矩的零偏"),
        text!("the bias of the moment about z", "绕 z 轴力矩的零偏"),
        text!("the mass", "质量"),
        text!("the centre of gravity in x", "x 方向的重心"),
        text!("the centre of gravity in y", "y 方向的重心"),
        text!("the centre of gravity in z", "z 方向的重心"),
    ];
    let solution = sums
        .solve()
        .map_err(|error| match IdentifyError::of_fit(&error, &names) {
            IdentifyError::CannotTell(text) => IdentifyError::CannotTell(text!(
                "{text}: the rests are too much alike, turn the flange about two axes between them",
                "{text}：各静止段过于相似，请在它们之间绕两个轴转动法兰"
            )),
            other => other,
        })?;
    let mass = solution.values[6];
    let cog = match mass.abs() > 1e-3 {
        true => core::array::from_fn(|axis| solution.values[7 + axis] / mass),
        false => [0.0; 3],
    };
    Ok(Answer::Sensor(SensorAnswer {
        bias: core::array::from_fn(|axis| solution.values[axis]),
        mass,
        cog,
        sigma_bias: core::array::from_fn(|axis| solution.sigmas[axis]),
        sigma_mass: solution.sigmas[6],
        sigma_cog: core::array::from_fn(|axis| solution.sigmas[7 + axis] / mass.abs().max(1e-3)),
        residual_rms: solution.residual_rms / (count as f64 / rests.len() as f64).sqrt(),
        samples: rests.len(),
    }))
}
