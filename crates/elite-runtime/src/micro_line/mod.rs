//! Micro lines: files of points at even times (manual 3.1.37 to 3.1.40), and the table of those a task has loaded.
//!
//! Owns the text format and what the numbers mean. Knows nothing of how the arm runs through the points.
//!
//! The format is our own, the manual gives none: one point a line, six numbers apart by commas or blanks; `#` begins a
//! comment, lines without numbers do not count. Points are numbered from 1.
//!
//! The numbers are samples of a smooth path, rounded to the decimals they are written with: what is run is within that
//! rounding of them (see [`smooth`]). Asked for one by one they are given as they stand in the file.

mod smooth;

use std::cell::RefCell;

use kinematics::{JointPositions, Pose, RobotModel, RpyPose};
use messages::Localized;
use nalgebra::{Quaternion, UnitQuaternion};
use thiserror::Error;

/// Most points of one file.
pub const POINTS_MAX: usize = 100_000;
/// Most files that a task may have loaded.
pub const LOADED_MAX: usize = 64;
/// Most points of all files that a task has loaded.
pub const POINTS_OF_TASK_MAX: usize = 500_000;

/// Coarsest rounding that is taken for one, m and rad: numbers written with fewer decimals are meant as they are.
const COARSEST: f64 = 1e-3;
/// Rounding that any file has, m and rad: that of 32-bit numbers.
const FINEST: f64 = 1e-6;
/// Rounding matters where it looks like a jerk of that much, m/s³ and rad/s³.
const ROUNDING_JERK_MIN: f64 = 10.0;
/// Joint positions of one pose this near to one another are the same, rad.
const SAME_BRANCH: f64 = 1e-6;
/// Share of a file's numbers that show how many decimals it is written with.
const MOST_NUMBERS: f64 = 0.95;

/// What the numbers of a file are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// Joint positions.
    Joint,
    /// TCP poses in the part's frame, with the TCP that is active when they are used.
    Cartesian,
}

/// In which units the numbers of a file are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Units {
    /// rad; m and rad.
    Si,
    /// Degrees; mm and rad.
    DegreesOrMillimetres,
}

/// The reason for which a file or its points cannot be used.
#[derive(Clone, Debug, PartialEq, Error, Localized)]
#[non_exhaustive]
pub enum MicroLineError {
    /// A word of the file is no number that can be used.
    #[error("line {line}: {word:?} is not a finite number")]
    #[zh("第 {line} 行：{word:?} 不是有限数")]
    NotANumber {
        /// The line of the file, from 1.
        line: usize,
        /// The word, cut where it is long.
        word: String,
    },
    /// A line does not hold one point.
    #[error("line {line} has {count} numbers, a point has 6")]
    #[zh("第 {line} 行有 {count} 个数，一个点有 6 个")]
    NotSix {
        /// The line of the file, from 1.
        line: usize,
        /// Numbers found.
        count: usize,
    },
    /// The file holds too little or too much.
    #[error("2 to {POINTS_MAX} points are allowed, it has {count}")]
    #[zh("允许 2 到 {POINTS_MAX} 个点，它有 {count} 个")]
    Count {
        /// Points found.
        count: usize,
    },
    /// A point cannot be reached.
    #[error("no joint positions reach point {point}, {pose:?}, with this TCP")]
    #[zh("以此 TCP 没有关节位置能到达第 {point} 点 {pose:?}")]
    OutOfReach {
        /// From 1.
        point: usize,
        /// In the base frame.
        pose: [f64; 6],
    },
    /// There is no room for another file.
    #[error(
        "a task may load {LOADED_MAX} micro-line files with {POINTS_OF_TASK_MAX} points together, this would be more"
    )]
    #[zh("一个任务最多加载 {LOADED_MAX} 个微线段文件、共 {POINTS_OF_TASK_MAX} 个点，这会超出")]
    Full,
}

/// A loaded file.
#[derive(Clone, Debug, PartialEq)]
pub struct MicroLine {
    space: Space,
    /// Time from point to point, s.
    interval: f64,
    /// SI units: rad, or m and rad; as they stand in the file.
    points: Vec<[f64; 6]>,
    /// What they are taken for: joint positions, or positions and quaternions (w, x, y, z) whose signs go on.
    samples: Vec<[f64; 7]>,
    /// The frame of Cartesian points, in the base frame.
    base_from_part: Pose,
    /// Joint positions that have been looked up one by one.
    chain: RefCell<SolutionChain>,
}

