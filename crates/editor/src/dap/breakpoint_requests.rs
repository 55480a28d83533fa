//! What the client wants the program to be held for, taken over from its requests.

use std::path::PathBuf;
use std::sync::Arc;

use messages::{Text, text};
use serde_json::{Value as Json, json};

use super::bodies::{
    BoundBreakpoint, BreakpointEvent, BreakpointsResponse, DataBreakpointInfo, LocationsResponse,
    SourcePlace, body_of,
};
use super::breakpoints::{
    BREAKPOINTS_MAX, BreakpointRequest, DataBreakpoint, FunctionBreakpoint, bind, condition_of_arm,
    same_path,
};
use super::session::{DapSession, WantedSource};

impl DapSession<'_> {
    fn next_id(&mut self) -> u64 {
        self.last_id += 1;
        self.last_id
    }

    /// A breakpoint that is not in force, and why.
    fn refused(&self, id: u64, why: &Text) -> BoundBreakpoint {
        BoundBreakpoint::refused(Some(id), why.in_language(self.language))
    }

    fn list(&self, arguments: &Json, key: &str) -> Result<Vec<BreakpointRequest>, Text> {
        let list = arguments.get(key).cloned().unwrap_or(json!([]));
        let wanted: Vec<BreakpointRequest> = serde_json::from_value(list)
            .map_err(|error| text!("{key}: {error}", "{key}：{error}"))?;
        if wanted.len() > BREAKPOINTS_MAX {
            let given = wanted.len();
            return Err(text!(
                "{given} breakpoints at once, {BREAKPOINTS_MAX} are allowed",
                "一次给出 {given} 个断点，最多允许 {BREAKPOINTS_MAX} 个"
            ));
        }
        Ok(wanted)
    }

    pub(super) fn changed(&mut self) {
        self.last_met = None;
        // The program of a server is held for what its driver wants, whoever else looks on.
        if let Some(attachment) = &self.attachment {
            if attachment.drives() {
                let breakpoints = Arc::new(self.breakpoints.clone());
                attachment.hub.set_breakpoints(breakpoints);
            }
            return;
        }
        let is_free = self.launched.as_ref().is_some_and(|l| l.is_free);
        if let Some(run) = self.run.as_ref().filter(|_| !is_free) {
            run.set_breakpoints(Arc::new(self.breakpoints.clone()));
        }
    }

    /// `setBreakpoints`: all those of one text.
    pub(super) fn set_source_breakpoints(&mut self, arguments: &Json) -> Result<Json, Text> {
        let path = arguments.pointer("/source/path").and_then(Json::as_str);
        let path = path.map_or_else(Default::default, |path| same_path(path.as_ref()));
        let wanted = self.list(arguments, "breakpoints")?;
        self.wanted_sources.retain(|wanted| wanted.path != path);
        let is_known = self.is_program(&path) || path.as_os_str().is_empty();
        if self.launched.is_none() || self.attachment.is_some() && !is_known {
            // Bound when the program is known.
            let pending = |_: &BreakpointRequest| {
                BoundBreakpoint::refused(Some(self.next_id()), "no such program runs yet")
            };
            let pending: Vec<_> = wanted.iter().map(pending).collect();
            self.want_source(path, arguments, &pending);
            return Ok(response(pending));
        }
        if !is_known {
            let refused = |_: &BreakpointRequest| {
                BoundBreakpoint::refused(None, "this text is not the program that runs")
            };
            let refused: Vec<_> = wanted.iter().map(refused).collect();
            self.want_source(path, arguments, &refused);
            return Ok(response(refused));
        }
        let bound = self.bind_all(&wanted, &[]);
        // Bound once more when the run begins: by the numbers that the client knows.
        self.want_source(path, arguments, &bound);
        self.changed();
        Ok(response(bound))
    }

    fn want_source(&mut self, path: PathBuf, arguments: &Json, bound: &[BoundBreakpoint]) {
        self.wanted_sources.push(WantedSource {
            path,
            arguments: arguments.clone(),
            ids: bound.iter().map(|breakpoint| breakpoint.id).collect(),
        });
    }

    /// Binds breakpoints to statements; those that have numbers already keep them.
    fn bind_all(
        &mut self,
        wanted: &[BreakpointRequest],
        ids: &[Option<u64>],
    ) -> Vec<BoundBreakpoint> {
        let Some(launched) = &self.launched else {
            return Vec::new();
        };
        let places = launched.places.clone();
        self.breakpoints.places.clear();
        let mut bound = Vec::new();
        for (index, breakpoint) in wanted.iter().enumerate() {
            let id = match ids.get(index).copied().flatten() {
                Some(id) => id,
                None => self.next_id(),
            };
            let line = i64::from(breakpoint.line) + 1 - self.first_line;
            let column = breakpoint
                .column
                .map(|column| i64::from(column) + 1 - self.first_column);
            let line = u32::try_from(line).unwrap_or(0);
            let column = column.and_then(|column| u32::try_from(column).ok());
            let place = bind(&places, line, column);
            let made = breakpoint.breakpoint(id);
            bound.push(match (place, made) {
                (Some(place), Ok(made)) => {
                    let key = (place.line, place.column);
                    self.breakpoints.places.entry(key).or_default().push(made);
                    BoundBreakpoint::at(id, self.place_of_client(place.line, place.column))
                }
                (None, _) => self.refused(
                    id,
                    &text!("no statement begins here or below", "该处及其后没有语句"),
                ),
                (_, Err(error)) => self.refused(id, &error),
            });
        }
        bound
    }

    /// A place as the client counts.
    fn place_of_client(&self, line: u32, column: u32) -> SourcePlace {
        SourcePlace {
            line: i64::from(line) - 1 + self.first_line,
            column: i64::from(column) - 1 + self.first_column,
        }
    }

    /// The program is known now: breakpoints that came before it are bound, and the client is told where.
    pub(super) fn bind_sources(&mut self) {
        let mut wanted = self.wanted_sources.iter();
        let own = wanted.find(|wanted| self.is_program(&wanted.path));
        let Some(WantedSource { arguments, ids, .. }) = own.cloned() else {
            return;
        };
        let Ok(wanted) = self.list(&arguments, "breakpoints") else {
            return;
        };
        let bound = self.bind_all(&wanted, &ids);
        for breakpoint in bound {
            let reason = "changed";
            let event = BreakpointEvent { reason, breakpoint };
            self.event("breakpoint", body_of(&event));
        }
        self.changed();
    }

    /// `setFunctionBreakpoints`
    pub(super) fn set_function_breakpoints(&mut self, arguments: &Json) -> Result<Json, Text> {
        let wanted = self.list(arguments, "breakpoints")?;
        self.breakpoints.functions.clear();
        let mut bound = Vec::new();
        for breakpoint in wanted {
            let id = self.next_id();
            let name = breakpoint.name.trim().to_owned();
            bound.push(match breakpoint.breakpoint(id) {
                Ok(_) if name.is_empty() => {
                    let empty = text!(
                        "name is empty; allowed is the name of a function, with or without that of its class",
                        "name 为空；应为函数名，可带类名"
                    );
                    self.refused(id, &empty)
                }
                Ok(at) => {
                    self.breakpoints
                        .functions
                        .push(FunctionBreakpoint { name, at });
                    BoundBreakpoint::verified(id)
                }
                Err(error) => self.refused(id, &error),
            });
        }
        self.changed();
        Ok(response(bound))
    }

    /// `setExceptionBreakpoints`
    pub(super) fn set_exception_breakpoints(&mut self, arguments: &Json) -> Result<Json, Text> {
        let filters = arguments.get("filters").and_then(Json::as_array);
        let filters: Vec<&str> = filters
            .into_iter()
            .flatten()
            .filter_map(Json::as_str)
            .collect();
        let known = ["caught", "uncaught"];
        if let Some(other) = filters.iter().find(|filter| !known.contains(filter)) {
            return Err(text!(
                "there is no filter {other:?}; there are caught and uncaught",
                "没有过滤器 {other:?}；有 caught 和 uncaught"
            ));
        }
        self.breakpoints.caught = filters.contains(&"caught");
        self.breakpoints.uncaught = filters.contains(&"uncaught");
        self.changed();
        Ok(json!({}))
    }

    /// `dataBreakpointInfo`: the text that was asked for is a condition of the arm, or the name of one of its values.
    pub(super) fn data_breakpoint_info(&self, arguments: &Json) -> Json {
        let name = arguments
            .get("name")
            .and_then(Json::as_str)
            .unwrap_or_default();
        let info = match condition_of_arm(name) {
            Ok(()) => DataBreakpointInfo {
                data_id: Some(name.to_owned()),
                description: name.to_owned(),
                access_types: vec!["write"],
                can_persist: Some(true),
            },
            Err(error) => DataBreakpointInfo {
                description: error.in_language(self.language).to_owned(),
                ..DataBreakpointInfo::default()
            },
        };
        body_of(&info)
    }

    /// `setDataBreakpoints`: the condition is that of the breakpoint, or what it is on.
    pub(super) fn set_data_breakpoints(&mut self, arguments: &Json) -> Result<Json, Text> {
        let wanted = self.list(arguments, "breakpoints")?;
        self.breakpoints.data.clear();
        let mut bound = Vec::new();
        for breakpoint in wanted {
            let id = self.next_id();
            let condition = breakpoint
                .condition
                .clone()
                .filter(|text| !text.trim().is_empty())
                .unwrap_or_else(|| breakpoint.data_id.clone());
            let known = condition_of_arm(&condition);
            let hits = breakpoint.hits();
            bound.push(match (known, hits) {
                (Ok(()), Ok(hits)) => {
                    self.breakpoints.data.push(DataBreakpoint {
                        id,
                        condition,
                        hits,
                    });
                    BoundBreakpoint::verified(id)
                }
                (Err(error), _) | (_, Err(error)) => self.refused(id, &error),
            });
        }
        self.changed();
        Ok(response(bound))
    }

    /// `breakpointLocations`
    pub(super) fn breakpoint_locations(&self, arguments: &Json) -> Result<Json, Text> {
        let launched = self
            .launched
            .as_ref()
            .ok_or(text!("no program was launched", "没有启动程序"))?;
        let path = arguments.pointer("/source/path").and_then(Json::as_str);
        if path.is_some_and(|path| !self.is_program(&same_path(path.as_ref()))) {
            return Err(text!(
                "source is not the program that runs",
                "source 不是正在运行的程序"
            ));
        }
        let number = |key: &str| {
            let number = arguments.get(key).and_then(Json::as_i64)?;
            u32::try_from(number + 1 - self.first_line).ok()
        };
        let from = number("line").unwrap_or(1);
        let to = number("endLine").unwrap_or(from);
        let within = launched
            .places
            .iter()
            .filter(|place| (from..=to).contains(&place.line));
        let places = within.map(|place| self.place_of_client(place.line, place.column));
        let breakpoints = places.collect();
        Ok(body_of(&LocationsResponse { breakpoints }))
    }
}

fn response(breakpoints: Vec<BoundBreakpoint>) -> Json {
    body_of(&BreakpointsResponse { breakpoints })
}
