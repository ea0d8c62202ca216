/** Ways to colour the observed points: `auto` is their own colours, and one colour where a prediction lies under them. */
export type ColourBy = 'auto' | 'own' | 'plain' | 'error';

/** Settings of the picture of a sequence. */
export interface Look {
  colour: ColourBy;
  observed: boolean;
  controls: boolean;
  prediction: boolean;
  springs: boolean;
  /** The prediction has the colours of its twin, if that has any. */
  appearance: boolean;
  /** The prediction stands beside the observed points in place of over them. */
  beside: boolean;
}

const FLAGS = ['observed', 'controls', 'prediction', 'springs', 'appearance', 'beside'] as const;

/** Default settings. */
export function usual(): Look {
  return {
    colour: 'auto',
    observed: true,
    controls: true,
    prediction: true,
    springs: false,
    appearance: true,
    beside: false,
  };
}

/** The look that an address has, the usual one where it has none. */
export function readLook(query: URLSearchParams, hasColours: boolean): Look {
  const look = usual();
  const colour = query.get('colour');
  if (colour === 'plain' || colour === 'error' || (colour === 'own' && hasColours)) look.colour = colour;
  for (const flag of FLAGS) {
    const text = query.get(flag);
    if (text === '0' || text === '1') look[flag] = text === '1';
  }
  return look;
}

/** Writes into an address what is not usual. */
export function writeLook(look: Look, query: URLSearchParams): void {
  const known = usual();
  if (look.colour !== known.colour) query.set('colour', look.colour);
  for (const flag of FLAGS) if (look[flag] !== known[flag]) query.set(flag, look[flag] ? '1' : '0');
}