/// Joint positions of the points from the first on, each near the one before: found once, and read again as long as the
/// first is reached with the same joint positions from where the arm stands.
#[derive(Clone, Debug, Default, PartialEq)]
struct SolutionChain {
    /// The TCP and frame that the solutions were found with.
    frames: Option<(Pose, Pose)>,
    found: Vec<JointPositions>,
}

impl MicroLine {
    /// Reads the text of a file.
    ///
    /// # Errors
    /// [`MicroLineError`] names the line.
    pub fn parse(
        text: &str,
        space: Space,
        units: Units,
        interval: f64,
    ) -> Result<Self, MicroLineError> {
        let mut points = Vec::new();
        let mut decimals = Decimals::default();
        for (index, line) in text.lines().enumerate() {
            if let Some(mut point) = point_of(line, index + 1, &mut decimals)? {
                in_si(&mut point, space, units);
                points.push(point);
                if points.len() > POINTS_MAX {
                    break;
                }
            }
        }
        if !(2..=POINTS_MAX).contains(&points.len()) {
            return Err(MicroLineError::Count {
                count: points.len(),
            });
        }
        let samples = samples(&points, space, interval, &decimals.rounding(space, units));
        Ok(Self {
            space,
            interval,
            points,
            samples,
            base_from_part: Pose::IDENTITY,
            chain: RefCell::default(),
        })
    }

    /// The number of points.
    pub fn count(&self) -> usize {
        self.points.len()
    }

    /// Time from point to point, s.
    pub fn interval(&self) -> f64 {
        self.interval
    }

    /// Cartesian points are given in this frame from now on.
    pub fn set_part(&mut self, base_from_part: &RpyPose) {
        self.base_from_part = Pose::from_rpy(base_from_part);
    }

    /// The joint positions at the first of the points `first` to `last`, counted from 1, nearest to `start`; those of
    /// poses are looked at one after the other before the arm moves.
    ///
    /// # Errors
    /// [`MicroLineError::OutOfReach`]
    pub fn reach(
        &self,
        (first, last): (usize, usize),
        model: &RobotModel,
        flange_from_tcp: &Pose,
        start: &JointPositions,
    ) -> Result<JointPositions, MicroLineError> {
        let begin = self.joints_near(first, model, flange_from_tcp, start)?;
        if self.space == Space::Cartesian {
            (first + 1..=last).try_fold(begin, |near, number| {
                self.joints_near(number, model, flange_from_tcp, &near)
            })?;
        }
        Ok(begin)
    }

    /// What the numbers are.
    pub fn space(&self) -> Space {
        self.space
    }

    /// What the points `first` to `last`, counted from 1, are taken for: joint positions, or positions and quaternions
    /// in the base frame.
    pub fn samples(&self, (first, last): (usize, usize)) -> Vec<[f64; 7]> {
        let part = (first.max(1) - 1)..last.min(self.samples.len());
        let samples = self.samples.get(part).unwrap_or_default();
        if self.space == Space::Joint {
            return samples.to_vec();
        }
        let part = UnitQuaternion::from_rotation_matrix(&self.base_from_part.rotation);
        let in_base = |[x, y, z, w, i, j, k]: &[f64; 7]| {
            let at = self.base_from_part.transform_point([*x, *y, *z].into());
            let turn = part.into_inner() * Quaternion::new(*w, *i, *j, *k);
            [at.x, at.y, at.z, turn.w, turn.i, turn.j, turn.k]
        };
        samples.iter().map(in_base).collect()
    }

    /// The joint positions of an existing point that are nearest to `near`.
    fn joints_near(
        &self,
        number: usize,
        model: &RobotModel,
        flange_from_tcp: &Pose,
        near: &JointPositions,
    ) -> Result<JointPositions, MicroLineError> {
        let [a, b, c, d, e, f, g] = self.samples[number - 1];
        if self.space == Space::Joint {
            return Ok(JointPositions([a, b, c, d, e, f]));
        }
        let turn = UnitQuaternion::new_normalize(Quaternion::new(d, e, f, g));
        let pose = self.base_from_part * Pose::new(turn.to_rotation_matrix(), [a, b, c].into());
        model
            .inverse_nearest(&pose, flange_from_tcp, near)
            .ok_or_else(|| MicroLineError::OutOfReach {
                point: number,
                pose: pose.to_rpy().to_array(),
            })
    }

