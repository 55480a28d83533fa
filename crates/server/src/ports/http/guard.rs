//! Who may change something through the http port: programs, and pages that this server itself sent.
//!
//! A page of another origin cannot read our answers, but it can make a browser send requests. Three things stop it: the
//! content type must be JSON, which a browser sends to another origin only after asking first (and that question is
//! not answered); where a browser names the page's origin, that must be this server; and this server must be named by
//! its address, since a name can be made to lead here by whoever owns it (DNS rebinding).

use std::net::{Ipv4Addr, Ipv6Addr};

use axum::http::{HeaderMap, StatusCode, header};

/// Why a request is turned away.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TurnedAway {
    /// A form, a text, or nothing at all.
    #[error("the content type is {0}; it must be application/json")]
    NotJson(String),
    /// A page that this server did not send.
    #[error("the request comes from a page of {0}; only pages of this server may change anything")]
    Foreign(String),
    /// The server is called by a name.
    #[error(
        "the page calls this server {0}; open it by its address, as http://127.0.0.1:8080, or as localhost"
    )]
    ByName(String),
}

impl TurnedAway {
    /// The answer's status.
    pub const fn status(&self) -> StatusCode {
        match self {
            Self::NotJson(_) => StatusCode::UNSUPPORTED_MEDIA_TYPE,
            Self::Foreign(_) | Self::ByName(_) => StatusCode::FORBIDDEN,
        }
    }
}

/// Lets a request through that no foreign page can have caused.
///
/// # Errors
/// [`TurnedAway`]
pub fn check(headers: &HeaderMap) -> Result<(), TurnedAway> {
    let text = |name| {
        let value = headers.get(name);
        value.map(|value: &header::HeaderValue| {
            String::from_utf8_lossy(value.as_bytes()).into_owned()
        })
    };
    let kind = text(header::CONTENT_TYPE).unwrap_or_else(|| "not given".to_owned());
    let essence = kind.split(';').next().unwrap_or_default().trim();
    if !essence.eq_ignore_ascii_case("application/json") {
        return Err(TurnedAway::NotJson(kind));
    }
    // Programs name no origin; browsers do for every request of this kind.
    let Some(origin) = text(header::ORIGIN) else {
        return Ok(());
    };
    let host = text(header::HOST).unwrap_or_default();
    if origin.strip_prefix("http://") != Some(host.as_str()) {
        return Err(TurnedAway::Foreign(origin));
    }
    if !is_address(&host) {
        return Err(TurnedAway::ByName(host));
    }
    Ok(())
}

/// `localhost` or an IP address, with or without a port.
fn is_address(host: &str) -> bool {
    if let Some(rest) = host.strip_prefix('[') {
        let Some((address, port)) = rest.split_once(']') else {
            return false;
        };
        let port_is_good = port.is_empty() || port.strip_prefix(':').is_some_and(is_port);
        return port_is_good && address.parse::<Ipv6Addr>().is_ok();
    }
    let (name, port) = match host.split_once(':') {
        Some((name, port)) => (name, Some(port)),
        None => (host, None),
    };
    port.is_none_or(is_port)
        && (name.eq_ignore_ascii_case("localhost") || name.parse::<Ipv4Addr>().is_ok())
}

fn is_port(digits: &str) -> bool {
    digits.parse::<u16>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(kind: &str, origin: &str, host: &str) -> Result<(), TurnedAway> {
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
            assert_eq!(found, Err(TurnedAway::Foreign(origin.to_owned())));
        }
        for host in [
            "evil.example:8080",
            "127.0.0.1.evil.example",
            "[evil]:8080",
            "[::1]x",
            "127.0.0.1:x",
        ] {
            let found = answer(JSON, &format!("http://{host}"), host);
            assert_eq!(found, Err(TurnedAway::ByName(host.to_owned())));
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
            assert!(matches!(found, TurnedAway::NotJson(_)), "{kind}");
            assert_eq!(found.status(), StatusCode::UNSUPPORTED_MEDIA_TYPE);
        }
    }
}
