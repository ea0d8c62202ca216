import type { Capture } from '@bendtwin/client';
import type { PageContext } from '../../page';
import { isGroup, type Settings } from './settings';

/** The settings of a capture's ingest with some of them changed; groups, as `calibration`, keep their others. */
export function changed(settings: Settings, change: Settings): Settings {
  const result: Settings = { ...settings };
  for (const [name, value] of Object.entries(change)) {
    const own = settings[name];
    result[name] = isGroup(value) && isGroup(own) ? { ...own, ...value } : value;
  }
  return result;
}

/** Reads a capture again with its settings, some of them changed, on the worker that it requires; gives the capture. */
export function readAgain({ api, signal }: PageContext, capture: Capture, change: Settings): Promise<Capture> {
  const { ingest, ingest_requirements: requirements } = capture;
  const body = { settings: changed(ingest.settings, change), requirements };
  return api.send<Capture>('POST', `/v1/${capture.name}/ingest`, body, signal);
}

/** Settings of an ingest that people made on other pages: they stay when it is run with other settings. */
export function keptSettings({ ingest }: Capture): Settings {
  const names = ['strokes', 'calibration'];
  return Object.fromEntries(Object.entries(ingest.settings).filter(([name]) => names.includes(name)));
}

/** True if a capture's last ingest made points, which fits need, rather than masks alone. */
export function hasPoints({ ingest }: Capture): boolean {
  return ingest.state === 'SUCCEEDED' && ingest.settings['until'] !== 'masks';
}
