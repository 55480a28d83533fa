//! One page that looks on: frames and events out, orders in, over one WebSocket.
//!
//! What is read never waits for what is written: a page that takes nothing can still be stopped, and one that holds a
//! jog button and takes nothing loses its hold like one that is gone. Frames that find no room are left out.

use std::sync::Arc;
use std::time::Instant;

use axum::http::{HeaderMap, StatusCode, header};
use axum::response::Response;
use futures_util::future::BoxFuture;
use futures_util::stream::{FuturesUnordered, SplitSink, SplitStream};
use futures_util::{FutureExt as _, SinkExt as _, StreamExt as _};
use hyper::Request;
use hyper::body::Incoming;
use hyper::upgrade::{OnUpgrade, Upgraded};
use hyper_util::rt::TokioIo;
use messages::{Text, text};
use motion_api::{CommandId, Outcome};
use pendant::jog::HoldToRun;
use pendant::{HoldToRunState, PageId, PageOrder};
use serde_json::{Value, json};
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::mpsc;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::protocol::{Role, WebSocketConfig};
use tokio_tungstenite::tungstenite::{Error, Message};
use tokio_util::sync::CancellationToken;

use super::super::refusal;
use super::{Page, PageBackend};
use crate::ports::allowed_hosts::is_same_server;
use crate::ports::description::TaskStatus;
use crate::ports::escape::EscapedLine;
use crate::ports::http::refuse;
use crate::ports::websocket::Upgrade;

/// Path of the live view.
pub const LIVE_PATH: &str = "/api/v1/live";

/// Longest message of a page, bytes: a program and its name, with every character escaped.
const MESSAGE_BYTES_MAX: usize = 8 << 20;
/// Answers that wait for a page; one more ends the connection.
const ANSWERS_MAX: usize = 256;
/// Orders of one page that are being carried out.
const ORDERS_MAX: usize = 16;
/// Time between two looks at what is held.
const LOOK: std::time::Duration = std::time::Duration::from_millis(20);

type PageStream = WebSocketStream<TokioIo<Upgraded>>;

/// Answers the request for the live view: pages of this very server and programs may look.
pub fn shake_hands(request: Request<Incoming>, upgrade: &Upgrade) -> Response {
    if let Some(origin) = foreign_origin(request.headers()) {
        let text = text!(
            "the request comes from a page of {}; only pages of this server may look",
            "请求来自 {} 的页面；只有此服务器的页面可以查看",
            EscapedLine(&origin)
        );
        return refuse(StatusCode::FORBIDDEN, &text);
    }
    upgrade.shake_hands(request, &[])
}

/// The page that asks, if it is not of this server.
fn foreign_origin(headers: &HeaderMap) -> Option<String> {
    let text = |name| {
        let value = headers.get(name);
        value.map(|value: &header::HeaderValue| {
            String::from_utf8_lossy(value.as_bytes()).into_owned()
        })
    };
    let origin = text(header::ORIGIN)?;
    let host = text(header::HOST).unwrap_or_default();
    (!is_same_server(&origin, &host)).then_some(origin)
}

/// Serves one page until it leaves or the server ends.
pub async fn attend<C: PageBackend>(
    page: &Page<C>,
    upgrade: OnUpgrade,
    shutdown: &CancellationToken,
) {
    let stream = match upgrade.await {
        Ok(stream) => stream,
        Err(error) => {
            tracing::debug!(%error, "page: the connection broke in the handshake");
            return;
        }
    };
    let config = WebSocketConfig::default()
        .max_message_size(Some(MESSAGE_BYTES_MAX))
        .max_frame_size(Some(MESSAGE_BYTES_MAX))
        .read_buffer_size(16 * 1024)
        .write_buffer_size(0);
    let socket: PageStream =
        WebSocketStream::from_raw_socket(TokioIo::new(stream), Role::Server, Some(config)).await;
    let (sink, source) = socket.split();
    let (answers, waiting) = mpsc::channel(ANSWERS_MAX);
    let id = page.desk.lock().enter();
    let presence = page.stage.enter();
    let mut session = PageSession {
        page,
        id,
        answers,
        is_trusted: false,
        jogging: HoldToRunState::default(),
        answer_to: None,
    };
    session.greet();
    let ended = tokio::select! {
        () = shutdown.cancelled() => Ok(()),
        ended = write(page, sink, waiting) => ended,
        ended = session.listen(source) => ended,
    };
    session.leave();
    drop(presence);
    if let Err(error) = ended {
        tracing::debug!(%error, page = id.0, "page: the connection broke");
    }
}

