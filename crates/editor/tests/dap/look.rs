//! What a held program shows, and what can be changed in it.

use serde_json::json;

use crate::client::Client;

const PROGRAM: &str = "\
class Part:
    def __init__(self, name):
        self.name = name
        self.weight = 1.5

parts = [Part('a'), Part('b')]
many = list(range(100000))
ring = [1]
ring.append(ring)
table = {'k': [1, 2], 3: 'x'}

def outer(n):
    captured = n * 2
    def inner(m):
        local = m + captured
        return local
    result = inner(n)
    return result

print(outer(4))
";

#[test]
fn values_are_listed_a_page_at_a_time_and_circles_do_no_harm() {
    let mut client = Client::launched(PROGRAM, &[json!({"line": 16})], json!({}));
    let held = client.held();
    assert_eq!(held.function, "outer.<locals>.inner");
    let locals = client.scope(&held, "Locals");
    let names: Vec<_> = locals.iter().map(|v| v["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["m", "local", "captured"]);
    let globals = client.scope(&held, "Globals");
    let find = |name: &str| globals.iter().find(|v| v["name"] == name).unwrap().clone();
    let many = find("many");
    assert_eq!(many["indexedVariables"], 100_000);
    assert!(many["value"].as_str().unwrap().len() < 400);
    let page = client.ask(
        "variables",
        json!({"variablesReference": many["variablesReference"], "filter": "indexed", "start": 99_998, "count": 5}),
    );
    let page = page["variables"].as_array().unwrap().clone();
    assert_eq!(page.len(), 2);
    assert_eq!(page[1]["name"], "[99999]");
    let mut ring = find("ring");
    for _ in 0..5 {
        let inner = client.variables(&ring["variablesReference"]);
        assert_eq!(inner.len(), 2);
        ring = inner[1].clone();
    }
    let table = client.variables(&find("table")["variablesReference"]);
    assert_eq!(table[0]["evaluateName"], "table['k']");
    assert_eq!(table[1]["value"], "'x'");
    let parts = client.variables(&find("parts")["variablesReference"]);
    let part = client.variables(&parts[0]["variablesReference"]);
    assert_eq!(part[1]["name"], "weight");
    assert_eq!(part[1]["evaluateName"], "parts[0].weight");
    client.end();
}

#[test]
fn variables_are_set_where_that_can_be_done() {
    let mut client = Client::launched(PROGRAM, &[json!({"line": 16})], json!({}));
    let held = client.held();
    let scopes = client.ask("scopes", json!({"frameId": held.frame}));
    let locals = scopes["scopes"][0]["variablesReference"].clone();
    let globals = scopes["scopes"][1]["variablesReference"].clone();
    let set = |reference: &serde_json::Value, name: &str, value: &str| {
        json!({"variablesReference": reference,
        "name": name, "value": value})
    };
    let body = client.ask("setVariable", set(&locals, "local", "m * 1000"));
    assert_eq!(body["value"], "4000");
    client.ask("setVariable", set(&locals, "captured", "1"));
    assert_eq!(
        client.evaluate("captured + local", "watch").unwrap(),
        "4001"
    );
    client.ask("setVariable", set(&globals, "ring", "[7, 8]"));
    assert_eq!(client.evaluate("ring[1]", "watch").unwrap(), "8");
    client.ask(
        "setExpression",
        json!({"expression": "parts[0].name", "value": "'z'", "frameId": held.frame}),
    );
    assert_eq!(client.evaluate("parts[0].name", "hover").unwrap(), "'z'");
    let refused = client.try_ask("setVariable", set(&locals, "local", "1 / 0"));
    assert!(refused.unwrap_err().contains("ZeroDivisionError"));
    // A call that waits for this one: its captured variable was reached through `captured`, its plain ones are not
    // open.
    let stack = client.ask("stackTrace", json!({"threadId": 1}));
    let caller = stack["stackFrames"][1]["id"].clone();
    let refused = client.try_ask(
        "setExpression",
        json!({"expression": "n", "value": "5", "frameId": caller}),
    );
    assert!(refused.unwrap_err().contains("waits for another one"));
    assert_eq!(client.try_go("continue"), None);
    assert_eq!(client.outputs, ["4000\n"]);
    client.end();
}

#[test]
fn only_the_console_moves_the_arm() {
    let program = "x = 1\nsleep(0.1)\ny = 2\nprint(x, y)\n";
    let mut client = Client::launched(program, &[json!({"line": 3})], json!({}));
    let held = client.held();
    let movej = "movej([0.1, -1.57, 1.57, -1.57, -1.57, 0])";
    for context in ["watch", "hover", "variables"] {
        let refused = client.evaluate(movej, context);
        let told = refused.unwrap_err();
        assert!(
            told.contains("movej() waits; only the debug console"),
            "{context}: {told}"
        );
        let told = client.evaluate("speedj([0.1]*6, 1)", context).unwrap_err();
        assert!(told.contains("speedj() "), "{context}: {told}");
        assert!(told.contains("only the debug console"), "{context}: {told}");
    }
    let refused = client.evaluate("x = 5", "watch");
    assert!(refused.is_err());
    client.evaluate(movej, "repl").unwrap();
    let q = client
        .evaluate("get_actual_joint_positions()[0]", "watch")
        .unwrap();
    assert!((q.parse::<f64>().unwrap() - 0.1).abs() < 1e-3, "{q}");
    client.evaluate("x = 41; x += 1", "repl").unwrap();
    let after = client.go("next");
    assert!(after.cycle > held.cycle + 10);
    assert_eq!(client.all(&after), ["x=42", "y=2"]);
    // The way back leads through what was done in the console.
    let back = client.go("stepBack");
    assert_eq!((back.line, back.cycle), (3, after.cycle));
    assert_eq!(client.all(&back), ["x=42"]);
    let before = client.go("stepBack");
    assert_eq!(before.line, 2);
    assert_eq!(client.all(&before), ["x=1"]);
    client.end();
}

#[test]
fn threads_and_groups_of_variables_have_names_in_the_language_of_the_client() {
    let mut client = Client::launched(PROGRAM, &[json!({"line": 16})], json!({}));
    let held = client.held();
    let names = |client: &mut Client, locale: &str| -> Vec<String> {
        client.ask("initialize", json!({"adapterID": "test", "locale": locale}));
        let threads = client.ask("threads", json!({}));
        let scopes = client.ask("scopes", json!({"frameId": held.frame}));
        let rows = [&threads["threads"], &scopes["scopes"]].map(|rows| rows.as_array().unwrap());
        let rows = rows.into_iter().flatten();
        rows.map(|row| row["name"].as_str().unwrap().to_owned())
            .collect()
    };
    assert_eq!(
        names(&mut client, "en"),
        ["main program", "Locals", "Globals", "Arm"]
    );
    assert_eq!(
        names(&mut client, "zh-cn"),
        ["主程序", "局部变量", "全局变量", "手臂"]
    );
    client.end();
}
