import type { Capture, Fit, OwnerUsage, Twin } from '@bendtwin/client';
import { jobs, parseMetrics, total } from '../../api/metrics';
import type { PageContext } from '../../page';
import { totalOf } from '../../ui/list';

/** Most twins that are counted where the server does not say how many there are. */
const COUNTED = 50;
/** Rows of each list. */
const SHOWN = 5;

/** State of the server as the first page shows it. */
export interface Numbers {
  readonly captures: number;
  readonly reading: number;
  readonly unread: number;
  readonly unreadable: number;
  readonly fits: number;
  readonly fitsRunning: number;
  readonly fitsQueued: number;
  readonly fitsFailed: number;
  /** Twins up to `COUNTED`; `hasMoreTwins` says if there are more. */
  readonly twins: number;
  readonly hasMoreTwins: boolean;
  /** `cpu` or `cuda` for each worker. */
  readonly workers: readonly string[];
  readonly diskFreeBytes: number;
  /** What is stored for the one who looks. */
  readonly usage: OwnerUsage;
  readonly newestCaptures: readonly Capture[];
  readonly newestFits: readonly Fit[];
  readonly newestTwins: readonly Twin[];
}

/** Asks the server for all numbers in parallel. */
export async function ask({ api, signal }: PageContext): Promise<Numbers> {
  const [text, captures, fits, twins, workers, usage] = await Promise.all([
    api.fetch('/metrics', { signal }).then((answer) => answer.text()),
    api.get('/v1/captures', { query: { page_size: SHOWN }, signal }),
    api.get('/v1/fits', { query: { page_size: SHOWN }, signal }),
    api.get('/v1/twins', { query: { page_size: COUNTED }, signal }),
    api.get('/v1/workers', { signal }),
    api.get('/v1/usage', { signal }),
  ]);
  const metrics = parseMetrics(text);
  const ingests = jobs(metrics, 'ingests');
  const fitJobs = jobs(metrics, 'fits');
  return {
    captures: total(ingests),
    reading: ingests('running'),
    unread: ingests('queued'),
    unreadable: ingests('failed'),
    fits: total(fitJobs),
    fitsRunning: fitJobs('running'),
    fitsQueued: fitJobs('queued'),
    fitsFailed: fitJobs('failed'),
    twins: totalOf(twins) ?? twins.twins.length,
    hasMoreTwins: totalOf(twins) === undefined && twins.next_page_token !== '',
    workers: workers.workers.map((worker) => worker.backend),
    diskFreeBytes: metrics.get('bendtwin_disk_bytes{state="free"}') ?? 0,
    usage,
    newestCaptures: captures.captures,
    newestFits: fits.fits,
    newestTwins: twins.twins.slice(0, SHOWN),
  };
}
