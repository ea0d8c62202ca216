import { visitedTwin } from '../api/visit';
import { h } from '../ui/dom';
import { counted } from '../ui/format';
import { pointCount } from '../view3d/skin';
import type { TwinShape } from '../view3d/shape';
import type { ColourBy } from '../view3d/twin_view';
import type { Background } from './background/background';
import type { Facts, Ready } from './protocol/messages';
import { backgroundPanel } from './panels/background';
import { goalPanel, type GoalPanel } from './panels/goal';
import { grippersPanel } from './panels/grippers';
import { helpPanel } from './panels/help';
import { obstaclesPanel } from './panels/obstacles';
import { panel } from './panels/parts';
import { coloursOf, pictureControls, readLook } from './panels/picture';
import { recordingPanel } from './panels/recording';
import { timePanel } from './panels/time';
import { worldPanel } from './panels/world';
import type { Playing } from './playing';
import { shareMenu } from './share/menu';

/** All panels of a play's page. */
export interface Panels {
  readonly bar: HTMLElement;
  readonly column: HTMLElement;
  readonly goal: GoalPanel;
  keepsHold(): boolean;
  update(facts: Facts): void;
  refresh(): void;
  /** Takes away what moves something. */
  watchOnly(): void;
  /** The picture in words. */
  describe(ready: Ready): string;
}

/** Makes the panels. */
export function panelsOf(
  playing: Playing,
  { shape, background }: { readonly shape: TwinShape; readonly background: Background },
  selected: () => void,
  query: () => URLSearchParams,
): Panels {
  const [time, world] = [timePanel(playing), worldPanel(playing)];
  const [grippers, obstacles] = [grippersPanel(playing, selected), obstaclesPanel(playing)];
  const [goal, recording] = [goalPanel(playing), recordingPanel(playing)];
  // Searches and recordings are not for those who have a link alone.
  const isVisit = visitedTwin() !== null;
  const moving = [grippers, world, obstacles, ...(isVisit ? [] : [goal, recording])];
  const help = helpPanel();
  const column = h('div', { class: 'play-panels-column' }, ...moving.map(({ element }) => element),
    picturePanel(playing, shape), backgroundPanel(background, playing.context.query.get('background')),
    isVisit ? '' : shareMenu(playing.scene.stage, playing.context, query, playing.name), help);
  return {
    bar: time.element,
    column,
    goal,
    keepsHold: () => grippers.keeps,
    update: (facts) => [time, ...moving].forEach((part) => part.update?.(facts)),
    refresh: () => [grippers, obstacles].forEach((part) => part.refresh?.()),
    watchOnly: () => [...[time, ...moving].map(({ element }) => element), help].forEach((part) => part.remove()),
    describe: (ready) =>
      `A twin of ${ready.nodes} nodes and ${pointCount(shape.skin)} points of skin, held by ` +
      `${counted(ready.grippers.filter(({ hand }) => hand !== null).length, 'hand')}, simulated ${ready.fps} times a second.`,
  };
}

/** Panel of how the twin is shown. */
function picturePanel({ scene, context }: Playing, shape: TwinShape): HTMLElement {
  const [none, ...others] = coloursOf(shape);
  const colours: ColourBy[] = [none ?? 'none', 'strain', ...others];
  return panel('Picture', false, pictureControls(scene.twin, readLook(context.query, shape), colours, () => undefined));
}
