//! Names and origins that are this machine's, and those that only look like it.

use std::net::Ipv4Addr;

use axum::http::Request;
use proptest::prelude::*;

use super::*;

const LOOPBACK: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);

/// What becomes of a request with this target and these headers, come in on `local`.
fn admitted(
    callers: &AllowedHosts,
    local: IpAddr,
    target: &str,
    headers: &[(&str, &str)],
) -> Result<(), HostRejection> {
    let mut request = Request::builder().uri(target);
    for (name, value) in headers {
        request = request.header(*name, *value);
    }
    callers.admit(&request.body(()).unwrap().into_parts().0, local)
}

fn by_host(callers: &AllowedHosts, local: IpAddr, host: &str) -> Result<(), HostRejection> {
    admitted(callers, local, "/", &[("host", host)])
}

fn at_home() -> AllowedHosts {
    AllowedHosts::of(LOOPBACK, Some("robot.factory.example"), &[])
}

#[test]
fn this_machine_is_called_by_its_loopback_addresses_and_as_localhost() {
    for host in [
        "127.0.0.1",
        "127.0.0.1:8080",
        "127.1.2.3:80",
        "[::1]",
        "[::1]:8080",
        "[::ffff:127.0.0.1]:8080",
        "localhost",
        "localhost:65535",
        "LocalHost:8080",
        "localhost.:8080",
        "localhost:",
    ] {
        assert_eq!(by_host(&at_home(), LOOPBACK, host), Ok(()), "{host}");
    }
}

/// Names that lead here without being this machine's, and things that are no name.
pub(crate) const FOREIGN_HOSTS: [&str; 36] = [
    "evil.example",
    "evil.example:8080",
    "127.0.0.1.evil.example",
    "127.0.0.1.nip.io:8080",
    "localhost.evil.example",
    "evil.localhost",
    "notlocalhost",
    "localhost..",
    ".localhost",
    "localtest.me",
    "lvh.me:8080",
    "user@127.0.0.1",
    "127.0.0.1@evil.example",
    "localhost:8080@evil.example",
    "user:127.0.0.1",
    "0.0.0.0",
    "0.0.0.0:8080",
    "[::]",
    "2130706433",
    "0x7f000001",
    "0177.0.0.1",
    "127.1",
    "127.0.0.1.",
    "127.0.0.1:x",
    "127.0.0.1:-1",
    "127.0.0.1:+80",
    "127.0.0.1:99999",
    "127.0.0.1:80:80",
    "::1",
    "[::1",
    "[::1]x",
    "[evil]:8080",
    "[::1%25lo]",
    "192.0.2.7",
    "robot.factory.example",
    "",
];

#[test]
fn names_of_others_are_turned_away_with_a_sentence() {
    for host in FOREIGN_HOSTS {
        let found = by_host(&at_home(), LOOPBACK, host);
        assert_eq!(found, Err(HostRejection::Host(host.to_owned())), "{host}");
    }
    let found = by_host(&at_home(), LOOPBACK, "evil.example").unwrap_err();
    assert_eq!(found.status(), StatusCode::FORBIDDEN);
    assert!(
        found
            .to_string()
            .starts_with("the request is for evil.example, ")
    );
}

#[test]
fn beyond_loopback_the_address_that_was_reached_and_the_names_of_the_machine_count() {
    let local: IpAddr = "192.0.2.7".parse().unwrap();
    let everywhere: IpAddr = "0.0.0.0".parse().unwrap();
    let trusted = ["Cell-4.example.".to_owned(), "198.51.100.1".to_owned()];
    for bind in [local, everywhere] {
        let callers = AllowedHosts::of(bind, Some("Robot.factory.example"), &trusted);
        for host in [
            "192.0.2.7:8080",
            "robot.factory.example",
            "ROBOT:8080",
            "robot.local",
            "cell-4.example:80",
            "198.51.100.1:80",
            "localhost",
            "127.0.0.1",
        ] {
            assert_eq!(by_host(&callers, local, host), Ok(()), "{host}");
        }
        for host in ["192.0.2.8", "robot.evil.example", "evil.example", "0.0.0.0"] {
            assert!(by_host(&callers, local, host).is_err(), "{host}");
        }
    }
    let v6: IpAddr = "2001:db8::7".parse().unwrap();
    let callers = AllowedHosts::of(v6, None, &[]);
    assert_eq!(by_host(&callers, v6, "[2001:DB8:0::7]:8080"), Ok(()));
    assert!(by_host(&callers, v6, "[2001:db8::8]:8080").is_err());
}

