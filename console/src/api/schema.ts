// Written by `npm run generate` from /openapi.json.

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
        /** Metrics for Prometheus */
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
         * @description Deletes its observation, playback and report, too. Refused with FAILED_PRECONDITION while a fit of it is queued or running. Twins stay.
         */
        delete: operations["DeleteCapture"];
        options?: never;
        head?: never;
        /**
         * Update capture
         * @description Changes display name, note and tags.
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
         * @description The capture now and after every change of its ingest, until that has ended. Over HTTP events named `capture`, with the revision of the ingest as id; `Last-Event-ID` skips what is known.
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
         * @description Runs the ingest again, for example with other settings. Refused with FAILED_PRECONDITION while it is under way, and while a fit of the capture is queued or running.
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
         * @description Asks the ingest to stop; one that has ended is returned as it is.
         */
        post: operations["CancelIngest"];
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
         * @description What a player shows, for reading by ranges: tracked points as 16-bit numbers and small images of the cameras (docs/playback.md). A capture that was read before there were playbacks has none until its ingest is run again.
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
         * @description Refused with FAILED_PRECONDITION while it runs: cancel it first. Its twin stays.
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
         * @description Asks a queued or running fit to stop; a fit that has ended is returned as it is.
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
    "/v1/keys": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * List keys
         * @description Newest first; revoked and expired keys are among them.
         */
        get: operations["ListKeys"];
        put?: never;
        /**
         * Create key
         * @description Makes a key. Its text is in the reply and nowhere else: the server stores a hash of it.
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
         * @description Revokes a key: no server accepts it 30 s later. It stays in the list, with its `revoke_time`.
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
         * @description One update after each iteration with the best so far, and a last one. The best is never worse than the nominal plan: whatever comes back was simulated, with that cost. A plan that strains the material beyond the limit counts as worse than every plan that does not, whatever its cost; of plans beyond it the one that is beyond it least is best. Over HTTP events named `update`; closing the connection stops the work.
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
         * @description Simulates the rollout from the states of slots, and leaves them in those that it ends in. Nothing changes if it fails or an instance diverges.
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
         * @description Brings the states of slots closer to what is seen, in place: smoothly, without touching what control points and grasps hold, and outside of the ground and of colliders, on the side of them where nodes were. Their rest shapes take part (CorrectOptions.carry), and belong to the slots from then on, in all that is simulated from them. Ends with FAILED_PRECONDITION if more than the stated residual is left at one of them, reason OBSERVATION_NOT_EXPLAINED, or OBJECT_LOST for a slot that is lost (Tracking); no state changes then.
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
         * @description Copies the state of a slot to others, and its rest shape.
         */
        post: operations["ForkSession"];
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
         * @description Sets slots back to the session's first state, or to a given one, and to the rest shape of the twin.
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
         * @description A step of a closed loop: corrects a slot by what is seen, plans from there, and advances the slot by the first frames of the best plan. All of the request is checked before anything changes. Later failures (EVERY_PLAN_DIVERGED, a lost worker, the deadline of the call) may leave the slot corrected, but not advanced.
         */
        post: operations["StepSession"];
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
        /** Delete twin */
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
         * @description The quality table of a twin on a capture. To a recording other than its own the twin is registered first: ends with FAILED_PRECONDITION, reason OBSERVATION_NOT_EXPLAINED, if that leaves too much. The capture's ingest has to have ended. The table is computed anew and kept nowhere. `motion` also asks for the predicted positions of nodes in a sequence, and for its errors frame by frame.
         */
        post: operations["EvaluateTwin"];
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
         * @description A WebSocket on which a simulation of the twin runs in real time. The first message says where it begins, `{"type": "begin"}` at least; docs/play.md has all messages. The play ends with the socket.
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
         * @description The state in which the twin explains an observation: a rigid motion, then a deformation, then frames of the twin's own physics under the pull of the points. Ends with FAILED_PRECONDITION, reason OBSERVATION_NOT_EXPLAINED, if more than the stated residual is left.
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
         * @description The same in parts, as instances finish: each part covers `first_instance` onwards. On a GPU the last bits of a result may differ from those of RollOut, as they depend on how many instances are simulated together; on the CPU they do not. With `returns.best` there is one part. With `returns.part_frames` every part is divided in time as well. Over HTTP events named `part`.
         */
        post: operations["StreamRollOut"];
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
        /** @description Coordinates of a plan, and the points or grippers that they move. Motion of the nominal plan that no coordinate has stays in every plan. */
        ActionSpace: {
            /** @enum {string} */
            coordinates?: "TOGETHER" | "PER_GROUP" | "POINTS" | "TRANSLATION" | "RIGID";
            /** @description With PER_GROUP. UINT32 [C]: the group of each control point, of a hand say. */
            group_of_control?: components["schemas"]["Tensor"];
            /** @description The place that coordinates, and their bounds, are counted from: FLOAT32 [C, 3] of trajectories, [G, 7] of poses; absent: row 0 of the nominal plan. */
            start?: components["schemas"]["Tensor"];
        };
        AdvanceSessionRequest: {
            name?: string;
            /** @description Its twin, initial state and fidelity are those of the session and must be left out. */
            rollout?: components["schemas"]["RollOutRequest"];
            /** @description One for each instance of the rollout; empty: slot 0 alone. */
            slots?: number[];
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
            /** @description The job that reads it. There is one for each; running it again replaces it. Fits of the capture fail with its fault. */
            ingest: components["schemas"]["Job"];
            /** @description Worker that its ingest asks for; absent: any. */
            ingest_requirements: components["schemas"]["WorkerRequirements"];
            /** @description captures/{uuid} */
            name: string;
            /** @description Text that people write about it: up to 10,000 bytes. */
            note: string;
            /** @description Owner of the key with which it was uploaded; empty if that is not known. */
            owner: string;
            /** Format: int64 */
            size_bytes: number;
            /** @description Up to 32 words of up to 50 characters, sorted. */
            tags: string[];
            /** @description The report's verdict in a word; empty until there is a report. */
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
        /** @description A rigid obstacle. It acts on nodes; control points and grippers pass through it, which a reply's diagnostics report. */
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
             * @description Distance that nodes keep from the shape, metres: about the radius of a cable, or half of the distance between nodes.
             */
            margin_m?: number;
            /** @description Reported under this name; default `collider{index}`. At most 128 bytes. */
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
            /** @description FLOAT32 [B, K, C, 3], metres. K = F + 1 is dense: row 0 belongs to the initial state. Any other K >= 2 is spread evenly over the horizon and interpolated. */
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
             * @description Share of the correction that the rest shape of the slot takes over, so that the slot does not go back to where it was: 0..1, times the share of the distances before that noise_m does not explain; default 1. With 0 the state alone is corrected. The rest shape follows what is seen if corrections are repeated, several times a second.
             */
            carry?: number;
            /**
             * Format: double
             * @description Deviation of a spring by its length in one correction; default 0.03: how far the shape is doubted.
             */
            give?: number;
            /** @description FLOAT32 [G, 7]: poses of the first G grippers now, where they are not known from the slot's last advance, or are others: x, y, z in metres, quaternion x, y, z, w. */
            grippers?: components["schemas"]["Tensor"];
            /**
             * Format: double
             * @description Median distance of the points beyond which the correction is refused, metres; default: half the distance of neighbouring nodes, or 0.005 if that is more.
             */
            max_residual_m?: number;
            /**
             * Format: double
             * @description Largest increase of the strain of a spring; default 0.5.
             */
            most_added_strain?: number;
            /**
             * Format: double
             * @description Deviation of a point from its place, metres; default 0.005: noise, and what a coarse twin cannot follow.
             */
            noise_m?: number;
            /** @description Replies have no states. */
            omit_state?: boolean;
            /** @description A slot that is lost, with this observation counted, is registered by it: from where it is, and if that does not explain it, from the rest shape anywhere, with what control points and grasps hold in place, and outside of the surroundings. */
            register_if_lost?: boolean;
            /**
             * Format: double
             * @description Share of the displacement that is added to the velocity, per second, where velocities are not observed; default 0.
             */
            velocity_gain_per_s?: number;
            /**
             * Format: double
             * @description Deviation of an observed velocity, metres per second; default 0.2.
             */
            velocity_noise_m_s?: number;
            /** @description Surroundings now. Absent: those of the slot's last advance where that ended, bodies included, or before one those of the session, with paths at their first pose and without what grippers carry. A path given here is at its first pose. */
            world?: components["schemas"]["World"];
        };
        CorrectSessionRequest: {
            name?: string;
            observation?: components["schemas"]["Observation"];
            options?: components["schemas"]["CorrectOptions"];
            /** @description All by the same observation; empty: slot 0 alone. */
            slots?: number[];
        };
        CorrectedSession: {
            /** @description One for each slot, in the order of the request. */
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
            /** @description True if the slot was lost and has been registered by this observation: it is at rest, with the rest shape of the twin, and `after` and `moved_mm` are those of the registration. */
            registered: boolean;
            /** Format: int64 */
            slot: number;
            /** @description The corrected state, of this slot alone, unless CorrectOptions.omit_state is set. InitialState.given takes it as it is; the rest shape stays in the session. */
            state?: components["schemas"]["InitialState.GivenState"];
            /** @description With this observation. */
            tracking?: components["schemas"]["Tracking"];
        };
        Cost: {
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed may be given. */
            clearance?: components["schemas"]["Cost.Clearance"];
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed may be given. */
            control_path?: components["schemas"]["Cost.ControlPath"];
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed may be given. */
            control_speed?: components["schemas"]["Cost.ControlSpeed"];
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed may be given. */
            force?: components["schemas"]["Cost.Force"];
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed may be given. */
            height?: components["schemas"]["Cost.Height"];
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed may be given. */
            keypoints?: components["schemas"]["Cost.Keypoints"];
            /** @description Reported under this name; default `cost{index}`. Names differ; at most 128 bytes each. */
            name?: string;
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed may be given. */
            smoothness?: components["schemas"]["Cost.Smoothness"];
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed may be given. */
            strain?: components["schemas"]["Cost.Strain"];
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed may be given. */
            target_cloud?: components["schemas"]["Cost.TargetCloud"];
            /**
             * Format: double
             * @description Of SOFT_MIN: the cost difference at which frames count for clearly less, in the cost's own unit; above 0.
             */
            temperature?: number;
            /**
             * Format: double
             * @description 1 if it is not given; 0 switches the cost off: it is reported as 0.
             */
            weight?: number;
            /**
             * @description When it is counted, default: after the last frame.
             * @enum {string}
             */
            when?: "LAST_FRAME" | "EVERY_FRAME" | "SOFT_MIN";
            /** @description Only one of target_cloud, keypoints, smoothness, strain, force, height, within, clearance, control_path, control_speed may be given. */
            within?: components["schemas"]["Cost.Within"];
        };
        /** @description Mean over nodes of max(0, margin - distance)^2 to a collider of the request, square metres. */
        "Cost.Clearance": {
            /** Format: int64 */
            collider?: number;
            /** Format: float */
            margin_m?: number;
        };
        /** @description Length of the way of the control points, mean over them, metres: counted whatever `when` says. */
        "Cost.ControlPath": Record<string, never>;
        /** @description Mean over control points and frames of max(0, speed - limit)^2, square metres per square second: counted whatever `when` says. */
        "Cost.ControlSpeed": {
            /** Format: double */
            limit_m_s?: number;
        };
        /** @description max(0, |f| - limit)^2 of the mean force over a frame, square newtons (per unit mass without a mass_kg). */
        "Cost.Force": {
            /**
             * Format: int64
             * @description Number of a collider of the request. Only one of controls, control, grasp, ground, collider may be given.
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
             * @description Number of a grasp of the request. Only one of controls, control, grasp, ground, collider may be given.
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
            /** @description Squared distances instead. */
            squared?: boolean;
            /** @description FLOAT32 [M, 3], [F, M, 3], [B, 1, M, 3] or [B, F, M, 3], metres, as those of a target cloud. */
            targets?: components["schemas"]["Tensor"];
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
             * @description The surface: SKIN, the default, or NODES for its surface nodes.
             * @enum {string}
             */
            point_set?: "NODES" | "SKIN";
            /** @description FLOAT32 [M, 3], metres, or [F, M, 3] by frame (with EVERY_FRAME or SOFT_MIN), or [B, 1, M, 3] or [B, F, M, 3] by instance too. */
            points?: components["schemas"]["Tensor"];
        };
        /** @description Mean over nodes of the squared distance to a box, square metres. */
        "Cost.Within": {
            cuboid?: components["schemas"]["Cuboid"];
            /** @description UINT32 [M]; absent: all. */
            nodes?: components["schemas"]["Tensor"];
        };
        CreateFitRequest: {
            capture: string;
            /** @description Empty means the capture's. */
            display_name?: string;
            /**
             * Format: int32
             * @description Higher runs earlier; 0 is normal, -100..100.
             */
            priority?: number;
            /** @description Worker that it asks for; absent means any. */
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
             * @description Absent: it does not expire.
             */
            expire_time?: string;
            /** @description Up to 200 characters; empty means the display name. */
            owner?: string;
            quotas?: components["schemas"]["KeyQuotas"];
            /** @description At least one. */
            scopes: string[];
        };
        CreateKeyResponse: {
            key: components["schemas"]["Key"];
            /** @description The key itself, `bt_{id}_{secret}`: what clients show. */
            secret_key: string;
        };
        /** @description A box along the axes. */
        Cuboid: {
            high?: number[];
            /** @description Least and greatest corner, three numbers each. */
            low?: number[];
        };
        /** @description Every action is simulated under E sets of parameters, given by `vary`, and its cost is a statistic of their costs. Instances are then B x E, those of one action together: member e of action b is instance b E + e in `instances`, positions, final states, forces, diagnostics, `diverged` and `implausible`. Costs, gradients, `first_instance` and `returns.best` count actions. A member that diverges has the cost +inf, and so has the mean. MEAN_PREDICTION is no statistic of costs: there the members move the object together. */
        Ensemble: {
            /** Format: int64 */
            members?: number;
            /**
             * Format: double
             * @description Of CVAR: the share of the worst that is averaged, above 0 and at most 1; rounded up to whole members.
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
            /** @description The motion that was asked for; missing if the twin could not be registered to its recording, which a warning of the table explains. */
            motion?: components["schemas"]["PredictedMotion"];
            /** @description The quality table as JSON (docs/twin-format.md, `quality`), with its assessment and, of a capture that the twin was not fitted to, how well it was registered. All frames of such a capture count as future. */
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
             * @description Of the points that are within reach of the twin, 0..1.
             */
            points: number;
            /**
             * Format: double
             * @description Of the surface that could have been seen and has a point within reach, 0..1. Tracks say nothing of the rest of the surface: there it is small.
             */
            surface: number;
            /**
             * Format: double
             * @description The reach.
             */
            within_mm: number;
        };
        /** @description Reason why something failed: the same triple that a failed call would carry. */
        Fault: {
            /** @description INVALID_ARGUMENT, NOT_FOUND, ...: the names of the gRPC codes. */
            category: string;
            /** @description Text for a person: what happened and what to do about it. */
            message: string;
            /** @description Stable UPPER_SNAKE_CASE word for programs. */
            reason: string;
        };
        Fit: {
            capture: string;
            /** @description The capture's when the fit was created, unless one was given; its twin's, too, when it is made. */
            display_name: string;
            /**
             * Format: double
             * @description Error of its twin, metres, as in `Twin`.
             */
            error_m: number | null;
            job: components["schemas"]["Job"];
            /** @description fits/{uuid} */
            name: string;
            /** @description Text that people write about it: up to 10,000 bytes. */
            note: string;
            /** @description Owner of the key with which it was asked for, and of its twin; empty if that is not known. */
            owner: string;
            /** Format: int32 */
            priority: number;
            /** @description Worker that it asks for; absent if any will do. */
            requirements: components["schemas"]["WorkerRequirements"];
            /** @description Up to 32 words of up to 50 characters, sorted. */
            tags: string[];
            /** @description twins/{uuid} once it has succeeded. */
            twin: string | null;
        };
        FitLosses: {
            /** @description In the order in which they were computed: stages one after another, models side by side. */
            curves: components["schemas"]["FitLosses.LossCurve"][];
        };
        /** @description Losses of one model over the iterations of a stage. Of a long stage every second iteration is kept, every fourth and so on, and the last. */
        "FitLosses.LossCurve": {
            /** @description The lowest up to each iteration. */
            best_losses: (number | null)[];
            /** @description Ascending, from 1. */
            iterations: number[];
            /** @description One for each iteration; NaN where it was not finite. */
            losses: (number | null)[];
            /** @description search or refine. */
            stage: string;
            /** @description bending or axial, of several starts followed by which: `bending 2/3`. */
            variant: string;
        };
        ForkSessionRequest: {
            /** Format: int64 */
            from?: number;
            name?: string;
            /** @description Empty: all others. */
            to?: number[];
        };
        GradientOptions: {
            /**
             * Format: int64
             * @description Frames through which a gradient reaches back at most: it is cut at every such number of frames; 0 for all of them. Gradients through many contacts grow until they say nothing; 15 is a good start where the object lies on something.
             */
            reach_frames?: number;
            /**
             * Format: double
             * @description Width of the layer in which ground and colliders act as smooth forces, metres, in the simulation that gradients are of and in the costs and arrays that come with them; 0 for impacts. 0.001 is a good start where the object lies on something. Nothing changes in requests without gradients.
             */
            smoothing_m?: number;
        };
        /** @description A hold of a gripper on the object. The twin's own control points hold as they were fitted, unless a grasp of their `hand` is open: to take hold elsewhere, release them by one that is never closed, whose `closed` is [0]. */
        Grasp: {
            /** @enum {string} */
            attachment?: "PIN" | "SPRINGS";
            /** @description UINT32 [K] for all instances or [B, K]: whether it is closed from each knot of the actions on, 1 or 0; [1]: from first to last, whatever the number of knots; absent: always closed. */
            closed?: components["schemas"]["Tensor"];
            /** @description Only one of sphere, cuboid, nodes, hand may be given. */
            cuboid?: components["schemas"]["Cuboid"];
            /**
             * Format: float
             * @description Newton seconds per metre; 0 chooses critical damping.
             */
            damping?: number;
            /**
             * Format: int64
             * @description The gripper, by its number in the actions' poses.
             */
            gripper?: number;
            /** @description The twin's own control points of a hand of its capture (TwinGeometry.hands), held as they were fitted. Once it has opened it stays open. Only one of sphere, cuboid, nodes, hand may be given. */
            hand?: components["schemas"]["Grasp.CaptureHand"];
            /**
             * Format: double
             * @description Mean force over a frame beyond which it lets go, newtons; absent: never.
             */
            max_force_n?: number;
            /** @description UINT32 [M]. Only one of sphere, cuboid, nodes, hand may be given. */
            nodes?: components["schemas"]["Tensor"];
            /** @description In the coordinates of the gripper. Only one of sphere, cuboid, nodes, hand may be given. */
            sphere?: components["schemas"]["Sphere"];
            /**
             * Format: float
             * @description Of SPRINGS: newtons per metre and node (per unit mass without a mass_kg); 0 chooses what the twin's substeps allow.
             */
            stiffness?: number;
        };
        "Grasp.CaptureHand": {
            /** Format: int64 */
            hand?: number;
        };
        /** @description Holds of grasps in a state: of G grasps and N nodes. All for one state, or with [B] in front. */
        Grasping: {
            /** @description UINT32 [N]: g + 1 for a node that grasp g holds; 0 for none. */
            holders?: components["schemas"]["Tensor"];
            /** @description UINT32 [G]: 0 open, 1 closed, 2 slipped. */
            phases?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [N, 3]: where a held node is in the coordinates of its gripper, metres. */
            places?: components["schemas"]["Tensor"];
        };
        /** @description Poses of rigid grippers that carry the control points attached to them. */
        GripperPoses: {
            /** @description UINT32 [C]: the gripper of each control point; empty means gripper 0 for all. */
            gripper_of_control?: components["schemas"]["Tensor"];
            /** @enum {string} */
            interpolation?: "LINEAR" | "CUBIC" | "ZERO";
            /** @description FLOAT32 [B, K, G, 7]: x, y, z in metres, quaternion x, y, z, w. K as in ControlTrajectories. Control points move as if glued to the gripper in its pose of row 0. */
            poses?: components["schemas"]["Tensor"];
        };
        IngestCaptureRequest: {
            /** @description Worker that it asks for; absent: any. */
            requirements?: components["schemas"]["WorkerRequirements"];
            /** @description IngestSettings as JSON; empty means defaults. */
            settings?: {
                [key: string]: unknown;
            };
        };
        InitialState: {
            /** @description The twin's state after following the capture's own controls up to a frame. Only one of rest, capture_frame, given, settled, session may be given. */
            capture_frame?: components["schemas"]["InitialState.CaptureFrame"];
            /** @description A state that a rollout returned, or another one that the caller made. Only one of rest, capture_frame, given, settled, session may be given. */
            given?: components["schemas"]["InitialState.GivenState"];
            /** @description The twin's rest shape, not moving. The default. Only one of rest, capture_frame, given, settled, session may be given. */
            rest?: components["schemas"]["InitialState.Rest"];
            /** @description The states of slots of a session. Only one of rest, capture_frame, given, settled, session may be given. */
            session?: components["schemas"]["InitialState.SessionSlots"];
            /** @description The twin's shape where it comes to rest, held by its control points at rest, in the request's world as it is at the start: gravity, ground, colliders that stand still or begin a path. Grippers come later: what they carry is not there yet, and grasps hold nothing. Only one of rest, capture_frame, given, settled, session may be given. */
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
            /** @description The shape of `controls`, metres: where grippers would have the control points if the ground did not hold them back, from where `poses` carry them on. Absent: where the control points are. */
            commanded_controls?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [C, 3] or [B, C, 3], metres: where the control points are. Absent: where pins say, others at rest; then `poses` carry control points that pin no node from there, so give it. */
            controls?: components["schemas"]["Tensor"];
            grasping?: components["schemas"]["Grasping"];
            /** @description FLOAT32 [N, 3] for all instances or [B, N, 3], metres. */
            positions?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [rods] for all instances or [B, rods], as the positions; radians since the twin's rods counted as untwisted. Empty means that none is twisted, and is what a twin without rods needs. */
            twists?: components["schemas"]["Tensor"];
            /** @description The same shape, metres per second; empty means at rest. */
            velocities?: components["schemas"]["Tensor"];
        };
        "InitialState.Rest": Record<string, never>;
        "InitialState.SessionSlots": {
            /** @description sessions/{uuid}; the request's twin may be left out then. */
            session?: string;
            /** @description One for all instances, or one for each; empty: slot 0 for all. */
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
             * @description Number that grows with every change, and on from one run of an ingest to the next; the event id of server-sent events.
             */
            revision: number;
            /** @description The settings in force, as JSON (docs/settings.md). */
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
             * @description From then on it is refused; absent: never.
             */
            expire_time: string | null;
            /**
             * Format: date-time
             * @description To about a minute; absent if it has not been used.
             */
            last_use_time: string | null;
            /** @description keys/{uuid} */
            name: string;
            /** @description Recorded as `owner` of the captures, fits and twins that are made with the key. */
            owner: string;
            quotas: components["schemas"]["KeyQuotas"];
            /**
             * Format: date-time
             * @description Absent unless it has been revoked.
             */
            revoke_time: string | null;
            /** @description Sorted: admin, captures:read, captures:write, fits:read, fits:write, rollouts:run, twins:read, twins:write. */
            scopes: string[];
        };
        /** @description Bounds on what the owner of a key may have when the key asks for more; none where a field is absent. */
        KeyQuotas: {
            /**
             * Format: int64
             * @description Fits and ingests that wait for a worker.
             * @default null
             */
            queued_jobs: number | null;
            /**
             * Format: int64
             * @description Rollouts, plans, registrations and evaluations under way at one server.
             * @default null
             */
            rollouts: number | null;
            /**
             * Format: int64
             * @description Size of captures, twin files and resumable uploads under way [bytes].
             * @default null
             */
            stored_bytes: number | null;
        };
        /** @description When the knots of the actions are, if they are not spread evenly over the horizon. */
        KnotTimes: {
            /** @description FLOAT32 [K], seconds from the start, rising; the first is 0, the last holds until the end. Only one of at_s, period_s may be given. */
            at_s?: components["schemas"]["Tensor"];
            /**
             * Format: double
             * @description Seconds from knot to knot: the period of a controller, whatever the twin's frame rate. Only one of at_s, period_s may be given.
             */
            period_s?: number;
        };
        ListCapturesResponse: {
            captures: components["schemas"]["Capture"][];
            /** @description Empty on the last page. */
            next_page_token: string;
        };
        ListFitsResponse: {
            fits: components["schemas"]["Fit"][];
            next_page_token: string;
        };
        ListKeysResponse: {
            keys: components["schemas"]["Key"][];
            /** @description Empty on the last page. */
            next_page_token: string;
        };
        ListTwinsResponse: {
            next_page_token: string;
            twins: components["schemas"]["Twin"][];
        };
        ListWorkersResponse: {
            next_page_token: string;
            workers: components["schemas"]["Worker"][];
        };
        /** @description Loss of a model after an iteration. */
        ModelLoss: {
            /** Format: double */
            best_loss: number | null;
            /** Format: int64 */
            iteration: number;
            /**
             * Format: double
             * @description Absent where it was not finite.
             */
            loss: number | null;
            /** @description search or refine. */
            stage: string;
            /** @description bending or axial, of several starts followed by which: `bending 2/3`. */
            variant: string;
        };
        /** @description A sequence whose predicted motion is asked for. */
        MotionRequest: {
            /**
             * Format: int64
             * @description Its index among the sequences of all recordings of the capture, in their order.
             */
            sequence?: number;
        };
        /** @description Points on the surface of an object at one time, in the twin's coordinates. Points that were not seen are left out. */
        Observation: {
            /** @description FLOAT32 [K, 3], metres, K up to 16: the cameras that saw the points, which say what part of the surface could have been seen. Absent: all of it. */
            cameras?: components["schemas"]["Tensor"];
            /** @description UINT32 [M]: nodes of the twin. Only one of nodes, places may be given. */
            nodes?: components["schemas"]["Tensor"];
            /** @description Places between nodes. Only one of nodes, places may be given. */
            places?: components["schemas"]["Observation.Places"];
            /** @description FLOAT32 [M, 3], metres, M in 1..200000. */
            points?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [M, 3], metres per second; absent: not known. Only a correction by tracks uses them. */
            velocities?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [M], from 0; absent: equal ones. */
            weights?: components["schemas"]["Tensor"];
        };
        /** @description Points that move with the nodes around them, as tracked points do. */
        "Observation.Places": {
            /** @description FLOAT32 [N, 3], metres: where the nodes were at that time; absent: at rest. */
            node_positions?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [M, 3], metres: where they were at one time. */
            points?: components["schemas"]["Tensor"];
        };
        OpenSessionRequest: {
            /** @enum {string} */
            fidelity?: "EXACT" | "FAST" | "PLANNER";
            grasps?: components["schemas"]["Grasp"][];
            /**
             * Format: double
             * @description 1..3600; 0 means 300.
             */
            idle_timeout_s?: number;
            /** @description First state; default: the rest shape. A batch of given states has one for each slot. */
            initial?: components["schemas"]["InitialState"];
            /**
             * Format: int64
             * @description Number of simulations, 1..4096; 0 means 1.
             */
            slots?: number;
            /** @description twins/{uuid} */
            twin?: string;
            /** @description Surroundings of every rollout from here that names none itself. */
            world?: components["schemas"]["World"];
        };
        /** @description Limits that every plan keeps, FLOAT32 [1] or by coordinate [D], absent: none. They hold at the knots, and between them as well along straight lines. */
        PlanBounds: {
            high?: components["schemas"]["Tensor"];
            /** @description Smallest and largest value of a coordinate, metres or radians from the start of the space. */
            low?: components["schemas"]["Tensor"];
            /** @description Fastest change of a coordinate, per second. */
            speed?: components["schemas"]["Tensor"];
        };
        /** @description Way to propose plans and to learn from their costs. */
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
        /** @description Cross-entropy: mean and spread of the best samples, iteration by iteration. */
        "PlanMethod.Cem": {
            /**
             * Format: int64
             * @description 0 means 8.
             */
            elites?: number;
            /**
             * Format: double
             * @description Share of the old mean and spread in the new ones, less than 1; absent: 0.1.
             */
            memory?: number;
            /**
             * Format: double
             * @description Spread below which it does not shrink, as a share of sigma; absent: 0.05.
             */
            smallest?: number;
        };
        /** @description Adam along the gradient, from the nominal plan and others that begin sigma away. */
        "PlanMethod.Gradient": {
            /** @description FLOAT32 [1] or [D]: largest step of an iteration, metres or radians; absent: 0.005. */
            rate?: components["schemas"]["Tensor"];
        };
        /** @description Model-predictive path integral control: the mean of all samples, weighted by their costs. */
        "PlanMethod.Mppi": {
            /**
             * Format: double
             * @description As a share of the costs' spread; 0 means 0.1.
             */
            temperature?: number;
        };
        /** @description The best sample around the best plan so far. */
        "PlanMethod.PredictiveSampling": Record<string, never>;
        PlanRequest: {
            bounds?: components["schemas"]["PlanBounds"];
            /**
             * Format: double
             * @description Of neighbouring knots of a sample, 0 or more and less than 1: larger is smoother.
             */
            correlation?: number;
            /**
             * Format: double
             * @description Time for the iterations, seconds; the best so far comes back then, the first iteration is always finished. 0 means as long as it takes.
             */
            deadline_s?: number;
            /**
             * Format: double
             * @description Samples have sigma times a factor, evenly spread in its logarithm from 1 to this, above 0 and at most 1; absent: 0.1, and 1 for methods that shrink their samples themselves.
             */
            finest?: number;
            /**
             * Format: int64
             * @description 0 means 1, and 20 with a gradient. At most 1,000,000 plans are simulated in all.
             */
            iterations?: number;
            method?: components["schemas"]["PlanMethod"];
            /** @description The rollout to minimize: twin or session, costs, horizon, surroundings, fidelity. Its actions, of one instance, are the nominal plan, which the first iteration begins with; knots that came back can be sent as they are. Row 0 is where things are, and stays: where the initial state tells the control points (a session, or given controls), row 0 of trajectories is taken from there. `plausibility.strain` is the limit of the strain (default: 1; infinity lifts it). With `plausibility.refuse` a plan beyond any of the limits counts as one that diverges. `returns` are those of one more rollout, of the best plan alone; without any there is none. */
            rollout?: components["schemas"]["RollOutRequest"];
            /**
             * Format: int64
             * @description Plans that are simulated in an iteration; 0 means 64, and 1 with a gradient.
             */
            samples?: number;
            /**
             * Format: int64
             * @description Same seed, same plan, if no deadline stops it.
             */
            seed?: number;
            /**
             * Format: double
             * @description Frames that were executed since the nominal plan was made: its actions are moved on by them, and stand still at their end. Closings of grasps and paths of colliders are taken as they are given.
             */
            shift_frames?: number;
            /** @description FLOAT32 [1], by coordinate [D], or by knot and coordinate [K, D]: standard deviations of samples, metres or radians; absent: 0.02. */
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
             * @description Iterations that were finished.
             */
            iterations: number;
            /** @description FLOAT32, in the shape of the request's actions: [1, K, C, 3] or [1, K, G, 7]. */
            knots?: components["schemas"]["Tensor"];
            /** @description True for the last update. */
            last: boolean;
            /**
             * Format: double
             * @description +inf if the nominal plan diverges.
             */
            nominal_cost: number;
            /** @enum {string} */
            origin: "NOMINAL" | "MEAN" | "SAMPLE";
            /**
             * Format: int64
             * @description Plans that did not diverge and were beyond the limit.
             */
            overstrained: number;
            /** @description In the last update, if returns were asked for: the rollout of the best plan. */
            rollout?: components["schemas"]["RollOutResponse"];
            /**
             * Format: int64
             * @description Plans that were simulated, and those of them that diverged.
             */
            simulated: number;
            /** @description True if the deadline ended the search before all iterations were done. */
            stopped_by_deadline: boolean;
            /**
             * Format: double
             * @description Largest strain of the material in the motion of the best plan, with an ensemble of its members, and the limit. It is above the limit only if that is so for every plan that was simulated.
             */
            strain: number;
            /** Format: double */
            strain_limit: number;
            /**
             * Format: double
             * @description Since planning began, seconds.
             */
            time_s: number;
        };
        /** @description Points with normal . x >= offset are above it. */
        Plane: {
            /**
             * @description Three numbers, of length 1, away from the ground; absent: upwards, 0 0 1.
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
        /** @description Limits of what is held to be possible. A reply flags instances beyond; with `refuse` it is an error instead (FAILED_PRECONDITION, reason IMPLAUSIBLE_MOTION), before anything is simulated where the actions alone tell. */
        Plausibility: {
            /**
             * Format: double
             * @description Deepest that the middle of a grasp's sphere or box may be below the ground or in a collider that stands still, and that a control point may be beyond its depth in the initial state; default 0.005. Hands and grippers stop at that depth below the ground (Diagnostics.stopped_hand_m).
             */
            control_depth_m?: number;
            /**
             * Format: double
             * @description Fastest control point; default 5.
             */
            control_speed_m_s?: number;
            refuse?: boolean;
            /**
             * Format: double
             * @description Largest distance between the initial state's control points and row 0 of the actions; default 0.005. It is 0.02 more if a given state does not say where they are.
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
        /** @description The prediction of a sequence by nodes, and its errors frame by frame. T frames of the sequence, the prediction starts in `start_frame` S. */
        PredictedMotion: {
            /** @description One-sided Chamfer distance in the L1 norm, in each frame from S on [m], float32 [T - S]; not a number where that was not measured. */
            chamfer_l1_m?: components["schemas"]["Tensor"];
            /**
             * Format: int64
             * @description Frames from one row of `positions` to the next: 1, or more where all would take more than 16 MiB.
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
            /** @description Its name. */
            name: string;
            /** @description Positions of nodes [m], float32 [R, N, 3]; row r is of frame `start_frame + r * every_frames`. */
            positions?: components["schemas"]["Tensor"];
            /** @description Name of its recording. */
            recording: string;
            /**
             * Format: int64
             * @description The index that was asked for.
             */
            sequence: number;
            /**
             * Format: int64
             * @description S
             */
            start_frame: number;
            /** @description Mean distance of tracked points from where they were, in each frame from S on [m], float32 [T - S]; not a number where that was not measured. */
            track_m?: components["schemas"]["Tensor"];
            /**
             * Format: int64
             * @description Frames before this one were for fitting; 0 if the twin was fitted to none of them.
             */
            train_frame_count: number;
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
            /** Format: double */
            eta_s: number | null;
            /**
             * Format: double
             * @description Of the whole job, 0..1.
             */
            fraction: number;
            /** Format: int64 */
            iteration: number;
            /** Format: int64 */
            iterations: number;
            /** Format: double */
            loss: number | null;
            /** @description The last loss of each model that is fitted side by side with others. */
            models: components["schemas"]["ModelLoss"][];
            note: string | null;
            /** @description ingest, search, refine or evaluate. */
            stage: string;
            /** @description bending or axial; of an ingest its step. */
            variant: string;
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
             * @description Deviation of a spring by its length; default 0.1.
             */
            give?: number;
            /**
             * Format: double
             * @description Least share of the points that must be explained, 0..1; default 0.5.
             */
            least_explained?: number;
            /**
             * Format: double
             * @description Median distance of the points beyond which the registration is refused, metres; default: half the distance of neighbouring nodes, or 0.005 if that is more.
             */
            max_residual_m?: number;
            /** @description The object is near the shape to start from: no other pose is tried. */
            near?: boolean;
            /**
             * Format: double
             * @description Deviation of a point from the surface, metres; default 0.004.
             */
            noise_m?: number;
            /**
             * Format: int64
             * @description Frames of physics, 0..1000; default 12. Without any the shape is as the points have it.
             */
            settle_frames?: number;
        };
        RegisterStateRequest: {
            /** @description FLOAT32 [C, 3], metres: where the control points are, if that is known, say from the gripper. Absent: they go where the nodes go that they hold. */
            controls?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [G, 7]: poses of the grippers that carry colliders of the world: x, y, z in metres, quaternion x, y, z, w. Colliders of others are left out. */
            grippers?: components["schemas"]["Tensor"];
            /** @description Shape to start from: a single state, of no session; default: the rest shape. */
            initial?: components["schemas"]["InitialState"];
            observation?: components["schemas"]["Observation"];
            options?: components["schemas"]["RegisterOptions"];
            /** @description twins/{uuid} */
            twin?: string;
            /** @description Gravity, ground and colliders, where they are not those of the twin. The state is outside of them, but for what control points hold. A collider on a path is at its first pose. */
            world?: components["schemas"]["World"];
        };
        RegisteredState: {
            after?: components["schemas"]["Residual"];
            /** @description Distances of the points from the shape to start from, and from the state. */
            before?: components["schemas"]["Residual"];
            /**
             * Format: double
             * @description Mean distance by which nodes move in a frame when the points stop pulling, millimetres: how far the state is from where forces balance.
             */
            drift_mm: number;
            explained?: components["schemas"]["Explained"];
            /** @description The rigid part of the motion from the shape to start from, about the origin: x, y, z in metres, quaternion x, y, z, w. */
            motion: number[];
            /** @description At rest, with its control points; InitialState.given takes it as it is. */
            state?: components["schemas"]["InitialState.GivenState"];
            /** @description workers/{uuid} */
            worker: string;
        };
        ResetSessionRequest: {
            /** @description Absent: the session's first state. */
            initial?: components["schemas"]["InitialState"];
            name?: string;
            /** @description Empty: all. */
            slots?: number[];
        };
        /** @description Distances between points and the twin, millimetres: of tracks from their places, of a cloud from the surface. */
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
        Returns: {
            /** @description d cost / d what the request gave as actions: knots or poses, in their shape. */
            action_gradients?: boolean;
            /**
             * Format: int64
             * @description Positions, final states and gradients of only the best k instances by cost; 0 means all. These are simulated once more: on a GPU they may differ in the last bits from what the costs were computed from.
             */
            best?: number;
            /** @description d cost / d control positions, dense. */
            control_gradients?: boolean;
            /** @description Control positions that were simulated, by frame. */
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
             * @description Only of StreamRollOut: parts of at most so many frames, each sent as soon as it is simulated; 0 for whole instances. Not with `best` or gradients.
             */
            part_frames?: number;
            /**
             * @description Points whose positions and velocities are recorded: NODES, the default, or SKIN. Final states and gradients are of nodes.
             * @enum {string}
             */
            point_set?: "NODES" | "SKIN";
            /** @description UINT32 [K]: points of the skin to record, with the point set SKIN; empty means all. */
            skin_points?: components["schemas"]["Tensor"];
            /** @description With an ensemble of two members or more, and every_frames: `spread` of the recorded points. Arrays beside it (positions, velocities, final states, forces, costs by frame, controls) are of member 0 of each action alone then, or of the mean with MEAN_PREDICTION. */
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
             * @description Horizon F in frames, 1..100000; 0 means that of the dense actions.
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
             * @description Seconds from the arrival of the request after which no more instances are simulated, above 0; absent: all are. The reply then names those that are missing in `unfinished`. Arrays of `returns.best` are simulated after that. Not with gradients or `returns.part_frames`.
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
            /** @description In the actions' shape for R instances: [R, K, C, 3], or [R, K, G, 7] for poses; d cost / d quaternion along the sphere of unit quaternions. */
            action_gradients?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [R, F + 1, C, 3]. */
            control_gradients?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [R, F + 1, C, 3], metres. */
            controls?: components["schemas"]["Tensor"];
            cost_names: string[];
            /** @description FLOAT64 [B', terms], weighted. */
            cost_terms?: components["schemas"]["Tensor"];
            /** @description FLOAT64 [B']: weighted sums; +inf where an instance diverged. */
            costs?: components["schemas"]["Tensor"];
            /** @description With FAST or PLANNER only: how far the answer strays where that was measured. */
            deviation?: components["schemas"]["RollOutResponse.Deviation"];
            diagnostics: components["schemas"]["RollOutResponse.Diagnostics"][];
            diverged: components["schemas"]["RollOutResponse.Divergence"][];
            /**
             * @description Fidelity of the answer: EXACT, FAST or PLANNER.
             * @enum {string}
             */
            fidelity: "EXACT" | "FAST" | "PLANNER";
            /** @description FLOAT32 [R, C, 3], metres, with `poses`: InitialState.GivenState.commanded_controls of the final state. */
            final_commanded_controls?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [R, C, 3], metres: the control points of the final state. */
            final_controls?: components["schemas"]["Tensor"];
            /** @description With [R] in front; absent without grasps. */
            final_grasping?: components["schemas"]["Grasping"];
            /** @description FLOAT32 [R, N, 3]. */
            final_positions?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [R, rods], radians; absent if the twin has no rods. With final_positions and final_velocities a whole state, to go on from by InitialState.given. */
            final_twists?: components["schemas"]["Tensor"];
            final_velocities?: components["schemas"]["Tensor"];
            /**
             * Format: int64
             * @description The instances that this part covers: first_instance .. first_instance + B'.
             */
            first_instance: number;
            forces?: components["schemas"]["RollOutResponse.Forces"];
            /** @description FLOAT64 [R, F + 1, terms], weighted. */
            frame_costs?: components["schemas"]["Tensor"];
            /** @description UINT32 [T']: recorded frames, 1-based. */
            frames?: components["schemas"]["Tensor"];
            /** @description True for an instance whose gradient exploded on its way back (docs/gradients.md): it says little. UINT32 [R]. */
            gradient_exploded?: components["schemas"]["Tensor"];
            /** @description FLOAT64 [R, F + 1]. */
            gradient_norms?: components["schemas"]["Tensor"];
            /** @description Instances that are not plausible, with the reason; limits in RollOutRequest.plausibility. */
            implausible: components["schemas"]["RollOutResponse.Implausible"][];
            /** @description FLOAT32 [R, N, 3]. */
            initial_position_gradients?: components["schemas"]["Tensor"];
            initial_velocity_gradients?: components["schemas"]["Tensor"];
            /** @description UINT32 [R]: the instances that positions, final states and gradients are of, best first if `best` was given, ascending otherwise. */
            instances?: components["schemas"]["Tensor"];
            /**
             * Format: double
             * @description Kilograms of the object: forces are in newtons and energies in joules. Without it they are per unit mass, as if a node of the twin weighed 1 kg.
             */
            mass_kg?: number;
            /** @description With an ensemble: FLOAT64 [B', E], the costs of its members, which `costs` are statistics of (but for MEAN_PREDICTION). */
            member_costs?: components["schemas"]["Tensor"];
            /** @description [R, T', K, 3], metres: of nodes, or of skin points (`returns.point_set`). */
            positions?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [actions, T', K], metres: root mean square distance of the other members' points from those of member 0, which positions are of (but for MEAN_PREDICTION). NaN where a member diverged. */
            spread?: components["schemas"]["Tensor"];
            /**
             * Format: int64
             * @description Substeps per frame that were simulated.
             */
            substeps: number;
            timing?: components["schemas"]["RollOutResponse.Timing"];
            /** @description UINT32: the instances that were not simulated within `time_limit_s`. Their costs are +inf, their arrays NaN. */
            unfinished?: components["schemas"]["Tensor"];
            /** @description [R, T', K, 3], metres per second, of the same points. */
            velocities?: components["schemas"]["Tensor"];
            /** @description With `returns.part_frames`: what this part covers in time. */
            window?: components["schemas"]["RollOutResponse.Window"];
            /** @description workers/{uuid} */
            worker: string;
        };
        /** @description Between the fast variant and the exact twin when both follow the twin's own capture from its start. It does not hold for this reply: with faster or larger motions, or other surroundings, 5 to 16 times as much was seen. With PLANNER between the planner's twin and the exact one under sampled actions that it was not fitted to. */
        "RollOutResponse.Deviation": {
            /**
             * Format: int64
             * @description Frames of each recording or action, at most.
             */
            frames: number;
            /** Format: double */
            max_m: number;
            /**
             * Format: double
             * @description Between a node here and there, over nodes and frames, metres; of points of the skin with PLANNER.
             */
            mean_m: number;
            /**
             * Format: double
             * @description To compare with: of the exact twin's nodes or skin from where they started, metres.
             */
            mean_travel_m: number;
        };
        "RollOutResponse.Diagnostics": {
            /**
             * Format: float
             * @description Deepest that the middle of a grasp's sphere or box was below the ground or in a collider that stands still, and a control point or a held node beyond its depth at the start, metres; where hands stopped at the ground, as deep as the actions would have had them.
             */
            control_depth_m: number;
            /** Format: float */
            elastic_energy: number;
            /** Format: int64 */
            ground_contacts: number;
            /**
             * Format: float
             * @description At the end, joules; without a mass_kg as if a node of the twin weighed 1 kg.
             */
            kinetic_energy: number;
            /**
             * Format: float
             * @description Of springs to control points.
             */
            max_control_strain: number;
            /**
             * Format: float
             * @description Of a node at the end of any frame.
             */
            max_speed_m_s: number;
            /**
             * Format: float
             * @description Of springs between nodes.
             */
            max_strain: number;
            /**
             * Format: float
             * @description Farthest that a hand or gripper was held back, metres; 0 if none was. It stops where a control point, a node pinned to it, or the middle of a grasp's sphere or box would get deeper below the ground than `plausibility.control_depth_m`; then all of it moves along the ground's normal. Control points may also be as deep as a frame earlier, and as the twin has them at rest below its own ground.
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
            /** @description FLOAT32 [R, F, K, 6], as `grasps`; about the carrier's origin. */
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
             * @description Most that was found, and the limit, in the unit of the limit.
             */
            found: number;
            /**
             * Format: int64
             * @description The frame in which it was found, where it is known.
             */
            frame: number;
            /** Format: int64 */
            instance: number;
            /** Format: double */
            limit: number;
            /** @description START_GAP, CONTROL_SPEED, STRAIN, CONTROL_IN_OBSTACLE. */
            reason: string;
        };
        "RollOutResponse.Timing": {
            /** Format: double */
            compute_s: number;
            /** Format: double */
            queue_s: number;
        };
        /** @description Part of the horizon. Arrays by frame have the rows of these frames, so that those of all parts follow one another; the start, frame 0, is in the first. Costs, their terms, diagnostics, what is implausible and final states come with the last part of an instance, a divergence with the part that it happened in. */
        "RollOutResponse.Window": {
            /**
             * Format: int64
             * @description 1-based; the last counts.
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
             * @description The session ends when nobody has used it for so long.
             */
            idle_timeout_s: number;
            /** @description Slots that are lost, ascending: see Tracking. */
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
            /** @description With [S] in front for S slots; InitialState.given takes it as it is. */
            states?: components["schemas"]["InitialState.GivenState"];
        };
        Sphere: {
            /** @description Three numbers; absent: the origin. */
            center?: number[];
            /** Format: float */
            radius_m?: number;
        };
        StepSessionRequest: {
            /** @description Without name and slots, which are given above. Absent: nothing is corrected. */
            correction?: components["schemas"]["CorrectSessionRequest"];
            /**
             * Format: double
             * @description Time for all of it, seconds; 0 means as long as it takes. A correction takes what it takes, the search ends when nine tenths have passed, and its first iteration is always finished.
             */
            deadline_s?: number;
            /**
             * Format: int64
             * @description Frames of the best plan by which the slot is advanced, up to the horizon; 0 plans alone.
             */
            execute_frames?: number;
            /** @description sessions/{uuid} */
            name?: string;
            /** @description Of the rollout of these frames. */
            returns?: components["schemas"]["Returns"];
            /** @description Its rollout without twin, initial state and returns; world and grasps are the session's where it names none. Its actions are the nominal plan: the knots of the step before, with the frames that were executed as `shift_frames`, continue that plan. Its fidelity and its ensemble are those of the search alone, but that a MEAN_PREDICTION advances the slot too. */
            search?: components["schemas"]["PlanRequest"];
            /**
             * Format: int64
             * @description The slot that is corrected, planned from and advanced.
             */
            slot?: number;
        };
        SteppedSession: {
            /** @description The rollout of the frames that were executed; absent without any. If it diverged, the slot stays where the plan began. */
            advanced?: components["schemas"]["RollOutResponse"];
            /** @description Absent if none was asked for, or it was refused; without the corrected state. */
            corrected?: components["schemas"]["CorrectedSession"];
            /** @description True if the slot does not follow its object any more: predictions and plans from it say nothing of the object until it is registered again. */
            lost: boolean;
            /** @description The best plan, as the last update of a search. */
            plan?: components["schemas"]["PlanUpdate"];
            /** @description The reason, if the correction was refused because the slot does not explain the points: its state is as it was, and the plan begins where it was predicted to be. */
            refused?: components["schemas"]["Fault"];
            /** @description The state that the slot is in now, for all instances; InitialState.given takes it as it is. */
            state?: components["schemas"]["InitialState.GivenState"];
            times?: components["schemas"]["SteppedSession.Times"];
        };
        /** @description Times of the parts, and of all of it, seconds. */
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
        /** @description Record of how well a slot explains the observations that it is corrected by, refused ones included, since its state was last set or registered. The misfit of one is the median distance of its points after the correction, by the largest of half the distance of neighbouring nodes, 5 mm and noise_m; or, if that is more, the share of its points that are farther away than that and than three noise_m, by 1/2. Up to 1 the observation is explained. */
        Tracking: {
            /** @description True if the last three observations in a row are not explained, or if the mean misfit is above 1: the slot does not follow its object any more. Register it again (CorrectOptions.register_if_lost). */
            lost: boolean;
            /**
             * Format: double
             * @description Mean misfit, each weighted by 3/4 of the one after it and counted as at most 1.5; 0 before the first.
             */
            misfit: number;
            /**
             * Format: int64
             * @description Last observations in a row that are not explained.
             */
            unexplained: number;
        };
        Twin: {
            /** @description The capture and the fit that it came from; empty for an imported twin. */
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
             * @description Error over frames that it was not fitted to, metres: of tracks, else of coordinates, else the Chamfer distance; of those of the quality table the first that there is.
             */
            error_m: number | null;
            fit: string | null;
            /** Format: double */
            fps: number;
            /**
             * Format: double
             * @description Mass of the object, if it is known.
             */
            mass_kg?: number;
            /** @description twins/{uuid} */
            name: string;
            /** Format: int64 */
            node_count: number;
            /** @description Text that people write about it: up to 10,000 bytes. */
            note: string;
            /** @description Owner of the key with which its fit was asked for, or with which it was imported; empty if that is not known. */
            owner: string;
            /** @description The quality table as JSON (docs/twin-format.md, `quality`). */
            quality: {
                [key: string]: unknown;
            };
            /** Format: int64 */
            size_bytes: number;
            /** Format: int64 */
            spring_count: number;
            /** Format: int64 */
            substeps: number;
            /** @description Up to 32 words of up to 50 characters, sorted. */
            tags: string[];
            /** Format: int64 */
            triplet_count: number;
        };
        TwinGeometry: {
            /** @description FLOAT32 [T]: newton metres per radian, or per unit mass. */
            bend_stiffness?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [C, 3], metres: control points at rest. */
            controls?: components["schemas"]["Tensor"];
            /** @description UINT32 [E, 2]: springs between endpoints; from N on these are control points. */
            edges?: components["schemas"]["Tensor"];
            /**
             * Format: int64
             * @description Number of fits: the twin and its members.
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
            /** @description UINT32 [C]: the hand of the capture that each control point belongs to. */
            hands?: components["schemas"]["Tensor"];
            /** @description UINT8 [N]: 0 observed surface, 1 completed surface, 2 interior. Surface nodes come first. */
            kinds?: components["schemas"]["Tensor"];
            /** Format: double */
            mass_kg?: number;
            /** @description FLOAT32 [N]: masses; kilograms if `mass_kg` is known, else in units of a node. */
            masses?: components["schemas"]["Tensor"];
            /** @description UINT8 [N]: the part of the object that each node belongs to, by its place among `regions` of the quality table's `identifiability`. Empty: the twin has no such report. */
            node_regions?: components["schemas"]["Tensor"];
            /** @description UINT32 [P, 2]: nodes that control points hold exactly, as pairs of node and control point. */
            pins?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [E], metres. */
            rest_lengths?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [N, 3], metres: the rest shape. */
            rest_positions?: components["schemas"]["Tensor"];
            /** Format: int64 */
            rod_count: number;
            rod_nodes?: components["schemas"]["Tensor"];
            /** @description UINT32 [rods + 1] and UINT32 [..]: nodes of each rod, one after another. */
            rod_starts?: components["schemas"]["Tensor"];
            skin?: components["schemas"]["TwinGeometry.Skin"];
            /** @description FLOAT32 [M], metres: standard deviation of each skin point that the recordings leave, root mean square over the motions of that report. */
            skin_sd?: components["schemas"]["Tensor"];
            /**
             * Format: double
             * @description Mean length of springs between nodes, metres.
             */
            spacing_m: number;
            /** @description FLOAT32 [E]: newtons per unit strain if `mass_kg` is known, else per unit mass. */
            spring_stiffness?: components["schemas"]["Tensor"];
            /** Format: int64 */
            substeps: number;
            /** Format: int64 */
            surface_count: number;
            /** @description UINT32 [T, 3]: bending triplets, the centre in the middle. */
            triplets?: components["schemas"]["Tensor"];
        };
        /** @description Points of a twin's surface, finer than its nodes, that the nodes carry: M points, K weights. Point m is at sum over its weights of w x(node), plus its offset along the axes of its frame. With nodes a, b, c of the frame these are e1 along x(b) - x(a), e2 = e3 x e1, and e3 along (x(b) - x(a)) x (x(c) - x(a)). A twin that was fitted without a skin has its surface nodes here. */
        "TwinGeometry.Skin": {
            /** @description UINT32 [M, 3]: nodes a, b, c; 4294967295 for all three: the axes are those of the world. */
            frames?: components["schemas"]["Tensor"];
            /** @description UINT32 [M]: the capture's observed point that each is; 4294967295: none. */
            observed_points?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [M, 3], metres. Offsets of a frame whose nodes span no triangle count as 0. */
            offsets?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [M, 3], metres: with the nodes at rest. */
            rest_positions?: components["schemas"]["Tensor"];
            /** @description UINT32 [M]: number of weights of each point, which follow one another. */
            weight_counts?: components["schemas"]["Tensor"];
            /** @description UINT32 [K]. */
            weight_nodes?: components["schemas"]["Tensor"];
            /** @description FLOAT32 [K]; those of a point sum up to 1. */
            weights?: components["schemas"]["Tensor"];
        };
        UpdateCaptureRequest: {
            /** @description Tags to add to those that there are, and to take from them; not beside `tags` in the mask. */
            add_tags?: string[];
            display_name?: string;
            /** @description Text that people write about it: up to 10,000 bytes. */
            note?: string;
            remove_tags?: string[];
            /** @description Up to 32 words of up to 50 characters, sorted. */
            tags?: string[];
        };
        UpdateFitRequest: {
            /** @description Tags to add to those that there are, and to take from them; not beside `tags` in the mask. */
            add_tags?: string[];
            /** @description The capture's when the fit was created, unless one was given; its twin's, too, when it is made. */
            display_name?: string;
            /** @description Text that people write about it: up to 10,000 bytes. */
            note?: string;
            remove_tags?: string[];
            /** @description Up to 32 words of up to 50 characters, sorted. */
            tags?: string[];
        };
        UpdateTwinRequest: {
            /** @description Tags to add to those that there are, and to take from them; not beside `tags` in the mask. */
            add_tags?: string[];
            display_name?: string;
            /** @description Text that people write about it: up to 10,000 bytes. */
            note?: string;
            remove_tags?: string[];
            /** @description Up to 32 words of up to 50 characters, sorted. */
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
        /** @description Parameters by instance, as factors of the twin's own: B numbers each, FLOAT32 [B], or [E] with an ensemble. Absent: 1. An instance whose factors ask for more substeps than the twin has gets them, up to 100,000 a frame, and is as much more work. */
        Vary: {
            /** @description Of stiffness of bending and twist, 0..100. */
            bending?: components["schemas"]["Tensor"];
            /** @description Of dashpots, drag and damping of bending and twist, 0..100. */
            damping?: components["schemas"]["Tensor"];
            /** @description With an ensemble: member e is simulated on fit e of the twin, 0 being the twin itself and the others its members; at most as many as TwinGeometry.fits. Not with FAST or PLANNER, nor with rest shapes that corrections have changed. Factors apply on top of each fit. */
            fits?: boolean;
            /** @description Of friction with ground, colliders and other nodes, 0..100; friction is at most 2. */
            friction?: components["schemas"]["Tensor"];
            /** @description No factors, since captures hardly show them: the restitution of the ground and that between nodes, 0..1, in the place of the twin's and of the world's. */
            ground_restitution?: components["schemas"]["Tensor"];
            /** @description Of the mass of all nodes, 0.01..100. */
            mass?: components["schemas"]["Tensor"];
            object_restitution?: components["schemas"]["Tensor"];
            /** @description Of axial stiffness, 0.01..100. */
            stiffness?: components["schemas"]["Tensor"];
        };
        Worker: {
            /** @description cpu or cuda. */
            backend: string;
            build: string;
            device: string;
            /** @description True if it was asked to end. */
            draining: boolean;
            /** @description fits/{uuid} under way, if any. */
            fit: string | null;
            /** @description captures/{uuid} whose ingest is under way, if any. */
            ingest: string | null;
            /** @description Words that it was started with, which fits can ask for. */
            labels: string[];
            /** Format: date-time */
            last_seen_time: string;
            /** Format: int64 */
            memory_total_bytes: number | null;
            /**
             * Format: int64
             * @description Memory of its device in use, by whomever, and in all [bytes]; zero where it is not known.
             */
            memory_used_bytes: number | null;
            /** @description workers/{uuid}; a restarted worker is a new one. */
            name: string;
            /** Format: int64 */
            rollouts_in_flight: number;
            /** @description servers/{uuid} of the server that started it, and whose rollouts alone it answers; empty if others started it. */
            server: string | null;
            /** Format: date-time */
            start_time: string;
            /** @description Twins that are loaded and answer at once. */
            warm_twins: string[];
        };
        /** @description Worker that a fit or an ingest asks for. It waits until there is one. */
        WorkerRequirements: {
            /**
             * @description `cpu` or `cuda`; empty means either.
             * @default
             */
            backend: string;
            /**
             * @description Labels of which the worker has each: up to 32 of up to 50 characters without spaces and commas.
             * @default []
             */
            labels: string[];
            /**
             * Format: int64
             * @description Memory of the device at least [bytes]; on a CPU, that which a fit may take.
             * @default 0
             */
            memory_bytes: number;
        };
        /** @description The surroundings of an object in a rollout. Grippers are rigid bodies whose poses are the actions (GripperPoses); they are numbered from 0. */
        World: {
            /** @description At most 32. */
            colliders?: components["schemas"]["Collider"][];
            /** @description Three numbers, m/s^2; absent: the twin's own. */
            gravity?: number[];
            /** @description Instead of the twin's own ground. Only one of ground, no_ground may be given. */
            ground?: components["schemas"]["Plane"];
            /**
             * Format: float
             * @description Coulomb friction of the ground, 0..2, and its restitution, 0..1; absent: the twin's own.
             */
            ground_friction?: number;
            /** Format: float */
            ground_restitution?: number;
            /** @description No ground at all. Only one of ground, no_ground may be given. */
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
    ListCaptures: {
        parameters: {
            query?: {
                /** @description 0 means 50; more than 1000 counts as 1000. */
                page_size?: number;
                /** @description Of the page before, with the same filters and order. */
                page_token?: string;
                /** @description Only those whose display name or note has this text, whatever its case; up to 200 characters. */
                search?: string;
                /** @description Only those with this tag. */
                tag?: string;
                /** @description `create_time` or `name`, ascending or, followed by ` desc`, descending; empty means `create_time desc`. */
                order_by?: string;
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
                /** @description Display name. */
                display_name?: string;
                /** @description BLAKE3 of the body, hex; checked. Headers may give it instead. */
                digest?: string;
                /** @description Settings of the ingest that differ from the defaults, as JSON. */
                ingest?: string;
                /** @description Worker that the ingest asks for, as JSON. */
                ingest_requirements?: string;
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
                /** @description Skip revisions up to this one; what is no revision skips none. */
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
            /** @description Server-sent events with messages as data; one named `error` has a problem document and ends them. */
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
    ListFits: {
        parameters: {
            query?: {
                /** @description 0 means 50; more than 1000 counts as 1000. */
                page_size?: number;
                page_token?: string;
                /** @description Only fits of this capture, if given. */
                capture?: string;
                /** @description Only fits in this state, if given. */
                state?: "QUEUED" | "RUNNING" | "SUCCEEDED" | "FAILED" | "CANCELLED";
                /** @description Only those whose display name or note has this text, whatever its case; up to 200 characters. */
                search?: string;
                /** @description Only those with this tag. */
                tag?: string;
                /** @description `create_time`, `name` or `error`, ascending or, followed by ` desc`, descending; empty means `create_time desc`. */
                order_by?: string;
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
                /** @description Skip revisions up to this one; what is no revision skips none. */
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
            /** @description Server-sent events with messages as data; one named `error` has a problem document and ends them. */
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
    ListKeys: {
        parameters: {
            query?: {
                /** @description 0 means 50; more than 1000 counts as 1000. */
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
            /** @description Server-sent events with messages as data; one named `error` has a problem document and ends them. */
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
                /** @description Empty: all. */
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
    ListTwins: {
        parameters: {
            query?: {
                /** @description 0 means 50; more than 1000 counts as 1000. */
                page_size?: number;
                page_token?: string;
                /** @description Only twins of this capture, if given. */
                capture?: string;
                /** @description Only those whose display name or note has this text, whatever its case; up to 200 characters. */
                search?: string;
                /** @description Only those with this tag. */
                tag?: string;
                /** @description `create_time`, `name` or `error`, ascending or, followed by ` desc`, descending; empty means `create_time desc`. */
                order_by?: string;
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
                /** @description Display name. */
                display_name?: string;
                /** @description BLAKE3 of the body, hex; checked. Headers may give it instead. */
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
            /** @description Server-sent events with messages as data; one named `error` has a problem document and ends them. */
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
