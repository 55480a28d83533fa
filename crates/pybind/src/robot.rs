//! `elitescript.Robot`: one arm with its tool, payload and mounting.
//!
//! Owns the Python class; the mathematics is `kinematics::RobotModel`. A robot never changes after it is made, so
//! threads may share it.

use crate::NoSolutionError;
use crate::arguments::{PyArgument, PyArrayResult, Rows, common_batch, number, single};
use crate::results::{OneOrBatch, compute, detached, reshaped};
use kinematics::{
    Calibration, Dynamics, GRAVITY_UPRIGHT, JointAccelerations, JointPositions, JointSpeeds,
    Payload, PlaneMode, PlaneSwitches, Pose, RobotModel, RpyPose, SafetyBounds, SafetyPlane,
};
use nalgebra::{Matrix6, Vector3};
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::path::{Path, PathBuf};

/// Where the controller stands at start, and where inverse kinematics looks from when nothing else is said, rad.
#[expect(
    clippy::approx_constant,
    reason = "the documented default has four decimals"
)]
const HOME: [f64; 6] = [0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0];

/// Mass, centre of gravity, inertia: kg, m, kg m².
type PayloadTuple = (f64, [f64; 3], [f64; 6]);

/// The class and the arguments that make a robot again: model, tcp, payload, gravity, calibration.
type PickleParts<'py> = (
    Bound<'py, PyAny>,
    (String, [f64; 6], PayloadTuple, [f64; 3], Option<PathBuf>),
);

/// An arm with a tool, a payload and a mounting.
///
/// model: a name from `models()` or the path of a URDF file with six revolute joints. Default: that of the calibration
///     file, else "cs66".
/// tcp: the tool centre point as a pose in the flange frame, (6,), m and rad. Default: the flange itself.
/// payload: (mass, cog) or (mass, cog, inertia): kg, (3,) m in the flange frame, (6,) kg m^2 as Ixx, Iyy, Izz, Ixy,
/// Ixz,
///     Iyz about the centre of gravity in flange axes. Default: nothing.
/// gravity: free-fall acceleration in the base frame, (3,), m/s^2. Default (0, 0, -9.81), a base that stands upright.
///     It points down; the script's set_gravity takes the opposite direction.
/// calibration: the path of a TOML file with the lengths and twists measured of this very arm, as --calibration takes
/// it.
///
/// Robots do not change; make another one for another tool.
///
/// >>> robot = elitescript.Robot("cs66", tcp=[0, 0, 0.1, 0, 0, 0])
/// >>> robot.get_forward_kin([0, 0, 0, 0, 0, 0]).round(4)
/// array([-0.8175, -0.3395,  0.066 ,  1.5708,  0.    ,  0.    ])
#[pyclass(frozen, module = "elitescript")]
pub(crate) struct Robot {
    /// The model's name or file as it was given, for `repr` and pickling.
    source: String,
    model: RobotModel,
    tcp: RpyPose,
    payload: Payload,
    gravity: Vector3<f64>,
    dynamics: Dynamics,
}

fn pose(row: &[f64; 6]) -> Pose {
    Pose::from_rpy(&RpyPose::from_array(*row))
}

/// The arm and what its model is called.
fn open(model: Option<&str>, calibration: Option<&Path>) -> PyResult<(String, RobotModel)> {
    let Some(path) = calibration else {
        let name = model.unwrap_or("cs66");
        let arm =
            RobotModel::open(name).map_err(|e| PyValueError::new_err(format!("model: {e}")))?;
        return Ok((name.to_owned(), arm));
    };
    let wrong = |e| PyValueError::new_err(format!("calibration: {e}"));
    let measured = Calibration::load(path).map_err(wrong)?;
    let name = measured.model_for(model).map_err(wrong)?.to_owned();
    Ok((name, measured.open().map_err(wrong)?))
}

/// Rows of a matrix one after the other.
fn row_major(matrix: &Matrix6<f64>) -> [f64; 36] {
    let mut rows = [0.0; 36];
    rows.copy_from_slice(matrix.transpose().as_slice());
    rows
}

