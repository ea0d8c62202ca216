import type { PageContext } from '../../page';
import { fileName } from '../../play/share/download';
import { h } from '../../ui/dom';
import { menu } from '../../ui/menu';
import { download } from '../parts/actions';

/** Formats of a twin: names in the API, words, extension, and where the file opens. */
const FORMATS: readonly (readonly [format: string, text: string, extension: string, where: string])[] = [
  ['glb', 'GLB', 'glb', 'Browsers, Blender, game engines'],
  ['usdz', 'USD', 'usdz', 'Omniverse and Isaac Sim, Apple Quick Look'],
  ['mujoco', 'MuJoCo', 'xml', 'MuJoCo 3: nodes, springs, contact'],
  ['ply', 'PLY', 'ply', 'MeshLab, CloudCompare, Open3D'],
  ['obj', 'OBJ', 'obj', 'Any program for meshes'],
  ['html', 'Web page', 'html', 'Any browser, without a server: simulated in the page'],
  ['npz', 'NumPy', 'npz', 'numpy.load: all arrays of the twin'],
];

/** A menu of the files that a twin can be downloaded as. */
export function exportMenu(context: PageContext, path: string, name: string, faults: HTMLElement): HTMLElement {
  const item = (text: string, extension: string, where: string, address: string): HTMLElement => {
    const label = h('span', {}, `${text} `, h('span', { class: 'hint' }, `.${extension}: ${where}`));
    return download(context, label, address, fileName(name, extension), faults);
  };
  return menu('Export', [
    ...FORMATS.map(([format, text, extension, where]) => item(text, extension, where, `${path}/export?format=${format}`)),
    item('Twin file', 'safetensors', 'Other BendTwin servers, and the Python client', `${path}/content`),
  ]);
}
