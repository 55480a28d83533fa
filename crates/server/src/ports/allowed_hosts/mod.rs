//! By which names this machine may be called, and which pages may call: for every request of every port that speaks
//! HTTP.
//!
//! A page of somebody else cannot read our answers, unless its own name is made to lead here by whoever owns it (DNS
//! rebinding): then for the browser the page and this server are one. What such a page cannot change is what the
//! browser says: the name it connected by (`Host`) and where the page is from (`Origin`). So both must be this
//! machine's. Pure.

use std::net::{IpAddr, Ipv6Addr};

use axum::http::request::Parts;
use axum::http::uri::Authority;
use axum::http::{HeaderName, StatusCode, Version, header};
use messages::Localized;

use super::escape::EscapedLine;

/// A reason why a request is turned away: one sentence that names what was given.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Localized)]
pub enum HostRejection {
    /// The server is called by a name that is not this machine's.
    #[error(
        "the request is for {0}, which is not a name of this machine; open it by its address or as localhost, or \
         start the server with --trust-host"
    )]
    #[zh("请求的是 {0}，不是本机的名称；请用地址或 localhost 打开，或以 --trust-host 启动服务器")]
    Host(String),
    /// A page that comes from elsewhere.
    #[error("the request comes from a page of {0}; only pages of this machine may ask here")]
    #[zh("请求来自 {0} 的页面；这里只有本机的页面可以请求")]
    Origin(String),
    /// HTTP demands exactly one name.
    #[error("a request needs one Host header, this one has {0}")]
    #[zh("请求需要一个 Host 头，此请求有 {0} 个")]
    Hosts(usize),
}

impl HostRejection {
    /// The answer's status.
    pub const fn status(&self) -> StatusCode {
        match self {
            Self::Host(_) | Self::Origin(_) => StatusCode::FORBIDDEN,
            Self::Hosts(_) => StatusCode::BAD_REQUEST,
        }
    }
}

/// The names of this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AllowedHosts {
    /// Names in small letters, without a dot at the end.
    names: Vec<String>,
    /// Pages of files on this machine's disk may ask: read-only ports of desktop apps.
    files: bool,
}

impl AllowedHosts {
    /// `localhost`, and with a port that others can reach the machine's own name; those in `trusted` as well.
    pub fn of(bind: IpAddr, machine: Option<&str>, trusted: &[String]) -> Self {
        let mut names = vec!["localhost".to_owned()];
        if !bind.is_loopback()
            && let Some(machine) = machine.map(normal).filter(|name| !name.is_empty())
        {
            // The name alone, and as machines announce it on the local network (mDNS, RFC 6762).
            let first = machine.split('.').next().unwrap_or_default();
            names.push(format!("{first}.local"));
            names.push(first.to_owned());
            names.push(machine);
        }
        names.extend(trusted.iter().map(|name| normal(name)));
        Self {
            names,
            files: false,
        }
    }

    /// These hosts; pages of files on this machine's disk may ask, too.
    pub fn with_files(self) -> Self {
        Self {
            files: true,
            ..self
        }
    }

    /// Lets a request in that came to the address `local` of this machine.
    ///
    /// # Errors
    /// [`HostRejection`] says what is not this machine's.
    pub fn admit(&self, head: &Parts, local: IpAddr) -> Result<(), HostRejection> {
        // A request for a whole address is for that, whatever its headers say (RFC 9112, 3.2.2).
        if let Some(authority) = head.uri.authority() {
            self.check_host(authority.as_str(), local)?;
        }
        let mut hosts = 0;
        for host in values(head, &header::HOST) {
            self.check_host(&host, local)?;
            hosts += 1;
        }
        // Only programs speak HTTP/1.0 without a Host, and no name leads them here.
        if hosts > 1 || hosts == 0 && head.version > Version::HTTP_10 {
            return Err(HostRejection::Hosts(hosts));
        }
        for origin in values(head, &header::ORIGIN) {
            self.check_origin(&origin, local)?;
        }
        Ok(())
    }

    fn check_host(&self, host: &str, local: IpAddr) -> Result<(), HostRejection> {
        match self.is_own(host, local) {
            true => Ok(()),
            false => Err(HostRejection::Host(EscapedLine(host).to_string())),
        }
    }

    fn check_origin(&self, origin: &str, local: IpAddr) -> Result<(), HostRejection> {
        let host = origin.split_once("://").and_then(|(scheme, host)| {
            let is_web = ["http", "https"]
                .iter()
                .any(|s| scheme.eq_ignore_ascii_case(s));
            is_web.then_some(host)
        });
        let is_own = match host {
            Some(host) => self.is_own(host, local),
            None => self.files && origin == "file://",
        };
        match is_own {
            true => Ok(()),
            false => Err(HostRejection::Origin(EscapedLine(origin).to_string())),
        }
    }

    /// True for a name or an address of this machine, with or without a port. Exact: what would have to be interpreted
    /// (user names, escapes, other spellings of numbers) is nobody's.
    fn is_own(&self, host: &str, local: IpAddr) -> bool {
        let Some(host) = without_port(host) else {
            return false;
        };
        match address(host) {
            Some(address) => {
                address.is_loopback()
                    || address == local.to_canonical()
                    || self.names.iter().any(|name| name.parse() == Ok(address))
            }
            None => self.names.contains(&normal(host)),
        }
    }
}

/// All values of a header, as they came; what is no text cannot be a name.
fn values(head: &Parts, name: &HeaderName) -> impl Iterator<Item = String> {
    let values = head.headers.get_all(name).into_iter();
    values.map(|value| String::from_utf8_lossy(value.as_bytes()).into_owned())
}

/// Host names do not know capitals, and a dot at the end only says that the name is whole.
fn normal(name: &str) -> String {
    let name = name.strip_suffix('.').unwrap_or(name);
    name.to_ascii_lowercase()
}

/// What stands before the port; `None` when it is no host with or without a port.
fn without_port(host: &str) -> Option<&str> {
    let end = match host.strip_prefix('[') {
        Some(rest) => rest.find(']')? + 2,
        None => host.find(':').unwrap_or(host.len()),
    };
    let (host, rest) = host.split_at(end);
    let is_port = match rest.strip_prefix(':') {
        Some(port) => port.is_empty() || port.parse::<u16>().is_ok() && !port.starts_with('+'),
        None => rest.is_empty(),
    };
    is_port.then_some(host)
}

/// The address that a host is, if it is none of the names.
fn address(host: &str) -> Option<IpAddr> {
    let address = match host
        .strip_prefix('[')
        .and_then(|rest| rest.strip_suffix(']'))
    {
        Some(inner) => IpAddr::V6(inner.parse::<Ipv6Addr>().ok()?),
        None => IpAddr::V4(host.parse().ok()?),
    };
    Some(address.to_canonical())
}

/// True when two ways to name a server mean the same: `http://localhost:80` and `LOCALHOST`.
pub fn is_same_server(origin: &str, host: &str) -> bool {
    let Some(origin) = origin.strip_prefix("http://") else {
        return false;
    };
    let port = |text: &str| {
        text.parse::<Authority>()
            .ok()
            .map(|a| a.port_u16().unwrap_or(80))
    };
    let both_named = without_port(origin).zip(without_port(host));
    both_named.is_some_and(|(a, b)| normal(a) == normal(b)) && port(origin) == port(host)
}

#[cfg(test)]
pub(crate) mod tests;
