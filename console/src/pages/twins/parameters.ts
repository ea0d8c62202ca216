import type { PageContext } from '../../page';
import { h } from '../../ui/dom';
import { facts } from '../../ui/form';
import { count } from '../../ui/format';
import { table } from '../../ui/table';
import { below } from '../parts/error';
import { settingWord, settingsView } from '../parts/settings_view';
import { readTwinFile, spreadOf, type TwinFile } from './file';

/** Tensors with parameters: their names, words and units. */
const TENSORS: readonly (readonly [string, string, string])[] = [
  ['springs.stiffness', 'Stiffness of springs', 'N per unit strain and node mass'],
  ['springs.dashpot', 'Damping of springs', 'N s/m per node mass'],
  ['triplets.bend_stiffness', 'Stiffness of bending', 'N m/rad'],
  ['triplets.bend_damping', 'Damping of bending', 'N m s/rad'],
  ['rods.twist_stiffness', 'Stiffness of twist', 'N m/rad'],
  ['rods.twist_damping', 'Damping of twist', 'N m s/rad'],
];

/** Parameters and settings of the fit, from the twin's file; `own` are the settings of the request. */
export function parametersView(context: PageContext, twin: string, own: () => Promise<unknown>): HTMLElement {
  const element = h('section', {}, h('h2', {}, 'Parameters'));
  const load = async (): Promise<void> => {
    const file = await readTwinFile(context.api, twin, context.signal);
    const [tensors, asked] = await Promise.all([tensorTable(file), own()]);
    const { provenance } = file.document;
    const settings = provenance?.settings ?? null;
    element.append(
      tensors,
      materialFacts(file),
      settings === null && asked === null
        ? h('p', { class: 'muted' }, 'The file does not contain the settings of the fit.')
        : settingsView('Settings of the fit', asked ?? settings, settings),
    );
  };
  load().catch((error: unknown) => {
    if (!context.signal.aborted)
      element.append(h('p', { class: 'muted' }, `The file cannot be read: ${String(error)}`));
  });
  return element;
}

async function tensorTable(file: TwinFile): Promise<HTMLElement> {
  const spreads = await Promise.all(
    TENSORS.map(async ([name, ...words]) => [words, spreadOf(await file.floats(name))] as const),
  );
  const rows = spreads.flatMap(([words, spread]) => (spread === null ? [] : [{ words, spread }]));
  const word = (value: number): string =>
    value === 0
      ? '0'
      : Math.abs(value) < 0.01 || value >= 1e6
        ? value.toExponential(2)
        : count(Number(value.toPrecision(3)));
  return table({
    caption: 'Fitted values: median, and the range of nine in ten',
    rows,
    columns: [
      { header: 'Parameter', cell: ({ words: [text] }) => text },
      { header: 'Median', isNumeric: true, cell: ({ words: [, unit = ''], spread }) => [word(spread.median), below(unit)] },
      { header: 'Nine in ten', isNumeric: true, cell: ({ spread }) => `${word(spread.low)} to ${word(spread.high)}` },
    ],
  });
}

function materialFacts({ document }: TwinFile): HTMLElement {
  const { drag, contact = {}, provenance } = document;
  const pairs: [string, string][] = [];
  if (drag !== undefined) pairs.push(['Drag', `${Number(drag.toPrecision(3))} 1/s`]);
  for (const [name, text] of [
    ['ground_friction', 'Friction on the ground'],
    ['ground_restitution', 'Restitution on the ground'],
  ] as const) {
    const value = contact[name];
    if (typeof value === 'number') pairs.push([text, String(Number(value.toPrecision(3)))]);
  }
  if (provenance?.build !== undefined)
    pairs.push(['Made by', `${provenance.build}, ${settingWord(provenance.backend)}`]);
  return facts(pairs);
}
