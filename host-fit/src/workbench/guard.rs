//! Who may ask: the workbench's own page in a browser on this machine, and nobody else.
//!
//! The danger is not the network, as the server listens on loopback only, but another page in the same browser. It is
//! kept out three times: by the name that the browser thinks it talks to (a foreign name that resolves to this machine,
//! "DNS rebinding"), by the origin of the page that asks, and by a header that a foreign page cannot send without
//! asking first, which is never answered.

use std::net::IpAddr;

use axum::extract::{Request, State};
use axum::http::{HeaderValue, Method, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

/// The header that every request which changes something must carry.
pub(super) const OWN_HEADER: &str = "x-fos-workbench";

/// The names that the workbench goes by: host and port as in an address.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Names(Vec<String>);

impl Names {
    /// For a server at this address; where others may reach it, by the address they use.
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

    /// Why a request is refused, if it is.
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
        // browsers say from where a page asks, also where they send no origin; a link there may open the workbench, but
        // not read from it
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

/// Lets a request pass, or refuses it; what is answered is kept to itself.
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

/// What the browser is told to hold the page to: nothing from elsewhere, in no frame, no guessing of types.
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
