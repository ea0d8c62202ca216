import settings from './known.json';

/** A setting of fits: its name, its default as JSON (empty: none), what is allowed, and its meaning. */
export type KnownSetting = readonly [name: string, standard: string, allowed: string, meaning: string];

/** The settings of docs/use/settings.md, in its order, each with the first sentence about it. */
export const KNOWN_SETTINGS = settings as unknown as readonly KnownSetting[];
