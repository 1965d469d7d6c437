//! Routes and connections of the server.

use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;

use std::time::Duration;

use axum::Router;
use axum::body::Body;
use axum::extract::{DefaultBodyLimit, Request, State};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::Response;
use axum::routing::{delete, get, post};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::TcpListener;
use tokio_stream::StreamExt;

use super::folders::Folders;
use super::guard::{Names, guard};
use super::task::LogFiles;
use super::workspace::Workspace;
use super::{api, assets, populations};
use fos_data::file::FileError;
use fos_data::recording::LoadOptions;
use fos_diagnose::effects::Library;

/// Largest size of a request that is not a file, bytes.
const LARGEST_REQUEST: usize = 64 * 1024;

/// Largest size of a figure to be drawn, bytes.
const LARGEST_FIGURE: usize = 4 << 20;

/// Time without progress after which a request is dropped and its connection closed: the client may be gone.
const PATIENCE: Duration = Duration::from_secs(30);

/// Failure to open the workbench.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The server cannot listen at the address.
    #[error("cannot listen at {address}: {source}\nhelp: another --port, or --port 0 for any that is free")]
    Listen {
        /// Requested IP address and port.
        address: SocketAddr,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The folder of stored studies cannot be used.
    #[error(transparent)]
    Stored(#[from] FileError),
    /// The operating system does not report the address of the listener.
    #[error("the server ended: {0}")]
    Serve(#[from] std::io::Error),
}

/// Listening workbench.
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    workspace: Arc<Workspace>,
}

impl Server {
    /// Listens at an address; port 0 takes any that is free.
    ///
    /// # Errors
    ///
    /// The address is in use or not this machine's, or the folder of stored studies cannot be used.
    pub async fn bind(ip: IpAddr, port: u16, folders: Folders, library: Library) -> Result<Self, ServeError> {
        let address = SocketAddr::new(ip, port);
        let failed = |source| ServeError::Listen { address, source };
        let listener = TcpListener::bind(address).await.map_err(failed)?;
        let address = listener.local_addr()?;
        Ok(Self { listener, address, workspace: Arc::new(Workspace::new(folders, library)?) })
    }

    /// Returns the address of the listener.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Opens a study of these logs, as the page would; a stored one resumes.
    ///
    /// # Errors
    ///
    /// Too many studies are open, or the stored one cannot be renamed.
    pub fn open(
        &self,
        log: String,
        reference: Option<String>,
        evaluation: Option<String>,
        read: LoadOptions,
    ) -> Result<u64, String> {
        self.workspace.open_or_resume(LogFiles { log, reference, evaluation, read })
    }

    /// Answers requests until `end` resolves.
    pub async fn run(self, end: impl Future<Output = ()> + Send + 'static) -> Result<(), ServeError> {
        self.run_with(PATIENCE, end).await
    }

    pub(super) async fn run_with(
        self,
        patience: Duration,
        end: impl Future<Output = ()> + Send,
    ) -> Result<(), ServeError> {
        let router = router(self.workspace, Names::of(self.address.ip(), self.address.port()), patience);
        // event streams never end by themselves: the end does not wait for them
        tokio::select! {
            () = serve(self.listener, router, patience) => Ok(()),
            () = end => Ok(()),
        }
    }
}

/// Answers every connection. `axum::serve` is no choice: it waits for the head of a request without a time limit.
async fn serve(listener: TcpListener, router: Router, patience: Duration) {
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(patience);
    loop {
        let Ok((connection, _)) = listener.accept().await else {
            // the connection is closed already, or there are too many: others end meanwhile
            tokio::time::sleep(Duration::from_millis(100)).await;
            continue;
        };
        let answered =
            http.serve_connection(TokioIo::new(connection), TowerToHyperService::new(router.clone()));
        // the end of one connection does not concern the others
        tokio::spawn(async { drop(answered.await) });
    }
}

/// Drops a request whose body makes no progress.
async fn impatient(State(patience): State<Duration>, request: Request, next: Next) -> Response {
    let request = request.map(|body| {
        let pieces = body.into_data_stream().timeout(patience);
        Body::from_stream(pieces.map(|piece| match piece {
            Ok(piece) => piece.map_err(axum::Error::into_inner),
            Err(elapsed) => Err(elapsed.into()),
        }))
    });
    next.run(request).await
}

/// All routes.
pub(super) fn router(workspace: Arc<Workspace>, names: Names, patience: Duration) -> Router {
    Router::new()
        .route("/api/studies", get(api::studies).post(api::open))
        .route("/api/studies/{id}", delete(api::close).get(api::state))
        .route("/api/studies/{id}/events", get(api::events))
        .route("/api/studies/{id}/axis", post(api::look_at))
        .route("/api/studies/{id}/cancel", post(api::cancel))
        .route("/api/studies/{id}/add", post(api::add))
        .route("/api/studies/{id}/undo", post(api::undo))
        .route("/api/studies/{id}/logs", post(api::read_again))
        .route("/api/studies/{id}/moved", post(api::keep_moved))
        .route("/api/studies/{id}/series", get(api::series))
        .route("/api/studies/{id}/figures", get(api::figures))
        .route("/api/studies/{id}/noise", get(api::noise))
        .route("/api/studies/{id}/strapdown", get(api::strapdown))
        .route("/api/studies/{id}/export/{format}", get(api::export))
        .route("/api/studies/{id}/hubs", get(api::hubs))
        .route("/api/studies/{id}/certificate", get(api::certificate))
        .route("/api/studies/{id}/replay", get(api::replay))
        .route("/api/logs", get(api::logs))
        .route("/api/populations", get(populations::listed))
        .route("/api/population", get(populations::population))
        .route("/api/population/unit", get(populations::unit))
        .route("/api/preview", post(api::preview))
        .route("/api/effects", get(api::effects))
        // added before the limit of all others: a dropped file is large, and streamed to the disk
        .layer(DefaultBodyLimit::max(LARGEST_REQUEST))
        .route("/api/draw", post(api::draw).layer(DefaultBodyLimit::max(LARGEST_FIGURE)))
        .route("/api/uploads", post(api::upload).layer(DefaultBodyLimit::disable()))
        .fallback(assets::asset)
        .with_state(workspace)
        .layer(from_fn_with_state(patience, impatient))
        .layer(from_fn_with_state(names, guard))
}
