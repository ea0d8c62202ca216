{{/* Values that contradict each other, beyond what values.schema.json can say. */}}
{{- define "bendtwin.check" -}}
{{- if include "bendtwin.isFleet" . }}
{{- if not .Values.secrets.store }}
{{- fail "mode is `fleet`: name a secret with BENDTWIN_DATABASE_URL and BENDTWIN_OBJECTS in secrets.store (docs/run/kubernetes.md#a-fleet)" }}
{{- end }}
{{- if not .Values.secrets.clientToken }}
{{- fail "mode is `fleet`: name a secret with client-token in secrets.clientToken, so that all servers have the same one (docs/run/kubernetes.md#a-fleet)" }}
{{- end }}
{{- end }}
{{- if and (eq .Values.tls.public.source "secret") (not .Values.tls.public.secret) }}
{{- fail "tls.public.source is `secret`: name a secret with tls.crt and tls.key in tls.public.secret" }}
{{- end }}
{{- if and (eq .Values.tls.public.source "certManager") (not .Values.tls.public.issuerRef) (ne .Values.tls.workers.source "certManager") }}
{{- fail "tls.public.source is `certManager`: name an issuer in tls.public.issuerRef, or let the chart make an authority with tls.workers.source=certManager" }}
{{- end }}
{{- if .Values.workers }}
{{- if not .Values.secrets.workerToken }}
{{- fail "there are workers: name a secret with BENDTWIN_WORKER_TOKEN in secrets.workerToken" }}
{{- end }}
{{- if and (eq .Values.tls.workers.source "secret") (not (and .Values.tls.workers.serverSecret .Values.tls.workers.workerSecret)) }}
{{- fail "there are workers: name the secrets with their certificates in tls.workers.serverSecret and tls.workers.workerSecret, or set tls.workers.source=certManager (docs/run/kubernetes.md#tls)" }}
{{- end }}
{{- if and .Values.tls.workers.revocationList (ne .Values.tls.workers.source "secret") }}
{{- fail "tls.workers.revocationList: cert-manager makes no revocation lists; use tls.workers.source=secret" }}
{{- end }}
{{- end }}
{{- if and .Values.ingress.enabled (not .Values.ingress.hosts) }}
{{- fail "ingress.enabled: name the hosts in ingress.hosts" }}
{{- end }}
{{- range $name, $_ := .Values.workers }}
{{- $pool := include "bendtwin.pool" (dict "root" $ "pool" $name) | fromYaml }}
{{- if and $pool.autoscaling.enabled (not (include "bendtwin.isFleet" $)) }}
{{- fail (printf "workers.%s.autoscaling asks PostgreSQL for the queue: set mode=fleet" $name) }}
{{- end }}
{{- end }}
{{- if regexMatch "(?m)^\\s*shutdown_grace_s\\s*=" .Values.server.config }}
{{- fail "server.config has shutdown_grace_s: set server.shutdownGraceSeconds, from which the time until a pod is killed follows" }}
{{- end }}
{{- end }}
