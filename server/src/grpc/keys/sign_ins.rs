//! `bendtwin.v1.SignInService`.

use bendtwin_proto::v1::{
    Caller, CreateSignInRequest, CreateSignInResponse, DeleteSignInRequest, DeleteSignInResponse,
    GetCallerRequest, GetSignInOptionsRequest, SignInOptions, StartDeviceSignInRequest,
    StartDeviceSignInResponse, StartSignInRequest, StartSignInResponse,
    sign_in_service_server::SignInService,
};
use tonic::{Request, Response, Status};

use crate::{
    app::{Error, WhoAmI},
    grpc::{Api, convert},
    sign_in::{Challenge, Proof},
};

#[tonic::async_trait]
impl SignInService for Api {
    async fn get_sign_in_options(
        &self,
        _: Request<GetSignInOptionsRequest>,
    ) -> Result<Response<SignInOptions>, Status> {
        let Some(sign_in) = self.app.sign_in_options() else {
            return Ok(Response::new(SignInOptions::default()));
        };
        Ok(Response::new(SignInOptions {
            enabled: true,
            display_name: sign_in.display_name.clone(),
            public_url: sign_in.origin(),
        }))
    }

    async fn start_sign_in(
        &self,
        request: Request<StartSignInRequest>,
    ) -> Result<Response<StartSignInResponse>, Status> {
        let StartSignInRequest { state, nonce, code_challenge } = request.into_inner();
        let challenge = Challenge { state, nonce, code_challenge };
        let authorization_url = self.app.start_sign_in(&challenge).await?;
        Ok(Response::new(StartSignInResponse { authorization_url }))
    }

    async fn start_device_sign_in(
        &self,
        _: Request<StartDeviceSignInRequest>,
    ) -> Result<Response<StartDeviceSignInResponse>, Status> {
        let device = self.app.start_device_sign_in().await?;
        Ok(Response::new(StartDeviceSignInResponse {
            device_code: device.device_code,
            user_code: device.user_code,
            verification_uri: device.verification_uri,
            verification_uri_complete: device.verification_uri_complete.unwrap_or_default(),
            interval_s: device.interval.unwrap_or_default(),
            expires_in_s: device.expires_in,
        }))
    }

    async fn create_sign_in(
        &self,
        request: Request<CreateSignInRequest>,
    ) -> Result<Response<CreateSignInResponse>, Status> {
        let CreateSignInRequest { code, code_verifier, nonce, device_code } = request.into_inner();
        let is_of_browser = [&code, &code_verifier, &nonce].iter().any(|text| !text.is_empty());
        let proof = match (device_code.is_empty(), is_of_browser) {
            (true, _) => Proof::Browser { code, code_verifier, nonce },
            (false, false) => Proof::Device { code: device_code },
            (false, true) => {
                let fault = "is that of a device, which has no code, code_verifier and nonce: send one \
                             or the other";
                return Err(Error::invalid("device_code", fault).into());
            }
        };
        let (key, secret_key) = self.app.create_sign_in(proof).await?;
        Ok(Response::new(CreateSignInResponse { key: Some(convert::key(key)), secret_key }))
    }

    async fn delete_sign_in(
        &self,
        _: Request<DeleteSignInRequest>,
    ) -> Result<Response<DeleteSignInResponse>, Status> {
        self.app.delete_sign_in().await?;
        Ok(Response::new(DeleteSignInResponse {}))
    }

    async fn get_caller(&self, _: Request<GetCallerRequest>) -> Result<Response<Caller>, Status> {
        let WhoAmI { owner, scopes, key } = self.app.who_am_i().await?;
        let expire_time =
            key.as_ref().and_then(|key| key.expires).map(bendtwin_proto::json::timestamp);
        Ok(Response::new(Caller {
            owner,
            scopes,
            is_sign_in: key.as_ref().is_some_and(|key| key.signed_in_as.is_some()),
            key: key.map(|key| key.id.to_string()).unwrap_or_default(),
            expire_time,
        }))
    }
}
