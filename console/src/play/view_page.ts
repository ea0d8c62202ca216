import type { OpenPage, PageContext } from '../page';
import { h } from '../ui/dom';
import { counted } from '../ui/format';
import { Legend } from '../view3d/legend';
import { Ground } from '../view3d/place/ground';
import type { TwinShape } from '../view3d/shape';
import { pointCount } from '../view3d/skin';
import { Stage } from '../view3d/stage';
import { TwinView } from '../view3d/twin_view';
import { Background } from './background/background';
import { layoutOf } from './layout';
import { backgroundPanel } from './panels/background';
import { panel } from './panels/parts';
import { coloursOf, pictureControls, readLook, writeLook, type Look } from './panels/picture';
import { shareMenu } from './share/menu';
import { loadTwin, type ShownTwin } from './twin';
import './play.css';

/** A twin at rest, viewed from any side. */
export const open: OpenPage = async (context) => {
  const id = context.parameters['id'] ?? '';
  const twin = await loadTwin(context, id);
  const { shape, name, capture } = twin;
  const stage = new Stage(`The twin ${name} at rest`);
  const ground = new Ground(stage, shape.rest);
  ground.place(shape.ground);
  const view = placed(stage, shape);
  const background = Background.of({ stage, ground, shape }, context, capture);
  const look = readLook(context.query, shape);
  if (!stage.setView(context.query.get('view') ?? '')) stage.lookAt(shape.rest);
  const element = elementOf(context, { ...twin, stage, view, look, background });
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
  stage.overlay.append(h('div', { class: 'play-legends' }, legend.element));
  const view = new TwinView(stage, shape, legend);
  view.above(shape.ground);
  return view;
}

/** A displayed twin. */
interface Viewed extends ShownTwin {
  readonly stage: Stage;
  readonly view: TwinView;
  readonly look: Look;
  readonly background: Background;
}

function elementOf(context: PageContext, { id, name, stage, shape, view, look, background }: Viewed): HTMLElement {
  const query = (): URLSearchParams => {
    const written = new URLSearchParams({ view: stage.view });
    writeLook(look, written);
    if (background.choice !== 'grid') written.set('background', background.choice);
    return written;
  };
  stage.controls.addEventListener('end', () => context.setQuery(query()));
  const counts = [
    counted(shape.rest.length / 3, 'node'), counted(shape.springs.length / 2, 'spring'),
    counted(shape.triplets.length / 3, 'bending triplet'), counted(pointCount(shape.skin), 'skin point'),
  ].join(', ');
  const keys = 'arrows rotate, Control and arrows move, plus and minus zoom';
  stage.describe(`${counts}. Keys: ${keys}.`);
  return layoutOf({
    bar: h('div', { class: 'row' },
      h('a', { class: 'button primary', href: `#/twins/${id}/play` }, 'Play with it'),
      h('a', { class: 'button', href: `#/twins/${id}` }, 'Errors and history')),
    stage: stage.element,
    below: h('div', { class: 'play-below' },
      h('p', { class: 'play-facts' }, h('span', {}, counts)),
      h('p', { class: 'hint' },
        'Drag to rotate, right button or two fingers to move, wheel to zoom. ' +
        `With the picture in focus: ${keys}.`)),
    panels: [
      panel('Picture', true, pictureControls(view, look, coloursOf(shape), () => context.setQuery(query()))),
      backgroundPanel(background, context.query.get('background')),
      shareMenu(stage, context, query, name),
    ],
  });
}
