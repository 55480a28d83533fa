//! Where observers are told that script threads stand: lines once a cycle and at the end, nodes of the pendant's task
//! as they are passed.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use crate::common;

use common::{Standing, run};

/// What was told of one thread: lines, and nodes as `line:number label`.
fn told(text: &str, thread: u32) -> Vec<String> {
    let ran = run(&Standing::default(), text);
    let of_thread = ran
        .places
        .into_iter()
        .filter(|(number, _)| *number == thread);
    of_thread
        .map(|(_, (line, node))| match node {
            None => line.to_string(),
            Some((number, label)) => format!("{line}:{number} {label}"),
        })
        .collect()
}

#[test]
fn the_last_line_of_a_thread_is_where_it_ended() {
    for (text, last) in [
        ("a = 1\nsleep(0.1)\nb = 2\n", "3"),
        ("def job():\n  sleep(0.1)\n  b = 2\nend\n", "3"),
        ("def job():\n  sleep(0.1)\n  b = 1 / 0\n  c = 1\nend\n", "3"),
        (
            "def f():\n  sync()\n  raise ValueError('no')\ndef job():\n  sync()\n  f()\n  return 1\njob()\n",
            "3",
        ),
        ("def job():\n  sleep(0.1)\n  halt()\n  c = 1\nend\n", "3"),
        ("x = 1\ny = missing_name\n", "2"),
    ] {
        let lines = told(text, 0);
        assert_eq!(
            lines.last().map(String::as_str),
            Some(last),
            "{text}: {lines:?}"
        );
        assert!(!lines.contains(&"0".to_owned()), "{text}: {lines:?}");
    }
}

#[test]
fn a_thread_that_ends_or_is_stopped_has_its_last_line() {
    let text = "def work():
  sleep(0.1)
  x = 1
def hold():
  y = 1
  sleep(100)
a = start_thread(work, ())
b = start_thread(hold, ())
join_thread(a)
stop_thread(b)
sleep(0.1)
";
    assert_eq!(told(text, 1), ["2", "3"]);
    assert_eq!(told(text, 2), ["6"]);
}

#[test]
fn a_line_is_told_once_a_cycle() {
    let text = "i = 0
while i < 50:
  i = i + 1
  sync()
  sync()
";
    let lines = told(text, 0);
    assert_eq!(&lines[..4], ["4", "5", "4", "5"]);
    assert_eq!(lines.len(), 101, "{lines:?}");
}

#[test]
fn every_node_is_told_also_those_that_take_no_time() {
    let text = "def job():
  $ LINE: (2, \"主任务\")
  n = 0
  while n < 2:
    $ LINE: (3, \"MoveJ\", \"after\")
    movej([0, -1.5, 1.5, 0, 0, 0])
    $ LINE: (4, \"set\")
    n = n + 1
    $ LINE: (5, \"wait\")
    sleep(0.1)
  end
  $ LINE: (6, \"done\")
  x = 1 / 0
end
";
    assert_eq!(
        told(text, 0),
        [
            "3:2 主任务",
            "6:2 主任务",
            "6:3 MoveJ",
            "8:4 set",
            "10:5 wait",
            "6:5 wait",
            "6:3 MoveJ",
            "8:4 set",
            "10:5 wait",
            "13:6 done",
        ]
    );
    let ran = run(&Standing::default(), text);
    assert_eq!(ran.error, "ZeroDivisionError: division by zero");
    assert!(
        ran.report.contains("\n  in node 6 done\n"),
        "{}",
        ran.report
    );
}

#[test]
fn a_thread_begins_in_the_node_that_started_it_and_an_error_in_it_names_its_own() {
    let text = "def work(n):
  sleep(0.1)
  $ LINE: (20, \"worker\")
  x = 1 / n
$ LINE: (2, \"main\")
start_thread(work, (0,))
$ LINE: (3, \"wait\")
sleep(1)
";
    assert_eq!(told(text, 1), ["2:2 main", "4:20 worker"]);
    let ran = run(&Standing::default(), text);
    assert!(
        ran.report.contains("\n  in node 20 worker\n"),
        "{}",
        ran.report
    );
}

#[test]
fn a_flood_of_nodes_is_bounded() {
    let text = "i = 0
while i < 3000:
  $ LINE: (1, 'a')
  i += 1
  $ LINE: (2, 'b')
  i += 1
$ LINE: (3, 'c')
sleep(0.1)
";
    let nodes = told(text, 0);
    assert!((64..=66).contains(&nodes.len()), "{}", nodes.len());
    assert_eq!(nodes.last().map(String::as_str), Some("8:3 c"));
}
