//! Access control: only the workbench's own page in a browser on this machine may send requests.
//!
//! The danger is not the network, as the server listens on loopback only by default, but another page in the same browser. Three
//! checks reject it: the host name of the request (a foreign name that resolves to this machine, "DNS rebinding"), the
//! origin of the page, and a header that a foreign page cannot send without a preflight request, which is never
//! answered.

use std::net::IpAddr;

use axum::extract::{Request, State};
use axum::http::{HeaderValue, Method, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

/// Header that every request for a change must carry.
pub(super) const OWN_HEADER: &str = "x-fos-workbench";

/// Names of the workbench: host and port as in an address.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Names(Vec<String>);

impl Names {
    /// Names of a server at this address; if other machines can reach it, also the address they use.
    pub(super) fn of(ip: IpAddr, port: u16) -> Self {
        let mut names =
            vec![format!("127.0.0.1:{port}"), format!("localhost:{port}"), format!("[::1]:{port}")];
        if !ip.is_loopback() && !ip.is_unspecified() {
            names.push(match ip {
                IpAddr::V4(ip) => format!("{ip}:{port}"),
                IpAddr::V6(ip) => format!("[{ip}]:{port}"),
            });
        }
        Self(names)
    }

    fn contain(&self, host: &str) -> bool {
        self.0.iter().any(|name| name.eq_ignore_ascii_case(host))
    }

    /// Returns the reason why a request is refused; none if it is not.
    fn refuse(&self, request: &Request) -> Option<&'static str> {
        let text = |name: &str| request.headers().get(name).map(|value| value.to_str().unwrap_or_default());
        if !text("host").is_some_and(|host| self.contain(host)) {
            return Some("asked under a foreign name");
        }
        if let Some(origin) = text("origin")
            && !origin.strip_prefix("http://").is_some_and(|host| self.contain(host))
        {
            return Some("asked by a foreign page");
        }
        // browsers report the site of the requesting page even without an origin; a link there may open the workbench,
        // but not read from it
        let opens = text("sec-fetch-mode") == Some("navigate") && !request.uri().path().starts_with("/api/");
        if matches!(text("sec-fetch-site"), Some("cross-site" | "same-site")) && !opens {
            return Some("asked by a foreign page");
        }
        let changes = !matches!(*request.method(), Method::GET | Method::HEAD);
        if changes && text(OWN_HEADER) != Some("1") {
            return Some("asked without the header of the page");
        }
        None
    }
}

/// Lets a request pass or refuses it, and protects the response with [`HEADERS`].
pub(super) async fn guard(State(names): State<Names>, request: Request, next: Next) -> Response {
    let mut response = match names.refuse(&request) {
        Some(why) => (StatusCode::FORBIDDEN, axum::Json(serde_json::json!({ "error": why }))).into_response(),
        None => next.run(request).await,
    };
    let headers = response.headers_mut();
    for (name, value) in HEADERS {
        headers.entry(name).or_insert(HeaderValue::from_static(value));
    }
    response
}

/// Headers that restrict the browser: no content from elsewhere, no embedding in frames, no guessing of types, no
/// caching.
const HEADERS: [(&str, &str); 7] = [
    (
        "content-security-policy",
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
    ("x-content-type-options", "nosniff"),
    ("x-frame-options", "DENY"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-resource-policy", "same-origin"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cache-control", "no-store"),
];
