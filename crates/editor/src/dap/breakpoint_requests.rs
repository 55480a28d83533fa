//! What the client wants the program to be held for, taken over from its requests.

use std::sync::Arc;

use serde_json::{Value as Json, json};

use super::breakpoints::{
    BREAKPOINTS_MAX, BreakpointRequest, DataBreakpoint, FunctionBreakpoint, bind, condition_of_arm,
    same_path,
};
use super::session::DapSession;

impl DapSession<'_> {
    fn next_id(&mut self) -> u64 {
        self.last_id += 1;
        self.last_id
    }

    fn list(&self, arguments: &Json, key: &str) -> Result<Vec<BreakpointRequest>, String> {
        let list = arguments.get(key).cloned().unwrap_or(json!([]));
        let wanted: Vec<BreakpointRequest> =
            serde_json::from_value(list).map_err(|error| format!("{key}: {error}"))?;
        if wanted.len() > BREAKPOINTS_MAX {
            let given = wanted.len();
            return Err(format!(
                "{given} breakpoints at once, {BREAKPOINTS_MAX} are allowed"
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
    pub(super) fn set_source_breakpoints(&mut self, arguments: &Json) -> Result<Json, String> {
        let path = arguments.pointer("/source/path").and_then(Json::as_str);
        let path = path.map_or_else(Default::default, |path| same_path(path.as_ref()));
        let wanted = self.list(arguments, "breakpoints")?;
        self.wanted_sources.retain(|(known, _)| *known != path);
        self.wanted_sources.push((path.clone(), arguments.clone()));
        let is_known = self.is_program(&path) || path.as_os_str().is_empty();
        if self.launched.is_none() || self.attachment.is_some() && !is_known {
            // Bound when the program is known.
            let pending: Vec<Json> = wanted
                .iter()
                .map(|_| json!({"id": self.next_id(), "verified": false, "message": "no such program runs yet"}))
                .collect();
            if let Some((_, kept)) = self.wanted_sources.last_mut()
                && let Json::Object(fields) = kept
            {
                let ids: Vec<Json> = pending.iter().map(|b| b["id"].clone()).collect();
                fields.insert("ids".to_owned(), json!(ids));
            }
            return Ok(json!({ "breakpoints": pending }));
        }
        if !is_known {
            let refused = |_: &BreakpointRequest| json!({"verified": false, "message": "this text is not the program that runs"});
            let refused: Vec<Json> = wanted.iter().map(refused).collect();
            return Ok(json!({ "breakpoints": refused }));
        }
        let ids = (0..wanted.len()).map(|_| None).collect();
        let bound = self.bind_all(&wanted, ids);
        // Bound once more when the run begins: by the numbers that the client knows.
        if let Some((_, Json::Object(kept))) = self.wanted_sources.last_mut() {
            let ids: Vec<Json> = bound.iter().map(|b| b["id"].clone()).collect();
            kept.insert("ids".to_owned(), json!(ids));
        }
        self.changed();
        Ok(json!({ "breakpoints": bound }))
    }

    fn bind_all(&mut self, wanted: &[BreakpointRequest], ids: Vec<Option<u64>>) -> Vec<Json> {
        let Some(launched) = &self.launched else {
            return Vec::new();
        };
        let places = launched.places.clone();
        self.breakpoints.places.clear();
        let mut bound = Vec::new();
        for (breakpoint, id) in wanted.iter().zip(ids) {
            let id = match id {
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
                    json!({
                        "id": id,
                        "verified": true,
                        "line": i64::from(place.line) - 1 + self.first_line,
                        "column": i64::from(place.column) - 1 + self.first_column,
                    })
                }
                (None, _) => {
                    json!({"id": id, "verified": false, "message": "no statement begins here or below"})
                }
                (_, Err(error)) => json!({"id": id, "verified": false, "message": error}),
            });
        }
        bound
    }

    /// The program is known now: breakpoints that came before it are bound, and the client is told where.
    pub(super) fn bind_sources(&mut self) {
        let own = self
            .wanted_sources
            .iter()
            .find(|(path, _)| self.is_program(path));
        let Some((_, arguments)) = own.cloned() else {
            return;
        };
        let Ok(wanted) = self.list(&arguments, "breakpoints") else {
            return;
        };
        let known = arguments.get("ids").and_then(Json::as_array).cloned();
        let ids = known.unwrap_or_default();
        let ids = (0..wanted.len())
            .map(|index| ids.get(index).and_then(Json::as_u64))
            .collect();
        let bound = self.bind_all(&wanted, ids);
        for breakpoint in bound {
            let body = json!({"reason": "changed", "breakpoint": breakpoint});
            self.event("breakpoint", body);
        }
        self.changed();
    }

    /// `setFunctionBreakpoints`
    pub(super) fn set_function_breakpoints(&mut self, arguments: &Json) -> Result<Json, String> {
        let wanted = self.list(arguments, "breakpoints")?;
        self.breakpoints.functions.clear();
        let mut bound = Vec::new();
        for breakpoint in wanted {
            let id = self.next_id();
            let name = breakpoint.name.trim().to_owned();
            bound.push(match breakpoint.breakpoint(id) {
                Ok(_) if name.is_empty() => {
                    json!({"id": id, "verified": false, "message": "name is empty; \
                        allowed is the name of a function, with or without that of its class"})
                }
                Ok(at) => {
                    self.breakpoints
                        .functions
                        .push(FunctionBreakpoint { name, at });
                    json!({"id": id, "verified": true})
                }
                Err(error) => json!({"id": id, "verified": false, "message": error}),
            });
        }
        self.changed();
        Ok(json!({ "breakpoints": bound }))
    }

    /// `setExceptionBreakpoints`
    pub(super) fn set_exception_breakpoints(&mut self, arguments: &Json) -> Result<Json, String> {
        let filters = arguments.get("filters").and_then(Json::as_array);
        let filters: Vec<&str> = filters
            .into_iter()
            .flatten()
            .filter_map(Json::as_str)
            .collect();
        let known = ["caught", "uncaught"];
        if let Some(other) = filters.iter().find(|filter| !known.contains(filter)) {
            return Err(format!(
                "there is no filter {other:?}; there are caught and uncaught"
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
        match condition_of_arm(name) {
            Ok(()) => json!({
                "dataId": name,
                "description": name,
                "accessTypes": ["write"],
                "canPersist": true,
            }),
            Err(error) => json!({"dataId": null, "description": error}),
        }
    }

    /// `setDataBreakpoints`: the condition is that of the breakpoint, or what it is on.
    pub(super) fn set_data_breakpoints(&mut self, arguments: &Json) -> Result<Json, String> {
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
                    json!({"id": id, "verified": true})
                }
                (Err(error), _) | (_, Err(error)) => {
                    json!({"id": id, "verified": false, "message": error})
                }
            });
        }
        self.changed();
        Ok(json!({ "breakpoints": bound }))
    }

    /// `breakpointLocations`
    pub(super) fn breakpoint_locations(&self, arguments: &Json) -> Result<Json, String> {
        let launched = self.launched.as_ref().ok_or("no program was launched")?;
        let path = arguments.pointer("/source/path").and_then(Json::as_str);
        if path.is_some_and(|path| !self.is_program(&same_path(path.as_ref()))) {
            return Err("source is not the program that runs".to_owned());
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
        let bodies: Vec<Json> = within
            .map(|place| {
                json!({
                    "line": i64::from(place.line) - 1 + self.first_line,
                    "column": i64::from(place.column) - 1 + self.first_column,
                })
            })
            .collect();
        Ok(json!({ "breakpoints": bodies }))
    }
}
