//! Connections: how many there are at once, how long a silent one is kept, and how they end.

use crate::addresses::Addresses;
use crate::catalogue::Catalogue;
use crate::error::ServeError;
use crate::metrics::Metrics;
use crate::options::ServeOptions;
use crate::paced::Paced;
use axum::{Extension, Router};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::future::Future;
use std::io::ErrorKind;
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Semaphore, watch};
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};

/// Time until connections are accepted again after the system refused one.
const REST: Duration = Duration::from_millis(50);
/// What a connection beyond the limit is told.
const FULL: &[u8] = b"HTTP/1.1 503 Service Unavailable\r\nRetry-After: 1\r\nContent-Length: 0\r\n\
    Connection: close\r\n\r\n";
/// What a connection beyond the limit of its address is told (RFC 6585, section 4).
const FULL_OF_ADDRESS: &[u8] =
    b"HTTP/1.1 429 Too Many Requests\r\nRetry-After: 1\r\nContent-Length: 0\r\n\
    Connection: close\r\n\r\n";

/// Answers connections until `stop` ends; those that are open then have a time to end.
pub(crate) async fn answer(
    listener: TcpListener,
    routes: Router,
    catalogue: &Catalogue,
    stop: impl Future<Output = ()>,
) -> Result<(), ServeError> {
    let options = catalogue.options();
    let places = Arc::new(Semaphore::new(options.most_connections));
    let addresses = Addresses::new(options.most_of_address);
    let ending = watch::Sender::new(());
    let mut connections = JoinSet::new();
    let mut stop = pin!(stop);
    loop {
        let (stream, peer) = tokio::select! {
            () = &mut stop => break,
            Some(_) = connections.join_next() => continue,
            accepted = listener.accept() => match accepted {
                Ok(accepted) => accepted,
                Err(error) if error.kind() == ErrorKind::InvalidInput => return Err(error.into()),
                Err(_) => {
                    // No more files may be open: others end first.
                    sleep(REST).await;
                    continue;
                }
            },
        };
        let Ok(place) = Arc::clone(&places).try_acquire_owned() else {
            Metrics::add(&catalogue.metrics().overloaded, 1);
            let _ = stream.try_write(FULL);
            continue;
        };
        let Some(of_address) = addresses.open(peer.ip()) else {
            Metrics::add(&catalogue.metrics().overloaded, 1);
            let _ = stream.try_write(FULL_OF_ADDRESS);
            continue;
        };
        // A session goes on with the place of its connection.
        let routes = routes.clone().layer(Extension(of_address));
        let catalogue = catalogue.clone();
        let is_over = ending.subscribe();
        connections.spawn(async move {
            run(stream, routes, catalogue.options(), is_over).await;
            drop(place);
        });
    }
    drop(listener);
    ending.send_replace(());
    let ended = async { while connections.join_next().await.is_some() {} };
    // Those that are left are cut off.
    let _ = timeout(options.drain, ended).await;
    Ok(())
}

/// Answers the requests of a connection.
async fn run(
    stream: TcpStream,
    routes: Router,
    options: &ServeOptions,
    mut is_over: watch::Receiver<()>,
) {
    // Messages of sessions are small and wanted at once.
    let _ = stream.set_nodelay(true);
    let stream = Paced::new(stream, options.throttle_bps, options.patience);
    let mut builder = http1::Builder::new();
    builder
        .timer(TokioTimer::new())
        .header_read_timeout(options.silence);
    let service = TowerToHyperService::new(routes);
    let connection = builder.serve_connection(TokioIo::new(stream), service);
    let mut connection = pin!(connection.with_upgrades());
    tokio::select! {
        // What a client does wrong ends its own connection alone.
        _ = connection.as_mut() => return,
        _ = is_over.changed() => connection.as_mut().graceful_shutdown(),
    }
    let _ = connection.await;
}
