import { number } from '../../view3d/legend';
import type { Excess } from './strain';

/** How far strain may exceed the recorded range before one is warned: recordings do not show the very most. */
export const TOLERATED = 1.25;
/** Multiples of the object's weight from which a force is worth mentioning. */
const REMARKABLE = 5;

/** Warning about a state of a twin; empty while it is as the recordings were. `weights` is the largest force. */
export function warningOf({ times, way }: Pick<Excess, 'times' | 'way'>, weights: number | null): string {
  if (times <= TOLERATED) return '';
  const verb = way === 'stretched' ? 'Stretched' : 'Compressed';
  const pull = weights === null || weights < REMARKABLE ? '' : `, pulled with ${multiple(weights)} times its weight`;
  return `${verb} ${multiple(times)} times beyond anything recorded${pull}: do not trust this.`;
}

/** A force [N] in words; relative ones, where the mass is not known, as multiples of the weight alone. */
export function forceOf(size: number, weight: number, isKnown: boolean): string {
  const weights = weight > 0 ? `${multiple(size / weight)} × weight` : '';
  if (!isKnown) return weights || number(size);
  return weights === '' ? `${number(size)} N` : `${number(size)} N, ${weights}`;
}

/** Two digits are enough of a multiple, and no more than its whole number. */
function multiple(value: number): string {
  return value >= 10 ? String(Math.round(value)) : String(Number(value.toPrecision(2)));
}
