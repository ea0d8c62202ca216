import { h } from '../ui/dom';
import { Legend } from '../view3d/legend';
import { Ground } from '../view3d/place/ground';
import { Stage } from '../view3d/stage';
import { TwinView } from '../view3d/twin_view';
import { TwinFile } from './file';
import { listenToKeys } from './keys';
import { LiveTwin } from './live_twin';
import { PointerPull } from './pointer';
import { readShape } from './shape';

/** The page of a twin, from the content of its file: the object, and what can be done with it. */
export function twinPage(name: string, content: Uint8Array): HTMLElement {
  const file = new TwinFile(content);
  const twin = new LiveTwin(file);
  const shape = readShape(file, twin.model);
  const stage = new Stage(`${name}: drag it to pull, drag beside it to turn the view`);
  const view = new TwinView(stage, shape, new Legend());
  view.above(shape.ground);
  new Ground(stage, shape.rest).place(shape.ground);
  stage.lookAt(shape.rest);

  let isPaused = matchMedia('(prefers-reduced-motion: reduce)').matches;
  let isSeen = true;
  let last: number | null = null;
  const status = h('p', { role: 'status' });
  const speed = h('p', {});
  const pause = h('button', { type: 'button', onclick: () => setPaused(!isPaused) });
  const reset = h('button', { type: 'button', onclick: () => begin() }, 'Reset');
  const letGo = h('button', { type: 'button', onclick: () => drop() });

  const place = (): void => view.place(Float32Array.from(twin.nodes), Float32Array.from(twin.controls));
  /** Shows a change that was asked for, and lets pictures follow. */
  const show = (text: string): void => {
    status.textContent = text;
    pause.textContent = isPaused ? 'Play' : 'Pause';
    letGo.textContent = twin.isHeld ? 'Let go' : 'Hold';
    letGo.hidden = !twin.canFall;
    place();
    stage.invalidate();
  };
  const setPaused = (is: boolean): void => {
    isPaused = is;
    twin.wake();
    show(is ? 'Paused' : '');
  };
  const begin = (): void => {
    twin.reset();
    stage.lookAt(shape.rest);
    show('Reset');
  };
  const drop = (): void => {
    if (!twin.canFall) return;
    twin.hold(!twin.isHeld);
    setPaused(false);
  };
  const moved = (): void => {
    if (twin.isPulled && isPaused) setPaused(false);
    else stage.invalidate();
  };

  stage.beforeFrame((now) => {
    if (isPaused || !isSeen || twin.isStill) {
      last = null;
      return false;
    }
    if (last !== null && !twin.advance((now - last) / 1000)) show('The motion went out of bounds and began anew.');
    last = now;
    speed.textContent = twin.slowness === null ? '' : `${Math.round(100 * twin.slowness)} % of real speed`;
    place();
    return true;
  });
  new PointerPull(stage, twin, shape.spacing, moved);
  listenToKeys(stage, twin, { reset: begin, pause: () => setPaused(!isPaused), letGo: drop, moved });
  new IntersectionObserver(([entry]) => {
    isSeen = entry?.isIntersecting ?? true;
    stage.invalidate();
  }).observe(stage.element);
  stage.describe('Drag the object to pull it. Arrows turn the view, with Shift they pull. Space pauses, R resets.');
  setPaused(isPaused);
  return h('main', {}, stage.element,
    h('footer', {},
      h('p', {}, h('strong', {}, h('bdi', {}, name)), 'simulated by BendTwin'),
      speed, status,
      h('div', { class: 'embed-buttons', role: 'group', 'aria-label': 'Simulation' }, letGo, pause, reset)));
}
