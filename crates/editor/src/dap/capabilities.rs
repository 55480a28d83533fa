//! What the debugger says that it can do.

use serde_json::{Value as Json, json};

/// The body of the response to `initialize`.
pub(crate) fn capabilities() -> Json {
    json!({
        "supportsConfigurationDoneRequest": true,
        "supportsFunctionBreakpoints": true,
        "supportsConditionalBreakpoints": true,
        "supportsHitConditionalBreakpoints": true,
        "supportsEvaluateForHovers": true,
        "exceptionBreakpointFilters": [
            {"filter": "caught", "label": "Raised exceptions", "default": false,
             "description": "Hold where an exception is raised, also one that the program catches."},
            {"filter": "uncaught", "label": "Uncaught exceptions", "default": true,
             "description": "Show the statement that raised the exception which ended the program."},
        ],
        "supportsStepBack": true,
        "supportsSetVariable": true,
        "supportsSetExpression": true,
        "supportsRestartFrame": true,
        "supportsRestartRequest": true,
        "supportsExceptionInfoRequest": true,
        "supportTerminateDebuggee": true,
        "supportsTerminateRequest": true,
        "supportsDelayedStackTraceLoading": true,
        "supportsLoadedSourcesRequest": true,
        "supportsLogPoints": true,
        "supportsDataBreakpoints": true,
        "supportsBreakpointLocationsRequest": true,
        "supportsClipboardContext": true,
        "supportsNextNodeRequest": true,
        "supportsGotoCycleRequest": true,
    })
}
