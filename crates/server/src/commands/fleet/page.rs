//! The page of a fleet: a table of all robots with a link to each pendant, logs, `/healthz` and `/metrics` of all.
//!
//! Owns the text of these pages, and how the robots are asked. Who may ask is decided as on every http port
//! (`ports::callers`).

use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::{Path, State as Shared};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use serde_json::{Value as Json, json};
use supervision::{ThreadRole, ThreadSupervisor};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::timeout;

use super::log::end_of;
use super::metrics::MergedMetrics;
use super::robot::{ProcessState, ProcessStatus, RobotProcess};
use crate::language::{pick, shown};

/// A robot has so long to answer.
const ANSWER_WITHIN: Duration = Duration::from_secs(1);
/// Longest answer of a robot, and end of a log that is shown, bytes.
const ANSWER_BYTES_MAX: u64 = 4 << 20;
const LOG_BYTES_MAX: u64 = 64 << 10;

/// All robots, for the pages.
pub(super) type Robots = Arc<Vec<Arc<RobotProcess>>>;

pub(super) fn router(robots: Robots) -> Router {
    Router::new()
        .route("/", get(table))
        .route("/healthz", get(health))
        .route("/metrics", get(metrics))
        .route("/logs/{robot}", get(log))
        .with_state(robots)
}

/// A robot with what it says of itself, in the order of the file.
async fn asked(
    robots: &Robots,
    page: &'static str,
) -> Vec<(Arc<RobotProcess>, ProcessStatus, Option<String>)> {
    let asked = |robot: &Arc<RobotProcess>| {
        let (robot, seen) = (robot.clone(), robot.seen());
        ThreadSupervisor::default().spawn(ThreadRole::Task, "question", async move {
            let bind = robot.plan().bind;
            let answer = match seen.ports.get("http") {
                Some(port) => ask(bind, *port, page).await,
                None => None,
            };
            (robot, seen, answer)
        })
    };
    // All at once: one that does not answer must not make the others wait.
    let under_way: Vec<_> = robots.iter().map(asked).collect();
    let mut all = Vec::new();
    for answer in under_way {
        if let Ok(Ok(answer)) = answer.await {
            all.push(answer);
        }
    }
    all
}

/// The body of a page of a robot, whatever its status; `None` when it does not answer.
async fn ask(ip: IpAddr, port: u16, page: &str) -> Option<String> {
    let address = SocketAddr::new(own(ip), port);
    let asking = async {
        let mut stream = TcpStream::connect(address).await.ok()?;
        let request =
            format!("GET {page} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n");
        stream.write_all(request.as_bytes()).await.ok()?;
        let mut answer = Vec::new();
        stream
            .take(ANSWER_BYTES_MAX)
            .read_to_end(&mut answer)
            .await
            .ok()?;
        let text = String::from_utf8(answer).ok()?;
        let (_, body) = text.split_once("\r\n\r\n")?;
        Some(body.to_owned())
    };
    timeout(ANSWER_WITHIN, asking).await.ok().flatten()
}

/// An address to ask a robot by that listens on all.
const fn own(ip: IpAddr) -> IpAddr {
    match ip {
        IpAddr::V4(ip) if ip.is_unspecified() => IpAddr::V4(std::net::Ipv4Addr::LOCALHOST),
        IpAddr::V6(ip) if ip.is_unspecified() => IpAddr::V6(std::net::Ipv6Addr::LOCALHOST),
        ip => ip,
    }
}

/// 200 while every robot is ready and its control cycle runs; 503 otherwise. Details as JSON.
async fn health(Shared(robots): Shared<Robots>) -> Response {
    let mut all = serde_json::Map::new();
    let mut is_well = true;
    for (robot, seen, answer) in asked(&robots, "/healthz").await {
        let own: Json = answer
            .and_then(|answer| serde_json::from_str(&answer).ok())
            .unwrap_or_default();
        let robot_is_well = seen.state == ProcessState::Ready && own["status"] == "ok";
        is_well &= robot_is_well;
        let plan = robot.plan();
        all.insert(
            plan.name.clone(),
            json!({
                "status": if robot_is_well { "ok" } else { "not well" },
                "state": seen.state.name(),
                "address": plan.bind.to_string(),
                "ports": seen.ports,
                "pid": seen.pid,
                "restarts": seen.restarts,
                "last_end": seen.last_end,
                "memory_bytes": seen.memory,
                "controller": own,
            }),
        );
    }
    let (code, status) = match is_well {
        true => (StatusCode::OK, "ok"),
        false => (StatusCode::SERVICE_UNAVAILABLE, "not well"),
    };
    let page = json!({"status": status, "robots": all});
    let kind = [(header::CONTENT_TYPE, "application/json")];
    (code, kind, format!("{page}\n")).into_response()
}

async fn metrics(Shared(robots): Shared<Robots>) -> Response {
    let mut merged = MergedMetrics::default();
    for (robot, seen, answer) in asked(&robots, "/metrics").await {
        let name = robot.plan().name;
        let up = u64::from(seen.state == ProcessState::Ready && answer.is_some());
        merged.sample(
            (
                "elite_fleet_robot_up",
                "gauge",
                "1 while the robot answers.",
            ),
            &name,
            up,
        );
        merged.sample(
            (
                "elite_fleet_robot_restarts_total",
                "counter",
                "How often the robot was started again without being asked.",
            ),
            &name,
            seen.restarts,
        );
        merged.sample(
            (
                "elite_fleet_robot_resident_bytes",
                "gauge",
                "Memory that the robot's process holds.",
            ),
            &name,
            seen.memory,
        );
        if let Some(page) = answer {
            merged.add(&name, &page);
        }
    }
    let kind = [(
        header::CONTENT_TYPE,
        crate::ports::http::metrics::CONTENT_TYPE,
    )];
    (kind, merged.text()).into_response()
}

