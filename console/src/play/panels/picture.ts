import { h } from '../../ui/dom';
import type { TwinShape } from '../../view3d/shape';
import type { ColourBy, TwinLayer, TwinView } from '../../view3d/twin_view';

const NAMES: Readonly<Record<TwinLayer, string>> = {
  skin: 'Skin',
  appearance: 'Appearance',
  nodes: 'Nodes',
  springs: 'Springs',
  triplets: 'Bending triplets',
  rods: 'Rods',
  controls: 'Control points',
  shadow: 'Shadow',
};
const COLOURS: Readonly<Record<ColourBy, string>> = {
  none: 'nothing',
  strain: 'strain',
  stiffness: 'stiffness',
  uncertainty: 'uncertainty (the skin)',
};

/** Settings of the picture of a twin. */
export interface Look {
  readonly layers: Set<TwinLayer>;
  colour: ColourBy;
}

/** A look from an address, where it has one; else springs only where no surface or splats hide them. */
export function readLook(query: URLSearchParams, shape: Pick<TwinShape, 'appearance' | 'surface'>): Look {
  const usual = shape.surface !== null || shape.appearance?.splats ? 'skin,appearance,shadow' : 'skin,appearance,springs,shadow';
  const names = (query.get('layers') ?? usual).split(',');
  const colour = query.get('colour') ?? 'none';
  return {
    layers: new Set(names.filter((name): name is TwinLayer => Object.hasOwn(NAMES, name))),
    colour: Object.hasOwn(COLOURS, colour) ? (colour as ColourBy) : 'none',
  };
}

/** Writes a look into an address. */
export function writeLook(look: Look, query: URLSearchParams): void {
  query.set('layers', [...look.layers].join(','));
  if (look.colour !== 'none') query.set('colour', look.colour);
}

/** Values by which a twin at rest can be coloured, where available. */
export function coloursOf({ springStiffness, skinSd }: Pick<TwinShape, 'springStiffness' | 'skinSd'>): ColourBy[] {
  const known: readonly (readonly [ColourBy, boolean])[] = [
    ['none', true],
    ['stiffness', springStiffness.length > 0],
    ['uncertainty', skinSd.length > 0],
  ];
  return known.flatMap(([colour, isKnown]) => (isKnown ? [colour] : []));
}

/** Boxes for layers, and what springs and triplets, or the skin, are coloured by. */
export function pictureControls(
  view: TwinView,
  look: Look,
  colours: readonly ColourBy[],
  changed: () => void,
): HTMLElement {
  const boxes = new Map(view.layers.map((layer) => [layer, h('input', { type: 'checkbox' })]));
  const select = h('select', {}, ...colours.map((colour) => h('option', { value: colour }, COLOURS[colour])));
  const apply = (): void => {
    for (const [layer, box] of boxes) box.checked = look.layers.has(layer);
    select.value = look.colour;
    view.show(look.layers);
    view.colourBy(look.colour);
  };
  for (const [layer, box] of boxes) {
    box.addEventListener('change', () => {
      if (box.checked) look.layers.add(layer);
      else look.layers.delete(layer);
      apply();
      changed();
    });
  }
  select.addEventListener('change', () => {
    look.colour = select.value as ColourBy;
    // What is coloured must be seen: springs, which the skin would hide, or the skin without its pictures.
    if (look.colour === 'uncertainty') {
      look.layers.add('skin');
      look.layers.delete('appearance');
      look.layers.delete('springs');
    } else if (look.colour !== 'none') {
      look.layers.add('springs');
      look.layers.delete('skin');
    }
    apply();
    changed();
  });
  apply();
  return h('div', {},
    ...[...boxes].map(([layer, box]) => h('label', {}, box, ` ${NAMES[layer]}`)),
    h('label', {}, 'Colour by ', select));
}
