//! Grippers on the controller's serial lines and on Modbus TCP: programs speak to them in cycles that are the same
//! every time.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "test helpers fail by panicking"
)]

use std::io::Write as _;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use controller::cell::Cell;
use controller::{ControllerConfig, NullObserver, SteppedController, WallTimeout};
use elite_runtime::ProgramText;
use motion_api::{RobotState, Seconds};

/// Fingers around a cube of 40 mm on a plate, where the flange of [`down`] puts them.
fn cell(bus: &str) -> String {
    format!(
        r#"
[world]
floor = -0.5

[[obstacle]]
name = "plate"
shape = "box"
size = [0.4, 0.4, 0.05]
pose = [-0.45, -0.2, 0.125, 0, 0, 0]

[[part]]
name = "cube"
shape = "box"
size = [0.04, 0.04, 0.04]
mass = 0.3
pose = [-0.45, -0.2, 0.17, 0, 0, 0]

[[gripper]]
name = "hand"
kind = "fingers"
stroke = 0.085
finger = {{ size = [0.02, 0.01, 0.04], pose = [0, 0.005, 0.1, 0, 0, 0] }}
force = 100
speed = 0.05
{bus}
"#
    )
}

const ROBOTIQ: &str = "protocol = \"robotiq-2f\"\nbus = \"tool\"";
const DH: &str = "protocol = \"dh-ag\"\nbus = \"masterboard\"\nslave = 3";

/// Takes the cube and lifts it; the registers tell what the gripper said.
const TAKE_ROBOTIQ: &str = "
tool_serial_config(True, 115200, 0, 1, 8, True)
set_tcp([0, 0, 0.1, 0, 0, 0])
down = [3.141592653589793, 0, 0]
movel([-0.45, -0.2, 0.18] + down, a=1, v=0.3)
tool_modbus_write_registers(9, 1000, [256, 0, 0])
write_output_integer_register(0, tool_modbus_read_registers(9, 2000, 1)[0])
tool_modbus_write_registers(9, 1000, [2304, 255, 65535])
status = tool_modbus_read_registers(9, 2000, 3)
write_output_integer_register(1, status[0])
cycles = 0
while (status[0] >> 14) == 0:
    sleep(0.004)
    cycles = cycles + 1
    status = tool_modbus_read_input_registers(9, 2000, 3)
write_output_integer_register(2, status[0])
write_output_integer_register(3, status[2] >> 8)
write_output_integer_register(4, cycles)
movel([-0.45, -0.2, 0.35] + down, a=1, v=0.3)
";

const TAKE_DH: &str = "
masterboard_serial_config(True, 115200, 0, 1, 8, True)
set_tcp([0, 0, 0.1, 0, 0, 0])
down = [3.141592653589793, 0, 0]
movel([-0.45, -0.2, 0.18] + down, a=1, v=0.3)
masterboard_modbus_rtu_write_single_register(3, 256, 1)
write_output_integer_register(0, masterboard_modbus_rtu_read_registers(3, 512, 1)[0])
masterboard_modbus_rtu_write_single_register(3, 257, 80)
masterboard_modbus_rtu_write_single_register(3, 259, 0)
status = masterboard_modbus_rtu_read_registers(3, 512, 3)
write_output_integer_register(1, status[1])
cycles = 0
while status[1] == 0:
    sleep(0.004)
    cycles = cycles + 1
    status = masterboard_modbus_rtu_read_registers(3, 512, 3)
write_output_integer_register(2, status[1])
write_output_integer_register(3, status[2])
write_output_integer_register(4, cycles)
movel([-0.45, -0.2, 0.35] + down, a=1, v=0.3)
";

const TAKE_TCP: &str = "
modbus_add_signal('127.0.0.1', 9, 1000, 3, 'ask', registers_count=3, port=5020)
modbus_add_signal('localhost', 9, 2000, 2, 'status', registers_count=3, port=5020)
modbus_set_signal_update_frequency('ask', 50)
modbus_set_signal_update_frequency('status', 50)
def status():
    return modbus_get_signal_status('status')
set_tcp([0, 0, 0.1, 0, 0, 0])
down = [3.141592653589793, 0, 0]
movel([-0.45, -0.2, 0.18] + down, a=1, v=0.3)
modbus_set_output_register('ask', [256, 0, 0])
sleep(0.1)
write_output_integer_register(0, status()[0])
modbus_set_output_register('ask', [2304, 255, 65535])
sleep(0.1)
write_output_integer_register(1, status()[0])
while (status()[0] >> 14) == 0:
    sleep(0.004)