fn read_payload(given: PyArgument<'_, '_>) -> PyResult<Payload> {
    let wrong = || {
        PyValueError::new_err(format!(
            "payload must be (mass, cog) or (mass, cog, inertia), got {}",
            given
                .repr()
                .map_or_else(|_| "something else".to_owned(), |r| r.to_string())
        ))
    };
    let parts: Vec<Bound<'_, PyAny>> = given.extract().map_err(|_| wrong())?;
    let (mass, cog, inertia) = match parts.as_slice() {
        [mass, cog] => (mass, cog, [0.0; 6]),
        [mass, cog, inertia] => (mass, cog, single("payload inertia", inertia)?),
        _ => return Err(wrong()),
    };
    Payload::new(
        number("payload mass", mass)?,
        single("payload cog", cog)?,
        inertia,
    )
    .map_err(|e| PyValueError::new_err(e.to_string()))
}

/// Safety planes as rows of a point and a direction to the allowed side.
fn read_planes(given: Option<PyArgument<'_, '_>>) -> PyResult<SafetyBounds> {
    let Some(given) = given else {
        return Ok(SafetyBounds::default());
    };
    let rows = Rows::<6>::read("planes", given)?;
    let planes = (0..rows.batch().unwrap_or(1)).map(|i| rows.at(i));
    planes
        .enumerate()
        .try_fold(SafetyBounds::default(), |bounds, (i, row)| {
            let [x, y, z, nx, ny, nz] = *row;
            SafetyPlane::new([x, y, z], [nx, ny, nz], PlaneMode::Both, None)
                .and_then(|plane| bounds.with_plane(plane))
                .map_err(|error| PyValueError::new_err(format!("planes, row {i}: {error}")))
        })
}

/// The tool of a call, as transforms from the TCP to the flange: one for all rows, or one a row.
struct ToolTransforms {
    poses: Vec<Pose>,
    batch: Option<usize>,
}

impl ToolTransforms {
    #[inline]
    fn at(&self, row: usize) -> &Pose {
        &self.poses[if self.batch.is_some() { row } else { 0 }]
    }
}

impl Robot {
    /// The arm without its tool and payload.
    pub(crate) const fn model(&self) -> &RobotModel {
        &self.model
    }

    /// The tool of a call: its own, or the robot's.
    fn tool(&self, tcp: Option<PyArgument<'_, '_>>) -> PyResult<ToolTransforms> {
        let rows = Rows::read_or("tcp", tcp, self.tcp.to_array())?;
        let batch = rows.batch();
        Ok(ToolTransforms {
            poses: (0..batch.unwrap_or(1)).map(|i| pose(rows.at(i))).collect(),
            batch,
        })
    }

    /// A vector argument with the tool of the call, and their batch size.
    fn with_tool(
        &self,
        name: &str,
        given: PyArgument<'_, '_>,
        tcp: Option<PyArgument<'_, '_>>,
    ) -> PyResult<(Rows<6>, ToolTransforms, Option<usize>)> {
        let (rows, tool) = (Rows::read(name, given)?, self.tool(tcp)?);
        let batch = common_batch(&[(name, rows.batch()), ("tcp", tool.batch)])?;
        Ok((rows, tool, batch))
    }

    /// `f` of the solution nearest to qnear and the tool, row by row.
    fn nearest<T: Send>(
        &self,
        py: Python<'_>,
        p: PyArgument<'_, '_>,
        qnear: Option<PyArgument<'_, '_>>,
        tcp: Option<PyArgument<'_, '_>>,
        f: impl Fn(Option<JointPositions>, &Pose) -> T + Send + Sync,
    ) -> PyResult<OneOrBatch<T>> {
        let (p, near, tcp) = (
            Rows::<6>::read("p", p)?,
            Rows::<6>::read_or("qnear", qnear, HOME)?,
            self.tool(tcp)?,
        );
        let batch = common_batch(&[
            ("p", p.batch()),
            ("qnear", near.batch()),
            ("tcp", tcp.batch),
        ])?;
        Ok(compute(py, batch, |i| {
            let near = JointPositions(*near.at(i));
            let found = self.model.inverse_nearest(&pose(p.at(i)), tcp.at(i), &near);
            f(found, tcp.at(i))
        }))
    }
}

