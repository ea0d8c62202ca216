import type { OpenPage } from './page';

/** A route: its address and the page there, which is fetched when it is first opened. */
export interface Route {
  /** Address behind `#`, with `:name` for a part that varies. */
  readonly path: string;
  readonly open: () => Promise<{ open: OpenPage }>;
}

/** All pages. */
export const ROUTES: readonly Route[] = [
  { path: '/', open: () => import('./pages/home/page') },
  { path: '/captures', open: () => import('./pages/captures/list') },
  { path: '/captures/:id/playback', open: () => import('./playback/page') },
  { path: '/captures/:id/masks', open: () => import('./masks/page') },
  { path: '/captures/:id', open: () => import('./pages/captures/detail') },
  { path: '/fits', open: () => import('./pages/fits/list') },
  { path: '/fits/new', open: () => import('./pages/fits/new') },
  { path: '/fits/compare', open: () => import('./pages/fits/compare') },
  { path: '/fits/:id', open: () => import('./pages/fits/detail') },
  { path: '/twins', open: () => import('./pages/twins/list') },
  { path: '/twins/compare', open: () => import('./pages/twins/compare') },
  { path: '/twins/:id', open: () => import('./pages/twins/detail') },
  { path: '/upload', open: () => import('./pages/upload/page') },
  { path: '/trash', open: () => import('./pages/trash') },
  { path: '/workers', open: () => import('./pages/workers') },
  { path: '/login', open: () => import('./pages/login') },
  { path: '/twins/:id/view', open: () => import('./play/view_page') },
  { path: '/twins/:id/play', open: () => import('./play/page') },
  { path: '/shared/:id', open: () => import('./pages/shared/page') },
  { path: '/plays/:id', open: () => import('./play/watch_page') },
];

/** The route of an address and the parts that it names, or null. */
export function match(routes: readonly Route[], path: string): { route: Route; parameters: Record<string, string> } | null {
  const parts = path.split('/').filter((part) => part !== '');
  for (const route of routes) {
    const wanted = route.path.split('/').filter((part) => part !== '');
    if (wanted.length !== parts.length) continue;
    const parameters: Record<string, string> = {};
    const fits = wanted.every((part, index) => {
      const given = parts[index] ?? '';
      if (!part.startsWith(':')) return part === given;
      parameters[part.slice(1)] = given;
      return true;
    });
    if (fits) return { route, parameters };
  }
  return null;
}
