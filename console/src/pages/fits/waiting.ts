import { hasEnded, type Capture, type Fit, type Worker } from '@bendtwin/client';
import { counted } from '../../ui/format';
import { ANY_WORKER, satisfies, wanted } from '../parts/requirements';

/** What a queued fit waits for, in a sentence. */
export function whyItWaits(fit: Fit, capture: Capture | null, workers: readonly Worker[]): string {
  const resumes = fit.job.attempts > 0 ? ' It then resumes where it stopped.' : '';
  if (capture !== null && !hasEnded(capture.ingest)) return 'Waits until its capture has been read.';
  if (workers.length === 0) return `Waits for a worker: none is connected.${resumes}`;
  const { requirements } = fit;
  const able = workers.filter((worker) => satisfies(worker, requirements));
  if (able.length === 0) return `Waits for a worker with ${wanted(requirements)}: none is connected.${resumes}`;
  const idle = able.filter(({ fit: other, draining }) => !other && !draining);
  if (idle.length > 0) return `Waits for a worker.${resumes}`;
  const kind = wanted(requirements) === wanted(ANY_WORKER) ? '' : ` with ${wanted(requirements)}`;
  const busy = able.length === 1 ? `the only one${kind} is busy` : `all ${counted(able.length, 'worker')}${kind} are busy`;
  return `Waits its turn: ${busy}.${resumes}`;
}
