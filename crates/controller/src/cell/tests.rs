//! The whole schema read, and the sentence for every mistake.

use super::point::IoGroup;
use super::schema::*;
use super::*;
use motion::contact::Shape as Shape3d;

fn cell(text: &str) -> Result<Tables, CellError> {
    parse(text, &Text::verbatim("c.toml"), &mut NoFiles).map(|(tables, _)| tables)
}

/// Every table with every key.
const WHOLE: &str = r#"
[[obstacle]]
name = "bench"
shape = "box"
size = [1.2, 0.8, 0.05]
pose = [0.5, 0, -0.025, 0, 0, 0]
stiffness = 1e5
damping = 100
friction = 0.4
[[obstacle]]
name = "ball"
shape = "sphere"
size = 0.1
pose = [0, 0.5, 0.3, 0, 0, 0]
[[obstacle]]
name = "wall"
shape = "plane"
pose = [1, 0, 0, 0, -1.5708, 0]
[tool]
shape = "cylinder"
size = [0.02, 0.1]
pose = [0, 0, 0.05, 0, 0, 0]
[[safety_plane]]
name = "door"
point = [0, -0.6, 0]
normal = [0, 1, 0]
mode = "both"
ci_pair = 3
[[safety_plane]]
name = "ceiling"
point = [0, 0, 1]
normal = [0, 0, -2]
[limits]
joint_speed = [1, 1, 1, 2, 2, 2]
joint_acceleration = [5, 5, 5, 5, 5, 5]
joint_jerk = [100, 100, 100, 100, 100, 100]
joint_position_min = [-3, -3, -3, -3, -3, -3]
joint_position_max = [3, 3, 3, 3, 3, 3]
tcp_speed = 1.5
elbow_speed = 1.5
tcp_force = 150
self_collision = false
[sensor]
force_noise = 0.2
torque_noise = 0.01
[payload]
mass = 2
cog = [0, 0.01, 0.08]
inertia = [0.01, 0.01, 0.02, 0, 0, 0]
[arm]
coulomb = [6, 6, 5, 2, 2, 2]
viscous = [4, 4, 3, 1, 1, 1]
rotor_inertia = [0.6, 0.6, 0.4, 0.1, 0.1, 0.1]
[[wrench]]
at = 1
duration = 0.5
wrench = [0, 0, -20, 0, 0, 0]
frame = "tool"
[[conveyor]]
encoder = 0
direction = [1, 0, 0]
speed = 0.1
ticks_per_meter = 10000
start_at = 2
[[conveyor]]
encoder = 1
center = [0.5, 0, 0, 0, 0, 0]
speed = 0.2
ticks_per_revolution = 4096
[[wire]]
from = "standard_digital_out[3]"
to = "configurable_digital_in[2]"
delay = 0.02
[[input]]
at = 0.5
set = "standard_digital_in[0]"
value = true
[[input]]
at = 0.5
set = "tool_analog_in"
value = 4.5
[[safety_input]]
function = "safeguard_stop"
pair = 1
[[safety_input]]
function = "safeguard_reset"
pair = 2
active = "high"
[[serial]]
port = "masterboard"
device = "tcp:127.0.0.1:4000"
[[modbus]]
IP = "127.0.0.1"
slave_number = 255
signal_address = 0
signal_type = 3
signal_name = "speed"
is_sequential = true
registers_count = 10
port = 5021
[names]
"standard_digital_out[3]" = "vacuum"
"configurable_digital_in[2]" = "part held"
"#;

