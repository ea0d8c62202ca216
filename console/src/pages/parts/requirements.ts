import type { Fit, Worker } from '@bendtwin/client';
import { size } from '../../ui/format';

/** Requirements of a fit on its worker. */
export type Requirements = Fit['requirements'];

export const ANY_WORKER: Requirements = { backend: '', memory_bytes: 0, labels: [] };

/** The worker that a fit asks for, in words. */
export function wanted({ backend, memory_bytes: memory, labels }: Requirements): string {
  const words = [
    ...(backend === '' ? [] : [backendWord(backend)]),
    ...(memory > 0 ? [`${size(memory)} of memory`] : []),
    ...labels,
  ];
  return words.length > 0 ? words.join(', ') : 'any';
}

/** True if a worker satisfies requirements. An unknown memory counts as enough. */
export function satisfies(worker: Worker, { backend, memory_bytes: memory, labels }: Requirements): boolean {
  return (
    (backend === '' || backend === worker.backend) &&
    memory <= (worker.memory_total_bytes ?? Infinity) &&
    labels.every((label) => worker.labels.includes(label))
  );
}

export function backendWord(backend: string): string {
  return backend.toUpperCase();
}
