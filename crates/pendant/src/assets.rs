//! The files of the page, as the build has bundled them; without Node in the build a page that says so.

/// One file.
#[derive(Clone, Copy, Debug)]
pub struct Asset {
    /// Path in the address, with its slash.
    pub path: &'static str,
    /// Media type, for instance `text/html; charset=utf-8`.
    pub media_type: &'static str,
    /// Content, byte for byte what is sent.
    pub bytes: &'static [u8],
    /// The content is compressed with gzip.
    pub is_gzipped: bool,
    /// Entity tag: another content has another one.
    pub mark: &'static str,
}

include!(concat!(env!("OUT_DIR"), "/assets.rs"));

/// Path of the page.
pub const INDEX: &str = "/";
/// In the page, the place of the number that its style sheets must carry.
pub const NONCE_MARK: &str = "__NONCE__";

/// The file at a path.
pub fn find(path: &str) -> Option<&'static Asset> {
    ASSETS.iter().find(|asset| asset.path == path)
}

/// What the page may load: its own files alone. `nonce` lets the editor add its style sheet.
pub fn content_security_policy(nonce: &str) -> String {
    format!(
        "default-src 'self'; style-src 'self' 'nonce-{nonce}'; object-src 'none'; base-uri 'none'; \
         form-action 'none'; frame-ancestors 'none'"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_a_page_and_it_is_small() {
        let page = find(INDEX).unwrap();
        assert!(!page.is_gzipped && page.media_type.starts_with("text/html"));
        let text = std::str::from_utf8(page.bytes).unwrap();
        assert!(!text.contains("http://") && !text.contains("https://"));
        let bytes: usize = ASSETS.iter().map(|asset| asset.bytes.len()).sum();
        assert!(bytes <= 700_000, "{bytes}");
        assert_eq!(IS_BUNDLED, find("/app.js").is_some());
        assert!(find("/../etc/passwd").is_none());
    }
}