/// Sends what the page is shown: answers first, then events, then the latest frame.
async fn write<C: PageBackend>(
    page: &Page<C>,
    mut sink: SplitSink<PageStream, Message>,
    mut answers: mpsc::Receiver<Arc<str>>,
) -> Result<(), Error> {
    let mut events = page.stage.events();
    let mut frames = page.stage.frames();
    let mut world = page.stage.world();
    // Whoever comes sees the world as it is, where there is one.
    if &**world.borrow() != "null" {
        world.mark_changed();
    }
    for (name, text) in ["panel", "registers"].into_iter().zip(page.stage.now()) {
        let event = format!(r#"{{"event":"{name}","{name}":{text}}}"#);
        sink.send(Message::text(event)).await?;
    }
    loop {
        tokio::select! {
            biased;
            answer = answers.recv() => match answer {
                Some(answer) => sink.send(Message::text(&*answer)).await?,
                None => return Ok(()),
            },
            event = events.recv() => match event {
                Ok(event) => sink.send(Message::text(&*event)).await?,
                Err(RecvError::Lagged(missed)) => {
                    let event = json!({"event": "missed", "events": missed});
                    sink.send(Message::text(event.to_string())).await?;
                }
                Err(RecvError::Closed) => return Ok(()),
            },
            changed = world.changed() => {
                if changed.is_err() {
                    return Ok(());
                }
                let event = format!(r#"{{"event":"world","world":{}}}"#, *world.borrow_and_update());
                sink.send(Message::text(event)).await?;
            },
            changed = frames.changed() => {
                if changed.is_err() {
                    return Ok(());
                }
                let frame = frames.borrow_and_update().to_vec();
                sink.send(Message::binary(frame)).await?;
            },
        }
    }
}

/// What a page may do and what it holds.
struct PageSession<'p, C> {
    page: &'p Page<C>,
    id: PageId,
    answers: mpsc::Sender<Arc<str>>,
    /// The page has shown the token.
    is_trusted: bool,
    jogging: HoldToRunState,
    /// The order whose answer comes when what is held has ended.
    answer_to: Option<u64>,
}

impl<C: PageBackend> PageSession<'_, C> {
    fn greet(&self) {
        let cockpit = &self.page.cockpit;
        let holder = self.page.desk.lock().holder();
        self.send(&json!({
            "event": "welcome",
            "version": 1,
            "you": self.id.0,
            "control": holder.map(|page| page.0),
            "read_only": cockpit.read_only(),
        }));
    }

    /// A page that asks for more than it reads is behind for good; it learns of the end of its connection.
    fn send(&self, message: &Value) {
        if self.answers.try_send(message.to_string().into()).is_err() {
            tracing::debug!(page = self.id.0, "page: an answer found no room");
        }
    }

    fn answer(&self, id: u64, result: Result<Value, Text>) {
        let message = match result {
            Ok(value) => json!({"answer": id, "ok": true, "value": value}),
            Err(reason) => {
                let mut refusal = refusal(&reason);
                refusal["answer"] = id.into();
                refusal["ok"] = false.into();
                refusal
            }
        };
        self.send(&message);
    }

    /// Does what the page says until it leaves.
    async fn listen(&mut self, mut source: SplitStream<PageStream>) -> Result<(), Error> {
        let mut orders: FuturesUnordered<BoxFuture<'_, (u64, Result<Value, Text>)>> =
            FuturesUnordered::new();
        let mut looks = tokio::time::interval(LOOK);
        looks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Skip);
        loop {
            let is_holding = self.jogging.held().is_some();
            let deadline = self.jogging.deadline();
            let expired = async {
                match deadline {
                    Some(deadline) => tokio::time::sleep_until(deadline.into()).await,
                    None => std::future::pending().await,
                }
            };
            tokio::select! {
                said = source.next() => match said {
                    None => return Ok(()),
                    Some(said) => match said? {
                        Message::Text(text) => {
                            let order = self.take(text.as_bytes());
                            if let Some((id, order)) = order {
                                if orders.len() >= ORDERS_MAX {
                                    let text = text!(
            "{ORDERS_MAX} orders of this page are being carried out already",
            "此页面已有 {ORDERS_MAX} 个命令正在执行");
                                    self.answer(id, Err(text));
                                } else {
                                    let cockpit = &self.page.cockpit;
                                    let carried = cockpit.order(order).map(move |result| (id, result));
                                    orders.push(carried.boxed());
                                }
                            }
                        }
                        Message::Binary(_) => self.send(&json!({"event": "mistake", "text": "orders are JSON texts"})),
                        Message::Close(_) => return Ok(()),
                        Message::Ping(_) | Message::Pong(_) | Message::Frame(_) => {}
                    },
                },
                Some((id, result)) = orders.next(), if !orders.is_empty() => self.answer(id, result),
                () = expired => self.release(Err(text!("the page gave no sign of life, so the arm was stopped",
                    "页面没有发出心跳，机械臂已停止"))),
                _ = looks.tick(), if is_holding => self.poll_held_motion(),
            }
        }
    }

    /// What a message asks for; an order that is not held is given back to be carried out.
    fn take(&mut self, text: &[u8]) -> Option<(u64, PageOrder)> {
        let request = match pendant::PageRequest::read(text) {
            Ok(request) => request,
            Err(error) => {
                // The number, if it can be found, so that the page knows which order it was.
                let id = serde_json::from_slice::<Value>(text).ok();
                let id = id.and_then(|value| value["id"].as_u64()).unwrap_or(0);
                self.answer(id, Err(Text::of(&error)));
                return None;
            }
        };
        let id = request.id;
        if let Some(token) = &request.token {
            self.is_trusted = self.page.token.is(token);
            if !self.is_trusted {
                self.answer(id, Err(Text::of(&pendant::ControlError::Token)));
                return None;
            }
        }
        if request.alive {
            self.jogging.alive(Instant::now());
        }
        if let Some(control) = request.control {
            let done = self.control(control);
            self.answer(id, done);
        }
        let Some(order) = request.order else {
            if request.token.is_some() && request.control.is_none() {
                self.answer(id, Ok(Value::Null));
            }
            return None;
        };
        if let Err(reason) = self.check(&order) {
            self.answer(id, Err(reason));
            return None;
        }
        match order {
            PageOrder::Jog { axis, frame, speed } => {
                self.hold(id, HoldToRun::Jog { axis, frame, speed })
            }
            PageOrder::MoveTo { joints, speed } => {
                match self.page.cockpit.check_joint_target(joints) {
                    Ok(joints) => self.hold(id, HoldToRun::MoveTo { joints, speed }),
                    Err(reason) => self.answer(id, Err(reason)),
                }
            }
            PageOrder::Freedrive => self.hold(id, HoldToRun::Freedrive),
            PageOrder::Release => {
                self.release(Ok(json!("released")));
                self.answer(id, Ok(Value::Null));
            }
            order => {
                if order == PageOrder::Stop {
                    self.release(Ok(json!("stopped")));
                }
                return Some((id, order));
            }
        }
        None
    }

    fn check(&self, order: &PageOrder) -> Result<(), Text> {
        if let Some(reason) = self.page.cockpit.read_only() {
            return Err(reason);
        }
        if !self.is_trusted {
            return Err(Text::of(&pendant::ControlError::Token));
        }
        if order.needs_control() {
            self.page
                .desk
                .lock()
                .check(self.id)
                .map_err(|error| Text::of(&error))?;
        }
        Ok(())
    }

    fn control(&mut self, takes: bool) -> Result<Value, Text> {
        if let Some(reason) = self.page.cockpit.read_only() {
            return Err(reason);
        }
        if !self.is_trusted {
            return Err(Text::of(&pendant::ControlError::Token));
        }
        if takes {
            let before = self.page.desk.lock().take(self.id);
            if let Some(before) = before {
                tracing::info!(page = self.id.0, before = before.0, "page: took control");
            }
        } else {
            self.release(Ok(json!("released")));
            self.page.desk.lock().leave(self.id);
        }
        self.page.tell_control();
        Ok(Value::Null)
    }

    /// Something is held from now on, instead of what was.
    fn hold(&mut self, id: u64, held: HoldToRun) {
        self.release(Ok(json!("released")));
        let cockpit = &self.page.cockpit;
        if cockpit.task_status() != TaskStatus::Stopped {
            let text = text!(
                "a program runs; stop it before the arm is moved by hand",
                "程序正在运行；手动移动机械臂前请先停止程序"
            );
            return self.answer(id, Err(text));
        }
        match cockpit.begin_hold(held.begin(&cockpit.state())) {
            Ok(command) => {
                self.jogging.begin(held, command, Instant::now());
                self.answer_to = Some(id);
            }
            Err(reason) => self.answer(id, Err(reason)),
        }
    }

    /// What is held ends; the order that began it is answered.
    fn release(&mut self, result: Result<Value, Text>) {
        let command = self.jogging.held().map(|(_, command)| command);
        let Some(end) = self.jogging.end() else {
            return;
        };
        self.page.cockpit.end_hold(end);
        self.settle(command, result);
    }

    fn settle(&mut self, command: Option<CommandId>, result: Result<Value, Text>) {
        if let Some(command) = command.filter(|id| *id != CommandId::NONE) {
            self.page.cockpit.forget(command);
        }
        if let Some(id) = self.answer_to.take() {
            self.answer(id, result);
        }
    }

    /// Looks whether what is held was refused, has ended, or must be given again; and whether the page still may.
    fn poll_held_motion(&mut self) {
        let Some((held, command)) = self.jogging.held() else {
            return;
        };
        let cockpit = &self.page.cockpit;
        if let Err(error) = self.page.desk.lock().check(self.id) {
            return self.release(Err(Text::of(&error)));
        }
        let outcome = cockpit.outcome(command);
        let (result, is_over) = match outcome {
            None => (Ok(Value::Null), false),
            // The speed is reached, and held.
            Some(Outcome::Done) => (Ok(json!("there")), held.ends_by_itself()),
            Some(Outcome::Refused(refusal)) => (Err(cockpit.sentence(&refusal)), true),
            Some(Outcome::Aborted) => (Ok(json!("stopped")), true),
            Some(Outcome::ProtectiveStop(reason)) => {
                let reason = cockpit.sentence(&reason);
                (
                    Err(text!("protective stop: {reason}", "保护性停止：{reason}")),
                    true,
                )
            }
        };
        if is_over {
            // Nothing is left to be ended.
            let _ = self.jogging.end();
            return self.settle(None, result);
        }
        if let Some(again) = held.again(&cockpit.state()) {
            match cockpit.begin_hold(again) {
                Ok(next) => {
                    cockpit.forget(command);
                    let deadline = self.jogging.deadline();
                    self.jogging.begin(held, next, Instant::now());
                    if let Some(last) =
                        deadline.and_then(|d| d.checked_sub(pendant::jog::SIGN_OF_LIFE))
                    {
                        // A command given again is no sign of life.
                        self.jogging.alive(last);
                    }
                }
                Err(reason) => self.release(Err(reason)),
            }
        }
    }

    /// The page is gone: what it held ends at once, and control is free.
    fn leave(&mut self) {
        self.release(Ok(json!("released")));
        let had = self.page.desk.lock().leave(self.id);
        if had {
            self.page.tell_control();
        }
    }
}
