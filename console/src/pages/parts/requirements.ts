import type { Fit } from '../../api/types';
import { size } from '../../ui/format';

/** The worker that a fit asks for, in words. */
export function wanted({ requirements }: Fit): string {
  const { backend, memory_bytes: memory, labels } = requirements;
  const words = [
    ...(backend === '' ? [] : [backend === 'cpu' ? 'CPU' : backend.toUpperCase()]),
    ...(memory > 0 ? [`${size(memory)} of memory`] : []),
    ...labels,
  ];
  return words.length > 0 ? words.join(', ') : 'any';
}
