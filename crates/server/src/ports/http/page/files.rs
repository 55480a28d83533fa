//! The page's own files, as the build has bundled them.

use axum::body::Body;
use axum::http::{HeaderValue, Uri, header};
use axum::response::{IntoResponse, Response};
use pendant::Token;
use pendant::assets::{INDEX, NONCE_MARK, content_security_policy, find};

use super::super::refuse;
use axum::http::StatusCode;

/// The file at the path of a request.
pub(super) async fn file(uri: Uri) -> Response {
    let Some(asset) = find(uri.path()) else {
        return refuse(StatusCode::NOT_FOUND, "there is no such page");
    };
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
