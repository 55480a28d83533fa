//! A task as the pendant generates it, with a configuration whose variables outlive plays and a PLC that hands out orders: loaded,
//! set and started at the dashboard, as a line's computer does it.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::time::{Duration, Instant};

use crate::common::{Dashboard, PATIENCE, Server, alone};

const TASK: &str = r#"<EliTask name="stack" installationName="line" installationDirectory="cell" robotType="6212" createdVersion="2.15.0.477">
  <InitVariables/>
  <MainTask isTaskAlwaysLoops="false" hasBeforeStart="true" hasInitVariables="false"/>
</EliTask>
"#;

const VARIABLES: &str = r#"<VariablesManager>
    <Variable name="width" value="594.59998" remarks="mm, &lt;outer&gt;" favorite="false"/>
    <Variable name="layer" value="0" remarks="" favorite="true"/>
    <Variable name="pick_q" value="[0.2, -1.5708, 1.5708, -1.5708, -1.5708, 0]" remarks="" favorite="true"/>
    <Variable name="recipe" value="&quot;A &amp; B&quot;" remarks="" favorite="false"/>
</VariablesManager>
"#;

/// The values in the text are those of the moment in which it was generated.
const SCRIPT: &str = r#"def stack():
  # mm, <outer>
  global width
  width = 100
  #
  global layer
  layer = 7
  #
  global pick_q
  pick_q = [0, 0, 0, 0, 0, 0]
  #
  global recipe
  recipe = ""
  set_tool_voltage(0)
  set_tcp([0, 0, 0.12, 0, 0, 0])
  $ LINE: (1, "Robot Main Task")
  def order():
    return read_port_register(256, True)
  end
  $ LINE: (2, "wait for an order")
  while order() == 0:
    sleep(0.01)
  end
  layer = layer + order()
  width = width / 2
  $ LINE: (3, "MoveJ")
  movej(pick_q, a=4, v=2)
  write_port_register(257, layer)
  write_port_bit(34, True)
  $ LINE: (4, "wait until the order is taken back")
  while order() != 0:
    sleep(0.01)
  end
  write_port_register(257, 0)
  write_port_bit(34, False)
  textmsg(recipe)
end
"#;

fn word(plc: &mut TcpStream, address: u16) -> i16 {
    let [a, b] = address.to_be_bytes();
    plc.write_all(&[0, 1, 0, 0, 0, 6, 1, 4, a, b, 0, 1])
        .unwrap();
    let mut reply = [0; 11];
    plc.read_exact(&mut reply).unwrap();
    assert_eq!(reply[7..9], [4, 2]);
    i16::from_be_bytes([reply[9], reply[10]])
}

fn write(plc: &mut TcpStream, address: u16, value: i16) {
    let ([a, b], [c, d]) = (address.to_be_bytes(), value.to_be_bytes());
    let request = [0, 1, 0, 0, 0, 6, 1, 6, a, b, c, d];
    plc.write_all(&request).unwrap();
    let mut reply = [0; 12];
    plc.read_exact(&mut reply).unwrap();
    assert_eq!(reply, request);
}

fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !holds() {
        assert!(begun.elapsed() < PATIENCE, "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// One order of the PLC, from its number to the end of the program.
fn order(plc: &mut TcpStream, dashboard: &mut Dashboard, count: i16, layer: i16) {
    until("the program runs", || word(plc, 500) == 1);
    write(plc, 256, count);
    until("the order is done", || word(plc, 257) != 0);
    assert_eq!(word(plc, 257), layer);
    assert_eq!(word(plc, 2), 4, "output 2");
    assert_eq!(word(plc, 73), 200, "mrad");
    write(plc, 256, 0);
    until("the program ends", || {
        dashboard.ask("task -s") == "Task is stopped"
    });
    assert_eq!((word(plc, 257), word(plc, 2)), (0, 0));
}

fn variables(folder: &Path) -> String {
    std::fs::read_to_string(folder.join("tasks/cell/line.configuration.variables")).unwrap()
}

#[test]
fn a_generated_task_goes_on_with_the_values_of_its_last_run() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let cell = folder.path().join("tasks/cell");
    std::fs::create_dir_all(&cell).unwrap();
    for (name, text) in [
        ("stack.task", TASK),
        ("stack.task.script", SCRIPT),
        ("line.configuration.variables", VARIABLES),
    ] {
        std::fs::write(cell.join(name), text).unwrap();
    }
    let server = Server::start(folder.path(), &["--record", "off", "--task-dir", "tasks"]);
    let mut plc = TcpStream::connect(("127.0.0.1", server.ports["modbus"])).unwrap();
    plc.set_nodelay(true).unwrap();
    let mut dashboard = Dashboard::connect(&server);
    assert_eq!(
        dashboard.ask("task -p cell/stack.task"),
        "Loaded task: cell/stack.task"
    );
    assert_eq!(dashboard.ask("variable -get layer"), "0");
    assert_eq!(dashboard.ask("variable -get width"), "594.59998");
    assert_eq!(dashboard.ask("variable -set width 600"), "width, 600");
    assert_eq!(dashboard.ask("variable -get width"), "600");

    assert_eq!(dashboard.ask("play"), "Starting task");
    assert_eq!(
        dashboard
            .ask("variable -get recipe")
            .trim_matches(['\'', '"']),
        "A & B"
    );
    let refused = dashboard.ask("variable -set layer 5");
    assert!(
        refused.starts_with("Error: ") && refused.contains("while a program runs"),
        "{refused}"
    );
    order(&mut plc, &mut dashboard, 3, 3);
    // At once, and in the file; what is beside the values stays.
    assert_eq!(dashboard.ask("variable -get layer"), "3");
    assert_eq!(dashboard.ask("variable -get width"), "300.0");
    let expected = VARIABLES
        .replace("594.59998", "300.0")
        .replace("name=\"layer\" value=\"0\"", "name=\"layer\" value=\"3\"");
    until("the file has it", || {
        variables(folder.path()).contains("\"300.0\"")
    });
    assert_eq!(variables(folder.path()), expected);

    assert_eq!(dashboard.ask("play"), "Starting task");
    order(&mut plc, &mut dashboard, 4, 7);
    // Ended by the end of the server, with what it had.
    assert_eq!(dashboard.ask("variable -set layer -2"), "layer, -2");
    assert_eq!(dashboard.ask("play"), "Starting task");
    until("it runs", || word(&mut plc, 500) == 1);
    write(&mut plc, 256, 10);
    until("the order is done", || word(&mut plc, 257) == 8);
    assert!(server.terminate().success());
    assert!(variables(folder.path()).contains("name=\"layer\" value=\"8\""));
    let log = std::fs::read_to_string(folder.path().join("stderr.log")).unwrap();
    assert_eq!(log.matches("A & B").count(), 2, "{log}");
}
