//! Whether suction cups can bear a wrench together.
//!
//! Each sealed cup bears a pull along its axis of up to F, a push of any size (by its rim), a shear of up to µF and a
//! moment of up to F·r about any axis. Any distribution within these limits counts. Most grips are proved by one
//! distribution in closed form, the least-squares one; the others go to a second-order cone program that finds how much
//! of the wrench can be borne.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use kinematics::Wrench;
use nalgebra::{Matrix6, Vector3, Vector6};

/// What one sealed cup can bear.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CupLimit {
    /// Middle of the rim from the point that the wrench is about, m.
    pub(crate) lever: Vector3<f64>,
    /// From the cup into the part, unit vector.
    pub(crate) axis: Vector3<f64>,
    /// Largest pull, N.
    pub(crate) pull: f64,
    /// Largest shear, N.
    pub(crate) shear: f64,
    /// Largest moment, Nm.
    pub(crate) moment: f64,
}

/// Forces below this are nothing, N; moments likewise, Nm.
const NOTHING: f64 = 1e-9;
/// The program looks no further than this multiple of the wrench.
const FACTOR_MAX: f64 = 4.0;
/// A wrench is borne when the program finds this share of it: what the solver leaves of the whole.
const WHOLE: f64 = 1.0 - 1e-6;

/// Whether the cups can give the part this wrench.
pub(crate) fn can_bear(cups: &[CupLimit], wrench: &Wrench) -> bool {
    if wrench.force.norm() < NOTHING && wrench.moment.norm() < NOTHING {
        return true;
    }
    if cups.is_empty() {
        return false;
    }
    is_borne_by_least_squares(cups, wrench) || load_factor(cups, wrench) >= WHOLE
}

/// Wrenches on the part of a unit of each component, columns: pull, two of shear, three of moment.
fn columns(cup: &CupLimit) -> [Vector6<f64>; 6] {
    let side = if cup.axis.x.abs() < 0.7 {
        Vector3::x()
    } else {
        Vector3::y()
    };
    let u = cup.axis.cross(&side).normalize();
    let v = cup.axis.cross(&u);
    let force = |direction: Vector3<f64>| {
        let moment = cup.lever.cross(&direction);
        Vector6::new(
            direction.x,
            direction.y,
            direction.z,
            moment.x,
            moment.y,
            moment.z,
        )
    };
    let moment = |direction: Vector3<f64>| {
        Vector6::new(0.0, 0.0, 0.0, direction.x, direction.y, direction.z)
    };
    [
        force(-cup.axis),
        force(u),
        force(v),
        moment(Vector3::x()),
        moment(Vector3::y()),
        moment(Vector3::z()),
    ]
}

fn limits(cup: &CupLimit) -> [f64; 6] {
    [
        cup.pull, cup.shear, cup.shear, cup.moment, cup.moment, cup.moment,
    ]
}

/// The distribution with the smallest sum of squares, each component measured in its limit; true if it keeps all
/// limits.
fn is_borne_by_least_squares(cups: &[CupLimit], wrench: &Wrench) -> bool {
    let mut gram = Matrix6::zeros();
    for cup in cups {
        for (column, limit) in columns(cup).iter().zip(limits(cup)) {
            gram += column * column.transpose() * (limit * limit);
        }
    }
    let Some(gram) = gram.cholesky() else {
        return false;
    };
    let dual = gram.solve(&wrench.to_vector());
    cups.iter().all(|cup| {
        let (columns, limits) = (columns(cup), limits(cup));
        let of: [f64; 6] = core::array::from_fn(|k| columns[k].dot(&dual) * limits[k]);
        let shear = of[1] * of[1] + of[2] * of[2];
        let moment = of[3] * of[3] + of[4] * of[4] + of[5] * of[5];
        of[0] <= 1.0 && shear <= 1.0 && moment <= 1.0
    })
}

