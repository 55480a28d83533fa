//! Going back: a walk in both directions meets what a walk forwards has met.

use std::collections::BTreeMap;

use serde_json::json;

use crate::client::{Client, Suspension};

const PROGRAM: &str = "\
import random

def leg(n):
    seen = []
    for k in range(n):
        if k % 2:
            seen.append(random.randint(0, 9))
        elif k > 2:
            sleep(0.012)
    return seen

def ticker():
    global ticks
    while ticks < 40:
        ticks += 1
        sleep(0.02)

def squares(n):
    for i in range(n):
        yield i * i

ticks = 0
t = start_thread(ticker, ())
log = []
i = 0
while i < 4:
    log += leg(i + 2)
    movej([0.05 * i, -1.57, 1.57, -1.57, -1.57, 0], a=5, v=2)
    i += 1
try:
    for s in squares(3):
        log.append(s)
    print('log', log)
    1 / 0
except ZeroDivisionError as error:
    log.append(str(error))
finally:
    i = -1
print('end', log, ticks)
";

/// What a place in a run shows, but for why it was held.
type StopView = (i64, i64, String, usize, u64, u64, Vec<String>);

fn seen(client: &mut Client, held: &Suspension) -> StopView {
    let all = client.all(held);
    let place = (held.line, held.column, held.function.clone(), held.depth);
    (
        place.0,
        place.1,
        place.2,
        place.3,
        held.statement,
        held.cycle,
        all,
    )
}

/// Numbers that follow from a seed (SplitMix64).
struct Dice(u64);

impl Dice {
    fn roll(&mut self, sides: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) % sides
    }
}

#[test]
fn random_walks_both_ways_meet_the_trace_of_a_walk_forwards() {
    let mut client = Client::launched(PROGRAM, &[], json!({"stopOnEntry": true}));
    let mut trace: BTreeMap<u64, StopView> = BTreeMap::new();
    let mut order = Vec::new();
    let mut held = client.held();
    loop {
        let place = seen(&mut client, &held);
        order.push(held.statement);
        trace.insert(held.statement, place);
        match client.try_go("stepIn") {
            Some(next) => held = next,
            None => break,
        }
    }
    let said = client.outputs.concat();
    client.end();
    assert!(trace.len() > 60, "{}", trace.len());
    for seed in 1..=3 {
        let mut dice = Dice(seed);
        let mut client = Client::launched(PROGRAM, &[], json!({"stopOnEntry": true}));
        client.held();
        let mut has_ended = false;
        for step in 0..40 {
            let command = match dice.roll(5) {
                0 => "stepBack",
                1 => "next",
                2 => "stepOut",
                3 if step % 7 == 0 => "reverseContinue",
                _ => "stepIn",
            };
            let Some(held) = client.try_go(command) else {
                has_ended = true;
                break;
            };
            if held.thread != 1 {
                continue;
            }
            let place = seen(&mut client, &held);
            let known = trace.get(&held.statement);
            assert_eq!(known, Some(&place), "seed {seed}, step {step}, {command}");
            if command == "stepBack" && held.reason == "step" {
                // `next` leads back to where it was, or into a call that was stepped over.
                let index = order.iter().position(|tick| *tick == held.statement);
                assert!(index.is_some());
            }
        }
        client.set_breakpoints(&[]);
        client.ask("setExceptionBreakpoints", json!({"filters": []}));
        while !has_ended && client.try_go("continue").is_some() {}
        // Whatever the way was, everything was said once.
        assert_eq!(client.outputs.concat(), said, "seed {seed}");
        client.end();
    }
}