    /// The joint positions of an existing point as the arm would run there from the first point on.
    fn joints_in_turn(
        &self,
        number: usize,
        model: &RobotModel,
        flange_from_tcp: &Pose,
        start: &JointPositions,
    ) -> Result<JointPositions, MicroLineError> {
        let mut chain = self.chain.borrow_mut();
        let first = self.joints_near(1, model, flange_from_tcp, start)?;
        let is_same = chain.found.first().is_some_and(|found| {
            found.distance_squared(&first) < SAME_BRANCH * SAME_BRANCH
                && chain.frames == Some((*flange_from_tcp, self.base_from_part))
        });
        if !is_same {
            *chain = SolutionChain {
                frames: Some((*flange_from_tcp, self.base_from_part)),
                found: vec![first],
            };
        }
        while chain.found.len() < number {
            let near = chain.found.last().unwrap_or(start);
            let next = self.joints_near(chain.found.len() + 1, model, flange_from_tcp, near)?;
            chain.found.push(next);
        }
        Ok(chain.found[number - 1])
    }

    /// One point, counted from 1, as joint positions or as a TCP pose in the part's frame. `None` when there is none of
    /// this number.
    ///
    /// # Errors
    /// [`MicroLineError::OutOfReach`]
    pub fn values(
        &self,
        number: usize,
        wanted: Space,
        model: &RobotModel,
        flange_from_tcp: &Pose,
        start: &JointPositions,
    ) -> Result<Option<[f64; 6]>, MicroLineError> {
        let Some(point) = number
            .checked_sub(1)
            .and_then(|index| self.points.get(index))
        else {
            return Ok(None);
        };
        Ok(match (self.space, wanted) {
            (Space::Joint, Space::Cartesian) => {
                let base_from_tcp = model.tcp_pose(&JointPositions(*point), flange_from_tcp);
                let pose = self.base_from_part.inverse() * base_from_tcp;
                Some(pose.to_rpy().to_array())
            }
            (Space::Cartesian, Space::Joint) => {
                // From the first point on, as the arm would run: a pose alone has several solutions.
                let joints = self.joints_in_turn(number, model, flange_from_tcp, start)?;
                Some(joints.0)
            }
            _ => Some(*point),
        })
    }
}

/// The decimals that the numbers of a file are written with: how many numbers of each column have so many.
#[derive(Clone, Debug, Default)]
struct Decimals([[usize; 20]; 6]);

impl Decimals {
    fn count(&mut self, column: usize, word: &str) {
        let (digits, power) = word.split_once(['e', 'E']).unwrap_or((word, "0"));
        let after_point = digits.split_once('.').map_or(0, |(_, after)| after.len());
        let power = power.parse().unwrap_or(0_i64);
        let decimals = i64::try_from(after_point)
            .unwrap_or(0)
            .saturating_sub(power);
        let counts = &mut self.0[column];
        let last = counts.len() - 1;
        counts[usize::try_from(decimals).unwrap_or(0).min(last)] += 1;
    }

    /// Half of the last decimal of each column, m or rad.
    fn rounding(&self, space: Space, units: Units) -> [f64; 6] {
        core::array::from_fn(|column| {
            let counts = &self.0[column];
            let needed = MOST_NUMBERS * counts.iter().sum::<usize>() as f64;
            let mut seen = 0;
            let enough = counts.iter().position(|count| {
                seen += count;
                seen as f64 >= needed
            });
            let unit = match (space, units) {
                (Space::Joint, Units::DegreesOrMillimetres) => 1.0_f64.to_radians(),
                (Space::Cartesian, Units::DegreesOrMillimetres) if column < 3 => 1e-3,
                _ => 1.0,
            };
            let half = 0.5 * unit * 10.0_f64.powi(-(enough.unwrap_or(0) as i32));
            if half > COARSEST {
                FINEST
            } else {
                half.max(FINEST)
            }
        })
    }
}

/// What the points are taken for, within the rounding of their numbers.
fn samples(points: &[[f64; 6]], space: Space, interval: f64, rounding: &[f64; 6]) -> Vec<[f64; 7]> {
    let mut before = UnitQuaternion::identity();
    let mut samples: Vec<[f64; 7]> = points
        .iter()
        .map(|point| {
            let [a, b, c, d, e, f] = *point;
            if space == Space::Joint {
                return [a, b, c, d, e, f, 0.0];
            }
            let pose = Pose::from_rpy(&RpyPose::from_array(*point));
            let turn = UnitQuaternion::from_rotation_matrix(&pose.rotation);
            // A rotation has two quaternions, of opposite signs; the one nearer to that of the point before makes a
            // smooth series.
            let is_far = turn.coords.dot(&before.coords) < 0.0;
            before = if is_far {
                UnitQuaternion::new_unchecked(-turn.into_inner())
            } else {
                turn
            };
            [a, b, c, before.w, before.i, before.j, before.k]
        })
        .collect();
    for column in 0..7 {
        let own = match (space, column) {
            (Space::Joint, 6) => continue,
            (Space::Joint, _) | (Space::Cartesian, 0..3) => rounding[column],
            // A quaternion turns by half the angle.
            (Space::Cartesian, _) => 0.5 * rounding[3].max(rounding[4]).max(rounding[5]),
        };
        if 4.0 * own < ROUNDING_JERK_MIN * interval.powi(3) {
            continue;
        }
        let values: Vec<f64> = samples.iter().map(|sample| sample[column]).collect();
        for (sample, value) in samples.iter_mut().zip(smooth::smoothed(&values, own)) {
            sample[column] = value;
        }
    }
    samples
}