async fn log(Shared(robots): Shared<Robots>, Path(name): Path<String>) -> Response {
    let Some(robot) = robots.iter().find(|robot| robot.plan().name == name) else {
        let none = pick("there is no robot of this name\n", "没有这个名称的机器人\n");
        return (StatusCode::NOT_FOUND, none).into_response();
    };
    let file = robot.plan().folder.join("robot.log");
    let kind = [
        (header::CONTENT_TYPE, "text/plain; charset=utf-8"),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    ];
    match end_of(&file, LOG_BYTES_MAX) {
        Ok(text) => (kind, text).into_response(),
        Err(error) => (StatusCode::NOT_FOUND, format!("{}\n", shown(&error))).into_response(),
    }
}

async fn table(Shared(robots): Shared<Robots>) -> Response {
    let mut rows = String::new();
    for (robot, seen, answer) in asked(&robots, "/healthz").await {
        let own: Json = answer
            .and_then(|answer| serde_json::from_str(&answer).ok())
            .unwrap_or_default();
        rows.push_str(&row(&robot, &seen, &own));
    }
    let (language, title) = (pick("en", "zh"), pick("Robots", "机器人"));
    let heads = pick(
        "<th>robot</th><th>state</th><th>task</th><th>cycle</th><th>memory</th><th>restarts</th><th>address</th>\
         <th>log</th>",
        "<th>机器人</th><th>状态</th><th>任务</th><th>周期</th><th>内存</th><th>重启</th><th>地址</th><th>日志</th>",
    );
    let (health, metrics) = (pick("health", "健康状况"), pick("metrics", "指标"));
    let page = format!(
        "<!doctype html><html lang=\"{language}\"><head><meta charset=\"utf-8\"><title>{title}</title>\
         <meta http-equiv=\"refresh\" content=\"2\">\
         <style>body{{font:16px system-ui,sans-serif;margin:2em}}table{{border-collapse:collapse}}\
         th,td{{padding:.4em 1em;text-align:left;border-bottom:1px solid #8884}}\
         .ready{{color:#080}}.waiting,.stopped,.bad{{color:#b00}}.starting{{color:#850}}\
         @media(prefers-color-scheme:dark){{body{{background:#111;color:#ddd}}a{{color:#8cf}}.ready{{color:#7d7}}\
         .waiting,.stopped,.bad{{color:#f88}}.starting{{color:#fc8}}}}</style></head><body><h1>{title}</h1>\
         <table><thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table>\
         <p><a href=\"/healthz\">{health}</a> · <a href=\"/metrics\">{metrics}</a></p></body></html>\n"
    );
    let heads = [
        (header::CONTENT_TYPE, "text/html; charset=utf-8"),
        (
            header::CONTENT_SECURITY_POLICY,
            "default-src 'none'; style-src 'unsafe-inline'",
        ),
    ];
    (heads, page).into_response()
}

fn row(robot: &RobotProcess, seen: &ProcessStatus, health: &Json) -> String {
    let plan = robot.plan();
    let (state, log) = (seen.state.name(), pick("log", "日志"));
    let word = shown(&state);
    let (name, bind) = (&plan.name, plan.bind);
    let pendant = match seen.ports.get("http") {
        Some(port) => {
            let address = SocketAddr::new(own(bind), *port);
            format!("<a href=\"http://{address}/\">{name}</a>")
        }
        None => name.clone(),
    };
    let doing = match (&seen.last_end, seen.state) {
        (Some(why), ProcessState::Waiting) => {
            format!(
                "{word}{}{}",
                pick(": ", "："),
                escaped(&shown(why).to_string())
            )
        }
        (_, ProcessState::Ready) if health["status"] != "ok" => {
            let why = match health["status"].as_str() {
                Some("stopped by a fault") => pick("stopped by a fault", "因故障停止"),
                Some("standing still") => pick("standing still", "控制周期停滞"),
                Some(other) => other,
                None => pick("no answer", "没有应答"),
            };
            format!("{word}{}{}", pick(", ", "，"), escaped(why))
        }
        _ => word.to_string(),
    };
    let class = match seen.state {
        ProcessState::Ready if health["status"] != "ok" => "bad",
        _ => state.english(),
    };
    format!(
        "<tr><td>{pendant}</td><td class=\"{class}\">{doing}</td><td>{}</td><td>{}</td><td>{} MB</td>\
         <td>{}</td><td>{bind}</td><td><a href=\"/logs/{name}\">{log}</a></td></tr>",
        match health["task"].as_str() {
            Some("running") => pick("running", "运行中").to_owned(),
            Some("paused") => pick("paused", "已暂停").to_owned(),
            Some("stopped") => pick("stopped", "已停止").to_owned(),
            other => escaped(other.unwrap_or("–")),
        },
        health["cycle"],
        seen.memory / 1_000_000,
        seen.restarts,
    )
}

/// Text of a page.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
