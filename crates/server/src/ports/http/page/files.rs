//! The page's own files, as the build has bundled them.

use axum::body::Body;
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use messages::text;
use pendant::Token;
use pendant::assets::{INDEX, NONCE_MARK, content_security_policy, find};

use super::super::refuse;

/// The file at the path of a request. A browser that has it already, and its compiled form, is told so.
pub(super) async fn file(method: Method, uri: Uri, asked: HeaderMap) -> Response {
    if method != Method::GET && method != Method::HEAD {
        let mut refused = refuse(
            StatusCode::METHOD_NOT_ALLOWED,
            &text!("a page can only be looked at", "页面只能查看"),
        );
        let allowed = HeaderValue::from_static("GET, HEAD");
        refused.headers_mut().insert(header::ALLOW, allowed);
        return refused;
    }
    let Some(asset) = find(uri.path()) else {
        return refuse(
            StatusCode::NOT_FOUND,
            &text!("there is no such page", "没有这个页面"),
        );
    };
    let known = asked.get(header::IF_NONE_MATCH);
    if asset.path != INDEX && known.is_some_and(|known| known == asset.mark) {
        let headers = [
            (header::ETAG, asset.mark),
            (header::CACHE_CONTROL, "no-cache"),
        ];
        return (StatusCode::NOT_MODIFIED, headers).into_response();
    }
    // Without random numbers the style sheet of the editor is not applied; everything else is.
    let nonce = Token::random().map_or_else(|_| String::new(), |token| token.reveal().to_owned());
    let mut response = if asset.path == INDEX {
        let text = String::from_utf8_lossy(asset.bytes).replace(NONCE_MARK, &nonce);
        Body::from(text).into_response()
    } else {
        Body::from(asset.bytes).into_response()
    };
    let headers = response.headers_mut();
    headers.insert(
        header::CONTENT_TYPE,
        HeaderValue::from_static(asset.media_type),
    );
    // The page itself has another nonce every time.
    if asset.path != INDEX {
        headers.insert(header::ETAG, HeaderValue::from_static(asset.mark));
    }
    if asset.is_gzipped {
        headers.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
    }
    for (name, value) in [
        (header::CACHE_CONTROL, "no-cache"),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::X_FRAME_OPTIONS, "DENY"),
        (header::REFERRER_POLICY, "no-referrer"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    if let Ok(policy) = content_security_policy(&nonce).parse() {
        headers.insert(header::CONTENT_SECURITY_POLICY, policy);
    }
    response
}
