//! What a program says while it is ahead of the arm is heard when the arm has caught up.

#![allow(clippy::unwrap_used, reason = "a test helper fails by panicking")]

use crate::common;

use common::{Ran, Standing, run};
use elite_runtime::TaskEnd;

/// Cycles from the call of a blended motion until its zone is entered.
const BLEND_CYCLES: u64 = 12;

fn run_ahead(text: &str) -> Ran {
    let standing = Standing {
        blend_cycles: BLEND_CYCLES,
        ..Standing::default()
    };
    run(&standing, text)
}

const BLENDED: &str = "movej([0, -1.5, 1.5, -1.5, -1.5, 0], a=2, v=0.5, r=0.05)";
const LAST: &str = "movej([0.1, -1.5, 1.5, -1.5, -1.5, 0], a=2, v=0.5)";

#[test]
fn messages_and_flags_wait_for_the_zone_and_the_program_does_not() {
    let ran = run_ahead(&format!(
        "
n = 0
def watch():
  global n
  while not get_flag(1):
    n = n + 1
    if n == 6:
      textmsg('six cycles')
    end
    sync()
  end
  print('seen after', n)
end
set_flag(1, False)
t = start_thread(watch)
{BLENDED}
set_flag(1, True)
textmsg('in the zone')
print('own', get_flag(1), n)
{LAST}
join_thread(t)
"
    ));
    assert_eq!(ran.end, TaskEnd::Finished, "{}", ran.error);
    assert_eq!(ran.log, ["six cycles", "in the zone"]);
    let lines: Vec<&str> = ran.printed.lines().collect();
    let [own, seen] = lines[..] else {
        panic!("{:?}", ran.printed);
    };
    // The program went on at once and reads its own flag.
    let own: Vec<&str> = own.split_whitespace().collect();
    assert_eq!(own[..2], ["own", "True"]);
    assert!(own[2].parse::<u64>().unwrap() <= 3, "{own:?}");
    let seen: u64 = seen.rsplit(' ').next().unwrap().parse().unwrap();
    assert!(
        (BLEND_CYCLES - 1..=BLEND_CYCLES + 4).contains(&seen),
        "{seen}"
    );
}

#[test]
fn the_order_of_messages_is_that_of_the_program() {
    let ran = run_ahead(&format!(
        "{BLENDED}\ntextmsg(1)\ntextmsg(2)\n{BLENDED}\ntextmsg(3)\n{LAST}\ntextmsg(4)\n"
    ));
    assert_eq!(ran.end, TaskEnd::Finished, "{}", ran.error);
    assert_eq!(ran.log, ["1", "2", "3", "4"]);
}

#[test]
fn more_messages_than_may_wait_are_all_shown() {
    let ran = run_ahead(&format!(
        "{BLENDED}\nfor i in range(40):\n  textmsg(i)\nend\n{LAST}\n"
    ));
    assert_eq!(ran.end, TaskEnd::Finished, "{}", ran.error);
    let expected: Vec<String> = (0..40).map(|i| i.to_string()).collect();
    assert_eq!(ran.log, expected);
}

#[test]
fn a_message_before_an_error_or_the_end_is_not_lost() {
    let ran = run_ahead(&format!("{BLENDED}\ntextmsg('x is 0')\n1 / 0\n"));
    assert_eq!(ran.end, TaskEnd::Failed);
    assert_eq!(ran.log, ["x is 0"]);
    let ran = run_ahead(&format!("{BLENDED}\ntextmsg('the end')\n"));
    assert_eq!(ran.end, TaskEnd::Finished, "{}", ran.error);
    assert_eq!(ran.log, ["the end"]);
}

#[test]
fn a_thread_that_is_stopped_on_the_way_says_nothing() {
    let ran = run_ahead(&format!(
        "
def moves():
  {BLENDED}
  textmsg('never reached')
  sleep(1)
end
t = start_thread(moves)
sleep(0.01)
stop_thread(t)
sleep(0.2)
textmsg('stopped')
"
    ));
    assert_eq!(ran.end, TaskEnd::Finished, "{}", ran.error);
    assert_eq!(ran.log, ["stopped"]);
}
