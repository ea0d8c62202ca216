import type { PageContext } from '../../page';
import { h } from '../../ui/dom';
import { millimetres } from '../../ui/format';
import { Errors, type Place } from '../axis/errors';
import { sequenceText } from '../choices';
import type { Head } from '../file/head';
import { Prediction, type FrameErrors } from '../prediction';

/** The worst frames of a sequence by each measure; a measure that it has not is left out. */
export type WorstPlaces = Partial<Record<keyof FrameErrors, Place>>;

/** A frame of a sequence, and its error [m]. */
export interface Found extends Place {
  readonly sequence: number;
}

/** Worst frames that were found before, by twin, capture and sequence: each costs a simulation. */
const KNOWN = new Map<string, Promise<WorstPlaces>>();

/** The worst frame of all sequences by a measure, and how many sequences have that; null without any. */
export function worstOf(all: readonly WorstPlaces[], measure: keyof FrameErrors): { found: Found; of: number } | null {
  const places = all.flatMap((places, sequence) => {
    const place = places[measure];
    return place === undefined ? [] : [{ ...place, sequence }];
  });
  const [first, ...others] = places;
  if (first === undefined) return null;
  return { found: others.reduce((worst, place) => (place.error > worst.error ? place : worst), first), of: places.length };
}

/** The prediction of a twin in the sequences of a capture. */
export interface Predicted {
  readonly context: PageContext;
  readonly capture: string;
  readonly twin: string;
  /** The version of the capture's playback. */
  readonly version: string;
  readonly head: Head;
}

/** Notes the errors of a sequence that is shown. */
export function note(predicted: Predicted, sequence: number, errors: Errors): void {
  KNOWN.set(keyOf(predicted, sequence), Promise.resolve(placesOf(errors)));
}

/**
 * A button that looks for the worst frame of all sequences: the twin is simulated beside each that was not looked at
 * before. `measure` is that of the sequence which is shown, `go` opens another one at a frame.
 */
export function worstOfAllButton(
  predicted: Predicted,
  measure: keyof FrameErrors,
  say: (text: string) => void,
  go: (found: Found) => void,
): HTMLElement {
  const { sequences } = predicted.head;
  const look = async (): Promise<void> => {
    button.disabled = true;
    button.setAttribute('aria-busy', 'true');
    try {
      const all: WorstPlaces[] = [];
      for (const index of sequences.keys()) {
        say(`The twin is simulated beside sequence ${index + 1} of ${sequences.length}…`);
        all.push(await placesIn(predicted, index));
        if (predicted.context.signal.aborted) return;
      }
      const worst = worstOf(all, measure);
      if (worst === null) say('No sequence has errors of this kind.');
      else {
        const { found, of } = worst;
        const missing = of < sequences.length ? ` Only ${of} of ${sequences.length} sequences have errors of this kind.` : '';
        const name = sequenceText(predicted.head, found.sequence);
        const text = `The worst frame of all sequences is frame ${found.frame} of ${name}: ${millimetres(found.error)}.${missing}`;
        say(text);
        // Another sequence is another page, which this text does not reach.
        predicted.context.announce(text);
        go(found);
      }
    } catch (error) {
      say(`The worst frame cannot be found: ${error instanceof Error ? error.message : String(error)}`);
    }
    button.removeAttribute('aria-busy');
    button.disabled = false;
  };
  const text = `Worst frame of all ${sequences.length} sequences`;
  const button = h('button', { type: 'button', onclick: () => void look() }, text);
  return button;
}

/** The worst frames of a sequence; of one that the twin has no prediction of, none. */
function placesIn(predicted: Predicted, sequence: number): Promise<WorstPlaces> {
  const key = keyOf(predicted, sequence);
  const known = KNOWN.get(key) ?? ask(predicted, sequence);
  KNOWN.set(key, known);
  // What failed is asked for again.
  known.catch(() => KNOWN.delete(key));
  return known;
}

async function ask({ context, capture, twin, head }: Predicted, sequence: number): Promise<WorstPlaces> {
  const prediction = await Prediction.load(context.api, { twin, capture, sequence }, context.signal);
  return placesOf(new Errors(prediction, head.sequences[sequence]!.frame_count));
}

function placesOf(errors: Errors): WorstPlaces {
  return Object.fromEntries(errors.curves.flatMap((curve) => {
    const place = errors.worstOf(curve);
    return place === null ? [] : [[curve.of, place]];
  }));
}

function keyOf({ twin, capture, version }: Predicted, sequence: number): string {
  return [twin, capture, version, sequence].join(' ');
}