#[pymethods]
impl Robot {
    #[new]
    #[pyo3(signature = (model=None, tcp=None, payload=None, gravity=None, calibration=None))]
    fn new(
        model: Option<&str>,
        tcp: Option<PyArgument<'_, '_>>,
        payload: Option<PyArgument<'_, '_>>,
        gravity: Option<PyArgument<'_, '_>>,
        calibration: Option<PathBuf>,
    ) -> PyResult<Self> {
        let (source, model) = open(model, calibration.as_deref())?;
        let tcp = RpyPose::from_array(tcp.map_or(Ok([0.0; 6]), |t| single("tcp", t))?);
        let payload = payload.map_or(Ok(Payload::NONE), read_payload)?;
        let gravity = gravity.map_or(Ok(GRAVITY_UPRIGHT), |g| {
            single("gravity", g).map(Vector3::<f64>::from)
        })?;
        let dynamics = model.dynamics(&payload, gravity);
        Ok(Self {
            source,
            model,
            tcp,
            payload,
            gravity,
            dynamics,
        })
    }

    /// The model's name, "cs66" for instance.
    #[getter]
    fn name(&self) -> &str {
        self.model.name()
    }

    /// The path of the calibration file, as given; None for an arm that is as its model.
    #[getter]
    fn calibration(&self) -> Option<String> {
        let calibration = self.model.calibration();
        calibration.map(|measured| measured.path().display().to_string())
    }

    /// The vendor's robot type number, 6206 for the CS66; None for a URDF that names none.
    #[getter]
    fn robot_type(&self) -> Option<u32> {
        self.model.type_number()
    }

    /// The payload the arm is rated for in kg; None for a URDF that names none.
    #[getter]
    fn rated_payload(&self) -> Option<f64> {
        self.model.rated_payload_kg()
    }

