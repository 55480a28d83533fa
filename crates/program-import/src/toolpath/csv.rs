//! Points as a table: x, y, z and, in six columns, roll, pitch and yaw of the tool in rad.

use messages::{Text, text};

use super::{Point, StepKind, Toolpath, ToolpathError};

/// Reads a table with lengths in `unit_m` metres. A first line without numbers is a head and may name the columns in
/// any order.
///
/// # Errors
///
/// A line has another number of columns, or something that is no number.
pub fn read(text: &str, unit_m: f64) -> Result<Toolpath, ToolpathError> {
    let mut path = Toolpath::default();
    let mut order: Vec<usize> = Vec::new();
    let mut columns = 0;
    for (number, line) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.is_empty() {
            continue;
        }
        let has_semicolons = line.contains(';');
        let cells: Vec<String> = line
            .split(if has_semicolons { ';' } else { ',' })
            // Where `;` is between columns, `,` is in numbers.
            .map(|cell| cell.trim().trim_matches('"').replace(',', "."))
            .collect();
        if columns == 0 && order.is_empty() && cells.iter().all(|cell| cell.parse::<f64>().is_err())
        {
            order = head(&cells, number)?;
            continue;
        }
        let damaged = |text: Text| ToolpathError::Damaged { line: number, text };
        if columns == 0 {
            columns = cells.len();
            if order.is_empty() {
                order = (0..columns).collect();
            }
        }
        if cells.len() != columns
            || !matches!(order.len(), 3 | 6)
            || order.iter().any(|at| *at >= columns)
        {
            return Err(damaged(text!(
                "{} columns: a point has x, y, z and perhaps rx, ry, rz",
                "有 {} 列：一个点有 x、y、z，以及可选的 rx、ry、rz",
                cells.len()
            )));
        }
        let mut values = [0.0; 6];
        for (value, at) in values.iter_mut().zip(&order) {
            let cell = &cells[*at];
            *value = match cell.parse::<f64>() {
                Ok(number) if number.is_finite() => number,
                _ => {
                    let shown: String = cell.chars().take(20).collect();
                    return Err(damaged(text!("'{shown}' is no number", "'{shown}' 不是数")));
                }
            };
        }
        let point: Point = [values[0] * unit_m, values[1] * unit_m, values[2] * unit_m];
        if point.iter().any(|x| x.abs() > 100.0) {
            return Err(damaged(text!(
                "the point is more than 100 m away",
                "点在 100 m 之外"
            )));
        }
        path.push(
            number,
            match order.len() {
                3 => StepKind::Line(point),
                _ => StepKind::Pose(point, [values[3], values[4], values[5]]),
            },
        )?;
    }
    match path.steps.is_empty() {
        true => Err(ToolpathError::Empty {
            text: text!("there is no point in it", "其中没有点"),
        }),
        false => Ok(path),
    }
}

/// Where x, y, z, rx, ry, rz stand; names that say nothing leave them in their order.
fn head(cells: &[String], line: u32) -> Result<Vec<usize>, ToolpathError> {
    let find = |name: &str| {
        cells.iter().position(|cell| {
            let cell = cell.to_ascii_lowercase();
            cell == name || cell.split(['_', ' ', '[', '(']).next() == Some(name)
        })
    };
    let position: Vec<usize> = ["x", "y", "z"].into_iter().filter_map(find).collect();
    let rotation: Vec<usize> = ["rx", "ry", "rz"].into_iter().filter_map(find).collect();
    match (position.len(), rotation.len(), cells.len()) {
        (3, 3, _) => Ok([position, rotation].concat()),
        (3, 0, _) => Ok(position),
        (0, 0, count @ (3 | 6)) => Ok((0..count).collect()),
        _ => Err(ToolpathError::Damaged {
            line,
            text: text!(
                "the head names no columns x, y, z and perhaps rx, ry, rz",
                "表头没有列名 x、y、z 以及可选的 rx、ry、rz"
            ),
        }),
    }
}