/// The point of a line; `None` for a line without one.
fn point_of(
    line: &str,
    number: usize,
    decimals: &mut Decimals,
) -> Result<Option<[f64; 6]>, MicroLineError> {
    let line = line.split('#').next().unwrap_or_default();
    let separates = |c: char| c == ',' || c.is_whitespace() || c == '\u{feff}';
    let words = line.split(separates).filter(|word| !word.is_empty());
    let mut point = [0.0; 6];
    let mut count = 0;
    for word in words {
        let value = word.parse().ok().filter(|value: &f64| value.is_finite());
        let value = value.ok_or_else(|| MicroLineError::NotANumber {
            line: number,
            word: word.chars().take(40).collect(),
        })?;
        if let Some(place) = point.get_mut(count) {
            *place = value;
            decimals.count(count, word);
        }
        count += 1;
    }
    match count {
        0 => Ok(None),
        6 => Ok(Some(point)),
        _ => Err(MicroLineError::NotSix {
            line: number,
            count,
        }),
    }
}

fn in_si(point: &mut [f64; 6], space: Space, units: Units) {
    match (space, units) {
        (_, Units::Si) => {}
        (Space::Joint, Units::DegreesOrMillimetres) => {
            for angle in point {
                *angle = angle.to_radians();
            }
        }
        // The manual leaves the angles of poses in rad.
        (Space::Cartesian, Units::DegreesOrMillimetres) => {
            for coordinate in &mut point[..3] {
                *coordinate /= 1000.0;
            }
        }
    }
}

/// The files that a task has loaded, by their index.
#[derive(Debug, Default)]
pub struct MicroLines {
    list: Vec<MicroLine>,
}

impl MicroLines {
    /// Adds a file; its index. Content and settings that are loaded already keep their index, and the part's frame that
    /// was set for it.
    ///
    /// # Errors
    /// [`MicroLineError::Full`]
    pub fn add(&mut self, line: MicroLine) -> Result<usize, MicroLineError> {
        let same = |known: &MicroLine| {
            known.space == line.space
                && known.interval == line.interval
                && known.points == line.points
        };
        if let Some(index) = self.list.iter().position(same) {
            return Ok(index);
        }
        let points: usize = self.list.iter().map(MicroLine::count).sum();
        if self.list.len() >= LOADED_MAX || points + line.count() > POINTS_OF_TASK_MAX {
            return Err(MicroLineError::Full);
        }
        self.list.push(line);
        Ok(self.list.len() - 1)
    }

    /// The file of an index.
    pub fn get(&self, index: i64) -> Option<&MicroLine> {
        self.list.get(usize::try_from(index).ok()?)
    }

    /// The file of an index, to change.
    pub fn get_mut(&mut self, index: i64) -> Option<&mut MicroLine> {
        self.list.get_mut(usize::try_from(index).ok()?)
    }