/// The largest multiple of the wrench that the cups can give, up to [`FACTOR_MAX`]; 0 where the solver finds none.
fn load_factor(cups: &[CupLimit], wrench: &Wrench) -> f64 {
    // Unknowns: the factor, then six components a cup in units of its limits. All limits of a cup without pull are 0
    // but the push.
    let largest = cups
        .iter()
        .map(|c| c.pull)
        .fold(0.0, f64::max)
        .max(wrench.force.norm())
        .max(NOTHING);
    let size = 1 + 6 * cups.len();
    let scaled = wrench.to_vector() / largest;
    let mut rows: Vec<Vec<(usize, f64)>> = Vec::new();
    let mut bounds = Vec::new();
    for k in 0..6 {
        let mut row = vec![(0, -scaled[k])];
        for (i, cup) in cups.iter().enumerate() {
            row.extend(
                columns(cup)
                    .iter()
                    .enumerate()
                    .map(|(c, column)| (1 + 6 * i + c, column[k])),
            );
        }
        rows.push(row);
        bounds.push(0.0);
    }
    let mut cones = vec![
        SupportedConeT::ZeroConeT(6),
        SupportedConeT::NonnegativeConeT(1 + cups.len()),
    ];
    rows.push(vec![(0, 1.0)]);
    bounds.push(FACTOR_MAX);
    for (i, cup) in cups.iter().enumerate() {
        rows.push(vec![(1 + 6 * i, 1.0)]);
        bounds.push(cup.pull / largest);
    }
    for (i, cup) in cups.iter().enumerate() {
        for (limit, components) in [(cup.shear, 1..3), (cup.moment, 3..6)] {
            rows.push(Vec::new());
            bounds.push(limit / largest);
            cones.push(SupportedConeT::SecondOrderConeT(1 + components.len()));
            for c in components {
                rows.push(vec![(1 + 6 * i + c, -1.0)]);
                bounds.push(0.0);
            }
        }
    }
    let mut dense = vec![Vec::new(); size];
    for (row, entries) in rows.iter().enumerate() {
        for (column, value) in entries {
            dense[*column].push((row, *value));
        }
    }
    let mut starts = vec![0];
    let (mut indices, mut values) = (Vec::new(), Vec::new());
    for column in &dense {
        indices.extend(column.iter().map(|(row, _)| *row));
        values.extend(column.iter().map(|(_, value)| *value));
        starts.push(indices.len());
    }
    let matrix = CscMatrix::new(rows.len(), size, starts, indices, values);
    let mut goal = vec![0.0; size];
    goal[0] = -1.0;
    let settings = DefaultSettings {
        verbose: false,
        max_threads: 1,
        max_iter: 100,
        ..DefaultSettings::default()
    };
    let quadratic = CscMatrix::zeros((size, size));
    let Ok(mut solver) = DefaultSolver::new(&quadratic, &goal, &matrix, &bounds, &cones, settings)
    else {
        return 0.0;
    };
    solver.solve();
    match solver.solution.status {
        SolverStatus::Solved | SolverStatus::AlmostSolved => solver.solution.x[0],
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cup that looks upwards at `x`, below the part; F = 100 N, µ = 0.5, r = 0.02 m.
    fn cup(x: f64, y: f64) -> CupLimit {
        CupLimit {
            lever: Vector3::new(x, y, 0.0),
            axis: Vector3::z(),
            pull: 100.0,
            shear: 50.0,
            moment: 2.0,
        }
    }

    /// The factor at which a wrench stops being borne, by bisection of [`can_bear`].
    fn limit(cups: &[CupLimit], wrench: [f64; 6]) -> f64 {
        let (mut low, mut high) = (0.0, 1e4);
        for _ in 0..60 {
            let middle = (low + high) / 2.0;
            let scaled = Wrench::from_array(wrench.map(|x| x * middle));
            if can_bear(cups, &scaled) {
                low = middle
            } else {
                high = middle
            }
        }
        low
    }

    fn near(found: f64, expected: f64) {
        assert!(
            (found / expected - 1.0).abs() < 1e-4,
            "{found}, not {expected}"
        );
    }

    #[test]
    fn the_limits_of_simple_loads_are_those_of_the_closed_forms() {
        // The part is pulled along -z by the cups; it needs that when its weight hangs the other way.
        let two = [cup(-0.1, 0.0), cup(0.1, 0.0)];
        near(limit(&two, [0.0, 0.0, -1.0, 0.0, 0.0, 0.0]), 200.0);
        near(limit(&two, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]), 100.0);
        // Two cups at ±a and a weight at c beyond them bear 2F(a + r)/(a + c).
        let c = 0.3;
        near(
            limit(&two, [0.0, 0.0, -1.0, 0.0, c, 0.0]),
            2.0 * 100.0 * (0.1 + 0.02) / (0.1 + c),
        );
        // One cup alone peels off at F·r.
        near(limit(&[cup(0.0, 0.0)], [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]), 2.0);
        // Pull and shear are limits of their own.
        near(
            limit(&[cup(0.0, 0.0)], [0.5, 0.0, -1.0, 0.0, 0.0, 0.0]),
            100.0,
        );
    }

    #[test]
    fn a_push_has_no_limit_and_cups_without_pressure_bear_nothing_else() {
        let four: Vec<_> = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)]
            .map(|(x, y)| cup(0.1 * x, 0.1 * y))
            .into();
        assert!(can_bear(
            &four,
            &Wrench::from_array([0.0, 0.0, 1e4, 0.0, 0.0, 0.0])
        ));
        let empty = four
            .iter()
            .map(|c| CupLimit {
                pull: 0.0,
                shear: 0.0,
                moment: 0.0,
                ..*c
            })
            .collect::<Vec<_>>();
        assert!(!can_bear(
            &empty,
            &Wrench::from_array([0.0, 0.0, -1.0, 0.0, 0.0, 0.0])
        ));
        assert!(can_bear(&empty, &Wrench::default()));
        assert!(!can_bear(
            &[],
            &Wrench::from_array([0.0, 0.0, -1.0, 0.0, 0.0, 0.0])
        ));
    }
}