write_output_integer_register(2, status()[0])
write_output_integer_register(3, status()[2] >> 8)
movel([-0.45, -0.2, 0.35] + down, a=1, v=0.3)
";

struct Controller(SteppedController);

impl Controller {
    fn open(cell: &str) -> Self {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(cell.as_bytes()).unwrap();
        let config = ControllerConfig {
            cell: Some(file.path().to_owned()),
            ..ControllerConfig::default()
        };
        Self(SteppedController::open(&config, Arc::new(NullObserver)).unwrap())
    }

    fn run(&self, program: &str) -> RobotState {
        let text = ProgramText {
            name: "grip.script".to_owned(),
            text: program.to_owned(),
        };
        let mut patience = WallTimeout {
            wall: Duration::from_secs(60),
            keep_going: &mut || true,
        };
        let result = self
            .0
            .run_program(text, Seconds::new(60.0).unwrap(), &mut patience)
            .unwrap();
        assert_eq!(result.error, None);
        self.0.state()
    }

    fn told(&self) -> [i32; 5] {
        let registers = self.0.controller().robot().registers().images();
        [0, 1, 2, 3, 4].map(|k| registers.output.integer(k))
    }

    fn holding(&self) -> Option<String> {
        let world = self.0.controller().world().unwrap().lock();
        world.state().grippers[0]
            .holding
            .as_ref()
            .map(ToString::to_string)
    }
}

/// 22.5 mm a finger: (85 mm - 40 mm) / 2 at 50 mm/s, in cycles of 4 ms.
const CLOSING_CYCLES: i32 = 113;

#[test]
fn a_program_takes_a_part_with_a_robotiq_gripper_at_the_tool() {
    let controller = Controller::open(&cell(ROBOTIQ));
    controller.run(TAKE_ROBOTIQ);
    assert_eq!(controller.holding().as_deref(), Some("cube"));
    let [ready, moving, held, position, cycles] = controller.told();
    assert_eq!([ready, moving, held], [0x3100, 0x3900, 0xB900]);
    // 255 (1 - 40/85) = 135.
    assert_eq!(position, 135);
    assert!((cycles - CLOSING_CYCLES).abs() <= 2, "{cycles}");
    let again = Controller::open(&cell(ROBOTIQ));
    let (first, second) = (controller.0.state(), again.run(TAKE_ROBOTIQ));
    assert_eq!(again.told(), controller.told());
    assert_eq!(first.cycle, second.cycle);
    // Opens: the part falls.
    controller.run("tool_modbus_write_registers(9, 1001, [0])\nsleep(1)");
    assert_eq!(controller.holding(), None);
}

#[test]
fn a_program_takes_a_part_with_a_dh_gripper_at_the_control_box() {
    let controller = Controller::open(&cell(DH));
    controller.run(TAKE_DH);
    assert_eq!(controller.holding().as_deref(), Some("cube"));
    let [ready, moving, held, position, cycles] = controller.told();
    assert_eq!([ready, moving, held], [1, 0, 2]);
    // 1000 · 40/85 = 471.
    assert!((470..=471).contains(&position), "{position}");
    assert!((cycles - CLOSING_CYCLES).abs() <= 2, "{cycles}");
}

#[test]
fn fingers_stop_when_go_is_taken_back_and_other_slaves_are_silent() {
    let controller = Controller::open(&cell(ROBOTIQ));
    controller.run(
        "
tool_serial_config(True, 115200, 0, 1, 8, True)
tool_modbus_write_registers(9, 1000, [2304, 255, 65535])
sleep(0.4)
tool_modbus_write_single_register(9, 1000, 256)
sleep(0.2)
a = tool_modbus_read_registers(9, 2002, 1)[0] >> 8
sleep(0.2)
write_output_integer_register(0, a)
write_output_integer_register(1, tool_modbus_read_registers(9, 2002, 1)[0] >> 8)
write_output_integer_register(2, len(tool_modbus_read_registers(8, 2002, 1)))
write_output_integer_register(3, len(tool_modbus_read_registers(9, 2002, 2)))
write_output_integer_register(4, tool_modbus_write_single_bit(9, 1000, True))
",
    );
    let [stopped, later, silent, outside, bit] = controller.told();
    // 40 of 85 mm.
    assert!((119..=121).contains(&stopped), "{stopped}");
    assert_eq!([later, silent, outside, bit], [stopped, 0, 0, 0]);
}