#[test]
fn every_table_and_key_is_read() {
    let cell = cell(WHOLE).unwrap();
    assert_eq!(cell.obstacle.len(), 3);
    assert_eq!(cell.obstacle[0].size.numbers(), [1.2, 0.8, 0.05]);
    assert_eq!(cell.obstacle[1].size.numbers(), [0.1]);
    assert_eq!(cell.obstacle[2].size, Size::None);
    assert_eq!(cell.obstacle[1].stiffness, None);
    assert_eq!(
        cell.tool.as_ref().map(|tool| tool.shape),
        Some(ShapeName::Cylinder)
    );
    assert_eq!(cell.safety_plane[0].mode, PlaneMode::Both);
    assert_eq!(cell.safety_plane[1].mode, PlaneMode::Normal);
    assert_eq!(
        cell.limits.joint_speed,
        Some([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
    );
    assert_eq!(cell.wrench[0].frame, LoadFrame::Tool);
    assert_eq!(cell.conveyor[1].start_at, 0.0);
    assert_eq!(cell.wire[0].to.group, IoGroup::ConfigurableDigital);
    assert_eq!(cell.input[1].value, InputValue::Number(4.5));
    assert_eq!(cell.modbus[0].port, 5021);
    let point = "standard_digital_out[3]".parse().unwrap();
    assert_eq!(cell.names.get(&point).map(String::as_str), Some("vacuum"));
}

#[test]
fn obstacles_tool_and_sensor_reach_the_arm() {
    let cell = Cell::from_text(WHOLE.to_owned(), Path::new("c.toml")).unwrap();
    let around = cell.surroundings();
    let shapes: Vec<_> = around
        .obstacles
        .iter()
        .map(|o| o.solid.shape.clone())
        .collect();
    let half = [0.6, 0.4, 0.025];
    assert_eq!(
        shapes,
        [
            Shape3d::Box { half },
            Shape3d::Sphere { radius: 0.1 },
            Shape3d::Plane
        ]
    );
    let bench = &around.obstacles[0];
    assert_eq!(
        (bench.stiffness, bench.damping, bench.friction),
        (Some(1e5), 100.0, 0.4)
    );
    let ball = &around.obstacles[1];
    assert_eq!(
        (ball.stiffness, ball.damping, ball.friction),
        (None, 0.0, 0.0)
    );
    assert_eq!(
        around.tool.first().map(|tool| tool.shape.clone()),
        Some(Shape3d::Cylinder {
            radius: 0.02,
            half_length: 0.05
        })
    );
    let noise = cell.sensor_noise(7);
    assert_eq!((noise.force, noise.torque, noise.seed), (0.2, 0.01, 7));
    assert_eq!(cell.limits().tcp_force, Some(150.0));
    assert_eq!(cell.limits().self_collision, Some(false));
}

#[test]
fn the_truth_reaches_the_arm_and_is_none_without_its_tables() {
    let truth = |text: &str| {
        let cell = Cell::from_text(text.to_owned(), Path::new("c.toml"));
        cell.unwrap().truth()
    };
    let there = truth(WHOLE);
    let payload = there.payload.unwrap();
    assert_eq!(
        (payload.mass, payload.cog.y, payload.inertia[2]),
        (2.0, 0.01, 0.02)
    );
    assert_eq!(there.drivetrain.coulomb.0, [6.0, 6.0, 5.0, 2.0, 2.0, 2.0]);
    assert_eq!(there.drivetrain.viscous[2], 3.0);
    assert_eq!(there.drivetrain.rotor_inertia[5], 0.1);
    assert_eq!(truth(""), PlantParameters::default());
    // No mass is a truth as well.
    assert!(truth("[payload]\nmass = 0").payload.is_some());
}

#[test]
fn limits_and_the_text_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cell.toml");
    let text = "[limits]\ntcp_speed = 0.5\njoint_speed = [1, 1, 1, 2, 2, 2]\n[sensor]\n";
    std::fs::write(&path, text).unwrap();
    let cell = Cell::load(&path).unwrap();
    assert_eq!(cell.text(), text);
    let expected = LimitOverrides {
        tcp_speed: Some(0.5),
        joint_speed: Some(JointSpeeds([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])),
        ..LimitOverrides::default()
    };
    assert_eq!(cell.limits(), expected);
    assert_eq!(cell.reduced_limits(), LimitOverrides::default());
    std::fs::write(&path, "[limits.reduced]\nelbow_speed = 0.2\n").unwrap();
    let reduced = LimitOverrides {
        elbow_speed: Some(0.2),
        ..LimitOverrides::default()
    };
    assert_eq!(Cell::load(&path).unwrap().reduced_limits(), reduced);
    let missing = Cell::load(&folder.path().join("x.toml")).unwrap_err();
    assert!(
        missing
            .to_string()
            .starts_with("cannot read the cell file ")
    );
}

#[test]
fn each_mistake_has_one_sentence_that_names_the_key() {
    let obstacle =
        |lines: &str| format!("[[obstacle]]\nname = \"a\"\npose = [0, 0, 0, 0, 0, 0]\n{lines}");
    let mistakes = [
        "[table]\nx = 1".to_owned(),
        "[limits]\njoint_sped = [1, 1, 1, 1, 1, 1]".to_owned(),
        "[limits]\njoint_speed = [1, 1, 1, 1, 1]".to_owned(),
        "[limits]\njoint_speed = 1".to_owned(),
        "[limits]\ntcp_speed = \"fast\"".to_owned(),
        "[limits\n".to_owned(),
        "[[obstacle]]\nshape = \"box\"".to_owned(),
        format!("{}\n[tool]\nshape = \"box\"", obstacle("shape = \"plane\"")),
        format!("{}\n[[obstacle]]\nname = \"b\"\npose = [0, 0, 0, 0, 0, 0]", obstacle("shape = \"plane\"")),
        "[[wire]]\nfrom = \"standard_digital_out[0]\"\nto = \"standard_digital_in[0]\"\n\n[[wire]]\n\
         to = \"standard_digital_in[1]\"".to_owned(),
        "wrench = [{ at = 1, duration = 1, wrench = [0, 0, 0, 0, 0, 0] },\n{ at = 2, duration = 1 }]".to_owned(),
        "[[modbus]]\nIP = \"h\"\nslave_number = 1\nsignal_address = 0\nsignal_name = \"x\"".to_owned(),
        obstacle("shape = \"cube\""),
        obstacle("shape = \"box\"\nsize = 1"),
        obstacle("shape = \"box\"\nsize = \"big\""),
        obstacle("shape = \"plane\"\nsize = [1]"),
        obstacle("shape = \"sphere\"\nsize = -1"),
        obstacle("shape = \"sphere\"\nsize = nan"),
        obstacle("shape = \"plane\"\nstiffness = 0"),
        obstacle("shape = \"plane\"\nfriction = -0.1"),
        obstacle("shape = \"plane\"\nstiffness = 1e9"),
        obstacle("shape = \"plane\"\nstiffness = nan"),
        obstacle("shape = \"plane\"\ndamping = -1"),
        obstacle("shape = \"plane\"\nfriction = 11"),
        obstacle("shape = \"plane\"\nmass = 1"),
        "[sensor]\nforce_noise = -1".to_owned(),
        "[sensor]\ntorque_noise = inf".to_owned(),
        "[sensor]\nseed = 1".to_owned(),
        "[payload]\ncog = [0, 0, 0]".to_owned(),
        "[payload]\nmass = -1".to_owned(),
        "[payload]\nmass = 1\ncog = [0, 0, 11]".to_owned(),
        "[payload]\nmass = 1\ninertia = [1, 1, 3, 0, 0, 0]".to_owned(),
        "[payload]\nmass = 1\nweight = 1".to_owned(),
        "[arm]\ncoulomb = [1, 1, 1]".to_owned(),
        "[arm]\nviscous = [0, 0, nan, 0, 0, 0]".to_owned(),
        "[arm]\nrotor_inertia = [0, 0, -0.1, 0, 0, 0]".to_owned(),
        "[arm]\nfriction = [0, 0, 0, 0, 0, 0]".to_owned(),
        "[tool]\nshape = \"sphere\"\nsize = 0\npose = [0, 0, 0, 0, 0, 0]".to_owned(),
        "[[wrench]]\nat = 0\nduration = 1\nwrench = [0, 0, 1e6, 0, 0, 0]".to_owned(),
        format!("{}\n{}", obstacle("shape = \"plane\""), obstacle("shape = \"plane\"")),
        "[tool]\nshape = \"plane\"\npose = [0, 0, 0, 0, 0, 0]".to_owned(),
        "[[safety_plane]]\nname = \"p\"\npoint = [0, 0, 0]\nnormal = [0, 0, 0]".to_owned(),
        "[[safety_plane]]\nname = \"p\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nci_pair = 4".to_owned(),
        "[[wrench]]\nat = -1\nduration = 1\nwrench = [0, 0, 0, 0, 0, 0]".to_owned(),
        "[[conveyor]]\nencoder = 2\nspeed = 1".to_owned(),
        "[[conveyor]]\nencoder = 0\nspeed = 1\ndirection = [1, 0, 0]".to_owned(),
        "[[wire]]\nfrom = \"standard_digital_in[0]\"\nto = \"standard_digital_in[1]\"".to_owned(),
        "[[wire]]\nfrom = \"standard_digital_out[0]\"\nto = \"standard_analog_in[1]\"".to_owned(),
        "[[wire]]\nfrom = \"standard_digital_out[99]\"\nto = \"standard_digital_in[1]\"".to_owned(),
        "[[input]]\nat = 0\nset = \"standard_digital_in[0]\"\nvalue = 1.5".to_owned(),
        "[[input]]\nat = 0\nset = \"standard_analog_in[0]\"\nvalue = true".to_owned(),
        "[[serial]]\nport = \"usb\"\ndevice = \"x\"".to_owned(),
        "[[modbus]]\nIP = \"x\"\nslave_number = 1\nsignal_address = 0\nsignal_type = 4\nsignal_name = \"a\"".to_owned(),
        "[names]\n\"standard_digital_out[16]\" = \"lamp\"".to_owned(),
        "[names]\nlamp = \"standard_digital_out[1]\"".to_owned(),
        "[names]\n\"standard_digital_out[1]\" = 3".to_owned(),
        "[names]\n\"standard_digital_out[1]\" = \" \"".to_owned(),
        format!("[names]\n\"tool_analog_in\" = \"{}\"", "x".repeat(41)),
        "[names]\n\"standard_digital_in[1]\" = \"part\"\n\"standard_digital_in[2]\" = \"part\"".to_owned(),
    ];
    let sentences = mistakes.map(|text| cell(&text).unwrap_err().to_string());
    insta::assert_snapshot!(sentences.join("\n"));
}
