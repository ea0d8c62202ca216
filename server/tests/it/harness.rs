//! A server on a free port with a temporary folder, and calls to it.

use bendtwin_proto::v1::{
    capture_service_client::CaptureServiceClient, fit_service_client::FitServiceClient,
    planning_service_client::PlanningServiceClient, rollout_service_client::RolloutServiceClient,
    twin_service_client::TwinServiceClient,
};
use bendtwin_server::{ClientTokenPolicy, Handle, Options, Service};
use serde_json::Value;
use tonic::transport::{Channel, Endpoint};

pub(crate) const TOKEN: &str = "a-token-of-the-tests";

pub(crate) struct Server {
    pub(crate) dir: tempfile::TempDir,
    pub(crate) handle: Handle,
    pub(crate) http: reqwest::Client,
    pub(crate) channel: Channel,
}

/// Options without worker processes, on a free port.
pub(crate) fn options(dir: &tempfile::TempDir) -> Options {
    let mut options = Options {
        listen: ([127, 0, 0, 1], 0).into(),
        data_dir: dir.path().join("data"),
        worker_token: Some(TOKEN.to_owned()),
        client_token: ClientTokenPolicy::None,
        ..Options::default()
    };
    options.workers.count = 0;
    options
}

impl Server {
    pub(crate) async fn start() -> Self {
        Self::start_with(|_| ()).await
    }

    pub(crate) async fn start_with(change: impl FnOnce(&mut Options)) -> Self {
        Self::start_in(tempfile::tempdir().unwrap(), change).await
    }

    /// In a folder that an earlier server may have left.
    pub(crate) async fn start_in(
        dir: tempfile::TempDir,
        change: impl FnOnce(&mut Options),
    ) -> Self {
        let mut options = options(&dir);
        change(&mut options);
        let handle = Service::start(options).await.unwrap();
        let channel = Endpoint::from_shared(format!("http://{}", handle.local_addr()))
            .unwrap()
            .connect_lazy();
        Self { dir, handle, http: reqwest::Client::new(), channel }
    }

    pub(crate) fn url(&self, path: &str) -> String {
        format!("http://{}{path}", self.handle.local_addr())
    }

    pub(crate) async fn get(&self, path: &str) -> (u16, Value) {
        read(self.http.get(self.url(path)).send().await.unwrap()).await
    }

    pub(crate) async fn post(&self, path: &str, body: Value) -> (u16, Value) {
        read(self.http.post(self.url(path)).json(&body).send().await.unwrap()).await
    }

    pub(crate) async fn delete(&self, path: &str) -> (u16, Value) {
        read(self.http.delete(self.url(path)).send().await.unwrap()).await
    }

    /// Deletes a resource for good.
    pub(crate) async fn purge(&self, path: &str) -> (u16, Value) {
        self.delete(&format!("{path}?purge=true")).await
    }

    /// Uploads a capture; returns its name.
    pub(crate) async fn capture(&self) -> String {
        let request = self.http.post(self.url("/v1/captures?display_name=rope"));
        let request = request.header("content-type", "application/zip").body("an archive");
        let (status, capture) = read(request.send().await.unwrap()).await;
        assert_eq!(status, 201, "{capture}");
        capture["name"].as_str().unwrap().to_owned()
    }

    /// Queues a fit of a new capture; returns its name.
    pub(crate) async fn fit(&self) -> String {
        let capture = self.capture().await;
        let (status, fit) = self.post("/v1/fits", serde_json::json!({"capture": capture})).await;
        assert_eq!(status, 202, "{fit}");
        fit["name"].as_str().unwrap().to_owned()
    }

    pub(crate) fn captures(&self) -> CaptureServiceClient<Channel> {
        CaptureServiceClient::new(self.channel.clone())
    }

    pub(crate) fn fits(&self) -> FitServiceClient<Channel> {
        FitServiceClient::new(self.channel.clone())
    }

    pub(crate) fn twins(&self) -> TwinServiceClient<Channel> {
        TwinServiceClient::new(self.channel.clone())
    }

    pub(crate) fn rollouts(&self) -> RolloutServiceClient<Channel> {
        RolloutServiceClient::new(self.channel.clone())
    }

    pub(crate) fn planning(&self) -> PlanningServiceClient<Channel> {
        PlanningServiceClient::new(self.channel.clone())
    }

    /// Removes the file of a blob behind the server's back. False if there is no such file.
    pub(crate) fn lose_blob(&self, digest: &str) -> bool {
        self.blob(digest).is_some_and(|path| std::fs::remove_file(path).is_ok())
    }

    /// The file of a blob.
    pub(crate) fn blob(&self, digest: &str) -> Option<std::path::PathBuf> {
        fn find(folder: &std::path::Path, digest: &str) -> Option<std::path::PathBuf> {
            let paths = std::fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path());
            let has_name = |path: &std::path::Path| path.file_name().unwrap() == digest;
            paths.into_iter().find_map(|path| match path.is_dir() {
                true => find(&path, digest),
                false => has_name(&path).then_some(path),
            })
        }
        find(&self.dir.path().join("data/blobs"), digest)
    }

    /// Bytes of the files below the folder of blobs, its identity apart.
    pub(crate) fn blob_bytes(&self) -> u64 {
        fn sum(path: &std::path::Path) -> u64 {
            let Ok(entries) = std::fs::read_dir(path) else { return 0 };
            let size = |entry: std::fs::DirEntry| match entry.path().is_dir() {
                true => sum(&entry.path()),
                false => entry.metadata().map_or(0, |file| file.len()),
            };
            entries.flatten().map(size).sum()
        }
        let blobs = self.dir.path().join("data/blobs");
        let identity = std::fs::metadata(blobs.join("identity")).map_or(0, |file| file.len());
        sum(&blobs).saturating_sub(identity)
    }

    /// Files below the folder of blobs, its identity apart.
    pub(crate) fn blob_files(&self) -> usize {
        fn count(path: &std::path::Path) -> usize {
            let Ok(entries) = std::fs::read_dir(path) else { return 0 };
            entries.flatten().map(|e| if e.path().is_dir() { count(&e.path()) } else { 1 }).sum()
        }
        count(&self.dir.path().join("data/blobs")) - 1
    }
}

/// Status and JSON body; null if there is no body.
pub(crate) async fn read(response: reqwest::Response) -> (u16, Value) {
    let status = response.status().as_u16();
    let is_json = response
        .headers()
        .get("content-type")
        .is_some_and(|v| v.to_str().unwrap().ends_with("json"));
    let text = response.text().await.unwrap();
    let body = if is_json { serde_json::from_str(&text).unwrap() } else { Value::String(text) };
    (status, body)
}
