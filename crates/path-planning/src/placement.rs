//! Where the arm should stand: the base pose from which it reaches all points, far from the ends of its joints' ranges.

use kinematics::elementary::{cos, sin};
use kinematics::ik::unwrap_towards;
use kinematics::{JointPositions, Pose, RpyPose};

use crate::scene::{CollisionScene, ObstacleId, ObstaclePlace, PlacedArm};

/// Places along each side of the area, and turns, that are looked at first.
const SIDE_PLACES: u32 = 41;
const TURNS: u32 = 16;
/// The best of these are improved.
const STARTS: usize = 12;
/// Improving ends at steps of this length, m and a tenth of it rad.
const FINEST_STEP: f64 = 5e-4;
/// Directions in which better places are looked for: where joints take turns at being nearest to their ends, only a
/// narrow cone of directions leads up.
const DIRECTIONS: [u32; 2] = [8, 64];
/// Joint margins nearer to each other than this are equal, rad: then the quicker one is better.
const SAME_MARGIN: f64 = 1e-6;

/// What the arm has to reach, and where it may stand.
#[derive(Clone, Debug)]
pub struct PlacementRequest {
    /// The arm at the origin of the cell, among what stands in the cell.
    pub scene: CollisionScene,
    /// TCP poses in the frame of the cell; at least one.
    pub points: Vec<Pose>,
    /// The distance that is kept at every point, m.
    pub margin: f64,
    /// Where the base may be: least and largest x, least and largest y, m.
    pub area: [f64; 4],
    /// Whether the base may be turned about its vertical.
    pub has_yaw: bool,
}

/// A base pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BasePose {
    /// Place, m.
    pub x: f64,
    /// Place, m.
    pub y: f64,
    /// Turn about the vertical, rad.
    pub yaw: f64,
}

/// A base pose from which all points are reached.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Where the base is.
    pub base: BasePose,
    /// The least distance of a joint to the end of its range at any point, rad.
    pub joint_margin: f64,
    /// The least distance at any point, m; infinite where nothing can touch.
    pub distance: f64,
    /// How long the joints take from point to point at their highest speeds, s.
    pub time: f64,
    /// Joint positions for every point.
    pub joints: Vec<JointPositions>,
}

impl BasePose {
    /// The pose in the frame of the cell.
    pub fn pose(&self) -> Pose {
        Pose::from_rpy(&RpyPose {
            xyz: [self.x, self.y, 0.0],
            rpy: [0.0, 0.0, self.yaw],
        })
    }
}

impl Placement {
    fn is_better_than(&self, other: &Self) -> bool {
        match self.joint_margin - other.joint_margin {
            more if more > SAME_MARGIN => true,
            more if more < -SAME_MARGIN => false,
            _ => self.time < other.time,
        }
    }
}

/// Judges base poses.
#[derive(Clone, Debug)]
pub struct PlacementCheck<'a> {
    request: &'a PlacementRequest,
    scene: CollisionScene,
    standing: Vec<(ObstacleId, Pose)>,
    arm: PlacedArm,
    /// The point that failed last: most often it fails at the next place as well.
    suspect: usize,
}

impl<'a> PlacementCheck<'a> {
    /// For one request.
    pub fn new(request: &'a PlacementRequest) -> Self {
        let scene = request.scene.clone();
        let names: Vec<String> = scene.obstacle_names().map(str::to_owned).collect();
        let standing = names.iter().filter_map(|name| {
            let id = scene.obstacle(name)?;
            match scene.place(id)? {
                ObstaclePlace::Standing(pose) => Some((id, pose)),
                _ => None,
            }
        });
        Self {
            request,
            standing: standing.collect(),
            scene,
            arm: PlacedArm::default(),
            suspect: 0,
        }
    }

