import type { Worker } from '@bendtwin/client';
import { expect, test } from 'vitest';

import { ANY_WORKER, satisfies, wanted } from './requirements';

const GPU = { backend: 'cuda', memory_total_bytes: 80e9, labels: ['gpu=h100', 'lab=2'] } as unknown as Worker;
const CPU = { backend: 'cpu', memory_total_bytes: null, labels: [] } as unknown as Worker;

test('a worker has the kind, the memory and each label that are asked for', () => {
  const both = (asked: object): boolean[] => [GPU, CPU].map((worker) => satisfies(worker, { ...ANY_WORKER, ...asked }));
  expect(both({})).toEqual([true, true]);
  expect(both({ backend: 'cuda' })).toEqual([true, false]);
  expect(both({ memory_bytes: 80e9 })).toEqual([true, true]);
  expect(both({ memory_bytes: 81e9 })).toEqual([false, true]);
  expect(both({ labels: ['lab=2'] })).toEqual([true, false]);
  expect(both({ labels: ['lab=2', 'lab=3'] })).toEqual([false, false]);
});

test('requirements are put into words', () => {
  expect(wanted(ANY_WORKER)).toBe('any');
  expect(wanted({ backend: 'cuda', memory_bytes: 0, labels: ['lab=2'] })).toBe('CUDA, lab=2');
});