    /// How many are loaded.
    pub fn count(&self) -> usize {
        self.list.len()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn parse(text: &str) -> Result<MicroLine, MicroLineError> {
        MicroLine::parse(text, Space::Joint, Units::Si, 0.004)
    }

    #[test]
    fn points_are_six_numbers_a_line_with_comments_between() {
        let text = "\u{feff}# a header\r\n1,2,3,4,5,6\r\n\n 1e-1\t.2 , -3 4 5 6 # the second\n";
        assert_eq!(
            parse(text).unwrap().points,
            [
                [1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
                [0.1, 0.2, -3.0, 4.0, 5.0, 6.0]
            ]
        );
    }

    #[test]
    fn what_is_wrong_with_a_file_is_said_with_its_line() {
        let say = |text: &str| parse(text).unwrap_err().to_string();
        assert_eq!(
            say("0,0,0,0,0,0\n\n1,2,3\n"),
            "line 3 has 3 numbers, a point has 6"
        );
        assert_eq!(
            say("0,0,0,0,0,0,0\n"),
            "line 1 has 7 numbers, a point has 6"
        );
        assert_eq!(
            say("0,0,zero,0,0,0"),
            "line 1: \"zero\" is not a finite number"
        );
        assert_eq!(
            say("0,0,nan,0,0,0"),
            "line 1: \"nan\" is not a finite number"
        );
        assert_eq!(say("# nothing"), "2 to 100000 points are allowed, it has 0");
        assert_eq!(
            say(&"0 0 0 0 0 0\n".repeat(100_002)),
            "2 to 100000 points are allowed, it has 100001"
        );
    }

    #[test]
    fn degrees_and_millimetres_become_si() {
        let read = |space| {
            let text = "180,90,0,0,0,0\n1000,500,1,1,1,1";
            let units = Units::DegreesOrMillimetres;
            MicroLine::parse(text, space, units, 0.1).unwrap().points
        };
        let joints = read(Space::Joint);
        assert_eq!(joints[0][0], std::f64::consts::PI);
        assert_eq!(read(Space::Cartesian)[1], [1.0, 0.5, 0.001, 1.0, 1.0, 1.0]);
    }

    #[test]
    fn the_same_file_keeps_its_index() {
        let mut lines = MicroLines::default();
        let (a, b) = ("0 0 0 0 0 0\n1 1 1 1 1 1", "0 0 0 0 0 0\n2 1 1 1 1 1");
        assert_eq!(lines.add(parse(a).unwrap()), Ok(0));
        assert_eq!(lines.add(parse(b).unwrap()), Ok(1));
        assert_eq!(lines.add(parse(a).unwrap()), Ok(0));
        for k in 2..LOADED_MAX {
            let line = parse(&format!("0 0 0 0 0 0\n{k} 0 0 0 0 0")).unwrap();
            assert_eq!(lines.add(line), Ok(k));
        }
        let another = parse("0 0 0 0 0 0\n0 0 0 0 0 7").unwrap();
        assert_eq!(lines.add(another), Err(MicroLineError::Full));
        assert!(lines.get(-1).is_none() && lines.get(64).is_none());
    }

    #[test]
    fn points_are_given_as_joints_or_as_poses_of_the_part() {
        let model = RobotModel::built_in("cs66").unwrap();
        let tcp = Pose::IDENTITY;
        let home = JointPositions([0.0, -1.57, 1.57, -1.57, -1.57, 0.0]);
        let q = [0.1, -1.5, 1.6, -1.5, -1.5, 0.1];
        let text = format!("{:?}\n{q:?}", home.0).replace(['[', ']'], "");
        let joints = parse(&text).unwrap();
        let values = |line: &MicroLine, number, space| {
            line.values(number, space, &model, &tcp, &home).unwrap()
        };
        assert_eq!(values(&joints, 2, Space::Joint), Some(q));
        assert_eq!(values(&joints, 0, Space::Joint), None);
        assert_eq!(values(&joints, 3, Space::Joint), None);

        let part = RpyPose::from_array([0.5, 0.0, 0.1, 0.0, 0.0, 1.0]);
        let in_part: Vec<String> = [home.0, q]
            .iter()
            .map(|q| {
                let base_from_tcp = model.tcp_pose(&JointPositions(*q), &tcp);
                let pose = Pose::from_rpy(&part).inverse() * base_from_tcp;
                format!("{:?}", pose.to_rpy().to_array()).replace(['[', ']'], "")
            })
            .collect();
        let text = in_part.join("\n");
        let mut poses = MicroLine::parse(&text, Space::Cartesian, Units::Si, 0.01).unwrap();
        poses.set_part(&part);
        let found = values(&poses, 2, Space::Joint).unwrap();
        for joint in 0..6 {
            assert!((found[joint] - q[joint]).abs() < 1e-9, "{found:?}");
        }
        let mut same = joints;
        same.set_part(&part);
        let pose = values(&same, 2, Space::Cartesian).unwrap();
        let as_given = values(&poses, 2, Space::Cartesian).unwrap();
        for k in 0..6 {
            assert!(
                (pose[k] - as_given[k]).abs() < 1e-9,
                "{pose:?} {as_given:?}"
            );
        }
        poses.set_part(&RpyPose::from_array([3.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
        let error = poses.values(2, Space::Joint, &model, &tcp, &home);
        assert!(matches!(
            error,
            Err(MicroLineError::OutOfReach { point: 1, .. })
        ));
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "[-0-9eE.,# \\n\\tnaif]{0,200}") {
            let _ = parse(&text);
        }
    }
}