#[test]
fn a_program_takes_a_part_with_a_gripper_on_modbus_tcp_in_the_same_cycles_every_time() {
    let bus = "protocol = \"robotiq-2f\"\nbus = \"tcp:5020\"";
    let take = || {
        let controller = Controller::open(&cell(bus));
        let state = controller.run(TAKE_TCP);
        assert_eq!(controller.holding().as_deref(), Some("cube"));
        (controller.told(), state.cycle)
    };
    let ([ready, moving, held, position, _], cycle) = take();
    assert_eq!([ready, moving, held], [0x3100, 0x3900, 0xB900]);
    assert_eq!(position, 135);
    // Two at a time: no port of the machine is in use.
    let other = std::thread::spawn(take);
    assert_eq!(take().1, cycle);
    assert_eq!(other.join().unwrap().1, cycle);
}

#[test]
fn only_robotiq_reads_and_writes_in_one_function() {
    let errors = |protocol: &str, written: u32, read: u32| {
        let bus = format!("protocol = \"{protocol}\"\nbus = \"tcp:5020\"\nslave = 9");
        let controller = Controller::open(&cell(&bus));
        controller.run(&format!(
            "
modbus_add_rw_signal('127.0.0.1', 9, {read}, 1, {written}, 1, 'both', port=5020)
modbus_set_signal_update_frequency('both', 50)
sleep(0.1)
modbus_set_output_register('both', [1])
sleep(0.2)
write_output_integer_register(0, modbus_get_error('both')[0])
"
        ));
        controller.told()[0]
    };
    assert_eq!(errors("robotiq-2f", 1001, 2000), 0);
    // Exception 1: the function is not allowed.
    assert_eq!(errors("dh-ag", 0x0104, 0x0200), 1);
}

#[test]
fn another_slave_of_a_tcp_port_is_told_to_be_absent() {
    let controller = Controller::open(&cell("protocol = \"robotiq-2f\"\nbus = \"tcp:5020\""));
    controller.run(
        "
modbus_add_signal('127.0.0.1', 8, 2000, 2, 'nobody', port=5020)
modbus_add_signal('127.0.0.1', 255, 2000, 2, 'somebody', port=5020)
sleep(0.5)
write_output_integer_register(0, modbus_get_error('nobody')[0])
write_output_integer_register(1, modbus_get_error('somebody')[0])
",
    );
    let [nobody, somebody, ..] = controller.told();
    assert_eq!([nobody, somebody], [11, 0]);
}

#[test]
fn what_cannot_be_on_a_bus_is_refused_in_a_sentence() {
    let second = "\n[[gripper]]\nname = \"other\"\nkind = \"fingers\"\nstroke = 0.08\n\
                  finger = { size = [0.02, 0.01, 0.04], pose = [0, 0.005, 0.1, 0, 0, 0] }\nforce = 9\nspeed = 0.1\n\
                  protocol = \"dh-ag\"\nbus = \"tool\"\nslave = 9\n";
    let serial = "\n[[serial]]\nport = \"tool\"\ndevice = \"tcp:127.0.0.1:9\"\n";
    for (text, parts) in [
        (
            format!("{ROBOTIQ}{second}"),
            ["gripper \"other\" has slave = 9", "\"hand\""],
        ),
        (
            format!("{ROBOTIQ}{serial}"),
            ["has bus = \"tool\"", "[[serial]]"],
        ),
        (
            format!("{ROBOTIQ}\nclose = \"standard_digital_out[0]\""),
            ["has close = standard_digital_out[0]", "no points"],
        ),
        (
            "protocol = \"dh-ag\"\nbus = \"tcp:65536\"".to_owned(),
            ["has bus = \"tcp:65536\"", "1 to 65535"],
        ),
        (
            "protocol = \"dh-ag\"\nbus = \"tcp:0\"".to_owned(),
            ["has bus = \"tcp:0\"", "1 to 65535"],
        ),
        (
            "protocol = \"dh-ag\"\nbus = \"can\"".to_owned(),
            ["has bus = \"can\"", "\"masterboard\""],
        ),
        (
            "protocol = \"dh-ag\"".to_owned(),
            ["has bus = nothing", "\"tool\""],
        ),
        (
            format!("{ROBOTIQ}\nslave = 0"),
            ["has slave = 0", "1 to 247"],
        ),
        (
            "close = \"standard_digital_out[0]\"\nslave = 4".to_owned(),
            ["has slave = given", "protocol"],
        ),
    ] {
        let refused = Cell::from_text(cell(&text), Path::new("cell.toml")).unwrap_err();
        let refused = refused.to_string();
        for part in parts {
            assert!(refused.contains(part), "{refused}");
        }
    }
}
