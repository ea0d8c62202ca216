import { Vector3 } from 'three';
import type { OpenPage, PageContext } from '../page';
import { h } from '../ui/dom';
import { counted } from '../ui/format';
import { GroundLayer } from '../view3d/layers/ground';
import { Legend } from '../view3d/legend';
import type { TwinShape } from '../view3d/shape';
import { pointCount } from '../view3d/skin';
import { Stage } from '../view3d/stage';
import { TwinView } from '../view3d/twin_view';
import { panel } from './panels/parts';
import { coloursOf, pictureControls, readLook, writeLook, type Look } from './panels/picture';
import { shareMenu } from './share/menu';
import { loadTwin } from './twin';
import './play.css';

/** A twin at rest, viewed from any side. */
export const open: OpenPage = async (context) => {
  const id = context.parameters['id'] ?? '';
  const { shape, name } = await loadTwin(context, id);
  const stage = new Stage(`The twin ${name} at rest`);
  const view = placed(stage, shape);
  const look = readLook(context.query, shape);
  if (!stage.setView(context.query.get('view') ?? '')) stage.lookAt(shape.rest);
  const element = elementOf(context, { id, name, stage, shape, view, look });
  return {
    element,
    dispose: () => {
      view.dispose();
      stage.dispose();
    },
  };
};

/** A twin at rest on its ground. */
function placed(stage: Stage, shape: TwinShape): TwinView {
  const legend = new Legend();
  stage.overlay.append(legend.element);
  const view = new TwinView(stage, shape, legend);
  stage.add(new GroundLayer()).place(shape.ground, new Vector3(...shape.rest.subarray(0, 3)));
  view.above(shape.ground);
  return view;
}

/** A displayed twin. */
interface Viewed {
  readonly id: string;
  readonly name: string;
  readonly stage: Stage;
  readonly shape: TwinShape;
  readonly view: TwinView;
  readonly look: Look;
}

function elementOf(context: PageContext, { id, name, stage, shape, view, look }: Viewed): HTMLElement {
  const query = (): URLSearchParams => {
    const written = new URLSearchParams({ view: stage.view });
    writeLook(look, written);
    return written;
  };
  stage.controls.addEventListener('end', () => context.setQuery(query()));
  const counts = [
    counted(shape.rest.length / 3, 'node'), counted(shape.springs.length / 2, 'spring'),
    counted(shape.triplets.length / 3, 'bending triplet'), counted(pointCount(shape.skin), 'skin point'),
  ].join(', ');
  const keys = 'arrows rotate, Control and arrows move, plus and minus zoom';
  stage.describe(`${counts}. Keys: ${keys}.`);
  return h('div', { class: 'play' },
    h('div', { class: 'play-main' },
      h('div', { class: 'row' },
        h('a', { class: 'button primary', href: `#/twins/${id}/play` }, 'Play with it'),
        h('a', { class: 'button', href: `#/twins/${id}` }, 'Errors and history'),
        h('span', { class: 'play-facts' }, counts)),
      stage.element,
      h('p', { class: 'hint' },
        'Drag to rotate, right button or two fingers to move, wheel to zoom. ' +
        `With the picture in focus: ${keys}.`)),
    h('div', { class: 'play-panels' },
      panel('Picture', true,
        pictureControls(view, look, coloursOf(shape), () => context.setQuery(query()))),
      shareMenu(stage, context, query, name)));
}
