//! Who may change something through the http port: programs, and pages that this server itself sent.
//!
//! That a request is for this machine and from it was looked at before (see `allowed_hosts`). A page of another server
//! on this machine can still make a browser send requests. Two things stop it: the content type must be JSON, which a
//! browser sends to another origin only after asking first (and that question is not answered); and where a browser
//! names the page's origin, that must be this server.

use axum::http::{HeaderMap, StatusCode, header};
use messages::Localized;

use crate::ports::allowed_hosts::is_same_server;
use crate::ports::escape::EscapedLine;

/// A reason why a request is turned away.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Localized)]
pub enum CrossSiteRejection {
    /// A form, a text, or nothing at all.
    #[error("the content type is {0}; it must be application/json")]
    #[zh("内容类型为 {0}；必须是 application/json")]
    NotJson(String),
    /// A page that this server did not send.
    #[error("the request comes from a page of {0}; only pages of this server may change anything")]
    #[zh("请求来自 {0} 的页面；只有本服务器的页面可以更改")]
    Foreign(String),
}

impl CrossSiteRejection {
    /// The answer's status.
    pub const fn status(&self) -> StatusCode {
        match self {
            Self::NotJson(_) => StatusCode::UNSUPPORTED_MEDIA_TYPE,
            Self::Foreign(_) => StatusCode::FORBIDDEN,
        }
    }
}

/// Lets a request through that no foreign page can have caused.
///
/// # Errors
/// [`CrossSiteRejection`]
pub fn check(headers: &HeaderMap) -> Result<(), CrossSiteRejection> {
    let text = |name| {
        let value = headers.get(name);
        value.map(|value: &header::HeaderValue| {
            String::from_utf8_lossy(value.as_bytes()).into_owned()
        })
    };
    let kind = text(header::CONTENT_TYPE).unwrap_or_else(|| "not given".to_owned());
    let essence = kind.split(';').next().unwrap_or_default().trim();
    if !essence.eq_ignore_ascii_case("application/json") {
        return Err(CrossSiteRejection::NotJson(EscapedLine(&kind).to_string()));
    }
    // Programs name no origin; browsers do for every request of this kind.
    let Some(origin) = text(header::ORIGIN) else {
        return Ok(());
    };
    let host = text(header::HOST).unwrap_or_default();
    match is_same_server(&origin, &host) {
        true => Ok(()),
        false => Err(CrossSiteRejection::Foreign(
            EscapedLine(&origin).to_string(),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(kind: &str, origin: &str, host: &str) -> Result<(), CrossSiteRejection> {
        let mut headers = HeaderMap::new();
        for (name, value) in [
            (header::CONTENT_TYPE, kind),
            (header::ORIGIN, origin),
            (header::HOST, host),
        ] {
            if !value.is_empty() {
                headers.insert(name, value.parse().unwrap());
            }
        }
        check(&headers)
    }

    const JSON: &str = "application/json; charset=utf-8";

    #[test]
    fn programs_and_our_own_pages_come_in() {
        for (origin, host) in [
            ("", "robot.example:8080"),
            ("http://localhost", "localhost:80"),
            ("http://127.0.0.1:8080", "127.0.0.1:8080"),
            ("http://localhost:8080", "localhost:8080"),
            ("http://192.0.2.7", "192.0.2.7"),
            ("http://[::1]:8080", "[::1]:8080"),
        ] {
            assert_eq!(answer(JSON, origin, host), Ok(()), "{origin}");
        }
    }

    #[test]
    fn pages_of_others_stay_out() {
        for (origin, host) in [
            ("https://127.0.0.1:8080", "127.0.0.1:8080"),
            ("http://127.0.0.1:9999", "127.0.0.1:8080"),
            ("http://evil.example", "127.0.0.1:8080"),
            ("null", "127.0.0.1:8080"),
            ("http://", "127.0.0.1"),
        ] {
            let found = answer(JSON, origin, host);
            assert_eq!(found, Err(CrossSiteRejection::Foreign(origin.to_owned())));
        }
    }

    #[test]
    fn what_a_form_can_send_is_no_request() {
        for kind in [
            "",
            "text/plain",
            "application/x-www-form-urlencoded",
            "text/plain; application/json",
            "application/jsonp",
        ] {
            let found = answer(kind, "", "127.0.0.1").unwrap_err();
            assert!(matches!(found, CrossSiteRejection::NotJson(_)), "{kind}");
            assert_eq!(found.status(), StatusCode::UNSUPPORTED_MEDIA_TYPE);
        }
    }
}
