import { DataTexture, LinearFilter } from 'three';
import { texels, type ColourMap } from '../colour';

/** A colour map as a texture of 256 colours; the caller disposes of it. */
export function mapTexture(map: ColourMap): DataTexture {
  const texture = new DataTexture(texels(map, 256), 256, 1);
  texture.magFilter = LinearFilter;
  texture.minFilter = LinearFilter;
  texture.needsUpdate = true;
  return texture;
}
