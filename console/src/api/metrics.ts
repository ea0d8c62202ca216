/** Values of `/metrics`, by `name{label="value",…}`. */
export type Metrics = ReadonlyMap<string, number>;

/** Reads the text format of Prometheus; invalid lines are left out. */
export function parseMetrics(text: string): Metrics {
  const metrics = new Map<string, number>();
  for (const line of text.split('\n')) {
    const space = line.lastIndexOf(' ');
    const value = Number(line.slice(space + 1));
    if (space > 0 && !line.startsWith('#') && !Number.isNaN(value)) metrics.set(line.slice(0, space), value);
  }
  return metrics;
}

/** Jobs by state, of `fits` or `ingests`. */
export function jobs(metrics: Metrics, kind: 'fits' | 'ingests'): (state: string) => number {
  return (state) => metrics.get(`bendtwin_${kind}{state="${state}"}`) ?? 0;
}

/** Sum over all states. */
export function total(of: (state: string) => number): number {
  return ['queued', 'running', 'succeeded', 'failed', 'cancelled'].reduce((sum, state) => sum + of(state), 0);
}
