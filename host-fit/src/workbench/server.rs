//! Which request goes where.

use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;

use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::routing::{delete, get, post};
use tokio::net::TcpListener;

use super::desk::Desk;
use super::folders::Folders;
use super::guard::{Names, guard};
use super::tasks::Open;
use super::{api, assets};
use crate::effects::Library;
use crate::recording::LoadOptions;

/// Bytes of a request that is not a file.
const LARGEST_REQUEST: usize = 64 * 1024;

/// Why the workbench cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The address.
    #[error("cannot listen at {address}: {source}\nhelp: another --port, or --port 0 for any that is free")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// Why.
        source: std::io::Error,
    },
    /// While serving.
    #[error("the server ended: {0}")]
    Serve(#[from] std::io::Error),
}

/// A workbench that listens.
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    desk: Arc<Desk>,
}

impl Server {
    /// Listens at an address; port 0 takes any that is free.
    ///
    /// # Errors
    ///
    /// The address is taken or not this machine's.
    pub async fn bind(ip: IpAddr, port: u16, folders: Folders, library: Library) -> Result<Self, ServeError> {
        let address = SocketAddr::new(ip, port);
        let failed = |source| ServeError::Listen { address, source };
        let listener = TcpListener::bind(address).await.map_err(failed)?;
        let address = listener.local_addr()?;
        Ok(Self { listener, address, desk: Arc::new(Desk::new(folders, library)) })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Opens a study of these logs, as the page would.
    ///
    /// # Errors
    ///
    /// Too many studies are open.
    pub fn open(
        &self,
        field: String,
        quiet: Option<String>,
        judged: Option<String>,
        read: LoadOptions,
    ) -> Result<u64, String> {
        self.desk.open(Open::Logs { field, quiet, judged, read })
    }

    /// Answers until `end` comes.
    ///
    /// # Errors
    ///
    /// The listener fails.
    pub async fn run(self, end: impl Future<Output = ()> + Send + 'static) -> Result<(), ServeError> {
        let router = router(self.desk, Names::of(self.address.ip(), self.address.port()));
        // streams of events never end by themselves: the end does not wait for them
        tokio::select! {
            served = async { axum::serve(self.listener, router).await } => Ok(served?),
            () = end => Ok(()),
        }
    }
}

/// All routes.
pub(super) fn router(desk: Arc<Desk>, names: Names) -> Router {
    Router::new()
        .route("/api/studies", get(api::studies).post(api::open))
        .route("/api/studies/{id}", delete(api::close).get(api::state))
        .route("/api/studies/{id}/events", get(api::events))
        .route("/api/studies/{id}/axis", post(api::look_at))
        .route("/api/studies/{id}/cancel", post(api::cancel))
        .route("/api/studies/{id}/add", post(api::add))
        .route("/api/studies/{id}/undo", post(api::undo))
        .route("/api/studies/{id}/series", get(api::series))
        .route("/api/studies/{id}/figures", get(api::figures))
        .route("/api/studies/{id}/export/{format}", get(api::export))
        .route("/api/studies/{id}/replay", get(api::replay))
        .route("/api/logs", get(api::logs))
        .route("/api/preview", post(api::preview))
        .route("/api/effects", get(api::effects))
        // before the limit of all others: a dropped file is large, and goes to the disk as it comes
        .layer(DefaultBodyLimit::max(LARGEST_REQUEST))
        .route("/api/uploads", post(api::upload).layer(DefaultBodyLimit::disable()))
        .fallback(assets::asset)
        .with_state(desk)
        .layer(axum::middleware::from_fn_with_state(names, guard))
}