#[test]
fn every_host_that_a_request_names_counts() {
    let call = |target, headers: &[(&str, &str)]| admitted(&at_home(), LOOPBACK, target, headers);
    let own = ("host", "localhost");
    assert_eq!(call("http://localhost:8080/panel", &[own]), Ok(()));
    assert!(call("http://evil.example/panel", &[own]).is_err());
    assert!(call("http://user@localhost/panel", &[own]).is_err());
    assert!(call("/", &[own, ("host", "evil.example")]).is_err());
    assert!(call("/", &[("host", "evil.example"), own]).is_err());
    assert_eq!(call("/", &[own, own]), Err(HostRejection::Hosts(2)));
    assert_eq!(call("/", &[]), Err(HostRejection::Hosts(0)));
    let mut old = Request::builder().version(Version::HTTP_10).uri("/");
    let head = |request: axum::http::request::Builder| request.body(()).unwrap().into_parts().0;
    assert_eq!(at_home().admit(&head(old), LOOPBACK), Ok(()));
    old = Request::builder().version(Version::HTTP_10).uri("/");
    let evil = head(old.header("origin", "http://evil.example"));
    assert!(at_home().admit(&evil, LOOPBACK).is_err());
}

#[test]
fn pages_of_this_machine_come_in_and_others_stay_out() {
    let by_origin = |callers: &AllowedHosts, origin| {
        admitted(
            callers,
            LOOPBACK,
            "/",
            &[("host", "localhost:8080"), ("origin", origin)],
        )
    };
    for origin in [
        "http://127.0.0.1:8080",
        "http://localhost:3000",
        "https://localhost",
        "HTTP://[::1]:8080",
    ] {
        assert_eq!(by_origin(&at_home(), origin), Ok(()), "{origin}");
    }
    for origin in [
        "null",
        "http://",
        "http://evil.example",
        "https://evil.example:8080",
        "http://localhost.evil.example",
        "http://user@localhost",
        "http://localhost/",
        "http://localhost http://evil.example",
        "file://",
        "chrome-extension://abcdef",
        "ws://localhost",
        "localhost",
        "",
    ] {
        let found = by_origin(&at_home(), origin);
        assert_eq!(
            found,
            Err(HostRejection::Origin(origin.to_owned())),
            "{origin}"
        );
    }
    let two = [
        ("host", "localhost"),
        ("origin", "http://localhost"),
        ("origin", "http://evil.example"),
    ];
    assert!(admitted(&at_home(), LOOPBACK, "/", &two).is_err());
    // The desktop app of a read-only port is a page on the disk.
    let viewer = at_home().with_files();
    assert_eq!(by_origin(&viewer, "file://"), Ok(()));
    assert!(by_origin(&viewer, "null").is_err() && by_origin(&viewer, "file:///x").is_err());
}

#[test]
fn the_same_server_has_the_same_name_and_port() {
    for (origin, host, same) in [
        ("http://127.0.0.1:8080", "127.0.0.1:8080", true),
        ("http://localhost", "LOCALHOST:80", true),
        ("http://[::1]:8080", "[::1]:8080", true),
        ("http://localhost:3000", "localhost:8080", false),
        ("http://127.0.0.1:8080", "localhost:8080", false),
        ("https://localhost", "localhost", false),
        ("null", "localhost", false),
    ] {
        assert_eq!(is_same_server(origin, host), same, "{origin} {host}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn only_names_and_addresses_of_this_machine_are_own(
        host in "[a-z0-9.:@%\\[\\]-]{0,30}|localhost[a-z.:0-9@]{0,6}|127[.0-9:]{0,12}",
    ) {
        if at_home().is_own(&host, LOOPBACK) {
            let name = without_port(&host).unwrap();
            prop_assert!(
                normal(name) == "localhost" || address(name).is_some_and(|address| address.is_loopback())
            );
        }
    }
}
