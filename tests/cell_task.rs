//! A task as the pendant generates it, with a configuration whose variables outlive plays and a PLC that hands out
//! orders: loaded, set and started at the dashboard, as a line's computer does it.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::time::{Duration, Instant};

use crate::common::{Dashboard, PATIENCE, Server, alone};

const TASK: &str = r#"<EliTask name="stack" installationName="line" installationDirectory="cell" robotType="6212"
         createdVersion="2.15.0.477">
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

const CELL_OF_GUARD: &str = r#"<EliTask name="guard" installationName="" robotType="6212"
         createdVersion="2.15.0.477">
  <MainTask isTaskAlwaysLoops="false" hasBeforeStart="false" hasInitVariables="false"/>
</EliTask>
"#;

/// A node "direction" with "until": a thread moves along an axis of the tool towards a point a kilometre away, and the
/// node watches an input, stops the thread and brakes. What the arm has done is left in general purpose words.
const DIRECTION: &str = r#"def guard():
  $ LINE: (1, "MoveJ")
  movej([0, -1.5708, -1.5708, -1.5708, 1.5708, 0], a=4, v=2)
  begin = get_actual_tcp_pose()
  $ LINE: (2, "Direction")
  def along():
    movel(pose_trans(get_target_tcp_pose(), [0, 0, AXIS, 0, 0, 0]), a=0.5, v=0.05)
  end
  way = start_thread(along, ())
  write_port_register(256, 1)
  $ LINE: (3, "Until")
  while not get_standard_digital_in(3):
    sync()
  end
  stop_thread(way)
  stopl(2)
  $ LINE: (4, "Set")
  there = get_actual_tcp_pose()
  gone = pose_trans(pose_inv(begin), there)
  write_port_register(257, int(gone[2] * 10000))
  write_port_register(258, int((abs(gone[0]) + abs(gone[1])) * 10000))
  sleep(0.2)
  write_port_register(259, int(abs(get_actual_tcp_pose()[2] - there[2]) * 10000))
  write_port_register(256, 2)
end
"#;

/// Sets input 3 of the control box.
fn switch(server: &Server, level: bool) {
    let mut http = TcpStream::connect(("127.0.0.1", server.ports["http"])).unwrap();
    let body = format!("{{\"standard_digital_in[3]\": {level}}}");
    let head = "POST /api/inputs HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Type: application/json";
    write!(
        http,
        "{head}\r\nContent-Length: {}\r\n\r\n{body}",
        body.len()
    )
    .unwrap();
    let mut reply = String::new();
    http.read_to_string(&mut reply).unwrap();
    assert!(reply.starts_with("HTTP/1.1 200"), "{reply}");
}

#[test]
fn a_direction_goes_on_until_an_input_and_not_further() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let tasks = folder.path().join("tasks");
    std::fs::create_dir_all(&tasks).unwrap();
    for (name, axis) in [("forth", "1000"), ("back", "-1000")] {
        std::fs::write(tasks.join(format!("{name}.task")), CELL_OF_GUARD).unwrap();
        let text = DIRECTION.replace("AXIS", axis);
        std::fs::write(tasks.join(format!("{name}.task.script")), text).unwrap();
    }
    let server = Server::start(folder.path(), &["--record", "off", "--task-dir", "tasks"]);
    let mut plc = TcpStream::connect(("127.0.0.1", server.ports["modbus"])).unwrap();
    plc.set_nodelay(true).unwrap();
    let mut dashboard = Dashboard::connect(&server);
    for (name, sign) in [("forth", 1), ("back", -1)] {
        switch(&server, false);
        write(&mut plc, 256, 0);
        let loaded = format!("Loaded task: {name}.task");
        assert_eq!(dashboard.ask(&format!("task -p {name}.task")), loaded);
        assert_eq!(dashboard.ask("play"), "Starting task");
        until("the direction has begun", || word(&mut plc, 256) == 1);
        // The arm is on its way: 30 mm at least, in tenths of a millimetre.
        let begin = [384, 385, 386].map(|address| word(&mut plc, address));
        until("the arm moves", || {
            let now = [384, 385, 386].map(|address| word(&mut plc, address));
            let squares = begin.iter().zip(now).map(|(a, b)| f64::from(b - a).powi(2));
            squares.sum::<f64>().sqrt() > 300.0
        });
        assert_eq!(word(&mut plc, 256), 1, "it goes on without the input");
        switch(&server, true);
        until("the program has seen the input", || {
            word(&mut plc, 256) == 2
        });
        let gone = word(&mut plc, 257) * sign;
        assert!(
            (300..3000).contains(&gone),
            "{name}: {gone} tenths of a millimetre"
        );
        assert!(word(&mut plc, 258) < 10, "{name}: beside its line");
        assert!(word(&mut plc, 259) < 10, "{name}: the arm goes on");
        until("the program ends", || {
            dashboard.ask("task -s") == "Task is stopped"
        });
    }
    assert!(server.terminate().success());
    let log = std::fs::read_to_string(folder.path().join("stderr.log")).unwrap();
    assert!(!log.contains("Error"), "{log}");
}