    /// What holds with the base there: a placement, or the numbers of points that are not reached, from 0 and in order.
    /// No more than `failing_max` of them are looked for.
    ///
    /// # Errors
    /// The points that fail.
    pub fn judge(&mut self, base: &BasePose, failing_max: usize) -> Result<Placement, Vec<usize>> {
        let base_from_cell = base.pose().inverse();
        for (id, pose) in &self.standing {
            let place = ObstaclePlace::Standing(base_from_cell * *pose);
            self.scene.set_place(*id, place);
        }
        let request = self.request;
        let suspect = self.suspect;
        let mut of_suspect = match request.points.get(suspect) {
            Some(point) if failing_max == 1 => {
                let reached = self.best_joints(&(base_from_cell * *point));
                Some(reached.ok_or_else(|| vec![suspect])?)
            }
            _ => None,
        };
        let (mut failing, mut joints) = (Vec::new(), Vec::new());
        let (mut joint_margin, mut distance) = (f64::INFINITY, f64::INFINITY);
        for (number, point) in request.points.iter().enumerate() {
            let known = of_suspect.take_if(|_| number == suspect);
            match known.or_else(|| self.best_joints(&(base_from_cell * *point))) {
                Some((q, margin, far)) => {
                    joints.push(q);
                    joint_margin = joint_margin.min(margin);
                    distance = distance.min(far);
                }
                None => {
                    self.suspect = number;
                    failing.push(number);
                    if failing.len() >= failing_max {
                        return Err(failing);
                    }
                }
            }
        }
        if !failing.is_empty() {
            return Err(failing);
        }
        Ok(Placement {
            base: *base,
            joint_margin,
            distance,
            time: self.time(&joints),
            joints,
        })
    }

    /// The joint positions for a TCP pose that are farthest from the ends of their ranges and keep the margin, with
    /// both distances.
    fn best_joints(&mut self, pose: &Pose) -> Option<(JointPositions, f64, f64)> {
        let model = self.scene.model();
        let limits = *model.limits();
        let middle = JointPositions(core::array::from_fn(|joint| {
            (limits.position_min[joint] + limits.position_max[joint]) / 2.0
        }));
        let margin = |q: &JointPositions| {
            let margins = (0..6).map(|joint| {
                let (min, max) = (limits.position_min[joint], limits.position_max[joint]);
                (q[joint] - min).min(max - q[joint])
            });
            margins.fold(f64::INFINITY, f64::min)
        };
        let solutions = model.inverse_all(pose, self.scene.flange_from_tcp());
        let mut inside: Vec<(f64, JointPositions)> = solutions
            .iter()
            .filter_map(|q| unwrap_towards(q, &middle, &limits))
            .map(|q| (margin(&q), q))
            .collect();
        inside.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (margin, q) in inside {
            self.scene.place_arm(&q, &mut self.arm);
            let nearest = self.scene.nearest_of(&self.arm);
            let distance = nearest.map_or(f64::INFINITY, |nearest| nearest.distance);
            if distance >= self.request.margin {
                return Some((q, margin, distance));
            }
        }
        None
    }

    /// How long the slowest joint takes from point to point, s.
    fn time(&self, joints: &[JointPositions]) -> f64 {
        let limits = self.scene.model().limits();
        let (speed, acceleration) = (limits.speed, limits.acceleration);
        let times = joints.windows(2).map(|ends| {
            let of_joint = |joint: usize| {
                let way = (ends[1][joint] - ends[0][joint]).abs();
                let (v, a) = (speed[joint], acceleration[joint]);
                // Up to speed and down again, or only a part of it.
                match way > v * v / a {
                    true => way / v + v / a,
                    false => 2.0 * (way / a).sqrt(),
                }
            };
            (0..6).map(of_joint).fold(0.0, f64::max)
        });
        // The sum of nothing is -0, and shows as such.
        times.sum::<f64>() + 0.0
    }
}

