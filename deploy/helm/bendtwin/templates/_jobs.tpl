{{/* Queries of the queue. */}}

{{/* Whether a pool is scaled automatically. */}}
{{- define "bendtwin.scales" -}}
{{- range $name, $_ := .Values.workers -}}
{{- $pool := include "bendtwin.pool" (dict "root" $ "pool" $name) | fromYaml -}}
{{- if $pool.autoscaling.enabled }}yes{{ end -}}
{{- end -}}
{{- end }}

{{/* Number of jobs that wait or run and that a pool may take: requirements (JSON, or empty for none) name its backend
or none, and no label that it lacks. Takes kind, poolName and pool. */}}
{{- define "bendtwin.jobsFor" -}}
{{- $labels := list -}}
{{- range concat (list (printf "pool=%s" .poolName)) .pool.labels }}{{ $labels = append $labels (squote (replace "'" "''" .)) }}{{ end -}}
{{- $asks := "nullif(requirements, '')::json" -}}
select count(*) from jobs
where kind = '{{ .kind }}' and state in ('queued', 'running')
and coalesce({{ $asks }}->>'backend', '') in ('', '{{ .pool.backend }}')
and not exists (select from json_array_elements_text({{ $asks }}->'labels') as label
where label not in ({{ join ", " $labels }}))
{{- if not .pool.autoscaling.countsUnspecificJobs }}
and ({{ $asks }}->>'backend' = '{{ .pool.backend }}' or json_array_length({{ $asks }}->'labels') > 0)
{{- end }}
{{- end }}
