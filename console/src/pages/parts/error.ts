import { h, type Child } from '../../ui/dom';
import { millimetres } from '../../ui/format';

/** Words for the measures of errors, as the API names them. */
const MEASURES: Record<string, string> = { track: 'tracks', coordinate: 'coordinates', chamfer: 'Chamfer' };

/** What errors in lists mean, which stands behind the header of their column. */
export const ERROR_HELP =
  'How far predictions are from what was recorded, on average over the frames that were not fitted to. The word below ' +
  'says how it was measured. Tracks: the distance of tracked points. Coordinates: the difference of the coordinates of ' +
  'markers. Chamfer: the distance of observed points from the surface, where no point was tracked. Errors of different ' +
  'measures are not comparable.';

/** A measure in a word: tracks, coordinates or Chamfer. */
export function measureWord(measure: string): string {
  return MEASURES[measure] ?? measure;
}

/** An error with its measure, as "8.3 mm (tracks)". */
export function errorWords(metres: number | null | undefined, measure: string | null | undefined): string {
  const word = measure ? ` (${measureWord(measure)})` : '';
  return `${millimetres(metres)}${word}`;
}

/** An error in a column of a list, with its measure below it; a dash without one. */
export function errorCell(metres: number | null | undefined, measure: string | null | undefined): Child {
  const isKnown = metres !== null && metres !== undefined && measure;
  return [millimetres(metres), isKnown ? below(measureWord(measure)) : ''];
}

/** A word below a number of a table: its measure or its unit. */
export function below(word: string): HTMLElement {
  return h('span', { class: 'below' }, word);
}
