//! What ports tell of the arm, from the configuration of the control cycle: figures that stay while the server runs.
//!
//! Live and replayed controllers describe themselves here, so that they tell the same.

use elite_runtime::port_map::NOMINAL_AMPERES;
use kinematics::JointPositions;
use motion::{ConfigError, CycleConfig};

use crate::ports::description::RobotDescription;

/// Figures of the arm with the limits in force.
///
/// # Errors
/// The configuration does not suit the arm.
pub fn robot_description(config: &CycleConfig) -> Result<RobotDescription, ConfigError> {
    let model = config.limited_model()?;
    let limits = model.limits();
    let dh = model.modified_dh();
    let anywhere = model.forward(&JointPositions::ZERO);
    Ok(RobotDescription {
        name: model.name().to_uppercase(),
        robot_type: model.type_number().unwrap_or(0),
        position_limits: std::array::from_fn(|j| (limits.position_min[j], limits.position_max[j])),
        speed_limits: limits.speed.0,
        acceleration_limits: limits.acceleration.0,
        dh_a: dh.map_or([0.0; 6], |t| t.a),
        dh_d: dh.map_or([0.0; 6], |t| t.d),
        dh_alpha: dh.map_or([0.0; 6], |t| t.alpha),
        torque_per_ampere: limits.effort.0.map(|nominal| nominal / NOMINAL_AMPERES),
        elbow_radius: model.collision().elbow_radius(&anywhere).unwrap_or(0.0),
        safety_checksum: safety_checksum(config)?,
    })
}

/// A number for the settings of the safety system: limits in force, safety inputs, safety planes and the tool they hold
/// back. Equal settings give equal numbers, in this version; how the vendor computes its own is not known.
fn safety_checksum(config: &CycleConfig) -> Result<u32, ConfigError> {
    // The derived text names every field there is: none can be forgotten, and floats are printed to the last bit.
    let settings = (config.resolve()?, config.safety_inputs, &config.safety);
    Ok(crc32fast::hash(format!("{settings:?}").as_bytes()))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use kinematics::RobotModel;

    use super::*;
    use controller::cell::Cell;
    use controller::start_configuration::cycle_config;

    fn described(model: &str, cell: &str) -> RobotDescription {
        let setup = recorder::Setup {
            plant: controller::start_configuration::IDEAL.to_owned(),
            home: JointPositions([0.0, -1.5, 1.5, -1.5, -1.5, 0.0]),
            step_time: 0.004,
            ..recorder::Setup::default()
        };
        let cell = Cell::from_text(cell.to_owned(), Path::new("cell.toml")).unwrap();
        let model = RobotModel::built_in(model).unwrap();
        robot_description(&cycle_config(&setup, model, Some(&cell)).unwrap()).unwrap()
    }

    #[test]
    fn the_checksum_changes_with_every_safety_setting_and_with_nothing_else() {
        let settings = [
            "",
            "[limits]\njoint_speed = [1, 1, 1, 1, 1, 1]",
            "[limits]\njoint_position_max = [3, 3, 3, 3, 3, 3]",
            "[limits]\ntcp_speed = 1.0",
            "[limits]\ntcp_speed = 1.5",
            "[limits]\nelbow_speed = 1.0",
            "[limits]\ntcp_force = 100",
            "[[safety_plane]]\nname = 'p'\npoint = [0, 0, 0]\nnormal = [0, 0, 1]",
            "[[safety_plane]]\nname = 'p'\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nmode = 'both'",
            "[[safety_plane]]\nname = 'p'\npoint = [0, 0, 0.01]\nnormal = [0, 0, 1]",
            "[[safety_input]]\nfunction = 'emergency_stop'\npair = 0",
            "[[safety_input]]\nfunction = 'safeguard_stop'\npair = 0",
            "[[safety_input]]\nfunction = 'safeguard_stop'\npair = 1",
            "[[safety_input]]\nfunction = 'safeguard_stop'\npair = 1\nactive = 'high'",
        ];
        let mut seen = std::collections::BTreeMap::new();
        for cell in settings {
            let checksum = described("cs66", cell).safety_checksum;
            assert_eq!(checksum, described("cs66", cell).safety_checksum);
            if let Some(other) = seen.insert(checksum, cell) {
                panic!("{cell:?} and {other:?} have the same checksum {checksum:08x}");
            }
        }
        let wired = "[[input]]\nat = 1\nset = 'standard_digital_in[0]'\nvalue = true";
        let same = described("cs66", wired).safety_checksum;
        assert_eq!(seen.get(&same), Some(&""));
    }

    #[test]
    fn limits_are_those_in_force_and_the_elbow_has_its_housing() {
        let slow = described("cs66", "[limits]\njoint_speed = [1, 1, 1, 1, 1, 1]");
        assert_eq!(slow.speed_limits, [1.0; 6]);
        // The upper arm of the CS63 is thicker at the elbow (61.4 mm) than the forearm (50.3 mm).
        assert_eq!(described("cs63", "").elbow_radius, 0.0614);
        for model in ["cs66", "cs612", "cs616", "cs620", "cs625"] {
            let radius = described(model, "").elbow_radius;
            assert!((0.05..0.15).contains(&radius), "{model}: {radius}");
        }
    }
}
