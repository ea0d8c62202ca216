// Written by `npm run generate` in console from /openapi.json.

export interface paths {
    "/healthz": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Liveness */
        get: operations["GetHealth"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/metrics": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Metrics for Prometheus
         * @description While the database does not answer, what comes from it stays as it was read last: `bendtwin_store_up` is 0.
         */
        get: operations["GetMetrics"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/readyz": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Readiness */
        get: operations["GetReadiness"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/caller": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Get caller
         * @description The caller, as the server knows it.
         */
        get: operations["GetCaller"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/captures": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** List captures */
        get: operations["ListCaptures"];
        put?: never;
        /**
         * Upload a capture
         * @description The body is the archive, ZIP or tar, or an MCAP file. It is read in the background: `ingest` in the response has the progress. The same archive under the same `Idempotency-Key` answers with the existing capture.
         */
        post: operations["CreateCapture"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/captures/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Get capture */
        get: operations["GetCapture"];
        put?: never;
        post?: never;
        /**
         * Delete capture
         * @description Moves a capture to the trash, with what ingests made of it and its supplements; an ingest that is queued or running ends. Refused with FAILED_PRECONDITION while a fit of the capture is queued or running. Its twins are kept.
         */
        delete: operations["DeleteCapture"];
        options?: never;
        head?: never;
        /**
         * Update capture
         * @description Changes display name, note, tags and who recorded it.
         */
        patch: operations["UpdateCapture"];
        trace?: never;
    };
    "/v1/captures/{id}/content": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Download the archive of a capture */
        get: operations["GetCaptureContent"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/captures/{id}/events": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Watch ingest
         * @description The capture now and after every change of its ingest, until the ingest has ended. Over HTTP events named `capture`, with the revision of the ingest as id; `Last-Event-ID` skips what is known.
         */
        get: operations["WatchIngest"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/captures/{id}/ingest": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Ingest capture
         * @description Runs the ingest again, for example with other settings. Refused with FAILED_PRECONDITION while an ingest or a fit of the capture is queued or running.
         */
        post: operations["IngestCapture"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/captures/{id}/ingest/cancel": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Cancel ingest
         * @description Asks the ingest to stop; an ingest that has ended is returned unchanged.
         */
        post: operations["CancelIngest"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/captures/{id}/masks": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Download the masks of a capture
         * @description Masks that the last ingest made of the strokes in its settings, in the layout of a raw PhysTwin case, with `mask/following.json` beside them (docs/formats/capture.md). Reason `CAPTURE_HAS_NO_MASKS` if there are none.
         */
        get: operations["ExportMasks"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/captures/{id}/observation": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Download the observation of a capture
         * @description The bundle that fits read: tracked points in space, whatever the format of the capture.
         */
        get: operations["ExportObservation"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/captures/{id}/playback": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Download the playback of a capture
         * @description What a player shows, for reading by ranges: tracked points as 16-bit numbers and small images of the cameras (docs/formats/playback.md). A capture that was read before there were playbacks has none until its ingest is run again.
         */
        get: operations["GetPlayback"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/captures/{id}/report": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** The report of a capture */
        get: operations["GetCaptureReport"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/captures/{id}/report.html": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * The report of a capture as a page
         * @description The pictures are embedded. The page has no scripts, and its security policy allows none.
         */
        get: operations["GetCaptureReportPage"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/captures/{id}/supplements/{kind}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Download a file that was added to a capture */
        get: operations["ExportSupplement"];
        /**
         * Add a file to a capture
         * @description The body is the file: for `masks` an archive with a folder `mask`, for `calibration` a JSON document. It takes the place of the one of its kind, and the next ingest reads it. The same content again changes nothing.
         */
        put: operations["AddSupplement"];
        post?: never;
        /** Remove a file that was added to a capture */
        delete: operations["DeleteSupplement"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/captures/{id}/thumbnail": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * A small picture of a capture
         * @description The first image of its first camera, in its own size, or its points on a transparent background.
         */
        get: operations["GetCaptureThumbnail"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/captures/{id}/undelete": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Undelete capture
         * @description Restores a deleted capture, with its ingest: one that was queued or running is queued again. A capture that is not in the trash is returned unchanged.
         */
        post: operations["UndeleteCapture"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/fits": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** List fits */
        get: operations["ListFits"];
        put?: never;
        /**
         * Create fit
         * @description Queues a fit.
         */
        post: operations["CreateFit"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/fits/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Get fit */
        get: operations["GetFit"];
        put?: never;
        post?: never;
        /**
         * Delete fit
         * @description Moves a fit to the trash; one that is queued waits no more. Refused with FAILED_PRECONDITION while the fit runs: cancel it first. Its twin is kept.
         */
        delete: operations["DeleteFit"];
        options?: never;
        head?: never;
        /**
         * Update fit
         * @description Changes display name, note and tags.
         */
        patch: operations["UpdateFit"];
        trace?: never;
    };
    "/v1/fits/{id}/cancel": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Cancel fit
         * @description Asks a queued or running fit to stop; a fit that has ended is returned unchanged.
         */
        post: operations["CancelFit"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/fits/{id}/events": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Watch fit
         * @description The fit now and after every change, until it has ended. Over HTTP events named `fit`, with the revision as id; `Last-Event-ID` skips what is known.
         */
        get: operations["WatchFit"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/fits/{id}/losses": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Get fit losses
         * @description The losses of all iterations so far, by stage and model. They stay until the fit is deleted.
         */
        get: operations["GetFitLosses"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/fits/{id}/preview": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Get fit preview
         * @description What the fit has so far: the motion that its best parameters predict, and their error. Renewed every few iterations while the fit searches and refines; dropped once it has a twin. NOT_FOUND with reason PREVIEW_MISSING without one.
         */
        get: operations["GetFitPreview"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/fits/{id}/undelete": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Undelete fit
         * @description Restores a deleted fit. One that was queued is queued again, or ends if its capture is gone or cannot be fitted. A fit that is not in the trash is returned unchanged.
         */
        post: operations["UndeleteFit"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/keys": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * List keys
         * @description All keys, newest first, revoked and expired ones included.
         */
        get: operations["ListKeys"];
        put?: never;
        /**
         * Create key
         * @description Creates a key. Its text is only in this reply: the server stores a hash.
         */
        post: operations["CreateKey"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/keys/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Get key */
        get: operations["GetKey"];
        put?: never;
        post?: never;
        /**
         * Delete key
         * @description Revokes a key, with the shares that were made with it: after 30 s no server accepts them any more. They stay in the list, with their `revoke_time`. The key of a sign-in ends the shares of its person.
         */
        delete: operations["DeleteKey"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/plans": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Plan
         * @description Sends an update with the best plan after each iteration, and a last one. The best plan is never worse than the nominal plan: every returned plan was simulated, with the returned cost. A plan beyond a limit of the strain of the material or of the force of a grasp is worse than every plan within both, regardless of the cost; among plans beyond a limit the one with the least excess is best, which is the sum of (found - limit) / limit over both. Over HTTP events named `update`; closing the connection stops the work.
         */
        post: operations["Plan"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/plays/{id}/recording": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Recording of a play
         * @description The last recording of a play that is under way. Each segment is the body of a rollout.
         */
        get: operations["GetPlayRecording"];
        /**
         * Put a recording
         * @description In the place of the last one of a play, to be shown again there.
         */
        put: operations["PutPlayRecording"];
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/plays/{id}/watch": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Watch a play
         * @description A WebSocket on which the states of a play come, for any number of browsers; they move nothing.
         */
        get: operations["WatchPlay"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/projects": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * List projects
         * @description The projects that the owner of the key is a member of, newest first; with the scope `admin` all projects.
         */
        get: operations["ListProjects"];
        put?: never;
        /** Create project */
        post: operations["CreateProject"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/projects/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Get project
         * @description With any key a project of its owner, with the scope `admin` any project.
         */
        get: operations["GetProject"];
        put?: never;
        post?: never;
        /**
         * Delete project
         * @description Deletes a project. Its members keep what they have, and no longer share it.
         */
        delete: operations["DeleteProject"];
        options?: never;
        head?: never;
        /**
         * Update project
         * @description Changes name and members. A change takes effect immediately at the server that receives it, and within 30 s at the others.
         */
        patch: operations["UpdateProject"];
        trace?: never;
    };
    "/v1/retention": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * List retention rules
         * @description All rules, those of the server's configuration first.
         */
        get: operations["ListRetentionRules"];
        put?: never;
        /** Create retention rule */
        post: operations["CreateRetentionRule"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/retention-preview": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Preview retention
         * @description What the rules would delete now, and what matches a rule but is kept, with the reason. Changes nothing.
         */
        get: operations["PreviewRetention"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/retention/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Get retention rule */
        get: operations["GetRetentionRule"];
        put?: never;
        post?: never;
        /**
         * Delete retention rule
         * @description Rules of the server's configuration cannot be deleted.
         */
        delete: operations["DeleteRetentionRule"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/sessions": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Open session
         * @description Opens simulations of a twin that stay at a worker until they are closed, or until nobody has used them for `idle_timeout_s`.
         */
        post: operations["OpenSession"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/sessions/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Get session */
        get: operations["GetSession"];
        put?: never;
        post?: never;
        /**
         * Close session
         * @description Closes a session. It is no error if it has ended.
         */
        delete: operations["CloseSession"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/sessions/{id}/advance": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Advance session
         * @description Simulates a rollout from the states of slots, and stores the final states in the slots. The slots do not change if the rollout fails or an instance diverges.
         */
        post: operations["AdvanceSession"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/sessions/{id}/correct": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Correct session
         * @description Moves the states of slots towards an observation, in place. The correction is smooth, leaves nodes held by control points and grasps where they are, and keeps nodes outside of the ground and of colliders, on the side where they were. The rest shapes of the slots are corrected too (CorrectOptions.carry), and apply to everything simulated from these slots afterwards. Ends with FAILED_PRECONDITION if the remaining residual of a slot is above the given limit, reason OBSERVATION_NOT_EXPLAINED, or OBJECT_LOST for a slot that is lost (Tracking); no state changes then.
         */
        post: operations["CorrectSession"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/sessions/{id}/fork": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Fork session
         * @description Copies the state and the rest shape of a slot to other slots.
         */
        post: operations["ForkSession"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/sessions/{id}/render": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Render session
         * @description Renders the states of slots as cameras see them, over backgrounds and beside props. Nothing changes.
         */
        post: operations["RenderSession"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/sessions/{id}/reset": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Reset session
         * @description Resets slots to the session's first state, or to a given one, and to the rest shape of the twin.
         */
        post: operations["ResetSession"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/sessions/{id}/states": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Get session states
         * @description The states of slots, as `initial.given` takes them, without the rest shapes that corrections gave them.
         */
        get: operations["GetSessionStates"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/sessions/{id}/step": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Step session
         * @description A step of a closed loop: corrects a slot by an observation, plans from the corrected state, and advances the slot by the first frames of the best plan. The whole request is checked before anything changes. Later failures (EVERY_PLAN_DIVERGED, a lost worker, the deadline of the call) may leave the slot corrected, but not advanced.
         */
        post: operations["StepSession"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/shares/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        post?: never;
        /**
         * Delete share
         * @description Revokes a share: after 30 s no server accepts it any more, and plays that were begun with it have ended. It stays in the list, with its `revoke_time`.
         */
        delete: operations["DeleteShare"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/sign-in": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Get sign in options
         * @description Whether people can sign in, and what the button says. The provider is not asked.
         */
        get: operations["GetSignInOptions"];
        put?: never;
        /**
         * Create sign in
         * @description Ends a sign-in that has begun: the key of the person, whose text is only in this reply. A sign-in of a device that the person has not confirmed yet is refused with SIGN_IN_PENDING and a delay for the next attempt.
         */
        post: operations["CreateSignIn"];
        /**
         * Delete sign in
         * @description Signs out: revokes the key that the call shows if it comes from a sign-in. Any other key remains good.
         */
        delete: operations["DeleteSignIn"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/sign-in/device": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Start device sign in
         * @description Begins a sign-in of a program without a browser (RFC 8628).
         */
        post: operations["StartDeviceSignIn"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/sign-in/start": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Start sign in
         * @description The address of the provider to which a browser goes. It returns to `/sign-in` of the server's public address, with `code` and `state`.
         */
        post: operations["StartSignIn"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/trash/captures": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * List trashed captures
         * @description Deleted captures, the last one first.
         */
        get: operations["ListTrashedCaptures"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/trash/fits": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * List trashed fits
         * @description Deleted fits, the last one first.
         */
        get: operations["ListTrashedFits"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/trash/twins": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * List trashed twins
         * @description Deleted twins, the last one first.
         */
        get: operations["ListTrashedTwins"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/twins": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** List twins */
        get: operations["ListTwins"];
        put?: never;
        /** Import a twin file */
        post: operations["CreateTwin"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/twins/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Get twin */
        get: operations["GetTwin"];
        put?: never;
        post?: never;
        /**
         * Delete twin
         * @description Moves a twin to the trash.
         */
        delete: operations["DeleteTwin"];
        options?: never;
        head?: never;
        /**
         * Update twin
         * @description Changes display name, note and tags.
         */
        patch: operations["UpdateTwin"];
        trace?: never;
    };
    "/v1/twins/{id}/content": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Download a twin file */
        get: operations["ExportTwin"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/twins/{id}/evaluations": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Evaluate twin
         * @description The quality table of a twin on a capture. The twin is first registered to a recording that it was not fitted to; the call ends with FAILED_PRECONDITION, reason OBSERVATION_NOT_EXPLAINED, if the remaining distances are too large. The capture's ingest must have ended. The table is computed for this call and not stored. `motion` also asks for the predicted positions of nodes in a sequence, and for its errors frame by frame.
         */
        post: operations["EvaluateTwin"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/twins/{id}/export": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Download a twin in the format of another program
         * @description The twin at rest, as `bendtwin twin export` writes it (docs/formats/exchange.md): the surface in formats of programs that show it, and else the nodes.
         */
        get: operations["ExportTwinAs"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/twins/{id}/geometry": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Get twin geometry
         * @description Facts of a twin that planners need, without its file: nodes, springs, control points and the hand that each belongs to.
         */
        get: operations["GetTwinGeometry"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/twins/{id}/play": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Play with a twin
         * @description A WebSocket on which a simulation of the twin runs in real time. The first message says where it begins, `{"type": "begin"}` at least; docs/formats/play.md has all messages. The play ends with the socket.
         */
        get: operations["Play"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/twins/{id}/register": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Register state
         * @description The state in which the twin explains an observation: a rigid motion, then a deformation, then frames of the twin's own physics under the pull of the points. Ends with FAILED_PRECONDITION, reason OBSERVATION_NOT_EXPLAINED, if the remaining residual is above the given limit.
         */
        post: operations["RegisterState"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/twins/{id}/rollouts": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Roll out
         * @description Robot actions in; motion, costs or gradients out. Over HTTP a large body must be protobuf, and a large reply base64 or protobuf.
         */
        post: operations["RollOut"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/twins/{id}/rollouts/stream": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Stream roll out
         * @description Like RollOut, with the reply in parts as instances finish: each part covers `first_instance` onwards. On a GPU the last bits of a result may differ from those of RollOut, because they depend on the number of instances simulated together; on the CPU they do not. With `returns.best` there is one part. With `returns.part_frames` every part is divided in time as well. Over HTTP events named `part`.
         */
        post: operations["StreamRollOut"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/twins/{id}/shares": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * List shares
         * @description The shares of a twin, newest first, revoked and expired ones included.
         */
        get: operations["ListShares"];
        put?: never;
        /**
         * Share twin
         * @description Makes a share. The text of its key is only in this reply: the server stores a hash. The caller needs the scope rollouts:run for the twin as well. Refused with SHARE_NOT_NEEDED by a server that requires no token.
         */
        post: operations["ShareTwin"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/twins/{id}/surface": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Get twin surface
         * @description The surface of a twin for the eye: a closed triangle mesh in the object's colours, or tubes along cables. It is made here for a twin whose file has none.
         */
        get: operations["GetTwinSurface"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/twins/{id}/thumbnail": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * A small picture of a twin
         * @description Its surface at rest in its colours, on a transparent background.
         */
        get: operations["GetTwinThumbnail"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/twins/{id}/undelete": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Undelete twin
         * @description Restores a deleted twin. A twin that is not in the trash is returned unchanged.
         */
        post: operations["UndeleteTwin"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/uploads": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * List uploads
         * @description Those under way, and those that ended and are still remembered.
         */
        get: operations["ListUploads"];
        put?: never;
        /**
         * Begin a resumable upload
         * @description `Upload-Metadata` may give `filename`, `display_name`, `request_id` (or as `Idempotency-Key`) and `digest` (BLAKE3, hex). The same request id with the same metadata answers with the upload that was begun before, however far it is. A body is the first part of the content.
         */
        post: operations["CreateUpload"];
        delete?: never;
        /** Supported features of tus */
        options: operations["GetUploadOptions"];
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/uploads/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * One upload
         * @description The sender is not disturbed.
         */
        get: operations["GetUpload"];
        put?: never;
        post?: never;
        /**
         * Terminate an upload
         * @description Frees what it held. A capture that was made of it stays.
         */
        delete: operations["TerminateUpload"];
        options?: never;
        /**
         * Offset at which to resume
         * @description A request that still sends to the upload is ended: its connection may be dead. Makes the capture if only that is missing. To look without disturbing, GET.
         */
        head: operations["GetUploadOffset"];
        /**
         * Append to an upload
         * @description Acknowledged bytes are durable. With the last byte the capture is made; the response names it.
         */
        patch: operations["AppendUpload"];
        trace?: never;
    };
    "/v1/usage": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Get usage
         * @description Usage of the caller's owner, with the quotas of the key that is used.
         */
        get: operations["GetUsage"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/usage/owners": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * List owner usage
         * @description Usage of all owners who have anything or have a valid key, by name.
         */
        get: operations["ListOwnerUsage"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/workers": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** List workers */
        get: operations["ListWorkers"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/workers/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Get worker */
        get: operations["GetWorker"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/v1/workers/{id}/drain": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Drain worker
         * @description Asks a worker to take no more jobs and rollouts, to hand back its job with a checkpoint, to finish the rollouts under way and to exit; its sessions end with it. It is no error to ask again.
         */
        post: operations["DrainWorker"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
}
export type webhooks = Record<string, never>;
export interface components {
    schemas: {
        /** @description Coordinates of a plan, and the points or grippers that they move. Motion of the nominal plan outside of these coordinates is kept in every plan. */
        ActionSpace: {
            /** @enum {string} */
            coordinates?: "TOGETHER" | "PER_GROUP" | "POINTS" | "TRANSLATION" | "RIGID";
            /** @description With PER_GROUP: the group of each control point, UINT32 [C]; a hand, for example. */
            group_of_control?: components["schemas"]["Tensor"];
            /** @description Origin of the coordinates and their bounds: FLOAT32 [C, 3] for trajectories, [G, 7] for poses; absent: row 0 of the nominal plan. */
            start?: components["schemas"]["Tensor"];
        };
        AdvanceSessionRequest: {
            name?: string;
            /** @description The rollout. Twin, initial state and fidelity are those of the session and must be left out. */
            rollout?: components["schemas"]["RollOutRequest"];
            /** @description One slot for each instance of the rollout; empty: only slot 0. */
            slots?: number[];
        };
        Caller: {
            /**
             * Format: date-time
             * @description The key is refused from this time on; absent: never.
             */
            expire_time: string | null;
            /** @description True if the key comes from a sign-in. */
            is_sign_in: boolean;
            /** @description keys/{uuid}; empty without a key. */
            key: string;
            /** @description Owner of what the caller makes: `local` with the client token, empty where the server requires none. */
            owner: string;
            /** @description Scopes of the caller, sorted. */
            scopes: string[];
        };
        Capsule: {
            /** @description Ends of the axis, three numbers each. */
            from?: number[];
            /** Format: float */
            radius_m?: number;
            to?: number[];
        };
        Capture: {
            /** Format: date-time */
            create_time: string;
            /** @description BLAKE3 of the uploaded archive, hex. */
            digest: string;
            display_name: string;
            /** @description The job that reads the capture. Each capture has one; running the ingest again replaces it. When the ingest failed, fits of the capture fail with the same fault. */
            ingest: components["schemas"]["Job"];
            /** @description Worker that the ingest requires; absent: any. */
            ingest_requirements: components["schemas"]["WorkerRequirements"];
            /** @description True if the last ingest made masks of strokes. */
            masks: boolean;
            /** @description captures/{uuid} */
            name: string;
            /** @description Note written by users, up to 10,000 bytes. */
            note: string;
            /** @description Owner of the key that uploaded the capture; empty if unknown. */
            owner: string;
            /** @description Who recorded the capture, up to 200 characters; empty if not stated. */
            recorded_by: string;
            /** Format: int64 */
            size_bytes: number;
            /** @description Files that were added after the upload, one of each kind. */
            supplements: components["schemas"]["Supplement"][];
            /** @description Up to 32 tags of up to 50 characters, sorted. */
            tags: string[];
            /** @description Verdict of the report, one word; empty until the report exists. */
            verdict: string | null;
        };
        /** @description One condition of readiness. */
        Check: {
            /** @description The state found, and what to do if it is not ok. */
            message: string;
            /** @description running, writes, disk or workers */
            name: string;
            ok: boolean;
        };
        /** @description A rigid obstacle. It acts on nodes only: control points and grippers pass through it, which the diagnostics of a reply report. */
        Collider: {
            /** @description Only one of sphere, capsule, cuboid, convex_mesh may be given. */
            capsule?: components["schemas"]["Capsule"];
            /** @description Only one of sphere, capsule, cuboid, convex_mesh may be given. */
            convex_mesh?: components["schemas"]["ConvexMesh"];
            /** @description Only one of sphere, capsule, cuboid, convex_mesh may be given. */
            cuboid?: components["schemas"]["Cuboid"];
            /** @description Stands still in the world; the default. Only one of fixed, gripper, path may be given. */
            fixed?: components["schemas"]["Collider.Fixed"];
            /**
             * Format: float
             * @description Coulomb friction, 0..2; default 0.5.
             */
            friction?: number;
            /**
             * Format: int64
             * @description Carried by the gripper with this number. Only one of fixed, gripper, path may be given.
             */
            gripper?: number;
            /**
             * Format: float
             * @description Distance that nodes keep from the shape, metres: about the radius of a cable, or half the node spacing.
             */
            margin_m?: number;
            /** @description Name in replies; default `collider{index}`. At most 128 bytes. */
            name?: string;
            /** @description FLOAT32 [K, 7] for all instances: x, y, z in metres, quaternion x, y, z, w, at knots as those of the actions. Only one of fixed, gripper, path may be given. */
            path?: components["schemas"]["Tensor"];
            /** @description Pose of the shape on its carrier: x, y, z in metres, quaternion x, y, z, w; absent: none. */
            pose?: number[];
            /**
             * Format: float
             * @description Restitution, 0..1; default 0.
             */
            restitution?: number;
            /** @description Only one of sphere, capsule, cuboid, convex_mesh may be given. */
            sphere?: components["schemas"]["Sphere"];
        };
        "Collider.Fixed": Record<string, never>;
        /** @description Positions of every control point. */
        ControlTrajectories: {
            /** @enum {string} */
            interpolation?: "LINEAR" | "CUBIC" | "ZERO";
            /** @description FLOAT32 [B, K, C, 3], metres. K = F + 1 is dense: row 0 belongs to the initial state. Any other number of knots K >= 2 is spread evenly over the horizon and interpolated. */
            positions?: components["schemas"]["Tensor"];
        };
        /** @description The convex hull of points. */
        ConvexMesh: {
            /** @description FLOAT32 [M, 3], metres, M in 4..4096; its hull has at most 128 faces. */
            points?: components["schemas"]["Tensor"];
        };
        CorrectOptions: {
            /**
             * Format: double
             * @description Share of the correction that the rest shape of the slot takes over, so that the slot does not spring back: 0..1, multiplied by the share of the distances before the correction that noise_m does not explain; default 1. With 0 only the state is corrected. The rest shape follows the observations if corrections are repeated several times a second.
             */
            carry?: number;
            /**
             * Format: double
             * @description Standard deviation of a spring's relative length in one correction; default 0.03. Larger values trust the predicted shape less.
             */
            give?: number;
            /** @description Current poses of the first G grippers, FLOAT32 [G, 7]: x, y, z in metres, quaternion x, y, z, w. Needed where they differ from, or are unknown after, the slot's last advance. */
            grippers?: components["schemas"]["Tensor"];
            /**
             * Format: double
             * @description Median distance of the points above which the correction is refused, metres; default: half the node spacing, at least 0.005.
             */
            max_residual_m?: number;
            /**
             * Format: double
             * @description Largest increase of the strain of a spring; default 0.5.
             */
            most_added_strain?: number;
            /**
             * Format: double
             * @description Standard deviation of a point from its place, metres; default 0.005. It covers noise, and motion that a coarse twin cannot follow.
             */
            noise_m?: number;
            /** @description Leave the states out of the reply. */
            omit_state?: boolean;
            /** @description A slot that is lost, this observation included, is registered with it: first from its current state, and if that does not explain the observation, from the rest shape in any pose. Nodes held by control points and grasps stay in place, and the result is outside of the surroundings. */
            register_if_lost?: boolean;
            /**
             * Format: double
             * @description Share of the displacement added to the velocity, per second, where velocities are not observed; default 0.
             */
            velocity_gain_per_s?: number;
            /**
             * Format: double
             * @description Standard deviation of an observed velocity, metres per second; default 0.2.
             */
            velocity_noise_m_s?: number;
            /** @description Current surroundings. Absent: the surroundings at the end of the slot's last advance, moved bodies included. Before the first advance: those of the session, with paths at their first pose and without colliders carried by grippers. A path given here is at its first pose. */
            world?: components["schemas"]["World"];
        };
        CorrectSessionRequest: {
            name?: string;
            observation?: components["schemas"]["Observation"];
            options?: components["schemas"]["CorrectOptions"];
            /** @description Slots, all corrected by the same observation; empty: only slot 0. */
            slots?: number[];
        };
        CorrectedSession: {
            /** @description One correction for each slot, in the order of the request. */
            corrections: components["schemas"]["CorrectedSession.Correction"][];
            session?: components["schemas"]["Session"];
        };
        "CorrectedSession.Correction": {
            after?: components["schemas"]["Residual"];
            /** @description Distances of the points before and after. */
            before?: components["schemas"]["Residual"];
            /**
             * Format: double
             * @description Largest displacement of a node, millimetres.
             */
            moved_mm: number;
            /** @description True if the slot was lost and has been registered with this observation: it is then at rest, with the rest shape of the twin, and `after` and `moved_mm` describe the registration. */
            registered: boolean;
            /** Format: int64 */
            slot: number;
            /** @description The corrected state of this slot, unless CorrectOptions.omit_state is set. InitialState.given accepts it unchanged; the rest shape stays in the session. */
            state?: components["schemas"]["InitialState.GivenState"];
            /** @description Tracking record, this observation included. */
            tracking?: components["schemas"]["Tracking"];
        };
        Cost: {
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed, order, winding, coverage may be given. */
            clearance?: components["schemas"]["Cost.Clearance"];
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed, order, winding, coverage may be given. */
            control_path?: components["schemas"]["Cost.ControlPath"];
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed, order, winding, coverage may be given. */
            control_speed?: components["schemas"]["Cost.ControlSpeed"];
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed, order, winding, coverage may be given. */
            coverage?: components["schemas"]["Cost.Coverage"];
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed, order, winding, coverage may be given. */
            force?: components["schemas"]["Cost.Force"];
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed, order, winding, coverage may be given. */
            height?: components["schemas"]["Cost.Height"];
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed, order, winding, coverage may be given. */
            keypoints?: components["schemas"]["Cost.Keypoints"];
            /** @description Name in replies; default `cost{index}`. Names must differ; at most 128 bytes each. */
            name?: string;
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed, order, winding, coverage may be given. */
            order?: components["schemas"]["Cost.Order"];
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed, order, winding, coverage may be given. */
            smoothness?: components["schemas"]["Cost.Smoothness"];
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed, order, winding, coverage may be given. */
            strain?: components["schemas"]["Cost.Strain"];
            /**
             * Format: double
             * @description Condition of success, at least 0: the value of the cost after the last frame, without its weight and regardless of `when`, is at most this. Costs and gradients do not depend on it. An instance succeeds if it meets all conditions (RollOutResponse.successes). Not for `force`, `smoothness`, `control_path` and `control_speed`.
             */
            success_at_most?: number;
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed, order, winding, coverage may be given. */
            target_cloud?: components["schemas"]["Cost.TargetCloud"];
            /**
             * Format: double
             * @description Temperature of SOFT_MIN, above 0: the difference in cost at which frames count for clearly less, in the unit of the cost.
             */
            temperature?: number;
            /**
             * Format: double
             * @description Default: 1. With 0 the cost is switched off and reported as 0; its condition of success still counts.
             */
            weight?: number;
            /**
             * @description Frames at which the cost is counted; default: after the last frame.
             * @enum {string}
             */
            when?: "LAST_FRAME" | "EVERY_FRAME" | "SOFT_MIN";
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed, order, winding, coverage may be given. */
            winding?: components["schemas"]["Cost.Winding"];
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed, order, winding, coverage may be given. */
            within?: components["schemas"]["Cost.Within"];
        };
        /** @description Mean over nodes of max(0, margin - distance)^2 to a collider of the request, square metres. */
        "Cost.Clearance": {
            /** Format: int64 */
            collider?: number;
            /** Format: float */
            margin_m?: number;
        };
        /** @description Path length of the control points, mean over them, metres; `when` has no effect. */
        "Cost.ControlPath": Record<string, never>;
        /** @description Mean over control points and frames of max(0, speed - limit)^2, square metres per square second; `when` has no effect. */
        "Cost.ControlSpeed": {
            /** Format: double */
            limit_m_s?: number;
        };
        /** @description Uncovered share of points, 0..1: mean over the points of 1 - exp(-d^2 / (2 reach^2)), with the distance d to the nearest point of the twin's surface. The gradient takes the nearest point as fixed and fades where d is several times the reach. */
        "Cost.Coverage": {
            /**
             * @description Points of the surface: SKIN, the default, or NODES for the surface nodes.
             * @enum {string}
             */
            point_set?: "NODES" | "SKIN";
            /** @description FLOAT32 [M, 3], metres. */
            points?: components["schemas"]["Tensor"];
            /**
             * Format: float
             * @description 1e-6..1000 metres; about half the spacing of the surface's points, or more for a gradient from afar.
             */
            reach_m?: number;
        };
        /** @description max(0, |f| - limit)^2 of the mean force over a frame, square newtons (per unit mass without a mass_kg). */
        "Cost.Force": {
            /**
             * Format: int64
             * @description Index of a collider of the request. Only one of controls, control, grasp, ground, collider may be given.
             */
            collider?: number;
            /**
             * Format: int64
             * @description Only one of controls, control, grasp, ground, collider may be given.
             */
            control?: number;
            /** @description All control points together. Only one of controls, control, grasp, ground, collider may be given. */
            controls?: components["schemas"]["Cost.Force.All"];
            /**
             * Format: int64
             * @description Index of a grasp of the request. Only one of controls, control, grasp, ground, collider may be given.
             */
            grasp?: number;
            /** @description Only one of controls, control, grasp, ground, collider may be given. */
            ground?: components["schemas"]["Cost.Force.All"];
            /** Format: double */
            limit_n?: number;
        };
        "Cost.Force.All": Record<string, never>;
        /** @description Mean over nodes of the squared depth below a plane, square metres. */
        "Cost.Height": {
            /** @description UINT32 [M]; absent: all. */
            nodes?: components["schemas"]["Tensor"];
            plane?: components["schemas"]["Plane"];
        };
        /** @description Mean distance between nodes or skin points and their targets, metres. */
        "Cost.Keypoints": {
            /** @description UINT32 [M]: nodes. Give either these or `skin_points`. */
            nodes?: components["schemas"]["Tensor"];
            /** @description UINT32 [M]: points of the skin. */
            skin_points?: components["schemas"]["Tensor"];
            /** @description Use squared distances. */
            squared?: boolean;
            /** @description FLOAT32 [M, 3], [F, M, 3], [B, 1, M, 3] or [B, F, M, 3], metres, like the points of a target cloud. */
            targets?: components["schemas"]["Tensor"];
        };
        /** @description Order of nodes or skin points along a direction: mean over neighbours in the list of max(0, gap - direction . (x(next) - x))^2, square metres. 0 if each point is at least `gap_m` ahead of the one before it. */
        "Cost.Order": {
            /** @description Unit vector, three numbers. */
            direction?: number[];
            /**
             * Format: float
             * @description At least 0.
             */
            gap_m?: number;
            /** @description UINT32 [M], M >= 2: nodes. Give either these or `skin_points`. */
            nodes?: components["schemas"]["Tensor"];
            /** @description UINT32 [M], M >= 2: points of the skin. */
            skin_points?: components["schemas"]["Tensor"];
        };
        /** @description Mean squared second difference of node positions over three frames, square metres. */
        "Cost.Smoothness": Record<string, never>;
        /** @description Mean over springs of the material of max(0, |strain| - limit)^2. */
        "Cost.Strain": {
            /** Format: float */
            limit?: number;
        };
        /** @description Mean squared distance of the target's points to the nearest point of the twin's surface, square metres. */
        "Cost.TargetCloud": {
            /**
             * @description Points of the surface: SKIN, the default, or NODES for the surface nodes.
             * @enum {string}
             */
            point_set?: "NODES" | "SKIN";
            /** @description FLOAT32 [M, 3], metres, or [F, M, 3] by frame (with EVERY_FRAME or SOFT_MIN), or [B, 1, M, 3] or [B, F, M, 3] by instance as well. */
            points?: components["schemas"]["Tensor"];
        };
        /** @description Winding of a chain of nodes or skin points around a straight line: (turns - wanted turns)^2. The turns are the sum of the angles between neighbours in the list, each within half a turn, over 2 pi; positive is counter-clockwise seen against the direction of the line. Angles at a point within 1 micrometre of the line count as 0. The gradient turns the first and the last point around the line; it has no jumps where the chain crosses the line. */
        "Cost.Winding": {
            /** @description Only one of axis, collider may be given. */
            axis?: components["schemas"]["Cost.Winding.Axis"];
            /**
             * Format: int64
             * @description Index of a fixed collider of the request that is a capsule: its axis, from its first end to its second. Only one of axis, collider may be given.
             */
            collider?: number;
            /** @description UINT32 [M], M >= 2: nodes. Give either these or `skin_points`. */
            nodes?: components["schemas"]["Tensor"];
            /** @description UINT32 [M], M >= 2: points of the skin. */
            skin_points?: components["schemas"]["Tensor"];
            /**
             * Format: float
             * @description Wanted turns, -100..100.
             */
            turns?: number;
        };
        "Cost.Winding.Axis": {
            direction?: number[];
            /** @description Three numbers each: a point, metres, and a unit vector. */
            point?: number[];
        };
        /** @description Mean over nodes of the squared distance to a box, square metres. */
        "Cost.Within": {
            cuboid?: components["schemas"]["Cuboid"];
            /** @description UINT32 [M]; absent: all. */
            nodes?: components["schemas"]["Tensor"];
        };
        CreateFitRequest: {
            capture: string;
            /** @description Default: the display name of the capture. */
            display_name?: string;
            /**
             * Format: int32
             * @description Priority, -100..100: fits with a higher one run earlier. Normal: 0; the key bounds it (`KeyQuotas`).
             */
            priority?: number;
            /** @description Worker that the fit requires; absent: any. */
            requirements?: components["schemas"]["WorkerRequirements"];
            /** @description FitSettings as JSON; empty means defaults. */
            settings?: {
                [key: string]: unknown;
            };
        };
        CreateKeyRequest: {
            /** @description 1 to 200 characters. */
            display_name: string;
            /**
             * Format: date-time
             * @description Absent: the key does not expire.
             */
            expire_time?: string;
            /** @description Up to 200 characters. Default: the display name. */
            owner?: string;
            quotas?: components["schemas"]["KeyQuotas"];
            /** @description At least one. */
            scopes: string[];
        };
        CreateKeyResponse: {
            key: components["schemas"]["Key"];
            /** @description The key itself, `bt_{id}_{secret}`, as clients present it. */
            secret_key: string;
        };
        CreateProjectRequest: {
            /** @description 1 to 200 characters. */
            display_name: string;
            /** @description Names of owners, up to 200. An owner need not have a key yet. */
            members?: string[];
        };
        CreateRetentionRuleRequest: {
            /** @description captures, fits or twins */
            collection: string;
            /** @description 1 to 200 characters. */
            display_name: string;
            /**
             * Format: double
             * @description Only what was created at least this long ago [days], up to 36,500.
             */
            min_age_days: number;
            /** @description Only what this owner has; empty: any. */
            owner?: string;
            /** @description Only what has this tag; empty: any. */
            tag?: string;
            /** @description Only captures whose report has this verdict; empty: any. */
            verdict?: string;
        };
        /** @description Either `code`, `code_verifier` and `nonce`, or `device_code`. */
        CreateSignInRequest: {
            /** @description Code that the provider gave to the browser. */
            code?: string;
            /** @description Secret of which StartSignIn got the hash: 43 characters of base64url. */
            code_verifier?: string;
            /** @description Code of StartDeviceSignIn. */
            device_code?: string;
            /** @description That from StartSignIn. */
            nonce?: string;
        };
        CreateSignInResponse: {
            key: components["schemas"]["Key"];
            /** @description The key itself, as clients present it. */
            secret_key: string;
        };
        /** @description A box aligned with the axes. */
        Cuboid: {
            high?: number[];
            /** @description Lowest and highest corner, three numbers each. */
            low?: number[];
        };
        /** @description Ensemble: every action is simulated with E sets of parameters (members), given by `vary`, and its cost is a statistic of the members' costs. There are then B x E instances, the members of one action side by side: member e of action b is instance b E + e in `instances`, positions, final states, forces, diagnostics, `diverged` and `implausible`. Costs, gradients, `first_instance` and `returns.best` count actions. The cost of a member that diverges is +inf, and so is the mean. MEAN_PREDICTION is not a statistic of costs: there the members predict one motion together. */
        Ensemble: {
            /** Format: int64 */
            members?: number;
            /**
             * Format: double
             * @description Share of the worst members that CVAR averages, above 0 and at most 1; rounded up to whole members.
             */
            share?: number;
            /** @enum {string} */
            statistic?: "MEAN" | "WORST" | "CVAR" | "MEAN_PREDICTION";
        };
        EvaluateTwinRequest: {
            /** @description captures/{uuid} */
            capture: string;
            /** @description Also return the predicted motion of a sequence. */
            motion?: components["schemas"]["MotionRequest"];
            /** @description twins/{uuid} */
            twin?: string;
        };
        Evaluation: {
            /** @description captures/{uuid} */
            capture: string;
            /** @description The requested motion; missing if the twin could not be registered to the recording, which a warning in the table explains. */
            motion?: components["schemas"]["PredictedMotion"];
            /** @description The quality table as JSON (docs/formats/twin.md, `quality`), with its assessment and, for a capture that the twin was not fitted to, the quality of the registration. All frames of such a capture count as future. */
            quality: {
                [key: string]: unknown;
            };
            /** @description twins/{uuid} */
            twin: string;
            /** @description workers/{uuid} */
            worker: string;
        };
        /** @description Shares of an observation and of the twin that explain each other. */
        Explained: {
            /**
             * Format: double
             * @description Share of the points that are within reach of the twin, 0..1.
             */
            points: number;
            /**
             * Format: double
             * @description Share of the visible surface that has a point within reach, 0..1. Tracks say nothing about the rest of the surface, so that the share is small with tracks.
             */
            surface: number;
            /**
             * Format: double
             * @description The reach, millimetres.
             */
            within_mm: number;
        };
        /** @description Reason for a failure: the same triple that a failed call carries. */
        Fault: {
            /** @description INVALID_ARGUMENT, NOT_FOUND, ...: the names of the gRPC codes. */
            category: string;
            /** @description Text for people: what happened and what to do about it. */
            message: string;
            /** @description Stable UPPER_SNAKE_CASE word for programs. */
            reason: string;
        };
        Fit: {
            capture: string;
            /** @description The name given when the fit was created, by default that of its capture. The twin gets the same name. */
            display_name: string;
            /**
             * Format: double
             * @description Error of the fitted twin, metres, as in `Twin`.
             */
            error_m: number | null;
            job: components["schemas"]["Job"];
            /** @description Kind of `error_m`: `track`, `coordinate` or `chamfer`; empty if unknown. */
            measure: string | null;
            /** @description fits/{uuid} */
            name: string;
            /** @description Note written by users, up to 10,000 bytes. */
            note: string;
            /** @description Owner of the key that created the fit, and of the fitted twin; empty if unknown. */
            owner: string;
            /** Format: int32 */
            priority: number;
            /** @description Worker that the fit requires; absent: any. */
            requirements: components["schemas"]["WorkerRequirements"];
            /** @description Up to 32 tags of up to 50 characters, sorted. */
            tags: string[];
            /** @description twins/{uuid} once the fit has succeeded. */
            twin: string | null;
        };
        FitLosses: {
            /** @description Curves in the order of computation: stages one after another, models side by side. */
            curves: components["schemas"]["FitLosses.LossCurve"][];
        };
        /** @description Losses of one model over the iterations of a stage. Long stages are thinned: only every second, fourth, ... iteration is kept, and the last. */
        "FitLosses.LossCurve": {
            /** @description Lowest loss up to each iteration. */
            best_losses: (number | null)[];
            /** @description Error over the training frames with the best parameters up to each iteration, metres, as in FitPreview; NaN for iterations without a preview. Empty: no iteration has one. */
            errors_m: (number | null)[];
            /** @description Iterations, ascending from 1. */
            iterations: number[];
            /** @description Loss of each iteration; NaN where it was not finite. */
            losses: (number | null)[];
            /** @description Stage: search or refine. */
            stage: string;
            /** @description Model: bending or axial, with several starts followed by the start: `bending 2/3`. */
            variant: string;
        };
        /** @description Predicted motion of the best parameters of a running fit: P points of the object's surface in F frames of one sequence; up to 400 points and 24 frames. */
        FitPreview: {
            /**
             * Format: double
             * @description Error of the object standing still, over the frames of `error_m`, metres.
             */
            baseline_m: number;
            /** Format: date-time */
            create_time: string;
            /**
             * Format: double
             * @description Error over the frames that the parameters are fitted to, metres.
             */
            error_m: number;
            /** @description Numbers of the frames, ascending, UINT32 [F]. */
            frames?: components["schemas"]["Tensor"];
            /**
             * Format: double
             * @description Error over training frames that are held back to choose among starts, metres; absent: none are.
             */
            held_back_m?: number;
            /**
             * Format: int64
             * @description Iterations of the stage that were done.
             */
            iteration: number;
            /** @description Kind of the errors, the one that the twin will be judged by: `track`, `coordinate` or `chamfer`. */
            measure: string;
            /** @description INT16_SCALED [F, P, 3], metres. */
            positions?: components["schemas"]["Tensor"];
            /**
             * Format: int64
             * @description Index of the sequence among those of the capture.
             */
            sequence: number;
            /** @description Stage that found the parameters: search or refine. */
            stage: string;
            /** @description Model: bending or axial, with several starts followed by the start: `bending 2/3`. */
            variant: string;
        };
        ForkSessionRequest: {
            /** Format: int64 */
            from?: number;
            name?: string;
            /** @description Empty: all other slots. */
            to?: number[];
        };
        GradientOptions: {
            /**
             * Format: int64
             * @description Largest number of frames that a gradient reaches back: it is cut every `reach_frames` frames; 0 means no cut. Gradients through many contacts grow until they are useless; 15 is a good start where the object lies on something.
             */
            reach_frames?: number;
            /**
             * Format: double
             * @description Width of the layer in which ground and colliders act as smooth forces, metres; 0 means impacts instead. The layer is used in the simulation that is differentiated, and so in the costs and arrays returned with the gradients; requests without gradients are not affected. 0.001 is a good start where the object lies on something.
             */
            smoothing_m?: number;
        };
        /** @description A gripper's grasp of the object. The twin's own control points hold the object as fitted, unless a grasp of their `hand` is open. To grasp elsewhere, first release them with a grasp of that `hand` that is never closed: its `closed` is [0]. */
        Grasp: {
            /** @enum {string} */
            attachment?: "PIN" | "SPRINGS";
            /** @description Closed (1) or open (0) from each knot of the actions on: UINT32 [K] for all instances, or [B, K]. [1] holds for all knots; absent: always closed. */
            closed?: components["schemas"]["Tensor"];
            /** @description Only one of sphere, cuboid, nodes, hand may be given. */
            cuboid?: components["schemas"]["Cuboid"];
            /**
             * Format: float
             * @description Damping of SPRINGS, newton seconds per metre; 0 chooses critical damping.
             */
            damping?: number;
            /**
             * Format: int64
             * @description The gripper, by its number in the actions' poses.
             */
            gripper?: number;
            /** @description The twin's own control points of a hand of its capture (TwinGeometry.hands), holding as fitted. Once this grasp has opened it stays open. Only one of sphere, cuboid, nodes, hand may be given. */
            hand?: components["schemas"]["Grasp.CaptureHand"];
            /**
             * Format: double
             * @description Mean force over a frame beyond which the grasp slips, newtons; absent: never.
             */
            max_force_n?: number;
            /** @description UINT32 [M]. Only one of sphere, cuboid, nodes, hand may be given. */
            nodes?: components["schemas"]["Tensor"];
            /** @description In the coordinates of the gripper. Only one of sphere, cuboid, nodes, hand may be given. */
            sphere?: components["schemas"]["Sphere"];
            /**
             * Format: float
             * @description Stiffness of SPRINGS: newtons per metre and node (per unit mass without a mass_kg); 0 chooses what the twin's substeps allow.
             */
            stiffness?: number;
        };
        "Grasp.CaptureHand": {
            /** Format: int64 */
            hand?: number;
        };
        /** @description Search over P places to grasp, by successive halving. Each place has its own search of a motion, with its own nominal plan, which begins at the place and otherwise moves like the nominal plan: by the same displacements and rotations along the world's axes. Grippers that are not listed move as in the nominal plan. The places still searched share the samples of each iteration; after each round the worse half of them, in the order of plans, is given up, until one is left. There are ceil(log2(P)) + 1 rounds of iterations / rounds iterations each, rounded down; the last round, of a single place, has the iterations that remain. With a gradient each place keeps its starts, samples / P of them.  A plan in which no grasp of a listed gripper ever exerts a force has grasped nothing: its cost is +inf, and it counts as diverged. If there is no other, the call ends with FAILED_PRECONDITION, reason NOTHING_GRASPED. Only with poses as actions and with `rollout.grasps` that have a sphere, a cuboid or nodes for each listed gripper, also in a session. Refused if such a grasp holds something in the given initial state, or in the slot of a session that was opened with its grasps, and is closed at the start of the plan. */
        GraspSearch: {
            /** @description Grippers whose places are searched, ascending; empty: all. */
            grippers?: number[];
            /** @description Poses at the start of the motion, of all grippers listed in `grippers`: FLOAT32 [P, G', 7], P in 2..256. Coordinates of these grippers and their bounds are counted from there, instead of from `space.start`. */
            poses?: components["schemas"]["Tensor"];
        };
        /** @description What G grasps hold of N nodes in a state. Shapes are those of one state; several states have [B] in front. */
        Grasping: {
            /** @description Grasp that holds each node, UINT32 [N]: g + 1 for grasp g; 0 for none. */
            holders?: components["schemas"]["Tensor"];
            /** @description Phase of each grasp, UINT32 [G]: 0 open, 1 closed, 2 slipped. */
            phases?: components["schemas"]["Tensor"];
            /** @description Positions of held nodes in the coordinates of their gripper, FLOAT32 [N, 3], metres. */
            places?: components["schemas"]["Tensor"];
        };
        /** @description Poses of rigid grippers that carry the control points attached to them. */
        GripperPoses: {
            /** @description Gripper of each control point, UINT32 [C]; empty means gripper 0 for all. */
            gripper_of_control?: components["schemas"]["Tensor"];
            /** @enum {string} */
            interpolation?: "LINEAR" | "CUBIC" | "ZERO";
            /** @description FLOAT32 [B, K, G, 7]: x, y, z in metres, quaternion x, y, z, w. K as in ControlTrajectories. Control points move as if glued to the gripper in its pose of row 0. */
            poses?: components["schemas"]["Tensor"];
        };
        IngestCaptureRequest: {
            /** @description Worker that the ingest requires; absent: any. */
            requirements?: components["schemas"]["WorkerRequirements"];
            /** @description IngestSettings as JSON; empty means defaults. */
            settings?: {
                [key: string]: unknown;
            };
        };
        InitialState: {
            /** @description The twin's state after following the capture's own controls up to a frame. Only one of rest, capture_frame, given, settled, session may be given. */
            capture_frame?: components["schemas"]["InitialState.CaptureFrame"];
            /** @description A state that a rollout returned or that the caller made. Only one of rest, capture_frame, given, settled, session may be given. */
            given?: components["schemas"]["InitialState.GivenState"];
            /** @description The twin's rest shape, at rest. The default. Only one of rest, capture_frame, given, settled, session may be given. */
            rest?: components["schemas"]["InitialState.Rest"];
            /** @description The states of slots of a session. Only one of rest, capture_frame, given, settled, session may be given. */
            session?: components["schemas"]["InitialState.SessionSlots"];
            /** @description The twin's shape after it has come to rest, held by its control points at rest, in the request's world at the start: gravity, ground, static colliders, and colliders at the first pose of their path. Grippers are added afterwards: colliders that they carry are absent while the twin settles, and grasps hold nothing. Only one of rest, capture_frame, given, settled, session may be given. */
            settled?: components["schemas"]["InitialState.Settled"];
        };
        "InitialState.CaptureFrame": {
            /** @description captures/{uuid}; empty means the twin's own capture. */
            capture?: string;
            /** Format: int64 */
            frame?: number;
            /** Format: int64 */
            sequence?: number;
        };
        "InitialState.GivenState": {
            /** @description Commanded positions of the control points, in the shape of `controls`, metres: where the grippers would hold them if the ground did not stop the grippers. `poses` carry them from there. Absent: equal to `controls`. */
            commanded_controls?: components["schemas"]["Tensor"];
            /** @description Positions of the control points, FLOAT32 [C, 3] or [B, C, 3], metres. Absent: pinned ones at their nodes, others at rest. With `poses`, control points that pin no node are carried from there, so their positions should be given. */
            controls?: components["schemas"]["Tensor"];
            grasping?: components["schemas"]["Grasping"];
            /** @description FLOAT32 [N, 3] for all instances or [B, N, 3], metres. */
            positions?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [rods] for all instances or [B, rods], like the positions; radians relative to the twin's untwisted rods. Empty: no rod is twisted, or the twin has no rods. */
            twists?: components["schemas"]["Tensor"];
            /** @description The same shape, metres per second; empty means at rest. */
            velocities?: components["schemas"]["Tensor"];
        };
        "InitialState.Rest": Record<string, never>;
        "InitialState.SessionSlots": {
            /** @description sessions/{uuid}; the request's twin may be left out then. */
            session?: string;
            /** @description One slot for all instances, or one for each; empty: slot 0 for all. */
            slots?: number[];
        };
        "InitialState.Settled": Record<string, never>;
        /** @description Work that a worker does for a fit, or for the ingest of a capture. */
        Job: {
            attempt_faults: components["schemas"]["Fault"][];
            /** Format: int64 */
            attempts: number;
            cancel_requested: boolean;
            /** Format: date-time */
            create_time: string;
            /** Format: date-time */
            end_time: string | null;
            /** @description Reason of the failure; errors of earlier attempts precede it in `attempt_faults`. */
            fault: null | components["schemas"]["Fault"];
            progress: null | components["schemas"]["Progress"];
            /**
             * Format: int64
             * @description Number that grows with every change, also from one run of an ingest to the next; it is the id of server-sent events.
             */
            revision: number;
            /**
             * Format: double
             * @description Time for which the job has run at workers, over all attempts, as of the last report of its worker [s].
             */
            run_s: number;
            /** @description The settings in force, as JSON (docs/use/settings.md). */
            settings: {
                [key: string]: unknown;
            };
            /** Format: date-time */
            start_time: string | null;
            /** @enum {string} */
            state: "QUEUED" | "RUNNING" | "SUCCEEDED" | "FAILED" | "CANCELLED";
            /** @description workers/{uuid} while it runs. */
            worker: string | null;
        };
        Key: {
            /** Format: date-time */
            create_time: string;
            display_name: string;
            /**
             * Format: date-time
             * @description The key is refused from this time on; absent: never.
             */
            expire_time: string | null;
            /** @description True if a person got the key by signing in. */
            is_sign_in: boolean;
            /**
             * Format: date-time
             * @description Last use, accurate to about a minute; absent if the key has not been used.
             */
            last_use_time: string | null;
            /** @description keys/{uuid} */
            name: string;
            /** @description Recorded as `owner` of captures, fits and twins created with the key. */
            owner: string;
            quotas: components["schemas"]["KeyQuotas"];
            /**
             * Format: date-time
             * @description Absent unless the key has been revoked.
             */
            revoke_time: string | null;
            /** @description Scopes, sorted: admin, captures:read, captures:write, fits:read, fits:write, metrics:read, rollouts:run, twins:read, twins:write. Those of captures, fits, rollouts and twins may end in `:own`, for example captures:write:own: the scope then applies to what the owner of the key has, and to what members of the owner's projects have. */
            scopes: string[];
            /** @description twins/{uuid}: the twin that the key is limited to, if it is a share. Its scopes are `share` and perhaps `share:export`, which no other key has. */
            twin: string | null;
        };
        /** @description Quotas: the server refuses requests with the key when its owner has reached one. An absent field sets no bound but the server's default, unless it says otherwise. */
        KeyQuotas: {
            /**
             * Format: int64
             * @description Time for which one fit may run at workers, over all attempts [s]; the server's bound applies as well.
             * @default null
             */
            fit_run_s: number | null;
            /**
             * Format: int64
             * @description Highest priority of fits, up to 100. Absent when a key is created: 0, or 100 with the scope admin.
             * @default null
             */
            priority: number | null;
            /**
             * Format: int64
             * @description Fits and ingests that wait for a worker.
             * @default null
             */
            queued_jobs: number | null;
            /**
             * Format: int64
             * @description Rollouts, plans, registrations and evaluations in progress at one server.
             * @default null
             */
            rollouts: number | null;
            /**
             * Format: int64
             * @description Fits and ingests that run at workers, at least 1; further ones stay queued.
             * @default null
             */
            running_jobs: number | null;
            /**
             * Format: int64
             * @description Size of everything stored for the owner: captures with what was added to them and made of them, twins, checkpoints, and uploads in progress [bytes].
             * @default null
             */
            stored_bytes: number | null;
        };
        /** @description Times of the knots of the actions, if they are not spread evenly over the horizon. */
        KnotTimes: {
            /** @description FLOAT32 [K], seconds from the start, increasing; the first is 0, the last knot holds until the end. Only one of at_s, period_s may be given. */
            at_s?: components["schemas"]["Tensor"];
            /**
             * Format: double
             * @description Seconds from knot to knot: the period of a controller, independent of the twin's frame rate. Only one of at_s, period_s may be given.
             */
            period_s?: number;
        };
        /** @description A distant light and an even one. */
        Light: {
            /** @description Share of the even light, 0..1: FLOAT32 [1] or [S]; absent: 0.5. */
            ambient?: components["schemas"]["Tensor"];
            /** @description Factor of all light, backgrounds excepted, 0..4: FLOAT32 [1] or [S]; absent: 1. */
            brightness?: components["schemas"]["Tensor"];
            /** @description Direction from which the light comes, FLOAT32 [3] or [S, 3], of any length above 0; absent: from above and behind the first camera. */
            direction?: components["schemas"]["Tensor"];
        };
        ListCapturesResponse: {
            captures: components["schemas"]["Capture"][];
            /** @description Empty on the last page. */
            next_page_token: string;
            /**
             * Format: int64
             * @description Number of captures that match the filters, counted up to 10,000. Only on the first page.
             */
            total_size?: number;
        };
        ListFitsResponse: {
            fits: components["schemas"]["Fit"][];
            next_page_token: string;
            /**
             * Format: int64
             * @description Number of fits that match the filters, counted up to 10,000. Only on the first page.
             */
            total_size?: number;
        };
        ListKeysResponse: {
            keys: components["schemas"]["Key"][];
            /** @description Empty on the last page. */
            next_page_token: string;
        };
        ListOwnerUsageResponse: {
            /** @description Empty on the last page. */
            next_page_token: string;
            owners: components["schemas"]["OwnerUsage"][];
        };
        ListProjectsResponse: {
            /** @description Empty on the last page. */
            next_page_token: string;
            projects: components["schemas"]["Project"][];
        };
        ListRetentionRulesResponse: {
            rules: components["schemas"]["RetentionRule"][];
        };
        ListSharesResponse: {
            /** @description Empty on the last page. */
            next_page_token: string;
            shares: components["schemas"]["Share"][];
        };
        ListTrashedCapturesResponse: {
            /** @description Empty on the last page. */
            next_page_token: string;
            resources: components["schemas"]["TrashedResource"][];
        };
        ListTrashedFitsResponse: {
            /** @description Empty on the last page. */
            next_page_token: string;
            resources: components["schemas"]["TrashedResource"][];
        };
        ListTrashedTwinsResponse: {
            /** @description Empty on the last page. */
            next_page_token: string;
            resources: components["schemas"]["TrashedResource"][];
        };
        ListTwinsResponse: {
            next_page_token: string;
            /**
             * Format: int64
             * @description Number of twins that match the filters, counted up to 10,000. Only on the first page.
             */
            total_size?: number;
            twins: components["schemas"]["Twin"][];
        };
        ListWorkersResponse: {
            next_page_token: string;
            workers: components["schemas"]["Worker"][];
        };
        /** @description Loss of one model after one iteration. */
        ModelLoss: {
            /** Format: double */
            best_loss: number | null;
            /**
             * Format: double
             * @description Error over the training frames with the best parameters, metres; absent of an iteration without a preview.
             */
            error_m: number | null;
            /** Format: int64 */
            iteration: number;
            /**
             * Format: double
             * @description Absent where the loss was not finite.
             */
            loss: number | null;
            /** @description Stage: search or refine. */
            stage: string;
            /** @description Model: bending or axial, with several starts followed by the start: `bending 2/3`. */
            variant: string;
        };
        /** @description A sequence whose predicted motion is requested. */
        MotionRequest: {
            /**
             * Format: int64
             * @description Index among the sequences of all recordings of the capture, in their order.
             */
            sequence?: number;
        };
        /** @description Points on the surface of an object at one time, in the twin's coordinates. Unseen points are left out. */
        Observation: {
            /** @description Positions of the cameras that saw the points, FLOAT32 [K, 3], metres, K up to 16. They determine the part of the surface that could have been seen; absent: all of it. */
            cameras?: components["schemas"]["Tensor"];
            /** @description UINT32 [M]: nodes of the twin. Only one of nodes, places may be given. */
            nodes?: components["schemas"]["Tensor"];
            /** @description Places between nodes. Only one of nodes, places may be given. */
            places?: components["schemas"]["Observation.Places"];
            /** @description FLOAT32 [M, 3], metres, M in 1..200000. */
            points?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [M, 3], metres per second; absent: unknown. Only corrections by tracks use velocities. */
            velocities?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [M], 0 or more; absent: equal weights. */
            weights?: components["schemas"]["Tensor"];
        };
        /** @description Points that move with the nodes around them, as tracked points do. */
        "Observation.Places": {
            /** @description Positions of the nodes at that time, FLOAT32 [N, 3], metres; absent: at rest. */
            node_positions?: components["schemas"]["Tensor"];
            /** @description Positions of the points at one time, FLOAT32 [M, 3], metres. */
            points?: components["schemas"]["Tensor"];
        };
        OpenSessionRequest: {
            /** @enum {string} */
            fidelity?: "EXACT" | "FAST" | "PLANNER";
            grasps?: components["schemas"]["Grasp"][];
            /**
             * Format: double
             * @description Seconds, 1..3600. Default (0): 300.
             */
            idle_timeout_s?: number;
            /** @description First state; default: the rest shape. A batch of given states has one state for each slot. */
            initial?: components["schemas"]["InitialState"];
            /**
             * Format: int64
             * @description Number of simulations, 1..4096; 0 means 1.
             */
            slots?: number;
            /** @description twins/{uuid} */
            twin?: string;
            /** @description Surroundings of every rollout of the session that gives none. */
            world?: components["schemas"]["World"];
        };
        OwnerUsage: {
            /** Format: int64 */
            captures: number;
            /**
             * Format: int64
             * @description Fits, ended ones included.
             */
            fits: number;
            /** @description Empty: what was made where no key was required. */
            owner: string;
            /**
             * Format: int64
             * @description Fits and ingests that wait for a worker.
             */
            queued_jobs: number;
            /** @description Quotas of the key that is used; in the list the widest among the owner's valid keys. Defaults of the server stand where a key has none. */
            quotas: components["schemas"]["KeyQuotas"];
            /**
             * Format: int64
             * @description Fits and ingests that run.
             */
            running_jobs: number;
            stored_bytes: components["schemas"]["StoredBytes"];
            /** Format: int64 */
            twins: number;
        };
        /** @description A pinhole camera without distortion. Axes as in OpenCV: x to the right, y down, z forward; the centre of the first pixel is at (0, 0). Surfaces and props nearer than 1 cm and Gaussians nearer than 5 cm are not seen, nor is a closed surface from its inside. */
        PictureCamera: {
            /** @description What is seen where there is neither the object nor a prop (sRGB): UINT8 [height, width, 3] or [S, height, width, 3], or a colour, [3] or [S, 3]. Absent: a light grey. */
            background?: components["schemas"]["Tensor"];
            /** Format: int64 */
            height?: number;
            /** @description fx, fy, cx, cy in pixels: FLOAT32 [4] or [S, 4]; fx and fy above 0, all up to 1e6. */
            intrinsics?: components["schemas"]["Tensor"];
            /** @description Name in errors; default `camera{index}`. At most 128 bytes. */
            name?: string;
            /** @description Pose in the world, x, y, z in metres, quaternion x, y, z, w: FLOAT32 [7] or [S, 7]. Coordinates up to 1000. */
            pose?: components["schemas"]["Tensor"];
            /**
             * Format: int64
             * @description Pixels, 8..2048 each.
             */
            width?: number;
        };
        /** @description Limits that every plan keeps, FLOAT32 [1] or by coordinate [D]; absent: none. They hold at the knots, and between knots with linear interpolation. */
        PlanBounds: {
            high?: components["schemas"]["Tensor"];
            /** @description Smallest and largest value of a coordinate, metres or radians from the start of the space. */
            low?: components["schemas"]["Tensor"];
            /** @description Highest rate of change of a coordinate, per second. */
            speed?: components["schemas"]["Tensor"];
        };
        /** @description Method that proposes plans and learns from their costs. */
        PlanMethod: {
            /** @description Only one of mppi, cem, predictive_sampling, gradient may be given. */
            cem?: components["schemas"]["PlanMethod.Cem"];
            /** @description Only one of mppi, cem, predictive_sampling, gradient may be given. */
            gradient?: components["schemas"]["PlanMethod.Gradient"];
            /** @description Only one of mppi, cem, predictive_sampling, gradient may be given. */
            mppi?: components["schemas"]["PlanMethod.Mppi"];
            /** @description Only one of mppi, cem, predictive_sampling, gradient may be given. */
            predictive_sampling?: components["schemas"]["PlanMethod.PredictiveSampling"];
        };
        /** @description Cross-entropy method: each iteration samples with the mean and spread of the best samples before. */
        "PlanMethod.Cem": {
            /**
             * Format: int64
             * @description Default (0): 8.
             */
            elites?: number;
            /**
             * Format: double
             * @description Share of the old mean and spread in the new ones, below 1; absent: 0.1.
             */
            memory?: number;
            /**
             * Format: double
             * @description Smallest spread, as a share of sigma; absent: 0.05.
             */
            smallest?: number;
        };
        /** @description Adam along the gradient, from the nominal plan and from further starts sigma away. */
        "PlanMethod.Gradient": {
            /** @description FLOAT32 [1] or [D]: largest step of an iteration, metres or radians; absent: 0.005. */
            rate?: components["schemas"]["Tensor"];
        };
        /** @description Model-predictive path integral control: the mean of all samples, weighted by their costs. */
        "PlanMethod.Mppi": {
            /**
             * Format: double
             * @description Temperature as a share of the spread of the costs. Default (0): 0.1.
             */
            temperature?: number;
        };
        /** @description Predictive sampling: takes the best of the samples around the best plan so far. */
        "PlanMethod.PredictiveSampling": Record<string, never>;
        PlanRequest: {
            bounds?: components["schemas"]["PlanBounds"];
            /**
             * Format: double
             * @description Correlation of neighbouring knots of a sample, at least 0 and below 1: larger is smoother.
             */
            correlation?: number;
            /**
             * Format: double
             * @description Time for the iterations, seconds, after which the best plan so far is returned; the first iteration is always finished. 0 means no deadline.
             */
            deadline_s?: number;
            /**
             * Format: double
             * @description Smallest scale of the samples, above 0 and at most 1. Samples use sigma times scales from 1 down to this one, evenly spaced in the logarithm. Absent: 0.1, or 1 for methods that shrink their samples themselves.
             */
            finest?: number;
            /** @description Places to grasp, searched together with the motion. */
            grasp_search?: components["schemas"]["GraspSearch"];
            /**
             * Format: int64
             * @description Default (0): 1, or 20 with a gradient; with `grasp_search` at least one for each round. At most 1,000,000 plans are simulated in total.
             */
            iterations?: number;
            method?: components["schemas"]["PlanMethod"];
            /** @description The rollout to minimize: twin or session, costs, horizon, surroundings, fidelity. Its actions, of one instance, are the nominal plan, which the first iteration starts from; returned knots can be sent unchanged. Row 0 is the current position and is not changed: where the initial state has control points (a session, or given controls), row 0 of trajectories is taken from them. `plausibility.strain` is the limit of the strain (default: 1; infinity lifts it), `plausibility.grasp_force_n` that of the force of each grasp (default: none). With `plausibility.refuse` a plan beyond any of the limits counts as diverged. `returns` apply to one more rollout, of the best plan; without any, this rollout is left out. */
            rollout?: components["schemas"]["RollOutRequest"];
            /**
             * Format: int64
             * @description Plans simulated in an iteration. Default (0): 64, or 1 with a gradient; with `grasp_search` at least 8, or 1 with a gradient, for each place.
             */
            samples?: number;
            /**
             * Format: int64
             * @description The same seed gives the same plan, unless the deadline stops the search.
             */
            seed?: number;
            /**
             * Format: double
             * @description Frames executed since the nominal plan was made: its actions are shifted by these frames, and hold their last value at the end. `closed` of grasps and paths of colliders are not shifted.
             */
            shift_frames?: number;
            /** @description Standard deviations of samples, metres or radians: FLOAT32 [1], by coordinate [D], or by knot and coordinate [K, D]; absent: 0.02. */
            sigma?: components["schemas"]["Tensor"];
            space?: components["schemas"]["ActionSpace"];
        };
        /** @description The best plan so far. */
        PlanUpdate: {
            /** @description FLOAT64 [K, D]: the same in the coordinates of the space. */
            coordinates?: components["schemas"]["Tensor"];
            /**
             * Format: double
             * @description Cost of exactly these knots, as simulated.
             */
            cost: number;
            cost_names: string[];
            /** @description FLOAT64 [terms], weighted. */
            cost_terms?: components["schemas"]["Tensor"];
            /** Format: int64 */
            diverged: number;
            /**
             * Format: int64
             * @description With `grasp_search`: the place of the best plan, and the cost of the best plan of each place so far, also of those given up, FLOAT64 [P]; +inf where every plan diverged or grasped nothing.
             */
            grasp?: number;
            grasp_costs?: components["schemas"]["Tensor"];
            /**
             * Format: double
             * @description The limit; absent without one in `plausibility.grasp_force_n`.
             */
            grasp_force_limit_n?: number;
            /**
             * Format: double
             * @description Largest mean force of a grasp over a frame in the motion of the best plan (with an ensemble, over its members), newtons (per unit mass without a mass_kg); absent without a limit and without `grasp_search`.
             */
            grasp_force_n?: number;
            /**
             * Format: int64
             * @description Finished iterations.
             */
            iterations: number;
            /** @description FLOAT32, in the shape of the request's actions: [1, K, C, 3] or [1, K, G, 7]. */
            knots?: components["schemas"]["Tensor"];
            /** @description True for the last update. */
            last: boolean;
            /**
             * Format: double
             * @description +inf if the nominal plan diverges. With `grasp_search` that of the place of the best plan.
             */
            nominal_cost: number;
            /** @enum {string} */
            origin: "NOMINAL" | "MEAN" | "SAMPLE";
            /**
             * Format: int64
             * @description Plans beyond a limit, of the strain or of the force of a grasp, that did not diverge.
             */
            overstrained: number;
            /** @description In the last update, if returns were requested: the rollout of the best plan. */
            rollout?: components["schemas"]["RollOutResponse"];
            /**
             * Format: int64
             * @description Simulated plans, and the diverged ones among them.
             */
            simulated: number;
            /** @description True if the deadline ended the search before all iterations were done. */
            stopped_by_deadline: boolean;
            /**
             * Format: double
             * @description Largest strain of the material in the motion of the best plan (with an ensemble, over its members), and the limit. A strain above the limit means that every simulated plan is beyond a limit.
             */
            strain: number;
            /** Format: double */
            strain_limit: number;
            /**
             * Format: double
             * @description Time since planning began, seconds.
             */
            time_s: number;
        };
        /** @description Points with normal . x >= offset are above it. */
        Plane: {
            /**
             * @description Unit normal pointing away from the ground, three numbers; absent: upwards, 0 0 1.
             * @default []
             */
            normal: number[];
            /**
             * Format: float
             * @description Metres along the normal.
             * @default 0
             */
            offset_m: number;
        };
        /** @description Limits of plausible motion. A reply flags instances beyond a limit; with `refuse` the call ends with FAILED_PRECONDITION, reason IMPLAUSIBLE_MOTION, instead, and does so before the simulation if the actions alone are beyond a limit. */
        Plausibility: {
            /**
             * Format: double
             * @description Largest depth of the middle of a grasp's sphere or box below the ground or inside a static collider, and of a control point beyond its depth in the initial state; default 0.005. Hands and grippers stop at that depth below the ground (Diagnostics.stopped_hand_m).
             */
            control_depth_m?: number;
            /**
             * Format: double
             * @description Highest speed of a control point; default 5.
             */
            control_speed_m_s?: number;
            /**
             * Format: double
             * @description Largest mean force of a grasp over a frame, newtons (per unit mass without a mass_kg); default: none. Each grasp beyond it is listed. A grasp with max_force_n that slips counts with the force at which it slipped.
             */
            grasp_force_n?: number;
            refuse?: boolean;
            /**
             * Format: double
             * @description Largest distance between the initial state's control points and row 0 of the actions; default 0.005. The limit is 0.02 larger if a given state has no control points.
             */
            start_gap_m?: number;
            /**
             * Format: double
             * @description Largest strain of the material; default 1.
             */
            strain?: number;
        };
        /** @description A recorded play, as rollouts that anyone can repeat. */
        PlayRecording: {
            /**
             * Format: double
             * @description Frames a second.
             */
            fps: number;
            /** @description Bodies of `POST /v1/twins/{id}/rollouts`, one after the other. */
            segments: components["schemas"]["RollOutRequest"][];
            /** @description twins/{uuid} */
            twin: string;
        };
        /** @description The predicted node positions of a sequence, and the errors of each frame. The sequence has T frames; the prediction starts in `start_frame` S. */
        PredictedMotion: {
            /** @description One-sided Chamfer distance in the L1 norm, in each frame from S on [m], float32 [T - S]; NaN where it was not measured. */
            chamfer_l1_m?: components["schemas"]["Tensor"];
            /**
             * Format: int64
             * @description Frames from one row of `positions` to the next: 1, or more where all frames would take more than 16 MiB.
             */
            every_frames: number;
            /**
             * Format: double
             * @description Frames per second.
             */
            fps: number;
            /**
             * Format: int64
             * @description T
             */
            frame_count: number;
            /** @description Name of the sequence. */
            name: string;
            /** @description Positions of nodes [m], float32 [R, N, 3]; row r is of frame `start_frame + r * every_frames`. */
            positions?: components["schemas"]["Tensor"];
            /** @description Name of the recording. */
            recording: string;
            /**
             * Format: int64
             * @description The requested index.
             */
            sequence: number;
            /**
             * Format: int64
             * @description S
             */
            start_frame: number;
            /** @description Mean distance of predicted from observed tracked points in each frame from S on [m], float32 [T - S]; NaN where it was not measured. */
            track_m?: components["schemas"]["Tensor"];
            /**
             * Format: int64
             * @description Frames before this one were used for fitting; 0 if the twin was fitted to no frame of the sequence.
             */
            train_frame_count: number;
        };
        PreviewRetentionResponse: {
            /** @description In the order of deletion: twins, fits, captures, the oldest first. What several rules match stands under the first of them. */
            outcomes: components["schemas"]["RetentionOutcome"][];
            /** @description True if there are more than are listed. */
            truncated: boolean;
        };
        /** @description An RFC 9457 problem document. */
        ProblemDocument: {
            /** @description The event, and the action to take. */
            detail: string;
            /** @description A stable word for programs. */
            reason: string;
            /** @description To be quoted when reporting the problem. */
            request_id: string;
            /**
             * Format: int32
             * @description The HTTP status.
             */
            status: number;
            /** @description The category, as gRPC names it. */
            title: string;
            /** @description `urn:bendtwin:error:{reason}`. */
            type: string;
        };
        /** @description Progress of a running job. */
        Progress: {
            /** Format: double */
            best_loss: number | null;
            /**
             * Format: double
             * @description Error over the training frames of the newest preview of a fit, metres (GetFitPreview).
             */
            error_m: number | null;
            /** Format: double */
            eta_s: number | null;
            /**
             * Format: double
             * @description Fraction of the whole job that is done, 0..1.
             */
            fraction: number;
            /** Format: int64 */
            iteration: number;
            /** Format: int64 */
            iterations: number;
            /** Format: double */
            loss: number | null;
            /** @description The latest loss of each model, when several are fitted side by side. */
            models: components["schemas"]["ModelLoss"][];
            note: string | null;
            /** @description Stage: ingest, search, refine or evaluate. */
            stage: string;
            /** @description Model: bending or axial; for an ingest, the step. */
            variant: string;
        };
        Project: {
            /** Format: date-time */
            create_time: string;
            /** @description 1 to 200 characters. */
            display_name: string;
            /** @description Names of owners, sorted; up to 200. */
            members: string[];
            /** @description projects/{uuid} */
            name: string;
        };
        /** @description A rigid thing in pictures. It has no effect on the simulation. */
        Prop: {
            /** @description Only one of sphere, capsule, cuboid, convex_mesh may be given. */
            capsule?: components["schemas"]["Capsule"];
            /** @description Colour (sRGB), UINT8 [3] or [S, 3]; absent: grey. */
            color?: components["schemas"]["Tensor"];
            /** @description Only one of sphere, capsule, cuboid, convex_mesh may be given. */
            convex_mesh?: components["schemas"]["ConvexMesh"];
            /** @description Only one of sphere, capsule, cuboid, convex_mesh may be given. */
            cuboid?: components["schemas"]["Cuboid"];
            /** @description Pose, x, y, z in metres, quaternion x, y, z, w: FLOAT32 [7] or [S, 7]; absent: the origin. */
            pose?: components["schemas"]["Tensor"];
            /** @description Only one of sphere, capsule, cuboid, convex_mesh may be given. */
            sphere?: components["schemas"]["Sphere"];
        };
        /** @description State of the server as `/readyz` reports it. */
        Readiness: {
            /** @description Name and version of the server's program. */
            build: string;
            /**
             * @description `running`: the server is not stopping; `writes`: a change can be made to last; `disk`: there
             *     is more free space than the floor; `workers`: at least one answers.
             */
            checks: components["schemas"]["Check"][];
            /** @description True if all checks are ok. */
            ready: boolean;
            /** @description Rollouts under way or waiting. */
            rollouts: number;
            /** @description Registered workers. */
            workers: number;
        };
        RegisterOptions: {
            /**
             * Format: double
             * @description Standard deviation of a spring's relative length; default 0.1.
             */
            give?: number;
            /**
             * Format: double
             * @description Smallest share of the points that must be explained, 0..1; default 0.5.
             */
            least_explained?: number;
            /**
             * Format: double
             * @description Median distance of the points above which the registration is refused, metres; default: half the node spacing, at least 0.005.
             */
            max_residual_m?: number;
            /** @description The object is near the shape to start from, so that no other pose is tried. */
            near?: boolean;
            /**
             * Format: double
             * @description Standard deviation of a point from the surface, metres; default 0.004.
             */
            noise_m?: number;
            /**
             * Format: int64
             * @description Frames of physics, 0..1000; default 12. With 0 the shape follows the points alone.
             */
            settle_frames?: number;
        };
        RegisterStateRequest: {
            /** @description Positions of the control points, FLOAT32 [C, 3], metres, if known, for example from the gripper. Absent: control points follow the nodes that they hold. */
            controls?: components["schemas"]["Tensor"];
            /** @description Poses of the grippers that carry colliders of the world, FLOAT32 [G, 7]: x, y, z in metres, quaternion x, y, z, w. Colliders carried by other grippers are left out. */
            grippers?: components["schemas"]["Tensor"];
            /** @description Shape to start from: a single state, not one of a session; default: the rest shape. */
            initial?: components["schemas"]["InitialState"];
            observation?: components["schemas"]["Observation"];
            options?: components["schemas"]["RegisterOptions"];
            /** @description twins/{uuid} */
            twin?: string;
            /** @description Gravity, ground and colliders, where they differ from those of the twin. The state is outside of the ground and the colliders, except nodes held by control points. A collider on a path is at its first pose. */
            world?: components["schemas"]["World"];
        };
        RegisteredState: {
            after?: components["schemas"]["Residual"];
            /** @description Distances of the points from the shape to start from, and from the registered state. */
            before?: components["schemas"]["Residual"];
            /**
             * Format: double
             * @description Mean distance by which nodes move in a frame once the points stop pulling, millimetres: a measure of how far the state is from equilibrium.
             */
            drift_mm: number;
            explained?: components["schemas"]["Explained"];
            /** @description The rigid part of the motion from the shape to start from, about the origin: x, y, z in metres, quaternion x, y, z, w. */
            motion: number[];
            /** @description The state, at rest, with its control points; InitialState.given accepts it unchanged. */
            state?: components["schemas"]["InitialState.GivenState"];
            /** @description workers/{uuid} */
            worker: string;
        };
        /** @description Pictures of S slots by each of the cameras. Arrays with [S] in front have a row for each slot, in the order of the slots; those without apply to all slots. */
        RenderSessionRequest: {
            /** @description 1..8. All pictures of a call together have at most 8,388,608 pixels. */
            cameras?: components["schemas"]["PictureCamera"][];
            /** @description Return depths as well. */
            depths?: boolean;
            /** @description Return labels of what is seen in each pixel as well. */
            labels?: boolean;
            light?: components["schemas"]["Light"];
            /** @enum {string} */
            look?: "SURFACE" | "GAUSSIANS";
            /** @description sessions/{uuid} */
            name?: string;
            /** @description Rigid things beside the object: tables, bins, grippers, goals. At most 64. */
            props?: components["schemas"]["Prop"][];
            /** @description Empty: all slots. At most 1024. */
            slots?: number[];
        };
        RenderedSession: {
            /** @description One set for each camera. */
            cameras: components["schemas"]["RenderedSession.Pictures"][];
            /** @description The slots of the pictures. */
            slots: number[];
        };
        "RenderedSession.Pictures": {
            /** @description sRGB, UINT8 [S, height, width, 3]. */
            colors?: components["schemas"]["Tensor"];
            /** @description Distance of what the label names along the camera's axis, metres; 0 for the background. FLOAT32 [S, height, width]. */
            depths?: components["schemas"]["Tensor"];
            /** @description What covers most of a pixel: 0 the background, 1 the object, 2 + i prop i. UINT8 [S, height, width]. */
            labels?: components["schemas"]["Tensor"];
        };
        ResetSessionRequest: {
            /** @description Absent: the session's first state. */
            initial?: components["schemas"]["InitialState"];
            name?: string;
            /** @description Empty: all slots. */
            slots?: number[];
        };
        /** @description Distances between points and the twin, millimetres: from tracks to their places, from the points of a cloud to the surface. */
        Residual: {
            /** Format: double */
            mean_mm: number;
            /** Format: double */
            median_mm: number;
            /**
             * Format: double
             * @description 95th percentile.
             */
            p95_mm: number;
        };
        /** @description A resource that a rule matches. */
        RetentionOutcome: {
            /** Format: date-time */
            create_time: string;
            display_name: string;
            /** @description Why it is kept; empty if it would be deleted. */
            kept_because: string;
            /** @description captures/{uuid}, fits/{uuid} or twins/{uuid} */
            name: string;
            owner: string;
            /** @description Display name of the rule. */
            rule: string;
            /**
             * Format: int64
             * @description Size of the archive of a capture, or of a twin file; 0 for a fit [bytes].
             */
            size_bytes: number;
        };
        /** @description A rule. It matches what fulfils all of its conditions. */
        RetentionRule: {
            /** @description captures, fits or twins */
            collection: string;
            /**
             * Format: date-time
             * @description Absent for a rule of the server's configuration.
             */
            create_time: string | null;
            display_name: string;
            /**
             * Format: double
             * @description Only what was created at least this long ago [days].
             */
            min_age_days: number;
            /** @description retention/{uuid}; empty for a rule of the server's configuration. */
            name: string | null;
            /** @description Only what this owner has; empty: any. */
            owner: string;
            /** @description Only what has this tag; empty: any. */
            tag: string;
            /** @description Only captures whose report has this verdict; empty: any. */
            verdict: string;
        };
        Returns: {
            /** @description d cost / d actions as the request gave them: knots or poses, in their shape. */
            action_gradients?: boolean;
            /**
             * Format: int64
             * @description Return positions, final states and gradients only of the best k instances by cost; 0 means all. The best are simulated once more: on a GPU their motion may differ in the last bits from the one that the costs were computed from.
             */
            best?: number;
            /** @description d cost / d control positions, dense. */
            control_gradients?: boolean;
            /** @description Control positions as simulated, by frame. */
            controls?: boolean;
            diagnostics?: boolean;
            /** @enum {string} */
            encoding?: "FLOAT32" | "INT16";
            /**
             * Format: int64
             * @description Record the positions of every k-th frame; 0 records none.
             */
            every_frames?: number;
            final_state?: boolean;
            /** @description Forces by frame. */
            forces?: boolean;
            /** @description Costs by frame and by term. */
            frame_costs?: boolean;
            /** @description Norm of d cost / d positions by frame. */
            gradient_norms?: boolean;
            /** @description d cost / d initial positions and velocities. */
            initial_gradients?: boolean;
            /** @description UINT32 [K]: nodes to record, with the point set NODES; empty means all. */
            nodes?: components["schemas"]["Tensor"];
            /**
             * Format: int64
             * @description Only for StreamRollOut: most frames in a part, which is sent as soon as it is simulated; 0 for whole instances. Not with `best` or gradients.
             */
            part_frames?: number;
            /**
             * @description Points whose positions and velocities are recorded: NODES, the default, or SKIN. Final states and gradients are always those of nodes.
             * @enum {string}
             */
            point_set?: "NODES" | "SKIN";
            /** @description UINT32 [K]: points of the skin to record, with the point set SKIN; empty means all. */
            skin_points?: components["schemas"]["Tensor"];
            /** @description With an ensemble of two members or more, and every_frames: return the `spread` of the recorded points. The other arrays (positions, velocities, final states, forces, costs by frame, controls) are then those of member 0 of each action only, or of the mean with MEAN_PREDICTION. */
            spread?: boolean;
            /** @description Velocities where positions are recorded. */
            velocities?: boolean;
        };
        /** @description B instances of one twin, F frames each. */
        RollOutRequest: {
            costs?: components["schemas"]["Cost"][];
            ensemble?: components["schemas"]["Ensemble"];
            /** @enum {string} */
            fidelity?: "EXACT" | "FAST" | "PLANNER";
            /**
             * Format: int64
             * @description Horizon F in frames, 1..100000; 0 means the horizon of the dense actions.
             */
            frames?: number;
            gradient?: components["schemas"]["GradientOptions"];
            /** @description At most 32. */
            grasps?: components["schemas"]["Grasp"][];
            initial?: components["schemas"]["InitialState"];
            knot_times?: components["schemas"]["KnotTimes"];
            plausibility?: components["schemas"]["Plausibility"];
            /** @description Only one of trajectories, poses may be given. */
            poses?: components["schemas"]["GripperPoses"];
            returns?: components["schemas"]["Returns"];
            /**
             * Format: double
             * @description Time from the arrival of the request after which no further instances are started, seconds, above 0; absent: no limit. The reply lists the missing instances in `unfinished`. Arrays of `returns.best` are simulated after the limit. Not with gradients or `returns.part_frames`.
             */
            time_limit_s?: number;
            /** @description Only one of trajectories, poses may be given. */
            trajectories?: components["schemas"]["ControlTrajectories"];
            /** @description twins/{uuid} */
            twin?: string;
            vary?: components["schemas"]["Vary"];
            world?: components["schemas"]["World"];
        };
        RollOutResponse: {
            /** @description In the shape of the actions of R instances: [R, K, C, 3], or [R, K, G, 7] for poses. d cost / d quaternion is tangent to the sphere of unit quaternions. */
            action_gradients?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [R, F + 1, C, 3]. */
            control_gradients?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [R, F + 1, C, 3], metres. */
            controls?: components["schemas"]["Tensor"];
            cost_names: string[];
            /** @description FLOAT64 [B', terms], weighted. */
            cost_terms?: components["schemas"]["Tensor"];
            /** @description Weighted sums of the costs, FLOAT64 [B']; +inf where an instance diverged. */
            costs?: components["schemas"]["Tensor"];
            /** @description With FAST or PLANNER only: deviation from the exact twin, as measured for the twin. */
            deviation?: components["schemas"]["RollOutResponse.Deviation"];
            diagnostics: components["schemas"]["RollOutResponse.Diagnostics"][];
            diverged: components["schemas"]["RollOutResponse.Divergence"][];
            /**
             * @description Fidelity of the answer: EXACT, FAST or PLANNER.
             * @enum {string}
             */
            fidelity: "EXACT" | "FAST" | "PLANNER";
            /** @description InitialState.GivenState.commanded_controls of the final state, with `poses`: FLOAT32 [R, C, 3], metres. */
            final_commanded_controls?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [R, C, 3], metres: the control points of the final state. */
            final_controls?: components["schemas"]["Tensor"];
            /** @description Shapes with [R] in front; absent without grasps. */
            final_grasping?: components["schemas"]["Grasping"];
            /** @description FLOAT32 [R, N, 3]. */
            final_positions?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [R, rods], radians; absent if the twin has no rods. Together with final_positions and final_velocities this is a complete state, from which InitialState.given continues. */
            final_twists?: components["schemas"]["Tensor"];
            final_velocities?: components["schemas"]["Tensor"];
            /**
             * Format: int64
             * @description First of the instances that this part covers: first_instance .. first_instance + B'.
             */
            first_instance: number;
            forces?: components["schemas"]["RollOutResponse.Forces"];
            /** @description FLOAT64 [R, F + 1, terms], weighted. */
            frame_costs?: components["schemas"]["Tensor"];
            /** @description UINT32 [T']: recorded frames, 1-based. */
            frames?: components["schemas"]["Tensor"];
            /** @description 1 for an instance whose gradient exploded on its way back and is of little use (docs/use/gradients.md); UINT32 [R]. */
            gradient_exploded?: components["schemas"]["Tensor"];
            /** @description FLOAT64 [R, F + 1]. */
            gradient_norms?: components["schemas"]["Tensor"];
            /** @description Implausible instances, with the reason; RollOutRequest.plausibility has the limits. */
            implausible: components["schemas"]["RollOutResponse.Implausible"][];
            /** @description FLOAT32 [R, N, 3]. */
            initial_position_gradients?: components["schemas"]["Tensor"];
            initial_velocity_gradients?: components["schemas"]["Tensor"];
            /** @description Instances of the rows of positions, final states and gradients, UINT32 [R]: best first if `best` was given, otherwise ascending. */
            instances?: components["schemas"]["Tensor"];
            /**
             * Format: double
             * @description Mass of the object, kilograms: forces are in newtons and energies in joules. Without a known mass they are per unit mass, as if a node of the twin weighed 1 kg.
             */
            mass_kg?: number;
            /** @description With an ensemble: the costs of the members, FLOAT64 [B', E]. `costs` are statistics of them, except with MEAN_PREDICTION. */
            member_costs?: components["schemas"]["Tensor"];
            /** @description Positions of nodes, or of skin points (`returns.point_set`), [R, T', K, 3], metres. */
            positions?: components["schemas"]["Tensor"];
            /** @description Root mean square distance of the other members' points from the points in `positions`, FLOAT32 [actions, T', K], metres. `positions` are those of member 0, except with MEAN_PREDICTION. NaN where a member diverged. */
            spread?: components["schemas"]["Tensor"];
            /**
             * Format: int64
             * @description Substeps per frame that were simulated.
             */
            substeps: number;
            /** @description Present if a cost has a condition of success: 1 for an instance that meets all conditions, and otherwise 0, also where it diverged or is unfinished. With an ensemble, the share of members that meet them; with MEAN_PREDICTION that of the mean motion. FLOAT32 [B']. */
            successes?: components["schemas"]["Tensor"];
            timing?: components["schemas"]["RollOutResponse.Timing"];
            /** @description Instances that were not simulated within `time_limit_s`, UINT32. Their costs are +inf, their arrays NaN. */
            unfinished?: components["schemas"]["Tensor"];
            /** @description Velocities of the recorded points, [R, T', K, 3], metres per second. */
            velocities?: components["schemas"]["Tensor"];
            /** @description With `returns.part_frames`: the frames that this part covers. */
            window?: components["schemas"]["RollOutResponse.Window"];
            /** @description workers/{uuid} */
            worker: string;
        };
        /** @description Deviation of the fast variant from the exact twin when both follow the twin's own capture from its start. The deviation in this reply may be larger: with faster or larger motions, or other surroundings, 5 to 16 times as much was seen. With PLANNER, deviation of the planner's twin from the exact twin under sampled actions that it was not fitted to. */
        "RollOutResponse.Deviation": {
            /**
             * Format: int64
             * @description Largest number of frames of a recording or action.
             */
            frames: number;
            /** Format: double */
            max_m: number;
            /**
             * Format: double
             * @description Distance of a node in one from the same node in the other, over nodes and frames, metres; with PLANNER, of points of the skin.
             */
            mean_m: number;
            /**
             * Format: double
             * @description For comparison: mean distance of the exact twin's nodes or skin points from their start, metres.
             */
            mean_travel_m: number;
        };
        "RollOutResponse.Diagnostics": {
            /**
             * Format: float
             * @description Largest depth of the middle of a grasp's sphere or box below the ground or inside a static collider, and of a control point or a held node beyond its depth at the start, metres; where hands were stopped at the ground, the depth that the actions commanded.
             */
            control_depth_m: number;
            /** Format: float */
            elastic_energy: number;
            /** Format: int64 */
            ground_contacts: number;
            /**
             * Format: float
             * @description Energies at the end, joules; without a mass_kg as if a node of the twin weighed 1 kg.
             */
            kinetic_energy: number;
            /**
             * Format: float
             * @description Largest strain of springs to control points.
             */
            max_control_strain: number;
            /**
             * Format: float
             * @description Highest speed of a node at the end of any frame.
             */
            max_speed_m_s: number;
            /**
             * Format: float
             * @description Largest strain of springs between nodes.
             */
            max_strain: number;
            /**
             * Format: float
             * @description Largest distance by which a hand or gripper was held back, metres; 0 if none was. A hand stops where one of its control points, a node pinned to one, or the middle of a grasp's sphere or box would be deeper below the ground than `plausibility.control_depth_m`; the whole hand is then shifted along the ground's normal. Control points may also be as deep as in the frame before, and as deep below the twin's own ground as they are at rest.
             */
            stopped_hand_m: number;
        };
        "RollOutResponse.Divergence": {
            /**
             * Format: int64
             * @description 1-based.
             */
            frame: number;
            /** Format: int64 */
            instance: number;
            /** Format: int64 */
            node: number;
        };
        /** @description Mean forces on the object over each frame. */
        "RollOutResponse.Forces": {
            /** @description FLOAT32 [R, F, K, 6], like `grasps`; torque about the carrier's origin. */
            colliders?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [R, F, C, 3], newtons. */
            controls?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [R, F, G, 6]: force in newtons, then torque in newton metres about the gripper's origin at the end of the frame, along the world's axes. */
            grasps?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [R, F, 3]. */
            ground?: components["schemas"]["Tensor"];
        };
        "RollOutResponse.Implausible": {
            /**
             * Format: double
             * @description Largest value found, and the limit, in the unit of the limit.
             */
            found: number;
            /**
             * Format: int64
             * @description Frame in which the value was found, where known.
             */
            frame: number;
            /**
             * Format: int64
             * @description With GRASP_FORCE: index of the grasp.
             */
            grasp?: number;
            /** Format: int64 */
            instance: number;
            /** Format: double */
            limit: number;
            /** @description START_GAP, CONTROL_SPEED, STRAIN, CONTROL_IN_OBSTACLE, GRASP_FORCE. */
            reason: string;
        };
        "RollOutResponse.Timing": {
            /** Format: double */
            compute_s: number;
            /** Format: double */
            queue_s: number;
        };
        /** @description Part of the horizon. Arrays by frame have the rows of these frames, so that the arrays of all parts can be concatenated; the start, frame 0, is in the first part. Costs, their terms, diagnostics, implausible instances and final states come with the last part of an instance; a divergence comes with the part in which it happened. */
        "RollOutResponse.Window": {
            /**
             * Format: int64
             * @description 1-based, both inclusive.
             */
            first_frame: number;
            /** Format: int64 */
            last_frame: number;
        };
        Session: {
            /** @enum {string} */
            fidelity: "EXACT" | "FAST" | "PLANNER";
            /** @description Frames by which each slot has been advanced since its first state, [slots]. */
            frames: number[];
            /**
             * Format: double
             * @description Time without calls after which the session ends, seconds.
             */
            idle_timeout_s: number;
            /** @description Lost slots, ascending: see Tracking. */
            lost: number[];
            /** @description sessions/{uuid} */
            name: string;
            /** Format: int64 */
            slots: number;
            /** @description twins/{uuid} */
            twin: string;
            /** @description workers/{uuid} */
            worker: string;
        };
        SessionStates: {
            frames: number[];
            slots: number[];
            /** @description Shapes with [S] in front for S slots; InitialState.given accepts it unchanged. */
            states?: components["schemas"]["InitialState.GivenState"];
        };
        Share: {
            /** @description True if its holder may download the twin. */
            allow_export: boolean;
            /** Format: date-time */
            create_time: string;
            display_name: string;
            /**
             * Format: date-time
             * @description The share is refused from this time on.
             */
            expire_time: string;
            /**
             * Format: date-time
             * @description Last use, accurate to about a minute; absent if the share has not been used.
             */
            last_use_time: string | null;
            /** @description shares/{uuid} */
            name: string;
            /** @description Owner of the key that made the share. */
            owner: string;
            /**
             * Format: date-time
             * @description Absent unless the share has been revoked.
             */
            revoke_time: string | null;
            /** @description twins/{uuid} */
            twin: string;
        };
        ShareTwinRequest: {
            /** @description True if its holder may download the twin. */
            allow_export?: boolean;
            /** @description For whom the link is: up to 200 characters. */
            display_name?: string;
            /**
             * Format: date-time
             * @description The time at which it expires; not together with `ttl_s`.
             */
            expire_time?: string;
            /**
             * Format: int64
             * @description Time until it expires, at most 90 days [s]. Default (0): 7 days.
             */
            ttl_s?: number;
        };
        ShareTwinResponse: {
            /** @description The key, `bt_{id}_{secret}`, which the link `/#/shared/{id of the twin}?key={key}` contains. */
            secret_key: string;
            share: components["schemas"]["Share"];
        };
        SignInOptions: {
            /** @description Name of the provider, for people. */
            display_name: string;
            /** @description False where the server has no identity provider. */
            enabled: boolean;
            /** @description Origin at which browsers have to begin, since the provider sends them back to it: `https://twin.example`. Empty without a provider. */
            public_url: string;
        };
        Sphere: {
            /** @description Centre, three numbers; absent: the origin. */
            center?: number[];
            /** Format: float */
            radius_m?: number;
        };
        StartDeviceSignInResponse: {
            /** @description Shown in CreateSignIn. A secret. */
            device_code: string;
            /**
             * Format: double
             * @description Time after which the code is not accepted any more [s].
             */
            expires_in_s: number;
            /**
             * Format: double
             * @description Least time between two attempts [s].
             */
            interval_s: number;
            /** @description What the person enters at the provider. */
            user_code: string;
            /** @description Where. */
            verification_uri: string;
            /** @description The same with the code in it; empty if the provider has none. */
            verification_uri_complete: string;
        };
        StartSignInRequest: {
            /** @description SHA-256 of the code verifier, base64url (RFC 7636, S256). */
            code_challenge: string;
            /** @description Random text that the ID token has to contain: 43 characters of base64url. */
            nonce: string;
            /** @description Random text of the browser, which the provider returns: 43 characters of base64url. */
            state: string;
        };
        StartSignInResponse: {
            authorization_url: string;
        };
        StepSessionRequest: {
            /** @description The correction, without name and slots, which are given above. Absent: nothing is corrected. */
            correction?: components["schemas"]["CorrectSessionRequest"];
            /**
             * Format: double
             * @description Time for the whole step, seconds; 0 means no deadline. The correction is always completed; the search ends when nine tenths of the time have passed, but always finishes its first iteration.
             */
            deadline_s?: number;
            /**
             * Format: int64
             * @description Frames of the best plan by which the slot is advanced, up to the horizon; 0 only plans.
             */
            execute_frames?: number;
            /** @description sessions/{uuid} */
            name?: string;
            /** @description Returns of the rollout of these frames. */
            returns?: components["schemas"]["Returns"];
            /** @description The plan, with a rollout without twin, initial state and returns; without world or grasps the rollout uses those of the session. The actions of the rollout are the nominal plan: to continue the plan of the step before, send its knots with the executed frames as `shift_frames`. Fidelity and ensemble apply only to the search, except that a MEAN_PREDICTION also advances the slot. */
            search?: components["schemas"]["PlanRequest"];
            /**
             * Format: int64
             * @description The slot to correct, to plan from and to advance.
             */
            slot?: number;
        };
        SteppedSession: {
            /** @description The rollout of the executed frames; absent without any. If it diverged, the slot keeps the state in which the plan began. */
            advanced?: components["schemas"]["RollOutResponse"];
            /** @description The correction, without the corrected state; absent if none was requested, or if it was refused. */
            corrected?: components["schemas"]["CorrectedSession"];
            /** @description True if the slot no longer follows its object: predictions and plans from it are meaningless until it is registered again. */
            lost: boolean;
            /** @description The best plan, as in the last update of a search. */
            plan?: components["schemas"]["PlanUpdate"];
            /** @description The reason, if the correction was refused because the slot does not explain the points: the state of the slot is unchanged, and the plan starts from the predicted state. */
            refused?: components["schemas"]["Fault"];
            /** @description The current state of the slot, for all instances; InitialState.given accepts it unchanged. */
            state?: components["schemas"]["InitialState.GivenState"];
            times?: components["schemas"]["SteppedSession.Times"];
        };
        /** @description Times of the parts and of the whole step, seconds. */
        "SteppedSession.Times": {
            /** Format: double */
            advance_s: number;
            /** Format: double */
            correct_s: number;
            /** Format: double */
            plan_s: number;
            /** Format: double */
            total_s: number;
        };
        /** @description Sizes [bytes]. Equal content counts for each resource that has it. */
        StoredBytes: {
            /**
             * Format: int64
             * @description Archives of captures, and files that were added to them.
             */
            captures: number;
            /**
             * Format: int64
             * @description Checkpoints of jobs that have not ended.
             */
            checkpoints: number;
            /**
             * Format: int64
             * @description Observations, playbacks, masks and reports, which ingests made.
             */
            derived: number;
            /**
             * Format: int64
             * @description The sum, which the quota `stored_bytes` bounds.
             */
            total: number;
            /** Format: int64 */
            twins: number;
            /**
             * Format: int64
             * @description Uploads in progress: the declared sizes, or what has arrived and is set aside for more.
             */
            uploads: number;
        };
        /** @description A file that was added to a capture, which ingests read beside the archive. */
        Supplement: {
            /** Format: date-time */
            create_time: string;
            /** @description BLAKE3 of the file, hex. */
            digest: string;
            /** @description `masks`, an archive (ZIP or tar) with a folder `mask`, in place of the recording's own masks; or `calibration`, a JSON document, in place of its own calibration (docs/formats/capture.md). */
            kind: string;
            /** Format: int64 */
            size_bytes: number;
        };
        /** @description A dense array: nested lists of numbers, in which null stands for what is no finite number, or raw bytes. */
        Tensor: unknown[] | {
            /** @description Base64 of the little-endian, row-major bytes. */
            data: string;
            /** @enum {string} */
            dtype: "FLOAT32" | "FLOAT64" | "UINT32" | "INT32" | "UINT8" | "INT16_SCALED";
            /** @description Of INT16_SCALED. */
            offset?: number;
            /** @description Of INT16_SCALED: value = int16 * scale + offset. */
            scale?: number;
            shape: number[];
        };
        /** @description Record of how well a slot has explained its observations, refused ones included, since its state was last set or registered. The misfit of an observation is the larger of two ratios: the median distance of its points after the correction over a length, which is the largest of half the node spacing, 5 mm and noise_m; and the share of its points that are farther away than that length and than three noise_m, over 1/2. Up to a misfit of 1 the observation is explained. */
        Tracking: {
            /** @description True if the last three observations in a row are not explained, or if the mean misfit is above 1: the slot no longer follows its object. Register it again (CorrectOptions.register_if_lost). */
            lost: boolean;
            /**
             * Format: double
             * @description Weighted mean of the misfits, each counted as at most 1.5 and with 3/4 of the weight of the next; 0 before the first observation.
             */
            misfit: number;
            /**
             * Format: int64
             * @description Number of latest observations in a row that are not explained.
             */
            unexplained: number;
        };
        /** @description A deleted capture, fit or twin. */
        TrashedResource: {
            /** Format: date-time */
            create_time: string;
            /** Format: date-time */
            delete_time: string;
            /** @description Owner of the key that deleted it, or `retention: ` and the name of the rule that did; empty if unknown. */
            deleted_by: string;
            display_name: string;
            /** @description captures/{uuid}, fits/{uuid} or twins/{uuid} */
            name: string;
            owner: string;
            /**
             * Format: date-time
             * @description Purged from this time on, or earlier if the disk of the server gets full.
             */
            purge_time: string;
            /**
             * Format: int64
             * @description Size of the archive of a capture, or of a twin file; 0 for a fit [bytes].
             */
            size_bytes: number;
        };
        Twin: {
            /** @description The capture and the fit that the twin came from; empty for an imported twin. */
            capture: string | null;
            /** Format: int64 */
            control_count: number;
            /** Format: date-time */
            create_time: string;
            /** @description BLAKE3 of the twin file, hex. */
            digest: string;
            display_name: string;
            /**
             * Format: double
             * @description Error over frames that the twin was not fitted to, metres: the first of track error, coordinate error and Chamfer distance that the quality table has.
             */
            error_m: number | null;
            fit: string | null;
            /** Format: double */
            fps: number;
            /**
             * Format: double
             * @description Mass of the object, if known.
             */
            mass_kg?: number;
            /** @description twins/{uuid} */
            name: string;
            /** Format: int64 */
            node_count: number;
            /** @description Note written by users, up to 10,000 bytes. */
            note: string;
            /** @description Owner of the key that created the fit or imported the twin; empty if unknown. */
            owner: string;
            /** @description The quality table as JSON (docs/formats/twin.md, `quality`). */
            quality: {
                [key: string]: unknown;
            };
            /** Format: int64 */
            size_bytes: number;
            /** Format: int64 */
            spring_count: number;
            /** Format: int64 */
            substeps: number;
            /** @description Up to 32 tags of up to 50 characters, sorted. */
            tags: string[];
            /** Format: int64 */
            triplet_count: number;
        };
        TwinGeometry: {
            /** @description FLOAT32 [T]: newton metres per radian, or per unit mass. */
            bend_stiffness?: components["schemas"]["Tensor"];
            /** @description Control points at rest, FLOAT32 [C, 3], metres. */
            controls?: components["schemas"]["Tensor"];
            /** @description Endpoints of the springs, UINT32 [E, 2]: nodes, or control points from number N on. */
            edges?: components["schemas"]["Tensor"];
            /**
             * Format: int64
             * @description Number of fits: the twin itself and its members.
             */
            fits: number;
            /** Format: double */
            fps: number;
            /** @description Three numbers, m/s^2. */
            gravity: number[];
            /** @description Absent: none. */
            ground?: components["schemas"]["Plane"];
            /** Format: float */
            ground_friction: number;
            /** Format: float */
            ground_restitution: number;
            /** @description The capture's hand to which each control point belongs, UINT32 [C]. */
            hands?: components["schemas"]["Tensor"];
            /** @description Kinds of the nodes, UINT8 [N]: 0 observed surface, 1 completed surface, 2 interior. Surface nodes come first. */
            kinds?: components["schemas"]["Tensor"];
            /** Format: double */
            mass_kg?: number;
            /** @description Node masses, FLOAT32 [N]: kilograms if `mass_kg` is known, else relative to one node. */
            masses?: components["schemas"]["Tensor"];
            /** @description The region of each node, UINT8 [N]: its index among `regions` of the quality table's `identifiability`. Empty: the twin has no such report. */
            node_regions?: components["schemas"]["Tensor"];
            /** @description Nodes pinned to control points, UINT32 [P, 2]: pairs of node and control point. */
            pins?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [E], metres. */
            rest_lengths?: components["schemas"]["Tensor"];
            /** @description Rest shape, FLOAT32 [N, 3], metres. */
            rest_positions?: components["schemas"]["Tensor"];
            /** Format: int64 */
            rod_count: number;
            rod_nodes?: components["schemas"]["Tensor"];
            /** @description Nodes of the rods, one rod after another: UINT32 [rods + 1] offsets into UINT32 [..] nodes. */
            rod_starts?: components["schemas"]["Tensor"];
            skin?: components["schemas"]["TwinGeometry.Skin"];
            /** @description Standard deviation that the recordings leave for each skin point, FLOAT32 [M], metres: root mean square over the motions of that report. */
            skin_sd?: components["schemas"]["Tensor"];
            /**
             * Format: double
             * @description Mean length of the springs between nodes, metres.
             */
            spacing_m: number;
            /** @description FLOAT32 [E]: newtons per unit strain if `mass_kg` is known, else per unit mass. */
            spring_stiffness?: components["schemas"]["Tensor"];
            /** Format: int64 */
            substeps: number;
            /** Format: int64 */
            surface_count: number;
            /** @description Nodes of the bending triplets, UINT32 [T, 3], the centre in the middle. */
            triplets?: components["schemas"]["Tensor"];
        };
        /** @description Points of a twin's surface, finer than its nodes, that the nodes carry: M points, K weights. Point m is at the sum over its weights of w x(node), plus its offset along the axes of its frame. With nodes a, b, c of the frame the axes are e1 along x(b) - x(a), e2 = e3 x e1, and e3 along (x(b) - x(a)) x (x(c) - x(a)). For a twin fitted without a skin, the skin points are the surface nodes. */
        "TwinGeometry.Skin": {
            /** @description Nodes a, b, c of the frames, UINT32 [M, 3]; 4294967295 for all three: the world's axes. */
            frames?: components["schemas"]["Tensor"];
            /** @description The capture's observed point for each skin point, UINT32 [M]; 4294967295: none. */
            observed_points?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [M, 3], metres. Offsets of a frame whose nodes span no triangle count as 0. */
            offsets?: components["schemas"]["Tensor"];
            /** @description Positions with the nodes at rest, FLOAT32 [M, 3], metres. */
            rest_positions?: components["schemas"]["Tensor"];
            /** @description Number of weights of each point, UINT32 [M]; the weights of a point follow those of the point before. */
            weight_counts?: components["schemas"]["Tensor"];
            /** @description UINT32 [K]. */
            weight_nodes?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [K]; the weights of a point sum to 1. */
            weights?: components["schemas"]["Tensor"];
        };
        TwinSurface: {
            /** @description The V vertices, carried as skin points are. */
            carriers?: components["schemas"]["TwinGeometry.Skin"];
            /** @description Colours as in images (sRGB), UINT8 [V, 3]. Empty: unknown. */
            colors?: components["schemas"]["Tensor"];
            /**
             * Format: int64
             * @description Number of the twin's nodes.
             */
            node_count: number;
            /** @description Corners, counter-clockwise seen from outside, UINT32 [F, 3]. */
            triangles?: components["schemas"]["Tensor"];
            tube_nodes?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [tubes], metres. */
            tube_radii?: components["schemas"]["Tensor"];
            /** @description Nodes of the tubes, one tube after another: UINT32 [tubes + 1] offsets into UINT32 [..] nodes. The last node of a closed tube is its first. */
            tube_starts?: components["schemas"]["Tensor"];
        };
        UpdateCaptureRequest: {
            /** @description Tags to add and to remove, leaving the others; not allowed together with `tags` in the mask. */
            add_tags?: string[];
            display_name?: string;
            /** @description Note written by users, up to 10,000 bytes. */
            note?: string;
            /** @description Who recorded the capture, up to 200 characters; empty if not stated. */
            recorded_by?: string;
            remove_tags?: string[];
            /** @description Up to 32 tags of up to 50 characters, sorted. */
            tags?: string[];
        };
        UpdateFitRequest: {
            /** @description Tags to add and to remove, leaving the others; not allowed together with `tags` in the mask. */
            add_tags?: string[];
            /** @description The name given when the fit was created, by default that of its capture. The twin gets the same name. */
            display_name?: string;
            /** @description Note written by users, up to 10,000 bytes. */
            note?: string;
            remove_tags?: string[];
            /** @description Up to 32 tags of up to 50 characters, sorted. */
            tags?: string[];
        };
        UpdateProjectRequest: {
            /** @description Members to add and to remove, leaving the others; not allowed together with `members` in the mask. */
            add_members?: string[];
            /** @description 1 to 200 characters. */
            display_name?: string;
            /** @description Names of owners, sorted; up to 200. */
            members?: string[];
            remove_members?: string[];
        };
        UpdateTwinRequest: {
            /** @description Tags to add and to remove, leaving the others; not allowed together with `tags` in the mask. */
            add_tags?: string[];
            display_name?: string;
            /** @description Note written by users, up to 10,000 bytes. */
            note?: string;
            remove_tags?: string[];
            /** @description Up to 32 tags of up to 50 characters, sorted. */
            tags?: string[];
        };
        /** @description An upload that can be resumed. */
        Upload: {
            /** @description `captures/{uuid}` once it is stored. */
            capture?: string | null;
            /** @description RFC 3339. */
            create_time: string;
            display_name: string;
            /** @description Time at which it is abandoned unless more bytes arrive, or forgotten if it has ended. */
            expire_time: string;
            /**
             * Format: int64
             * @description Size of the whole; null while the client does not know it.
             */
            length_bytes?: number | null;
            /** @description `uploads/{uuid}` */
            name: string;
            /**
             * Format: int64
             * @description Bytes that are stored durably.
             */
            offset_bytes: number;
            /** @description RECEIVING, STORED or GONE. */
            state: string;
            /** @description Reason for which it is gone. */
            why?: string | null;
        };
        /** @description A page of uploads, newest first. */
        Uploads: {
            /** @description Empty on the last page. */
            next_page_token: string;
            uploads: components["schemas"]["Upload"][];
        };
        /** @description Parameters by instance, as factors of the twin's parameters: FLOAT32 [B], or [E] with an ensemble. Absent: 1. An instance whose factors need more substeps than the twin has gets them, up to 100,000 a frame, and counts as that much more work. */
        Vary: {
            /** @description Factors of the stiffness of bending and twist, 0..100. */
            bending?: components["schemas"]["Tensor"];
            /** @description Factors of dashpots, drag, and damping of bending and twist, 0..100. */
            damping?: components["schemas"]["Tensor"];
            /** @description With an ensemble: member e is simulated with fit e of the twin. Fit 0 is the twin itself, the others are its members; TwinGeometry.fits bounds their number. Not with FAST or PLANNER, nor with rest shapes that corrections have changed. Factors apply on top of each fit. */
            fits?: boolean;
            /** @description Factors of friction with ground, colliders and other nodes, 0..100; the resulting friction is at most 2. */
            friction?: components["schemas"]["Tensor"];
            /** @description Restitution of the ground and between nodes, 0..1, replacing that of the twin and of the world. These are values rather than factors, because captures hardly show restitution. */
            ground_restitution?: components["schemas"]["Tensor"];
            /** @description Factors of the mass of all nodes, 0.01..100. */
            mass?: components["schemas"]["Tensor"];
            object_restitution?: components["schemas"]["Tensor"];
            /** @description Factors of axial stiffness, 0.01..100. */
            stiffness?: components["schemas"]["Tensor"];
        };
        Worker: {
            /** @description cpu or cuda. */
            backend: string;
            build: string;
            device: string;
            /** @description True if the worker was asked to exit. */
            draining: boolean;
            /** @description fits/{uuid} of the running fit, if any. */
            fit: string | null;
            /** @description captures/{uuid} of the running ingest, if any. */
            ingest: string | null;
            /** @description Labels that the worker was started with and that fits can require. */
            labels: string[];
            /** Format: date-time */
            last_seen_time: string;
            /** Format: int64 */
            memory_total_bytes: number | null;
            /**
             * Format: int64
             * @description Device memory in use by all processes, and in total [bytes]; zero where unknown.
             */
            memory_used_bytes: number | null;
            /** @description workers/{uuid}; a restarted worker is a new one. */
            name: string;
            /** Format: int64 */
            rollouts_in_flight: number;
            /** @description servers/{uuid} of the server that started the worker; the worker then answers only that server's rollouts. Empty if it was started otherwise. */
            server: string | null;
            /** Format: date-time */
            start_time: string;
            /** @description Twins that are loaded, so that their rollouts start immediately. */
            warm_twins: string[];
        };
        /** @description Requirements on the worker of a fit or an ingest. The job waits until such a worker is free. */
        WorkerRequirements: {
            /**
             * @description `cpu` or `cuda`; empty means either.
             * @default
             */
            backend: string;
            /**
             * @description Labels that the worker must all have: up to 32 of up to 50 characters without spaces and commas.
             * @default []
             */
            labels: string[];
            /**
             * Format: int64
             * @description Least device memory [bytes]; on a CPU, least memory that a fit may take.
             * @default 0
             */
            memory_bytes: number;
        };
        /** @description The surroundings of an object in a rollout. Grippers are rigid bodies whose poses are the actions (GripperPoses); they are numbered from 0. */
        World: {
            /** @description At most 32. */
            colliders?: components["schemas"]["Collider"][];
            /** @description Gravity, three numbers, m/s^2; absent: that of the twin. */
            gravity?: number[];
            /** @description Replaces the twin's ground. Only one of ground, no_ground may be given. */
            ground?: components["schemas"]["Plane"];
            /**
             * Format: float
             * @description Coulomb friction of the ground, 0..2, and its restitution, 0..1; absent: those of the twin.
             */
            ground_friction?: number;
            /** Format: float */
            ground_restitution?: number;
            /** @description Removes the ground. Only one of ground, no_ground may be given. */
            no_ground?: boolean;
        };
    };
    responses: never;
    parameters: never;
    requestBodies: never;
    headers: never;
    pathItems: never;
}
export type $defs = Record<string, never>;
export interface operations {
    GetHealth: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "text/plain": string;
                };
            };
        };
    };
    GetMetrics: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "text/plain": string;
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetReadiness: {
        parameters: {
            query?: {
                /** @description Checks to leave out, with commas between them: running, writes, disk, workers. `workers` is left out where requests are to come before there is a worker */
                without?: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Readiness"];
                };
            };
            /** @description Not ready. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Readiness"];
                };
            };
        };
    };
    GetCaller: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Caller"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    ListCaptures: {
        parameters: {
            query?: {
                /** @description Default (0): 50. Values above 1000 count as 1000. */
                page_size?: number;
                /** @description `next_page_token` of the previous page; filters and order must be the same. */
                page_token?: string;
                /** @description Only captures whose display name or note contains this text, ignoring case; up to 200 characters. */
                search?: string;
                /** @description Only captures with this tag. */
                tag?: string;
                /** @description `create_time` or `name`; ascending, or descending if followed by ` desc`. Default: `create_time desc`. */
                order_by?: string;
                /** @description Only captures of this owner. */
                owner?: string;
                /** @description Only captures recorded by this person. */
                recorded_by?: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ListCapturesResponse"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    CreateCapture: {
        parameters: {
            query?: {
                display_name?: string;
                /** @description BLAKE3 of the archive, hex; the server checks it if given. */
                digest?: string;
                /** @description IngestSettings as JSON; empty means defaults. */
                ingest?: string;
                /** @description Worker that the ingest requires; absent: any. */
                ingest_requirements?: string;
                /** @description Who recorded the capture, up to 200 characters. */
                recorded_by?: string;
            };
            header?: {
                /** @description Makes the upload idempotent */
                "Idempotency-Key"?: string;
                /** @description BLAKE3 of the body, hex; checked */
                "X-Content-Blake3"?: string;
                /** @description blake3=:{base64}:; checked */
                "Content-Digest"?: string;
            };
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/zip": string;
            };
        };
        responses: {
            /** @description Created. */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Capture"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetCapture: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Capture"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    DeleteCapture: {
        parameters: {
            query?: {
                /** @description True: deleted for good, also from the trash, and nothing can restore it. */
                purge?: boolean;
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success, without content. */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    UpdateCapture: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["UpdateCaptureRequest"];
            };
        };
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Capture"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetCaptureContent: {
        parameters: {
            query?: never;
            header?: {
                /** @description One range of bytes */
                Range?: string;
                /** @description The ETag that the range is of */
                "If-Range"?: string;
            };
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/zip": string;
                };
            };
            /** @description The range that was asked for. */
            206: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/zip": string;
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    WatchIngest: {
        parameters: {
            query?: never;
            header?: {
                /** @description Skip revisions up to this one; an invalid id skips nothing. */
                "Last-Event-ID"?: string;
            };
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Server-sent events with messages as data. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "text/event-stream": components["schemas"]["Capture"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    IngestCapture: {
        parameters: {
            query?: never;
            header?: {
                /** @description Makes the call idempotent. */
                "Idempotency-Key"?: string;
            };
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["IngestCaptureRequest"];
            };
        };
        responses: {
            /** @description Accepted: it is under way. */
            202: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Capture"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    CancelIngest: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Capture"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    ExportMasks: {
        parameters: {
            query?: never;
            header?: {
                /** @description One range of bytes */
                Range?: string;
                /** @description The ETag that the range is of */
                "If-Range"?: string;
            };
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/zip": string;
                };
            };
            /** @description The range that was asked for. */
            206: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/zip": string;
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    ExportObservation: {
        parameters: {
            query?: never;
            header?: {
                /** @description One range of bytes */
                Range?: string;
                /** @description The ETag that the range is of */
                "If-Range"?: string;
            };
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/zip": string;
                };
            };
            /** @description The range that was asked for. */
            206: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/zip": string;
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetPlayback: {
        parameters: {
            query?: never;
            header?: {
                /** @description One range of bytes */
                Range?: string;
                /** @description The ETag that the range is of */
                "If-Range"?: string;
            };
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/octet-stream": string;
                };
            };
            /** @description The range that was asked for. */
            206: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/octet-stream": string;
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetCaptureReport: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": Record<string, never>;
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetCaptureReportPage: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "text/html": string;
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    ExportSupplement: {
        parameters: {
            query?: never;
            header?: {
                /** @description One range of bytes */
                Range?: string;
                /** @description The ETag that the range is of */
                "If-Range"?: string;
            };
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
                /** @description What the file is */
                kind: "masks" | "calibration";
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/octet-stream": string;
                };
            };
            /** @description The range that was asked for. */
            206: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/octet-stream": string;
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    AddSupplement: {
        parameters: {
            query?: {
                /** @description BLAKE3 of the body, hex; checked */
                digest?: string;
            };
            header?: {
                /** @description BLAKE3 of the body, hex; checked */
                "X-Content-Blake3"?: string;
                /** @description blake3=:{base64}:; checked */
                "Content-Digest"?: string;
            };
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
                /** @description What the file is */
                kind: "masks" | "calibration";
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": Record<string, never>;
                "application/zip": string;
            };
        };
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Capture"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    DeleteSupplement: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
                /** @description What the file is */
                kind: "masks" | "calibration";
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success, without content. */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetCaptureThumbnail: {
        parameters: {
            query?: {
                /** @description Width in pixels, 16 to 1024; default: 160. The height is three quarters of it */
                width?: number;
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "image/jpeg": string;
                    "image/png": string;
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    UndeleteCapture: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Capture"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    ListFits: {
        parameters: {
            query?: {
                /** @description Default (0): 50. Values above 1000 count as 1000. */
                page_size?: number;
                page_token?: string;
                /** @description Only fits of this capture, if given. */
                capture?: string;
                /** @description Only fits in this state, if given. */
                state?: "QUEUED" | "RUNNING" | "SUCCEEDED" | "FAILED" | "CANCELLED";
                /** @description Only fits whose display name or note contains this text, ignoring case; up to 200 characters. */
                search?: string;
                /** @description Only fits with this tag. */
                tag?: string;
                /** @description `create_time`, `name` or `error`; ascending, or descending if followed by ` desc`. Default: `create_time desc`. */
                order_by?: string;
                /** @description Only fits of this owner. */
                owner?: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ListFitsResponse"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    CreateFit: {
        parameters: {
            query?: never;
            header?: {
                /** @description Makes the call idempotent. */
                "Idempotency-Key"?: string;
            };
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["CreateFitRequest"];
            };
        };
        responses: {
            /** @description Accepted: it is under way. */
            202: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Fit"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetFit: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Fit"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    DeleteFit: {
        parameters: {
            query?: {
                /** @description True: deleted for good, also from the trash, and nothing can restore it. */
                purge?: boolean;
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success, without content. */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    UpdateFit: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["UpdateFitRequest"];
            };
        };
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Fit"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    CancelFit: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Fit"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    WatchFit: {
        parameters: {
            query?: never;
            header?: {
                /** @description Skip revisions up to this one; an invalid id skips nothing. */
                "Last-Event-ID"?: string;
            };
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Server-sent events with messages as data. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "text/event-stream": components["schemas"]["Fit"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetFitLosses: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["FitLosses"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetFitPreview: {
        parameters: {
            query?: {
                /** @description `lists` (nested lists of numbers, the default) or `base64`. */
                tensors?: string;
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["FitPreview"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    UndeleteFit: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Fit"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    ListKeys: {
        parameters: {
            query?: {
                /** @description Default (0): 50. Values above 1000 count as 1000. */
                page_size?: number;
                page_token?: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ListKeysResponse"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    CreateKey: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["CreateKeyRequest"];
            };
        };
        responses: {
            /** @description Created. */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["CreateKeyResponse"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetKey: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Key"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    DeleteKey: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success, without content. */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    Plan: {
        parameters: {
            query?: {
                /** @description `lists` (nested lists of numbers, the default) or `base64`. */
                tensors?: string;
                /** @description Give up after so many seconds. */
                timeout_s?: number;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["PlanRequest"];
                "application/x-protobuf": string;
            };
        };
        responses: {
            /** @description Server-sent events with messages as data; an event named `error` has a problem document and ends them. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "text/event-stream": components["schemas"]["PlanUpdate"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetPlayRecording: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["PlayRecording"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    PutPlayRecording: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["PlayRecording"];
            };
        };
        responses: {
            /** @description Success, without content. */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    WatchPlay: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The WebSocket. */
            101: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    ListProjects: {
        parameters: {
            query?: {
                /** @description Default (0): 50. Values above 1000 count as 1000. */
                page_size?: number;
                page_token?: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ListProjectsResponse"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    CreateProject: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["CreateProjectRequest"];
            };
        };
        responses: {
            /** @description Created. */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Project"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetProject: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Project"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    DeleteProject: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success, without content. */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    UpdateProject: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["UpdateProjectRequest"];
            };
        };
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Project"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    ListRetentionRules: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ListRetentionRulesResponse"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    CreateRetentionRule: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["CreateRetentionRuleRequest"];
            };
        };
        responses: {
            /** @description Created. */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["RetentionRule"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    PreviewRetention: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["PreviewRetentionResponse"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetRetentionRule: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["RetentionRule"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    DeleteRetentionRule: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success, without content. */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    OpenSession: {
        parameters: {
            query?: {
                /** @description `lists` (nested lists of numbers, the default) or `base64`. */
                tensors?: string;
                /** @description Give up after so many seconds. */
                timeout_s?: number;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["OpenSessionRequest"];
                "application/x-protobuf": string;
            };
        };
        responses: {
            /** @description Created. */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Session"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetSession: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Session"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    CloseSession: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success, without content. */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    AdvanceSession: {
        parameters: {
            query?: {
                /** @description `lists` (nested lists of numbers, the default) or `base64`. */
                tensors?: string;
                /** @description Give up after so many seconds. */
                timeout_s?: number;
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["AdvanceSessionRequest"];
                "application/x-protobuf": string;
            };
        };
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["RollOutResponse"];
                    "application/x-protobuf": string;
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    CorrectSession: {
        parameters: {
            query?: {
                /** @description `lists` (nested lists of numbers, the default) or `base64`. */
                tensors?: string;
                /** @description Give up after so many seconds. */
                timeout_s?: number;
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["CorrectSessionRequest"];
                "application/x-protobuf": string;
            };
        };
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["CorrectedSession"];
                    "application/x-protobuf": string;
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    ForkSession: {
        parameters: {
            query?: {
                /** @description `lists` (nested lists of numbers, the default) or `base64`. */
                tensors?: string;
                /** @description Give up after so many seconds. */
                timeout_s?: number;
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["ForkSessionRequest"];
            };
        };
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Session"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    RenderSession: {
        parameters: {
            query?: {
                /** @description `lists` (nested lists of numbers, the default) or `base64`. */
                tensors?: string;
                /** @description Give up after so many seconds. */
                timeout_s?: number;
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["RenderSessionRequest"];
                "application/x-protobuf": string;
            };
        };
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["RenderedSession"];
                    "application/x-protobuf": string;
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    ResetSession: {
        parameters: {
            query?: {
                /** @description `lists` (nested lists of numbers, the default) or `base64`. */
                tensors?: string;
                /** @description Give up after so many seconds. */
                timeout_s?: number;
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["ResetSessionRequest"];
                "application/x-protobuf": string;
            };
        };
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Session"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetSessionStates: {
        parameters: {
            query?: {
                /** @description Empty: all slots. */
                slots?: string;
                /** @description `lists` (nested lists of numbers, the default) or `base64`. */
                tensors?: string;
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["SessionStates"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    StepSession: {
        parameters: {
            query?: {
                /** @description `lists` (nested lists of numbers, the default) or `base64`. */
                tensors?: string;
                /** @description Give up after so many seconds. */
                timeout_s?: number;
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["StepSessionRequest"];
                "application/x-protobuf": string;
            };
        };
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["SteppedSession"];
                    "application/x-protobuf": string;
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    DeleteShare: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success, without content. */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetSignInOptions: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["SignInOptions"];
                };
            };
        };
    };
    CreateSignIn: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["CreateSignInRequest"];
            };
        };
        responses: {
            /** @description Created. */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["CreateSignInResponse"];
                };
            };
        };
    };
    DeleteSignIn: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success, without content. */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    StartDeviceSignIn: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["StartDeviceSignInResponse"];
                };
            };
        };
    };
    StartSignIn: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["StartSignInRequest"];
            };
        };
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["StartSignInResponse"];
                };
            };
        };
    };
    ListTrashedCaptures: {
        parameters: {
            query?: {
                /** @description Default (0): 50. Values above 1000 count as 1000. */
                page_size?: number;
                /** @description `next_page_token` of the previous page; the filter must be the same. */
                page_token?: string;
                /** @description Only those of this owner. */
                owner?: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ListTrashedCapturesResponse"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    ListTrashedFits: {
        parameters: {
            query?: {
                /** @description Default (0): 50. Values above 1000 count as 1000. */
                page_size?: number;
                /** @description `next_page_token` of the previous page; the filter must be the same. */
                page_token?: string;
                /** @description Only those of this owner. */
                owner?: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ListTrashedFitsResponse"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    ListTrashedTwins: {
        parameters: {
            query?: {
                /** @description Default (0): 50. Values above 1000 count as 1000. */
                page_size?: number;
                /** @description `next_page_token` of the previous page; the filter must be the same. */
                page_token?: string;
                /** @description Only those of this owner. */
                owner?: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ListTrashedTwinsResponse"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    ListTwins: {
        parameters: {
            query?: {
                /** @description Default (0): 50. Values above 1000 count as 1000. */
                page_size?: number;
                page_token?: string;
                /** @description Only twins of this capture, if given. */
                capture?: string;
                /** @description Only twins whose display name or note contains this text, ignoring case; up to 200 characters. */
                search?: string;
                /** @description Only twins with this tag. */
                tag?: string;
                /** @description `create_time`, `name` or `error`; ascending, or descending if followed by ` desc`. Default: `create_time desc`. */
                order_by?: string;
                /** @description Only twins of this owner. */
                owner?: string;
                /** @description Only twins with this level of trust: `good`, `fair`, `poor` or `unknown` in the assessment of the quality table. */
                level?: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ListTwinsResponse"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    CreateTwin: {
        parameters: {
            query?: {
                display_name?: string;
                digest?: string;
            };
            header?: {
                /** @description Makes the import idempotent */
                "Idempotency-Key"?: string;
                /** @description BLAKE3 of the body, hex; checked */
                "X-Content-Blake3"?: string;
            };
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/octet-stream": string;
            };
        };
        responses: {
            /** @description Created. */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Twin"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetTwin: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Twin"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    DeleteTwin: {
        parameters: {
            query?: {
                /** @description True: deleted for good, also from the trash, and nothing can restore it. */
                purge?: boolean;
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success, without content. */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    UpdateTwin: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["UpdateTwinRequest"];
            };
        };
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Twin"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    ExportTwin: {
        parameters: {
            query?: never;
            header?: {
                /** @description One range of bytes */
                Range?: string;
                /** @description The ETag that the range is of */
                "If-Range"?: string;
            };
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/octet-stream": string;
                };
            };
            /** @description The range that was asked for. */
            206: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/octet-stream": string;
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    EvaluateTwin: {
        parameters: {
            query?: {
                /** @description `lists` (nested lists of numbers, the default) or `base64`. */
                tensors?: string;
                /** @description Give up after so many seconds. */
                timeout_s?: number;
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["EvaluateTwinRequest"];
            };
        };
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Evaluation"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    ExportTwinAs: {
        parameters: {
            query?: {
                /** @description The format; default: glb */
                format?: "twin" | "splats" | "ply" | "ply-sequence" | "obj" | "glb" | "npz" | "usda" | "usdz" | "mujoco" | "mcap" | "html";
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/octet-stream": string;
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetTwinGeometry: {
        parameters: {
            query?: {
                /** @description `lists` (nested lists of numbers, the default) or `base64`. */
                tensors?: string;
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["TwinGeometry"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    Play: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The WebSocket. */
            101: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    RegisterState: {
        parameters: {
            query?: {
                /** @description `lists` (nested lists of numbers, the default) or `base64`. */
                tensors?: string;
                /** @description Give up after so many seconds. */
                timeout_s?: number;
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["RegisterStateRequest"];
                "application/x-protobuf": string;
            };
        };
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["RegisteredState"];
                    "application/x-protobuf": string;
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    RollOut: {
        parameters: {
            query?: {
                /** @description `lists` (nested lists of numbers, the default) or `base64`. */
                tensors?: string;
                /** @description Give up after so many seconds. */
                timeout_s?: number;
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["RollOutRequest"];
                "application/x-protobuf": string;
            };
        };
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["RollOutResponse"];
                    "application/x-protobuf": string;
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    StreamRollOut: {
        parameters: {
            query?: {
                /** @description `lists` (nested lists of numbers, the default) or `base64`. */
                tensors?: string;
                /** @description Give up after so many seconds. */
                timeout_s?: number;
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["RollOutRequest"];
                "application/x-protobuf": string;
            };
        };
        responses: {
            /** @description Server-sent events with messages as data; an event named `error` has a problem document and ends them. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "text/event-stream": components["schemas"]["RollOutResponse"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    ListShares: {
        parameters: {
            query?: {
                /** @description Default (0): 50. Values above 1000 count as 1000. */
                page_size?: number;
                page_token?: string;
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ListSharesResponse"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    ShareTwin: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["ShareTwinRequest"];
            };
        };
        responses: {
            /** @description Created. */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ShareTwinResponse"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetTwinSurface: {
        parameters: {
            query?: {
                /** @description `lists` (nested lists of numbers, the default) or `base64`. */
                tensors?: string;
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["TwinSurface"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetTwinThumbnail: {
        parameters: {
            query?: {
                /** @description Width in pixels, 16 to 1024; default: 160. The height is three quarters of it */
                width?: number;
            };
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "image/png": string;
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    UndeleteTwin: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Twin"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    ListUploads: {
        parameters: {
            query?: {
                /** @description At most 1000; 0 means 50. */
                page_size?: number;
                /** @description `next_page_token` of the previous page. */
                page_token?: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Uploads"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    CreateUpload: {
        parameters: {
            query?: never;
            header: {
                /** @description 1.0.0 */
                "Tus-Resumable": string;
                /** @description Size of the whole [bytes] */
                "Upload-Length"?: number;
                /** @description 1 if the size is not known yet */
                "Upload-Defer-Length"?: number;
                /** @description Pairs `key base64`, separated by commas */
                "Upload-Metadata"?: string;
                /** @description Makes the upload idempotent */
                "Idempotency-Key"?: string;
                /** @description `algorithm base64` of the body */
                "Upload-Checksum"?: string;
            };
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/offset+octet-stream": string;
            };
        };
        responses: {
            /** @description Created. */
            201: {
                headers: {
                    Location?: string;
                    "Upload-Expires"?: string;
                    "Upload-Offset"?: number;
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetUploadOptions: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success, without content. */
            204: {
                headers: {
                    "Tus-Checksum-Algorithm"?: string;
                    "Tus-Extension"?: string;
                    "Tus-Max-Size"?: number;
                    "Tus-Version"?: string;
                    [name: string]: unknown;
                };
                content?: never;
            };
        };
    };
    GetUpload: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Upload"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    TerminateUpload: {
        parameters: {
            query?: never;
            header?: {
                /** @description 1.0.0 */
                "Tus-Resumable"?: string;
            };
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success, without content. */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetUploadOffset: {
        parameters: {
            query?: never;
            header: {
                /** @description 1.0.0 */
                "Tus-Resumable": string;
            };
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    "Bendtwin-Capture"?: string;
                    "Upload-Defer-Length"?: number;
                    "Upload-Expires"?: string;
                    "Upload-Length"?: number;
                    "Upload-Metadata"?: string;
                    "Upload-Offset"?: number;
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    AppendUpload: {
        parameters: {
            query?: never;
            header: {
                /** @description 1.0.0 */
                "Tus-Resumable": string;
                /** @description Where the body begins; must be the upload's offset */
                "Upload-Offset": number;
                /** @description Size of the whole, if it was deferred [bytes] */
                "Upload-Length"?: number;
                /** @description `algorithm base64` of the body: sha1, sha256 or blake3 */
                "Upload-Checksum"?: string;
            };
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/offset+octet-stream": string;
            };
        };
        responses: {
            /** @description Success, without content. */
            204: {
                headers: {
                    "Bendtwin-Capture"?: string;
                    "Content-Location"?: string;
                    "Upload-Expires"?: string;
                    "Upload-Offset"?: number;
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetUsage: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["OwnerUsage"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    ListOwnerUsage: {
        parameters: {
            query?: {
                /** @description Default (0): 50. Values above 1000 count as 1000. */
                page_size?: number;
                page_token?: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ListOwnerUsageResponse"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    ListWorkers: {
        parameters: {
            query?: {
                page_size?: number;
                page_token?: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ListWorkersResponse"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    GetWorker: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Worker"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
    DrainWorker: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The uuid of the resource's name. */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Success. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Worker"];
                };
            };
            /** @description An RFC 9457 problem document: what happened and what to do. */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["ProblemDocument"];
                };
            };
        };
    };
}