#[test]
fn the_last_breakpoint_and_the_last_moment_of_a_condition_are_found() {
    let program = "\
for i in range(5):
    movej([0.1 * i, -1.57, 1.57, -1.57, -1.57, 0], a=5, v=2)
done = True
";
    let mut client = Client::launched(program, &[json!({"line": 3})], json!({}));
    let end = client.held();
    client.set_breakpoints(&[json!({"line": 2, "condition": "i in (1, 3)"})]);
    let held = client.go("reverseContinue");
    assert_eq!((held.reason.as_str(), held.line), ("breakpoint", 2));
    assert_eq!(client.all(&held), ["i=3"]);
    assert_eq!(client.go("reverseContinue").line, 2);
    assert_eq!(client.evaluate("i", "hover").unwrap(), "1");
    assert_eq!(client.go("reverseContinue").reason, "entry");
    client.set_breakpoints(&[]);
    let info = client.ask("dataBreakpointInfo", json!({"name": "actual_q[0] > 0.25"}));
    let refused = client.ask("dataBreakpointInfo", json!({"name": "nothing[0] > 0.25"}));
    assert!(refused["dataId"].is_null());
    let data = json!({"breakpoints": [{"dataId": info["dataId"]}, {"dataId": "nothing"}]});
    let bound = client.ask("setDataBreakpoints", data);
    assert_eq!(bound["breakpoints"][0]["verified"], true);
    assert_eq!(bound["breakpoints"][1]["verified"], false);
    let forwards = client.go("continue");
    assert_eq!(forwards.reason, "data breakpoint");
    let q = client
        .evaluate("get_actual_joint_positions()[0]", "watch")
        .unwrap();
    let q: f64 = q.parse().unwrap();
    assert!((0.25..0.27).contains(&q), "{q}");
    client.ask("gotoCycle", json!({"cycle": end.cycle - 1}));
    assert_eq!(client.held().cycle, end.cycle - 1);
    let backwards = client.go("reverseContinue");
    assert_eq!(
        (backwards.reason.as_str(), backwards.cycle),
        ("data breakpoint", forwards.cycle)
    );
    client.end();
}

#[test]
fn an_uncaught_exception_is_shown_where_it_was_raised_and_walked_back_from() {
    let program = "\
def divide(a, b):
    print('dividing')
    return a / b

x = 1
sleep(0.1)
divide(x, 0)
";
    let mut client = Client::launched(program, &[], json!({}));
    let held = client.held();
    assert_eq!((held.reason.as_str(), held.line), ("exception", 3));
    assert!(held.text.contains("division by zero"), "{}", held.text);
    assert_eq!(client.evaluate("b", "hover").unwrap(), "0");
    assert_eq!(client.go("stepBack").line, 3);
    assert_eq!(client.go("stepBack").line, 2);
    assert_eq!(client.go("stepBack").line, 7);
    assert_eq!(client.go("stepBack").line, 6);
    let held = client.go("continue");
    assert_eq!((held.reason.as_str(), held.line), ("exception", 3));
    assert_eq!(client.try_go("continue"), None);
    assert_eq!(client.event("exited")["exitCode"], 1);
    let dividing = client
        .outputs
        .iter()
        .filter(|text| text.contains("dividing"));
    assert_eq!(dividing.count(), 1);
    client.end();
}

#[test]
fn a_protective_stop_and_the_end_of_a_program_can_be_walked_back_from() {
    let program = "a = 1\nspeedj([50, 0, 0, 0, 0, 0], 1000, 5)\nsleep(5)\nb = 2\n";
    let mut client = Client::launched(program, &[], json!({"stopAtEnd": true}));
    let held = client.held();
    let safety = client.scope(&held, "Arm");
    let safety = safety.iter().find(|v| v["name"] == "safety_mode").unwrap();
    println!("{held:?} {safety}");
    let back = client.go("stepBack");
    assert!(back.cycle <= held.cycle);
    let start = client.go("reverseContinue");
    assert_eq!((start.reason.as_str(), start.line), ("entry", 1));
    client.end();
}

#[test]
fn the_end_of_a_program_is_stepped_back_from() {
    let program = "def f():\n    return 1\na = f()\nsleep(0.1)\nb = 2\n";
    let mut client = Client::launched(program, &[], json!({"stopAtEnd": true}));
    client.held();
    let lines: Vec<i64> = (0..4).map(|_| client.go("stepBack").line).collect();
    assert_eq!(lines, [5, 4, 3, 1]);
    client.end();
}

#[test]
fn a_call_is_begun_again_and_so_is_the_program() {
    let program = "def f(n):\n    m = n\n    m += 1\n    return m\nprint(f(3))\n";
    let mut client = Client::launched(program, &[json!({"line": 4})], json!({}));
    let held = client.held();
    client.ask("restartFrame", json!({"frameId": held.frame}));
    let again = client.held();
    assert_eq!((again.reason.as_str(), again.line), ("restart", 2));
    assert_eq!(client.go("continue").line, 4);
    client.ask("restart", json!({}));
    assert_eq!(client.held().line, 4);
    assert_eq!(client.try_go("continue"), None);
    client.end();
}