    /// The tool centre point in the flange frame, (6,), m and rad.
    #[getter]
    fn tcp<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.tcp.to_array())
    }

    /// (mass, cog, inertia) as three plain Python values: kg, m, kg m^2.
    #[getter]
    fn payload(&self) -> PayloadTuple {
        (
            self.payload.mass,
            self.payload.cog.into(),
            self.payload.inertia,
        )
    }

    /// Free-fall acceleration in the base frame, (3,), m/s^2.
    #[getter]
    fn gravity_vector<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.gravity.as_slice())
    }

    /// Names of the six joints, base first.
    #[getter]
    fn joint_names<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.model.joint_names())
    }

    /// Smallest and largest joint positions, (6, 2), rad.
    #[getter]
    fn joint_limits<'py>(&self, py: Python<'py>) -> PyArrayResult<'py> {
        let limits = self.model.limits();
        let pairs = (0..6).flat_map(|i| [limits.position_min[i], limits.position_max[i]]);
        reshaped(PyArray1::from_iter(py, pairs), vec![6, 2])
    }

    /// Largest joint speeds, (6,), rad/s.
    #[getter]
    fn speed_limits<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.model.limits().speed.0)
    }

    /// Largest joint torques, (6,), Nm.
    #[getter]
    fn torque_limits<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.model.limits().effort.0)
    }

    /// Pose of the TCP in the base frame (manual 3.2.4).
    ///
    /// q: joint positions, (6,) or (N, 6), rad. tcp: another tool than the robot's, (6,) or (N, 6).
    /// Returns (6,) or (N, 6), m and rad.
    #[pyo3(signature = (q, tcp=None))]
    fn get_forward_kin<'py>(
        &self,
        py: Python<'py>,
        q: PyArgument<'_, 'py>,
        tcp: Option<PyArgument<'_, 'py>>,
    ) -> PyArrayResult<'py> {
        let (q, tcp, batch) = self.with_tool("q", q, tcp)?;
        compute(py, batch, |i| {
            self.model
                .tcp_pose(&JointPositions(*q.at(i)), tcp.at(i))
                .to_rpy()
                .to_array()
        })
        .into_array(py)
    }

    /// The joint positions nearest to `qnear` that reach a TCP pose (manual 3.2.1).
    ///
    /// Each joint is moved by whole turns towards qnear inside its limits, then the smallest Euclidean distance wins.
    ///
    /// p: poses, (6,) or (N, 6), m and rad. qnear: (6,) or (N, 6), rad; default the controller's home position.
    /// tcp: another tool than the robot's. Returns (6,) or (N, 6), rad.
    ///
    /// Raises NoSolutionError if a single pose cannot be reached; in a batch its row is NaN.
    #[pyo3(signature = (p, qnear=None, tcp=None))]
    fn get_inverse_kin<'py>(
        &self,
        py: Python<'py>,
        p: PyArgument<'_, 'py>,
        qnear: Option<PyArgument<'_, 'py>>,
        tcp: Option<PyArgument<'_, 'py>>,
    ) -> PyArrayResult<'py> {
        match self.nearest(py, p, qnear, tcp, |q, _| q)? {
            OneOrBatch::One(Some(q)) => OneOrBatch::One(q.0).into_array(py),
            OneOrBatch::One(None) => Err(NoSolutionError::new_err(format!(
                "no joint positions of the {} inside the limits reach the pose p = {}",
                self.model.name(),
                p.repr()?
            ))),
            OneOrBatch::Many(rows) => {
                let rows = rows.into_iter().map(|q| q.map_or([f64::NAN; 6], |q| q.0));
                OneOrBatch::Many(rows.collect()).into_array(py)
            }
        }
    }

    /// Whether get_inverse_kin would find a solution (manual 3.2.2). Arguments as there. Returns a bool, or (N,).
    #[pyo3(signature = (p, qnear=None, tcp=None))]
    fn get_inverse_kin_has_solution<'py>(
        &self,
        py: Python<'py>,
        p: PyArgument<'_, 'py>,
        qnear: Option<PyArgument<'_, 'py>>,
        tcp: Option<PyArgument<'_, 'py>>,
    ) -> PyArrayResult<'py> {
        self.nearest(py, p, qnear, tcp, |q, _| q.is_some())?
            .into_number(py)
    }

    /// Every solution for a TCP pose, each joint in [-pi, pi), ordered by shoulder, wrist, elbow as in manual 3.2.3.
    ///
    /// Joint limits are not looked at. Where the wrist is singular, joint 6 is 0.
    ///
    /// p: poses, (6,) or (N, 6), m and rad. tcp: another tool than the robot's.
    /// Returns (k, 6) in rad with 0 to 8 rows for one pose; for a batch a pair: (N, 8, 6) with NaN in unused rows, and
    /// the number of solutions (N,). A calibrated arm can have more close to singularities: 16 rows in place of 8.
    #[pyo3(signature = (p, tcp=None))]
    fn get_all_inverse_kin<'py>(
        &self,
        py: Python<'py>,
        p: PyArgument<'_, 'py>,
        tcp: Option<PyArgument<'_, 'py>>,
    ) -> PyArrayResult<'py> {
        let (p, tcp, batch) = self.with_tool("p", p, tcp)?;
        let solve = |i| self.model.inverse_all(&pose(p.at(i)), tcp.at(i));
        let Some(count) = batch else {
            let solutions = solve(0);
            let rows: Vec<f64> = solutions.iter().flat_map(|q| q.0).collect();
            return reshaped(PyArray1::from_vec(py, rows), vec![solutions.len(), 6]);
        };
        let most = self.model.ik_method().max_solutions();
        let (rows, counts) = detached(py, count, || {
            let mut rows = vec![[f64::NAN; 6]; count * most];
            let mut counts = vec![0_i64; count];
            for (i, (rows, count)) in rows.chunks_exact_mut(most).zip(&mut counts).enumerate() {
                let solutions = solve(i);
                *count = solutions.len() as i64;
                for (row, q) in rows.iter_mut().zip(&solutions) {
                    *row = q.0;
                }
            }
            (rows, counts)
        });
        let rows = PyArray1::from_vec(py, rows.into_flattened());
        let rows = reshaped(rows, vec![count, most, 6])?;
        let counts = PyArray1::from_vec(py, counts).into_any();
        Ok(PyTuple::new(py, [rows, counts])?.into_any())
    }

    /// Geometric Jacobian of the TCP: twist [vx, vy, vz, wx, wy, wz] in base axes = J qd.
    ///
    /// q: (6,) or (N, 6), rad. tcp: another tool than the robot's. Returns (6, 6) or (N, 6, 6).
    #[pyo3(signature = (q, tcp=None))]
    fn jacobian<'py>(
        &self,
        py: Python<'py>,
        q: PyArgument<'_, 'py>,
        tcp: Option<PyArgument<'_, 'py>>,
    ) -> PyArrayResult<'py> {
        let (q, tcp, batch) = self.with_tool("q", q, tcp)?;
        compute(py, batch, |i| {
            let (_, jacobian) = self
                .model
                .tcp_pose_and_jacobian(&JointPositions(*q.at(i)), tcp.at(i));
            row_major(&jacobian)
        })
        .into_array_of(py, &[6, 6])
    }

    /// Joint torques for a motion, payload and gravity included: tau = M(q) qdd + C(q, qd) qd + g(q).
    ///
    /// No friction and no rotor inertia: no public figures exist.
    ///
    /// q, qd, qdd: (6,) or (N, 6), rad, rad/s, rad/s^2. Returns (6,) or (N, 6), Nm.
    fn inverse_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: PyArgument<'_, 'py>,
        qd: PyArgument<'_, 'py>,
        qdd: PyArgument<'_, 'py>,
    ) -> PyArrayResult<'py> {
        let (q, qd, qdd) = (
            Rows::<6>::read("q", q)?,
            Rows::<6>::read("qd", qd)?,
            Rows::<6>::read("qdd", qdd)?,
        );
        let batch = common_batch(&[("q", q.batch()), ("qd", qd.batch()), ("qdd", qdd.batch())])?;
        compute(py, batch, |i| {
            self.dynamics
                .inverse_dynamics(
                    &JointPositions(*q.at(i)),
                    &JointSpeeds(*qd.at(i)),
                    &JointAccelerations(*qdd.at(i)),
                )
                .0
        })
        .into_array(py)
    }

    /// Joint-space mass matrix, payload included. q: (6,) or (N, 6), rad. Returns (6, 6) or (N, 6, 6), kg m^2.
    fn mass_matrix<'py>(&self, py: Python<'py>, q: PyArgument<'_, 'py>) -> PyArrayResult<'py> {
        let q = Rows::<6>::read("q", q)?;
        compute(py, q.batch(), |i| {
            row_major(&self.dynamics.mass_matrix(&JointPositions(*q.at(i))))
        })
        .into_array_of(py, &[6, 6])
    }

    /// Joint torques that hold the arm still, payload included. q: (6,) or (N, 6), rad. Returns the same shape, Nm.
    fn gravity<'py>(&self, py: Python<'py>, q: PyArgument<'_, 'py>) -> PyArrayResult<'py> {
        let q = Rows::<6>::read("q", q)?;
        compute(py, q.batch(), |i| {
            self.dynamics.gravity_torques(&JointPositions(*q.at(i))).0
        })
        .into_array(py)
    }

    /// Smallest distance between links of the arm that can meet, m; negative where the capsules around them overlap.
    ///
    /// The capsules enclose the links with some air, the tool is not part of it: a hint, not a proof of collision.
    ///
    /// q: (6,) or (N, 6), rad. Returns a float, or (N,); NaN for an arm whose URDF has no collision shapes.
    fn self_collision_distance<'py>(
        &self,
        py: Python<'py>,
        q: PyArgument<'_, 'py>,
    ) -> PyArrayResult<'py> {
        let q = Rows::<6>::read("q", q)?;
        compute(py, q.batch(), |i| {
            let frames = self.model.forward(&JointPositions(*q.at(i)));
            let nearest = self.model.collision().self_distance(&frames);
            nearest.map_or(f64::NAN, |links| links.distance)
        })
        .into_number(py)
    }

    /// Whether a TCP pose can be reached inside the joint limits, or joint positions lie inside them (manual 3.1.35).
    ///
    /// Give p, or q by name. The TCP must also be on the allowed side of all `planes`; the controller takes those of
    /// its cell file, and looks at the shape of the tool too.
    ///
    /// p: (6,) or (N, 6), m and rad; with it qnear and tcp as in get_inverse_kin. q: (6,) or (N, 6), rad; with it tcp.
    /// planes: up to eight rows [x, y, z, nx, ny, nz], a point in m and a direction to the allowed side, base frame.
    /// Returns a bool, or (N,).
    ///
    /// >>> table = [0, 0, 0.1, 0, 0, 1]
    /// >>> elitescript.Robot("cs66").is_within_safety_limits([-0.5, -0.2, 0.05, 3.14, 0, 0], planes=table)
    /// False
    #[pyo3(signature = (p=None, qnear=None, tcp=None, *, q=None, planes=None))]
    fn is_within_safety_limits<'py>(
        &self,
        py: Python<'py>,
        p: Option<PyArgument<'_, 'py>>,
        qnear: Option<PyArgument<'_, 'py>>,
        tcp: Option<PyArgument<'_, 'py>>,
        q: Option<PyArgument<'_, 'py>>,
        planes: Option<PyArgument<'_, 'py>>,
    ) -> PyArrayResult<'py> {
        let bounds = read_planes(planes)?;
        let allowed = |q: &JointPositions, tool: &Pose| {
            let switches = PlaneSwitches::default();
            bounds
                .violation_at(&self.model, q, tool, &switches)
                .is_none()
        };
        match (p, q) {
            (Some(p), None) => self.nearest(py, p, qnear, tcp, |q, tool| {
                q.is_some_and(|q| allowed(&q, tool))
            })?,
            (None, Some(_)) if qnear.is_some() => {
                return Err(PyValueError::new_err("qnear goes with p, not with q"));
            }
            (None, Some(q)) => {
                let (q, tcp, batch) = self.with_tool("q", q, tcp)?;
                compute(py, batch, |i| allowed(&JointPositions(*q.at(i)), tcp.at(i)))
            }
            (None, None) => return Err(PyValueError::new_err("either p or q must be given")),
            (Some(_), Some(_)) => {
                return Err(PyValueError::new_err("p and q must not both be given"));
            }
        }
        .into_number(py)
    }

    fn __repr__(&self) -> String {
        let list = |values: &[f64]| format!("{values:?}");
        let calibration = self.model.calibration().map_or(String::new(), |measured| {
            format!(", calibration={:?}", measured.path())
        });
        format!(
            "Robot({:?}, tcp={}, payload=({:?}, {}, {}), gravity={}{calibration})",
            self.source,
            list(&self.tcp.to_array()),
            self.payload.mass,
            list(self.payload.cog.as_slice()),
            list(&self.payload.inertia),
            list(self.gravity.as_slice())
        )
    }

    /// Pickling: robots go to worker processes by their arguments.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PickleParts<'py> {
        let robot = slf.get();
        let arguments = (
            robot.source.clone(),
            robot.tcp.to_array(),
            robot.payload(),
            robot.gravity.into(),
            robot.model.calibration().map(|it| it.path().to_owned()),
        );
        (slf.get_type().into_any(), arguments)
    }
}
