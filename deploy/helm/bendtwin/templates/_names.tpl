{{/* Names, labels and images. */}}

{{/* Prefix of all names: short enough for those of pods, with a pool and a number behind it. */}}
{{- define "bendtwin.fullname" -}}
{{- $name := default .Chart.Name .Values.nameOverride -}}
{{- $full := ternary .Release.Name (printf "%s-%s" .Release.Name $name) (contains $name .Release.Name) -}}
{{- default $full .Values.fullnameOverride | trunc 28 | trimSuffix "-" -}}
{{- end }}

{{/* Labels that never change, for selectors. Takes root and component. */}}
{{- define "bendtwin.selector" -}}
app.kubernetes.io/name: {{ default .root.Chart.Name .root.Values.nameOverride }}
app.kubernetes.io/instance: {{ .root.Release.Name }}
{{- with .component }}
app.kubernetes.io/component: {{ . }}
{{- end }}
{{- with .pool }}
pool: {{ . }}
{{- end }}
{{- end }}

{{/* Labels of a pod: without versions, so that a new chart with the same image restarts nothing. */}}
{{- define "bendtwin.podLabels" -}}
{{ include "bendtwin.selector" . }}
{{- with .root.Values.commonLabels }}
{{ toYaml . }}
{{- end }}
{{- with .values }}
{{- with .podLabels }}
{{ toYaml . }}
{{- end }}
{{- end }}
{{- end }}

{{/* Labels of an object. Takes root, component and perhaps pool. */}}
{{- define "bendtwin.labels" -}}
{{ include "bendtwin.selector" . }}
app.kubernetes.io/version: {{ .root.Chart.AppVersion | quote }}
app.kubernetes.io/managed-by: {{ .root.Release.Service }}
helm.sh/chart: {{ printf "%s-%s" .root.Chart.Name .root.Chart.Version | replace "+" "_" }}
{{- with .root.Values.commonLabels }}
{{ toYaml . }}
{{- end }}
{{- end }}

{{/* Image. Takes root, backend and perhaps tag. */}}
{{- define "bendtwin.image" -}}
{{- $image := .root.Values.image -}}
{{- $tag := default .root.Chart.AppVersion $image.tag -}}
{{- if eq .backend "cuda" }}{{ $tag = printf "%s%s" $tag $image.cudaSuffix }}{{ end -}}
{{- printf "%s:%s" $image.repository (default $tag .tag) -}}
{{- end }}

{{/* Requests and limits with a GPU, which Kubernetes wants in both. Takes resources, backend and gpuResource. */}}
{{- define "bendtwin.resources" -}}
{{- $resources := deepCopy .resources -}}
{{- if eq .backend "cuda" -}}
{{- $gpu := dict "requests" (dict .gpuResource "1") "limits" (dict .gpuResource "1") -}}
{{- $resources = mergeOverwrite $resources $gpu -}}
{{- end -}}
{{- toYaml $resources -}}
{{- end }}

{{- define "bendtwin.serviceAccount" -}}
{{- $own := printf "%s-server" (include "bendtwin.fullname" .) -}}
{{- default (ternary $own "default" .Values.serviceAccount.create) .Values.serviceAccount.name -}}
{{- end }}

{{- define "bendtwin.isFleet" -}}
{{- if eq .Values.mode "fleet" }}yes{{ end -}}
{{- end }}

{{/* Whether clients reach the servers over TLS of the servers themselves. */}}
{{- define "bendtwin.hasTls" -}}
{{- if ne .Values.tls.public.source "proxy" }}yes{{ end -}}
{{- end }}

{{- define "bendtwin.publicSecret" -}}
{{- $own := printf "%s-public-tls" (include "bendtwin.fullname" .) -}}
{{- ternary .Values.tls.public.secret $own (eq .Values.tls.public.source "secret") -}}
{{- end }}

{{- define "bendtwin.workersServerSecret" -}}
{{- $own := printf "%s-servers-tls" (include "bendtwin.fullname" .) -}}
{{- ternary .Values.tls.workers.serverSecret $own (eq .Values.tls.workers.source "secret") -}}
{{- end }}

{{- define "bendtwin.workerSecret" -}}
{{- $own := printf "%s-workers-tls" (include "bendtwin.fullname" .) -}}
{{- ternary .Values.tls.workers.workerSecret $own (eq .Values.tls.workers.source "secret") -}}
{{- end }}

{{/* Name of the service of clients within the cluster. */}}
{{- define "bendtwin.host" -}}
{{- printf "%s.%s.svc" (include "bendtwin.fullname" .) .Release.Namespace -}}
{{- end }}

{{- define "bendtwin.port" -}}
{{- .Values.service.port | default (ternary 443 80 (eq (include "bendtwin.hasTls" .) "yes")) -}}
{{- end }}

{{- define "bendtwin.url" -}}
{{- $scheme := ternary "https" "http" (eq (include "bendtwin.hasTls" .) "yes") -}}
{{- printf "%s://%s:%s" $scheme (include "bendtwin.host" .) (include "bendtwin.port" .) -}}
{{- end }}

{{/* Claim with the data of a single server. */}}
{{- define "bendtwin.dataClaim" -}}
{{- default (printf "%s-data" (include "bendtwin.fullname" .)) .Values.server.persistence.existingClaim -}}
{{- end }}

{{/* The values of a pool: those of all pools, and its own. Takes root and pool. */}}
{{- define "bendtwin.pool" -}}
{{- $own := index .root.Values.workers .pool | default dict -}}
{{- mergeOverwrite (deepCopy .root.Values.workerDefaults) (deepCopy $own) | toYaml -}}
{{- end }}

{{/* Whether somebody who looks finds a worker: pools without one at times do not count. */}}
{{- define "bendtwin.expectsWorkers" -}}
{{- if and (ne .Values.mode "fleet") (gt (int .Values.server.ownWorkers) 0) }}yes{{ end -}}
{{- range $name, $_ := .Values.workers -}}
{{- $pool := include "bendtwin.pool" (dict "root" $ "pool" $name) | fromYaml -}}
{{- $fewest := ternary $pool.autoscaling.minReplicas $pool.replicas $pool.autoscaling.enabled -}}
{{- if gt (int $fewest) 0 }}yes{{ end -}}
{{- end -}}
{{- end }}

{{/* Name of the certificate that clients are shown: an issuer of a public authority has none for the service. */}}
{{- define "bendtwin.publicName" -}}
{{- $hosts := concat .Values.ingress.hosts .Values.tls.public.hosts -}}
{{- if and .Values.tls.public.issuerRef $hosts }}{{ first $hosts }}{{ else }}{{ include "bendtwin.host" . }}{{ end -}}
{{- end }}
