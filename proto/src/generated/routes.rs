&[
Rpc { path: "/bendtwin.v1.CaptureService/CreateCapture", scope: Scope::CapturesWrite, audited: true, routes: &[
    Route { method: "POST", path: "/v1/captures", status: 201, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.CaptureService/GetCapture", scope: Scope::CapturesRead, audited: false, routes: &[
    Route { method: "GET", path: "/v1/captures/{id}", status: 200, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::GetCaptureRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::Capture>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.CaptureService/ListCaptures", scope: Scope::CapturesRead, audited: false, routes: &[
    Route { method: "GET", path: "/v1/captures", status: 200, secret: false, messages: Some(Messages { source: Source::Query, has_request_id: false, read: |given| read::<crate::v1::ListCapturesRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::ListCapturesResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.CaptureService/UpdateCapture", scope: Scope::CapturesWrite, audited: true, routes: &[
    Route { method: "PATCH", path: "/v1/captures/{id}", status: 200, secret: false, messages: Some(Messages { source: Source::Body, has_request_id: false, read: |given| read::<crate::v1::UpdateCaptureRequest>(given, |message, given| { message.capture.get_or_insert_default().name = given.id.to_owned(); }), write: |reply| write::<crate::v1::Capture>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.CaptureService/DeleteCapture", scope: Scope::CapturesWrite, audited: true, routes: &[
    Route { method: "DELETE", path: "/v1/captures/{id}", status: 204, secret: false, messages: Some(Messages { source: Source::Query, has_request_id: false, read: |given| read::<crate::v1::DeleteCaptureRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::DeleteCaptureResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.CaptureService/IngestCapture", scope: Scope::CapturesWrite, audited: true, routes: &[
    Route { method: "POST", path: "/v1/captures/{id}/ingest", status: 202, secret: false, messages: Some(Messages { source: Source::Body, has_request_id: true, read: |given| read::<crate::v1::IngestCaptureRequest>(given, |message, given| { message.name = given.id.to_owned(); message.request_id = given.request_id.to_owned(); }), write: |reply| write::<crate::v1::Capture>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.CaptureService/CancelIngest", scope: Scope::CapturesWrite, audited: true, routes: &[
    Route { method: "POST", path: "/v1/captures/{id}/ingest/cancel", status: 200, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::CancelIngestRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::Capture>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.CaptureService/WatchIngest", scope: Scope::CapturesRead, audited: false, routes: &[
    Route { method: "GET", path: "/v1/captures/{id}/events", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.CaptureService/GetCaptureReport", scope: Scope::CapturesRead, audited: false, routes: &[
    Route { method: "GET", path: "/v1/captures/{id}/report", status: 200, secret: false, messages: None },
    Route { method: "GET", path: "/v1/captures/{id}/report.html", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.CaptureService/ExportObservation", scope: Scope::CapturesRead, audited: false, routes: &[
    Route { method: "GET", path: "/v1/captures/{id}/observation", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.CaptureService/ExportMasks", scope: Scope::CapturesRead, audited: false, routes: &[
    Route { method: "GET", path: "/v1/captures/{id}/masks", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.CaptureService/AddSupplement", scope: Scope::CapturesWrite, audited: true, routes: &[
    Route { method: "PUT", path: "/v1/captures/{id}/supplements/{kind}", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.CaptureService/ExportSupplement", scope: Scope::CapturesRead, audited: false, routes: &[
    Route { method: "GET", path: "/v1/captures/{id}/supplements/{kind}", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.CaptureService/DeleteSupplement", scope: Scope::CapturesWrite, audited: true, routes: &[
    Route { method: "DELETE", path: "/v1/captures/{id}/supplements/{kind}", status: 204, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.FitService/CreateFit", scope: Scope::FitsWrite, audited: true, routes: &[
    Route { method: "POST", path: "/v1/fits", status: 202, secret: false, messages: Some(Messages { source: Source::Body, has_request_id: true, read: |given| read::<crate::v1::CreateFitRequest>(given, |message, given| { message.request_id = given.request_id.to_owned(); }), write: |reply| write::<crate::v1::Fit>(reply, Some(|message| Some(&message.name))) }) },] },
Rpc { path: "/bendtwin.v1.FitService/GetFit", scope: Scope::FitsRead, audited: false, routes: &[
    Route { method: "GET", path: "/v1/fits/{id}", status: 200, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::GetFitRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::Fit>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.FitService/ListFits", scope: Scope::FitsRead, audited: false, routes: &[
    Route { method: "GET", path: "/v1/fits", status: 200, secret: false, messages: Some(Messages { source: Source::Query, has_request_id: false, read: |given| read::<crate::v1::ListFitsRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::ListFitsResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.FitService/UpdateFit", scope: Scope::FitsWrite, audited: true, routes: &[
    Route { method: "PATCH", path: "/v1/fits/{id}", status: 200, secret: false, messages: Some(Messages { source: Source::Body, has_request_id: false, read: |given| read::<crate::v1::UpdateFitRequest>(given, |message, given| { message.fit.get_or_insert_default().name = given.id.to_owned(); }), write: |reply| write::<crate::v1::Fit>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.FitService/GetFitLosses", scope: Scope::FitsRead, audited: false, routes: &[
    Route { method: "GET", path: "/v1/fits/{id}/losses", status: 200, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::GetFitLossesRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::FitLosses>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.FitService/GetFitPreview", scope: Scope::FitsRead, audited: false, routes: &[
    Route { method: "GET", path: "/v1/fits/{id}/preview", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.FitService/CancelFit", scope: Scope::FitsWrite, audited: true, routes: &[
    Route { method: "POST", path: "/v1/fits/{id}/cancel", status: 200, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::CancelFitRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::Fit>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.FitService/DeleteFit", scope: Scope::FitsWrite, audited: true, routes: &[
    Route { method: "DELETE", path: "/v1/fits/{id}", status: 204, secret: false, messages: Some(Messages { source: Source::Query, has_request_id: false, read: |given| read::<crate::v1::DeleteFitRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::DeleteFitResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.FitService/WatchFit", scope: Scope::FitsRead, audited: false, routes: &[
    Route { method: "GET", path: "/v1/fits/{id}/events", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.TwinService/CreateTwin", scope: Scope::TwinsWrite, audited: true, routes: &[
    Route { method: "POST", path: "/v1/twins", status: 201, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.TwinService/GetTwin", scope: Scope::TwinsRead, audited: false, routes: &[
    Route { method: "GET", path: "/v1/twins/{id}", status: 200, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::GetTwinRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::Twin>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.TwinService/ListTwins", scope: Scope::TwinsRead, audited: false, routes: &[
    Route { method: "GET", path: "/v1/twins", status: 200, secret: false, messages: Some(Messages { source: Source::Query, has_request_id: false, read: |given| read::<crate::v1::ListTwinsRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::ListTwinsResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.TwinService/UpdateTwin", scope: Scope::TwinsWrite, audited: true, routes: &[
    Route { method: "PATCH", path: "/v1/twins/{id}", status: 200, secret: false, messages: Some(Messages { source: Source::Body, has_request_id: false, read: |given| read::<crate::v1::UpdateTwinRequest>(given, |message, given| { message.twin.get_or_insert_default().name = given.id.to_owned(); }), write: |reply| write::<crate::v1::Twin>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.TwinService/DeleteTwin", scope: Scope::TwinsWrite, audited: true, routes: &[
    Route { method: "DELETE", path: "/v1/twins/{id}", status: 204, secret: false, messages: Some(Messages { source: Source::Query, has_request_id: false, read: |given| read::<crate::v1::DeleteTwinRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::DeleteTwinResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.TwinService/ExportTwin", scope: Scope::TwinsRead, audited: false, routes: &[
    Route { method: "GET", path: "/v1/twins/{id}/content", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.TwinService/GetTwinGeometry", scope: Scope::TwinsRead, audited: false, routes: &[
    Route { method: "GET", path: "/v1/twins/{id}/geometry", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.TwinService/GetTwinSurface", scope: Scope::TwinsRead, audited: false, routes: &[
    Route { method: "GET", path: "/v1/twins/{id}/surface", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.TrashService/ListTrashedCaptures", scope: Scope::CapturesRead, audited: false, routes: &[
    Route { method: "GET", path: "/v1/trash/captures", status: 200, secret: false, messages: Some(Messages { source: Source::Query, has_request_id: false, read: |given| read::<crate::v1::ListTrashedCapturesRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::ListTrashedCapturesResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.TrashService/ListTrashedFits", scope: Scope::FitsRead, audited: false, routes: &[
    Route { method: "GET", path: "/v1/trash/fits", status: 200, secret: false, messages: Some(Messages { source: Source::Query, has_request_id: false, read: |given| read::<crate::v1::ListTrashedFitsRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::ListTrashedFitsResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.TrashService/ListTrashedTwins", scope: Scope::TwinsRead, audited: false, routes: &[
    Route { method: "GET", path: "/v1/trash/twins", status: 200, secret: false, messages: Some(Messages { source: Source::Query, has_request_id: false, read: |given| read::<crate::v1::ListTrashedTwinsRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::ListTrashedTwinsResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.TrashService/UndeleteCapture", scope: Scope::CapturesWrite, audited: true, routes: &[
    Route { method: "POST", path: "/v1/captures/{id}/undelete", status: 200, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::UndeleteCaptureRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::Capture>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.TrashService/UndeleteFit", scope: Scope::FitsWrite, audited: true, routes: &[
    Route { method: "POST", path: "/v1/fits/{id}/undelete", status: 200, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::UndeleteFitRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::Fit>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.TrashService/UndeleteTwin", scope: Scope::TwinsWrite, audited: true, routes: &[
    Route { method: "POST", path: "/v1/twins/{id}/undelete", status: 200, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::UndeleteTwinRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::Twin>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.RetentionService/CreateRetentionRule", scope: Scope::Admin, audited: true, routes: &[
    Route { method: "POST", path: "/v1/retention", status: 201, secret: false, messages: Some(Messages { source: Source::Body, has_request_id: false, read: |given| read::<crate::v1::CreateRetentionRuleRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::RetentionRule>(reply, Some(|message| Some(&message.name))) }) },] },
Rpc { path: "/bendtwin.v1.RetentionService/GetRetentionRule", scope: Scope::Admin, audited: false, routes: &[
    Route { method: "GET", path: "/v1/retention/{id}", status: 200, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::GetRetentionRuleRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::RetentionRule>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.RetentionService/ListRetentionRules", scope: Scope::Admin, audited: false, routes: &[
    Route { method: "GET", path: "/v1/retention", status: 200, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::ListRetentionRulesRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::ListRetentionRulesResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.RetentionService/DeleteRetentionRule", scope: Scope::Admin, audited: true, routes: &[
    Route { method: "DELETE", path: "/v1/retention/{id}", status: 204, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::DeleteRetentionRuleRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::DeleteRetentionRuleResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.RetentionService/PreviewRetention", scope: Scope::Admin, audited: false, routes: &[
    Route { method: "GET", path: "/v1/retention-preview", status: 200, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::PreviewRetentionRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::PreviewRetentionResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.WorkerService/GetWorker", scope: Scope::Anyone, audited: false, routes: &[
    Route { method: "GET", path: "/v1/workers/{id}", status: 200, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::GetWorkerRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::Worker>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.WorkerService/ListWorkers", scope: Scope::Anyone, audited: false, routes: &[
    Route { method: "GET", path: "/v1/workers", status: 200, secret: false, messages: Some(Messages { source: Source::Query, has_request_id: false, read: |given| read::<crate::v1::ListWorkersRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::ListWorkersResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.WorkerService/DrainWorker", scope: Scope::Admin, audited: false, routes: &[
    Route { method: "POST", path: "/v1/workers/{id}/drain", status: 200, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::DrainWorkerRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::Worker>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.KeyService/CreateKey", scope: Scope::Admin, audited: true, routes: &[
    Route { method: "POST", path: "/v1/keys", status: 201, secret: true, messages: Some(Messages { source: Source::Body, has_request_id: false, read: |given| read::<crate::v1::CreateKeyRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::CreateKeyResponse>(reply, Some(|message| message.key.as_ref().map(|made| &made.name))) }) },] },
Rpc { path: "/bendtwin.v1.KeyService/GetKey", scope: Scope::Admin, audited: false, routes: &[
    Route { method: "GET", path: "/v1/keys/{id}", status: 200, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::GetKeyRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::Key>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.KeyService/ListKeys", scope: Scope::Admin, audited: false, routes: &[
    Route { method: "GET", path: "/v1/keys", status: 200, secret: false, messages: Some(Messages { source: Source::Query, has_request_id: false, read: |given| read::<crate::v1::ListKeysRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::ListKeysResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.KeyService/DeleteKey", scope: Scope::Admin, audited: true, routes: &[
    Route { method: "DELETE", path: "/v1/keys/{id}", status: 204, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::DeleteKeyRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::DeleteKeyResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.ShareService/ShareTwin", scope: Scope::TwinsWrite, audited: true, routes: &[
    Route { method: "POST", path: "/v1/twins/{id}/shares", status: 201, secret: true, messages: Some(Messages { source: Source::Body, has_request_id: false, read: |given| read::<crate::v1::ShareTwinRequest>(given, |message, given| { message.twin = given.id.to_owned(); }), write: |reply| write::<crate::v1::ShareTwinResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.ShareService/ListShares", scope: Scope::TwinsWrite, audited: false, routes: &[
    Route { method: "GET", path: "/v1/twins/{id}/shares", status: 200, secret: false, messages: Some(Messages { source: Source::Query, has_request_id: false, read: |given| read::<crate::v1::ListSharesRequest>(given, |message, given| { message.twin = given.id.to_owned(); }), write: |reply| write::<crate::v1::ListSharesResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.ShareService/DeleteShare", scope: Scope::TwinsWrite, audited: true, routes: &[
    Route { method: "DELETE", path: "/v1/shares/{id}", status: 204, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::DeleteShareRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::DeleteShareResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.ProjectService/CreateProject", scope: Scope::Admin, audited: true, routes: &[
    Route { method: "POST", path: "/v1/projects", status: 201, secret: false, messages: Some(Messages { source: Source::Body, has_request_id: false, read: |given| read::<crate::v1::CreateProjectRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::Project>(reply, Some(|message| Some(&message.name))) }) },] },
Rpc { path: "/bendtwin.v1.ProjectService/GetProject", scope: Scope::Anyone, audited: false, routes: &[
    Route { method: "GET", path: "/v1/projects/{id}", status: 200, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::GetProjectRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::Project>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.ProjectService/ListProjects", scope: Scope::Anyone, audited: false, routes: &[
    Route { method: "GET", path: "/v1/projects", status: 200, secret: false, messages: Some(Messages { source: Source::Query, has_request_id: false, read: |given| read::<crate::v1::ListProjectsRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::ListProjectsResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.ProjectService/UpdateProject", scope: Scope::Admin, audited: true, routes: &[
    Route { method: "PATCH", path: "/v1/projects/{id}", status: 200, secret: false, messages: Some(Messages { source: Source::Body, has_request_id: false, read: |given| read::<crate::v1::UpdateProjectRequest>(given, |message, given| { message.project.get_or_insert_default().name = given.id.to_owned(); }), write: |reply| write::<crate::v1::Project>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.ProjectService/DeleteProject", scope: Scope::Admin, audited: true, routes: &[
    Route { method: "DELETE", path: "/v1/projects/{id}", status: 204, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::DeleteProjectRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::DeleteProjectResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.UsageService/GetUsage", scope: Scope::Anyone, audited: false, routes: &[
    Route { method: "GET", path: "/v1/usage", status: 200, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::GetUsageRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::OwnerUsage>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.UsageService/ListOwnerUsage", scope: Scope::Admin, audited: false, routes: &[
    Route { method: "GET", path: "/v1/usage/owners", status: 200, secret: false, messages: Some(Messages { source: Source::Query, has_request_id: false, read: |given| read::<crate::v1::ListOwnerUsageRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::ListOwnerUsageResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.SignInService/GetSignInOptions", scope: Scope::Open, audited: false, routes: &[
    Route { method: "GET", path: "/v1/sign-in", status: 200, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::GetSignInOptionsRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::SignInOptions>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.SignInService/StartSignIn", scope: Scope::Open, audited: false, routes: &[
    Route { method: "POST", path: "/v1/sign-in/start", status: 200, secret: false, messages: Some(Messages { source: Source::Body, has_request_id: false, read: |given| read::<crate::v1::StartSignInRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::StartSignInResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.SignInService/StartDeviceSignIn", scope: Scope::Open, audited: false, routes: &[
    Route { method: "POST", path: "/v1/sign-in/device", status: 200, secret: true, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::StartDeviceSignInRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::StartDeviceSignInResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.SignInService/CreateSignIn", scope: Scope::Open, audited: true, routes: &[
    Route { method: "POST", path: "/v1/sign-in", status: 201, secret: true, messages: Some(Messages { source: Source::Body, has_request_id: false, read: |given| read::<crate::v1::CreateSignInRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::CreateSignInResponse>(reply, Some(|message| message.key.as_ref().map(|made| &made.name))) }) },] },
Rpc { path: "/bendtwin.v1.SignInService/DeleteSignIn", scope: Scope::Anyone, audited: true, routes: &[
    Route { method: "DELETE", path: "/v1/sign-in", status: 204, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::DeleteSignInRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::DeleteSignInResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.SignInService/GetCaller", scope: Scope::Anyone, audited: false, routes: &[
    Route { method: "GET", path: "/v1/caller", status: 200, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::GetCallerRequest>(given, |_, _| {  }), write: |reply| write::<crate::v1::Caller>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.RolloutService/RollOut", scope: Scope::RolloutsRun, audited: false, routes: &[
    Route { method: "POST", path: "/v1/twins/{id}/rollouts", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.RolloutService/StreamRollOut", scope: Scope::RolloutsRun, audited: false, routes: &[
    Route { method: "POST", path: "/v1/twins/{id}/rollouts/stream", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.PlanningService/Plan", scope: Scope::RolloutsRun, audited: false, routes: &[
    Route { method: "POST", path: "/v1/plans", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.RegistrationService/RegisterState", scope: Scope::RolloutsRun, audited: false, routes: &[
    Route { method: "POST", path: "/v1/twins/{id}/register", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.EvaluationService/EvaluateTwin", scope: Scope::RolloutsRun, audited: false, routes: &[
    Route { method: "POST", path: "/v1/twins/{id}/evaluations", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.SessionService/OpenSession", scope: Scope::RolloutsRun, audited: false, routes: &[
    Route { method: "POST", path: "/v1/sessions", status: 201, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.SessionService/GetSession", scope: Scope::RolloutsRun, audited: false, routes: &[
    Route { method: "GET", path: "/v1/sessions/{id}", status: 200, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::GetSessionRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::Session>(reply, None) }) },] },
Rpc { path: "/bendtwin.v1.SessionService/GetSessionStates", scope: Scope::RolloutsRun, audited: false, routes: &[
    Route { method: "GET", path: "/v1/sessions/{id}/states", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.SessionService/AdvanceSession", scope: Scope::RolloutsRun, audited: false, routes: &[
    Route { method: "POST", path: "/v1/sessions/{id}/advance", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.SessionService/ControlSession", scope: Scope::RolloutsRun, audited: false, routes: &[] },
Rpc { path: "/bendtwin.v1.SessionService/ForkSession", scope: Scope::RolloutsRun, audited: false, routes: &[
    Route { method: "POST", path: "/v1/sessions/{id}/fork", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.SessionService/ResetSession", scope: Scope::RolloutsRun, audited: false, routes: &[
    Route { method: "POST", path: "/v1/sessions/{id}/reset", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.SessionService/CorrectSession", scope: Scope::RolloutsRun, audited: false, routes: &[
    Route { method: "POST", path: "/v1/sessions/{id}/correct", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.SessionService/StepSession", scope: Scope::RolloutsRun, audited: false, routes: &[
    Route { method: "POST", path: "/v1/sessions/{id}/step", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.SessionService/RenderSession", scope: Scope::RolloutsRun, audited: false, routes: &[
    Route { method: "POST", path: "/v1/sessions/{id}/render", status: 200, secret: false, messages: None },] },
Rpc { path: "/bendtwin.v1.SessionService/CloseSession", scope: Scope::RolloutsRun, audited: false, routes: &[
    Route { method: "DELETE", path: "/v1/sessions/{id}", status: 204, secret: false, messages: Some(Messages { source: Source::Nothing, has_request_id: false, read: |given| read::<crate::v1::CloseSessionRequest>(given, |message, given| { message.name = given.id.to_owned(); }), write: |reply| write::<crate::v1::CloseSessionResponse>(reply, None) }) },] },
Rpc { path: "/bendtwin.worker.v1.WorkerLink/Register", scope: Scope::Worker, audited: false, routes: &[] },
Rpc { path: "/bendtwin.worker.v1.WorkerLink/Heartbeat", scope: Scope::Worker, audited: false, routes: &[] },
Rpc { path: "/bendtwin.worker.v1.WorkerLink/LeaseJob", scope: Scope::Worker, audited: false, routes: &[] },
Rpc { path: "/bendtwin.worker.v1.WorkerLink/ReportJob", scope: Scope::Worker, audited: false, routes: &[] },
Rpc { path: "/bendtwin.worker.v1.WorkerLink/SaveCheckpoint", scope: Scope::Worker, audited: false, routes: &[] },
Rpc { path: "/bendtwin.worker.v1.WorkerLink/CompleteFit", scope: Scope::Worker, audited: false, routes: &[] },
Rpc { path: "/bendtwin.worker.v1.WorkerLink/EndIngest", scope: Scope::Worker, audited: false, routes: &[] },
Rpc { path: "/bendtwin.worker.v1.WorkerLink/FailJob", scope: Scope::Worker, audited: false, routes: &[] },
Rpc { path: "/bendtwin.worker.v1.WorkerLink/Leave", scope: Scope::Worker, audited: false, routes: &[] },
Rpc { path: "/bendtwin.worker.v1.WorkerLink/Download", scope: Scope::Worker, audited: false, routes: &[] },
]