/// The best base pose. `should_stop` is asked now and then, and ends the search with what was found until then.
///
/// # Errors
/// The numbers of the points, from 0, that are not reached from where the fewest are not.
pub fn place(
    request: &PlacementRequest,
    should_stop: &mut dyn FnMut() -> bool,
) -> Result<Placement, Vec<usize>> {
    let mut check = PlacementCheck::new(request);
    let [x_min, x_max, y_min, y_max] = request.area;
    let side =
        |min: f64, max: f64, k: u32| min + (max - min) * f64::from(k) / f64::from(SIDE_PLACES - 1);
    let turns = match request.has_yaw {
        true => TURNS,
        false => 1,
    };
    let mut found: Vec<Placement> = Vec::new();
    let mut places = Vec::new();
    for turn in 0..turns {
        let yaw = core::f64::consts::TAU * f64::from(turn) / f64::from(TURNS);
        for j in 0..SIDE_PLACES {
            for i in 0..SIDE_PLACES {
                let base = BasePose {
                    x: side(x_min, x_max, i),
                    y: side(y_min, y_max, j),
                    yaw: wrapped(yaw),
                };
                places.push(base);
            }
        }
    }
    for base in &places {
        if should_stop() {
            break;
        }
        if let Ok(placement) = check.judge(base, 1) {
            found.push(placement);
        }
    }
    found.sort_by(|a, b| {
        let by_margin = b.joint_margin.total_cmp(&a.joint_margin);
        by_margin.then(a.time.total_cmp(&b.time))
    });
    found.truncate(STARTS);
    let step = ((x_max - x_min).max(y_max - y_min) / f64::from(SIDE_PLACES - 1)).max(FINEST_STEP);
    let improved = found
        .into_iter()
        .map(|start| improve(&mut check, start, step, should_stop));
    let best = improved.reduce(|best, other| match other.is_better_than(&best) {
        true => other,
        false => best,
    });
    best.ok_or_else(|| {
        let mut fewest: Option<Vec<usize>> = None;
        for base in &places {
            let count = fewest.as_ref().map_or(usize::MAX, Vec::len);
            // No place reaches all of them: fewer than one is not to be found.
            if count == 1 || fewest.is_some() && should_stop() {
                break;
            }
            if let Err(failing) = check.judge(base, count)
                && failing.len() < count
            {
                fewest = Some(failing);
            }
        }
        fewest.unwrap_or_default()
    })
}

/// Goes to better places beside a placement, with smaller and smaller steps.
fn improve(
    check: &mut PlacementCheck<'_>,
    start: Placement,
    step: f64,
    should_stop: &mut dyn FnMut() -> bool,
) -> Placement {
    let (mut best, mut step) = (start, step);
    while step > FINEST_STEP && !should_stop() {
        let better = DIRECTIONS
            .iter()
            .find_map(|directions| best_beside(check, &best, step, *directions));
        match better {
            Some(better) => best = better,
            None => step /= 2.0,
        }
    }
    best
}

/// The best of the places so far from a placement, in so many directions; `None` where none is better than it.
fn best_beside(
    check: &mut PlacementCheck<'_>,
    start: &Placement,
    step: f64,
    directions: u32,
) -> Option<Placement> {
    let [x_min, x_max, y_min, y_max] = check.request.area;
    let turns: &[f64] = match check.request.has_yaw {
        true => &[0.0, 1.0, -1.0],
        false => &[0.0],
    };
    let turned = |turn: f64| wrapped(start.base.yaw + turn * step * 5.0);
    let mut bases = Vec::new();
    for direction in 0..directions {
        let angle = core::f64::consts::TAU * f64::from(direction) / f64::from(directions);
        bases.extend(turns.iter().map(|turn| BasePose {
            x: (start.base.x + step * cos(angle)).clamp(x_min, x_max),
            y: (start.base.y + step * sin(angle)).clamp(y_min, y_max),
            yaw: turned(*turn),
        }));
    }
    // Turned where it stands.
    bases.extend(turns.iter().skip(1).map(|turn| BasePose {
        yaw: turned(*turn),
        ..start.base
    }));
    let mut better: Option<Placement> = None;
    for base in &bases {
        if let Ok(placement) = check.judge(base, 1)
            && placement.is_better_than(better.as_ref().unwrap_or(start))
        {
            better = Some(placement);
        }
    }
    better
}

/// An angle from -pi to pi.
fn wrapped(angle: f64) -> f64 {
    let turns = (angle / core::f64::consts::TAU).round();
    angle - turns * core::f64::consts::TAU
}
