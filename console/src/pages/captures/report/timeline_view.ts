import type { PageContext } from '../../../page';
import { h } from '../../../ui/dom';
import type { Report } from './report';
import { bandsOf, timelinesOf } from './timelines';

/** The timelines of a report; null without any. What draws them is fetched now. `playback`: the address of the playback, or null. */
export function timelineView({ signal }: PageContext, report: Report, playback: string | null): HTMLElement | null {
  const { frame_count: frameCount, train_frame_count: trainFrameCount, fps } = report;
  const [bands, timelines] = [bandsOf(report), timelinesOf(report)];
  if (frameCount < 2 || bands.length + timelines.length === 0) return null;
  const later = trainFrameCount > 0 && trainFrameCount < frameCount;
  const hint = [
    playback === null ? '' : 'Click a frame to play the recording from there. ',
    later ? `Frames from ${trainFrameCount} on, right of the dashed line, are held back to see how well a twin predicts.` : '',
  ];
  const element = h('section', {}, h('h2', {}, 'Over time'), h('p', { class: 'hint' }, ...hint));
  const onFrame = playback === null ? null : (frame: number): void => void (location.hash = `${playback}?frame=${frame}`);
  void import('./timeline_charts').then(
    ({ TimelineCharts }) => {
      if (signal.aborted) return;
      const charts = new TimelineCharts({ bands, timelines, frameCount, trainFrameCount, fps, onFrame });
      signal.addEventListener('abort', () => charts.dispose());
      element.append(charts.element);
    },
    // The report is whole without them; a later visit fetches them again.
    () => element.remove(),
  );
  return element;
}
