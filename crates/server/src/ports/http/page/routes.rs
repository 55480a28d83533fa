//! The routes of `/api/v1` that are not live: what the arm is, programs, findings, the history, and orders of programs.

use std::sync::Arc;

use axum::Router;
use axum::body::Bytes;
use axum::extract::{Path, Request, State};
use axum::http::{HeaderMap, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use messages::text;
use pendant::editor_queries::{self, TextQuery};
use pendant::history::{EVENTS_GIVEN_MAX, EventQuery};
use pendant::orders::OrderBody;
use pendant::planned_path::PathQuery;
use pendant::programs::{self, SaveError};
use pendant::{ControlError, FRAME_BYTES, FRAME_VERSION};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::super::{BODY_TIMEOUT, answer, cross_site, refuse};
use super::{Page, PageBackend, files, planned, search};

/// Largest body of a request here, bytes: a program with every character escaped.
const BODY_BYTES_MAX: usize = 8 << 20;

/// Every route of the page.
pub fn router<C: PageBackend>(page: Arc<Page<C>>) -> Router {
    Router::new()
        .route("/api/v1", get(about::<C>))
        .route("/api/v1/session", get(session::<C>))
        .route("/api/v1/scene", get(scene::<C>))
        .route("/api/v1/meshes/{number}", get(mesh::<C>))
        .route("/api/v1/state", get(state::<C>))
        .route("/api/v1/debug", get(debug::<C>))
        .route("/api/v1/builtins", get(builtins))
        .route("/api/v1/builtins/{name}", get(describe))
        .route("/api/v1/tasks", get(tasks::<C>))
        .route("/api/v1/tasks/{*name}", get(open::<C>).put(save::<C>))
        .route("/api/v1/program", get(program::<C>))
        .route("/api/v1/check", post(check::<C>))
        .route("/api/v1/complete", post(complete::<C>))
        .route("/api/v1/hover", post(hover::<C>))
        .route("/api/v1/call", post(call::<C>))
        .route("/api/v1/reach", post(reach::<C>))
        .route("/api/v1/path", post(path::<C>))
        .route("/api/v1/orders", post(order::<C>))
        .route("/api/v1/history", get(history::<C>))
        .route("/api/v1/moment", get(moment::<C>))
        .route("/api/v1/events", get(events::<C>))
        .route("/api/v1/find", post(find::<C>))
        .with_state(page)
        .fallback(files::file)
}

type PageState<C> = State<Arc<Page<C>>>;

async fn about<C: PageBackend>(State(page): PageState<C>) -> Response {
    let mut about = page.cockpit.about();
    about["interface"] = json!("v1");
    about["frame"] = json!({"version": FRAME_VERSION, "bytes": FRAME_BYTES});
    about["read_only"] = json!(page.cockpit.read_only());
    answer(StatusCode::OK, &about)
}

/// The token, where it is given. A page of another server on this machine cannot read the answer.
async fn session<C: PageBackend>(State(page): PageState<C>, headers: HeaderMap) -> Response {
    // What a browser says of requests that a page of another site causes.
    let site = headers.get("sec-fetch-site").and_then(|v| v.to_str().ok());
    let is_own = site.is_none_or(|site| site == "same-origin" || site == "none");
    let is_given = page.token_is_public && is_own && page.cockpit.read_only().is_none();
    let token = is_given.then(|| page.token.reveal());
    let session = json!({
        "token": token,
        "asks_for_token": !page.token_is_public && page.cockpit.read_only().is_none(),
    });
    let mut response = answer(StatusCode::OK, &session);
    let never = header::HeaderValue::from_static("no-store");
    response.headers_mut().insert(header::CACHE_CONTROL, never);
    response
}

async fn scene<C: PageBackend>(State(page): PageState<C>) -> Response {
    answer(StatusCode::OK, &page.cockpit.scene())
}

/// A mesh of the scene by its number. A client that has it already is told so.
async fn mesh<C: PageBackend>(
    State(page): PageState<C>,
    Path(number): Path<String>,
    asked: HeaderMap,
) -> Response {
    let meshes = page.cockpit.meshes();
    let known = number.parse().ok().and_then(|number| meshes.get(number));
    let Some(mesh) = known else {
        return refuse(
            StatusCode::NOT_FOUND,
            &text!(
                "the scene has no mesh of this number",
                "场景中没有此编号的网格"
            ),
        );
    };
    let headers = [
        (header::ETAG, mesh.mark.as_str()),
        (header::CACHE_CONTROL, "no-cache"),
        (header::CONTENT_TYPE, "application/octet-stream"),
    ];
    let has_it = asked.get(header::IF_NONE_MATCH);
    match has_it.is_some_and(|has_it| has_it == mesh.mark.as_str()) {
        true => (StatusCode::NOT_MODIFIED, headers).into_response(),
        false => (headers, Bytes::from_owner(mesh.bytes.clone())).into_response(),
    }
}

/// What the arm is doing now, for programs that want no frames.
async fn state<C: PageBackend>(State(page): PageState<C>) -> Response {
    let cockpit = &page.cockpit;
    let state = cockpit.state();
    let holder = page.desk.lock().holder();
    answer(
        StatusCode::OK,
        &json!({
            "time": state.time,
            "cycle": state.cycle,
            "robot_mode": state.robot_mode.name(),
            "safety_mode": state.safety_mode.name(),
            "motion_mode": state.motion_mode.name(),
            "program_state": cockpit.task_status().name(),
            "speed": state.target_speed_fraction,
            "actual_q": state.actual_q.0,
            "actual_qd": state.actual_qd.0,
            "actual_tcp_pose": state.actual_tcp_pose.to_array(),
            "tcp_force": state.tcp_force,
            "control": holder.map(|page| page.0),
            "pages": page.stage.pages(),
            "panel": cockpit.panel(),
        }),
    )
}

/// Who debugs, and where the program is held. The same path is that of the debugger's channel.
async fn debug<C: PageBackend>(State(page): PageState<C>) -> Response {
    match page.cockpit.debuggers() {
        Some(hub) => answer(StatusCode::OK, &hub.shown()),
        None => refuse(
            StatusCode::SERVICE_UNAVAILABLE,
            &text!(
                "nothing runs here that could be debugged",
                "这里没有可调试的程序在运行"
            ),
        ),
    }
}

async fn builtins() -> Response {
    answer(StatusCode::OK, &programs::builtins())
}

async fn tasks<C: PageBackend>(State(page): PageState<C>) -> Response {
    let Some((_, root)) = page.cockpit.tasks() else {
        return answer(StatusCode::OK, &json!([]));
    };
    let rows = programs::list(root).into_iter();
    let rows: Value = rows
        .map(|(name, bytes)| json!({"name": name, "bytes": bytes}))
        .collect();
    answer(StatusCode::OK, &rows)
}

async fn open<C: PageBackend>(State(page): PageState<C>, Path(name): Path<String>) -> Response {
    let Some((folder, _)) = page.cockpit.tasks() else {
        return refuse(
            StatusCode::NOT_FOUND,
            &text!("a recording has no task folder", "记录没有任务文件夹"),
        );
    };
    match programs::open(folder, &name) {
        Ok(program) => answer(StatusCode::OK, &program),
        Err(error) => refuse(StatusCode::NOT_FOUND, &error),
    }
}

/// A program by its number; without one the newest.
async fn program<C: PageBackend>(State(page): PageState<C>, uri: Uri) -> Response {
    let newest = page.cockpit.program_number();
    let number = match number(&uri, "number", newest.into()) {
        Ok(number) => number as u32,
        Err(refused) => return *refused,
    };
    let shown = page.cockpit.program(number).map(
        |program| json!({"number": program.number, "name": program.name, "text": &*program.text}),
    );
    answer(StatusCode::OK, &shown.unwrap_or(Value::Null))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SaveRequest {
    text: String,
    /// The mark of the text that this one was made from; none for a new file.
    before: Option<String>,
}

async fn save<C: PageBackend>(
    State(page): PageState<C>,
    Path(name): Path<String>,
    request: Request,
) -> Response {
    if let Err(refused) = may_order(&page, request.headers()) {
        return *refused;
    }
    let saved: SaveRequest = match body(request).await {
        Ok(saved) => saved,
        Err(refused) => return refused,
    };
    let Some((_, root)) = page.cockpit.tasks() else {
        return refuse(
            StatusCode::NOT_FOUND,
            &text!("a recording has no task folder", "记录没有任务文件夹"),
        );
    };
    match programs::save(root, &name, &saved.text, saved.before.as_deref()) {
        Ok(etag) => answer(StatusCode::OK, &json!({"name": name, "etag": etag})),
        Err(error) => {
            let status = match error {
                SaveError::Changed { .. } => StatusCode::CONFLICT,
                SaveError::System { .. } => StatusCode::INTERNAL_SERVER_ERROR,
                _ => StatusCode::UNPROCESSABLE_ENTITY,
            };
            refuse(status, &error)
        }
    }
}

/// What the editor asks about a text, answered by `answers` on the compile pool.
async fn about_text<C: PageBackend>(
    page: &Page<C>,
    request: Request,
    answers: fn(&TextQuery) -> Value,
) -> Response {
    let question: TextQuery = match body(request).await {
        Ok(question) => question,
        Err(refused) => return refused,
    };
    if let Err(error) = question.check() {
        return refuse(StatusCode::UNPROCESSABLE_ENTITY, &error);
    }
    let Ok(_turn) = page.reading.acquire().await else {
        return refuse(
            StatusCode::SERVICE_UNAVAILABLE,
            &text!("the server is ending", "服务器正在结束"),
        );
    };
    let pool = page.cockpit.compile_pool();
    let reading = pool.run(question.text.len(), move || answers(&question));
    match reading.await {
        Ok(found) => answer(StatusCode::OK, &found),
        Err(trouble) => refuse(StatusCode::SERVICE_UNAVAILABLE, &trouble),
    }
}

async fn check<C: PageBackend>(State(page): PageState<C>, request: Request) -> Response {
    about_text(&page, request, editor_queries::findings).await
}

async fn complete<C: PageBackend>(State(page): PageState<C>, request: Request) -> Response {
    about_text(&page, request, editor_queries::completions).await
}

async fn hover<C: PageBackend>(State(page): PageState<C>, request: Request) -> Response {
    about_text(&page, request, editor_queries::about_place).await
}

async fn call<C: PageBackend>(State(page): PageState<C>, request: Request) -> Response {
    about_text(&page, request, editor_queries::call_around).await
}

/// The long text about a function.
async fn describe(Path(name): Path<String>, uri: Uri) -> Response {
    let query = uri.query().unwrap_or_default().split('&');
    let mut languages = query.filter_map(|part| part.strip_prefix("language="));
    let text = editor_queries::about_name(&name, languages.next().unwrap_or_default());
    match text.is_null() {
        true => refuse(
            StatusCode::NOT_FOUND,
            &text!("there is no function of this name", "没有这个名称的函数"),
        ),
        false => answer(StatusCode::OK, &json!({"name": name, "text": text})),
    }
}

/// Answers when a condition held in the recording.
async fn find<C: PageBackend>(State(page): PageState<C>, request: Request) -> Response {
    let question: search::SearchRequest = match body(request).await {
        Ok(question) => question,
        Err(refused) => return refused,
    };
    match search::find(&page, question).await {
        Ok(found) => answer(StatusCode::OK, &found),
        Err(reason) => refuse(StatusCode::UNPROCESSABLE_ENTITY, &reason),
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
enum ReachTarget {
    Pose([f64; 6]),
    Joints([f64; 6]),
}

/// Answers where the arm would stand after a move, which the page shows before it.
async fn reach<C: PageBackend>(State(page): PageState<C>, request: Request) -> Response {
    let place: ReachTarget = match body(request).await {
        Ok(place) => place,
        Err(refused) => return refused,
    };
    let cockpit = &page.cockpit;
    let found = match place {
        ReachTarget::Pose(pose) => cockpit
            .reach(pose)
            .and_then(|joints| cockpit.check_joint_target(joints)),
        ReachTarget::Joints(joints) => cockpit.check_joint_target(joints),
    };
    match found {
        Ok(joints) => answer(StatusCode::OK, &json!({"joints": joints})),
        Err(reason) => refuse(StatusCode::UNPROCESSABLE_ENTITY, &reason),
    }
}

/// Answers which path a program would drive. It is run, if only beside the robot, so that takes the token.
async fn path<C: PageBackend>(State(page): PageState<C>, request: Request) -> Response {
    if let Err(refused) = may_order(&page, request.headers()) {
        return *refused;
    }
    let question: PathQuery = match body(request).await {
        Ok(question) => question,
        Err(refused) => return refused,
    };
    match planned::path(&page, question).await {
        Ok(found) => answer(StatusCode::OK, &found),
        Err(reason) => refuse(StatusCode::UNPROCESSABLE_ENTITY, &reason),
    }
}

/// One order of a program, while no page has control.
async fn order<C: PageBackend>(State(page): PageState<C>, request: Request) -> Response {
    if let Err(refused) = may_order(&page, request.headers()) {
        return *refused;
    }
    let order = match body(request).await {
        Ok(OrderBody(Some(order))) => order,
        Ok(OrderBody(None)) => {
            return refuse(
                StatusCode::UNPROCESSABLE_ENTITY,
                &text!("there is no order", "没有命令"),
            );
        }
        Err(refused) => return refused,
    };
    if let Err(error) = order.check() {
        return refuse(StatusCode::UNPROCESSABLE_ENTITY, &error);
    }
    if order.is_held() {
        let text = text!(
            "what is held needs signs of life: give this order over /api/v1/live",
            "按住的动作需要心跳：请通过 /api/v1/live 发出此命令"
        );
        return refuse(StatusCode::UNPROCESSABLE_ENTITY, &text);
    }
    if order.needs_control()
        && let Err(error) = page.desk.lock().check_visitor()
    {
        return refuse(StatusCode::CONFLICT, &error);
    }
    match page.cockpit.order(order).await {
        Ok(value) => answer(StatusCode::OK, &json!({"ok": true, "value": value})),
        Err(reason) => refuse(StatusCode::CONFLICT, &reason),
    }
}

/// Whether a request may change something: not from a foreign page, and with the token.
fn may_order<C: PageBackend>(page: &Page<C>, headers: &HeaderMap) -> Result<(), Box<Response>> {
    if let Some(reason) = page.cockpit.read_only() {
        return Err(refuse(StatusCode::CONFLICT, &reason).into());
    }
    let given = headers
        .get(header::AUTHORIZATION)
        .and_then(|v| v.to_str().ok());
    let given = given.and_then(|value| value.strip_prefix("Bearer "));
    match given.is_some_and(|given| page.token.is(given.trim())) {
        true => Ok(()),
        false => Err(refuse(StatusCode::UNAUTHORIZED, &ControlError::Token).into()),
    }
}

/// The body of a request that no foreign page can have sent, as JSON of one form.
async fn body<T: DeserializeOwned>(request: Request) -> Result<T, Response> {
    let (head, body) = request.into_parts();
    if let Err(turned_away) = cross_site::check(&head.headers) {
        return Err(refuse(turned_away.status(), &turned_away));
    }
    let read = axum::body::to_bytes(body, BODY_BYTES_MAX);
    let bytes = match tokio::time::timeout(BODY_TIMEOUT, read).await {
        Ok(Ok(bytes)) => bytes,
        Ok(Err(_too_long_or_broken)) => {
            let text = text!(
                "the body is cut off or longer than {BODY_BYTES_MAX} bytes",
                "正文不完整或超过 {BODY_BYTES_MAX} 字节"
            );
            return Err(refuse(StatusCode::PAYLOAD_TOO_LARGE, &text));
        }
        Err(_elapsed) => {
            let secs = BODY_TIMEOUT.as_secs();
            let text = text!(
                "the body was not complete after {secs} s",
                "{secs} s 后正文仍不完整"
            );
            return Err(refuse(StatusCode::REQUEST_TIMEOUT, &text));
        }
    };
    serde_json::from_slice(&bytes).map_err(|error| {
        let text = text!("the body does not fit: {error}", "正文不符：{error}");
        refuse(StatusCode::UNPROCESSABLE_ENTITY, &text)
    })
}

/// A number of the query, and where it is missing another.
fn number(uri: &Uri, name: &str, otherwise: f64) -> Result<f64, Box<Response>> {
    let query = uri.query().unwrap_or_default().split('&');
    let mut values = query.filter_map(|part| part.split_once('=').filter(|(n, _)| *n == name));
    let Some((_, text)) = values.next() else {
        return Ok(otherwise);
    };
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => {
            let text = text!("{name} must be a number", "{name} 必须是数");
            Err(refuse(StatusCode::UNPROCESSABLE_ENTITY, &text).into())
        }
    }
}

/// Frames of a span of time, one behind the other; the span that there is, in headers.
async fn history<C: PageBackend>(State(page): PageState<C>, uri: Uri) -> Response {
    let asked = || -> Result<_, Box<Response>> {
        Ok((
            number(&uri, "from", f64::MIN)?,
            number(&uri, "to", f64::MAX)?,
            number(&uri, "points", 1000.0)?,
        ))
    };
    let (from, to, points) = match asked() {
        Ok(asked) => asked,
        Err(refused) => return *refused,
    };
    let history = page.stage.history().lock();
    let frames = history.frames(from, to, points.max(1.0) as usize);
    let (first, last) = history.span().unwrap_or((0.0, 0.0));
    let whole = history.is_whole();
    drop(history);
    let headers = [
        ("content-type", "application/octet-stream".to_owned()),
        ("cache-control", "no-store".to_owned()),
        ("x-first-time", first.to_string()),
        ("x-last-time", last.to_string()),
        ("x-complete", whole.to_string()),
    ];
    (headers, frames).into_response()
}

/// One moment: its frame, and what was there beside it.
async fn moment<C: PageBackend>(State(page): PageState<C>, uri: Uri) -> Response {
    let time = match number(&uri, "time", f64::MAX) {
        Ok(time) => time,
        Err(refused) => return *refused,
    };
    let history = page.stage.history().lock();
    let frame = history.frame_at(time).map(|frame| STANDARD.encode(frame));
    let mut moment = history.beside(time);
    drop(history);
    moment["frame"] = json!(frame);
    answer(StatusCode::OK, &moment)
}

/// What happened in a span of time.
async fn events<C: PageBackend>(State(page): PageState<C>, uri: Uri) -> Response {
    let asked = || -> Result<_, Box<Response>> {
        Ok(EventQuery {
            from: number(&uri, "from", f64::MIN)?,
            to: number(&uri, "to", f64::MAX)?,
            level: number(&uri, "level", 0.0)? as u8,
            most: number(&uri, "most", EVENTS_GIVEN_MAX as f64)? as usize,
            first: number(&uri, "first", 0.0)? != 0.0,
        })
    };
    let wanted = match asked() {
        Ok(wanted) => wanted,
        Err(refused) => return *refused,
    };
    let text = page.stage.history().lock().events(wanted);
    let kind = [(header::CONTENT_TYPE, "application/json")];
    (kind, text).into_response()
}
