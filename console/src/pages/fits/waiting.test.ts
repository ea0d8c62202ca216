import type { Capture, Fit, Worker } from '@bendtwin/client';
import { expect, test } from 'vitest';

import { ANY_WORKER } from '../parts/requirements';
import { whyItWaits } from './waiting';

const fit = (changes: object = {}, attempts = 0): Fit =>
  ({ requirements: ANY_WORKER, job: { state: 'QUEUED', attempts }, ...changes }) as unknown as Fit;
const capture = (state: string): Capture => ({ ingest: { state } }) as unknown as Capture;
const worker = (changes: object = {}): Worker =>
  ({ backend: 'cpu', labels: [], memory_total_bytes: null, fit: null, draining: false, ...changes }) as unknown as Worker;
const READ = capture('SUCCEEDED');

test('a fit waits for its capture, for a worker that can do it, or for its turn', () => {
  expect(whyItWaits(fit(), capture('RUNNING'), [])).toBe('Waits until its capture has been read.');
  expect(whyItWaits(fit(), READ, [])).toBe('Waits for a worker: none is connected.');
  const gpu = fit({ requirements: { ...ANY_WORKER, backend: 'cuda', labels: ['lab'] } });
  expect(whyItWaits(gpu, READ, [worker()])).toBe('Waits for a worker with CUDA, lab: none is connected.');
  expect(whyItWaits(fit(), null, [worker()])).toBe('Waits for a worker.');
  const busy = worker({ fit: 'fits/1' });
  expect(whyItWaits(fit(), READ, [busy])).toBe('Waits its turn: the only one is busy.');
  expect(whyItWaits(fit({}, 1), READ, [busy, worker({ draining: true })])).toBe(
    'Waits its turn: all 2 workers are busy. It then resumes where it stopped.',
  );
  const able = worker({ backend: 'cuda', labels: ['lab'], fit: 'fits/1' });
  expect(whyItWaits(gpu, READ, [able, worker()])).toBe('Waits its turn: the only one with CUDA, lab is busy.');
});
