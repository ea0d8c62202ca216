import { hasEnded, idOf, type Capture } from '@bendtwin/client';
import { h } from '../../ui/dom';
import { cli, command } from '../../ui/empty';
import { hasPoints } from '../parts/ingest';
import type { Numbers } from './numbers';

/** Next steps from a recording to a twin that can be moved, while some of them are still to be done. */
export function nextSteps(numbers: Numbers): HTMLElement {
  const steps = [...stepsOf(numbers)];
  if (steps.length === 0) return h('div');
  return h('section', { class: 'card next-steps' }, h('h2', { class: 'first' }, 'What to do next'), ...steps);
}

function* stepsOf(numbers: Numbers): Generator<HTMLElement> {
  if (numbers.workers.length === 0) {
    yield h('p', {}, 'No worker is connected: captures, fits and predictions wait for one.');
    yield h('p', {}, 'See ', h('a', { href: '#/workers' }, 'how to start workers'), '.');
  }
  if (numbers.captures === 0) {
    yield h('p', {}, 'Upload a recording of a soft object: tracked points or the images of your cameras.');
    yield h('p', {}, h('a', { class: 'button primary', href: '#/upload' }, 'Upload a recording'));
    yield h('p', {}, 'Or make one of a simulated rope, to try everything out:');
    yield command('bendtwin capture make rope rope.zip --tiny');
    yield command(cli('bendtwin capture push rope.zip'));
  } else if (numbers.fits === 0 || isUnfitted(numbers)) {
    yield* fitStep(numbers.newestCaptures[0]);
  }
  const [twin] = numbers.newestTwins;
  if (twin !== undefined && numbers.twins === 1 && !numbers.hasMoreTwins) {
    yield h('p', {}, 'Your first twin is ready: drag its hands, grasp it anywhere, change the world around it.');
    yield h('p', {}, h('a', { class: 'button primary', href: `#/twins/${idOf(twin.name)}/play` }, 'Play with it'));
  }
}

/** True if the newest capture is newer than all fits, so that none is of it. */
function isUnfitted({ newestCaptures: [capture], newestFits: [fit] }: Numbers): boolean {
  return capture !== undefined && fit !== undefined && capture.create_time > fit.job.create_time;
}

/** The way from the newest capture to a twin. */
function* fitStep(newest: Capture | undefined): Generator<HTMLElement> {
  if (newest !== undefined && hasEnded(newest.ingest) && !hasPoints(newest)) {
    yield h('p', {}, 'Your newest recording is not ready for a fit: its page says what it lacks, and helps with masks and calibration.');
    yield h('p', {}, h('a', { class: 'button primary', href: `#/${newest.name}` }, 'To the recording'));
    return;
  }
  const query = newest === undefined ? '' : `?${new URLSearchParams({ capture: idOf(newest.name) })}`;
  yield h('p', {}, 'Fit a twin to your recording. With the effort “draft” this takes about a minute.');
  yield h('p', {}, h('a', { class: 'button primary', href: `#/fits/new${query}` }, 'Fit a twin'));
}
