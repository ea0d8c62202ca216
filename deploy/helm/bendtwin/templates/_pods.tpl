{{/* What pods have in common. */}}

{{/* Security of a pod: the user and the group of the image, to whom volumes belong. */}}
{{- define "bendtwin.podSecurity" -}}
runAsNonRoot: true
runAsUser: 10001
runAsGroup: 10001
fsGroup: 10001
# Files on a volume keep their permissions after the first start.
fsGroupChangePolicy: OnRootMismatch
seccompProfile: {type: RuntimeDefault}
{{- end }}

{{- define "bendtwin.containerSecurity" -}}
allowPrivilegeEscalation: false
readOnlyRootFilesystem: true
capabilities: {drop: [ALL]}
{{- end }}

{{/* Placement. Takes root, component, perhaps pool, values, spreads (over zones) and avoids (each
other's nodes). */}}
{{- define "bendtwin.placement" -}}
{{- $labels := include "bendtwin.selector" . -}}
{{- with .values.priorityClassName }}
priorityClassName: {{ . }}
{{- end }}
{{- with .values.runtimeClassName }}
runtimeClassName: {{ . }}
{{- end }}
{{- with .values.nodeSelector }}
nodeSelector: {{- toYaml . | nindent 2 }}
{{- end }}
{{- with .values.tolerations }}
tolerations: {{- toYaml . | nindent 2 }}
{{- end }}
{{- if .values.affinity }}
affinity: {{- toYaml .values.affinity | nindent 2 }}
{{- else if .avoids }}
affinity:
  podAntiAffinity:
    preferredDuringSchedulingIgnoredDuringExecution:
      - weight: 100
        podAffinityTerm:
          topologyKey: kubernetes.io/hostname
          labelSelector:
            matchLabels: {{- $labels | nindent 14 }}
{{- end }}
{{- if .values.topologySpreadConstraints }}
topologySpreadConstraints: {{- toYaml .values.topologySpreadConstraints | nindent 2 }}
{{- else if .spreads }}
topologySpreadConstraints:
  - maxSkew: 1
    topologyKey: topology.kubernetes.io/zone
    whenUnsatisfiable: ScheduleAnyway
    labelSelector:
      matchLabels: {{- $labels | nindent 8 }}
{{- end }}
{{- end }}

{{/* Variables that name the store, for servers and backups. */}}
{{- define "bendtwin.storeEnv" -}}
{{- with .Values.secrets.store }}
envFrom:
  # BENDTWIN_DATABASE_URL, BENDTWIN_OBJECTS, and AWS_… where the pod has no role.
  - secretRef: {name: {{ . }}}
{{- end }}
{{- end }}

{{/* The token of clients in a file, which servers and backups read. */}}
{{- define "bendtwin.clientTokenFile" -}}/var/run/secrets/bendtwin/client/client-token{{- end }}

{{- define "bendtwin.clientTokenMount" -}}
{name: client, mountPath: /var/run/secrets/bendtwin/client, readOnly: true}
{{- end }}

{{- define "bendtwin.clientTokenVolume" -}}
name: client
secret:
  secretName: {{ .Values.secrets.clientToken }}
  defaultMode: 0440
  items: [{key: client-token, path: client-token}]
{{- end }}

{{/* Names by which clients call the servers. */}}
{{- define "bendtwin.allowedHosts" -}}
{{- $name := include "bendtwin.fullname" . -}}
{{- $inside := list $name (printf "%s.%s" $name .Release.Namespace) (include "bendtwin.host" .) -}}
{{- concat $inside .Values.ingress.hosts .Values.tls.public.hosts .Values.server.allowedHosts | uniq | join "," -}}
{{- end }}

{{/* Affinity to the node of a single server, for pods that mount its volume. */}}
{{- define "bendtwin.besideServer" -}}
affinity:
  podAffinity:
    requiredDuringSchedulingIgnoredDuringExecution:
      - topologyKey: kubernetes.io/hostname
        labelSelector:
          matchLabels: {{- include "bendtwin.selector" (dict "root" . "component" "server") | nindent 12 }}
{{- with .Values.server.tolerations }}
tolerations: {{- toYaml . | nindent 2 }}
{{- end }}
{{- end }}
