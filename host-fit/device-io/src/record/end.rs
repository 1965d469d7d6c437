//! Requests to end from outside: Ctrl-C, and the signals of a shutdown or a closed terminal.

use std::io;
use std::thread;

use tokio::runtime::{Builder, Runtime};

/// From now on such a request does not end the process but calls `end`, in a separate thread.
pub(super) fn when_asked_to_end(end: impl FnOnce() + Send + 'static) -> io::Result<()> {
    let runtime = Builder::new_current_thread().enable_all().build()?;
    let asked = wishes(&runtime)?;
    thread::spawn(move || {
        runtime.block_on(asked);
        end();
    });
    Ok(())
}

#[cfg(unix)]
fn wishes(runtime: &Runtime) -> io::Result<impl Future<Output = ()> + Send + use<>> {
    use tokio::signal::unix::{Signal, SignalKind, signal};

    let _inside = runtime.enter();
    let mut interrupt = signal(SignalKind::interrupt())?;
    let mut terminate = signal(SignalKind::terminate())?;
    // `nohup` has set SIGHUP to be ignored.
    let mut hangup = (!is_hangup_ignored()).then(|| signal(SignalKind::hangup())).transpose()?;
    // A closed pipe only ends the messages; recording continues.
    let mut pipe = signal(SignalKind::pipe())?;
    let hung_up = async move {
        match &mut hangup {
            Some(hangup) => Signal::recv(hangup).await,
            None => std::future::pending().await,
        }
    };
    Ok(async move {
        tokio::select! {
            _ = interrupt.recv() => {}
            _ = terminate.recv() => {}
            _ = hung_up => {}
            () = async { while pipe.recv().await.is_some() {} } => {}
        }
    })
}

#[cfg(not(unix))]
fn wishes(_: &Runtime) -> io::Result<impl Future<Output = ()> + Send + use<>> {
    Ok(async {
        if tokio::signal::ctrl_c().await.is_err() {
            std::future::pending::<()>().await;
        }
    })
}

/// The process was started to outlive its terminal. False if the system does not report it.
#[cfg(unix)]
fn is_hangup_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    // the first bit is signal 1, a hangup
    ignored.is_some_and(|mask| mask & 1 == 1)
}
